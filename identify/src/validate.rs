//! How well a fitted model predicts rides it was not fitted to, and which of several formulations
//! the data prefer.

pub mod criteria;
pub mod replay;
pub mod residual;
pub mod spectrum;

use crate::bicycles::formulation;
use crate::effort::Effort;
use crate::error::{Error, Result};
use crate::fit::{Fit, fit};
use crate::free::{Scope, Variable, has};
use crate::objective::Objective;
use crate::objective::time::Time;
use crate::objective::whittle::Whittle;
use crate::plan::{Plan, Ridden};
use crate::problem::{Problem, Rides};
use crate::progress::Watch;
use crate::ride::Ride;
use crate::run::Run;
use crate::solver::Landscape;
use crate::verdict::Estimate;
use bicycle::Formulation;
use criteria::{Criteria, Start};
use nalgebra::DMatrix;
use replay::{Replayed, replayed};
use serde::{Deserialize, Serialize};
use spectrum::{Predicted, predicted};

/// A value that was estimated again on a held-out ride, since each ride has its own.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Reestimated {
    /// Name of the row.
    pub name: String,
    /// Mean over the rides of the fit [SI].
    pub fitted: f64,
    /// On this ride [SI].
    pub value: f64,
}

/// A ride that was not fitted.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct HeldOut {
    /// Its file.
    pub ride: String,
    /// Whether it is one that the model was fitted to after all.
    pub fitted_to: bool,
    /// The condition of the fit whose estimates it was predicted with; none: where conditions or
    /// rides of the fit have their own, the mean over them.
    pub condition: Option<String>,
    /// What was estimated again on it: nuisances.
    pub reestimated: Vec<Reestimated>,
    /// Its spectrum, of a fit of spectra.
    pub spectrum: Option<Predicted>,
    /// Its windows, of a fit of windows.
    pub replays: Vec<Replayed>,
}

impl HeldOut {
    /// One number for how far off the model is: of spectra the root mean square of the bands'
    /// errors [dB], of windows 1 − variance accounted for, both over channels.
    pub fn error(&self) -> f64 {
        let mean = |all: &mut dyn Iterator<Item = f64>| {
            let (sum, n) = all.fold((0.0, 0.0), |(s, n), v| (s + v, n + 1.0));
            sum / n
        };
        match &self.spectrum {
            Some(predicted) => {
                let squares = predicted.bands.iter().map(|b| b.decibels.powi(2));
                mean(&mut { squares }).sqrt()
            }
            None => mean(
                &mut self
                    .replays
                    .iter()
                    .map(|r| 1.0 - r.replay.variance_accounted_for),
            ),
        }
    }
}

/// One formulation.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Candidate {
    /// Its name.
    pub formulation: String,
    /// What it is worth; none where it cannot be fitted.
    pub weighed: Option<Weighed>,
    /// Why it cannot: its bicycle does not stand, say.
    pub failed: Option<String>,
}

/// What a formulation is worth.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Weighed {
    /// Whether its search arrived.
    pub converged: bool,
    /// Its estimates on the rides of the fit.
    pub parameters: Vec<Estimate>,
    /// What the rides of the fit prefer.
    pub criteria: Criteria,
    /// The held-out rides.
    pub held_out: Vec<HeldOut>,
    /// Mean of their errors.
    pub error: f64,
}

/// What a validation says.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Validation {
    /// The fit's objective.
    pub objective: String,
    /// What [`HeldOut::error`] is: its unit.
    pub error_of: String,
    /// The held-out rides under the fit on record.
    pub held_out: Vec<HeldOut>,
    /// Formulations, each fitted again to the rides of the fit.
    pub formulations: Vec<Candidate>,
}

/// The objectives that can be validated: the others predict neither spectra nor windows.
const OFFERED: [Objective; 4] = [
    Objective::Amplitude,
    Objective::Whittle,
    Objective::Time,
    Objective::FreeResponse,
];

/// `ride`, to be predicted by `run`: on the bicycle and under the condition that is `condition` in
/// the fit, or where the fit has but one, under that.
pub fn unfitted<'a>(run: &Run, ride: &'a Ride, condition: Option<&str>) -> Result<Ridden<'a>> {
    let conditions = || run.rides.iter().map(|r| r.condition.as_str());
    let first = &run.rides[0].condition;
    let condition = condition.or_else(|| conditions().all(|c| c == first).then_some(first));
    let like = match condition {
        None => 0,
        Some(name) => conditions()
            .position(|c| c == name)
            .ok_or_else(|| Error::unknown("condition", name, conditions()))?,
    };
    let own = &run.ridden_as(like, ride)?;
    Ok(Ridden {
        condition: condition.unwrap_or_default().into(),
        windows: Vec::new(),
        ..own.clone()
    })
}

/// `run` on `rides`, which it was not fitted to.
pub fn validate(run: &Run, rides: &[Ridden]) -> Result<Validation> {
    run.fit.objective.check("validation", &OFFERED)?;
    let plan = run.plan()?;
    let held_out = rides
        .iter()
        .map(|ridden| held_out(&plan, &run.fit, ridden, run))
        .collect::<Result<_>>()?;
    Ok(Validation {
        objective: run.fit.objective.name().into(),
        error_of: if run.fit.objective.is_replayed() {
            "1 − variance accounted for"
        } else {
            "rms error of the bands [dB]"
        }
        .into(),
        held_out,
        formulations: Vec::new(),
    })
}

/// `run` fitted again to its own rides, `fitted`, with each of the formulations `names`, and each of
/// them on `rides`. A formulation that cannot be fitted says why and stops none of the others.
pub fn formulations(
    run: &Run,
    fitted: &[Ride],
    rides: &[Ridden],
    names: &[String],
) -> Result<Vec<Candidate>> {
    run.fit.objective.check("validation", &OFFERED)?;
    let known = names.iter().map(|name| formulation(name));
    let known: Vec<Formulation> = known.collect::<Result<_>>()?;
    let candidate = |formulation: Formulation| {
        let weighed = weigh(run, fitted, rides, formulation);
        Candidate {
            formulation: formulation.name().into(),
            failed: weighed.as_ref().err().map(ToString::to_string),
            weighed: weighed.ok(),
        }
    };
    Ok(known.into_iter().map(candidate).collect())
}

fn weigh(
    run: &Run,
    fitted: &[Ride],
    rides: &[Ridden],
    formulation: Formulation,
) -> Result<Weighed> {
    let mut plan = run.plan()?;
    plan.formulation = formulation;
    // one noise for all: likelihoods are of the same observations
    plan.noise = plan.noise.or_else(|| shared_noise(&run.fit));
    if let Some(free) = &mut plan.free {
        free.retain(|f| has(formulation, f.row.name));
    }
    plan.ties.retain(|tie| has(formulation, tie.leader.name));
    let (problem, fit) = fit(
        &run.ridden(fitted)?,
        &plan,
        &Effort::default(),
        &Watch::default(),
    )?;
    let held_out = rides
        .iter()
        .map(|ridden| held_out(&plan, &fit, ridden, run))
        .collect::<Result<Vec<_>>>()?;
    Ok(Weighed {
        converged: fit.converged,
        criteria: criteria(&problem, &fit)?,
        error: held_out.iter().map(HeldOut::error).sum::<f64>() / held_out.len() as f64,
        parameters: fit.parameters,
        held_out,
    })
}

/// The noise of each channel, root mean square over the rides of `fit`.
fn shared_noise(fit: &Fit) -> Option<Vec<f64>> {
    let rides = &fit.explained;
    let of = |c: usize| {
        let squares = rides.iter().map(|r| r.noise.get(c).map(|n| n * n));
        let sum = squares.sum::<Option<f64>>()?;
        Some((sum / rides.len() as f64).sqrt())
    };
    (0..fit.channels.len()).map(of).collect()
}

/// What the rides of `problem` prefer, at the estimates of `fit`.
pub fn criteria(problem: &Problem, fit: &Fit) -> Result<Criteria> {
    let values: Vec<f64> = fit.parameters.iter().map(|p| p.value).collect();
    let z = problem.at(&values);
    match &problem.rides {
        Rides::Amplitude(spectra) | Rides::Whittle(spectra) => {
            let information = spectra.information(&z, Whittle::information)?;
            let sample = problem.observations() as f64 / information.factor;
            let of = "Fourier coefficients of all channels, less what the taper correlates";
            let cost = spectra.cost(&z);
            Ok(Criteria::new(cost, &information, (sample, of), &[]))
        }
        // a cost that is no likelihood
        Rides::Frf(_) => Err(problem.objective.refused("AIC and BIC", &OFFERED)),
        Rides::Time(windows) => {
            let held: Vec<usize> = (0..z.len()).collect();
            let outcome = problem.search(&z, &held, &Watch::default())?.outcome;
            let bases = windows.each(&outcome.point, Time::hat_bases);
            let bases = bases.into_iter().collect::<Result<Vec<_>>>()?.concat();
            let start = |basis: &DMatrix<f64>| Start {
                parameters: basis.ncols(),
                observations: basis.nrows(),
            };
            Ok(Criteria::new(
                outcome.cost,
                &problem.information(&outcome.point)?,
                (bases.len() as f64, "windows, each a cluster"),
                &bases.iter().map(start).collect::<Vec<_>>(),
            ))
        }
    }
}

/// `ridden` under the estimates of `fit`: all held but the nuisances, which each ride has of its own.
fn held_out(plan: &Plan, fit: &Fit, ridden: &Ridden, run: &Run) -> Result<HeldOut> {
    let ride = ridden.ride;
    let problem = Problem::new(std::slice::from_ref(ridden), plan)?;
    let conditions = Conditions { fit, run, ridden };
    let values: Vec<f64> = problem
        .variables
        .iter()
        .map(|variable| conditions.estimate(variable))
        .collect::<Result<_>>()?;
    let start = problem.at(&values);
    let held: Vec<usize> = (0..start.len())
        .filter(|&i| {
            let free = &problem.variables[i].free;
            !free.nuisance() || free.scope == Scope::Shared
        })
        .collect();
    let point = problem
        .search(&start, &held, &Watch::default())?
        .outcome
        .point;
    let found = problem.values(&point);
    let again = (0..start.len()).filter(|i| !held.contains(i));
    let reestimated = again.map(|i| Reestimated {
        name: problem.variables[i].free.row.name.into(),
        fitted: values[i],
        value: found[i],
    });
    let (mut spectrum, mut replays) = (None, Vec::new());
    match &problem.rides {
        Rides::Amplitude(spectra) | Rides::Whittle(spectra) => {
            let mut all = spectra.each(&point, |ride, z| predicted(&ride.spectral, z));
            spectrum = Some(all.remove(0)?);
        }
        Rides::Frf(_) => {}
        Rides::Time(windows) => {
            let mut all = windows.each(&point, |windows, z| replayed(windows, z, ride));
            replays = all.remove(0)?;
        }
    }
    let sha = ride.origin.as_ref().map(|o| &o.sha256);
    Ok(HeldOut {
        ride: ride.name(),
        fitted_to: run.rides.iter().any(|r| Some(&r.source.sha256) == sha),
        condition: conditions.known().then(|| ridden.condition.clone()),
        reestimated: reestimated.collect(),
        spectrum,
        replays,
    })
}

/// A ride among the conditions of a fit.
struct Conditions<'a> {
    fit: &'a Fit,
    run: &'a Run,
    ridden: &'a Ridden<'a>,
}

impl Conditions<'_> {
    /// Whether the fit had rides of its condition.
    fn known(&self) -> bool {
        let mut rides = self.run.rides.iter();
        rides.any(|recorded| recorded.condition == self.ridden.condition)
    }

    /// Whether what the fit calls `of`, a condition or a ride, is of its condition.
    fn own(&self, of: &str) -> bool {
        let rides = self.fit.explained.iter().zip(&self.run.rides);
        let mut named =
            rides.filter(|(explained, recorded)| explained.ride == of || recorded.condition == of);
        named.any(|(_, recorded)| recorded.condition == self.ridden.condition)
    }

    /// The fit's value of `variable` [SI]: where rides or conditions had their own, that of the
    /// ride's condition, of several rides of it the mean; where the fit does not know the condition,
    /// the mean over all.
    fn estimate(&self, variable: &Variable) -> Result<f64> {
        let name = variable.free.row.name;
        let parameters = &self.fit.parameters;
        let all: Vec<&Estimate> = parameters.iter().filter(|p| p.name == name).collect();
        if all.is_empty() {
            let known = parameters.iter().map(|p| p.name.as_str());
            return Err(Error::unknown("fitted parameter", name, known));
        }
        let is_own = |p: &&&Estimate| p.of.as_ref().is_none_or(|of| self.own(of));
        let own: Vec<&Estimate> = all.iter().filter(is_own).copied().collect();
        let of = if own.is_empty() { &all } else { &own };
        Ok(of.iter().map(|p| p.value).sum::<f64>() / of.len() as f64)
    }
}

#[cfg(test)]
mod tests;
