//! A table as found in a file: columns by name, rows by number; nobody knows yet what they mean.

use crate::error::{Error, Result};

/// A table of cells as found in a file.
#[derive(Debug)]
pub(crate) struct Table {
    /// The header, trimmed.
    pub(crate) header: Vec<String>,
    /// Line of the header, from 1; none in a file that has no lines.
    pub(crate) header_row: Option<usize>,
    /// Line of each row, from 1; where there are no lines, number of the sample.
    pub(crate) rows: Vec<usize>,
    /// What the file says, see [`crate::ride::Ride::law_in_loop`].
    pub(crate) law_in_loop: Option<bool>,
    /// What was done to make a table of the bytes.
    pub(crate) notes: Vec<String>,
    pub(crate) cells: Cells,
}

/// What stands in a table.
#[derive(Debug)]
pub(crate) enum Cells {
    /// Text, a record a row.
    Text(Vec<::csv::StringRecord>),
    /// Numbers, column by column; where a column has none, what it has, in words.
    Numbers(Vec<std::result::Result<Vec<f64>, String>>),
}

impl Table {
    /// Columns of numbers with their names. As many rows as the longest has; of those with fewer
    /// none can be read.
    pub(crate) fn of_numbers(
        file: &str,
        header: Vec<String>,
        columns: Vec<std::result::Result<Vec<f64>, String>>,
    ) -> Result<Self> {
        let longest = columns.iter().flatten().map(Vec::len).max();
        let too_few = |found| Error::TooFew {
            file: file.into(),
            found,
        };
        let rows = match longest {
            None => return Err(too_few("no column of numbers")),
            Some(0) => return Err(too_few("a header only")),
            Some(1) => return Err(too_few("1 row")),
            Some(rows) => rows,
        };
        Ok(Self {
            header,
            header_row: None,
            rows: (1..=rows).collect(),
            law_in_loop: None,
            notes: Vec::new(),
            cells: Cells::Numbers(columns),
        })
    }

    /// Why column `index` can be no channel, whatever it is called, in words.
    pub(crate) fn unusable(&self, index: usize) -> Option<String> {
        let Cells::Numbers(columns) = &self.cells else {
            return None;
        };
        match &columns[index] {
            Ok(values) if values.len() == self.rows.len() => None,
            Ok(values) => Some(format!("{} of {} numbers", values.len(), self.rows.len())),
            Err(what) => Some(what.clone()),
        }
    }

    /// The numbers in column `index`.
    pub(crate) fn numbers(&self, file: &str, index: usize) -> Result<Vec<f64>> {
        let column = || self.header[index].clone();
        let cell = |row: usize, found| Error::Cell {
            file: file.into(),
            row,
            column: column(),
            found,
        };
        if let Some(found) = self.unusable(index) {
            return Err(Error::Column {
                file: file.into(),
                column: column(),
                found,
            });
        }
        match &self.cells {
            Cells::Text(records) => {
                let read = |(record, &row): (&::csv::StringRecord, &usize)| {
                    let text = record.get(index).unwrap_or_default();
                    number(text).ok_or_else(|| match text {
                        "" => cell(row, "an empty cell".into()),
                        _ => cell(row, format!("`{text}`")),
                    })
                };
                records.iter().zip(&self.rows).map(read).collect()
            }
            Cells::Numbers(columns) => {
                let values = columns[index].as_ref().expect("a usable column");
                match values.iter().position(|value| !value.is_finite()) {
                    Some(i) => Err(cell(self.rows[i], format!("{}", values[i]))),
                    None => Ok(values.clone()),
                }
            }
        }
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
