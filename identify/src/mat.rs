//! MAT-files: the variables of MATLAB as the columns of a ride.
//!
//! Version 5 (what `save -v7` and `save -v6` write; MathWorks, MAT-File Format, R2024, chapter 1):
//! a header of 128 bytes, then elements of a tag (type, number of bytes) and data filled up to a
//! multiple of eight bytes; each may be compressed. An array is an element of elements: flags,
//! dimensions, name, content by columns. Version 7.3 is HDF5.
//!
//! Columns are real vectors, lying or standing. A struct that stands alone is the table, its fields
//! the columns; beside other vectors or structs they are called `struct.field`.

#[cfg(test)]
mod tests;
#[cfg(feature = "mat73")]
mod v73;

use crate::error::{Error, Result};
use crate::import::table::Table;
use flate2::read::ZlibDecoder;
use std::io::Read as _;

/// Data types, table 1-1.
pub(crate) mod kind {
    pub(crate) const INT8: u32 = 1;
    pub(super) const UINT8: u32 = 2;
    pub(super) const INT16: u32 = 3;
    pub(crate) const UINT16: u32 = 4;
    pub(crate) const INT32: u32 = 5;
    pub(crate) const UINT32: u32 = 6;
    pub(super) const SINGLE: u32 = 7;
    pub(crate) const DOUBLE: u32 = 9;
    pub(super) const INT64: u32 = 12;
    pub(super) const UINT64: u32 = 13;
    pub(crate) const MATRIX: u32 = 14;
    pub(super) const COMPRESSED: u32 = 15;
}

/// Array classes, table 1-3; 17 is an object of a class of MATLAB's.
pub(crate) mod class {
    pub(crate) const CELL: u32 = 1;
    pub(super) const STRUCT: u32 = 2;
    pub(crate) const CHAR: u32 = 4;
    pub(super) const SPARSE: u32 = 5;
    pub(crate) const DOUBLE: u32 = 6;
    pub(super) const UINT64: u32 = 15;
    pub(super) const OPAQUE: u32 = 17;
}

/// Structs in structs beyond this are nobody's ride.
const DEEPEST: usize = 8;

/// How to save what cannot be read, in words.
const SAVE: &str = "save vectors, or a struct of them, with `save -v7`";

/// A variable: its name and what it is.
struct Variable {
    name: String,
    content: Content,
}

enum Content {
    /// A real vector, lying or standing, or a scalar.
    Vector(Vec<f64>),
    /// A struct of one element.
    Struct(Vec<Variable>),
    /// What cannot be a column, in words.
    Other(String),
}

/// Whether `bytes` are a MAT-file of version 5.
pub(crate) fn is_mat(bytes: &[u8]) -> bool {
    matches!(
        bytes.get(124..128),
        Some([0, 1, b'I', b'M'] | [1, 0, b'M', b'I'])
    )
}

/// Whether `bytes` are HDF5, as MAT-files of version 7.3 are, behind a user block or not.
pub(crate) fn is_hdf5(bytes: &[u8]) -> bool {
    let signature = b"\x89HDF\r\n\x1a\n";
    [0, 512]
        .iter()
        .any(|&at| bytes.get(at..at + 8) == Some(signature))
}

/// Most bytes of a variable: what a damaged length would have us read is no ride.
const MOST: u64 = 1 << 31;

fn inflate(data: &[u8]) -> Option<Vec<u8>> {
    let mut inflated = Vec::new();
    let mut stream = ZlibDecoder::new(data).take(MOST);
    stream.read_to_end(&mut inflated).ok()?;
    Some(inflated)
}

/// The table in the MAT-file `bytes` of version 5, which `file` names.
pub(crate) fn read(file: &str, bytes: &[u8]) -> Result<Table> {
    let big = bytes[126] == b'M';
    let mut rest = Elements {
        bytes: &bytes[128..],
        big,
    };
    let mut variables = Vec::new();
    let broken = |why| broken(file, why);
    while !rest.bytes.is_empty() {
        let (kind, data) = rest
            .next()
            .ok_or_else(|| broken("its end inside a variable"))?;
        let inflated;
        let (kind, data) = if kind == kind::COMPRESSED {
            inflated = inflate(data).ok_or_else(|| broken("a compressed variable damaged"))?;
            let mut inner = Elements {
                bytes: &inflated,
                big,
            };
            inner
                .next()
                .ok_or_else(|| broken("a compressed variable cut short"))?
        } else {
            (kind, data)
        };
        if kind == kind::MATRIX {
            let inner = Elements { bytes: data, big };
            let variable = inner
                .array(0)
                .ok_or_else(|| broken("a variable that is no array"))?;
            variables.extend(variable);
        }
    }
    table(file, variables)
}

/// The table in the MAT-file `bytes` of version 7.3.
#[cfg(feature = "mat73")]
pub(crate) fn read_hdf5(file: &str, bytes: &[u8]) -> Result<Table> {
    table(file, v73::variables(file, bytes)?)
}

/// The table in the MAT-file `bytes` of version 7.3.
#[cfg(not(feature = "mat73"))]
pub(crate) fn read_hdf5(file: &str, _bytes: &[u8]) -> Result<Table> {
    Err(broken(
        file,
        "version 7.3 (HDF5), which this program was built without (feature mat73)",
    ))
}

fn broken(file: &str, why: &str) -> Error {
    Error::Unreadable {
        file: file.into(),
        expected: "a MAT-file of version 5",
        found: format!("{why}; {SAVE}"),
    }
}

/// The columns among `variables`.
fn table(file: &str, variables: Vec<Variable>) -> Result<Table> {
    let mut columns = Vec::new();
    let mut law_in_loop = None;
    let besides = |v: &&Variable| match &v.content {
        Content::Vector(values) => values.len() > 1,
        Content::Struct(_) => true,
        Content::Other(_) => false,
    };
    let alone = variables.iter().filter(besides).count() == 1;
    for variable in variables {
        match variable.content {
            Content::Struct(fields) if alone => flatten(None, fields, &mut columns),
            content => {
                let name = variable.name;
                flatten(None, vec![Variable { name, content }], &mut columns);
            }
        }
    }
    columns.retain(|(name, column)| match column {
        Ok(values) if name == "law_in_loop" && values.len() == 1 => {
            law_in_loop = Some(values[0] != 0.0);
            false
        }
        _ => true,
    });
    let (header, columns) = columns.into_iter().unzip();
    let table = Table::of_numbers(file, header, columns)?;
    Ok(Table {
        law_in_loop,
        ..table
    })
}

/// Puts `variables` of the struct called `of` behind `columns`.
fn flatten(
    of: Option<&str>,
    variables: Vec<Variable>,
    columns: &mut Vec<(String, std::result::Result<Vec<f64>, String>)>,
) {
    for Variable { name, content } in variables {
        let name = of.map_or_else(|| name.clone(), |of| format!("{of}.{name}"));
        match content {
            Content::Vector(values) => columns.push((name, Ok(values))),
            Content::Struct(fields) => flatten(Some(&name), fields, columns),
            Content::Other(what) => columns.push((name, Err(what))),
        }
    }
}

/// A sequence of data elements.
struct Elements<'a> {
    bytes: &'a [u8],
    /// Whether the high byte comes first.
    big: bool,
}

impl<'a> Elements<'a> {
    /// Type and data of the next element; none where it is cut short.
    fn next(&mut self) -> Option<(u32, &'a [u8])> {
        let tag = self.word(self.bytes.get(..4)?);
        // the small form keeps type, length and up to four bytes in eight (1-10)
        let (kind, length, from) = if tag >> 16 == 0 {
            (tag, self.word(self.bytes.get(4..8)?) as usize, 8)
        } else {
            (tag & 0xffff, (tag >> 16) as usize, 4)
        };
        if from == 4 && length > 4 {
            return None;
        }
        let end = from + length;
        let data = self.bytes.get(from..end)?;
        let filled = if kind == kind::COMPRESSED {
            end
        } else {
            end.next_multiple_of(8)
        };
        self.bytes = self.bytes.get(filled..).unwrap_or_default();
        Some((kind, data))
    }

    fn word(&self, bytes: &[u8]) -> u32 {
        let bytes: [u8; 4] = bytes.try_into().expect("four bytes");
        if self.big {
            u32::from_be_bytes(bytes)
        } else {
            u32::from_le_bytes(bytes)
        }
    }

    /// The next element, of type `expected`.
    fn expect(&mut self, expected: u32) -> Option<&'a [u8]> {
        self.next()
            .filter(|(kind, _)| *kind == expected)
            .map(|(_, data)| data)
    }

    fn text(&mut self) -> Option<String> {
        let text = self.expect(kind::INT8)?;
        Some(text.iter().map(|&b| char::from(b)).collect())
    }

    /// The array these elements make, `depth` structs deep: `Some(None)` for MATLAB's own, which
    /// has no name; none where it is no array.
    #[expect(
        clippy::option_option,
        reason = "nothing to be read is another thing than nothing there"
    )]
    fn array(mut self, depth: usize) -> Option<Option<Variable>> {
        if depth > DEEPEST {
            return None;
        }
        let flags = self.expect(kind::UINT32)?;
        let flags = self.word(flags.get(..4)?);
        let (class, complex) = (flags & 0xff, flags & 0x0800 != 0);
        if class == class::OPAQUE {
            let name = self.text()?;
            let kind = self.text().and_then(|_| self.text()).unwrap_or_default();
            let what = format!("an object of MATLAB ({kind}); {SAVE}, e.g. by table2struct");
            return Some(Some(Variable {
                name,
                content: Content::Other(what),
            }));
        }
        let shape: Vec<u32> = self
            .expect(kind::INT32)?
            .chunks_exact(4)
            .map(|word| self.word(word))
            .collect();
        let name = self.text()?;
        let count = shape
            .iter()
            .try_fold(1usize, |n, &d| n.checked_mul(d as usize))?;
        let other = |what: &str| Some(Content::Other(what.into()));
        let content = match class {
            class::STRUCT if count == 1 => Some(Content::Struct(self.fields(depth)?)),
            class::STRUCT => other("a struct array"),
            class::CELL => other("a cell array"),
            class::CHAR => other("text"),
            class::SPARSE => other("a sparse matrix"),
            class::DOUBLE..=class::UINT64 if complex => other("complex numbers"),
            class::DOUBLE..=class::UINT64 => {
                let values = self.numbers().filter(|values| values.len() == count)?;
                Some(vector(
                    values,
                    &shape.iter().map(|&d| u64::from(d)).collect::<Vec<_>>(),
                ))
            }
            _ => other("no numbers"),
        }?;
        // what MATLAB keeps for itself has no name, and no field is without
        Some((!name.is_empty() || depth > 0).then_some(Variable { name, content }))
    }

    /// The fields of a struct of one element.
    fn fields(&mut self, depth: usize) -> Option<Vec<Variable>> {
        let length = self.expect(kind::INT32)?;
        let length = self.word(length.get(..4)?) as usize;
        let names = self.expect(kind::INT8)?;
        let mut fields = Vec::new();
        for name in names.chunks_exact(Some(length).filter(|&length| length > 0)?) {
            let name = name
                .iter()
                .take_while(|&&b| b != 0)
                .map(|&b| char::from(b))
                .collect();
            let data = self.expect(kind::MATRIX)?;
            // an empty field may be an element without data
            let content = if data.is_empty() {
                Content::Vector(Vec::new())
            } else {
                let field = Elements {
                    bytes: data,
                    big: self.big,
                };
                field.array(depth + 1)??.content
            };
            fields.push(Variable { name, content });
        }
        Some(fields)
    }

    /// The numbers of the next element. Whole ones are stored in the smallest type that holds them,
    /// whatever the class.
    fn numbers(&mut self) -> Option<Vec<f64>> {
        macro_rules! read {
            ($data:expr, $($kind:ident: $type:ty),*) => {
                match $data {
                    $((kind::$kind, data) => data
                        .chunks_exact(size_of::<$type>())
                        .map(|bytes| {
                            let bytes = bytes.try_into().expect("a chunk of that size");
                            #[expect(
                                clippy::allow_attributes,
                                reason = "lossless or not, as the type has it"
                            )]
                            #[allow(clippy::cast_lossless)]
                            let value = if self.big {
                                <$type>::from_be_bytes(bytes)
                            } else {
                                <$type>::from_le_bytes(bytes)
                            } as f64;
                            value
                        })
                        .collect(),)*
                    _ => return None,
                }
            };
        }
        Some(read!(
            self.next()?, INT8: i8, UINT8: u8, INT16: i16, UINT16: u16, INT32: i32, UINT32: u32,
            INT64: i64, UINT64: u64, SINGLE: f32, DOUBLE: f64
        ))
    }
}

/// `values` of an array of so many rows, columns, …: a vector if it is one.
fn vector(values: Vec<f64>, shape: &[u64]) -> Content {
    if shape.iter().filter(|&&d| d > 1).count() > 1 {
        let shape: Vec<String> = shape.iter().map(u64::to_string).collect();
        return Content::Other(format!("a matrix of {}", shape.join(" × ")));
    }
    Content::Vector(values)
}
