//! The windows replayed, and how they compare with the record.

use super::Time;
use crate::error::Result;
use crate::solver::Block;
use bicycle::Bicycle;
use nalgebra::{DMatrix, DVector};

/// How a replay compares with the record, channel by channel.
#[derive(Debug, Clone, PartialEq, serde::Serialize, serde::Deserialize)]
pub struct Replay {
    /// Name of the channel.
    pub channel: String,
    /// Variance accounted for, 1 − var(residual)/var(measured).
    pub variance_accounted_for: f64,
    /// Residual, rms [SI].
    pub residual_rms: f64,
}

impl Time {
    /// The channels replayed with the free parameters at `z`, each window from the initial state
    /// that fits it best: one list over the samples a channel.
    pub fn replay_all(&self, z: &DVector<f64>) -> Result<Vec<Vec<f64>>> {
        let mut all = self.start();
        all.rows_mut(0, self.shared())
            .copy_from(&z.rows(0, self.shared()));
        let bicycle = self.bicycle(&all);
        let pieces = self.pieces(&bicycle)?;
        let mut replayed =
            vec![Vec::with_capacity(self.windows * self.length); self.channels.len()];
        for window in 0..self.windows {
            for _ in 0..4 {
                self.settle_window(&bicycle, pieces, &mut all, window);
            }
            let residuals = self.residuals(&bicycle, pieces, &all, window);
            for (k, residual) in residuals.iter().enumerate() {
                let (sample, c) = (k / self.channels.len(), k % self.channels.len());
                let measured = self.measured[c][window * self.length + sample];
                replayed[c].push(measured - residual * self.noise[c]);
            }
        }
        Ok(replayed)
    }

    /// Moves a window's initial state downhill: one damped Gauss–Newton step on it alone.
    fn settle_window(&self, bicycle: &Bicycle, pieces: usize, z: &mut DVector<f64>, window: usize) {
        let cost = self.residuals(bicycle, pieces, z, window).norm_squared();
        let Block {
            gradient,
            curvature,
            ..
        } = self.window(bicycle, pieces, z, window).blocks.remove(0);
        let at = self.place(window);
        let before = z.rows(at, self.order).into_owned();
        for damping in [1e-6, 1e-3, 1.0, 1e3] {
            let scaled = &curvature + DMatrix::from_diagonal(&curvature.diagonal()) * damping;
            if let Some(factor) = scaled.cholesky() {
                z.rows_mut(at, self.order)
                    .copy_from(&(&before - factor.solve(&gradient)));
                if self.residuals(bicycle, pieces, z, window).norm_squared() < cost {
                    return;
                }
            }
        }
        z.rows_mut(at, self.order).copy_from(&before);
    }

    /// How the replay at `z` compares with the record.
    pub fn replays(&self, z: &DVector<f64>) -> Result<Vec<Replay>> {
        let bicycle = self.bicycle(z);
        let pieces = self.pieces(&bicycle)?;
        let residuals: Vec<_> = (0..self.windows)
            .map(|w| self.residuals(&bicycle, pieces, z, w))
            .collect();
        let n = self.channels.len();
        let replays = (0..n)
            .map(|c| {
                let residual: Vec<f64> = residuals
                    .iter()
                    .flat_map(|r| r.iter().skip(c).step_by(n).map(|v| v * self.noise[c]))
                    .collect();
                let measured = &self.measured[c][..self.windows * self.length];
                let power = residual.iter().map(|v| v * v).sum::<f64>() / residual.len() as f64;
                Replay {
                    channel: self.channels[c].into(),
                    variance_accounted_for: 1.0 - variance(&residual) / variance(measured),
                    residual_rms: power.sqrt(),
                }
            })
            .collect();
        Ok(replays)
    }
}

fn variance(y: &[f64]) -> f64 {
    let mean = y.iter().sum::<f64>() / y.len() as f64;
    y.iter().map(|v| (v - mean).powi(2)).sum::<f64>() / y.len() as f64
}
