//! `RearLoadBicycle.fmu`: library, description, documentation in one archive.

use crate::description::{Starts, description_from};
use crate::documentation;
use bicycle::{Input, Parameters};
use fmi_export::Package;
use model_description::Platform;
use std::env::consts::{DLL_PREFIX, DLL_SUFFIX};
use std::path::{Path, PathBuf};

/// An FMU that cannot be packed.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum Error {
    /// The shared library was not built, or not installed with the program.
    #[error(
        "expected the shared library {name} beside {program}, found none; \
         `cargo build --release -p fmu` makes it, `--library FILE` names one elsewhere"
    )]
    NoLibrary {
        /// File name of the library.
        name: String,
        /// The running program.
        program: PathBuf,
    },
    /// The running program cannot be located.
    #[error("expected to find the path of the running program: {0}")]
    NoProgram(#[source] std::io::Error),
    /// FMI 2.0 has no name for this platform.
    #[error("expected a platform that FMI 2.0 names (Linux, Windows, macOS), found {os}", os = std::env::consts::OS)]
    NoPlatform,
    /// A start value that an importer would not be let in with.
    #[error("{name}: expected a start value of {min} to {max} {unit}, found {found} {unit}")]
    OutOfRange {
        /// Name of the row.
        name: &'static str,
        /// Smallest value.
        min: f64,
        /// Largest value.
        max: f64,
        /// Unit of all three.
        unit: &'static str,
        /// The value.
        found: f64,
    },
    /// The archive could not be written.
    #[error(transparent)]
    Pack(#[from] fmi_export::Error),
}

/// The bicycle with these start values, its libraries still to be added.
pub fn package(starts: &Starts) -> Result<Package, Error> {
    let parameters = Parameters::TABLE.iter().zip(starts.parameters.to_array());
    let inputs = Input::TABLE.iter().zip(starts.input.to_array());
    for (row, value) in parameters.chain(inputs) {
        if !row.admits(value) {
            return Err(Error::OutOfRange {
                name: row.name,
                min: row.min,
                max: row.max,
                unit: row.unit.symbol,
                found: value,
            });
        }
    }
    Ok(Package {
        description: description_from(starts),
        libraries: Vec::new(),
        files: documentation::files(),
    })
}

/// Packs the nominal bicycle with the shared library of this platform into the FMU `out`.
pub fn pack(library: &Path, out: &Path) -> Result<(), Error> {
    let platform = Platform::current().ok_or(Error::NoPlatform)?;
    let mut package = package(&Starts::default())?;
    package.libraries.push((platform, library.to_owned()));
    package.write(out)?;
    Ok(())
}

/// The shared library that cargo put beside the running program, or an installer did.
pub fn built_library() -> Result<PathBuf, Error> {
    let program = std::env::current_exe().map_err(Error::NoProgram)?;
    let name = format!("{DLL_PREFIX}fmu{DLL_SUFFIX}");
    let folder = program.parent().unwrap_or(Path::new("."));
    // Cargo builds into `deps` and links from there to beside the program; tests run in `deps`.
    [folder.join("deps"), folder.to_owned(), folder.join("..")]
        .into_iter()
        .take(if folder.ends_with("deps") { 3 } else { 2 })
        .map(|folder| folder.join(&name))
        .find(|path| path.is_file())
        .ok_or(Error::NoLibrary { name, program })
}

#[cfg(test)]
mod tests {
    use super::*;
    use model_description::{ModelDescription, VariableType};

    fn start(description: &ModelDescription, name: &str) -> Option<f64> {
        match &description.variable(name)?.variable_type {
            VariableType::Real(real) => real.start,
            VariableType::Enumeration(choice) => choice.start.map(f64::from),
            _ => None,
        }
    }

    #[test]
    fn start_values_are_the_bicycles_and_the_guid_is_not_theirs() {
        let starts = Starts {
            parameters: Parameters {
                trail: 0.1 + 0.2 - 0.25,
                ..Parameters::default()
            },
            formulation: bicycle::Formulation::Minimal,
            input: Input {
                speed: 3.0,
                ..Input::default()
            },
        };
        let described = package(&starts).expect("in range").description;
        assert_eq!(start(&described, "trail"), Some(starts.parameters.trail));
        assert_eq!(start(&described, "speed"), Some(3.0));
        assert_eq!(start(&described, "formulation"), Some(2.0));
        let nominal = package(&Starts::default()).expect("in range").description;
        assert_eq!(described.guid, nominal.guid);
    }

    #[test]
    fn a_start_value_out_of_range_is_refused_by_name() {
        let mut starts = Starts::default();
        starts.parameters.trail = 0.3;
        let error = package(&starts).expect_err("too long").to_string();
        assert_eq!(
            error,
            "trail: expected a start value of -0.1 to 0.2 m, found 0.3 m"
        );
        starts.parameters.trail = f64::NAN;
        assert!(package(&starts).is_err());
    }
}
