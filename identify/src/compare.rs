//! Rides beside each other: which bands of a spectrum rise and which fall.

use crate::error::Result;
use crate::ride::Ride;
use crate::spectrum::{Analysis, Recipe};
use nalgebra::Complex;
use serde::Serialize;
use std::fmt;

/// The bands [Hz] that the paper's discussion distinguishes: slow balancing, the oscillation,
/// what lies above.
pub const BANDS: [(f64, f64); 3] = [(0.3, 0.8), (0.8, 1.6), (1.6, 3.0)];

/// The amplitude spectrum of a channel of a ride.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Amplitudes {
    /// The ride's file.
    pub ride: String,
    /// Name of the channel.
    pub channel: String,
    /// Its unit.
    pub unit: &'static str,
    /// Frequencies of the bins [Hz].
    pub frequency: Vec<f64>,
    /// One-sided amplitudes [SI].
    pub amplitude: Vec<f64>,
}

/// The residual of a ride in a band.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct BandRow {
    /// The ride's file.
    pub ride: String,
    /// Low end [Hz].
    pub low: f64,
    /// High end [Hz].
    pub high: f64,
    /// Root mean square of the residual in the band [SI].
    pub rms: f64,
    /// Over that of the first ride.
    pub ratio: f64,
    /// 95 % interval of the ratio, both taken for noise; a slalom or pedalling line is none.
    pub interval: (f64, f64),
    /// What the interval says.
    pub verdict: Change,
}

/// Whether a ratio differs from 1 for all that its interval knows.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
pub enum Change {
    /// The interval lies above 1.
    #[serde(rename = "rises")]
    Rises,
    /// It lies below 1.
    #[serde(rename = "falls")]
    Falls,
    /// It holds 1.
    #[serde(rename = "no change")]
    None,
}

impl Change {
    /// What an interval of a ratio says.
    pub fn of(interval: (f64, f64)) -> Self {
        match interval {
            (low, _) if low > 1.0 => Self::Rises,
            (_, high) if high < 1.0 => Self::Falls,
            _ => Self::None,
        }
    }

    /// The name in tables.
    pub fn name(self) -> &'static str {
        match self {
            Self::Rises => "rises",
            Self::Falls => "falls",
            Self::None => "no change",
        }
    }
}

impl fmt::Display for Change {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.pad(self.name())
    }
}

/// The amplitude spectrum of `channel` of `ride`.
pub fn amplitudes(ride: &Ride, channel: &str, recipe: &Recipe) -> Result<Amplitudes> {
    let analysis = Analysis::new(recipe, ride.step(), ride.len())?;
    let unit = analysis.to_amplitude();
    let coefficients = analysis.coefficients(ride.signal(channel)?);
    Ok(Amplitudes {
        ride: ride.name(),
        channel: channel.into(),
        unit: crate::ride::quantity(channel)?.unit.symbol,
        frequency: analysis.frequencies(),
        amplitude: coefficients.iter().map(|y| unit * y.norm()).collect(),
    })
}

/// Each ride's residual in each of [`BANDS`] against the first ride's.
pub fn bands(rides: &[Ride], channel: &str, recipe: &Recipe) -> Result<Vec<BandRow>> {
    let mut rows: Vec<BandRow> = Vec::new();
    for (low, high) in BANDS {
        let recipe = within(recipe, (low, high));
        let mut first = None;
        for (i, ride) in rides.iter().enumerate() {
            let analysis = Analysis::new(&recipe, ride.step(), ride.len())
                .map_err(|cause| cause.in_file(ride.name()))?;
            let rms = mean_square(&analysis, ride.signal(channel)?).sqrt();
            let bins = analysis.frequencies().len();
            let (reference, of) = *first.get_or_insert((rms, bins));
            let ratio = rms / reference;
            let interval = if i == 0 {
                (ratio, ratio)
            } else {
                noise_interval(ratio, bins, of)
            };
            let verdict = Change::of(interval);
            rows.push(BandRow {
                ride: ride.name(),
                low,
                high,
                rms,
                ratio,
                interval,
                verdict,
            });
        }
    }
    Ok(rows)
}

/// `recipe` within another band [Hz].
pub(crate) fn within(recipe: &Recipe, band: (f64, f64)) -> Recipe {
    Recipe {
        band,
        ..recipe.clone()
    }
}

/// Mean square [SI²] of the residual of `samples` in the band of `analysis`.
pub(crate) fn mean_square(analysis: &Analysis, samples: &[f64]) -> f64 {
    let coefficients = analysis.coefficients(samples);
    let power: f64 = coefficients.iter().map(Complex::norm_sqr).sum();
    2.0 * power / analysis.duration()
}

/// 95 % interval of a `ratio` of two root mean squares of noise, from so many bins each.
pub(crate) fn noise_interval(ratio: f64, bins: usize, of: usize) -> (f64, f64) {
    // the power in n bins scatters by 1/√n, its root by half of that
    let scatter = 1.96 * 0.5 * (1.0 / bins as f64 + 1.0 / of as f64).sqrt();
    (ratio * (-scatter).exp(), ratio * scatter.exp())
}

#[cfg(test)]
mod tests {
    #![expect(clippy::unwrap_used, reason = "a failed step is a failed test")]
    use super::*;
    use crate::synthesis::Synthesis;
    use bicycle::Excitation;

    #[test]
    fn twice_the_remnant_doubles_every_band_and_a_ride_does_not_change_against_itself() {
        let ride = |intensity, seed| {
            let excitation = Excitation {
                remnant_intensity: intensity,
                ..Excitation::default()
            };
            Synthesis {
                excitation,
                seed,
                ..Synthesis::default()
            }
            .ride()
            .unwrap()
        };
        let rows = bands(
            &[ride(1.0, 1), ride(1.0, 1), ride(4.0, 2)],
            "steer",
            &Recipe::default(),
        )
        .unwrap();
        for band in rows.chunks(3) {
            assert_eq!(
                (band[0].ratio, band[1].ratio, band[1].verdict),
                (1.0, 1.0, Change::None)
            );
            assert_eq!(band[2].verdict, Change::Rises);
            // a factor of 4, within three standard deviations of the interval stated
            let (low, high) = band[2].interval;
            assert!(low / 1.3 < 4.0 && 4.0 < high * 1.3, "{:?}", band[2]);
        }
    }
}
