//! The windows replayed, and how they compare with the record.

use super::Time;
use super::noise::deviation;
use crate::error::Result;
use crate::progress::Watch;
use crate::solver::{Limits, Search, minimise};
use nalgebra::DVector;
use std::ops::Range;

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

    /// Each channel's windows as recorded and what the replay at `z` leaves of them.
    pub fn leftovers(&self, z: &DVector<f64>) -> Result<Vec<Leftover>> {
        let residuals = self.residuals(z)?;
        let leftover = |(c, channel): (usize, &&'static str)| {
            let left = self.left(&residuals, c);
            let measured: Vec<f64> = self.samples().map(|i| self.measured[c][i]).collect();
            Leftover {
                channel,
                measured: self.parted(&measured),
                left: self.parted(&left),
            }
        };
        Ok(self.channels.iter().enumerate().map(leftover).collect())
    }

    /// What belongs to each window of `all`, one window behind the other.
    fn parted(&self, mut all: &[f64]) -> Vec<Vec<f64>> {
        let part = |window: &Range<usize>| {
            let (own, rest) = all.split_at(window.len());
            all = rest;
            own.to_vec()
        };
        self.windows.iter().map(part).collect()
    }

    /// How the replay at `z` compares with the record.
    pub fn replays(&self, z: &DVector<f64>) -> Result<Vec<Replay>> {
        Ok(self.leftovers(z)?.iter().map(Leftover::replay).collect())
    }
}

/// A channel's windows, and what a replay leaves of them [SI].
#[derive(Debug, Clone)]
pub struct Leftover {
    /// Name of the channel.
    pub channel: &'static str,
    /// As recorded, window by window.
    pub measured: Vec<Vec<f64>>,
    /// Recorded minus replayed.
    pub left: Vec<Vec<f64>>,
}

impl Leftover {
    /// How the replay compares with the record.
    pub fn replay(&self) -> Replay {
        let (left, measured) = (self.left.concat(), self.measured.concat());
        let windows = self.left.iter().zip(&self.measured);
        let power = left.iter().map(|v| v * v).sum::<f64>() / left.len() as f64;
        Replay {
            channel: self.channel.into(),
            variance_accounted_for: accounted_for(&left, &measured),
            median_window: median(windows.map(|(l, m)| accounted_for(l, m)).collect()),
            residual_rms: power.sqrt(),
        }
    }
}

/// Variance accounted for, 1 − var(left)/var(measured): unlike the fit in per cent it forgives an
/// offset.
fn accounted_for(left: &[f64], measured: &[f64]) -> f64 {
    1.0 - (deviation(left) / deviation(measured)).powi(2)
}

/// The middle one, of an even number the mean of the two in the middle.
fn median(mut values: Vec<f64>) -> f64 {
    values.sort_by(f64::total_cmp);
    let n = values.len();
    0.5 * (values[(n - 1) / 2] + values[n / 2])
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_perfect_model_accounts_for_all_and_an_offset_is_forgiven() {
        let y = [1.0, -2.0, 0.5, 3.0];
        assert_eq!(accounted_for(&[0.0; 4], &y), 1.0);
        // rounding of a mean
        assert!((accounted_for(&[3.0; 4], &y) - 1.0).abs() < 1e-12);
        // half of the amplitude missing: a quarter of the variance
        assert!((accounted_for(&y.map(|y| 0.5 * y), &y) - 0.75).abs() < 1e-12);
    }

    #[test]
    fn the_median_of_an_even_number_lies_between_the_middle_two() {
        assert_eq!(median(vec![3.0, 1.0, 2.0]), 2.0);
        assert_eq!(median(vec![4.0, 1.0, 3.0, 2.0]), 2.5);
    }
}
