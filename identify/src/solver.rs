//! Bounded Levenberg–Marquardt as a solver of argmin (which has none): the only module that names
//! argmin. The loop, its limits and its counters are argmin's.
//!
//! Moré 1978 (scaling by the curvature's diagonal), Nielsen 1999 (damping), Bertsekas 1982
//! (variables at a bound that the gradient pushes outwards are held). A cost that is not finite, a
//! failed simulation, is a step too long and never an error.

use crate::error::{self, Result};
use argmin::core::{
    CostFunction, Executor, Hessian, IterState, KV, Problem, Solver, State, TerminationReason,
    TerminationStatus,
};
use nalgebra::{DMatrix, DVector};

/// What a search walks on: a cost and its local model, over the variables of the search.
pub trait Landscape: Sync {
    /// Number of variables in blocks, behind the shared ones.
    fn blocks(&self) -> usize {
        0
    }
    /// The cost at `z`; not finite where it cannot be computed.
    fn cost(&self, z: &DVector<f64>) -> f64;
    /// Gradient and curvature at a `z` of finite cost.
    fn quadratic(&self, z: &DVector<f64>) -> Result<Quadratic>;
}

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

/// A block of variables that meets only itself and the shared ones: the initial state of a window.
#[derive(Debug, Clone)]
pub struct Block {
    /// Gradient over the block.
    pub gradient: DVector<f64>,
    /// What the block's observations add to the gradient over the shared variables.
    pub share: DVector<f64>,
    /// Curvature of the block with itself.
    pub curvature: DMatrix<f64>,
    /// Curvature of the block (rows) with the shared variables (columns).
    pub cross: DMatrix<f64>,
}

/// A local model of a cost: gradient and positive semidefinite curvature (Gauss–Newton or
/// Fisher) over the shared variables and then the blocks.
#[derive(Debug, Clone)]
pub struct Quadratic {
    /// Gradient over the shared variables.
    pub gradient: DVector<f64>,
    /// Curvature of the shared variables.
    pub curvature: DMatrix<f64>,
    /// The blocks, in the order of the variables.
    pub blocks: Vec<Block>,
}

/// What is left of a [`Quadratic`] over the shared variables once the blocks are eliminated.
#[derive(Debug, Clone)]
pub struct Reduced {
    /// Gradient.
    pub gradient: DVector<f64>,
    /// Curvature: the Schur complement.
    pub curvature: DMatrix<f64>,
    /// The part of the gradient from each block's observations: clusters of a covariance.
    pub scores: Vec<DVector<f64>>,
    /// (B + damping)⁻¹ [cross, gradient] of each block.
    solved: Vec<(DMatrix<f64>, DVector<f64>)>,
}

impl Quadratic {
    /// Eliminates the blocks, their diagonals increased by `damping` of themselves. None where a
    /// block is singular or not finite.
    pub fn reduce(&self, damping: f64) -> Option<Reduced> {
        let mut reduced = Reduced {
            gradient: self.gradient.clone(),
            curvature: self.curvature.clone(),
            scores: Vec::with_capacity(self.blocks.len()),
            solved: Vec::with_capacity(self.blocks.len()),
        };
        for block in &self.blocks {
            let factor = damped(&block.curvature, damping).cholesky()?;
            let (cross, gradient) = (factor.solve(&block.cross), factor.solve(&block.gradient));
            let eliminated = block.cross.transpose() * &gradient;
            reduced.curvature -= block.cross.transpose() * &cross;
            reduced.gradient -= &eliminated;
            reduced.scores.push(&block.share - eliminated);
            reduced.solved.push((cross, gradient));
        }
        Some(reduced)
    }

    /// The step that minimises the damped model over the `free` shared variables and all blocks.
    fn step(&self, damping: f64, free: &[bool]) -> Option<DVector<f64>> {
        let reduced = self.reduce(damping)?;
        let kept: Vec<usize> = (0..free.len()).filter(|&i| free[i]).collect();
        let mut shared = DVector::zeros(free.len());
        if !kept.is_empty() {
            let gradient = reduced.gradient.select_rows(&kept);
            let curvature = reduced.curvature.select_rows(&kept).select_columns(&kept);
            let step = damped(&curvature, damping).cholesky()?.solve(&-gradient);
            for (&i, value) in kept.iter().zip(step.iter()) {
                shared[i] = *value;
            }
        }
        let mut step: Vec<f64> = shared.iter().copied().collect();
        for (cross, gradient) in &reduced.solved {
            step.extend((-gradient - cross * &shared).iter());
        }
        step.iter()
            .all(|v| v.is_finite())
            .then(|| DVector::from_vec(step))
    }

    /// By how much the undamped model falls along `step`.
    fn fall(&self, step: &DVector<f64>) -> f64 {
        let n = self.gradient.len();
        let shared = step.rows(0, n);
        let mut fall = -self.gradient.dot(&shared) - 0.5 * shared.dot(&(&self.curvature * shared));
        let mut at = n;
        for block in &self.blocks {
            let own = step.rows(at, block.gradient.len());
            at += block.gradient.len();
            fall -= block.gradient.dot(&own)
                + own.dot(&(&block.cross * shared))
                + 0.5 * own.dot(&(&block.curvature * own));
        }
        fall
    }
}

/// `matrix` with its diagonal increased by `damping` of itself; an empty diagonal entry, a
/// variable without influence here, becomes the damping of the largest.
fn damped(matrix: &DMatrix<f64>, damping: f64) -> DMatrix<f64> {
    let mut sum = matrix.clone();
    let floor = 1e-12 * matrix.diagonal().amax();
    for i in 0..matrix.nrows() {
        sum[(i, i)] += damping * matrix[(i, i)].max(floor) + f64::MIN_POSITIVE;
    }
    sum
}

/// Box and step limits of the shared variables.
#[derive(Debug, Clone)]
pub struct Limits {
    /// Lower bounds.
    pub lower: DVector<f64>,
    /// Upper bounds.
    pub upper: DVector<f64>,
    /// Longest change of a variable in one step.
    pub reach: DVector<f64>,
}

/// Part of a cost below which a fall means nothing: where a model does not fit, the cost is large
/// and so is every standard error.
const ROUGH: f64 = 1e-8;

/// The solver.
struct LevenbergMarquardt {
    limits: Limits,
    damping: f64,
    growth: f64,
    /// Falls smaller than this, or than [`ROUGH`] of the cost, end the search.
    tolerance: f64,
    /// Why it ended, once it has.
    end: Option<&'static str>,
}

type Here = IterState<DVector<f64>, (), (), Quadratic, (), f64>;

impl LevenbergMarquardt {
    /// `point` moved by `step`, within reach and bounds.
    fn candidate(&self, point: &DVector<f64>, step: &DVector<f64>) -> DVector<f64> {
        let mut next = point + step;
        for i in 0..self.limits.lower.len() {
            let reach = self.limits.reach[i];
            next[i] = (point[i] + step[i].clamp(-reach, reach))
                .clamp(self.limits.lower[i], self.limits.upper[i]);
        }
        next
    }

    /// Which shared variables may move: not those at a bound that the gradient pushes outwards.
    fn free(&self, point: &DVector<f64>, gradient: &DVector<f64>) -> Vec<bool> {
        (0..gradient.len())
            .map(|i| {
                let held = (point[i] <= self.limits.lower[i] && gradient[i] > 0.0)
                    || (point[i] >= self.limits.upper[i] && gradient[i] < 0.0);
                !held
            })
            .collect()
    }
}

type Iteration = std::result::Result<(Here, Option<KV>), argmin::core::Error>;

impl<'a, L: Landscape> Solver<Walk<'a, L>, Here> for LevenbergMarquardt {
    fn name(&self) -> &'static str {
        "bounded Levenberg-Marquardt"
    }

    fn init(&mut self, problem: &mut Problem<Walk<'a, L>>, mut state: Here) -> Iteration {
        let point = state.take_param().expect("the executor was given a start");
        let cost = problem.cost(&point)?;
        Ok((state.param(point).cost(cost), None))
    }

    fn next_iter(&mut self, problem: &mut Problem<Walk<'a, L>>, mut state: Here) -> Iteration {
        let point = state.take_param().expect("every iteration leaves a point");
        let cost = state.get_cost();
        let model = problem.hessian(&point)?;
        let gradient = model
            .reduce(0.0)
            .map_or_else(|| model.gradient.clone(), |r| r.gradient);
        let free = self.free(&point, &gradient);
        let tolerance = self.tolerance.max(ROUGH * cost.abs());
        while self.damping < 1e16 {
            if let Some(step) = model.step(self.damping, &free) {
                let next = self.candidate(&point, &step);
                let step = &next - &point;
                let expected = model.fall(&step);
                let found = problem.cost(&next)?;
                let fall = if found.is_finite() {
                    cost - found
                } else {
                    f64::NEG_INFINITY
                };
                if fall > 0.0 {
                    let ratio = (fall / expected).clamp(0.0, 1.0);
                    self.damping *= (1.0 - (2.0 * ratio - 1.0).powi(3)).max(1.0 / 3.0);
                    self.growth = 2.0;
                    if fall < tolerance && expected < tolerance {
                        self.end = Some(
                            "converged: the last step lowered the cost by less than the tolerance",
                        );
                    }
                    return Ok((state.param(next).cost(found), None));
                }
                if expected.abs() < tolerance {
                    self.end =
                        Some("converged: no step would lower the cost by more than the tolerance");
                    break;
                }
            }
            self.damping *= self.growth;
            self.growth *= 2.0;
        }
        self.end
            .get_or_insert("stalled: no step, however short, lowers the cost");
        Ok((state.param(point).cost(cost), None))
    }

    fn terminate(&mut self, _: &Here) -> TerminationStatus {
        self.end.map_or(TerminationStatus::NotTerminated, |why| {
            TerminationStatus::Terminated(TerminationReason::SolverExit(why.into()))
        })
    }
}

/// Where a search ended.
#[derive(Debug, Clone)]
pub struct Outcome {
    /// The best point.
    pub point: DVector<f64>,
    /// Its cost.
    pub cost: f64,
    /// Why the search ended, in words.
    pub termination: String,
    /// Whether that was convergence.
    pub converged: bool,
    /// Iterations.
    pub iterations: u64,
    /// Evaluations of the cost.
    pub cost_evaluations: u64,
    /// Evaluations of gradient and curvature.
    pub curvature_evaluations: u64,
}

/// Searches `landscape` from `start` for the least cost within `limits`; a fall in cost below
/// `tolerance` (or 1e-8 of the cost) ends it.
pub fn minimise<L: Landscape>(
    landscape: &L,
    start: DVector<f64>,
    limits: Limits,
    tolerance: f64,
    max_iterations: u64,
) -> Result<Outcome> {
    let solver = LevenbergMarquardt {
        limits,
        damping: 1e-3,
        growth: 2.0,
        tolerance,
        end: None,
    };
    let result = Executor::new(Walk(landscape), solver)
        .configure(|state| state.param(start).max_iters(max_iterations).counting(true))
        .run()
        .map_err(|cause| match cause.downcast::<error::Error>() {
            Ok(ours) => ours,
            Err(other) => error::Error::Search(other.to_string()),
        })?;
    let state = result.state;
    let count = |name: &str| state.get_func_counts().get(name).copied().unwrap_or(0);
    let converged = result
        .solver
        .end
        .is_some_and(|why| why.starts_with("converged"));
    Ok(Outcome {
        point: state.get_best_param().expect("the start at least").clone(),
        cost: state.get_best_cost(),
        termination: result.solver.end.map_or_else(
            || format!("stopped after {max_iterations} iterations"),
            str::to_owned,
        ),
        converged,
        iterations: state.get_iter(),
        cost_evaluations: count("cost_count"),
        curvature_evaluations: count("hessian_count"),
    })
}

#[cfg(test)]
mod tests {
    #![expect(clippy::unwrap_used, reason = "a failed step is a failed test")]
    use super::*;

    /// Rosenbrock's valley as least squares, NaN left of x = −1.5.
    struct Valley;
    impl Valley {
        fn residual(p: &DVector<f64>) -> DVector<f64> {
            DVector::from_vec(vec![10.0 * (p[1] - p[0] * p[0]), 1.0 - p[0]])
        }
    }
    impl Landscape for Valley {
        fn cost(&self, p: &DVector<f64>) -> f64 {
            if p[0] < -1.5 {
                f64::NAN
            } else {
                0.5 * Self::residual(p).norm_squared()
            }
        }
        fn quadratic(&self, p: &DVector<f64>) -> Result<Quadratic> {
            let j = DMatrix::from_row_slice(2, 2, &[-20.0 * p[0], 10.0, -1.0, 0.0]);
            Ok(Quadratic {
                gradient: j.transpose() * Self::residual(p),
                curvature: j.transpose() * j,
                blocks: Vec::new(),
            })
        }
    }

    fn box_of(lower: [f64; 2], upper: [f64; 2]) -> Limits {
        Limits {
            lower: DVector::from_row_slice(&lower),
            upper: DVector::from_row_slice(&upper),
            reach: DVector::from_element(2, 1.0),
        }
    }

    #[test]
    fn the_valley_is_walked_to_its_end_and_the_work_counted() {
        let start = DVector::from_row_slice(&[-1.2, 1.0]);
        let outcome = minimise(&Valley, start, box_of([-2.0; 2], [2.0; 2]), 1e-20, 100).unwrap();
        assert!(
            (&outcome.point - DVector::from_element(2, 1.0)).norm() < 1e-8,
            "{outcome:?}"
        );
        assert!(outcome.converged && outcome.iterations < 30, "{outcome:?}");
        assert!(outcome.cost_evaluations >= outcome.iterations);
    }

    #[test]
    fn a_bound_holds_and_the_rest_is_optimal_on_it() {
        // with x ≤ ½ the least of the valley is at x = ½, y = ¼
        let start = DVector::from_row_slice(&[-1.2, 1.0]);
        let outcome = minimise(&Valley, start, box_of([-2.0; 2], [0.5, 2.0]), 1e-20, 100).unwrap();
        assert!(
            (&outcome.point - DVector::from_row_slice(&[0.5, 0.25])).norm() < 1e-8,
            "{outcome:?}"
        );
    }

    #[test]
    fn blocks_are_eliminated_as_the_full_system_would() {
        // a random positive definite 2 + 2 × 3 arrow matrix
        let entry = |i: usize, j: usize| ((i * i * 7 + j * j * 3 + i * j + 1) as f64).sin();
        let jacobian = DMatrix::from_fn(20, 8, |i, j| {
            // rows 0..10 see the first block, 10..20 the second
            let block = if j < 2 { true } else { (j - 2) / 3 == i / 10 };
            if block { entry(i, j) } else { 0.0 }
        });
        let residual = DVector::from_fn(20, |i, _| entry(i, 11));
        let (h, g) = (
            jacobian.transpose() * &jacobian,
            jacobian.transpose() * &residual,
        );
        let block = |k: usize| Block {
            share: jacobian.view((10 * k, 0), (10, 2)).transpose() * residual.rows(10 * k, 10),
            gradient: g.rows(2 + 3 * k, 3).into_owned(),
            curvature: h.view((2 + 3 * k, 2 + 3 * k), (3, 3)).into_owned(),
            cross: h.view((2 + 3 * k, 0), (3, 2)).into_owned(),
        };
        let model = Quadratic {
            gradient: g.rows(0, 2).into_owned(),
            curvature: h.view((0, 0), (2, 2)).into_owned(),
            blocks: vec![block(0), block(1)],
        };
        let full = h.clone().cholesky().unwrap().solve(&-&g);
        let step = model.step(0.0, &[true, true]).unwrap();
        assert!((&step - &full).norm() < 1e-9 * full.norm());
        let fall = -g.dot(&full) - 0.5 * full.dot(&(&h * &full));
        assert!((model.fall(&step) / fall - 1.0).abs() < 1e-9);
        // and the clusters' scores are the reduced gradient's parts
        let reduced = model.reduce(0.0).unwrap();
        let sum: DVector<f64> = reduced.scores.iter().sum();
        assert!((sum - reduced.gradient).norm() < 1e-9);
    }
}
