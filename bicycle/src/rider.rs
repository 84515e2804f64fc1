//! The rider: a steering law on the four angles and rates, and one who follows a course.

mod design;
mod preview;
pub mod riccati;

pub use design::{Gains, Manner, Sampled, Unridable, sampled};
pub use preview::{Followed, Preview, Sample, Schedule, follow};

use crate::parameters::Parameters;
use crate::real::Real;
use crate::state::State;

/// The four gains at `speed` [m/s], k(V) = k + slope · V, in the order of the law.
#[inline(always)]
pub fn gains<T: Real>(p: &Parameters<T>, speed: T) -> [T; 4] {
    [
        p.rider_roll_gain + p.rider_roll_gain_slope * speed,
        p.rider_roll_rate_gain + p.rider_roll_rate_gain_slope * speed,
        p.rider_steer_gain + p.rider_steer_gain_slope * speed,
        p.rider_steer_rate_gain + p.rider_steer_rate_gain_slope * speed,
    ]
}

/// Steer torque of the rider `τ_h` [N m], left positive.
/// `τ_h = −k_φ φ − k_p φ̇ − k_θ θ − k_w θ̇`; the paper's law (section 3.1) has the first two.
///
/// With roll right positive and steer left positive the law steers into the lean.
#[inline(always)]
pub fn torque<T: Real>(p: &Parameters<T>, x: &State<T>, speed: T) -> T {
    let [k_phi, k_p, k_theta, k_w] = gains(p, speed);
    -(k_phi * x.roll) - k_p * x.roll_rate - k_theta * x.steer - k_w * x.steer_rate
}
