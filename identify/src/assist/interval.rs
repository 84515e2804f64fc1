//! How well rides of several seeds know the ratio of two powers.

use super::Pair;
use crate::distribution::student_half_width;

/// 95 % interval of √(Σ with / Σ without), the powers paired by seed; none of fewer than two pairs.
///
/// The jackknife of the logarithm with Student's t: Tukey 1958, *Ann. Math. Statist.* 29, 614;
/// Miller 1974, *Biometrika* 61, 1. The mean of the pairs' own log ratios with Student's t would be
/// simpler, but where one spectrum is sharper than the other, that mean is not the logarithm of the
/// ratio of the mean powers (E ln χ²_ν/ν ≈ −1/ν), and with 20 seeds its interval held the truth in
/// 90 to 92 of 100 against 94 to 95 of this one.
pub(super) fn paired(powers: &Pair<Vec<f64>>) -> Option<(f64, f64)> {
    let seeds = powers.with.len();
    if seeds < 2 {
        return None;
    }
    let sum = powers.map(|powers| powers.iter().sum::<f64>());
    let log_ratio = |all: Pair<f64>| 0.5 * (all.with / all.without).ln();
    let without_one = |(without, with): (&f64, &f64)| {
        log_ratio(Pair {
            without: sum.without - without,
            with: sum.with - with,
        })
    };
    let pairs = powers.without.iter().zip(&powers.with);
    let left: Vec<f64> = pairs.map(without_one).collect();
    let n = seeds as f64;
    let mean = left.iter().sum::<f64>() / n;
    let square: f64 = left.iter().map(|log| (log - mean).powi(2)).sum();
    let half = student_half_width(n - 1.0, 0.95) * ((n - 1.0) / n * square).sqrt();
    let centre = log_ratio(sum);
    Some(((centre - half).exp(), (centre + half).exp()))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn two_pairs_are_the_t_of_their_two_log_ratios() {
        let powers = Pair {
            without: vec![1.0, 4.0],
            with: vec![0.5, 1.0],
        };
        let (low, high) = paired(&powers).expect("two pairs");
        let logs = [0.5_f64, 0.25].map(|ratio| 0.5 * ratio.ln());
        let half = student_half_width(1.0, 0.95) * 0.5 * (logs[0] - logs[1]).abs();
        let centre = 0.5 * (1.5_f64 / 5.0).ln();
        // sums of numbers about 1: some units in the last place
        assert!((low.ln() - (centre - half)).abs() < 1e-13, "{low}");
        assert!((high.ln() - (centre + half)).abs() < 1e-13, "{high}");
    }
}
