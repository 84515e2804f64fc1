//! Steady turns: motions other than upright about which a bicycle can be linearised.

use super::state_equations;
use crate::dynamics::{Bicycle, derivative};
use crate::state::{Input, State};
use nalgebra::{DMatrix, DVector};
use std::f64::consts::FRAC_PI_2;

/// States that a steady turn holds at a value given: roll and steer rate 0, and the steer angle.
const HELD: [usize; 3] = [
    State::index("roll_rate").expect("a state"),
    State::index("steer_rate").expect("a state"),
    State::index("steer").expect("a state"),
];
/// States whose rates are other states, zero by what is held.
const ANGLES: [usize; 2] = [
    State::index("roll").expect("a state"),
    State::index("steer").expect("a state"),
];
const STEER_TORQUE: usize = Input::index("steer_torque").expect("an input");
/// Newton's method doubles the digits in each round, once it is near.
const ROUNDS: usize = 40;

/// The steady turn at `speed` [m/s] with the steer angle `steer` [rad] held: roll, yaw rate and
/// what else moves at rest, and the steer torque [N m] that holds it there besides the rider law.
/// By Newton's method from upright; none where that finds no turn short of lying on the side.
pub fn steady_turn(b: &Bicycle, speed: f64, steer: f64) -> Option<(State, Input)> {
    let n = b.order();
    let sought: Vec<usize> = (0..n).filter(|i| !HELD.contains(i)).collect();
    let rows: Vec<usize> = (0..n).filter(|i| !ANGLES.contains(i)).collect();
    let mut x = State {
        steer,
        ..State::ZERO
    };
    let mut u = Input {
        speed,
        ..Input::ZERO
    };
    for _ in 0..ROUNDS {
        let rates = derivative(b, &x, &u).to_array();
        let residual = DVector::from_fn(rows.len(), |i, _| rates[rows[i]]);
        let (of_state, of_input) = state_equations(b, &x, &u);
        let jacobian = DMatrix::from_fn(rows.len(), rows.len(), |i, j| match sought.get(j) {
            Some(state) => of_state[(rows[i], *state)],
            None => of_input[(rows[i], STEER_TORQUE)],
        });
        let step = jacobian.lu().solve(&residual)?;
        for (state, change) in sought.iter().zip(step.iter()) {
            x.set(*state, x.get(*state) - change);
        }
        u.steer_torque -= step[sought.len()];
        if !step.iter().all(|change| change.is_finite()) || x.roll.abs() >= FRAC_PI_2 {
            return None;
        }
        // 1e-12 of forces and torques of 100 N and 1 N m is far below what any of them means
        let size = x.to_array().iter().fold(1.0f64, |m, v| m.max(v.abs()));
        if step.amax() < 1e-12 * size {
            return Some((x, u));
        }
    }
    None
}
