//! Values of variables as parameters of SSP, and their units.

use super::unfit;
use crate::{Error, Value};
use model_description::ssp::{ConnectorType, ParameterValue, Unit};
use model_description::{ModelDescription, ScalarVariable, VariableType};
use std::path::Path;

/// The units an SSP document defines, gathered from FMUs.
#[derive(Default)]
pub(super) struct Units(pub(super) Vec<Unit>);

impl Units {
    /// The unit of `variable` where the document can say it: the FMU must define it in SI units,
    /// and no other FMU otherwise. Left out, it is that of the variable all the same.
    fn of(&mut self, description: &ModelDescription, variable: &ScalarVariable) -> Option<String> {
        let unit = Unit::of(description.unit(variable)?)?;
        if self.0.iter().all(|known| known.name != unit.name) {
            self.0.push(unit.clone());
        }
        self.0.contains(&unit).then_some(unit.name)
    }

    /// The type of a connector to `variable`; none for an enumeration, whose definition stays
    /// the FMU's affair.
    pub(super) fn connector_type(
        &mut self,
        description: &ModelDescription,
        variable: &ScalarVariable,
    ) -> Option<ConnectorType> {
        match &variable.variable_type {
            VariableType::Real(_) => Some(ConnectorType::Real {
                unit: self.of(description, variable),
            }),
            VariableType::Integer(_) => Some(ConnectorType::Integer),
            VariableType::Boolean(_) => Some(ConnectorType::Boolean),
            VariableType::String(_) => Some(ConnectorType::String),
            VariableType::Enumeration(_) => None,
        }
    }

    /// `value` of `variable` as a parameter.
    pub(super) fn parameter(
        &mut self,
        description: &ModelDescription,
        variable: &ScalarVariable,
        value: &Value,
        path: &Path,
    ) -> Result<ParameterValue, Error> {
        let what = || format!("start value of {}", variable.name);
        Ok(match (&variable.variable_type, value) {
            (VariableType::Real(_), Value::Real(value)) if value.is_finite() => {
                ParameterValue::Real {
                    value: *value,
                    unit: self.of(description, variable),
                }
            }
            (VariableType::Real(_), Value::Real(value)) => {
                let expected = "a finite number";
                return Err(unfit(path, what(), expected, value.to_string()));
            }
            (VariableType::Integer(_), Value::Integer(value)) => ParameterValue::Integer(*value),
            (VariableType::Boolean(_), Value::Boolean(value)) => ParameterValue::Boolean(*value),
            (VariableType::String(_), Value::String(value)) => {
                ParameterValue::String(value.clone())
            }
            (VariableType::Enumeration(_), Value::Integer(value)) => {
                let mut items = description.choices(variable).iter();
                let item = items.find(|item| item.value == *value);
                let item = item
                    .ok_or_else(|| unfit(path, what(), "one of its choices", value.to_string()))?;
                ParameterValue::Enumeration {
                    value: item.name.clone(),
                    name: None,
                }
            }
            (expected, value) => return Err(wrong(variable, expected.name(), value.type_name())),
        })
    }
}

/// The value of `variable` that a parameter gives, in the variable's unit; `units` are those of
/// the parameter set.
pub(super) fn value(
    description: &ModelDescription,
    variable: &ScalarVariable,
    parameter: &ParameterValue,
    units: &[Unit],
    path: &Path,
) -> Result<Value, Error> {
    let refuse = |expected: &str, found: &str| {
        let what = format!("value of {}", variable.name);
        unfit(path, what, expected, format!("{found:?}"))
    };
    Ok(match (&variable.variable_type, parameter) {
        (VariableType::Real(_), ParameterValue::Real { value, unit: from }) => {
            let (Some(from), Some(to)) = (from, description.unit(variable)) else {
                return Ok(Value::Real(*value));
            };
            let defined = units.iter().find(|unit| unit.name == *from);
            let conversion = match (defined, &to.base) {
                (Some(from), Some(to)) => from.base.conversion(to),
                (_, None) if *from == to.name => Some((1.0, 0.0)),
                _ => None,
            };
            match conversion {
                // a unit into itself leaves every bit, the sign of 0 too
                Some((1.0, 0.0)) => Value::Real(*value),
                Some((factor, offset)) => Value::Real(factor * value + offset),
                None => {
                    let expected = format!("a unit that converts to {:?}", to.name);
                    return Err(refuse(&expected, from));
                }
            }
        }
        (VariableType::Integer(_), ParameterValue::Integer(value)) => Value::Integer(*value),
        (VariableType::Boolean(_), ParameterValue::Boolean(value)) => Value::Boolean(*value),
        (VariableType::String(_), ParameterValue::String(value)) => Value::String(value.clone()),
        (VariableType::Enumeration(_), ParameterValue::Enumeration { value, .. }) => {
            let mut items = description.choices(variable).iter();
            let item = items.find(|item| item.name == *value);
            let item = item.ok_or_else(|| refuse("one of its choices", value))?;
            Value::Integer(item.value)
        }
        (expected, found) => return Err(wrong(variable, expected.name(), found.type_name())),
    })
}

fn wrong(variable: &ScalarVariable, expected: &'static str, found: &'static str) -> Error {
    Error::WrongType {
        name: variable.name.clone(),
        expected,
        found,
    }
}
