//! The covariance of a loop under what drives it, and how it changes with the loop.

use super::{Change, LineMotion, STEER};
use nalgebra::{Complex, DMatrix, DVector, Dyn, LU};
use std::f64::consts::TAU;

/// Rows and columns of the different entries of a symmetric matrix.
pub(super) fn entries(n: usize) -> impl Iterator<Item = (usize, usize)> {
    (0..n).flat_map(move |i| (i..n).map(move |j| (i, j)))
}

/// The different entries of a symmetric matrix.
pub(super) fn packed(p: &DMatrix<f64>) -> DVector<f64> {
    let n = p.nrows();
    DVector::from_iterator(n * (n + 1) / 2, entries(n).map(|place| p[place]))
}

/// The symmetric matrix of order `n` of its different entries.
pub(super) fn unpacked(n: usize, values: &DVector<f64>) -> DMatrix<f64> {
    let mut p = DMatrix::zeros(n, n);
    for ((i, j), value) in entries(n).zip(values.iter()) {
        p[(i, j)] = *value;
        p[(j, i)] = *value;
    }
    p
}

/// P of `ẋ = A x + B n`, n first-order noise of corner r [1/s] and variance 1. With c = E[x n],
/// (A − r) c + B = 0 and A P + P Aᵀ + B cᵀ + c Bᵀ = 0.
#[derive(Debug, Clone)]
pub(super) struct Stationary {
    torque: DVector<f64>,
    /// r − A.
    shifted: LU<f64, Dyn, Dyn>,
    /// P ↦ −(A P + P Aᵀ), on the different entries.
    lyapunov: LU<f64, Dyn, Dyn>,
    /// c.
    with_noise: DVector<f64>,
    /// P.
    pub covariance: DMatrix<f64>,
}

impl Stationary {
    /// None where the loop has no covariance: it is not stable.
    pub fn new(a: &DMatrix<f64>, b: &DVector<f64>, rate: f64) -> Option<Self> {
        let n = a.nrows();
        let shifted = (DMatrix::identity(n, n) * rate - a).lu();
        let with_noise = shifted.solve(b)?;
        let index = |i: usize, j: usize| {
            let (i, j) = (i.min(j), i.max(j));
            i * n - i * (i + 1) / 2 + j
        };
        let count = n * (n + 1) / 2;
        let mut system = DMatrix::zeros(count, count);
        for (row, (i, j)) in entries(n).enumerate() {
            for k in 0..n {
                system[(row, index(k, j))] -= a[(i, k)];
                system[(row, index(k, i))] -= a[(j, k)];
            }
        }
        let mut stationary = Self {
            torque: b.clone(),
            shifted,
            lyapunov: system.lu(),
            covariance: DMatrix::zeros(n, n),
            with_noise,
        };
        let half = b * stationary.with_noise.transpose();
        let p = stationary.solve(&half)?;
        // variances that are none come of a loop that is not stable
        let is_covariance =
            p.iter().all(|v| v.is_finite()) && p.diagonal().iter().all(|v| *v > 0.0);
        stationary.covariance = p;
        is_covariance.then_some(stationary)
    }

    /// X of A X + X Aᵀ + U + Uᵀ = 0.
    fn solve(&self, half: &DMatrix<f64>) -> Option<DMatrix<f64>> {
        let right = packed(&(half + half.transpose()));
        let values = self.lyapunov.solve(&right)?;
        Some(unpacked(half.nrows(), &values))
    }

    /// dP with a change of A, B and r.
    pub fn change(&self, change: &Change) -> DMatrix<f64> {
        let regular = "factors that have solved for the covariance";
        let right =
            &change.state * &self.with_noise + &change.torque - &self.with_noise * change.rate;
        let with_noise = self.shifted.solve(&right).expect(regular);
        let half = &change.state * &self.covariance
            + &change.torque * self.with_noise.transpose()
            + &self.torque * with_noise.transpose();
        self.solve(&half).expect(regular)
    }
}

/// What a deterministic line of steer torque makes of the loop: a sine of known steer amplitude.
#[derive(Debug, Clone)]
pub(super) struct Swing {
    /// 2πif − A.
    resolvent: LU<Complex<f64>, Dyn, Dyn>,
    /// Amplitude of the torque [N m], in phase with what is 0 here.
    pub torque: f64,
    /// Amplitudes of the states.
    motion: DVector<Complex<f64>>,
}

impl Swing {
    /// None where the loop has an undamped oscillation of that very frequency.
    pub fn new(a: &DMatrix<f64>, b: &DVector<f64>, line: &LineMotion) -> Option<Self> {
        let mut m = a.map(|v| Complex::from(-v));
        for i in 0..m.nrows() {
            m[(i, i)] += Complex::new(0.0, TAU * line.frequency);
        }
        let resolvent = m.lu();
        let response = resolvent.solve(&b.map(Complex::from))?;
        let torque = line.steer_amplitude / response[STEER].norm();
        Some(Self {
            resolvent,
            torque,
            motion: response * Complex::from(torque),
        })
    }

    /// ½ Re(X Xᴴ), its covariance.
    pub fn covariance(&self) -> DMatrix<f64> {
        half_product(&self.motion, &self.motion)
    }

    /// Change of the covariance with A and B; the steer amplitude stays.
    pub fn change(&self, change: &Change) -> DMatrix<f64> {
        let x = &self.motion;
        let right = change.state.map(Complex::from) * x
            + change.torque.map(|b| Complex::from(b * self.torque));
        let mut dx = self
            .resolvent
            .solve(&right)
            .expect("a factor that has solved for the motion");
        let longer = (x[STEER].conj() * dx[STEER]).re / x[STEER].norm_sqr();
        dx.axpy(Complex::from(-longer), x, Complex::from(1.0));
        let half = half_product(&dx, x);
        &half + half.transpose()
    }
}

/// ½ Re(X Yᴴ).
fn half_product(x: &DVector<Complex<f64>>, y: &DVector<Complex<f64>>) -> DMatrix<f64> {
    DMatrix::from_fn(x.len(), y.len(), |i, j| 0.5 * (x[i] * y[j].conj()).re)
}
