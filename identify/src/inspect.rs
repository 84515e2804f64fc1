//! What a ride is like before anything is done with it: channels, ranges, and what looks wrong.

#[cfg(test)]
mod tests;

use crate::ride::{Ride, SPEED, Span};
use serde::Serialize;
use std::fmt;

/// What `wobble inspect` reports.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Inspection {
    /// The file, where the ride comes from one.
    pub file: Option<String>,
    /// SHA-256 of the file, in hexadecimal.
    pub sha256: Option<String>,
    /// Number of samples.
    pub samples: usize,
    /// Sampling rate [Hz].
    pub rate: f64,
    /// Time of the first sample [s].
    pub start: f64,
    /// Duration [s].
    pub duration: f64,
    /// See [`Ride::law_in_loop`].
    pub law_in_loop: Option<bool>,
    /// The channels.
    pub channels: Vec<Summary>,
    /// What was done at the door.
    pub notes: Vec<String>,
    /// What looks wrong, or limits what can be made of the ride.
    pub findings: Vec<Finding>,
}

/// A channel in five numbers, in its unit.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Summary {
    /// Its name.
    pub name: &'static str,
    /// Its SI unit.
    pub unit: &'static str,
    /// Smallest value.
    pub min: f64,
    /// Largest value.
    pub max: f64,
    /// Mean.
    pub mean: f64,
    /// Root mean square about the mean.
    pub rms: f64,
}

/// Something to know before trusting a ride.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[serde(tag = "kind", rename_all = "snake_case")]
pub enum Finding {
    /// The bicycle stands.
    Standstill {
        /// Where.
        spans: Vec<Span>,
    },
    /// A channel that says nothing.
    Constant {
        /// The channel.
        channel: &'static str,
        /// Its only value [SI].
        value: f64,
        /// SI unit.
        unit: &'static str,
    },
    /// Single samples far off both their neighbours.
    Glitch {
        /// The channel.
        channel: &'static str,
        /// How many.
        count: usize,
        /// The farthest value [SI].
        value: f64,
        /// SI unit.
        unit: &'static str,
        /// Where the farthest is.
        at: Span,
    },
    /// A channel in steps, as encoders give it.
    Quantised {
        /// The channel.
        channel: &'static str,
        /// The step [SI].
        step: f64,
        /// SI unit.
        unit: &'static str,
    },
    /// A channel that runs into its largest or smallest value and stays there.
    Clipped {
        /// The channel.
        channel: &'static str,
        /// The value [SI].
        value: f64,
        /// SI unit.
        unit: &'static str,
        /// The longest stretch.
        span: Span,
    },
}

impl fmt::Display for Finding {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Standstill { spans } => {
                let list: Vec<String> = spans.iter().take(3).map(Span::to_string).collect();
                write!(f, "speed: standstill in {}", list.join("; "))?;
                match spans.len() {
                    0..=3 => Ok(()),
                    n => write!(f, "; and {} more", n - 3),
                }
            }
            Self::Constant {
                channel,
                value,
                unit,
            } => {
                write!(f, "{channel}: {value} {unit} throughout")
            }
            Self::Glitch {
                channel,
                count: 1,
                value,
                unit,
                at,
            } => {
                write!(f, "{channel}: a glitch, {value} {unit} in {at}")
            }
            Self::Glitch {
                channel,
                count,
                value,
                unit,
                at,
            } => {
                write!(
                    f,
                    "{channel}: {count} glitches, the farthest {value} {unit} in {at}"
                )
            }
            Self::Quantised {
                channel,
                step,
                unit,
            } => {
                write!(f, "{channel}: in steps of {step:.3e} {unit}")
            }
            Self::Clipped {
                channel,
                value,
                unit,
                span,
            } => {
                write!(
                    f,
                    "{channel}: stays at its extreme {value} {unit} in {span}: clipped?"
                )
            }
        }
    }
}

/// Looks `ride` over.
pub fn inspect(ride: &Ride) -> Inspection {
    let mut findings = Vec::new();
    let spans = ride.standstill();
    if !spans.is_empty() {
        findings.push(Finding::Standstill { spans });
    }
    let mut channels = Vec::new();
    for (row, x) in ride.channels() {
        let summary = Summary::of(row.name, row.unit.symbol, x);
        let Summary {
            name: channel,
            unit,
            min,
            max,
            rms,
            ..
        } = summary;
        if min == max {
            findings.push(Finding::Constant {
                channel,
                value: min,
                unit,
            });
        } else {
            if let Some((count, i)) = glitches(x, rms) {
                let at = ride.span(i, i);
                findings.push(Finding::Glitch {
                    channel,
                    count,
                    value: x[i],
                    unit,
                    at,
                });
            }
            let step = quantum(x, rms);
            if let Some(step) = step {
                findings.push(Finding::Quantised {
                    channel,
                    step,
                    unit,
                });
            }
            // a speed that stays at its extreme is a bicycle that keeps its speed, or stands
            for value in if channel == SPEED {
                vec![]
            } else {
                vec![min, max]
            } {
                if let Some((first, last)) = clipped(x, value, step.unwrap_or(0.0)) {
                    let span = ride.span(first, last);
                    findings.push(Finding::Clipped {
                        channel,
                        value,
                        unit,
                        span,
                    });
                }
            }
        }
        channels.push(summary);
    }
    Inspection {
        file: ride.origin.as_ref().map(|origin| origin.file.clone()),
        sha256: ride.origin.as_ref().map(|origin| origin.sha256.clone()),
        samples: ride.len(),
        rate: ride.rate(),
        start: ride.time(0),
        duration: ride.duration(),
        law_in_loop: ride.law_in_loop,
        channels,
        notes: ride.notes.clone(),
        findings,
    }
}

impl Summary {
    fn of(name: &'static str, unit: &'static str, x: &[f64]) -> Self {
        let n = x.len() as f64;
        let mean = x.iter().sum::<f64>() / n;
        Self {
            name,
            unit,
            min: x.iter().copied().fold(f64::INFINITY, f64::min),
            max: x.iter().copied().fold(f64::NEG_INFINITY, f64::max),
            mean,
            rms: (x.iter().map(|x| (x - mean).powi(2)).sum::<f64>() / n).sqrt(),
        }
    }
}

/// Changes finer than this part of the rms are the rounding of printed numbers, not an encoder's.
const COARSE: f64 = 0.005;

/// How many single samples stick out, and the index of the farthest; none where none does.
///
/// A sample sticks out by the smaller of its distances to its neighbours, if both lie on the same
/// side; at an end, to the neighbour and to the line through the next two. Out of the ordinary is
/// what exceeds ten times the rms of the lower 99 % of these distances, and three times the
/// signal's rms: no band-limited signal does that.
fn glitches(x: &[f64], rms: f64) -> Option<(usize, usize)> {
    let n = x.len();
    if n < 4 {
        return None;
    }
    let out = |i: usize| {
        let (a, b) = match i {
            0 => (x[0] - x[1], x[0] - (2.0 * x[1] - x[2])),
            _ if i == n - 1 => (x[i] - x[i - 1], x[i] - (2.0 * x[i - 1] - x[i - 2])),
            _ => (x[i] - x[i - 1], x[i] - x[i + 1]),
        };
        if a * b > 0.0 {
            a.abs().min(b.abs())
        } else {
            0.0
        }
    };
    let distances: Vec<f64> = (0..n).map(out).collect();
    let mut sorted = distances.clone();
    sorted.sort_by(f64::total_cmp);
    let ordinary = &sorted[..(n - n.div_ceil(100))];
    let scale = (ordinary.iter().map(|d| d * d).sum::<f64>() / ordinary.len() as f64).sqrt();
    let threshold = (10.0 * scale).max(3.0 * rms);
    let count = distances.iter().filter(|d| **d > threshold).count();
    let farthest = (0..n).max_by(|&a, &b| distances[a].total_cmp(&distances[b]))?;
    (count > 0).then_some((count, farthest))
}

/// The step of a signal that moves in whole steps: the smallest change (but for one in fifty),
/// if nineteen in twenty of the changes up to three times as large are whole multiples of it.
/// (Printed numbers are rounded, so that ten steps need not be ten times one.)
fn quantum(x: &[f64], rms: f64) -> Option<f64> {
    let mut changes: Vec<f64> = x
        .windows(2)
        .map(|pair| (pair[1] - pair[0]).abs())
        .filter(|c| *c > COARSE * rms)
        .collect();
    changes.sort_by(f64::total_cmp);
    let step = *changes.get(changes.len() / 50)?;
    let few = &changes[..changes.partition_point(|change| *change < 3.5 * step)];
    let whole = |change: &&f64| (*change / step - (*change / step).round()).abs() < 0.1;
    let multiples = few.iter().filter(whole).count();
    (few.len() >= 10 && multiples * 20 >= few.len() * 19).then_some(step)
}

/// The longest stretch of at least ten samples at `extreme` into which the signal runs faster
/// than it usually changes, and by more than three steps of its `quantum`; first and last index.
fn clipped(x: &[f64], extreme: f64, quantum: f64) -> Option<(usize, usize)> {
    let changes = x
        .windows(2)
        .map(|pair| (pair[1] - pair[0]).powi(2))
        .sum::<f64>();
    let usual = (changes / x.len() as f64).sqrt();
    let fast = (0.5 * usual).max(3.0 * quantum);
    let mut longest: Option<(usize, usize)> = None;
    let mut i = 0;
    for run in x.chunk_by(|a, b| a == b) {
        let (first, last) = (i, i + run.len() - 1);
        i += run.len();
        let enters = first >= 2 && (x[first] - x[first - 2]).abs() > fast;
        if run[0] == extreme
            && run.len() >= 10
            && enters
            && longest.is_none_or(|(a, b)| last - first > b - a)
        {
            longest = Some((first, last));
        }
    }
    longest
}
