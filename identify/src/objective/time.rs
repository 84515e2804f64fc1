//! `time`: the recorded torque replayed in short windows, multiple shooting.
//!
//! The ridden bicycle is unstable, so errors of a start grow: a whole ride cannot be replayed, and
//! is refused with the eigenvalue named. Each window has a free initial state, eliminated from the
//! equations; standard errors come from the scatter between windows (those of Gauss–Newton are
//! three times too small). Bock 1987; Liang & Zeger 1986.

mod replay;

pub use replay::Replay;

use super::spectral::estimated_noise;
use super::{Information, Unknowns};
use crate::error::{Error, Result};
use crate::ride::Ride;
use crate::solver::{Block, Landscape, Quadratic};
use crate::spectrum::{Analysis, Recipe};
use bicycle::simulate::{rk4, stability_limit};
use bicycle::{Bicycle, Formulation, Input, Parameters, Real, State, dynamics, linear};
use nalgebra::{DMatrix, DVector};
use num_dual::DualSVec64;

/// Directions differentiated in one pass.
const LANES: usize = 12;
/// Longest step of the replay [s]: 1e-3 rad at worst over whole rides, far less in a window.
const STEP: f64 = 2.5e-3;
/// Internal steps to a sample at most: what is stiffer is no bicycle that a ride could tell.
const MOST_PIECES: f64 = 1000.0;
/// Growth of a start's error over a window, as exponent, beyond which windows are refused.
const GROWTH: f64 = 1.5;

/// A recorded ride cut into windows, and the model that is to replay it.
#[derive(Debug, Clone)]
pub struct Time {
    /// What is sought.
    pub unknowns: Unknowns,
    /// Names of the channels.
    pub channels: Vec<&'static str>,
    /// Standard deviation of each channel's noise [SI].
    pub noise: Vec<f64>,
    formulation: Formulation,
    /// States of a window's start: those that move.
    order: usize,
    law_in_loop: bool,
    step: f64,
    /// Samples of a window.
    length: usize,
    windows: usize,
    states: Vec<usize>,
    measured: Vec<Vec<f64>>,
    /// States that the ride records, looked at or not: where the windows' searches start.
    recorded: Vec<(usize, Vec<f64>)>,
    torque: Vec<f64>,
    speed: Vec<f64>,
}

impl Time {
    /// The windows of `window` [s] of a ride, at `speed` [m/s] where it does not say. Its
    /// `steer_torque` is the whole torque of the rider, or, with `law_in_loop`, what acts besides
    /// a steering law closed on the simulated state.
    pub fn new(
        ride: &Ride,
        channels: &[&'static str],
        unknowns: Unknowns,
        formulation: Formulation,
        (speed, window): (f64, f64),
        noise: Option<&[f64]>,
    ) -> Result<Self> {
        let torque = ride.signal("steer_torque")?.to_vec();
        let speeds = ride
            .channel("speed")
            .map_or_else(|_| vec![speed; ride.len()], <[f64]>::to_vec);
        let law_in_loop = ride.law_in_loop.unwrap_or(false);
        if let Some(free) = unknowns.free.iter().find(|f| f.bicycle_index().is_none()) {
            return Err(Error::NoInfluence {
                name: free.row.name.into(),
                objective: "time",
                why: "it describes the unmeasured torque of a spectrum; here the torque is measured",
            });
        }
        let start = &unknowns.start.parameters;
        let replayed = if law_in_loop {
            *start
        } else {
            start.riderless()
        };
        check_smooth(&unknowns, formulation)?;
        let order = Bicycle::new(start, formulation).order();
        check_growth(&replayed, formulation, ride.mean_speed(speed), window)?;
        let length = (window / ride.step()).round() as usize;
        let windows = if length > order {
            ride.len() / length
        } else {
            0
        };
        if windows < unknowns.free.len() + 1 {
            return Err(Error::Windows {
                window,
                step: ride.step(),
                found: windows,
                free: unknowns.free.len(),
            });
        }
        let recipe = Recipe {
            average: ride.duration().min(5.0),
            ..Recipe::default()
        };
        let analysis = Analysis::new(&recipe, ride.step(), ride.len())?;
        let (mut measured, mut deviations, mut states) = (Vec::new(), Vec::new(), Vec::new());
        for (i, channel) in channels.iter().enumerate() {
            let samples = ride.signal(channel)?;
            let given = noise.and_then(|n| n.get(i).copied());
            let seen = || estimated_noise(&analysis, ride, channel);
            deviations.push(given.map_or_else(seen, Ok)?);
            measured.push(samples.to_vec());
            states.push(State::index(channel).ok_or_else(|| {
                Error::unknown("state", channel, State::TABLE.iter().map(|row| row.name))
            })?);
        }
        let recorded = State::TABLE
            .iter()
            .enumerate()
            .filter_map(|(i, row)| Some((i, ride.channel(row.name).ok()?.to_vec())))
            .collect();
        Ok(Self {
            unknowns,
            channels: channels.to_vec(),
            noise: deviations,
            formulation,
            order,
            law_in_loop,
            step: ride.step(),
            length,
            windows,
            states,
            measured,
            recorded,
            torque,
            speed: speeds,
        })
    }

    /// `p` without a rider law where the torque is the whole torque.
    fn parameters<T: Real>(&self, p: &Parameters<T>) -> Parameters<T> {
        if self.law_in_loop { *p } else { p.riderless() }
    }

    /// Number of windows.
    pub fn windows(&self) -> usize {
        self.windows
    }

    /// Number of observations.
    pub fn observations(&self) -> usize {
        self.windows * self.length * self.channels.len()
    }

    /// Number of free parameters, the initial states not counted.
    fn shared(&self) -> usize {
        self.unknowns.free.len()
    }

    /// All variables of the search: the free parameters and the windows' initial states, these
    /// from straight lines through the first tenth of a second of each state that was recorded.
    pub fn start(&self) -> DVector<f64> {
        let mut z: Vec<f64> = self
            .unknowns
            .start
            .variables(&self.unknowns.free)
            .iter()
            .copied()
            .collect();
        let samples = ((0.1 / self.step).round() as usize).clamp(2, self.length);
        for window in 0..self.windows {
            let mut state = vec![0.0; self.order];
            for (index, channel) in self.recorded.iter().filter(|(i, _)| *i < self.order) {
                let (value, slope) = line(&channel[window * self.length..][..samples], self.step);
                state[*index] = value;
                let rate = match State::TABLE[*index].name {
                    "roll" => State::index("roll_rate"),
                    "steer" => State::index("steer_rate"),
                    _ => None,
                };
                if let Some(rate) = rate.filter(|r| self.recorded.iter().all(|(i, _)| i != r)) {
                    state[rate] = slope;
                }
            }
            z.extend(state);
        }
        DVector::from_vec(z)
    }

    /// Replays window `window` from `state`, showing what is seen of the state at each sample.
    fn replay<T: Real>(
        &self,
        bicycle: &Bicycle<T>,
        pieces: usize,
        window: usize,
        mut state: State<T>,
        mut show: impl FnMut(usize, &State<T>),
    ) {
        let first = window * self.length;
        let h = T::from(self.step / pieces as f64);
        for sample in 0..self.length {
            let (i, j) = (
                first + sample,
                (first + sample + 1).min(self.torque.len() - 1),
            );
            let seen = State {
                yaw_rate: bicycle.yaw_rate(&state, T::from(self.speed[i])),
                ..state
            };
            show(sample, &seen);
            for piece in 0..pieces {
                state = rk4(state, h, |fraction, x| {
                    let at = (piece as f64 + fraction) / pieces as f64;
                    let between = |y: &[f64]| T::from(y[i] * (1.0 - at) + y[j] * at);
                    let input = Input {
                        speed: between(&self.speed),
                        steer_torque: between(&self.torque),
                        assist_torque: T::from(0.0),
                        roll_moment: T::from(0.0),
                    };
                    dynamics::derivative(bicycle, x, &input)
                });
            }
        }
    }

    /// Internal steps to a sample: short enough to be accurate and stable at the slowest and the
    /// fastest speed, but no more than [`MOST_PIECES`].
    fn pieces(&self, bicycle: &Bicycle) -> Result<usize> {
        let slowest = self.speed.iter().copied().fold(f64::INFINITY, f64::min);
        let fastest = self.speed.iter().copied().fold(0.0, f64::max);
        let limit = stability_limit(bicycle, slowest).min(stability_limit(bicycle, fastest));
        let pieces = (self.step / STEP.min(0.9 * limit)).ceil();
        if pieces <= MOST_PIECES {
            Ok(pieces as usize)
        } else {
            Err(Error::Stiff {
                limit,
                expected: self.step / MOST_PIECES,
            })
        }
    }

    fn bicycle(&self, z: &DVector<f64>) -> Bicycle {
        let parameters = self.unknowns.candidate(z).parameters;
        Bicycle::new(&self.parameters(&parameters), self.formulation)
    }

    /// Where the initial state of `window` begins among the variables.
    fn place(&self, window: usize) -> usize {
        self.shared() + window * self.order
    }

    fn initial(&self, z: &DVector<f64>, window: usize) -> [f64; State::LEN] {
        let mut state = State::ZERO.to_array();
        let moving = z.rows(self.place(window), self.order);
        state[..self.order].copy_from_slice(moving.as_slice());
        state
    }

    /// Residuals of a window over their noise, measured minus replayed, samples × channels.
    fn residuals(
        &self,
        bicycle: &Bicycle,
        pieces: usize,
        z: &DVector<f64>,
        window: usize,
    ) -> DVector<f64> {
        let mut residuals = Vec::with_capacity(self.length * self.channels.len());
        let state = State::from_array(self.initial(z, window));
        self.replay(bicycle, pieces, window, state, |sample, x| {
            let x = x.to_array();
            for ((y, &index), noise) in self.measured.iter().zip(&self.states).zip(&self.noise) {
                residuals.push((y[window * self.length + sample] - x[index]) / noise);
            }
        });
        DVector::from_vec(residuals)
    }

    /// ∂residuals/∂(free parameters, initial state) of a window, by dual numbers.
    fn jacobian(&self, pieces: usize, z: &DVector<f64>, window: usize) -> DMatrix<f64> {
        let shared = self.shared();
        let mut jacobian = DMatrix::zeros(self.length * self.channels.len(), shared + self.order);
        let values = self.unknowns.candidate(z);
        for first in (0..shared + self.order).step_by(LANES) {
            let seed = |value: f64, slope: f64, direction: usize| {
                let mut dual = DualSVec64::<LANES>::from(value);
                if (first..first + LANES).contains(&direction) {
                    let mut eps = nalgebra::SVector::<f64, LANES>::zeros();
                    eps[direction - first] = slope;
                    dual.eps = num_dual::Derivative::some(eps);
                }
                dual
            };
            let mut parameters = values.parameters.map(DualSVec64::<LANES>::from);
            for (direction, free) in self.unknowns.free.iter().enumerate() {
                let index = free
                    .bicycle_index()
                    .expect("checked when the problem was made");
                let value = values.get(free);
                parameters.set(index, seed(value, free.slope(value), direction));
            }
            let bicycle = Bicycle::new(&self.parameters(&parameters), self.formulation);
            let initial = self.initial(z, window);
            let state =
                State::from_array(std::array::from_fn(|i| seed(initial[i], 1.0, shared + i)));
            self.replay(&bicycle, pieces, window, state, |sample, x| {
                let x = x.to_array();
                for (c, (&index, noise)) in self.states.iter().zip(&self.noise).enumerate() {
                    let eps = x[index]
                        .eps
                        .unwrap_generic(nalgebra::Const, nalgebra::Const);
                    let row = sample * self.channels.len() + c;
                    for direction in first..(first + LANES).min(shared + self.order) {
                        jacobian[(row, direction)] = -eps[direction - first] / noise;
                    }
                }
            });
        }
        jacobian
    }

    /// What the windows know at `z`.
    pub fn information(&self, z: &DVector<f64>) -> Result<Information> {
        let quadratic = self.quadratic(z)?;
        // a state that no channel sees leaves its block singular: a trace of damping
        let reduced = quadratic
            .reduce(0.0)
            .or_else(|| quadratic.reduce(1e-9))
            .ok_or_else(|| Error::Search("the curvature of a window is not finite".into()))?;
        let meat = reduced
            .scores
            .iter()
            .map(|s| s * s.transpose())
            .sum::<DMatrix<f64>>();
        let (n, p) = (self.windows as f64, self.shared() as f64);
        Ok(Information {
            curvature: reduced.curvature,
            meat: Some(meat * (n / (n - p))),
            factor: 1.0,
        })
    }

    /// The local model of one window alone.
    fn window(
        &self,
        bicycle: &Bicycle,
        pieces: usize,
        z: &DVector<f64>,
        window: usize,
    ) -> Quadratic {
        let residuals = self.residuals(bicycle, pieces, z, window);
        let jacobian = self.jacobian(pieces, z, window);
        let shared = jacobian.columns(0, self.shared());
        let own = jacobian.columns(self.shared(), self.order);
        let share = shared.transpose() * &residuals;
        Quadratic {
            gradient: share.clone(),
            curvature: shared.transpose() * shared,
            blocks: vec![Block {
                share,
                gradient: own.transpose() * &residuals,
                curvature: own.transpose() * own,
                cross: own.transpose() * shared,
            }],
        }
    }
}

impl Landscape for Time {
    fn blocks(&self) -> usize {
        self.windows * self.order
    }

    fn cost(&self, z: &DVector<f64>) -> f64 {
        let bicycle = self.bicycle(z);
        let Ok(pieces) = self.pieces(&bicycle) else {
            return f64::INFINITY;
        };
        let square = |window| self.residuals(&bicycle, pieces, z, window).norm_squared();
        0.5 * (0..self.windows).map(square).sum::<f64>()
    }

    fn quadratic(&self, z: &DVector<f64>) -> Result<Quadratic> {
        let bicycle = self.bicycle(z);
        let pieces = self.pieces(&bicycle)?;
        let mut sum = self.window(&bicycle, pieces, z, 0);
        for window in 1..self.windows {
            let own = self.window(&bicycle, pieces, z, window);
            sum.gradient += own.gradient;
            sum.curvature += own.curvature;
            sum.blocks.extend(own.blocks);
        }
        Ok(sum)
    }
}

/// Refuses jumps: the windows' equations are differentiated.
fn check_smooth(unknowns: &Unknowns, formulation: Formulation) -> Result<()> {
    let p = &unknowns.start.parameters;
    let is_free = |name: &str| unknowns.free.iter().any(|free| free.row.name == name);
    let rubs = p.coulomb_friction != 0.0 || is_free("coulomb_friction");
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

/// Refuses windows over which errors of the start would grow too far.
fn check_growth(p: &Parameters, formulation: Formulation, speed: f64, window: f64) -> Result<()> {
    let worst = linear::fastest_growth(p, formulation, speed);
    let limit = GROWTH / worst.re;
    if worst.re.is_nan() || worst.re > 0.0 && window > limit {
        return Err(Error::WindowTooLong {
            window,
            limit,
            re: worst.re,
            im: worst.im.abs(),
        });
    }
    Ok(())
}

/// Value at the first sample and slope of the straight line through `y`.
fn line(y: &[f64], step: f64) -> (f64, f64) {
    let n = y.len() as f64;
    let middle = 0.5 * (n - 1.0);
    let mean = y.iter().sum::<f64>() / n;
    let (mut up, mut down) = (0.0, 0.0);
    for (i, value) in y.iter().enumerate() {
        let x = i as f64 - middle;
        up += x * (value - mean);
        down += x * x;
    }
    (mean - middle * up / down, up / down / step)
}
