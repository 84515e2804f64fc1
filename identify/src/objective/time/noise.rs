//! The noise of the channels: what the model leaves of them.

use super::Time;
use crate::error::{Error, Result};
use crate::free::limits;
use crate::objective::spectral::QUIET;
use crate::progress::Watch;
use crate::solver::{Landscape, Search, minimise};
use crate::spectrum::{Analysis, Recipe};
use nalgebra::DVector;

/// Iterations of the search behind the noise: the residuals are there long before the parameters.
const ITERATIONS: u64 = 5;
/// It ends when an iteration lowers the cost by less than this for each observation.
const ENOUGH: f64 = 1e-3;
/// Where a model explains a channel to the last digit, its noise is this part of the channel.
const LEAST: f64 = 1e-6;

impl Time {
    /// Standard deviation of what a first search leaves of each channel, the channels weighted by
    /// the upper half of their spectra.
    pub(super) fn found_noise(&self) -> Result<Vec<f64>> {
        let mut pilot = self.immediate();
        for (noise, channel) in pilot.noise.iter_mut().zip(&self.measured) {
            *noise = white(channel, self.step, 0.25 / self.step)
                .unwrap_or(0.0)
                .max(LEAST * deviation(channel));
        }
        let limits = limits(&self.unknowns.free);
        let search = Search {
            limits: &limits,
            held: &[],
            tolerance: ENOUGH * pilot.observations() as f64,
            max_iterations: ITERATIONS,
            watch: Watch::default(),
        };
        let found = minimise(&pilot, pilot.start(), &search)?;
        let residuals = pilot.residuals(&found.point)?;
        let freedom = pilot.freedom();
        let noise = (0..self.channels.len()).map(|c| {
            let own = pilot.left(&residuals, c);
            let square = own.iter().map(|r| r * r).sum::<f64>() / own.len() as f64;
            let left = (square / freedom).sqrt();
            left.max(LEAST * deviation(&self.measured[c]))
        });
        Ok(noise.collect())
    }

    /// Share of the observations that no free parameter or initial state explains.
    fn freedom(&self) -> f64 {
        let explained = self.shared() + self.blocks();
        let observations = self.observations();
        observations.saturating_sub(explained).max(1) as f64 / observations as f64
    }

    /// What is left of channel `c` [SI], window after window.
    pub(super) fn left(&self, residuals: &[Vec<f64>], c: usize) -> Vec<f64> {
        let own = residuals.iter().flat_map(|window| {
            let length = window.len() / self.channels.len();
            &window[c * length..][..length]
        });
        own.map(|r| r * self.noise[c]).collect()
    }

    /// Mean square of what is left of the channels at `z` over that of white noise as strong as
    /// the left has it above 10 Hz, where a bicycle does not move: 1 where the model is true, more
    /// where it leaves motion behind.
    pub fn misfit(&self, z: &DVector<f64>) -> Result<f64> {
        let residuals = self.residuals(z)?;
        let mut sum = 0.0;
        for (c, channel) in self.channels.iter().enumerate() {
            let left = self.left(&residuals, c);
            let square = left.iter().map(|r| r * r).sum::<f64>() / left.len() as f64;
            let noise = white(&left, self.step, QUIET).ok_or_else(|| Error::NoNoise {
                channel: (*channel).into(),
                above: QUIET,
                nyquist: 0.5 / self.step,
            })?;
            sum += square / self.freedom() / (noise * noise).max(f64::MIN_POSITIVE);
        }
        Ok(sum / self.channels.len() as f64)
    }
}

/// Standard deviation of white noise as strong as `y` above `above` [Hz]; none where there is
/// nothing.
fn white(y: &[f64], step: f64, above: f64) -> Option<f64> {
    let recipe = Recipe {
        average: (y.len() as f64 * step).min(5.0),
        band: (0.0, 0.5 / step),
        ..Recipe::default()
    };
    Analysis::new(&recipe, step, y.len()).ok()?.noise(y, above)
}

/// Root mean square about the mean.
pub(super) fn deviation(y: &[f64]) -> f64 {
    let mean = y.iter().sum::<f64>() / y.len() as f64;
    (y.iter().map(|v| (v - mean).powi(2)).sum::<f64>() / y.len() as f64).sqrt()
}
