//! Seeded rides of the model: the rider law and its remnant, a deterministic line, sensor noise.

use crate::error::Result;
use crate::ride::Ride;
use crate::speed::SpeedTrace;
use bicycle::simulate::Simulation;
use bicycle::{Excitation, Formulation, Input, Parameters};
use rand::{Rng, SeedableRng};
use rand_distr::{Distribution, StandardNormal};
use rand_xoshiro::Xoshiro256PlusPlus;
use serde::{Deserialize, Serialize};
use std::f64::consts::TAU;

/// A sine of steer torque: the slalom as a rider's deterministic effort.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct TorqueLine {
    /// Frequency [Hz].
    pub frequency: f64,
    /// Amplitude [N m].
    pub amplitude: f64,
}

/// White noise of the sensors, standard deviations; 0 for a perfect sensor.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct SensorNoise {
    /// Steer encoder [rad].
    pub steer: f64,
    /// Roll and yaw gyroscopes [rad/s].
    pub gyro: f64,
    /// Torque sensor [N m].
    pub torque: f64,
}

impl SensorNoise {
    /// An encoder of .1°, a gyroscope of .2°/s, a torque sensor of .1 N m.
    pub const INSTRUMENTED: Self = Self {
        steer: 0.1 * TAU / 360.0,
        gyro: 0.2 * TAU / 360.0,
        torque: 0.1,
    };
    /// No noise.
    pub const NONE: Self = Self {
        steer: 0.0,
        gyro: 0.0,
        torque: 0.0,
    };
}

/// How a ride is made. The same values make the same ride, to the last bit.
#[derive(Debug, Clone)]
pub struct Synthesis {
    /// The bicycle with its rider law.
    pub parameters: Parameters,
    /// How the equations are read.
    pub formulation: Formulation,
    /// Inputs held over the ride; the steer torque is what acts besides rider, remnant and line.
    pub input: Input,
    /// A speed that changes, in place of that among the inputs; its first sample is that of the
    /// record.
    pub speed: Option<SpeedTrace>,
    /// Remnant of the rider.
    pub excitation: Excitation,
    /// A deterministic line besides.
    pub line: Option<TorqueLine>,
    /// Length [s].
    pub duration: f64,
    /// Samples per second [Hz].
    pub rate: f64,
    /// Noise of the sensors.
    pub noise: SensorNoise,
    /// Whether the ride is written with its whole steer torque, as a torque sensor sees it.
    pub torque_recorded: bool,
    /// Seed of remnant, phase and noise.
    pub seed: u64,
}

/// Time the rider rides before the record starts [s]: the slowest mode of the nominal bicycle has
/// died out by e^-16.
pub(crate) const WARM_UP: f64 = 6.0;

impl Default for Synthesis {
    /// The nominal bicycle for 24 s at 200 Hz, instruments as [`SensorNoise::INSTRUMENTED`].
    fn default() -> Self {
        Self {
            parameters: Parameters::default(),
            formulation: Formulation::default(),
            input: Input::default(),
            speed: None,
            excitation: Excitation {
                remnant_intensity: 1.2,
                ..Excitation::default()
            },
            line: None,
            duration: 24.0,
            rate: 200.0,
            noise: SensorNoise::INSTRUMENTED,
            torque_recorded: false,
            seed: 1,
        }
    }
}

impl Synthesis {
    /// Rides. Channels: steer, roll_rate, yaw_rate, speed, and steer_torque where recorded; the
    /// latter is the whole torque on the handlebar, so a model that replays it has no rider law.
    pub fn ride(&self) -> Result<Ride> {
        let step = 1.0 / self.rate;
        let [samples, warm] = [self.duration, WARM_UP].map(|t| (t * self.rate).round() as usize);
        let mut rng = Xoshiro256PlusPlus::seed_from_u64(self.seed);
        let phase = TAU * rng.random::<f64>();
        let mut normal = || -> f64 { StandardNormal.sample(&mut rng) };

        let remnant = remnant(&self.excitation, warm + samples + 1, step, &mut normal);
        let external = |t: f64| {
            let position = t / step;
            let i = (position as usize).min(remnant.len() - 2);
            let fraction = position - i as f64;
            let line = self
                .line
                .map_or(0.0, |l| l.amplitude * (TAU * l.frequency * t + phase).sin());
            remnant[i] * (1.0 - fraction)
                + remnant[i + 1] * fraction
                + line
                + self.input.steer_torque
        };

        let speed = |t: f64| {
            let trace = self.speed.as_ref();
            trace.map_or(self.input.speed, |trace| trace.at(t - warm as f64 * step))
        };
        let start = Input {
            speed: speed(0.0),
            ..self.input
        };
        let mut simulation = Simulation::new(&self.parameters, self.formulation, start, 0.0)?;
        let internal = self.parameters.internal_step;
        let pieces = (step / internal).round().max(1.0) as usize;
        let mut channels: [Vec<f64>; 4] = std::array::from_fn(|_| Vec::with_capacity(samples));
        for i in 0..warm + samples {
            let t = i as f64 * step;
            if i >= warm {
                let seen = simulation.output();
                let torque = seen.rider_torque + external(t) + self.input.assist_torque;
                for (channel, value) in
                    channels
                        .iter_mut()
                        .zip([seen.steer, seen.roll_rate, seen.yaw_rate, torque])
                {
                    channel.push(value);
                }
            }
            // torque and speed run straight between samples: the mean torque over each internal
            // step, and the speed as it runs
            for piece in 0..pieces {
                let [from, to] =
                    [piece, piece + 1].map(|k: usize| t + step * k as f64 / pieces as f64);
                let input = Input {
                    steer_torque: external(0.5 * (from + to)),
                    speed: speed(from),
                    ..self.input
                };
                let slope = Input {
                    speed: (speed(to) - speed(from)) / (to - from),
                    ..Input::ZERO
                };
                simulation.set(&self.parameters, input, slope)?;
                simulation.advance(to)?;
            }
        }

        let deviations = [
            self.noise.steer,
            self.noise.gyro,
            self.noise.gyro,
            self.noise.torque,
        ];
        for (channel, deviation) in channels.iter_mut().zip(deviations) {
            for value in channel {
                *value += deviation * normal();
            }
        }
        let [steer, roll_rate, yaw_rate, torque] = channels;
        let mut ride = Ride::new(0.0, step, samples);
        ride.insert("steer", steer)?;
        ride.insert("roll_rate", roll_rate)?;
        ride.insert("yaw_rate", yaw_rate)?;
        let recorded = (warm..warm + samples).map(|i| speed(i as f64 * step));
        ride.insert("speed", recorded.collect())?;
        if self.torque_recorded {
            ride.insert("steer_torque", torque)?;
            ride.law_in_loop = Some(false);
        }
        Ok(ride)
    }
}

/// The rider's remnant [N m] at samples `step` [s] apart: first-order low-pass noise of the
/// excitation's intensity and corner, from white noise of variance 1.
pub(crate) fn remnant(
    excitation: &Excitation,
    samples: usize,
    step: f64,
    normal: &mut impl FnMut() -> f64,
) -> Vec<f64> {
    let keep = (-TAU * excitation.remnant_corner * step).exp();
    let renew = (1.0 - keep * keep).sqrt();
    let mut value = normal();
    (0..samples)
        .map(|_| {
            let torque = value * excitation.remnant_intensity;
            value = keep * value + renew * normal();
            torque
        })
        .collect()
}
