//! How far each number can be trusted: standard errors, correlations and a verdict in a word.

use crate::free::Variable;
use crate::objective::Information;
use crate::ride::base;
use nalgebra::{DMatrix, DVector, SymmetricEigen};
use serde::{Deserialize, Serialize};

/// The verdict on a parameter.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub enum Verdict {
    /// Standard error below .3 of what the literature leaves open.
    #[serde(rename = "determined")]
    Determined,
    /// Standard error .3 to .7 of that.
    #[serde(rename = "weak")]
    Weak,
    /// More than .7 of that, at a bound, or part of a direction the data do not see at all.
    #[serde(rename = "not determined")]
    NotDetermined,
    /// Estimated for the others' sake.
    #[serde(rename = "nuisance")]
    Nuisance,
}

impl Verdict {
    /// The word.
    pub fn name(self) -> &'static str {
        match self {
            Self::Determined => "determined",
            Self::Weak => "weak",
            Self::NotDetermined => "not determined",
            Self::Nuisance => "nuisance",
        }
    }
}

/// One row of a fit.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Estimate {
    /// Name of the row.
    pub name: String,
    /// The condition or the ride it is of; none: of all.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub of: Option<String>,
    /// SI unit.
    pub unit: String,
    /// Estimate [SI].
    pub value: f64,
    /// Standard error [SI]; none where the data leave it infinite or the value is at a bound.
    pub std_error: Option<f64>,
    /// 95 % interval [SI], within the bounds; of the remnant's intensity symmetric in its
    /// logarithm.
    pub interval: Option<(f64, f64)>,
    /// Lower bound of the search [SI].
    pub lower: f64,
    /// Upper bound of the search [SI].
    pub upper: f64,
    /// Whether the estimate is at one of them.
    pub at_bound: bool,
    /// The verdict.
    pub verdict: Verdict,
    /// Parameters whose change the data cannot tell from a change of this one.
    pub trades_against: Vec<String>,
}

impl Estimate {
    /// Its name, and of which ride or condition it is where it is not of all.
    pub fn label(&self) -> String {
        let of = self.of.as_deref().map(base);
        of.map_or_else(|| self.name.clone(), |of| format!("{} of {of}", self.name))
    }

    /// The verdict as a sentence has it, and which parameters a change of this one can hide in.
    pub fn words(&self) -> String {
        let verdict = match self.verdict {
            _ if self.at_bound => "at its bound",
            Verdict::Determined => "determined",
            Verdict::Weak => "weakly determined",
            Verdict::NotDetermined => "not determined by this data",
            Verdict::Nuisance => "a nuisance, estimated for the others' sake",
        };
        if self.trades_against.is_empty() {
            verdict.into()
        } else {
            format!(
                "{verdict}; trades against {}",
                self.trades_against.join(", ")
            )
        }
    }
}

/// Relative singular value below which the data do not see a direction.
const SINGULAR: f64 = 1e-6;
/// Part in such a direction from which a parameter belongs to it.
const PART: f64 = 1e-3;
/// Correlation from which two weakly determined parameters trade against each other.
const CORRELATED: f64 = 0.9;

/// Covariance of the variables, and of each variable which others share a singular direction
/// with it (none: it is regular).
pub(crate) struct Spread {
    pub(crate) covariance: DMatrix<f64>,
    pub(crate) singular: Vec<Option<Vec<usize>>>,
}

/// What `information` leaves open; a direction that the data do not see adds nothing.
pub(crate) fn spread(information: &Information) -> Spread {
    let a = &information.curvature;
    let n = a.nrows();
    if n == 0 {
        return Spread {
            covariance: DMatrix::zeros(0, 0),
            singular: Vec::new(),
        };
    }
    let scale = DVector::from_fn(n, |i, _| a[(i, i)].max(f64::MIN_POSITIVE).sqrt());
    let normal = DMatrix::from_fn(n, n, |i, j| a[(i, j)] / scale[i] / scale[j]);
    let eigen = SymmetricEigen::new(normal);
    let largest = eigen.eigenvalues.amax();
    let mut inverse = DMatrix::zeros(n, n);
    let mut groups: Vec<Option<Vec<usize>>> = vec![None; n];
    for (value, direction) in eigen
        .eigenvalues
        .iter()
        .zip(eigen.eigenvectors.column_iter())
    {
        if *value > SINGULAR * SINGULAR * largest {
            inverse += direction * direction.transpose() / *value;
            continue;
        }
        let members: Vec<usize> = (0..n).filter(|&i| direction[i].abs() > PART).collect();
        for &i in &members {
            let others = members.iter().copied().filter(|&j| j != i);
            groups[i].get_or_insert_default().extend(others);
        }
    }
    let inverse = DMatrix::from_fn(n, n, |i, j| inverse[(i, j)] / scale[i] / scale[j]);
    let covariance = match &information.meat {
        None => inverse * information.factor,
        Some(meat) => &inverse * meat * &inverse * information.factor,
    };
    Spread {
        covariance,
        singular: groups,
    }
}

/// Estimates at `values` [SI] from what the data know there and, where it could be computed, at
/// the nominal values; and the correlation matrix (0 in rows and columns without a standard
/// error, 1 on the diagonal).
pub fn judge(
    variables: &[Variable],
    values: &[f64],
    here: &Information,
    nominal: Option<&Information>,
) -> (Vec<Estimate>, DMatrix<f64>) {
    let n = variables.len();
    let at_bound: Vec<bool> = variables
        .iter()
        .zip(values)
        .map(|(Variable { free, .. }, &value)| free.at_bound(value))
        .collect();
    // a direction that the data do not see stays unseen where a bound happens to stop the search
    let unseen = spread(here).singular;
    // what is held at a bound is no longer estimated
    let kept: Vec<usize> = (0..n).filter(|&i| !at_bound[i]).collect();
    let at = spread(&here.of(&kept));
    let nominal = nominal.map(|information| spread(&information.of(&kept)));
    let deviation = |s: &Spread, k: usize| s.covariance[(k, k)].max(0.0).sqrt();

    let quantile = here.quantile();
    let mut correlation = DMatrix::identity(n, n);
    for (k, &i) in kept.iter().enumerate() {
        for (l, &j) in kept.iter().enumerate().filter(|(l, _)| *l != k) {
            let regular = unseen[i].is_none() && unseen[j].is_none();
            let product = deviation(&at, k) * deviation(&at, l);
            let value = if regular && product > 0.0 {
                at.covariance[(k, l)] / product
            } else {
                0.0
            };
            correlation[(i, j)] = value;
        }
    }

    let estimates = (0..n)
        .map(|i| {
            let (Variable { free: f, of }, value) = (&variables[i], values[i]);
            let k = kept.iter().position(|&j| j == i);
            let in_search = k.filter(|_| unseen[i].is_none()).map(|k| deviation(&at, k));
            let std_error = in_search.map(|s| s * f.slope(value));
            // what the data do not see at the nominal values has an infinite error there
            let typical = k.zip(nominal.as_ref()).map_or(0.0, |(k, s)| {
                let nominal = f.row.nominal.clamp(f.lower, f.upper);
                s.singular[k]
                    .as_ref()
                    .map_or_else(|| deviation(s, k) * f.slope(nominal), |_| f64::INFINITY)
            });
            let rho = std_error.map(|s| s.max(typical) / (f.yardstick() / 12f64.sqrt()));
            let verdict = match rho {
                _ if f.nuisance() => Verdict::Nuisance,
                Some(rho) if rho < 0.3 => Verdict::Determined,
                Some(rho) if rho <= 0.7 => Verdict::Weak,
                _ => Verdict::NotDetermined,
            };
            let trades: Vec<usize> = match &unseen[i] {
                Some(group) => group.clone(),
                None if matches!(verdict, Verdict::Weak | Verdict::NotDetermined) => (0..n)
                    .filter(|&j| j != i && correlation[(i, j)].abs() > CORRELATED)
                    .collect(),
                None => Vec::new(),
            };
            let interval = in_search.map(|s| {
                let z = f.variable(value);
                let end = |sign: f64| f.value(z + sign * quantile * s).clamp(f.lower, f.upper);
                (end(-1.0), end(1.0))
            });
            Estimate {
                name: f.row.name.into(),
                of: of.clone(),
                unit: f.row.unit.symbol.into(),
                value,
                std_error,
                interval,
                lower: f.lower,
                upper: f.upper,
                at_bound: at_bound[i],
                verdict,
                trades_against: trades
                    .into_iter()
                    .map(|j| variables[j].to_string())
                    .collect(),
            }
        })
        .collect();
    (estimates, correlation)
}

#[cfg(test)]
mod tests {
    #![expect(clippy::unwrap_used, reason = "a failed step is a failed test")]
    use super::*;
    use crate::free::Free;

    fn free(names: &[&str]) -> Vec<Variable> {
        let variable = |name: &&str| Variable {
            free: Free::new(name).unwrap(),
            of: None,
        };
        names.iter().map(variable).collect()
    }

    fn information(curvature: DMatrix<f64>) -> Information {
        Information {
            curvature,
            meat: None,
            freedom: None,
            factor: 1.0,
        }
    }

    #[test]
    fn a_singular_direction_has_no_standard_error_and_names_its_members() {
        // only c/.3 + d/.15 is seen, C_θ well
        let jacobian = DMatrix::from_row_slice(2, 3, &[100.0, 0.0, 0.0, 0.0, 20.0, 20.0]);
        let a = information(jacobian.transpose() * jacobian);
        let rows = free(&[
            "cornering_stiffness",
            "viscous_friction",
            "coulomb_friction",
        ]);
        let (estimates, correlation) = judge(&rows, &[14.0, 0.3, 0.15], &a, Some(&a));
        assert_eq!(estimates[0].verdict, Verdict::Determined);
        assert!((estimates[0].std_error.unwrap() - 0.14).abs() < 1e-12);
        for (i, other) in [(1, "coulomb_friction"), (2, "viscous_friction")] {
            assert_eq!(estimates[i].verdict, Verdict::NotDetermined);
            assert_eq!(
                (estimates[i].std_error, estimates[i].interval),
                (None, None)
            );
            assert_eq!(estimates[i].trades_against, [other]);
            let words = format!("not determined by this data; trades against {other}");
            assert_eq!(estimates[i].words(), words);
        }
        assert_eq!(estimates[0].words(), "determined");
        assert_eq!(correlation[(1, 2)], 0.0);
    }

    #[test]
    fn verdicts_follow_the_standard_error_over_what_the_literature_leaves_open() {
        let rows = free(&["cornering_stiffness"]);
        // measured 8–18, so a uniform spread of 2.887; variables are C_θ/14
        for (rho, verdict) in [
            (0.29, Verdict::Determined),
            (0.31, Verdict::Weak),
            (0.69, Verdict::Weak),
            (0.71, Verdict::NotDetermined),
        ] {
            let z = rho * 10.0 / 12f64.sqrt() / 14.0;
            let a = information(DMatrix::from_element(1, 1, 1.0 / (z * z)));
            let sharp = information(DMatrix::from_element(1, 1, 1e8));
            assert_eq!(
                judge(&rows, &[14.0], &a, Some(&sharp)).0[0].verdict,
                verdict
            );
            assert_eq!(
                judge(&rows, &[14.0], &sharp, Some(&a)).0[0].verdict,
                verdict,
                "at nominal"
            );
            assert_eq!(judge(&rows, &[14.0], &a, None).0[0].verdict, verdict);
        }
    }

    #[test]
    fn at_a_bound_nothing_is_claimed() {
        let rows = free(&["cornering_stiffness", "camber_stiffness"]);
        let a = information(DMatrix::from_row_slice(2, 2, &[1e4, 5e3, 5e3, 1e4]));
        let (estimates, _) = judge(&rows, &[14.0, 0.0], &a, None);
        assert!(estimates[1].at_bound);
        assert_eq!(
            (estimates[1].std_error, estimates[1].verdict),
            (None, Verdict::NotDetermined)
        );
        assert_eq!(estimates[1].words(), "at its bound");
        // the other as if the one at its bound were known
        assert!((estimates[0].std_error.unwrap() - 0.14).abs() < 1e-12);
    }

    #[test]
    fn an_unseen_direction_stays_unseen_at_a_bound() {
        let jacobian = DMatrix::from_row_slice(1, 2, &[20.0, 20.0]);
        let a = information(jacobian.transpose() * jacobian);
        let rows = free(&["viscous_friction", "coulomb_friction"]);
        let (estimates, _) = judge(&rows, &[0.0, 0.15], &a, None);
        assert!(estimates[0].at_bound && !estimates[1].at_bound);
        for (estimate, other) in estimates
            .iter()
            .zip(["coulomb_friction", "viscous_friction"])
        {
            assert_eq!(
                (estimate.std_error, estimate.verdict),
                (None, Verdict::NotDetermined)
            );
            assert_eq!(estimate.trades_against, [other]);
        }
    }

    #[test]
    fn a_nuisance_has_a_standard_error_and_no_verdict() {
        let rows = free(&["remnant_intensity"]);
        let a = information(DMatrix::from_element(1, 1, 25.0));
        let (estimates, _) = judge(&rows, &[1.2], &a, None);
        assert_eq!(estimates[0].verdict, Verdict::Nuisance);
        assert!((estimates[0].std_error.unwrap() - 0.24).abs() < 1e-12);
        let (low, high) = estimates[0].interval.unwrap();
        assert!(
            (low * high / 1.44 - 1.0).abs() < 1e-12,
            "symmetric in the logarithm"
        );
    }
}
