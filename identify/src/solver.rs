//! Searches: the only module tree that names argmin, whose executor runs the loops, keeps the best
//! point and the counters and tells its observers. argmin has neither bounds nor
//! Levenberg–Marquardt nor a covariance adapting strategy: they are [solvers](argmin::core::Solver)
//! here. What they need of a problem is a [`Landscape`].

mod cost;
mod covariance_adaptation;
mod levenberg_marquardt;
mod multistart;
mod quadratic;

pub use cost::Cost;
pub use covariance_adaptation::{Evolution, Generation, evolve, generation};
pub use levenberg_marquardt::{Search, minimise};
pub use multistart::{Attempt, Searchable, Starts, multistart};
pub use quadratic::{Block, Quadratic, Reduced};

use crate::error::{self, Result};
use crate::progress::{Event, Watch};
use argmin::core::observers::Observe;
use argmin::core::{IterState, KV};
use nalgebra::DVector;
use rayon::prelude::*;
use serde::{Deserialize, Serialize};

/// What a search walks on: a cost and its local model, over the variables of the search.
pub trait Landscape: Sync {
    /// The cost at `z`; not finite where it cannot be computed.
    fn cost(&self, z: &DVector<f64>) -> f64;

    /// Gradient and curvature at a `z` of finite cost.
    fn quadratic(&self, z: &DVector<f64>) -> Result<Quadratic>;

    /// Number of variables behind the shared ones: those of the [blocks](Block).
    fn blocks(&self) -> usize {
        0
    }

    /// How far a `z` without a cost is from having one, ≥ 0: the growth rate of a mode that should
    /// decay, the part of a ride that a fall cuts off. The default knows no slope.
    fn excess(&self, _z: &DVector<f64>) -> f64 {
        0.0
    }

    /// What each of `points` is worth, all cores at work. An engine that computes many at once
    /// does it here.
    fn costs(&self, points: &[DVector<f64>]) -> Vec<Cost> {
        let worth = |z: &DVector<f64>| Cost::new(self.cost(z), || self.excess(z));
        points.par_iter().map(worth).collect()
    }
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

/// Where a search ended.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Outcome {
    /// The best point.
    #[serde(with = "numbers")]
    pub point: DVector<f64>,
    /// Its cost.
    pub cost: f64,
    /// Why the search ended, in words.
    pub termination: String,
    /// Whether that was convergence.
    pub converged: bool,
    /// Whether it was stopped from outside, and could have gone on.
    pub stopped: bool,
    /// Iterations, or generations.
    pub iterations: u64,
    /// Evaluations of the cost.
    pub cost_evaluations: u64,
    /// Evaluations of gradient and curvature.
    pub curvature_evaluations: u64,
    /// Those evaluations of the cost that found none: failed or diverged simulations.
    pub failures: u64,
}

/// Why a search ends that was asked to.
const STOPPED: &str = "stopped: asked to, with the best point so far";

/// argmin's state of a search over a vector with a local model `H`.
type Here<H> = IterState<DVector<f64>, (), (), H, (), f64>;

/// What one iteration of a solver of argmin gives.
type Iteration<H> = std::result::Result<(Here<H>, Option<KV>), argmin::core::Error>;

/// Costs that differ by less are the same: a likelihood ratio of e^0.001.
const SAME_COST: f64 = 1e-3;

/// A watch as an observer of argmin's executor: told of evaluations where there is a budget of
/// them, of iterations else.
struct Observer {
    watch: Watch,
    budget: Option<u64>,
}

impl<H> Observe<Here<H>> for Observer {
    fn observe_iter(
        &mut self,
        state: &Here<H>,
        _: &KV,
    ) -> std::result::Result<(), argmin::core::Error> {
        self.watch.tell(match self.budget {
            Some(of) => Event::Done {
                done: count(state, "cost_count"),
                of,
                best: Some(state.cost),
            },
            None => Event::Iteration {
                iteration: state.iter + 1,
                cost: state.cost,
            },
        });
        Ok(())
    }
}

/// An error that went through argmin.
fn ours(cause: argmin::core::Error) -> error::Error {
    match cause.downcast::<error::Error>() {
        Ok(ours) => ours,
        Err(other) => error::Error::Search(other.to_string()),
    }
}

/// How often `state` says that something was evaluated.
fn count<H>(state: &Here<H>, name: &str) -> u64 {
    state.counts.get(name).copied().unwrap_or(0)
}

/// A vector in a file: its numbers.
mod numbers {
    use nalgebra::DVector;
    use serde::{Deserialize, Deserializer, Serialize, Serializer};

    pub(super) fn serialize<S: Serializer>(z: &DVector<f64>, to: S) -> Result<S::Ok, S::Error> {
        z.as_slice().serialize(to)
    }

    pub(super) fn deserialize<'a, D: Deserializer<'a>>(from: D) -> Result<DVector<f64>, D::Error> {
        Vec::deserialize(from).map(DVector::from_vec)
    }
}

#[cfg(test)]
mod tests;
