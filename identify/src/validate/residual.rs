//! What a residual still holds: its correlation with itself and with the input, and how much of
//! the record the model accounts for. Ljung 1999, *System Identification*, §16.6.
//!
//! Records come in segments, windows that are replayed each from its own start: products reach
//! over no seam.

use crate::distribution::{chi_square_tail, normal_half_width};
use serde::{Deserialize, Serialize};

/// Probability that a band holds a correlation where there is none.
pub const BAND: f64 = 0.99;

/// Correlations at lags, and the band that holds each with probability [`BAND`] where there is
/// none.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Correlations {
    /// Lags [s]; of a cross-correlation how long the residual comes after the input.
    pub lag: Vec<f64>,
    /// Correlations.
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
    /// Ljung & Box's statistic, χ² with as many degrees of freedom as lags.
    pub statistic: f64,
    /// Probability of a larger one where the residual is white.
    pub probability: f64,
}

/// Σ x_i y_{i+lag} over all segments, and the number of products.
fn products(x: &[&[f64]], y: &[&[f64]], lag: usize) -> (f64, usize) {
    let pairs = x.iter().zip(y).map(|(x, y)| {
        let later = y.get(lag..).unwrap_or_default();
        let sum: f64 = x.iter().zip(later).map(|(a, b)| a * b).sum();
        (sum, later.len())
    });
    pairs.fold((0.0, 0), |(s, n), (sum, count)| (s + sum, n + count))
}

/// Mean of x_i y_{i+lag} over the roots of the mean squares.
fn correlation(x: &[&[f64]], y: &[&[f64]], lag: usize) -> (f64, usize) {
    let (sum, count) = products(x, y, lag);
    let power = |x: &[&[f64]]| {
        let (sum, count) = products(x, x, 0);
        sum / count as f64
    };
    (sum / count as f64 / (power(x) * power(y)).sqrt(), count)
}

/// Lags up to `most`, fewer where the longest segment has not twice as many samples.
fn lags(segments: &[&[f64]], most: usize) -> usize {
    let longest = segments.iter().map(|s| s.len()).max().unwrap_or(0);
    most.min(longest / 2)
}

impl Correlations {
    fn new(lag: Vec<f64>, value: Vec<f64>, band: Vec<f64>) -> Self {
        let outside = value
            .iter()
            .zip(&band)
            .filter(|(v, b)| v.abs() > **b)
            .count();
        Self {
            outside: outside as f64 / lag.len().max(1) as f64,
            lag,
            value,
            band,
        }
    }
}

/// Autocorrelation of the residual `e`, samples `step` [s] apart, at 1 to `most` lags.
pub fn whiteness(e: &[&[f64]], step: f64, most: usize) -> Whiteness {
    let half_width = normal_half_width(BAND);
    let samples: usize = e.iter().map(|s| s.len()).sum();
    let n = samples as f64;
    let (mut lag, mut value, mut band) = (Vec::new(), Vec::new(), Vec::new());
    let mut statistic = 0.0;
    for k in 1..=lags(e, most) {
        let (r, count) = correlation(e, e, k);
        lag.push(k as f64 * step);
        value.push(r);
        band.push(half_width / (count as f64).sqrt());
        // Ljung & Box 1978: n (n + 2) Σ r² / (n − k) with r = Σ e e / Σ e², of one segment
        statistic += r * r * count as f64 * (n + 2.0) / n;
    }
    Whiteness {
        probability: chi_square_tail(lag.len() as f64, statistic),
        statistic,
        correlations: Correlations::new(lag, value, band),
    }
}

/// Correlation of the residual `e` with the input `u` at lags −`most` to `most`. Under
/// independence its variance is Σ_k ρ_ee(k) ρ_uu(k)/n: slow signals correlate by chance.
pub fn cross_correlation(e: &[&[f64]], u: &[&[f64]], step: f64, most: usize) -> Correlations {
    let most = lags(e, most);
    let longest = e.iter().map(|s| s.len()).max().unwrap_or(0);
    let both = |k: usize| correlation(e, e, k).0 * correlation(u, u, k).0;
    // the triangle keeps the sum positive, and is what a mean over products has
    let fade = |k: usize| 1.0 - k as f64 / longest as f64;
    let tail: f64 = (1..longest).map(|k| 2.0 * fade(k) * both(k)).sum();
    let spread = (1.0 + tail).max(f64::MIN_POSITIVE).sqrt();
    let half_width = normal_half_width(BAND) * spread;
    let at = |k: isize| {
        let lag = k.unsigned_abs();
        let (r, count) = if k < 0 {
            correlation(e, u, lag)
        } else {
            correlation(u, e, lag)
        };
        (k as f64 * step, r, half_width / (count as f64).sqrt())
    };
    let most = most.cast_signed();
    let rows: Vec<_> = (-most..=most).map(at).collect();
    Correlations::new(
        rows.iter().map(|r| r.0).collect(),
        rows.iter().map(|r| r.1).collect(),
        rows.iter().map(|r| r.2).collect(),
    )
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

/// Variance accounted for, 1 − var(y − ŷ)/var(y): unlike the fit it forgives an offset.
pub fn variance_accounted_for(measured: &[f64], model: &[f64]) -> f64 {
    let variance = |y: &[f64]| {
        let middle = mean(y);
        y.iter().map(|v| (v - middle).powi(2)).sum::<f64>()
    };
    let residual: Vec<f64> = measured.iter().zip(model).map(|(y, m)| y - m).collect();
    1.0 - variance(&residual) / variance(measured)
}

#[cfg(test)]
mod tests {
    use super::*;
    use rand::SeedableRng;
    use rand_distr::{Distribution, StandardNormal};
    use rand_xoshiro::Xoshiro256PlusPlus;

    fn noise(seed: u64, n: usize) -> Vec<f64> {
        let mut rng = Xoshiro256PlusPlus::seed_from_u64(seed);
        (0..n).map(|_| StandardNormal.sample(&mut rng)).collect()
    }

    /// x_i = a x_{i−1} + white.
    fn coloured(seed: u64, n: usize, a: f64) -> Vec<f64> {
        let mut x = 0.0;
        noise(seed, n)
            .into_iter()
            .map(|e| {
                x = a * x + e;
                x
            })
            .collect()
    }

    #[test]
    fn white_noise_is_white_as_often_as_it_is_said_to_be() {
        // 400 records of 8 windows: P(p < .05) = .05 ± .011, 3 deviations; 1 % of the lags outside
        let records: Vec<Whiteness> = (0..400)
            .map(|seed| {
                let e = noise(seed, 800);
                let windows: Vec<&[f64]> = e.chunks(100).collect();
                whiteness(&windows, 0.005, 20)
            })
            .collect();
        let low = records.iter().filter(|w| w.probability < 0.05).count();
        assert!((8..=33).contains(&low), "{low} of 400");
        let outside: f64 = records.iter().map(|w| w.correlations.outside).sum::<f64>() / 400.0;
        assert!((outside - 0.01).abs() < 0.004, "{outside}");
    }

    #[test]
    fn coloured_noise_is_not_white_and_shows_its_pole() {
        let e = coloured(3, 4000, 0.6);
        let w = whiteness(&[&e], 0.005, 20);
        assert!(w.probability < 1e-10, "{}", w.probability);
        // ρ_k = a^k, to three times 1/√n
        assert!((w.correlations.value[0] - 0.6).abs() < 0.05);
        assert!((w.correlations.value[1] - 0.36).abs() < 0.06);
    }

    #[test]
    fn independent_slow_signals_stay_within_a_band_that_knows_they_are_slow() {
        // with 1/√n alone a third of the lags would lie outside
        let (mut outside, mut naive) = (0.0, 0.0);
        for seed in 0..60 {
            let (e, u) = (coloured(seed, 2000, 0.9), coloured(1000 + seed, 2000, 0.9));
            let c = cross_correlation(&[&e], &[&u], 0.005, 50);
            outside += c.outside / 60.0;
            let beyond = |v: &&f64| v.abs() > 2.5758 / 2000_f64.sqrt();
            naive += c.value.iter().filter(beyond).count() as f64 / c.value.len() as f64 / 60.0;
        }
        assert!(outside < 0.03, "{outside}");
        assert!(naive > 0.2, "{naive}");
    }

    #[test]
    fn an_input_that_the_model_has_missed_shows_at_its_lag() {
        let u = noise(5, 2000);
        let e: Vec<f64> = noise(6, 2000)
            .iter()
            .enumerate()
            .map(|(i, n)| n + 0.5 * if i >= 7 { u[i - 7] } else { 0.0 })
            .collect();
        let c = cross_correlation(&[&e], &[&u], 0.01, 20);
        let peak = (0..41).max_by(|&a, &b| c.value[a].abs().total_cmp(&c.value[b].abs()));
        let peak = peak.expect("lags");
        assert!((c.lag[peak] - 0.07).abs() < 1e-12);
        assert!(c.value[peak] > 3.0 * c.band[peak]);
    }

    #[test]
    fn windows_are_not_joined() {
        // a jump between windows is no correlation inside them: 1, 1, −1, −1 in windows of two
        let windows: [&[f64]; 2] = [&[1.0, 1.0], &[-1.0, -1.0]];
        let w = whiteness(&windows, 1.0, 5);
        assert_eq!(w.correlations.value, [1.0]);
    }

    #[test]
    fn a_perfect_model_fits_all_and_the_mean_nothing() {
        let y = noise(1, 100);
        assert_eq!(fit_percent(&y, &y), 100.0);
        assert_eq!(variance_accounted_for(&y, &y), 1.0);
        assert!(fit_percent(&y, &vec![mean(&y); 100]).abs() < 1e-12);
        let shifted: Vec<f64> = y.iter().map(|v| v + 3.0).collect();
        assert!((variance_accounted_for(&y, &shifted) - 1.0).abs() < 1e-12);
        assert!(fit_percent(&y, &shifted) < 0.0);
        // half of the amplitude missing: 50 %, and a quarter of the variance
        let half: Vec<f64> = y.iter().map(|v| 0.5 * (v + mean(&y))).collect();
        assert!((fit_percent(&y, &half) - 50.0).abs() < 1e-9);
        assert!((variance_accounted_for(&y, &half) - 0.75).abs() < 1e-12);
    }
}
