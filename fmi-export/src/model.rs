//! What a model must be able to do.

use crate::Experiment;
use model_description::ModelDescription;
use serde::Serialize;
use serde::de::DeserializeOwned;

/// A model that can be exported.
///
/// A value is set only after [`crate::Instance`] has checked that the variable exists, has that
/// type, may be set in this state, and that the value is finite and in the range the description
/// gives.
///
/// `Clone` is what saves and restores a state; `Serialize` and `Deserialize` carry it to another
/// process. So a clone must go on exactly as the original would, and deserialising must refuse
/// what no model could have become (`#[serde(try_from = "…")]`): bytes come from outside. Values
/// of variables that can be set are checked against the description in any case.
pub trait Model: Clone + Send + Serialize + DeserializeOwned + 'static {
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

    /// Σ ∂unknown/∂known · seed over `known`, pairs of a value reference and its seed, for each
    /// value reference in `unknown`: in initialization mode of initial unknowns by parameters and
    /// inputs, later of outputs and state derivatives by inputs and states (FMI 2.0 §2.1.9).
    ///
    /// A model that declares `providesDirectionalDerivative` overrides this.
    fn directional_derivative(&self, unknown: &[u32], known: &[(u32, f64)]) -> Vec<f64> {
        let _ = (unknown, known);
        panic!("providesDirectionalDerivative is declared, the method is not there")
    }

    /// From the present time on the `Real` input `reference` changes by `slope` a second, until
    /// its slope is set anew; a value set meanwhile moves the ramp.
    ///
    /// A model that declares `canInterpolateInputs` overrides this.
    fn set_input_slope(&mut self, reference: u32, slope: f64) {
        let _ = (reference, slope);
        panic!("canInterpolateInputs is declared, the method is not there")
    }

    /// The time derivative of the `Real` output `reference` \[its unit per s\].
    ///
    /// A model that declares `maxOutputDerivativeOrder` 1 overrides this.
    fn output_rate(&self, reference: u32) -> f64 {
        let _ = reference;
        panic!("maxOutputDerivativeOrder is declared, the method is not there")
    }
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

/// What the functions of the interface tell apart: an enumeration is an integer.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Kind {
    /// `Real`
    Real,
    /// `Integer` and `Enumeration`
    Integer,
    /// `Boolean`
    Boolean,
    /// `String`
    String,
}

impl Value {
    /// Which functions carry it.
    pub fn kind(&self) -> Kind {
        match self {
            Self::Real(_) => Kind::Real,
            Self::Integer(_) => Kind::Integer,
            Self::Boolean(_) => Kind::Boolean,
            Self::String(_) => Kind::String,
        }
    }

    /// The number that a range can be asked of.
    pub(crate) fn number(&self) -> Option<f64> {
        match *self {
            Self::Real(value) => Some(value),
            Self::Integer(value) => Some(value.into()),
            Self::Boolean(_) | Self::String(_) => None,
        }
    }
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
