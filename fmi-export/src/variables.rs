//! The rules of each variable: type, range, and when it may be set (FMI 2.0 §2.2.7, §4.2.4).

use crate::{Error, State, Value};
use model_description::{
    Causality, Initial, ModelDescription, RealVariable, ScalarVariable, TypeDefinition,
    Variability, VariableType,
};

/// What must be known of a variable to judge a call.
#[derive(Clone, Debug)]
struct Rule {
    name: String,
    causality: Causality,
    variability: Variability,
    initial: Option<Initial>,
    type_name: &'static str,
    min: f64,
    max: f64,
    /// After a space, or nothing.
    unit: String,
}

/// The rules of all variables, by value reference.
#[derive(Clone, Debug)]
pub(crate) struct Variables(Vec<Rule>);

impl Variables {
    pub(crate) fn new(description: &ModelDescription) -> Result<Self, Error> {
        description
            .variables
            .iter()
            .enumerate()
            .map(|(row, variable)| {
                if variable.value_reference as usize == row {
                    Rule::new(variable, description)
                } else {
                    Err(Error::Description(format!(
                        "variable {}: expected value reference {row}, its row number, found {}",
                        variable.name, variable.value_reference
                    )))
                }
            })
            .collect::<Result<_, _>>()
            .map(Self)
    }

    fn rule(&self, reference: u32) -> Result<&Rule, Error> {
        self.0
            .get(reference as usize)
            .ok_or(Error::UnknownReference {
                found: reference,
                count: self.0.len(),
            })
    }

    /// Whether the variable may be read as one of the types `types`.
    pub(crate) fn check_get(
        &self,
        reference: u32,
        types: &'static [&'static str],
    ) -> Result<(), Error> {
        self.rule(reference)?.check_type(types)
    }

    /// Whether the variable may be set to `value` in `state`.
    pub(crate) fn check_set(
        &self,
        reference: u32,
        types: &'static [&'static str],
        value: &Value,
        state: State,
    ) -> Result<(), Error> {
        let rule = self.rule(reference)?;
        rule.check_type(types)?;
        if !rule.settable_in(state) {
            return Err(Error::NotSettable {
                name: rule.name.clone(),
                causality: rule.causality,
                variability: rule.variability,
                state,
            });
        }
        match *value {
            Value::Real(value) => rule.check_range(value),
            Value::Integer(value) => rule.check_range(f64::from(value)),
            Value::Boolean(_) | Value::String(_) => Ok(()),
        }
    }

    /// Whether the model computes the variable's value; others hold what was set.
    pub(crate) fn is_computed(&self, reference: u32) -> bool {
        self.0.get(reference as usize).is_some_and(|rule| {
            rule.initial == Some(Initial::Calculated) || rule.causality == Causality::Independent
        })
    }

    /// The error for a model whose value is not of the described type.
    pub(crate) fn mistyped(&self, reference: u32, value: &Value) -> Error {
        let name = self
            .0
            .get(reference as usize)
            .map_or("?", |rule| &rule.name);
        Error::Description(format!(
            "variable {name}: the model gives {value:?}, which is of another type"
        ))
    }
}

impl Rule {
    fn new(variable: &ScalarVariable, description: &ModelDescription) -> Result<Self, Error> {
        let unbounded = (f64::NEG_INFINITY, f64::INFINITY);
        let (min, max) = match &variable.variable_type {
            VariableType::Real(RealVariable { min, max, .. }) => {
                (min.unwrap_or(unbounded.0), max.unwrap_or(unbounded.1))
            }
            VariableType::Integer(integer) => (
                integer.min.map_or(unbounded.0, f64::from),
                integer.max.map_or(unbounded.1, f64::from),
            ),
            VariableType::Enumeration(enumeration) => {
                match description
                    .simple_type(&enumeration.declared_type)
                    .map(|simple| &simple.definition)
                {
                    // The items of an enumeration exported here are numbered without gaps.
                    Some(TypeDefinition::Enumeration(choices)) => choices
                        .items
                        .iter()
                        .map(|item| f64::from(item.value))
                        .fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), value| {
                            (low.min(value), high.max(value))
                        }),
                    _ => {
                        return Err(Error::Description(format!(
                            "variable {}: expected an enumeration type, found {}",
                            variable.name, enumeration.declared_type
                        )));
                    }
                }
            }
            VariableType::Boolean(_) | VariableType::String(_) => unbounded,
        };
        Ok(Self {
            name: variable.name.clone(),
            causality: variable.causality,
            variability: variable.variability,
            initial: variable.initial(),
            type_name: variable.variable_type.name(),
            min,
            max,
            unit: variable
                .unit()
                .map_or_else(String::new, |unit| format!(" {unit}")),
        })
    }

    fn check_type(&self, types: &'static [&'static str]) -> Result<(), Error> {
        if types.contains(&self.type_name) {
            Ok(())
        } else {
            Err(Error::WrongType {
                name: self.name.clone(),
                expected: self.type_name,
                found: types[0],
            })
        }
    }

    /// The footnotes of the table of FMI 2.0 §4.2.4. Inputs in *instantiated* are our leniency:
    /// importers set them there.
    fn settable_in(&self, state: State) -> bool {
        let input = self.causality == Causality::Input;
        let constant = self.variability == Variability::Constant;
        match state {
            State::Instantiated => {
                input || !constant && matches!(self.initial, Some(Initial::Exact | Initial::Approx))
            }
            State::Initialization => input || !constant && self.initial == Some(Initial::Exact),
            State::StepComplete => {
                input
                    || self.causality == Causality::Parameter
                        && self.variability == Variability::Tunable
            }
            State::StepFailed | State::Terminated => false,
        }
    }

    fn check_range(&self, found: f64) -> Result<(), Error> {
        if !found.is_finite() {
            Err(Error::NotFinite {
                name: self.name.clone(),
                found,
            })
        } else if (self.min..=self.max).contains(&found) {
            Ok(())
        } else {
            Err(Error::OutOfRange {
                name: self.name.clone(),
                min: self.min,
                max: self.max,
                unit: self.unit.clone(),
                found,
            })
        }
    }
}
