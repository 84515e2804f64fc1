//! The times of a simulation and the tolerance wished for.

use crate::Error;
use serde::{Deserialize, Serialize};

/// What `fmi2SetupExperiment` said.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Experiment {
    /// Start time [s].
    pub start_time: f64,
    /// Time beyond which no step may go [s].
    pub stop_time: Option<f64>,
    /// Relative tolerance wished for.
    pub tolerance: Option<f64>,
}

impl Experiment {
    /// Whether it makes sense (FMI 2.0 §2.1.6).
    pub(crate) fn check(&self) -> Result<(), Error> {
        let start = self.start_time;
        if !start.is_finite() {
            return refuse("start time", "a finite time".to_owned(), start);
        }
        if let Some(stop) = self.stop_time
            && !(stop.is_finite() && stop >= start)
        {
            let expected = format!("a finite time not before the start at {start} s");
            return refuse("stop time", expected, stop);
        }
        if let Some(tolerance) = self.tolerance
            && !(tolerance.is_finite() && tolerance > 0.0)
        {
            return refuse("tolerance", "a positive number".to_owned(), tolerance);
        }
        Ok(())
    }
}

/// The error for a time or tolerance.
pub(crate) fn refuse<T>(what: &'static str, expected: String, found: f64) -> Result<T, Error> {
    Err(Error::Experiment {
        what,
        expected,
        found,
    })
}
