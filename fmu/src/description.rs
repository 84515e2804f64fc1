//! modelDescription.xml from the tables.

use crate::dependencies;
use crate::row::Row;
use bicycle::quantity::{self, UNITS};
use bicycle::{Formulation, Input, Output, Parameters, Path, Quantity, State, Unit};
use fmi_export::{co_simulation, log_categories};
use model_description::{
    BaseUnit, Causality, CoSimulation, DefaultExperiment, DisplayUnit, EnumerationType,
    EnumerationVariable, Item, ModelDescription, ModelStructure, RealVariable, ScalarVariable,
    SimpleType, TypeDefinition, Unknown, Variability, VariableType,
};

/// Name of the FMU and of its shared library.
pub const MODEL_IDENTIFIER: &str = "RearLoadBicycle";

/// When this version of the description was made: same input, same bytes. `SOURCE_DATE_EPOCH` puts
/// another date in its place on packing.
const VERSION_DATE: &str = "2026-11-22T00:00:00Z";

const FORMULATION_TYPE: &str = "Formulation";

/// What a bicycle starts from: its values of what can be set.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Starts {
    /// The parameters.
    pub parameters: Parameters,
    /// How the equations are read.
    pub formulation: Formulation,
    /// The inputs.
    pub input: Input,
}

/// The description with nominal start values, guid included.
pub(crate) fn description() -> ModelDescription {
    description_from(&Starts::default())
}

/// The description with these start values; the guid is the same for all.
pub(crate) fn description_from(starts: &Starts) -> ModelDescription {
    let mut description = ModelDescription {
        model_name: MODEL_IDENTIFIER.to_owned(),
        description: Some(
            "Bicycle with slipping tyres, steering friction, a rider and a load on the rear \
             carrier: nonlinear equations or the four-body bicycle"
                .to_owned(),
        ),
        author: Some("the wobble authors".to_owned()),
        version: Some(env!("CARGO_PKG_VERSION").to_owned()),
        copyright: Some("the wobble authors".to_owned()),
        license: Some(env!("CARGO_PKG_LICENSE").to_owned()),
        generation_tool: Some(concat!("wobble ", env!("CARGO_PKG_VERSION")).to_owned()),
        generation_date_and_time: Some(VERSION_DATE.to_owned()),
        co_simulation: Some(CoSimulation {
            can_interpolate_inputs: true,
            provides_directional_derivative: true,
            max_output_derivative_order: 1,
            ..co_simulation(MODEL_IDENTIFIER)
        }),
        units: units(),
        types: vec![formulations()],
        log_categories: log_categories(),
        default_experiment: Some(DefaultExperiment {
            start_time: Some(0.0),
            stop_time: Some(24.0),
            tolerance: Some(1e-4),
            step_size: Some(0.005),
        }),
        variables: Row::all().map(|row| variable(row, starts)).collect(),
        structure: structure(),
        ..ModelDescription::default()
    };
    description.guid = description.fingerprint();
    description
}

/// The units the variables have.
fn units() -> Vec<model_description::Unit> {
    let used = |unit: &Unit| {
        *unit == quantity::S
            || Row::all()
                .filter_map(Row::quantity)
                .any(|row| row.unit == *unit)
    };
    UNITS.iter().filter(|unit| used(unit)).map(unit).collect()
}

/// A unit of the tables as FMI describes it.
pub fn unit(unit: &Unit) -> model_description::Unit {
    model_description::Unit {
        name: unit.symbol.to_owned(),
        base: Some(BaseUnit {
            kg: unit.kg.into(),
            m: unit.m.into(),
            s: unit.s.into(),
            rad: unit.rad.into(),
            ..BaseUnit::default()
        }),
        display_units: display_unit(unit).into_iter().collect(),
    }
}

/// What people read instead of rad and m/s.
fn display_unit(unit: &Unit) -> Option<DisplayUnit> {
    let (name, factor) = match *unit {
        quantity::RAD => ("deg", 1_f64.to_degrees()),
        quantity::RAD_PER_S => ("deg/s", 1_f64.to_degrees()),
        quantity::RAD_PER_S2 => ("deg/s2", 1_f64.to_degrees()),
        quantity::M_PER_S => ("km/h", 3.6),
        _ => return None,
    };
    Some(DisplayUnit {
        name: name.to_owned(),
        factor,
        offset: 0.0,
    })
}

/// The choices of `formulation`, numbered from 1.
fn formulations() -> SimpleType {
    SimpleType {
        name: FORMULATION_TYPE.to_owned(),
        description: Some("How the equations are read".to_owned()),
        definition: TypeDefinition::Enumeration(EnumerationType {
            quantity: None,
            items: Formulation::ALL
                .into_iter()
                .map(|formulation| Item {
                    name: formulation.name().to_owned(),
                    value: formulation_value(formulation),
                    description: Some(formulation.what().to_owned()),
                })
                .collect(),
        }),
    }
}

/// The value a formulation travels as.
pub(crate) fn formulation_value(formulation: Formulation) -> i32 {
    formulation as i32 + 1
}

/// The formulation that travels as `value`.
pub(crate) fn formulation_of(value: i32) -> Option<Formulation> {
    Formulation::ALL
        .into_iter()
        .find(|&formulation| formulation_value(formulation) == value)
}

fn variable(row: Row, starts: &Starts) -> ScalarVariable {
    match (row, row.quantity()) {
        (Row::Parameter(index), Some(quantity)) => {
            let variability = match quantity.variability {
                quantity::Variability::Tunable => Variability::Tunable,
                quantity::Variability::Fixed | quantity::Variability::Continuous => {
                    Variability::Fixed
                }
            };
            let start = starts.parameters.get(index);
            real(
                row,
                quantity,
                Causality::Parameter,
                variability,
                Some(start),
            )
        }
        (Row::Input(index), Some(quantity)) => real(
            row,
            quantity,
            Causality::Input,
            Variability::Continuous,
            Some(starts.input.get(index)),
        ),
        (Row::Derived(_), Some(quantity)) => {
            real(row, quantity, Causality::Local, Variability::Tunable, None)
        }
        (_, Some(quantity)) => real(
            row,
            quantity,
            Causality::Output,
            Variability::Continuous,
            None,
        ),
        (Row::Formulation, None) => ScalarVariable {
            name: "formulation".to_owned(),
            value_reference: row.reference(),
            description: Some("How the equations are read".to_owned()),
            causality: Causality::Parameter,
            variability: Variability::Fixed,
            initial: None,
            variable_type: VariableType::Enumeration(EnumerationVariable {
                declared_type: FORMULATION_TYPE.to_owned(),
                start: Some(formulation_value(starts.formulation)),
                ..EnumerationVariable::default()
            }),
        },
        (_, None) => ScalarVariable {
            name: "time".to_owned(),
            value_reference: row.reference(),
            description: Some("Time".to_owned()),
            causality: Causality::Independent,
            variability: Variability::Continuous,
            initial: None,
            variable_type: VariableType::Real(RealVariable {
                unit: Some(quantity::S.symbol.to_owned()),
                ..RealVariable::default()
            }),
        },
    }
}

fn real(
    row: Row,
    quantity: &Quantity,
    causality: Causality,
    variability: Variability,
    start: Option<f64>,
) -> ScalarVariable {
    ScalarVariable {
        name: quantity.name.to_owned(),
        value_reference: row.reference(),
        description: Some(format!("{} ({})", quantity.what, quantity.symbol)),
        causality,
        variability,
        initial: None,
        variable_type: VariableType::Real(RealVariable {
            unit: Some(quantity.unit.symbol.to_owned()),
            display_unit: display_unit(&quantity.unit).map(|display| display.name),
            min: quantity.min.is_finite().then_some(quantity.min),
            max: quantity.max.is_finite().then_some(quantity.max),
            start,
            derivative: state_of(row).map(Row::index),
            ..RealVariable::default()
        }),
    }
}

/// The outputs that are continuous states, each after the output that is its time derivative.
const DERIVATIVES: [(&str, &str); State::LEN + Path::LEN] = [
    ("roll_rate", "roll"),
    ("steer_rate", "steer"),
    ("yaw_rate", "heading"),
    ("steer_acceleration", "steer_rate"),
    ("roll_acceleration", "roll_rate"),
    ("yaw_acceleration", "yaw_rate"),
    ("lateral_velocity_rate", "lateral_velocity"),
    ("front_lateral_force_rate", "front_lateral_force"),
    ("rear_lateral_force_rate", "rear_lateral_force"),
    ("x_rate", "x"),
    ("y_rate", "y"),
];

/// The continuous state whose derivative `row` is.
fn state_of(row: Row) -> Option<Row> {
    let quantity = matches!(row, Row::Output(_)).then(|| row.quantity())??;
    let pair = DERIVATIVES.iter().find(|(name, _)| *name == quantity.name);
    pair.and_then(|(_, state)| Output::index(state))
        .map(Row::Output)
}

/// Every output, all of them computed in initialization mode, and which of them are derivatives.
fn structure() -> ModelStructure {
    let unknowns = |dependencies: Vec<Vec<u32>>| -> Vec<Unknown> {
        (0..Output::LEN)
            .zip(dependencies)
            .map(|(row, dependencies)| Unknown {
                index: Row::Output(row).index(),
                dependencies: Some(dependencies),
                dependencies_kind: None,
            })
            .collect()
    };
    let outputs = unknowns(dependencies::at_communication_points());
    let is_derivative = |unknown: &&Unknown| {
        let row = Row::at(unknown.index - 1);
        state_of(row).is_some()
    };
    ModelStructure {
        derivatives: outputs.iter().filter(is_derivative).cloned().collect(),
        outputs,
        initial_unknowns: unknowns(dependencies::at_the_start()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use expect_test::expect_file;

    #[test]
    fn the_golden_file_is_up_to_date() {
        let xml = description().to_xml().expect("writable");
        expect_file!["../modelDescription.xml"].assert_eq(&xml);
    }

    #[test]
    fn every_unit_a_variable_has_is_defined() {
        let description = description();
        for variable in &description.variables {
            if let Some(name) = variable.unit() {
                let unit = description.units.iter().find(|unit| unit.name == name);
                assert!(unit.is_some(), "{}: {name}", variable.name);
            }
        }
    }

    #[test]
    fn formulations_travel_as_their_number() {
        for formulation in Formulation::ALL {
            let value = formulation_value(formulation);
            assert_eq!(formulation_of(value), Some(formulation));
        }
        assert_eq!(formulation_of(0), None);
        assert_eq!(formulation_of(6), None);
    }
}
