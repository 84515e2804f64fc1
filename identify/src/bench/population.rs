//! A global search over simulated rides.

use crate::checkpoint::Journal;
use crate::error::Result;
use crate::model::{Model, SEEDS_PER_RIDE, Seeds};
use crate::objective::Objective;
use crate::plan::Plan;
use crate::problem::Problem;
use crate::progress::Watch;
use crate::ride::Ride;
use crate::solver::{Evolution, Generation, Outcome, evolve};

/// Rides that are simulated.
pub const RIDES: usize = 3600;

/// Candidates of a generation: with their seeds one batch.
const POPULATION: usize = 25;

/// Searches the box of damping and intensity for `ride` by amplitude, with [`RIDES`] rides as long.
pub fn search(ride: &Ride) -> Result<Outcome> {
    let plan = Plan {
        objective: Some(Objective::Amplitude),
        channels: Some(vec!["steer"]),
        model: Model::Simulated(Seeds {
            count: None,
            seed: 1000,
        }),
        ..Plan::default()
    };
    let problem = Problem::new(&[plan.ridden(ride)], &plan)?;
    let evolution = Evolution {
        limits: &problem.limits(),
        start: &problem.start(),
        population: Some(POPULATION),
        budget: (RIDES / SEEDS_PER_RIDE) as u64,
        tolerance: 1e-6,
        seed: 1,
        watch: Watch::default(),
    };
    let costs = |points: &[_]| problem.costs(points);
    evolve(&costs, &evolution, &Journal::<Generation>::in_memory())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::synthesis::Synthesis;

    #[test]
    fn a_search_takes_as_many_rides_as_it_says() {
        // how long they are does not change how many
        let short = Synthesis {
            duration: 6.0,
            ..Synthesis::default()
        };
        let outcome = search(&short.ride().expect("upright")).expect("a search");
        let rides = outcome.cost_evaluations as usize * SEEDS_PER_RIDE;
        assert_eq!(rides, RIDES);
        assert_eq!(
            outcome.iterations as usize * POPULATION * SEEDS_PER_RIDE,
            RIDES
        );
        assert!(outcome.cost.is_finite());
    }
}
