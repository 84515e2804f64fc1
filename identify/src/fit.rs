//! A fit: rides, one objective, some free parameters → values, uncertainty, verdicts.

mod leaning;
mod notes;

use crate::effort::{Effort, Further, Work};
use crate::error::Result;
use crate::free::Free;
use crate::objective::amplitude::Amplitude;
use crate::objective::frf::Frf;
use crate::objective::time::{Replay, Time};
use crate::objective::whittle::Whittle;
use crate::objective::{Information, Objective};
use crate::plan::{Plan, Ridden, left_alone};
use crate::problem::{Found, Problem, Rides, Spent};
use crate::progress::{Event, Watch};
use crate::verdict::{Estimate, Verdict, judge};
use nalgebra::DVector;
use serde::{Deserialize, Serialize};

/// How one ride was explained.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Explained {
    /// What the ride is called: its file.
    pub ride: String,
    /// Standard deviation of each channel's noise, given or estimated [SI].
    pub noise: Vec<f64>,
    /// Number of observations, less what each window's initial state explains.
    pub observations: usize,
    /// Mean square of what should have unit variance: 1 where the model is true.
    pub misfit: f64,
    /// Steer rate of the linearised loop [rad/s rms] (spectra only): what turns Coulomb friction
    /// into effective damping.
    pub steer_rate_deviation: Option<f64>,
    /// The replay against the record, channel by channel (`time` only).
    pub replays: Vec<Replay>,
}

/// What came out.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Fit {
    /// The objective.
    pub objective: Objective,
    /// The channels it looked at.
    pub channels: Vec<String>,
    /// The free parameters.
    pub parameters: Vec<Estimate>,
    /// Their correlations, in the same order.
    pub correlation: Vec<Vec<f64>>,
    /// Least cost: ½ Σ r² of `amplitude` and `time`, −log L of `whittle`.
    pub cost: f64,
    /// Mean square of what should have unit variance, over all rides: 1 where the model is true.
    pub misfit: f64,
    /// Number of observations.
    pub observations: usize,
    /// How each ride was explained.
    pub explained: Vec<Explained>,
    /// Why the search ended.
    pub termination: String,
    /// Whether it converged.
    pub converged: bool,
    /// The work it took.
    pub work: Spent,
    /// What a reader should know: assumptions, warnings, implications.
    pub notes: Vec<String>,
    /// What was asked besides: starts, population, profiles, bootstrap.
    #[serde(flatten)]
    pub further: Further,
}

impl Fit {
    /// The row called `name`, of the first ride or condition where each has its own.
    pub fn estimate(&self, name: &str) -> Option<&Estimate> {
        self.parameters.iter().find(|p| p.name == name)
    }
}

/// Fits `plan` to `rides` with some `effort`; `watch` is told how far it is and may stop it. The problem comes along,
/// for what more is asked of it.
pub fn fit(
    rides: &[Ridden],
    plan: &Plan,
    effort: &Effort,
    watch: &Watch,
) -> Result<(Problem, Fit)> {
    watch.tell(Event::Phase("reading the rides"));
    let problem = Problem::new(rides, plan)?;
    problem.check_windows()?;
    problem.check_influence()?;
    let mut work = Work::new(&problem, rides, plan, effort, watch);
    let found = work.search()?;
    let mut fit = judged(&problem, &found, plan)?;
    let shared = found.outcome.point.rows(0, problem.shared()).into_owned();
    fit.further = work.further(&shared, &fit.parameters)?;
    Ok((problem, fit))
}

/// What a search's end says: values, their uncertainty, a verdict each.
pub fn judged(problem: &Problem, found: &Found, plan: &Plan) -> Result<Fit> {
    let outcome = &found.outcome;
    let here = problem.information(&outcome.point)?;
    // where the nominal bicycle does not stand there is nothing to compare with; the scatter of the
    // gradient is that of the estimate, elsewhere it would hold the gradient itself
    let nominal = problem.information(&problem.nominal(&outcome.point)).ok();
    let nominal = nominal.map(|n| Information {
        meat: here.meat.clone(),
        freedom: here.freedom,
        ..n
    });
    let values = problem.values(&outcome.point);
    let (mut parameters, correlation) = judge(&problem.variables, &values, &here, nominal.as_ref());
    if !outcome.converged {
        // a search that has not arrived has determined nothing
        for estimate in parameters
            .iter_mut()
            .filter(|e| e.verdict != Verdict::Nuisance)
        {
            estimate.verdict = Verdict::NotDetermined;
        }
    }
    let explained = explained(problem, &outcome.point)?;
    let weight: usize = explained.iter().map(|ride| ride.observations).sum();
    let squares = explained
        .iter()
        .map(|ride| ride.misfit * ride.observations as f64);
    let misfit = squares.sum::<f64>() / weight as f64;
    let mut notes = notes::notes(problem, &outcome.point, plan)?;
    let free: Vec<Free> = problem.variables.iter().map(|v| v.free).collect();
    notes.extend(left_alone(&free, plan));
    let leaning = leaning::lean(problem, &outcome.point, plan, &mut parameters)?;
    notes.extend(leaning);
    Ok(Fit {
        objective: problem.objective,
        channels: problem.channels.iter().map(|c| (*c).to_owned()).collect(),
        parameters,
        correlation: correlation
            .row_iter()
            .map(|row| row.iter().copied().collect())
            .collect(),
        cost: outcome.cost,
        misfit,
        observations: problem.observations(),
        explained,
        termination: outcome.termination.clone(),
        converged: outcome.converged,
        work: found.work(),
        notes,
        further: Further::default(),
    })
}

/// How the point `z` of a search explains each ride.
fn explained(problem: &Problem, z: &DVector<f64>) -> Result<Vec<Explained>> {
    let amplitude = problem.objective == Objective::Amplitude;
    let spectrum = |ride: &Whittle, z: &DVector<f64>| {
        let spectral = &ride.spectral;
        let observations = spectral.measured.coefficients.len() * problem.channels.len();
        let misfit = if amplitude {
            let weighted = Amplitude::new(spectral.clone(), z)?;
            weighted.residuals(z)?.norm_squared() / observations as f64
        } else {
            ride.misfit(z)?
        };
        Ok(Explained {
            ride: String::new(),
            noise: spectral.measured.noise.clone(),
            observations,
            misfit,
            steer_rate_deviation: spectral.beside(z)?.map(|l| l.steer_rate_deviation()),
            replays: Vec::new(),
        })
    };
    let replay = |ride: &Time, z: &DVector<f64>| {
        let observations = ride.observations().saturating_sub(z.len()).max(1);
        Ok(Explained {
            ride: String::new(),
            noise: ride.noise.clone(),
            observations,
            misfit: ride.misfit(z)?,
            steer_rate_deviation: None,
            replays: ride.replays(z)?,
        })
    };
    let response = |ride: &Frf, z: &DVector<f64>| {
        Ok(Explained {
            ride: String::new(),
            noise: Vec::new(),
            observations: ride.observations(),
            misfit: ride.misfit(z)?,
            steer_rate_deviation: None,
            replays: Vec::new(),
        })
    };
    let explained: Vec<Result<Explained>> = match &problem.rides {
        Rides::Amplitude(spectra) | Rides::Whittle(spectra) => spectra.each(z, spectrum),
        Rides::Time(windows) => windows.each(z, replay),
        Rides::Frf(responses) => responses.each(z, response),
    };
    let named = |(explained, name): (Result<Explained>, &String)| {
        Ok(Explained {
            ride: name.clone(),
            ..explained?
        })
    };
    explained
        .into_iter()
        .zip(&problem.names)
        .map(named)
        .collect()
}
