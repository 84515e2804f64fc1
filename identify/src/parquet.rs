//! Parquet files: columns of numbers, as pandas and polars write them. Times may be time stamps;
//! they then begin at 0.

use crate::error::{Error, Result};
use crate::import::table::Table;

/// Whether `bytes` are a Parquet file.
pub(crate) fn is_parquet(bytes: &[u8]) -> bool {
    bytes.starts_with(b"PAR1")
}

fn unreadable(file: &str, found: impl Into<String>) -> Error {
    Error::Unreadable {
        file: file.into(),
        expected: "a Parquet file",
        found: found.into(),
    }
}

/// The table in `bytes`, of a file called `file`.
#[cfg(not(feature = "parquet"))]
pub(crate) fn read(file: &str, _bytes: &[u8]) -> Result<Table> {
    let found = "one that this program cannot read: it was built without (feature parquet)";
    Err(unreadable(file, found))
}

/// The table in `bytes`, of a file called `file`.
#[cfg(feature = "parquet")]
pub(crate) fn read(file: &str, bytes: &[u8]) -> Result<Table> {
    let (header, columns, law_in_loop) =
        columns::all(bytes).map_err(|cause| unreadable(file, cause.to_string()))?;
    let table = Table::of_numbers(file, header, columns)?;
    Ok(Table {
        law_in_loop,
        ..table
    })
}

#[cfg(feature = "parquet")]
mod columns {
    use parquet::basic::{LogicalType, TimeUnit};
    use parquet::column::reader::{ColumnReader, ColumnReaderImpl};
    use parquet::data_type::DataType;
    use parquet::errors::{ParquetError, Result};
    use parquet::file::metadata::ColumnChunkMetaData;
    use parquet::file::reader::{FileReader, SerializedFileReader};
    use parquet::schema::types::ColumnDescriptor;
    use std::io::Write as _;

    /// The numbers of a column, NaN where it has none; else what it has.
    type Column = std::result::Result<Vec<f64>, String>;

    /// Names and columns, and what the file says of the law in the loop.
    pub(super) fn all(bytes: &[u8]) -> Result<(Vec<String>, Vec<Column>, Option<bool>)> {
        // of what is in memory the reader takes a type of a crate of its own only
        let mut whole = tempfile::tempfile()?;
        whole.write_all(bytes)?;
        let file = SerializedFileReader::new(whole)?;
        let meta = file.metadata().file_metadata();
        let schema = meta.schema_descr();
        let mut columns: Vec<Column> = schema
            .columns()
            .iter()
            .map(|column| match column.max_rep_level() {
                0 => Ok(Vec::new()),
                _ => Err("lists".into()),
            })
            .collect();
        for group in 0..file.num_row_groups() {
            let group = file.get_row_group(group)?;
            let rows = usize::try_from(group.metadata().num_rows()).unwrap_or(0);
            if let Some(chunk) = group
                .metadata()
                .columns()
                .iter()
                .find(|c| !is_within(c, bytes))
            {
                let name = chunk.column_path().string();
                return Err(ParquetError::EOF(format!(
                    "column {name} ends beyond the file"
                )));
            }
            for (index, column) in columns.iter_mut().enumerate() {
                let Ok(values) = column else { continue };
                let most = schema.column(index).max_def_level();
                match numbers(group.get_column_reader(index)?, rows, most)? {
                    Ok(more) => values.extend(more),
                    Err(what) => *column = Err(what),
                }
            }
        }
        for (column, described) in columns.iter_mut().zip(schema.columns()) {
            if let (Ok(values), Some(unit)) = (column, unit_of_time(described)) {
                let first = values.first().copied().unwrap_or(0.0);
                values.iter_mut().for_each(|t| *t = (*t - first) / unit);
            }
        }
        let law_in_loop = meta.key_value_metadata().and_then(|pairs| {
            let said = pairs.iter().find(|pair| pair.key == "law_in_loop")?;
            said.value.as_deref()?.parse().ok()
        });
        let names = schema.columns().iter().map(|column| column.path().string());
        Ok((names.collect(), columns, law_in_loop))
    }

    /// Whether a chunk lies within the file: the reader makes room for it first.
    fn is_within(chunk: &ColumnChunkMetaData, bytes: &[u8]) -> bool {
        let start = chunk
            .dictionary_page_offset()
            .unwrap_or(chunk.data_page_offset());
        let ends = [start, chunk.compressed_size(), chunk.data_page_offset()];
        let end = start.checked_add(chunk.compressed_size());
        ends.iter().all(|&at| at >= 0) && end.is_some_and(|end| end as usize <= bytes.len())
    }

    /// Units of a time stamp in a second; none of another column.
    fn unit_of_time(column: &ColumnDescriptor) -> Option<f64> {
        match column.logical_type_ref()? {
            LogicalType::Timestamp(time) => Some(match time.unit {
                TimeUnit::MILLIS => 1e3,
                TimeUnit::MICROS => 1e6,
                TimeUnit::NANOS => 1e9,
            }),
            _ => None,
        }
    }

    /// `rows` numbers of a column that are there at level `most` of its definition.
    fn numbers(reader: ColumnReader, rows: usize, most: i16) -> Result<Column> {
        Ok(Ok(match reader {
            ColumnReader::BoolColumnReader(r) => cells(r, rows, most, |x| f64::from(u8::from(x)))?,
            ColumnReader::Int32ColumnReader(r) => cells(r, rows, most, f64::from)?,
            ColumnReader::Int64ColumnReader(r) => cells(r, rows, most, |x| x as f64)?,
            ColumnReader::FloatColumnReader(r) => cells(r, rows, most, f64::from)?,
            ColumnReader::DoubleColumnReader(r) => cells(r, rows, most, |x| x)?,
            _ => return Ok(Err("text or bytes".into())),
        }))
    }

    fn cells<T: DataType>(
        mut reader: ColumnReaderImpl<T>,
        rows: usize,
        most: i16,
        number: impl Fn(T::T) -> f64,
    ) -> Result<Vec<f64>> {
        let (mut levels, mut values) = (Vec::new(), Vec::new());
        let mut read = 0;
        while read < rows {
            let levels = (most > 0).then_some(&mut levels);
            match reader
                .read_records(rows - read, levels, None, &mut values)?
                .0
            {
                0 => break,
                more => read += more,
            }
        }
        let mut values = values.into_iter().map(number);
        Ok(if most == 0 {
            values.collect()
        } else {
            let cell = |level| {
                let there = level == most;
                there.then(|| values.next()).flatten().unwrap_or(f64::NAN)
            };
            levels.into_iter().map(cell).collect()
        })
    }
}

#[cfg(test)]
mod tests {
    #![expect(clippy::unwrap_used, reason = "a failed import is a failed test")]
    use crate::import::Import;

    /// Files of pyarrow's making, see `tests/data/rides/write.py`.
    const RIDE: &[u8] = include_bytes!("../../tests/data/rides/ride.parquet");

    #[cfg(not(feature = "parquet"))]
    #[test]
    fn a_program_without_the_reader_says_so() {
        let error = Import::default().parse("ride.parquet", RIDE).unwrap_err();
        assert!(error.to_string().contains("(feature parquet)"), "{error}");
    }

    #[cfg(feature = "parquet")]
    #[test]
    fn columns_of_numbers_and_time_stamps_are_read() {
        let ride = Import::default().parse("ride.parquet", RIDE).unwrap();
        assert_eq!((ride.len(), ride.step(), ride.time(0)), (40, 0.005, 0.0));
        assert_eq!(ride.notes, ["columns not used: rider (text or bytes)"]);
        for i in 0..40 {
            let steer = ride.channel("steer").unwrap()[i];
            // degrees and back: some units in the last place
            assert!((steer - (i as f64 / 5.0).sin() / 10.0).abs() < 1e-15);
            let roll_rate = ride.channel("roll_rate").unwrap()[i];
            // in single precision
            assert!((roll_rate - (i as f64 / 7.0).cos() / 4.0).abs() < 2e-8);
        }
        let rows: Vec<usize> = (1..=40).collect();
        assert_eq!(ride.origin.unwrap().rows, rows);
    }

    #[cfg(feature = "parquet")]
    #[test]
    fn an_empty_cell_has_its_row_and_a_cut_file_an_error() {
        let gap = include_bytes!("../../tests/data/rides/gap.parquet");
        let error = Import::default().parse("gap.parquet", gap).unwrap_err();
        assert_eq!(
            error.to_string(),
            "gap.parquet, row 31: expected a number in column `speed`, found NaN"
        );
        for at in (4..RIDE.len()).step_by(7) {
            let error = Import::default()
                .parse("ride.parquet", &RIDE[..at])
                .unwrap_err();
            assert!(
                error
                    .to_string()
                    .starts_with("ride.parquet: expected a Parquet file")
            );
        }
    }
}
