//! The model spectrum: statistical linearisation of bicycle and rider under the rider's remnant.
//!
//! Each term that is not smooth or not nearly linear is replaced by its mean gain E[∂f/∂x] under
//! N(0, P), P the stationary covariance of the loop so linearised, until both agree. (The Jacobian
//! at upright of a smoothed jump would be wrong by factors of 4 to 17.) Roberts & Spanos 2003,
//! *Random Vibration and Statistical Linearization*, ch. 5.

mod expected;
pub(crate) mod gains;
mod response;
mod stationary;

use crate::error::{Error, Result};
use bicycle::linear;
use bicycle::{Formulation, Input, Parameters};
use gains::{Gains, STEER, STEER_RATE};
use nalgebra::{DMatrix, DVector, Dyn, LU};
use stationary::{Stationary, Swing, entries, packed, unpacked};
use std::f64::consts::TAU;

pub use expected::{Bin, Expansion};
pub use gains::sign_gain;

/// Above this steering [rad rms] the linearisation has not been checked.
pub const STEER_CHECKED: f64 = 5.0 * std::f64::consts::PI / 180.0;

/// A deterministic line as the loop sees it: its frequency and the steer amplitude it leaves.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LineMotion {
    /// Frequency [Hz].
    pub frequency: f64,
    /// Amplitude of the steer angle [rad].
    pub steer_amplitude: f64,
}

/// What drives the loop.
#[derive(Debug, Clone, PartialEq)]
pub struct Drive {
    /// Speed [m/s].
    pub speed: f64,
    /// Remnant: first-order low-pass torque noise, rms [N m].
    pub remnant_intensity: f64,
    /// Its corner [Hz].
    pub remnant_corner: f64,
    /// Deterministic lines besides.
    pub lines: Vec<LineMotion>,
}

impl Drive {
    /// Corner of the remnant as an angular rate [1/s].
    fn rate(&self) -> f64 {
        TAU * self.remnant_corner
    }
}

/// A change of a loop, per unit of whatever it changes with.
#[derive(Debug, Clone)]
struct Change {
    /// Of A.
    state: DMatrix<f64>,
    /// Of B.
    torque: DVector<f64>,
    /// Of what is seen of the rows of the state.
    seen: DMatrix<f64>,
    /// Of the corner of the remnant [1/s].
    rate: f64,
    /// Of its intensity, relative.
    intensity: f64,
}

/// Bicycle and rider, linearised about the motion the remnant makes.
#[derive(Debug, Clone)]
pub struct ClosedLoop {
    gains: Gains,
    formulation: Formulation,
    drive: Drive,
    state: DMatrix<f64>,
    /// Covariance of the states that move, lines included.
    covariance: DMatrix<f64>,
}

/// Passes of the linearisation at most.
const PASSES: usize = 60;
/// Relative change of a variance after which a pass changes nothing but round-off, and after which
/// Newton's method, whose error squares, does not either.
const ARRIVED: f64 = 1e-12;
const NEWTON_ARRIVED: f64 = 1e-7;
/// Newton's method goes on where a pass changes less than `NEAR`, but not `FAST` times less than
/// the one before: most loops arrive in some ten passes without.
const NEAR: f64 = 0.3;
const FAST: f64 = 0.2;

/// One pass: the loop with the mean gains of a covariance, and the covariance of that loop.
struct Pass {
    noise: Stationary,
    swings: Vec<Swing>,
    power: f64,
    covariance: DMatrix<f64>,
}

impl Pass {
    fn new(gains: &Gains, drive: &Drive, p: &DMatrix<f64>) -> Result<Self> {
        let state = gains.state(p);
        let torque = torque(gains);
        let unstable = || unstable(&state);
        let noise = Stationary::new(&state, &torque, drive.rate()).ok_or_else(unstable)?;
        let lines = drive.lines.iter().filter(|line| line.steer_amplitude > 0.0);
        let swings = lines
            .map(|line| Swing::new(&state, &torque, line).ok_or_else(unstable))
            .collect::<Result<Vec<_>>>()?;
        let power = drive.remnant_intensity.powi(2);
        let mut covariance = &noise.covariance * power;
        for swing in &swings {
            covariance += swing.covariance();
        }
        Ok(Self {
            noise,
            swings,
            power,
            covariance,
        })
    }

    /// The change of the covariance with a change of the loop.
    fn change(&self, change: &Change) -> DMatrix<f64> {
        let mut dp = self.noise.change(change) * self.power;
        dp += &self.noise.covariance * (2.0 * change.intensity * self.power);
        for swing in &self.swings {
            dp += swing.change(change);
        }
        dp
    }

    /// 1 − ∂(covariance after the pass)/∂(covariance `p` before it), on the different entries.
    fn feedback(&self, gains: &Gains, p: &DMatrix<f64>) -> LU<f64, Dyn, Dyn> {
        let n = p.nrows();
        let count = n * (n + 1) / 2;
        let mut matrix = DMatrix::identity(count, count);
        for (column, (i, j)) in entries(n).enumerate() {
            let mut dp = DMatrix::zeros(n, n);
            (dp[(i, j)], dp[(j, i)]) = (1.0, 1.0);
            let change = of_state(gains.change(p, &dp));
            if change.state.iter().any(|v| *v != 0.0) {
                let mut column = matrix.column_mut(column);
                column -= packed(&self.change(&change));
            }
        }
        matrix.lu()
    }
}

/// A change of nothing but the state matrix.
fn of_state(state: DMatrix<f64>) -> Change {
    let n = state.nrows();
    Change {
        torque: DVector::zeros(n),
        seen: DMatrix::zeros(bicycle::State::LEN, n),
        state,
        rate: 0.0,
        intensity: 0.0,
    }
}

/// ∂ẋ/∂(steer torque).
fn torque(gains: &Gains) -> DVector<f64> {
    let column = Input::index("steer_torque").expect("a row");
    gains.parts.input.column(column).into_owned()
}

/// The fastest growth of a loop, as an error.
fn unstable(state: &DMatrix<f64>) -> Error {
    let worst = linear::eigenvalues(state)[0];
    Error::Unstable {
        growth: worst.re,
        frequency: worst.im.abs() / TAU,
    }
}

/// The largest change of a variance, relative.
fn difference(p: &DMatrix<f64>, q: &DMatrix<f64>) -> f64 {
    let changes = p
        .diagonal()
        .zip_map(&q.diagonal(), |p, q| (p - q).abs() / q);
    changes.max()
}

impl ClosedLoop {
    /// The loop of `parameters` under `drive`.
    pub fn new(parameters: &Parameters, formulation: Formulation, drive: &Drive) -> Result<Self> {
        let gains = Gains {
            parts: linear::apart(parameters, formulation, drive.speed),
            parameters: *parameters,
            speed: drive.speed,
        };
        // begin with friction at a steer rate of .3 rad/s rms and everything else linear
        let n = gains.parts.state.nrows();
        let mut covariance = DMatrix::zeros(n, n);
        covariance[(STEER_RATE, STEER_RATE)] = 0.09;
        // and some steering: without, an unsmoothed sign θ would have no gain at all
        covariance[(STEER, STEER)] = 1e-6;
        let mut change = f64::INFINITY;
        for _ in 0..PASSES {
            let pass = Pass::new(&gains, drive, &covariance)?;
            let before = std::mem::replace(&mut change, difference(&covariance, &pass.covariance));
            let step = (change < NEAR && change > FAST * before)
                .then(|| pass.feedback(&gains, &covariance))
                .and_then(|f| f.solve(&packed(&(&pass.covariance - &covariance))));
            let newton = step
                .map(|step| &covariance + unpacked(n, &step))
                .filter(|p| p.diagonal().iter().all(|v| *v > 0.0));
            let arrived = match newton {
                Some(_) => NEWTON_ARRIVED,
                None => ARRIVED,
            };
            covariance = newton.unwrap_or(pass.covariance);
            if change < arrived {
                let state = gains.state(&covariance);
                if linear::eigenvalues(&state)[0].re >= 0.0 {
                    return Err(unstable(&state));
                }
                return Ok(Self {
                    gains,
                    formulation,
                    drive: drive.clone(),
                    state,
                    covariance,
                });
            }
        }
        Err(Error::Search(format!(
            "the linearisation still changed by {change:.1e} after {PASSES} passes"
        )))
    }

    /// Standard deviation of what is seen of a row of the state, lines included [SI].
    pub fn deviation(&self, row: usize) -> f64 {
        let seen = self.gains.parts.seen.row(row);
        (seen * &self.covariance * seen.transpose())[0].sqrt()
    }

    /// σ_θ̇ [rad/s], the steer rate's standard deviation.
    pub fn steer_rate_deviation(&self) -> f64 {
        self.deviation(STEER_RATE)
    }

    /// σ_θ [rad], the steer angle's standard deviation.
    pub fn steer_deviation(&self) -> f64 {
        self.deviation(STEER)
    }

    /// Amplitude of the steer torque [N m] that makes `line`.
    pub fn torque_amplitude(&self, line: &LineMotion) -> f64 {
        let swing = Swing::new(&self.state, &torque(&self.gains), line);
        swing
            .expect("a loop that stands has no undamped oscillation")
            .torque
    }

    /// How the loop changes along each of `variables`: of each the parameters and the drive on
    /// both sides of this loop's, `width` units of the variable apart. The differences are those
    /// of the equations at this loop's covariance; that it changes too is by differentiation.
    fn changes(&self, variables: &[[(Parameters, Drive); 2]], width: f64) -> Result<Vec<Change>> {
        if variables.is_empty() {
            return Ok(Vec::new());
        }
        let pass = Pass::new(&self.gains, &self.drive, &self.covariance)?;
        let feedback = pass.feedback(&self.gains, &self.covariance);
        let changes = variables.iter().map(|sides| {
            let mut change = self.explicit(sides, width);
            let right = packed(&pass.change(&change));
            let along = feedback.solve(&right).ok_or_else(|| {
                Error::Search("the linearisation has no derivative here: two solutions meet".into())
            })?;
            let dp = unpacked(self.covariance.nrows(), &along);
            change.state += self.gains.change(&self.covariance, &dp);
            Ok(change)
        });
        changes.collect()
    }

    /// The change along a variable with the covariance held.
    fn explicit(&self, [low, high]: &[(Parameters, Drive); 2], width: f64) -> Change {
        let mut change = if low.0 == high.0 {
            of_state(DMatrix::zeros(self.state.nrows(), self.state.nrows()))
        } else {
            let [(a, b, c), (d, e, f)] = [low, high].map(|(parameters, drive)| {
                let gains = Gains {
                    parts: linear::apart(parameters, self.formulation, drive.speed),
                    parameters: *parameters,
                    speed: drive.speed,
                };
                let torque = torque(&gains);
                (gains.state(&self.covariance), torque, gains.parts.seen)
            });
            Change {
                state: (d - a) / width,
                torque: (e - b) / width,
                seen: (f - c) / width,
                rate: 0.0,
                intensity: 0.0,
            }
        };
        change.rate = (high.1.rate() - low.1.rate()) / width;
        let ratio = high.1.remnant_intensity / low.1.remnant_intensity;
        change.intensity = ratio.ln() / width;
        change
    }
}

#[cfg(test)]
mod tests;
