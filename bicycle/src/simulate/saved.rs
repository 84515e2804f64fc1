//! A simulation as it is saved, and what is asked of one before it goes on.

use super::ramp::Ramp;
use super::stability::StableSpeeds;
use super::{Moment, Simulation, Stop, slack};
use crate::dynamics::{Bicycle, Formulation};
use crate::parameters::Parameters;
use serde::{Deserialize, Serialize};

/// What a simulation is made of, without what follows from it.
#[derive(Debug, Clone, Serialize, Deserialize)]
pub(super) struct Saved {
    parameters: Parameters,
    formulation: Formulation,
    ramp: Ramp,
    start_time: f64,
    base: Moment,
    base_on_grid: bool,
    next: u64,
    here: Moment,
    ahead: bool,
    stop: Option<Stop>,
    derivatives: u64,
}

impl From<Simulation> for Saved {
    fn from(simulation: Simulation) -> Self {
        Self {
            parameters: simulation.bicycle.p,
            formulation: simulation.bicycle.formulation,
            ramp: simulation.ramp,
            start_time: simulation.start_time,
            base: simulation.base,
            base_on_grid: simulation.base_on_grid,
            next: simulation.next,
            here: simulation.here,
            ahead: simulation.ahead,
            stop: simulation.stop,
            derivatives: simulation.derivatives,
        }
    }
}

impl TryFrom<Saved> for Simulation {
    type Error = String;

    /// Refuses rows outside their ranges, numbers and times that no simulation has.
    fn try_from(saved: Saved) -> Result<Self, String> {
        check_rows(&saved.parameters)?;
        let simulation = Self {
            bicycle: Bicycle::new(&saved.parameters, saved.formulation),
            stable: StableSpeeds::NONE,
            ramp: saved.ramp,
            start_time: saved.start_time,
            base: saved.base,
            base_on_grid: saved.base_on_grid,
            next: saved.next,
            here: saved.here,
            ahead: saved.ahead,
            stop: saved.stop,
            derivatives: saved.derivatives,
        };
        simulation.check_numbers()?;
        simulation.check_times()?;
        Ok(simulation)
    }
}

fn check_rows(parameters: &Parameters) -> Result<(), String> {
    for (row, value) in Parameters::TABLE.iter().zip(parameters.to_array()) {
        if !row.admits(value) {
            let (name, min, max, unit) = (row.name, row.min, row.max, row.unit.symbol);
            return Err(format!(
                "{name}: expected {min} to {max} {unit}, found {value} {unit}"
            ));
        }
    }
    Ok(())
}

impl Moment {
    fn numbers(&self) -> impl Iterator<Item = f64> {
        let (state, path) = (self.state.to_array(), self.path.to_array());
        [self.time].into_iter().chain(state).chain(path)
    }

    fn is_place_of(&self, other: &Self) -> bool {
        (self.state, self.path) == (other.state, other.path)
    }
}

impl Simulation {
    fn check_numbers(&self) -> Result<(), String> {
        let Ramp {
            value,
            slope,
            since,
        } = self.ramp;
        let inputs = value.to_array().into_iter().chain(slope.to_array());
        let mut numbers = [self.start_time, since]
            .into_iter()
            .chain(inputs)
            .chain(self.base.numbers())
            .chain(self.here.numbers());
        if let Some(odd) = numbers.find(|v| !v.is_finite()) {
            return Err(format!(
                "expected finite states, inputs and times, found {odd}"
            ));
        }
        // so that counting on cannot overflow
        if self.derivatives > u64::MAX / 2 {
            let found = self.derivatives;
            return Err(format!("expected fewer derivatives, found {found}"));
        }
        Ok(())
    }

    /// Whether the times are those that [`Simulation::advance`] leaves behind.
    fn check_times(&self) -> Result<(), String> {
        let (start, base, here) = (self.start_time, self.base.time, self.here.time);
        let step = self.bicycle.p.internal_step;
        let order = |holds: bool, expected: &str| {
            if holds {
                return Ok(());
            }
            Err(format!(
                "expected {expected}, found start {start} s, base {base} s, here {here} s, ramp \
                 since {} s, next grid point {} at steps of {step} s",
                self.ramp.since, self.next
            ))
        };
        // where times are too coarse for the grid, as good as endless steps lead to the next one
        let resolved = [start, base, here].iter().all(|t| slack(step, *t) < step);
        order(resolved, "times that tell internal steps apart")?;
        if let Some(stop) = self.stop {
            // nothing moves any more
            return order(stop.time() == here, "the time of the stop");
        }
        let last = self.next.checked_sub(1).map(|n| self.grid(n));
        let on_grid = last == Some(base);
        let after_grid = last.is_some_and(|last| last < base) && base < self.grid(self.next);
        let fits = if self.base_on_grid {
            on_grid
        } else {
            after_grid
        };
        order(fits, "the base on the grid or before its next point")?;
        let arrived = if self.ahead {
            base < here && here < self.grid(self.next)
        } else {
            // the sum of an instant and its slack rounds
            (here - base).abs() <= 2.0 * slack(step, here) && self.here.is_place_of(&self.base)
        };
        order(arrived, "an arrival before the next grid point")?;
        let since = self.ramp.since;
        order(
            start <= since && since <= self.instant(),
            "inputs that were set between start and now",
        )
    }
}
