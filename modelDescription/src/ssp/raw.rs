//! SSP elements as they stand in the files, and lists of them.

use super::{
    Component, Connection, Connector, ConnectorKind, ConnectorType, Enumeration, Implementation,
    Parameter, ParameterBinding, ParameterSet, ParameterSource, ParameterValue, Unit,
};
use crate::xml::{Empty, is_zero, list};
use serde::{Deserialize, Deserializer, Serialize, Serializer};

list!(connectors: Connector as "ssd:Connector");
list!(connections: Connection as "ssd:Connection");
list!(parameter_bindings: ParameterBinding as "ssd:ParameterBinding");
list!(parameters: Parameter as "ssv:Parameter");
list!(units: Unit as "ssc:Unit");
list!(enumerations: Enumeration as "ssc:Enumeration");

/// The elements of a system, which are components.
pub(super) mod elements {
    use super::{Component, Deserialize, Deserializer, Named, Serialize, Serializer};
    use serde::de::Error;

    #[derive(Serialize)]
    struct Components<'a> {
        #[serde(rename = "ssd:Component")]
        components: &'a [Component],
    }

    pub(in crate::ssp) fn serialize<S: Serializer>(
        components: &[Component],
        serializer: S,
    ) -> Result<S::Ok, S::Error> {
        Components { components }.serialize(serializer)
    }

    #[derive(Deserialize)]
    struct Elements {
        #[serde(rename = "ssd:Component", default)]
        components: Vec<Component>,
        #[serde(rename = "ssd:System", default)]
        systems: Vec<Named>,
        #[serde(rename = "ssd:SignalDictionaryReference", default)]
        dictionaries: Vec<Named>,
    }

    pub(in crate::ssp) fn deserialize<'de, D: Deserializer<'de>>(
        deserializer: D,
    ) -> Result<Vec<Component>, D::Error> {
        let elements = Elements::deserialize(deserializer)?;
        let others = [
            ("system", &elements.systems),
            ("signal dictionary reference", &elements.dictionaries),
        ];
        for (what, others) in others {
            if let Some(other) = others.first() {
                return Err(D::Error::custom(format!(
                    "expected a system of components only, found the {what} {:?}",
                    other.name
                )));
            }
        }
        Ok(elements.components)
    }
}

/// An element of which only the name counts.
#[derive(Deserialize)]
struct Named {
    #[serde(rename = "@name")]
    name: String,
}

const FMU: &str = "application/x-fmu-sharedlibrary";
const PARAMETER_SET: &str = "application/x-ssp-parameter-set";

#[derive(Clone, Serialize, Deserialize)]
pub(super) struct RawComponent {
    #[serde(rename = "@name")]
    name: String,
    #[serde(rename = "@type", default)]
    mime_type: Option<String>,
    #[serde(rename = "@source")]
    source: String,
    #[serde(rename = "@implementation", default, skip_serializing_if = "is_zero")]
    implementation: Implementation,
    #[serde(
        rename = "ssd:Connectors",
        with = "connectors",
        default,
        skip_serializing_if = "Vec::is_empty"
    )]
    connectors: Vec<Connector>,
    #[serde(
        rename = "ssd:ParameterBindings",
        with = "parameter_bindings",
        default,
        skip_serializing_if = "Vec::is_empty"
    )]
    parameter_bindings: Vec<ParameterBinding>,
}

impl From<Component> for RawComponent {
    fn from(component: Component) -> Self {
        Self {
            name: component.name,
            mime_type: Some(FMU.to_owned()),
            source: component.source,
            implementation: component.implementation,
            connectors: component.connectors,
            parameter_bindings: component.parameter_bindings,
        }
    }
}

impl TryFrom<RawComponent> for Component {
    type Error = String;

    fn try_from(raw: RawComponent) -> Result<Self, String> {
        if let Some(found) = raw.mime_type.filter(|found| found != FMU) {
            let name = raw.name;
            return Err(format!(
                "component {name:?}: expected the type {FMU:?}, found {found:?}"
            ));
        }
        Ok(Self {
            name: raw.name,
            source: raw.source,
            implementation: raw.implementation,
            connectors: raw.connectors,
            parameter_bindings: raw.parameter_bindings,
        })
    }
}

/// At most one of the types.
#[derive(Clone, Default, Serialize, Deserialize)]
pub(super) struct RawConnector {
    #[serde(rename = "@name")]
    name: String,
    #[serde(rename = "@kind")]
    kind: ConnectorKind,
    #[serde(rename = "ssc:Real", default)]
    real: Option<RealType>,
    #[serde(rename = "ssc:Integer", default)]
    integer: Option<Empty>,
    #[serde(rename = "ssc:Boolean", default)]
    boolean: Option<Empty>,
    #[serde(rename = "ssc:String", default)]
    string: Option<Empty>,
    #[serde(rename = "ssc:Enumeration", default)]
    enumeration: Option<EnumerationReference>,
    #[serde(rename = "ssc:Binary", default)]
    binary: Option<Empty>,
}

#[derive(Clone, Serialize, Deserialize)]
struct RealType {
    #[serde(rename = "@unit", default)]
    unit: Option<String>,
}

#[derive(Clone, Serialize, Deserialize)]
struct EnumerationReference {
    #[serde(rename = "@name")]
    name: String,
}

impl From<Connector> for RawConnector {
    fn from(connector: Connector) -> Self {
        let mut raw = Self {
            name: connector.name,
            kind: connector.kind,
            ..Self::default()
        };
        match connector.connector_type {
            Some(ConnectorType::Real { unit }) => raw.real = Some(RealType { unit }),
            Some(ConnectorType::Integer) => raw.integer = Some(Empty {}),
            Some(ConnectorType::Boolean) => raw.boolean = Some(Empty {}),
            Some(ConnectorType::String) => raw.string = Some(Empty {}),
            Some(ConnectorType::Enumeration { name }) => {
                raw.enumeration = Some(EnumerationReference { name });
            }
            None => {}
        }
        raw
    }
}

impl TryFrom<RawConnector> for Connector {
    type Error = String;

    fn try_from(raw: RawConnector) -> Result<Self, String> {
        if raw.binary.is_some() {
            return Err(format!(
                "connector {:?}: expected a type of FMI 2.0, found Binary",
                raw.name
            ));
        }
        let connector_type = raw
            .real
            .map(|real| ConnectorType::Real { unit: real.unit })
            .or(raw.integer.map(|_| ConnectorType::Integer))
            .or(raw.boolean.map(|_| ConnectorType::Boolean))
            .or(raw.string.map(|_| ConnectorType::String))
            .or(raw
                .enumeration
                .map(|found| ConnectorType::Enumeration { name: found.name }));
        Ok(Self {
            name: raw.name,
            kind: raw.kind,
            connector_type,
        })
    }
}

#[derive(Clone, Default, Serialize, Deserialize)]
pub(super) struct RawConnection {
    #[serde(rename = "@startElement", default)]
    start_element: Option<String>,
    #[serde(rename = "@startConnector")]
    start_connector: String,
    #[serde(rename = "@endElement", default)]
    end_element: Option<String>,
    #[serde(rename = "@endConnector")]
    end_connector: String,
    #[serde(
        rename = "@suppressUnitConversion",
        default,
        skip_serializing_if = "is_zero"
    )]
    suppress_unit_conversion: bool,
    #[serde(rename = "ssc:LinearTransformation", default)]
    linear: Option<Empty>,
    #[serde(rename = "ssc:BooleanMappingTransformation", default)]
    boolean: Option<Empty>,
    #[serde(rename = "ssc:IntegerMappingTransformation", default)]
    integer: Option<Empty>,
    #[serde(rename = "ssc:EnumerationMappingTransformation", default)]
    enumeration: Option<Empty>,
}

impl From<Connection> for RawConnection {
    fn from(connection: Connection) -> Self {
        Self {
            start_element: connection.start_element,
            start_connector: connection.start_connector,
            end_element: connection.end_element,
            end_connector: connection.end_connector,
            suppress_unit_conversion: connection.suppress_unit_conversion,
            ..Self::default()
        }
    }
}

impl TryFrom<RawConnection> for Connection {
    type Error = String;

    fn try_from(raw: RawConnection) -> Result<Self, String> {
        let transformations = [raw.linear, raw.boolean, raw.integer, raw.enumeration];
        if transformations.iter().any(Option::is_some) {
            return Err(format!(
                "connection of {:?} with {:?}: expected no transformation, found one",
                raw.start_connector, raw.end_connector
            ));
        }
        Ok(Self {
            start_element: raw.start_element,
            start_connector: raw.start_connector,
            end_element: raw.end_element,
            end_connector: raw.end_connector,
            suppress_unit_conversion: raw.suppress_unit_conversion,
        })
    }
}

#[derive(Clone, Default, Serialize, Deserialize)]
pub(super) struct RawParameterBinding {
    #[serde(rename = "@type", default)]
    mime_type: Option<String>,
    #[serde(rename = "@source", default)]
    source: Option<String>,
    #[serde(rename = "@sourceBase", default)]
    source_base: Option<String>,
    #[serde(rename = "@prefix", default, skip_serializing_if = "String::is_empty")]
    prefix: String,
    #[serde(rename = "ssd:ParameterValues", default)]
    values: Option<RawParameterValues>,
    #[serde(rename = "ssd:ParameterMapping", default)]
    mapping: Option<Empty>,
}

#[derive(Clone, Serialize, Deserialize)]
struct RawParameterValues {
    #[serde(rename = "ssv:ParameterSet")]
    set: ParameterSet,
}

impl From<ParameterBinding> for RawParameterBinding {
    fn from(binding: ParameterBinding) -> Self {
        let raw = Self {
            prefix: binding.prefix,
            ..Self::default()
        };
        match binding.source {
            ParameterSource::File(source) => Self {
                source: Some(source),
                ..raw
            },
            ParameterSource::Inline(set) => Self {
                values: Some(RawParameterValues { set }),
                ..raw
            },
        }
    }
}

impl TryFrom<RawParameterBinding> for ParameterBinding {
    type Error = String;

    fn try_from(raw: RawParameterBinding) -> Result<Self, String> {
        let refuse = |expected: &str, found: &str| {
            Err(format!(
                "parameter binding: expected {expected}, found {found}"
            ))
        };
        if let Some(found) = raw.mime_type.filter(|found| found != PARAMETER_SET) {
            return refuse(
                &format!("the type {PARAMETER_SET:?}"),
                &format!("{found:?}"),
            );
        }
        if let Some(found) = raw.source_base.filter(|found| found != "SSD") {
            return refuse("the sourceBase \"SSD\"", &format!("{found:?}"));
        }
        if raw.mapping.is_some() {
            return refuse("no parameter mapping", "one");
        }
        let source = match (raw.source, raw.values) {
            (Some(source), None) => ParameterSource::File(source),
            (None, Some(values)) => ParameterSource::Inline(values.set),
            (Some(_), Some(_)) => return refuse("a source or values", "both"),
            (None, None) => return refuse("a source or values", "neither"),
        };
        Ok(Self {
            prefix: raw.prefix,
            source,
        })
    }
}

/// Exactly one of the types.
#[derive(Clone, Default, Serialize, Deserialize)]
pub(super) struct RawParameter {
    #[serde(rename = "@name")]
    name: String,
    #[serde(rename = "@description", default)]
    description: Option<String>,
    #[serde(rename = "ssv:Real", default)]
    real: Option<RealValue>,
    #[serde(rename = "ssv:Integer", default)]
    integer: Option<Plain<i32>>,
    #[serde(rename = "ssv:Boolean", default)]
    boolean: Option<Plain<bool>>,
    #[serde(rename = "ssv:String", default)]
    string: Option<Plain<String>>,
    #[serde(rename = "ssv:Enumeration", default)]
    enumeration: Option<EnumerationValue>,
}

#[derive(Clone, Serialize, Deserialize)]
struct RealValue {
    #[serde(rename = "@value")]
    value: f64,
    #[serde(rename = "@unit", default)]
    unit: Option<String>,
}

#[derive(Clone, Serialize, Deserialize)]
struct Plain<T> {
    #[serde(rename = "@value")]
    value: T,
}

#[derive(Clone, Serialize, Deserialize)]
struct EnumerationValue {
    #[serde(rename = "@value")]
    value: String,
    #[serde(rename = "@name", default)]
    name: Option<String>,
}

impl From<Parameter> for RawParameter {
    fn from(parameter: Parameter) -> Self {
        let mut raw = Self {
            name: parameter.name,
            description: parameter.description,
            ..Self::default()
        };
        match parameter.value {
            ParameterValue::Real { value, unit } => raw.real = Some(RealValue { value, unit }),
            ParameterValue::Integer(value) => raw.integer = Some(Plain { value }),
            ParameterValue::Boolean(value) => raw.boolean = Some(Plain { value }),
            ParameterValue::String(value) => raw.string = Some(Plain { value }),
            ParameterValue::Enumeration { value, name } => {
                raw.enumeration = Some(EnumerationValue { value, name });
            }
        }
        raw
    }
}

impl TryFrom<RawParameter> for Parameter {
    type Error = String;

    fn try_from(raw: RawParameter) -> Result<Self, String> {
        let value = raw
            .real
            .map(|real| ParameterValue::Real {
                value: real.value,
                unit: real.unit,
            })
            .or(raw.integer.map(|v| ParameterValue::Integer(v.value)))
            .or(raw.boolean.map(|v| ParameterValue::Boolean(v.value)))
            .or(raw.string.map(|v| ParameterValue::String(v.value)))
            .or(raw.enumeration.map(|v| ParameterValue::Enumeration {
                value: v.value,
                name: v.name,
            }))
            .ok_or_else(|| crate::xml::untyped("Parameter", &raw.name))?;
        Ok(Self {
            name: raw.name,
            description: raw.description,
            value,
        })
    }
}
