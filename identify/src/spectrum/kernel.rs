//! How a spectral density comes to the bins of a record.

use super::Analysis;
use nalgebra::Complex;
use std::f64::consts::TAU;

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
    pub(super) fn new(analysis: &Analysis) -> Self {
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
