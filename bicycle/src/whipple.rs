//! The four-body bicycle of Whipple and Carvallo, linear about upright: without slip (`whipple`)
//! and with side-slip tyres (`whipple_slip`).
//!
//! Meijaard, Papadopoulos, Ruina, Schwab 2007 (Proc. R. Soc. A 463:1955), appendix A, below "(A n)".
//! **Literature's signs**: z down, so `v_y`, yaw rate r, steer δ and its torque are right positive.
//! The marked door are the functions that take a [`State`]: these take and give ISO 8855; the matrices
//! are the literature's, number for number. With tyres (extended here by
//! camber thrust and friction as in (5), (6) and (9)):
//!
//! ```text
//! M q̈ + D(v) q̇ + K (φ, δ) = (1, 0, 0, 0)ᵀ F_R + (1, w, 0, −c cos λ)ᵀ F_F + (0, 0, T_φ, T_δ)ᵀ
//! q̇ = (v_y, r, φ̇, δ̇)
//! ```

use crate::dynamics::{Bicycle, Formulation, Nonlinear, steering_torque};
use crate::mass::Lumps;
use crate::parameters::Parameters;
use crate::real::Real;
use crate::state::{Input, State};
use crate::tyre;

/// A square matrix, rows first.
pub type Matrix<T, const N: usize> = [[T; N]; N];

/// The constants of the four-body bicycle, literature's symbols and signs.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FourBodies<T = f64> {
    /// M of q̈ = (v̇_y, ṙ, φ̈, δ̈) [kg, kg m, kg m²].
    pub mass_with_slip: Matrix<T, 4>,
    /// M of (φ̈, δ̈) without slip, (A 20) [kg m²].
    pub mass: Matrix<T, 2>,
    /// `C_1` of v (φ̇, δ̇) without slip, (A 24) [kg m].
    pub damping: Matrix<T, 2>,
    /// `K_0` of g (φ, δ), (A 22) [kg m].
    pub stiffness: Matrix<T, 2>,
    /// `K_2` of v² (φ, δ) without slip, (A 23) [kg].
    pub speed_stiffness: Matrix<T, 2>,
    /// `S_F = I_Fyy/r_F`, gyrostatic coefficient of the front wheel [kg m].
    pub front_spin: T,
    /// `S_T = S_R + S_F`, of both wheels [kg m].
    pub total_spin: T,
    /// `I_Aλλ`, inertia of the front assembly about the steer axis [kg m²].
    pub steer_inertia: T,
    inverse_with_slip: Matrix<T, 4>,
    inverse: Matrix<T, 2>,
    trail: T,
    wheelbase: T,
    sin: T,
    cos: T,
}

impl<T: Real> FourBodies<T> {
    /// The constants of `p`, its bodies with the load on board being `lumps`.
    pub fn new(p: &Parameters<T>, lumps: &Lumps<T>) -> Self {
        let (w, c) = (p.wheelbase, p.trail);
        let (sin, cos) = p.caster_angle.sin_cos();
        // (A 1)–(A 5): the whole, about the rear contact
        let (m_t, x_t, z_t) = (lumps.total_mass, lumps.cog_to_rear, -lumps.cog_height);
        let (i_txx, i_tzz, i_txz) = (lumps.roll_inertia, lumps.yaw_inertia, lumps.cross_inertia);
        // (A 6)–(A 13): the front assembly, about the steer axis
        let a = p.front_assembly();
        let (m_a, x_a, z_a) = (a.mass, a.x, -a.h);
        let u_a = (x_a - w - c) * cos - z_a * sin;
        let i_all = m_a * u_a * u_a
            + a.roll_inertia * sin * sin
            + T::from(2.0) * a.cross_inertia * sin * cos
            + a.yaw_inertia * cos * cos;
        let i_alx = -(m_a * u_a * z_a) + a.roll_inertia * sin + a.cross_inertia * cos;
        let i_alz = m_a * u_a * x_a + a.cross_inertia * sin + a.yaw_inertia * cos;
        // (A 14)–(A 19)
        let mu = c / w * cos;
        let s_f = p.front_wheel_inertia / p.front_wheel_radius;
        let s_t = p.rear_wheel_inertia / p.rear_wheel_radius + s_f;
        let s_a = m_a * u_a + mu * m_t * x_t;

        let m_phi_delta = i_alx + mu * i_txz;
        let m_delta_delta = i_all + (mu + mu) * i_alz + mu * mu * i_tzz;
        let mass = [[i_txx, m_phi_delta], [m_phi_delta, m_delta_delta]];
        let nil = T::from(0.0);
        let damping = [
            [nil, mu * s_t + s_f * cos + i_txz / w * cos - mu * m_t * z_t],
            [
                -(mu * s_t + s_f * cos),
                i_alz / w * cos + mu * (s_a + i_tzz / w * cos),
            ],
        ];
        let stiffness = [[m_t * z_t, -s_a], [-s_a, -(s_a * sin)]];
        let speed_stiffness = [
            [nil, (s_t - m_t * z_t) / w * cos],
            [nil, (s_a + s_f * sin) / w * cos],
        ];
        let mass_with_slip = [
            [m_t, m_t * x_t, -(m_t * z_t), m_a * u_a],
            [m_t * x_t, i_tzz, i_txz, i_alz],
            [-(m_t * z_t), i_txz, i_txx, i_alx],
            [m_a * u_a, i_alz, i_alx, i_all],
        ];
        Self {
            mass_with_slip,
            mass,
            damping,
            stiffness,
            speed_stiffness,
            front_spin: s_f,
            total_spin: s_t,
            steer_inertia: i_all,
            inverse_with_slip: inverse(mass_with_slip),
            inverse: inverse(mass),
            trail: c,
            wheelbase: w,
            sin,
            cos,
        }
    }

    /// Torques of the spinning wheels, on the left of the equations: the gyroscopic part of
    /// D(v) q̇. It does no work.
    #[inline(always)]
    pub fn gyroscopic(&self, v: T, [_, r, phi_rate, delta_rate]: [T; 4]) -> [T; 4] {
        let (s_t, s_f) = (self.total_spin, self.front_spin);
        [
            T::from(0.0),
            -(v * s_t * phi_rate) - v * s_f * self.sin * delta_rate,
            s_t * v * r + v * s_f * self.cos * delta_rate,
            s_f * self.sin * v * r - v * s_f * self.cos * phi_rate,
        ]
    }

    /// What the frame's turning at r adds to the accelerations: the other part of D(v) q̇,
    /// the first column of M times v r.
    #[inline(always)]
    pub fn centripetal(&self, v: T, r: T) -> [T; 4] {
        self.mass_with_slip.map(|row| row[0] * v * r)
    }

    /// Yaw rate r [rad/s] of wheels that do not slip.   `r = (v δ + c δ̇) cos λ/w`
    #[inline(always)]
    fn rolling(&self, v: T, delta: T, delta_rate: T) -> T {
        (v * delta + self.trail * delta_rate) * self.cos / self.wheelbase
    }

    /// Yaw rate ψ̇ [rad/s], left positive, of wheels that do not slip.
    pub fn yaw_rate(&self, x: &State<T>, speed: T) -> T {
        // r of (δ, δ̇) is linear: the signs of both sides turn together
        self.rolling(speed, x.steer, x.steer_rate)
    }

    /// Lateral forces of the rear and the front tyre [N], left positive, where nothing slips: what
    /// the first two rows of the equations with slip need for a motion without.
    pub fn constraint_forces(&self, x: &State<T>, acceleration: &State<T>, v: T) -> [T; 2] {
        let (delta_rate, delta_acceleration) = (-x.steer_rate, -acceleration.steer_rate);
        let r = self.rolling(v, -x.steer, delta_rate);
        let motion = [
            T::from(0.0),
            self.rolling(v, delta_rate, delta_acceleration),
            acceleration.roll_rate,
            delta_acceleration,
        ];
        let inertial = product(&self.mass_with_slip, motion);
        let centripetal = self.centripetal(v, r);
        let gyroscopic = self.gyroscopic(v, [motion[0], r, x.roll_rate, delta_rate]);
        let front = (inertial[1] + centripetal[1] + gyroscopic[1]) / self.wheelbase;
        let rear = inertial[0] + centripetal[0] - front;
        [-rear, -front]
    }

    /// Time derivative of the state, ISO 8855 in and out.
    #[inline(always)]
    pub fn rate(&self, b: &Bicycle<T>, x: &State<T>, u: &Input<T>, n: &Nonlinear<T>) -> State<T> {
        // the door: literature's signs from here
        let v = u.speed;
        let (phi, delta) = (x.roll, -x.steer);
        let (phi_rate, delta_rate) = (x.roll_rate, -x.steer_rate);
        let (t_phi, t_delta) = (u.roll_moment, -steering_torque(b, x, u, n));

        let [k_phi, k_delta] = product(&self.stiffness, [phi, delta]);
        let weight = [b.p.gravity * k_phi, b.p.gravity * k_delta];
        let nil = T::from(0.0);
        if b.formulation == Formulation::WhippleSlip {
            let [rear, front] = tyre::forces(b, x, v);
            let (f_r, f_f) = (-rear, -front);
            let rates = [-x.lateral_velocity, -x.yaw_rate, phi_rate, delta_rate];
            let gyroscopic = self.gyroscopic(v, rates);
            let centripetal = self.centripetal(v, rates[1]);
            let right = [
                f_r + f_f,
                self.wheelbase * f_f,
                t_phi - weight[0],
                t_delta - weight[1] - self.trail * self.cos * f_f,
            ];
            let rest = std::array::from_fn(|i| right[i] - gyroscopic[i] - centripetal[i]);
            let [vy, r, phi, delta] = product(&self.inverse_with_slip, rest);
            let [front_rate, rear_rate] = tyre::force_rates(b, x, v);
            State {
                roll_rate: phi,
                steer_rate: -delta,
                roll: x.roll_rate,
                steer: x.steer_rate,
                yaw_rate: -r,
                lateral_velocity: -vy,
                front_lateral_force: front_rate,
                rear_lateral_force: rear_rate,
            }
        } else {
            let [c_phi, c_delta] = product(&self.damping, [phi_rate, delta_rate]);
            let [k2_phi, k2_delta] = product(&self.speed_stiffness, [phi, delta]);
            let rest = [
                t_phi - v * c_phi - weight[0] - v * v * k2_phi,
                t_delta - v * c_delta - weight[1] - v * v * k2_delta,
            ];
            let [phi, delta] = product(&self.inverse, rest);
            State {
                roll_rate: phi,
                steer_rate: -delta,
                roll: x.roll_rate,
                steer: x.steer_rate,
                yaw_rate: nil,
                lateral_velocity: nil,
                front_lateral_force: nil,
                rear_lateral_force: nil,
            }
        }
    }
}

#[inline(always)]
fn product<T: Real, const N: usize>(m: &Matrix<T, N>, x: [T; N]) -> [T; N] {
    m.map(|row| {
        let mut sum = row[0] * x[0];
        for j in 1..N {
            sum = sum + row[j] * x[j];
        }
        sum
    })
}

/// Inverse of a symmetric positive definite matrix: Gauss–Jordan, which needs no pivoting then.
/// (nalgebra's asks for more of a scalar than the equations do.)
fn inverse<T: Real, const N: usize>(mut m: Matrix<T, N>) -> Matrix<T, N> {
    for k in 0..N {
        let pivot = T::from(1.0) / m[k][k];
        m[k][k] = T::from(1.0);
        m[k] = m[k].map(|v| v * pivot);
        let above = m[k];
        for (_, row) in m.iter_mut().enumerate().filter(|(i, _)| *i != k) {
            let factor = row[k];
            row[k] = T::from(0.0);
            for (v, a) in row.iter_mut().zip(above) {
                *v = *v - factor * a;
            }
        }
    }
    m
}
