//! Parameter sets, the SSV format.

use super::raw::{self, RawParameter};
use super::{Enumeration, Item, Unit, VERSION};
use crate::xml::{self, Error, Format};
use crate::{Causality, Initial, ModelDescription, ScalarVariable, Variability, VariableType};
use serde::{Deserialize, Serialize};

/// The root element of an SSV file: values by name.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename = "ssv:ParameterSet")]
pub struct ParameterSet {
    /// Version of the standard: "1.0".
    #[serde(rename = "@version")]
    pub version: String,
    /// Name.
    #[serde(rename = "@name")]
    pub name: String,
    /// What it is.
    #[serde(rename = "@description", default)]
    pub description: Option<String>,
    /// Tool that generated the file.
    #[serde(rename = "@generationTool", default)]
    pub generation_tool: Option<String>,
    /// The parameters; their names are unique.
    #[serde(rename = "ssv:Parameters", with = "raw::parameters")]
    pub parameters: Vec<Parameter>,
    /// Enumerations the parameters refer to.
    #[serde(
        rename = "ssv:Enumerations",
        with = "raw::enumerations",
        default,
        skip_serializing_if = "Vec::is_empty"
    )]
    pub enumerations: Vec<Enumeration>,
    /// Units the parameters refer to.
    #[serde(
        rename = "ssv:Units",
        with = "raw::units",
        default,
        skip_serializing_if = "Vec::is_empty"
    )]
    pub units: Vec<Unit>,
}

impl Default for ParameterSet {
    /// An empty set of SSP version 1.0.
    fn default() -> Self {
        Self {
            version: VERSION.to_owned(),
            name: String::new(),
            description: None,
            generation_tool: None,
            parameters: Vec::new(),
            enumerations: Vec::new(),
            units: Vec::new(),
        }
    }
}

impl ParameterSet {
    const FORMAT: Format = Format {
        what: "a parameter set of SSP 1",
        prefix: "ssv",
        root: "ParameterSet",
    };

    /// The start values of what can be set before the start (SSP 1.0, ParameterBinding: inputs, and what has
    /// an exact or approximate one and is no constant), under the variables' names.
    pub fn of_starts(description: &ModelDescription) -> Self {
        let mut set = Self {
            name: description.model_name.clone(),
            ..Self::default()
        };
        for variable in &description.variables {
            let has_start = matches!(variable.initial(), Some(Initial::Exact | Initial::Approx));
            let can_be_set = variable.causality == Causality::Input
                || has_start && variable.variability != Variability::Constant;
            if let Some(value) = set.start(description, variable).filter(|_| can_be_set) {
                set.parameters.push(Parameter {
                    name: variable.name.clone(),
                    description: variable.description.clone(),
                    value,
                });
            }
        }
        set
    }

    /// The start value of `variable`; defines its unit or its choices, where they can be.
    fn start(
        &mut self,
        description: &ModelDescription,
        variable: &ScalarVariable,
    ) -> Option<ParameterValue> {
        Some(match &variable.variable_type {
            VariableType::Real(real) => {
                let value = real.start?;
                let unit = description.unit(variable).and_then(Unit::of);
                if let Some(unit) = unit.iter().find(|unit| !self.units.contains(unit)) {
                    self.units.push(unit.clone());
                }
                ParameterValue::Real {
                    value,
                    unit: unit.map(|unit| unit.name),
                }
            }
            VariableType::Integer(integer) => ParameterValue::Integer(integer.start?),
            VariableType::Boolean(boolean) => ParameterValue::Boolean(boolean.start?),
            VariableType::String(string) => ParameterValue::String(string.start.clone()?),
            VariableType::Enumeration(enumeration) => {
                let choices = description.choices(variable).iter();
                let items: Vec<Item> = choices
                    .map(|choice| Item {
                        name: choice.name.clone(),
                        value: choice.value,
                    })
                    .collect();
                let start = enumeration.start?;
                let value = items.iter().find(|item| item.value == start)?.name.clone();
                let name = enumeration.declared_type.clone();
                if self.enumerations.iter().all(|known| known.name != name) {
                    self.enumerations.push(Enumeration {
                        name: name.clone(),
                        items,
                    });
                }
                ParameterValue::Enumeration {
                    value,
                    name: Some(name),
                }
            }
        })
    }

    /// The XML text, indented, ending in a newline.
    pub fn to_xml(&self) -> Result<String, Error> {
        xml::write(self, &["ssc", "ssv"])
    }

    /// Reads the XML text.
    pub fn from_xml(xml: &str) -> Result<Self, Error> {
        let set: Self = xml::read(xml, &Self::FORMAT)?;
        Self::FORMAT.check_version(&set.version)?;
        Ok(set)
    }
}

/// A value by name.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(try_from = "RawParameter", into = "RawParameter")]
pub struct Parameter {
    /// Name.
    pub name: String,
    /// What it is.
    pub description: Option<String>,
    /// Value.
    pub value: ParameterValue,
}

/// A value of one of the five types; binary ones are not held.
#[derive(Clone, Debug, PartialEq)]
pub enum ParameterValue {
    /// `Real`
    Real {
        /// Value.
        value: f64,
        /// One of the set's units. `None`: that of the variable.
        unit: Option<String>,
    },
    /// `Integer`
    Integer(i32),
    /// `Boolean`
    Boolean(bool),
    /// `String`
    String(String),
    /// `Enumeration`
    Enumeration {
        /// Name of the choice; its number is the variable's affair.
        value: String,
        /// One of the set's enumerations.
        name: Option<String>,
    },
}

impl ParameterValue {
    /// The name of the type as the standard spells it.
    pub fn type_name(&self) -> &'static str {
        match self {
            Self::Real { .. } => "Real",
            Self::Integer(_) => "Integer",
            Self::Boolean(_) => "Boolean",
            Self::String(_) => "String",
            Self::Enumeration { .. } => "Enumeration",
        }
    }
}
