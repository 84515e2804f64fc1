//! A first-order lag, solved exactly over a step with its input held.

use crate::master::{Connection, Direction, Kind, Master, Member, Participant, Port};
use crate::{Error, Step};

/// ẋ = −rate·x + gain·input; its output is x.
#[derive(Clone, Debug)]
pub struct Lag {
    pub rate: f64,
    pub gain: f64,
    pub start: f64,
    /// When it ends of itself [s].
    pub end: f64,
    /// Whether steps from 0 on are refused that are longer than this [s].
    pub longest: f64,
    /// The only length of its steps [s], if there is one.
    pub only: Option<f64>,
    pub can_keep: bool,
    pub x: f64,
    pub input: f64,
    pub kept: (f64, f64),
    pub ports: Vec<Port>,
}

pub fn port(name: &str, direction: Direction) -> Port {
    Port {
        name: name.to_owned(),
        direction,
        kind: Kind::Real,
        unit: None,
        depends_on: Some(Vec::new()),
        nominal: 1.0,
    }
}

impl Lag {
    pub fn new(rate: f64, gain: f64, start: f64) -> Self {
        Self {
            rate,
            gain,
            start,
            end: f64::INFINITY,
            longest: f64::INFINITY,
            only: None,
            can_keep: true,
            x: start,
            input: 0.0,
            kept: (0.0, 0.0),
            ports: vec![
                port("input", Direction::Input),
                port("x", Direction::Output),
            ],
        }
    }
}

impl Participant for Lag {
    fn ports(&self) -> &[Port] {
        &self.ports
    }

    fn enter_initialization(&mut self, _start: f64, _stop: f64) -> Result<(), Error> {
        (self.x, self.input) = (self.start, 0.0);
        Ok(())
    }

    fn exit_initialization(&mut self) -> Result<(), Error> {
        Ok(())
    }

    fn read(&mut self, ports: &[usize], values: &mut [f64]) -> Result<(), Error> {
        for (port, value) in ports.iter().zip(values) {
            *value = [self.input, self.x][*port];
        }
        Ok(())
    }

    fn write(&mut self, ports: &[usize], values: &[f64]) -> Result<(), Error> {
        if !ports.is_empty() {
            self.input = values[0];
        }
        Ok(())
    }

    fn step(&mut self, point: f64, h: f64) -> Result<Step, Error> {
        if let Some(only) = self.only {
            assert!((h - only).abs() < 1e-9, "a step of {h} s");
        }
        let arrives = point + h <= self.end;
        let h = h.min(self.end - point);
        if !arrives || h > self.longest {
            let decay = if arrives { 1.0 } else { (-self.rate * h).exp() };
            self.x *= decay;
            return Ok(Step::Discarded {
                last_successful_time: Some(if arrives { point } else { self.end }),
                terminated: !arrives,
                log: Vec::new(),
            });
        }
        let decay = (-self.rate * h).exp();
        self.x = self.x * decay + self.gain * self.input / self.rate * (1.0 - decay);
        Ok(Step::Complete)
    }

    fn can_vary_step(&self) -> bool {
        self.only.is_none()
    }

    fn can_keep(&self) -> bool {
        self.can_keep
    }

    fn keep(&mut self) -> Result<(), Error> {
        self.kept = (self.x, self.input);
        Ok(())
    }

    fn go_back(&mut self) -> Result<(), Error> {
        (self.x, self.input) = self.kept;
        Ok(())
    }

    fn terminate(&mut self) -> Result<(), Error> {
        Ok(())
    }
}

pub fn member(name: &str, lag: Lag) -> Member<'static> {
    Member {
        name: name.to_owned(),
        participant: Box::new(lag),
        step: None,
    }
}

pub fn connection(source: &str, target: &str) -> Connection {
    Connection {
        source: source.parse().expect("a terminal"),
        target: target.parse().expect("a terminal"),
    }
}

/// ẋ = −x + 2 y, ẏ = −3 y − x: each a lag driven by the other.
pub fn pair() -> Vec<Member<'static>> {
    vec![
        member("x", Lag::new(1.0, 2.0, 1.0)),
        member("y", Lag::new(3.0, -1.0, 0.5)),
    ]
}

pub fn coupled() -> Vec<Connection> {
    vec![connection("y.x", "x.input"), connection("x.x", "y.input")]
}

/// The pair at `t`. The matrix [−1 2; −1 −3] has the eigenvalues −2 ± i, so with N = A + 2,
/// N² = −1, exp(A t) = e^−2t (cos t + N sin t).
pub fn exact(t: f64) -> [f64; 2] {
    let (sin, cos) = t.sin_cos();
    let [x, y] = [1.0, 0.5];
    let decay = (-2.0 * t).exp();
    [
        decay * (x * cos + (x + 2.0 * y) * sin),
        decay * (y * cos + (-x - y) * sin),
    ]
}

pub fn master() -> Master<'static> {
    Master::new(pair(), coupled()).expect("connected")
}
