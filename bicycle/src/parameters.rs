//! The one parameter table. Names, units, nominal values, ranges and sources stand here and
//! nowhere else.

use crate::mass::{self, Body, Lumps};
use crate::quantity::rows;
use crate::real::Real;
use crate::state::State;

/// The paper's bicycle with a rider of 75 kg and 1.78 m: the nominal lumps.
const NOMINAL: Lumps = mass::compose(&[mass::PAPER_BICYCLE, mass::rider(75.0, 1.78)]);
const DEGREE: f64 = std::f64::consts::PI / 180.0;

rows! {
    /// The parameters, SI. The lumps (`total_mass` to `cross_inertia`) describe bicycle and rider
    /// **without** load, inertias about the rear contact point; the load has rows of its own and
    /// is added by [`crate::mass::loaded`].
    Parameters;
    Tunable {
        total_mass: "M" KG = NOMINAL.total_mass, in [5.0, 250.0], "Mass of bicycle and rider", "composition: the paper's bicycle (17.5 kg, Table 4) and a rider of 75 kg (Table 6)";
        cog_to_rear: "L_1" M = NOMINAL.cog_to_rear, in [0.05, 1.0], "Centre of mass, forward of the rear contact", "composition; the paper's Table 3 sweeps .68, .52, .37 m";
        cog_height: "h" M = NOMINAL.cog_height, in [0.2, 1.5], "Centre of mass above the ground", "composition";
        roll_inertia: "I_xx" KG_M2 = NOMINAL.roll_inertia, in [0.1, 1000.0], "Roll inertia about the rear contact", "composition";
        yaw_inertia: "I_zz" KG_M2 = NOMINAL.yaw_inertia, in [0.1, 1000.0], "Yaw inertia about the rear contact", "composition";
        cross_inertia: "I_xz" KG_M2 = NOMINAL.cross_inertia, in [-500.0, 500.0], "Product of inertia Σ(I_xz + m x h) about the rear contact", "composition";
        wheelbase: "L" M = 1.015, in [0.5, 2.0], "Wheelbase, kept for every trail", "paper, Table 4 (given at trail .11 m)";
        caster_angle: "λ" RAD = 20.0 * DEGREE, in [-0.2, 0.8], "Caster angle of the steer axis from the vertical", "paper, Table 4";
        front_wheel_radius: "r_f" M = 0.308, in [0.1, 0.5], "Radius of the front wheel", "paper, Table 4";
        rear_wheel_radius: "r_r" M = 0.308, in [0.1, 0.5], "Radius of the rear wheel", "paper, Table 4";
        trail: "L_3" M = 0.085, in [-0.1, 0.2], "Mechanical trail", "paper, Table 5, step +1";
        front_wheel_mass: "m_f" KG = 1.8, in [0.5, 10.0], measured [1.5, 3.5], "Mass of the front wheel (not the whipple formulations)", "Moore 2012, BicycleParameters data: 1.5–3.5 kg";
        steer_inertia: "I_h" KG_M2 = 0.14, in [0.001, 1.0], measured [0.07, 0.25], "Inertia of the steering assembly about the steer axis; that of the whipple formulations follows from the front assembly", "Moore 2012, measured bicycles .07–.25 (the paper's Table 4 prints .00181)";
        front_assembly_mass: "m_A" KG = 5.24, in [0.5, 30.0], "Mass of fork, bar and front wheel (whipple formulations)", "Batavus Browser, BicycleParameters data";
        front_assembly_x: "x_A" M = 0.859, in [0.0, 2.0], "Centre of mass of the front assembly, forward of the rear contact (whipple formulations)", "Batavus Browser: .156 m behind the front contact";
        front_assembly_h: "h_A" M = 0.592, in [0.1, 1.5], "Centre of mass of the front assembly above the ground (whipple formulations)", "Batavus Browser, BicycleParameters data";
        front_assembly_inertia_xx: "I_Axx" KG_M2 = 0.545, in [0.001, 10.0], "Roll inertia of the front assembly about its centre of mass (whipple formulations)", "Batavus Browser, BicycleParameters data";
        front_assembly_inertia_xz: "I_Axz" KG_M2 = -0.200, in [-5.0, 5.0], "Product of inertia of the front assembly about its centre of mass, sign as in Σ(I_xz + m x h) (whipple formulations)", "Batavus Browser, BicycleParameters data";
        front_assembly_inertia_zz: "I_Azz" KG_M2 = 0.264, in [0.001, 10.0], "Yaw inertia of the front assembly about its centre of mass (whipple formulations)", "Batavus Browser, BicycleParameters data";
        front_wheel_inertia: "I_f" KG_M2 = 0.11, in [0.01, 1.0], measured [0.08, 0.19], "Spin inertia of the front wheel", "Moore 2012, measured bicycles .08–.19";
        rear_wheel_inertia: "I_r" KG_M2 = 0.13, in [0.01, 1.0], measured [0.08, 0.20], "Spin inertia of the rear wheel", "Moore 2012, measured bicycles .08–.20";
        cornering_stiffness: "C_θ" PER_RAD = 14.0, in [2.0, 40.0], measured [8.0, 18.0], "Front cornering stiffness per normal load (not whipple)", "Dressel 2013: 11.46; Dell'Orto 2024: 9.5–16.8; VTI: 17.2";
        camber_stiffness: "C_φ" PER_RAD = 0.8, in [0.0, 3.0], measured [0.5, 1.1], "Front camber stiffness per normal load (not whipple)", "Dressel 2013: .573; Dell'Orto 2024: .60–.98";
        rear_cornering_stiffness: "C_θR" PER_RAD = 14.0, in [2.0, 40.0], measured [8.0, 18.0], "Rear cornering stiffness per normal load (whipple_slip)", "as cornering_stiffness";
        rear_camber_stiffness: "C_φR" PER_RAD = 0.8, in [0.0, 3.0], measured [0.5, 1.1], "Rear camber stiffness per normal load (whipple_slip)", "as camber_stiffness";
        viscous_friction: "c" N_M_S_PER_RAD = 0.30, in [0.0, 5.0], measured [0.2, 0.4], "Viscous friction of the steering", "Moore 2012: .34 ± .04; Delft steer-by-wire bicycle: .2–.3";
        coulomb_friction: "d" N_M = 0.15, in [0.0, 3.0], measured [0.1, 0.2], "Coulomb friction of the steering", "Moore 2012: .15 ± .05; Delft steer-by-wire firmware: .2";
        steer_smoothing: "ε_θ" RAD = 1e-3, in [0.0, 0.1], "Width over which sign θ is smoothed, 0 the jump (not the whipple formulations)", "identified: error on bounded rides 3e-4 rad in the median, on the nine cases up to 4e-3 rad";
        steer_rate_smoothing: "ε_θ̇" RAD_PER_S = 1e-2, in [0.0, 1.0], "Width over which sign θ̇ is smoothed, 0 the jump", "identified: error on bounded rides 3e-4 rad in the median, on the nine cases up to 4e-3 rad";
        steer_limit: "θ_max" RAD = 85.0 * DEGREE, in [10.0 * DEGREE, 89.0 * DEGREE], "Steer angle at which a simulation ends", "assumed: 90° of the paper is a singular barrier of (8) and (9)";
        rear_load: "m_l" KG = 0.0, in [0.0, 100.0], "Mass on the rear carrier", "composition";
        rear_load_x: "x_l" M = -0.02, in [-1.0, 1.0], "Load, forward of the rear contact", "assumed: box .40 × .30 × .25 m on the carrier";
        rear_load_h: "h_l" M = 0.80, in [0.1, 2.0], "Load above the ground", "assumed: box .40 × .30 × .25 m on the carrier";
        rear_load_roll_gyration: "k_xx" M = 0.1127, in [0.0, 1.0], "Radius of gyration of the load about its own roll axis", "assumed: box .40 × .30 × .25 m, √((.30² + .25²)/12)";
        rear_load_yaw_gyration: "k_zz" M = 0.1443, in [0.0, 1.0], "Radius of gyration of the load about its own yaw axis", "assumed: box .40 × .30 × .25 m, √((.40² + .30²)/12)";
        gravity: "g" M_PER_S2 = 9.81, in [1.0, 30.0], "Gravitational acceleration", "standard";
        rider_roll_gain: "k_φ" N_M_PER_RAD = 400.0, in [-2000.0, 2000.0], "Rider law: torque against roll", "identified: the nominal bicycle is stable at trails .13, .085, −.035 with 0–30 kg";
        rider_roll_rate_gain: "k_p" N_M_S_PER_RAD = 120.0, in [-1000.0, 1000.0], "Rider law: torque against roll rate", "identified: as rider_roll_gain";
        rider_steer_gain: "k_θ" N_M_PER_RAD = 60.0, in [-1000.0, 1000.0], "Rider law: torque against steer; 0 in the paper's law", "identified: as rider_roll_gain";
        rider_steer_rate_gain: "k_w" N_M_S_PER_RAD = 6.0, in [-100.0, 100.0], "Rider law: torque against steer rate; 0 in the paper's law", "identified: as rider_roll_gain";
        rider_roll_gain_slope: "k_φ'" N_S_PER_RAD = 0.0, in [-1000.0, 1000.0], "Change of rider_roll_gain with speed", "assumed: the paper's law does not depend on speed";
        rider_roll_rate_gain_slope: "k_p'" N_S2_PER_RAD = 0.0, in [-1000.0, 1000.0], "Change of rider_roll_rate_gain with speed", "assumed: the paper's law does not depend on speed";
        rider_steer_gain_slope: "k_θ'" N_S_PER_RAD = 0.0, in [-1000.0, 1000.0], "Change of rider_steer_gain with speed", "assumed: the paper's law does not depend on speed";
        rider_steer_rate_gain_slope: "k_w'" N_S2_PER_RAD = 0.0, in [-1000.0, 1000.0], "Change of rider_steer_rate_gain with speed", "assumed: the paper's law does not depend on speed";
    }
    Fixed {
        relaxation_length: "σ" M = 0.175, in [0.0, 1.0], measured [0.1, 0.3], "Distance over which a tyre builds its force up, 0 at once (whipple_slip)", "Dressel 2013; VTI: .1–.3";
        internal_step: "Δ" S = 1e-3, in [1e-5, 5e-3], "Step of the internal grid", "assumed: error of the smoothed model 1.4e-4 rad at worst on bounded rides";
        roll_rate_start: "φ̇_0" RAD_PER_S = 0.0, in [-10.0, 10.0], "Roll rate at the start", "paper, Table 2: 0";
        steer_rate_start: "θ̇_0" RAD_PER_S = 0.0, in [-50.0, 50.0], "Steer rate at the start", "paper, Table 2: 0";
        roll_start: "φ_0" RAD = 0.0, in [-1.5, 1.5], "Roll angle at the start", "assumed: upright (Table 2: −5° in the nine cases)";
        steer_start: "θ_0" RAD = 0.0, in [-1.5, 1.5], "Steer angle at the start", "assumed: straight (Table 2: 1° in the nine cases)";
        yaw_rate_start: "ψ̇_0" RAD_PER_S = 0.0, in [-10.0, 10.0], "Yaw rate at the start; in whipple it follows from the steering", "assumed: straight (Table 2: 2 rad/s in the nine cases)";
    }
}

rows! {
    /// What excites a ride when nobody measured the torque, and the friction that such a ride
    /// knows. Not parameters of the bicycle: no equation of motion reads them.
    Excitation;
    Fixed {
        remnant_intensity: "σ_τ" N_M = 0.0, in [0.0, 20.0], "Remnant of the rider: torque noise, rms", "identified: free in every spectral fit";
        remnant_corner: "f_τ" HZ = 2.0, in [0.2, 10.0], "Corner of the remnant's first-order low-pass", "assumed: reported with every spectral fit";
        effective_damping: "c_eff" N_M_S_PER_RAD = 0.5, in [0.0, 10.0], measured [0.2, 1.0], "Viscous friction with the mean gain of the Coulomb friction, c + √(2/π) d/σ_θ̇", "identified: what a steering spectrum knows of friction";
    }
}

rows! {
    /// How a recording shows what happened: recorded = gain · true + offset. Not parameters of the
    /// bicycle: no equation of motion reads them; a record of several seconds hardly does without.
    Instruments;
    Fixed {
        torque_gain: "k_τ" ONE = 1.0, in [0.1, 10.0], measured [0.8, 1.2], "Recorded steer torque over the true one", "identified: free where asked for; 1.2 explains the torque of the hand recorded on the Delft steer-by-wire bicycle better than 1";
        torque_offset: "τ_0" N_M = 0.0, in [-20.0, 20.0], "Steer torque recorded where there is none", "identified: free where asked for";
        roll_rate_offset: "φ̇_b" RAD_PER_S = 0.0, in [-1.0, 1.0], "Roll rate recorded at rest", "identified: free where asked for";
        steer_rate_offset: "θ̇_b" RAD_PER_S = 0.0, in [-1.0, 1.0], "Steer rate recorded at rest", "identified: free where asked for";
        roll_offset: "φ_b" RAD = 0.0, in [-0.5, 0.5], "Roll angle recorded upright", "identified: free where asked for";
        steer_offset: "θ_b" RAD = 0.0, in [-0.5, 0.5], "Steer angle recorded straight ahead", "identified: free where asked for";
        yaw_rate_offset: "ψ̇_b" RAD_PER_S = 0.0, in [-1.0, 1.0], "Yaw rate recorded at rest", "identified: free where asked for";
    }
}

impl<T: Real> Parameters<T> {
    /// The state of the `*_start` rows. Tyres start unloaded, the rear contact straight ahead.
    pub fn start(&self) -> State<T> {
        State {
            roll_rate: self.roll_rate_start,
            steer_rate: self.steer_rate_start,
            roll: self.roll_start,
            steer: self.steer_start,
            yaw_rate: self.yaw_rate_start,
            ..State::ZERO.map(T::from)
        }
    }

    /// The same bicycle with a rider who holds still: no steering law.
    #[must_use]
    pub fn riderless(&self) -> Self {
        let none = T::from(0.0);
        Self {
            rider_roll_gain: none,
            rider_roll_rate_gain: none,
            rider_steer_gain: none,
            rider_steer_rate_gain: none,
            rider_roll_gain_slope: none,
            rider_roll_rate_gain_slope: none,
            rider_steer_gain_slope: none,
            rider_steer_rate_gain_slope: none,
            ..*self
        }
    }

    /// The same bicycle with a rider who steers by roll [N m/rad] and roll rate [N m s/rad] alone.
    #[must_use]
    pub fn steered_by_roll(&self, roll_gain: f64, roll_rate_gain: f64) -> Self {
        Self {
            rider_roll_gain: T::from(roll_gain),
            rider_roll_rate_gain: T::from(roll_rate_gain),
            ..self.riderless()
        }
    }
}

impl<T: Copy> Parameters<T> {
    /// Fork, bar and front wheel.
    pub fn front_assembly(&self) -> Body<T> {
        Body {
            mass: self.front_assembly_mass,
            x: self.front_assembly_x,
            h: self.front_assembly_h,
            roll_inertia: self.front_assembly_inertia_xx,
            yaw_inertia: self.front_assembly_inertia_zz,
            cross_inertia: self.front_assembly_inertia_xz,
        }
    }

    /// Replaces fork, bar and front wheel.
    pub fn set_front_assembly(&mut self, body: Body<T>) {
        self.front_assembly_mass = body.mass;
        self.front_assembly_x = body.x;
        self.front_assembly_h = body.h;
        self.front_assembly_inertia_xx = body.roll_inertia;
        self.front_assembly_inertia_zz = body.yaw_inertia;
        self.front_assembly_inertia_xz = body.cross_inertia;
    }

    /// The six lumps of bicycle and rider, without load.
    pub fn lumps(&self) -> Lumps<T> {
        Lumps {
            total_mass: self.total_mass,
            cog_to_rear: self.cog_to_rear,
            cog_height: self.cog_height,
            roll_inertia: self.roll_inertia,
            yaw_inertia: self.yaw_inertia,
            cross_inertia: self.cross_inertia,
        }
    }

    /// Replaces the six lumps of bicycle and rider.
    pub fn set_lumps(&mut self, lumps: Lumps<T>) {
        self.total_mass = lumps.total_mass;
        self.cog_to_rear = lumps.cog_to_rear;
        self.cog_height = lumps.cog_height;
        self.roll_inertia = lumps.roll_inertia;
        self.yaw_inertia = lumps.yaw_inertia;
        self.cross_inertia = lumps.cross_inertia;
    }
}
