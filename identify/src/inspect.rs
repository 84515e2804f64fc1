//! What a ride is like before anything is done with it: channels, ranges, and what looks wrong.

mod finding;
mod page;
mod signs;
#[cfg(test)]
mod tests;

pub use finding::Finding;
pub use page::html;

use crate::ride::{Ride, SPEED};
use crate::spectrum::{Analysis, Recipe};
use serde::Serialize;
pub(crate) use signs::glitches;
use signs::{clipped, drift, dropouts, freezes, quantum};

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

/// Looks `ride` over.
pub fn inspect(ride: &Ride) -> Inspection {
    let mut findings = Vec::new();
    let spans = ride.standstill();
    if !spans.is_empty() {
        findings.push(Finding::Standstill { spans });
    }
    let backwards = ride.backwards();
    findings.extend(backwards.map(|speed| Finding::Backwards { speed }));
    let moving: Vec<_> = ride
        .channels()
        .filter(|(_, x)| x.iter().any(|value| *value != x[0]))
        .collect();
    let samples: Vec<&[f64]> = moving.iter().map(|(_, x)| *x).collect();
    let names = || moving.iter().map(|(row, _)| row.name).collect();
    findings.extend(dropout(ride, names(), &freezes(&samples)));
    let mut channels = Vec::new();
    for (row, x) in ride.channels() {
        let summary = Summary::of(row.name, row.unit.symbol, x);
        let Summary {
            name: channel,
            unit,
            min,
            max,
            mean,
            rms,
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
            } else {
                // one sample can be as large as it likes
                findings.extend(improbable(channel, rms.hypot(mean), unit));
            }
            let step = quantum(x, rms);
            if let Some(step) = step {
                findings.push(Finding::Quantised {
                    channel,
                    step,
                    noise: step / 12.0_f64.sqrt(),
                    unit,
                });
            }
            let stops = dropouts(x, step.unwrap_or(0.0));
            findings.extend(dropout(ride, vec![channel], &stops));
            if let Some(change) = drift(x, rms).filter(|_| !TRAVELS.contains(&channel)) {
                findings.push(Finding::Drift {
                    channel,
                    change,
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
    findings.extend(lines(ride));
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

/// Root mean squares that no ridden bicycle reaches [SI]: 40° of lean or of steer throughout is a fall, and a
/// hand turns no handlebar at 20 rad/s throughout. Angles in degrees under another name do.
const MOST: [(&str, f64); 5] = [
    ("steer", 0.7),
    ("roll", 0.7),
    ("steer_rate", 20.0),
    ("roll_rate", 10.0),
    ("yaw_rate", 10.0),
];

/// A channel of such root mean square, if no ridden bicycle has one.
fn improbable(channel: &'static str, rms: f64, unit: &'static str) -> Option<Finding> {
    let (_, most) = MOST.into_iter().find(|(name, _)| *name == channel)?;
    (rms > most).then_some(Finding::Improbable {
        channel,
        rms,
        most,
        unit,
    })
}

/// What may well be another at the end of a ride than at its start.
const TRAVELS: [&str; 5] = [SPEED, "heading", "x", "y", "lateral_offset"];

/// Those `stretches` (first and last index) as a finding, if there are any.
fn dropout(
    ride: &Ride,
    channels: Vec<&'static str>,
    stretches: &[(usize, usize)],
) -> Option<Finding> {
    let longest = stretches.iter().max_by_key(|(first, last)| last - first)?;
    Some(Finding::Dropout {
        channels,
        count: stretches.len(),
        span: ride.span(longest.0, longest.1),
    })
}

/// The channels whose spectra are looked at for lines.
const SPECTRAL: [&str; 4] = ["steer", "roll_rate", "yaw_rate", "steer_torque"];

/// Lines this close to a stronger one are that one's [Hz]: a sine kept by hand is no sharp line.
const ONE_LINE: f64 = 0.3;

/// Lines of the spectra, each of the first channel that shows it, the strongest first; none of a
/// ride too short for one.
fn lines(ride: &Ride) -> Vec<Finding> {
    let Ok(analysis) = Analysis::new(&Recipe::default(), ride.step(), ride.len()) else {
        return Vec::new();
    };
    let speed = ride.has(SPEED).then(|| ride.mean_speed(0.0));
    let mut found: Vec<(f64, Finding)> = Vec::new();
    for name in SPECTRAL {
        let (Ok(x), Ok(row)) = (ride.signal(name), crate::ride::quantity(name)) else {
            continue;
        };
        let sine = |frequency: f64| (analysis.line_amplitude(x, frequency), frequency);
        let mut sines: Vec<_> = analysis.standing_lines(x).into_iter().map(sine).collect();
        sines.sort_by(|a, b| b.0.total_cmp(&a.0));
        for (amplitude, frequency) in sines {
            if found
                .iter()
                .any(|(known, _)| (known - frequency).abs() < ONE_LINE)
            {
                continue;
            }
            let line = Finding::Line {
                channel: row.name,
                frequency,
                amplitude,
                unit: row.unit.symbol,
                // two cones a period
                cones: speed.map(|speed| speed.abs() / (2.0 * frequency)),
            };
            found.push((frequency, line));
        }
    }
    found.into_iter().map(|(_, line)| line).collect()
}

impl Summary {
    fn of(name: &'static str, unit: &'static str, x: &[f64]) -> Self {
        let n = x.len() as f64;
        // the mean of one value is that value, to the last digit too
        let constant = x.iter().all(|value| *value == x[0]);
        let mean = if constant {
            x[0]
        } else {
            x.iter().sum::<f64>() / n
        };
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
