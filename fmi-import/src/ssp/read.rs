//! A system from an archive.

use super::check::{Models, check};
use super::{Component, DESCRIPTION, Package, System, unfit, value};
use crate::archive::text;
use crate::archive::unpack::{Limits, inside, unpack};
use crate::master::{Connection, Terminal};
use crate::{Error, Value};
use model_description::Causality;
use model_description::ssp::{
    self, ConnectorKind, Implementation, ParameterBinding, ParameterSet, ParameterSource,
    SystemStructureDescription,
};
use percent_encoding::percent_decode_str;
use std::path::{Path, PathBuf};

/// Unpacks the archive at `path` and reads its system, with the FMUs' descriptions beside it.
///
/// Connections to the system's own outputs are left out: they are for looking at. Refused, besides
/// what does not fit, is what a [`System`] cannot hold: systems in systems, signal dictionaries,
/// parameter mappings, transformations, connections without unit conversion, inputs of the
/// system, FMUs and parameters that are not in the archive.
pub fn read(path: &Path) -> Result<Package, Error> {
    let unpacked = unpack(path, &Limits::default()).map_err(|error| match error {
        Error::Zip { path, source } => {
            unfit(&path, "file", "an SSP, a zip archive", source.to_string())
        }
        error => error,
    })?;
    let files = Files {
        path,
        folder: unpacked.folder.path(),
    };
    if !files.folder.join(DESCRIPTION).is_file() {
        return Err(unfit(path, "archive", DESCRIPTION, "none"));
    }
    let description = files.parse(DESCRIPTION, SystemStructureDescription::from_xml)?;
    let experiment = description.default_experiment.unwrap_or_default();
    let mut system = System {
        name: description.system.name.clone(),
        components: description
            .system
            .components
            .iter()
            .map(|component| files.component(component))
            .collect::<Result<_, _>>()?,
        connections: Vec::new(),
        start_time: experiment.start_time,
        stop_time: experiment.stop_time,
    };
    let models = Models::open(&system)?;
    for connection in &description.system.connections {
        if let Some(connection) = files.connection(connection, &description, &system, &models)? {
            system.connections.push(connection);
        }
    }
    let ignored = files.start_values(&mut system, &description.system, &models)?;
    check(&system, &models, path)?;
    Ok(Package {
        system,
        ignored,
        _folder: unpacked.folder,
    })
}

/// What an archive was unpacked to.
struct Files<'a> {
    path: &'a Path,
    folder: &'a Path,
}

impl Files<'_> {
    fn parse<T>(
        &self,
        entry: &str,
        parse: fn(&str) -> Result<T, model_description::Error>,
    ) -> Result<T, Error> {
        let file = self.resource(entry)?;
        let bytes = std::fs::read(&file).map_err(|source| Error::File { path: file, source })?;
        // an encoding other than UTF-8 is odd, and harmless
        let (xml, _) = text::decode(&bytes);
        parse(&xml).map_err(|source| Error::SystemFile {
            path: self.path.to_owned(),
            entry: entry.to_owned(),
            source,
        })
    }

    /// The file that a URI, relative to the description, names.
    fn resource(&self, uri: &str) -> Result<PathBuf, Error> {
        let refuse = || {
            let expected = "the URI of a file in the archive";
            unfit(self.path, "source", expected, format!("{uri:?}"))
        };
        let name = percent_decode_str(uri)
            .decode_utf8()
            .map_err(|_| refuse())?;
        let file = self.folder.join(inside(&name).ok_or_else(refuse)?);
        if file.is_file() {
            Ok(file)
        } else {
            Err(refuse())
        }
    }

    fn component(&self, component: &ssp::Component) -> Result<Component, Error> {
        if component.implementation == Implementation::ModelExchange {
            let what = format!("component {}", component.name);
            let expected = "an FMU for co-simulation";
            return Err(unfit(self.path, what, expected, "ModelExchange"));
        }
        Ok(Component {
            name: component.name.clone(),
            fmu: self.resource(&component.source)?,
            start_values: Vec::new(),
        })
    }

    /// From output to input; none where the system only shows an output.
    fn connection(
        &self,
        connection: &ssp::Connection,
        description: &SystemStructureDescription,
        system: &System,
        models: &Models,
    ) -> Result<Option<Connection>, Error> {
        let start = port(
            connection.start_element.as_ref(),
            &connection.start_connector,
        );
        let end = port(connection.end_element.as_ref(), &connection.end_connector);
        let (start, end) = match (start, end) {
            (Ok(start), Ok(end)) => (start, end),
            (Err(own), _) | (_, Err(own)) => {
                let mut connectors = description.system.connectors.iter();
                let found = connectors.find(|connector| connector.name == *own);
                if found.is_some_and(|found| found.kind == ConnectorKind::Output) {
                    return Ok(None);
                }
                let what = format!("connection of the system's {own:?}");
                let expected = "a connection between components";
                return Err(unfit(self.path, what, expected, "none"));
            }
        };
        if connection.suppress_unit_conversion {
            let what = format!("connection of {start} with {end}");
            let found = "suppressUnitConversion";
            return Err(unfit(self.path, what, "unit conversion", found));
        }
        // the order says nothing on the direction
        let (_, first) = models.variable(system, &start, self.path)?;
        let (source, target) = match first.causality {
            Causality::Input => (end, start),
            _ => (start, end),
        };
        Ok(Some(Connection { source, target }))
    }

    /// Sets the start values that are bound; returns the names of those that no variable has.
    fn start_values(
        &self,
        system: &mut System,
        description: &ssp::System,
        models: &Models,
    ) -> Result<Vec<String>, Error> {
        let mut ignored = Vec::new();
        // those of the system come last, for they hold over those of the components
        let mut bindings: Vec<(Option<&str>, &ParameterBinding)> = Vec::new();
        for component in &description.components {
            let bound = component.parameter_bindings.iter();
            bindings.extend(bound.map(|binding| (Some(component.name.as_str()), binding)));
        }
        bindings.extend(description.parameter_bindings.iter().map(|b| (None, b)));
        for (component, binding) in bindings {
            let read;
            let set = match &binding.source {
                ParameterSource::Inline(set) => set,
                ParameterSource::File(source) => {
                    read = self.parse(source, ParameterSet::from_xml)?;
                    &read
                }
            };
            for parameter in &set.parameters {
                let name = match component {
                    Some(component) => format!("{component}.{}{}", binding.prefix, parameter.name),
                    None => format!("{}{}", binding.prefix, parameter.name),
                };
                let Some((position, variable)) = resolve(system, models, &name) else {
                    ignored.push(name);
                    continue;
                };
                let description = models.description(position);
                let value = value::value(
                    description,
                    variable,
                    &parameter.value,
                    &set.units,
                    self.path,
                )?;
                assign(&mut system.components[position], &variable.name, value);
            }
        }
        Ok(ignored)
    }
}

/// A component's connector; the name of the system's own where there is no component.
fn port<'a>(element: Option<&String>, connector: &'a str) -> Result<Terminal, &'a str> {
    Ok(Terminal {
        participant: element.ok_or(connector)?.clone(),
        variable: connector.to_owned(),
    })
}

/// The variable with the hierarchical name `name`, and the position of its component.
fn resolve<'a>(
    system: &System,
    models: &'a Models,
    name: &str,
) -> Option<(usize, &'a model_description::ScalarVariable)> {
    let mut components = system.components.iter().enumerate();
    components.find_map(|(position, component)| {
        let variable = name.strip_prefix(&component.name)?.strip_prefix('.')?;
        let variable = models.description(position).variable(variable)?;
        Some((position, variable))
    })
}

/// The last value of a name holds.
fn assign(component: &mut Component, name: &str, value: Value) {
    let mut values = component.start_values.iter_mut();
    match values.find(|(known, _)| known == name) {
        Some((_, known)) => *known = value,
        None => component.start_values.push((name.to_owned(), value)),
    }
}
