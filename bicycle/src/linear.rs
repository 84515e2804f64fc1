//! The linear system ẋ = A x + B u by dual numbers: the same source as the simulation.

mod steady;

pub use steady::steady_turn;

use crate::dynamics::{Bicycle, Formulation, Nonlinear, derivative_with, output_with};
use crate::parameters::Parameters;
use crate::quantity::Quantity;
use crate::real::Real;
use crate::state::{Input, Path, State};
use crate::tyre;
use nalgebra::{Complex, DMatrix, DVector, SMatrix, SVector, Schur};
use num_dual::{Dual2SVec64, DualSVec64};

/// A linear system about a motion, `ẋ = A x + B u`, `y = C x + D u`, all changes from there. Its
/// states are the rows of [`State`] that the formulation moves, the first n of the table.
#[derive(Debug, Clone, PartialEq)]
pub struct Linear {
    /// ∂ẋ/∂x, n × n.
    pub a: DMatrix<f64>,
    /// ∂ẋ/∂u, n × 4, columns in the order of [`Input`].
    pub b: DMatrix<f64>,
    /// ∂y/∂x, rows in the order of [`crate::Output`].
    pub c: DMatrix<f64>,
    /// ∂y/∂u.
    pub d: DMatrix<f64>,
}

impl Linear {
    /// The rows of its states.
    pub fn states(&self) -> &'static [Quantity] {
        &State::TABLE[..self.a.nrows()]
    }
}

/// Directions of the dual numbers: the states, then the inputs.
const DIRECTIONS: usize = State::LEN + Input::LEN;

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

/// State and inputs as dual numbers, each row with its own direction.
fn lifted<const N: usize>(x: &State, u: &Input) -> (State<DualSVec64<N>>, Input<DualSVec64<N>>) {
    let mut direction = 0..;
    let mut next = |value: f64| seed::<N>(value, direction.next().expect("endless"));
    (x.map(&mut next), u.map(&mut next))
}

/// The nonlinear terms at a state; a jump, of width 0, as the constant that it is on either side.
fn terms<const N: usize>(
    b: &Bicycle<DualSVec64<N>>,
    x: &State<DualSVec64<N>>,
    speed: DualSVec64<N>,
) -> Nonlinear<DualSVec64<N>> {
    let mut terms = Nonlinear::at(b, x, speed);
    if b.p.steer_smoothing.is_zero() {
        terms.steer_sign = DualSVec64::from(terms.steer_sign.re);
    }
    if b.p.steer_rate_smoothing.is_zero() {
        terms.steer_rate_sign = DualSVec64::from(terms.steer_rate_sign.re);
    }
    terms
}

/// What `rows` change with the first `n` states and with the inputs.
fn slopes<const N: usize>(rows: &[DualSVec64<N>], n: usize) -> (DMatrix<f64>, DMatrix<f64>) {
    let count = rows.len();
    (
        DMatrix::from_fn(count, n, |i, j| partial(&rows[i], j)),
        DMatrix::from_fn(count, Input::LEN, |i, j| partial(&rows[i], State::LEN + j)),
    )
}

/// ∂ẋ/∂x and ∂ẋ/∂u of the states that move, at state `x` and input `u`; the jumps contribute their
/// smoothed slopes, of width 0 none.
pub fn state_equations(b: &Bicycle, x: &State, u: &Input) -> (DMatrix<f64>, DMatrix<f64>) {
    let n = b.order();
    let dual = Bicycle::new(&b.p.map(DualSVec64::<DIRECTIONS>::from), b.formulation);
    let (x, u) = lifted::<DIRECTIONS>(x, u);
    let rates = derivative_with(&dual, &x, &u, &terms(&dual, &x, u.speed)).to_array();
    slopes(&rates[..n], n)
}

/// The linear system at state `x` and input `u`, heading straight on; the jumps contribute their
/// smoothed slopes, of width 0 none.
pub fn linearize(b: &Bicycle, x: &State, u: &Input) -> Linear {
    let n = b.order();
    let dual = Bicycle::new(&b.p.map(DualSVec64::<DIRECTIONS>::from), b.formulation);
    let (state, input) = lifted::<DIRECTIONS>(x, u);
    let terms = terms(&dual, &state, input.speed);
    let seen = output_with(&dual, &state, &Path::default(), &input, &terms).to_array();
    let rates = derivative_with(&dual, &state, &input, &terms).to_array();
    let (a, b) = slopes(&rates[..n], n);
    let (c, d) = slopes(&seen, n);
    Linear { a, b, c, d }
}

/// The linear system at rest upright with the three nonlinear terms held apart:
/// `ẋ = A x + B u + E n`, and the products of `sign θ` with the state in `sign θ · ½ xᵀ H_i x`.
/// States as in [`Linear`].
#[derive(Debug, Clone)]
pub struct Apart {
    /// ∂ẋ/∂x with the nonlinear terms at zero.
    pub state: DMatrix<f64>,
    /// ∂ẋ/∂u.
    pub input: DMatrix<f64>,
    /// ∂ẋ/∂(sign θ̇).
    pub steer_rate_sign: DVector<f64>,
    /// ∂ẋ/∂(path angle) [per rad].
    pub path_angle: DVector<f64>,
    /// Hessian over x of `∂ẋ_i/∂(sign θ)`, one matrix for each state derivative i, the path angle
    /// following the yaw rate with its slope at rest, L/V; none where sign θ plays no part.
    pub steer_sign: Vec<DMatrix<f64>>,
    /// What is seen of the rows of [`State`], moved or not: `State::LEN` × n.
    pub seen: DMatrix<f64>,
}

/// [`Apart`] for a bicycle at `speed` [m/s].
pub fn apart(p: &Parameters, formulation: Formulation, speed: f64) -> Apart {
    const ALL: usize = DIRECTIONS + 2;
    let dual = Bicycle::new(&p.map(DualSVec64::<ALL>::from), formulation);
    let upright = Input {
        speed,
        ..Input::ZERO
    };
    let (x, u) = lifted::<ALL>(&State::ZERO, &upright);
    let terms = Nonlinear {
        steer_sign: DualSVec64::from(0.0),
        steer_rate_sign: seed::<ALL>(0.0, DIRECTIONS),
        path_angle: seed::<ALL>(0.0, DIRECTIONS + 1),
    };
    let rows = derivative_with(&dual, &x, &u, &terms).to_array();
    let n = dual.order();
    let (state, input) = slopes(&rows[..n], n);
    let mut seen = x;
    seen.yaw_rate = dual.yaw_rate(&x, u.speed);
    let seen = seen.to_array();
    Apart {
        state,
        input,
        steer_rate_sign: DVector::from_fn(n, |i, _| partial(&rows[i], DIRECTIONS)),
        path_angle: DVector::from_fn(n, |i, _| partial(&rows[i], DIRECTIONS + 1)),
        steer_sign: if formulation.has_four_bodies() {
            Vec::new()
        } else {
            steer_sign_products(p, formulation, speed)
        },
        seen: DMatrix::from_fn(State::LEN, n, |i, j| partial(&seen[i], j)),
    }
}

/// Second derivatives over the state of what multiplies sign θ: each `ẋ_i` is affine in sign θ, so
/// that factor is the difference between sign θ = 1 and 0. The path angle enters it with its slope
/// at rest.
fn steer_sign_products(p: &Parameters, formulation: Formulation, speed: f64) -> Vec<DMatrix<f64>> {
    // the rows that the paper's formulations move
    const N: usize = 5;
    type Second = Dual2SVec64<N>;
    let dual = Bicycle::new(&p.map(Second::from), formulation);
    debug_assert_eq!(dual.order(), N, "rows that move");
    let x = State::from_array(std::array::from_fn(|i| {
        let mut value = Second::from(0.0);
        if i < N {
            let (row, column) = (nalgebra::Const::<1>, nalgebra::Const::<N>);
            value.v1 = num_dual::Derivative::derivative_generic(row, column, i);
        }
        value
    }));
    let u = Input {
        speed,
        ..Input::ZERO
    }
    .map(Second::from);
    let rows = |sign: f64| {
        let terms = Nonlinear {
            steer_sign: Second::from(sign),
            steer_rate_sign: Second::from(0.0),
            path_angle: x.yaw_rate * Second::from(p.wheelbase / speed),
        };
        derivative_with(&dual, &x, &u, &terms).to_array()
    };
    let (with, without) = (rows(1.0), rows(0.0));
    let n = dual.order();
    let hessian = |i: usize| {
        let second = (with[i] - without[i])
            .v2
            .unwrap_generic(nalgebra::Const::<N>, nalgebra::Const::<N>);
        DMatrix::from_fn(n, n, |j, k| second[(j, k)])
    };
    (0..n).map(hessian).collect()
}

/// ẋ = A(V) x of a bicycle upright, jumps left out, made ready for many speeds: the parameters
/// become dual numbers once, and no matrix needs memory of its own. N is [`Bicycle::order`].
#[derive(Debug, Clone)]
pub(crate) struct Upright<const N: usize> {
    dual: Bicycle<DualSVec64<N>>,
    x: State<DualSVec64<N>>,
}

impl<const N: usize> Upright<N> {
    pub(crate) fn new(b: &Bicycle) -> Self {
        debug_assert_eq!(b.order(), N, "rows that move");
        let seeded = |i| {
            if i < N {
                seed::<N>(0.0, i)
            } else {
                DualSVec64::from(0.0)
            }
        };
        Self {
            dual: Bicycle::new(&b.p.map(DualSVec64::from), b.formulation),
            x: State::from_array(std::array::from_fn(seeded)),
        }
    }

    /// A at `speed` [m/s].
    pub(crate) fn at(&self, speed: f64) -> SMatrix<f64, N, N> {
        let u = Input {
            speed,
            ..Input::ZERO
        }
        .map(DualSVec64::from);
        let nil = DualSVec64::from(0.0);
        let terms = Nonlinear {
            steer_sign: nil,
            steer_rate_sign: nil,
            path_angle: tyre::path_angle(&self.dual, u.speed, self.x.yaw_rate),
        };
        let rows = derivative_with(&self.dual, &self.x, &u, &terms).to_array();
        SMatrix::from_fn(|i, j| partial(&rows[i], j))
    }
}

/// The first row of the state that is a force, of a size of 1000 N where angles are of 1 rad.
const FORCES: usize = State::index("front_lateral_force").expect("a state");

/// The Schur form of a finite matrix. Forces are counted in kilonewtons meanwhile, or their size
/// would cost the slow modes three digits. (Balancing does as much there, but worse where tyres are
/// stiff and do not relax.) The QR iteration mostly takes some ten rounds. One matrix in a million
/// sends it round in circles; its transpose, with the same eigenvalues, takes another way. (A macro:
/// nalgebra's bounds on a size would fill half a page.)
macro_rules! schur {
    ($a:expr) => {{
        let mut even = $a.clone();
        for i in FORCES..even.nrows() {
            even.row_mut(i).scale_mut(1e-3);
            even.column_mut(i).scale_mut(1e3);
        }
        let transpose = even.transpose();
        Schur::try_new(even, f64::EPSILON, 1000)
            .or_else(|| Schur::try_new(transpose, f64::EPSILON, 1000))
    }};
}

/// Square matrices of the sizes that formulations have, on the stack.
pub(crate) trait Spectral<const N: usize> {
    /// Eigenvalues in no order; none where the matrix is not finite.
    fn spectrum(&self) -> Option<SVector<Complex<f64>, N>>;
}

macro_rules! spectral {
    ($($N:literal)*) => {
        $(impl Spectral<$N> for SMatrix<f64, $N, $N> {
            fn spectrum(&self) -> Option<SVector<Complex<f64>, $N>> {
                if self.iter().any(|v| !v.is_finite()) {
                    return None;
                }
                schur!(*self).map(|schur| schur.complex_eigenvalues())
            }
        })*
    };
}
spectral!(4 5 6 8);

/// Eigenvalues [1/s] of a square matrix, largest real part first; NaN where it is not finite.
pub fn eigenvalues(a: &DMatrix<f64>) -> Vec<Complex<f64>> {
    let unknown = vec![Complex::new(f64::NAN, f64::NAN); a.nrows()];
    if a.iter().any(|v| !v.is_finite()) {
        return unknown;
    }
    let Some(schur) = schur!(a) else {
        return unknown;
    };
    let mut values: Vec<_> = schur.complex_eigenvalues().iter().copied().collect();
    values.sort_by(|a, b| b.re.total_cmp(&a.re).then(b.im.total_cmp(&a.im)));
    values
}

/// A bound on the modulus [1/s] of every eigenvalue, a few per cent above the largest:
/// ρ(A) ≤ ‖Aᵏ‖^(1/k) whatever k (Gelfand), here 2⁸; infinite where A is not finite. A has at most
/// as many rows as [`State`].
pub fn spectral_bound(a: &DMatrix<f64>) -> f64 {
    // what is not there stays zero, and small fixed matrices need no memory of their own
    match a.nrows() {
        ..=5 => bound(SMatrix::<f64, 5, 5>::zeros(), a),
        _ => bound(SMatrix::<f64, { State::LEN }, { State::LEN }>::zeros(), a),
    }
}

fn bound<const N: usize>(mut power: SMatrix<f64, N, N>, a: &DMatrix<f64>) -> f64 {
    power.view_mut((0, 0), a.shape()).copy_from(a);
    let (mut exponent, mut log_bound) = (1.0, 0.0);
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
    let exact = Parameters {
        steer_smoothing: 0.0,
        steer_rate_smoothing: 0.0,
        ..*p
    };
    let upright = Input {
        speed,
        ..Input::ZERO
    };
    let (a, _) = state_equations(&Bicycle::new(&exact, formulation), &State::ZERO, &upright);
    eigenvalues(&a)[0]
}
