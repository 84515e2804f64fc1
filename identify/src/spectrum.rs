//! The spectrum of a channel: residual of a moving average, Fourier bins of a band, lines masked.
//! Measured and simulated rides pass through here alike.

mod kernel;
pub mod welch;

use crate::error::{Error, Result};
use nalgebra::Complex;
use rustfft::{Fft, FftPlanner};
use serde::{Deserialize, Serialize};
use std::f64::consts::{PI, TAU};
use std::sync::Arc;

pub use kernel::Kernel;

/// Weight of the samples over the record.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Taper {
    /// All alike.
    Rectangle,
    /// Hann, scaled to unit mean square: several channels need it, the rectangle leaks into
    /// their nearly singular cross-spectral matrix.
    Hann,
}

impl Taper {
    /// The taper for a spectrum of so many channels.
    pub fn of(channels: usize) -> Self {
        if channels > 1 {
            Self::Hann
        } else {
            Self::Rectangle
        }
    }

    /// Weight of sample `i` of `n`.
    fn weight(self, i: usize, n: usize) -> f64 {
        match self {
            Self::Rectangle => 1.0,
            Self::Hann => (8.0_f64 / 3.0).sqrt() * (PI * (i as f64 + 0.5) / n as f64).sin().powi(2),
        }
    }

    /// By how much the covariance of an estimate exceeds that from independent bins: the square
    /// of the Hann window correlates neighbours, Σ ρ² = 35/18.
    pub fn covariance_factor(self) -> f64 {
        match self {
            Self::Rectangle => 1.0,
            Self::Hann => 35.0 / 18.0,
        }
    }
}

/// A deterministic line in a spectrum: the slalom, or pedalling. Bins within ± 3/T of it are left
/// out, and its own covariance is added where the model is linearised.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Line {
    /// Frequency [Hz].
    pub frequency: f64,
}

/// How a spectrum is taken.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Recipe {
    /// Length of the moving average that is taken off [s].
    pub average: f64,
    /// Lowest and highest frequency [Hz].
    pub band: (f64, f64),
    /// Weight of the samples.
    pub taper: Taper,
    /// Lines to leave out.
    pub lines: Vec<Line>,
}

impl Default for Recipe {
    /// The paper's moving average, 1000 samples at 200 Hz, and the band it discusses.
    fn default() -> Self {
        Self {
            average: 5.0,
            band: (0.3, 3.0),
            taper: Taper::Rectangle,
            lines: Vec::new(),
        }
    }
}

/// Samples that a moving average of `window` samples takes before and after its own.
fn reach(window: usize) -> (usize, usize) {
    (window / 2, (window - 1) / 2)
}

/// Moving average over `window` samples. An even window takes n/2 before and n/2 − 1 after, and
/// the window shrinks at the ends, both as MATLAB's `movmean` does.
pub fn moving_average(y: &[f64], window: usize) -> Vec<f64> {
    let mut sums = Vec::with_capacity(y.len() + 1);
    sums.push(0.0);
    for value in y {
        sums.push(sums[sums.len() - 1] + value);
    }
    let (before, after) = reach(window);
    (0..y.len())
        .map(|i| {
            let (low, high) = (i.saturating_sub(before), (i + after + 1).min(y.len()));
            (sums[high] - sums[low]) / (high - low) as f64
        })
        .collect()
}

/// What the moving average leaves: the oscillation the paper looks at.
pub fn residual(y: &[f64], window: usize) -> Vec<f64> {
    moving_average(y, window)
        .iter()
        .zip(y)
        .map(|(mean, value)| value - mean)
        .collect()
}

/// A [`Recipe`] applied to records of one length: bins, transforms and the kernel that carries a
/// spectral density through the same filter, taper and record length.
#[derive(Clone)]
pub struct Analysis {
    recipe: Recipe,
    step: f64,
    samples: usize,
    window: usize,
    bins: Vec<usize>,
    taper: Vec<f64>,
    fft: Arc<dyn Fft<f64>>,
}

impl Analysis {
    /// For records of `samples` samples, `step` [s] apart.
    pub fn new(recipe: &Recipe, step: f64, samples: usize) -> Result<Self> {
        let (duration, (low, high)) = (samples as f64 * step, recipe.band);
        let nyquist = 0.5 / step;
        if !(low >= 0.0 && low < high && high <= nyquist) {
            return Err(Error::Band { low, high, nyquist });
        }
        if recipe.average > duration || recipe.average < 2.0 * step {
            return Err(Error::Average {
                average: recipe.average,
                duration,
                step,
            });
        }
        let outside = |line: &&Line| !(line.frequency > 0.0 && line.frequency < nyquist);
        if let Some(line) = recipe.lines.iter().find(outside) {
            return Err(Error::LineFrequency {
                found: line.frequency,
                nyquist,
            });
        }
        // a bin on an edge belongs to the band, whatever the rounding
        let edge = 1e-9;
        let bins: Vec<usize> = (1..samples.div_ceil(2))
            .filter(|&k| {
                let f = k as f64 / duration;
                let masked = |line: &Line| (f - line.frequency).abs() <= 3.0 / duration + edge;
                f >= low - edge && f <= high + edge && !recipe.lines.iter().any(masked)
            })
            .collect();
        if bins.is_empty() {
            return Err(Error::NoBins {
                low,
                high,
                width: 1.0 / duration,
            });
        }
        Ok(Self {
            recipe: recipe.clone(),
            step,
            samples,
            window: (recipe.average / step).round() as usize,
            bins,
            taper: (0..samples)
                .map(|i| recipe.taper.weight(i, samples))
                .collect(),
            fft: FftPlanner::new().plan_fft_forward(samples),
        })
    }

    /// The recipe.
    pub fn recipe(&self) -> &Recipe {
        &self.recipe
    }

    /// Length of the record [s].
    pub fn duration(&self) -> f64 {
        self.samples as f64 * self.step
    }

    /// Frequencies of the bins [Hz].
    pub fn frequencies(&self) -> Vec<f64> {
        self.bins.iter().map(|&k| self.frequency(k)).collect()
    }

    fn frequency(&self, bin: usize) -> f64 {
        bin as f64 / self.duration()
    }

    /// All Fourier coefficients of the residual under `taper`, scaled so that their mean square is
    /// the two-sided power spectral density [unit²/Hz].
    fn transform(&self, y: &[f64], taper: &[f64]) -> Vec<Complex<f64>> {
        assert_eq!(
            y.len(),
            self.samples,
            "the analysis was made for another length"
        );
        let scale = (self.step / self.samples as f64).sqrt();
        let mut z: Vec<_> = residual(y, self.window)
            .iter()
            .zip(taper)
            .map(|(value, weight)| Complex::new(value * weight * scale, 0.0))
            .collect();
        self.fft.process(&mut z);
        z
    }

    /// The coefficients of the band's bins [unit/√Hz].
    pub fn coefficients(&self, y: &[f64]) -> Vec<Complex<f64>> {
        let all = self.transform(y, &self.taper);
        self.bins.iter().map(|&k| all[k]).collect()
    }

    /// What each sample adds to each coefficient, real and imaginary part, sample after sample:
    /// residual, taper and transform are linear, so [`Self::coefficients`] is a product with these.
    pub fn weights(&self) -> Vec<[f64; 2]> {
        let (n, bins) = (self.samples, self.bins.len());
        let (before, after) = reach(self.window);
        let scale = (self.step / n as f64).sqrt();
        let mut weights = vec![[0.0; 2]; n * bins];
        for (b, &bin) in self.bins.iter().enumerate() {
            // the moving average turned round: what sample i takes off reaches over its window
            let mut starts = vec![Complex::new(0.0, 0.0); n + 1];
            let turn = |i: usize| {
                let angle = -TAU * (i * bin % n) as f64 / n as f64;
                Complex::from_polar(self.taper[i] * scale, angle)
            };
            for i in 0..n {
                let (low, high) = (i.saturating_sub(before), (i + after + 1).min(n));
                let share = turn(i) / (high - low) as f64;
                starts[low] += share;
                starts[high] -= share;
            }
            let mut taken = Complex::new(0.0, 0.0);
            for (i, start) in starts[..n].iter().enumerate() {
                taken += start;
                let weight = turn(i) - taken;
                weights[i * bins + b] = [weight.re, weight.im];
            }
        }
        weights
    }

    /// From a magnitude [unit/√Hz] to the amplitude of a sine [unit] on that bin: the one-sided
    /// amplitude spectrum.
    pub fn to_amplitude(&self) -> f64 {
        let gain = self.taper.iter().sum::<f64>() / self.samples as f64;
        2.0 / (self.duration().sqrt() * gain)
    }

    /// Standard deviation of the white noise in `y`, from the bins above `above` [Hz]; none where
    /// the record does not reach there. Always through a Hann window: what the rectangle leaks
    /// from below would be taken for noise.
    pub fn noise(&self, y: &[f64], above: f64) -> Option<f64> {
        let hann: Vec<f64> = (0..self.samples)
            .map(|i| Taper::Hann.weight(i, self.samples))
            .collect();
        let all = self.transform(y, &hann);
        let powers: Vec<f64> = (1..self.samples.div_ceil(2))
            .filter(|&k| self.frequency(k) > above)
            .map(|k| all[k].norm_sqr())
            .collect();
        let mean = powers.iter().sum::<f64>() / powers.len() as f64;
        (!powers.is_empty()).then(|| (mean / self.step).sqrt())
    }

    /// Frequencies [Hz] of the unmasked bins that stand out of their surroundings as noise hardly
    /// ever does: 25 times the median power within 1 Hz, which one bin of noise in 3 · 10⁷ reaches.
    pub fn standing_lines(&self, y: &[f64]) -> Vec<f64> {
        let power: Vec<f64> = self.coefficients(y).iter().map(Complex::norm_sqr).collect();
        let frequency = self.frequencies();
        let near = |k: usize, reach: f64| -> Vec<f64> {
            let close = |f: &f64| (f - frequency[k]).abs() <= reach;
            let bins = frequency.iter().zip(&power).filter(|(f, _)| close(f));
            bins.map(|(_, p)| *p).collect()
        };
        (0..power.len())
            .filter(|&k| {
                let mut around = near(k, 1.0);
                around.sort_by(f64::total_cmp);
                // of a line that leaks over several bins, its highest
                let highest = near(k, 3.0 / self.duration())
                    .into_iter()
                    .fold(0.0, f64::max);
                power[k] > 25.0 * around[around.len() / 2] && power[k] >= highest
            })
            .map(|k| frequency[k])
            .collect()
    }

    /// Amplitude [unit] of a sine of `frequency` [Hz] in `y`, from the residual's projection on it.
    pub fn line_amplitude(&self, y: &[f64], frequency: f64) -> f64 {
        let z = residual(y, self.window);
        let turn = |i: usize| Complex::from_polar(1.0, -TAU * frequency * self.step * i as f64);
        let sum: Complex<f64> = z
            .iter()
            .enumerate()
            .map(|(i, value)| turn(i) * *value)
            .sum();
        // what the moving average leaves of such a sine
        let x = PI * frequency * self.recipe.average;
        2.0 * sum.norm() / self.samples as f64 / (1.0 - x.sin() / x).abs()
    }

    /// The kernel |W_k(f)|² of these records.
    pub fn kernel(&self) -> Kernel {
        Kernel::new(self)
    }
}

#[cfg(test)]
mod tests;
