//! Ride files as loggers and spreadsheets write them: CSV.
//!
//! Separator (`;`, tab or comma), decimal comma, byte-order mark, line ends, blank lines and comment
//! lines (`#`, `%`) are found out.

use crate::error::{Error, Result};
use crate::import::table::{Cells, Table};

/// Reads `bytes`, of a file called `file`.
pub(crate) fn read(file: &str, bytes: &[u8]) -> Result<Table> {
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
    Ok(Table {
        header,
        header_row: Some(header_row),
        rows,
        law_in_loop,
        notes,
        cells: Cells::Text(records),
    })
}
