//! Tables 2–6 of the paper as data, the nine cases of its section 3, and the same study with loads
//! on the carrier.

mod oscillation;

pub use oscillation::{Oscillation, dominant_frequency, reversals};

use crate::dynamics::Formulation;
use crate::parameters::Parameters;
use crate::simulate::{Refusal, Simulation, Stop};
use crate::state::Input;

/// Table 2: φ̇ [rad/s], θ̇ [rad/s], φ [°], θ [°], ψ̇ [rad/s] at the start.
pub const TABLE_2: [f64; 5] = [0.0, 0.0, -5.0, 1.0, 2.0];
/// Table 3, rows: trails [m].
pub const TRAILS: [f64; 3] = [0.130, 0.085, -0.035];
/// Table 3, columns: centre of mass before the rear contact [m].
pub const COGS: [f64; 3] = [0.68, 0.52, 0.37];
/// Table 4: mass [kg], wheel radius [m], wheelbase [m], caster angle [°], rear contact to centre
/// of mass [m], steering inertia [kg m²], as printed.
pub const TABLE_4: [f64; 6] = [17.5, 0.308, 1.015, 20.0, 0.507, 0.00181];
/// Table 5: step and trail [m]; step +4 is printed −.05, which the sequence shows to mean −.005.
pub const TABLE_5: [(i8, f64); 7] = [
    (-1, 0.13),
    (0, 0.11),
    (1, 0.085),
    (2, 0.055),
    (3, 0.025),
    (4, -0.005),
    (5, -0.035),
];
/// Table 6: the riders, height [m] and mass [kg].
pub const RIDERS: [(f64, f64); 3] = [(1.78, 82.0), (1.68, 53.0), (1.78, 75.0)];
/// How long the cases run [s]; assumed, the paper does not say.
pub const DURATION: f64 = 5.0;
/// What comes before is the way from Table 2's start; what comes after is judged \[s\]. Assumed, the
/// paper does not say.
pub const SETTLED: f64 = 1.0;

/// What goes backwards from case to case.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Rearward {
    /// The centre of mass of bicycle and rider, this far before the rear contact [m], as the paper
    /// shifts it: inertias about it kept.
    CogToRear(f64),
    /// A load on the carrier [kg], the row `rear_load`: what riders do.
    RearLoad(f64),
}

/// A case: one of the nine of Table 3, or one with a load instead.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Case {
    /// From 1.
    pub number: usize,
    /// Trail [m].
    pub trail: f64,
    /// What makes it heavy behind.
    pub rearward: Rearward,
}

/// The nine cases, trail by trail.
pub fn all() -> [Case; 9] {
    std::array::from_fn(|i| Case {
        number: i + 1,
        trail: TRAILS[i / 3],
        rearward: Rearward::CogToRear(COGS[i % 3]),
    })
}

/// The same trails with each of `loads` [kg] on the carrier, trail by trail.
pub fn loaded(loads: &[f64]) -> Vec<Case> {
    let of_trail = |trail: f64| {
        let rearward = loads.iter().copied().map(Rearward::RearLoad);
        rearward.map(move |rearward| (trail, rearward))
    };
    let cases = TRAILS.into_iter().flat_map(of_trail).zip(1..);
    cases
        .map(|((trail, rearward), number)| Case {
            number,
            trail,
            rearward,
        })
        .collect()
}

/// How a case went.
#[derive(Debug, Clone, PartialEq)]
pub struct Course {
    /// The case.
    pub case: Case,
    /// Times [s], every `interval` from 0 to the end.
    pub time: Vec<f64>,
    /// Steer angle [rad] at those times.
    pub steer: Vec<f64>,
    /// Why it ended before [`DURATION`], if it did.
    pub stop: Option<Stop>,
}

impl Course {
    /// Time at which the case ended [s].
    pub fn end_time(&self) -> f64 {
        self.stop.map_or(DURATION, Stop::time)
    }

    /// Largest |steer| [rad] after the first second; `None` when the case ended early.
    pub fn amplitude(&self) -> Option<f64> {
        self.stop.is_none().then(|| {
            let all = self.time.iter().zip(&self.steer);
            let late = all.filter(|(t, _)| **t >= SETTLED);
            late.fold(0.0, |largest, (_, steer)| steer.abs().max(largest))
        })
    }

    /// Instants \[s\] at which the steer angle turns back.
    pub fn reversals(&self) -> Vec<f64> {
        reversals(&self.time, &self.steer)
    }

    /// Frequency of the steer angle's swings after the first second [Hz], see
    /// [`dominant_frequency`]; `None` when the case ended early or does not swing.
    pub fn dominant_frequency(&self) -> Option<f64> {
        let reversals = self.reversals();
        let late = &reversals[reversals.partition_point(|t| *t < SETTLED)..];
        self.stop.is_none().then(|| dominant_frequency(late))?
    }

    /// How often the steer angle turns back in the first second.
    pub fn early_reversals(&self) -> usize {
        self.reversals().partition_point(|t| *t < SETTLED)
    }
}

impl Case {
    /// `parameters` with this case's trail, its centre of mass or load, and Table 2's start values.
    pub fn parameters(&self, parameters: &Parameters) -> Parameters {
        let [roll_rate, steer_rate, roll, steer, yaw_rate] = TABLE_2;
        let mut p = Parameters {
            trail: self.trail,
            roll_rate_start: roll_rate,
            steer_rate_start: steer_rate,
            roll_start: roll.to_radians(),
            steer_start: steer.to_radians(),
            yaw_rate_start: yaw_rate,
            ..*parameters
        };
        match self.rearward {
            Rearward::CogToRear(x) => {
                let lumps = parameters.lumps();
                p.set_lumps(lumps.moved(x, lumps.cog_height));
            }
            Rearward::RearLoad(mass) => p.rear_load = mass,
        }
        p
    }

    /// Runs the case, the steer angle noted every `interval` [s].
    pub fn run(
        &self,
        parameters: &Parameters,
        formulation: Formulation,
        input: Input,
        interval: f64,
    ) -> Result<Course, Refusal> {
        let p = self.parameters(parameters);
        let mut simulation = Simulation::new(&p, formulation, input, 0.0)?;
        let mut course = Course {
            case: *self,
            time: vec![0.0],
            steer: vec![p.steer_start],
            stop: None,
        };
        for k in 1..=(DURATION / interval).round() as u64 {
            let outcome = simulation.advance(k as f64 * interval);
            course.time.push(simulation.time());
            course.steer.push(simulation.state().steer);
            if let Err(stop) = outcome {
                course.stop = Some(stop);
                break;
            }
        }
        Ok(course)
    }
}
