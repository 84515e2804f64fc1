//! Systems of FMUs as SSP 1.0 archives: [`write()`] makes one whole, [`read()`] opens one.
//!
//! An archive holds `SystemStructure.ssd`, the FMUs under `resources/`, each once, and the start
//! values in [`PARAMETERS`], bound to the system with names `component.variable`. Only what is
//! connected is a connector. Units are those of the FMUs; where two of them are connected, the
//! importer converts, as the standard has it.
//!
//! fmpy 0.3.32 simulates such an archive. It does not apply the bound parameters by itself, but
//! takes them as an argument:
//!
//! ```python
//! from fmpy.ssp.simulation import simulate_ssp
//! from fmpy.ssp.ssd import read_ssv
//!
//! start = read_ssv("system.ssp", resource="resources/parameters.ssv")
//! result = simulate_ssp("system.ssp", stop_time=20, step_size=0.005, parameter_set=start)
//! ```
//!
//! It has every input at 0 during the first step, Jacobi's scheme after that, and no unit
//! conversion. It takes texts for numbers, so that of a parameter set's values only `Real` and
//! `Integer` ones arrive: for a `Boolean` set `p.value = p.value == "true"`, for an `Enumeration`
//! its number, for each such `p` of `start.parameters`. It mistakes a component whose name begins
//! with another's for that other.

mod check;
mod read;
#[cfg(test)]
mod tests;
mod value;
mod write;

pub use read::read;
pub use write::write;

use crate::master::Connection;
use crate::{Error, Value};
use std::path::{Path, PathBuf};
use tempfile::TempDir;

/// Where an archive written here has its start values.
pub const PARAMETERS: &str = "resources/parameters.ssv";

const DESCRIPTION: &str = "SystemStructure.ssd";

/// FMUs and the connections between them.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct System {
    /// Its name.
    pub name: String,
    /// The FMUs.
    pub components: Vec<Component>,
    /// The connections; a participant is a component.
    pub connections: Vec<Connection>,
    /// From when it is meant to be simulated [s].
    pub start_time: Option<f64>,
    /// Until when it is meant to be simulated [s].
    pub stop_time: Option<f64>,
}

/// An FMU in a system.
#[derive(Clone, Debug, PartialEq)]
pub struct Component {
    /// Its name, unique in the system and without dots.
    pub name: String,
    /// The FMU's file; several components may share one.
    pub fmu: PathBuf,
    /// Names of its variables, each once, and the values to set before the start, in the
    /// variable's unit.
    pub start_values: Vec<(String, Value)>,
}

/// A system read from an archive; its FMUs are in a temporary folder that goes with it.
#[derive(Debug)]
pub struct Package {
    system: System,
    ignored: Vec<String>,
    _folder: TempDir,
}

impl Package {
    /// The system.
    pub fn system(&self) -> &System {
        &self.system
    }

    /// Names of parameters that no variable has; the standard wants them ignored.
    pub fn ignored(&self) -> &[String] {
        &self.ignored
    }
}

/// What does not fit at `what` in the archive `path`.
fn unfit(path: &Path, what: impl Into<String>, expected: &str, found: impl Into<String>) -> Error {
    Error::System {
        path: path.to_owned(),
        what: what.into(),
        expected: expected.to_owned(),
        found: found.into(),
    }
}
