//! A run beside its rides, as curves: spectra, signals over time, frequency responses.

use super::Run;
use crate::error::Result;
use crate::objective::frf::{Frf, Point};
use crate::objective::spectral::Spectral;
use crate::objective::time::Time;
use crate::plan::Plan;
use crate::problem::{Problem, Rides};
use crate::progress::Watch;
use crate::ride::Ride;
use crate::spectrum::residual;
use crate::synthesis::{SensorNoise, Synthesis};
use bicycle::Input;
use nalgebra::{Complex, DVector};
use serde::Serialize;
use std::ops::Range;

/// Measured and expected spectrum of a channel: amplitudes of sines [SI].
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Curve {
    /// Name of the channel.
    pub channel: String,
    /// Its unit.
    pub unit: String,
    /// Frequencies of the bins [Hz].
    pub frequency: Vec<f64>,
    /// Measured amplitude.
    pub measured: Vec<f64>,
    /// Mean amplitude of the fitted model.
    pub expected: Vec<f64>,
    /// 2.5 % quantile of one ride's amplitude under the fitted model.
    pub low: Vec<f64>,
    /// 97.5 % quantile.
    pub high: Vec<f64>,
}

/// A signal of the ride and of the model over time [SI].
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Trace {
    /// Name of the channel.
    pub channel: String,
    /// Its unit.
    pub unit: String,
    /// Times [s].
    pub time: Vec<f64>,
    /// The windows that were replayed, as ranges of the samples here; none of a seeded ride.
    pub windows: Vec<Range<usize>>,
    /// Measured.
    pub measured: Vec<f64>,
    /// Of the model: a replay, or a seeded ride that shares nothing with the measured one but
    /// its statistics.
    pub model: Vec<f64>,
}

/// Measured and expected frequency response of a channel.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Responded {
    /// Name of the channel.
    pub channel: String,
    /// Frequencies of the bins [Hz].
    pub frequency: Vec<f64>,
    /// Measured magnitude [dB of the channel's SI unit per N m].
    pub magnitude: Vec<f64>,
    /// Measured phase [°], the expected one's within half a turn.
    pub phase: Vec<f64>,
    /// Coherence γ².
    pub coherence: Vec<f64>,
    /// Magnitude of the fitted model [dB].
    pub expected_magnitude: Vec<f64>,
    /// Phase of the fitted model [°].
    pub expected_phase: Vec<f64>,
    /// Measured over expected magnitude, its logarithm in random errors of the bin.
    pub magnitude_residual: Vec<f64>,
    /// Measured less expected phase in random errors of the bin.
    pub phase_residual: Vec<f64>,
}

impl Run {
    /// Each ride's frequency responses beside those of the fitted model; none but for `frf`.
    pub fn responses(&self, problem: &Problem) -> Result<Vec<Vec<Responded>>> {
        match &problem.rides {
            Rides::Frf(responses) => responses
                .each(&problem.at(&self.values()), responded)
                .into_iter()
                .collect(),
            _ => Ok(Vec::new()),
        }
    }

    /// Each ride's spectra beside those of the fitted model; none for `time`.
    pub fn curves(&self, problem: &Problem) -> Result<Vec<Vec<Curve>>> {
        let z = problem.at(&self.values());
        match &problem.rides {
            Rides::Amplitude(spectra) | Rides::Whittle(spectra) => spectra
                .each(&z, |ride, z| curves(&ride.spectral, z))
                .into_iter()
                .collect(),
            Rides::Time(_) | Rides::Frf(_) => Ok(Vec::new()),
        }
    }

    /// Each ride's signals beside those of the fitted model: replayed windows for `time`, else the
    /// residual of the moving average beside that of a seeded ride (empty where the fitted bicycle
    /// falls, and where an FMU was the model).
    pub fn traces(&self, problem: &Problem, rides: &[Ride]) -> Result<Vec<Vec<Trace>>> {
        let z = problem.at(&self.values());
        if let Rides::Time(windows) = &problem.rides {
            let found = problem.search(
                &z,
                &(0..problem.shared()).collect::<Vec<_>>(),
                &Watch::default(),
            )?;
            let replay = |ride: &Time, z: &DVector<f64>| {
                let samples: Vec<usize> = ride.samples().collect();
                Ok((
                    samples,
                    behind_each_other(ride.ranges()),
                    ride.replay_all(z)?,
                ))
            };
            let replayed = windows.each(&found.outcome.point, replay);
            let trace = |(replayed, ride): (Result<Replayed>, &Ride)| {
                let (samples, windows, replayed) = replayed?;
                let channels = problem.channels.iter().zip(replayed);
                channels
                    .map(|(channel, model)| {
                        let all = ride.channel(channel)?;
                        let measured = samples.iter().map(|&i| all[i]).collect();
                        Ok(Trace {
                            time: samples.iter().map(|&i| ride.time(i)).collect(),
                            windows: windows.clone(),
                            ..trace(channel, ride, measured, model)?
                        })
                    })
                    .collect()
            };
            return replayed.into_iter().zip(rides).map(trace).collect();
        }
        if let Rides::Frf(_) = &problem.rides {
            return Ok(Vec::new());
        }
        let plan = self.plan()?;
        (0..rides.len())
            .map(|i| self.residuals(i, &rides[i], &plan, &problem.channels))
            .collect()
    }

    /// The residual of the run's ride number `i` beside that of a seeded one.
    fn residuals(
        &self,
        i: usize,
        ride: &Ride,
        plan: &Plan,
        channels: &[&str],
    ) -> Result<Vec<Trace>> {
        if plan.model.foreign().is_some() {
            return Ok(Vec::new());
        }
        let fitted = self.fitted(i)?;
        let synthesis = Synthesis {
            parameters: self.as_simulated(&fitted),
            formulation: plan.formulation,
            input: Input {
                speed: ride.mean_speed(self.rides[i].start.speed),
                ..Input::default()
            },
            excitation: fitted.excitation,
            duration: ride.duration(),
            rate: ride.rate(),
            noise: SensorNoise::NONE,
            seed: self.asked.effort.seed,
            ..Synthesis::default()
        };
        let Ok(simulated) = synthesis.ride() else {
            return Ok(Vec::new());
        };
        let window = (plan.recipe.average / ride.step()).round() as usize;
        let pair = |channel: &&str| {
            let measured = residual(ride.channel(channel)?, window);
            let model = residual(simulated.channel(channel)?, window);
            trace(channel, ride, measured, model)
        };
        channels.iter().map(pair).collect()
    }
}

fn trace(channel: &str, ride: &Ride, measured: Vec<f64>, model: Vec<f64>) -> Result<Trace> {
    Ok(Trace {
        channel: channel.into(),
        unit: crate::ride::quantity(channel)?.unit.symbol.to_owned(),
        time: (0..model.len()).map(|i| ride.time(i)).collect(),
        windows: Vec::new(),
        measured,
        model,
    })
}

/// Samples of a ride, the windows among them, and each channel replayed there.
type Replayed = (Vec<usize>, Vec<Range<usize>>, Vec<Vec<f64>>);

/// Ranges as long as `windows`, the next from where the last ends.
fn behind_each_other(windows: &[Range<usize>]) -> Vec<Range<usize>> {
    let mut end = 0;
    let next = |window: &Range<usize>| {
        let start = end;
        end += window.len();
        start..end
    };
    windows.iter().map(next).collect()
}

impl Trace {
    /// Whether its windows cover less than half of the time from first to last.
    pub fn is_sparse(&self) -> bool {
        let (Some(first), Some(last)) = (self.time.first(), self.time.last()) else {
            return false;
        };
        let length = |window: &Range<usize>| self.time[window.end - 1] - self.time[window.start];
        self.windows.len() > 1
            && self.windows.iter().map(length).sum::<f64>() < 0.5 * (last - first)
    }

    /// The residual, measured less modelled, of each window [SI].
    pub fn residuals(&self) -> Vec<Vec<f64>> {
        let both = |window: &Range<usize>| {
            let pairs = self.measured[window.clone()]
                .iter()
                .zip(&self.model[window.clone()]);
            pairs.map(|(measured, model)| measured - model).collect()
        };
        self.windows.iter().map(both).collect()
    }
}

/// A ride's frequency responses beside those of the model at `z`.
fn responded(frf: &Frf, z: &DVector<f64>) -> Result<Vec<Responded>> {
    let model = frf.model(z)?;
    let decibels = |z: &Complex<f64>| 20.0 * z.norm().log10();
    let channels = frf.channels.iter().zip(&frf.points).zip(model);
    let responded = channels.map(|((channel, points), model)| {
        let of = |value: fn(&Point) -> f64| points.iter().map(value).collect();
        // from bin to bin the model turns by less than half a turn
        let mut turn = 0.0;
        let unwound: Vec<f64> = (model.iter().enumerate())
            .map(|(k, z)| {
                turn = match k {
                    0 => z.arg(),
                    _ => turn + (z / model[k - 1]).arg(),
                };
                turn
            })
            .collect();
        let turned = |(k, point): (usize, &Point)| {
            (unwound[k] + (point.response / model[k]).arg()).to_degrees()
        };
        let residuals: Vec<Complex<f64>> = (points.iter().zip(&model))
            .map(|(point, model)| (point.response / model).ln() / point.error)
            .collect();
        Responded {
            channel: (*channel).into(),
            magnitude_residual: residuals.iter().map(|r| r.re).collect(),
            phase_residual: residuals.iter().map(|r| r.im).collect(),
            frequency: of(|p| p.frequency),
            magnitude: points.iter().map(|p| decibels(&p.response)).collect(),
            phase: points.iter().enumerate().map(turned).collect(),
            coherence: of(|p| p.coherence),
            expected_magnitude: model.iter().map(decibels).collect(),
            expected_phase: unwound.iter().map(|phase| phase.to_degrees()).collect(),
        }
    });
    Ok(responded.collect())
}

/// A ride's spectra beside those of the model at `z`.
fn curves(spectral: &Spectral, z: &DVector<f64>) -> Result<Vec<Curve>> {
    let expected = spectral.expected(z)?;
    let measured = &spectral.measured;
    let unit = measured.analysis.to_amplitude();
    // |Y|² is exponential with mean S
    let quantile = |s: f64, q: f64| unit * (-(1.0 - q).ln() * s).sqrt();
    let curve = |(c, channel): (usize, &&'static str)| {
        let power: Vec<f64> = expected.iter().map(|bin| bin[(c, c)].re).collect();
        let coefficients = measured.coefficients.iter();
        Ok(Curve {
            channel: (*channel).into(),
            unit: crate::ride::quantity(channel)?.unit.symbol.into(),
            frequency: measured.analysis.frequencies(),
            measured: coefficients.map(|y| unit * y[c].norm()).collect(),
            expected: power
                .iter()
                .map(|s| unit * (0.25 * std::f64::consts::PI * s).sqrt())
                .collect(),
            low: power.iter().map(|s| quantile(*s, 0.025)).collect(),
            high: power.iter().map(|s| quantile(*s, 0.975)).collect(),
        })
    };
    measured.channels.iter().enumerate().map(curve).collect()
}
