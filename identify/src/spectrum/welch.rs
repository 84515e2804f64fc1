//! Frequency responses from an input to an output by overlapped, windowed averaging. Welch 1967;
//! Bendat & Piersol 2010, ch. 9.

use super::Taper;
use nalgebra::Complex;
use rustfft::FftPlanner;

/// A frequency response as measured, at the bins of the averaged windows.
#[derive(Debug, Clone, PartialEq)]
pub struct Response {
    /// Frequencies [Hz], 0 left out.
    pub frequency: Vec<f64>,
    /// `G_xy/G_xx` [output unit per input unit].
    pub response: Vec<Complex<f64>>,
    /// γ², 0 to 1: the part of the output's power that the input explains linearly.
    pub coherence: Vec<f64>,
    /// Two-sided power spectral density of the input [unit²/Hz].
    pub input: Vec<f64>,
    /// Number of independent averages n_d: overlapping windows share what they see.
    pub averages: f64,
}

impl Response {
    /// Random error ε of |G|, relative, and of the phase [rad] at bin `k`.
    /// `ε = √(1 − γ²)/(|γ| √(2 n_d))`
    pub fn random_error(&self, k: usize) -> f64 {
        let coherence = self.coherence[k];
        ((1.0 - coherence) / (2.0 * self.averages * coherence)).sqrt()
    }
}

/// The response of `output` to `input`, `step` [s] apart, averaged over Hann windows of `window`
/// samples that overlap by half, means taken off. None where fewer than two windows fit.
pub fn response(input: &[f64], output: &[f64], step: f64, window: usize) -> Option<Response> {
    let hop = (window / 2).max(1);
    let samples = input.len().min(output.len());
    if window < 4 || samples < window + hop {
        return None;
    }
    let fft = FftPlanner::new().plan_fft_forward(window);
    let weights: Vec<f64> = (0..window).map(|i| Taper::Hann.weight(i, window)).collect();
    let transform = |y: &[f64]| {
        let mean = y.iter().sum::<f64>() / window as f64;
        let tapered = y.iter().zip(&weights).map(|(y, w)| (y - mean) * w);
        let mut z: Vec<Complex<f64>> = tapered.map(Complex::from).collect();
        fft.process(&mut z);
        z
    };
    let bins = 1..window.div_ceil(2);
    let (mut xx, mut yy) = (vec![0.0; window], vec![0.0; window]);
    let mut xy = vec![Complex::from(0.0); window];
    let starts = (0..=samples - window).step_by(hop);
    let segments = starts.clone().count();
    for start in starts {
        let x = transform(&input[start..start + window]);
        let y = transform(&output[start..start + window]);
        for k in bins.clone() {
            xx[k] += x[k].norm_sqr();
            yy[k] += y[k].norm_sqr();
            xy[k] += x[k].conj() * y[k];
        }
    }
    let n = segments as f64;
    // neighbouring Hann windows that overlap by half are correlated by 1/6
    let averages = n / (1.0 + 2.0 * (n - 1.0) / n / 36.0);
    Some(Response {
        frequency: bins
            .clone()
            .map(|k| k as f64 / (window as f64 * step))
            .collect(),
        response: bins.clone().map(|k| xy[k] / xx[k]).collect(),
        coherence: bins
            .clone()
            .map(|k| (xy[k].norm_sqr() / (xx[k] * yy[k])).min(1.0))
            .collect(),
        input: bins.map(|k| xx[k] * step / (window as f64 * n)).collect(),
        averages,
    })
}
