//! A fit: one ride, one objective, some free parameters → values, uncertainty, verdicts.

use crate::closed_loop::{ClosedLoop, sign_gain};
use crate::error::{Error, Result};
use crate::free::{Candidate, Free};
use crate::objective::amplitude::Amplitude;
use crate::objective::spectral::{Measured, Spectral};
use crate::objective::time::{Replay, Time};
use crate::objective::whittle::Whittle;
use crate::objective::{Information, Objective};
use crate::plan::{Plan, Resolved, left_alone, resolve};
use crate::ride::Ride;
use crate::solver::{Landscape, Limits, Outcome, minimise};
use crate::verdict::{Estimate, Verdict, judge};
use bicycle::Parameters;
use nalgebra::DVector;
use serde::{Deserialize, Serialize};

/// Variation of the speed, rms over mean, above which a spectrum at the mean speed is remarked on.
const STEADY: f64 = 0.03;

/// The work a fit took.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct Work {
    /// Iterations of the search.
    pub iterations: u64,
    /// Evaluations of the cost.
    pub cost_evaluations: u64,
    /// Evaluations of gradient and curvature.
    pub curvature_evaluations: u64,
    /// Searches: the weights of `amplitude` are renewed between them.
    pub passes: u64,
}

/// What came out.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Fit {
    /// The objective.
    pub objective: Objective,
    /// The channels it looked at.
    pub channels: Vec<String>,
    /// Standard deviation of each channel's noise, given or estimated [SI].
    pub noise: Vec<f64>,
    /// The free parameters.
    pub parameters: Vec<Estimate>,
    /// Their correlations, in the same order.
    pub correlation: Vec<Vec<f64>>,
    /// Least cost: ½ Σ r² of `amplitude` and `time`, −log L of `whittle`.
    pub cost: f64,
    /// Mean square of what should have unit variance: 1 where the model is true.
    pub misfit: f64,
    /// Number of observations.
    pub observations: usize,
    /// Steer rate of the linearised loop [rad/s rms] (spectra only): what turns Coulomb friction
    /// into effective damping.
    pub steer_rate_deviation: Option<f64>,
    /// The replay against the record, channel by channel (`time` only).
    pub replays: Vec<Replay>,
    /// Why the search ended.
    pub termination: String,
    /// Whether it converged.
    pub converged: bool,
    /// The work it took.
    pub work: Work,
    /// What a reader should know: assumptions, warnings, implications.
    pub notes: Vec<String>,
}

impl Fit {
    /// The row called `name`.
    pub fn estimate(&self, name: &str) -> Option<&Estimate> {
        self.parameters.iter().find(|p| p.name == name)
    }

    /// `start` with the estimates in place of the free parameters.
    pub fn candidate(&self, start: &Candidate) -> Result<Candidate> {
        let mut candidate = start.clone();
        for estimate in &self.parameters {
            candidate.set(&Free::new(&estimate.name)?, estimate.value);
        }
        Ok(candidate)
    }
}

/// Fits `plan` to `ride`; `progress` is told what is being done.
pub fn fit(ride: &Ride, plan: &Plan, progress: &dyn Fn(&str)) -> Result<Fit> {
    let Resolved {
        objective,
        channels,
        unknowns,
        recipe,
    } = resolve(ride, plan)?;
    let free = unknowns.free.clone();
    let noise = plan.noise.as_deref();
    progress("reading the ride");
    if objective == Objective::Time {
        let problem = Time::new(
            ride,
            &channels,
            unknowns,
            plan.formulation,
            (plan.speed, plan.window),
            noise,
        )?;
        let mut fit = fit_time(&problem, plan, progress)?;
        fit.notes.extend(left_alone(&free, plan));
        return Ok(fit);
    }
    let measured = Measured::new(ride, &channels, &recipe, plan.speed, noise)?;
    let spectral = Spectral {
        measured,
        unknowns,
        formulation: plan.formulation,
    };
    let observations = spectral.measured.coefficients.len() * channels.len();
    if observations <= free.len() {
        return Err(Error::TooFewObservations {
            free: free.len(),
            found: observations,
        });
    }
    let start = start_of(&spectral, objective)?;
    progress("searching");
    let judged = if objective == Objective::Whittle {
        let problem = Whittle {
            spectral: spectral.clone(),
        };
        check_influence(&problem, &free, &start, objective)?;
        let (outcome, work) = search(&problem, &free, start, plan, 1e-9)?;
        let misfit = problem.misfit(&outcome.point)?;
        judge_at(&free, outcome, work, misfit, |z| problem.information(z))?
    } else {
        let (problem, outcome, work) = fit_amplitude(&spectral, &free, start, plan, progress)?;
        let misfit = 2.0 * outcome.cost / observations as f64;
        judge_at(&free, outcome, work, misfit, |z| problem.information(z))?
    };
    let closed_loop = spectral.closed_loop(&judged.outcome.point)?;
    let mut notes = notes(&spectral, &judged.outcome.point, &closed_loop);
    notes.extend(left_alone(&free, plan));
    Ok(Fit {
        observations,
        steer_rate_deviation: Some(closed_loop.steer_rate_deviation()),
        notes,
        ..assemble(
            objective,
            &free,
            (&channels, &spectral.measured.noise),
            judged,
        )
    })
}

/// A search that has ended, and what the data know there and at the nominal values.
struct Judged {
    outcome: Outcome,
    work: Work,
    misfit: f64,
    here: Information,
    nominal: Option<Information>,
}

fn judge_at(
    free: &[Free],
    outcome: Outcome,
    work: Work,
    misfit: f64,
    information: impl Fn(&DVector<f64>) -> Result<Information>,
) -> Result<Judged> {
    let here = information(&outcome.point)?;
    // where the nominal bicycle does not stand there is nothing to compare with; the scatter of the
    // gradient is that of the estimate, elsewhere it would hold the gradient itself
    let nominal = information(&nominal_variables(free, &outcome.point)).ok();
    let nominal = nominal.map(|n| Information {
        meat: here.meat.clone(),
        ..n
    });
    Ok(Judged {
        outcome,
        work,
        misfit,
        here,
        nominal,
    })
}

/// The first start, from the plan's own towards the nominal values, at which there is a spectrum.
fn start_of(spectral: &Spectral, objective: Objective) -> Result<DVector<f64>> {
    let free = &spectral.unknowns.free;
    let own = spectral.unknowns.start.variables(free);
    let nominal = Candidate {
        parameters: Parameters::default(),
        excitation: Plan::default().excitation,
    };
    let nominal = nominal.variables(free);
    let mut cause = String::new();
    for k in 0..5 {
        let part = 0.25 * f64::from(k);
        let z = &own * (1.0 - part) + &nominal * part;
        match spectral.expected(&z) {
            Ok(bins) if bins.iter().all(|bin| bin.clone().cholesky().is_some()) => return Ok(z),
            Ok(_) => cause = "the spectral matrix of a bin is not positive definite".into(),
            Err(error) => cause = error.to_string(),
        }
    }
    Err(Error::NoStart {
        objective: objective.name(),
        cause,
    })
}

/// The variables of the nominal values; a nuisance keeps its own.
fn nominal_variables(free: &[Free], own: &DVector<f64>) -> DVector<f64> {
    DVector::from_fn(own.len(), |i, _| match free.get(i) {
        Some(f) if !f.nuisance() => f.variable(f.row.nominal.clamp(f.lower, f.upper)),
        _ => own[i],
    })
}

/// Refuses a free parameter along which nothing changes at the start.
fn check_influence<L: Landscape>(
    landscape: &L,
    free: &[Free],
    start: &DVector<f64>,
    objective: Objective,
) -> Result<()> {
    let curvature = landscape.quadratic(start)?.curvature;
    let largest = curvature.diagonal().amax();
    for (i, f) in free.iter().enumerate() {
        if curvature[(i, i)] <= 1e-20 * largest {
            return Err(Error::NoInfluence {
                name: f.row.name.into(),
                objective: objective.name(),
                why: "no equation that this objective evaluates changes with it at these values",
            });
        }
    }
    Ok(())
}

fn search<L: Landscape>(
    landscape: &L,
    free: &[Free],
    start: DVector<f64>,
    plan: &Plan,
    tolerance: f64,
) -> Result<(Outcome, Work)> {
    let variables = |value: fn(&Free) -> f64| {
        DVector::from_iterator(free.len(), free.iter().map(|f| f.variable(value(f))))
    };
    let limits = Limits {
        lower: variables(|f| f.lower),
        upper: variables(|f| f.upper),
        reach: DVector::from_element(free.len(), 0.7),
    };
    let outcome = minimise(landscape, start, limits, tolerance, plan.max_iterations)?;
    let work = Work {
        iterations: outcome.iterations,
        cost_evaluations: outcome.cost_evaluations,
        curvature_evaluations: outcome.curvature_evaluations,
        passes: 1,
    };
    Ok((outcome, work))
}

/// Searches with frozen weights, from the most likely point on, until renewing them moves nothing.
fn fit_amplitude(
    spectral: &Spectral,
    free: &[Free],
    start: DVector<f64>,
    plan: &Plan,
    progress: &dyn Fn(&str),
) -> Result<(Amplitude, Outcome, Work)> {
    const PASSES: u64 = 6;
    check_influence(
        &Amplitude::new(spectral.clone(), &start)?,
        free,
        &start,
        Objective::Amplitude,
    )?;
    // the likelihood carries its own weights and comes near from any start
    let likelihood = Whittle {
        spectral: spectral.clone(),
    };
    let (near, mut total) = search(&likelihood, free, start, plan, 1e-9)?;
    let mut point = near.point;
    total.passes = 0;
    loop {
        let problem = Amplitude::new(spectral.clone(), &point)?;
        let (outcome, work) = search(&problem, free, point.clone(), plan, 1e-9)?;
        total = Work {
            iterations: total.iterations + work.iterations,
            cost_evaluations: total.cost_evaluations + work.cost_evaluations,
            curvature_evaluations: total.curvature_evaluations + work.curvature_evaluations,
            passes: total.passes + 1,
        };
        let moved = (&outcome.point - &point).amax();
        point.clone_from(&outcome.point);
        if moved < 1e-3 {
            return Ok((problem, outcome, total));
        }
        if total.passes == PASSES {
            let termination = format!(
                "the weights still moved the estimates by {moved:.1e} of their scale after {PASSES} passes"
            );
            return Ok((
                problem,
                Outcome {
                    termination,
                    converged: false,
                    ..outcome
                },
                total,
            ));
        }
        progress("renewing the weights");
    }
}

fn fit_time(problem: &Time, plan: &Plan, progress: &dyn Fn(&str)) -> Result<Fit> {
    let free = &problem.unknowns.free;
    let start = problem.start();
    check_influence(problem, free, &start, Objective::Time)?;
    progress("searching");
    let (outcome, work) = search(problem, free, start, plan, 1e-5)?;
    // each window's initial state and each free parameter explains one observation
    let freedom = problem
        .observations()
        .saturating_sub(outcome.point.len())
        .max(1);
    let misfit = 2.0 * outcome.cost / freedom as f64;
    let replays = problem.replays(&outcome.point)?;
    let judged = judge_at(free, outcome, work, misfit, |z| problem.information(z))?;
    let note = format!(
        "{} windows of {} s, each with a free initial state; standard errors from the scatter between windows",
        problem.windows(),
        plan.window
    );
    Ok(Fit {
        observations: problem.observations(),
        replays,
        notes: vec![note],
        ..assemble(
            Objective::Time,
            free,
            (&problem.channels, &problem.noise),
            judged,
        )
    })
}

fn assemble(
    objective: Objective,
    free: &[Free],
    (channels, noise): (&[&str], &[f64]),
    Judged {
        outcome,
        work,
        misfit,
        here,
        nominal,
    }: Judged,
) -> Fit {
    let variables = free.iter().zip(outcome.point.iter());
    let values: Vec<f64> = variables.map(|(f, z)| f.value(*z)).collect();
    let (mut parameters, correlation) = judge(free, &values, &here, nominal.as_ref());
    if !outcome.converged {
        // a search that has not arrived has determined nothing
        for estimate in parameters
            .iter_mut()
            .filter(|e| e.verdict != Verdict::Nuisance)
        {
            estimate.verdict = Verdict::NotDetermined;
        }
    }
    Fit {
        objective,
        channels: channels.iter().map(|c| (*c).to_owned()).collect(),
        noise: noise.to_vec(),
        parameters,
        correlation: correlation
            .row_iter()
            .map(|row| row.iter().copied().collect())
            .collect(),
        cost: outcome.cost,
        misfit,
        observations: 0,
        steer_rate_deviation: None,
        replays: Vec::new(),
        termination: outcome.termination,
        converged: outcome.converged,
        work,
        notes: Vec::new(),
    }
}

/// What a reader of a spectral fit should know.
fn notes(spectral: &Spectral, z: &DVector<f64>, closed_loop: &ClosedLoop) -> Vec<String> {
    let candidate = spectral.unknowns.candidate(z);
    let mut notes = vec![format!(
        "torque not measured: assumed to be the rider law plus first-order noise with a corner of {} Hz",
        candidate.excitation.remnant_corner
    )];
    let steer = closed_loop.steer_deviation();
    if steer > crate::closed_loop::STEER_CHECKED {
        notes.push(format!(
            "steering of {:.1}° rms: above 5° the linearised model spectrum has not been checked",
            steer.to_degrees()
        ));
    }
    let free = &spectral.unknowns.free;
    if free.iter().any(|f| f.row.name == "effective_damping") {
        let p = &candidate.parameters;
        let gain = sign_gain(closed_loop.steer_rate_deviation());
        let implied = candidate.excitation.effective_damping - gain * p.coulomb_friction;
        notes.push(format!(
            "effective damping at a steer rate of {:.3} rad/s rms; with the assumed Coulomb friction of \
             {} N.m it implies a viscous friction of {implied:.3} N.m.s/rad{}",
            closed_loop.steer_rate_deviation(),
            p.coulomb_friction,
            if implied < 0.0 { ", which no bicycle has: too much Coulomb friction is assumed, or the damping is too uncertain to say" } else { "" },
        ));
    }
    let measured = &spectral.measured;
    if measured.speed_spread > STEADY {
        notes.push(format!(
            "the speed varies by {:.0} % rms; the model rides at its mean of {:.2} m/s throughout",
            100.0 * measured.speed_spread,
            measured.speed
        ));
    }
    for line in &measured.unmasked {
        notes.push(format!(
            "the steering has a line at {line:.2} Hz that noise does not explain: slalom or \
             pedalling? Masked with --line it would no longer bias friction and intensity"
        ));
    }
    for line in &measured.lines {
        notes.push(format!(
            "line at {} Hz masked, its steer amplitude of {:.2}° put into the linearisation",
            line.frequency,
            line.steer_amplitude.to_degrees()
        ));
    }
    notes
}
