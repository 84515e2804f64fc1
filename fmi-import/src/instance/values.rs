//! Values of variables, in and out.

use super::host::owned;
use super::{Instance, c_texts, same_length};
use crate::Error;
use fmi2::{fmi2Boolean, fmi2False, fmi2String};
use model_description::{ScalarVariable, VariableType};
use serde::Serialize;
use std::fmt;
use std::ptr::null;

/// A value of any of the five types; an enumeration travels as its integer.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[serde(untagged)]
pub enum Value {
    /// `Real`
    Real(f64),
    /// `Integer` or `Enumeration`
    Integer(i32),
    /// `Boolean`
    Boolean(bool),
    /// `String`
    String(String),
}

impl fmt::Display for Value {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        match self {
            Self::Real(value) => value.fmt(f),
            Self::Integer(value) => value.fmt(f),
            Self::Boolean(value) => value.fmt(f),
            Self::String(value) => value.fmt(f),
        }
    }
}

impl Value {
    pub(crate) fn type_name(&self) -> &'static str {
        match self {
            Self::Real(_) => "Real",
            Self::Integer(_) => "Integer",
            Self::Boolean(_) => "Boolean",
            Self::String(_) => "String",
        }
    }

    /// Whether it is a value for `variable`.
    pub(crate) fn check_type(&self, variable: &ScalarVariable) -> Result<(), Error> {
        match (&variable.variable_type, self) {
            (VariableType::Real(_), Self::Real(_))
            | (VariableType::Integer(_) | VariableType::Enumeration(_), Self::Integer(_))
            | (VariableType::Boolean(_), Self::Boolean(_))
            | (VariableType::String(_), Self::String(_)) => Ok(()),
            (expected, found) => Err(Error::WrongType {
                name: variable.name.clone(),
                expected: expected.name(),
                found: found.type_name(),
            }),
        }
    }
}

/// Calls that hand over the importer's array as it is.
macro_rules! numbers {
    ($($(#[$doc:meta])* $name:ident($values:ident: $type:ty) = $function:literal, $pointer:ident;)*) => {
        $(
            $(#[$doc])*
            pub fn $name(&mut self, references: &[u32], $values: $type) -> Result<(), Error> {
                same_length(references.len(), $values.len())?;
                if references.is_empty() {
                    return Ok(());
                }
                self.core.call($function, |i| {
                    // SAFETY: the component is alive, both arrays have the length given.
                    unsafe {
                        (i.fmu.functions.$name)(
                            i.component,
                            references.as_ptr(),
                            references.len(),
                            $values.$pointer(),
                        )
                    }
                })
            }
        )*
    };
}

/// Nothing to read or set is no call: some FMUs refuse it.
impl Instance<'_> {
    numbers! {
        /// Reads `Real` variables into `values`, one for each value reference.
        get_real(values: &mut [f64]) = "fmi2GetReal", as_mut_ptr;
        /// Reads `Integer` and `Enumeration` variables into `values`.
        get_integer(values: &mut [i32]) = "fmi2GetInteger", as_mut_ptr;
        /// Sets `Real` variables.
        set_real(values: &[f64]) = "fmi2SetReal", as_ptr;
        /// Sets `Integer` and `Enumeration` variables.
        set_integer(values: &[i32]) = "fmi2SetInteger", as_ptr;
    }

    /// Reads `Boolean` variables into `values`.
    pub fn get_boolean(&mut self, references: &[u32], values: &mut [bool]) -> Result<(), Error> {
        same_length(references.len(), values.len())?;
        if references.is_empty() {
            return Ok(());
        }
        let mut found = vec![fmi2False; values.len()];
        self.core.call("fmi2GetBoolean", |i| {
            // SAFETY: the component is alive, both arrays have the length given.
            unsafe {
                (i.fmu.functions.get_boolean)(
                    i.component,
                    references.as_ptr(),
                    references.len(),
                    found.as_mut_ptr(),
                )
            }
        })?;
        for (value, found) in values.iter_mut().zip(found) {
            *value = found != fmi2False;
        }
        Ok(())
    }

    /// Reads `String` variables into `values`; bytes that are not UTF-8 are replaced.
    pub fn get_string(&mut self, references: &[u32], values: &mut [String]) -> Result<(), Error> {
        same_length(references.len(), values.len())?;
        if references.is_empty() {
            return Ok(());
        }
        let mut found: Vec<fmi2String> = vec![null(); values.len()];
        self.core.call("fmi2GetString", |i| {
            // SAFETY: the component is alive, both arrays have the length given.
            unsafe {
                (i.fmu.functions.get_string)(
                    i.component,
                    references.as_ptr(),
                    references.len(),
                    found.as_mut_ptr(),
                )
            }
        })?;
        for (value, found) in values.iter_mut().zip(found) {
            // SAFETY: the FMU keeps its texts until its next function is called.
            *value = unsafe { owned(found) };
        }
        Ok(())
    }

    /// Sets `Boolean` variables.
    pub fn set_boolean(&mut self, references: &[u32], values: &[bool]) -> Result<(), Error> {
        same_length(references.len(), values.len())?;
        if references.is_empty() {
            return Ok(());
        }
        let values: Vec<fmi2Boolean> = values.iter().map(|&value| value.into()).collect();
        self.core.call("fmi2SetBoolean", |i| {
            // SAFETY: the component is alive, both arrays have the length given.
            unsafe {
                (i.fmu.functions.set_boolean)(
                    i.component,
                    references.as_ptr(),
                    references.len(),
                    values.as_ptr(),
                )
            }
        })
    }

    /// Sets `String` variables.
    pub fn set_string(&mut self, references: &[u32], values: &[&str]) -> Result<(), Error> {
        same_length(references.len(), values.len())?;
        if references.is_empty() {
            return Ok(());
        }
        let texts = c_texts("value", values)?;
        let pointers: Vec<fmi2String> = texts.iter().map(|text| text.as_ptr()).collect();
        self.core.call("fmi2SetString", |i| {
            // SAFETY: the component is alive, both arrays have the length given, and the texts
            // outlive the call.
            unsafe {
                (i.fmu.functions.set_string)(
                    i.component,
                    references.as_ptr(),
                    references.len(),
                    pointers.as_ptr(),
                )
            }
        })
    }

    /// Reads one variable of any type.
    pub fn get(&mut self, variable: &ScalarVariable) -> Result<Value, Error> {
        let reference = [variable.value_reference];
        Ok(match variable.variable_type {
            VariableType::Real(_) => {
                let mut value = [0.0];
                self.get_real(&reference, &mut value)?;
                Value::Real(value[0])
            }
            VariableType::Integer(_) | VariableType::Enumeration(_) => {
                let mut value = [0];
                self.get_integer(&reference, &mut value)?;
                Value::Integer(value[0])
            }
            VariableType::Boolean(_) => {
                let mut value = [false];
                self.get_boolean(&reference, &mut value)?;
                Value::Boolean(value[0])
            }
            VariableType::String(_) => {
                let mut value = [String::new()];
                self.get_string(&reference, &mut value)?;
                let [value] = value;
                Value::String(value)
            }
        })
    }

    /// Sets one variable to a value of its type.
    pub fn set(&mut self, variable: &ScalarVariable, value: &Value) -> Result<(), Error> {
        value.check_type(variable)?;
        let reference = [variable.value_reference];
        match value {
            Value::Real(value) => self.set_real(&reference, &[*value]),
            Value::Integer(value) => self.set_integer(&reference, &[*value]),
            Value::Boolean(value) => self.set_boolean(&reference, &[*value]),
            Value::String(value) => self.set_string(&reference, &[value]),
        }
    }
}
