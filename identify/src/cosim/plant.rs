//! The plant known natively: what its FMU starts with, as a bicycle, and back.

use crate::bicycles::{Bicycle, FORMULATION, formulation};
use crate::error::Result;
use bicycle::{Excitation, Formulation, Input, Parameters, Quantity};
use fmi_import::{Value, VariableRow};

/// The bicycle that an FMU with these variables starts with; none where it lacks a row of our
/// tables.
pub fn bicycle(model: &str, rows: &[VariableRow]) -> Result<Option<Bicycle>> {
    let start = |quantity: &Quantity| {
        let row = rows.iter().find(|row| row.name == quantity.name)?;
        match row.start {
            Some(Value::Real(value)) => Some(value),
            _ => None,
        }
    };
    let values = |table: &[Quantity]| table.iter().map(start).collect::<Option<Vec<f64>>>();
    let (Some(parameters), Some(inputs), Some(equations)) = (
        values(Parameters::TABLE),
        values(Input::TABLE),
        formulation_of(rows),
    ) else {
        return Ok(None);
    };
    let mut bicycle = Bicycle {
        name: model.to_owned(),
        description: String::new(),
        source: "start values of the FMU".to_owned(),
        parameters: Parameters::default(),
        excitation: Excitation::default(),
        input: Input::default(),
        formulation: formulation(&equations)?,
        law_in_loop: false,
        notes: Vec::new(),
    };
    for (index, value) in parameters.into_iter().enumerate() {
        bicycle.parameters.set(index, value);
    }
    for (index, value) in inputs.into_iter().enumerate() {
        bicycle.input.set(index, value);
    }
    Ok(Some(bicycle))
}

fn formulation_of(rows: &[VariableRow]) -> Option<String> {
    let row = rows.iter().find(|row| row.name == FORMULATION)?;
    let Some(Value::Integer(start)) = row.start else {
        return None;
    };
    let (name, _) = row.choices.iter().find(|(_, number)| *number == start)?;
    Some(name.clone())
}

/// Start values that make such an FMU this bicycle: those that differ from its own.
pub fn starts(
    rows: &[VariableRow],
    parameters: &Parameters,
    input: &Input,
    formulation: Formulation,
) -> Vec<(String, Value)> {
    let real = |(quantity, value): (&Quantity, f64)| (quantity.name, Value::Real(value));
    let reals = (Parameters::TABLE.iter().zip(parameters.to_array()))
        .chain(Input::TABLE.iter().zip(input.to_array()))
        .map(real);
    let choices = rows.iter().filter(|row| row.name == FORMULATION);
    let choices = choices
        .flat_map(|row| &row.choices)
        .filter(|(name, _)| name == formulation.name())
        .map(|(_, number)| (FORMULATION, Value::Integer(*number)));
    let differs = |(name, value): &(&str, Value)| {
        let row = rows.iter().find(|row| row.name == *name);
        row.is_some_and(|row| row.start.as_ref() != Some(value))
    };
    reals
        .chain(choices)
        .filter(differs)
        .map(|(name, value)| (name.to_owned(), value))
        .collect()
}
