//! What can be seen of a simulation where it has arrived.

use super::{Simulation, jump};
use crate::quantity::Quantity;
use crate::sensitivity;
use crate::state::{Output, Path, State};

/// Where the number of an output row is to be found.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Place {
    /// A row of the state, where the formulation moves it.
    State(usize),
    /// A row of the path.
    Path(usize),
    /// With the bicycle's constants.
    FrontLoad,
    /// Nowhere: it takes an evaluation of the equations.
    Equations,
}

/// The place of each output row: one called as a row of state or path is that row.
const PLACES: [Place; Output::LEN] = {
    let front_load = Output::index("front_load").expect("an output");
    let mut places = [Place::Equations; Output::LEN];
    let mut row = 0;
    while row < Output::LEN {
        let Quantity { name, .. } = Output::TABLE[row];
        if let Some(i) = State::index(name) {
            places[row] = Place::State(i);
        } else if let Some(i) = Path::index(name) {
            places[row] = Place::Path(i);
        } else if row == front_load {
            places[row] = Place::FrontLoad;
        }
        row += 1;
    }
    places
};

impl Simulation {
    /// Where we are [s].
    pub fn time(&self) -> f64 {
        self.here.time
    }

    /// The state there.
    pub fn state(&self) -> &State {
        &self.here.state
    }

    /// The path up to there.
    pub fn path(&self) -> &Path {
        &self.here.path
    }

    /// Everything that can be seen there.
    pub fn output(&self) -> Output {
        jump::output(&self.bicycle, self.state(), self.path(), &self.input())
    }

    /// Row `row` of [`Self::output`] where it can be had without evaluating the equations: the rows
    /// of state and path, and the front load. `None` for every other row of the table.
    pub fn output_row(&self, row: usize) -> Option<f64> {
        match PLACES[row] {
            Place::State(i) if i < self.bicycle.order() => Some(self.here.state.get(i)),
            Place::Path(i) => Some(self.here.path.get(i)),
            Place::FrontLoad => Some(self.bicycle.front_load),
            Place::State(_) | Place::Equations => None,
        }
    }

    /// Time derivative of [`Self::output`], each row in its unit per second, with the inputs on
    /// their present slopes.
    pub fn output_rate(&self) -> Output {
        sensitivity::output_rate(
            &self.bicycle,
            self.state(),
            self.path(),
            &self.input(),
            self.input_slope(),
        )
    }
}
