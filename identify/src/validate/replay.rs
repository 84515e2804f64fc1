//! Windows that were replayed, beside the record.

use super::residual::{Correlations, Left, Whiteness, cross_correlation, fit_percent, whiteness};
use crate::error::Result;
use crate::objective::time::{Leftover, Replay, Time};
use crate::ride::Ride;
use nalgebra::DVector;
use serde::{Deserialize, Serialize};

/// A channel replayed.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Replayed {
    /// How the replay compares with the record.
    #[serde(flatten)]
    pub replay: Replay,
    /// Fit over all windows [%].
    pub fit: f64,
    /// Whether the residual is white.
    pub whiteness: Whiteness,
    /// Correlation of the residual with the steer torque, where that was recorded.
    pub torque: Option<Correlations>,
}

/// The windows of `ride` replayed with the parameters at `z`, each from the start that fits best.
pub fn replayed(windows: &Time, z: &DVector<f64>, ride: &Ride) -> Result<Vec<Replayed>> {
    let settled = windows.settled(z)?;
    let bases = windows.hat_bases(&settled)?;
    let torque = ride.channel("steer_torque").ok().map(|torque| {
        let middle = torque.iter().sum::<f64>() / torque.len() as f64;
        let window = |w: &std::ops::Range<usize>| torque[w.clone()].iter().map(|t| t - middle);
        let all: Vec<Vec<f64>> = windows
            .ranges()
            .iter()
            .map(|w| window(w).collect())
            .collect();
        all
    });
    let channel = |(c, leftover): (usize, Leftover)| {
        let replay = leftover.replay();
        let model: Vec<f64> = (leftover.measured.iter().flatten())
            .zip(leftover.left.iter().flatten())
            .map(|(measured, left)| measured - left)
            .collect();
        let fit = fit_percent(&leftover.measured.concat(), &model);
        let own = leftover.left.into_iter().zip(&bases);
        let left: Vec<Left> = own
            .map(|(residual, basis)| Left {
                basis: basis.rows(c * residual.len(), residual.len()).into_owned(),
                residual,
            })
            .collect();
        Replayed {
            replay,
            fit,
            whiteness: whiteness(&left, ride.step()),
            torque: torque
                .as_ref()
                .map(|u| cross_correlation(&left, u, ride.step())),
        }
    };
    let channels = windows.leftovers(&settled)?.into_iter().enumerate();
    Ok(channels.map(channel).collect())
}
