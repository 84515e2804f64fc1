//! The rest of the paper's equations: what is not linear about upright.

use super::step::{Remainder, Rest, reciprocal_root};
use crate::dynamics::Bicycle;
use crate::lanes::Pack;
use std::f64::consts::FRAC_PI_4;

macro_rules! constants {
    ($b:ident, $v:ident; $($(#[$what:meta])* $field:ident = $value:expr;)+) => {
        /// The repaired equations as constants of a bicycle at a speed, mostly divided by what
        /// stands on the left of their equation: nothing is divided by a parameter under way.
        #[derive(Debug, Clone, Copy)]
        pub(super) struct Paper<T> {
            $($(#[$what])* $field: T,)+
        }

        impl<T: Pack> Paper<T> {
            /// Those of bicycles at speeds [m/s], [`Pack::WIDTH`] of them.
            pub fn new(bicycles: &[(Bicycle, f64)]) -> Self {
                Self {
                    $($field: T::from_fn(|lane| {
                        let ($b, $v) = (&bicycles[lane].0, bicycles[lane].1);
                        let _ = $v;
                        $value
                    }),)+
                }
            }
        }
    };
}

constants! {
    b, v;
    /// sin λ.
    sin_caster = b.sin_caster;
    /// L/V [s].
    path = b.p.wheelbase / v;
    /// `I_xz V/L / I_xx` [1/s].
    cross = b.lumps.cross_inertia * v / b.p.wheelbase / b.lumps.roll_inertia;
    /// `M g h/I_xx` [1/s²].
    gravity = b.lumps.total_mass * b.p.gravity * b.lumps.cog_height / b.lumps.roll_inertia;
    /// `I_f V/r_f / I_xx` [1/s].
    gyro = b.p.front_wheel_inertia * v / b.p.front_wheel_radius / b.lumps.roll_inertia;
    /// `F_z/I_xx` [1/(m s²)].
    contact = b.front_load / b.lumps.roll_inertia;
    /// `m_f g f/I` [1/s²], I the inertia on the left of (9).
    wheel = b.p.front_wheel_mass * b.p.gravity * b.fork_offset / b.steering_inertia;
    /// `I_f cos λ V²/(L r_f)/I` [1/s²].
    turning = b.p.front_wheel_inertia * b.cos_caster * v * v
        / (b.p.wheelbase * b.p.front_wheel_radius * b.steering_inertia);
    /// `F_z/I` [1/(m s²)].
    load = b.front_load / b.steering_inertia;
    /// `F_z` [N].
    front_load = b.front_load;
    /// `L_3` [m].
    trail = b.p.trail;
    /// `r_f` [m].
    radius = b.p.front_wheel_radius;
    /// `C_θ`.
    cornering = b.p.cornering_stiffness;
    /// `C_φ`.
    camber = b.p.camber_stiffness;
    /// `L F_z C_θ/I_zz` [1/s²].
    yaw = b.p.wheelbase * b.front_load * b.p.cornering_stiffness / b.lumps.yaw_inertia;
    /// d [N m].
    friction = b.p.coulomb_friction;
    /// Square of the smoothing width of sign θ [rad²].
    steer_width = b.p.steer_smoothing * b.p.steer_smoothing;
    /// Square of that of sign θ̇ [rad²/s²].
    rate_width = b.p.steer_rate_smoothing * b.p.steer_rate_smoothing;
}

impl<T: Pack> Remainder<T, 5, 3> for Paper<T> {
    const ROWS: [usize; 3] = [0, 1, 4];

    #[inline(always)]
    fn friction(&self) -> T {
        self.friction
    }

    #[inline(always)]
    fn widths(&self) -> [T; 2] {
        [self.steer_width, self.rate_width]
    }

    #[inline(always)]
    fn at(&self, x: &[T; 5]) -> Rest<T, 3> {
        let [_, steer_rate, roll, steer, yaw_rate] = *x;
        let one = T::from(1.0);
        let gamma = (-steer).mul_add(self.sin_caster, roll);
        let path = yaw_rate * self.path;
        // in riding every angle is small, and the polynomials need no reduction
        let small = roll.all_small(FRAC_PI_4)
            & steer.all_small(FRAC_PI_4)
            & gamma.all_small(FRAC_PI_4)
            & path.all_small(0.4375);
        let ((sin_roll, cos_roll), (sin_steer, cos_steer), sin_gamma, path_angle) = if small {
            (
                roll.sin_cos_small(),
                steer.sin_cos_small(),
                gamma.sin_cos_small().0,
                path.atan_small(),
            )
        } else {
            (roll.sin_cos(), steer.sin_cos(), gamma.sin(), path.atan())
        };
        let secant = one / cos_steer;
        let tangent = sin_steer * secant;
        let size = steer.mul_add(steer, self.steer_width);
        let sign = steer * reciprocal_root(size);
        // what the path angle is short of ψ̇ L/V
        let lag = path - path_angle;
        let slip = steer - path_angle;

        let cross = self.cross * steer_rate * (tangent * tangent);
        let gravity = self.gravity * (sin_roll - roll);
        let gyro = self.gyro * (secant - one) * (yaw_rate + steer_rate);
        let kink = self.radius * sin_roll;
        let bow = sin_steer.mul_add(cos_roll, -steer);
        let contact = self.contact * bow.mul_add(self.trail, sin_steer * kink * sign);
        let roll_rest = cross + gravity + gyro - contact;

        // side force over load: weight, cornering, camber on one arm, (9) as repaired
        let linear_slip = slip - lag;
        let side = sin_gamma + self.cornering * slip - self.camber * gamma;
        let linear_side = (one - self.camber).mul_add(gamma, self.cornering * linear_slip);
        let wheel = self.wheel * (sin_gamma - gamma);
        let turning = self.turning * (tangent - steer);
        let arm = self.trail * self.load * side.mul_add(cos_roll, -linear_side);
        Rest {
            smooth: [roll_rest, -(wheel + turning + arm), self.yaw * lag],
            sign_torque: -(kink * self.front_load * side),
        }
    }
}
