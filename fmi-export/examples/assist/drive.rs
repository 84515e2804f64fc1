//! From sensors to torque: the clock asks the law, the watch may overrule it, the motor follows.

use super::clock::ticks;
use super::motor::{LONGEST_DEAD_TIME, Motor};
use fmi_export::Flow;
use fmi_export::serde::{Deserialize, Serialize};

/// More ticks in one communication step would not end in reasonable time.
const MOST_TICKS: f64 = 1e8;

/// Who wants less [N m] wants nothing: a bicycle at rest is no fault.
const NOTHING: f64 = 0.01;

/// The rows that every assist has; what they mean is said there.
#[derive(Clone, Copy, Debug)]
pub struct Settings {
    /// [s]
    pub sample_time: f64,
    /// [s]
    pub dead_time: f64,
    /// [N m]
    pub torque_limit: f64,
    /// [N m/s]
    pub torque_rate_limit: f64,
    /// [s]
    pub motor_time_constant: f64,
    /// [s]
    pub stale_time: f64,
}

impl Settings {
    /// Refuses, in words, a dead time that is no number of samples, or one of too many.
    pub fn check(&self) -> Result<(), String> {
        let samples = self.dead_time / self.sample_time;
        // the quotient of two decimal fractions is whole but for rounding
        if (samples - samples.round()).abs() > 1e-6 || samples.round() > LONGEST_DEAD_TIME as f64 {
            return Err(format!(
                "dead_time {} s: expected 0 to {LONGEST_DEAD_TIME} times sample_time, {} s",
                self.dead_time, self.sample_time
            ));
        }
        Ok(())
    }
}

/// Clock, watch and motor under way. `M` is what the sensors measure.
#[derive(Clone, Debug, Default, Serialize, Deserialize)]
#[serde(crate = "fmi_export::serde")]
pub struct Drive<M> {
    start: f64,
    /// The last sample, and for how many ticks it has been the same since.
    last: M,
    unchanged: u32,
    motor: Motor,
    fault: bool,
}

impl<M: Copy + Default + PartialEq> Drive<M> {
    /// At rest, the clock starting at `start` [s].
    pub fn new(start: f64) -> Self {
        Self {
            start,
            ..Self::default()
        }
    }

    /// Goes on from `t` to `t + h` [s] with the inputs as they are. At every tick `law` is given the
    /// torque of the motor and says which it wants [N m], or `None` where the inputs are no numbers.
    /// That, or sensors that say the same for longer than the stale time while the law wants a
    /// torque, is a fault: the motor is then asked for 0, until there are live numbers again.
    pub fn run(
        &mut self,
        s: &Settings,
        [t, h]: [f64; 2],
        measured: M,
        mut law: impl FnMut(f64) -> Option<f64>,
    ) -> Flow {
        if h / s.sample_time > MOST_TICKS {
            return Flow::Refuse(format!(
                "expected at most {MOST_TICKS} samples, {} s each, found a step of {h} s",
                s.sample_time
            ));
        }
        let mut now = t;
        for tick in ticks(self.start, s.sample_time, t, h) {
            self.motor.run(tick - now, s);
            now = now.max(tick);
            self.unchanged = if measured == self.last {
                self.unchanged.saturating_add(1)
            } else {
                0
            };
            self.last = measured;
            let demand = law(self.motor.torque).filter(|demand| demand.is_finite());
            let stale = f64::from(self.unchanged) * s.sample_time > s.stale_time;
            self.fault = demand.is_none_or(|demand| stale && demand.abs() > NOTHING);
            let granted = demand.filter(|_| !self.fault).unwrap_or(0.0);
            self.motor.command(granted, s);
        }
        self.motor.run(t + h - now, s);
        Flow::Continue
    }

    /// The torque on the fork [N m].
    pub fn torque(&self) -> f64 {
        self.motor.torque
    }

    /// Whether the last sample was no use.
    pub fn fault(&self) -> bool {
        self.fault
    }
}
