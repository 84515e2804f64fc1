//! A run on record: `fit.json` holds all that is needed to make the fit again, and its result.

use crate::error::{Error, Result};
use crate::file;
use crate::fit::Fit;
use crate::free::{Candidate, Free};
use crate::objective::Objective;
use crate::objective::spectral::{Measured, Spectral};
use crate::objective::time::Time;
use crate::plan::{self, Plan};
use crate::ride::Ride;
use crate::spectrum::{Recipe, Taper, residual};
use crate::synthesis::{SensorNoise, Synthesis};
use bicycle::{Excitation, Input, Parameters, Quantity};
use nalgebra::DVector;
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;
use std::path::Path;

/// Where the ride came from.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Source {
    /// Path of the file, as given.
    pub file: String,
    /// SHA-256 of its bytes.
    pub sha256: String,
    /// Name or path of the channel map, if one was used.
    pub map: Option<String>,
    /// SHA-256 of the map's text.
    pub map_sha256: Option<String>,
    /// Sampling rate given for a file without a clock [Hz].
    pub rate: Option<f64>,
    /// Whether gaps were bridged.
    pub resample: bool,
    /// The stretch of it that was used [s].
    pub times: Option<(f64, f64)>,
    /// What was done to it at the door.
    pub notes: Vec<String>,
}

impl Source {
    /// The file behind `ride`, read whole and without a map.
    pub fn of(ride: &Ride) -> Self {
        let origin = ride.origin.as_ref();
        Self {
            file: ride.name(),
            sha256: origin.map_or_else(String::new, |o| o.sha256.clone()),
            map: None,
            map_sha256: None,
            rate: None,
            resample: false,
            times: None,
            notes: ride.notes.clone(),
        }
    }
}

/// The bicycle a fit started from.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Start {
    /// Name of the set.
    pub bicycle: String,
    /// How the equations are read.
    pub formulation: String,
    /// Speed [m/s] where the ride does not record it.
    pub speed: f64,
    /// Whether a steering law is closed on the simulated state.
    pub law_in_loop: bool,
    /// All rows by name [SI].
    pub rows: BTreeMap<String, f64>,
}

/// How the fit was asked for.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Asked {
    /// How spectra are taken.
    pub recipe: Recipe,
    /// Length of a window of `time` [s].
    pub window: f64,
    /// Noise of the channels, where given [SI].
    pub noise: Option<Vec<f64>>,
    /// Most iterations of a search.
    pub max_iterations: u64,
    /// Seed of the simulated ride of the report.
    pub seed: u64,
}

/// A fit on record.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Run {
    /// Name and version of the program.
    pub program: String,
    /// The ride.
    pub ride: Source,
    /// The bicycle it started from.
    pub start: Start,
    /// How it was asked for.
    pub asked: Asked,
    /// What came out.
    #[serde(flatten)]
    pub fit: Fit,
}

fn rows() -> impl Iterator<Item = &'static Quantity> {
    Parameters::TABLE.iter().chain(Excitation::TABLE)
}

impl Run {
    /// Puts a fit of `plan` on record.
    pub fn new(
        ride: Source,
        bicycle: &str,
        plan: &Plan,
        law_in_loop: bool,
        seed: u64,
        fit: Fit,
    ) -> Self {
        let values = plan
            .parameters
            .to_array()
            .into_iter()
            .chain(plan.excitation.to_array());
        Self {
            program: concat!("wobble ", env!("CARGO_PKG_VERSION")).into(),
            ride,
            start: Start {
                bicycle: bicycle.into(),
                formulation: plan.formulation.name().into(),
                speed: plan.speed,
                law_in_loop,
                rows: rows().map(|row| row.name.to_owned()).zip(values).collect(),
            },
            asked: Asked {
                recipe: Recipe {
                    taper: Taper::of(fit.channels.len()),
                    ..plan.recipe.clone()
                },
                window: plan.window,
                noise: plan.noise.clone(),
                max_iterations: plan.max_iterations,
                seed,
            },
            fit,
        }
    }

    /// Reads a run from `fit.json`.
    pub fn read(path: &Path) -> Result<Self> {
        let text = file::read_text(path)?;
        serde_json::from_str(&text).map_err(|cause| Error::Json {
            file: path.display().to_string(),
            row: cause.line(),
            message: cause.to_string(),
        })
    }

    /// The run as JSON.
    pub fn to_json(&self) -> String {
        serde_json::to_string_pretty(self).expect("finite numbers and strings")
    }

    /// The plan that makes the same fit again.
    pub fn plan(&self) -> Result<Plan> {
        let mut start = Candidate {
            parameters: Parameters::default(),
            excitation: Excitation::default(),
        };
        for (name, value) in &self.start.rows {
            start.set(&Free::new(name)?, *value);
        }
        let formulation = crate::bicycles::formulation(&self.start.formulation)?;
        let channel = |name: &String| crate::ride::quantity(name).map(|row| row.name);
        Ok(Plan {
            parameters: start.parameters,
            formulation,
            speed: self.start.speed,
            excitation: start.excitation,
            objective: Some(self.fit.objective),
            channels: Some(
                self.fit
                    .channels
                    .iter()
                    .map(channel)
                    .collect::<Result<_>>()?,
            ),
            free: Some(self.free()?),
            bounds: Vec::new(),
            recipe: self.asked.recipe.clone(),
            window: self.asked.window,
            noise: self.asked.noise.clone(),
            max_iterations: self.asked.max_iterations,
        })
    }

    fn free(&self) -> Result<Vec<Free>> {
        let free = |p: &crate::verdict::Estimate| Free::new(&p.name)?.within(p.lower, p.upper);
        self.fit.parameters.iter().map(free).collect()
    }

    /// The fitted bicycle and what drives it.
    pub fn fitted(&self) -> Result<Candidate> {
        let plan = self.plan()?;
        self.fit.candidate(&Candidate {
            parameters: plan.parameters,
            excitation: plan.excitation,
        })
    }

    /// The variables of the search at the estimates.
    fn variables(&self, free: &[Free]) -> DVector<f64> {
        let values = free.iter().zip(&self.fit.parameters);
        DVector::from_iterator(free.len(), values.map(|(f, p)| f.variable(p.value)))
    }
}

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
    /// Measured.
    pub measured: Vec<f64>,
    /// Of the model: a replay, or a seeded ride that shares nothing with the measured one but
    /// its statistics.
    pub model: Vec<f64>,
}

impl Run {
    /// Spectra of a ride beside those of the fitted model; none for `time`.
    pub fn curves(&self, ride: &Ride) -> Result<Vec<Curve>> {
        let plan = self.plan()?;
        let resolved = plan::resolve(ride, &plan)?;
        if resolved.objective == Objective::Time {
            return Ok(Vec::new());
        }
        let z = self.variables(&resolved.unknowns.free);
        let noise = Some(self.fit.noise.as_slice());
        let measured = Measured::new(
            ride,
            &resolved.channels,
            &resolved.recipe,
            plan.speed,
            noise,
        )?;
        let unit = measured.analysis.to_amplitude();
        let spectral = Spectral {
            measured,
            unknowns: resolved.unknowns,
            formulation: plan.formulation,
        };
        let expected = spectral.expected(&z)?;
        let measured = &spectral.measured;
        // |Y|² is exponential with mean S
        let quantile = |s: f64, q: f64| unit * (-(1.0 - q).ln() * s).sqrt();
        Ok(measured
            .channels
            .iter()
            .enumerate()
            .map(|(c, channel)| {
                let power: Vec<f64> = expected.iter().map(|bin| bin[(c, c)].re).collect();
                Curve {
                    channel: (*channel).into(),
                    unit: crate::ride::quantity(channel)
                        .map_or("", |row| row.unit.symbol)
                        .into(),
                    frequency: measured.analysis.frequencies(),
                    measured: measured
                        .coefficients
                        .iter()
                        .map(|y| unit * y[c].norm())
                        .collect(),
                    expected: power
                        .iter()
                        .map(|s| unit * (0.25 * std::f64::consts::PI * s).sqrt())
                        .collect(),
                    low: power.iter().map(|s| quantile(*s, 0.025)).collect(),
                    high: power.iter().map(|s| quantile(*s, 0.975)).collect(),
                }
            })
            .collect())
    }

    /// Signals beside those of the fitted model: replayed windows for `time`, else the residual
    /// of the moving average beside that of a seeded ride (empty where the fitted bicycle falls).
    pub fn traces(&self, ride: &Ride) -> Result<Vec<Trace>> {
        let plan = self.plan()?;
        let resolved = plan::resolve(ride, &plan)?;
        let time: Vec<f64> = (0..ride.len()).map(|i| ride.time(i)).collect();
        let unit =
            |channel: &str| crate::ride::quantity(channel).map(|row| row.unit.symbol.to_owned());
        if resolved.objective == Objective::Time {
            let noise = Some(self.fit.noise.as_slice());
            let channels = resolved.channels.clone();
            let unknowns = resolved.unknowns;
            let problem = Time::new(
                ride,
                &channels,
                unknowns,
                plan.formulation,
                (plan.speed, plan.window),
                noise,
            )?;
            let replayed = problem.replay_all(&self.variables(&problem.unknowns.free))?;
            return channels
                .iter()
                .zip(replayed)
                .map(|(channel, model)| {
                    let n = model.len();
                    Ok(Trace {
                        channel: (*channel).into(),
                        unit: unit(channel)?,
                        time: time[..n].to_vec(),
                        measured: ride.channel(channel)?[..n].to_vec(),
                        model,
                    })
                })
                .collect();
        }
        let fitted = self.fitted()?;
        let synthesis = Synthesis {
            parameters: self.as_simulated(&fitted),
            formulation: plan.formulation,
            input: Input {
                speed: ride.mean_speed(plan.speed),
                ..Input::default()
            },
            excitation: fitted.excitation,
            duration: ride.duration(),
            rate: ride.rate(),
            noise: SensorNoise::NONE,
            seed: self.asked.seed,
            ..Synthesis::default()
        };
        let Ok(simulated) = synthesis.ride() else {
            return Ok(Vec::new());
        };
        let window = (resolved.recipe.average / ride.step()).round() as usize;
        resolved
            .channels
            .iter()
            .map(|channel| {
                Ok(Trace {
                    channel: (*channel).into(),
                    unit: unit(channel)?,
                    time: time.clone(),
                    measured: residual(ride.channel(channel)?, window),
                    model: residual(simulated.channel(channel)?, window),
                })
            })
            .collect()
    }

    /// The fitted bicycle with its effective damping, if that is what was fitted, as viscous
    /// friction alone.
    pub fn as_simulated(&self, fitted: &Candidate) -> Parameters {
        match self.fit.estimate("effective_damping") {
            Some(damping) => Parameters {
                viscous_friction: damping.value,
                coulomb_friction: 0.0,
                ..fitted.parameters
            },
            None => fitted.parameters,
        }
    }
}
