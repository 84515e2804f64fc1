//! `free-response`: windows, given, in which the bicycle was left to itself, each replayed from a
//! free initial state without the recorded torque; a steering law stays closed on the simulated
//! state. Otherwise as [`super::time`], which may have its windows given as well: the stretches in
//! which a hand drove the steering, say. Windows may differ in length.
//!
//! Schwab & Kooijman 2008 took eigenvalues from such responses to pulses of the hand one by one;
//! here all windows of all rides are answers of one bicycle.

use super::Unknowns;
use super::time::{Time, Torque};
use crate::error::{Error, Result};
use crate::file;
use crate::ride::Ride;
use bicycle::Formulation;
use std::ops::Range;
use std::path::Path;

/// The windows of `ride` in the CSV file at `path`: columns `start` and `stop` [s, on the clock of
/// the ride] or `start_sample` and `stop_sample` (from 0), the stop not included. A column `file`
/// names the ride of each row, without folder and extension; other columns are not looked at.
pub fn read(path: &Path, ride: &Ride) -> Result<Vec<Range<usize>>> {
    parse(&path.display().to_string(), &file::read_text(path)?, ride)
}

/// The same from `text`, which `file` names in errors.
pub fn parse(file: &str, text: &str, ride: &Ride) -> Result<Vec<Range<usize>>> {
    let mut reader = csv::ReaderBuilder::new()
        .trim(csv::Trim::All)
        .comment(Some(b'#'))
        .from_reader(text.as_bytes());
    let broken = |cause: &csv::Error| Error::WindowFile {
        file: file.into(),
        row: cause.position().map_or(1, csv::Position::line),
        cause: cause.to_string(),
    };
    let header = reader.headers().map_err(|e| broken(&e))?.clone();
    let column = |name: &str| header.iter().position(|cell| cell == name);
    let times = column("start").zip(column("stop"));
    let samples = column("start_sample").zip(column("stop_sample"));
    let Some((start, stop)) = samples.or(times) else {
        return Err(Error::WindowFile {
            file: file.into(),
            row: 1,
            cause: format!(
                "expected columns start and stop, or start_sample and stop_sample, found {}",
                header.iter().collect::<Vec<_>>().join(", ")
            ),
        });
    };
    let ride_file = ride.name();
    let name = Path::new(&ride_file).file_stem().unwrap_or_default();
    let mut windows = Vec::new();
    for record in reader.records() {
        let record = record.map_err(|e| broken(&e))?;
        let other = column("file").is_some_and(|i| {
            record.get(i).is_some_and(|cell| {
                Path::new(cell) != name && Path::new(cell).file_stem() != Some(name)
            })
        });
        if other {
            continue;
        }
        let number = |i: usize| {
            let cell = record.get(i).unwrap_or_default();
            cell.parse::<f64>()
                .ok()
                .filter(|x| x.is_finite() && *x >= 0.0)
                .ok_or_else(|| Error::WindowFile {
                    file: file.into(),
                    row: record.position().map_or(0, csv::Position::line),
                    cause: format!(
                        "expected a number of at least 0 in column `{}`, found `{cell}`",
                        &header[i]
                    ),
                })
        };
        let index = |x: f64| match samples {
            Some(_) => x.round() as usize,
            None => ((x - ride.time(0)) / ride.step()).round().max(0.0) as usize,
        };
        // far outside of any ride, and not at the end of the numbers: it may be added to
        let index = |x: f64| index(x).min(usize::MAX / 2);
        windows.push(index(number(start)?)..index(number(stop)?));
    }
    if windows.is_empty() {
        return Err(Error::WindowFile {
            file: file.into(),
            row: 1,
            cause: format!("expected windows of {ride_file}, found none"),
        });
    }
    Ok(windows)
}

/// The landscape of `windows` [samples] of a ride, at `speed` [m/s] where it does not say, with its
/// `torque` as recorded or none. Contradictory windows are refused: the wrong way round, too short,
/// outside the ride, overlapping another, or over a standstill.
pub fn in_windows(
    ride: &Ride,
    channels: &[&'static str],
    unknowns: Unknowns,
    formulation: Formulation,
    torque: Torque,
    (speed, windows): (f64, &[Range<usize>]),
    noise: Option<&[f64]>,
) -> Result<Time> {
    check(ride, windows)?;
    let free = unknowns.free.len();
    let uncut = Time::uncut(ride, channels, unknowns, formulation, speed, torque)?;
    let shortest = windows
        .iter()
        .map(ExactSizeIterator::len)
        .min()
        .unwrap_or(0);
    if shortest <= uncut.order() {
        return Err(Error::Windows {
            window: shortest as f64 * ride.step(),
            step: ride.step(),
            found: windows.len(),
            free,
        });
    }
    let longest = windows
        .iter()
        .map(ExactSizeIterator::len)
        .max()
        .unwrap_or(0);
    uncut.check_growth(longest as f64 * ride.step(), ride.mean_speed(speed))?;
    uncut.over(windows.to_vec(), noise)
}

fn check(ride: &Ride, windows: &[Range<usize>]) -> Result<()> {
    let standing = ride.standstill();
    let time = |sample: usize| ride.time(0) + sample as f64 * ride.step();
    for (i, window) in windows.iter().enumerate() {
        if window.start + 1 >= window.end || window.end > ride.len() {
            return Err(Error::Window {
                ride: ride.name(),
                start: time(window.start),
                stop: time(window.end),
                from: ride.time(0),
                to: ride.time(ride.len().saturating_sub(1)),
            });
        }
        let overlaps = |other: &&Range<usize>| other.start < window.end && window.start < other.end;
        if let Some(other) = windows[..i].iter().find(overlaps) {
            return Err(Error::Overlapping {
                ride: ride.name(),
                first: (time(other.start), time(other.end)),
                second: (time(window.start), time(window.end)),
            });
        }
        let (start, stop) = (time(window.start), time(window.end - 1));
        if let Some(&span) = standing.iter().find(|s| s.start <= stop && start <= s.stop) {
            return Err(Error::Standstill {
                ride: ride.name(),
                threshold: crate::ride::STANDSTILL,
                span,
            });
        }
    }
    Ok(())
}

#[cfg(test)]
mod tests;
