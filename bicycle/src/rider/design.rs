//! Gains for following a course: optimal linear preview control of the bicycle ridden.
//!
//! After Sharp and Valtetsiotis (2001) and Sharp (2008, "On the stability and control of the
//! bicycle"). Theirs is a path in the ground's frame, previewed as lateral positions in a shift
//! register; here offset and heading are those with respect to the course, and what is previewed is
//! its curvature. For small angles that is the same problem, and it serves a circle as well.
//!
//! ```text
//! ẋ = A x + B τ                       the bicycle upright at speed V, without its rider's law
//! ė = V ε + v_y                       offset of the rear contact, left of the course
//! ε̇ = ψ̇ − V κ                         heading against the course's, κ(s) its curvature
//! J = Σ (e/e₀)² + ((ε + v_y/V)/ε₀)² + (τ/τ₀)²,        torque and curvature held over each sample
//! τ_k = −K (x, e, ε)_k − Σ_j K_j κ_{k+j},    K_j = (r + Γᵀ P Γ)⁻¹ Γᵀ (Φ − Γ K)ᵀʲ P E
//! ```
//!
//! A rider who reacts late acts on the state predicted by this same system from what was seen and
//! from the torques on their way (Kleinman 1969): with a delay of the torque that is the optimum.
//!
//! The sum runs over the horizon; beyond it the course is taken to keep its curvature, which is the
//! closed sum of the remaining terms.
//!
//! The Coulomb friction of the steering is left out: its slope at rest, d/ε, would have the rider
//! fight a viscosity that is gone as soon as the fork moves. The rider meets it as a disturbance.

use super::riccati::{self, Problem};
use crate::dynamics::{Bicycle, Formulation};
use crate::linear::{self, Linear};
use crate::parameters::Parameters;
use crate::quantity::rows;
use crate::state::{Input, Output, State};
use nalgebra::{DMatrix, DVector};
use std::fmt;

rows! {
    /// How a rider follows a course. The first three rows weigh the cost by Bryson's rule: an error
    /// of that size costs as much as each of the others.
    Manner;
    Fixed {
        offset_scale: "e_0" M = 0.02, in [0.001, 10.0], "Offset from the course that is worth a steer torque of torque_scale", "assumed: half of what the paper's slalom swings";
        direction_scale: "ε_0" RAD = 0.2, in [0.001, 10.0], "Direction of travel off the course that is worth as much", "assumed: ten times offset_scale over a metre, so that the offset decides";
        torque_scale: "τ_0" N_M = 10.0, in [0.01, 1000.0], "Steer torque that is worth as much", "assumed: what an arm gives without effort";
        horizon: "t_p" S = 2.5, in [0.0, 20.0], "How far ahead the course is seen", "assumed: the nominal bicycle's gains are below 1 % of the largest after 1.9 s from 0.5 m/s on";
        sample_time: "T" S = 0.005, in [0.0005, 0.1], "From one look to the next; the torque is held in between", "paper, section 4.1: sampling at 200 Hz";
        reaction_delay: "t_d" S = 0.0, in [0.0, 1.0], "From seeing to acting, in whole samples", "assumed: none; McRuer and Jex 1967: people act some 0.1 to 0.2 s late";
        torque_limit: "τ_max" N_M = f64::INFINITY, in [0.0, f64::INFINITY], "Largest steer torque", "assumed: none";
    }
}

/// Why there are no gains for a bicycle at a speed.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Unridable {
    /// At `speed` [m/s] nobody rides: it is not above zero, or the equations of motion have no
    /// finite slopes there.
    NoLinearSystem {
        /// Forward speed [m/s].
        speed: f64,
    },
    /// At `speed` [m/s] no steer torque keeps the bicycle on a course, as far as the Riccati
    /// equation can tell.
    Uncontrollable {
        /// Forward speed [m/s].
        speed: f64,
    },
}

impl fmt::Display for Unridable {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        match self {
            Self::NoLinearSystem { speed } => {
                write!(
                    f,
                    "nothing to steer by at {speed} m/s: expected a finite speed above 0"
                )
            }
            Self::Uncontrollable { speed } => {
                write!(
                    f,
                    "no steer torque keeps the bicycle on a course at {speed} m/s"
                )
            }
        }
    }
}

impl std::error::Error for Unridable {}

/// The gains of a rider at one speed.
#[derive(Debug, Clone, PartialEq)]
pub struct Gains {
    /// Forward speed [m/s].
    pub speed: f64,
    /// The bicycle on its course, for which they are the optimum.
    pub sampled: Sampled,
    /// K: steer torque [N m] against the states that the formulation moves, in the order of
    /// [`State`], then against offset [N] and heading with respect to the course [N m/rad].
    pub state: DVector<f64>,
    /// Against the curvature [N m²] of the course during each sample to come.
    pub preview: Vec<f64>,
    /// Against the curvature with which the course goes on [N m²].
    pub beyond: f64,
    /// Relative residual of the Riccati equation.
    pub residual: f64,
}

/// A residual of the Riccati equation beyond which its solution is none.
const RESIDUAL: f64 = 1e-6;

impl Gains {
    /// Those for a bicycle at `speed` [m/s]; the rider law of `parameters` plays no part.
    pub fn new(
        parameters: &Parameters,
        formulation: Formulation,
        manner: &Manner,
        speed: f64,
    ) -> Result<Self, Unridable> {
        let sampled = sampled(parameters, formulation, manner, speed)
            .ok_or(Unridable::NoLinearSystem { speed })?;
        let regulator = riccati::solve(&sampled.problem)
            .filter(|r| r.residual < RESIDUAL)
            .ok_or(Unridable::Uncontrollable { speed })?;
        let back = regulator.closed_loop.transpose();
        let mut shadow = &regulator.cost_to_go * &sampled.course;
        let input = &sampled.problem.input;
        let effect = |shadow: &DVector<f64>| input.dot(shadow) / regulator.weight;
        let samples = (manner.horizon / manner.sample_time).round() as usize;
        let preview = (0..samples)
            .map(|_| {
                let gain = effect(&shadow);
                shadow = &back * &shadow;
                gain
            })
            .collect();
        // Σ (Φ − Γ K)ᵀʲ over all that follow
        let n = shadow.len();
        let rest = (DMatrix::identity(n, n) - back)
            .lu()
            .solve(&shadow)
            .ok_or(Unridable::Uncontrollable { speed })?;
        let beyond = effect(&rest);
        Ok(Self {
            speed,
            sampled,
            state: regulator.gain,
            preview,
            beyond,
            residual: regulator.residual,
        })
    }
}

/// The bicycle on a course from sample to sample: states of the bicycle, offset, heading error.
#[derive(Debug, Clone, PartialEq)]
pub struct Sampled {
    /// The bicycle and what its rider minds.
    pub problem: Problem,
    /// E, effect of the course's curvature [1/m] during a sample.
    pub course: DVector<f64>,
}

/// The linear system of the design at `speed` [m/s], `None` where it is not finite.
pub fn sampled(
    parameters: &Parameters,
    formulation: Formulation,
    manner: &Manner,
    speed: f64,
) -> Option<Sampled> {
    let frictionless = Parameters {
        coulomb_friction: 0.0,
        ..parameters.riderless()
    };
    let bicycle = Bicycle::new(&frictionless, formulation);
    let input = Input {
        speed,
        ..Input::default()
    };
    let Linear { a, b, c, d } = linear::linearize(&bicycle, &State::ZERO, &input);
    let n = a.nrows();
    let (offset, heading, torque, curvature) = (n, n + 1, n + 2, n + 3);

    // d/dt (x, e, ε, τ, κ), the last two held
    let mut rates = DMatrix::zeros(n + 4, n + 4);
    rates.view_mut((0, 0), (n, n)).copy_from(&a);
    let by_torque = b.column(STEER_TORQUE);
    rates.view_mut((0, torque), (n, 1)).copy_from(&by_torque);
    for (row, seen) in [(offset, LATERAL_VELOCITY), (heading, YAW_RATE)] {
        rates.view_mut((row, 0), (1, n)).copy_from(&c.row(seen));
        rates[(row, torque)] = d[(seen, STEER_TORQUE)];
    }
    rates[(offset, heading)] = speed;
    rates[(heading, curvature)] = -speed;
    if rates.iter().any(|rate| !rate.is_finite()) || speed <= 0.0 {
        return None;
    }

    let held = (rates * manner.sample_time).exp();
    let mut aside = DVector::zeros(n + 2);
    aside[offset] = 1.0 / manner.offset_scale;
    let mut astray = DVector::zeros(n + 2);
    let drift = c.row(LATERAL_VELOCITY).transpose() / speed;
    astray.rows_mut(0, n).copy_from(&drift);
    astray[heading] = 1.0;
    astray /= manner.direction_scale;
    let state_cost = &aside * aside.transpose() + &astray * astray.transpose();
    Some(Sampled {
        problem: Problem {
            transition: held.view((0, 0), (n + 2, n + 2)).into_owned(),
            input: held.view((0, torque), (n + 2, 1)).column(0).into_owned(),
            state_cost,
            input_cost: manner.torque_scale.powi(-2),
        },
        course: held.view((0, curvature), (n + 2, 1)).column(0).into_owned(),
    })
}

const STEER_TORQUE: usize = Input::index("steer_torque").expect("an input");
const LATERAL_VELOCITY: usize = Output::index("lateral_velocity").expect("an output");
const YAW_RATE: usize = Output::index("yaw_rate").expect("an output");
