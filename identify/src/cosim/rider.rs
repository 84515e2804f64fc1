//! The rider as a participant: follows a course or leaves that to the law in the plant, and adds a
//! remnant.

use crate::synthesis::remnant;
use bicycle::rider::Preview;
use bicycle::{Excitation, Input, Output, Quantity};
use fmi_import::master::{Direction, Kind, Participant, Port};
use fmi_import::{Error, Step};
use rand::SeedableRng;
use rand_distr::{Distribution, StandardNormal};
use rand_xoshiro::Xoshiro256PlusPlus;

/// Samples of the remnant are that far apart [s]; it runs straight in between.
const REMNANT_STEP: f64 = 0.005;

/// What the rider gives, rows of the plant's inputs.
const GIVES: [&str; 2] = ["steer_torque", "speed"];

/// A rider in the saddle.
#[derive(Clone)]
pub struct Rider {
    ports: Vec<Port>,
    /// What the plant's inputs start with: the speed is held, the torque added to.
    input: Input,
    course: Option<Preview>,
    /// As at the start, to begin a run with.
    fresh: Option<Preview>,
    start: f64,
    remnant: Vec<f64>,
    seen: Output,
    torque: f64,
    kept: Option<Box<Rider>>,
}

impl Rider {
    /// A rider for a ride of `duration` [s] with these inputs and, perhaps, on a course.
    pub fn new(
        input: Input,
        course: Option<Preview>,
        excitation: &Excitation,
        seed: u64,
        duration: f64,
    ) -> Self {
        let mut rng = Xoshiro256PlusPlus::seed_from_u64(seed);
        let samples = (duration / REMNANT_STEP).ceil() as usize + 2;
        let remnant = if excitation.remnant_intensity > 0.0 {
            let mut normal = || -> f64 { StandardNormal.sample(&mut rng) };
            remnant(excitation, samples, REMNANT_STEP, &mut normal)
        } else {
            Vec::new()
        };
        Self {
            ports: ports(course.is_some()),
            input,
            fresh: course.clone(),
            course,
            start: 0.0,
            remnant,
            seen: Output::default(),
            torque: input.steer_torque,
            kept: None,
        }
    }

    /// The remnant at `time` [s] after the start.
    fn remnant(&self, time: f64) -> f64 {
        let position = time / REMNANT_STEP;
        let n = (position as usize).min(self.remnant.len().saturating_sub(2));
        match self.remnant.get(n..n + 2) {
            Some([a, b]) => a + (b - a) * (position - n as f64),
            _ => 0.0,
        }
    }
}

/// A row of a table as a port of one in the saddle.
pub fn port(quantity: &Quantity, direction: Direction) -> Port {
    Port {
        name: quantity.name.to_owned(),
        direction,
        kind: Kind::Real,
        unit: Some(fmu::unit(&quantity.unit)),
        depends_on: Some(Vec::new()),
        // what a rider wants is no error of the coupling, however it changes with the step
        nominal: f64::INFINITY,
    }
}

/// The plant's outputs come in, where there is a course to follow; the plant's inputs go out.
fn ports(on_course: bool) -> Vec<Port> {
    let inputs = Output::TABLE.iter().filter(|_| on_course);
    let gives = GIVES.map(|name| &Input::TABLE[Input::index(name).expect("a row")]);
    inputs
        .map(|quantity| port(quantity, Direction::Input))
        .chain(
            gives
                .into_iter()
                .map(|quantity| port(quantity, Direction::Output)),
        )
        .collect()
}

impl Participant for Rider {
    fn ports(&self) -> &[Port] {
        &self.ports
    }

    fn enter_initialization(&mut self, start: f64, _stop: f64) -> Result<(), Error> {
        self.start = start;
        self.course = self.fresh.clone();
        (self.seen, self.torque) = (Output::default(), self.input.steer_torque);
        Ok(())
    }

    fn exit_initialization(&mut self) -> Result<(), Error> {
        Ok(())
    }

    fn read(&mut self, ports: &[usize], values: &mut [f64]) -> Result<(), Error> {
        let inputs = if self.course.is_some() {
            Output::LEN
        } else {
            0
        };
        for (&port, value) in ports.iter().zip(values) {
            *value = match port.checked_sub(inputs) {
                None => self.seen.get(port),
                Some(0) => self.torque,
                Some(_) => self.input.speed,
            };
        }
        Ok(())
    }

    fn write(&mut self, ports: &[usize], values: &[f64]) -> Result<(), Error> {
        for (&port, &value) in ports.iter().zip(values) {
            self.seen.set(port, value);
        }
        Ok(())
    }

    fn step(&mut self, point: f64, h: f64) -> Result<Step, Error> {
        let steering = match &mut self.course {
            Some(rider) => rider.torque(point - self.start, &self.seen),
            None => 0.0,
        };
        // its value in the middle of the step; under Jacobi it acts a step later, as all does
        let remnant = self.remnant(point - self.start + 0.5 * h);
        self.torque = self.input.steer_torque + steering + remnant;
        Ok(Step::Complete)
    }

    fn can_vary_step(&self) -> bool {
        true
    }

    fn can_keep(&self) -> bool {
        true
    }

    fn keep(&mut self) -> Result<(), Error> {
        self.kept = None;
        self.kept = Some(Box::new(self.clone()));
        Ok(())
    }

    fn go_back(&mut self) -> Result<(), Error> {
        let kept = self.kept.take().ok_or(Error::NothingKept)?;
        *self = (*kept).clone();
        self.kept = Some(kept);
        Ok(())
    }

    fn terminate(&mut self) -> Result<(), Error> {
        Ok(())
    }
}
