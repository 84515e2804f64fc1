//! How well a fitted model foretells rides it was not fitted to, and which of several readings of
//! the equations the data prefer.

pub mod criteria;
pub mod replay;
pub mod residual;
pub mod spectrum;

use crate::bicycles::formulation;
use crate::effort::Effort;
use crate::error::{Error, Result};
use crate::fit::{Fit, fit};
use crate::free::{Variable, has};
use crate::objective::Objective;
use crate::objective::whittle::Whittle;
use crate::plan::{Plan, Ridden};
use crate::problem::{Problem, Rides};
use crate::progress::Watch;
use crate::ride::Ride;
use crate::run::Run;
use crate::solver::Landscape;
use crate::verdict::Estimate;
use bicycle::Formulation;
use criteria::Criteria;
use replay::{Replayed, replayed};
use serde::{Deserialize, Serialize};
use spectrum::{Foretold, foretold};

/// A value that was sought anew on a held-out ride, since each ride has its own.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Renewed {
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
    /// What was sought anew on it: nuisances.
    pub renewed: Vec<Renewed>,
    /// Its spectrum, of a fit of spectra.
    pub spectrum: Option<Foretold>,
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
            Some(foretold) => {
                let squares = foretold.bands.iter().map(|b| b.decibels.powi(2));
                mean(&mut { squares }).sqrt()
            }
            None => mean(&mut self.replays.iter().map(|r| 1.0 - r.variance_accounted_for)),
        }
    }
}

/// One reading of the equations.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Candidate {
    /// Its name.
    pub formulation: String,
    /// What it is worth; none where it cannot be fitted.
    pub weighed: Option<Weighed>,
    /// Why it cannot: its bicycle does not stand, say.
    pub failed: Option<String>,
}

/// What a reading of the equations is worth.
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
    /// Readings of the equations, each fitted anew to the rides of the fit.
    pub formulations: Vec<Candidate>,
}

/// `run` on `rides`, which it was not fitted to.
pub fn validate(run: &Run, rides: &[Ride]) -> Result<Validation> {
    let plan = run.plan()?;
    let held_out = rides
        .iter()
        .map(|ride| held_out(&plan, &run.fit, ride, run))
        .collect::<Result<_>>()?;
    let windows = plan.objective == Some(Objective::Time);
    Ok(Validation {
        objective: run.fit.objective.name().into(),
        error_of: if windows {
            "1 − variance accounted for"
        } else {
            "rms error of the bands [dB]"
        }
        .into(),
        held_out,
        formulations: Vec::new(),
    })
}

/// `run` fitted anew to its own rides, `fitted`, with each of the readings `names`, and each of them
/// on `rides`. A reading that cannot be fitted says why and stops none of the others.
pub fn formulations(
    run: &Run,
    fitted: &[Ride],
    rides: &[Ride],
    names: &[String],
) -> Result<Vec<Candidate>> {
    let readings = names.iter().map(|name| formulation(name));
    let readings: Vec<Formulation> = readings.collect::<Result<_>>()?;
    let candidate = |reading: Formulation| {
        let weighed = weigh(run, fitted, rides, reading);
        Candidate {
            formulation: reading.name().into(),
            failed: weighed.as_ref().err().map(ToString::to_string),
            weighed: weighed.ok(),
        }
    };
    Ok(readings.into_iter().map(candidate).collect())
}

fn weigh(run: &Run, fitted: &[Ride], rides: &[Ride], reading: Formulation) -> Result<Weighed> {
    let mut plan = run.plan()?;
    plan.formulation = reading;
    // one noise for all: likelihoods are of the same observations
    plan.noise = plan.noise.or_else(|| shared_noise(&run.fit));
    if let Some(free) = &mut plan.free {
        free.retain(|f| has(reading, f.row.name));
    }
    plan.ties.retain(|tie| has(reading, tie.leader.name));
    let (problem, fit) = fit(
        &run.ridden(fitted)?,
        &plan,
        &Effort::default(),
        &Watch::default(),
    )?;
    let held_out = rides
        .iter()
        .map(|ride| held_out(&plan, &fit, ride, run))
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
            Ok(Criteria::new(
                spectra.cost(&z),
                &information,
                sample,
                "Fourier coefficients of all channels, less what the taper correlates",
            ))
        }
        Rides::Frf(responses) => Ok(Criteria::new(
            responses.cost(&z),
            &problem.information(&z)?,
            problem.observations() as f64,
            "magnitudes and phases; the cost is no likelihood",
        )),
        Rides::Time(windows) => {
            let held: Vec<usize> = (0..z.len()).collect();
            let outcome = problem.search(&z, &held, &Watch::default())?.outcome;
            let clusters = windows.members.iter().map(|m| m.landscape.windows());
            Ok(Criteria::new(
                outcome.cost,
                &problem.information(&outcome.point)?,
                clusters.sum::<usize>() as f64,
                "windows, each a cluster",
            ))
        }
    }
}

/// `ride` under the estimates of `fit`: all held but the nuisances, which each ride has of its own.
fn held_out(plan: &Plan, fit: &Fit, ride: &Ride, run: &Run) -> Result<HeldOut> {
    run.fit.objective.check(
        "validation",
        &[Objective::Amplitude, Objective::Whittle, Objective::Time],
    )?;
    let ridden = Ridden {
        condition: run.rides[0].condition.clone(),
        ..plan.ridden(ride)
    };
    let problem = Problem::new(&[ridden], plan)?;
    let values: Vec<f64> = problem
        .variables
        .iter()
        .map(|variable| estimate(fit, variable))
        .collect::<Result<_>>()?;
    let start = problem.at(&values);
    let held: Vec<usize> = (0..start.len())
        .filter(|&i| !problem.variables[i].free.nuisance())
        .collect();
    let point = problem
        .search(&start, &held, &Watch::default())?
        .outcome
        .point;
    let found = problem.values(&point);
    let renewed = (0..start.len()).filter(|i| !held.contains(i));
    let renewed = renewed.map(|i| Renewed {
        name: problem.variables[i].free.row.name.into(),
        fitted: values[i],
        value: found[i],
    });
    let (mut spectrum, mut replays) = (None, Vec::new());
    match &problem.rides {
        Rides::Amplitude(spectra) | Rides::Whittle(spectra) => {
            let mut all = spectra.each(&point, |ride, z| foretold(&ride.spectral, z));
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
        renewed: renewed.collect(),
        spectrum,
        replays,
    })
}

/// The fit's value of `variable` [SI]: where rides or conditions had their own, the mean.
fn estimate(fit: &Fit, variable: &Variable) -> Result<f64> {
    let name = variable.free.row.name;
    let all: Vec<f64> = fit
        .parameters
        .iter()
        .filter(|p| p.name == name)
        .map(|p| p.value)
        .collect();
    if all.is_empty() {
        let known = fit.parameters.iter().map(|p| p.name.as_str());
        return Err(Error::unknown("fitted parameter", name, known));
    }
    Ok(all.iter().sum::<f64>() / all.len() as f64)
}

#[cfg(test)]
mod tests;
