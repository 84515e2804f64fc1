//! Tables 2–6 of the paper as data, and the nine cases of its section 3.

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

/// One of the nine cases of Table 3.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Case {
    /// 1 to 9.
    pub number: usize,
    /// Trail [m].
    pub trail: f64,
    /// Centre of mass before the rear contact [m].
    pub cog_to_rear: f64,
}

/// The nine cases, trail by trail.
pub fn all() -> [Case; 9] {
    std::array::from_fn(|i| Case {
        number: i + 1,
        trail: TRAILS[i / 3],
        cog_to_rear: COGS[i % 3],
    })
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
            let late = self
                .time
                .iter()
                .zip(&self.steer)
                .filter(|(t, _)| **t >= 1.0);
            late.fold(0.0, |largest, (_, steer)| steer.abs().max(largest))
        })
    }
}

impl Case {
    /// `parameters` with this case's trail, centre of mass (inertias about it kept) and Table 2's
    /// start values.
    pub fn parameters(&self, parameters: &Parameters) -> Parameters {
        let lumps = parameters.lumps();
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
        p.set_lumps(lumps.moved(self.cog_to_rear, lumps.cog_height));
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
