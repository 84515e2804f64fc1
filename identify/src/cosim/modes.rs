//! Eigenvalues of what is coupled, about standing upright.
//!
//! Where every FMU lists its states and declares directional derivatives, from these. Else from how
//! the coupled system answers a small pulse of steer torque and one of roll moment: the answers,
//! sampled with the longest communication step of a participant, are those of a linear system, which
//! the eigensystem realization algorithm finds (Juang & Pappa 1985, *J. Guidance* 8(5)). So
//! controllers that sample, with states nobody lists, have eigenvalues as well.

use super::PLANT;
use super::coupling::{Coupling, Variation};
use super::opening::Opened;
use super::{derivatives, realization};
use crate::error::Result;
use bicycle::{Input, Parameters, linear};
use fmi_import::master::{Direction, End, Kind, Participant, Plan, Port, Terminal};
use fmi_import::{Error, Step};
use nalgebra::Complex;

/// Eigenvalues [1/s] and how they were found; or why there are none, a clause.
pub type Modes = std::result::Result<(Vec<Complex<f64>>, &'static str), String>;

/// Free motion looked at [s]: a period of the slowest oscillation that matters; less where growth
/// soon hides all that decays.
const TIMES: [f64; 3] = [1.25, 0.6, 0.3];
/// Pulse of steer torque and of roll moment [N m]: so small that angles are some 1e-6 rad, where
/// every equation is straight to 1e-12, and answers still have ten digits.
const PULSE: f64 = 1e-3;

impl Coupling {
    /// Eigenvalues about standing upright, at the speed of the start, without what has no slope
    /// there: Coulomb friction, and the steps of quantisers (rows called `…_resolution`).
    pub fn modes(&self, variation: &Variation) -> Result<Modes> {
        let Some(bicycle) = &self.bicycle else {
            return Ok(Err(
                "the plant is none of the bicycles known natively".to_owned()
            ));
        };
        if self.has_course() {
            return Ok(Err(
                "the rider follows a course: no law of fixed gains".to_owned()
            ));
        }
        let row = Parameters::index("steer_smoothing").expect("a row");
        let widest = Parameters::TABLE[row].max;
        let upright = Parameters {
            roll_start: 0.0,
            steer_start: 0.0,
            roll_rate_start: 0.0,
            steer_rate_start: 0.0,
            yaw_rate_start: 0.0,
            coulomb_friction: 0.0,
            // of no slope upright, and so wide that small angles do not see it bend
            steer_smoothing: widest,
            ..variation.of(bicycle)
        };
        let variation = Variation {
            parameters: Some(&upright),
            smooth: true,
            ..*variation
        };
        if let Some(values) = self.by_derivatives(&variation)? {
            return Ok(Ok((values, "directional derivatives")));
        }
        self.by_pulses(&variation, bicycle.input.speed)
    }

    /// From directional derivatives; none where an FMU does not declare them, or lists no states.
    fn by_derivatives(&self, variation: &Variation) -> Result<Option<Vec<Complex<f64>>>> {
        let lists = |fmu: &Opened| derivatives::lists_states(fmu.fmu.description());
        if !self.present(variation).all(lists) {
            return Ok(None);
        }
        let master = self.master(variation)?;
        let connections = master.connections();
        let mut linear = Vec::new();
        for opened in self.present(variation) {
            let starts = self.starts_of(opened, variation);
            linear.push(derivatives::Linear::of(
                &opened.fmu,
                &opened.name,
                &starts,
                connections,
            )?);
        }
        Ok(derivatives::coupled(&linear, master.factors()).map(|a| linear::eigenvalues(&a)))
    }

    /// From the answers to pulses at `speed` [m/s].
    fn by_pulses(&self, variation: &Variation, speed: f64) -> Result<Modes> {
        let mut first = None;
        for time in TIMES {
            let found = self.by_pulses_within(time, variation, speed)?;
            match found {
                Ok(modes) => return Ok(Ok(modes)),
                Err(reason) => first = first.or(Some(reason)),
            }
        }
        Ok(Err(first.unwrap_or_default()))
    }

    fn by_pulses_within(&self, time: f64, variation: &Variation, speed: f64) -> Result<Modes> {
        let seen = ["roll", "steer", "roll_rate", "steer_rate", "yaw_rate"];
        let plan = Plan {
            stop_time: time,
            tolerance: None,
            initial_exchange: true,
            record: seen
                .map(|variable| Terminal {
                    participant: PLANT.to_owned(),
                    variable: variable.to_owned(),
                })
                .into(),
            ..self.plan().clone()
        };
        let every = self.longest_step();
        let rows = (every / plan.step).round() as usize;
        let mut answers = Vec::new();
        for input in ["steer_torque", "roll_moment"] {
            let mut sides = Vec::new();
            for sign in [1.0, -1.0] {
                let pulse = Pulse::new(input, sign * PULSE, speed);
                let mut master = self.master_with(variation, Some(Box::new(pulse)))?;
                let run = master.run(&plan)?;
                match run.end {
                    End::Complete | End::Stopped => sides.push(run.columns),
                    End::Early { member, time, .. } => {
                        return Ok(Err(format!(
                            "after a small pulse {member} ended at {time} s"
                        )));
                    }
                    End::Failed(error) => return Err(error.into()),
                }
            }
            // free from the end of the step in which the pulse acts; even powers cancel
            let column = |c: usize| -> Vec<f64> {
                let differences = sides[0][c].iter().zip(&sides[1][c]);
                let differences = differences.map(|(a, b)| 0.5 * (a - b));
                differences.skip(rows).step_by(rows).collect()
            };
            answers.push((1..=seen.len()).map(column).collect::<Vec<_>>());
        }
        Ok(realization::eigenvalues(&answers).map(|values| {
            // what is faster than the samples tell: delays, and what dies within one
            let slow = values.into_iter().filter(|z| z.norm() > realization::GONE);
            (slow.map(|z| z.ln() / every).collect(), "answers to pulses")
        }))
    }
}

/// In the rider's place: the speed, and a pulse in the first step.
struct Pulse {
    ports: Vec<Port>,
    speed: f64,
    torque: f64,
}

impl Pulse {
    fn new(input: &str, pulse: f64, speed: f64) -> Self {
        let port = |name: &str| {
            let row = &Input::TABLE[Input::index(name).expect("a row")];
            Port {
                name: row.name.to_owned(),
                direction: Direction::Output,
                kind: Kind::Real,
                unit: Some(fmu::unit(&row.unit)),
                depends_on: Some(Vec::new()),
                nominal: 1.0,
            }
        };
        Self {
            ports: vec![port("speed"), port(input)],
            speed,
            torque: pulse,
        }
    }
}

impl Participant for Pulse {
    fn ports(&self) -> &[Port] {
        &self.ports
    }
    fn enter_initialization(&mut self, _: f64, _: f64) -> std::result::Result<(), Error> {
        Ok(())
    }
    fn exit_initialization(&mut self) -> std::result::Result<(), Error> {
        Ok(())
    }
    fn read(&mut self, ports: &[usize], values: &mut [f64]) -> std::result::Result<(), Error> {
        for (&port, value) in ports.iter().zip(values) {
            *value = [self.speed, self.torque][port];
        }
        Ok(())
    }
    fn write(&mut self, _: &[usize], _: &[f64]) -> std::result::Result<(), Error> {
        Ok(())
    }
    fn step(&mut self, _: f64, _: f64) -> std::result::Result<Step, Error> {
        self.torque = 0.0;
        Ok(Step::Complete)
    }
    fn can_vary_step(&self) -> bool {
        true
    }
    fn can_keep(&self) -> bool {
        false
    }
    fn keep(&mut self) -> std::result::Result<(), Error> {
        Err(Error::NothingKept)
    }
    fn go_back(&mut self) -> std::result::Result<(), Error> {
        Err(Error::NothingKept)
    }
    fn terminate(&mut self) -> std::result::Result<(), Error> {
        Ok(())
    }
}

#[cfg(test)]
mod tests;
