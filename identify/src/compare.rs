//! Rides beside each other: which bands of a spectrum rise and which fall.

mod loads;

pub use loads::{Cell, Level, Loads, SLICE, Shift, loads};

use crate::distribution::{f_quantile, gamma_quantile};
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

/// Probability that an interval holds the truth.
const CONFIDENCE: f64 = 0.95;

/// 95 % interval of a `ratio` of two root mean squares of noise, from so many bins each: the ratio of
/// the powers over that of their expectations is F with twice the bins as degrees of freedom.
pub(crate) fn noise_interval(ratio: f64, bins: usize, of: usize) -> (f64, f64) {
    about(ratio, noise_limits(bins, of), 1.0)
}

/// The same of what is expected over what was found, from bins worth `bins` independent ones: their
/// power over its expectation is gamma over its shape.
pub(crate) fn expectation_interval(ratio: f64, bins: f64) -> (f64, f64) {
    about(ratio, gamma_limits(bins), 1.0)
}

/// Logarithms of the limits that hold √(F(2 `of`, 2 `bins`)) with [`CONFIDENCE`]: those of an
/// expected ratio over the found one.
fn noise_limits(bins: usize, of: usize) -> (f64, f64) {
    tails(|p| f_quantile(2.0 * of as f64, 2.0 * bins as f64, p))
}

/// The same of the found root mean square of `bins` bins over the expected one.
fn gamma_limits(bins: f64) -> (f64, f64) {
    tails(|p| gamma_quantile(bins, p) / bins)
}

fn tails(power: impl Fn(f64) -> f64) -> (f64, f64) {
    let tail = 0.5 * (1.0 - CONFIDENCE);
    (0.5 * power(tail).ln(), 0.5 * power(1.0 - tail).ln())
}

/// `x` between limits in logarithms, `stretch` times as far off.
fn about(x: f64, (low, high): (f64, f64), stretch: f64) -> (f64, f64) {
    (x * (stretch * low).exp(), x * (stretch * high).exp())
}

#[cfg(test)]
mod tests {
    #![expect(clippy::unwrap_used, reason = "a failed step is a failed test")]
    use super::*;
    use crate::bicycles::{Bicycle, Changes};
    use crate::run::Source;
    use crate::spectrum::Line;
    use crate::study::{Entry, Labels};
    use crate::synthesis::Synthesis;
    use bicycle::Excitation;
    use rand::SeedableRng;
    use rand_distr::{Distribution, StandardNormal};

    /// White noise of standard deviation `level` for 24 s at 100 Hz, as an entry of a study.
    fn entry(trail: f64, load: f64, level: f64, seed: u64) -> Entry {
        let mut rng = rand_xoshiro::Xoshiro256PlusPlus::seed_from_u64(seed);
        let mut normal = || -> f64 { StandardNormal.sample(&mut rng) };
        let mut ride = Ride::new(0.0, 0.01, 2400);
        let steer = (0..2400).map(|_| level * normal()).collect();
        ride.insert("steer", steer).unwrap();
        Entry {
            source: Source::of(&ride),
            ride,
            bicycle: Bicycle::open("nominal", &Changes::default()).unwrap(),
            labels: Labels {
                rider: "75kg,1.78m".into(),
                load,
                trail,
                speed: 2.0,
                condition: String::new(),
            },
        }
    }

    #[test]
    fn loads_are_held_against_the_smallest_of_the_same_trail() {
        let entries = [
            entry(0.13, 20.0, 4.0, 1),
            entry(0.13, 0.0, 1.0, 2),
            entry(0.085, 0.0, 1.0, 3),
            entry(0.085, 10.0, 0.25, 4),
            entry(0.085, 20.0, 1.0, 3),
            entry(-0.035, 0.0, 1.0, 5),
        ];
        let found = loads(&entries, "steer", &Recipe::default()).unwrap();
        let of = |cell: &Cell| (cell.trail, cell.load, cell.bands[1].verdict);
        assert_eq!(
            found.cells.iter().map(of).collect::<Vec<_>>(),
            [
                (0.13, 20.0, Change::Rises),
                (0.085, 10.0, Change::Falls),
                (0.085, 20.0, Change::None)
            ]
        );
        // the same noise, ride by ride: the same ratio
        assert!(found.cells[2].slices.iter().all(|slice| slice.ratio == 1.0));
        assert_eq!(found.notes, ["no other load to hold ride against"]);
        let (down, across) = found.labels();
        assert_eq!(
            down,
            ["rider 75kg, 1.78m, 20 kg", "rider 75kg, 1.78m, 10 kg"]
        );
        assert_eq!(across, ["trail 0.130 m", "trail 0.085 m"]);
        assert!(
            found
                .table()
                .contains("0.8 to 1.6 Hz: rises in 1, falls in 1, no change in 1 of 3")
        );
        // alone there is nothing to compare
        assert!(loads(&entries[5..], "steer", &Recipe::default()).is_err());
    }

    #[test]
    fn a_slice_under_a_line_is_left_out() {
        let recipe = Recipe {
            lines: vec![Line { frequency: 1.2 }],
            ..Recipe::default()
        };
        let entries = [entry(0.1, 0.0, 1.0, 1), entry(0.1, 20.0, 1.0, 2)];
        let cell = &loads(&entries, "steer", &recipe).unwrap().cells[0];
        // of the 14 slices of 2.7/14 Hz, ± 3/24 s about 1.2 Hz covers that from 1.07 to 1.26 Hz
        assert_eq!((cell.bands.len(), cell.slices.len()), (3, 13));
        let narrow = Recipe {
            band: (1.15, 1.25),
            ..recipe
        };
        assert_eq!(
            loads(&entries, "steer", &narrow).unwrap().cells[0].slices,
            []
        );
    }

    /// The part of slices that change where noise is held against noise, and their number.
    fn changed(rides: u8) -> (f64, f64) {
        let (mut changed, mut all) = (0, 0);
        for seed in 0..200 {
            let entries: Vec<_> = (0..2 * rides)
                .map(|n| entry(0.1, f64::from(n % 2), 1.0, seed * 100 + u64::from(n)))
                .collect();
            let found = loads(&entries, "steer", &Recipe::default()).unwrap();
            let slices = &found.cells[0].slices;
            all += slices.len();
            changed += slices.iter().filter(|s| s.verdict != Change::None).count();
        }
        (f64::from(changed as u32) / all as f64, all as f64)
    }

    #[test]
    fn noise_against_noise_changes_as_often_as_the_intervals_say() {
        for (rides, expected) in [
            // one slice in twenty
            (1, 0.05),
            // the larger of noise and scatter between rides is taken, which is more than either
            (3, 0.021),
        ] {
            let (changed, all) = changed(rides);
            // three binomial deviations of 2800 slices, .012 and .008
            let reach = 3.0 * (expected * (1.0 - expected) / all).sqrt();
            assert!((changed - expected).abs() < reach, "{rides}: {changed}");
        }
    }

    #[test]
    fn an_interval_of_few_bins_holds_the_ratio_as_often_as_it_says() {
        let mut rng = rand_xoshiro::Xoshiro256PlusPlus::seed_from_u64(7);
        for bins in [1, 5] {
            let gamma = rand_distr::Gamma::new(f64::from(bins), 1.0).unwrap();
            let n = 10_000;
            let (mut held, mut expected) = (0, 0);
            for _ in 0..n {
                let (of, over): (f64, f64) = (gamma.sample(&mut rng), gamma.sample(&mut rng));
                let holds = |(low, high): (f64, f64)| i32::from(low < 1.0 && 1.0 < high);
                held += holds(noise_interval(
                    (over / of).sqrt(),
                    bins as usize,
                    bins as usize,
                ));
                let model = (f64::from(bins) / of).sqrt();
                expected += holds(expectation_interval(model, bins.into()));
            }
            // 3.3 binomial deviations of 9500: 22
            for held in [held, expected] {
                assert!((held - 9500).abs() < 72, "{bins} bins: {held}");
            }
        }
    }

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
            // a factor of 4, within 1.7 times the interval: 3.3 standard deviations
            let (low, high) = band[2].interval;
            let reach = (high / low).powf(0.35);
            assert!(low / reach < 4.0 && 4.0 < high * reach, "{:?}", band[2]);
        }
    }
}
