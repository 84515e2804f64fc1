//! The equations of motion (7)–(9), one function each, and what they are assembled into; which
//! formulation moves the bicycle is decided here.
//!
//! A formulation branches inside the terms it changes. `EQUATIONS.md` holds every deviation from
//! the printed equations against its reason and its test.

mod seen;

pub use seen::{output, output_with, path_derivative};

use crate::mass::{self, Lumps};
use crate::parameters::Parameters;
use crate::real::{Real, sign};
use crate::rider;
use crate::state::{Derived, Input, State};
use crate::tyre;
use crate::whipple::FourBodies;
use serde::{Deserialize, Serialize};

/// By which equations the bicycle moves: one of three readings of the paper's, or the four-body
/// bicycle of the literature.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Formulation {
    /// Literally as printed.
    Printed,
    /// The two repairs without which nothing moves as described: `I_zz` once in (7), no `I_xx` in (9).
    Minimal,
    /// All repairs: passes the dimension law and the mirror law.
    #[default]
    Repaired,
    /// The linear four-body bicycle of Whipple and Carvallo, whose wheels do not slip.
    Whipple,
    /// The same with slipping tyres front and rear.
    WhippleSlip,
}

impl Formulation {
    /// Every formulation, in the order of the FMU's enumeration.
    pub const ALL: [Self; 5] = [
        Self::Printed,
        Self::Minimal,
        Self::Repaired,
        Self::Whipple,
        Self::WhippleSlip,
    ];

    /// The name in files, on the command line and in the FMU.
    pub fn name(self) -> &'static str {
        match self {
            Self::Printed => "printed",
            Self::Minimal => "minimal",
            Self::Repaired => "repaired",
            Self::Whipple => "whipple",
            Self::WhippleSlip => "whipple_slip",
        }
    }

    /// Whether it is one of the four-body bicycle, linear about upright.
    pub fn has_four_bodies(self) -> bool {
        matches!(self, Self::Whipple | Self::WhippleSlip)
    }

    /// What it is, in a sentence.
    pub fn what(self) -> &'static str {
        match self {
            Self::Printed => "the paper's equations literally as printed",
            Self::Minimal => "I_zz once in (7) and no I_xx in (9), all else as printed",
            Self::Repaired => "all repairs: dimensions and mirror symmetry hold",
            Self::Whipple => "the linear four-body bicycle (Whipple, Carvallo), no wheel slips",
            Self::WhippleSlip => "the four-body bicycle with slipping tyres front and rear",
        }
    }
}

impl std::str::FromStr for Formulation {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        Self::ALL
            .into_iter()
            .find(|f| f.name() == text)
            .ok_or_else(|| {
                let names = Self::ALL.map(Self::name).join(", ");
                format!("expected a formulation ({names}), found '{text}'")
            })
    }
}

/// Parameters made ready for the equations: the load on board, constants of the geometry.
#[derive(Debug, Clone, Copy)]
pub struct Bicycle<T = f64> {
    /// The parameters as given.
    pub p: Parameters<T>,
    /// How the equations are read.
    pub formulation: Formulation,
    /// Bicycle, rider and load as one.
    pub lumps: Lumps<T>,
    /// `F_z = M g L_1/L`, front normal load [N].
    pub front_load: T,
    /// sin λ.
    pub sin_caster: T,
    /// cos λ.
    pub cos_caster: T,
    /// `f = r_f sin λ − L_3 cos λ`, fork offset [m].
    pub fork_offset: T,
    /// Rear normal load [N].
    pub rear_wheel_load: T,
    /// The inertia on the left of (9), or `I_Aλλ` of the four-body bicycle [kg m²].
    pub steering_inertia: T,
    /// The four-body bicycle, where the formulation asks for it.
    pub four_bodies: Option<FourBodies<T>>,
    /// Whether the tyres take a distance to build their force up.
    pub relaxes: bool,
}

impl<T: Real> Bicycle<T> {
    /// Folds the load into the lumps and evaluates what does not move.
    pub fn new(p: &Parameters<T>, formulation: Formulation) -> Self {
        let lumps = mass::loaded(p);
        let (sin_caster, cos_caster) = p.caster_angle.sin_cos();
        let wheel = p.front_wheel_mass * p.trail * p.trail;
        let front_load = lumps.total_mass * p.gravity * lumps.cog_to_rear / p.wheelbase;
        let four_bodies = formulation
            .has_four_bodies()
            .then(|| FourBodies::new(p, &lumps));
        let steering_inertia = match (&four_bodies, formulation) {
            (Some(bodies), _) => bodies.steer_inertia,
            (None, Formulation::Printed) => p.steer_inertia + lumps.roll_inertia + wheel,
            (None, _) => p.steer_inertia + wheel,
        };
        Self {
            p: *p,
            formulation,
            lumps,
            front_load,
            rear_wheel_load: lumps.total_mass * p.gravity - front_load,
            sin_caster,
            cos_caster,
            fork_offset: p.front_wheel_radius * sin_caster - p.trail * cos_caster,
            steering_inertia,
            four_bodies,
            relaxes: formulation == Formulation::WhippleSlip && !p.relaxation_length.is_zero(),
        }
    }

    /// How many rows of the state, from the first on, move by differential equations. The others
    /// are carried along unchanged.
    pub fn order(&self) -> usize {
        match self.formulation {
            Formulation::Printed | Formulation::Minimal | Formulation::Repaired => 5,
            Formulation::Whipple => 4,
            Formulation::WhippleSlip if self.relaxes => 8,
            Formulation::WhippleSlip => 6,
        }
    }

    /// Yaw rate ψ̇ [rad/s]: a state, or where the wheels do not slip a consequence of the steering.
    pub fn yaw_rate(&self, x: &State<T>, speed: T) -> T {
        match (&self.four_bodies, self.formulation) {
            (Some(bodies), Formulation::Whipple) => bodies.yaw_rate(x, speed),
            _ => x.yaw_rate,
        }
    }

    /// What follows from the parameters alone.
    pub fn derived(&self) -> Derived<T> {
        Derived {
            fork_offset: self.fork_offset,
            loaded_mass: self.lumps.total_mass,
            loaded_cog_to_rear: self.lumps.cog_to_rear,
            loaded_cog_height: self.lumps.cog_height,
            loaded_roll_inertia: self.lumps.roll_inertia,
            loaded_yaw_inertia: self.lumps.yaw_inertia,
            loaded_cross_inertia: self.lumps.cross_inertia,
        }
    }
}

/// The three terms that are not smooth or not nearly linear in riding. The equations take them
/// from outside, so that an estimator can put a mean gain in their place.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Nonlinear<T> {
    /// sign θ in (2).
    pub steer_sign: T,
    /// sign θ̇ in (9).
    pub steer_rate_sign: T,
    /// atan(ψ̇ L/V) [rad] in (4).
    pub path_angle: T,
}

impl<T: Real> Nonlinear<T> {
    /// Their values at a state.
    #[inline(always)]
    pub fn at(b: &Bicycle<T>, x: &State<T>, speed: T) -> Self {
        Self {
            steer_sign: sign(x.steer, b.p.steer_smoothing),
            steer_rate_sign: sign(x.steer_rate, b.p.steer_rate_smoothing),
            path_angle: tyre::path_angle(b, speed, x.yaw_rate),
        }
    }
}

/// Sines and cosines at a state: several terms ask for the same ones, and they are most of the
/// work.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Angles<T> {
    /// sin φ.
    pub sin_roll: T,
    /// cos φ.
    pub cos_roll: T,
    /// sin θ.
    pub sin_steer: T,
    /// cos θ.
    pub cos_steer: T,
}

impl<T: Real> Angles<T> {
    /// Those of the roll and the steer angle.
    #[inline(always)]
    pub fn at(x: &State<T>) -> Self {
        let (sin_roll, cos_roll) = x.roll.sin_cos();
        let (sin_steer, cos_steer) = x.steer.sin_cos();
        Self {
            sin_roll,
            cos_roll,
            sin_steer,
            cos_steer,
        }
    }
}

/// Yaw acceleration ψ̈ [rad/s²], (7).
///
/// printed `I_zz ψ̈ = (L F_z/I_zz) C_θ β − C_φ (φ + θ sin λ)`;
/// repaired `I_zz ψ̈ = L F_z C_θ β − L F_z C_φ (φ − θ sin λ)`
#[inline(always)]
pub fn yaw_acceleration<T: Real>(b: &Bicycle<T>, x: &State<T>, n: &Nonlinear<T>) -> T {
    let i_zz = b.lumps.yaw_inertia;
    let beta = tyre::slip_angle(x.steer, n.path_angle);
    let cornering = b.p.wheelbase * tyre::lateral_force(b, beta);
    let cornering = match b.formulation {
        Formulation::Printed => cornering / i_zz,
        _ => cornering,
    };
    let camber = match b.formulation {
        Formulation::Printed | Formulation::Minimal => {
            b.p.camber_stiffness * tyre::camber_angle(b, x)
        }
        _ => b.p.wheelbase * tyre::camber_thrust(b, x),
    };
    (cornering - camber) / i_zz
}

/// Roll acceleration φ̈ [rad/s²], (8), with the roll moment of the inputs added.
///
/// `I_xx φ̈ = I_xz θ̇ V/(L cos²θ) + M g h sin φ + I_r ψ̇ V/r_r + M h V² tan(θ−β)/(L_1+L_2)`
/// `         + I_f sec θ (V/r_f)(ψ̇ + θ̇) − M g (L_1 sin θ/(L_1+L_2)) L_3'`
///
/// `L_1 + L_2 = L`, and `V tan(θ−β)/L = ψ̇` by (3).
#[inline(always)]
pub fn roll_acceleration<T: Real>(
    b: &Bicycle<T>,
    x: &State<T>,
    u: &Input<T>,
    n: &Nonlinear<T>,
    a: &Angles<T>,
) -> T {
    let (p, m, v) = (&b.p, &b.lumps, u.speed);
    let (sin_steer, cos_steer) = (a.sin_steer, a.cos_steer);
    let cross = m.cross_inertia * x.steer_rate * v / (p.wheelbase * cos_steer * cos_steer);
    let gravity = m.total_mass * p.gravity * m.cog_height * a.sin_roll;
    let rear_gyro = p.rear_wheel_inertia * x.yaw_rate * v / p.rear_wheel_radius;
    let centrifugal = m.total_mass * m.cog_height * v * x.yaw_rate;
    let front_gyro = p.front_wheel_inertia / cos_steer
        * (v / p.front_wheel_radius)
        * (x.yaw_rate + x.steer_rate);
    let contact = b.front_load * sin_steer * tyre::effective_trail(b, a, n.steer_sign);
    (cross + gravity + rear_gyro + centrifugal + front_gyro - contact + u.roll_moment)
        / m.roll_inertia
}

/// Torque on the steering [N m] of rider, inputs and friction, left positive, in (9).
/// `τ_h + τ + τ_a − (c θ̇ + d sign θ̇)`
#[inline(always)]
pub fn steering_torque<T: Real>(b: &Bicycle<T>, x: &State<T>, u: &Input<T>, n: &Nonlinear<T>) -> T {
    let torque = rider::torque(&b.p, x, u.speed) + u.steer_torque + u.assist_torque;
    let friction = b.p.viscous_friction * x.steer_rate + b.p.coulomb_friction * n.steer_rate_sign;
    torque - friction
}

/// Steer acceleration θ̈ [rad/s²], (9), with the assist torque of the inputs added to `τ_h`.
///
/// printed `(I_h + I_xx + m_f L_3²) θ̈ = −m_f g f sin(φ − θ sin λ) − I_f cos λ V tan θ/(L_1+L_2) + τ_h`
/// `  − (c θ̇ + d sign θ̇) − L_3' F_z sin(φ − θ sin λ) − C_θ β F_z (L_3 cos φ + r_f sin φ)`
/// `  + C_φ (φ − θ sin λ) F_z cos φ`;
/// repaired: no `I_xx`, wheel spin `V/r_f` in the gyroscopic term, arm `L_3'` of both tyre forces.
#[inline(always)]
pub fn steer_acceleration<T: Real>(
    b: &Bicycle<T>,
    x: &State<T>,
    u: &Input<T>,
    n: &Nonlinear<T>,
    a: &Angles<T>,
) -> T {
    let (p, v) = (&b.p, u.speed);
    let gamma = x.roll - x.steer * b.sin_caster;
    let sin_gamma = gamma.sin();
    let trail = tyre::effective_trail(b, a, n.steer_sign);
    let beta = tyre::slip_angle(x.steer, n.path_angle);

    let wheel_weight = p.front_wheel_mass * p.gravity * sin_gamma * b.fork_offset;
    let turning = v * (a.sin_steer / a.cos_steer) / p.wheelbase;
    let spin = match b.formulation {
        Formulation::Printed | Formulation::Minimal => T::from(1.0),
        _ => v / p.front_wheel_radius,
    };
    let gyro = p.front_wheel_inertia * b.cos_caster * turning * spin;
    let torque = steering_torque(b, x, u, n);
    let weight = trail * b.front_load * sin_gamma;
    let cornering_arm = match b.formulation {
        Formulation::Printed | Formulation::Minimal => {
            p.trail * a.cos_roll + p.front_wheel_radius * a.sin_roll
        }
        _ => trail,
    };
    let cornering = tyre::lateral_force(b, beta) * cornering_arm;
    let camber_arm = match b.formulation {
        Formulation::Printed | Formulation::Minimal => a.cos_roll,
        _ => trail,
    };
    let camber = p.camber_stiffness * gamma * b.front_load * camber_arm;
    (torque - wheel_weight - gyro - weight - cornering + camber) / b.steering_inertia
}

/// Time derivative of the state with the nonlinear terms given.
#[inline(always)]
pub fn derivative_with<T: Real>(
    b: &Bicycle<T>,
    x: &State<T>,
    u: &Input<T>,
    n: &Nonlinear<T>,
) -> State<T> {
    rate(b, x, u, n, &Angles::at(x))
}

#[inline(always)]
fn rate<T: Real>(
    b: &Bicycle<T>,
    x: &State<T>,
    u: &Input<T>,
    n: &Nonlinear<T>,
    a: &Angles<T>,
) -> State<T> {
    if let Some(bodies) = &b.four_bodies {
        return bodies.rate(b, x, u, n);
    }
    let nil = T::from(0.0);
    State {
        roll_rate: roll_acceleration(b, x, u, n, a),
        steer_rate: steer_acceleration(b, x, u, n, a),
        roll: x.roll_rate,
        steer: x.steer_rate,
        yaw_rate: yaw_acceleration(b, x, n),
        lateral_velocity: nil,
        front_lateral_force: nil,
        rear_lateral_force: nil,
    }
}

/// Time derivative of the state.
#[inline(always)]
pub fn derivative<T: Real>(b: &Bicycle<T>, x: &State<T>, u: &Input<T>) -> State<T> {
    derivative_with(b, x, u, &Nonlinear::at(b, x, u.speed))
}
