//! Landscapes to search in tests.
#![expect(clippy::unwrap_used, reason = "a failed step is a failed test")]

use super::*;
use nalgebra::DMatrix;

/// Least squares of a residual, its slope by central differences over a 1e-6th of each variable.
pub(super) struct Least<F = fn(&[f64]) -> Vec<f64>>(pub F);

impl<F: Fn(&[f64]) -> Vec<f64> + Sync> Landscape for Least<F> {
    fn cost(&self, z: &DVector<f64>) -> f64 {
        0.5 * (self.0)(z.as_slice()).iter().map(|r| r * r).sum::<f64>()
    }

    fn quadratic(&self, z: &DVector<f64>) -> Result<Quadratic> {
        let residual = DVector::from_vec((self.0)(z.as_slice()));
        let mut jacobian = DMatrix::zeros(residual.len(), z.len());
        for j in 0..z.len() {
            let h = if z[j] == 0.0 { 1e-9 } else { 1e-6 * z[j].abs() };
            let at = |h: f64| {
                let mut z = z.clone();
                z[j] += h;
                DVector::from_vec((self.0)(z.as_slice()))
            };
            jacobian.set_column(j, &((at(h) - at(-h)) / (2.0 * h)));
        }
        Ok(Quadratic {
            gradient: jacobian.transpose() * &residual,
            curvature: jacobian.transpose() * jacobian,
            blocks: Vec::new(),
        })
    }
}

/// A box whose reach is as long as it is wide.
pub(super) fn box_of(lower: &[f64], upper: &[f64]) -> Limits {
    let (lower, upper) = (
        DVector::from_column_slice(lower),
        DVector::from_column_slice(upper),
    );
    Limits {
        reach: &upper - &lower,
        lower,
        upper,
    }
}

#[test]
fn the_costs_of_many_are_those_of_each_in_order() {
    /// √x, which a negative number is |x| away from having.
    struct Root;
    impl Landscape for Root {
        fn cost(&self, z: &DVector<f64>) -> f64 {
            z[0].sqrt()
        }
        fn quadratic(&self, _: &DVector<f64>) -> Result<Quadratic> {
            unreachable!("only costs are asked for")
        }
        fn excess(&self, z: &DVector<f64>) -> f64 {
            -z[0]
        }
    }
    let points: Vec<_> = [4.0, -2.0, 9.0, -1.0]
        .map(|x| DVector::from_element(1, x))
        .into();
    let costs = Root.costs(&points);
    assert_eq!((costs[0].value(), costs[2].value()), (2.0, 3.0));
    assert!(costs[1].failed() && costs[3].failed() && costs[3] < costs[1]);
    assert!(costs[2] < costs[3]);
}

#[test]
fn an_outcome_is_the_same_in_a_file() {
    let outcome = Outcome {
        point: DVector::from_column_slice(&[0.1 + 0.2, -0.0]),
        cost: 1.0 / 3.0,
        termination: "converged".into(),
        converged: true,
        stopped: false,
        iterations: 1,
        cost_evaluations: 2,
        curvature_evaluations: 3,
        failures: 4,
    };
    let text = serde_json::to_string(&outcome).unwrap();
    assert!(
        text.starts_with(r#"{"point":[0.30000000000000004,-0.0],"#),
        "{text}"
    );
    assert_eq!(serde_json::from_str::<Outcome>(&text).unwrap(), outcome);
}
