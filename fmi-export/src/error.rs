//! What can be refused, and in which words.

use crate::{Kind, State};
use fmi2::{fmi2Discard, fmi2Error, fmi2Status};
use model_description::{Causality, Platform, Variability};
use std::path::PathBuf;

/// A refused call, an early end, or an FMU that could not be packed.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum Error {
    /// The function is not legal in this state.
    #[error("{function} is not allowed in state {state}")]
    NotAllowed {
        /// Name of the function.
        function: &'static str,
        /// The state.
        state: State,
    },
    /// The function belongs to a capability the description does not declare.
    #[error("{function} is not provided: modelDescription.xml does not declare the capability")]
    NotProvided {
        /// Name of the function.
        function: &'static str,
    },
    /// No variable has this value reference.
    #[error("expected a value reference below {count}, found {found}")]
    UnknownReference {
        /// The value reference.
        found: u32,
        /// Number of variables.
        count: usize,
    },
    /// As many values as value references are needed.
    #[error("expected {references} values, one for each value reference, found {values}")]
    Length {
        /// Number of value references.
        references: usize,
        /// Number of values.
        values: usize,
    },
    /// The variable is of another type.
    #[error("variable {name}: expected a call for {expected}, found one for {found:?}")]
    WrongType {
        /// Name of the variable.
        name: String,
        /// The variable's type.
        expected: &'static str,
        /// The type of the call.
        found: Kind,
    },
    /// No derivative of this kind exists of the variable, or by it.
    #[error("variable {name}: expected {expected}, found another variable")]
    NoDerivative {
        /// Name of the variable.
        name: String,
        /// What it would have to be.
        expected: &'static str,
    },
    /// A derivative of another order than the first.
    #[error("variable {name}: expected a derivative of order 1, found one of order {found}")]
    Order {
        /// Name of the variable.
        name: String,
        /// The order.
        found: i32,
    },
    /// The pointer is no saved state, or one that was freed.
    #[error("argument FMUstate: expected a state from fmi2GetFMUstate, found another pointer")]
    UnknownState,
    /// Bytes that are no saved state of this model.
    #[error("serialised state: {0}")]
    Bytes(String),
    /// The variable may not be set in this state.
    #[error("variable {name} ({causality:?}, {variability:?}) cannot be set in state {state}")]
    NotSettable {
        /// Name of the variable.
        name: String,
        /// Its causality.
        causality: Causality,
        /// Its variability.
        variability: Variability,
        /// The state.
        state: State,
    },
    /// NaN or infinite.
    #[error("variable {name}: expected a finite value, found {found}")]
    NotFinite {
        /// Name of the variable.
        name: String,
        /// The value.
        found: f64,
    },
    /// Outside the range of the description.
    #[error("variable {name}: expected a value in [{min}, {max}]{unit}, found {found}")]
    OutOfRange {
        /// Name of the variable.
        name: String,
        /// Smallest value.
        min: f64,
        /// Largest value.
        max: f64,
        /// Unit of all three after a space, or nothing.
        unit: String,
        /// The value.
        found: f64,
    },
    /// A time or tolerance that makes no sense.
    #[error("{what}: expected {expected}, found {found}")]
    Experiment {
        /// Which argument.
        what: &'static str,
        /// What it must be.
        expected: String,
        /// What it was.
        found: f64,
    },
    /// Initialization mode was entered before the experiment was set up.
    #[error("expected fmi2SetupExperiment before fmi2EnterInitializationMode")]
    NoExperiment,
    /// The model refused.
    #[error("{0}")]
    Model(String),
    /// The model came to its end within a step.
    #[error("{why}; the last successful time is {at} s")]
    Ended {
        /// The last successful time [s].
        at: f64,
        /// The reason.
        why: String,
    },
    /// A status that exists only while a step is pending, or not at all.
    #[error("{function}: status kind {kind} is not available, no step is ever pending")]
    NoStatus {
        /// Name of the function.
        function: &'static str,
        /// The kind asked for.
        kind: i32,
    },
    /// A null pointer where there must be none.
    #[error("argument {argument}: expected a pointer, found NULL")]
    Null {
        /// Name of the argument in the standard.
        argument: &'static str,
    },
    /// A text that is not UTF-8.
    #[error("argument {argument}: expected UTF-8, found other bytes")]
    NotUtf8 {
        /// Name of the argument in the standard.
        argument: &'static str,
    },
    /// An instance without a name.
    #[error("argument instanceName: expected a name, found an empty text")]
    NoName,
    /// Not for co-simulation.
    #[error("argument fmuType: expected fmi2CoSimulation (1), found {found}")]
    NotCoSimulation {
        /// The type.
        found: i32,
    },
    /// The resource location is no folder.
    #[error("argument fmuResourceLocation: expected {expected}, found {found}")]
    ResourceLocation {
        /// What it must be.
        expected: &'static str,
        /// What it was.
        found: String,
    },
    /// Start values that were packed cannot be used.
    #[error("{path}: {why}")]
    Start {
        /// The file.
        path: PathBuf,
        /// What was expected, what was found.
        why: String,
    },
    /// The description belongs to another binary.
    #[error("argument fmuGUID: expected {expected}, found {found}")]
    Guid {
        /// The binary's guid.
        expected: String,
        /// The guid given.
        found: String,
    },
    /// A log category the description does not list.
    #[error("expected a log category out of {known}, found {found}")]
    UnknownCategory {
        /// The category.
        found: String,
        /// The categories there are.
        known: String,
    },
    /// The model's description contradicts itself.
    #[error("model description: {0}")]
    Description(String),
    /// The description could not be written.
    #[error(transparent)]
    Xml(#[from] model_description::Error),
    /// A file could not be read or written.
    #[error("{path}: {source}")]
    File {
        /// The file.
        path: PathBuf,
        /// The reason.
        source: std::io::Error,
    },
    /// The archive could not be written.
    #[error("{path}: {source}")]
    Zip {
        /// The file.
        path: PathBuf,
        /// The reason.
        source: zip::result::ZipError,
    },
    /// A file that is no shared library.
    #[error("{path}: expected a shared library (ELF, PE or Mach-O), found {found}")]
    NoLibrary {
        /// The file.
        path: PathBuf,
        /// What it is instead.
        found: String,
    },
    /// A library for another platform than it was given for.
    #[error("{path}: expected a library for {expected}, found one for {found}")]
    OtherPlatform {
        /// The file.
        path: PathBuf,
        /// The platform it was given for.
        expected: Platform,
        /// The one it is for.
        found: Platform,
    },
    /// A library that is no FMU's.
    #[error(
        "{path}: expected the functions of FMI 2.0 for co-simulation, not exported: {}",
        shortened(missing)
    )]
    MissingFunctions {
        /// The file.
        path: PathBuf,
        /// Names of the functions.
        missing: Vec<&'static str>,
    },
    /// The description was changed after its guid was made, and with it what the library must do.
    #[error("modelDescription.xml: expected the guid {expected}, its fingerprint, found {found}")]
    Fingerprint {
        /// The fingerprint.
        expected: String,
        /// The guid.
        found: String,
    },
    /// A path that an archive cannot have, or that the description has.
    #[error("{path}: expected a path below the root of the FMU, such as documentation/index.html")]
    Entry {
        /// The path.
        path: String,
    },
    /// Two files of one path in the archive.
    #[error("{path}: expected one file of this path in the FMU, found two")]
    SameEntry {
        /// The path.
        path: String,
    },
    /// A date that is none.
    #[error("SOURCE_DATE_EPOCH: expected seconds since 1970, up to the year 2107, found {found}")]
    Epoch {
        /// The value of the environment variable.
        found: String,
    },
}

/// The first five of `names`, and how many there are besides.
pub(crate) fn shortened<T: AsRef<str>>(names: &[T]) -> String {
    let shown: Vec<&str> = names.iter().take(5).map(AsRef::as_ref).collect();
    match names.len() - shown.len() {
        0 => shown.join(", "),
        more => format!("{} and {more} more", shown.join(", ")),
    }
}

impl Error {
    /// The status that says it through the interface.
    pub fn status(&self) -> fmi2Status {
        match self {
            Self::Ended { .. } | Self::NoStatus { .. } => fmi2Discard,
            _ => fmi2Error,
        }
    }
}
