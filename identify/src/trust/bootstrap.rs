//! Parametric bootstrap: the whole fit done again on data that the fitted model makes. What its
//! estimates scatter by is the uncertainty, skewness and bias included. Efron & Tibshirani 1993.

use crate::trust::profile::COVERAGE;
use serde::{Deserialize, Serialize};

/// What a parameter's bootstrap estimates say of it, in the unit the estimates have.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Scatter {
    /// Standard deviation of the estimates.
    pub std_error: f64,
    /// Median of the estimates less the value that made the data.
    pub bias: f64,
    /// 2.5 % to 97.5 % of the estimates.
    pub percentile: (f64, f64),
    /// The same quantiles mirrored at the value: an estimator that is biased upwards lowers it.
    pub basic: (f64, f64),
}

/// The `p` quantile of sorted values: order statistic p (n + 1), straight in between.
fn quantile(sorted: &[f64], p: f64) -> f64 {
    let place = (p * (sorted.len() + 1) as f64 - 1.0).clamp(0.0, (sorted.len() - 1) as f64);
    let low = place.floor() as usize;
    let high = (low + 1).min(sorted.len() - 1);
    sorted[low] + (sorted[high] - sorted[low]) * (place - low as f64)
}

/// The scatter of `estimates` about the `value` that made their data; none of fewer than two.
pub fn scatter(value: f64, estimates: &[f64]) -> Option<Scatter> {
    if estimates.len() < 2 {
        return None;
    }
    let mut sorted = estimates.to_vec();
    sorted.sort_by(f64::total_cmp);
    let n = sorted.len() as f64;
    let mean = sorted.iter().sum::<f64>() / n;
    let square: f64 = sorted.iter().map(|v| (v - mean).powi(2)).sum();
    let tail = 0.5 * (1.0 - COVERAGE);
    let (low, high) = (quantile(&sorted, tail), quantile(&sorted, 1.0 - tail));
    Some(Scatter {
        std_error: (square / (n - 1.0)).sqrt(),
        bias: quantile(&sorted, 0.5) - value,
        percentile: (low, high),
        basic: (2.0 * value - high, 2.0 * value - low),
    })
}

#[cfg(test)]
mod tests {
    #![expect(clippy::unwrap_used, reason = "a failed step is a failed test")]
    use super::*;

    #[test]
    fn quantiles_are_order_statistics() {
        // of 1 to 39 the 2.5 % and 97.5 % quantiles are the first and the last
        let all: Vec<f64> = (1..=39).rev().map(f64::from).collect();
        let s = scatter(18.0, &all).unwrap();
        assert_eq!(s.percentile, (1.0, 39.0));
        assert_eq!(s.basic, (-3.0, 35.0));
        assert_eq!(s.bias, 2.0);
        // the variance of 1 to n is n (n + 1)/12
        assert!((s.std_error - 130_f64.sqrt()).abs() < 1e-12);
    }

    #[test]
    fn one_estimate_scatters_by_nothing_known() {
        assert_eq!(scatter(1.0, &[1.0]), None);
    }
}
