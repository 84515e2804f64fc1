//! What is said of an oscillation: of a steering trace, and of the linear bicycle behind it.

use crate::dynamics::{Bicycle, Formulation};
use crate::modes::{self, Mode, Root};
use crate::parameters::Parameters;
use std::f64::consts::TAU;

/// Instants \[s\] at which a trace, sampled at `time`, turns back: the tops of the parabolas through
/// its extremes. One that rests before it turns, as a stuck fork does, turns in the middle of the
/// rest.
pub fn reversals(time: &[f64], trace: &[f64]) -> Vec<f64> {
    // steps that are none are rest
    let steps = trace.windows(2).zip(time.windows(2));
    let moves: Vec<(f64, &[f64])> = steps
        .map(|(y, t)| (y[1] - y[0], t))
        .filter(|(step, _)| *step != 0.0)
        .collect();
    let turns = moves.windows(2).filter(|pair| pair[0].0 * pair[1].0 < 0.0);
    turns
        .map(|pair| {
            let [(before, t0), (after, t1)] = [pair[0], pair[1]];
            let aside = 0.5 * (before + after) / (before - after);
            0.5 * (t0[1] + t1[0]) + aside * (t1[1] - t1[0])
        })
        .collect()
}

/// The dominant frequency [Hz] of a trace that turns back at `reversals` \[s\]: over the median of
/// its periods, each from one turn to the second after it. `None` of fewer than two turns.
///
/// Each swing counts the same, however small: the turns of a decaying oscillation come at the
/// frequency of its mode whatever its damping, and a drift moves them to and fro without changing
/// their periods. A periodogram of the few seconds of a case, in which most of the swing is its
/// decay, peaks at its lowest bin instead.
pub fn dominant_frequency(reversals: &[f64]) -> Option<f64> {
    if let [first, second] = *reversals {
        return Some(0.5 / (second - first));
    }
    let mut periods: Vec<f64> = reversals.windows(3).map(|t| t[2] - t[0]).collect();
    periods.sort_by(f64::total_cmp);
    let (low, high) = (periods.len().checked_sub(1)? / 2, periods.len() / 2);
    Some(2.0 / (periods[low] + periods[high]))
}

/// An oscillating mode of the linear bicycle: a pair of complex eigenvalues.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Oscillation {
    /// Its name; see [`crate::modes`] for what it means.
    pub mode: Mode,
    /// Imaginary part over 2π [Hz].
    pub frequency: f64,
    /// −Re λ/|λ| [–]: 1 does not swing, 0 does not decay, below 0 it grows.
    pub damping_ratio: f64,
}

impl Oscillation {
    /// The oscillating modes of the bicycle upright at `speed` [m/s], the slowest first, with the
    /// rider law in the loop as far as its gains are not zero. The jumps are left out.
    pub fn all(p: &Parameters, formulation: Formulation, speed: f64) -> Vec<Self> {
        let bicycle = Bicycle::new(p, formulation);
        let roots = modes::over_speeds(&bicycle, &[speed]).concat();
        let pairs = roots.into_iter().filter(|root| root.value.im > 0.0);
        let mut all: Vec<Self> = pairs
            .map(|Root { value, mode }| Self {
                mode,
                frequency: value.im / TAU,
                damping_ratio: -value.re / value.norm(),
            })
            .collect();
        all.sort_by(|a, b| a.frequency.total_cmp(&b.frequency));
        all
    }

    /// The least damped of them; `None` where nothing oscillates.
    pub fn least_damped(p: &Parameters, formulation: Formulation, speed: f64) -> Option<Self> {
        let all = Self::all(p, formulation, speed).into_iter();
        all.min_by(|a, b| a.damping_ratio.total_cmp(&b.damping_ratio))
    }
}
