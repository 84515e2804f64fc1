//! Quantiles of the distributions that intervals and tests are made of.

use statrs::distribution::{ChiSquared, ContinuousCDF, Gamma, Normal, StudentsT};

/// Probability with which an interval is to hold the truth.
pub const COVERAGE: f64 = 0.95;

/// The x with P(X ≤ x) = `p` of a gamma variable of shape `a` and scale 1, 0 < p < 1: what
/// Σ |Y_k|²/S_k of `a` complex coefficients is.
pub(crate) fn gamma_quantile(a: f64, p: f64) -> f64 {
    Gamma::new(a, 1.0).expect("a positive shape").inverse_cdf(p)
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
        for (freedom, t) in [(1.0, 12.706), (3.0, 3.182), (10.0, 2.228), (120.0, 1.980)] {
            assert!(
                (student_half_width(freedom, 0.95) - t).abs() < 5e-4,
                "t({freedom})"
            );
        }
    }
}
