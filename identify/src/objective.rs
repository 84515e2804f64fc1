//! What a fit makes small: objectives over one kind of problem.

pub mod amplitude;
pub mod free_response;
pub mod frf;
pub mod simulated;
pub mod spectral;
pub mod time;
pub mod together;
pub mod whittle;

use crate::distribution::{COVERAGE, normal_half_width, student_half_width};
use crate::error::{Error, Result};
use crate::free::{Candidate, Free, Tie};
use nalgebra::{DMatrix, DVector};
use serde::{Deserialize, Serialize};

/// The objectives by name.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Objective {
    /// Expected amplitude against measured amplitude in each bin: the paper's comparison.
    Amplitude,
    /// Whittle likelihood of all channels with their cross-spectra.
    Whittle,
    /// The recorded torque replayed in short windows with free initial states.
    Time,
    /// Given windows in which the bicycle was left to itself, with free initial states.
    FreeResponse,
    /// The frequency response from the recorded torque, by CIFER's cost.
    Frf,
}

impl Objective {
    /// All of them.
    pub const ALL: [Self; 5] = [
        Self::Amplitude,
        Self::Whittle,
        Self::Time,
        Self::FreeResponse,
        Self::Frf,
    ];

    /// The name on the command line and in files.
    pub fn name(self) -> &'static str {
        match self {
            Self::Amplitude => "amplitude",
            Self::Whittle => "whittle",
            Self::Time => "time",
            Self::FreeResponse => "free-response",
            Self::Frf => "frf",
        }
    }
}

impl Objective {
    /// Whether nobody knows the torque, so that a remnant stands for it.
    pub fn has_remnant(self) -> bool {
        matches!(self, Self::Amplitude | Self::Whittle)
    }

    /// Refuses what only `those` offer.
    pub(crate) fn check(self, what: &str, those: &[Self]) -> Result<()> {
        if those.contains(&self) {
            return Ok(());
        }
        Err(self.refused(what, those))
    }

    /// That only `those` offer `what`.
    pub(crate) fn refused(self, what: &str, those: &[Self]) -> Error {
        let names: Vec<&str> = those.iter().map(|o| o.name()).collect();
        Error::Objective {
            what: what.into(),
            expected: names.join(", "),
            found: self.name(),
        }
    }

    /// Whether windows are replayed.
    pub fn is_replayed(self) -> bool {
        matches!(self, Self::Time | Self::FreeResponse)
    }
}

impl std::str::FromStr for Objective {
    type Err = Error;

    fn from_str(text: &str) -> Result<Self> {
        Self::ALL
            .into_iter()
            .find(|o| o.name() == text)
            .ok_or_else(|| Error::unknown("objective", text, Self::ALL.map(Self::name)))
    }
}

/// What an estimate can be judged by, in variables of the search.
#[derive(Debug, Clone)]
pub struct Information {
    /// Curvature over the free parameters, initial states eliminated.
    pub curvature: DMatrix<f64>,
    /// Covariance of the gradient; none where it equals the curvature but for a factor.
    pub meat: Option<DMatrix<f64>>,
    /// Degrees of freedom of the scatter that `meat` was found from; none where they are many.
    pub freedom: Option<f64>,
    /// By what the covariance exceeds the inverse curvature (neighbouring bins of a taper).
    pub factor: f64,
}

impl Information {
    /// Half width of a 95 % interval in standard errors.
    pub fn quantile(&self) -> f64 {
        self.freedom.map_or_else(
            || normal_half_width(COVERAGE),
            |freedom| student_half_width(freedom, COVERAGE),
        )
    }

    /// The curvature alone.
    #[must_use]
    pub fn plain(&self) -> Self {
        Self {
            curvature: self.curvature.clone(),
            meat: None,
            freedom: None,
            factor: 1.0,
        }
    }

    /// The same of the variables `kept` alone, the others known.
    #[must_use]
    pub fn of(&self, kept: &[usize]) -> Self {
        let select = |m: &DMatrix<f64>| m.select_rows(kept).select_columns(kept);
        Self {
            curvature: select(&self.curvature),
            meat: self.meat.as_ref().map(select),
            freedom: self.freedom,
            factor: self.factor,
        }
    }
}

/// What the estimator of one ride seeks, and the values of the rest.
#[derive(Debug, Clone)]
pub struct Unknowns {
    /// The free parameters.
    pub free: Vec<Free>,
    /// Rows that follow them.
    pub ties: Vec<Tie>,
    /// All values; those of the free parameters are where the search starts.
    pub start: Candidate,
}

impl Unknowns {
    /// The candidate at the variables `z` (further ones, of windows, are not looked at).
    pub fn candidate(&self, z: &DVector<f64>) -> Candidate {
        let mut candidate = self.start.at(&self.free, z);
        for tie in &self.ties {
            candidate.follow(tie, &self.start);
        }
        candidate
    }

    /// Whether the row called `name` is sought.
    pub fn seeks(&self, name: &str) -> bool {
        self.free.iter().any(|free| free.row.name == name)
    }
}
