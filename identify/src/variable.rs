//! Variables of an FMU, by name, and values for them as typed.

#[cfg(test)]
mod tests;

use crate::error::{Error, Result};
use crate::unit::{self, Scale};
use bicycle::quantity::UNITS;
use fmi_import::model_description::Unit;
use fmi_import::{Value, VariableRow};

/// The variable called `name`.
pub fn row<'a>(variables: &'a [VariableRow], name: &str) -> Result<&'a VariableRow> {
    let found = variables.iter().find(|row| row.name == name);
    let names = || variables.iter().map(|row| row.name.as_str());
    found.ok_or_else(|| Error::unknown("variable", name, names()))
}

/// The value that `text` means for the variable called `name`, if it is in its range. A number may
/// carry a unit.
pub fn value(units: &[Unit], variables: &[VariableRow], name: &str, text: &str) -> Result<Value> {
    let row = row(variables, name)?;
    within(row, parse(units, row, text)?)
}

fn parse(units: &[Unit], row: &VariableRow, text: &str) -> Result<Value> {
    let form = |expected| Error::Form {
        expected,
        found: text.to_owned(),
    };
    Ok(match row.type_name {
        "Real" => Value::Real(real(units, row.unit.as_deref(), &row.name, text)?),
        "Integer" => Value::Integer(text.parse().map_err(|_| form("an integer"))?),
        "Boolean" => Value::Boolean(text.parse().map_err(|_| form("true or false"))?),
        "Enumeration" => {
            let choice = row.choices.iter().find(|(name, _)| name == text);
            let number = choice.map(|(_, number)| *number).or(text.parse().ok());
            let names = row.choices.iter().map(|(name, _)| name.as_str());
            Value::Integer(number.ok_or_else(|| Error::unknown("choice", text, names))?)
        }
        _ => Value::String(text.to_owned()),
    })
}

/// The value, if it is a number in the range of the variable.
fn within(row: &VariableRow, value: Value) -> Result<Value> {
    let (min, max) = (
        row.min.unwrap_or(f64::NEG_INFINITY),
        row.max.unwrap_or(f64::INFINITY),
    );
    let found = match value {
        Value::Real(found) => found,
        Value::Integer(found) => found.into(),
        Value::Boolean(_) | Value::String(_) => return Ok(value),
    };
    if (min..=max).contains(&found) {
        return Ok(value);
    }
    Err(Error::Form {
        expected: "a value in the variable's range",
        found: format!("{found}, outside {min} to {max}"),
    })
}

/// A number in the variable's `unit`: it may carry that unit, one the FMU displays it in, or one of
/// the same dimension.
fn real(units: &[Unit], unit: Option<&str>, name: &str, text: &str) -> Result<f64> {
    let number = |text: &str| text.trim().parse().ok().filter(|x: &f64| x.is_finite());
    let what = unit.map_or_else(|| name.to_owned(), |unit| format!("{name} [{unit}]"));
    let wrong = || Error::Number {
        what: what.clone(),
        found: text.to_owned(),
    };
    if let Some(value) = number(text) {
        return Ok(value);
    }
    let unit = unit.ok_or_else(wrong)?;
    if let Some(value) = text.strip_suffix(unit).and_then(number) {
        return Ok(value);
    }
    // the units of the bicycle's tables first, so that a text means the same number everywhere
    let scale = |known| {
        Scale::of(unit, known, &what)
            .ok()
            .map(|scale| (known, scale))
    };
    let known = UNITS.iter().copied().find_map(scale);
    let ours = known.map(|(known, scale)| {
        unit::parse(text, known, &what).map(|value| match scale.to_si(1.0) {
            1.0 => value,
            factor => value / factor,
        })
    });
    if let Some(Ok(value)) = ours {
        return Ok(value);
    }
    let display_units = units.iter().filter(|own| own.name == unit);
    for display in display_units.flat_map(|own| &own.display_units) {
        if let Some(value) = text.strip_suffix(display.name.as_str()).and_then(number) {
            return Ok((value - display.offset) / display.factor);
        }
    }
    ours.unwrap_or_else(|| Err(wrong()))
}
