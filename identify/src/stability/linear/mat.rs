//! MAT-files of level 5, uncompressed: what MATLAB and `scipy.io.loadmat` read.
//!
//! MathWorks, MAT-File Format (R2024), chapter 1: a header of 128 bytes, then elements of a tag
//! (type, number of bytes) and data filled up to a multiple of eight bytes. An array is an element
//! of elements: flags, dimensions, name, content by columns.

use nalgebra::DMatrix;

// Data types, table 1-1, and array classes, table 1-3.
const INT8: u32 = 1;
const UINT16: u32 = 4;
const INT32: u32 = 5;
const UINT32: u32 = 6;
const DOUBLE: u32 = 9;
const MATRIX: u32 = 14;
const CELL_CLASS: u32 = 1;
const CHAR_CLASS: u32 = 4;
const DOUBLE_CLASS: u32 = 6;

/// A file in the making.
pub(super) struct File(Vec<u8>);

impl File {
    /// The header. Its text has no date: the same system gives the same bytes.
    pub(super) fn new() -> Self {
        let mut bytes = b"MATLAB 5.0 MAT-file, written by wobble".to_vec();
        bytes.resize(116, b' ');
        // no subsystem data; version 1; the two letters tell the order of bytes
        bytes.extend([0; 8]);
        bytes.extend(0x0100u16.to_le_bytes());
        bytes.extend(b"IM");
        Self(bytes)
    }

    pub(super) fn matrix(&mut self, name: &str, matrix: &DMatrix<f64>) {
        let content: Vec<u8> = matrix.iter().flat_map(|v| v.to_le_bytes()).collect();
        let content = element(DOUBLE, &content);
        self.0
            .extend(array(DOUBLE_CLASS, matrix.shape(), name, &content));
    }

    pub(super) fn text(&mut self, name: &str, text: &str) {
        self.0.extend(characters(name, text));
    }

    /// A cell array, a row a text.
    pub(super) fn texts(&mut self, name: &str, texts: &[&str]) {
        let cells: Vec<u8> = texts.iter().flat_map(|text| characters("", text)).collect();
        self.0
            .extend(array(CELL_CLASS, (texts.len(), 1), name, &cells));
    }

    pub(super) fn into_bytes(self) -> Vec<u8> {
        self.0
    }
}

fn characters(name: &str, text: &str) -> Vec<u8> {
    let content: Vec<u8> = text.encode_utf16().flat_map(u16::to_le_bytes).collect();
    let shape = (1, content.len() / 2);
    array(CHAR_CLASS, shape, name, &element(UINT16, &content))
}

fn array(class: u32, (rows, columns): (usize, usize), name: &str, content: &[u8]) -> Vec<u8> {
    let words = |words: [u32; 2]| words.map(u32::to_le_bytes).concat();
    let parts = [
        element(UINT32, &words([class, 0])),
        element(INT32, &words([rows as u32, columns as u32])),
        element(INT8, name.as_bytes()),
        content.to_vec(),
    ];
    element(MATRIX, &parts.concat())
}

fn element(kind: u32, data: &[u8]) -> Vec<u8> {
    let mut bytes = kind.to_le_bytes().to_vec();
    bytes.extend((data.len() as u32).to_le_bytes());
    bytes.extend(data);
    bytes.resize(bytes.len().next_multiple_of(8), 0);
    bytes
}
