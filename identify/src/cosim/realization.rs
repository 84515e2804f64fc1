//! A linear system from its free motions: the eigensystem realization algorithm (Juang & Pappa
//! 1985, *J. Guidance* 8(5) 620–627).

use bicycle::linear;
use nalgebra::{Complex, DMatrix};

/// Singular values below a share of the largest are round-off and what is not linear; where that
/// begins differs from system to system, so several shares are tried.
const RANKS: [f64; 4] = [1e-6, 1e-7, 1e-8, 1e-9];
/// A free motion of a system found differs from what was seen by no more than this share of it, or
/// it is no system found.
const RESIDUAL: f64 = 1e-5;
/// Samples that are enough.
const FEWEST: usize = 6;
/// Discrete eigenvalues below this belong to delays and to what dies within a sample or two.
pub const GONE: f64 = 0.02;

/// Eigenvalues z of x⁺ = A x from its free motions: for each of them, for each output, the samples.
/// An error says why they tell none.
pub fn eigenvalues(motions: &[Vec<Vec<f64>>]) -> Result<Vec<Complex<f64>>, String> {
    let outputs = motions[0].len();
    let samples = motions.iter().flatten().map(Vec::len).min().unwrap_or(0);
    let size = |output: usize| {
        let all = motions.iter().flat_map(|motion| &motion[output]);
        all.fold(0.0, |largest: f64, y| largest.max(y.abs()))
    };
    let sizes: Vec<f64> = (0..outputs).map(size).collect();
    if sizes.iter().any(|size| !size.is_finite()) {
        return Err("the answer to a small pulse is not finite".to_owned());
    }
    let y = |k: usize, output: usize, motion: usize| match sizes[output] {
        0.0 => 0.0,
        size => motions[motion][output][k] / size,
    };
    if samples < FEWEST {
        return Err(format!(
            "{samples} samples of the answer to a pulse are too few"
        ));
    }
    // H_ij = Y(i + j), as many rows as columns of samples
    let half = (samples - 1) / 2;
    let hankel = |shift: usize| {
        DMatrix::from_fn(half * outputs, half * motions.len(), |r, c| {
            y(
                r / outputs + c / motions.len() + shift,
                r % outputs,
                c % motions.len(),
            )
        })
    };
    let svd = hankel(0).svd(true, true);
    let (Some(u), Some(v_t)) = (svd.u, svd.v_t) else {
        return Err("the answers to pulses have no singular values".to_owned());
    };
    let s = svd.singular_values;
    let shifted = hankel(1);
    // the system of an order, and by how much its free motions miss those seen
    let realize = |order: usize| {
        let root =
            |power: f64| DMatrix::from_diagonal(&s.rows(0, order).map(|value| value.powf(power)));
        let left = u.columns(0, order) * root(-0.5);
        let right = v_t.rows(0, order).transpose() * root(-0.5);
        let a = left.transpose() * &shifted * right;
        let c = u.rows(0, outputs).columns(0, order) * root(0.5);
        let mut state = root(0.5) * v_t.columns(0, motions.len()).rows(0, order);
        let mut worst = 0.0_f64;
        for k in 0..samples {
            let found = &c * &state;
            for motion in 0..motions.len() {
                for output in 0..outputs {
                    let missed = (found[(output, motion)] - y(k, output, motion)).abs();
                    // a NaN stays
                    worst = if missed > worst || missed.is_nan() {
                        missed
                    } else {
                        worst
                    };
                }
            }
            state = &a * state;
        }
        (linear::eigenvalues(&a), worst)
    };
    let mut orders = RANKS
        .map(|rank| s.iter().filter(|v| **v > rank * s.max()).count())
        .to_vec();
    orders.dedup();
    if orders == [0] {
        return Err("the system does not answer to pulses".to_owned());
    }
    let mut found: Vec<_> = orders
        .into_iter()
        .filter(|order| *order > 0)
        .map(realize)
        .collect();
    found.sort_by(|a, b| a.1.total_cmp(&b.1));
    let (values, worst) = found.swap_remove(0);
    if worst.is_nan() || worst > RESIDUAL {
        let far = if worst < 1.0 {
            format!("off by {:.1} %", 100.0 * worst)
        } else {
            "far off".to_owned()
        };
        return Err(format!(
            "the answers to small pulses are not those of a linear system: the nearest is {far}"
        ));
    }
    Ok(values)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_eigenvalues_of_a_known_system_come_back() {
        // poles of a bicycle with a motor: a slow real one, a swing, a fast one, a delay
        let z = [
            Complex::new(0.995, 0.0),
            Complex::from_polar(0.99, 0.04),
            Complex::new(0.55, 0.0),
            Complex::new(0.0, 0.0),
        ];
        let motion = |weights: [f64; 4]| -> Vec<Vec<f64>> {
            let output = |shift: f64| {
                let sample = |k: i32| {
                    let terms = z.iter().zip(weights).enumerate();
                    let term = |(n, (z, w)): (usize, (&Complex<f64>, f64))| {
                        (z.powi(k) * Complex::from_polar(w, shift * n as f64)).re
                    };
                    terms.map(term).sum::<f64>()
                };
                (0..200).map(sample).collect()
            };
            vec![output(0.3), output(1.1), output(0.7)]
        };
        let motions = [motion([1.0, 2.0, 0.5, 0.1]), motion([0.2, -1.0, 1.0, -0.3])];
        let mut found = eigenvalues(&motions).expect("found");
        found.retain(|z| z.norm() > GONE && z.im >= 0.0);
        found.sort_by(|a, b| b.norm().total_cmp(&a.norm()));
        assert_eq!(found.len(), 3, "{found:?}");
        for (found, z) in found.iter().zip(z) {
            assert!((found - z).norm() < 1e-9, "{found} for {z}");
        }
    }

    #[test]
    fn what_is_not_linear_is_told_and_silence_too() {
        let square = |n: usize| {
            f64::from(u8::from((n / 7).is_multiple_of(2))) - 0.3 * (n as f64 * n as f64).sin()
        };
        let noise: Vec<f64> = (0..60).map(square).collect();
        let reason = eigenvalues(&[vec![noise]]).expect_err("not linear");
        assert!(reason.contains("not those of a linear system"), "{reason}");
        let reason = eigenvalues(&[vec![vec![0.0; 40]]]).expect_err("silent");
        assert!(reason.contains("does not answer"), "{reason}");
    }
}
