//! Mean gains E[∂f/∂x] of what is not linear, and how they change with the covariance.

use bicycle::linear::Apart;
use bicycle::{Parameters, State};
use nalgebra::DMatrix;
use std::f64::consts::{FRAC_2_PI, TAU};

pub(super) const STEER_RATE: usize = State::index("steer_rate").expect("a state");
pub(super) const STEER: usize = State::index("steer").expect("a state");
pub(super) const YAW_RATE: usize = State::index("yaw_rate").expect("a state");

/// Mean gain √(2/π)/σ of a sign under a deviation `sigma`.
pub fn sign_gain(sigma: f64) -> f64 {
    FRAC_2_PI.sqrt() / sigma
}

/// σ² in the mean gain of a sign smoothed over `width`: exact for σ → 0 and σ → ∞.
fn spread(variance: f64, width: f64) -> f64 {
    variance + FRAC_2_PI * width * width
}

/// E[1/(1 + s² z²)] for standard normal z, the mean gain of an arctangent, and its derivative over
/// s². The trapezoidal rule converges geometrically here; 1e-12 up to s = 1.
fn arctangent_gain(square: f64) -> (f64, f64) {
    let h = 0.2;
    let term = |k: i32| {
        let z2 = (h * f64::from(k)).powi(2);
        let gain = 1.0 / (1.0 + square * z2);
        // the integrand is even
        let weight = if k == 0 { 0.5 } else { 1.0 } * (-0.5 * z2).exp();
        (weight * gain, -weight * z2 * gain * gain)
    };
    let (gain, slope) = (0..=40)
        .map(term)
        .fold((0.0, 0.0), |sum, t| (sum.0 + t.0, sum.1 + t.1));
    let scale = 2.0 * h / TAU.sqrt();
    (scale * gain, scale * slope)
}

/// A bicycle upright at a speed, its nonlinear terms apart.
#[derive(Debug, Clone)]
pub(crate) struct Gains {
    pub parts: Apart,
    pub parameters: Parameters,
    /// [m/s].
    pub speed: f64,
}

impl Gains {
    /// The state matrix with the mean gains of a covariance `p`.
    pub fn state(&self, p: &DMatrix<f64>) -> DMatrix<f64> {
        let (parts, b) = (&self.parts, &self.parameters);
        let mut a = parts.state.clone();
        let steer_rate = spread(p[(STEER_RATE, STEER_RATE)], b.steer_rate_smoothing);
        let friction = sign_gain(steer_rate.sqrt());
        let mut column = a.column_mut(STEER_RATE);
        column.axpy(friction, &parts.steer_rate_sign, 1.0);

        // what follows is of the paper's formulations; the four-body bicycle is linear
        if parts.steer_sign.is_empty() {
            return a;
        }
        let slope = b.wheelbase / self.speed;
        let (path, _) = arctangent_gain(slope * slope * p[(YAW_RATE, YAW_RATE)]);
        let mut column = a.column_mut(YAW_RATE);
        column.axpy(slope * path, &parts.path_angle, 1.0);

        // f_i = sign θ · ½ xᵀ H x:  E[∂f_i/∂x] = E[sign θ H x] + E[2 δ(θ) ½ xᵀ H x] e_θ
        let square = spread(p[(STEER, STEER)], b.steer_smoothing);
        let sigma = square.sqrt();
        let with_steer = p.column(STEER);
        for (i, h) in self.bent() {
            let slope = h * with_steer;
            let given_steer = h.dot(p) - slope.dot(&with_steer) / square;
            let mut row = a.row_mut(i);
            row += slope.transpose() * sign_gain(sigma);
            row[STEER] += given_steer / (TAU.sqrt() * sigma);
        }
        a
    }

    /// The change of [`Self::state`] at `p` with a change `dp` of it.
    pub fn change(&self, p: &DMatrix<f64>, dp: &DMatrix<f64>) -> DMatrix<f64> {
        let (parts, b) = (&self.parts, &self.parameters);
        let mut da = DMatrix::zeros(p.nrows(), p.nrows());
        // g = √(2/π)/σ:  dg = −½ g dσ²/σ²
        let steer_rate = spread(p[(STEER_RATE, STEER_RATE)], b.steer_rate_smoothing);
        let less = 0.5 * dp[(STEER_RATE, STEER_RATE)] / steer_rate;
        let mut column = da.column_mut(STEER_RATE);
        column.axpy(
            -less * sign_gain(steer_rate.sqrt()),
            &parts.steer_rate_sign,
            1.0,
        );

        if parts.steer_sign.is_empty() {
            return da;
        }
        let slope = b.wheelbase / self.speed;
        let (_, bend) = arctangent_gain(slope * slope * p[(YAW_RATE, YAW_RATE)]);
        let mut column = da.column_mut(YAW_RATE);
        column.axpy(
            slope.powi(3) * bend * dp[(YAW_RATE, YAW_RATE)],
            &parts.path_angle,
            1.0,
        );

        let square = spread(p[(STEER, STEER)], b.steer_smoothing);
        let (sigma, less) = (square.sqrt(), 0.5 * dp[(STEER, STEER)] / square);
        let (with_steer, moved) = (p.column(STEER), dp.column(STEER));
        for (i, h) in self.bent() {
            let (slope, dslope) = (h * with_steer, h * moved);
            let along = slope.dot(&with_steer) / square;
            let given_steer = h.dot(p) - along;
            // both factors of wᵀ H w change alike: H is symmetric
            let dgiven = h.dot(dp) - 2.0 * slope.dot(&moved) / square + 2.0 * less * along;
            let mut row = da.row_mut(i);
            row += (dslope - slope * less).transpose() * sign_gain(sigma);
            row[STEER] += (dgiven - less * given_steer) / (TAU.sqrt() * sigma);
        }
        da
    }

    /// The rows that hold a product with sign θ, each with its Hessian.
    fn bent(&self) -> impl Iterator<Item = (usize, &DMatrix<f64>)> {
        let all = self.parts.steer_sign.iter().enumerate();
        all.filter(|(_, h)| h.iter().any(|v| *v != 0.0))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use bicycle::{Formulation, linear};

    #[test]
    fn the_arctangents_gain_is_the_gaussian_mean() {
        assert!((arctangent_gain(0.0).0 - 1.0).abs() < 1e-12);
        // √(π/2)/s e^{1/2s²} erfc(1/(√2 s)) at s = 1 and ½, by 30-digit arithmetic
        assert!((arctangent_gain(1.0).0 - 0.655_679_542_418_798_6).abs() < 1e-11);
        assert!((arctangent_gain(0.25).0 - 0.842_738_458_576_109_3).abs() < 1e-11);
    }

    /// A difference over 1e-5 of the covariance is good to 1e-9.
    #[test]
    fn the_gains_change_as_their_differences_say() {
        for formulation in [Formulation::Repaired, Formulation::WhippleSlip] {
            let parameters = Parameters::default();
            let gains = Gains {
                parts: linear::apart(&parameters, formulation, 2.2),
                parameters,
                speed: 2.2,
            };
            let n = gains.parts.state.nrows();
            let p = DMatrix::from_fn(n, n, |i, j| {
                1e-2 / (1.0 + (i as f64 - j as f64).powi(2)) + 1e-3 * (i * j) as f64
            });
            let dp = DMatrix::from_fn(n, n, |i, j| 1e-2 * ((i + j) as f64).cos());
            let h = 1e-5;
            let difference =
                (gains.state(&(&p + &dp * h)) - gains.state(&(&p - &dp * h))) / (2.0 * h);
            let change = gains.change(&p, &dp);
            assert!(change.norm() > 1e-3, "{formulation:?}");
            for (j, (c, d)) in change
                .column_iter()
                .zip(difference.column_iter())
                .enumerate()
            {
                let size = d.norm().max(1e-6 * difference.norm());
                assert!((c - d).norm() < 1e-7 * size, "{formulation:?}, column {j}");
            }
        }
    }
}
