//! Many rides together: parameter sets, excitations and initial states side by side in lanes, for
//! the identification. The same source runs on plain numbers, a batch of one.
//!
//! `repaired` goes by an exponential two-step method. The equations are split into
//!
//! ```text
//! ẋ = A x + n(x) + ∂ẋ/∂τ (u + B(x) s(θ) − d s(θ̇))
//! ```
//!
//! with A the Jacobian upright, rider law included, jumps left out; n what is left of the smooth
//! equations; u the torque from outside; s the smoothed signs. The linear part is exact, with
//! exp(A h) and its φ-functions made once for each bicycle; n enters by an exponential Adams
//! predictor and corrector (Hochbruck & Ostermann 2010, section 4); the jumps, which are what
//! limits other methods, by their exact means along the path foreseen. One evaluation of n a step.
//! The other formulations go by the reference method ([`crate::simulate::rk4`]).
//!
//! Between samples the torque runs straight, and that is integrated exactly.

mod exponential;
mod paper;
mod ride;
mod runge_kutta;
mod step;
mod watch;

use crate::dynamics::{Bicycle, Formulation};
use crate::lanes::Pack;
use crate::linear::Upright;
use crate::parameters::Parameters;
use crate::simulate::{self, Refusal, Stop};
use crate::state::State;
use paper::Paper;
use ride::System;
use std::fmt;
use watch::Watch;

/// When a batch is looked at.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Plan {
    /// Between samples \[s\].
    pub interval: f64,
    /// How many samples, the start being the first.
    pub samples: usize,
    /// Steps of the two-step method to a sample, at least 1. With 2.5 ms the error is below 2e-5 rad
    /// on bounded rides, with 5 ms below 1.2e-4 rad.
    pub steps_per_sample: usize,
}

impl Plan {
    /// `duration` [s] sampled 200 times a second, 2.5 ms to a step.
    pub fn of(duration: f64) -> Self {
        let interval = 5e-3;
        Self {
            interval,
            samples: (duration / interval).round() as usize,
            steps_per_sample: 2,
        }
    }

    /// The step [s].
    pub fn step(&self) -> f64 {
        self.interval / self.steps_per_sample as f64
    }
}

/// One ride of a batch.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Lane {
    /// The bicycle and its rider law.
    pub parameters: Parameters,
    /// Its speed [m/s].
    pub speed: f64,
    /// Where it starts.
    pub start: State,
}

/// The torque that acts besides the rider law [N m] at each sample.
pub trait Torque<T> {
    /// At sample `k`. To be marked `#[inline(always)]`.
    fn at(&self, k: usize) -> T;
}

/// One torque for all lanes.
impl<T: Pack> Torque<T> for [f64] {
    #[inline(always)]
    fn at(&self, k: usize) -> T {
        T::from(self[k])
    }
}

/// A torque for each lane, at least as long as the ride; the last one serves the lanes that are
/// left over.
impl<T: Pack> Torque<T> for [&[f64]] {
    #[inline(always)]
    fn at(&self, k: usize) -> T {
        T::from_fn(|lane| self[lane.min(self.len() - 1)][k])
    }
}

/// What is made of the states while they are at hand.
pub trait See<T> {
    /// The states at sample `k`. To be marked `#[inline(always)]`.
    fn sample(&mut self, k: usize, x: &State<T>);
}

/// The work a batch took.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
struct Ended {
    derivatives: u64,
}

/// How a batch went.
#[derive(Debug, Clone, PartialEq)]
pub struct Outcome {
    /// Why each ride ended early, if it did; located between samples. What was seen of it from then
    /// on means nothing: its lane goes on from upright, so as not to disturb the others.
    pub stops: Vec<Option<Stop>>,
    /// Evaluations of the derivative, each for all lanes.
    pub derivatives: u64,
}

/// Why a batch was not ridden.
#[derive(Debug, Clone, PartialEq)]
pub enum Unfit {
    /// No equation of motion says anything about a lane.
    Lane {
        /// Which.
        lane: usize,
        /// Why.
        refusal: Refusal,
    },
    /// A smoothing width is 0: jumps are located by [`crate::simulate::Simulation`] only.
    Jump {
        /// Which lane.
        lane: usize,
        /// The row of the table.
        name: &'static str,
    },
    /// There are no lanes, or more than are advanced together.
    Lanes {
        /// How many there are.
        found: usize,
        /// How many there may be.
        most: usize,
    },
    /// A plan without samples or steps.
    Empty,
}

impl fmt::Display for Unfit {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        match self {
            Self::Lane { lane, refusal } => write!(f, "lane {lane}: {refusal}"),
            Self::Jump { lane, name } => {
                write!(f, "lane {lane}: {name}: expected a width above 0, found 0")
            }
            Self::Lanes { found, most } => {
                write!(f, "expected 1 to {most} lanes, found {found}")
            }
            Self::Empty => write!(f, "expected samples and steps between them, found none"),
        }
    }
}

impl std::error::Error for Unfit {}

/// Rides up to [`Pack::WIDTH`] lanes together; fewer are filled up with copies of the last.
#[inline(always)]
pub fn ride<T: Pack>(
    lanes: &[Lane],
    formulation: Formulation,
    plan: &Plan,
    torque: &(impl Torque<T> + ?Sized),
    see: &mut impl See<T>,
) -> Result<Outcome, Unfit> {
    let bicycles = ready::<T>(lanes, formulation, plan)?;
    let last = lanes.len() - 1;
    let row = |i: usize| T::from_fn(|lane| lanes[lane.min(last)].start.get(i));
    let mut watch = Watch::new(&bicycles, plan);
    let ended = if formulation == Formulation::Repaired {
        let upright = bicycles.iter().map(|(b, v)| Upright::<5>::new(b).at(*v));
        let upright: Vec<_> = upright.collect();
        let entry = |i: usize, j: usize| T::from_fn(|lane| upright[lane][(i, j)]);
        let matrix = std::array::from_fn(|i| std::array::from_fn(|j| entry(i, j)));
        let mut direction = [T::from(0.0); 5];
        direction[1] = T::from_fn(|lane| 1.0 / bicycles[lane].0.steering_inertia);
        let system = System {
            remainder: &Paper::new(&bicycles),
            matrix: &matrix,
            torque: &direction,
        };
        let start = std::array::from_fn(row);
        ride::ride(&system, start, plan, &By(torque), &mut watch, see)
    } else {
        let start = State::from_array(std::array::from_fn(row));
        runge_kutta::ride(&bicycles, start, plan, &By(torque), &mut watch, see)
    };
    let mut stops = watch.into_stops();
    stops.truncate(lanes.len());
    Ok(Outcome {
        stops,
        derivatives: ended.derivatives,
    })
}

/// A torque by reference, of known size.
struct By<'a, U: ?Sized>(&'a U);

impl<T, U: Torque<T> + ?Sized> Torque<T> for By<'_, U> {
    #[inline(always)]
    fn at(&self, k: usize) -> T {
        self.0.at(k)
    }
}

/// The bicycles and speeds of all lanes, checked.
fn ready<T: Pack>(
    lanes: &[Lane],
    formulation: Formulation,
    plan: &Plan,
) -> Result<Vec<(Bicycle, f64)>, Unfit> {
    let (found, most) = (lanes.len(), T::WIDTH);
    if !(1..=most).contains(&found) {
        return Err(Unfit::Lanes { found, most });
    }
    if plan.samples == 0 || plan.steps_per_sample == 0 || plan.interval.is_nan() {
        return Err(Unfit::Empty);
    }
    let mut bicycles = Vec::with_capacity(most);
    for (lane, ridden) in lanes.iter().enumerate() {
        let b = Bicycle::new(&ridden.parameters, formulation);
        simulate::check(&b, ridden.speed).map_err(|refusal| Unfit::Lane { lane, refusal })?;
        let p = &ridden.parameters;
        let steers = !formulation.has_four_bodies();
        if steers && p.steer_smoothing <= 0.0 {
            let name = "steer_smoothing";
            return Err(Unfit::Jump { lane, name });
        }
        if p.coulomb_friction != 0.0 && p.steer_rate_smoothing <= 0.0 {
            let name = "steer_rate_smoothing";
            return Err(Unfit::Jump { lane, name });
        }
        bicycles.push((b, ridden.speed));
    }
    bicycles.resize(most, bicycles[found - 1]);
    Ok(bicycles)
}

#[cfg(test)]
mod tests;
