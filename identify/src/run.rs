//! A run on record: `fit.json` holds all that is needed to make the fit again, and its result.

mod curves;

pub use curves::{Curve, Responded, Trace};

use crate::effort::Effort;
use crate::error::{Error, Result};
use crate::file;
use crate::fit::Fit;
use crate::free::{Candidate, Free, Prior, Scale, Scope, Tie, Variable, rows};
use crate::model::Spec;
use crate::plan::{Plan, Ridden};
use crate::problem::Problem;
use crate::ride::Ride;
use crate::spectrum::{Recipe, Taper};
use bicycle::{Instruments, Parameters};
use serde::{Deserialize, Serialize};
use std::collections::{BTreeMap, BTreeSet};
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
    /// Sampling rate of the ride [Hz].
    pub sampling: f64,
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
    /// What stood for the bicycle.
    #[serde(default)]
    pub model: Spec,
    /// What was asked besides one search; its seed is that of the report's simulated rides too.
    #[serde(flatten)]
    pub effort: Effort,
    /// Path of the study that the rides came from, if any.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub study: Option<String>,
    /// Path of the file that gave the windows, if any.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub windows: Option<String>,
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
            sampling: ridden.ride.rate(),
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
    /// Puts a fit of `plan` to `rides`, made with some `effort`, on record.
    pub fn new(
        rides: Vec<Recorded>,
        plan: &Plan,
        problem: &Problem,
        effort: &Effort,
        fit: Fit,
    ) -> Self {
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
                model: plan.model.spec(),
                effort: effort.clone(),
                study: None,
                windows: None,
            },
            fit,
        }
    }

    /// Reads a run from `fit.json`.
    pub fn read(path: &Path) -> Result<Self> {
        let file = || path.display().to_string();
        let text = file::read_text(path)?;
        // what is no JSON at all is another kind of file, not a damaged one
        if !text.trim_start().starts_with('{') {
            let found = text.lines().next().unwrap_or_default();
            return Err(Error::Unreadable {
                file: file(),
                expected: "a fit as `wobble fit -o` writes it",
                found: format!("`{}`", found.chars().take(40).collect::<String>()),
            });
        }
        let run: Self = serde_json::from_str(&text).map_err(|cause| Error::Json {
            file: file(),
            row: cause.line(),
            message: format!("expected a fit as `wobble fit -o` writes it, found {cause}"),
        })?;
        run.check().map_err(|cause| cause.in_file(file()))?;
        Ok(run)
    }

    /// Refuses a record whose parts do not go together: it was changed by hand, or damaged.
    fn check(&self) -> Result<()> {
        if self.rides.is_empty() {
            return Err(Error::NoRides);
        }
        let scoped = |sought: &Sought| match sought.scope {
            _ if self.rides.len() == 1 => 1,
            Scope::Shared => 1,
            Scope::Ride => self.rides.len(),
            Scope::Condition => {
                let all = self.rides.iter().map(|ride| ride.condition.as_str());
                all.collect::<BTreeSet<_>>().len()
            }
        };
        let variables = self.asked.free.iter().map(scoped).sum::<usize>();
        let fit = &self.fit;
        let rows = fit.correlation.iter().map(Vec::len);
        let widest = rows.clone().max().unwrap_or(0);
        for (name, expected, found) in [
            ("explained", self.rides.len(), fit.explained.len()),
            ("parameters", variables, fit.parameters.len()),
            ("correlation", variables, fit.correlation.len()),
            ("correlation", variables, rows.min().unwrap_or(0)),
            ("correlation", variables, widest),
        ] {
            if expected != found {
                return Err(Error::Entries {
                    name,
                    expected,
                    found,
                });
            }
        }
        Ok(())
    }

    /// Refuses a ride that is not sampled as those of the fit are.
    pub fn check_sampled(&self, ride: &Ride) -> Result<()> {
        let first = &self.rides[0];
        ride.check_sampled(first.sampling, &first.source.file)
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
