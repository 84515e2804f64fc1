//! Rides beside each other: which bands of a spectrum rise and which fall.

use crate::error::{Error, Result};
use crate::ride::Ride;
use crate::spectrum::{Analysis, Recipe};
use serde::Serialize;

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
    /// `rises`, `falls`, or `no change` where the interval holds 1.
    pub verdict: &'static str,
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
        let recipe = Recipe {
            band: (low, high),
            ..recipe.clone()
        };
        let mut first = None;
        for (i, ride) in rides.iter().enumerate() {
            let analysis =
                Analysis::new(&recipe, ride.step(), ride.len()).map_err(|cause| Error::InFile {
                    file: ride.name(),
                    cause: Box::new(cause),
                })?;
            let coefficients = analysis.coefficients(ride.signal(channel)?);
            let power: f64 = coefficients.iter().map(nalgebra::Complex::norm_sqr).sum();
            let rms = (2.0 * power / analysis.duration()).sqrt();
            let bins = coefficients.len() as f64;
            let (reference, of) = *first.get_or_insert((rms, bins));
            // the power in n bins scatters by 1/√n, its root by half of that
            let scatter = if i == 0 {
                0.0
            } else {
                1.96 * 0.5 * (1.0 / bins + 1.0 / of).sqrt()
            };
            let ratio = rms / reference;
            let interval = (ratio * (-scatter).exp(), ratio * scatter.exp());
            let verdict = match interval {
                (low, _) if low > 1.0 => "rises",
                (_, high) if high < 1.0 => "falls",
                _ => "no change",
            };
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
                (1.0, 1.0, "no change")
            );
            assert_eq!(band[2].verdict, "rises");
            // a factor of 4, within three standard deviations of the interval stated
            let (low, high) = band[2].interval;
            assert!(low / 1.3 < 4.0 && 4.0 < high * 1.3, "{:?}", band[2]);
        }
    }
}
