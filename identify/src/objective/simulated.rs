//! A simulated spectrum as the model: the mean power of rides with fixed seeds.
//!
//! Every candidate rides under the same white noise (common random numbers), so that the mean is as
//! smooth a function of the parameters as one ride is. It scatters itself: of K seeds a bin's power
//! by 1/√K, which adds rides/K to the covariance of estimates. A single seed would be fitted in
//! place of the bicycle.

mod native;

use super::spectral::Measured;
use crate::closed_loop::Bin;
use crate::closed_loop::{Drive, Expansion};
use crate::error::{Error, Result};
use crate::foreign::Foreign;
use crate::spectrum::Analysis;
use crate::starts::stream;
use crate::synthesis::{WARM_UP, remnant};
use bicycle::{Excitation, Formulation, Parameters};
use nalgebra::{Complex, DMatrix, DVector};
use rand_distr::{Distribution, StandardNormal};
use std::borrow::Cow;

/// Half of the width over which simulations are differenced, in variables of the search: curvature
/// leaves some 1e-6 of a slope, and a smoothed jump is not felt as a kink.
pub(crate) const WIDTH: f64 = 1e-3;

/// Who rides.
#[derive(Debug, Clone)]
pub enum Engine {
    /// Our own equations.
    Native(Formulation),
    /// An FMU.
    Foreign(Foreign),
}

/// A bicycle, and what drives it.
pub type Setting = (Parameters, Drive);

/// One ride to be simulated: whose, and under which noise.
#[derive(Debug, Clone, Copy)]
pub struct Job<'a> {
    /// Whose.
    pub setting: &'a Setting,
    /// The number of the noise.
    pub seed: usize,
}

/// What a ride shows: the Fourier coefficients of its channels.
pub(crate) type Coefficients = Vec<Vec<Complex<f64>>>;

/// The record that simulated rides are to be compared with, and the noise they ride under.
#[derive(Clone)]
pub struct Record {
    /// Names of the channels.
    pub channels: Vec<&'static str>,
    /// How their spectra are taken.
    pub analysis: Analysis,
    /// Rows of the state behind the channels.
    pub states: Vec<usize>,
    /// Between samples [s].
    pub step: f64,
    /// Samples before the record begins: the rider's warm-up.
    pub before: usize,
    /// Samples of the record.
    pub samples: usize,
    seed: u64,
    /// The remnant of each seed at an intensity of 1 N m and this corner [Hz].
    corner: f64,
    remnants: Vec<Vec<f64>>,
}

impl Record {
    /// Samples of a ride, warm-up and record.
    pub fn length(&self) -> usize {
        self.before + self.samples
    }

    /// Torque besides the rider law [N m] at each sample of a ride and at its end.
    pub fn torque(&self, job: &Job) -> Vec<f64> {
        let drive = &job.setting.1;
        let unit = if drive.remnant_corner == self.corner {
            Cow::Borrowed(&self.remnants[job.seed])
        } else {
            Cow::Owned(unit(
                self.seed,
                job.seed,
                drive.remnant_corner,
                self.step,
                self.length(),
            ))
        };
        unit.iter()
            .map(|torque| torque * drive.remnant_intensity)
            .collect()
    }

    /// The coefficients of what the channels showed over a whole ride.
    pub fn coefficients(&self, channels: &[Vec<f64>]) -> Coefficients {
        let record = channels.iter().map(|samples| &samples[self.before..]);
        record
            .map(|samples| self.analysis.coefficients(samples))
            .collect()
    }
}

/// A remnant of intensity 1 N m.
fn unit(seed: u64, job: usize, corner: f64, step: f64, samples: usize) -> Vec<f64> {
    // a ride of the same seed has its own stream, that of job 0
    let mut rng = stream(seed, job as u64 + 1);
    let excitation = Excitation {
        remnant_intensity: 1.0,
        remnant_corner: corner,
        ..Excitation::default()
    };
    remnant(&excitation, samples + 1, step, &mut || {
        StandardNormal.sample(&mut rng)
    })
}

/// Spectra by simulation.
#[derive(Clone)]
pub struct Simulated {
    engine: Engine,
    record: Record,
    /// What samples add to coefficients: [`Analysis::weights`].
    weights: Vec<[f64; 2]>,
    noise: Vec<f64>,
    /// What white noise of density 1 adds to each bin.
    white: Vec<f64>,
    seeds: usize,
}

impl Simulated {
    /// Rides of `engine` for what was `measured`, with so many `seeds` that follow from `seed`.
    /// The corner of `excitation` is that of most rides.
    pub fn new(
        engine: Engine,
        measured: &Measured,
        excitation: &Excitation,
        (seeds, seed): (usize, u64),
    ) -> Result<Self> {
        if !measured.lines.is_empty() {
            return Err(Error::Form {
                expected: "no masked line with simulated rides, which have none",
                found: format!("{} lines", measured.lines.len()),
            });
        }
        let (analysis, step) = (measured.analysis.clone(), measured.step);
        let samples = (analysis.duration() / step).round() as usize;
        let before = (WARM_UP / step).round() as usize;
        let corner = excitation.remnant_corner;
        let remnant = |job| unit(seed, job, corner, step, before + samples);
        Ok(Self {
            weights: analysis.weights(),
            noise: measured.noise.clone(),
            white: measured.kernel.white.clone(),
            record: Record {
                channels: measured.channels.clone(),
                states: measured.states.clone(),
                analysis,
                step,
                before,
                samples,
                seed,
                corner,
                remnants: (0..seeds).map(remnant).collect(),
            },
            engine,
            seeds,
        })
    }

    /// Mean cross-powers of each of `settings`, sensor noise added; an error where one of its rides
    /// ended early.
    pub fn spectra(&self, settings: &[Setting]) -> Vec<Result<Vec<Bin>>> {
        let jobs: Vec<Job> = settings
            .iter()
            .flat_map(|setting| (0..self.seeds).map(move |seed| Job { setting, seed }))
            .collect();
        let ridden = match &self.engine {
            Engine::Native(formulation) => native::ride(self, *formulation, &jobs),
            Engine::Foreign(foreign) => foreign.spectra(&self.record, &jobs),
        };
        let mut ridden = ridden.into_iter();
        let own = |_: &Setting| ridden.by_ref().take(self.seeds).collect();
        let own: Vec<Vec<_>> = settings.iter().map(own).collect();
        own.into_iter().map(|rides| self.mean(rides)).collect()
    }

    /// The mean cross-powers of the rides of one setting.
    fn mean(&self, rides: Vec<Result<Coefficients>>) -> Result<Vec<Bin>> {
        let n = self.record.channels.len();
        let bins = self.record.analysis.frequencies().len();
        let mut mean = vec![DMatrix::zeros(n, n); bins];
        let (mut fallen, mut cut, mut first) = (0, 0.0, String::new());
        let duration = self.record.length() as f64 * self.record.step;
        let share = 1.0 / self.seeds as f64;
        for ride in rides {
            let ride = match ride {
                Ok(ride) => ride,
                Err(why) => {
                    let time = match &why {
                        Error::Stopped(stop) => stop.time(),
                        Error::FailedStep { time, .. } => *time,
                        _ => return Err(why),
                    };
                    if fallen == 0 {
                        first = why.to_string();
                    }
                    fallen += 1;
                    cut += share * (1.0 - time / duration);
                    continue;
                }
            };
            for (k, bin) in mean.iter_mut().enumerate() {
                for i in 0..n {
                    for j in 0..n {
                        bin[(i, j)] += ride[i][k] * ride[j][k].conj() * share;
                    }
                }
            }
        }
        if fallen > 0 {
            return Err(Error::Fell {
                fallen,
                of: self.seeds,
                cut,
                first,
            });
        }
        for (bin, white) in mean.iter_mut().zip(&self.white) {
            for (i, deviation) in self.noise.iter().enumerate() {
                bin[(i, i)] += deviation * deviation * self.record.step * white;
            }
        }
        Ok(mean)
    }

    /// The FMU that rides, if it is one.
    pub fn foreign(&self) -> Option<&Foreign> {
        match &self.engine {
            Engine::Native(_) => None,
            Engine::Foreign(foreign) => Some(foreign),
        }
    }

    /// The spectrum at the variables `z` with its slopes, by central differences of rides under
    /// the same noise; `setting` says what a point means.
    pub fn expansion(
        &self,
        z: &DVector<f64>,
        setting: impl Fn(&DVector<f64>) -> Setting,
    ) -> Result<Expansion> {
        let mut settings = vec![setting(z)];
        for i in 0..z.len() {
            for h in [WIDTH, -WIDTH] {
                let mut moved = z.clone();
                moved[i] += h;
                settings.push(setting(&moved));
            }
        }
        let mut spectra = self.spectra(&settings).into_iter();
        let mut next = || spectra.next().expect("one a setting");
        let expected = next()?;
        let slope = |(up, down): (Bin, Bin)| (up - down) / Complex::from(2.0 * WIDTH);
        let slopes = (0..z.len())
            .map(|_| Ok(next()?.into_iter().zip(next()?).map(slope).collect()))
            .collect::<Result<_>>()?;
        Ok(Expansion { expected, slopes })
    }
}

#[cfg(test)]
mod tests;
