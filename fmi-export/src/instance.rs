//! The safe life cycle of one instance.

use crate::class::Class;
use crate::experiment::refuse;
use crate::saved::{from_bytes, next, to_bytes};
use crate::{Error, Experiment, Flow, Function, Model, Scalar, State, Value};
use fmi2::fmi2FMUstate;
use serde::{Deserialize, Serialize};
use std::sync::Arc;

/// What changes in an instance: all of it is saved and restored.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub(crate) struct Snapshot<M> {
    model: M,
    state: State,
    experiment: Option<Experiment>,
    /// End of the last successful step [s].
    time: f64,
    /// A value was set since the model was initialised.
    stale: bool,
    /// The model came to its end.
    ended: bool,
    /// Value references of inputs that are ramps, with their slopes.
    slopes: Vec<(u32, f64)>,
}

/// One instance of a model in its life cycle.
///
/// A call that returns an error has changed nothing, with one exception: [`Error::Ended`].
#[derive(Debug)]
pub struct Instance<M: Model> {
    class: Arc<Class<M>>,
    /// Whose saved states are whose.
    number: usize,
    /// With the start values, for a reset.
    pristine: M,
    now: Snapshot<M>,
}

impl<M: Model> Instance<M> {
    /// An instance of the model with its compiled start values, in the state right after
    /// `fmi2Instantiate`.
    pub fn new() -> Result<Self, Error> {
        Ok(Self::of(Class::new()?, M::new()))
    }

    /// An instance that starts as `pristine` is.
    pub(crate) fn of(class: Arc<Class<M>>, pristine: M) -> Self {
        Self {
            number: next(),
            class,
            now: Snapshot::of(pristine.clone()),
            pristine,
        }
    }

    pub(crate) fn class(&self) -> &Class<M> {
        &self.class
    }

    /// The state.
    pub fn state(&self) -> State {
        self.now.state
    }

    /// Refuses `function` where the table does.
    #[inline]
    pub fn permit(&self, function: Function) -> Result<(), Error> {
        let state = self.now.state;
        if function.is_legal_in(state) {
            Ok(())
        } else {
            let function = function.name;
            Err(Error::NotAllowed { function, state })
        }
    }

    /// Takes start time, stop time and tolerance.
    pub fn setup_experiment(&mut self, experiment: Experiment) -> Result<(), Error> {
        self.permit(Function::SetupExperiment)?;
        experiment.check()?;
        self.now.experiment = Some(experiment);
        self.now.time = experiment.start_time;
        Ok(())
    }

    /// Enters initialization mode.
    pub fn enter_initialization_mode(&mut self) -> Result<(), Error> {
        self.permit(Function::EnterInitializationMode)?;
        if self.now.experiment.is_none() {
            return Err(Error::NoExperiment);
        }
        self.now.state = State::Initialization;
        Ok(())
    }

    /// Leaves initialization mode; the model is at the start time.
    pub fn exit_initialization_mode(&mut self) -> Result<(), Error> {
        self.permit(Function::ExitInitializationMode)?;
        self.initialize()?;
        self.now.state = State::StepComplete;
        Ok(())
    }

    fn initialize(&mut self) -> Result<(), Error> {
        let experiment = self.now.experiment.ok_or(Error::NoExperiment)?;
        if self.now.stale {
            let model = &mut self.now.model;
            model.initialize(&experiment).map_err(Error::Model)?;
            self.now.stale = false;
        }
        Ok(())
    }

    /// In initialization mode, what is computed follows what was set so far.
    fn refresh(&mut self) -> Result<(), Error> {
        if self.now.state == State::Initialization {
            self.initialize()?;
        }
        Ok(())
    }

    /// Ends the simulation.
    pub fn terminate(&mut self) -> Result<(), Error> {
        self.permit(Function::Terminate)?;
        self.now.state = State::Terminated;
        Ok(())
    }

    /// Back to the state right after instantiation.
    pub fn reset(&mut self) -> Result<(), Error> {
        self.permit(Function::Reset)?;
        self.now = Snapshot::of(self.pristine.clone());
        Ok(())
    }

    /// Reads variables. In initialization mode, computed ones follow what was set so far.
    pub fn get<T: Scalar>(&mut self, references: &[u32], values: &mut [T]) -> Result<(), Error> {
        self.permit(T::GET)?;
        same_length(references, values.len())?;
        let mut computed = false;
        for &reference in references {
            computed |= self.class.variables.check_get(reference, T::KIND)?;
        }
        if computed {
            self.refresh()?;
        }
        for (&reference, value) in references.iter().zip(values) {
            *value = T::from_value(self.now.model.get(reference))
                .map_err(|found| self.class.variables.mistyped(reference, &found))?;
        }
        Ok(())
    }

    /// Sets variables: all of them, or on an error none.
    pub fn set<T: Scalar>(&mut self, references: &[u32], values: &[T]) -> Result<(), Error> {
        self.permit(T::SET)?;
        same_length(references, values.len())?;
        let (variables, state) = (&self.class.variables, self.now.state);
        for (&reference, value) in references.iter().zip(values) {
            variables.check_set(reference, T::KIND, value.number(), state)?;
        }
        for (&reference, value) in references.iter().zip(values) {
            self.now.model.set(reference, value.clone().into_value());
        }
        self.now.stale = true;
        Ok(())
    }

    /// Lets inputs change by so much a second from now on: all of them, or on an error none.
    pub fn set_input_slopes(
        &mut self,
        references: &[u32],
        orders: &[i32],
        slopes: &[f64],
    ) -> Result<(), Error> {
        let function = Function::SetRealInputDerivatives;
        self.permit(function)?;
        provided(self.class.interpolates_inputs, function)?;
        same_length(references, orders.len())?;
        same_length(references, slopes.len())?;
        for ((&reference, &order), &slope) in references.iter().zip(orders).zip(slopes) {
            self.class.variables.check_slope(reference, order, slope)?;
        }
        for (&reference, &slope) in references.iter().zip(slopes) {
            self.now.model.set_input_slope(reference, slope);
            self.now.slopes.retain(|&(ramp, _)| ramp != reference);
            if slope != 0.0 {
                self.now.slopes.push((reference, slope));
            }
        }
        self.now.stale = true;
        Ok(())
    }

    /// Time derivatives of outputs.
    pub fn output_rates(
        &mut self,
        references: &[u32],
        orders: &[i32],
        rates: &mut [f64],
    ) -> Result<(), Error> {
        let function = Function::GetRealOutputDerivatives;
        self.permit(function)?;
        provided(self.class.output_derivative_order > 0, function)?;
        same_length(references, orders.len())?;
        same_length(references, rates.len())?;
        for (&reference, &order) in references.iter().zip(orders) {
            self.class.variables.check_rate(reference, order)?;
        }
        for (&reference, rate) in references.iter().zip(rates) {
            *rate = self.now.model.output_rate(reference);
        }
        Ok(())
    }

    /// Σ ∂unknown/∂known · seed over the known variables.
    pub fn directional_derivative(
        &mut self,
        unknown: &[u32],
        known: &[u32],
        seeds: &[f64],
        derivatives: &mut [f64],
    ) -> Result<(), Error> {
        let function = Function::GetDirectionalDerivative;
        self.permit(function)?;
        provided(self.class.differentiates, function)?;
        same_length(known, seeds.len())?;
        same_length(unknown, derivatives.len())?;
        let (variables, state) = (&self.class.variables, self.now.state);
        for &reference in unknown {
            variables.check_unknown(reference, state)?;
        }
        for &reference in known {
            variables.check_known(reference, state)?;
        }
        for (&reference, &seed) in known.iter().zip(seeds) {
            variables.check_seed(reference, seed)?;
        }
        self.refresh()?;
        let known: Vec<(u32, f64)> = known.iter().copied().zip(seeds.iter().copied()).collect();
        let found = self.now.model.directional_derivative(unknown, &known);
        derivatives.copy_from_slice(&found);
        Ok(())
    }

    /// Goes on from `point`, which must be the present time, by `h` > 0, both [s].
    pub fn do_step(&mut self, point: f64, h: f64) -> Result<(), Error> {
        self.permit(Function::DoStep)?;
        let now = &mut self.now;
        if !(h.is_finite() && h > 0.0) {
            let expected = "a finite positive time".to_owned();
            return refuse("communication step size", expected, h);
        }
        let start = now
            .experiment
            .map_or(0.0, |experiment| experiment.start_time);
        let largest = [start, now.time, point, h].map(f64::abs);
        let largest = largest.into_iter().fold(0.0, f64::max);
        let apart = (point - now.time).abs();
        // An importer that adds up its steps drifts by far less than a millionth of one.
        let negligible = 1e-6 * h + round_off(largest);
        if !point.is_finite() || apart > round_off(largest) {
            let expected = format!("{} s, the end of the last step", now.time);
            return refuse("communication point", expected, point);
        }
        let end = point + h;
        if !end.is_finite() {
            return refuse(
                "end of the communication step",
                "a finite time".to_owned(),
                end,
            );
        }
        if let Some(stop) = now.experiment.and_then(|experiment| experiment.stop_time)
            && end > stop + negligible
        {
            let expected = format!("no step beyond the stop time {stop} s");
            return refuse("end of the communication step", expected, end);
        }
        for &(reference, slope) in &now.slopes {
            if let Value::Real(value) = now.model.get(reference) {
                let variables = &self.class.variables;
                variables.check_ramp(reference, value + slope * h)?;
            }
        }
        match now.model.step(point, h) {
            Flow::Continue => {
                now.time = end;
                Ok(())
            }
            Flow::Terminate { at, why } => {
                now.time = at;
                now.state = State::StepFailed;
                now.ended = true;
                Err(Error::Ended { at, why })
            }
            Flow::Refuse(why) => Err(Error::Model(why)),
        }
    }

    /// End of the last successful step [s].
    pub fn last_successful_time(&self) -> Result<f64, Error> {
        self.permit(Function::GetRealStatus)?;
        Ok(self.now.time)
    }

    /// Whether the model came to its end.
    pub fn terminated(&self) -> Result<bool, Error> {
        self.permit(Function::GetBooleanStatus)?;
        Ok(self.now.ended)
    }

    /// Saves the present state in `state`: where it is NULL in a new one, else in its place.
    pub fn save(&self, state: &mut fmi2FMUstate) -> Result<(), Error> {
        self.permit(Function::GetFMUstate)?;
        self.class.saved.keep(self.number, &self.now, state)
    }

    /// Goes back, or over, to a saved state of this or another instance.
    pub fn restore(&mut self, state: fmi2FMUstate) -> Result<(), Error> {
        self.permit(Function::SetFMUstate)?;
        let now = &mut self.now;
        self.class.saved.with(state, |saved| now.clone_from(saved))
    }

    /// Forgets a saved state and makes it NULL; NULL is none.
    pub fn forget(&self, state: &mut fmi2FMUstate) -> Result<(), Error> {
        self.permit(Function::FreeFMUstate)?;
        self.class.saved.free(state)
    }

    /// A saved state in bytes, for another instance or process.
    pub fn serialize(&self, state: fmi2FMUstate) -> Result<Vec<u8>, Error> {
        self.permit(Function::SerializeFMUstate)?;
        self.bytes(state)
    }

    /// How many bytes [`Instance::serialize`] gives.
    pub fn serialized_size(&self, state: fmi2FMUstate) -> Result<usize, Error> {
        self.permit(Function::SerializedFMUstateSize)?;
        Ok(self.bytes(state)?.len())
    }

    fn bytes(&self, state: fmi2FMUstate) -> Result<Vec<u8>, Error> {
        let class = &self.class;
        class
            .saved
            .with(state, |saved| to_bytes(&class.guid, saved))?
    }

    /// Saves what `bytes` hold: in a new state, unless `state` is one already.
    pub fn deserialize(&self, bytes: &[u8], state: &mut fmi2FMUstate) -> Result<(), Error> {
        self.permit(Function::DeSerializeFMUstate)?;
        let snapshot: Snapshot<M> = from_bytes(&self.class.guid, bytes)?;
        snapshot.check(&self.class)?;
        self.class.saved.make(self.number, &snapshot, state);
        Ok(())
    }
}

impl<M: Model> Drop for Instance<M> {
    /// With an instance go its saved states (FMI 2.0 §2.1.5).
    fn drop(&mut self) {
        self.class.saved.free_all(self.number);
    }
}

impl<M: Model> Snapshot<M> {
    /// Right after instantiation or reset.
    fn of(model: M) -> Self {
        Self {
            model,
            state: State::Instantiated,
            experiment: None,
            time: 0.0,
            stale: true,
            ended: false,
            slopes: Vec::new(),
        }
    }

    /// Refuses what no instance could have become. The checksum keeps out accidents, not intent.
    fn check(&self, class: &Class<M>) -> Result<(), Error> {
        let wrong = |error: Error| Error::Bytes(error.to_string());
        class
            .variables
            .check_all(|reference| self.model.get(reference))
            .map_err(wrong)?;
        for &(reference, slope) in &self.slopes {
            let variables = &class.variables;
            variables.check_slope(reference, 1, slope).map_err(wrong)?;
        }
        if let Some(experiment) = self.experiment {
            experiment.check().map_err(wrong)?;
        }
        let is_under_way = self.state != State::Instantiated;
        if !self.time.is_finite() || is_under_way && self.experiment.is_none() {
            return Err(Error::Bytes(format!(
                "expected an experiment and a finite time in {}, found {} s",
                self.state, self.time
            )));
        }
        Ok(())
    }
}

/// A capability the description does not declare is not used.
fn provided(declared: bool, function: Function) -> Result<(), Error> {
    if declared {
        Ok(())
    } else {
        let function = function.name;
        Err(Error::NotProvided { function })
    }
}

#[inline]
fn same_length(references: &[u32], values: usize) -> Result<(), Error> {
    if references.len() == values {
        Ok(())
    } else {
        Err(Error::Length {
            references: references.len(),
            values,
        })
    }
}

/// What two ways of computing a time of this magnitude may differ by: start + n·h, or a sum, or a
/// unit conversion differ in the last few bits.
fn round_off(magnitude: f64) -> f64 {
    64.0 * f64::EPSILON * magnitude
}
