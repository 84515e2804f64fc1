//! Ride files of any kind: a reader for each, picked by what is in the file; the same maps, units,
//! signs, rules for gaps and errors for all.
//!
//! | file | reader |
//! |---|---|
//! | CSV, as loggers and spreadsheets write it | always |
//! | MAT-file of version 5 (`save -v7`) | always |
//! | MAT-file of version 7.3 (HDF5) | feature `mat73` |
//! | Parquet | feature `parquet` |
//!
//! A file of our own form has columns called `name[unit]` (`name` alone: SI), names as in the
//! tables of the bicycle, and a `time` column or a given sampling rate. A foreign file needs a
//! [`Map`]. Whatever else is done to the numbers is written into the notes of the ride.

mod clock;
pub(crate) mod table;
#[cfg(test)]
mod tests;

use crate::error::{self, Error, Result};
use crate::map::{Column, Map};
use crate::ride::{Origin, Ride, TIME, quantities};
use crate::{csv, file, mat, parquet};
use clock::Clock;
use std::path::Path;
use table::Table;

/// How a ride file is to be read.
#[derive(Debug, Clone, Default)]
pub struct Import {
    /// What the columns of a foreign file mean.
    pub map: Option<Map>,
    /// Sampling rate [Hz] of a file without a time column; with one, what it must agree with.
    pub rate: Option<f64>,
    /// Whether gaps in time of up to ten steps are bridged by straight lines instead of refused.
    pub resample: bool,
}

impl Import {
    /// Reads the ride file at `path`.
    pub fn read(&self, path: &Path) -> Result<Ride> {
        self.parse(&path.display().to_string(), &file::read(path)?)
    }

    /// Reads a ride from the `bytes` of a file, which `file` names.
    pub fn parse(&self, file: &str, bytes: &[u8]) -> Result<Ride> {
        let table = table(file, bytes)?;
        let mut notes = table.notes.clone();
        let plan = self
            .plan(&table, &mut notes)
            .map_err(|cause| match table.header_row {
                Some(row) => Error::Header {
                    file: file.into(),
                    row,
                    cause: Box::new(cause),
                },
                None => cause.in_file(file),
            })?;
        let mut time = None;
        let mut channels = Vec::new();
        for (index, column) in plan {
            let samples: Vec<f64> = table
                .numbers(file, index)?
                .into_iter()
                .map(|x| column.to_si(x))
                .collect();
            match column.channel {
                None => time = Some(samples),
                Some(row) => channels.push((row, samples)),
            }
        }
        let clock = match (time, self.rate()?) {
            (Some(times), rate) => Clock::of(file, &table.rows, &times, rate, self.resample)?,
            (None, Some(rate)) => Clock::steady(rate, table.rows.len()),
            (None, None) => return Err(Error::NoTime { file: file.into() }),
        };
        notes.extend(clock.notes.iter().cloned());

        let mut ride = Ride::new(clock.start, clock.step, clock.len());
        for (row, samples) in channels {
            ride.insert(row.name, clock.sample(samples))?;
        }
        ride.law_in_loop = match &self.map {
            Some(map) => map.law_in_loop,
            None => table.law_in_loop,
        };
        ride.origin = Some(Origin {
            file: file.into(),
            sha256: file::sha256(bytes),
            rows: clock.rows(&table.rows),
        });
        ride.notes = notes;
        Ok(ride)
    }

    /// The rate given, by the caller or by the map [Hz].
    fn rate(&self) -> Result<Option<f64>> {
        let rate = self.rate.or(self.map.as_ref().and_then(|map| map.rate));
        match rate {
            // a million samples a second are no bicycle's
            Some(value) if !(value > 0.0 && value <= 1e6) => Err(Error::OutOfRange {
                name: "rate".into(),
                value,
                min: 0.0,
                max: 1e6,
                unit: "Hz",
            }),
            _ => Ok(rate),
        }
    }

    /// Which columns to read, and how.
    fn plan(&self, table: &Table, notes: &mut Vec<String>) -> Result<Vec<(usize, Column)>> {
        let header = &table.header;
        let Some(map) = &self.map else {
            let mut plan: Vec<(usize, Column)> = Vec::new();
            let (of_others, own): (Vec<_>, Vec<_>) = header
                .iter()
                .enumerate()
                .partition(|(index, cell)| is_of_another(cell) || is_besides(table, *index));
            let names = of_others.into_iter().map(|(index, _)| index);
            notes.extend(not_used(table, names.collect()));
            for (index, cell) in own {
                let column = Column::own(cell).map_err(|e| foreign(e, cell))?;
                if plan.iter().any(|(_, known)| known.name() == column.name()) {
                    return Err(Error::Repeated {
                        name: column.name().into(),
                    });
                }
                plan.push((index, column));
            }
            return Ok(plan);
        };
        let mut plan = Vec::new();
        for column in &map.columns {
            let mut found = header
                .iter()
                .enumerate()
                .filter(|(_, cell)| **cell == column.column);
            let Some((index, _)) = found.next() else {
                return Err(Error::unknown(
                    "column",
                    &column.column,
                    header.iter().map(String::as_str),
                ));
            };
            if found.next().is_some() {
                return Err(Error::Repeated {
                    name: column.column.clone(),
                });
            }
            plan.push((index, column.clone()));
        }
        let turned: Vec<&str> = map
            .columns
            .iter()
            .filter(|c| c.is_turned())
            .map(Column::name)
            .collect();
        if !turned.is_empty() {
            notes.push(format!("signs turned to ISO 8855: {}", turned.join(", ")));
        }
        let unused = (0..header.len()).filter(|&index| plan.iter().all(|(used, _)| *used != index));
        notes.extend(not_used(table, unused.collect()));
        Ok(plan)
    }
}

/// The table in `bytes`, of a file called `file`.
fn table(file: &str, bytes: &[u8]) -> Result<Table> {
    let is_called = |ending: &str| {
        let extension = Path::new(file).extension();
        extension.is_some_and(|found| found.eq_ignore_ascii_case(ending))
    };
    let unreadable = |expected, found: &str| {
        Err(Error::Unreadable {
            file: file.into(),
            expected,
            found: found.into(),
        })
    };
    if mat::is_mat(bytes) {
        mat::read(file, bytes)
    } else if mat::is_hdf5(bytes) {
        mat::read_hdf5(file, bytes)
    } else if parquet::is_parquet(bytes) {
        parquet::read(file, bytes)
    } else if is_called("mat") {
        unreadable(
            "a MAT-file of version 5",
            "another file; save with `save -v7`",
        )
    } else if is_called("parquet") {
        unreadable("a Parquet file", "another file")
    } else {
        csv::read(file, bytes)
    }
}

/// Whether a column of a coupled run belongs to another participant than the bicycle, or is what
/// the bicycle was given: `controller.assist_torque[N.m]`.
fn is_of_another(cell: &str) -> bool {
    let name = cell.split('[').next().unwrap_or_default();
    name.contains('.') && cell.parse::<f64>().is_err()
}

/// Whether column `index` is none of a ride's: neither called like a channel nor as long as one.
fn is_besides(table: &Table, index: usize) -> bool {
    table.unusable(index).is_some() && Column::own(&table.header[index]).is_err()
}

/// A note on columns nobody asked for, if there are any; with what is in them where that is no
/// number a row.
fn not_used(table: &Table, columns: Vec<usize>) -> Option<String> {
    let name = |index: usize| match table.unusable(index) {
        Some(what) => format!("{} ({what})", table.header[index]),
        None => table.header[index].clone(),
    };
    let names: Vec<String> = columns.into_iter().map(name).collect();
    (!names.is_empty()).then(|| format!("columns not used: {}", names.join(", ")))
}

/// The error for a column no channel is called like: it may be a foreign file's.
fn foreign(error: Error, cell: &str) -> Error {
    match error {
        Error::Unknown { name, .. } if cell.parse::<f64>().is_err() => Error::UnknownColumn {
            nearest: error::nearest(&name, quantities().map(|row| row.name).chain([TIME])),
            name,
        },
        Error::Unknown { name, .. } => Error::NoHeader { found: name },
        other => other,
    }
}
