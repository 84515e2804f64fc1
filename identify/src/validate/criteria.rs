//! Which of several models the data prefer: −log L and a price for each parameter.
//!
//! Where neighbouring bins or residuals of one window belong together, −log L is that of a composite
//! likelihood, and a parameter costs more than one: p = tr(V H), with V the covariance that the fit
//! reports and H the curvature of −log L. For independent observations of a true model that is the
//! number of parameters. Takeuchi 1976; Varin & Vidoni 2005; Gao & Song 2010.
//!
//! Replayed windows have a free start each, whose rows are parameters too, incidental ones (Neyman &
//! Scott 1948): they take up as many of the observations as they are, so that formulations of
//! different order do not compare without them. Their number grows with the windows, but Akaike's
//! price stays one each: with the noise known, ½ E‖r‖² of a least-squares fit is short of that of new
//! data on the same starts by the trace of the hat matrix, exactly and whatever the size of the sample
//! (Mallows 1973; for parameters of clusters Vaida & Blanchard 2005, the conditional criterion).
//! Schwarz's price of a parameter is the logarithm of the number of observations that inform *it*: of
//! a start the observations of its window, ln n_w, not the windows (Pauler 1998; Delattre, Lavielle &
//! Poursat 2014).

use crate::objective::Information;
use crate::verdict::spread;
use serde::{Deserialize, Serialize};

/// A model's criteria; a difference between models of the same data means something, a value alone
/// nothing.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Criteria {
    /// −log L, less a constant of the data.
    pub minus_log_likelihood: f64,
    /// Parameters as they count, those of the windows' starts not among them.
    pub parameters: f64,
    /// Parameters of the windows' starts.
    pub starts: usize,
    /// Size of the sample, independent observations of the parameters.
    pub sample: f64,
    /// What these are.
    pub sample_of: String,
    /// Akaike's criterion, 2 (−log L + p + starts).
    pub aic: f64,
    /// Schwarz's criterion, 2 (−log L) + p ln n + Σ ln n_w over the starts' parameters.
    pub bic: f64,
}

/// The free start of a window.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Start {
    /// Its parameters: those that the window's observations see.
    pub parameters: usize,
    /// Observations of the window.
    pub observations: usize,
}

impl Criteria {
    /// From −log L, what the data know of the parameters there, a sample of size `sample`, and the
    /// windows' starts.
    pub fn new(
        minus_log_likelihood: f64,
        information: &Information,
        (sample, sample_of): (f64, &str),
        starts: &[Start],
    ) -> Self {
        let p = (spread(information).covariance * &information.curvature).trace();
        let incidental: usize = starts.iter().map(|start| start.parameters).sum();
        let informed = |start: &Start| start.parameters as f64 * (start.observations as f64).ln();
        Self {
            minus_log_likelihood,
            parameters: p,
            starts: incidental,
            sample,
            sample_of: sample_of.into(),
            aic: 2.0 * (minus_log_likelihood + p + incidental as f64),
            bic: 2.0 * minus_log_likelihood
                + p * sample.ln()
                + starts.iter().map(informed).sum::<f64>(),
        }
    }
}

#[cfg(test)]
mod tests {
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
        let new = |information, sample| Criteria::new(100.0, &information, (sample, "bins"), &[]);
        let plain = new(of(None, 1.0), 50.0);
        assert!((plain.parameters - 2.0).abs() < 1e-12);
        assert!((plain.aic - 204.0).abs() < 1e-9);
        assert!((plain.bic - (200.0 + 2.0 * 50_f64.ln())).abs() < 1e-9);
        let tapered = new(of(None, 35.0 / 18.0), 50.0);
        assert!((tapered.parameters - 35.0 / 9.0).abs() < 1e-12);
        let clustered = new(of(Some(&h * 9.0), 1.0), 15.0);
        assert!((clustered.parameters - 18.0).abs() < 1e-9);
    }

    #[test]
    fn starts_are_parameters_that_their_own_windows_inform() {
        let information = Information {
            curvature: DMatrix::identity(1, 1),
            meat: None,
            freedom: None,
            factor: 1.0,
        };
        let start = |parameters, observations| Start {
            parameters,
            observations,
        };
        let starts = [start(4, 300), start(5, 150)];
        let criteria = Criteria::new(0.0, &information, (2.0, "windows"), &starts);
        assert_eq!(criteria.starts, 9);
        assert!((criteria.aic - 20.0).abs() < 1e-12);
        let bic = 2_f64.ln() + 4.0 * 300_f64.ln() + 5.0 * 150_f64.ln();
        assert!((criteria.bic - bic).abs() < 1e-12);
    }
}
