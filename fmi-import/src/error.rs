//! What can go wrong, with the FMU's own words.

use fmi2::{fmi2Discard, fmi2Error, fmi2Fatal, fmi2OK, fmi2Pending, fmi2Status, fmi2Warning};
use model_description::Platform;
use std::fmt;
use std::path::PathBuf;

/// A status an FMU returned.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Status {
    /// All well.
    Ok,
    /// Not quite right, but going on is possible.
    Warning,
    /// Computed in part only.
    Discard,
    /// Refused.
    Error,
    /// The instance is broken.
    Fatal,
    /// Still being computed.
    Pending,
    /// None of the standard's.
    Unknown(fmi2Status),
}

impl From<fmi2Status> for Status {
    #[expect(non_upper_case_globals, reason = "the standard's names")]
    fn from(status: fmi2Status) -> Self {
        match status {
            fmi2OK => Self::Ok,
            fmi2Warning => Self::Warning,
            fmi2Discard => Self::Discard,
            fmi2Error => Self::Error,
            fmi2Fatal => Self::Fatal,
            fmi2Pending => Self::Pending,
            other => Self::Unknown(other),
        }
    }
}

/// A line of an FMU's log.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct LogLine {
    /// How serious.
    pub status: Status,
    /// One of the description's log categories, if the FMU keeps to them.
    pub category: String,
    /// The message. Placeholders of printf, if any, are not filled in.
    pub message: String,
}

impl fmt::Display for LogLine {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        write!(f, "[{}] {}", self.category, self.message)
    }
}

/// An FMU that cannot be opened, loaded or run.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum Error {
    /// A file could not be read or written.
    #[error("{path}: {source}")]
    File {
        /// The file.
        path: PathBuf,
        /// The reason.
        source: std::io::Error,
    },
    /// Not a zip archive.
    #[error("{path}: expected an FMU, a zip archive: {source}")]
    Zip {
        /// The file.
        path: PathBuf,
        /// The reason.
        source: zip::result::ZipError,
    },
    /// An entry would be written outside the folder the archive is unpacked to.
    #[error("{path}: entry {entry:?} points outside the archive")]
    Escape {
        /// The archive.
        path: PathBuf,
        /// Name of the entry.
        entry: String,
    },
    /// The archive is too big.
    #[error("{path}: expected at most {limit} {what}, found more")]
    TooBig {
        /// The archive.
        path: PathBuf,
        /// What is counted.
        what: &'static str,
        /// How many there may be.
        limit: u64,
    },
    /// The archive has no description.
    #[error("{path}: expected modelDescription.xml in the archive, found none")]
    NoDescription {
        /// The archive.
        path: PathBuf,
    },
    /// The description cannot be read.
    #[error("{path}: modelDescription.xml: {source}")]
    Description {
        /// The archive.
        path: PathBuf,
        /// The reason.
        source: model_description::Error,
    },
    /// Not for co-simulation.
    #[error("{path}: expected an FMU for co-simulation, found one for model exchange only")]
    NotCoSimulation {
        /// The archive.
        path: PathBuf,
    },
    /// No binary for this machine.
    #[error("{path}: expected a binary for {expected}, found {found}", expected = wanted(*.expected), found = list(.found))]
    NoBinary {
        /// The archive.
        path: PathBuf,
        /// This machine, if the standard has a name for it.
        expected: Option<Platform>,
        /// What there is.
        found: Vec<Platform>,
    },
    /// The library cannot be loaded, or lacks a function.
    #[error("{path}: {source}")]
    Library {
        /// The library.
        path: PathBuf,
        /// The reason.
        source: libloading::Error,
    },
    /// The library is of another version.
    #[error("{path}: expected fmi2GetVersion to return \"2.0\", found {found:?}")]
    Version {
        /// The library.
        path: PathBuf,
        /// What it returned.
        found: String,
    },
    /// A text with a null character inside.
    #[error("{what}: expected a text without null characters, found {found:?}")]
    Text {
        /// What it is.
        what: &'static str,
        /// The text.
        found: String,
    },
    /// `fmi2Instantiate` returned NULL.
    #[error("the FMU made no instance{log}", log = lines(.log))]
    NotInstantiated {
        /// What the FMU said.
        log: Vec<LogLine>,
    },
    /// A function did not succeed.
    #[error("{function} returned {status:?}{log}", log = lines(.log))]
    Refused {
        /// Name of the function.
        function: &'static str,
        /// What it returned.
        status: Status,
        /// What the FMU said during the call.
        log: Vec<LogLine>,
    },
    /// As many values as value references are needed.
    #[error("expected {references} values, one for each value reference, found {values}")]
    Length {
        /// Number of value references.
        references: usize,
        /// Number of values.
        values: usize,
    },
    /// The FMU has no variable of this name.
    #[error("expected a variable of {model}, found {name:?}")]
    UnknownVariable {
        /// The model.
        model: String,
        /// The name.
        name: String,
    },
    /// The variable is of another type.
    #[error("variable {name}: expected {expected}, found {found}")]
    WrongType {
        /// The variable.
        name: String,
        /// What would fit.
        expected: &'static str,
        /// What there is.
        found: &'static str,
    },
    /// A plan that cannot be carried out.
    #[error("{what}: expected {expected}, found {found}")]
    Plan {
        /// Which entry.
        what: &'static str,
        /// What it must be.
        expected: &'static str,
        /// What it is.
        found: f64,
    },
}

fn lines(log: &[LogLine]) -> String {
    match log {
        [] => ", without a word".to_owned(),
        lines => {
            let lines: Vec<String> = lines.iter().map(LogLine::to_string).collect();
            format!(":\n  {}", lines.join("\n  "))
        }
    }
}

fn wanted(platform: Option<Platform>) -> &'static str {
    platform.map_or(
        "this platform (FMI 2.0 has no name for it)",
        Platform::folder,
    )
}

fn list(platforms: &[Platform]) -> String {
    if platforms.is_empty() {
        return "none".to_owned();
    }
    let names: Vec<&str> = platforms.iter().map(|platform| platform.folder()).collect();
    names.join(", ")
}
