//! Ride files: CSV as loggers and spreadsheets write it.
//!
//! A file of our own form has a header of `name[unit]` cells (`name` alone: SI), names as in the
//! tables of the bicycle, and a `time` column or a given sampling rate. A foreign file needs a
//! [`Map`]. Separator (`;`, tab or comma), decimal comma, byte-order mark, line ends, blank lines
//! and comment lines (`#`, `%`) are found out. Whatever else is done to the numbers is written
//! into the notes of the ride.

mod clock;
mod table;
#[cfg(test)]
mod tests;

use crate::error::{self, Error, Result};
use crate::file;
use crate::map::{Column, Map};
use crate::ride::{Origin, Ride, TIME, quantities};
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
        let table = Table::read(file, bytes)?;
        let mut notes = table.notes.clone();
        let plan = self
            .plan(&table, &mut notes)
            .map_err(|cause| Error::Header {
                file: file.into(),
                row: table.header_row,
                cause: Box::new(cause),
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
                .partition(|(_, cell)| is_of_another(cell));
            if !of_others.is_empty() {
                let names: Vec<&str> = of_others.iter().map(|(_, cell)| cell.as_str()).collect();
                notes.push(format!("columns not used: {}", names.join(", ")));
            }
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
        let unused: Vec<&str> = header
            .iter()
            .map(String::as_str)
            .filter(|cell| map.columns.iter().all(|c| c.column != *cell))
            .collect();
        if !unused.is_empty() {
            notes.push(format!("columns not used: {}", unused.join(", ")));
        }
        Ok(plan)
    }
}

/// Whether a column of a coupled run belongs to another participant than the bicycle, or is what
/// the bicycle was given: `controller.assist_torque[N.m]`.
fn is_of_another(cell: &str) -> bool {
    let name = cell.split('[').next().unwrap_or_default();
    name.contains('.') && cell.parse::<f64>().is_err()
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
