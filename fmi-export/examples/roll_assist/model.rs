//! A steering assist that turns the fork into the lean, from a gyroscope under the saddle.
//!
//! ```text
//! τ_m = −s(V) (k_φ φ + k_p φ̇)                within the limits of the motor
//! s(V) = min(1, V/V_1) max(0, 1 − V/V_0)     none at standstill, and none from V_0 on
//! ```
//!
//! Roll is positive to the right and steer to the left, hence the sign.

use super::assist::{self, Drive, quantised};
use fmi_export::model_description::ModelDescription;
use fmi_export::serde::{Deserialize, Serialize};
use fmi_export::{Experiment, Flow, Model, Value};
use std::f64::consts::PI;

assist::variables! {
    /// The variables of the roll assist.
    pub struct Variables {
        roll: f64 = 0.0, Input Continuous, unit "rad", "Roll angle, right positive";
        roll_rate: f64 = 0.0, Input Continuous, unit "rad/s", "Roll rate, right positive";
        speed: f64 = 8.0 / 3.6, Input Continuous, unit "m/s", in [0.0, 20.0], "Forward speed";
        roll_gain: f64 = 60.0, Parameter Tunable, unit "N.m/rad", in [-1000.0, 1000.0], "Torque against roll k_φ, before the schedule";
        roll_rate_gain: f64 = 60.0, Parameter Tunable, unit "N.m.s/rad", in [-500.0, 500.0], "Torque against roll rate k_p, before the schedule";
        walking_speed: f64 = 1.0, Parameter Tunable, unit "m/s", in [0.1, 5.0], "Speed V_1 below which the assist fades: who pushes a bicycle leans it without wanting to turn";
        fade_speed: f64 = 6.5, Parameter Tunable, unit "m/s", in [0.1, 20.0], "Speed V_0 from which on there is no assist";
        roll_resolution: f64 = PI / 32768.0, Parameter Tunable, unit "rad", in [0.0, 0.1], "Resolution of the roll angle, 0 perfect";
        roll_rate_resolution: f64 = 200.0 / 180.0 * PI / 32768.0, Parameter Tunable, unit "rad/s", in [0.0, 0.1], "Resolution of the roll rate, 0 perfect";
    }
}

/// A roll-based steering assist.
#[derive(Clone, Debug, Serialize, Deserialize)]
#[serde(crate = "fmi_export::serde")]
pub struct RollAssist {
    /// What an importer sees.
    pub variables: Variables,
    drive: Drive<[f64; 2]>,
}

impl Variables {
    /// The torque wanted [N m], if the inputs are numbers.
    fn law(&self) -> Option<f64> {
        let roll = quantised(self.roll, self.roll_resolution);
        let roll_rate = quantised(self.roll_rate, self.roll_rate_resolution);
        let schedule = (self.speed / self.walking_speed).min(1.0)
            * (1.0 - self.speed / self.fade_speed).max(0.0);
        let torque = -schedule * (self.roll_gain * roll + self.roll_rate_gain * roll_rate);
        [roll, roll_rate, self.speed]
            .iter()
            .all(|input| input.is_finite())
            .then_some(torque)
    }
}

impl Model for RollAssist {
    fn description() -> ModelDescription {
        assist::describe(
            "RollAssist",
            "Steering assist from roll angle and roll rate, scheduled with speed",
            &Variables::rows(),
        )
    }

    fn new() -> Self {
        Self {
            variables: Variables::default(),
            drive: Drive::default(),
        }
    }

    fn get(&self, reference: u32) -> Value {
        self.variables.value(reference)
    }

    fn set(&mut self, reference: u32, value: Value) {
        self.variables.assign(reference, value);
    }

    fn initialize(&mut self, experiment: &Experiment) -> Result<(), String> {
        let v = &mut self.variables;
        v.settings().check()?;
        v.time = experiment.start_time;
        self.drive = Drive::new(v.time);
        Ok(())
    }

    fn step(&mut self, t: f64, h: f64) -> Flow {
        let v = &mut self.variables;
        let measured = [v.roll, v.roll_rate];
        let flow = self.drive.run(&v.settings(), [t, h], measured, |_| v.law());
        if flow == Flow::Continue {
            v.assist_torque = self.drive.torque();
            v.fault = self.drive.fault();
            v.time = t + h;
        }
        flow
    }
}
