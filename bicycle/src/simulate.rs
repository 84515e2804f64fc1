//! The reference stepper: classical Runge–Kutta on a fixed grid, exact arrival at any instant, the
//! steer limit located in time. FMU, native runs and oracles all use this one.

use crate::dynamics::{self, Bicycle, Formulation};
use crate::linear;
use crate::parameters::Parameters;
use crate::quantity::{Variability, Vector};
use crate::real::Real;
use crate::state::{Input, Output, Path, State};
use std::f64::consts::FRAC_PI_2;
use std::fmt;

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

/// Why a simulation ended before it was asked to.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Stop {
    /// |steer| reached `steer_limit` at time `t` [s].
    SteerLimit {
        /// Time of the event [s].
        t: f64,
    },
    /// After time `t` [s] the bicycle lay on its side (|roll| > 90°) or a state was not finite.
    Diverged {
        /// Last time with a meaningful state [s].
        t: f64,
    },
}

impl Stop {
    /// When it ended [s].
    pub fn time(self) -> f64 {
        match self {
            Self::SteerLimit { t } | Self::Diverged { t } => t,
        }
    }

    /// The word for it in files: `steer_limit` or `diverged`.
    pub fn name(self) -> &'static str {
        match self {
            Self::SteerLimit { .. } => "steer_limit",
            Self::Diverged { .. } => "diverged",
        }
    }
}

impl fmt::Display for Stop {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        match self {
            Self::SteerLimit { t } => write!(f, "the steer limit was reached at {t} s"),
            Self::Diverged { t } => write!(f, "the bicycle fell over after {t} s"),
        }
    }
}

impl std::error::Error for Stop {}

/// Why a simulation was not started, or a change not taken.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Refusal {
    /// The internal step is too long for explicit steps of these parameters.
    StepTooLong {
        /// The row `internal_step` [s].
        step: f64,
        /// The longest stable step [s].
        limit: f64,
    },
    /// The load lifts the front wheel.
    FrontLifted {
        /// Front normal load [N].
        front_load: f64,
    },
}

impl fmt::Display for Refusal {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        match self {
            Self::StepTooLong { step, limit } => write!(
                f,
                "internal_step: expected less than {limit:.3e} s, the stability limit of these \
                 parameters at this speed, found {step:.3e} s"
            ),
            Self::FrontLifted { front_load } => {
                write!(
                    f,
                    "expected a front wheel on the ground, found a front load of {front_load:.1} N"
                )
            }
        }
    }
}

impl std::error::Error for Refusal {}

/// Every z = h λ with Re z ≤ 0 and |z| up to this lies in the stability region of [`rk4`]; its
/// border comes nearest to the origin, 2.616, at 123° (2.785 on the real, 2.828 on the imaginary axis).
const STABLE_RADIUS: f64 = 2.6;

/// Longest step [s] of [`rk4`] at `speed` [m/s] with which every decaying mode of the bicycle
/// upright decays, smoothed Coulomb friction (a jump, width 0, has no slope) and rider law included.
/// A bound a few per cent short of the limit, 0 where there is none.
pub fn stability_limit(b: &Bicycle, speed: f64) -> f64 {
    let mut upright = *b;
    if b.p.steer_rate_smoothing == 0.0 {
        upright.p.coulomb_friction = 0.0;
    }
    let input = Input {
        speed,
        ..Input::default()
    };
    let (a, _) = linear::linearize(&upright, &State::default(), &input);
    STABLE_RADIUS / linear::spectral_bound(&a)
}

/// State and path at a time.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Moment {
    time: f64,
    state: State,
    path: Path,
}

/// A bicycle under way.
///
/// The internal grid is t₀ + n·Δ (Δ the row `internal_step`). An arrival between grid points is
/// computed on a copy; the grid state is kept as long as no input and no parameter changes value
/// (compared bitwise). When one does, the copy becomes the state at that instant, and the next
/// internal step is shortened to end on the next grid point. So results depend on the instants of
/// change, not on how often one looks (but for a steer limit that is passed and left again within
/// one internal step: only who looks in between sees it). Cloning gives a second bicycle that goes on from here.
#[derive(Debug, Clone)]
pub struct Simulation {
    bicycle: Bicycle,
    input: Input,
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
        check(&bicycle, &input)?;
        let state = State {
            roll_rate: parameters.roll_rate_start,
            steer_rate: parameters.steer_rate_start,
            roll: parameters.roll_start,
            steer: parameters.steer_start,
            yaw_rate: parameters.yaw_rate_start,
        };
        let start = Moment {
            time: start_time,
            state,
            path: Path::default(),
        };
        Ok(Self {
            bicycle,
            input,
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

    /// Sets the inputs from here on.
    pub fn set_input(&mut self, input: Input) -> Result<(), Refusal> {
        if bits(&input.to_array()) != bits(&self.input.to_array()) {
            if input.speed.to_bits() != self.input.speed.to_bits() {
                check(&self.bicycle, &input)?;
            }
            self.input = input;
            self.settle();
        }
        Ok(())
    }

    /// Sets the tunable parameters from here on; fixed rows keep the values they started with.
    pub fn set_parameters(&mut self, parameters: &Parameters) -> Result<(), Refusal> {
        self.set(parameters, self.input)
    }

    /// Sets tunable parameters and inputs at once, refused or taken together.
    pub fn set(&mut self, parameters: &Parameters, input: Input) -> Result<(), Refusal> {
        let (old, new) = (self.bicycle.p.to_array(), parameters.to_array());
        let values = std::array::from_fn(|i| match Parameters::TABLE[i].variability {
            Variability::Fixed => old[i],
            Variability::Tunable | Variability::Continuous => new[i],
        });
        if bits(&values) == bits(&old) {
            return self.set_input(input);
        }
        let bicycle = Bicycle::new(&Parameters::from_array(values), self.bicycle.formulation);
        check(&bicycle, &input)?;
        self.bicycle = bicycle;
        self.input = input;
        self.settle();
        Ok(())
    }

    /// The copy becomes the state: something changes at this instant.
    fn settle(&mut self) {
        if self.ahead {
            self.base = self.here;
            self.base_on_grid = false;
            self.ahead = false;
        }
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
        // instants closer than this are one: a billionth of a step, or the rounding of `to`
        let slack = (1e-9 * step).max(4.0 * (to.abs().next_up() - to.abs()));
        loop {
            let grid = self.start_time + self.next as f64 * step;
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
        Ok(())
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
        let (b, u) = (&self.bicycle, &self.input);
        self.derivatives += 4;
        let (state, path) = rk4((from.state, from.path), h, |_, (x, path)| {
            (
                dynamics::derivative(b, x, u),
                dynamics::path_derivative(x, path, u.speed),
            )
        });
        Moment {
            time: from.time + h,
            state,
            path,
        }
    }

    /// Where we are [s].
    pub fn time(&self) -> f64 {
        self.here.time
    }

    /// The state there.
    pub fn state(&self) -> &State {
        &self.here.state
    }

    /// Everything that can be seen there.
    pub fn output(&self) -> Output {
        dynamics::output(
            &self.bicycle,
            &self.here.state,
            &self.here.path,
            &self.input,
        )
    }

    /// The parameters in force.
    pub fn parameters(&self) -> &Parameters {
        &self.bicycle.p
    }

    /// The inputs in force.
    pub fn input(&self) -> &Input {
        &self.input
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

fn bits<const N: usize>(values: &[f64; N]) -> [u64; N] {
    values.map(f64::to_bits)
}

/// The conditions under which explicit steps make sense.
fn check(b: &Bicycle, u: &Input) -> Result<(), Refusal> {
    if b.front_load <= 0.0 {
        return Err(Refusal::FrontLifted {
            front_load: b.front_load,
        });
    }
    let (step, limit) = (b.p.internal_step, stability_limit(b, u.speed));
    if step > limit {
        return Err(Refusal::StepTooLong { step, limit });
    }
    Ok(())
}
