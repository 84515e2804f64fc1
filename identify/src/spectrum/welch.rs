//! Frequency responses from an input to outputs by overlapped, windowed averaging. Welch 1967;
//! Bendat & Piersol 2010, ch. 9.

use super::Taper;
use nalgebra::{Complex, DMatrix};
use rustfft::FftPlanner;

/// Frequency responses as measured, at the bins of the averaged windows.
#[derive(Debug, Clone, PartialEq)]
pub struct Responses {
    /// Frequencies [Hz], 0 left out.
    pub frequency: Vec<f64>,
    /// Of each output.
    pub outputs: Vec<Response>,
    /// At each bin the covariance E[δ_i δ̄_j] of the outputs' relative errors, δ = Ĝ/G − 1: what the
    /// input does not explain of two outputs may have one cause.
    pub scatter: Vec<DMatrix<Complex<f64>>>,
    /// Two-sided power spectral density of the input [unit²/Hz].
    pub input: Vec<f64>,
}

/// The response of an output at each bin.
#[derive(Debug, Clone, PartialEq)]
pub struct Response {
    /// `G_xy/G_xx` [output unit per input unit].
    pub response: Vec<Complex<f64>>,
    /// γ², 0 to 1: the part of the output's power that the input explains linearly.
    pub coherence: Vec<f64>,
}

/// The responses of `outputs` to `input`, `step` [s] apart, averaged over Hann windows of `window`
/// samples that overlap by half, means taken off. None where fewer than two windows fit.
pub fn responses(input: &[f64], outputs: &[&[f64]], step: f64, window: usize) -> Option<Responses> {
    let hop = (window / 2).max(1);
    let samples = outputs
        .iter()
        .map(|y| y.len())
        .fold(input.len(), usize::min);
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
    let (bins, n) = (1..window.div_ceil(2), outputs.len());
    let mut xx = vec![0.0; window];
    let mut xy = vec![vec![Complex::from(0.0); n]; window];
    let mut yy = vec![DMatrix::from_element(n, n, Complex::from(0.0)); window];
    let starts = (0..=samples - window).step_by(hop);
    let segments = starts.clone().count() as f64;
    for start in starts {
        let x = transform(&input[start..start + window]);
        let y: Vec<_> = (outputs.iter().map(|y| transform(&y[start..start + window]))).collect();
        for k in bins.clone() {
            xx[k] += x[k].norm_sqr();
            for i in 0..n {
                xy[k][i] += x[k].conj() * y[i][k];
                for j in 0..n {
                    yy[k][(i, j)] += y[i][k] * y[j][k].conj();
                }
            }
        }
    }
    // independent averages n_d: neighbouring Hann windows that overlap by half are correlated by 1/6
    let averages = segments / (1.0 + 2.0 * (segments - 1.0) / segments / 36.0);
    let output = |i: usize| Response {
        response: bins.clone().map(|k| xy[k][i] / xx[k]).collect(),
        coherence: bins
            .clone()
            .map(|k| (xy[k][i].norm_sqr() / (xx[k] * yy[k][(i, i)].re)).min(1.0))
            .collect(),
    };
    // what the input leaves of the outputs, S_ij − S_ix S_xj/S_xx, over n_d S_xx G_i Ḡ_j
    let scatter = |k: usize| {
        DMatrix::from_fn(n, n, |i, j| {
            let explained = xy[k][i] * xy[k][j].conj() / xx[k];
            (yy[k][(i, j)] / explained - 1.0) / averages
        })
    };
    Some(Responses {
        frequency: bins
            .clone()
            .map(|k| k as f64 / (window as f64 * step))
            .collect(),
        outputs: (0..n).map(output).collect(),
        scatter: bins.clone().map(scatter).collect(),
        input: bins
            .map(|k| xx[k] * step / (window as f64 * segments))
            .collect(),
    })
}
