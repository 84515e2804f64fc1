//! Windows that were replayed, beside the record.

use super::residual::{
    Correlations, Whiteness, cross_correlation, fit_percent, variance_accounted_for, whiteness,
};
use crate::error::Result;
use crate::objective::time::Time;
use crate::ride::Ride;
use nalgebra::DVector;
use serde::{Deserialize, Serialize};

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
    let length = windows.observations() / (windows.windows() * windows.channels.len());
    let torque = ride.signal("steer_torque")?;
    let middle = torque.iter().sum::<f64>() / torque.len() as f64;
    channels
        .map(|(channel, model)| {
            let measured = &ride.channel(channel)?[..model.len()];
            let residual: Vec<f64> = measured.iter().zip(&model).map(|(y, m)| y - m).collect();
            let torque: Vec<f64> = torque[..model.len()].iter().map(|t| t - middle).collect();
            let parts: Vec<&[f64]> = residual.chunks(length).collect();
            let inputs: Vec<&[f64]> = torque.chunks(length).collect();
            let mut windows: Vec<f64> = measured
                .chunks(length)
                .zip(model.chunks(length))
                .map(|(y, m)| variance_accounted_for(y, m))
                .collect();
            windows.sort_by(f64::total_cmp);
            let power = residual.iter().map(|r| r * r).sum::<f64>() / residual.len() as f64;
            Ok(Replayed {
                channel: (*channel).into(),
                fit: fit_percent(measured, &model),
                variance_accounted_for: variance_accounted_for(measured, &model),
                median_window: windows[windows.len() / 2],
                residual_rms: power.sqrt(),
                whiteness: whiteness(&parts, ride.step(), LAGS),
                torque: cross_correlation(&parts, &inputs, ride.step(), LAGS),
            })
        })
        .collect()
}

/// Lags looked at, each way.
const LAGS: usize = 25;
