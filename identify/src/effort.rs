//! What is asked of a fit besides one search: many starts, a population, profiles, fits of data made
//! again. All of it can be stopped; starts, population and fits of data made again are taken up again
//! where they were, profiles and reduction are made anew.

use crate::checkpoint::Journal;
use crate::error::{Error, Result};
use crate::file::sha256;
use crate::plan::{Plan, Ridden};
use crate::problem::{Found, Problem};
use crate::progress::{Event, Watch};
use crate::solver::{Attempt, Evolution, Generation, Starts, evolve, generation, multistart};
use crate::starts::sobol;
use crate::trust::Solved;
use crate::trust::bootstrap::{Bootstrap, Draw, Resampled};
use crate::trust::insensitivity::Reduction;
use crate::trust::profile::Profile;
use crate::verdict::{Estimate, Verdict};
use nalgebra::DVector;
use serde::{Deserialize, Serialize};
use std::fmt::Write as _;
use std::path::{Path, PathBuf};

/// How much more is asked.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
#[serde(default)]
pub struct Effort {
    /// Searches from so many Sobol points besides that from the plan's own values.
    pub starts: usize,
    /// Evaluations of the cost for a population that searches the whole box first; 0: none.
    pub population: u64,
    /// Whether every parameter is profiled.
    pub profiles: bool,
    /// Fits of data made again.
    pub bootstrap: u64,
    /// Whether parameters that the data can do without are left out, one by one.
    pub reduce: bool,
    /// Seed of the starts, the population and the data made again.
    pub seed: u64,
    /// Journals of what is finished: this path with `.starts`, `.population`, `.bootstrap` behind.
    /// Not put on record: a fit that was taken up again is the fit that was not.
    #[serde(skip)]
    pub resume: Option<PathBuf>,
}

/// What came of many starts.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Agreement {
    /// Starts that were asked for.
    pub planned: usize,
    /// Points that were passed over for starts: no model stands there.
    pub passed_over: usize,
    /// Searches that could not begin.
    pub failed: usize,
    /// Searches that ended where the best did: at its cost to 1e-3, and at each determined
    /// parameter to a tenth of its standard error.
    pub agreeing: usize,
    /// Where each search ended, the least first.
    pub costs: Vec<f64>,
    /// Whether it was stopped before all had been searched from.
    pub stopped: bool,
}

/// What came of a population.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Population {
    /// Least cost it found, before a local search went on from there.
    pub cost: f64,
    /// Evaluations of the cost.
    pub evaluations: u64,
    /// Those of them that found none.
    pub failures: u64,
    /// How it ended.
    pub termination: String,
}

/// What came of all that was asked besides.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
pub struct Further {
    /// Of many starts.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub starts: Option<Agreement>,
    /// Of a population.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub population: Option<Population>,
    /// The profiles of the parameters.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub profiles: Vec<Profile>,
    /// What the parameters scatter when the data are made again.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub bootstrap: Option<Resampled>,
    /// What is left when what the data can do without is left out.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub reduction: Option<Reduction>,
}

/// What decides the results of long work on `problem`, but for its budget: SHA-256.
fn identity(rides: &[Ridden], plan: &Plan, seed: u64) -> String {
    let mut text = format!("{plan:?} {seed} {}", crate::kernel::Isa::best().name());
    for ridden in rides {
        let Ridden {
            ride,
            parameters,
            speed,
            condition,
            windows,
        } = ridden;
        let law = ride.law_in_loop;
        let _ = writeln!(
            text,
            "{parameters:?} {speed} {condition} {law:?} {windows:?}"
        );
        text += &ride.to_csv();
    }
    sha256(text.as_bytes())
}

/// The journal of `kind` behind the path, or one that ends with the process.
fn journal<J>(resume: Option<&Path>, kind: &str, identity: &str) -> Result<Journal<J>>
where
    J: Serialize + serde::de::DeserializeOwned,
{
    let Some(path) = resume else {
        return Ok(Journal::in_memory());
    };
    let mut path = path.as_os_str().to_owned();
    path.push(".");
    path.push(kind);
    Journal::open(Path::new(&path), kind, identity)
}

/// Searching and judging one problem with some effort.
pub struct Work<'a> {
    problem: &'a Problem,
    rides: &'a [Ridden<'a>],
    plan: &'a Plan,
    effort: &'a Effort,
    identity: String,
    watch: &'a Watch,
    passed_over: usize,
    starts: Option<Starts>,
    population: Option<Population>,
}

impl<'a> Work<'a> {
    /// Of `problem`, which is `plan` on `rides`.
    pub fn new(
        problem: &'a Problem,
        rides: &'a [Ridden<'a>],
        plan: &'a Plan,
        effort: &'a Effort,
        watch: &'a Watch,
    ) -> Self {
        let needs = effort.resume.is_some();
        Self {
            problem,
            rides,
            plan,
            effort,
            identity: if needs {
                identity(rides, plan, effort.seed)
            } else {
                String::new()
            },
            watch,
            passed_over: 0,
            starts: None,
            population: None,
        }
    }

    fn journal<J: Serialize + serde::de::DeserializeOwned>(
        &self,
        kind: &str,
    ) -> Result<Journal<J>> {
        journal(self.effort.resume.as_deref(), kind, &self.identity)
    }

    /// The lowest end of all searches.
    pub fn search(&mut self) -> Result<Found> {
        let own = self.problem.start();
        let from = self.evolve(&own)?;
        self.watch.tell(Event::Phase("searching"));
        let mut best = self.problem.search(&from, &[], self.watch)?;
        if self.effort.starts > 0 && !self.watch.stopped() {
            let points = self.points();
            let starts = multistart(
                self.problem,
                &points,
                &self.journal::<Attempt>("starts")?,
                self.watch,
            )?;
            let own = self.problem.worth(&best.outcome);
            if let Some(lowest) = starts.outcome().filter(|o| o.cost < own) {
                let mut outcome = lowest.clone();
                outcome.cost = self.problem.cost(&outcome.point);
                best = Found {
                    outcome,
                    passes: best.passes,
                };
            }
            self.starts = Some(starts);
        }
        Ok(best)
    }

    /// Sobol points at which the model stands.
    fn points(&mut self) -> Vec<DVector<f64>> {
        let wanted = self.effort.starts;
        let mut points = Vec::with_capacity(wanted);
        let limits = self.problem.limits();
        let mut fresh = sobol(&limits, self.effort.seed);
        // where hardly any point of the box has a cost, no number of tries is enough
        for _ in 0..50 {
            let tried: Vec<_> = fresh.by_ref().take(wanted).collect();
            let costs = self.problem.costs(&tried);
            for (point, cost) in tried.into_iter().zip(costs) {
                if points.len() == wanted {
                    return points;
                }
                if cost.failed() {
                    self.passed_over += 1;
                } else {
                    points.push(point);
                }
            }
        }
        points
    }

    /// Where a population ends, or `own`.
    fn evolve(&mut self, own: &DVector<f64>) -> Result<DVector<f64>> {
        if self.effort.population == 0 {
            return Ok(own.clone());
        }
        let least = generation(self.problem.shared()) as u64;
        if self.effort.population < least {
            return Err(Error::Population {
                least,
                found: self.effort.population,
            });
        }
        self.watch.tell(Event::Phase("searching the whole box"));
        let limits = self.problem.limits();
        let evolution = Evolution {
            limits: &limits,
            start: own,
            population: None,
            budget: self.effort.population,
            tolerance: 1e-6,
            seed: self.effort.seed,
            watch: self.watch.clone(),
        };
        let costs = |points: &[DVector<f64>]| self.problem.costs(points);
        let outcome = evolve(
            &costs,
            &evolution,
            &self.journal::<Generation>("population")?,
        )?;
        self.population = Some(Population {
            cost: outcome.cost,
            evaluations: outcome.cost_evaluations,
            failures: outcome.failures,
            termination: outcome.termination,
        });
        Ok(outcome.point)
    }

    /// What more is known about the end of the search, the shared variables `z`, where the
    /// parameters are `estimates`.
    pub fn further(self, z: &DVector<f64>, estimates: &[Estimate]) -> Result<Further> {
        let starts = self
            .starts
            .as_ref()
            .map(|starts| self.agreement(starts, estimates));
        let mut further = Further {
            starts,
            population: self.population.clone(),
            ..Further::default()
        };
        let asked = self.effort.profiles || self.effort.reduce;
        if asked && !self.watch.stopped() {
            let solved = Solved::new(self.problem, z)?;
            if self.effort.profiles && !self.watch.stopped() {
                self.watch.tell(Event::Phase("profiling"));
                further.profiles = solved.profiles();
            }
            if self.effort.reduce && !self.watch.stopped() {
                self.watch
                    .tell(Event::Phase("leaving out what the data can do without"));
                further.reduction = solved.reduce(1.0)?;
            }
        }
        if self.effort.bootstrap > 0 && !self.watch.stopped() {
            further.bootstrap = Some(self.bootstrap(z)?);
        }
        Ok(further)
    }

    fn agreement(&self, starts: &Starts, estimates: &[Estimate]) -> Agreement {
        let determined: Vec<(usize, f64)> = estimates
            .iter()
            .zip(&self.problem.variables)
            .enumerate()
            .filter(|(_, (estimate, _))| estimate.verdict == Verdict::Determined)
            .filter_map(|(i, (estimate, variable))| {
                Some((i, estimate.std_error? / variable.free.slope(estimate.value)))
            })
            .collect();
        let ends = starts
            .attempts
            .iter()
            .filter_map(|a| a.outcome.as_ref().ok());
        let mut costs: Vec<f64> = ends.map(|outcome| outcome.cost).collect();
        costs.sort_by(f64::total_cmp);
        Agreement {
            planned: starts.planned,
            passed_over: self.passed_over,
            failed: starts.failures(),
            agreeing: starts
                .agreeing(&determined)
                .into_iter()
                .filter(|a| *a)
                .count(),
            costs,
            stopped: starts.stopped(),
        }
    }

    fn bootstrap(&self, z: &DVector<f64>) -> Result<Resampled> {
        self.watch.tell(Event::Phase("fitting data made again"));
        let journal = self.journal::<Draw>("bootstrap")?;
        let bootstrap = Bootstrap::new(self.rides, self.plan, self.problem, z, self.effort.seed)?;
        bootstrap.run(self.effort.bootstrap, &journal, self.watch)
    }
}
