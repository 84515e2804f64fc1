//! Why a simulation ended.

use serde::{Deserialize, Serialize};
use std::fmt;

/// Why a simulation ended before it was asked to.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Stop {
    /// |steer| reached `steer_limit` at time `t` [s].
    SteerLimit {
        /// Time of the event [s].
        t: f64,
    },
    /// After time `t` [s] the bicycle lay on its side (|roll| > 90°) or a state was not finite.
    Diverged {
        /// Last time with a meaningful state [s].
        t: f64,
    },
}

impl Stop {
    /// When it ended [s].
    pub fn time(self) -> f64 {
        match self {
            Self::SteerLimit { t } | Self::Diverged { t } => t,
        }
    }

    /// The word for it in files: `steer_limit` or `diverged`.
    pub fn name(self) -> &'static str {
        match self {
            Self::SteerLimit { .. } => "steer_limit",
            Self::Diverged { .. } => "diverged",
        }
    }
}

impl fmt::Display for Stop {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        match self {
            Self::SteerLimit { t } => write!(f, "the steer limit was reached at {t} s"),
            Self::Diverged { t } => write!(f, "the bicycle fell over after {t} s"),
        }
    }
}

impl std::error::Error for Stop {}
