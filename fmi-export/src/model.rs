//! What a model must be able to do.

use crate::instance::Experiment;
use model_description::ModelDescription;

/// A model that can be exported.
///
/// A value is set only after [`crate::Instance`] has checked that the variable exists, has that
/// type, may be set in this state, and that the value is finite and in the range the description
/// gives.
pub trait Model: Clone + Send + 'static {
    /// What modelDescription.xml says, apart from the guid, which is its fingerprint. Variable `i`
    /// (from 0) has value reference `i`.
    fn description() -> ModelDescription;

    /// The model with the start values of the description.
    fn new() -> Self;

    /// The value of variable `reference`, as the values set so far make it. Called after
    /// [`Model::initialize`], except for variables with a start value.
    fn get(&self, reference: u32) -> Value;

    /// Sets variable `reference`; acts from the present time on.
    fn set(&mut self, reference: u32, value: Value);

    /// Computes the state at the start time from the values set so far. May be called again,
    /// and then starts anew. On an error, in words, other values may be set and the call repeated.
    fn initialize(&mut self, experiment: &Experiment) -> Result<(), String>;

    /// Goes on from time `t` to exactly `t + h`, both in s, h > 0.
    fn step(&mut self, t: f64, h: f64) -> Flow;
}

/// A value of any of the five types; an enumeration travels as its integer.
#[derive(Clone, Debug, PartialEq)]
pub enum Value {
    /// `Real`
    Real(f64),
    /// `Integer` or `Enumeration`
    Integer(i32),
    /// `Boolean`
    Boolean(bool),
    /// `String`
    String(String),
}

/// How a step went.
#[derive(Clone, Debug, PartialEq)]
pub enum Flow {
    /// It arrived at t + h.
    Continue,
    /// The model has come to its end on the way: it stays at time `at` [s], where its values can
    /// be read.
    Terminate {
        /// The last time with a state [s].
        at: f64,
        /// The reason, in words.
        why: String,
    },
    /// The step was not begun, for the reason given; the state is as before.
    Refuse(String),
}
