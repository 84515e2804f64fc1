//! Bootstrap: the whole fit done again on data made again. What its estimates scatter by is the
//! uncertainty, skewness and bias included.
//!
//! Spectra: rides of the fitted model, as long, as noisy and as driven as the measured ones, with
//! seeds of their own (Efron & Tibshirani 1993, §6.5): the correlation of neighbouring bins and
//! what the linearisation leaves out are in them. Replayed windows: the windows drawn with
//! replacement, which asks nothing of the model's noise (ibid., §8.4).

use crate::checkpoint::Journal;
use crate::distribution::COVERAGE;
use crate::error::{Error, Result};
use crate::objective::Objective;
use crate::objective::spectral::Spectral;
use crate::objective::time::Time;
use crate::objective::together::{Member, Together};
use crate::objective::whittle::Whittle;
use crate::plan::{Plan, Ridden};
use crate::problem::{Problem, Rides};
use crate::progress::{Event, Watch};
use crate::ride::Ride;
use crate::solver::Outcome;
use crate::starts::stream;
use crate::synthesis::{SensorNoise, Synthesis, TorqueLine};
use bicycle::{Excitation, Input};
use nalgebra::DVector;
use rand::Rng;
use rand_distr::{Distribution, StandardNormal};
use rayon::prelude::*;
use serde::{Deserialize, Serialize};
use std::sync::atomic::{AtomicU64, Ordering};

/// What a parameter's bootstrap estimates say of it.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Scatter {
    /// Standard deviation of the estimates.
    pub std_error: f64,
    /// Median of the estimates less the value that made the data.
    pub bias: f64,
    /// 2.5 % to 97.5 % of the estimates.
    pub percentile: (f64, f64),
    /// The same quantiles mirrored at the value: an estimator that is biased upwards lowers it.
    pub basic: (f64, f64),
}

/// The `p` quantile of sorted values: order statistic p (n + 1), straight in between.
fn quantile(sorted: &[f64], p: f64) -> f64 {
    let place = (p * (sorted.len() + 1) as f64 - 1.0).clamp(0.0, (sorted.len() - 1) as f64);
    let low = place.floor() as usize;
    let high = (low + 1).min(sorted.len() - 1);
    sorted[low] + (sorted[high] - sorted[low]) * (place - low as f64)
}

/// The scatter of `estimates` about the `value` that made their data; none of fewer than two.
pub fn scatter(value: f64, estimates: &[f64]) -> Option<Scatter> {
    if estimates.len() < 2 {
        return None;
    }
    let mut sorted = estimates.to_vec();
    sorted.sort_by(f64::total_cmp);
    let n = sorted.len() as f64;
    let mean = sorted.iter().sum::<f64>() / n;
    let square: f64 = sorted.iter().map(|v| (v - mean).powi(2)).sum();
    let tail = 0.5 * (1.0 - COVERAGE);
    let (low, high) = (quantile(&sorted, tail), quantile(&sorted, 1.0 - tail));
    Some(Scatter {
        std_error: (square / (n - 1.0)).sqrt(),
        bias: quantile(&sorted, 0.5) - value,
        percentile: (low, high),
        basic: (2.0 * value - high, 2.0 * value - low),
    })
}

/// What one job of a bootstrap found: the shared variables; none where a ride fell or the search
/// did not arrive.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Draw {
    /// The variables.
    pub z: Option<Vec<f64>>,
}

/// How the data of a bootstrap are made.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub enum Kind {
    /// Rides of the fitted model.
    #[serde(rename = "simulated rides")]
    Rides,
    /// Windows drawn with replacement.
    #[serde(rename = "windows drawn with replacement")]
    Windows,
}

/// A parameter's row of a bootstrap [SI].
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Row {
    /// The parameter, and of which ride or condition it is.
    pub name: String,
    /// The value that made the data.
    pub value: f64,
    /// Scatter of the estimates; none of fewer than two. Basic intervals are mirrored on the scale
    /// of the search and kept within its bounds.
    pub scatter: Option<Scatter>,
    /// Estimates that ended at a bound.
    pub at_bound: usize,
}

/// What a bootstrap found.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Resampled {
    /// How its data were made.
    pub kind: Kind,
    /// Seed.
    pub seed: u64,
    /// Jobs asked for; more than ended only where the bootstrap was stopped.
    pub planned: u64,
    /// Jobs that ended.
    pub jobs: usize,
    /// Jobs without an estimate.
    pub failed: usize,
    /// The parameters.
    pub parameters: Vec<Row>,
}

/// A fit to be done again and again: many independent jobs, each the same whenever and in whatever
/// order it runs.
pub struct Bootstrap<'a> {
    rides: &'a [Ridden<'a>],
    plan: Plan,
    problem: &'a Problem,
    z: DVector<f64>,
    seed: u64,
}

impl<'a> Bootstrap<'a> {
    /// Of the fit of `plan` to `rides`, which is `problem` and ended in the shared variables `z`.
    pub fn new(
        rides: &'a [Ridden<'a>],
        plan: &Plan,
        problem: &'a Problem,
        z: &DVector<f64>,
        seed: u64,
    ) -> Result<Self> {
        problem.objective.check(
            "a bootstrap",
            &[Objective::Amplitude, Objective::Whittle, Objective::Time],
        )?;
        if plan.model.foreign().is_some() {
            return Err(Error::Form {
                expected: "a bootstrap of our own equations",
                found: "an FMU as the model".into(),
            });
        }
        let mut plan = plan.clone();
        match &problem.rides {
            Rides::Frf(_) => {}
            Rides::Time(windows) => {
                // the seams between windows are not the sensors' noise
                let n = windows.members.len() as f64;
                let mean_square = |c: usize| {
                    let squares = windows.members.iter().map(|m| m.landscape.noise[c].powi(2));
                    (squares.sum::<f64>() / n).sqrt()
                };
                plan.noise = Some((0..problem.channels.len()).map(mean_square).collect());
            }
            Rides::Amplitude(spectra) | Rides::Whittle(spectra) => {
                let lines = |m: &Member<Whittle>| m.landscape.spectral.measured.lines.len();
                if let Some(found) = spectra.members.iter().map(lines).find(|&n| n > 1) {
                    return Err(Error::Form {
                        expected: "a bootstrap of rides with one masked line at most",
                        found: format!("{found} lines"),
                    });
                }
            }
        }
        Ok(Self {
            rides,
            plan,
            problem,
            z: z.rows(0, problem.shared()).into_owned(),
            seed,
        })
    }

    /// How its data are made.
    pub fn kind(&self) -> Kind {
        match self.problem.rides {
            Rides::Time(_) => Kind::Windows,
            Rides::Amplitude(_) | Rides::Whittle(_) | Rides::Frf(_) => Kind::Rides,
        }
    }

    /// Job number `job`: data made again and fitted from the estimates on; none where `watch` asked
    /// for a stop before the fit had ended.
    pub fn draw(&self, job: u64, watch: &Watch) -> Option<Draw> {
        match self.refit(job, watch) {
            Ok(outcome) if outcome.stopped => None,
            Ok(outcome) => {
                let shared = outcome.point.rows(0, self.z.len());
                let z = outcome.converged.then(|| shared.iter().copied().collect());
                Some(Draw { z })
            }
            Err(_) => Some(Draw { z: None }),
        }
    }

    fn refit(&self, job: u64, watch: &Watch) -> Result<Outcome> {
        let mut rng = stream(self.seed, job);
        let made: Vec<Result<Ride>> = match &self.problem.rides {
            Rides::Amplitude(spectra) | Rides::Whittle(spectra) => {
                let models = spectra.each(&self.z, |ride, z| (ride.spectral.clone(), z.clone()));
                let rides = models.iter().zip(self.rides);
                rides
                    .map(|((spectral, z), ridden)| simulated(spectral, z, ridden, rng.random()))
                    .collect()
            }
            Rides::Frf(_) => Vec::new(),
            Rides::Time(windows) => {
                let rides = windows.members.iter().zip(self.rides);
                rides
                    .map(|(member, ridden)| redrawn(&member.landscape, ridden.ride, &mut rng))
                    .collect()
            }
        };
        let made = made.into_iter().collect::<Result<Vec<_>>>()?;
        let ridden: Vec<Ridden> = made
            .iter()
            .zip(self.rides)
            .map(|(ride, ridden)| Ridden {
                ride,
                ..ridden.clone()
            })
            .collect();
        let mut problem = Problem::new(&ridden, &self.plan)?;
        // a prior is a datum as well
        problem.redraw_known(&self.z, &mut rng);
        if let (Rides::Time(windows), Rides::Time(redrawn)) = (&self.problem.rides, &problem.rides)
        {
            let count = |rides: &Together<Time>| -> usize {
                rides.members.iter().map(|m| m.landscape.windows()).sum()
            };
            if count(redrawn) != count(windows) {
                let why = "a seam between windows was taken for a glitch of the sensor";
                return Err(Error::Search(why.into()));
            }
        }
        Ok(problem.search(&self.z, &[], &watch.silent())?.outcome)
    }

    /// Jobs 0 to `jobs`, all cores at work. What has ended is in `journal`, and what `journal` has is
    /// not done again; a bootstrap of more jobs holds those of fewer. A stop gives what has ended.
    pub fn run(&self, jobs: u64, journal: &Journal<Draw>, watch: &Watch) -> Result<Resampled> {
        let ended = AtomicU64::new(0);
        let job = |job: u64| {
            let draw = match journal.get(job) {
                Some(draw) => draw,
                None if watch.stopped() => return Ok(None),
                None => match self.draw(job, watch) {
                    Some(draw) => journal.put(job, &draw)?,
                    None => return Ok(None),
                },
            };
            let done = ended.fetch_add(1, Ordering::Relaxed) + 1;
            watch.tell(Event::Done {
                done,
                of: jobs,
                best: None,
            });
            Ok(Some(draw))
        };
        let draws = (0..jobs).into_par_iter().map(job);
        let draws: Vec<Option<Draw>> = draws.collect::<Result<_>>()?;
        let ended: Vec<Draw> = draws.into_iter().flatten().collect();
        Ok(self.summary(&ended, jobs))
    }

    /// What `draws` of `planned` jobs say.
    fn summary(&self, draws: &[Draw], planned: u64) -> Resampled {
        let found: Vec<&Vec<f64>> = draws.iter().filter_map(|d| d.z.as_ref()).collect();
        let limits = self.problem.limits();
        let row = |i: usize| {
            let variable = &self.problem.variables[i];
            let free = &variable.free;
            let (low, high) = (limits.lower[i], limits.upper[i]);
            let estimates: Vec<f64> = found.iter().map(|z| z[i]).collect();
            let value = free.value(self.z[i]);
            let si = |z: f64| free.value(z.clamp(low, high));
            let both = |(a, b): (f64, f64)| (si(a), si(b));
            let edge = 1e-6 * (high - low);
            Row {
                name: variable.to_string(),
                value,
                scatter: scatter(self.z[i], &estimates).map(|s| Scatter {
                    std_error: s.std_error * free.slope(value),
                    bias: free.value(self.z[i] + s.bias) - value,
                    percentile: both(s.percentile),
                    basic: both(s.basic),
                }),
                at_bound: estimates
                    .iter()
                    .filter(|z| **z - low < edge || high - **z < edge)
                    .count(),
            }
        };
        Resampled {
            kind: self.kind(),
            seed: self.seed,
            planned,
            jobs: draws.len(),
            failed: draws.len() - found.len(),
            parameters: (0..self.z.len()).map(row).collect(),
        }
    }
}

/// A ride of the model at `z`, as long as `ridden` and with its noise.
fn simulated(spectral: &Spectral, z: &DVector<f64>, ridden: &Ridden, seed: u64) -> Result<Ride> {
    let measured = &spectral.measured;
    let (parameters, drive) = spectral.setting(z);
    let line = match measured.lines.first() {
        Some(line) => Some(TorqueLine {
            frequency: line.frequency,
            amplitude: spectral.closed_loop(z)?.torque_amplitude(line),
        }),
        None => None,
    };
    let mut ride = Synthesis {
        parameters,
        formulation: spectral.formulation,
        input: Input {
            speed: drive.speed,
            ..Input::default()
        },
        excitation: Excitation {
            remnant_intensity: drive.remnant_intensity,
            remnant_corner: drive.remnant_corner,
            ..Excitation::default()
        },
        line,
        duration: ridden.ride.duration(),
        rate: ridden.ride.rate(),
        noise: SensorNoise::NONE,
        seed,
        ..Synthesis::default()
    }
    .ride()?;
    // the ride's remnant is drawn from stream 0
    let mut rng = stream(seed, 1);
    for (channel, noise) in measured.channels.iter().zip(&measured.noise) {
        let noisy = ride.channel(channel)?.iter().map(|value| {
            let normal: f64 = StandardNormal.sample(&mut rng);
            value + noise * normal
        });
        let noisy = noisy.collect();
        ride.insert(channel, noisy)?;
    }
    Ok(ride)
}

/// The windows of `ride` drawn with replacement, one behind the other: each is replayed from a
/// start of its own, so that the seams do not matter.
fn redrawn(windows: &Time, ride: &Ride, rng: &mut impl Rng) -> Result<Ride> {
    let windows = windows.ranges();
    let n = windows.len();
    let drawn: Vec<_> = (0..n).map(|_| &windows[rng.random_range(0..n)]).collect();
    let samples = drawn.iter().map(|window| window.len()).sum();
    let mut redrawn = Ride::new(0.0, ride.step(), samples);
    redrawn.law_in_loop = ride.law_in_loop;
    for (row, samples) in ride.channels() {
        let windows = drawn.iter().flat_map(|window| &samples[(*window).clone()]);
        redrawn.insert(row.name, windows.copied().collect())?;
    }
    Ok(redrawn)
}

#[cfg(test)]
mod tests {
    #![expect(clippy::unwrap_used, reason = "a failed step is a failed test")]
    use super::*;

    #[test]
    fn quantiles_are_order_statistics() {
        // of 1 to 39 the 2.5 % and 97.5 % quantiles are the first and the last
        let all: Vec<f64> = (1..=39).rev().map(f64::from).collect();
        let s = scatter(18.0, &all).unwrap();
        // .025 · 40 − 1 is not 0 to the last bit
        let close = |found: (f64, f64), low: f64, high: f64| {
            (found.0 - low).abs() < 1e-12 && (found.1 - high).abs() < 1e-12
        };
        assert!(close(s.percentile, 1.0, 39.0), "{s:?}");
        assert!(close(s.basic, -3.0, 35.0), "{s:?}");
        assert_eq!(s.bias, 2.0);
        // the variance of 1 to n is n (n + 1)/12
        assert!((s.std_error - 130_f64.sqrt()).abs() < 1e-12);
    }

    #[test]
    fn one_estimate_scatters_by_nothing_known() {
        assert_eq!(scatter(1.0, &[1.0]), None);
    }
}
