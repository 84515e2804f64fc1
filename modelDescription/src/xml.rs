//! The XML form: the only module that names the XML crates.

use crate::{
    BooleanVariable, Category, Causality, EnumerationType, EnumerationVariable, Initial,
    IntegerType, IntegerVariable, ModelDescription, RealType, RealVariable, ScalarVariable,
    SimpleType, StringVariable, TypeDefinition, Unit, Unknown, Variability, VariableType,
};
use serde::de::DeserializeOwned;
use serde::{Deserialize, Serialize};
use serde_xml_rs::SerdeXml;
use xml::EmitterConfig;

mod prefix;

/// A text that is no such description, or a value that cannot be written.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum Error {
    /// The XML could not be read.
    #[error("expected an FMI 2.0 model description: {0}")]
    Read(#[source] serde_xml_rs::Error),
    /// The description says it is of another version.
    #[error("expected fmiVersion \"2.0\", found \"{found}\"")]
    Version {
        /// The version found.
        found: String,
    },
    /// The XML of an SSP could not be read.
    #[error("expected {expected}: {source}")]
    Ssp {
        /// What was to be read.
        expected: &'static str,
        /// The reason.
        source: serde_xml_rs::Error,
    },
    /// The XML is another document.
    #[error("expected {expected}, found the element {found}")]
    Root {
        /// What was to be read.
        expected: &'static str,
        /// Its root element, with its namespace.
        found: String,
    },
    /// An SSP of another version.
    #[error("expected {expected}, found version {found:?}")]
    SspVersion {
        /// What was to be read.
        expected: &'static str,
        /// The version found.
        found: String,
    },
    /// The description could not be written.
    #[error("the description cannot be written as XML: {0}")]
    Write(#[source] serde_xml_rs::Error),
}

impl ModelDescription {
    /// The XML text, indented, ending in a newline.
    pub fn to_xml(&self) -> Result<String, Error> {
        write(self, &[])
    }

    /// Reads the XML text; unknown elements and attributes are ignored.
    pub fn from_xml(xml: &str) -> Result<Self, Error> {
        // Siblings of one kind may be separated by elements this crate does not know.
        let description: Self = SerdeXml::new()
            .overlapping_sequences(true)
            .from_str(xml.trim_start_matches('\u{feff}'))
            .map_err(Error::Read)?;
        // "future minor revisions are denoted as 2.0.1, 2.0.2 etc" (FMI 2.0 §2.2.1).
        if description.fmi_version == "2.0" || description.fmi_version.starts_with("2.0.") {
            Ok(description)
        } else {
            Err(Error::Version {
                found: description.fmi_version,
            })
        }
    }
}

/// The XML text of `value`, indented, ending in a newline; its root declares the namespaces of SSP
/// with these prefixes.
pub(crate) fn write<T: Serialize>(value: &T, prefixes: &[&str]) -> Result<String, Error> {
    let emitter = EmitterConfig::new()
        .perform_indent(true)
        .indent_string("  ")
        .pad_self_closing(false);
    let mut form = SerdeXml::new().emitter(emitter);
    for (prefix, uri) in prefix::NAMESPACES {
        if prefixes.contains(&prefix) {
            form = form.namespace(prefix, uri);
        }
    }
    let mut xml = form.to_string(value).map_err(Error::Write)?;
    xml.push('\n');
    Ok(with_tabs(&xml))
}

/// The XML crate writes tabs of attributes as they are, and they would be read as blanks. There
/// are no others: indentation is of blanks.
fn with_tabs(xml: &str) -> String {
    xml.replace('\t', "&#9;")
}

/// A document of SSP.
pub(crate) struct Format {
    /// What it is, in words.
    pub(crate) what: &'static str,
    /// Prefix of its namespace.
    pub(crate) prefix: &'static str,
    /// Name of its root element.
    pub(crate) root: &'static str,
}

impl Format {
    /// Refuses other versions than 1.
    pub(crate) fn check_version(&self, found: &str) -> Result<(), Error> {
        if found.starts_with("1.") {
            return Ok(());
        }
        Err(Error::SspVersion {
            expected: self.what,
            found: found.to_owned(),
        })
    }

    fn unreadable(&self, source: impl Into<serde_xml_rs::Error>) -> Error {
        Error::Ssp {
            expected: self.what,
            source: source.into(),
        }
    }
}

/// Reads a document of SSP; unknown elements and attributes are ignored.
pub(crate) fn read<T: DeserializeOwned>(xml: &str, format: &Format) -> Result<T, Error> {
    let xml = prefix::canonical(xml.trim_start_matches('\u{feff}'), format)?;
    SerdeXml::new()
        .overlapping_sequences(true)
        .from_str(&xml)
        .map_err(|error| format.unreadable(error))
}

/// A `Vec` as an element that contains one element for each item.
macro_rules! list {
    ($module:ident: $item:ty as $element:literal) => {
        pub(crate) mod $module {
            use super::*;

            #[derive(Serialize)]
            struct Borrowed<'a> {
                #[serde(rename = $element)]
                items: &'a [$item],
            }

            #[derive(Deserialize)]
            struct Owned {
                #[serde(rename = $element, default)]
                items: Vec<$item>,
            }

            pub(crate) fn serialize<S: serde::Serializer>(
                items: &[$item],
                serializer: S,
            ) -> Result<S::Ok, S::Error> {
                Borrowed { items }.serialize(serializer)
            }

            pub(crate) fn deserialize<'de, D: serde::Deserializer<'de>>(
                deserializer: D,
            ) -> Result<Vec<$item>, D::Error> {
                Ok(Owned::deserialize(deserializer)?.items)
            }
        }
    };
}

pub(crate) use list;

list!(units: Unit as "Unit");
list!(simple_types: SimpleType as "SimpleType");
list!(categories: Category as "Category");
list!(variables: ScalarVariable as "ScalarVariable");
list!(unknowns: Unknown as "Unknown");

/// `SimpleType` as it stands in the file: exactly one of five elements.
#[derive(Clone, Default, Serialize, Deserialize)]
pub(crate) struct RawSimpleType {
    #[serde(rename = "@name")]
    name: String,
    #[serde(rename = "@description", default)]
    description: Option<String>,
    #[serde(rename = "Real", default)]
    real: Option<RealType>,
    #[serde(rename = "Integer", default)]
    integer: Option<IntegerType>,
    #[serde(rename = "Boolean", default)]
    boolean: Option<Empty>,
    #[serde(rename = "String", default)]
    string: Option<Empty>,
    #[serde(rename = "Enumeration", default)]
    enumeration: Option<EnumerationType>,
}

/// An element without content.
#[derive(Clone, Default, Serialize, Deserialize)]
pub(crate) struct Empty {}

impl From<SimpleType> for RawSimpleType {
    fn from(simple: SimpleType) -> Self {
        let mut raw = Self {
            name: simple.name,
            description: simple.description,
            ..Self::default()
        };
        match simple.definition {
            TypeDefinition::Real(real) => raw.real = Some(real),
            TypeDefinition::Integer(integer) => raw.integer = Some(integer),
            TypeDefinition::Boolean => raw.boolean = Some(Empty {}),
            TypeDefinition::String => raw.string = Some(Empty {}),
            TypeDefinition::Enumeration(enumeration) => raw.enumeration = Some(enumeration),
        }
        raw
    }
}

impl TryFrom<RawSimpleType> for SimpleType {
    type Error = String;

    fn try_from(raw: RawSimpleType) -> Result<Self, String> {
        let definition = raw
            .real
            .map(TypeDefinition::Real)
            .or(raw.integer.map(TypeDefinition::Integer))
            .or(raw.boolean.map(|_| TypeDefinition::Boolean))
            .or(raw.string.map(|_| TypeDefinition::String))
            .or(raw.enumeration.map(TypeDefinition::Enumeration))
            .ok_or_else(|| untyped("SimpleType", &raw.name))?;
        Ok(Self {
            name: raw.name,
            description: raw.description,
            definition,
        })
    }
}

/// `ScalarVariable` as it stands in the file: exactly one of five elements.
#[derive(Clone, Default, Serialize, Deserialize)]
pub(crate) struct RawScalarVariable {
    #[serde(rename = "@name")]
    name: String,
    #[serde(rename = "@valueReference")]
    value_reference: u32,
    #[serde(rename = "@description", default)]
    description: Option<String>,
    #[serde(rename = "@causality", default)]
    causality: Causality,
    #[serde(rename = "@variability", default)]
    variability: Variability,
    #[serde(rename = "@initial", default)]
    initial: Option<Initial>,
    #[serde(rename = "Real", default)]
    real: Option<RealVariable>,
    #[serde(rename = "Integer", default)]
    integer: Option<IntegerVariable>,
    #[serde(rename = "Boolean", default)]
    boolean: Option<BooleanVariable>,
    #[serde(rename = "String", default)]
    string: Option<StringVariable>,
    #[serde(rename = "Enumeration", default)]
    enumeration: Option<EnumerationVariable>,
}

impl From<ScalarVariable> for RawScalarVariable {
    fn from(variable: ScalarVariable) -> Self {
        let mut raw = Self {
            name: variable.name,
            value_reference: variable.value_reference,
            description: variable.description,
            causality: variable.causality,
            variability: variable.variability,
            initial: variable.initial,
            ..Self::default()
        };
        match variable.variable_type {
            VariableType::Real(real) => raw.real = Some(real),
            VariableType::Integer(integer) => raw.integer = Some(integer),
            VariableType::Boolean(boolean) => raw.boolean = Some(boolean),
            VariableType::String(string) => raw.string = Some(string),
            VariableType::Enumeration(enumeration) => raw.enumeration = Some(enumeration),
        }
        raw
    }
}

impl TryFrom<RawScalarVariable> for ScalarVariable {
    type Error = String;

    fn try_from(raw: RawScalarVariable) -> Result<Self, String> {
        let variable_type = raw
            .real
            .map(VariableType::Real)
            .or(raw.integer.map(VariableType::Integer))
            .or(raw.boolean.map(VariableType::Boolean))
            .or(raw.string.map(VariableType::String))
            .or(raw.enumeration.map(VariableType::Enumeration))
            .ok_or_else(|| untyped("ScalarVariable", &raw.name))?;
        Ok(Self {
            name: raw.name,
            value_reference: raw.value_reference,
            description: raw.description,
            causality: raw.causality,
            variability: raw.variability,
            initial: raw.initial,
            variable_type,
        })
    }
}

pub(crate) fn untyped(element: &str, name: &str) -> String {
    format!(
        "{element} \"{name}\": expected one of Real, Integer, Boolean, String, Enumeration, found none"
    )
}

/// The schema's default of `factor`.
pub(crate) fn one() -> f64 {
    1.0
}

#[expect(
    clippy::trivially_copy_pass_by_ref,
    reason = "serde passes fields by reference"
)]
pub(crate) fn is_one(value: &f64) -> bool {
    *value == 1.0
}

pub(crate) fn is_zero<T: Default + PartialEq>(value: &T) -> bool {
    *value == T::default()
}
