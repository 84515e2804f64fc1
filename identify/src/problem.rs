//! What a plan means for rides, ready to be searched: starts, profiles and bootstraps are many
//! searches of one problem.

use crate::error::{Error, Result};
use crate::free::{Candidate, Variable, limits};
use crate::model::Model;
use crate::objective::amplitude::Amplitude;
use crate::objective::free_response::in_windows;
use crate::objective::frf::Frf;
use crate::objective::simulated::{Engine, Simulated};
use crate::objective::spectral::{Measured, Source, Spectral};
use crate::objective::time::{self, Time, Torque};
use crate::objective::together::{Known, Member, Together};
use crate::objective::whittle::Whittle;
use crate::objective::{Information, Objective};
use crate::plan::{Plan, Resolved, Ridden, names, resolve};
use crate::progress::Watch;
use crate::solver::{Cost, Landscape, Limits, Outcome, Search, Searchable, minimise};
use crate::verdict::spread;
use nalgebra::DVector;
use rand::Rng;
use rand_distr::{Distribution, StandardNormal};
use rayon::prelude::*;
use serde::{Deserialize, Serialize};
use std::sync::Arc;

/// The work a fit took.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct Spent {
    /// Iterations of the search.
    pub iterations: u64,
    /// Evaluations of the cost.
    pub cost_evaluations: u64,
    /// Those of them that found none: failed or diverged simulations.
    pub failures: u64,
    /// Evaluations of gradient and curvature.
    pub curvature_evaluations: u64,
    /// Searches: the weights of `amplitude` are renewed between them.
    pub passes: u64,
}

/// Where one search ended.
#[derive(Debug, Clone)]
pub struct Found {
    /// The end: shared variables, then the rides' blocks. The counts are those of all passes.
    pub outcome: Outcome,
    /// Searches that it took.
    pub passes: u64,
}

impl Found {
    /// The work it took.
    pub fn work(&self) -> Spent {
        Spent {
            iterations: self.outcome.iterations,
            cost_evaluations: self.outcome.cost_evaluations,
            failures: self.outcome.failures,
            curvature_evaluations: self.outcome.curvature_evaluations,
            passes: self.passes,
        }
    }

    /// `later`, with the work of both.
    fn then(&self, later: Outcome) -> Self {
        let before = &self.outcome;
        Self {
            outcome: Outcome {
                iterations: before.iterations + later.iterations,
                cost_evaluations: before.cost_evaluations + later.cost_evaluations,
                curvature_evaluations: before.curvature_evaluations + later.curvature_evaluations,
                failures: before.failures + later.failures,
                ..later
            },
            passes: self.passes + 1,
        }
    }
}

/// The rides under one objective.
pub enum Rides {
    /// Spectra, fitted by amplitude.
    Amplitude(Together<Whittle>),
    /// Spectra, fitted by likelihood.
    Whittle(Together<Whittle>),
    /// Replayed windows.
    Time(Together<Time>),
    /// Frequency responses.
    Frf(Together<Frf>),
}

/// Rides, what is sought in them and what is made small.
pub struct Problem {
    /// The objective.
    pub objective: Objective,
    /// The channels.
    pub channels: Vec<&'static str>,
    /// What the rides are called.
    pub names: Vec<String>,
    /// What is sought.
    pub variables: Vec<Variable>,
    /// The rides.
    pub rides: Rides,
    /// The variables of the plan's own values.
    own: DVector<f64>,
    max_iterations: u64,
}

/// A fall of the cost below which a search of spectra has arrived.
const SPECTRAL: f64 = 1e-9;
/// The same of replayed windows, whose cost carries the noise of every sample.
const REPLAYED: f64 = 1e-5;
/// Searches with frozen weights at most.
const PASSES: u64 = 6;

impl Problem {
    /// The problem of `plan` on `rides`.
    pub fn new(rides: &[Ridden], plan: &Plan) -> Result<Self> {
        let resolved = resolve(rides, plan)?;
        let (variables, indices) = resolved.variables(rides);
        let own = own(&variables, &indices, rides, &resolved, plan);
        let mut problem = Self {
            objective: resolved.objective,
            channels: resolved.channels.clone(),
            names: names(rides),
            rides: build(rides, plan, &resolved, &variables, &indices)?,
            variables,
            own,
            max_iterations: plan.max_iterations,
        };
        if problem.priors().iter().any(Option::is_some) {
            // CIFER's cost is no likelihood that a prior could be weighed against
            problem.objective.check(
                "a prior",
                &[
                    Objective::Amplitude,
                    Objective::Whittle,
                    Objective::Time,
                    Objective::FreeResponse,
                ],
            )?;
        }
        let (observations, free) = (problem.observations(), problem.variables.len());
        if let Rides::Amplitude(_) | Rides::Whittle(_) = &problem.rides {
            // channels of one bin are no further frequencies: a spectrum of few bins says little
            let found = observations / problem.channels.len();
            if found < free {
                return Err(Error::TooFewBins { free, found });
            }
        }
        if observations <= free {
            return Err(Error::TooFewObservations {
                free,
                found: observations,
            });
        }
        problem.own = problem.stand()?;
        problem.weigh_priors()?;
        Ok(problem)
    }

    fn priors(&mut self) -> &mut Vec<Option<Known>> {
        match &mut self.rides {
            Rides::Amplitude(spectra) | Rides::Whittle(spectra) => &mut spectra.priors,
            Rides::Time(windows) => &mut windows.priors,
            Rides::Frf(responses) => &mut responses.priors,
        }
    }

    /// Gives priors their weight against replayed windows, whose curvature counts every sample as
    /// if it stood alone: by the variances of the estimates without them.
    fn weigh_priors(&mut self) -> Result<()> {
        let priors = self.priors().clone();
        if priors.iter().all(Option::is_none) || !self.objective.is_replayed() {
            return Ok(());
        }
        self.priors().fill(None);
        let found = self.search(&self.start(), &[], &Watch::default())?;
        let information = self.information(&found.outcome.point)?;
        let (scattered, plain) = (spread(&information), spread(&information.plain()));
        *self.priors() = priors;
        for (i, known) in self.priors().iter_mut().enumerate() {
            // what the windows do not see has its prior alone, whatever its weight
            if let (Some(known), None) = (known, &scattered.singular[i]) {
                known.factor = scattered.covariance[(i, i)] / plain.covariance[(i, i)];
            }
        }
        Ok(())
    }

    /// Draws the means of what was known before anew, as if the truth were at `z`.
    pub fn redraw_known(&mut self, z: &DVector<f64>, rng: &mut impl Rng) {
        for (known, z) in self.priors().iter_mut().zip(z.iter()) {
            if let Some(known) = known {
                let normal: f64 = StandardNormal.sample(rng);
                known.mean = z + known.deviation * normal;
            }
        }
    }

    /// Number of variables that are no block's.
    pub fn shared(&self) -> usize {
        self.variables.len()
    }

    /// Number of observations.
    pub fn observations(&self) -> usize {
        match &self.rides {
            Rides::Amplitude(t) | Rides::Whittle(t) => {
                let bins = |m: &Member<Whittle>| m.landscape.spectral.measured.coefficients.len();
                t.members.iter().map(bins).sum::<usize>() * self.channels.len()
            }
            Rides::Time(t) => t.members.iter().map(|m| m.landscape.observations()).sum(),
            Rides::Frf(t) => t.members.iter().map(|m| m.landscape.observations()).sum(),
        }
    }

    /// Where a search begins: the plan's own values, or as near to them as there is a spectrum.
    pub fn start(&self) -> DVector<f64> {
        self.own.clone()
    }

    /// The bounds of the shared variables.
    pub fn limits(&self) -> Limits {
        limits(self.variables.iter().map(|v| &v.free))
    }

    /// The values of the free parameters [SI] at the variables `z`.
    pub fn values(&self, z: &DVector<f64>) -> Vec<f64> {
        let variables = self.variables.iter().zip(z.iter());
        variables.map(|(v, z)| v.free.value(*z)).collect()
    }

    /// The variables at `values` [SI], within the bounds.
    pub fn at(&self, values: &[f64]) -> DVector<f64> {
        let variable = |(v, value): (&Variable, &f64)| {
            v.free.variable(value.clamp(v.free.lower, v.free.upper))
        };
        let variables = self.variables.iter().zip(values).map(variable);
        DVector::from_iterator(self.shared(), variables)
    }

    /// One search from the shared variables `start`; those of `held` stay.
    pub fn search(&self, start: &DVector<f64>, held: &[usize], watch: &Watch) -> Result<Found> {
        let limits = &self.limits();
        let search = |tolerance| Search {
            limits,
            held,
            tolerance,
            max_iterations: self.max_iterations,
            watch: watch.clone(),
        };
        let outcome = match &self.rides {
            Rides::Amplitude(spectra) => {
                // the likelihood carries its own weights and comes near from any start
                let near = minimise(spectra, start.clone(), &search(SPECTRAL))?;
                return renew_weights(spectra, near, &search(SPECTRAL));
            }
            Rides::Whittle(spectra) => minimise(spectra, start.clone(), &search(SPECTRAL))?,
            Rides::Frf(responses) => minimise(responses, start.clone(), &search(SPECTRAL))?,
            Rides::Time(windows) => {
                let search = search(REPLAYED);
                let stages = time::stages(windows);
                let start = with_blocks(&stages[0], start);
                let mut found = Found {
                    outcome: minimise(&stages[0], start, &search)?,
                    passes: 1,
                };
                for pair in stages.windows(2) {
                    let start = time::carry(&pair[0], &found.outcome.point, &pair[1]);
                    found = found.then(minimise(&pair[1], start, &search)?);
                }
                return Ok(found);
            }
        };
        Ok(Found { outcome, passes: 1 })
    }

    /// The same, `amplitude` with its weights frozen at `weights`: one cost for searches that are
    /// to be compared.
    pub fn search_weighted(
        &self,
        weights: &DVector<f64>,
        start: &DVector<f64>,
        held: &[usize],
    ) -> Result<Found> {
        let Rides::Amplitude(spectra) = &self.rides else {
            return self.search(start, held, &Watch::default());
        };
        let search = Search {
            limits: &self.limits(),
            held,
            tolerance: SPECTRAL,
            max_iterations: self.max_iterations,
            watch: Watch::default(),
        };
        let outcome = minimise(&weighted(spectra, weights)?, start.clone(), &search)?;
        Ok(Found { outcome, passes: 1 })
    }

    /// What each of many points is worth to a population. Of spectra their likelihood: amplitudes
    /// are weighted anew at every point, and such costs do not compare.
    pub fn costs(&self, points: &[DVector<f64>]) -> Vec<Cost> {
        match &self.rides {
            Rides::Amplitude(spectra) | Rides::Whittle(spectra) => spectra.costs(points),
            Rides::Frf(responses) => responses.costs(points),
            Rides::Time(windows) => {
                let cost = |z: &DVector<f64>| {
                    Cost::new(self.cost(z), || windows.excess(&with_blocks(windows, z)))
                };
                points.par_iter().map(cost).collect()
            }
        }
    }

    /// The cost by which the ends of searches compare: of `amplitude`, which ends where its own
    /// weights make it least, their likelihood.
    pub fn worth(&self, end: &Outcome) -> f64 {
        match &self.rides {
            Rides::Amplitude(spectra) => spectra.cost(&end.point),
            _ => end.cost,
        }
    }

    /// The least cost with the shared variables at `z`.
    pub fn cost(&self, z: &DVector<f64>) -> f64 {
        match &self.rides {
            Rides::Amplitude(spectra) => {
                weighted(spectra, z).map_or(f64::INFINITY, |together| together.cost(z))
            }
            Rides::Whittle(spectra) => spectra.cost(z),
            Rides::Frf(responses) => responses.cost(z),
            Rides::Time(_) => {
                let held: Vec<usize> = (0..self.shared()).collect();
                let settled = self.search(z, &held, &Watch::default());
                settled.map_or(f64::INFINITY, |found| found.outcome.cost)
            }
        }
    }

    /// What the rides know at the point `z` of a search.
    pub fn information(&self, z: &DVector<f64>) -> Result<Information> {
        match &self.rides {
            Rides::Amplitude(spectra) => spectra.information(z, |ride, z| {
                Amplitude::new(ride.spectral.clone(), z)?.information(z)
            }),
            Rides::Whittle(spectra) => spectra.information(z, Whittle::information),
            Rides::Time(windows) => time::information(windows, z),
            Rides::Frf(responses) => responses.information(z, Frf::information),
        }
    }

    /// Refuses windows too few to tell the scatter of the free parameters between them.
    pub fn check_windows(&self) -> Result<()> {
        let Rides::Time(rides) = &self.rides else {
            return Ok(());
        };
        let (found, free) = (windows(rides), self.shared());
        let longest = rides.members.iter().map(|m| m.landscape.longest());
        if found > free {
            return Ok(());
        }
        Err(Error::Windows {
            window: longest.fold(0.0, f64::max),
            step: rides.members[0].landscape.step(),
            found,
            free,
        })
    }

    /// Refuses a free parameter along which nothing changes at the start.
    pub fn check_influence(&self) -> Result<()> {
        let z = self.start();
        let curvature = match &self.rides {
            Rides::Amplitude(spectra) => weighted(spectra, &z)?.quadratic(&z)?.curvature,
            Rides::Whittle(spectra) => spectra.quadratic(&z)?.curvature,
            Rides::Time(windows) => windows.quadratic(&with_blocks(windows, &z))?.curvature,
            Rides::Frf(responses) => responses.quadratic(&z)?.curvature,
        };
        let largest = curvature.diagonal().amax();
        let deaf = (0..self.shared()).find(|&i| curvature[(i, i)] <= 1e-20 * largest);
        deaf.map_or(Ok(()), |i| {
            Err(Error::NoInfluence {
                name: self.variables[i].to_string(),
                objective: self.objective.name(),
                why: "no equation that this objective evaluates changes with it at these values",
            })
        })
    }

    /// The point `z` with its shared variables at the nominal values; a nuisance keeps its own.
    pub fn nominal(&self, z: &DVector<f64>) -> DVector<f64> {
        let mut nominal = z.clone();
        for (i, Variable { free, .. }) in self.variables.iter().enumerate() {
            if !free.nuisance() {
                nominal[i] = free.variable(free.row.nominal.clamp(free.lower, free.upper));
            }
        }
        nominal
    }

    /// The first start, from the plan's own towards the nominal values, at which every ride has a
    /// spectrum.
    fn stand(&self) -> Result<DVector<f64>> {
        let (Rides::Amplitude(spectra) | Rides::Whittle(spectra)) = &self.rides else {
            return Ok(self.own.clone());
        };
        let plain = Candidate {
            excitation: Plan::default().excitation,
            ..Candidate::default()
        };
        let nominal = DVector::from_iterator(
            self.shared(),
            self.variables
                .iter()
                .map(|v| plain.variables(std::slice::from_ref(&v.free))[0]),
        );
        let mut cause = String::new();
        for k in 0..5 {
            let part = 0.25 * f64::from(k);
            let z = &self.own * (1.0 - part) + &nominal * part;
            let stands = |ride: &Whittle, z: &DVector<f64>| {
                ride.spectral.expected(z).map(|_| ride.cost(z).is_finite())
            };
            match spectra
                .each(&z, stands)
                .into_iter()
                .collect::<Result<Vec<_>>>()
            {
                Ok(all) if all.iter().all(|stands| *stands) => return Ok(z),
                Ok(_) => cause = "the spectral matrix of a bin is not positive definite".into(),
                Err(error) => cause = error.to_string(),
            }
        }
        Err(Error::NoStart {
            objective: self.objective.name(),
            cause,
        })
    }
}

/// The variables of the rides' own values; what rides share starts at the first one's.
fn own(
    variables: &[Variable],
    indices: &[Vec<usize>],
    rides: &[Ridden],
    resolved: &Resolved,
    plan: &Plan,
) -> DVector<f64> {
    let mut z = DVector::zeros(variables.len());
    for (ridden, own) in rides.iter().zip(indices).rev() {
        let unknowns = resolved.unknowns(ridden, plan);
        let values = unknowns.start.variables(&unknowns.free);
        for (&i, value) in own.iter().zip(values.iter()) {
            z[i] = *value;
        }
    }
    z
}

/// The rides under the objective of `resolved`.
fn build(
    rides: &[Ridden],
    plan: &Plan,
    resolved: &Resolved,
    variables: &[Variable],
    indices: &[Vec<usize>],
) -> Result<Rides> {
    let (channels, noise) = (&resolved.channels, plan.noise.as_deref());
    let factor = match resolved.objective {
        Objective::Amplitude | Objective::Whittle => {
            let seeds = plan.model.seeds();
            let scatter = seeds.map_or(Ok(1.0), |seeds| seeds.covariance_factor(rides.len()))?;
            resolved.recipe.taper.covariance_factor() * scatter
        }
        Objective::Time | Objective::FreeResponse | Objective::Frf => 1.0,
    };
    let known = |v: &Variable| {
        let (mean, deviation) = v.free.prior_variable()?;
        Some(Known {
            mean,
            deviation,
            factor,
        })
    };
    let priors: Vec<_> = variables.iter().map(known).collect();
    let spectra = || {
        together(rides, indices, &priors, factor, |ridden| {
            let (ride, speed) = (ridden.ride, ridden.speed);
            let measured = Measured::new(ride, channels, &resolved.recipe, speed, noise)?;
            let unknowns = resolved.unknowns(ridden, plan);
            let engine = match &plan.model {
                Model::Equations => None,
                Model::Simulated(seeds) => Some((Engine::Native(plan.formulation), seeds)),
                Model::Foreign(fmu, seeds) => Some((Engine::Foreign(fmu.clone()), seeds)),
            };
            let source = match engine {
                None => Source::Linearised,
                Some((engine, seeds)) => Source::Simulated(Arc::new(Simulated::new(
                    engine,
                    &measured,
                    &unknowns.start.excitation,
                    (seeds.of(rides.len())?, seeds.seed),
                )?)),
            };
            let spectral = Spectral {
                measured,
                unknowns,
                formulation: plan.formulation,
                source,
            };
            Ok(Whittle { spectral })
        })
    };
    Ok(match resolved.objective {
        Objective::Amplitude => Rides::Amplitude(spectra()?),
        Objective::Whittle => Rides::Whittle(spectra()?),
        Objective::Time | Objective::FreeResponse => {
            Rides::Time(together(rides, indices, &priors, factor, |ridden| {
                let unknowns = resolved.unknowns(ridden, plan);
                let torque = match resolved.objective {
                    Objective::Time if ridden.windows.is_empty() => {
                        let (ride, cut) = (ridden.ride, (ridden.speed, resolved.window));
                        return match plan.model.foreign() {
                            Some(fmu) => {
                                Time::of_foreign(fmu, ride, channels, unknowns, cut, noise)
                            }
                            None => {
                                Time::new(ride, channels, unknowns, plan.formulation, cut, noise)
                            }
                        };
                    }
                    Objective::Time => Torque::Recorded,
                    _ => Torque::Off,
                };
                in_windows(
                    ridden.ride,
                    channels,
                    unknowns,
                    plan.formulation,
                    torque,
                    (ridden.speed, &ridden.windows),
                    noise,
                )
            })?)
        }
        Objective::Frf => Rides::Frf(together(rides, indices, &priors, factor, |ridden| {
            Frf::new(
                ridden.ride,
                channels,
                resolved.unknowns(ridden, plan),
                plan.formulation,
                (ridden.speed, resolved.window),
                resolved.recipe.band,
            )
        })?),
    })
}

fn together<'a, L>(
    rides: &[Ridden<'a>],
    indices: &[Vec<usize>],
    priors: &[Option<Known>],
    factor: f64,
    landscape: impl Fn(&Ridden<'a>) -> Result<L>,
) -> Result<Together<L>> {
    let member = |(ridden, variables): (&Ridden<'a>, &Vec<usize>)| {
        let landscape = landscape(ridden);
        let landscape = match (landscape, rides.len()) {
            // which of several rides it was
            (Err(error), 2..) => Err(error.in_file(ridden.ride.name())),
            (landscape, _) => landscape,
        }?;
        let variables = variables.clone();
        Ok(Member {
            landscape,
            variables,
        })
    };
    Ok(Together {
        members: rides
            .iter()
            .zip(indices)
            .map(member)
            .collect::<Result<_>>()?,
        priors: priors.to_vec(),
        factor,
    })
}

/// Number of windows of all rides.
fn windows(rides: &Together<Time>) -> usize {
    rides.members.iter().map(|m| m.landscape.windows()).sum()
}

/// The spectra of `spectra` fitted by amplitude, with the weights of the model at `z`.
fn weighted(spectra: &Together<Whittle>, z: &DVector<f64>) -> Result<Together<Amplitude>> {
    let amplitudes = spectra.each(z, |ride, z| Amplitude::new(ride.spectral.clone(), z));
    let members = spectra.members.iter().zip(amplitudes);
    let member = |(member, landscape): (&Member<Whittle>, Result<Amplitude>)| {
        Ok(Member {
            landscape: landscape?,
            variables: member.variables.clone(),
        })
    };
    Ok(Together {
        members: members.map(member).collect::<Result<_>>()?,
        priors: spectra.priors.clone(),
        factor: spectra.factor,
    })
}

/// Searches by amplitude with frozen weights, from the most likely point on, until renewing them
/// moves nothing.
fn renew_weights(spectra: &Together<Whittle>, near: Outcome, search: &Search) -> Result<Found> {
    let mut found = Found {
        outcome: near,
        passes: 0,
    };
    loop {
        let point = found.outcome.point.clone();
        found = found.then(minimise(
            &weighted(spectra, &point)?,
            point.clone(),
            search,
        )?);
        let moved = (&found.outcome.point - point).amax();
        if moved < 1e-3 || found.outcome.stopped {
            return Ok(found);
        }
        if found.passes == PASSES {
            found.outcome.converged = false;
            found.outcome.termination = format!(
                "the weights still moved the estimates by {moved:.1e} of their scale after {PASSES} passes"
            );
            return Ok(found);
        }
    }
}

impl Searchable for Problem {
    fn search(&self, start: &DVector<f64>, watch: &Watch) -> Result<Outcome> {
        let mut end = Self::search(self, start, &[], watch)?.outcome;
        end.cost = self.worth(&end);
        Ok(end)
    }
}

/// `shared` followed by the initial states that each ride starts from.
fn with_blocks(windows: &Together<Time>, shared: &DVector<f64>) -> DVector<f64> {
    let blocks = windows.members.iter().flat_map(|member| {
        let start = member.landscape.start();
        let own = member.variables.len();
        start.iter().skip(own).copied().collect::<Vec<_>>()
    });
    let shared = shared.iter().take(windows.shared()).copied();
    DVector::from_vec(shared.chain(blocks).collect())
}
