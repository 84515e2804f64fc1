//! The windows replayed side by side: each lane is a window of its own. Values, and derivatives by
//! dual numbers over the lanes, from the same source as every simulation.

use super::Time;
use super::dual::Dual;
use crate::free::Candidate;
use crate::kernel::Work;
use bicycle::lanes::Pack;
use bicycle::quantity::Vector;
use bicycle::simulate::STAGES;
use bicycle::{Bicycle, Input, Parameters, State, dynamics};
use nalgebra::{DMatrix, DVector};
use std::ops::Range;

/// Directions differentiated in one pass: the four parameters and five states of the paper's
/// bicycle take two.
const WIDTH: usize = 5;

/// How the model moves along a free variable, for each unit of the variable.
#[derive(Debug, Clone)]
pub(super) struct Move {
    parameters: [f64; Parameters::LEN],
    torque_gain: f64,
    torque_offset: f64,
    /// Of what each channel records.
    offsets: Vec<f64>,
}

impl Move {
    fn is_dynamic(&self) -> bool {
        self.torque_gain != 0.0
            || self.torque_offset != 0.0
            || self.parameters.iter().any(|p| *p != 0.0)
    }
}

/// What is differentiated for.
#[derive(Debug, Clone, Copy)]
enum Direction {
    /// A free variable.
    Free(usize),
    /// A row of the initial state.
    Start(usize),
}

/// A model at one point of a search, ready to replay windows.
#[derive(Debug, Clone)]
pub(super) struct Model<'a> {
    time: &'a Time,
    candidate: Candidate,
    moves: Vec<Move>,
    pieces: usize,
}

/// A window to replay, from which state.
#[derive(Debug, Clone, Copy)]
pub(super) struct Shot {
    first: usize,
    length: usize,
    state: [f64; State::LEN],
}

impl Shot {
    /// The window `range` from the initial state at `own`.
    pub fn new(range: &Range<usize>, own: &[f64]) -> Self {
        let mut state = State::ZERO.to_array();
        state[..own.len()].copy_from_slice(own);
        Self {
            first: range.start,
            length: range.len(),
            state,
        }
    }
}

/// What a window says about a point of a search, over the free variables and then its own initial
/// state: the squares of its residuals, their gradient and curvature.
#[derive(Debug, Clone)]
pub(super) struct Sums {
    /// Gradient of ½ Σ r².
    pub gradient: DVector<f64>,
    /// Its curvature, Gauss–Newton.
    pub curvature: DMatrix<f64>,
}

impl<'a> Model<'a> {
    /// The model of `time` at the variables `z`, stepped `pieces` times a sample.
    pub fn new(time: &'a Time, z: &DVector<f64>, pieces: usize) -> Self {
        // values are linear or exponential in the variables: a central difference of this width
        // is good to ten digits
        const H: f64 = 1e-5;
        let unknowns = &time.unknowns;
        let moves = (0..unknowns.free.len()).map(|i| {
            let at = |h: f64| {
                let mut moved = z.rows(0, unknowns.free.len()).into_owned();
                moved[i] += h;
                unknowns.candidate(&moved)
            };
            let (up, down) = (at(H), at(-H));
            let slope = |up: f64, down: f64| (up - down) / (2.0 * H);
            let (a, b) = (&up.instruments, &down.instruments);
            let parameters = up.parameters.zip(&down.parameters, slope);
            Move {
                parameters: parameters.to_array(),
                torque_gain: slope(a.torque_gain, b.torque_gain),
                torque_offset: slope(a.torque_offset, b.torque_offset),
                offsets: time
                    .offsets
                    .iter()
                    .map(|&row| slope(a.get(row), b.get(row)))
                    .collect(),
            }
        });
        Self {
            time,
            candidate: unknowns.candidate(z),
            moves: moves.collect(),
            pieces,
        }
    }

    /// The windows `shots`, as many as there are lanes, at their start, ready to be differentiated
    /// along `directions`.
    #[inline(always)]
    fn start<T: Pack, const D: usize>(
        &self,
        shots: &[Shot],
        directions: &[Direction],
    ) -> March<'_, T, D> {
        let time = self.time;
        let mut parameters = self.candidate.parameters.to_array().map(Dual::from);
        let mut state: [Dual<T, D>; State::LEN] = std::array::from_fn(|row| {
            Dual::constant(T::from_fn(|lane| shot(shots, lane).state[row]))
        });
        let instruments = &self.candidate.instruments;
        let mut gain = Dual::from(instruments.torque_gain);
        let mut offset = Dual::from(instruments.torque_offset);
        for (d, direction) in directions.iter().enumerate() {
            match *direction {
                Direction::Free(i) => {
                    let own = &self.moves[i];
                    for (parameter, slope) in parameters.iter_mut().zip(&own.parameters) {
                        parameter.eps[d] = T::from(*slope);
                    }
                    gain.eps[d] = T::from(own.torque_gain);
                    offset.eps[d] = T::from(own.torque_offset);
                }
                Direction::Start(row) => state[row].eps[d] = T::from(1.0),
            }
        }
        let parameters = time.replayed(&Parameters::from_array(parameters));
        March {
            time,
            bicycle: Bicycle::new(&parameters, time.formulation),
            offset,
            per_gain: Dual::from(1.0) / gain,
            pieces: self.pieces,
            state: State::from_array(state),
        }
    }

    /// Residuals of `shots` over their noise, channel by channel, as lanes; 0 behind a window's
    /// end. With D > 0 the derivatives of what is seen as well.
    #[inline(always)]
    fn pass<T: Pack, const D: usize>(
        &self,
        shots: &[Shot],
        directions: &[Direction],
        length: usize,
        mut columns: [&mut [T]; D],
    ) -> Vec<T> {
        let time = self.time;
        let mut residuals = vec![T::from(0.0); length * time.channels.len()];
        let offsets: Vec<f64> = time
            .offsets
            .iter()
            .map(|&row| self.candidate.instruments.get(row))
            .collect();
        let mut march = self.start::<T, D>(shots, directions);
        let mut here = time.recorded_at::<T>(shots, 0);
        for sample in 0..length {
            let seen = march.seen(here.speed);
            for (c, measured) in time.measured.iter().enumerate() {
                let x = seen.get(time.states[c]);
                let row = c * length + sample;
                let per_noise = T::from(1.0 / time.noise[c]);
                let y = gathered::<T>(measured, shots, sample) - T::from(offsets[c]);
                residuals[row] = within((y - x.re) * per_noise, shots, sample);
                for (column, eps) in columns.iter_mut().zip(x.eps) {
                    column[row] = within(-eps * per_noise, shots, sample);
                }
            }
            // one step after the last sample would be for nothing
            if sample + 1 < length {
                let next = time.recorded_at::<T>(shots, sample + 1);
                march.go(here, next);
                here = next;
            }
        }
        residuals
    }

    /// The directions in which the motion changes.
    fn directions(&self) -> Vec<Direction> {
        let free = (0..self.moves.len()).filter(|&i| self.moves[i].is_dynamic());
        let start = (0..self.time.order).map(Direction::Start);
        free.map(Direction::Free).chain(start).collect()
    }
}

/// The window of a lane; lanes left over repeat the last.
#[inline(always)]
fn shot(shots: &[Shot], lane: usize) -> &Shot {
    &shots[lane.min(shots.len() - 1)]
}

/// A record at a sample of each window.
#[inline(always)]
fn gathered<T: Pack>(record: &[f64], shots: &[Shot], sample: usize) -> T {
    let last = record.len() - 1;
    T::from_fn(|lane| record[(shot(shots, lane).first + sample).min(last)])
}

/// `x` within the windows, 0 behind their ends, where a lane may have diverged.
#[inline(always)]
fn within<T: Pack>(x: T, shots: &[Shot], sample: usize) -> T {
    if shots.iter().all(|shot| sample < shot.length) {
        return x;
    }
    T::from_fn(|lane| {
        if sample < shot(shots, lane).length {
            x.lane(lane)
        } else {
            0.0
        }
    })
}

/// What acts on the bicycle at a sample of each window.
#[derive(Clone, Copy)]
struct Acting<T> {
    speed: T,
    torque: T,
}

impl Time {
    #[inline(always)]
    fn recorded_at<T: Pack>(&self, shots: &[Shot], sample: usize) -> Acting<T> {
        Acting {
            speed: gathered(&self.speed, shots, sample),
            torque: gathered(&self.torque, shots, sample),
        }
    }
}

/// Windows under way.
struct March<'a, T, const D: usize> {
    time: &'a Time,
    bicycle: Bicycle<Dual<T, D>>,
    offset: Dual<T, D>,
    per_gain: Dual<T, D>,
    pieces: usize,
    state: State<Dual<T, D>>,
}

impl<T: Pack, const D: usize> March<'_, T, D> {
    /// The state as it is seen, with the yaw rate that follows from the others.
    #[inline(always)]
    fn seen(&self, speed: T) -> State<Dual<T, D>> {
        let mut seen = self.state;
        seen.yaw_rate = self.bicycle.yaw_rate(&seen, Dual::constant(speed));
        seen
    }

    /// On to the next sample, by the reference method. No closures: what is not inlined for certain
    /// loses the lanes' instructions.
    #[inline(always)]
    fn go(&mut self, from: Acting<T>, to: Acting<T>) {
        let part = 1.0 / self.pieces as f64;
        let h = self.time.step * part;
        let (dv, dt) = (to.speed - from.speed, to.torque - from.torque);
        for piece in 0..self.pieces {
            let (mut sum, mut stage) = (self.state, self.state);
            for (fraction, weight, reach) in STAGES {
                let at = T::from((piece as f64 + fraction) * part);
                let recorded = Dual::constant(at.mul_add(dt, from.torque));
                let input = Input {
                    speed: Dual::constant(at.mul_add(dv, from.speed)),
                    steer_torque: (recorded - self.offset) * self.per_gain,
                    assist_torque: Dual::from(0.0),
                    roll_moment: Dual::from(0.0),
                };
                let slope = dynamics::derivative(&self.bicycle, &stage, &input);
                sum = sum.along(Dual::from(weight * h), &slope);
                stage = self.state.along(Dual::from(reach * h), &slope);
            }
            self.state = sum;
        }
    }
}

/// Residuals of windows over their noise: channel by channel, sample by sample.
pub(super) struct Residuals<'a> {
    pub model: &'a Model<'a>,
    pub shots: &'a [Shot],
}

impl Work for Residuals<'_> {
    type Output = Vec<Vec<f64>>;

    #[inline(always)]
    fn run<T: Pack>(self) -> Self::Output {
        let mut all = Vec::with_capacity(self.shots.len());
        for shots in self.shots.chunks(T::WIDTH) {
            let length = shots.iter().map(|shot| shot.length).max().unwrap_or(0);
            let residuals = self.model.pass::<T, 0>(shots, &[], length, []);
            for (lane, shot) in shots.iter().enumerate() {
                let channels = residuals.chunks(length);
                let own = channels.flat_map(|c| c[..shot.length].iter().map(|x| x.lane(lane)));
                all.push(own.collect());
            }
        }
        all
    }
}

/// Gradients and curvatures of windows.
pub(super) struct Normal<'a> {
    pub model: &'a Model<'a>,
    pub shots: &'a [Shot],
}

impl Work for Normal<'_> {
    type Output = Vec<Sums>;

    #[inline(always)]
    fn run<T: Pack>(self) -> Self::Output {
        let Self { model, .. } = self;
        let time = model.time;
        let directions = model.directions();
        let free = model.moves.len();
        let n = free + time.order;
        let mut all = Vec::with_capacity(self.shots.len());
        for shots in self.shots.chunks(T::WIDTH) {
            let length = shots.iter().map(|shot| shot.length).max().unwrap_or(0);
            let rows = length * time.channels.len();
            // a column a variable: the free ones, then the initial state
            let mut columns = vec![T::from(0.0); n * rows];
            let mut residuals = Vec::new();
            let mut spare = vec![vec![T::from(0.0); rows]; WIDTH];
            for some in directions.chunks(WIDTH) {
                let [a, b, c, d, e] = &mut spare[..] else {
                    unreachable!("as many as directions in a pass")
                };
                let into = [a, b, c, d, e].map(|column| &mut column[..]);
                residuals = model.pass::<T, WIDTH>(shots, some, length, into);
                for (direction, column) in some.iter().zip(&spare) {
                    let place = match *direction {
                        Direction::Free(i) => i,
                        Direction::Start(row) => free + row,
                    };
                    columns[place * rows..][..rows].copy_from_slice(column);
                }
            }
            for (i, own) in model.moves.iter().enumerate() {
                for (c, offset) in own.offsets.iter().enumerate().filter(|(_, o)| **o != 0.0) {
                    for sample in 0..length {
                        let slope = T::from(-offset / time.noise[c]);
                        let slope = within(slope, shots, sample);
                        let entry = &mut columns[i * rows + c * length + sample];
                        *entry = *entry + slope;
                    }
                }
            }
            let mut sums: Vec<Sums> = (shots.iter())
                .map(|_| Sums {
                    gradient: DVector::zeros(n),
                    curvature: DMatrix::zeros(n, n),
                })
                .collect();
            for i in 0..n {
                let own = &columns[i * rows..][..rows];
                let gradient = dot(own, &residuals);
                for (lane, sum) in sums.iter_mut().enumerate() {
                    sum.gradient[i] = gradient.lane(lane);
                }
                for j in 0..=i {
                    let product = dot(own, &columns[j * rows..][..rows]);
                    for (lane, sum) in sums.iter_mut().enumerate() {
                        sum.curvature[(i, j)] = product.lane(lane);
                        sum.curvature[(j, i)] = product.lane(lane);
                    }
                }
            }
            all.extend(sums);
        }
        all
    }
}

/// Σ a_k b_k of each lane.
#[inline(always)]
fn dot<T: Pack>(a: &[T], b: &[T]) -> T {
    let mut sum = T::from(0.0);
    for (a, b) in a.iter().zip(b) {
        sum = a.mul_add(*b, sum);
    }
    sum
}
