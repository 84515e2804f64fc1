//! A population that adapts its covariance: CMA-ES with restarts, for landscapes of many valleys.
//!
//! Hansen 2016 (arXiv:1604.00772) gives the strategy and its constants, Auger, Hansen 2005 the
//! restarts with populations twice as large. Bounds are mirrors: the strategy walks on the
//! landscape unfolded beyond them, where a least cost at a bound is an ordinary minimum. It only
//! compares costs, so a [`Cost`] may be a penalty.

use super::{Cost, Here, Iteration, Limits, Observer, Outcome, STOPPED, count, ours};
use crate::checkpoint::Journal;
use crate::error::Result;
use crate::progress::Watch;
use crate::starts::stream;
use argmin::core::observers::ObserverMode;
use argmin::core::{Executor, Problem, Solver, State, TerminationReason, TerminationStatus};
use nalgebra::{DMatrix, DVector, SymmetricEigen};
use rand::Rng;
use rand_distr::{Distribution, StandardNormal};
use serde::{Deserialize, Serialize};

/// First standard deviation, as a part of each variable's range: Hansen's advice.
const FIRST_DEVIATION: f64 = 0.3;

/// Standard deviation, as a part of the range, below which a population stands on one point.
const POINT: f64 = 1e-12;

/// Condition of the covariance beyond which its axes are rounding.
const CONDITION: f64 = 1e14;

/// How a population searches.
#[derive(Debug, Clone)]
pub struct Evolution<'a> {
    /// Box of the variables; the reach does not matter.
    pub limits: &'a Limits,
    /// Where the first population is centred.
    pub start: &'a DVector<f64>,
    /// Points of the first population, ≥ 4; none for 4 + 3 ln n.
    pub population: Option<usize>,
    /// Evaluations of the cost not to exceed. It may be raised for a run that is resumed.
    pub budget: u64,
    /// A population whose costs differ by less has converged, and another begins elsewhere.
    pub tolerance: f64,
    /// Seed: every generation has its own stream of it.
    pub seed: u64,
    /// Who looks on and may stop it.
    pub watch: Watch,
}

/// All that the next generation follows from: what a journal keeps of each. Vectors are in parts of
/// the box.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Generation {
    number: u64,
    evaluations: u64,
    failures: u64,
    /// Best point so far, in variables, and what it is worth.
    best: Option<(Vec<f64>, Cost)>,
    /// Costs at which populations have converged.
    ends: Vec<f64>,
    descent: Descent,
}

/// One population on its way down.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
struct Descent {
    /// Points in a generation.
    size: usize,
    /// Generations so far.
    age: u64,
    mean: Vec<f64>,
    /// Step length σ.
    deviation: f64,
    /// C, column by column.
    covariance: Vec<f64>,
    /// p_c
    path: Vec<f64>,
    /// p_σ
    conjugate_path: Vec<f64>,
    /// Best cost of each of the last generations.
    recent: Vec<f64>,
}

/// How a descent goes on after a generation.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Course {
    Down,
    Converged,
    Stuck,
}

impl Descent {
    fn new(mean: Vec<f64>, size: usize) -> Self {
        let n = mean.len();
        Self {
            size,
            age: 0,
            deviation: FIRST_DEVIATION,
            covariance: DMatrix::<f64>::identity(n, n).as_slice().to_vec(),
            path: vec![0.0; n],
            conjugate_path: vec![0.0; n],
            recent: Vec::new(),
            mean,
        }
    }

    /// B D, whose columns are the axes of the population; then B.
    fn axes(&self) -> (DMatrix<f64>, DMatrix<f64>) {
        let n = self.mean.len();
        let covariance = DMatrix::from_column_slice(n, n, &self.covariance);
        let eigen = SymmetricEigen::new(covariance);
        let lengths = eigen.eigenvalues.map(|l| l.max(0.0).sqrt());
        let axes = &eigen.eigenvectors * DMatrix::from_diagonal(&lengths);
        (axes, eigen.eigenvectors)
    }

    /// Moves the population by its steps, (z, y = B D z), the best first, the directions of the
    /// axes in `turn`. Numbers in brackets are equations of Hansen 2016.
    fn adapt(&mut self, steps: &[(DVector<f64>, DVector<f64>)], turn: &DMatrix<f64>) {
        let n = self.mean.len() as f64;
        let parents = self.size / 2;
        let raw: Vec<f64> = (1..=parents)
            .map(|i| (0.5 * (self.size as f64 + 1.0)).ln() - (i as f64).ln())
            .collect();
        let total: f64 = raw.iter().sum();
        let weights: Vec<f64> = raw.iter().map(|w| w / total).collect();
        let mass = 1.0 / weights.iter().map(|w| w * w).sum::<f64>();
        // (55)–(58)
        let c_sigma = (mass + 2.0) / (n + mass + 5.0);
        let damping = 1.0 + 2.0 * (((mass - 1.0) / (n + 1.0)).sqrt() - 1.0).max(0.0) + c_sigma;
        let c_c = (4.0 + mass / n) / (n + 4.0 + 2.0 * mass / n);
        let c_1 = 2.0 / ((n + 1.3).powi(2) + mass);
        let c_mu = (1.0 - c_1).min(2.0 * (mass - 2.0 + 1.0 / mass) / ((n + 2.0).powi(2) + mass));
        let normal = n.sqrt() * (1.0 - 1.0 / (4.0 * n) + 1.0 / (21.0 * n * n));

        let zero = DVector::zeros(self.mean.len());
        let (z, y) = steps
            .iter()
            .zip(&weights)
            .fold((zero.clone(), zero), |(sum_z, sum_y), ((z, y), w)| {
                (sum_z + *w * z, sum_y + *w * y)
            });
        let mean = DVector::from_column_slice(&self.mean) + self.deviation * &y; // (42)
        let conjugate_path = (1.0 - c_sigma) * DVector::from_column_slice(&self.conjugate_path)
            + (c_sigma * (2.0 - c_sigma) * mass).sqrt() * (turn * z); // (43)
        let length = conjugate_path.norm();
        let deviation = self.deviation
            * ((c_sigma / damping) * (length / normal - 1.0))
                .min(1.0)
                .exp(); // (44)
        let forgotten = 1.0 - (1.0 - c_sigma).powf(2.0 * (self.age as f64 + 1.0));
        let steady = length / forgotten.sqrt() < (1.4 + 2.0 / (n + 1.0)) * normal;
        let h = if steady { 1.0 } else { 0.0 };
        let path = (1.0 - c_c) * DVector::from_column_slice(&self.path)
            + h * (c_c * (2.0 - c_c) * mass).sqrt() * &y; // (45)
        let old = DMatrix::from_column_slice(self.mean.len(), self.mean.len(), &self.covariance);
        let kept = 1.0 - c_1 - c_mu + (1.0 - h) * c_1 * c_c * (2.0 - c_c);
        let rank_mu = steps.iter().zip(&weights).fold(
            DMatrix::zeros(old.nrows(), old.ncols()),
            |sum, ((_, y), w)| sum + *w * y * y.transpose(),
        );
        let covariance = kept * old + c_1 * &path * path.transpose() + c_mu * rank_mu; // (47)

        self.mean = mean.as_slice().to_vec();
        self.conjugate_path = conjugate_path.as_slice().to_vec();
        self.path = path.as_slice().to_vec();
        // a population wider than the box sees it several times over and nothing else
        let widest = covariance.diagonal().amax().sqrt();
        self.deviation = deviation.min(1.0 / widest);
        self.covariance = covariance.as_slice().to_vec();
        self.age += 1;
    }

    /// How it goes on after a generation of `costs`, the best first.
    fn course(&mut self, costs: &[Cost], axes: &DMatrix<f64>, tolerance: f64) -> Course {
        let n = self.mean.len();
        let (best, worst) = (costs[0], costs[costs.len() - 1]);
        // Hansen 2016, appendix B.3
        let window = 10 + (30.0 * n as f64 / self.size as f64).ceil() as usize;
        self.recent.push(best.value());
        if self.recent.len() > window {
            self.recent.remove(0);
        }
        let lengths = axes.column_iter().map(|axis| axis.norm());
        let (short, long) = lengths.fold((f64::INFINITY, 0.0_f64), |(short, long), l| {
            (short.min(l), long.max(l))
        });
        let range = |costs: &[f64]| {
            let least = costs.iter().copied().fold(f64::INFINITY, f64::min);
            costs.iter().copied().fold(f64::NEG_INFINITY, f64::max) - least
        };
        let settled = self.recent.len() == window
            && range(&self.recent) < tolerance
            && worst.value() - best.value() < tolerance;
        if !best.failed() && (settled || self.deviation * long < POINT) {
            return Course::Converged;
        }
        let old = 100 + (50.0 * (n as f64 + 3.0).powi(2) / (self.size as f64).sqrt()) as u64;
        if best == worst || long > CONDITION.sqrt() * short || self.age > old {
            return Course::Stuck;
        }
        Course::Down
    }
}

/// A coordinate of the unfolded landscape in the box [0, 1].
fn folded(u: f64) -> f64 {
    let u = u.rem_euclid(2.0);
    if u > 1.0 { 2.0 - u } else { u }
}

/// What a population needs of a problem: the worth of many points at once, in their order.
type Costs<'a> = dyn Fn(&[DVector<f64>]) -> Vec<Cost> + Sync + 'a;

/// The solver.
struct CovarianceAdaptation<'a> {
    plan: &'a Evolution<'a>,
    journal: &'a Journal<Generation>,
    generation: Generation,
}

impl CovarianceAdaptation<'_> {
    /// A point of the unfolded landscape in variables.
    fn variables(&self, unfolded: &DVector<f64>) -> DVector<f64> {
        let Limits { lower, upper, .. } = self.plan.limits;
        DVector::from_fn(lower.len(), |i, _| {
            let z = lower[i] + (upper[i] - lower[i]) * folded(unfolded[i]);
            z.clamp(lower[i], upper[i])
        })
    }

    /// `state` where the search stands: at the best so far, the start before there is one.
    fn standing<H>(&self, state: Here<H>) -> Here<H> {
        match &self.generation.best {
            Some((point, cost)) => state
                .param(DVector::from_column_slice(point))
                .cost(cost.value()),
            None => state.param(self.plan.start.clone()).cost(f64::MAX),
        }
    }

    /// Whether another generation would exceed the budget.
    fn spent(&self) -> bool {
        let Generation {
            evaluations,
            descent,
            ..
        } = &self.generation;
        evaluations + descent.size as u64 > self.plan.budget
    }
}

impl<'a> Solver<&'a Costs<'a>, Here<()>> for CovarianceAdaptation<'a> {
    fn name(&self) -> &'static str {
        "covariance matrix adaptation"
    }

    fn init(&mut self, problem: &mut Problem<&'a Costs<'a>>, state: Here<()>) -> Iteration<()> {
        // a resumed run has evaluated what its journal says
        problem
            .counts
            .insert("cost_count", self.generation.evaluations);
        Ok((self.standing(state), None))
    }

    fn next_iter(
        &mut self,
        problem: &mut Problem<&'a Costs<'a>>,
        state: Here<()>,
    ) -> Iteration<()> {
        let mut next = self.generation.clone();
        let mut rng = stream(self.plan.seed, next.number);
        let (axes, turn) = next.descent.axes();
        let mean = DVector::from_column_slice(&next.descent.mean);
        let steps: Vec<(DVector<f64>, DVector<f64>)> = (0..next.descent.size)
            .map(|_| {
                let z = DVector::from_fn(mean.len(), |_, _| StandardNormal.sample(&mut rng));
                let y = &axes * &z;
                (z, y)
            })
            .collect();
        let points: Vec<DVector<f64>> = steps
            .iter()
            .map(|(_, y)| self.variables(&(&mean + next.descent.deviation * y)))
            .collect();
        let costs = problem.bulk_problem("cost_count", points.len(), |costs| Ok(costs(&points)))?;
        assert_eq!(costs.len(), points.len(), "one cost a point");
        if self.plan.watch.stopped() {
            // a stop cuts searches within the costs short: this generation is made anew
            return Ok((self.standing(state), None));
        }

        let mut order: Vec<usize> = (0..costs.len()).collect();
        order.sort_by_key(|&i| costs[i]);
        let ranked: Vec<Cost> = order.iter().map(|&i| costs[i]).collect();
        let steps: Vec<_> = order.iter().map(|&i| steps[i].clone()).collect();
        if next.best.as_ref().is_none_or(|(_, best)| ranked[0] < *best) {
            next.best = Some((points[order[0]].as_slice().to_vec(), ranked[0]));
        }
        next.number += 1;
        next.evaluations += costs.len() as u64;
        next.failures += costs.iter().filter(|cost| cost.failed()).count() as u64;
        next.descent.adapt(&steps, &turn);
        let course = next.descent.course(&ranked, &axes, self.plan.tolerance);
        if course == Course::Converged {
            next.ends.push(ranked[0].value());
        }
        if course != Course::Down {
            let anywhere = (0..mean.len()).map(|_| rng.random()).collect();
            next.descent = Descent::new(anywhere, 2 * next.descent.size);
        }
        self.generation = self.journal.put(next.number, &next)?;
        Ok((self.standing(state), None))
    }

    fn terminate(&mut self, _: &Here<()>) -> TerminationStatus {
        let why = if self.spent() {
            "the budget is used"
        } else if self.plan.watch.stopped() {
            STOPPED
        } else {
            return TerminationStatus::NotTerminated;
        };
        TerminationStatus::Terminated(TerminationReason::SolverExit(why.into()))
    }
}

/// Usual size of a generation in `n` variables (Hansen 2016).
pub fn generation(n: usize) -> usize {
    4 + (3.0 * (n as f64).ln()) as usize
}

/// Searches the whole box for the least cost, until the budget is used: `costs` gives the worth of
/// the points of a generation, and may do so in any way that depends on nothing else. The outcome
/// is converged if a population has converged to its cost within a thousandth. Each generation is in
/// `journal`; a run that finds some there continues behind the last, as if never interrupted.
pub fn evolve(
    costs: &(dyn Fn(&[DVector<f64>]) -> Vec<Cost> + Sync),
    plan: &Evolution,
    journal: &Journal<Generation>,
) -> Result<Outcome> {
    let generation = match journal.last() {
        Some((_, generation)) => generation,
        None => first(plan),
    };
    let solver = CovarianceAdaptation {
        plan,
        journal,
        generation,
    };
    let observer = Observer {
        watch: plan.watch.clone(),
        budget: Some(plan.budget),
    };
    let costs: &Costs = costs;
    let result = Executor::new(costs, solver)
        .configure(|state| state.counting(true))
        .add_observer(observer, ObserverMode::Always)
        .run()
        .map_err(ours)?;
    let (state, solver) = (result.state, result.solver);
    let Generation {
        number,
        failures,
        best,
        ends,
        ..
    } = &solver.generation;
    let cost = best.as_ref().map_or(f64::MAX, |(_, cost)| cost.value());
    let arrived = ends
        .iter()
        .filter(|&&end| end - cost <= super::SAME_COST)
        .count();
    let spent = solver.spent();
    Ok(Outcome {
        point: state.get_best_param().expect("the start at least").clone(),
        cost,
        termination: match (spent, count(&state, "cost_count"), ends.len()) {
            (false, ..) => STOPPED.into(),
            (true, evaluations, 0) => {
                format!("after {evaluations} evaluations, before a population had converged")
            }
            (true, evaluations, all) => format!(
                "after {evaluations} evaluations: {arrived} of {all} populations that converged \
                 ended at the least cost"
            ),
        },
        converged: arrived > 0,
        stopped: !spent,
        iterations: *number,
        cost_evaluations: count(&state, "cost_count"),
        curvature_evaluations: 0,
        failures: *failures,
    })
}

/// What the first generation follows from.
fn first(plan: &Evolution) -> Generation {
    let Limits { lower, upper, .. } = plan.limits;
    let n = lower.len();
    let mean = (0..n).map(|i| {
        let width = upper[i] - lower[i];
        if width > 0.0 {
            ((plan.start[i] - lower[i]) / width).clamp(0.0, 1.0)
        } else {
            0.0
        }
    });
    Generation {
        number: 0,
        evaluations: 0,
        failures: 0,
        best: None,
        ends: Vec::new(),
        descent: Descent::new(
            mean.collect(),
            plan.population.unwrap_or(generation(n)).max(4),
        ),
    }
}

#[cfg(test)]
mod tests;
