//! Derivatives of what is seen, by dual numbers: the same source as the simulation.

use crate::dynamics::{Bicycle, path_derivative};
use crate::linear::partial;
use crate::parameters::Parameters;
use crate::simulate::jump::Mode;
use crate::state::{Input, Output, Path, State};
use nalgebra::SVector;
use num_dual::{Derivative, DualSVec64};

/// A direction in which everything that an output depends on moves, each row in its own unit.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Direction {
    /// Of the parameters. The rows of the start and of the step move nothing.
    pub parameters: Parameters,
    /// Of the state.
    pub state: State,
    /// Of heading and place.
    pub path: Path,
    /// Of the inputs.
    pub input: Input,
}

impl Direction {
    /// Nothing moves.
    pub const ZERO: Self = Self {
        parameters: Parameters::ZERO,
        state: State::ZERO,
        path: Path::ZERO,
        input: Input::ZERO,
    };
}

type Dual = DualSVec64<1>;

fn dual(value: f64, slope: f64) -> Dual {
    Dual::new(value, Derivative::some(SVector::from([slope])))
}

/// Directional derivative of [`crate::simulate::output`]: Σ ∂y/∂p dp + ∂y/∂x dx + … Smoothed jumps
/// contribute their slopes; a jump itself (width 0) has none, and a fork that friction holds is
/// held along every direction.
pub fn output_along(b: &Bicycle, x: &State, path: &Path, u: &Input, d: &Direction) -> Output {
    let mode = Mode::at(b, x, u);
    let b = Bicycle::new(&b.p.zip(&d.parameters, dual), b.formulation);
    let x = x.zip(&d.state, dual);
    let path = path.zip(&d.path, dual);
    let u = u.zip(&d.input, dual);
    mode.output(&b, &x, &path, &u)
        .map(|value| partial(&value, 0))
}

/// Time derivative of [`crate::simulate::output`], each row in its unit per second, with the inputs
/// on slopes `slope`.
pub fn output_rate(b: &Bicycle, x: &State, path: &Path, u: &Input, slope: &Input) -> Output {
    let onward = Direction {
        state: Mode::at(b, x, u).derivative(b, x, u),
        path: path_derivative(b, x, path, u.speed),
        input: *slope,
        ..Direction::ZERO
    };
    output_along(b, x, path, u, &onward)
}
