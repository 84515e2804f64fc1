//! The linear system of bicycle, rider and controller, by its eigenvalues.

use super::Known;
use crate::error::{Error, Result};
use nalgebra::Complex;
use serde::Serialize;
use std::f64::consts::TAU;

/// Eigenvalues and what they say of the ride.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Modes {
    /// Real and imaginary parts [1/s].
    pub eigenvalues: Vec<[f64; 2]>,
    /// The oscillation of least damping ratio.
    pub least_damped: Known<Oscillation>,
    /// Largest real part [1/s]: growth of what grows fastest, negative where all decays.
    pub growth: f64,
}

/// A pair of complex eigenvalues.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Oscillation {
    /// |Im λ|/2π [Hz].
    pub frequency: f64,
    /// −Re λ/|λ|, negative where it grows.
    pub damping_ratio: f64,
}

impl Modes {
    /// Of the eigenvalues, if they are known.
    pub(super) fn of(
        found: &std::result::Result<Vec<Complex<f64>>, String>,
    ) -> Result<Known<Self>> {
        let values = match found {
            Ok(values) if values.is_empty() => {
                return Ok(Known::Null("the closed loop has no state".into()));
            }
            Ok(values) => values,
            Err(reason) => return Ok(Known::Null(reason.clone())),
        };
        if let Some(value) = values.iter().find(|v| !(v.re + v.im).is_finite()) {
            return Err(Error::Incomparable {
                what: "closed loop".into(),
                expected: "finite eigenvalues".into(),
                found: value.to_string(),
            });
        }
        let oscillation = |value: &Complex<f64>| Oscillation {
            frequency: value.im / TAU,
            damping_ratio: -value.re / value.norm(),
        };
        let least_damped = values
            .iter()
            .filter(|value| value.im > 0.0)
            .map(oscillation)
            .min_by(|a, b| a.damping_ratio.total_cmp(&b.damping_ratio));
        Ok(Known::Value(Self {
            eigenvalues: values.iter().map(|value| [value.re, value.im]).collect(),
            least_damped: least_damped.map_or_else(
                || Known::Null("no eigenvalue is complex".into()),
                Known::Value,
            ),
            growth: values
                .iter()
                .map(|v| v.re)
                .fold(f64::NEG_INFINITY, f64::max),
        }))
    }
}
