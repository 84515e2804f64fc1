//! Which of several models the data prefer: −log L and a price for each parameter.
//!
//! Where neighbouring bins or residuals of one window belong together, −log L is that of a composite
//! likelihood, and a parameter costs more than one: p = tr(V H), with V the covariance that the fit
//! reports and H the curvature of −log L. For independent observations of a true model that is the
//! number of parameters. Takeuchi 1976; Varin & Vidoni 2005; Gao & Song 2010.

use crate::objective::Information;
use crate::verdict::spread;
use serde::{Deserialize, Serialize};

/// A model's criteria; a difference between models of the same data means something, a value alone
/// nothing.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Criteria {
    /// −log L, less a constant of the data.
    pub minus_log_likelihood: f64,
    /// Parameters as they count.
    pub parameters: f64,
    /// Size of the sample, independent observations.
    pub sample: f64,
    /// What these are.
    pub sample_of: String,
    /// Akaike's criterion, 2 (−log L + p).
    pub aic: f64,
    /// The same corrected for a small sample; none where it has no more than p + 1 observations.
    pub aicc: Option<f64>,
    /// Schwarz's criterion, 2 (−log L) + p ln n.
    pub bic: f64,
}

impl Criteria {
    /// From −log L, what the data know of the parameters there, and a sample of size `sample`.
    pub fn new(
        minus_log_likelihood: f64,
        information: &Information,
        sample: f64,
        sample_of: &str,
    ) -> Self {
        let p = (spread(information).covariance * &information.curvature).trace();
        let aic = 2.0 * (minus_log_likelihood + p);
        let left = sample - p - 1.0;
        Self {
            minus_log_likelihood,
            parameters: p,
            sample,
            sample_of: sample_of.into(),
            aic,
            aicc: (left > 0.0).then(|| aic + 2.0 * p * (p + 1.0) / left),
            bic: 2.0 * minus_log_likelihood + p * sample.ln(),
        }
    }
}

#[cfg(test)]
mod tests {
    #![expect(clippy::unwrap_used, reason = "a failed step is a failed test")]
    use super::*;
    use nalgebra::DMatrix;

    #[test]
    fn a_parameter_counts_as_one_and_more_where_observations_hang_together() {
        let h = DMatrix::from_row_slice(2, 2, &[5.0, 1.0, 1.0, 3.0]);
        let of = |meat: Option<DMatrix<f64>>, factor| Information {
            curvature: h.clone(),
            meat,
            freedom: None,
            factor,
        };
        let plain = Criteria::new(100.0, &of(None, 1.0), 50.0, "bins");
        assert!((plain.parameters - 2.0).abs() < 1e-12);
        assert!((plain.aic - 204.0).abs() < 1e-9);
        assert!((plain.bic - (200.0 + 2.0 * 50_f64.ln())).abs() < 1e-9);
        // 2 p (p + 1)/(n − p − 1)
        assert!((plain.aicc.unwrap() - (204.0 + 12.0 / 47.0)).abs() < 1e-9);
        let tapered = Criteria::new(100.0, &of(None, 35.0 / 18.0), 50.0, "bins");
        assert!((tapered.parameters - 35.0 / 9.0).abs() < 1e-12);
        let clustered = Criteria::new(100.0, &of(Some(&h * 9.0), 1.0), 15.0, "windows");
        assert!((clustered.parameters - 18.0).abs() < 1e-9);
        assert_eq!(clustered.aicc, None);
    }
}
