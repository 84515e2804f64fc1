//! States, inputs and outputs: rows of the same kind as the parameters.

use crate::quantity::rows;
use std::f64::consts::TAU;

const FREE: f64 = f64::INFINITY;

rows! {
    /// The state q = [φ̇ θ̇ φ θ ψ̇] of the paper; its fifth entry is the yaw rate (Table 2 gives it
    /// in rad/s, and (7) is of first order in it). Slipping tyres add three.
    ///
    /// A formulation moves the first [`crate::Bicycle::order`] rows; the others stay what they were
    /// at the start. What is seen in their place is in [`Output`].
    State;
    Continuous {
        roll_rate: "φ̇" RAD_PER_S = 0.0, in [-FREE, FREE], "Roll rate, right positive", "state";
        steer_rate: "θ̇" RAD_PER_S = 0.0, in [-FREE, FREE], "Steer rate, left positive", "state";
        roll: "φ" RAD = 0.0, in [-FREE, FREE], "Roll angle, right positive", "state";
        steer: "θ" RAD = 0.0, in [-FREE, FREE], "Steer angle, left positive", "state";
        yaw_rate: "ψ̇" RAD_PER_S = 0.0, in [-FREE, FREE], "Yaw rate, left positive", "state";
        lateral_velocity: "v_y" M_PER_S = 0.0, in [-FREE, FREE], "Lateral velocity of the rear contact, left positive", "state of whipple_slip";
        front_lateral_force: "F_F" N = 0.0, in [-FREE, FREE], "Lateral force of the front tyre, left positive", "state of whipple_slip with a relaxation length";
        rear_lateral_force: "F_R" N = 0.0, in [-FREE, FREE], "Lateral force of the rear tyre, left positive", "state of whipple_slip with a relaxation length";
    }
}

rows! {
    /// Where the rear contact point went: ψ' = ψ̇, ẋ = V cos ψ − v_y sin ψ, ẏ = V sin ψ + v_y cos ψ.
    Path;
    Continuous {
        heading: "ψ" RAD = 0.0, in [-FREE, FREE], "Heading, left positive", "integral of the yaw rate";
        x: "x" M = 0.0, in [-FREE, FREE], "Rear contact point, forward", "ẋ = V cos ψ − v_y sin ψ";
        y: "y" M = 0.0, in [-FREE, FREE], "Rear contact point, left", "ẏ = V sin ψ + v_y cos ψ";
    }
}

rows! {
    /// What acts on the bicycle from outside.
    Input;
    Continuous {
        speed: "V" M_PER_S = 8.0 / 3.6, in [0.0, 20.0], "Forward speed; above 0 in all formulations but whipple, whose equations are those of constant speed", "paper, section 3.1: 8.0 km/h";
        steer_torque: "τ" N_M = 0.0, in [-1000.0, 1000.0], "Steer torque added to the rider law, left positive", "input; range assumed: beyond any rider";
        assist_torque: "τ_a" N_M = 0.0, in [-1000.0, 1000.0], "Steer torque of the assist motor, left positive", "input; range assumed: beyond any motor";
        roll_moment: "M_φ" N_M = 0.0, in [-10000.0, 10000.0], "Roll moment on the frame, right positive", "input; range assumed: beyond any gust";
    }
}

rows! {
    /// What can be seen of the bicycle. Angles are those of the state; `x` and `y` are the rear
    /// contact point.
    Output;
    Continuous {
        roll: "φ" RAD = 0.0, in [-FREE, FREE], "Roll angle, right positive", "state";
        steer: "θ" RAD = 0.0, in [-FREE, FREE], "Steer angle, left positive", "state";
        roll_rate: "φ̇" RAD_PER_S = 0.0, in [-FREE, FREE], "Roll rate, right positive", "state";
        steer_rate: "θ̇" RAD_PER_S = 0.0, in [-FREE, FREE], "Steer rate, left positive", "state";
        yaw_rate: "ψ̇" RAD_PER_S = 0.0, in [-FREE, FREE], "Yaw rate, left positive", "state";
        heading: "ψ" RAD = 0.0, in [-FREE, FREE], "Heading, left positive", "path";
        x: "x" M = 0.0, in [-FREE, FREE], "Rear contact point, forward", "path";
        y: "y" M = 0.0, in [-FREE, FREE], "Rear contact point, left", "path";
        slip_angle: "β" RAD = 0.0, in [-TAU, TAU], "Slip angle of the front tyre; 0 without slip (whipple)", "paper, (4)";
        camber_angle: "γ" RAD = 0.0, in [-FREE, FREE], "Camber angle of the front wheel, right positive", "paper, (6) as repaired";
        effective_trail: "L_3'" M = 0.0, in [-FREE, FREE], "Trail after the contact point has moved; it does not in the four-body formulations", "paper, (2)";
        lateral_force: "F_θ" N = 0.0, in [-FREE, FREE], "Front cornering force in steady slip, left positive; 0 without slip (whipple)", "paper, (5)";
        camber_thrust: "F_φ" N = 0.0, in [-FREE, FREE], "Front camber thrust in steady camber, right positive; 0 without slip (whipple)", "paper, (6)";
        rear_lateral_force: "F_R" N = 0.0, in [-FREE, FREE], "Lateral force of the rear tyre, left positive; 0 in the paper's formulations", "Meijaard et al. 2007 with side-slip tyres";
        lateral_velocity: "v_y" M_PER_S = 0.0, in [-FREE, FREE], "Lateral velocity of the rear contact, left positive; 0 where the rear wheel does not slip: all but whipple_slip", "state";
        front_load: "F_z" N = 0.0, in [-FREE, FREE], "Front normal load", "M g L_1/L with the load on board";
        rider_torque: "τ_h" N_M = 0.0, in [-FREE, FREE], "Steer torque of the rider law, left positive", "rider law";
        steer_acceleration: "θ̈" RAD_PER_S2 = 0.0, in [-FREE, FREE], "Steer acceleration, left positive", "paper, (9); the four-body bicycle";
        roll_acceleration: "φ̈" RAD_PER_S2 = 0.0, in [-FREE, FREE], "Roll acceleration, right positive", "paper, (8); the four-body bicycle";
        yaw_acceleration: "ψ̈" RAD_PER_S2 = 0.0, in [-FREE, FREE], "Yaw acceleration, left positive; in whipple at constant speed", "paper, (7); the four-body bicycle";
        x_rate: "ẋ" M_PER_S = 0.0, in [-FREE, FREE], "Velocity of the rear contact point, forward", "V cos ψ − v_y sin ψ";
        y_rate: "ẏ" M_PER_S = 0.0, in [-FREE, FREE], "Velocity of the rear contact point, left", "V sin ψ + v_y cos ψ";
        front_lateral_force: "F_F" N = 0.0, in [-FREE, FREE], "Lateral force of the front tyre, left positive", "F_θ − F_φ, after the relaxation length; without slip what the constraint takes";
        lateral_velocity_rate: "v̇_y" M_PER_S2 = 0.0, in [-FREE, FREE], "Rate of the lateral velocity; 0 in all but whipple_slip", "Meijaard et al. 2007 with side-slip tyres";
        front_lateral_force_rate: "Ḟ_F" N_PER_S = 0.0, in [-FREE, FREE], "Rate of the front tyre's force where it is a state, else 0", "(σ/V) Ḟ + F = F_steady";
        rear_lateral_force_rate: "Ḟ_R" N_PER_S = 0.0, in [-FREE, FREE], "Rate of the rear tyre's force where it is a state, else 0", "(σ/V) Ḟ + F = F_steady";
    }
}

rows! {
    /// What follows from the parameters alone: geometry, and bicycle, rider and load as one.
    Derived;
    Tunable {
        fork_offset: "f" M = 0.0, in [-FREE, FREE], "Fork offset", "r_f sin λ − L_3 cos λ";
        loaded_mass: "M + m_l" KG = 0.0, in [-FREE, FREE], "Mass of bicycle, rider and load", "composition";
        loaded_cog_to_rear: "L_1" M = 0.0, in [-FREE, FREE], "Centre of mass with the load, forward of the rear contact", "composition";
        loaded_cog_height: "h" M = 0.0, in [-FREE, FREE], "Centre of mass with the load above the ground", "composition";
        loaded_roll_inertia: "I_xx" KG_M2 = 0.0, in [-FREE, FREE], "Roll inertia with the load about the rear contact", "composition";
        loaded_yaw_inertia: "I_zz" KG_M2 = 0.0, in [-FREE, FREE], "Yaw inertia with the load about the rear contact", "composition";
        loaded_cross_inertia: "I_xz" KG_M2 = 0.0, in [-FREE, FREE], "Product of inertia with the load about the rear contact", "composition";
    }
}
