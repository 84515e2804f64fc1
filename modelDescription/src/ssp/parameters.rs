//! Parameter sets, the SSV format.

use super::raw::{self, RawParameter};
use super::{Enumeration, Unit, VERSION};
use crate::xml::{self, Error, Format};
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
