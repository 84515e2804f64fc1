//! Whether a system can be: its FMUs opened, its names and connections checked against them.

use super::{System, unfit};
use crate::master::{Connection, Terminal};
use crate::{Archive, Error};
use model_description::{Causality, ModelDescription, ScalarVariable};
use std::collections::HashSet;
use std::path::Path;

/// The FMUs of a system, each opened once.
pub(super) struct Models {
    pub(super) archives: Vec<Archive>,
    /// For each component, which.
    pub(super) of: Vec<usize>,
}

impl Models {
    /// Opens the FMUs, which must be for co-simulation.
    pub(super) fn open(system: &System) -> Result<Self, Error> {
        let mut archives: Vec<Archive> = Vec::new();
        let mut of = Vec::new();
        for component in &system.components {
            let known = archives.iter().position(|a| a.path() == component.fmu);
            if known.is_none() {
                let archive = Archive::open(&component.fmu)?;
                if archive.description().co_simulation.is_none() {
                    return Err(Error::NotCoSimulation {
                        path: component.fmu.clone(),
                    });
                }
                archives.push(archive);
            }
            of.push(known.unwrap_or_else(|| archives.len() - 1));
        }
        Ok(Self { archives, of })
    }

    /// The description of a component's FMU.
    pub(super) fn description(&self, component: usize) -> &ModelDescription {
        self.archives[self.of[component]].description()
    }

    /// The variable of a port, with the position of its component; `path` names the archive.
    pub(super) fn variable(
        &self,
        system: &System,
        port: &Terminal,
        path: &Path,
    ) -> Result<(usize, &ScalarVariable), Error> {
        let mut names = system.components.iter().map(|component| &component.name);
        let component = names
            .position(|name| *name == port.participant)
            .ok_or_else(|| {
                let expected = "a component of the system";
                let found = format!("{:?}", port.participant);
                unfit(path, format!("connection of {port}"), expected, found)
            })?;
        let variable = self.description(component).variable(&port.variable);
        let variable = variable.ok_or_else(|| {
            let known = self
                .description(component)
                .variables
                .iter()
                .map(|v| v.name.as_str());
            Error::unknown_variable(&port.participant, &port.variable, known)
        })?;
        Ok((component, variable))
    }
}

/// Refuses names that are taken or would be misread, and connections that do not fit.
pub(super) fn check(system: &System, models: &Models, path: &Path) -> Result<(), Error> {
    if system.name.is_empty() {
        return Err(unfit(path, "system", "a name", "none"));
    }
    let mut names = HashSet::new();
    for component in &system.components {
        let name = &component.name;
        let refuse = |expected| Err(unfit(path, "component", expected, format!("{name:?}")));
        if name.is_empty() || name.contains('.') {
            return refuse("a name without dots");
        }
        if !names.insert(name) {
            return refuse("a name no other component has");
        }
        let mut variables = HashSet::new();
        for (variable, _) in &component.start_values {
            if !variables.insert(variable) {
                let what = format!("start value of {name}.{variable}");
                return Err(unfit(path, what, "one", "two"));
            }
        }
    }
    let mut targets: Vec<&Connection> = Vec::new();
    for connection in &system.connections {
        let Connection { source, target } = connection;
        let (_, gives) = models.variable(system, source, path)?;
        let (_, takes) = models.variable(system, target, path)?;
        let what = || format!("connection of {source} with {target}");
        let causalities = (gives.causality, takes.causality);
        if causalities != (Causality::Output, Causality::Input) {
            let found = format!("{:?} and {:?}", causalities.0, causalities.1).to_lowercase();
            return Err(unfit(path, what(), "an output and an input", found));
        }
        let types = [gives, takes].map(|variable| variable.variable_type.name());
        if types[0] != types[1] {
            let found = format!("{} and {}", types[0], types[1]);
            return Err(unfit(path, what(), "variables of one type", found));
        }
        if let Some(other) = targets.iter().find(|other| other.target == *target) {
            let found = format!("{} and {source}", other.source);
            return Err(unfit(path, format!("input {target}"), "one source", found));
        }
        targets.push(connection);
    }
    Ok(())
}
