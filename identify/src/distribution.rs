//! Quantiles of the distributions that intervals and tests are made of.

use statrs::distribution::{ChiSquared, ContinuousCDF, FisherSnedecor, Gamma, Normal, StudentsT};
use std::f64::consts::PI;

/// Probability with which an interval is to hold the truth.
pub const COVERAGE: f64 = 0.95;

/// The x with P(X ≤ x) = `p` of a gamma variable of shape `a` and scale 1, 0 < p < 1: what
/// Σ |Y_k|²/S_k of `a` complex coefficients is.
pub(crate) fn gamma_quantile(a: f64, p: f64) -> f64 {
    Gamma::new(a, 1.0).expect("a positive shape").inverse_cdf(p)
}

/// The x with P(X ≤ x) = `p` of F with `numerator` and `denominator` degrees of freedom: a ratio of
/// two mean powers of noise.
pub(crate) fn f_quantile(numerator: f64, denominator: f64, p: f64) -> f64 {
    let fisher = FisherSnedecor::new(numerator, denominator).expect("positive freedom");
    fisher.inverse_cdf(p)
}

/// ψ'(n): the variance of the logarithm of a gamma variable of shape `n` ≥ 1.
pub(crate) fn trigamma(n: usize) -> f64 {
    // Abramowitz & Stegun 1964, 6.4.3; from where the sum would lose digits, 6.4.12
    if n < 100 {
        let sum: f64 = (1..n).map(|k| (k as f64).powi(-2)).sum();
        return PI * PI / 6.0 - sum;
    }
    let x = 1.0 / n as f64;
    x + x * x / 2.0 + x.powi(3) / 6.0 - x.powi(5) / 30.0
}

/// P(X > x) of χ² with `freedom` degrees.
pub(crate) fn chi_square_tail(freedom: f64, x: f64) -> f64 {
    ChiSquared::new(freedom).expect("positive freedom").sf(x)
}

/// Half width of the interval about 0 that holds a standard normal variable with `probability`.
pub(crate) fn normal_half_width(probability: f64) -> f64 {
    Normal::standard().inverse_cdf(0.5 * (1.0 + probability))
}

/// The same of Student's t with `freedom` degrees.
pub(crate) fn student_half_width(freedom: f64, probability: f64) -> f64 {
    let student = StudentsT::new(0.0, 1.0, freedom).expect("positive freedom");
    student.inverse_cdf(0.5 * (1.0 + probability))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn quantiles_are_those_of_the_tables() {
        // Abramowitz & Stegun 1964, tables 26.1, 26.8 and 26.10
        for (freedom, p, x) in [
            (1.0, 0.95, 3.841459),
            (1.0, 0.99, 6.634897),
            (2.0, 0.95, 5.991465),
            (10.0, 0.01, 2.558212),
            (30.0, 0.99, 50.892181),
            (100.0, 0.975, 129.561197),
        ] {
            assert!(
                (2.0 * gamma_quantile(0.5 * freedom, p) - x).abs() < 1e-6,
                "χ²({freedom}), {p}"
            );
            assert!((chi_square_tail(freedom, x) - (1.0 - p)).abs() < 1e-6);
        }
        assert!((normal_half_width(0.95) - 1.959963985).abs() < 1e-9);
        assert!((normal_half_width(0.99) - 2.575829304).abs() < 1e-9);
        // table 26.9
        for (numerator, denominator, x) in
            [(2.0, 2.0, 39.0), (10.0, 10.0, 3.717), (4.0, 60.0, 3.008)]
        {
            let found = f_quantile(numerator, denominator, 0.975);
            assert!(
                (found - x).abs() < 5e-4,
                "F({numerator}, {denominator}): {found}"
            );
            let low = f_quantile(denominator, numerator, 0.025);
            assert!((low * found - 1.0).abs() < 1e-6, "{low}");
        }
        // table 6.1
        for (n, value) in [(1, 1.6449340668), (2, 0.6449340668)] {
            assert!((trigamma(n) - value).abs() < 1e-10);
        }
        // both ways agree, and to the recurrence ψ'(n + 1) = ψ'(n) − 1/n²
        assert!((trigamma(99) - trigamma(100) - 99_f64.powi(-2)).abs() < 1e-12);
        for (freedom, t) in [(1.0, 12.706), (3.0, 3.182), (10.0, 2.228), (120.0, 1.980)] {
            assert!(
                (student_half_width(freedom, 0.95) - t).abs() < 5e-4,
                "t({freedom})"
            );
        }
    }
}
