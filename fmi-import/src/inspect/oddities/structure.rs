//! What depends on what.

use super::{List, Severity, names};
use model_description::{Causality, ModelDescription, Unknown};
use std::collections::HashMap;

impl List {
    /// FMI 2.0 §2.2.8.
    pub(super) fn structure(&mut self, d: &ModelDescription) {
        let index_of = |index: u32| (index as usize).checked_sub(1);
        let at = |index: u32| d.variables.get(index_of(index)?);
        let listed: HashMap<usize, &Unknown> = d
            .structure
            .outputs
            .iter()
            .filter_map(|unknown| Some((index_of(unknown.index)?, unknown)))
            .collect();
        let outputs = || {
            let all = d.variables.iter().enumerate();
            all.filter(|(_, v)| v.causality == Causality::Output)
        };
        self.each(
            Severity::Fault,
            "output-not-in-structure",
            "outputs missing from ModelStructure",
            outputs()
                .filter(|(index, _)| !listed.contains_key(index))
                .map(|(_, v)| v.name.as_str()),
        );
        let not_outputs = d
            .structure
            .outputs
            .iter()
            .filter_map(|unknown| at(unknown.index));
        self.each(
            Severity::Fault,
            "no-output",
            "in the outputs of ModelStructure, but no outputs",
            names(not_outputs.filter(|v| v.causality != Causality::Output)),
        );
        let unknowns = || {
            let s = &d.structure;
            s.outputs
                .iter()
                .chain(&s.derivatives)
                .chain(&s.initial_unknowns)
        };
        let mut beyond: Vec<u32> = unknowns()
            .flat_map(|unknown| {
                unknown
                    .dependencies
                    .iter()
                    .flatten()
                    .chain([&unknown.index])
            })
            .copied()
            .filter(|&index| at(index).is_none())
            .collect();
        beyond.sort_unstable();
        beyond.dedup();
        self.each(
            Severity::Fault,
            "index",
            "indices in ModelStructure that no variable has",
            beyond.iter().map(u32::to_string),
        );
        let kinds_differ = |unknown: &&Unknown| {
            let count = |list: Option<usize>| list.unwrap_or(0);
            unknown.dependencies_kind.is_some()
                && count(unknown.dependencies.as_ref().map(Vec::len))
                    != count(unknown.dependencies_kind.as_ref().map(Vec::len))
        };
        self.each(
            Severity::Fault,
            "dependencies-kind",
            "unknowns with more or fewer dependenciesKind than dependencies",
            names(
                unknowns()
                    .filter(kinds_differ)
                    .filter_map(|unknown| at(unknown.index)),
            ),
        );
        let has_inputs = d.variables.iter().any(|v| v.causality == Causality::Input);
        if has_inputs {
            self.each(
                Severity::Remark,
                "no-dependencies",
                "outputs without declared dependencies: taken to depend on every input, a master \
                 sees algebraic loops that may not be there",
                outputs()
                    .filter(|(index, _)| {
                        listed
                            .get(index)
                            .is_none_or(|unknown| unknown.dependencies.is_none())
                    })
                    .map(|(_, v)| v.name.as_str()),
            );
        }
    }
}
