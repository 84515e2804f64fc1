//! The linear system ẋ = A x + B u by dual numbers: the same source as the simulation.

use crate::dynamics::{Bicycle, Formulation, Nonlinear, derivative, derivative_with};
use crate::parameters::Parameters;
use crate::state::{Input, State};
use nalgebra::{Complex, DMatrix, SMatrix, SVector, Schur};
use num_dual::{Dual2SVec64, DualSVec64};

/// ∂ẋ/∂x, rows and columns in the order of [`State`].
pub type StateMatrix = SMatrix<f64, 5, 5>;
/// ∂ẋ/∂u, columns in the order of [`Input`].
pub type InputMatrix = SMatrix<f64, 5, 4>;

/// A dual number with derivative 1 in direction `index`.
fn seed<const N: usize>(value: f64, index: usize) -> DualSVec64<N> {
    DualSVec64::new(
        value,
        num_dual::Derivative::derivative_generic(nalgebra::Const::<N>, nalgebra::Const::<1>, index),
    )
}

/// The derivative of `value` in direction `index`.
pub(crate) fn partial<const N: usize>(value: &DualSVec64<N>, index: usize) -> f64 {
    value
        .eps
        .unwrap_generic(nalgebra::Const::<N>, nalgebra::Const::<1>)[index]
}

/// A and B at state `x` and input `u`; the jumps contribute their smoothed slopes.
pub fn linearize(b: &Bicycle, x: &State, u: &Input) -> (StateMatrix, InputMatrix) {
    let lifted = Bicycle::new(&b.p.map(DualSVec64::<9>::from), b.formulation);
    let mut k = 0;
    let mut next = |value: f64| {
        k += 1;
        seed::<9>(value, k - 1)
    };
    let x = x.map(&mut next);
    let u = u.map(&mut next);
    let rows = derivative(&lifted, &x, &u).to_array();
    (
        StateMatrix::from_fn(|i, j| partial(&rows[i], j)),
        InputMatrix::from_fn(|i, j| partial(&rows[i], 5 + j)),
    )
}

/// The linear system at rest upright with the three nonlinear terms held apart:
/// `ẋ = A x + B u + E n`, and the products of `sign θ` with the state in `sign θ · ½ xᵀ H_i x`.
#[derive(Debug, Clone)]
pub struct Apart {
    /// ∂ẋ/∂x with the nonlinear terms at zero.
    pub state: StateMatrix,
    /// ∂ẋ/∂u.
    pub input: InputMatrix,
    /// ∂ẋ/∂(sign θ̇).
    pub steer_rate_sign: SVector<f64, 5>,
    /// ∂ẋ/∂(path angle) [per rad].
    pub path_angle: SVector<f64, 5>,
    /// Hessian over x of `∂ẋ_i/∂(sign θ)`, one matrix for each state derivative i, the path angle
    /// following the yaw rate with its slope at rest, L/V.
    pub steer_sign: [StateMatrix; 5],
}

/// [`Apart`] for a bicycle at `speed` [m/s].
pub fn apart(p: &Parameters, formulation: Formulation, speed: f64) -> Apart {
    // directions: five states, four inputs, two of the nonlinear terms
    let lifted = Bicycle::new(&p.map(DualSVec64::<11>::from), formulation);
    let mut k = 0;
    let mut next = |value: f64| {
        k += 1;
        seed::<11>(value, k - 1)
    };
    let x = State {
        roll_rate: 0.0,
        steer_rate: 0.0,
        roll: 0.0,
        steer: 0.0,
        yaw_rate: 0.0,
    }
    .map(&mut next);
    let u = Input {
        speed,
        ..Input::default()
    }
    .map(&mut next);
    let n = Nonlinear {
        steer_sign: DualSVec64::from(0.0),
        steer_rate_sign: next(0.0),
        path_angle: next(0.0),
    };
    let rows = derivative_with(&lifted, &x, &u, &n).to_array();
    Apart {
        state: StateMatrix::from_fn(|i, j| partial(&rows[i], j)),
        input: InputMatrix::from_fn(|i, j| partial(&rows[i], 5 + j)),
        steer_rate_sign: SVector::from_fn(|i, _| partial(&rows[i], 9)),
        path_angle: SVector::from_fn(|i, _| partial(&rows[i], 10)),
        steer_sign: steer_sign_products(p, formulation, speed),
    }
}

/// Second derivatives over the state of what multiplies sign θ: each `ẋ_i` is affine in sign θ, so
/// that factor is the difference between sign θ = 1 and 0. The path angle enters it with its slope
/// at rest.
fn steer_sign_products(p: &Parameters, formulation: Formulation, speed: f64) -> [StateMatrix; 5] {
    type Second = Dual2SVec64<5>;
    let lifted = Bicycle::new(&p.map(Second::from), formulation);
    let x = State::from_array(std::array::from_fn(|i| {
        let mut value = Second::from(0.0);
        value.v1 =
            num_dual::Derivative::derivative_generic(nalgebra::Const::<1>, nalgebra::Const::<5>, i);
        value
    }));
    let u = Input {
        speed,
        ..Input::default()
    }
    .map(Second::from);
    let rows = |sign: f64| {
        let n = Nonlinear {
            steer_sign: Second::from(sign),
            steer_rate_sign: Second::from(0.0),
            path_angle: x.yaw_rate * Second::from(p.wheelbase / speed),
        };
        derivative_with(&lifted, &x, &u, &n).to_array()
    };
    let (with, without) = (rows(1.0), rows(0.0));
    std::array::from_fn(|i| {
        (with[i] - without[i])
            .v2
            .unwrap_generic(nalgebra::Const::<5>, nalgebra::Const::<5>)
    })
}

/// Eigenvalues [1/s] of a state matrix, largest real part first; NaN where it is not finite.
pub fn eigenvalues(a: &StateMatrix) -> Vec<Complex<f64>> {
    let unknown = vec![Complex::new(f64::NAN, f64::NAN); 5];
    if a.iter().any(|v| !v.is_finite()) {
        return unknown;
    }
    // The QR iteration mostly takes some ten rounds. One matrix in a million sends it round in
    // circles; its transpose, with the same eigenvalues, takes another way.
    let dynamic = DMatrix::from_column_slice(5, 5, a.as_slice());
    let schur = Schur::try_new(dynamic.clone(), f64::EPSILON, 1000)
        .or_else(|| Schur::try_new(dynamic.transpose(), f64::EPSILON, 1000));
    let Some(schur) = schur else {
        return unknown;
    };
    let mut values: Vec<_> = schur.complex_eigenvalues().iter().copied().collect();
    values.sort_by(|a, b| b.re.total_cmp(&a.re).then(b.im.total_cmp(&a.im)));
    values
}

/// A bound on the modulus [1/s] of every eigenvalue, a few per cent above the largest:
/// ρ(A) ≤ ‖Aᵏ‖^(1/k) whatever k (Gelfand), here 2⁸; infinite where A is not finite.
pub fn spectral_bound(a: &StateMatrix) -> f64 {
    let (mut power, mut exponent, mut log_bound) = (*a, 1.0, 0.0);
    for _ in 0..=8 {
        let size = power.norm();
        if !size.is_finite() {
            return f64::INFINITY;
        }
        if size == 0.0 {
            return 0.0;
        }
        log_bound += exponent * size.log2();
        power /= size;
        power *= power;
        exponent *= 0.5;
    }
    log_bound.exp2()
}

/// Eigenvalue of largest real part [1/s] of the bicycle upright at `speed`, jumps left out; the
/// rider law is in the loop as far as its gains are not zero.
pub fn fastest_growth(p: &Parameters, formulation: Formulation, speed: f64) -> Complex<f64> {
    let parts = apart(p, formulation, speed);
    let slope = p.wheelbase / speed;
    let mut a = parts.state;
    let mut yaw = a.column_mut(4);
    yaw += parts.path_angle * slope;
    eigenvalues(&a)[0]
}
