//! Spectra measured and expected: what `amplitude` and `whittle` share.

use super::simulated::Simulated;
use super::{Information, Unknowns};
use crate::closed_loop::{Bin, ClosedLoop, Drive, Expansion, LineMotion};
use crate::error::{Error, Result};
use crate::ride::Ride;
use crate::spectrum::{Analysis, Kernel, Recipe};
use bicycle::{Formulation, Parameters, State};
use nalgebra::{Complex, DMatrix, DVector};
use rayon::prelude::*;
use std::sync::Arc;

/// Above this frequency [Hz] a bicycle does not move and a channel is noise.
pub const QUIET: f64 = 10.0;

/// The spectrum of a ride in some channels.
#[derive(Clone)]
pub struct Measured {
    /// Names of the channels.
    pub channels: Vec<&'static str>,
    /// How the spectrum was taken.
    pub analysis: Analysis,
    /// Coefficients [unit/√Hz], one vector over the channels a bin.
    pub coefficients: Vec<DVector<Complex<f64>>>,
    /// Standard deviation of each channel's white noise [SI].
    pub noise: Vec<f64>,
    /// Step of the record [s].
    pub step: f64,
    /// Mean speed [m/s].
    pub speed: f64,
    /// Standard deviation of the speed over its mean.
    pub speed_spread: f64,
    /// Lines in the steering that nobody masked [Hz].
    pub unmasked: Vec<f64>,
    /// The masked lines as the steering shows them.
    pub lines: Vec<LineMotion>,
    /// Rows of the state behind the channels.
    pub(super) states: Vec<usize>,
    pub(super) kernel: Arc<Kernel>,
}

impl Measured {
    /// The spectrum of `channels` of `ride`, which moves at `speed` [m/s] where it does not say.
    /// `noise` [SI] overrides what the bins above [`QUIET`] say.
    pub fn new(
        ride: &Ride,
        channels: &[&'static str],
        recipe: &Recipe,
        speed: f64,
        noise: Option<&[f64]>,
    ) -> Result<Self> {
        let analysis = Analysis::new(recipe, ride.step(), ride.len())?;
        let mut transformed = Vec::new();
        let mut deviations = Vec::new();
        for (i, channel) in channels.iter().enumerate() {
            let samples = ride.signal(channel)?;
            transformed.push(analysis.coefficients(samples));
            let given = noise.and_then(|n| n.get(i).copied());
            deviations.push(match given {
                Some(noise) => noise,
                None => estimated_noise(&analysis, ride, channel)?,
            });
        }
        let coefficients = (0..analysis.frequencies().len())
            .map(|k| DVector::from_iterator(channels.len(), transformed.iter().map(|t| t[k])))
            .collect();
        let steer = ride.signal("steer")?;
        let lines = recipe
            .lines
            .iter()
            .map(|line| LineMotion {
                frequency: line.frequency,
                steer_amplitude: analysis.line_amplitude(steer, line.frequency),
            })
            .collect();
        let speed = ride.mean_speed(speed);
        let speed_spread = ride.channel("speed").map_or(0.0, |v| {
            let square = v.iter().map(|v| (v - speed).powi(2)).sum::<f64>() / v.len() as f64;
            square.sqrt() / speed
        });
        let unmasked = analysis.standing_lines(steer);
        let states = channels
            .iter()
            .map(|c| {
                State::index(c).ok_or_else(|| {
                    Error::unknown("state", c, State::TABLE.iter().map(|row| row.name))
                })
            })
            .collect::<Result<_>>()?;
        Ok(Self {
            channels: channels.to_vec(),
            kernel: Arc::new(analysis.kernel()),
            analysis,
            coefficients,
            noise: deviations,
            step: ride.step(),
            speed,
            speed_spread,
            unmasked,
            lines,
            states,
        })
    }
}

/// The white noise of `channel`, from the bins in which a bicycle does not move.
pub(super) fn estimated_noise(analysis: &Analysis, ride: &Ride, channel: &str) -> Result<f64> {
    analysis
        .noise(ride.signal(channel)?, QUIET)
        .ok_or_else(|| Error::NoNoise {
            channel: channel.into(),
            above: QUIET,
            nyquist: 0.5 * ride.rate(),
        })
}

/// A measured spectrum and the model that is to match it.
#[derive(Clone)]
pub struct Spectral {
    /// What was measured.
    pub measured: Measured,
    /// What is sought.
    pub unknowns: Unknowns,
    /// How the equations are read.
    pub formulation: Formulation,
    /// Whose spectrum is expected.
    pub source: Source,
}

/// Whose spectrum is expected.
#[derive(Clone)]
pub enum Source {
    /// That of the equations, linearised.
    Linearised,
    /// The mean of simulated rides.
    Simulated(Arc<Simulated>),
}

impl Spectral {
    /// Bicycle and drive at the variables `z`. A free `effective_damping` stands for viscous and
    /// Coulomb friction together.
    pub(crate) fn setting(&self, z: &DVector<f64>) -> (Parameters, Drive) {
        let candidate = self.unknowns.candidate(z);
        let (mut parameters, excitation) = (candidate.parameters, candidate.excitation);
        let mut free = self.unknowns.free.iter();
        if free.any(|f| f.row.name == "effective_damping") {
            let friction = (
                &mut parameters.viscous_friction,
                &mut parameters.coulomb_friction,
            );
            (*friction.0, *friction.1) = (excitation.effective_damping, 0.0);
        }
        let drive = Drive {
            speed: self.measured.speed,
            remnant_intensity: excitation.remnant_intensity,
            remnant_corner: excitation.remnant_corner,
            lines: self.measured.lines.clone(),
        };
        (parameters, drive)
    }

    /// The linearised loop at the variables `z`.
    pub fn closed_loop(&self, z: &DVector<f64>) -> Result<ClosedLoop> {
        let (parameters, drive) = self.setting(z);
        ClosedLoop::new(&parameters, self.formulation, &drive)
    }

    /// The linearised loop beside the spectrum expected at `z`: none where rides are simulated that
    /// it says nothing of.
    pub fn beside(&self, z: &DVector<f64>) -> Result<Option<ClosedLoop>> {
        match &self.source {
            Source::Linearised => self.closed_loop(z).map(Some),
            Source::Simulated(rides) if rides.foreign().is_some() => Ok(None),
            Source::Simulated(_) => Ok(self.closed_loop(z).ok()),
        }
    }

    /// Expected cross-powers at the variables `z`.
    pub fn expected(&self, z: &DVector<f64>) -> Result<Vec<Bin>> {
        match &self.source {
            Source::Linearised => self.linearised(z),
            Source::Simulated(rides) => {
                let mut spectra = rides.spectra(&[self.setting(z)]);
                spectra.pop().expect("one a setting")
            }
        }
    }

    fn linearised(&self, z: &DVector<f64>) -> Result<Vec<Bin>> {
        let m = &self.measured;
        Ok(self
            .closed_loop(z)?
            .expected(&m.kernel, &m.states, &m.noise, m.step))
    }

    /// [`Self::expected`] at each of `points`, all cores at work: simulated rides as one batch.
    pub fn each_expected(&self, points: &[DVector<f64>]) -> Vec<Result<Vec<Bin>>> {
        match &self.source {
            Source::Linearised => points.par_iter().map(|z| self.linearised(z)).collect(),
            Source::Simulated(rides) => {
                let settings: Vec<_> = points.iter().map(|z| self.setting(z)).collect();
                rides.spectra(&settings)
            }
        }
    }

    /// How far a `z` without a spectrum is from having one: the growth [1/s] of a loop that does
    /// not stand, the part of simulated rides that falls cut off.
    pub fn excess(&self, z: &DVector<f64>) -> f64 {
        let error = match &self.source {
            Source::Linearised => self.closed_loop(z).err(),
            Source::Simulated(_) => self.expected(z).err(),
        };
        error.as_ref().map_or(0.0, excess)
    }

    /// [`Self::expected`] with its derivatives ∂/∂z. Of the linearised loop only the equations are
    /// differenced, over a step that leaves 1e-10 of curvature and 1e-10 of round-off, so that a
    /// singular direction is seen as one.
    pub fn expansion(&self, z: &DVector<f64>) -> Result<Expansion> {
        const H: f64 = 1e-5;
        if let Source::Simulated(rides) = &self.source {
            return rides.expansion(z, |z| self.setting(z));
        }
        let variables: Vec<_> = (0..z.len())
            .map(|i| {
                [-H, H].map(|h| {
                    let mut moved = z.clone();
                    moved[i] += h;
                    self.setting(&moved)
                })
            })
            .collect();
        let m = &self.measured;
        let closed_loop = self.closed_loop(z)?;
        let variables = (variables.as_slice(), 2.0 * H);
        closed_loop.expansion(&m.kernel, &m.states, &m.noise, m.step, variables)
    }

    /// What the spectrum knows, from a curvature.
    pub fn information(&self, curvature: DMatrix<f64>) -> Information {
        let factor = self.measured.analysis.recipe().taper.covariance_factor();
        Information {
            curvature,
            meat: None,
            freedom: None,
            factor,
        }
    }
}

/// What an error says of how far a point is from having a spectrum.
pub(super) fn excess(error: &Error) -> f64 {
    match error {
        Error::Unstable { growth, .. } => *growth,
        Error::Fell { cut, .. } => *cut,
        _ => 0.0,
    }
}
