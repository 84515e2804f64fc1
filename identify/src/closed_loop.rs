//! The model spectrum: statistical linearisation of bicycle and rider under the rider's remnant.
//!
//! Each term that is not smooth or not nearly linear is replaced by its mean gain E[∂f/∂x] under
//! N(0, P), P the stationary covariance of the loop so linearised, until both agree. (The Jacobian
//! at upright of a smoothed jump would be wrong by factors of 4 to 17.) Roberts & Spanos 2003,
//! *Random Vibration and Statistical Linearization*, ch. 5.

use crate::error::{Error, Result};
use crate::spectrum::Kernel;
use bicycle::linear::{self, Apart};
use bicycle::{Formulation, Input, Parameters, State};
use nalgebra::{Complex, DMatrix, DVector};
use std::f64::consts::{FRAC_2_PI, TAU};

/// Rows of the state.
const STEER_RATE: usize = State::index("steer_rate").expect("a state");
const STEER: usize = State::index("steer").expect("a state");
const YAW_RATE: usize = State::index("yaw_rate").expect("a state");

/// Above this steering [rad rms] the linearisation has not been checked.
pub const STEER_CHECKED: f64 = 5.0 * std::f64::consts::PI / 180.0;

/// A deterministic line as the loop sees it: its frequency and the steer amplitude it leaves.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LineMotion {
    /// Frequency [Hz].
    pub frequency: f64,
    /// Amplitude of the steer angle [rad].
    pub steer_amplitude: f64,
}

/// What drives the loop.
#[derive(Debug, Clone, PartialEq)]
pub struct Drive {
    /// Speed [m/s].
    pub speed: f64,
    /// Remnant: first-order low-pass torque noise, rms [N m].
    pub remnant_intensity: f64,
    /// Its corner [Hz].
    pub remnant_corner: f64,
    /// Deterministic lines besides.
    pub lines: Vec<LineMotion>,
}

/// Bicycle and rider, linearised about the motion the remnant makes.
#[derive(Debug, Clone)]
pub struct ClosedLoop {
    state: DMatrix<f64>,
    torque: DVector<f64>,
    /// What is seen of the rows of the state.
    seen: DMatrix<f64>,
    /// Covariance of the states that move, lines included.
    covariance: DMatrix<f64>,
    drive: Drive,
}

/// Passes of the linearisation at most.
const PASSES: usize = 60;

/// Mean gain √(2/π)/σ of a sign under a deviation `sigma`.
pub fn sign_gain(sigma: f64) -> f64 {
    FRAC_2_PI.sqrt() / sigma
}

/// The σ in the mean gain of a sign smoothed over `width`: exact for σ → 0 and σ → ∞.
fn spread(variance: f64, width: f64) -> f64 {
    (variance + FRAC_2_PI * width * width).sqrt()
}

/// E[1/(1 + s² z²)] for standard normal z: the mean gain of an arctangent. The trapezoidal rule
/// converges geometrically here; 1e-12 up to s = 1.
fn arctangent_gain(s: f64) -> f64 {
    let h = 0.2;
    let term = |k: i32| {
        let z = h * f64::from(k);
        (-0.5 * z * z).exp() / (1.0 + s * s * z * z)
    };
    h / TAU.sqrt() * (-40..=40).map(term).sum::<f64>()
}

/// The loop with the mean gains of a covariance `p`.
fn with_gains(parts: &Apart, b: &Parameters, speed: f64, p: &DMatrix<f64>) -> DMatrix<f64> {
    let mut a = parts.state.clone();
    let friction = sign_gain(spread(p[(STEER_RATE, STEER_RATE)], b.steer_rate_smoothing));
    let mut column = a.column_mut(STEER_RATE);
    column.axpy(friction, &parts.steer_rate_sign, 1.0);

    // what follows is of the paper's formulations; the four-body bicycle is linear
    if parts.steer_sign.is_empty() {
        return a;
    }
    let slope = b.wheelbase / speed;
    let path = arctangent_gain(slope * p[(YAW_RATE, YAW_RATE)].sqrt());
    let mut column = a.column_mut(YAW_RATE);
    column.axpy(slope * path, &parts.path_angle, 1.0);

    // f_i = sign θ · ½ xᵀ H x:  E[∂f_i/∂x] = E[sign θ H x] + E[2 δ(θ) ½ xᵀ H x] e_θ
    let sigma = spread(p[(STEER, STEER)], b.steer_smoothing);
    let with_steer = p.column(STEER).clone_owned();
    let given_steer = p - &with_steer * with_steer.transpose() / (sigma * sigma);
    for (i, h) in parts.steer_sign.iter().enumerate() {
        let mut row = a.row_mut(i);
        row += (h * &with_steer).transpose() * sign_gain(sigma);
        row[STEER] += (h * &given_steer).trace() / (TAU.sqrt() * sigma);
    }
    a
}

/// P of `ẋ = A x + B n`, n first-order noise of corner `rate` [1/s] and variance 1: the upper left
/// of the solution of A₊ P + P A₊ᵀ + Q = 0 with the noise as one state more, in its different
/// entries.
fn stationary(a: &DMatrix<f64>, b: &DVector<f64>, rate: f64) -> Option<DMatrix<f64>> {
    let n = a.nrows() + 1;
    let mut a_plus = DMatrix::zeros(n, n);
    a_plus.view_mut((0, 0), a.shape()).copy_from(a);
    a_plus.view_mut((0, n - 1), b.shape()).copy_from(b);
    a_plus[(n - 1, n - 1)] = -rate;
    let index = |i: usize, j: usize| {
        let (i, j) = (i.min(j), i.max(j));
        i * n - i * (i + 1) / 2 + j
    };
    let entries = n * (n + 1) / 2;
    let mut system = DMatrix::zeros(entries, entries);
    let mut right = DVector::zeros(entries);
    for i in 0..n {
        for j in i..n {
            let row = index(i, j);
            for k in 0..n {
                system[(row, index(k, j))] += a_plus[(i, k)];
                system[(row, index(k, i))] += a_plus[(j, k)];
            }
        }
    }
    right[entries - 1] = -2.0 * rate;
    let p = system.lu().solve(&right)?;
    let p = DMatrix::from_fn(n - 1, n - 1, |i, j| p[index(i, j)]);
    // variances that are none come of a loop that is not stable
    let is_covariance = p.iter().all(|v| v.is_finite()) && p.diagonal().iter().all(|v| *v > 0.0);
    is_covariance.then_some(p)
}

impl ClosedLoop {
    /// The loop of `parameters` under `drive`. With `effective_damping` [N m s/rad] given, it
    /// stands for viscous and Coulomb friction together.
    pub fn new(
        parameters: &Parameters,
        formulation: Formulation,
        drive: &Drive,
        effective_damping: Option<f64>,
    ) -> Result<Self> {
        let mut parameters = *parameters;
        if let Some(damping) = effective_damping {
            (parameters.viscous_friction, parameters.coulomb_friction) = (damping, 0.0);
        }
        let parts = linear::apart(&parameters, formulation, drive.speed);
        let torque = parts
            .input
            .column(Input::index("steer_torque").expect("a row"))
            .into_owned();
        // begin with friction at a steer rate of .3 rad/s rms and everything else linear
        let n = parts.state.nrows();
        let mut covariance = DMatrix::zeros(n, n);
        covariance[(STEER_RATE, STEER_RATE)] = 0.09;
        // and some steering: without, an unsmoothed sign θ would have no gain at all
        covariance[(STEER, STEER)] = 1e-6;
        let mut state;
        let mut pass = 0;
        loop {
            state = with_gains(&parts, &parameters, drive.speed, &covariance);
            let unstable = || {
                let worst = linear::eigenvalues(&state)[0];
                Error::Unstable {
                    growth: worst.re,
                    frequency: worst.im.abs() / TAU,
                }
            };
            let mut next = stationary(&state, &torque, TAU * drive.remnant_corner)
                .ok_or_else(unstable)?
                * drive.remnant_intensity.powi(2);
            for line in &drive.lines {
                let x = response(&state, &torque, line.frequency).ok_or_else(unstable)?;
                let size = line.steer_amplitude / x[STEER].norm();
                let x = x * Complex::from(size);
                next += DMatrix::from_fn(n, n, |i, j| 0.5 * (x[i] * x[j].conj()).re);
            }
            let change = (&next - &covariance).norm() / next.norm();
            covariance = next;
            pass += 1;
            // Six passes give the spectrum to a per mille; the derivatives by differences, and
            // with them the verdict on what is singular, want the fixed point itself.
            if pass == PASSES && (change.is_nan() || change > 1e-6) {
                return Err(Error::Search(format!(
                    "the linearisation still changed by {change:.1e} after {PASSES} passes"
                )));
            }
            if change < 1e-13 || pass == PASSES {
                if linear::eigenvalues(&state)[0].re >= 0.0 {
                    return Err(unstable());
                }
                return Ok(Self {
                    state,
                    torque,
                    seen: parts.seen,
                    covariance,
                    drive: drive.clone(),
                });
            }
        }
    }

    /// Standard deviation of what is seen of a row of the state, lines included [SI].
    pub fn deviation(&self, row: usize) -> f64 {
        let seen = self.seen.row(row);
        (seen * &self.covariance * seen.transpose())[0].sqrt()
    }

    /// σ_θ̇ [rad/s], the steer rate's standard deviation.
    pub fn steer_rate_deviation(&self) -> f64 {
        self.deviation(STEER_RATE)
    }

    /// σ_θ [rad], the steer angle's standard deviation.
    pub fn steer_deviation(&self) -> f64 {
        self.deviation(STEER)
    }

    /// Two-sided spectral density [(N m)²/Hz] of the remnant at `f` [Hz].
    fn remnant_density(&self, f: f64) -> f64 {
        let (rate, omega) = (TAU * self.drive.remnant_corner, TAU * f);
        self.drive.remnant_intensity.powi(2) * 2.0 * rate / (rate * rate + omega * omega)
    }

    /// Expected cross-powers of the rows `channels` of the state in each bin of `kernel`, white noise of
    /// standard deviation `noise` [SI] and step `step` [s] added: one Hermitian matrix a bin.
    pub fn expected(
        &self,
        kernel: &Kernel,
        channels: &[usize],
        noise: &[f64],
        step: f64,
    ) -> Vec<DMatrix<Complex<f64>>> {
        let n = channels.len();
        let seen = self.seen.select_rows(channels).map(Complex::from);
        let responses: Vec<_> = kernel
            .frequencies
            .iter()
            .map(|&f| {
                let size = Complex::from(self.remnant_density(f).sqrt());
                match response(&self.state, &self.torque, f) {
                    Some(x) => &seen * x * size,
                    None => DVector::zeros(n),
                }
            })
            .collect();
        let mut density = vec![0.0; kernel.frequencies.len()];
        let mut expect = |i: usize, j: usize, part: fn(Complex<f64>) -> f64| {
            for (d, x) in density.iter_mut().zip(&responses) {
                *d = part(x[i] * x[j].conj());
            }
            if i == j || part(Complex::i()) == 0.0 {
                kernel.expect_real(&density)
            } else {
                kernel.expect_imaginary(&density)
            }
        };
        let mut bins: Vec<DMatrix<Complex<f64>>> = Vec::new();
        for i in 0..n {
            for j in 0..=i {
                let real = expect(i, j, |z| z.re);
                let imaginary = if i == j {
                    vec![0.0; real.len()]
                } else {
                    expect(i, j, |z| z.im)
                };
                bins.resize(real.len(), DMatrix::zeros(n, n));
                for (bin, (re, im)) in bins.iter_mut().zip(real.into_iter().zip(imaginary)) {
                    let white = if i == j {
                        noise[i] * noise[i] * step
                    } else {
                        0.0
                    };
                    bin[(i, j)] = Complex::new(re + white, im);
                    bin[(j, i)] = bin[(i, j)].conj();
                }
            }
        }
        bins
    }
}

/// (2πif − A)⁻¹ B.
fn response(a: &DMatrix<f64>, b: &DVector<f64>, f: f64) -> Option<DVector<Complex<f64>>> {
    let mut m = a.map(|v| Complex::new(-v, 0.0));
    for i in 0..m.nrows() {
        m[(i, i)] += Complex::new(0.0, TAU * f);
    }
    m.lu().solve(&b.map(Complex::from))
}

#[cfg(test)]
mod tests {
    #![expect(clippy::unwrap_used, reason = "a failed step is a failed test")]
    use super::*;

    #[test]
    fn the_arctangents_gain_is_the_gaussian_mean() {
        assert!((arctangent_gain(0.0) - 1.0).abs() < 1e-12);
        // √(π/2)/s e^{1/2s²} erfc(1/(√2 s)) at s = 1 and ½, by 30-digit arithmetic
        assert!((arctangent_gain(1.0) - 0.655_679_542_418_798_6).abs() < 1e-11);
        assert!((arctangent_gain(0.5) - 0.842_738_458_576_109_3).abs() < 1e-11);
    }

    #[test]
    fn the_stationary_covariance_solves_lyapunov() {
        let bicycle = Parameters::default();
        let parts = linear::apart(&bicycle, Formulation::Repaired, 2.2);
        let a = with_gains(&parts, &bicycle, 2.2, &(DMatrix::identity(5, 5) * 1e-3));
        let b = parts.input.column(1).into_owned();
        let p = stationary(&a, &b, 12.0).unwrap();
        // with the noise's own row eliminated: c = −(A − r)⁻¹ B, A P + P Aᵀ + B cᵀ + c Bᵀ = 0
        let c = -(&a - DMatrix::identity(5, 5) * 12.0)
            .lu()
            .solve(&b)
            .unwrap();
        let rest = &a * &p + &p * a.transpose() + &b * c.transpose() + c * b.transpose();
        assert!(rest.norm() < 1e-9 * (a * p).norm(), "{rest}");
    }

    #[test]
    fn an_unstable_loop_is_named() {
        let rideless = Parameters {
            rider_roll_gain: 0.0,
            rider_roll_rate_gain: 0.0,
            rider_steer_gain: 0.0,
            rider_steer_rate_gain: 0.0,
            ..Parameters::default()
        };
        let drive = Drive {
            speed: 2.2,
            remnant_intensity: 1.0,
            remnant_corner: 2.0,
            lines: Vec::new(),
        };
        let error = ClosedLoop::new(&rideless, Formulation::Repaired, &drive, None).unwrap_err();
        assert!(
            matches!(error, Error::Unstable { growth, .. } if growth > 1.0),
            "{error}"
        );
    }
}
