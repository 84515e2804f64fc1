//! The reference stepper: classical Runge–Kutta on a fixed grid, exact arrival at any instant, the
//! steer limit located in time. FMU, native runs and oracles all use this one.

mod change;
mod look;
mod ramp;
mod saved;
mod stability;
mod stop;

pub use stability::{Refusal, stability_limit};
pub use stop::Stop;

use crate::dynamics::{self, Bicycle, Formulation};
use crate::parameters::Parameters;
use crate::quantity::Vector;
use crate::real::Real;
use crate::state::{Input, Path, State};
use ramp::Ramp;
use saved::Saved;
use serde::{Deserialize, Serialize};
use stability::StableSpeeds;
use std::f64::consts::FRAC_PI_2;

/// One step of the classical fourth-order Runge–Kutta method; `f` is given the fraction of the
/// step (0, ½, 1) and the state there.
pub fn rk4<T: Real, X: Vector<T>>(x: X, h: T, mut f: impl FnMut(f64, &X) -> X) -> X {
    let (half, sixth) = (h * T::from(0.5), h * T::from(1.0 / 6.0));
    let third = sixth + sixth;
    let k1 = f(0.0, &x);
    let k2 = f(0.5, &x.along(half, &k1));
    let k3 = f(0.5, &x.along(half, &k2));
    let k4 = f(1.0, &x.along(h, &k3));
    x.along(sixth, &k1)
        .along(third, &k2)
        .along(third, &k3)
        .along(sixth, &k4)
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

    /// One internal step of `h` from `from`; on a stop, `here` is left where it happened.
    fn travel(&mut self, from: Moment, h: f64) -> Result<Moment, Stop> {
        let limit = self.bicycle.p.steer_limit;
        let at_limit = |m: &Moment| m.state.steer.abs() >= limit;
        let fallen = |m: &Moment| {
            m.state.roll.abs() > FRAC_PI_2 || !m.state.to_array().iter().all(|v| v.is_finite())
        };
        let to = self.rk4(from, h);
        if at_limit(&to) {
            let [_, at] = self.locate(from, h, at_limit);
            return Err(self.end(at, Stop::SteerLimit { t: at.time }));
        }
        if fallen(&to) {
            let [last, _] = self.locate(from, h, fallen);
            return Err(self.end(last, Stop::Diverged { t: last.time }));
        }
        Ok(to)
    }

    fn end(&mut self, at: Moment, stop: Stop) -> Stop {
        self.here = at;
        self.ahead = true;
        self.stop = Some(stop);
        stop
    }

    /// The last moment before `happened` and the first at which it has, next to each other to the
    /// last bit of h, within a step of `h` at whose end it has: bisection on the length of a step
    /// of the same method.
    fn locate(&mut self, from: Moment, h: f64, happened: impl Fn(&Moment) -> bool) -> [Moment; 2] {
        let (mut before, mut after, mut last) = (0.0, h, from);
        loop {
            let middle = 0.5 * (before + after);
            if middle <= before || middle >= after {
                return [last, self.rk4(from, after)];
            }
            let moment = self.rk4(from, middle);
            if happened(&moment) {
                after = middle;
            } else {
                (before, last) = (middle, moment);
            }
        }
    }

    fn rk4(&mut self, from: Moment, h: f64) -> Moment {
        let (b, ramp) = (&self.bicycle, &self.ramp);
        self.derivatives += 4;
        let (state, path) = rk4((from.state, from.path), h, |fraction, (x, path)| {
            let u = ramp.at(from.time + fraction * h);
            (
                dynamics::derivative(b, x, &u),
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
