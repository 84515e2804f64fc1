//! What is in an FMU and what is odd about it, found without running its code.

mod oddities;

pub use oddities::{Oddity, Severity};

use crate::{Archive, Value};
use model_description::{
    BaseUnit, Causality, CoSimulation, DefaultExperiment, ModelDescription, ScalarVariable,
    TypeDefinition, Variability, VariableType,
};
use serde::Serialize;
use std::fmt::Write as _;

/// What an FMU says of itself, and what is odd about it.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Inspection {
    /// Name of the model.
    pub model_name: String,
    /// One sentence on the model.
    pub description: Option<String>,
    /// Version of the model.
    pub version: Option<String>,
    /// Who made the model.
    pub author: Option<String>,
    /// Licence.
    pub license: Option<String>,
    /// Tool that generated the file.
    pub generation_tool: Option<String>,
    /// Date of generation, as written.
    pub generation_date_and_time: Option<String>,
    /// Version of the standard, as written.
    pub fmi_version: String,
    /// What ties the description to its binaries.
    pub guid: String,
    /// Whether it offers co-simulation.
    pub co_simulation: bool,
    /// Whether it offers model exchange.
    pub model_exchange: bool,
    /// The capabilities of co-simulation, all of them; none without co-simulation.
    pub capabilities: Vec<Capability>,
    /// Folders of the platforms it has a co-simulation binary for.
    pub platforms: Vec<&'static str>,
    /// A simulation set-up that makes sense; times in s.
    pub default_experiment: Option<DefaultExperiment>,
    /// The units it defines.
    pub units: Vec<UnitRow>,
    /// The variables in their order.
    pub variables: Vec<VariableRow>,
    /// Names of the files in the archive.
    pub files: Vec<String>,
    /// What is odd, faults first.
    pub oddities: Vec<Oddity>,
}

/// A capability of an FMU for co-simulation (FMI 2.0 §4.3.1).
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct Capability {
    /// The attribute, as the standard spells it.
    pub name: &'static str,
    /// 0 and 1 for false and true; the highest order of `maxOutputDerivativeOrder`.
    pub value: u32,
}

/// A unit the description defines.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct UnitRow {
    /// Its name.
    pub name: String,
    /// Its meaning in SI, e.g. `0.001 m`; none where it is not said.
    pub si: Option<String>,
    /// Units to display it in.
    pub display_units: Vec<String>,
}

/// A variable, with what its declared type adds.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct VariableRow {
    /// Its name.
    pub name: String,
    /// Its handle.
    pub value_reference: u32,
    /// `Real`, `Integer`, `Boolean`, `String` or `Enumeration`.
    #[serde(rename = "type")]
    pub type_name: &'static str,
    /// Its part in the model, as the standard spells it.
    pub causality: &'static str,
    /// When it may change, as the standard spells it.
    pub variability: &'static str,
    /// Its unit.
    pub unit: Option<String>,
    /// Its start value.
    pub start: Option<Value>,
    /// Smallest value.
    pub min: Option<f64>,
    /// Largest value.
    pub max: Option<f64>,
    /// Names of the choices of an enumeration with their numbers.
    pub choices: Vec<(String, i32)>,
    /// What it is.
    pub description: Option<String>,
}

impl Archive {
    /// What is in the FMU and what is odd about it; runs none of its code.
    pub fn inspect(&self) -> Inspection {
        let d = self.description();
        let mut inspection = Inspection {
            model_name: d.model_name.clone(),
            description: d.description.clone(),
            version: d.version.clone(),
            author: d.author.clone(),
            license: d.license.clone(),
            generation_tool: d.generation_tool.clone(),
            generation_date_and_time: d.generation_date_and_time.clone(),
            fmi_version: d.fmi_version.clone(),
            guid: d.guid.clone(),
            co_simulation: d.co_simulation.is_some(),
            model_exchange: d.model_exchange.is_some(),
            capabilities: d.co_simulation.as_ref().map_or(Vec::new(), capabilities),
            platforms: self.platforms().iter().map(|p| p.folder()).collect(),
            default_experiment: d.default_experiment,
            units: d.units.iter().map(UnitRow::of).collect(),
            variables: d.variables.iter().map(|v| VariableRow::of(v, d)).collect(),
            files: self.files().to_vec(),
            oddities: Vec::new(),
        };
        inspection.oddities = oddities::find(self, &inspection.variables);
        inspection
    }
}

fn capabilities(c: &CoSimulation) -> Vec<Capability> {
    [
        ("needsExecutionTool", u32::from(c.needs_execution_tool)),
        (
            "canHandleVariableCommunicationStepSize",
            c.can_handle_variable_communication_step_size.into(),
        ),
        ("canInterpolateInputs", c.can_interpolate_inputs.into()),
        ("maxOutputDerivativeOrder", c.max_output_derivative_order),
        ("canRunAsynchronuously", c.can_run_asynchronuously.into()),
        (
            "canBeInstantiatedOnlyOncePerProcess",
            c.can_be_instantiated_only_once_per_process.into(),
        ),
        (
            "canNotUseMemoryManagementFunctions",
            c.can_not_use_memory_management_functions.into(),
        ),
        ("canGetAndSetFMUstate", c.can_get_and_set_fmu_state.into()),
        ("canSerializeFMUstate", c.can_serialize_fmu_state.into()),
        (
            "providesDirectionalDerivative",
            c.provides_directional_derivative.into(),
        ),
    ]
    .map(|(name, value)| Capability { name, value })
    .into()
}

impl UnitRow {
    fn of(unit: &model_description::Unit) -> Self {
        Self {
            name: unit.name.clone(),
            si: unit.base.as_ref().map(si),
            display_units: unit.display_units.iter().map(|d| d.name.clone()).collect(),
        }
    }
}

/// `0.001 m.s-1 + 273.15`
fn si(base: &BaseUnit) -> String {
    let exponents = [
        ("kg", base.kg),
        ("m", base.m),
        ("s", base.s),
        ("A", base.ampere),
        ("K", base.kelvin),
        ("mol", base.mol),
        ("cd", base.cd),
        ("rad", base.rad),
    ];
    let symbols: Vec<String> = exponents
        .iter()
        .filter(|(_, exponent)| *exponent != 0)
        .map(|(symbol, exponent)| match exponent {
            1 => (*symbol).to_owned(),
            _ => format!("{symbol}{exponent}"),
        })
        .collect();
    let mut text = match symbols.as_slice() {
        [] => "1".to_owned(),
        symbols => symbols.join("."),
    };
    if base.factor != 1.0 {
        text = format!("{} {text}", base.factor);
    }
    if base.offset != 0.0 {
        let _ = write!(text, " {:+}", base.offset);
    }
    text
}

impl VariableRow {
    fn of(variable: &ScalarVariable, description: &ModelDescription) -> Self {
        let mut row = Self {
            name: variable.name.clone(),
            value_reference: variable.value_reference,
            type_name: variable.variable_type.name(),
            causality: causality(variable.causality),
            variability: variability(variable.variability),
            unit: None,
            start: None,
            min: None,
            max: None,
            choices: Vec::new(),
            description: variable.description.clone(),
        };
        // What the variable does not say itself its declared type says (FMI 2.0 §2.2.3).
        let declared = |name: &Option<String>| {
            let name = name.as_deref()?;
            description.simple_type(name).map(|t| &t.definition)
        };
        match &variable.variable_type {
            VariableType::Real(v) => {
                row.start = v.start.map(Value::Real);
                (row.unit, row.min, row.max) = (v.unit.clone(), v.min, v.max);
                if let Some(TypeDefinition::Real(t)) = declared(&v.declared_type) {
                    row.unit = row.unit.or_else(|| t.unit.clone());
                    (row.min, row.max) = (row.min.or(t.min), row.max.or(t.max));
                }
            }
            VariableType::Integer(v) => {
                row.start = v.start.map(Value::Integer);
                (row.min, row.max) = (v.min.map(f64::from), v.max.map(f64::from));
                if let Some(TypeDefinition::Integer(t)) = declared(&v.declared_type) {
                    row.min = row.min.or(t.min.map(f64::from));
                    row.max = row.max.or(t.max.map(f64::from));
                }
            }
            VariableType::Boolean(v) => row.start = v.start.map(Value::Boolean),
            VariableType::String(v) => row.start = v.start.clone().map(Value::String),
            VariableType::Enumeration(v) => {
                row.start = v.start.map(Value::Integer);
                (row.min, row.max) = (v.min.map(f64::from), v.max.map(f64::from));
                if let Some(TypeDefinition::Enumeration(t)) =
                    declared(&Some(v.declared_type.clone()))
                {
                    row.choices = t.items.iter().map(|i| (i.name.clone(), i.value)).collect();
                }
            }
        }
        row
    }

    /// The start value as text: for an enumeration the name of the choice.
    pub fn start_text(&self) -> Option<String> {
        let start = self.start.as_ref()?;
        let choice = self
            .choices
            .iter()
            .find(|(_, number)| *start == Value::Integer(*number));
        Some(choice.map_or_else(|| start.to_string(), |(name, _)| name.clone()))
    }
}

fn causality(causality: Causality) -> &'static str {
    match causality {
        Causality::Parameter => "parameter",
        Causality::CalculatedParameter => "calculatedParameter",
        Causality::Input => "input",
        Causality::Output => "output",
        Causality::Local => "local",
        Causality::Independent => "independent",
    }
}

fn variability(variability: Variability) -> &'static str {
    match variability {
        Variability::Constant => "constant",
        Variability::Fixed => "fixed",
        Variability::Tunable => "tunable",
        Variability::Discrete => "discrete",
        Variability::Continuous => "continuous",
    }
}
