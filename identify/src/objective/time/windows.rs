//! Which windows may be replayed, and what of a ride they leave out.

use super::Time;
use super::noise::deviation;
use crate::error::{Error, Result};
use crate::inspect::glitches;
use crate::objective::Unknowns;
use crate::ride::Ride;
use bicycle::{Formulation, linear};
use nalgebra::Complex;
use std::ops::Range;

/// Growth of a start's error over a window, as exponent, beyond which a search cannot begin at
/// what was measured.
const GROWTH: f64 = 1.5;
/// The same beyond which windows are refused: the equations square it, and of sixteen digits six
/// are left.
const MOST_GROWTH: f64 = 12.0;

/// Windows of `length` samples, one after the other, over the rows in which the bicycle moves and
/// nothing sticks out.
pub(super) fn cut(ride: &Ride, length: usize) -> Vec<Range<usize>> {
    let mut out = vec![false; ride.len()];
    for span in ride.standstill() {
        let sample = |t: f64| ((t - ride.time(0)) / ride.step()).round() as usize;
        out[sample(span.start)..=sample(span.stop)].fill(true);
    }
    for (_, samples) in ride.channels() {
        if let Some((_, farthest)) = glitches(samples, deviation(samples)) {
            out[farthest] = true;
        }
    }
    let mut windows = Vec::new();
    let mut first = 0;
    for stretch in out.chunk_by(|a, b| a == b) {
        if !stretch[0] {
            let starts = (first..first + stretch.len() + 1 - length.min(stretch.len() + 1))
                .step_by(length)
                .filter(|start| start + length <= first + stretch.len());
            windows.extend(starts.map(|start| start..start + length));
        }
        first += stretch.len();
    }
    windows
}

/// Refuses jumps: the windows' equations are differentiated.
pub(super) fn check_smooth(unknowns: &Unknowns, formulation: Formulation) -> Result<()> {
    let p = &unknowns.start.parameters;
    let rubs = p.coulomb_friction != 0.0 || unknowns.seeks("coulomb_friction");
    if p.steer_rate_smoothing == 0.0 && rubs {
        let name = "steer_rate_smoothing";
        return Err(Error::Jump { name });
    }
    if p.steer_smoothing == 0.0 && !formulation.has_four_bodies() {
        let name = "steer_smoothing";
        return Err(Error::Jump { name });
    }
    Ok(())
}

impl Time {
    /// The fastest growth [1/s] of the start's bicycle as it is replayed at `speed` [m/s].
    fn growth(&self, speed: f64) -> Complex<f64> {
        let p = self.replayed(&self.unknowns.start.parameters);
        linear::fastest_growth(&p, self.formulation, speed)
    }

    /// The longest window [s] whose search may begin at what was measured.
    pub(super) fn longest_immediate(&self, speed: f64) -> Result<f64> {
        let worst = self.growth(speed);
        if worst.re.is_nan() {
            return Err(Error::WindowTooLong {
                window: f64::NAN,
                limit: f64::NAN,
                re: worst.re,
                im: worst.im,
                exponent: MOST_GROWTH,
            });
        }
        Ok(if worst.re > 0.0 {
            GROWTH / worst.re
        } else {
            f64::INFINITY
        })
    }

    /// Refuses windows over which errors of the start would grow too far.
    pub(in crate::objective) fn check_growth(&self, window: f64, speed: f64) -> Result<()> {
        let worst = self.growth(speed);
        let limit = MOST_GROWTH / worst.re;
        if worst.re > 0.0 && window > limit {
            return Err(Error::WindowTooLong {
                window,
                limit,
                re: worst.re,
                im: worst.im.abs(),
                exponent: MOST_GROWTH,
            });
        }
        Ok(())
    }
}
