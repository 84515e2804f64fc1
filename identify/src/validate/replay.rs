//! Windows that were replayed, beside the record.

use super::residual::{
    Correlations, Whiteness, cross_correlation, fit_percent, variance_accounted_for, whiteness,
};
use crate::error::Result;
use crate::objective::time::Time;
use crate::ride::Ride;
use nalgebra::DVector;
use serde::{Deserialize, Serialize};
use std::ops::Range;

/// A channel replayed.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Replayed {
    /// Name of the channel.
    pub channel: String,
    /// Fit over all windows [%].
    pub fit: f64,
    /// Variance accounted for, over all windows.
    pub variance_accounted_for: f64,
    /// The same of the median window.
    pub median_window: f64,
    /// Residual, rms [SI].
    pub residual_rms: f64,
    /// Whether the residual is white.
    pub whiteness: Whiteness,
    /// Correlation of the residual with the steer torque.
    pub torque: Correlations,
}

/// The windows of `ride` replayed with the parameters at `z`, each from the start that fits best.
pub fn replayed(windows: &Time, z: &DVector<f64>, ride: &Ride) -> Result<Vec<Replayed>> {
    let models = windows.replay_all(z)?;
    let channels = windows.channels.iter().zip(models);
    let samples: Vec<usize> = windows.samples().collect();
    let torque = ride.signal("steer_torque")?;
    let middle = torque.iter().sum::<f64>() / torque.len() as f64;
    channels
        .map(|(channel, model)| {
            let all = ride.channel(channel)?;
            let measured: Vec<f64> = samples.iter().map(|&i| all[i]).collect();
            let residual: Vec<f64> = measured.iter().zip(&model).map(|(y, m)| y - m).collect();
            let torque: Vec<f64> = samples.iter().map(|&i| torque[i] - middle).collect();
            let parts = parted(&residual, windows.ranges());
            let inputs = parted(&torque, windows.ranges());
            let mut each: Vec<f64> = parted(&measured, windows.ranges())
                .into_iter()
                .zip(parted(&model, windows.ranges()))
                .map(|(y, m)| variance_accounted_for(y, m))
                .collect();
            each.sort_by(f64::total_cmp);
            let power = residual.iter().map(|r| r * r).sum::<f64>() / residual.len() as f64;
            Ok(Replayed {
                channel: (*channel).into(),
                fit: fit_percent(&measured, &model),
                variance_accounted_for: variance_accounted_for(&measured, &model),
                median_window: each[each.len() / 2],
                residual_rms: power.sqrt(),
                whiteness: whiteness(&parts, ride.step(), LAGS),
                torque: cross_correlation(&parts, &inputs, ride.step(), LAGS),
            })
        })
        .collect()
}

/// What belongs to each of `windows`, one behind the other in `all`.
fn parted<'a>(mut all: &'a [f64], windows: &[Range<usize>]) -> Vec<&'a [f64]> {
    let part = |window: &Range<usize>| {
        let (own, rest) = all.split_at(window.len());
        all = rest;
        own
    };
    windows.iter().map(part).collect()
}

/// Lags looked at, each way.
const LAGS: usize = 25;
