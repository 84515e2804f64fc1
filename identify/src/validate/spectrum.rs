//! A predicted spectrum, beside the one that came.

use crate::compare::{BANDS, expectation_interval};
use crate::distribution::{gamma_quantile, normal_half_width};
use crate::error::Result;
use crate::objective::spectral::Spectral;
use crate::validate::residual::BAND;
use nalgebra::{Complex, DVector};
use serde::{Deserialize, Serialize};

/// A channel's rms in a band, predicted over measured.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct BandError {
    /// Name of the channel.
    pub channel: String,
    /// Low end [Hz].
    pub low: f64,
    /// High end [Hz].
    pub high: f64,
    /// Bins in it.
    pub bins: usize,
    /// Root mean square of the measured residual [SI].
    pub measured: f64,
    /// What the model expects [SI].
    pub expected: f64,
    /// Expected over measured.
    pub ratio: f64,
    /// The same in decibels.
    pub decibels: f64,
    /// 95 % interval of the ratio: one ride scatters about what it is expected to be.
    pub interval: (f64, f64),
}

/// Yᴴ S⁻¹ Y of each bin: how far the coefficients are from where the model expects them.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Misfit {
    /// Frequencies of the bins [Hz].
    pub frequency: Vec<f64>,
    /// Yᴴ S⁻¹ Y over the number of channels: 1 on average where the model is true.
    pub misfit: Vec<f64>,
    /// What holds it in 99 % of the bins where the model is true.
    pub band: (f64, f64),
    /// Part of the bins outside.
    pub outside: f64,
    /// Mean over the bins.
    pub mean: f64,
    /// What holds the mean in 99 % of the rides where the model is true.
    pub mean_band: (f64, f64),
}

/// A spectrum against its model.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Predicted {
    /// The bands of each channel.
    pub bands: Vec<BandError>,
    /// The bins.
    pub misfit: Misfit,
}

/// The spectrum of `spectral` against its model at the variables `z`.
pub fn predicted(spectral: &Spectral, z: &DVector<f64>) -> Result<Predicted> {
    let measured = &spectral.measured;
    let expected = spectral.expected(z)?;
    let frequency = measured.analysis.frequencies();
    let channels = measured.channels.len() as f64;
    let factor = measured.analysis.recipe().taper.covariance_factor();

    let mut bands = Vec::new();
    for (c, channel) in measured.channels.iter().enumerate() {
        for (low, high) in BANDS {
            let inside: Vec<usize> = (0..frequency.len())
                .filter(|&k| (low..high).contains(&frequency[k]))
                .collect();
            if inside.is_empty() {
                continue;
            }
            let root = |power: f64| (2.0 * power / measured.analysis.duration()).sqrt();
            let found = inside
                .iter()
                .map(|&k| measured.coefficients[k][c].norm_sqr());
            let found = root(found.sum());
            let model = root(inside.iter().map(|&k| expected[k][(c, c)].re).sum());
            let ratio = model / found;
            // neighbours under a taper are worth fewer bins; what is expected does not scatter
            let worth = (inside.len() as f64 / factor).max(1.0);
            bands.push(BandError {
                channel: (*channel).into(),
                low,
                high,
                bins: inside.len(),
                measured: found,
                expected: model,
                ratio,
                decibels: 20.0 * ratio.log10(),
                interval: expectation_interval(ratio, worth),
            });
        }
    }

    let distance = |(k, y): (usize, &DVector<Complex<f64>>)| {
        let factor = expected[k].clone().cholesky();
        factor.map_or(f64::INFINITY, |f| y.dotc(&f.solve(y)).re / channels)
    };
    let misfit: Vec<f64> = measured
        .coefficients
        .iter()
        .enumerate()
        .map(distance)
        .collect();
    let tail = 0.5 * (1.0 - BAND);
    let quantile = |p| gamma_quantile(channels, p) / channels;
    let band = (quantile(tail), quantile(1.0 - tail));
    let outside = misfit
        .iter()
        .filter(|m| **m < band.0 || **m > band.1)
        .count();
    let n = misfit.len() as f64;
    // each bin's variance is 1/channels; the taper's neighbours add to that of the mean
    let spread = normal_half_width(BAND) * (factor / (n * channels)).sqrt();
    Ok(Predicted {
        bands,
        misfit: Misfit {
            mean: misfit.iter().sum::<f64>() / n,
            mean_band: (1.0 - spread, 1.0 + spread),
            outside: outside as f64 / n,
            frequency,
            misfit,
            band,
        },
    })
}
