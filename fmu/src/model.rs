//! The bicycle as a model that can be exported.

use crate::description::{description, formulation_of, formulation_value};
use crate::row::Row;
use bicycle::sensitivity::{self, Direction};
use bicycle::simulate::{self, Refusal, Simulation};
use bicycle::{Bicycle, Formulation, Input, Output, Parameters, Path, State};
use fmi_export::{Experiment, Flow, Model, Value};
use model_description::ModelDescription;
use serde::{Deserialize, Serialize};
use std::cell::OnceCell;

/// More internal steps in a communication step would not end in reasonable time: so many take some
/// seconds, and minutes where a ride has died away to subnormal numbers.
const MOST_STEPS: f64 = 1e7;

/// A bicycle under way, behind FMI.
///
/// What is set is kept here and taken over by the simulation when the next step begins, so that
/// setting a value and setting it back is no change.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct RearLoadBicycle {
    parameters: Parameters,
    formulation: Formulation,
    /// At the present time.
    input: Input,
    /// How much each input changes in a second.
    slope: Input,
    /// From initialization on.
    simulation: Option<Simulation>,
    /// What the simulation has not taken over.
    pending: Pending,
    /// Outputs at this time with the values set so far, once somebody asks.
    #[serde(skip)]
    output: OnceCell<Output>,
}

/// What was set since the last step.
#[derive(Clone, Copy, Debug, PartialEq, PartialOrd, Serialize, Deserialize)]
enum Pending {
    Nothing,
    Inputs,
    Parameters,
}

impl RearLoadBicycle {
    fn was_set(&mut self, what: Pending) {
        if what > self.pending {
            self.pending = what;
        }
        self.output = OnceCell::new();
    }

    /// Where the bicycle is, as the values set so far make it: whether a step could be taken with
    /// them is asked when it is.
    fn present(&self) -> Option<Present> {
        let simulation = self.simulation.as_ref()?;
        Some(Present {
            bicycle: if self.pending == Pending::Parameters {
                Bicycle::new(&self.parameters, self.formulation)
            } else {
                *simulation.bicycle()
            },
            state: *simulation.state(),
            path: *simulation.path(),
            input: self.input,
        })
    }

    fn output(&self, row: usize) -> f64 {
        // Inputs act on rates and forces; what has been reached stays until the next step.
        if self.pending < Pending::Parameters
            && let Some(value) = self.simulation.as_ref().and_then(|s| s.output_row(row))
        {
            return value;
        }
        self.output
            .get_or_init(|| {
                self.present().map_or_else(Output::default, |now| {
                    simulate::output(&now.bicycle, &now.state, &now.path, &now.input)
                })
            })
            .get(row)
    }
}

/// What outputs are computed from.
struct Present {
    bicycle: Bicycle,
    state: State,
    path: Path,
    input: Input,
}

fn take_over(
    simulation: &mut Simulation,
    pending: Pending,
    parameters: &Parameters,
    input: Input,
    slope: Input,
) -> Result<(), Refusal> {
    match pending {
        Pending::Nothing => Ok(()),
        Pending::Inputs if is_level(&slope) => simulation.set_input(input),
        Pending::Inputs | Pending::Parameters => simulation.set(parameters, input, slope),
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
            slope: Input::ZERO,
            simulation: None,
            pending: Pending::Nothing,
            output: OnceCell::new(),
        }
    }

    fn get(&self, reference: u32) -> Value {
        Value::Real(match Row::at(reference) {
            Row::Parameter(row) => self.parameters.get(row),
            Row::Formulation => return Value::Integer(formulation_value(self.formulation)),
            Row::Input(row) => self.input.get(row),
            Row::Output(row) => self.output(row),
            Row::Derived(row) => Bicycle::new(&self.parameters, self.formulation)
                .derived()
                .get(row),
            Row::Time => self.simulation.as_ref().map_or(0.0, Simulation::time),
        })
    }

    fn set(&mut self, reference: u32, value: Value) {
        let pending = match (Row::at(reference), value) {
            (Row::Parameter(row), Value::Real(value)) => {
                self.parameters.set(row, value);
                Pending::Parameters
            }
            (Row::Input(row), Value::Real(value)) => {
                self.input.set(row, value);
                Pending::Inputs
            }
            (Row::Formulation, Value::Integer(value)) => {
                if let Some(formulation) = formulation_of(value) {
                    self.formulation = formulation;
                }
                Pending::Parameters
            }
            (row, value) => unreachable!("{row:?} = {value:?} is refused by the instance"),
        };
        self.was_set(pending);
    }

    fn initialize(&mut self, experiment: &Experiment) -> Result<(), String> {
        let refuse = |refusal: Refusal| refusal.to_string();
        let start = experiment.start_time;
        let mut simulation = Simulation::new(&self.parameters, self.formulation, self.input, start)
            .map_err(refuse)?;
        simulation
            .set(&self.parameters, self.input, self.slope)
            .map_err(refuse)?;
        self.simulation = Some(simulation);
        self.pending = Pending::Nothing;
        self.output = OnceCell::new();
        Ok(())
    }

    fn step(&mut self, t: f64, h: f64) -> Flow {
        let longest = MOST_STEPS * self.parameters.internal_step;
        if h > longest {
            return Flow::Refuse(format!(
                "communication step size: expected at most {longest} s, {MOST_STEPS:e} internal \
                 steps, found {h} s"
            ));
        }
        let Some(simulation) = &mut self.simulation else {
            return Flow::Refuse("not initialised".to_owned());
        };
        let (pending, parameters) = (self.pending, &self.parameters);
        let taken = if is_level(&self.slope) {
            take_over(simulation, pending, parameters, self.input, self.slope)
        } else {
            // Where a ramp leads is known only once it is taken over, and may be refused then.
            let mut ahead = simulation.clone();
            take_over(&mut ahead, pending, parameters, self.input, self.slope)
                .and_then(|()| ahead.check_until(t + h))
                .map(|()| *simulation = ahead)
        };
        if let Err(refusal) = taken {
            return Flow::Refuse(refusal.to_string());
        }
        self.pending = Pending::Nothing;
        self.output = OnceCell::new();
        let arrived = simulation.advance(t + h);
        // A ramp that ends at a limit may pass it by its rounding.
        let input = simulation.input().to_array();
        self.input = Input::from_array(std::array::from_fn(|row| {
            input[row].clamp(Input::TABLE[row].min, Input::TABLE[row].max)
        }));
        match arrived {
            Ok(()) => Flow::Continue,
            Err(stop) => Flow::Terminate {
                at: stop.time(),
                why: stop.to_string(),
            },
        }
    }

    fn directional_derivative(&self, unknown: &[u32], known: &[(u32, f64)]) -> Vec<f64> {
        let Some(now) = self.present() else {
            return vec![0.0; unknown.len()];
        };
        let mut direction = Direction::ZERO;
        for &(reference, seed) in known {
            let row = Row::at(reference);
            match row {
                Row::Parameter(row) => direction
                    .parameters
                    .set(row, direction.parameters.get(row) + seed),
                Row::Input(row) => direction.input.set(row, direction.input.get(row) + seed),
                _ => {}
            }
            // A start value in initialization mode, the state itself later.
            let name = row.quantity().map_or("", |quantity| quantity.name);
            let name = name.strip_suffix("_start").unwrap_or(name);
            if let Some(row) = State::index(name) {
                direction.state.set(row, direction.state.get(row) + seed);
            } else if let Some(row) = Path::index(name) {
                direction.path.set(row, direction.path.get(row) + seed);
            }
        }
        let along =
            sensitivity::output_along(&now.bicycle, &now.state, &now.path, &now.input, &direction);
        let derivative = |&reference: &u32| match Row::at(reference) {
            Row::Output(row) => along.get(row),
            _ => 0.0,
        };
        unknown.iter().map(derivative).collect()
    }

    fn set_input_slope(&mut self, reference: u32, slope: f64) {
        if let Row::Input(row) = Row::at(reference) {
            self.slope.set(row, slope);
            self.was_set(Pending::Inputs);
        }
    }

    fn output_rate(&self, reference: u32) -> f64 {
        let (Row::Output(row), Some(now)) = (Row::at(reference), self.present()) else {
            return 0.0;
        };
        sensitivity::output_rate(&now.bicycle, &now.state, &now.path, &now.input, &self.slope)
            .get(row)
    }
}

/// Whether no input changes.
fn is_level(slope: &Input) -> bool {
    slope.to_array().iter().all(|&slope| slope == 0.0)
}
