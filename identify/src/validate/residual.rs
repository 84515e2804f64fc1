//! What a residual still holds: its correlation with itself and with the input. Ljung 1999, *System
//! Identification*, §16.6.
//!
//! Records come in windows that are replayed each from the start that fits best: products reach over
//! no seam, and least squares has taken its part out of each, H e of noise e. What is left of white
//! noise is therefore not white: its covariance is σ² (I − H), and a test that does not know this
//! rejects true models, the more surely the more windows there are. Noise of the torque sensor drives
//! the replay and is motion in what is left: a rejection may be the sensor's.

use crate::distribution::{chi_square_tail, normal_half_width, student_half_width};
use nalgebra::{DMatrix, DVector, SymmetricEigen};
use serde::{Deserialize, Serialize};

/// Probability that a band holds a correlation where there is none.
pub const BAND: f64 = 0.99;
/// Longest lag looked at [s]: a turn of the oscillation that the paper is about. No lag is longer than
/// half of the longest window.
const REACH: f64 = 1.0;

/// What is left of a channel in a window.
#[derive(Debug, Clone)]
pub struct Left {
    /// Measured minus replayed.
    pub residual: Vec<f64>,
    /// Its rows Q of an orthonormal basis of what was fitted to the window, H = Q Qᵀ; no columns where
    /// nothing was.
    pub basis: DMatrix<f64>,
}

impl Left {
    /// A residual from which nothing was fitted away.
    pub fn of(residual: Vec<f64>) -> Self {
        Self {
            basis: DMatrix::zeros(residual.len(), 0),
            residual,
        }
    }
}

/// Correlations at lags, and the band that holds each with probability [`BAND`] where there is
/// none.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Correlations {
    /// Lags [s]; of a cross-correlation how long the residual comes after the input.
    pub lag: Vec<f64>,
    /// Correlations, less what is expected where there is none.
    pub value: Vec<f64>,
    /// Half width of the band at each lag.
    pub band: Vec<f64>,
    /// Part of the lags outside the band; 1 − [`BAND`] is expected where there is no correlation.
    pub outside: f64,
}

/// Whether a residual is white.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Whiteness {
    /// Autocorrelations at lags above 0.
    pub correlations: Correlations,
    /// Squares of the autocorrelations over their covariance, χ²: Ljung & Box's statistic where nothing
    /// was fitted to the windows.
    pub statistic: f64,
    /// Its degrees of freedom: the lags, unless the windows are too short to tell them apart.
    pub freedom: usize,
    /// Probability of a larger one where the residual is white.
    pub probability: f64,
}

impl Correlations {
    /// Of lag, correlation and half width.
    fn of(rows: impl Iterator<Item = (f64, f64, f64)>) -> Self {
        let rows: Vec<_> = rows.collect();
        let outside = rows.iter().filter(|(_, value, band)| value.abs() > *band);
        Self {
            outside: outside.count() as f64 / rows.len().max(1) as f64,
            lag: rows.iter().map(|r| r.0).collect(),
            value: rows.iter().map(|r| r.1).collect(),
            band: rows.iter().map(|r| r.2).collect(),
        }
    }
}

/// Lags of windows whose samples are `step` [s] apart.
fn lags(windows: &[Left], step: f64) -> usize {
    let longest = windows.iter().map(|w| w.residual.len()).max().unwrap_or(0);
    ((REACH / step).round() as usize).min(longest / 2)
}

/// Σ x_i y_{i+lag}.
fn product(x: &[f64], y: &[f64], lag: usize) -> f64 {
    let later = y.get(lag..).unwrap_or_default();
    x.iter().zip(later).map(|(a, b)| a * b).sum()
}

/// Number of products of a window of `length` samples.
fn count(length: usize, lag: usize) -> f64 {
    length.saturating_sub(lag) as f64
}

/// Of quadratic forms rᵀ A_k r, A_k half of the sum of the shifts by k samples forth and back, at
/// lags 0 to `most`: mean and covariance where r has covariance I − H.
/// `E = tr(A_k (I − H)),   cov = 2 tr(A_k (I − H) A_l (I − H))`
fn moments(basis: &DMatrix<f64>, most: usize) -> (DVector<f64>, DMatrix<f64>) {
    let n = basis.nrows();
    let shifted = |k: usize| {
        if k == 0 {
            return basis.clone();
        }
        let mut sum = DMatrix::zeros(n, basis.ncols());
        if k < n {
            let mut early = sum.rows_mut(0, n - k);
            early += basis.rows(k, n - k) * 0.5;
            let mut late = sum.rows_mut(k, n - k);
            late += basis.rows(0, n - k) * 0.5;
        }
        sum
    };
    let shifted: Vec<DMatrix<f64>> = (0..=most).map(shifted).collect();
    let within: Vec<DMatrix<f64>> = shifted.iter().map(|s| basis.transpose() * s).collect();
    let mean = DVector::from_fn(most + 1, |k, _| {
        let all = if k == 0 { n as f64 } else { 0.0 };
        all - within[k].trace()
    });
    let mut covariance = DMatrix::zeros(most + 1, most + 1);
    for k in 0..=most {
        for l in 0..=k {
            let all = match (k, l) {
                (0, 0) => n as f64,
                _ if k == l => 0.5 * count(n, k),
                _ => 0.0,
            };
            // the trace of a product with a symmetric matrix is the sum of their entries' products
            let trace = all - 2.0 * shifted[k].dot(&shifted[l]) + within[k].dot(&within[l]);
            covariance[(k, l)] = 2.0 * trace;
            covariance[(l, k)] = 2.0 * trace;
        }
    }
    (mean, covariance)
}

/// Autocorrelation of what is left of `windows`, samples `step` [s] apart, against what is left of
/// white noise.
pub fn whiteness(windows: &[Left], step: f64) -> Whiteness {
    let most = lags(windows, step);
    let mut mean = DVector::zeros(most + 1);
    let mut covariance = DMatrix::zeros(most + 1, most + 1);
    let mut sums = DVector::zeros(most + 1);
    for Left { residual, basis } in windows {
        let own = moments(basis, most);
        mean += own.0;
        covariance += own.1;
        sums += DVector::from_fn(most + 1, |k, _| product(residual, residual, k));
    }
    // the noise's own strength is what it must be for lag 0
    let square = sums[0] / mean[0];
    let ratio = &mean / mean[0];
    let excess = DVector::from_fn(most, |k, _| sums[k + 1] / square - mean[k + 1]);
    let scatter = DMatrix::from_fn(most, most, |k, l| {
        let (k, l) = (k + 1, l + 1);
        covariance[(k, l)] - ratio[k] * covariance[(0, l)] - ratio[l] * covariance[(k, 0)]
            + ratio[k] * ratio[l] * covariance[(0, 0)]
    });
    let (statistic, freedom) = mahalanobis(&excess, scatter.clone());
    // Ljung & Box 1978: the mean square in the denominator scatters as well, by 2/n
    let statistic = statistic * (mean[0] + 2.0) / mean[0];
    let half_width = normal_half_width(BAND);
    let rows = (0..most).map(|k| {
        let products: f64 = (windows.iter())
            .map(|w| count(w.residual.len(), k + 1))
            .sum();
        let band = half_width * scatter[(k, k)].max(0.0).sqrt();
        ((k + 1) as f64 * step, excess[k] / products, band / products)
    });
    Whiteness {
        probability: match freedom {
            0 => 1.0,
            _ => chi_square_tail(freedom as f64, statistic),
        },
        statistic,
        freedom,
        correlations: Correlations::of(rows),
    }
}

/// xᵀ C⁻¹ x over the directions in which `covariance` is not singular, and their number.
fn mahalanobis(x: &DVector<f64>, covariance: DMatrix<f64>) -> (f64, usize) {
    if x.is_empty() {
        return (0.0, 0);
    }
    let eigen = SymmetricEigen::new(covariance);
    // of a sum of products of n numbers, rounding leaves far less
    let least = 1e-9 * eigen.eigenvalues.amax();
    let directions = eigen
        .eigenvalues
        .iter()
        .zip(eigen.eigenvectors.column_iter());
    let regular = directions.filter(|(value, _)| **value > least);
    regular.fold((0.0, 0), |(sum, n), (value, direction)| {
        (sum + direction.dot(x).powi(2) / value, n + 1)
    })
}

/// Correlation of what is left of `windows` with the input `u` in them, both ways. The band follows
/// from the scatter of the windows' own sums of products (Liang & Zeger 1986) by Student's t: slow
/// signals correlate by chance, and what a window's start takes up is gone from all of its products.
/// One window alone tells nothing: no lags.
pub fn cross_correlation(windows: &[Left], u: &[Vec<f64>], step: f64) -> Correlations {
    let clusters = windows.len() as f64;
    if windows.len() < 2 {
        return Correlations::of(std::iter::empty());
    }
    let half_width = student_half_width(clusters - 1.0, BAND);
    let power = |all: &mut dyn Iterator<Item = &[f64]>| {
        let (sum, n) = all.fold((0.0, 0), |(s, n), x| (s + product(x, x, 0), n + x.len()));
        sum / n as f64
    };
    let scale =
        power(&mut windows.iter().map(|w| &w.residual[..])) * power(&mut u.iter().map(|u| &u[..]));
    let at = |k: isize| {
        let lag = k.unsigned_abs();
        let sums: Vec<f64> = (windows.iter().zip(u))
            .map(|(Left { residual, .. }, u)| {
                if k < 0 {
                    product(residual, u, lag)
                } else {
                    product(u, residual, lag)
                }
            })
            .collect();
        let products: f64 = u.iter().map(|u| count(u.len(), lag)).sum();
        let sum: f64 = sums.iter().sum();
        let middle = sum / clusters;
        let square: f64 = sums.iter().map(|s| (s - middle).powi(2)).sum();
        let deviation = (square * clusters / (clusters - 1.0)).sqrt();
        let unit = products * scale.sqrt();
        (k as f64 * step, sum / unit, half_width * deviation / unit)
    };
    let most = lags(windows, step).cast_signed();
    Correlations::of((-most..=most).map(at))
}

fn mean(y: &[f64]) -> f64 {
    y.iter().sum::<f64>() / y.len() as f64
}

/// Fit in per cent as MATLAB's `compare` has it: 100 (1 − ‖y − ŷ‖/‖y − ȳ‖).
pub fn fit_percent(measured: &[f64], model: &[f64]) -> f64 {
    let middle = mean(measured);
    let error: f64 = measured
        .iter()
        .zip(model)
        .map(|(y, m)| (y - m).powi(2))
        .sum();
    let spread: f64 = measured.iter().map(|y| (y - middle).powi(2)).sum();
    100.0 * (1.0 - (error / spread).sqrt())
}

#[cfg(test)]
mod tests;
