//! The rule by which CIFER leaves parameters out: one whose change hardly shows (insensitivity
//! above 10 %) or that others can stand in for (Cramér–Rao bound above 20 %) is fixed and the rest
//! sought again, the worst first, until all that is left passes. Tischler & Remple 2012, *Aircraft
//! and Rotorcraft System Identification*, ch. 12.

use crate::free::{Free, Variable};
use crate::objective::Information;
use crate::verdict::spread;
use serde::{Deserialize, Serialize};

/// Largest insensitivity, relative to the value.
pub const INSENSITIVITY: f64 = 0.10;
/// Largest Cramér–Rao bound, relative to the value.
pub const CRAMER_RAO: f64 = 0.20;

/// How much the data ask for a parameter.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Sensitivity {
    /// Name of the parameter.
    pub name: String,
    /// Standard error over the value were all others known, 1/√H_ii, of windows their scatter; none where nothing changes
    /// with it or the value is 0.
    pub insensitivity: Option<f64>,
    /// Standard error over the value with all others sought, √(H⁻¹)_ii; none where it is infinite
    /// or the value is 0.
    pub cramer_rao: Option<f64>,
}

/// A parameter left out, and what spoke against it.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Dropped {
    /// What it was when it was dropped.
    #[serde(flatten)]
    pub sensitivity: Sensitivity,
    /// The value it was fixed at [SI].
    pub fixed_at: f64,
    /// Which part of the rule it broke.
    pub rule: Rule,
    /// By how much the least cost rose for it.
    pub cost_rise: f64,
}

/// What the rule leaves of a fit.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Reduction {
    /// The parameters that were kept.
    pub kept: Vec<Sensitivity>,
    /// Their values [SI], sought anew.
    pub values: Vec<f64>,
    /// The parameters that were left out, in their order.
    pub dropped: Vec<Dropped>,
    /// The least cost that is left.
    pub cost: f64,
}

/// The two parts of the rule.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Rule {
    /// Insensitivity above [`INSENSITIVITY`].
    Insensitivity,
    /// Cramér–Rao bound above [`CRAMER_RAO`].
    CramerRao,
    /// Where the search ended it was at a bound, which is no estimate.
    Bound,
}

/// Sensitivities of the free parameters at `values` [SI] from what the data know there. `caution`
/// multiplies the Cramér–Rao bound: 2 for residuals that are coloured and errors that do not know
/// it, as Tischler & Remple advise; 1 where the errors come from the scatter between windows or the
/// bins' own covariance.
pub fn sensitivities(
    variables: &[Variable],
    values: &[f64],
    information: &Information,
    caution: f64,
) -> Vec<Sensitivity> {
    let together = spread(information);
    let relative = |f: &Free, value: f64, deviation: f64| {
        let ratio = deviation * (f.slope(value) / value).abs();
        ratio.is_finite().then_some(ratio)
    };
    variables
        .iter()
        .zip(values)
        .enumerate()
        .map(|(i, (variable, &value))| {
            let f = &variable.free;
            let alone = spread(&information.of(&[i]));
            let deviation = |variance: f64| variance.max(0.0).sqrt();
            Sensitivity {
                name: variable.to_string(),
                insensitivity: (information.curvature[(i, i)] > 0.0)
                    .then(|| relative(f, value, deviation(alone.covariance[(0, 0)])))
                    .flatten(),
                cramer_rao: together.singular[i]
                    .is_none()
                    .then(|| relative(f, value, caution * deviation(together.covariance[(i, i)])))
                    .flatten(),
            }
        })
        .collect()
}

/// The parameter to leave out next, by its place in `sensitivities`, among those that `may` go:
/// the least sensitive, and only if all are sensitive the one with the largest bound.
pub fn worst(sensitivities: &[Sensitivity], may: impl Fn(usize) -> bool) -> Option<(usize, Rule)> {
    let beyond = |part: fn(&Sensitivity) -> Option<f64>, limit: f64| {
        let size = |i: &usize| part(&sensitivities[*i]).unwrap_or(f64::INFINITY);
        (0..sensitivities.len())
            .filter(|i| may(*i) && size(i) > limit)
            .max_by(|i, j| size(i).total_cmp(&size(j)))
    };
    beyond(|s| s.insensitivity, INSENSITIVITY)
        .map(|i| (i, Rule::Insensitivity))
        .or_else(|| beyond(|s| s.cramer_rao, CRAMER_RAO).map(|i| (i, Rule::CramerRao)))
}

#[cfg(test)]
mod tests {
    #![expect(clippy::unwrap_used, reason = "a failed step is a failed test")]
    use super::*;
    use nalgebra::DMatrix;

    fn rows(names: &[&str]) -> Vec<Variable> {
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
    fn alone_and_together_are_diagonal_and_inverse() {
        let rows = rows(&["cornering_stiffness", "camber_stiffness"]);
        // unit variables are 14 and .8; values half and twice that
        let h = DMatrix::from_row_slice(2, 2, &[400.0, 180.0, 180.0, 100.0]);
        let s = sensitivities(&rows, &[7.0, 1.6], &information(h), 2.0);
        assert!((s[0].insensitivity.unwrap() - 2.0 / 20.0).abs() < 1e-12);
        assert!((s[1].insensitivity.unwrap() - 0.5 / 10.0).abs() < 1e-12);
        // (H⁻¹)_00 = 100/(400·100 − 180²) = 1/76
        assert!((s[0].cramer_rao.unwrap() - 2.0 * 2.0 / 76_f64.sqrt()).abs() < 1e-12);
        assert!((s[1].cramer_rao.unwrap() - 2.0 * 0.5 * (4.0 / 76_f64).sqrt()).abs() < 1e-12);
    }

    #[test]
    fn the_insensitive_go_first_and_the_worst_of_them_before() {
        let of = |insensitivity, cramer_rao| Sensitivity {
            name: String::new(),
            insensitivity,
            cramer_rao,
        };
        let all = [
            of(Some(0.01), Some(0.9)),
            of(Some(0.2), Some(0.3)),
            of(Some(0.3), Some(0.4)),
            of(Some(0.02), Some(0.1)),
        ];
        assert_eq!(worst(&all, |_| true), Some((2, Rule::Insensitivity)));
        assert_eq!(worst(&all, |i| i != 2), Some((1, Rule::Insensitivity)));
        assert_eq!(
            worst(&all, |i| i != 1 && i != 2),
            Some((0, Rule::CramerRao))
        );
        assert_eq!(worst(&all[3..], |_| true), None);
        // what does not show at all is worse than anything that does
        assert_eq!(
            worst(&[of(Some(5.0), None), of(None, None)], |_| true),
            Some((1, Rule::Insensitivity))
        );
    }

    #[test]
    fn a_singular_pair_has_no_bound_but_each_alone_would_show() {
        let jacobian = DMatrix::from_row_slice(1, 2, &[20.0, 20.0]);
        let h = information(jacobian.transpose() * jacobian);
        let rows = rows(&["viscous_friction", "coulomb_friction"]);
        let s = sensitivities(&rows, &[0.3, 0.15], &h, 1.0);
        assert!((s[0].insensitivity.unwrap() - 0.05).abs() < 1e-12);
        assert_eq!(s[0].cramer_rao, None);
        assert_eq!(worst(&s, |_| true).unwrap().1, Rule::CramerRao);
    }
}
