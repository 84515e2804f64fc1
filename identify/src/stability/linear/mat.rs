//! MAT-files of level 5, uncompressed: what MATLAB and `scipy.io.loadmat` read.
//!
//! MathWorks, MAT-File Format (R2024), chapter 1: a header of 128 bytes, then elements of a tag
//! (type, number of bytes) and data filled up to a multiple of eight bytes. An array is an element
//! of elements: flags, dimensions, name, content by columns.

use crate::mat::{class, kind};
use nalgebra::DMatrix;

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
        let content = element(kind::DOUBLE, &content);
        self.0
            .extend(array(class::DOUBLE, matrix.shape(), name, &content));
    }

    pub(super) fn text(&mut self, name: &str, text: &str) {
        self.0.extend(characters(name, text));
    }

    /// A cell array, a row a text.
    pub(super) fn texts(&mut self, name: &str, texts: &[&str]) {
        let cells: Vec<u8> = texts.iter().flat_map(|text| characters("", text)).collect();
        self.0
            .extend(array(class::CELL, (texts.len(), 1), name, &cells));
    }

    pub(super) fn into_bytes(self) -> Vec<u8> {
        self.0
    }
}

fn characters(name: &str, text: &str) -> Vec<u8> {
    let content: Vec<u8> = text.encode_utf16().flat_map(u16::to_le_bytes).collect();
    let shape = (1, content.len() / 2);
    array(class::CHAR, shape, name, &element(kind::UINT16, &content))
}

fn array(class: u32, (rows, columns): (usize, usize), name: &str, content: &[u8]) -> Vec<u8> {
    let words = |words: [u32; 2]| words.map(u32::to_le_bytes).concat();
    let parts = [
        element(kind::UINT32, &words([class, 0])),
        element(kind::INT32, &words([rows as u32, columns as u32])),
        element(kind::INT8, name.as_bytes()),
        content.to_vec(),
    ];
    element(kind::MATRIX, &parts.concat())
}

fn element(kind: u32, data: &[u8]) -> Vec<u8> {
    let mut bytes = kind.to_le_bytes().to_vec();
    bytes.extend((data.len() as u32).to_le_bytes());
    bytes.extend(data);
    bytes.resize(bytes.len().next_multiple_of(8), 0);
    bytes
}
