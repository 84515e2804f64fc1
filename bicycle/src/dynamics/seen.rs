//! What can be seen of a motion, and where it leads on the ground.

use super::{Angles, Bicycle, Formulation, Nonlinear, rate};
use crate::real::Real;
use crate::rider;
use crate::state::{Input, Output, Path, State};
use crate::tyre;

/// Time derivative of the path: `ψ' = ψ̇, ẋ = V cos ψ − v_y sin ψ, ẏ = V sin ψ + v_y cos ψ`.
pub fn path_derivative<T: Real>(b: &Bicycle<T>, x: &State<T>, path: &Path<T>, speed: T) -> Path<T> {
    let (sin, cos) = path.heading.sin_cos();
    Path {
        heading: b.yaw_rate(x, speed),
        x: speed * cos - x.lateral_velocity * sin,
        y: speed * sin + x.lateral_velocity * cos,
    }
}

/// Everything that can be seen at a state.
pub fn output<T: Real>(b: &Bicycle<T>, x: &State<T>, path: &Path<T>, u: &Input<T>) -> Output<T> {
    output_with(b, x, path, u, &Nonlinear::at(b, x, u.speed))
}

/// Everything that can be seen at a state with the nonlinear terms given.
pub fn output_with<T: Real>(
    b: &Bicycle<T>,
    x: &State<T>,
    path: &Path<T>,
    u: &Input<T>,
    n: &Nonlinear<T>,
) -> Output<T> {
    let angles = Angles::at(x);
    let dx = rate(b, x, u, n, &angles);
    let place = path_derivative(b, x, path, u.speed);
    let nil = T::from(0.0);
    let mut output = Output {
        roll: x.roll,
        steer: x.steer,
        roll_rate: x.roll_rate,
        steer_rate: x.steer_rate,
        yaw_rate: place.heading,
        heading: path.heading,
        x: path.x,
        y: path.y,
        slip_angle: nil,
        camber_angle: tyre::camber_angle(b, x),
        effective_trail: b.p.trail,
        lateral_force: nil,
        camber_thrust: nil,
        rear_lateral_force: nil,
        lateral_velocity: x.lateral_velocity,
        front_load: b.front_load,
        rider_torque: rider::torque(&b.p, x, u.speed),
        steer_acceleration: dx.steer_rate,
        roll_acceleration: dx.roll_rate,
        yaw_acceleration: dx.yaw_rate,
        x_rate: place.x,
        y_rate: place.y,
        front_lateral_force: nil,
        lateral_velocity_rate: dx.lateral_velocity,
        front_lateral_force_rate: dx.front_lateral_force,
        rear_lateral_force_rate: dx.rear_lateral_force,
    };
    match &b.four_bodies {
        None => {
            output.slip_angle = tyre::slip_angle(x.steer, n.path_angle);
            output.effective_trail = tyre::effective_trail(b, &angles, n.steer_sign);
            output.lateral_force = tyre::lateral_force(b, output.slip_angle);
            output.camber_thrust = tyre::camber_thrust(b, x);
            output.front_lateral_force = output.lateral_force - output.camber_thrust;
        }
        Some(_) if b.formulation == Formulation::WhippleSlip => {
            output.slip_angle = tyre::front_side_slip(b, x, u.speed);
            output.lateral_force = tyre::lateral_force(b, output.slip_angle);
            output.camber_thrust = tyre::camber_thrust(b, x);
            [output.rear_lateral_force, output.front_lateral_force] = tyre::forces(b, x, u.speed);
        }
        Some(bodies) => {
            // ψ̇ is linear in θ and θ̇: its rate at constant speed is that of their rates
            output.yaw_acceleration = bodies.yaw_rate(&dx, u.speed);
            [output.rear_lateral_force, output.front_lateral_force] =
                bodies.constraint_forces(x, &dx, u.speed);
        }
    }
    output
}
