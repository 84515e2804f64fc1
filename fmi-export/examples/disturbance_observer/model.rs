//! Power steering by disturbance observer: it feels for the torque of rider and road with nothing
//! but the steer encoder and the motor's own current.
//!
//! ```text
//! J θ̈ + c θ̇ = τ + τ_m                        the fork: τ of rider and road, τ_m of the motor
//! τ̂ = Q(s) [(J s² + c s) θ − τ_m]            the observer (Ohnishi)
//! Q(s) = ω² / (s² + 2 ζ ω s + ω²)            of order 2, so that Q(s) s² needs no derivative
//! τ_m = α τ̂                                  the assist, within the limits of the motor
//! ```

use super::assist::{self, Drive, quantised};
use fmi_export::model_description::ModelDescription;
use fmi_export::serde::{Deserialize, Serialize};
use fmi_export::{Experiment, Flow, Model, Value};
use std::f64::consts::TAU;

assist::variables! {
    /// The variables of the disturbance observer.
    pub struct Variables {
        steer: f64 = 0.0, Input Continuous, unit "rad", "Steer angle, left positive";
        assist_gain: f64 = 1.0, Parameter Tunable, in [-0.95, 3.0], "Share α of the estimated torque that the motor adds: above 0 it helps, below 0 it resists";
        nominal_inertia: f64 = 0.25, Parameter Tunable, unit "kg.m2", in [0.0, 2.0], "Inertia J of the fork about the steer axis";
        nominal_friction: f64 = 0.0, Parameter Tunable, unit "N.m.s/rad", in [0.0, 10.0], "Viscous friction c of the steering; with 0 friction is a part of the estimate";
        observer_bandwidth: f64 = 3.0, Parameter Tunable, unit "Hz", in [0.1, 50.0], "Corner frequency ω/2π of the filter Q";
        observer_damping: f64 = 1.4, Parameter Tunable, in [0.3, 3.0], "Damping ratio ζ of the filter Q";
        steer_resolution: f64 = TAU / 4096.0, Parameter Tunable, unit "rad", in [0.0, 0.1], "Resolution of the steer encoder, 0 perfect";
        estimated_torque: f64 = 0.0, Local Continuous, unit "N.m", "Torque τ̂ of rider and road on the fork, left positive";
    }
}

/// A disturbance-observer power steering.
#[derive(Clone, Debug, Serialize, Deserialize)]
#[serde(crate = "fmi_export::serde")]
pub struct DisturbanceObserver {
    /// What an importer sees.
    pub variables: Variables,
    drive: Drive<f64>,
    /// None before the first sample, and after one that was no number.
    observer: Option<Observer>,
}

/// The filter Q over the steer angle, and over the torque of the motor.
#[derive(Clone, Copy, Debug, Serialize, Deserialize)]
#[serde(crate = "fmi_export::serde")]
struct Observer {
    steer: Filtered,
    motor_torque: Filtered,
}

/// A signal behind Q with its first and second derivative.
#[derive(Clone, Copy, Debug, Default, Serialize, Deserialize)]
#[serde(crate = "fmi_export::serde")]
struct Filtered {
    value: f64,
    rate: f64,
    acceleration: f64,
}

impl Filtered {
    /// A signal that has always been `value`.
    fn at(value: f64) -> Self {
        Self {
            value,
            ..Self::default()
        }
    }

    /// One sample of `time` [s] later, the signal being at `input`:
    /// ÿ + 2 ζ ω ẏ + ω² y = ω² u by the trapezoidal rule, stable for every ω.
    fn follow(&mut self, input: f64, omega: f64, zeta: f64, time: f64) {
        let half = 0.5 * time;
        let ahead = self.rate + half * self.acceleration;
        let pull = omega * omega * (input - self.value - half * (self.rate + ahead));
        self.acceleration = (pull - 2.0 * zeta * omega * ahead)
            / (1.0 + zeta * omega * time + (omega * half).powi(2));
        let rate = ahead + half * self.acceleration;
        self.value += half * (self.rate + rate);
        self.rate = rate;
    }
}

impl Variables {
    /// A sample: the torque wanted [N m], the motor being at `motor_torque` [N m].
    fn law(&mut self, observer: &mut Option<Observer>, motor_torque: f64) -> Option<f64> {
        if !self.steer.is_finite() {
            *observer = None;
            return None;
        }
        let steer = quantised(self.steer, self.steer_resolution);
        let observer = observer.get_or_insert(Observer {
            steer: Filtered::at(steer),
            motor_torque: Filtered::at(motor_torque),
        });
        let (omega, zeta) = (TAU * self.observer_bandwidth, self.observer_damping);
        for (filtered, input) in [
            (&mut observer.steer, steer),
            (&mut observer.motor_torque, motor_torque),
        ] {
            filtered.follow(input, omega, zeta, self.sample_time);
        }
        self.estimated_torque = self.nominal_inertia * observer.steer.acceleration
            + self.nominal_friction * observer.steer.rate
            - observer.motor_torque.value;
        Some(self.assist_gain * self.estimated_torque)
    }
}

impl Model for DisturbanceObserver {
    fn description() -> ModelDescription {
        assist::describe(
            "DisturbanceObserver",
            "Power steering by disturbance observer, from the steer angle alone",
            &Variables::rows(),
        )
    }

    fn new() -> Self {
        Self {
            variables: Variables::default(),
            drive: Drive::default(),
            observer: None,
        }
    }

    fn get(&self, reference: u32) -> Value {
        self.variables.value(reference)
    }

    fn set(&mut self, reference: u32, value: Value) {
        self.variables.assign(reference, value);
    }

    fn initialize(&mut self, experiment: &Experiment) -> Result<(), String> {
        self.variables.settings().check()?;
        self.variables.time = experiment.start_time;
        self.drive = Drive::new(experiment.start_time);
        self.observer = None;
        Ok(())
    }

    fn step(&mut self, t: f64, h: f64) -> Flow {
        let Self {
            variables: v,
            drive,
            observer,
        } = self;
        let flow = drive.run(&v.settings(), [t, h], v.steer, |motor_torque| {
            v.law(observer, motor_torque)
        });
        if flow == Flow::Continue {
            v.assist_torque = drive.torque();
            v.fault = drive.fault();
            v.time = t + h;
        }
        flow
    }
}
