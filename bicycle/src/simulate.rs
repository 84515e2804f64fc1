//! The reference stepper: classical Runge–Kutta on a fixed grid, exact arrival at any instant; the
//! steer limit and, where a smoothing width is 0, the jumps located in time. FMU, native runs and
//! oracles all use this one.

mod change;
pub(crate) mod jump;
mod look;
mod ramp;
mod saved;
mod stability;
mod stop;
mod travel;

pub use jump::output;
pub use stability::{Refusal, check, stability_limit};
pub use stop::Stop;

use crate::dynamics::{self, Bicycle, Formulation};
use crate::parameters::Parameters;
use crate::quantity::Vector;
use crate::real::Real;
use crate::state::{Input, Path, State};
use jump::Mode;
use ramp::Ramp;
use saved::Saved;
use serde::{Deserialize, Serialize};
use stability::StableSpeeds;

/// The classical fourth-order Runge–Kutta method, stage by stage: the fraction of the step at which
/// the slope is taken, its weight in the step, and how far along it the next stage lies, both in
/// steps.
pub const STAGES: [(f64, f64, f64); 4] = [
    (0.0, 1.0 / 6.0, 0.5),
    (0.5, 1.0 / 3.0, 0.5),
    (0.5, 1.0 / 3.0, 1.0),
    (1.0, 1.0 / 6.0, 1.0),
];

/// One step by [`STAGES`]; `f` is given the fraction of the step and the state there.
#[inline(always)]
pub fn rk4<T: Real, X: Vector<T>>(x: X, h: T, mut f: impl FnMut(f64, &X) -> X) -> X {
    let (mut sum, mut stage) = (x, x);
    for (fraction, weight, reach) in STAGES {
        let slope = f(fraction, &stage);
        sum = sum.along(h * T::from(weight), &slope);
        stage = x.along(h * T::from(reach), &slope);
    }
    sum
}

/// State and path at a time.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
struct Moment {
    time: f64,
    state: State,
    path: Path,
}

/// A bicycle under way.
///
/// The internal grid is t₀ + n·Δ (Δ the row `internal_step`). An arrival between grid points is
/// computed on a copy; the grid state is kept as long as no input, no slope of an input and no
/// parameter changes value (compared bitwise). When one does, the copy becomes the state at that
/// instant, and the next internal step is shortened to end on the next grid point. So results
/// depend on the instants of change, not on how often one looks (but for a steer limit that is
/// passed and left again within one internal step: only who looks in between sees it).
///
/// With a smoothing width of 0 the sign is a jump. The step then ends where θ = 0 (sign θ) or θ̇ = 0
/// (Coulomb friction), located in time, and goes on from there on the other side; or friction holds
/// the fork, θ̇ = 0 exactly, until the net torque without it exceeds d, which is located as well. So
/// the method keeps its order. What comes and goes again within one piece of a step is not seen.
/// A step has 16 pieces at most: where more would follow, the last one runs on to the end of the
/// step, from rest if the fork was swinging about θ = 0 in ever shorter arcs.
///
/// Inputs run straight in time, u(t) = u + u̇ (t − t_c) from the instant of change t_c on; every
/// stage of a step takes them at its own time. Setting the values that they have just reached, with
/// the same slopes, is no change: they go on from t_c.
///
/// Cloning gives a second bicycle that goes on from here, and so does saving and restoring, to the
/// last bit. What is restored is checked first: whatever the bytes, [`Self::advance`] then neither
/// panics nor works longer than it was asked to. Parameters outside the ranges of their rows, which
/// are allowed under way, are refused there.
#[derive(Debug, Clone, Serialize, Deserialize)]
#[serde(try_from = "Saved", into = "Saved")]
pub struct Simulation {
    bicycle: Bicycle,
    /// Speeds at which this bicycle can be stepped.
    stable: StableSpeeds,
    ramp: Ramp,
    start_time: f64,
    /// Where the next internal step starts: a grid point or the instant of the last change.
    base: Moment,
    base_on_grid: bool,
    /// Number of the first grid point after `base`.
    next: u64,
    /// Where we have arrived.
    here: Moment,
    /// Whether `here` is a copy ahead of `base`.
    ahead: bool,
    stop: Option<Stop>,
    derivatives: u64,
}

impl Simulation {
    /// A bicycle at `start_time` [s] in the state of the `*_start` rows.
    pub fn new(
        parameters: &Parameters,
        formulation: Formulation,
        input: Input,
        start_time: f64,
    ) -> Result<Self, Refusal> {
        let bicycle = Bicycle::new(parameters, formulation);
        let stable = StableSpeeds::around(&bicycle, input.speed)?;
        let start = Moment {
            time: start_time,
            state: parameters.start(),
            path: Path::default(),
        };
        Ok(Self {
            bicycle,
            stable,
            ramp: Ramp::constant(input, start_time),
            start_time,
            base: start,
            base_on_grid: true,
            next: 1,
            here: start,
            ahead: false,
            stop: None,
            derivatives: 0,
        })
    }

    /// Goes on to time `to` [s] (no further back than [`Self::time`]) and arrives exactly there,
    /// or stops on the way and stays where it stopped.
    pub fn advance(&mut self, to: f64) -> Result<(), Stop> {
        if let Some(stop) = self.stop {
            return Err(stop);
        }
        if to <= self.here.time || !to.is_finite() {
            return Ok(());
        }
        let step = self.bicycle.p.internal_step;
        let slack = slack(step, to);
        loop {
            let grid = self.grid(self.next);
            if grid > to + slack {
                break;
            }
            let h = if self.base_on_grid {
                step
            } else {
                grid - self.base.time
            };
            self.base = Moment {
                time: grid,
                ..self.travel(self.base, h)?
            };
            self.base_on_grid = true;
            self.next += 1;
            self.here = self.base;
            self.ahead = false;
        }
        let rest = to - self.base.time;
        self.ahead = rest > slack;
        let arrival = if self.ahead {
            self.travel(self.base, rest)?
        } else {
            self.base
        };
        self.here = Moment {
            time: to,
            ..arrival
        };
        if self.ramp.slope.speed != 0.0 {
            self.note_speed();
        }
        Ok(())
    }

    /// The time of grid point `n` [s].
    fn grid(&self, n: u64) -> f64 {
        self.start_time + n as f64 * self.bicycle.p.internal_step
    }

    /// The time at which the equations see us [s]: the grid point's, where we are on one up to
    /// rounding.
    fn instant(&self) -> f64 {
        if self.ahead {
            self.here.time
        } else {
            self.base.time
        }
    }

    fn rk4(&mut self, from: Moment, h: f64, mode: Mode) -> Moment {
        let (b, ramp) = (&self.bicycle, &self.ramp);
        self.derivatives += 4 * mode.evaluations();
        let (state, path) = rk4((from.state, from.path), h, |fraction, (x, path)| {
            let u = ramp.at(from.time + fraction * h);
            (
                mode.derivative(b, x, &u),
                dynamics::path_derivative(b, x, path, u.speed),
            )
        });
        Moment {
            time: from.time + h,
            state,
            path,
        }
    }

    /// The parameters in force.
    pub fn parameters(&self) -> &Parameters {
        &self.bicycle.p
    }

    /// The bicycle in force.
    pub fn bicycle(&self) -> &Bicycle {
        &self.bicycle
    }

    /// Why it ended, if it did.
    pub fn stop(&self) -> Option<Stop> {
        self.stop
    }

    /// How often the derivative has been evaluated: the work done.
    pub fn derivatives(&self) -> u64 {
        self.derivatives
    }
}

/// Instants closer to `time` [s] than this are one with it: a billionth of a step, or the rounding
/// of `time`.
fn slack(step: f64, time: f64) -> f64 {
    (1e-9 * step).max(4.0 * (time.abs().next_up() - time.abs()))
}
