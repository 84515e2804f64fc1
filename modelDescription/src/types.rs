//! Units and types (FMI 2.0 §2.2.2, §2.2.3).

use crate::xml::{RawSimpleType, is_one, is_zero, one};
use serde::{Deserialize, Serialize};

/// A unit, with its meaning in SI units and units to display it in.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Unit {
    /// Name the variables use, e.g. `N.m`.
    #[serde(rename = "@name")]
    pub name: String,
    /// Its meaning in SI units.
    #[serde(rename = "BaseUnit", default)]
    pub base: Option<BaseUnit>,
    /// Units to display values in.
    #[serde(rename = "DisplayUnit", default, skip_serializing_if = "Vec::is_empty")]
    pub display_units: Vec<DisplayUnit>,
}

/// SI exponents; value in SI = `factor` · value + `offset`.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct BaseUnit {
    /// Exponent of the kilogram.
    #[serde(rename = "@kg", default, skip_serializing_if = "is_zero")]
    pub kg: i32,
    /// Exponent of the metre.
    #[serde(rename = "@m", default, skip_serializing_if = "is_zero")]
    pub m: i32,
    /// Exponent of the second.
    #[serde(rename = "@s", default, skip_serializing_if = "is_zero")]
    pub s: i32,
    /// Exponent of the ampere.
    #[serde(rename = "@A", default, skip_serializing_if = "is_zero")]
    pub ampere: i32,
    /// Exponent of the kelvin.
    #[serde(rename = "@K", default, skip_serializing_if = "is_zero")]
    pub kelvin: i32,
    /// Exponent of the mole.
    #[serde(rename = "@mol", default, skip_serializing_if = "is_zero")]
    pub mol: i32,
    /// Exponent of the candela.
    #[serde(rename = "@cd", default, skip_serializing_if = "is_zero")]
    pub cd: i32,
    /// Exponent of the radian.
    #[serde(rename = "@rad", default, skip_serializing_if = "is_zero")]
    pub rad: i32,
    /// Factor to SI.
    #[serde(rename = "@factor", default = "one", skip_serializing_if = "is_one")]
    pub factor: f64,
    /// Offset to SI.
    #[serde(rename = "@offset", default, skip_serializing_if = "is_zero")]
    pub offset: f64,
}

impl Default for BaseUnit {
    /// The unit 1.
    fn default() -> Self {
        Self {
            kg: 0,
            m: 0,
            s: 0,
            ampere: 0,
            kelvin: 0,
            mol: 0,
            cd: 0,
            rad: 0,
            factor: 1.0,
            offset: 0.0,
        }
    }
}

impl BaseUnit {
    /// Factor and offset that make of a value in this unit one in `other`; none where the dimensions
    /// differ (the radian counts as one). Exactly 1 and 0 into itself.
    pub fn conversion(&self, other: &Self) -> Option<(f64, f64)> {
        let dimension = |unit: &Self| Self {
            factor: 1.0,
            offset: 0.0,
            ..*unit
        };
        // other.factor · y + other.offset = factor · x + offset
        (dimension(self) == dimension(other) && other.factor != 0.0).then(|| {
            (
                self.factor / other.factor,
                (self.offset - other.offset) / other.factor,
            )
        })
    }
}

/// A unit for display; displayed value = `factor` · value + `offset`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct DisplayUnit {
    /// Name, e.g. `deg`.
    #[serde(rename = "@name")]
    pub name: String,
    /// Factor from the unit to the display unit.
    #[serde(rename = "@factor", default = "one", skip_serializing_if = "is_one")]
    pub factor: f64,
    /// Offset from the unit to the display unit.
    #[serde(rename = "@offset", default, skip_serializing_if = "is_zero")]
    pub offset: f64,
}

/// A named type that variables refer to by `declared_type`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(try_from = "RawSimpleType", into = "RawSimpleType")]
pub struct SimpleType {
    /// Name, unlike that of any other type or variable.
    pub name: String,
    /// What the type is for.
    pub description: Option<String>,
    /// One of the five FMI types.
    pub definition: TypeDefinition,
}

/// One of the five FMI types with its attributes.
#[derive(Clone, Debug, PartialEq)]
pub enum TypeDefinition {
    /// `Real`
    Real(RealType),
    /// `Integer`
    Integer(IntegerType),
    /// `Boolean`
    Boolean,
    /// `String`
    String,
    /// `Enumeration`
    Enumeration(EnumerationType),
}

/// Attributes of a `Real` type.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct RealType {
    /// Physical quantity.
    #[serde(rename = "@quantity", default)]
    pub quantity: Option<String>,
    /// Unit, one of the unit definitions.
    #[serde(rename = "@unit", default)]
    pub unit: Option<String>,
    /// Unit for display, one of the unit's display units.
    #[serde(rename = "@displayUnit", default)]
    pub display_unit: Option<String>,
    /// Smallest value.
    #[serde(rename = "@min", default)]
    pub min: Option<f64>,
    /// Largest value.
    #[serde(rename = "@max", default)]
    pub max: Option<f64>,
    /// Typical magnitude.
    #[serde(rename = "@nominal", default)]
    pub nominal: Option<f64>,
}

/// Attributes of an `Integer` type.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct IntegerType {
    /// Physical quantity.
    #[serde(rename = "@quantity", default)]
    pub quantity: Option<String>,
    /// Smallest value.
    #[serde(rename = "@min", default)]
    pub min: Option<i32>,
    /// Largest value.
    #[serde(rename = "@max", default)]
    pub max: Option<i32>,
}

/// The names of an `Enumeration` type.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct EnumerationType {
    /// Physical quantity.
    #[serde(rename = "@quantity", default)]
    pub quantity: Option<String>,
    /// Name and value of each choice.
    #[serde(rename = "Item", default)]
    pub items: Vec<Item>,
}

/// One choice of an enumeration.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct Item {
    /// Name.
    #[serde(rename = "@name")]
    pub name: String,
    /// Value that travels through the interface.
    #[serde(rename = "@value")]
    pub value: i32,
    /// What the choice means.
    #[serde(rename = "@description", default)]
    pub description: Option<String>,
}
