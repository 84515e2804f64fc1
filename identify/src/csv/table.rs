//! From bytes to a table of cells with their line numbers.

use crate::error::{Error, Result};

/// A table of cells as found in a file.
#[derive(Debug)]
pub(super) struct Table {
    /// The header, trimmed.
    pub(super) header: Vec<String>,
    /// Line of the header, from 1.
    pub(super) header_row: usize,
    /// Line of each row, from 1.
    pub(super) rows: Vec<usize>,
    /// What a comment before the header said: `# law_in_loop = true`.
    pub(super) law_in_loop: Option<bool>,
    /// What was done to make text of the bytes.
    pub(super) notes: Vec<String>,
    records: Vec<::csv::StringRecord>,
}

impl Table {
    /// Reads `bytes`, of a file called `file`.
    pub(super) fn read(file: &str, bytes: &[u8]) -> Result<Self> {
        let too_few = |found| Error::TooFew {
            file: file.into(),
            found,
        };
        if let Some(offset) = bytes.iter().position(|&b| b == 0) {
            return Err(Error::NotText {
                file: file.into(),
                offset,
            });
        }
        let mut notes = Vec::new();
        let text = if let Ok(text) = std::str::from_utf8(bytes) {
            text.to_owned()
        } else {
            notes.push("read as Latin-1: the file is not UTF-8".into());
            bytes.iter().map(|&b| char::from(b)).collect()
        };
        let text = text.strip_prefix('\u{feff}').unwrap_or(&text);

        // Comments and blank lines go first, so that the parser's line n is the n-th entry here.
        let comment = |line: &str| line.starts_with(['#', '%']);
        let (lines, kept): (Vec<usize>, Vec<&str>) = text
            .lines()
            .enumerate()
            .filter(|(_, line)| {
                !comment(line) && !line.trim_matches([' ', '\t', ',', ';', '\r']).is_empty()
            })
            .map(|(i, line)| (i + 1, line))
            .unzip();
        let Some(first) = kept.first() else {
            return Err(too_few("an empty file"));
        };
        let delimiter = *b";\t"
            .iter()
            .find(|&&d| first.contains(char::from(d)))
            .unwrap_or(&b',');
        let law_in_loop = text.lines().take(lines[0]).find_map(|line| {
            line.strip_prefix('#')?
                .trim()
                .strip_prefix("law_in_loop = ")?
                .trim()
                .parse()
                .ok()
        });

        let joined = kept.join("\n");
        let mut reader = ::csv::ReaderBuilder::new()
            .has_headers(false)
            .flexible(true)
            .delimiter(delimiter)
            .trim(::csv::Trim::All)
            .from_reader(joined.as_bytes());
        let mut records = Vec::with_capacity(kept.len());
        let mut rows = Vec::with_capacity(kept.len());
        for record in reader.records() {
            let record = record.expect("flexible records of valid UTF-8 in memory cannot fail");
            let line = record.position().map_or(1, ::csv::Position::line) as usize;
            rows.push(lines[line - 1]);
            records.push(record);
        }
        let header_row = rows.remove(0);
        let mut header: Vec<String> = records.remove(0).iter().map(str::to_owned).collect();
        // spreadsheets leave empty columns behind the last
        while header.last().is_some_and(String::is_empty) {
            header.pop();
        }
        match rows.len() {
            0 => return Err(too_few("a header only")),
            1 => return Err(too_few("1 row")),
            _ => {}
        }
        for (record, &row) in records.iter().zip(&rows) {
            let excess = record
                .iter()
                .skip(header.len())
                .any(|cell| !cell.is_empty());
            if record.len() < header.len() || excess {
                let (expected, found) = (header.len(), record.len());
                return Err(Error::Cells {
                    file: file.into(),
                    row,
                    expected,
                    found,
                });
            }
        }
        Ok(Self {
            header,
            header_row,
            rows,
            law_in_loop,
            notes,
            records,
        })
    }

    /// The numbers in column `index`.
    pub(super) fn numbers(&self, file: &str, index: usize) -> Result<Vec<f64>> {
        self.records
            .iter()
            .zip(&self.rows)
            .map(|(record, &row)| {
                let cell = record.get(index).unwrap_or_default();
                number(cell).ok_or_else(|| Error::Cell {
                    file: file.into(),
                    row,
                    column: self.header[index].clone(),
                    found: if cell.is_empty() {
                        "an empty cell".into()
                    } else {
                        format!("`{cell}`")
                    },
                })
            })
            .collect()
    }
}

/// The finite number in a cell, with decimal point or decimal comma; none where a cell has both,
/// for then one of them groups thousands and nobody knows which.
fn number(cell: &str) -> Option<f64> {
    let value: f64 = if cell.contains(',') && !cell.contains('.') {
        cell.replacen(',', ".", 1).parse().ok()?
    } else {
        cell.parse().ok()?
    };
    value.is_finite().then_some(value)
}
