//! Scalar variables (FMI 2.0 §2.2.7).

use crate::xml::RawScalarVariable;
use serde::{Deserialize, Serialize};

/// One variable of the model.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(try_from = "RawScalarVariable", into = "RawScalarVariable")]
pub struct ScalarVariable {
    /// Unique name.
    pub name: String,
    /// Handle in function calls.
    pub value_reference: u32,
    /// What the variable is.
    pub description: Option<String>,
    /// Its part in the model.
    pub causality: Causality,
    /// When it may change.
    pub variability: Variability,
    /// How it is initialised, where it differs from the default;
    /// see [`ScalarVariable::initial`].
    pub initial: Option<Initial>,
    /// Type with attributes and start value.
    pub variable_type: VariableType,
}

impl ScalarVariable {
    /// How the variable is initialised: as given, else the default of its causality and
    /// variability (table on page 51 of FMI 2.0); `None` for inputs and the independent
    /// variable, which have none.
    pub fn initial(&self) -> Option<Initial> {
        use Causality::{CalculatedParameter, Independent, Input, Local, Output, Parameter};
        self.initial.or(match (self.causality, self.variability) {
            (Input | Independent, _) => None,
            (Parameter, _) | (_, Variability::Constant) => Some(Initial::Exact),
            (CalculatedParameter | Output | Local, _) => Some(Initial::Calculated),
        })
    }

    /// The unit of a `Real`, if it states one.
    pub fn unit(&self) -> Option<&str> {
        match &self.variable_type {
            VariableType::Real(real) => real.unit.as_deref(),
            _ => None,
        }
    }
}

/// The part of a variable in the model.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "camelCase")]
pub enum Causality {
    /// Set from outside, constant during simulation unless tunable.
    Parameter,
    /// Computed from parameters.
    CalculatedParameter,
    /// Given by another model.
    Input,
    /// Offered to other models.
    Output,
    /// Neither; for looking at.
    #[default]
    Local,
    /// The independent variable, time.
    Independent,
}

/// When a variable may change.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "camelCase")]
pub enum Variability {
    /// Never.
    Constant,
    /// Until the end of initialization.
    Fixed,
    /// Between communication steps, from outside.
    Tunable,
    /// At events.
    Discrete,
    /// Always.
    #[default]
    Continuous,
}

/// How a variable gets its first value.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "camelCase")]
pub enum Initial {
    /// Its start value.
    Exact,
    /// An iteration from its start value.
    Approx,
    /// Computed from other variables.
    Calculated,
}

/// The type of a variable, with its attributes.
#[derive(Clone, Debug, PartialEq)]
pub enum VariableType {
    /// `Real`
    Real(RealVariable),
    /// `Integer`
    Integer(IntegerVariable),
    /// `Boolean`
    Boolean(BooleanVariable),
    /// `String`
    String(StringVariable),
    /// `Enumeration`
    Enumeration(EnumerationVariable),
}

impl VariableType {
    /// The name of the type as the standard spells it.
    pub fn name(&self) -> &'static str {
        match self {
            Self::Real(_) => "Real",
            Self::Integer(_) => "Integer",
            Self::Boolean(_) => "Boolean",
            Self::String(_) => "String",
            Self::Enumeration(_) => "Enumeration",
        }
    }
}

/// Attributes of a `Real` variable.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct RealVariable {
    /// Name of a defined type that gives defaults.
    #[serde(rename = "@declaredType", default)]
    pub declared_type: Option<String>,
    /// Physical quantity.
    #[serde(rename = "@quantity", default)]
    pub quantity: Option<String>,
    /// Unit, one of the unit definitions.
    #[serde(rename = "@unit", default)]
    pub unit: Option<String>,
    /// Unit for display, one of the unit's display units.
    #[serde(rename = "@displayUnit", default)]
    pub display_unit: Option<String>,
    /// The display unit's offset does not apply.
    #[serde(
        rename = "@relativeQuantity",
        default,
        skip_serializing_if = "std::ops::Not::not"
    )]
    pub relative_quantity: bool,
    /// Smallest value.
    #[serde(rename = "@min", default)]
    pub min: Option<f64>,
    /// Largest value.
    #[serde(rename = "@max", default)]
    pub max: Option<f64>,
    /// Typical magnitude.
    #[serde(rename = "@nominal", default)]
    pub nominal: Option<f64>,
    /// May grow without bound.
    #[serde(
        rename = "@unbounded",
        default,
        skip_serializing_if = "std::ops::Not::not"
    )]
    pub unbounded: bool,
    /// First value.
    #[serde(rename = "@start", default)]
    pub start: Option<f64>,
    /// 1-based index of the variable this is the derivative of.
    #[serde(rename = "@derivative", default)]
    pub derivative: Option<u32>,
    /// May jump at events (model exchange).
    #[serde(
        rename = "@reinit",
        default,
        skip_serializing_if = "std::ops::Not::not"
    )]
    pub reinit: bool,
}

/// Attributes of an `Integer` variable.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct IntegerVariable {
    /// Name of a defined type that gives defaults.
    #[serde(rename = "@declaredType", default)]
    pub declared_type: Option<String>,
    /// Physical quantity.
    #[serde(rename = "@quantity", default)]
    pub quantity: Option<String>,
    /// Smallest value.
    #[serde(rename = "@min", default)]
    pub min: Option<i32>,
    /// Largest value.
    #[serde(rename = "@max", default)]
    pub max: Option<i32>,
    /// First value.
    #[serde(rename = "@start", default)]
    pub start: Option<i32>,
}

/// Attributes of a `Boolean` variable.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct BooleanVariable {
    /// Name of a defined type.
    #[serde(rename = "@declaredType", default)]
    pub declared_type: Option<String>,
    /// First value.
    #[serde(rename = "@start", default)]
    pub start: Option<bool>,
}

/// Attributes of a `String` variable.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct StringVariable {
    /// Name of a defined type.
    #[serde(rename = "@declaredType", default)]
    pub declared_type: Option<String>,
    /// First value.
    #[serde(rename = "@start", default)]
    pub start: Option<String>,
}

/// Attributes of an `Enumeration` variable.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct EnumerationVariable {
    /// Name of the defined type that lists the choices.
    #[serde(rename = "@declaredType")]
    pub declared_type: String,
    /// Physical quantity.
    #[serde(rename = "@quantity", default)]
    pub quantity: Option<String>,
    /// Smallest value.
    #[serde(rename = "@min", default)]
    pub min: Option<i32>,
    /// Largest value.
    #[serde(rename = "@max", default)]
    pub max: Option<i32>,
    /// First value.
    #[serde(rename = "@start", default)]
    pub start: Option<i32>,
}
