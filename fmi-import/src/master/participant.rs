//! What can take part.

use crate::{Error, Step};
use model_description::Unit;

/// Which way values go.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Direction {
    /// Into the participant.
    Input,
    /// Out of it.
    Output,
    /// For looking at only.
    Other,
}

/// Of what type values are; they travel as numbers.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Kind {
    /// A real number.
    Real,
    /// A whole number; an enumeration too.
    Integer,
    /// 0 or 1.
    Boolean,
}

impl Kind {
    /// As FMI calls it.
    pub fn name(self) -> &'static str {
        match self {
            Self::Real => "Real",
            Self::Integer => "Integer",
            Self::Boolean => "Boolean",
        }
    }
}

/// A variable that can be connected or recorded.
#[derive(Clone, Debug, PartialEq)]
pub struct Port {
    /// Its name.
    pub name: String,
    /// Which way its values go.
    pub direction: Direction,
    /// Of what type they are.
    pub kind: Kind,
    /// Their unit, where one is stated.
    pub unit: Option<Unit>,
    /// For an output the numbers of the inputs it depends on at a communication point; none where
    /// nobody says: it may be all of them.
    pub depends_on: Option<Vec<usize>>,
    /// The size that an error is measured by, in its unit.
    pub nominal: f64,
}

/// Something that goes on in time between communication points: an FMU or a native model.
///
/// Ports are named by their place in [`Participant::ports`].
pub trait Participant {
    /// What can be connected or recorded.
    fn ports(&self) -> &[Port];

    /// Makes ready for `start`; `stop` \[s\] is where the run ends.
    fn enter_initialization(&mut self, start: f64, stop: f64) -> Result<(), Error>;

    /// Initial values are exchanged.
    fn exit_initialization(&mut self) -> Result<(), Error>;

    /// Reads ports.
    fn read(&mut self, ports: &[usize], values: &mut [f64]) -> Result<(), Error>;

    /// Sets inputs.
    fn write(&mut self, ports: &[usize], values: &[f64]) -> Result<(), Error>;

    /// Goes on from `point` by `h`, both in s, its inputs held.
    fn step(&mut self, point: f64, h: f64) -> Result<Step, Error>;

    /// Whether a step may be of another length than the one before.
    fn can_vary_step(&self) -> bool;

    /// Whether it can go back to a state.
    fn can_keep(&self) -> bool;

    /// Keeps its state, in place of what it kept before.
    fn keep(&mut self) -> Result<(), Error>;

    /// Goes back to the state it kept.
    fn go_back(&mut self) -> Result<(), Error>;

    /// The run is over, and has not failed.
    fn terminate(&mut self) -> Result<(), Error>;
}
