//! A cart of given mass on a rail, pushed by a force, until the rail ends.

use crate::{Experiment, Flow, Model, Value, co_simulation, log_categories};
use model_description::{
    BooleanVariable, Causality, CoSimulation, EnumerationType, EnumerationVariable,
    IntegerVariable, Item, ModelDescription, ModelStructure, RealVariable, ScalarVariable,
    SimpleType, StringVariable, TypeDefinition, Unknown, Variability, VariableType,
};
use serde::{Deserialize, Serialize};

pub(super) const MASS: u32 = 0;
pub(super) const DRAG: u32 = 1;
pub(super) const WHEELS: u32 = 2;
pub(super) const BRAKED: u32 = 3;
pub(super) const OWNER: u32 = 4;
pub(super) const GAIT: u32 = 5;
pub(super) const FORCE: u32 = 6;
pub(super) const POSITION: u32 = 7;
pub(super) const ACCELERATION: u32 = 8;
pub(super) const TIME: u32 = 9;
pub(super) const AXLES: u32 = 10;
pub(super) const COUNT: u32 = 11;

/// The rail ends here [m].
pub(super) const RAIL: f64 = 10.0;
/// With so many wheels the model panics.
pub(super) const CURSED: i32 = 13;

#[derive(Clone, Serialize, Deserialize)]
pub(super) struct Cart {
    mass: f64,
    drag: f64,
    wheels: i32,
    braked: bool,
    owner: String,
    gait: i32,
    force: f64,
    force_slope: f64,
    position: f64,
    velocity: f64,
    time: f64,
}

impl Cart {
    fn acceleration(&self) -> f64 {
        (self.force - self.drag * self.velocity) / self.mass
    }
}

/// Name, causality, variability and type of each variable.
fn rows() -> [(&'static str, Causality, Variability, VariableType); COUNT as usize] {
    use Causality::{Independent, Input, Output, Parameter};
    use Variability::{Constant, Continuous, Fixed, Tunable};
    let real = |start: Option<f64>, min, max| {
        VariableType::Real(RealVariable {
            min,
            max,
            start,
            ..RealVariable::default()
        })
    };
    [
        ("mass", Parameter, Fixed, real(Some(2.0), Some(0.1), None)),
        ("drag", Parameter, Tunable, real(Some(0.0), None, Some(9.0))),
        (
            "wheels",
            Parameter,
            Fixed,
            VariableType::Integer(IntegerVariable {
                min: Some(2),
                start: Some(4),
                ..IntegerVariable::default()
            }),
        ),
        (
            "braked",
            Parameter,
            Tunable,
            VariableType::Boolean(BooleanVariable {
                start: Some(false),
                ..BooleanVariable::default()
            }),
        ),
        (
            "owner",
            Parameter,
            Fixed,
            VariableType::String(StringVariable {
                start: Some("nobody".to_owned()),
                ..StringVariable::default()
            }),
        ),
        (
            "gait",
            Parameter,
            Fixed,
            VariableType::Enumeration(EnumerationVariable {
                declared_type: "Gait".to_owned(),
                start: Some(1),
                ..EnumerationVariable::default()
            }),
        ),
        ("force", Input, Continuous, real(Some(1.0), None, None)),
        ("position", Output, Continuous, real(None, None, None)),
        ("acceleration", Output, Continuous, real(None, None, None)),
        ("time", Independent, Continuous, real(None, None, None)),
        (
            "axles",
            Output,
            Constant,
            VariableType::Integer(IntegerVariable {
                start: Some(2),
                ..IntegerVariable::default()
            }),
        ),
    ]
}

fn unknown(reference: u32) -> Unknown {
    Unknown {
        index: reference + 1,
        ..Unknown::default()
    }
}

impl Model for Cart {
    fn description() -> ModelDescription {
        ModelDescription {
            model_name: "Cart".to_owned(),
            co_simulation: Some(CoSimulation {
                can_interpolate_inputs: true,
                provides_directional_derivative: true,
                max_output_derivative_order: 1,
                ..co_simulation("Cart")
            }),
            types: vec![SimpleType {
                name: "Gait".to_owned(),
                description: None,
                definition: TypeDefinition::Enumeration(EnumerationType {
                    quantity: None,
                    items: ["trot", "walk"]
                        .into_iter()
                        .zip(1..)
                        .map(|(name, value)| Item {
                            name: name.to_owned(),
                            value,
                            description: None,
                        })
                        .collect(),
                }),
            }],
            log_categories: log_categories(),
            variables: rows()
                .into_iter()
                .zip(0..)
                .map(
                    |((name, causality, variability, variable_type), value_reference)| {
                        ScalarVariable {
                            name: name.to_owned(),
                            value_reference,
                            description: None,
                            causality,
                            variability,
                            initial: None,
                            variable_type,
                        }
                    },
                )
                .collect(),
            structure: ModelStructure {
                outputs: vec![unknown(POSITION), unknown(ACCELERATION)],
                initial_unknowns: vec![unknown(POSITION), unknown(ACCELERATION)],
                ..ModelStructure::default()
            },
            ..ModelDescription::default()
        }
    }

    fn new() -> Self {
        Self {
            mass: 2.0,
            drag: 0.0,
            wheels: 4,
            braked: false,
            owner: "nobody".to_owned(),
            gait: 1,
            force: 1.0,
            force_slope: 0.0,
            position: 0.0,
            velocity: 0.0,
            time: 0.0,
        }
    }

    fn get(&self, reference: u32) -> Value {
        match reference {
            MASS => Value::Real(self.mass),
            DRAG => Value::Real(self.drag),
            WHEELS => Value::Integer(self.wheels),
            BRAKED => Value::Boolean(self.braked),
            OWNER => Value::String(self.owner.clone()),
            GAIT => Value::Integer(self.gait),
            FORCE => Value::Real(self.force),
            POSITION => Value::Real(self.position),
            ACCELERATION => Value::Real(self.acceleration()),
            TIME => Value::Real(self.time),
            AXLES => Value::Integer(2),
            _ => unreachable!("checked by the instance"),
        }
    }

    fn set(&mut self, reference: u32, value: Value) {
        match (reference, value) {
            (MASS, Value::Real(value)) => self.mass = value,
            (DRAG, Value::Real(value)) => self.drag = value,
            (WHEELS, Value::Integer(value)) => self.wheels = value,
            (BRAKED, Value::Boolean(value)) => self.braked = value,
            (OWNER, Value::String(value)) => self.owner = value,
            (GAIT, Value::Integer(value)) => self.gait = value,
            (FORCE, Value::Real(value)) => self.force = value,
            _ => unreachable!("checked by the instance"),
        }
    }

    fn initialize(&mut self, experiment: &Experiment) -> Result<(), String> {
        if self.mass > 1000.0 {
            return Err(format!("expected a cart, found a ship of {} kg", self.mass));
        }
        self.time = experiment.start_time;
        self.position = 0.0;
        self.velocity = 0.0;
        Ok(())
    }

    fn step(&mut self, t: f64, h: f64) -> Flow {
        assert!(self.wheels != CURSED, "100 % cursed");
        if self.braked {
            return Flow::Refuse("the brake is on".to_owned());
        }
        let a = self.acceleration();
        // The jerk of a force that is a ramp; drag is not felt within a step.
        let jerk = self.force_slope / self.mass;
        let position = self.position + self.velocity * h + 0.5 * a * h * h + jerk * h * h * h / 6.0;
        if position > RAIL {
            self.time = t + 0.5 * h;
            self.position = RAIL;
            return Flow::Terminate {
                at: self.time,
                why: "the rail ends".to_owned(),
            };
        }
        self.position = position;
        self.velocity += a * h + 0.5 * jerk * h * h;
        self.force += self.force_slope * h;
        self.time = t + h;
        Flow::Continue
    }

    fn set_input_slope(&mut self, _: u32, slope: f64) {
        self.force_slope = slope;
    }

    fn output_rate(&self, reference: u32) -> f64 {
        match reference {
            POSITION => self.velocity,
            _ => (self.force_slope - self.drag * self.acceleration()) / self.mass,
        }
    }

    fn directional_derivative(&self, unknown: &[u32], known: &[(u32, f64)]) -> Vec<f64> {
        let by = |&(known, seed): &(u32, f64)| match known {
            FORCE => seed / self.mass,
            MASS => -seed * self.acceleration() / self.mass,
            _ => 0.0,
        };
        let acceleration = known.iter().map(by).sum();
        let derivative = |&unknown: &u32| match unknown {
            ACCELERATION => acceleration,
            _ => 0.0,
        };
        unknown.iter().map(derivative).collect()
    }
}
