//! A system as an archive.

use super::check::{Models, check};
use super::value::Units;
use super::{DESCRIPTION, PARAMETERS, System};
use crate::Error;
use model_description::ssp::{
    Component, Connection, Connector, ConnectorKind, DefaultExperiment, Implementation, Parameter,
    ParameterBinding, ParameterSet, ParameterSource, SystemStructureDescription, VERSION,
};
use std::fs::File;
use std::io::{BufWriter, Write};
use std::path::Path;
use zip::write::SimpleFileOptions;
use zip::{CompressionMethod, DateTime, ZipWriter};

const TOOL: &str = concat!("fmi-import ", env!("CARGO_PKG_VERSION"));

/// Writes `system` with its FMUs to `out`: first under a temporary name beside it, then renamed.
/// The same system gives the same bytes.
pub fn write(system: &System, out: &Path) -> Result<(), Error> {
    let models = Models::open(system)?;
    check(system, &models, out)?;
    let entries = entries(system, &models, out)?;
    let fail = |source| Error::File {
        path: out.to_owned(),
        source,
    };
    let folder = match out.parent() {
        Some(folder) if folder != Path::new("") => folder,
        _ => Path::new("."),
    };
    let mut builder = tempfile::Builder::new();
    builder.prefix(".ssp");
    // temporary files are made for their owner only; an archive is for others
    #[cfg(unix)]
    builder.permissions(std::os::unix::fs::PermissionsExt::from_mode(0o644));
    let temporary = builder.tempfile_in(folder).map_err(fail)?;
    archive(temporary.as_file(), &entries).map_err(|error| fail(error.into()))?;
    temporary.persist(out).map_err(|error| fail(error.error))?;
    Ok(())
}

/// Path and content of a file in the archive.
type Entry = (String, Vec<u8>);

fn archive(file: &File, entries: &[Entry]) -> zip::result::ZipResult<()> {
    let mut archive = ZipWriter::new(BufWriter::new(file));
    for (path, bytes) in entries {
        // an FMU is an archive already
        let method = if path.ends_with(FMU) {
            CompressionMethod::Stored
        } else {
            CompressionMethod::Deflated
        };
        let options = SimpleFileOptions::default()
            .compression_method(method)
            .last_modified_time(DateTime::default());
        archive.start_file(path, options)?;
        archive.write_all(bytes)?;
    }
    archive.finish()?.flush()?;
    Ok(())
}

const FMU: &str = ".fmu";

fn entries(system: &System, models: &Models, path: &Path) -> Result<Vec<Entry>, Error> {
    let invalid = |entry: &str, source| Error::SystemFile {
        path: path.to_owned(),
        entry: entry.to_owned(),
        source,
    };
    let sources = sources(models);
    let parameters = parameters(system, models, path)?;
    let description = describe(
        system,
        models,
        &sources,
        !parameters.parameters.is_empty(),
        path,
    )?;
    let xml = description.to_xml().map_err(|e| invalid(DESCRIPTION, e))?;
    let mut entries = vec![(DESCRIPTION.to_owned(), xml.into_bytes())];
    if !parameters.parameters.is_empty() {
        let xml = parameters.to_xml().map_err(|e| invalid(PARAMETERS, e))?;
        entries.push((PARAMETERS.to_owned(), xml.into_bytes()));
    }
    for (archive, source) in models.archives.iter().zip(sources) {
        let path = archive.path();
        let bytes = std::fs::read(path).map_err(|source| Error::File {
            path: path.to_owned(),
            source,
        })?;
        entries.push((source, bytes));
    }
    Ok(entries)
}

/// Where each FMU goes: its model identifier is an identifier of C, which any file system and any
/// URI takes; a number follows it where FMUs share one.
fn sources(models: &Models) -> Vec<String> {
    let mut sources = Vec::new();
    for archive in &models.archives {
        let co_simulation = archive.description().co_simulation.as_ref();
        let letters = |c: &char| c.is_ascii_alphanumeric() || *c == '_';
        let identifier: String = co_simulation
            .map_or("", |co_simulation| &co_simulation.model_identifier)
            .chars()
            .filter(letters)
            .collect();
        let numbered = (2..).map(|n| format!("{identifier}_{n}"));
        let mut names = std::iter::once(identifier.clone())
            .chain(numbered)
            .map(|name| format!("resources/{name}{FMU}"));
        let free = names.find(|name| !sources.contains(name));
        sources.extend(free);
    }
    sources
}

fn describe(
    system: &System,
    models: &Models,
    sources: &[String],
    has_parameters: bool,
    path: &Path,
) -> Result<SystemStructureDescription, Error> {
    let mut units = Units::default();
    let mut components: Vec<Component> = system
        .components
        .iter()
        .zip(&models.of)
        .map(|(component, &model)| Component {
            name: component.name.clone(),
            source: sources[model].clone(),
            implementation: Implementation::CoSimulation,
            ..Component::default()
        })
        .collect();
    let mut connections = Vec::new();
    for connection in &system.connections {
        let ends = [
            (&connection.source, ConnectorKind::Output),
            (&connection.target, ConnectorKind::Input),
        ];
        for (port, kind) in ends {
            let (component, variable) = models.variable(system, port, path)?;
            let connectors = &mut components[component].connectors;
            if connectors.iter().all(|known| known.name != port.variable) {
                let description = models.description(component);
                connectors.push(Connector {
                    name: port.variable.clone(),
                    kind,
                    connector_type: units.connector_type(description, variable),
                });
            }
        }
        connections.push(Connection {
            start_element: Some(connection.source.participant.clone()),
            start_connector: connection.source.variable.clone(),
            end_element: Some(connection.target.participant.clone()),
            end_connector: connection.target.variable.clone(),
            suppress_unit_conversion: false,
        });
    }
    let binding = has_parameters.then(|| ParameterBinding {
        prefix: String::new(),
        source: ParameterSource::File(PARAMETERS.to_owned()),
    });
    let experiment = DefaultExperiment {
        start_time: system.start_time,
        stop_time: system.stop_time,
    };
    Ok(SystemStructureDescription {
        version: VERSION.to_owned(),
        name: system.name.clone(),
        generation_tool: Some(TOOL.to_owned()),
        system: model_description::ssp::System {
            name: system.name.clone(),
            parameter_bindings: binding.into_iter().collect(),
            components,
            connections,
            ..Default::default()
        },
        enumerations: Vec::new(),
        units: units.0,
        default_experiment: (experiment != DefaultExperiment::default()).then_some(experiment),
    })
}

fn parameters(system: &System, models: &Models, path: &Path) -> Result<ParameterSet, Error> {
    let mut units = Units::default();
    let mut parameters = Vec::new();
    for (component, model) in system.components.iter().zip(&models.of) {
        let description = models.archives[*model].description();
        for (name, value) in &component.start_values {
            let variable = description.variable(name);
            let variable = variable.ok_or_else(|| {
                let known = description.variables.iter().map(|v| v.name.as_str());
                Error::unknown_variable(&component.name, name, known)
            })?;
            parameters.push(Parameter {
                name: format!("{}.{name}", component.name),
                description: None,
                value: units.parameter(description, variable, value, path)?,
            });
        }
    }
    Ok(ParameterSet {
        name: system.name.clone(),
        generation_tool: Some(TOOL.to_owned()),
        parameters,
        units: units.0,
        ..ParameterSet::default()
    })
}
