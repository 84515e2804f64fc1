//! The contacts: how they move, how they slip, what they push with. Equations (1)–(6), and what
//! slipping tyres of the four-body bicycle have besides.

use crate::dynamics::{Angles, Bicycle, Formulation};
use crate::real::Real;
use crate::state::State;

/// Shift of the front contact point δL₃ [m], (1).   `δL₃ = r_f sin φ`
#[inline(always)]
pub fn contact_shift<T: Real>(b: &Bicycle<T>, a: &Angles<T>) -> T {
    b.p.front_wheel_radius * a.sin_roll
}

/// Trail after the contact point has moved L₃' [m], (2).   `L₃' = L₃ cos φ + r_f sin φ · sign θ`
///
/// `steer_sign` is sign θ, smoothed or not.
#[inline(always)]
pub fn effective_trail<T: Real>(b: &Bicycle<T>, a: &Angles<T>, steer_sign: T) -> T {
    b.p.trail * a.cos_roll + contact_shift(b, a) * steer_sign
}

/// Yaw rate ψ̇ [rad/s] of a front wheel that runs at θ − β to the frame, (3).
/// `ψ̇ = V tan(θ − β)/L`
pub fn yaw_rate<T: Real>(b: &Bicycle<T>, speed: T, steer: T, slip: T) -> T {
    let (sin, cos) = (steer - slip).sin_cos();
    speed * (sin / cos) / b.p.wheelbase
}

/// Direction θ − β [rad] in which the front contact travels, left of the frame, (3) solved.
/// `θ − β = atan(ψ̇ L/V)`
#[inline(always)]
pub fn path_angle<T: Real>(b: &Bicycle<T>, speed: T, yaw_rate: T) -> T {
    (yaw_rate * b.p.wheelbase / speed).atan()
}

/// Slip angle β [rad], (4).   `β = θ − atan(ψ̇ L/V)`
#[inline(always)]
pub fn slip_angle<T: Real>(steer: T, path_angle: T) -> T {
    steer - path_angle
}

/// Front cornering force `F_θ` [N], left positive, (5).   `F_θ = C_θ β F_z`
#[inline(always)]
pub fn lateral_force<T: Real>(b: &Bicycle<T>, slip: T) -> T {
    b.p.cornering_stiffness * slip * b.front_load
}

/// Camber angle γ [rad] of the front wheel, right positive: the angle inside (6).
///
/// As printed `φ + θ sin λ`; repaired `φ − θ sin λ`, as (9) has it: with steer left positive a
/// wheel steered left leans left.
#[inline(always)]
pub fn camber_angle<T: Real>(b: &Bicycle<T>, x: &State<T>) -> T {
    let tilt = x.steer * b.sin_caster;
    match b.formulation {
        Formulation::Printed | Formulation::Minimal => x.roll + tilt,
        Formulation::Repaired | Formulation::Whipple | Formulation::WhippleSlip => x.roll - tilt,
    }
}

/// Front camber thrust `F_φ` [N], right positive, (6).   `F_φ = C_φ (φ + θ sin λ) F_z`
#[inline(always)]
pub fn camber_thrust<T: Real>(b: &Bicycle<T>, x: &State<T>) -> T {
    b.p.camber_stiffness * camber_angle(b, x) * b.front_load
}

/// Slip angle β [rad] of the front tyre of the four-body bicycle, left of its track: the wheel
/// stands at θ cos λ to the frame, and its contact, a trail behind the steer axis, is swept
/// sideways by θ̇.   `β = θ cos λ − (v_y + L ψ̇ − L_3 cos λ θ̇)/V`
#[inline(always)]
pub fn front_side_slip<T: Real>(b: &Bicycle<T>, x: &State<T>, speed: T) -> T {
    let sweep = b.p.trail * b.cos_caster * x.steer_rate;
    x.steer * b.cos_caster - (x.lateral_velocity + b.p.wheelbase * x.yaw_rate - sweep) / speed
}

/// Lateral forces [N] of the rear and the front tyre in steady slip, left positive.
/// `F_R = F_zR (−C_θR v_y/V − C_φR φ)`, `F_F = F_θ − F_φ`
#[inline(always)]
pub fn steady_forces<T: Real>(b: &Bicycle<T>, x: &State<T>, speed: T) -> [T; 2] {
    let (p, slip) = (&b.p, front_side_slip(b, x, speed));
    let rear = -(p.rear_cornering_stiffness * (x.lateral_velocity / speed))
        - p.rear_camber_stiffness * x.roll;
    [
        b.rear_wheel_load * rear,
        lateral_force(b, slip) - camber_thrust(b, x),
    ]
}

/// Lateral forces [N] of the rear and the front tyre, left positive: states where they relax.
#[inline(always)]
pub fn forces<T: Real>(b: &Bicycle<T>, x: &State<T>, speed: T) -> [T; 2] {
    if b.relaxes {
        [x.rear_lateral_force, x.front_lateral_force]
    } else {
        steady_forces(b, x, speed)
    }
}

/// Rates [N/s] of the front and the rear tyre's force, 0 where they do not relax.
/// `(σ/V) Ḟ + F = F_steady`
#[inline(always)]
pub fn force_rates<T: Real>(b: &Bicycle<T>, x: &State<T>, speed: T) -> [T; 2] {
    if !b.relaxes {
        return [T::from(0.0); 2];
    }
    let [rear, front] = steady_forces(b, x, speed);
    let rate = speed / b.p.relaxation_length;
    [
        rate * (front - x.front_lateral_force),
        rate * (rear - x.rear_lateral_force),
    ]
}
