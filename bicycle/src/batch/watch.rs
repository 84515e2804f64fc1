//! Who is still riding.

use super::Plan;
use crate::dynamics::Bicycle;
use crate::lanes::Pack;
use crate::simulate::Stop;
use std::f64::consts::FRAC_PI_2;

/// Looks at every sample whether a lane has reached its steer limit or lies on its side.
pub(super) struct Watch<T> {
    limits: Vec<f64>,
    /// The smallest of them.
    strictest: f64,
    interval: f64,
    /// The steer angle at the sample before [rad].
    before: T,
    stops: Vec<Option<Stop>>,
    /// Which lanes go on from upright now.
    fallen: Vec<bool>,
}

impl<T: Pack> Watch<T> {
    pub fn new(bicycles: &[(Bicycle, f64)], plan: &Plan) -> Self {
        let limits: Vec<f64> = bicycles.iter().map(|(b, _)| b.p.steer_limit).collect();
        Self {
            strictest: limits.iter().copied().fold(f64::INFINITY, f64::min),
            stops: vec![None; limits.len()],
            fallen: vec![false; limits.len()],
            limits,
            interval: plan.interval,
            before: T::from(0.0),
        }
    }

    /// Whether a lane has to be raised before the ride goes on; notes why and when.
    #[inline(always)]
    pub fn is_down(&mut self, sample: usize, roll: T, steer: T) -> bool {
        let all_up = roll.all_small(FRAC_PI_2) & steer.all_small(self.strictest);
        let down = !all_up && self.note(sample, roll, steer);
        self.before = steer;
        down
    }

    #[inline(never)]
    fn note(&mut self, sample: usize, roll: T, steer: T) -> bool {
        for lane in 0..T::WIDTH {
            let (phi, theta) = (roll.lane(lane), steer.lane(lane));
            let (before, limit) = (self.before.lane(lane).abs(), self.limits[lane]);
            let turned = theta.abs() >= limit;
            // NaN lies, too
            self.fallen[lane] = turned || !(phi.abs() < FRAC_PI_2 && theta.is_finite());
            let from = sample.saturating_sub(1) as f64 * self.interval;
            let stop = if turned && theta.is_finite() {
                // straight between the samples
                let share = ((limit - before) / (theta.abs() - before)).clamp(0.0, 1.0);
                Stop::SteerLimit {
                    t: from + share * self.interval,
                }
            } else {
                Stop::Diverged { t: from }
            };
            if self.fallen[lane] && self.stops[lane].is_none() {
                self.stops[lane] = Some(stop);
            }
        }
        self.fallen.contains(&true)
    }

    /// Which lanes go on from upright, so that they do not disturb the others.
    pub fn fallen(&self) -> &[bool] {
        &self.fallen
    }

    /// Why and when each lane stopped.
    pub fn into_stops(self) -> Vec<Option<Stop>> {
        self.stops
    }
}
