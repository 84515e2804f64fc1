//! modelDescription.xml of FMI 2.0 as types: read, write, fingerprint; and in [`ssp`] systems of
//! FMUs and parameter sets of SSP 1.0.
//!
//! The types follow FMI 2.0 §2.2 and §4.3.1; optional attributes are
//! `Option`s, attributes with a default in the schema hold that default.
//! Reading tolerates elements and attributes it does not know (they are
//! dropped); writing then reading gives back the same value.
#![forbid(unsafe_code)]

mod fingerprint;
mod platform;
pub mod ssp;
mod structure;
mod types;
mod variable;
mod xml;

pub use platform::Platform;
pub use structure::{DependencyKind, ModelStructure, Unknown};
pub use types::{
    BaseUnit, DisplayUnit, EnumerationType, IntegerType, Item, RealType, SimpleType,
    TypeDefinition, Unit,
};
pub use variable::{
    BooleanVariable, Causality, EnumerationVariable, Initial, IntegerVariable, RealVariable,
    ScalarVariable, StringVariable, Variability, VariableType,
};
pub use xml::Error;

use serde::{Deserialize, Serialize};

/// The root element `fmiModelDescription` (FMI 2.0 §2.2.1).
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename = "fmiModelDescription")]
pub struct ModelDescription {
    /// Version of the standard: "2.0".
    #[serde(rename = "@fmiVersion")]
    pub fmi_version: String,
    /// Name of the model.
    #[serde(rename = "@modelName")]
    pub model_name: String,
    /// Ties this description to its binaries; see [`ModelDescription::fingerprint`].
    #[serde(rename = "@guid")]
    pub guid: String,
    /// One sentence on the model.
    #[serde(rename = "@description", default)]
    pub description: Option<String>,
    /// Who made the model.
    #[serde(rename = "@author", default)]
    pub author: Option<String>,
    /// Version of the model.
    #[serde(rename = "@version", default)]
    pub version: Option<String>,
    /// Copyright line.
    #[serde(rename = "@copyright", default)]
    pub copyright: Option<String>,
    /// Licence.
    #[serde(rename = "@license", default)]
    pub license: Option<String>,
    /// Tool that generated the file.
    #[serde(rename = "@generationTool", default)]
    pub generation_tool: Option<String>,
    /// Date of generation, `xs:dateTime`.
    #[serde(rename = "@generationDateAndTime", default)]
    pub generation_date_and_time: Option<String>,
    /// How variable names are formed.
    #[serde(rename = "@variableNamingConvention", default)]
    pub variable_naming_convention: NamingConvention,
    /// Present if the FMU offers model exchange.
    #[serde(rename = "ModelExchange", default)]
    pub model_exchange: Option<ModelExchange>,
    /// Present if the FMU offers co-simulation.
    #[serde(rename = "CoSimulation", default)]
    pub co_simulation: Option<CoSimulation>,
    /// Units used by the variables.
    #[serde(
        rename = "UnitDefinitions",
        with = "xml::units",
        default,
        skip_serializing_if = "Vec::is_empty"
    )]
    pub units: Vec<Unit>,
    /// Types used by the variables.
    #[serde(
        rename = "TypeDefinitions",
        with = "xml::simple_types",
        default,
        skip_serializing_if = "Vec::is_empty"
    )]
    pub types: Vec<SimpleType>,
    /// Categories of log lines.
    #[serde(
        rename = "LogCategories",
        with = "xml::categories",
        default,
        skip_serializing_if = "Vec::is_empty"
    )]
    pub log_categories: Vec<Category>,
    /// A simulation set-up that makes sense for this model.
    #[serde(rename = "DefaultExperiment", default)]
    pub default_experiment: Option<DefaultExperiment>,
    /// All variables; their 1-based positions are the indices of [`ModelStructure`].
    #[serde(rename = "ModelVariables", with = "xml::variables", default)]
    pub variables: Vec<ScalarVariable>,
    /// Outputs and initial unknowns with their dependencies.
    #[serde(rename = "ModelStructure", default)]
    pub structure: ModelStructure,
}

impl Default for ModelDescription {
    /// An empty description of FMI version 2.0.
    fn default() -> Self {
        Self {
            fmi_version: "2.0".to_owned(),
            model_name: String::new(),
            guid: String::new(),
            description: None,
            author: None,
            version: None,
            copyright: None,
            license: None,
            generation_tool: None,
            generation_date_and_time: None,
            variable_naming_convention: NamingConvention::Flat,
            model_exchange: None,
            co_simulation: None,
            units: Vec::new(),
            types: Vec::new(),
            log_categories: Vec::new(),
            default_experiment: None,
            variables: Vec::new(),
            structure: ModelStructure::default(),
        }
    }
}

impl ModelDescription {
    /// The variable called `name`.
    pub fn variable(&self, name: &str) -> Option<&ScalarVariable> {
        self.variables.iter().find(|variable| variable.name == name)
    }

    /// The type called `name`.
    pub fn simple_type(&self, name: &str) -> Option<&SimpleType> {
        self.types.iter().find(|simple| simple.name == name)
    }

    /// The unit of a `Real`, its own or else its type's, as this description defines it.
    pub fn unit(&self, variable: &ScalarVariable) -> Option<&Unit> {
        let VariableType::Real(real) = &variable.variable_type else {
            return None;
        };
        let of_type = || match &self.simple_type(real.declared_type.as_ref()?)?.definition {
            TypeDefinition::Real(definition) => definition.unit.as_ref(),
            _ => None,
        };
        let name = real.unit.as_ref().or_else(of_type)?;
        self.units.iter().find(|unit| unit.name == *name)
    }

    /// The choices of an `Enumeration`; none of any other type.
    pub fn choices(&self, variable: &ScalarVariable) -> &[Item] {
        let VariableType::Enumeration(enumeration) = &variable.variable_type else {
            return &[];
        };
        let declared = self.simple_type(&enumeration.declared_type);
        match declared.map(|declared| &declared.definition) {
            Some(TypeDefinition::Enumeration(definition)) => &definition.items,
            _ => &[],
        }
    }
}

/// How variable names are formed (FMI 2.0 §2.2.9).
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "camelCase")]
pub enum NamingConvention {
    /// A list of strings.
    #[default]
    Flat,
    /// Hierarchical names with dots, arrays and derivatives.
    Structured,
}

/// That the FMU offers model exchange (FMI 2.0 §3.3.1); capabilities are not kept.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct ModelExchange {
    /// Name of the shared library without suffix.
    #[serde(rename = "@modelIdentifier")]
    pub model_identifier: String,
}

/// Capabilities of a co-simulation FMU (FMI 2.0 §4.3.1).
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[expect(
    clippy::struct_excessive_bools,
    reason = "the standard has ten independent flags"
)]
pub struct CoSimulation {
    /// Name of the shared library without suffix.
    #[serde(rename = "@modelIdentifier")]
    pub model_identifier: String,
    /// The FMU talks to a tool that must be installed.
    #[serde(rename = "@needsExecutionTool", default)]
    pub needs_execution_tool: bool,
    /// Communication steps may differ in length.
    #[serde(rename = "@canHandleVariableCommunicationStepSize", default)]
    pub can_handle_variable_communication_step_size: bool,
    /// `fmi2SetRealInputDerivatives` works.
    #[serde(rename = "@canInterpolateInputs", default)]
    pub can_interpolate_inputs: bool,
    /// Highest order `fmi2GetRealOutputDerivatives` gives; 0: none.
    #[serde(rename = "@maxOutputDerivativeOrder", default)]
    pub max_output_derivative_order: u32,
    /// `fmi2DoStep` may return before the step is done. (The standard's spelling.)
    #[serde(rename = "@canRunAsynchronuously", default)]
    pub can_run_asynchronuously: bool,
    /// At most one instance per process.
    #[serde(rename = "@canBeInstantiatedOnlyOncePerProcess", default)]
    pub can_be_instantiated_only_once_per_process: bool,
    /// The FMU does not call `allocateMemory` and `freeMemory`.
    #[serde(rename = "@canNotUseMemoryManagementFunctions", default)]
    pub can_not_use_memory_management_functions: bool,
    /// State can be saved and restored.
    #[serde(rename = "@canGetAndSetFMUstate", default)]
    pub can_get_and_set_fmu_state: bool,
    /// A saved state can be turned into bytes and back.
    #[serde(rename = "@canSerializeFMUstate", default)]
    pub can_serialize_fmu_state: bool,
    /// `fmi2GetDirectionalDerivative` works.
    #[serde(rename = "@providesDirectionalDerivative", default)]
    pub provides_directional_derivative: bool,
}

/// A category of log lines (FMI 2.0 §2.2.4).
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct Category {
    /// Name, e.g. `logStatusError`.
    #[serde(rename = "@name")]
    pub name: String,
    /// What is logged under it.
    #[serde(rename = "@description", default)]
    pub description: Option<String>,
}

/// A simulation set-up that makes sense for the model (FMI 2.0 §2.2.5); times in s.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct DefaultExperiment {
    /// Start time \[s\].
    #[serde(rename = "@startTime", default)]
    pub start_time: Option<f64>,
    /// Stop time \[s\].
    #[serde(rename = "@stopTime", default)]
    pub stop_time: Option<f64>,
    /// Relative tolerance of the integration.
    #[serde(rename = "@tolerance", default)]
    pub tolerance: Option<f64>,
    /// Preferred communication step \[s\].
    #[serde(rename = "@stepSize", default)]
    pub step_size: Option<f64>,
}

#[cfg(test)]
mod tests;
