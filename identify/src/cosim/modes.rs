//! Eigenvalues of what is coupled, about standing upright.
//!
//! Where every FMU lists its states and declares directional derivatives, from these. Else from how
//! the coupled system answers a small pulse of steer torque and one of roll moment: the answers,
//! sampled whenever all participants sample together, are those of a linear system, delays of the
//! exchange within, which the eigensystem realization algorithm finds (Juang & Pappa 1985,
//! *J. Guidance* 8(5)). So controllers that sample, with states nobody lists, have eigenvalues as
//! well.

use super::PLANT;
use super::coupling::{Begun, Coupling, Variation};
use super::opening::Opened;
use super::rider::port;
use super::{derivatives, realization};
use crate::error::Result;
use crate::ride;
use bicycle::{Input, Parameters, linear};
use fmi_import::master::{Algorithm, Direction, End, Participant, Plan, Port, Terminal};
use fmi_import::{Error, Step};
use nalgebra::Complex;

/// Eigenvalues [1/s] and how they were found; or why there are none, a clause.
pub type Modes = std::result::Result<(Vec<Complex<f64>>, &'static str), String>;

/// Free motion looked at [s]: a period of the slowest oscillation that matters.
const TIME: f64 = 1.25;
/// What grows is looked at until it is that many times as large as in the first samples: further on
/// it hides all that decays.
const GROWTH: f64 = 300.0;
/// First samples, and how few are enough.
const FIRST: usize = 12;
/// Samples at most: with more of them the step between is made longer.
const MOST_SAMPLES: usize = 250;
/// Pulse of steer torque and of roll moment [N m]: so small that angles are some 1e-9 rad, where
/// every equation is straight; numbers near 0 have all their digits.
const PULSE: f64 = 1e-6;
/// An eigenvalue is believed that is found from every sample and from every other, that near to each
/// other: the images of a slow one at multiples of a sampling rate are not, nor is what noise makes.
const AGREEMENT: f64 = 0.01;

impl Coupling {
    /// Eigenvalues about standing upright, at the speed of the start, without what has no slope
    /// there: Coulomb friction, and the steps of quantisers (rows called `…_resolution`).
    pub fn modes(&self, variation: &Variation, begun: &mut dyn FnMut(Begun)) -> Result<Modes> {
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
        self.by_pulses(&variation, bicycle.input.speed, begun)
    }

    /// From directional derivatives; none where an FMU does not declare them, or lists no states.
    fn by_derivatives(&self, variation: &Variation) -> Result<Option<Vec<Complex<f64>>>> {
        let lists = |fmu: &Opened| derivatives::lists_states(fmu.fmu.description());
        if !self.present(variation).all(lists) {
            return Ok(None);
        }
        let (connections, factors) = {
            let master = self.master(variation)?;
            (master.connections().to_vec(), master.factors().to_vec())
        };
        let mut linear = Vec::new();
        for opened in self.present(variation) {
            let starts = self.starts_of(opened, variation);
            linear.push(derivatives::Linear::of(
                &opened.fmu,
                &opened.name,
                &starts,
                &connections,
            )?);
        }
        Ok(derivatives::coupled(&linear, &factors).map(|a| linear::eigenvalues(&a)))
    }

    /// From the answers to pulses at `speed` [m/s], values travelling Jacobi's way.
    fn by_pulses(
        &self,
        variation: &Variation,
        speed: f64,
        begun: &mut dyn FnMut(Begun),
    ) -> Result<Modes> {
        // a sample is a whole number of everybody's steps
        let Some(period) = self.period() else {
            return Ok(Err(
                "the steps of the participants have no common multiple".to_owned()
            ));
        };
        let stride = (TIME / period / MOST_SAMPLES as f64).ceil().max(1.0);
        let every = stride * period;
        let record = SEEN.map(|variable| Terminal {
            participant: PLANT.to_owned(),
            variable: variable.to_owned(),
        });
        let plan = Plan {
            stop_time: (TIME / every).floor().max(1.0) * every,
            algorithm: Algorithm::Jacobi,
            tolerance: None,
            initial_exchange: true,
            record: record.into(),
            ..self.plan().clone()
        };
        let answers = self.answers(&plan, every, variation, speed, begun)?;
        Ok(answers.and_then(|answers| agreed(&answers, every)))
    }

    /// For each pulse what is seen of the free motion after it, a sample after every `every` [s].
    fn answers(
        &self,
        plan: &Plan,
        every: f64,
        variation: &Variation,
        speed: f64,
        begun: &mut dyn FnMut(Begun),
    ) -> Result<std::result::Result<Vec<Motion>, String>> {
        let rows = (every / plan.step).round() as usize;
        let mut answers = Vec::new();
        for input in [STEER_TORQUE, ROLL_MOMENT] {
            let mut sides = Vec::new();
            for sign in [1.0, -1.0] {
                let pulse = Pulse::new(input, sign * PULSE, speed);
                let mut master = self.master_with(variation, Some(Box::new(pulse)))?;
                begun(Begun {
                    watch: master.watch(),
                    names: [ride::TIME]
                        .iter()
                        .chain(&SEEN)
                        .map(|name| (*name).to_owned())
                        .collect(),
                    units: vec![None; 1 + SEEN.len()],
                });
                let run = master.run(plan)?;
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
            answers.push((1..=SEEN.len()).map(column).collect::<Vec<_>>());
        }
        Ok(Ok(answers))
    }
}

/// What is seen of a motion: of each output its samples.
type Motion = Vec<Vec<f64>>;

/// The eigenvalues that samples `every` [s] apart and every other of them agree on.
fn agreed(answers: &[Motion], every: f64) -> Modes {
    let seen = before_growth(answers);
    let found = |stride: usize| {
        let of = |samples: &Vec<f64>| samples.iter().take(seen).step_by(stride).copied().collect();
        let thinned: Vec<Motion> = (answers.iter())
            .map(|motion| motion.iter().map(of).collect())
            .collect();
        // what is faster than the samples tell: delays, and what dies within one
        realization::eigenvalues(&thinned).map(|values| {
            let told = values.into_iter().filter(|z| z.norm() > realization::GONE);
            told.map(|z| z.ln() / (stride as f64 * every))
                .collect::<Vec<_>>()
        })
    };
    let (mut values, others) = (found(1)?, found(2)?);
    let near = |a: &Complex<f64>, b: &Complex<f64>| (a - b).norm() < AGREEMENT * a.norm();
    values.retain(|value| others.iter().any(|other| near(value, other)));
    if values.is_empty() {
        return Err("no eigenvalue is the same from every sample and every other".to_owned());
    }
    Ok((values, "answers to pulses"))
}

/// How many samples there are before something has grown too large.
fn before_growth(answers: &[Motion]) -> usize {
    let samples = answers.iter().flatten();
    let large = |samples: &Vec<f64>| {
        let first = samples
            .iter()
            .take(FIRST)
            .fold(0.0, |most: f64, y| most.max(y.abs()));
        let too_large = samples
            .iter()
            .position(|y| y.abs() > GROWTH * first && first > 0.0);
        too_large.unwrap_or(samples.len()).max(FIRST)
    };
    samples.map(large).min().unwrap_or(0)
}

const SEEN: [&str; 5] = ["roll", "steer", "roll_rate", "steer_rate", "yaw_rate"];
const STEER_TORQUE: &str = "steer_torque";
const ROLL_MOMENT: &str = "roll_moment";

/// In the rider's place: the speed, and a pulse of one input in the first step.
struct Pulse {
    ports: Vec<Port>,
    /// One for each port: what it is in the first step and what from then on.
    values: [[f64; 2]; 3],
    /// Whether the first step is over.
    over: bool,
}

impl Pulse {
    fn new(input: &str, torque: f64, speed: f64) -> Self {
        let names = ["speed", STEER_TORQUE, ROLL_MOMENT];
        let port = |name: &str| {
            let row = &Input::TABLE[Input::index(name).expect("a row")];
            port(row, Direction::Output)
        };
        let of = |name: &str| {
            if name == input {
                [torque, 0.0]
            } else {
                [0.0; 2]
            }
        };
        Self {
            ports: names.map(port).into(),
            values: [[speed; 2], of(STEER_TORQUE), of(ROLL_MOMENT)],
            over: false,
        }
    }
}

impl Participant for Pulse {
    fn ports(&self) -> &[Port] {
        &self.ports
    }
    fn enter_initialization(&mut self, _: f64, _: f64) -> std::result::Result<(), Error> {
        self.over = false;
        Ok(())
    }
    fn exit_initialization(&mut self) -> std::result::Result<(), Error> {
        Ok(())
    }
    fn read(&mut self, ports: &[usize], values: &mut [f64]) -> std::result::Result<(), Error> {
        for (&port, value) in ports.iter().zip(values) {
            *value = self.values[port][usize::from(self.over)];
        }
        Ok(())
    }
    fn write(&mut self, _: &[usize], _: &[f64]) -> std::result::Result<(), Error> {
        Ok(())
    }
    fn step(&mut self, _: f64, _: f64) -> std::result::Result<Step, Error> {
        self.over = true;
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
