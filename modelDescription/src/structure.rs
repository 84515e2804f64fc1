//! What depends on what (FMI 2.0 §2.2.8).

use crate::xml;
use serde::{Deserialize, Serialize};

/// Outputs, derivatives and initial unknowns with what they depend on.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct ModelStructure {
    /// Every output, with its dependencies at a communication point.
    #[serde(
        rename = "Outputs",
        with = "xml::unknowns",
        default,
        skip_serializing_if = "Vec::is_empty"
    )]
    pub outputs: Vec<Unknown>,
    /// State derivatives the FMU exposes.
    #[serde(
        rename = "Derivatives",
        with = "xml::unknowns",
        default,
        skip_serializing_if = "Vec::is_empty"
    )]
    pub derivatives: Vec<Unknown>,
    /// What initialization mode computes, with its dependencies there.
    #[serde(
        rename = "InitialUnknowns",
        with = "xml::unknowns",
        default,
        skip_serializing_if = "Vec::is_empty"
    )]
    pub initial_unknowns: Vec<Unknown>,
}

/// A computed variable and the known ones it depends on.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct Unknown {
    /// 1-based position among the variables.
    #[serde(rename = "@index")]
    pub index: u32,
    /// 1-based positions of the variables it depends on, ascending.
    /// `None`: on all of them; empty: on none.
    #[serde(rename = "@dependencies", default)]
    pub dependencies: Option<Vec<u32>>,
    /// In what way, one for each dependency. `None`: in no particular way.
    #[serde(rename = "@dependenciesKind", default)]
    pub dependencies_kind: Option<Vec<DependencyKind>>,
}

/// How an unknown depends on a known.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "camelCase")]
pub enum DependencyKind {
    /// In no particular way.
    Dependent,
    /// By a constant factor.
    Constant,
    /// By a factor fixed after initialization.
    Fixed,
    /// By a factor that changes with tunable parameters.
    Tunable,
    /// By a factor that changes at events.
    Discrete,
}
