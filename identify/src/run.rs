//! A run on record: `fit.json` holds all that is needed to make the fit again, and its result.

use crate::error::{Error, Result};
use crate::file;
use crate::fit::Fit;
use crate::free::{Candidate, Free, Prior, Scale, Scope, Tie, Variable, rows};
use crate::model::Spec;
use crate::objective::frf::{Frf, Point};
use crate::objective::spectral::Spectral;
use crate::objective::time::Time;
use crate::plan::{Plan, Ridden};
use crate::problem::{Problem, Rides};
use crate::progress::Watch;
use crate::ride::Ride;
use crate::spectrum::{Recipe, Taper, residual};
use crate::synthesis::{SensorNoise, Synthesis};
use bicycle::{Input, Instruments, Parameters};
use nalgebra::{Complex, DVector};
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;
use std::ops::Range;
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

/// A ride of a run.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Recorded {
    /// Where it came from.
    #[serde(flatten)]
    pub source: Source,
    /// Rides of one condition share what is free per condition.
    pub condition: String,
    /// The bicycle that was ridden.
    pub start: Start,
    /// The windows that were given: first sample, sample behind the last.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub windows: Vec<Range<usize>>,
}

/// A free parameter as it was asked for.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Sought {
    /// Name of the row.
    pub name: String,
    /// Lower bound [SI].
    pub lower: f64,
    /// Upper bound [SI].
    pub upper: f64,
    /// Of how many rides it is one and the same.
    pub scope: Scope,
    /// The scale of the search.
    pub scale: Scale,
    /// What was known before.
    pub prior: Option<Prior>,
}

/// How the fit was asked for.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Asked {
    /// The free parameters.
    pub free: Vec<Sought>,
    /// Rows that followed them: follower, leader.
    pub ties: Vec<(String, String)>,
    /// How spectra are taken.
    pub recipe: Recipe,
    /// Length of a window of `time` or `frf` [s], where given.
    pub window: Option<f64>,
    /// Noise of the channels, where given [SI].
    pub noise: Option<Vec<f64>>,
    /// Most iterations of a search.
    pub max_iterations: u64,
    /// Seed of the simulated ride of the report.
    pub seed: u64,
    /// What stood for the bicycle.
    #[serde(default)]
    pub model: Spec,
}

/// A fit on record.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Run {
    /// Name and version of the program.
    pub program: String,
    /// The rides.
    pub rides: Vec<Recorded>,
    /// How it was asked for.
    pub asked: Asked,
    /// What came out.
    #[serde(flatten)]
    pub fit: Fit,
}

impl Recorded {
    /// `ridden`, which came from `source`, on the bicycle called `bicycle`.
    pub fn new(source: Source, bicycle: &str, ridden: &Ridden, plan: &Plan) -> Self {
        let values = [
            &ridden.parameters.to_array()[..],
            &plan.excitation.to_array()[..],
            &Instruments::default().to_array()[..],
        ];
        Self {
            source,
            condition: ridden.condition.clone(),
            windows: ridden.windows.clone(),
            start: Start {
                bicycle: bicycle.into(),
                formulation: plan.formulation.name().into(),
                speed: ridden.speed,
                law_in_loop: ridden.ride.law_in_loop.unwrap_or(false),
                rows: rows()
                    .map(|row| row.name.to_owned())
                    .zip(values.concat())
                    .collect(),
            },
        }
    }

    /// The bicycle and what drove it.
    fn candidate(&self) -> Result<Candidate> {
        let mut start = Candidate::default();
        for (name, value) in &self.start.rows {
            start.set(&Free::new(name)?, *value);
        }
        Ok(start)
    }
}

impl Run {
    /// Puts a fit of `plan` to `rides` on record; `seed` is that of the report's simulated rides.
    pub fn new(rides: Vec<Recorded>, plan: &Plan, problem: &Problem, seed: u64, fit: Fit) -> Self {
        let mut free: Vec<Sought> = Vec::new();
        for Variable { free: f, .. } in &problem.variables {
            if free.iter().all(|known| known.name != f.row.name) {
                free.push(Sought {
                    name: f.row.name.into(),
                    lower: f.lower,
                    upper: f.upper,
                    scope: f.scope,
                    scale: f.scale,
                    prior: f.prior,
                });
            }
        }
        let tie = |tie: &Tie| (tie.follower().name.into(), tie.leader.name.into());
        Self {
            program: concat!("wobble ", env!("CARGO_PKG_VERSION")).into(),
            rides,
            asked: Asked {
                free,
                ties: plan.ties.iter().map(tie).collect(),
                recipe: Recipe {
                    taper: Taper::of(fit.channels.len()),
                    ..plan.recipe.clone()
                },
                window: plan.window,
                noise: plan.noise.clone(),
                max_iterations: plan.max_iterations,
                seed,
                model: plan.model.spec(),
            },
            fit,
        }
    }

    /// Reads a run from `fit.json`.
    pub fn read(path: &Path) -> Result<Self> {
        let text = file::read_text(path)?;
        let run: Self = serde_json::from_str(&text).map_err(|cause| Error::Json {
            file: path.display().to_string(),
            row: cause.line(),
            message: cause.to_string(),
        })?;
        if run.rides.is_empty() {
            return Err(Error::NoRides.in_file(path.display().to_string()));
        }
        Ok(run)
    }

    /// The run as JSON.
    pub fn to_json(&self) -> String {
        serde_json::to_string_pretty(self).expect("finite numbers and strings")
    }

    /// The plan that makes the same fit again.
    pub fn plan(&self) -> Result<Plan> {
        let first = &self.rides[0];
        let start = first.candidate()?;
        let formulation = crate::bicycles::formulation(&first.start.formulation)?;
        let channel = |name: &String| crate::ride::quantity(name).map(|row| row.name);
        let channels = self.fit.channels.iter().map(channel);
        let tie = |(follower, leader): &(String, String)| Tie::new(follower, leader);
        Ok(Plan {
            parameters: start.parameters,
            formulation,
            speed: first.start.speed,
            excitation: start.excitation,
            objective: Some(self.fit.objective),
            channels: Some(channels.collect::<Result<_>>()?),
            free: Some(
                self.asked
                    .free
                    .iter()
                    .map(Sought::free)
                    .collect::<Result<_>>()?,
            ),
            changes: Vec::new(),
            ties: self.asked.ties.iter().map(tie).collect::<Result<_>>()?,
            recipe: self.asked.recipe.clone(),
            window: self.asked.window,
            noise: self.asked.noise.clone(),
            max_iterations: self.asked.max_iterations,
            model: self.asked.model.open()?,
        })
    }

    /// `rides`, the run's own in their order, on the bicycles they were ridden on.
    pub fn ridden<'a>(&self, rides: &'a [Ride]) -> Result<Vec<Ridden<'a>>> {
        let ridden = |(i, ride): (usize, &'a Ride)| {
            Ok(Ridden {
                windows: self.rides[i].windows.clone(),
                ..self.ridden_as(i, ride)?
            })
        };
        let own = rides.iter().take(self.rides.len());
        own.enumerate().map(ridden).collect()
    }

    /// `ride` on the bicycle and under the condition of the run's ride number `like`.
    pub fn ridden_as<'a>(&self, like: usize, ride: &'a Ride) -> Result<Ridden<'a>> {
        let recorded = &self.rides[like];
        Ok(Ridden {
            ride,
            parameters: recorded.candidate()?.parameters,
            speed: recorded.start.speed,
            condition: recorded.condition.clone(),
            windows: Vec::new(),
        })
    }

    /// The problem that was solved, of the run's own rides.
    pub fn problem(&self, rides: &[Ride]) -> Result<Problem> {
        Problem::new(&self.ridden(rides)?, &self.plan()?)
    }

    /// The fitted bicycle of the run's ride number `ride`, and what drives it.
    pub fn fitted(&self, ride: usize) -> Result<Candidate> {
        let recorded = &self.rides[ride];
        let start = recorded.candidate()?;
        let mut candidate = start.clone();
        let name = &self.fit.explained[ride].ride;
        let own = |of: &String| of == name || *of == recorded.condition;
        for estimate in &self.fit.parameters {
            if estimate.of.as_ref().is_none_or(own) {
                candidate.set(&Free::new(&estimate.name)?, estimate.value);
            }
        }
        for (follower, leader) in &self.asked.ties {
            candidate.follow(&Tie::new(follower, leader)?, &start);
        }
        Ok(candidate)
    }

    /// The estimates, in the order of the problem's variables.
    pub fn values(&self) -> Vec<f64> {
        self.fit.parameters.iter().map(|p| p.value).collect()
    }
}

impl Sought {
    fn free(&self) -> Result<Free> {
        let free = Free::new(&self.name)?
            .on(self.scale)?
            .within(self.lower, self.upper)?;
        let free = free.per(self.scope);
        match self.prior {
            None => Ok(free),
            prior => free.with_prior(prior),
        }
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
                Ok((samples, ride.replay_all(z)?))
            };
            let replayed = windows.each(&found.outcome.point, replay);
            let trace = |(replayed, ride): (Result<Replayed>, &Ride)| {
                let (samples, replayed) = replayed?;
                let channels = problem.channels.iter().zip(replayed);
                channels
                    .map(|(channel, model)| {
                        let all = ride.channel(channel)?;
                        let measured = samples.iter().map(|&i| all[i]).collect();
                        Ok(Trace {
                            time: samples.iter().map(|&i| ride.time(i)).collect(),
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
            seed: self.asked.seed,
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

    /// The fitted bicycle with its effective damping, if that is what was fitted, as viscous
    /// friction alone.
    pub fn as_simulated(&self, fitted: &Candidate) -> Parameters {
        match self.fit.estimate("effective_damping") {
            Some(_) => Parameters {
                viscous_friction: fitted.excitation.effective_damping,
                coulomb_friction: 0.0,
                ..fitted.parameters
            },
            None => fitted.parameters,
        }
    }
}

fn trace(channel: &str, ride: &Ride, measured: Vec<f64>, model: Vec<f64>) -> Result<Trace> {
    Ok(Trace {
        channel: channel.into(),
        unit: crate::ride::quantity(channel)?.unit.symbol.to_owned(),
        time: (0..model.len()).map(|i| ride.time(i)).collect(),
        measured,
        model,
    })
}

/// Samples of a ride, and each channel replayed there.
type Replayed = (Vec<usize>, Vec<Vec<f64>>);

/// A ride's frequency responses beside those of the model at `z`.
fn responded(frf: &Frf, z: &DVector<f64>) -> Result<Vec<Responded>> {
    let model = frf.model(z)?;
    let decibels = |z: &Complex<f64>| 20.0 * z.norm().log10();
    let channels = frf.channels.iter().zip(&frf.points).zip(model);
    let responded = channels.map(|((channel, points), model)| {
        let of = |value: fn(&Point) -> f64| points.iter().map(value).collect();
        let turned = |(point, model): (&Point, &Complex<f64>)| {
            (model.arg() + (point.response / model).arg()).to_degrees()
        };
        Responded {
            channel: (*channel).into(),
            frequency: of(|p| p.frequency),
            magnitude: points.iter().map(|p| decibels(&p.response)).collect(),
            phase: points.iter().zip(&model).map(turned).collect(),
            coherence: of(|p| p.coherence),
            expected_magnitude: model.iter().map(decibels).collect(),
            expected_phase: model.iter().map(|m| m.arg().to_degrees()).collect(),
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
