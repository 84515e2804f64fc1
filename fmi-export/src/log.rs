//! Log categories, and which of them are wanted.

use crate::Error;
use fmi2::{fmi2Discard, fmi2Fatal, fmi2Status, fmi2Warning};
use model_description::Category;
use std::ffi::CStr;

const WARNING: &CStr = c"logStatusWarning";
const DISCARD: &CStr = c"logStatusDiscard";
const ERROR: &CStr = c"logStatusError";
const FATAL: &CStr = c"logStatusFatal";

/// The categories under which this crate logs, for the description (FMI 2.0 §2.2.4).
pub fn log_categories() -> Vec<Category> {
    [
        (WARNING, "calls that were obeyed but look odd"),
        (DISCARD, "steps that ended early"),
        (ERROR, "calls that were refused"),
        (FATAL, "failures after which the instance is unusable"),
    ]
    .into_iter()
    .map(|(name, description)| Category {
        name: name.to_string_lossy().into_owned(),
        description: Some(description.to_owned()),
    })
    .collect()
}

/// The category of a line that goes with `status`.
#[expect(non_upper_case_globals, reason = "the standard's names")]
pub(crate) fn category(status: fmi2Status) -> &'static CStr {
    match status {
        fmi2Warning => WARNING,
        fmi2Discard => DISCARD,
        fmi2Fatal => FATAL,
        _ => ERROR,
    }
}

/// Which categories the importer wants to hear of.
#[derive(Clone, Debug, PartialEq)]
pub(crate) enum Wanted {
    None,
    All,
    Only(Vec<String>),
}

impl Wanted {
    /// As `fmi2SetDebugLogging` says (FMI 2.0 §2.1.5): off, all, or only those listed.
    pub(crate) fn new(on: bool, listed: Vec<String>, known: &[Category]) -> Result<Self, Error> {
        if let Some(unknown) = listed
            .iter()
            .find(|name| known.iter().all(|category| category.name != **name))
        {
            let names: Vec<&str> = known.iter().map(|category| &*category.name).collect();
            return Err(Error::UnknownCategory {
                found: unknown.clone(),
                known: names.join(", "),
            });
        }
        Ok(match (on, listed.is_empty()) {
            (false, _) => Self::None,
            (true, true) => Self::All,
            (true, false) => Self::Only(listed),
        })
    }

    pub(crate) fn contains(&self, category: &CStr) -> bool {
        match self {
            Self::None => false,
            Self::All => true,
            Self::Only(names) => names
                .iter()
                .any(|name| name.as_bytes() == category.to_bytes()),
        }
    }
}
