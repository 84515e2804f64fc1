//! The safe life cycle of one instance.

use crate::variables::Variables;
use crate::{Error, Flow, Function, Model, State, Value};
use model_description::ModelDescription;

/// What `fmi2SetupExperiment` said.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Experiment {
    /// Start time [s].
    pub start_time: f64,
    /// Time beyond which no step may go [s].
    pub stop_time: Option<f64>,
    /// Relative tolerance wished for.
    pub tolerance: Option<f64>,
}

/// A Rust type that carries values through the interface.
pub trait Scalar: Clone {
    /// The FMI types it stands for; the first names the functions.
    const TYPES: &'static [&'static str];
    /// The function that reads it.
    const GET: Function;
    /// The function that writes it.
    const SET: Function;
    /// As a value of any type.
    fn into_value(self) -> Value;
    /// Back, if it is of this type.
    fn from_value(value: Value) -> Result<Self, Value>;
}

macro_rules! scalar {
    ($($type:ty as $variant:ident, $types:expr, $get:ident, $set:ident;)*) => {
        $(
            impl Scalar for $type {
                const TYPES: &'static [&'static str] = &$types;
                const GET: Function = Function::$get;
                const SET: Function = Function::$set;
                fn into_value(self) -> Value {
                    Value::$variant(self)
                }
                fn from_value(value: Value) -> Result<Self, Value> {
                    match value {
                        Value::$variant(value) => Ok(value),
                        other => Err(other),
                    }
                }
            }
        )*
    };
}

scalar! {
    f64 as Real, ["Real"], GetReal, SetReal;
    i32 as Integer, ["Integer", "Enumeration"], GetInteger, SetInteger;
    bool as Boolean, ["Boolean"], GetBoolean, SetBoolean;
    String as String, ["String"], GetString, SetString;
}

/// One instance of a model in its life cycle.
///
/// A call that returns an error has changed nothing, with one exception: [`Error::Ended`].
#[derive(Clone, Debug)]
pub struct Instance<M> {
    model: M,
    state: State,
    variables: Variables,
    experiment: Option<Experiment>,
    /// End of the last successful step [s].
    time: f64,
    /// A value was set since the model was initialised.
    stale: bool,
    /// The model came to its end.
    ended: bool,
}

impl<M: Model> Instance<M> {
    /// An instance in the state right after `fmi2Instantiate`.
    pub fn new(description: &ModelDescription) -> Result<Self, Error> {
        Ok(Self {
            model: M::new(),
            state: State::Instantiated,
            variables: Variables::new(description)?,
            experiment: None,
            time: 0.0,
            stale: true,
            ended: false,
        })
    }

    /// The state.
    pub fn state(&self) -> State {
        self.state
    }

    /// Refuses `function` where the table does.
    pub fn permit(&self, function: Function) -> Result<(), Error> {
        if function.is_legal_in(self.state) {
            Ok(())
        } else {
            Err(Error::NotAllowed {
                function: function.name,
                state: self.state,
            })
        }
    }

    /// Takes start time, stop time and tolerance.
    pub fn setup_experiment(&mut self, experiment: Experiment) -> Result<(), Error> {
        self.permit(Function::SetupExperiment)?;
        let refuse = |what, expected: String, found| {
            Err(Error::Experiment {
                what,
                expected,
                found,
            })
        };
        let start = experiment.start_time;
        if !start.is_finite() {
            return refuse("start time", "a finite time".to_owned(), start);
        }
        if let Some(stop) = experiment.stop_time
            && !(stop.is_finite() && stop > start)
        {
            let expected = format!("a finite time after the start at {start} s");
            return refuse("stop time", expected, stop);
        }
        if let Some(tolerance) = experiment.tolerance
            && !(tolerance.is_finite() && tolerance > 0.0)
        {
            return refuse("tolerance", "a positive number".to_owned(), tolerance);
        }
        self.experiment = Some(experiment);
        self.time = start;
        Ok(())
    }

    /// Enters initialization mode.
    pub fn enter_initialization_mode(&mut self) -> Result<(), Error> {
        self.permit(Function::EnterInitializationMode)?;
        if self.experiment.is_none() {
            return Err(Error::NoExperiment);
        }
        self.state = State::Initialization;
        Ok(())
    }

    /// Leaves initialization mode; the model is at the start time.
    pub fn exit_initialization_mode(&mut self) -> Result<(), Error> {
        self.permit(Function::ExitInitializationMode)?;
        self.initialize()?;
        self.state = State::StepComplete;
        Ok(())
    }

    fn initialize(&mut self) -> Result<(), Error> {
        let experiment = self.experiment.ok_or(Error::NoExperiment)?;
        if self.stale {
            self.model.initialize(&experiment).map_err(Error::Model)?;
            self.stale = false;
        }
        Ok(())
    }

    /// Ends the simulation.
    pub fn terminate(&mut self) -> Result<(), Error> {
        self.permit(Function::Terminate)?;
        self.state = State::Terminated;
        Ok(())
    }

    /// Back to the state right after instantiation.
    pub fn reset(&mut self) -> Result<(), Error> {
        self.permit(Function::Reset)?;
        self.model = M::new();
        self.state = State::Instantiated;
        self.experiment = None;
        self.time = 0.0;
        self.stale = true;
        self.ended = false;
        Ok(())
    }

    /// Reads variables. In initialization mode, computed ones follow what was set so far.
    pub fn get<T: Scalar>(&mut self, references: &[u32], values: &mut [T]) -> Result<(), Error> {
        self.permit(T::GET)?;
        same_length(references, values)?;
        let mut computed = false;
        for &reference in references {
            self.variables.check_get(reference, T::TYPES)?;
            computed |= self.variables.is_computed(reference);
        }
        if self.state == State::Initialization && computed {
            self.initialize()?;
        }
        for (&reference, value) in references.iter().zip(values) {
            *value = T::from_value(self.model.get(reference))
                .map_err(|found| self.variables.mistyped(reference, &found))?;
        }
        Ok(())
    }

    /// Sets variables: all of them, or on an error none.
    pub fn set<T: Scalar>(&mut self, references: &[u32], values: &[T]) -> Result<(), Error> {
        self.permit(T::SET)?;
        same_length(references, values)?;
        for (&reference, value) in references.iter().zip(values) {
            let value = value.clone().into_value();
            self.variables
                .check_set(reference, T::TYPES, &value, self.state)?;
        }
        for (&reference, value) in references.iter().zip(values) {
            self.model.set(reference, value.clone().into_value());
        }
        self.stale = true;
        Ok(())
    }

    /// Goes on from `point`, which must be the present time, by `h` > 0, both [s].
    pub fn do_step(&mut self, point: f64, h: f64) -> Result<(), Error> {
        self.permit(Function::DoStep)?;
        let refuse = |what, expected: String, found| {
            Err(Error::Experiment {
                what,
                expected,
                found,
            })
        };
        if !(h.is_finite() && h > 0.0) {
            let expected = "a finite positive time".to_owned();
            return refuse("communication step size", expected, h);
        }
        let apart = (point - self.time).abs();
        if !point.is_finite() || apart > round_off(point.abs().max(self.time.abs())) {
            let expected = format!("{} s, the end of the last step", self.time);
            return refuse("communication point", expected, point);
        }
        let end = point + h;
        // An importer that adds up its steps drifts by far less than a millionth of one.
        if let Some(stop) = self.experiment.and_then(|experiment| experiment.stop_time)
            && end > stop + 1e-6 * h + round_off(stop.abs())
        {
            let expected = format!("no step beyond the stop time {stop} s");
            return refuse("end of the communication step", expected, end);
        }
        match self.model.step(point, h) {
            Flow::Continue => {
                self.time = end;
                Ok(())
            }
            Flow::Terminate { at, why } => {
                self.time = at;
                self.state = State::StepFailed;
                self.ended = true;
                Err(Error::Ended { at, why })
            }
            Flow::Refuse(why) => Err(Error::Model(why)),
        }
    }

    /// End of the last successful step [s].
    pub fn last_successful_time(&self) -> Result<f64, Error> {
        self.permit(Function::GetRealStatus)?;
        Ok(self.time)
    }

    /// Whether the model came to its end.
    pub fn terminated(&self) -> Result<bool, Error> {
        self.permit(Function::GetBooleanStatus)?;
        Ok(self.ended)
    }
}

fn same_length<T>(references: &[u32], values: &[T]) -> Result<(), Error> {
    if references.len() == values.len() {
        Ok(())
    } else {
        Err(Error::Length {
            references: references.len(),
            values: values.len(),
        })
    }
}

/// What two ways of computing a time of this magnitude may differ by: start + n·h, or a sum, or a
/// unit conversion differ in the last few bits.
fn round_off(magnitude: f64) -> f64 {
    64.0 * f64::EPSILON * magnitude
}
