//! `resources/start.json`: the start values an FMU was packed with, the same numbers bit for bit
//! as in its modelDescription.xml, for the binary to start from.

use crate::class::Class;
use crate::{Error, Model, State, Value};
use model_description::{ModelDescription, Variability, VariableType};
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;
use std::io::ErrorKind;
use std::path::Path;

/// Its name in the folder `resources`.
pub(crate) const FILE_NAME: &str = "start.json";

/// The file.
#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct Starts {
    /// That of the description it was packed with.
    guid: String,
    /// By name of variable.
    start: BTreeMap<String, Start>,
}

/// A start value; an enumeration's is its integer.
#[derive(Clone, Serialize, Deserialize)]
#[serde(untagged)]
enum Start {
    Boolean(bool),
    Integer(i32),
    Real(f64),
    String(String),
}

/// The file that belongs to `description`; constants are the binary's own.
pub(crate) fn to_json(description: &ModelDescription) -> String {
    let start = |variable_type: &VariableType| match variable_type {
        VariableType::Real(real) => real.start.map(Start::Real),
        VariableType::Integer(integer) => integer.start.map(Start::Integer),
        VariableType::Enumeration(enumeration) => enumeration.start.map(Start::Integer),
        VariableType::Boolean(boolean) => boolean.start.map(Start::Boolean),
        VariableType::String(string) => string.start.clone().map(Start::String),
    };
    let starts = Starts {
        guid: description.fingerprint(),
        start: description
            .variables
            .iter()
            .filter(|variable| variable.variability != Variability::Constant)
            .filter_map(|variable| Some((variable.name.clone(), start(&variable.variable_type)?)))
            .collect(),
    };
    let json = serde_json::to_string_pretty(&starts).expect("texts and numbers can be written");
    json + "\n"
}

/// The model with the start values that the file in `resources` gives; as compiled where there is
/// no such file.
pub(crate) fn model<M: Model>(class: &Class<M>, resources: Option<&Path>) -> Result<M, Error> {
    let mut model = M::new();
    let Some(path) = resources.map(|folder| folder.join(FILE_NAME)) else {
        return Ok(model);
    };
    let text = match std::fs::read_to_string(&path) {
        Ok(text) => text,
        Err(error) if error.kind() == ErrorKind::NotFound => return Ok(model),
        Err(source) => return Err(Error::File { path, source }),
    };
    let refuse = |why: String| Error::Start {
        path: path.clone(),
        why,
    };
    let starts: Starts = serde_json::from_str(&text).map_err(|error| refuse(error.to_string()))?;
    if starts.guid != class.guid {
        let (expected, found) = (&class.guid, &starts.guid);
        return Err(refuse(format!("guid: expected {expected}, found {found}")));
    }
    for (name, start) in starts.start {
        let reference = class
            .variables
            .find(&name)
            .ok_or_else(|| refuse(format!("expected a variable of the model, found {name}")))?;
        let value = match (start, class.variables.is_real(reference)) {
            (Start::Integer(value), true) => Value::Real(value.into()),
            (Start::Integer(value), false) => Value::Integer(value),
            (Start::Real(value), _) => Value::Real(value),
            (Start::Boolean(value), _) => Value::Boolean(value),
            (Start::String(value), _) => Value::String(value),
        };
        class
            .variables
            .check_set(reference, value.kind(), value.number(), State::Instantiated)
            .map_err(|error| refuse(error.to_string()))?;
        model.set(reference, value);
    }
    Ok(model)
}
