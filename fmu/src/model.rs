//! The bicycle as a model that can be exported.

use crate::description::{description, formulation_of, formulation_value};
use crate::row::Row;
use bicycle::simulate::{Refusal, Simulation};
use bicycle::{Bicycle, Formulation, Input, Output, Parameters};
use fmi_export::{Experiment, Flow, Model, Value};
use model_description::ModelDescription;
use std::cell::OnceCell;

/// A longer communication step would not end in reasonable time: 10⁵ s are 10⁸ internal steps of
/// 1 ms, about a minute.
const LONGEST_STEP: f64 = 1e5;

/// A bicycle under way, behind FMI.
///
/// What is set is kept here and taken over by the simulation when the next step begins, so that
/// setting a value and setting it back is no change.
#[derive(Clone, Debug)]
pub struct RearLoadBicycle {
    parameters: Parameters,
    formulation: Formulation,
    input: Input,
    /// From initialization on.
    simulation: Option<Simulation>,
    /// The simulation has not taken over what was set.
    changed: bool,
    /// Outputs at this time with the values set so far, once somebody asks.
    output: OnceCell<Output>,
}

impl RearLoadBicycle {
    /// The simulation with what was set taken over.
    fn updated(&self) -> Result<Simulation, String> {
        let mut simulation = self.simulation.clone().ok_or("not initialised")?;
        let refuse = |refusal: Refusal| refusal.to_string();
        simulation
            .set(&self.parameters, self.input)
            .map_err(refuse)?;
        Ok(simulation)
    }

    /// Outputs with what was set; where the next step would refuse that, as they were.
    fn compute_output(&self) -> Output {
        if self.changed
            && let Ok(updated) = self.updated()
        {
            return updated.output();
        }
        self.simulation
            .as_ref()
            .map_or_else(Output::default, Simulation::output)
    }
}

impl Model for RearLoadBicycle {
    fn description() -> ModelDescription {
        description()
    }

    fn new() -> Self {
        Self {
            parameters: Parameters::default(),
            formulation: Formulation::default(),
            input: Input::default(),
            simulation: None,
            changed: false,
            output: OnceCell::new(),
        }
    }

    fn get(&self, reference: u32) -> Value {
        Value::Real(match Row::at(reference) {
            Row::Parameter(row) => self.parameters.get(row),
            Row::Formulation => return Value::Integer(formulation_value(self.formulation)),
            Row::Input(row) => self.input.get(row),
            Row::Output(row) => self.output.get_or_init(|| self.compute_output()).get(row),
            Row::Derived(row) => Bicycle::new(&self.parameters, self.formulation)
                .derived()
                .get(row),
            Row::Time => self.simulation.as_ref().map_or(0.0, Simulation::time),
        })
    }

    fn set(&mut self, reference: u32, value: Value) {
        match (Row::at(reference), value) {
            (Row::Parameter(row), Value::Real(value)) => self.parameters.set(row, value),
            (Row::Input(row), Value::Real(value)) => self.input.set(row, value),
            (Row::Formulation, Value::Integer(value)) => {
                if let Some(formulation) = formulation_of(value) {
                    self.formulation = formulation;
                }
            }
            (row, value) => unreachable!("{row:?} = {value:?} is refused by the instance"),
        }
        self.changed = true;
        self.output.take();
    }

    fn initialize(&mut self, experiment: &Experiment) -> Result<(), String> {
        let start = experiment.start_time;
        let simulation = Simulation::new(&self.parameters, self.formulation, self.input, start)
            .map_err(|refusal| refusal.to_string())?;
        self.simulation = Some(simulation);
        self.changed = false;
        self.output.take();
        Ok(())
    }

    fn step(&mut self, t: f64, h: f64) -> Flow {
        if h > LONGEST_STEP {
            return Flow::Refuse(format!(
                "communication step size: expected at most {LONGEST_STEP} s, found {h} s"
            ));
        }
        if self.changed {
            match self.updated() {
                Ok(updated) => self.simulation = Some(updated),
                Err(why) => return Flow::Refuse(why),
            }
            self.changed = false;
        }
        self.output.take();
        let Some(simulation) = &mut self.simulation else {
            return Flow::Refuse("not initialised".to_owned());
        };
        match simulation.advance(t + h) {
            Ok(()) => Flow::Continue,
            Err(stop) => Flow::Terminate {
                at: stop.time(),
                why: stop.to_string(),
            },
        }
    }
}
