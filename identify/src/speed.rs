//! The speed of a ride as an input of a simulation: measured, not constant.

use crate::bicycles::admit;
use crate::error::Result;
use crate::ride::{Ride, SPEED, quantity};

/// A speed over time: straight between its samples, constant before the first and after the last.
/// Time is that of the simulation; the first sample is at 0.
#[derive(Debug, Clone, PartialEq)]
pub struct SpeedTrace {
    step: f64,
    samples: Vec<f64>,
}

impl SpeedTrace {
    /// The `samples` [m/s], `step` [s] apart. Each must lie in the range of its row.
    pub fn new(step: f64, samples: Vec<f64>) -> Result<Self> {
        let row = quantity(SPEED)?;
        for &speed in &samples {
            admit(row, speed)?;
        }
        admit(row, samples.first().copied().unwrap_or(f64::NAN))?;
        Ok(Self { step, samples })
    }

    /// The speed recorded in `ride`, which must move throughout.
    pub fn of(ride: &Ride) -> Result<Self> {
        let samples = ride.channel(SPEED)?.to_vec();
        ride.check_moving()?;
        Self::new(ride.step(), samples).map_err(|cause| cause.in_file(ride.name()))
    }

    /// Time of the last sample [s].
    pub fn duration(&self) -> f64 {
        (self.samples.len() - 1) as f64 * self.step
    }

    /// The speed at time `t` [s], in m/s.
    pub fn at(&self, t: f64) -> f64 {
        let last = self.samples.len() - 1;
        let position = (t / self.step).clamp(0.0, last as f64);
        let i = (position as usize).min(last.saturating_sub(1));
        let next = self.samples[(i + 1).min(last)];
        self.samples[i] + (position - i as f64) * (next - self.samples[i])
    }

    /// The mean slope from time `t` to `until` [s], in m/s².
    pub fn slope(&self, t: f64, until: f64) -> f64 {
        (self.at(until) - self.at(t)) / (until - t)
    }

    /// The time of the first sample after time `t`, none after the last [s].
    pub fn next(&self, t: f64) -> Option<f64> {
        // a billionth of a step forgives the rounding of times
        let nth = (t / self.step + 1e-9).floor() + 1.0;
        (nth >= 1.0 && nth < self.samples.len() as f64).then_some(nth * self.step)
    }
}
