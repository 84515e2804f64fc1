//! System Structure and Parameterization (SSP 1.0): which FMUs make a system and how they are
//! connected (`SystemStructure.ssd`), and parameter sets (`*.ssv`).
//!
//! The types hold one system of FMUs with its connections and parameters. Reading takes any
//! prefixes, drops geometry and annotations, and refuses what the types cannot hold: systems in
//! systems, references to signal dictionaries, parameter mappings, transformations.

mod parameters;
mod raw;
#[cfg(test)]
mod tests;

pub use parameters::{Parameter, ParameterSet, ParameterValue};

use crate::BaseUnit;
use crate::xml::{self, Error, Format};
use raw::{RawComponent, RawConnection, RawConnector, RawParameterBinding};
use serde::{Deserialize, Serialize};

/// The version of SSP that is written.
pub const VERSION: &str = "1.0";

/// The root element of `SystemStructure.ssd`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename = "ssd:SystemStructureDescription")]
pub struct SystemStructureDescription {
    /// Version of the standard: "1.0".
    #[serde(rename = "@version")]
    pub version: String,
    /// Name of the description.
    #[serde(rename = "@name")]
    pub name: String,
    /// Tool that generated the file.
    #[serde(rename = "@generationTool", default)]
    pub generation_tool: Option<String>,
    /// The system.
    #[serde(rename = "ssd:System")]
    pub system: System,
    /// Enumerations the connectors refer to.
    #[serde(
        rename = "ssd:Enumerations",
        with = "raw::enumerations",
        default,
        skip_serializing_if = "Vec::is_empty"
    )]
    pub enumerations: Vec<Enumeration>,
    /// Units the connectors refer to.
    #[serde(
        rename = "ssd:Units",
        with = "raw::units",
        default,
        skip_serializing_if = "Vec::is_empty"
    )]
    pub units: Vec<Unit>,
    /// From when to when to simulate.
    #[serde(rename = "ssd:DefaultExperiment", default)]
    pub default_experiment: Option<DefaultExperiment>,
}

impl SystemStructureDescription {
    const FORMAT: Format = Format {
        what: "a system structure description of SSP 1",
        prefix: "ssd",
        root: "SystemStructureDescription",
    };

    /// The XML text, indented, ending in a newline.
    pub fn to_xml(&self) -> Result<String, Error> {
        xml::write(self, &["ssc", "ssd", "ssv"])
    }

    /// Reads the XML text; see [`ssp`](self) for what is dropped and what is refused.
    pub fn from_xml(xml: &str) -> Result<Self, Error> {
        let description: Self = xml::read(xml, &Self::FORMAT)?;
        Self::FORMAT.check_version(&description.version)?;
        Ok(description)
    }
}

/// A system: components and the connections between them.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct System {
    /// Name.
    #[serde(rename = "@name")]
    pub name: String,
    /// What it is.
    #[serde(rename = "@description", default)]
    pub description: Option<String>,
    /// What it shows to the outside.
    #[serde(
        rename = "ssd:Connectors",
        with = "raw::connectors",
        default,
        skip_serializing_if = "Vec::is_empty"
    )]
    pub connectors: Vec<Connector>,
    /// Parameters by hierarchical name, `component.variable`.
    #[serde(
        rename = "ssd:ParameterBindings",
        with = "raw::parameter_bindings",
        default,
        skip_serializing_if = "Vec::is_empty"
    )]
    pub parameter_bindings: Vec<ParameterBinding>,
    /// The FMUs.
    #[serde(
        rename = "ssd:Elements",
        with = "raw::elements",
        default,
        skip_serializing_if = "Vec::is_empty"
    )]
    pub components: Vec<Component>,
    /// The connections.
    #[serde(
        rename = "ssd:Connections",
        with = "raw::connections",
        default,
        skip_serializing_if = "Vec::is_empty"
    )]
    pub connections: Vec<Connection>,
}

/// An FMU in a system.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(try_from = "RawComponent", into = "RawComponent")]
pub struct Component {
    /// Name, unique within the system.
    pub name: String,
    /// URI of the FMU, relative to the description: `resources/x.fmu`.
    pub source: String,
    /// Which of the FMU's implementations is meant.
    pub implementation: Implementation,
    /// Variables of the FMU that connections name, at least.
    pub connectors: Vec<Connector>,
    /// Parameters by the FMU's names.
    pub parameter_bindings: Vec<ParameterBinding>,
}

/// Which of an FMU's implementations is meant.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub enum Implementation {
    /// The importer chooses.
    #[default]
    #[serde(rename = "any")]
    Any,
    /// Model exchange.
    ModelExchange,
    /// Co-simulation.
    CoSimulation,
}

/// A variable that connections can name.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(try_from = "RawConnector", into = "RawConnector")]
pub struct Connector {
    /// Name; of a component's connector that of the variable.
    pub name: String,
    /// Its part; of a component's connector the causality of the variable.
    pub kind: ConnectorKind,
    /// Its type. `None`: that of the variable.
    pub connector_type: Option<ConnectorType>,
}

/// The part of a connector.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "camelCase")]
pub enum ConnectorKind {
    /// Takes.
    #[default]
    Input,
    /// Gives.
    Output,
    /// Set before the start.
    Parameter,
    /// Computed before the start.
    CalculatedParameter,
    /// What its connections make it; of signal dictionaries only.
    Inout,
}

/// The type of a connector.
#[derive(Clone, Debug, PartialEq)]
pub enum ConnectorType {
    /// `Real`
    Real {
        /// One of the description's units. `None`: that of the variable.
        unit: Option<String>,
    },
    /// `Integer`
    Integer,
    /// `Boolean`
    Boolean,
    /// `String`
    String,
    /// `Enumeration`
    Enumeration {
        /// One of the description's enumerations.
        name: String,
    },
}

/// A connection. Start and end say nothing on the direction: that follows from the connectors'
/// kinds.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(try_from = "RawConnection", into = "RawConnection")]
pub struct Connection {
    /// Component of the start. `None`: the system.
    pub start_element: Option<String>,
    /// Connector of the start.
    pub start_connector: String,
    /// Component of the end. `None`: the system.
    pub end_element: Option<String>,
    /// Connector of the end.
    pub end_connector: String,
    /// Values pass as numbers, whatever the units.
    pub suppress_unit_conversion: bool,
}

/// Parameters for an element; of several for one variable the last holds, and those of a system
/// hold over those of its components.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(try_from = "RawParameterBinding", into = "RawParameterBinding")]
pub struct ParameterBinding {
    /// What is put before every name.
    pub prefix: String,
    /// The parameters.
    pub source: ParameterSource,
}

/// Where parameters stand.
#[derive(Clone, Debug, PartialEq)]
pub enum ParameterSource {
    /// URI of an SSV file, relative to the description: `resources/x.ssv`.
    File(String),
    /// In the description itself.
    Inline(ParameterSet),
}

/// A unit in SI units.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Unit {
    /// Name, e.g. `N.m`.
    #[serde(rename = "@name")]
    pub name: String,
    /// Its meaning.
    #[serde(rename = "ssc:BaseUnit")]
    pub base: BaseUnit,
}

impl Unit {
    /// A unit of FMI, where it is defined in SI units.
    pub fn of(unit: &crate::Unit) -> Option<Self> {
        Some(Self {
            name: unit.name.clone(),
            base: unit.base?,
        })
    }
}

/// The names of an enumeration.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct Enumeration {
    /// Name.
    #[serde(rename = "@name")]
    pub name: String,
    /// Name and value of each choice.
    #[serde(rename = "ssc:Item", default)]
    pub items: Vec<Item>,
}

/// One choice of an enumeration.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct Item {
    /// Name.
    #[serde(rename = "@name")]
    pub name: String,
    /// Value.
    #[serde(rename = "@value")]
    pub value: i32,
}

/// From when to when to simulate.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct DefaultExperiment {
    /// Start time \[s\].
    #[serde(rename = "@startTime", default)]
    pub start_time: Option<f64>,
    /// Stop time \[s\].
    #[serde(rename = "@stopTime", default)]
    pub stop_time: Option<f64>,
}
