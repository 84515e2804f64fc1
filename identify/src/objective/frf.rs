//! `frf`: the frequency response from the measured steer torque to each channel, magnitude and
//! phase, with the cost and the weights of CIFER (Tischler & Remple 2012, ch. 11):
//!
//! ```text
//! J = 20/n_ω Σ W_γ [W_g (|Ĝ| − |G|)² + W_p (∠Ĝ − ∠G)²]     [dB, deg]
//! W_γ = [1.58 (1 − exp(−γ²))]²,   W_g = 1,   W_p = .01745
//! ```
//!
//! summed over the channels. Bins of a coherence below .6 are not looked at. The weights are a
//! convention, not a likelihood; standard errors come from the random errors of the measured
//! responses, carried through the weighted fit (sandwich). Their size is ε = √(1 − γ²)/(|γ| √(2 n_d));
//! one gust moves all channels, so at each frequency the errors of the channels are taken with their
//! covariance, from what the torque leaves of the channels' cross-spectra (Bendat & Piersol 2010,
//! ch. 9).
//!
//! The model is the linearised bicycle with the mean gain of each jump under the measured torque.
//! **In a closed loop** the torque of a rider answers the bicycle: the response from the whole
//! torque is then biased wherever something else than this torque, gusts or the road, moves the
//! bicycle, towards the inverse of the rider (Wellstead 1981). With a law in the loop the torque of
//! the hand is the input and the law a part of the model: what moves the hand is outside.

use super::{Information, Unknowns};
use crate::closed_loop::gains::Gains;
use crate::error::{Error, Result};
use crate::ride::Ride;
use crate::solver::{Landscape, Quadratic};
use crate::spectrum::welch::{self, Response, Responses};
use bicycle::{Excitation, Formulation, Input, Parameters, State, linear};
use nalgebra::{Complex, DMatrix, DVector};
use std::collections::BTreeMap;
use std::f64::consts::{LN_10, TAU};

/// Least coherence γ² of a bin (Tischler & Remple).
const LEAST_COHERENCE: f64 = 0.6;
/// Least random error: a coherence of 1 to the last digit is no proof of an error of 0.
const LEAST_ERROR: f64 = 1e-6;
/// Weight of a squared degree against a squared decibel.
const PHASE: f64 = 0.01745;
/// Above this frequency [Hz] the torque moves no bicycle that matters to a mean gain.
const QUIET: f64 = super::spectral::QUIET;
/// Decibels in a relative change of a magnitude.
const DECIBELS: f64 = 20.0 / LN_10;

/// A bin of a measured response.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Point {
    /// Bin of the averaged windows.
    pub bin: usize,
    /// Frequency [Hz].
    pub frequency: f64,
    /// Response [unit of the channel per N m].
    pub response: Complex<f64>,
    /// Coherence γ².
    pub coherence: f64,
    /// Random error ε of the magnitude (relative) and of the phase [rad].
    pub error: f64,
}

/// Measured frequency responses and the model that is to match them.
#[derive(Debug, Clone)]
pub struct Frf {
    /// What is sought.
    pub unknowns: Unknowns,
    /// Names of the channels.
    pub channels: Vec<&'static str>,
    /// The bins of each that are looked at.
    pub points: Vec<Vec<Point>>,
    formulation: Formulation,
    law_in_loop: bool,
    speed: f64,
    states: Vec<usize>,
    /// Covariance of the channels' relative errors at each bin: [`Responses::scatter`].
    scatter: Vec<DMatrix<Complex<f64>>>,
    /// Power of the recorded torque in each bin [N² m²].
    torque: Vec<(f64, f64)>,
}

impl Frf {
    /// The responses of `channels` of a ride, at `speed` [m/s] where it does not say, in windows of
    /// `window` [s], between the frequencies of `band` [Hz].
    pub fn new(
        ride: &Ride,
        channels: &[&'static str],
        unknowns: Unknowns,
        formulation: Formulation,
        (speed, window): (f64, f64),
        band: (f64, f64),
    ) -> Result<Self> {
        let torque = ride.signal("steer_torque")?;
        let nyquist = 0.5 * ride.rate();
        let (low, high) = band;
        if !(low >= 0.0 && low < high && high <= nyquist) {
            return Err(Error::Band { low, high, nyquist });
        }
        let insensitive =
            |name: &str| Excitation::index(name).is_some() || name.ends_with("_offset");
        if let Some(free) = unknowns.free.iter().find(|f| insensitive(f.row.name)) {
            return Err(Error::NoInfluence {
                name: free.row.name.into(),
                objective: "frf",
                why: "a response from the measured torque knows neither offsets nor a remnant",
            });
        }
        let samples = (window / ride.step()).round() as usize;
        let mut states = Vec::new();
        for channel in channels {
            states.push(State::index(channel).ok_or_else(|| {
                Error::unknown("state", channel, State::TABLE.iter().map(|row| row.name))
            })?);
        }
        let outputs: Vec<_> = (channels.iter().map(|c| ride.signal(c))).collect::<Result<_>>()?;
        let measured =
            welch::responses(torque, &outputs, ride.step(), samples).ok_or(Error::Average {
                average: 1.5 * window,
                duration: ride.duration(),
                step: 4.0 * ride.step(),
            })?;
        let points: Vec<Vec<Point>> = (0..channels.len())
            .map(|c| coherent(&measured, c, band))
            .collect();
        let power = (measured.frequency.iter().zip(&measured.input))
            .filter(|(f, _)| **f < QUIET)
            // two-sided: each bin stands for one at −f as well
            .map(|(f, s)| (*f, 2.0 * s / window))
            .collect();
        let found = 2 * points.iter().map(Vec::len).sum::<usize>();
        let free = unknowns.free.len();
        if found <= free {
            return Err(Error::TooFewObservations { free, found });
        }
        Ok(Self {
            channels: channels.to_vec(),
            points,
            formulation,
            law_in_loop: ride.law_in_loop.unwrap_or(false),
            speed: ride.mean_speed(speed),
            states,
            scatter: measured.scatter,
            torque: power,
            unknowns,
        })
    }

    /// Number of observations: magnitudes and phases.
    pub fn observations(&self) -> usize {
        2 * self.points.iter().map(Vec::len).sum::<usize>()
    }

    /// The model's responses at the variables `z`, at the points of each channel.
    pub fn model(&self, z: &DVector<f64>) -> Result<Vec<Vec<Complex<f64>>>> {
        let candidate = self.unknowns.candidate(z);
        let p: Parameters = if self.law_in_loop {
            candidate.parameters
        } else {
            candidate.parameters.riderless()
        };
        let gains = Gains {
            parts: linear::apart(&p, self.formulation, self.speed),
            parameters: p,
            speed: self.speed,
        };
        let column = Input::index("steer_torque").expect("a row");
        // recorded = gain · true
        let torque = gains.parts.input.column(column) / candidate.instruments.torque_gain;
        let torque = torque.map(Complex::from);
        let n = gains.parts.state.nrows();
        // (2πif − A)⁻¹ B
        let at = |a: &DMatrix<f64>, f: f64| {
            let mut m = a.map(|v| Complex::from(-v));
            for i in 0..n {
                m[(i, i)] += Complex::new(0.0, TAU * f);
            }
            let x: Option<DVector<Complex<f64>>> = m.lu().solve(&torque);
            x.ok_or_else(|| Error::Search(format!("the model has a pole at {f} Hz")))
        };
        // what the torque makes of the bicycle decides the mean gains of its jumps
        let mut covariance = DMatrix::identity(n, n) * 1e-3;
        for _ in 0..PASSES {
            let a = gains.state(&covariance);
            let mut next = DMatrix::zeros(n, n);
            for &(f, power) in &self.torque {
                let x = at(&a, f)?;
                next += DMatrix::from_fn(n, n, |i, j| power * (x[i] * x[j].conj()).re);
            }
            let change = (&next - &covariance).norm() / next.norm();
            covariance = next;
            if change < 1e-10 {
                break;
            }
        }
        let a = gains.state(&covariance);
        let channel = |(points, state): (&Vec<Point>, &usize)| {
            let seen = gains.parts.seen.row(*state);
            let at = |point: &Point| {
                let x = at(&a, point.frequency)?;
                Ok(seen.iter().zip(x.iter()).map(|(c, x)| x * *c).sum())
            };
            points.iter().map(at).collect()
        };
        self.points.iter().zip(&self.states).map(channel).collect()
    }

    /// Residuals whose squares sum up to J: of each point the magnitude [dB] and the phase [deg]
    /// over the root of their weights.
    pub fn residuals(&self, z: &DVector<f64>) -> Result<DVector<f64>> {
        let model = self.model(z)?;
        let mut residuals = Vec::with_capacity(self.observations());
        for (points, model) in self.points.iter().zip(model) {
            for (point, model) in points.iter().zip(model) {
                let ratio = point.response / model;
                let weight = weight(point, points.len());
                residuals.push(weight * DECIBELS * ratio.norm().ln());
                residuals.push(weight * PHASE.sqrt() * ratio.arg().to_degrees());
            }
        }
        Ok(DVector::from_vec(residuals))
    }

    /// J of each channel, and of all. CIFER takes a mean below 100 for a model that serves, below
    /// 50 for one that is nearly the data.
    pub fn costs(&self, z: &DVector<f64>) -> Result<(Vec<f64>, f64)> {
        let residuals = self.residuals(z)?;
        let mut rest = residuals.as_slice();
        let costs = self.points.iter().map(|points| {
            let (own, after) = rest.split_at(2 * points.len());
            rest = after;
            own.iter().map(|r| r * r).sum()
        });
        Ok((costs.collect(), residuals.norm_squared()))
    }

    /// ∂residuals/∂z: central differences, their step such that 1e-10 of curvature and of round-off
    /// are left.
    fn jacobian(&self, z: &DVector<f64>) -> Result<DMatrix<f64>> {
        const H: f64 = 1e-5;
        let mut jacobian = DMatrix::zeros(self.observations(), z.len());
        for i in 0..z.len() {
            let at = |h: f64| {
                let mut moved = z.clone();
                moved[i] += h;
                self.residuals(&moved)
            };
            let slope = (at(H)? - at(-H)?) / (2.0 * H);
            jacobian.set_column(i, &slope);
        }
        Ok(jacobian)
    }

    /// What the responses know at `z`: the scatter of the gradient from the random errors, those of
    /// the channels at one bin together.
    pub fn information(&self, z: &DVector<f64>) -> Result<Information> {
        let jacobian = self.jacobian(z)?;
        let n = z.len();
        // at each bin, of each channel there, what its complex relative error δ adds to the
        // gradient: Re(h δ), magnitude and phase being the real and the imaginary part of δ
        let mut bins = BTreeMap::<usize, Vec<_>>::new();
        let mut row = 0;
        for (channel, points) in self.points.iter().enumerate() {
            for point in points {
                let weight = weight(point, points.len());
                let magnitude = jacobian.row(row) * (weight * DECIBELS);
                let phase = jacobian.row(row + 1) * (weight * PHASE.sqrt() * 1f64.to_degrees());
                let h = DVector::from_fn(n, |i, _| Complex::new(magnitude[i], -phase[i]));
                bins.entry(point.bin).or_default().push((channel, h));
                row += 2;
            }
        }
        let mut meat = DMatrix::zeros(n, n);
        for (bin, channels) in bins {
            for (i, h) in &channels {
                for (j, other) in &channels {
                    let mut covariance = self.scatter[bin][(*i, *j)];
                    if i == j {
                        covariance = (2.0 * LEAST_ERROR.powi(2)).max(covariance.re).into();
                    }
                    // of a circular δ, E[Re(h δ) Re(g δ')] = ½ Re(h ḡ E[δ δ̄'])
                    meat += (h * other.adjoint()).map(|x| 0.5 * (x * covariance).re);
                }
            }
        }
        Ok(Information {
            curvature: jacobian.transpose() * &jacobian,
            meat: Some(meat),
            freedom: None,
            factor: 1.0,
        })
    }

    /// Mean square of the residuals over their random errors: 1 where the model is true.
    pub fn misfit(&self, z: &DVector<f64>) -> Result<f64> {
        let model = self.model(z)?;
        let mut sum = 0.0;
        for (points, model) in self.points.iter().zip(model) {
            for (point, model) in points.iter().zip(model) {
                let ratio = (point.response / model).ln();
                sum += ratio.norm_sqr() / (point.error * point.error);
            }
        }
        Ok(sum / self.observations().saturating_sub(z.len()).max(1) as f64)
    }
}

/// Passes of the linearisation at most.
const PASSES: usize = 30;

/// Root of the weight of a squared decibel at `point`, one of `n` of its channel.
fn weight(point: &Point, n: usize) -> f64 {
    (20.0 / n as f64).sqrt() * 1.58 * (1.0 - (-point.coherence).exp())
}

/// Every other bin of output `channel` of `measured` within `band` that is coherent: neighbours of a
/// Hann window see the same noise.
fn coherent(measured: &Responses, channel: usize, (low, high): (f64, f64)) -> Vec<Point> {
    let Response {
        response,
        coherence,
    } = &measured.outputs[channel];
    (0..measured.frequency.len())
        .step_by(2)
        .map(|bin| Point {
            bin,
            frequency: measured.frequency[bin],
            response: response[bin],
            coherence: coherence[bin],
            // half of the power of a circular error is the magnitude's, half the phase's
            error: (0.5 * measured.scatter[bin][(channel, channel)].re)
                .max(0.0)
                .sqrt()
                .max(LEAST_ERROR),
        })
        .filter(|p| p.frequency >= low && p.frequency <= high && p.coherence >= LEAST_COHERENCE)
        .collect()
}

impl Landscape for Frf {
    fn cost(&self, z: &DVector<f64>) -> f64 {
        self.residuals(z)
            .map_or(f64::INFINITY, |r| 0.5 * r.norm_squared())
    }

    fn quadratic(&self, z: &DVector<f64>) -> Result<Quadratic> {
        let (jacobian, residuals) = (self.jacobian(z)?, self.residuals(z)?);
        Ok(Quadratic {
            gradient: jacobian.transpose() * residuals,
            curvature: jacobian.transpose() * jacobian,
            blocks: Vec::new(),
        })
    }
}

#[cfg(test)]
mod tests;
