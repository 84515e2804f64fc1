//! The windows replayed, and how they compare with the record.

use super::Time;
use crate::error::Result;
use crate::progress::Watch;
use crate::solver::{Limits, Search, minimise};
use nalgebra::DVector;

/// How a replay compares with the record, channel by channel.
#[derive(Debug, Clone, PartialEq, serde::Serialize, serde::Deserialize)]
pub struct Replay {
    /// Name of the channel.
    pub channel: String,
    /// Variance accounted for, 1 − var(residual)/var(measured).
    pub variance_accounted_for: f64,
    /// The same within a window, in the median window.
    pub median_window: f64,
    /// Residual, rms [SI].
    pub residual_rms: f64,
}

/// Iterations of a search for initial states alone: a least-squares problem that is nearly linear.
const SETTLING: u64 = 30;

impl Time {
    /// The shared variables of `z` with the initial states that explain each window best: what a
    /// model predicts of a ride it was not fitted to. Long windows by way of short ones.
    pub fn settled(&self, z: &DVector<f64>) -> Result<DVector<f64>> {
        let shared = z.rows(0, self.shared()).into_owned();
        let limits = Limits {
            lower: shared.clone(),
            upper: shared.clone(),
            reach: DVector::from_element(shared.len(), 1.0),
        };
        let held: Vec<usize> = (0..shared.len()).collect();
        let search = Search {
            limits: &limits,
            held: &held,
            tolerance: 1e-5,
            max_iterations: SETTLING,
            watch: Watch::default(),
        };
        let mut settled = shared;
        let mut before: Option<Self> = None;
        for left in (0..=self.halvings()).rev() {
            let stage = self.halved(left);
            let own = match &before {
                None => stage.start().as_slice()[self.shared()..].to_vec(),
                // each window begins where the first of its two parts did
                Some(_) => settled.as_slice()[self.shared()..]
                    .chunks(self.order)
                    .step_by(2)
                    .flatten()
                    .copied()
                    .collect(),
            };
            let shared = settled.iter().take(self.shared()).copied();
            let start = DVector::from_vec(shared.chain(own).collect());
            settled = minimise(&stage, start, &search)?.point;
            before = Some(stage);
        }
        Ok(settled)
    }

    /// The channels replayed with the shared variables of `z`, each window from the initial state
    /// that explains it best, in the order of [`Self::samples`]: one list a channel.
    pub fn replay_all(&self, z: &DVector<f64>) -> Result<Vec<Vec<f64>>> {
        let residuals = self.residuals(&self.settled(z)?)?;
        let channels = 0..self.channels.len();
        Ok(channels
            .map(|c| {
                let left = self.left(&residuals, c);
                let measured = self.samples().map(|i| self.measured[c][i]);
                measured.zip(left).map(|(y, left)| y - left).collect()
            })
            .collect())
    }

    /// How the replay at `z` compares with the record.
    pub fn replays(&self, z: &DVector<f64>) -> Result<Vec<Replay>> {
        let residuals = self.residuals(z)?;
        let replay = |(c, channel): (usize, &&'static str)| {
            let left = self.left(&residuals, c);
            let measured: Vec<f64> = self.samples().map(|i| self.measured[c][i]).collect();
            let mut rest = (&left[..], &measured[..]);
            let mut windows: Vec<f64> = (self.windows.iter())
                .map(|window| {
                    let (left, after) = rest.0.split_at(window.len());
                    let (measured, later) = rest.1.split_at(window.len());
                    rest = (after, later);
                    accounted_for(left, measured)
                })
                .collect();
            windows.sort_by(f64::total_cmp);
            let power = left.iter().map(|v| v * v).sum::<f64>() / left.len() as f64;
            Replay {
                channel: (*channel).into(),
                variance_accounted_for: accounted_for(&left, &measured),
                median_window: windows[windows.len() / 2],
                residual_rms: power.sqrt(),
            }
        };
        Ok(self.channels.iter().enumerate().map(replay).collect())
    }
}

/// 1 − var(left)/var(measured).
fn accounted_for(left: &[f64], measured: &[f64]) -> f64 {
    1.0 - variance(left) / variance(measured)
}

fn variance(y: &[f64]) -> f64 {
    let mean = y.iter().sum::<f64>() / y.len() as f64;
    y.iter().map(|v| (v - mean).powi(2)).sum::<f64>() / y.len() as f64
}
