//! Bounded Levenberg–Marquardt.
//!
//! Marquardt 1963 and Moré 1978 (scaling by the curvature's diagonal: a change of units changes
//! nothing), Nielsen 1999 (damping from the gain ratio), Bertsekas 1982 (bounds: the model is
//! minimised in the box, face by face). A cost that is not finite, a failed simulation, is a step
//! too long and never an error.

use super::{
    Here, Iteration, Landscape, Limits, Observer, Outcome, Quadratic, STOPPED, count, ours,
};
use crate::error::{Error, Result};
use crate::progress::Watch;
use argmin::core::observers::ObserverMode;
use argmin::core::{
    CostFunction, Executor, Hessian, Problem, Solver, State, TerminationReason, TerminationStatus,
};
use nalgebra::DVector;

/// A landscape as argmin wants to see it.
struct Walk<'a, L>(&'a L);

impl<L: Landscape> CostFunction for Walk<'_, L> {
    type Param = DVector<f64>;
    type Output = f64;

    fn cost(&self, z: &DVector<f64>) -> std::result::Result<f64, argmin::core::Error> {
        Ok(self.0.cost(z))
    }
}

impl<L: Landscape> Hessian for Walk<'_, L> {
    type Param = DVector<f64>;
    type Hessian = Quadratic;

    fn hessian(&self, z: &DVector<f64>) -> std::result::Result<Quadratic, argmin::core::Error> {
        Ok(self.0.quadratic(z)?)
    }
}

/// Part of a cost below which a fall means nothing: where a model does not fit, the cost is large
/// and so is every standard error.
const ROUGH: f64 = 1e-8;

/// Damping of the step by whose promise convergence is judged: little enough to see the fall along
/// a poorly determined direction, enough to be deaf to rounding along one that is not at all.
const JUDGED: f64 = 1e-5;

/// Damping at which a step is no longer one.
const UTTER: f64 = 1e16;

/// Why a search ended.
#[derive(Debug, Clone)]
enum End {
    Converged,
    Stalled,
    Cliff,
    Lost(String),
    Stopped,
}

impl End {
    fn words(&self) -> String {
        match self {
            Self::Converged => {
                "converged: no step would lower the cost by more than the tolerance".into()
            }
            Self::Stalled => "stalled: no step, however short, lowers the cost".into(),
            Self::Cliff => {
                "stalled: where the cost falls, it cannot be computed a short step on".into()
            }
            Self::Lost(cause) => format!("stalled: no slope at the best point: {cause}"),
            Self::Stopped => STOPPED.into(),
        }
    }
}

/// The solver.
struct LevenbergMarquardt<'a> {
    limits: &'a Limits,
    held: &'a [usize],
    damping: f64,
    growth: f64,
    tolerance: f64,
    watch: Watch,
    failures: u64,
    /// Whether the last step that was too long had no cost at its end.
    cliff: bool,
    end: Option<End>,
}

impl LevenbergMarquardt<'_> {
    /// By how much the shared variables may change from `point`: within bounds and reach.
    fn room(&self, point: &DVector<f64>) -> (DVector<f64>, DVector<f64>) {
        let Limits {
            lower,
            upper,
            reach,
        } = self.limits;
        let open = |i: usize| !self.held.contains(&i);
        let room = |to: &dyn Fn(usize) -> f64| {
            DVector::from_fn(lower.len(), |i, _| if open(i) { to(i) } else { 0.0 })
        };
        (
            room(&|i| (lower[i] - point[i]).clamp(-reach[i], 0.0)),
            room(&|i| (upper[i] - point[i]).clamp(0.0, reach[i])),
        )
    }

    /// `point` moved by `step`, to the last bit within bounds.
    fn moved(&self, point: &DVector<f64>, step: &DVector<f64>) -> DVector<f64> {
        let mut next = point + step;
        for i in (0..self.limits.lower.len()).filter(|&i| step[i] != 0.0) {
            next[i] = next[i].clamp(self.limits.lower[i], self.limits.upper[i]);
        }
        next
    }
}

impl<'a, L: Landscape> Solver<Walk<'a, L>, Here<Quadratic>> for LevenbergMarquardt<'_> {
    fn name(&self) -> &'static str {
        "bounded Levenberg-Marquardt"
    }

    fn init(
        &mut self,
        problem: &mut Problem<Walk<'a, L>>,
        mut state: Here<Quadratic>,
    ) -> Iteration<Quadratic> {
        let point = state.take_param().expect("the executor was given a start");
        let cost = problem.cost(&point)?;
        if !cost.is_finite() {
            return Err(Error::Search(format!(
                "expected a finite cost at the start, found {cost}"
            ))
            .into());
        }
        Ok((state.param(point).cost(cost), None))
    }

    fn next_iter(
        &mut self,
        problem: &mut Problem<Walk<'a, L>>,
        mut state: Here<Quadratic>,
    ) -> Iteration<Quadratic> {
        let point = state.take_param().expect("every iteration leaves a point");
        let cost = state.get_cost();
        let model = match problem.hessian(&point) {
            Ok(model) => model,
            Err(cause) if state.get_iter() == 0 => return Err(cause),
            // argmin would lose the best point with the error
            Err(cause) => {
                self.end = Some(End::Lost(cause.to_string()));
                return Ok((state.param(point).cost(cost), None));
            }
        };
        let (low, high) = self.room(&point);
        let tolerance = self.tolerance.max(ROUGH * cost.abs());
        let promise = model
            .step(self.damping.min(JUDGED), &low, &high)
            .map(|step| model.fall(&step));
        if promise.is_some_and(|fall| fall < tolerance) {
            self.end = Some(End::Converged);
            // one more step promises little, but the point moves with the root of that; the usual
            // damping keeps it from wandering where nothing is determined
            let Some(step) = model.step(self.damping, &low, &high) else {
                return Ok((state.param(point).cost(cost), None));
            };
            let next = self.moved(&point, &step);
            if next != point {
                let found = problem.cost(&next)?;
                if found < cost && found.is_finite() {
                    return Ok((state.param(next).cost(found), None));
                }
            }
            return Ok((state.param(point).cost(cost), None));
        }
        while self.damping < UTTER {
            if let Some(step) = model.step(self.damping, &low, &high) {
                let expected = model.fall(&step);
                let next = self.moved(&point, &step);
                if next == point {
                    break;
                }
                let found = problem.cost(&next)?;
                if found < cost && found.is_finite() {
                    let ratio = ((cost - found) / expected).clamp(0.0, 1.0);
                    self.damping *= (1.0 - (2.0 * ratio - 1.0).powi(3)).max(1.0 / 3.0);
                    self.growth = 2.0;
                    return Ok((state.param(next).cost(found), None));
                }
                self.cliff = !found.is_finite();
                self.failures += u64::from(self.cliff);
            }
            self.damping *= self.growth;
            self.growth *= 2.0;
        }
        self.end = Some(if self.cliff { End::Cliff } else { End::Stalled });
        Ok((state.param(point).cost(cost), None))
    }

    fn terminate(&mut self, _: &Here<Quadratic>) -> TerminationStatus {
        if self.end.is_none() && self.watch.stopped() {
            self.end = Some(End::Stopped);
        }
        self.end
            .as_ref()
            .map_or(TerminationStatus::NotTerminated, |end| {
                TerminationStatus::Terminated(TerminationReason::SolverExit(end.words()))
            })
    }
}

/// How a local search is run.
#[derive(Debug, Clone)]
pub struct Search<'a> {
    /// Box and step limits of the shared variables.
    pub limits: &'a Limits,
    /// Shared variables that stay where they start.
    pub held: &'a [usize],
    /// A fall in cost below this, or below 1e-8 of the cost, is none.
    pub tolerance: f64,
    /// Iterations after which to give up.
    pub max_iterations: u64,
    /// Who looks on and may stop it.
    pub watch: Watch,
}

/// Searches `landscape` from `start`, which must have a cost and lie within the limits, for the
/// least cost. Ending early, by running out of iterations or being stopped, gives the best so far.
pub fn minimise<L: Landscape>(
    landscape: &L,
    start: DVector<f64>,
    search: &Search,
) -> Result<Outcome> {
    let solver = LevenbergMarquardt {
        limits: search.limits,
        held: search.held,
        damping: 1e-3,
        growth: 2.0,
        tolerance: search.tolerance,
        watch: search.watch.clone(),
        failures: 0,
        cliff: false,
        end: None,
    };
    let observer = Observer {
        watch: search.watch.clone(),
        budget: None,
    };
    let max_iterations = search.max_iterations;
    let result = Executor::new(Walk(landscape), solver)
        .configure(|state| state.param(start).max_iters(max_iterations).counting(true))
        .add_observer(observer, ObserverMode::Always)
        .run()
        .map_err(ours)?;
    let (state, solver) = (result.state, result.solver);
    Ok(Outcome {
        point: state.get_best_param().expect("the start at least").clone(),
        cost: state.get_best_cost(),
        termination: solver.end.as_ref().map_or_else(
            || format!("gave up after {max_iterations} iterations"),
            End::words,
        ),
        converged: matches!(solver.end, Some(End::Converged)),
        stopped: matches!(solver.end, Some(End::Stopped)),
        iterations: state.get_iter(),
        cost_evaluations: count(&state, "cost_count"),
        curvature_evaluations: count(&state, "hessian_count"),
        failures: solver.failures,
    })
}

#[cfg(test)]
mod tests;
