//! What can go wrong, with the FMU's own words.

use crate::LogLine;
use fmi2::{fmi2Discard, fmi2Error, fmi2Fatal, fmi2OK, fmi2Pending, fmi2Status, fmi2Warning};
use model_description::Platform;
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
    /// Two entries of one name, or of names that differ only in what the file system ignores.
    #[error("{path}: expected one entry {entry:?}, found two")]
    Duplicate {
        /// The archive.
        path: PathBuf,
        /// Name of the second.
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
    /// An FMU of another version of the standard.
    #[error("{path}: expected FMI 2.0, found FMI {found}")]
    FmiVersion {
        /// The archive.
        path: PathBuf,
        /// The version it states.
        found: String,
    },
    /// The description cannot be read.
    #[error("{path}: modelDescription.xml: {source}")]
    Description {
        /// The archive.
        path: PathBuf,
        /// The reason.
        source: model_description::Error,
    },
    /// A system that cannot be, or not be held.
    #[error("{path}: {what}: expected {expected}, found {found}")]
    System {
        /// The SSP.
        path: PathBuf,
        /// Where.
        what: String,
        /// What would fit.
        expected: String,
        /// What there is.
        found: String,
    },
    /// A file of an SSP cannot be read or written.
    #[error("{path}: {entry}: {source}")]
    SystemFile {
        /// The SSP.
        path: PathBuf,
        /// The file in it.
        entry: String,
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
    /// The binary is no shared library, or not all of one.
    #[error("{path}: expected a shared library, found {found}")]
    NoLibrary {
        /// The file.
        path: PathBuf,
        /// What it is.
        found: String,
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
    /// The library has other C types.
    #[error("{path}: expected fmi2GetTypesPlatform to return \"default\", found {found:?}")]
    TypesPlatform {
        /// The library.
        path: PathBuf,
        /// What it returned.
        found: String,
    },
    /// A function that needs a capability.
    #[error("{function}: expected an FMU that declares {flag}, found one that does not")]
    CapabilityAbsent {
        /// Name of the function.
        function: &'static str,
        /// The attribute of the description.
        flag: &'static str,
    },
    /// A function that the library should have.
    #[error("expected the FMU's library to have {function}, found none")]
    FunctionAbsent {
        /// Name of the function.
        function: &'static str,
    },
    /// A state of another instance.
    #[error(
        "expected a state that this instance saved, found another's; only bytes of states travel"
    )]
    ForeignState,
    /// A saved state too big for the memory.
    #[error("expected a state that fits into the memory, found one of {bytes} bytes")]
    StateSize {
        /// The size the FMU states.
        bytes: usize,
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
    /// Not called: an instance of this FMU has returned `fmi2Fatal` before.
    #[error(
        "{function}: expected an FMU that can still be called, found one that has returned Fatal"
    )]
    Broken {
        /// Name of the function.
        function: &'static str,
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
    #[error("expected a variable of {model}, found {name:?}; the nearest: {nearest}", nearest = .nearest.join(", "))]
    UnknownVariable {
        /// The model.
        model: String,
        /// The name.
        name: String,
        /// Names that are alike.
        nearest: Vec<String>,
    },
    /// No participant has this name.
    #[error("expected a participant, found {name:?}; the nearest: {nearest}", nearest = .nearest.join(", "))]
    UnknownMember {
        /// The name.
        name: String,
        /// Names that are alike.
        nearest: Vec<String>,
    },
    /// Two participants of one name.
    #[error("expected participants of different names, found two called {name:?}")]
    TwoMembers {
        /// The name.
        name: String,
    },
    /// A text that names no variable of a participant.
    #[error("expected PARTICIPANT.VARIABLE, found {found:?}")]
    Terminal {
        /// The text.
        found: String,
    },
    /// Ends that do not go together.
    #[error("{connection}: expected {expected}, found {found}")]
    Connection {
        /// Which connection.
        connection: String,
        /// What it takes.
        expected: &'static str,
        /// What there is.
        found: String,
    },
    /// Two outputs connected to one input.
    #[error("{target}: expected one source, found two, {first} and {second}")]
    TwoSources {
        /// The input.
        target: String,
        /// The output connected first.
        first: String,
        /// The output connected second.
        second: String,
    },
    /// A participant whose own step is none of the run's.
    #[error(
        "{member}: expected a step that is a multiple of the communication step of {step} s, found {found} s"
    )]
    OwnStep {
        /// The participant.
        member: String,
        /// The communication step [s].
        step: f64,
        /// The participant's own [s].
        found: f64,
    },
    /// A participant that steps of an error control are not for.
    #[error(
        "{member}: expected a participant that {reason}: with a tolerance steps are cut and taken back"
    )]
    Untolerant {
        /// The participant.
        member: String,
        /// What it should do.
        reason: &'static str,
    },
    /// A value that no variable can have.
    #[error("{variable}: expected a finite value, found {found} from {from}")]
    NotFinite {
        /// The input.
        variable: String,
        /// The value.
        found: f64,
        /// The output it comes from.
        from: String,
    },
    /// A participant was to go back to a state, and kept none.
    #[error("expected a state that was kept, found none")]
    NothingKept,
    /// A participant failed.
    #[error("{member} at {time} s{doing}: {cause}")]
    Member {
        /// Its name.
        member: String,
        /// The communication point [s].
        time: f64,
        /// What was being done, after a blank, or nothing.
        doing: String,
        /// Why.
        cause: Box<Error>,
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
    /// The variable has no start value of its own.
    #[error("variable {name}: expected one that can be set before the start, found {found}")]
    NotSettable {
        /// The variable.
        name: String,
        /// What it is.
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

impl Error {
    /// No variable of `model` is called `name`; these are `known`.
    pub(crate) fn unknown_variable<'a>(
        model: &str,
        name: &str,
        known: impl IntoIterator<Item = &'a str>,
    ) -> Self {
        Self::UnknownVariable {
            model: model.to_owned(),
            name: name.to_owned(),
            nearest: nearest(name, known),
        }
    }
}

/// Those of `known` that are most like `name`, best first: at most three, at least one.
pub fn nearest<'a>(name: &str, known: impl IntoIterator<Item = &'a str>) -> Vec<String> {
    let name = name.to_lowercase();
    let likeness = |k: &str| {
        let part = !name.is_empty() && (k.contains(&name) || name.contains(k));
        strsim::normalized_damerau_levenshtein(&name, k).max(if part { 0.7 } else { 0.0 })
    };
    let mut scored: Vec<(f64, &str)> = known
        .into_iter()
        .map(|k| (likeness(&k.to_lowercase()), k))
        .collect();
    // stable: equals keep the order of the table
    scored.sort_by(|a, b| b.0.total_cmp(&a.0));
    let alike = scored
        .iter()
        .filter(|(likeness, _)| *likeness > 0.5)
        .count()
        .clamp(1, 3);
    scored
        .into_iter()
        .take(alike)
        .map(|(_, k)| k.to_owned())
        .collect()
}
