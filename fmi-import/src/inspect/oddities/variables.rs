//! Each variable on its own: its name, kind, start, range, type and unit.

use super::{List, Severity, VariableRow, names};
use crate::Value;
use model_description::{
    Causality, Initial, ModelDescription, ScalarVariable, TypeDefinition, Variability, VariableType,
};
use std::collections::HashSet;

impl List {
    pub(super) fn names(&mut self, d: &ModelDescription) {
        let mut seen = HashSet::new();
        let twice = d.variables.iter().filter(|v| !seen.insert(v.name.as_str()));
        self.each(
            Severity::Fault,
            "duplicate-name",
            "names of several variables",
            twice.map(|v| v.name.as_str()),
        );
        let undescribed = |v: &&ScalarVariable| v.description.as_deref().is_none_or(str::is_empty);
        self.each(
            Severity::Remark,
            "no-description",
            "variables without description",
            names(d.variables.iter().filter(undescribed)),
        );
    }

    /// Which causality goes with which variability and type (FMI 2.0 §2.2.7).
    pub(super) fn kinds(&mut self, d: &ModelDescription) {
        use Variability::{Constant, Continuous, Fixed, Tunable};
        let is_real = |v: &ScalarVariable| matches!(v.variable_type, VariableType::Real(_));
        self.each(
            Severity::Fault,
            "continuous-not-real",
            "variables that are continuous, which is the default, but not Real",
            names(
                d.variables
                    .iter()
                    .filter(|v| v.variability == Continuous && !is_real(v)),
            ),
        );
        let is_odd = |v: &&ScalarVariable| match v.causality {
            Causality::Parameter | Causality::CalculatedParameter => {
                !matches!(v.variability, Fixed | Tunable)
            }
            Causality::Input => matches!(v.variability, Constant | Fixed | Tunable),
            Causality::Output => matches!(v.variability, Fixed | Tunable),
            Causality::Local => false,
            Causality::Independent => v.variability != Continuous,
        };
        self.each(
            Severity::Fault,
            "variability",
            "variables whose variability does not go with their causality",
            names(d.variables.iter().filter(is_odd)),
        );
        let independent = |v: &&ScalarVariable| v.causality == Causality::Independent;
        if d.variables.iter().filter(independent).count() > 1 {
            self.each(
                Severity::Fault,
                "independent",
                "several independent variables",
                names(d.variables.iter().filter(independent)),
            );
        }
    }

    /// FMI 2.0 §2.2.7, `start`.
    pub(super) fn starts(&mut self, d: &ModelDescription, rows: &[VariableRow]) {
        let with_row = || d.variables.iter().zip(rows);
        let needs_start = |v: &ScalarVariable| {
            v.causality == Causality::Input
                || matches!(v.initial(), Some(Initial::Exact | Initial::Approx))
        };
        self.each(
            Severity::Fault,
            "no-start",
            "variables that need a start value and have none",
            with_row()
                .filter(|(v, row)| needs_start(v) && row.start.is_none())
                .map(|(v, _)| v.name.as_str()),
        );
        self.each(
            Severity::Fault,
            "needless-start",
            "calculated variables with a start value",
            with_row()
                .filter(|(v, row)| !needs_start(v) && row.start.is_some())
                .map(|(v, _)| v.name.as_str()),
        );
    }

    pub(super) fn ranges(&mut self, rows: &[VariableRow]) {
        let outside = |row: &&VariableRow| {
            let start = match row.start {
                Some(Value::Real(start)) => start,
                Some(Value::Integer(start)) => f64::from(start),
                _ => return false,
            };
            row.min.is_some_and(|min| start < min) || row.max.is_some_and(|max| start > max)
        };
        self.each(
            Severity::Fault,
            "start-out-of-range",
            "start values outside min and max",
            rows.iter().filter(outside).map(|row| row.name.as_str()),
        );
        let empty = |row: &&VariableRow| row.min.zip(row.max).is_some_and(|(min, max)| min > max);
        self.each(
            Severity::Fault,
            "empty-range",
            "min above max",
            rows.iter().filter(empty).map(|row| row.name.as_str()),
        );
    }

    pub(super) fn enumerations(&mut self, d: &ModelDescription, rows: &[VariableRow]) {
        let is_enumeration = |row: &&VariableRow| row.type_name == "Enumeration";
        self.each(
            Severity::Fault,
            "no-items",
            "enumerations without items",
            rows.iter()
                .filter(is_enumeration)
                .filter(|row| row.choices.is_empty())
                .map(|row| row.name.as_str()),
        );
        let is_no_item = |row: &&VariableRow| match row.start {
            Some(Value::Integer(start)) if !row.choices.is_empty() => {
                row.choices.iter().all(|(_, number)| *number != start)
            }
            _ => false,
        };
        self.each(
            Severity::Fault,
            "start-no-item",
            "enumerations that start at none of their items",
            rows.iter()
                .filter(is_enumeration)
                .filter(is_no_item)
                .map(|row| row.name.as_str()),
        );
        let unknown_type = |v: &&ScalarVariable| {
            let declared = match &v.variable_type {
                VariableType::Real(v) => v.declared_type.as_deref(),
                VariableType::Integer(v) => v.declared_type.as_deref(),
                VariableType::Boolean(v) => v.declared_type.as_deref(),
                VariableType::String(v) => v.declared_type.as_deref(),
                VariableType::Enumeration(v) => Some(v.declared_type.as_str()),
            };
            declared.is_some_and(|name| {
                d.simple_type(name)
                    .is_none_or(|t| !is_of(&v.variable_type, &t.definition))
            })
        };
        self.each(
            Severity::Fault,
            "declared-type",
            "variables whose declaredType is not defined or of another type",
            names(d.variables.iter().filter(unknown_type)),
        );
    }

    pub(super) fn units(&mut self, d: &ModelDescription, rows: &[VariableRow]) {
        self.each(
            Severity::Remark,
            "no-unit",
            "Real variables without unit",
            rows.iter()
                .filter(|row| row.type_name == "Real" && row.unit.is_none())
                .map(|row| row.name.as_str()),
        );
        let is_defined = |name: &str| d.units.iter().any(|unit| unit.name == name);
        let mut undefined: Vec<&str> = rows
            .iter()
            .filter_map(|row| row.unit.as_deref())
            .filter(|unit| !is_defined(unit))
            .collect();
        undefined.sort_unstable();
        undefined.dedup();
        self.each(
            Severity::Fault,
            "undefined-unit",
            "units missing from UnitDefinitions",
            undefined,
        );
        self.each(
            Severity::Remark,
            "unit-without-meaning",
            "units without their meaning in SI",
            d.units
                .iter()
                .filter(|unit| unit.base.is_none())
                .map(|unit| unit.name.as_str()),
        );
    }
}

fn is_of(variable: &VariableType, definition: &TypeDefinition) -> bool {
    matches!(
        (variable, definition),
        (VariableType::Real(_), TypeDefinition::Real(_))
            | (VariableType::Integer(_), TypeDefinition::Integer(_))
            | (VariableType::Boolean(_), TypeDefinition::Boolean)
            | (VariableType::String(_), TypeDefinition::String)
            | (VariableType::Enumeration(_), TypeDefinition::Enumeration(_))
    )
}
