//! The spectrum of a channel: residual of a moving average, Fourier bins of a band, lines masked.
//! Measured and simulated rides pass through here alike.

use crate::error::{Error, Result};
use nalgebra::Complex;
use rustfft::{Fft, FftPlanner};
use serde::{Deserialize, Serialize};
use std::f64::consts::{PI, TAU};
use std::sync::Arc;

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

/// Moving average over `window` samples. An even window takes n/2 before and n/2 − 1 after, and
/// the window shrinks at the ends, both as MATLAB's `movmean` does.
pub fn moving_average(y: &[f64], window: usize) -> Vec<f64> {
    let mut sums = Vec::with_capacity(y.len() + 1);
    sums.push(0.0);
    for value in y {
        sums.push(sums[sums.len() - 1] + value);
    }
    let (before, after) = (window / 2, (window - 1) / 2);
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

    /// Amplitude [unit] of a sine of `frequency` [Hz] in `y`, by least squares on the residual.
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

/// Carries a spectral density to the bins: E|Y_k|² = ∫ |W_k(f)|² S(f) df, W_k(f) the response of
/// bin k, moving average and taper included, to e^{2πift}. No leakage is left out.
#[derive(Debug, Clone)]
pub struct Kernel {
    /// Frequencies [Hz] at which the density is wanted, from 0.
    pub frequencies: Vec<f64>,
    /// |W_k(f)|² + |W_k(−f)|², times df; bin by bin.
    even: Vec<f64>,
    /// |W_k(f)|² − |W_k(−f)|², times df: what the imaginary part of a cross-density meets.
    odd: Vec<f64>,
}

impl Kernel {
    fn new(analysis: &Analysis) -> Self {
        // four points to a bin resolve |W_k|² of a record of that length, and 2 Hz beyond the
        // band hold all that leaks into it
        let spacing = 0.25 / analysis.duration();
        let top = (analysis.recipe.band.1 + 2.0).min(0.5 / analysis.step);
        let frequencies: Vec<f64> = (0..=(top / spacing) as usize)
            .map(|j| j as f64 * spacing)
            .collect();
        let (bins, n) = (analysis.bins.len(), analysis.samples);
        let mut even = vec![0.0; bins * frequencies.len()];
        let mut odd = even.clone();
        for (j, &f) in frequencies.iter().enumerate() {
            let (re, im): (Vec<f64>, Vec<f64>) = (0..n)
                .map(|i| {
                    let (s, c) = (TAU * f * analysis.step * i as f64).sin_cos();
                    (c, s)
                })
                .unzip();
            let (re, im) = (
                analysis.transform(&re, &analysis.taper),
                analysis.transform(&im, &analysis.taper),
            );
            for (b, &k) in analysis.bins.iter().enumerate() {
                // e^{iωt} = cos + i sin, e^{−iωt} = cos − i sin
                let turn = Complex::<f64>::i() * im[k];
                let (plus, minus) = ((re[k] + turn).norm_sqr(), (re[k] - turn).norm_sqr());
                let minus = if j == 0 { 0.0 } else { minus };
                even[b * frequencies.len() + j] = (plus + minus) * spacing;
                odd[b * frequencies.len() + j] = (plus - minus) * spacing;
            }
        }
        Self {
            frequencies,
            even,
            odd,
        }
    }

    /// Expected |Y_k|² from an even density `density` [unit²/Hz] on [`Self::frequencies`].
    pub fn expect_real(&self, density: &[f64]) -> Vec<f64> {
        fold(&self.even, density)
    }

    /// Expected imaginary part of a cross-power from the odd imaginary part of a cross-density.
    pub fn expect_imaginary(&self, density: &[f64]) -> Vec<f64> {
        fold(&self.odd, density)
    }
}

fn fold(kernel: &[f64], density: &[f64]) -> Vec<f64> {
    kernel
        .chunks_exact(density.len())
        .map(|row| row.iter().zip(density).map(|(w, s)| w * s).sum())
        .collect()
}

#[cfg(test)]
mod tests {
    #![expect(clippy::unwrap_used, reason = "a failed step is a failed test")]
    use super::*;

    const STEP: f64 = 0.005;
    const SAMPLES: usize = 4800;

    fn analysis(taper: Taper) -> Analysis {
        Analysis::new(
            &Recipe {
                taper,
                ..Recipe::default()
            },
            STEP,
            SAMPLES,
        )
        .unwrap()
    }

    fn sine(frequency: f64, amplitude: f64) -> Vec<f64> {
        (0..SAMPLES)
            .map(|i| amplitude * (TAU * frequency * STEP * i as f64 + 0.4).sin())
            .collect()
    }

    #[test]
    fn an_even_window_takes_one_more_before_than_after_and_shrinks_at_the_ends() {
        let y = [1.0, 2.0, 4.0, 8.0, 16.0];
        // MATLAB: movmean([1 2 4 8 16], 4), movmean(…, 3)
        assert_eq!(
            moving_average(&y, 4),
            [1.5, 7.0 / 3.0, 3.75, 7.5, 28.0 / 3.0]
        );
        assert_eq!(
            moving_average(&y, 3),
            [1.5, 7.0 / 3.0, 14.0 / 3.0, 28.0 / 3.0, 12.0]
        );
    }

    #[test]
    fn a_sine_on_a_bin_has_its_amplitude_there_times_the_moving_averages_gain() {
        // gain of the residual 1 − sin(5πf)/(5πf): 1.21, .87, 1.09 at .3, .5, .7 Hz
        for (f, gain) in [(0.3, 1.2122), (0.5, 0.8727), (0.7, 1.0909)] {
            let exact = 1.0 - (5.0 * PI * f).sin() / (5.0 * PI * f);
            assert!((exact - gain).abs() < 1e-4, "known gain at {f} Hz: {exact}");
            // ten minutes, so that the shrinking windows at the ends weigh under 1 %
            let n = 120_000;
            let recipe = Recipe {
                taper: Taper::Hann,
                ..Recipe::default()
            };
            let long = Analysis::new(&recipe, STEP, n).unwrap();
            let y: Vec<f64> = (0..n)
                .map(|i| 2.0 * (TAU * f * STEP * i as f64).sin())
                .collect();
            let bin = long
                .frequencies()
                .iter()
                .position(|b| (b - f).abs() < 1e-9)
                .unwrap();
            let amplitude = long.coefficients(&y)[bin].norm() * long.to_amplitude();
            assert!(
                (amplitude / 2.0 / gain - 1.0).abs() < 2e-3,
                "{f} Hz: {amplitude}"
            );
        }
        // and with both tapers on a 24 s record; the shrinking windows at its ends weigh .2 %
        for taper in [Taper::Rectangle, Taper::Hann] {
            let a = analysis(taper);
            let bin = a
                .frequencies()
                .iter()
                .position(|f| (f - 2.5).abs() < 1e-9)
                .unwrap();
            let amplitude = a.coefficients(&sine(2.5, 0.1))[bin].norm() * a.to_amplitude();
            let gain = 1.0 - (12.5 * PI).sin() / (12.5 * PI);
            assert!(
                (amplitude / 0.1 / gain - 1.0).abs() < 5e-3,
                "{taper:?}: {amplitude}"
            );
        }
    }

    #[test]
    fn parseval() {
        let y: Vec<f64> = (0..SAMPLES)
            .map(|i| ((i * i) as f64 * 0.37).sin())
            .collect();
        let a = analysis(Taper::Rectangle);
        let power: f64 = a
            .transform(&y, &a.taper)
            .iter()
            .map(Complex::norm_sqr)
            .sum();
        let energy: f64 = residual(&y, 1000).iter().map(|z| z * z).sum();
        // Σ_k |Y_k|² = step · Σ_i z_i², to round-off
        assert!((power / (energy * STEP) - 1.0).abs() < 1e-12);
    }

    #[test]
    fn the_kernel_carries_white_noise_and_a_sine_as_the_transform_does() {
        for taper in [Taper::Rectangle, Taper::Hann] {
            let a = analysis(taper);
            let kernel = a.kernel();
            // a sine of amplitude 1 between bins has the two-sided density ¼ at ± f
            let j = kernel.frequencies.len() / 3;
            let mut density = vec![0.0; kernel.frequencies.len()];
            density[j] = 0.25 / kernel.frequencies[1];
            let expected = kernel.expect_real(&density);
            // mean over phases: that of a sine and a cosine
            let (s, c) = (
                sine(kernel.frequencies[j], 1.0),
                (0..SAMPLES)
                    .map(|i| (TAU * kernel.frequencies[j] * STEP * i as f64 + 0.4).cos())
                    .collect::<Vec<_>>(),
            );
            let (s, c) = (a.coefficients(&s), a.coefficients(&c));
            for (k, e) in expected.iter().enumerate() {
                let mean = 0.5 * (s[k].norm_sqr() + c[k].norm_sqr());
                assert!(
                    (mean - e).abs() < 1e-12 * expected.iter().fold(0.0, |a: f64, b| a.max(*b))
                );
            }
            // white noise of density 1, variance 1/step: the sum over its samples, one by one;
            // what leaks in from beyond the kernel's grid is below 1 %
            let white = kernel.expect_real(&vec![1.0; kernel.frequencies.len()]);
            let mut exact = vec![0.0; white.len()];
            let mut impulse = vec![0.0; SAMPLES];
            for i in 0..SAMPLES {
                impulse[i] = 1.0;
                for (sum, y) in exact.iter_mut().zip(a.coefficients(&impulse)) {
                    *sum += y.norm_sqr() / STEP;
                }
                impulse[i] = 0.0;
            }
            for (w, e) in white.iter().zip(&exact) {
                assert!((w / e - 1.0).abs() < 0.01, "{taper:?}: {w} {e}");
            }
        }
    }

    #[test]
    fn lines_are_masked_three_bins_to_each_side() {
        let recipe = Recipe {
            lines: vec![Line { frequency: 1.11 }],
            ..Recipe::default()
        };
        let f = Analysis::new(&recipe, STEP, SAMPLES).unwrap().frequencies();
        assert!(f.iter().all(|f| (f - 1.11).abs() > 3.0 / 24.0));
        assert_eq!(f.len(), analysis(Taper::Rectangle).frequencies().len() - 6);
        assert!(
            (analysis(Taper::Rectangle).line_amplitude(&sine(1.11, 0.2), 1.11) / 0.2 - 1.0).abs()
                < 0.02
        );
    }

    #[test]
    fn what_cannot_be_analysed_is_said() {
        let message =
            |recipe: Recipe, n| Analysis::new(&recipe, STEP, n).err().unwrap().to_string();
        assert_eq!(
            message(
                Recipe {
                    band: (3.0, 0.3),
                    ..Recipe::default()
                },
                SAMPLES
            ),
            "band: expected 0 <= low < high <= 100 Hz (Nyquist), found 3 to 0.3 Hz"
        );
        assert_eq!(
            message(Recipe::default(), 600),
            "moving average: expected 0.01 s to 3 s (the record), found 5 s"
        );
        assert_eq!(
            message(
                Recipe {
                    band: (0.30, 0.31),
                    ..Recipe::default()
                },
                SAMPLES
            ),
            "band 0.3 to 0.31 Hz: no unmasked bin in it, bins are 0.042 Hz apart"
        );
    }
}
