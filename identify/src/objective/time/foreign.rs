//! Windows replayed by an FMU.

use super::shooting::Sums;
use super::{Time, Torque, windows};
use crate::error::{Error, Result};
use crate::foreign::{Foreign, Request};
use crate::objective::Unknowns;
use crate::objective::simulated::WIDTH;
use crate::ride::Ride;
use bicycle::{Formulation, State};
use nalgebra::{DMatrix, DVector};

/// Longest window [s] whose search begins at what was measured: nobody knows how fast errors of a
/// start grow in an FMU, and .5 s is what serves a bicycle at riding speeds.
const IMMEDIATE: f64 = 0.5;

/// Half of the width over which the start of a window is differenced \[rad, rad/s\].
const START: f64 = 1e-4;

impl Time {
    /// As [`Time::new`], the windows replayed by `foreign`.
    pub fn of_foreign(
        foreign: &Foreign,
        ride: &Ride,
        channels: &[&'static str],
        unknowns: Unknowns,
        (speed, window): (f64, f64),
        noise: Option<&[f64]>,
    ) -> Result<Self> {
        let order = foreign.order()?;
        let length = (window / ride.step()).round() as usize;
        let cut = if length > order {
            windows::cut(ride, length)
        } else {
            Vec::new()
        };
        let free = unknowns.free.len();
        if cut.len() < free + 1 {
            return Err(Error::Windows {
                window,
                step: ride.step(),
                found: cut.len(),
                free,
            });
        }
        let formulation = Formulation::default();
        let mut uncut = Self::uncut(
            ride,
            channels,
            unknowns,
            formulation,
            speed,
            Torque::Recorded,
        )?;
        uncut.order = order;
        uncut.immediate = IMMEDIATE;
        uncut.foreign = Some(foreign.clone());
        uncut.over(cut, noise)
    }

    /// The window number `window` as a ride, with the variables `z` of the free parameters and the
    /// start `own`.
    fn request(&self, window: usize, z: &DVector<f64>, own: &[f64]) -> Request {
        let candidate = self.unknowns.candidate(z);
        let instruments = &candidate.instruments;
        let range = self.windows[window].clone();
        let mut start = State::ZERO;
        for (row, value) in own.iter().enumerate() {
            start.set(row, *value);
        }
        let torque = self.torque[range.clone()].iter();
        Request {
            parameters: self.replayed(&candidate.parameters),
            start: Some(start),
            torque: torque
                .map(|t| (t - instruments.torque_offset) / instruments.torque_gain)
                .collect(),
            speed: self.speed[range.clone()].to_vec(),
            step: self.step,
            samples: range.len(),
        }
    }

    /// What window number `window` leaves over its noise where `seen` is replayed, channel by
    /// channel.
    fn left_of(&self, window: usize, z: &DVector<f64>, seen: &[Vec<f64>]) -> Vec<f64> {
        let instruments = self.unknowns.candidate(z).instruments;
        let range = self.windows[window].clone();
        let channels = seen.iter().enumerate();
        let left = channels.flat_map(|(c, seen)| {
            let offset = instruments.get(self.offsets[c]);
            let measured = self.measured[c][range.clone()].iter();
            let noise = self.noise[c];
            measured
                .zip(seen)
                .map(move |(y, x)| (y - offset - x) / noise)
        });
        left.collect()
    }

    /// [`Time::residuals`] by `foreign`.
    pub(super) fn foreign_residuals(
        &self,
        foreign: &Foreign,
        z: &DVector<f64>,
    ) -> Result<Vec<Vec<f64>>> {
        let shared = z.rows(0, self.shared()).into_owned();
        let starts = z.as_slice()[self.shared()..].chunks(self.order);
        let requests = starts
            .enumerate()
            .map(|(w, own)| self.request(w, &shared, own));
        let replayed = foreign.replay(&self.channels, requests.collect());
        let left = |(w, seen): (usize, Result<Vec<Vec<f64>>>)| Ok(self.left_of(w, &shared, &seen?));
        replayed.into_iter().enumerate().map(left).collect()
    }

    /// Gradient and curvature of each window, by central differences of its replays.
    pub(super) fn foreign_sums(&self, foreign: &Foreign, z: &DVector<f64>) -> Result<Vec<Sums>> {
        let p = self.shared();
        let n = p + self.order;
        let shared = z.rows(0, p).into_owned();
        let starts = z.as_slice()[p..].chunks(self.order);
        let half = |i: usize| if i < p { WIDTH } else { START };
        // of each window itself and both sides of each of its variables
        let mut points = Vec::new();
        for (w, own) in starts.enumerate() {
            let own: Vec<f64> = shared.iter().chain(own).copied().collect();
            points.push((w, own.clone()));
            for i in 0..n {
                for h in [half(i), -half(i)] {
                    let mut moved = own.clone();
                    moved[i] += h;
                    points.push((w, moved));
                }
            }
        }
        let split = |own: &[f64]| (DVector::from_column_slice(&own[..p]), own[p..].to_vec());
        let request = |(w, own): &(usize, Vec<f64>)| {
            let (z, start) = split(own);
            self.request(*w, &z, &start)
        };
        let replayed = foreign.replay(&self.channels, points.iter().map(request).collect());
        let mut left = Vec::with_capacity(points.len());
        for ((w, own), seen) in points.iter().zip(replayed) {
            left.push(DVector::from_vec(self.left_of(*w, &split(own).0, &seen?)));
        }
        let sums = |of_window: &[DVector<f64>]| {
            let slope =
                |i: usize| (&of_window[1 + 2 * i] - &of_window[2 + 2 * i]) / (2.0 * half(i));
            let jacobian = DMatrix::from_columns(&(0..n).map(slope).collect::<Vec<_>>());
            Sums {
                gradient: jacobian.tr_mul(&of_window[0]),
                curvature: jacobian.tr_mul(&jacobian),
            }
        };
        Ok(left.chunks(1 + 2 * n).map(sums).collect())
    }
}
