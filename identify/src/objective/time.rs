//! `time`: the recorded torque replayed in short windows, multiple shooting.
//!
//! The ridden bicycle is unstable, so errors of a start grow: a whole ride cannot be replayed, and
//! is refused with the eigenvalue named. Each window has a free initial state, eliminated from the
//! equations; standard errors come from the scatter between windows (those of Gauss–Newton are
//! three times too small). Bock 1987; Liang & Zeger 1986.
//!
//! What a sensor adds, an offset or a gain of the torque, is free where asked for
//! ([`bicycle::Instruments`]). The channels are weighted by what the replay leaves of each: see
//! [`Time::noise`].

mod continuation;
mod dual;
mod foreign;
mod hat;
mod noise;
mod replay;
mod scatter;
mod shooting;
#[cfg(test)]
mod tests;
mod windows;

pub use continuation::{carry, stages};
pub use replay::{Leftover, Replay};
pub use scatter::information;

use super::Unknowns;
use crate::error::{Error, Result};
use crate::foreign::Foreign;
use crate::kernel;
use crate::ride::Ride;
use crate::solver::{Block, Landscape, Quadratic};
use bicycle::simulate::stability_limit;
use bicycle::{Bicycle, Excitation, Formulation, Instruments, Parameters, Real, State};
use nalgebra::{DMatrix, DVector};
use shooting::{Model, Normal, Residuals, Shot};
use std::ops::Range;

/// Longest step of the replay [s]: 1e-3 rad at worst over whole rides, far less in a window.
const STEP: f64 = 2.5e-3;
/// Internal steps to a sample at most: what is stiffer is no bicycle that a ride could tell.
const MOST_PIECES: f64 = 1000.0;

/// The torque of a replay.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Torque {
    /// As recorded.
    Recorded,
    /// None: the bicycle is left to itself and its steering law.
    Off,
}

/// A recorded ride cut into windows, and the model that is to replay it.
#[derive(Debug, Clone)]
pub struct Time {
    /// What is sought.
    pub unknowns: Unknowns,
    /// Names of the channels.
    pub channels: Vec<&'static str>,
    /// Standard deviation of what the model leaves of each channel [SI], its noise where the model
    /// is true: given, or found by a first search whose weights are the power in the upper half of
    /// each channel's spectrum, where a bicycle does not move.
    pub noise: Vec<f64>,
    formulation: Formulation,
    /// States of a window's start: those that move.
    order: usize,
    law_in_loop: bool,
    step: f64,
    windows: Vec<Range<usize>>,
    /// The longest window [s] whose search may begin at what was measured.
    immediate: f64,
    states: Vec<usize>,
    /// The offset of each channel: rows of [`Instruments`].
    offsets: Vec<usize>,
    measured: Vec<Vec<f64>>,
    /// States that the ride records, looked at or not: where the windows' searches start.
    recorded: Vec<(usize, Vec<f64>)>,
    torque: Vec<f64>,
    speed: Vec<f64>,
    /// Who replays in place of the equations.
    foreign: Option<Foreign>,
}

impl Time {
    /// The windows of `window` [s] of a ride, at `speed` [m/s] where it does not say. Its
    /// `steer_torque` is the whole torque of the rider, or, with `law_in_loop`, what acts besides
    /// a steering law closed on the simulated state. Rows at standstill and glitches are left out.
    pub fn new(
        ride: &Ride,
        channels: &[&'static str],
        unknowns: Unknowns,
        formulation: Formulation,
        (speed, window): (f64, f64),
        noise: Option<&[f64]>,
    ) -> Result<Self> {
        let length = (window / ride.step()).round() as usize;
        let order = Bicycle::new(&unknowns.start.parameters, formulation).order();
        let cut = if length > order {
            windows::cut(ride, length)
        } else {
            Vec::new()
        };
        let found = cut.len();
        let free = unknowns.free.len();
        let uncut = Self::uncut(
            ride,
            channels,
            unknowns,
            formulation,
            speed,
            Torque::Recorded,
        )?;
        // a window too long says more than too few of them
        uncut.check_growth(window, ride.mean_speed(speed))?;
        if found == 0 {
            return Err(Error::Windows {
                window,
                step: ride.step(),
                found,
                free,
            });
        }
        uncut.over(cut, noise)
    }

    /// A ride without windows yet.
    pub(super) fn uncut(
        ride: &Ride,
        channels: &[&'static str],
        unknowns: Unknowns,
        formulation: Formulation,
        speed: f64,
        torque: Torque,
    ) -> Result<Self> {
        let torque = match torque {
            Torque::Recorded => ride.signal("steer_torque")?.to_vec(),
            Torque::Off => vec![0.0; ride.len()],
        };
        let speeds = ride
            .channel("speed")
            .map_or_else(|_| vec![speed; ride.len()], <[f64]>::to_vec);
        if let Some(free) = unknowns
            .free
            .iter()
            .find(|f| Excitation::index(f.row.name).is_some())
        {
            return Err(Error::NoInfluence {
                name: free.row.name.into(),
                objective: "time",
                why: "it describes the unmeasured torque of a spectrum; here the torque is measured",
            });
        }
        windows::check_smooth(&unknowns, formulation)?;
        let start = &unknowns.start.parameters;
        let (mut measured, mut states, mut offsets) = (Vec::new(), Vec::new(), Vec::new());
        for channel in channels {
            measured.push(ride.signal(channel)?.to_vec());
            let row = |index: Option<usize>| {
                index.ok_or_else(|| {
                    Error::unknown("state", channel, State::TABLE.iter().map(|row| row.name))
                })
            };
            states.push(row(State::index(channel))?);
            offsets.push(row(Instruments::index(&format!("{channel}_offset")))?);
        }
        let recorded = State::TABLE
            .iter()
            .enumerate()
            .filter_map(|(i, row)| Some((i, ride.channel(row.name).ok()?.to_vec())))
            .collect();
        let mut uncut = Self {
            order: Bicycle::new(start, formulation).order(),
            channels: channels.to_vec(),
            noise: vec![1.0; channels.len()],
            formulation,
            law_in_loop: ride.law_in_loop.unwrap_or(false),
            step: ride.step(),
            windows: Vec::new(),
            immediate: f64::INFINITY,
            states,
            offsets,
            measured,
            recorded,
            torque,
            speed: speeds,
            foreign: None,
            unknowns,
        };
        uncut.immediate = uncut.longest_immediate(ride.mean_speed(speed))?;
        Ok(uncut)
    }

    /// The same over `windows`, with the noise given or found.
    pub(super) fn over(
        mut self,
        windows: Vec<Range<usize>>,
        noise: Option<&[f64]>,
    ) -> Result<Self> {
        self.windows = windows;
        self.noise = match noise {
            Some(given) => given.to_vec(),
            None => self.found_noise()?,
        };
        Ok(self)
    }

    /// `p` without a rider law where the torque is the whole torque.
    fn replayed<T: Real>(&self, p: &Parameters<T>) -> Parameters<T> {
        if self.law_in_loop { *p } else { p.riderless() }
    }

    /// Number of states of a window's start.
    pub(super) fn order(&self) -> usize {
        self.order
    }

    /// Number of windows.
    pub fn windows(&self) -> usize {
        self.windows.len()
    }

    /// Length of the longest window [s].
    pub fn longest(&self) -> f64 {
        let samples = self.windows.iter().map(ExactSizeIterator::len).max();
        samples.unwrap_or(0) as f64 * self.step
    }

    /// Step of the record [s].
    pub fn step(&self) -> f64 {
        self.step
    }

    /// The windows, in samples.
    pub fn ranges(&self) -> &[Range<usize>] {
        &self.windows
    }

    /// The samples of the windows, one window after the other.
    pub fn samples(&self) -> impl Iterator<Item = usize> {
        self.windows.iter().flat_map(Clone::clone)
    }

    /// Number of observations.
    pub fn observations(&self) -> usize {
        self.samples().count() * self.channels.len()
    }

    /// Number of free parameters, the initial states not counted.
    fn shared(&self) -> usize {
        self.unknowns.free.len()
    }

    /// All variables of the search: the free parameters and the windows' initial states, these
    /// from straight lines through the first tenth of a second of each state that was recorded.
    pub fn start(&self) -> DVector<f64> {
        let own = self.unknowns.start.variables(&self.unknowns.free);
        let mut z: Vec<f64> = own.iter().copied().collect();
        for window in &self.windows {
            z.extend(self.measured_start(window));
        }
        DVector::from_vec(z)
    }

    /// The initial state of `window` as measured.
    fn measured_start(&self, window: &Range<usize>) -> Vec<f64> {
        let samples = ((0.1 / self.step).round() as usize).clamp(2, window.len());
        let mut state = vec![0.0; self.order];
        for (index, channel) in self.recorded.iter().filter(|(i, _)| *i < self.order) {
            let (value, slope) = line(&channel[window.start..][..samples], self.step);
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
        state
    }

    /// Internal steps to a sample: short enough to be accurate and stable at the slowest and the
    /// fastest speed, but no more than [`MOST_PIECES`].
    fn pieces(&self, z: &DVector<f64>) -> Result<usize> {
        let parameters = self.unknowns.candidate(z).parameters;
        let bicycle = Bicycle::new(&self.replayed(&parameters), self.formulation);
        let speeds = || self.windows.iter().flat_map(|w| &self.speed[w.clone()]);
        let slowest = speeds().copied().fold(f64::INFINITY, f64::min);
        let fastest = speeds().copied().fold(0.0, f64::max);
        let mut limit = stability_limit(&bicycle, slowest);
        if fastest != slowest {
            limit = limit.min(stability_limit(&bicycle, fastest));
        }
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

    /// The model at `z`, and its windows with their initial states.
    fn model(&self, z: &DVector<f64>) -> Result<(Model<'_>, Vec<Shot>)> {
        let model = Model::new(self, z, self.pieces(z)?);
        let own = z.as_slice()[self.shared()..].chunks(self.order);
        let shots = self.windows.iter().zip(own);
        let shots = shots.map(|(window, own)| Shot::new(window, own)).collect();
        Ok((model, shots))
    }

    /// Residuals of each window over their noise, measured minus replayed: channel by channel.
    fn residuals(&self, z: &DVector<f64>) -> Result<Vec<Vec<f64>>> {
        if let Some(foreign) = &self.foreign {
            return self.foreign_residuals(foreign, z);
        }
        let (model, shots) = self.model(z)?;
        Ok(kernel::in_batches(&shots, |shots| {
            kernel::run(Residuals {
                model: &model,
                shots,
            })
        }))
    }
}

impl Landscape for Time {
    fn blocks(&self) -> usize {
        self.windows() * self.order
    }

    fn cost(&self, z: &DVector<f64>) -> f64 {
        let square = |residuals: Vec<Vec<f64>>| {
            let all = residuals.iter().flatten();
            0.5 * all.map(|r| r * r).sum::<f64>()
        };
        self.residuals(z).map_or(f64::INFINITY, square)
    }

    /// The part of the samples that a divergence cuts off, all where nothing can be replayed.
    fn excess(&self, z: &DVector<f64>) -> f64 {
        self.residuals(z).map_or(1.0, |residuals| {
            let all = residuals.iter().flatten();
            let lost = all.filter(|r| !r.is_finite()).count();
            lost as f64 / self.observations() as f64
        })
    }

    fn quadratic(&self, z: &DVector<f64>) -> Result<Quadratic> {
        let windows = if let Some(foreign) = &self.foreign {
            self.foreign_sums(foreign, z)?
        } else {
            let (model, shots) = self.model(z)?;
            kernel::in_batches(&shots, |shots| {
                kernel::run(Normal {
                    model: &model,
                    shots,
                })
            })
        };
        let p = self.shared();
        let mut sum = Quadratic {
            gradient: DVector::zeros(p),
            curvature: DMatrix::zeros(p, p),
            blocks: Vec::with_capacity(windows.len()),
        };
        for window in windows {
            let (gradient, curvature) = (&window.gradient, &window.curvature);
            let share = gradient.rows(0, p).into_owned();
            sum.gradient += &share;
            sum.curvature += curvature.view((0, 0), (p, p));
            sum.blocks.push(Block {
                share,
                own: curvature.view((0, 0), (p, p)).into_owned(),
                gradient: gradient.rows(p, self.order).into_owned(),
                curvature: curvature
                    .view((p, p), (self.order, self.order))
                    .into_owned(),
                cross: curvature.view((p, 0), (self.order, p)).into_owned(),
            });
        }
        Ok(sum)
    }
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
