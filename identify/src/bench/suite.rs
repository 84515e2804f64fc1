//! The named suite of bounded rides of 24 s on which the batch is judged: `section3` at five pairs
//! of trail and centre of mass, `nominal` at three trails, each under three excitations, from the
//! start of the paper's Table 2, smoothing widths 1e-3 rad and 1e-2 rad/s.

use crate::batch::{Excited, Ridden, Wanted, ride};
use crate::bicycles::{Bicycle, Changes};
use crate::error::Result;
use bicycle::batch::{Lane, Plan};
use bicycle::cases::{Case, Rearward, SETTLED};
use bicycle::simulate::{Simulation, rk4};
use bicycle::{Formulation, Input, Parameters, State, dynamics};
use rand::{Rng, SeedableRng};
use rand_xoshiro::Xoshiro256PlusPlus;
use rayon::prelude::*;
use serde::Serialize;
use std::f64::consts::TAU;

const SPEED: f64 = 8.0 / 3.6;
/// Between samples \[s\].
const INTERVAL: f64 = 5e-3;

/// A slalom and forty sines from .1 to 5 Hz for the rider's noise.
pub struct Excitation {
    slalom: f64,
    noise: f64,
    seed: u64,
}

impl Excitation {
    /// Quiet, middling, severe [N m].
    pub const ALL: [Self; 3] = [
        Self {
            slalom: 2.0,
            noise: 0.5,
            seed: 7,
        },
        Self {
            slalom: 2.0,
            noise: 2.0,
            seed: 11,
        },
        Self {
            slalom: 10.0,
            noise: 5.0,
            seed: 13,
        },
    ];

    /// The torque at each sample [N m].
    pub fn torque(&self, samples: usize) -> Vec<f64> {
        const SINES: usize = 40;
        let mut rng = Xoshiro256PlusPlus::seed_from_u64(self.seed);
        let sines: Vec<(f64, f64)> = (0..SINES)
            .map(|i| {
                let frequency = 0.1 + 4.9 * (i as f64 + rng.random::<f64>()) / SINES as f64;
                (TAU * frequency, TAU * rng.random::<f64>())
            })
            .collect();
        let amplitude = self.noise * (2.0 / SINES as f64).sqrt();
        let at = |k: usize| {
            let t = k as f64 * INTERVAL;
            let noise: f64 = sines.iter().map(|(w, phase)| (w * t + phase).sin()).sum();
            self.slalom * (TAU * 0.4 * t).sin() + amplitude * noise
        };
        (0..samples).map(at).collect()
    }
}

fn lane(parameters: &Parameters) -> Lane {
    Lane {
        parameters: Parameters {
            steer_smoothing: 1e-3,
            steer_rate_smoothing: 1e-2,
            ..*parameters
        },
        speed: SPEED,
        start: parameters.start(),
    }
}

/// The eight bicycles.
fn lanes() -> Result<Vec<Lane>> {
    let section3 = Bicycle::open("section3", &Changes::default())?.parameters;
    let nominal = Parameters::default();
    let case = |trail, rearward| Case {
        number: 0,
        trail,
        rearward,
    };
    let pairs = [
        (0.13, 0.68),
        (0.13, 0.37),
        (0.085, 0.68),
        (0.085, 0.52),
        (0.085, 0.37),
    ];
    let of_section3 = pairs
        .map(|(trail, cog)| lane(&case(trail, Rearward::CogToRear(cog)).parameters(&section3)));
    let of_nominal = [0.13, 0.085, 0.055]
        .map(|trail| lane(&case(trail, Rearward::RearLoad(0.0)).parameters(&nominal)));
    Ok(of_section3.into_iter().chain(of_nominal).collect())
}

/// `count` nominal bicycles, each a little different.
pub fn alike(count: usize) -> Vec<Lane> {
    let different = |i: usize| {
        let factor = 1.0 + 0.02 * i as f64 / count as f64;
        let p = Parameters::default();
        lane(&Parameters {
            cornering_stiffness: factor * p.cornering_stiffness,
            coulomb_friction: factor * p.coulomb_friction,
            roll_start: -0.05,
            ..p
        })
    };
    (0..count).map(different).collect()
}

/// Steer angles [rad] by the reference method, `pieces` steps to a sample.
pub fn reference(lane: &Lane, torque: &[f64], samples: usize, pieces: usize) -> Vec<f64> {
    let b = bicycle::Bicycle::new(&lane.parameters, Formulation::Repaired);
    let h = INTERVAL / pieces as f64;
    let (mut x, mut steer): (State, _) = (lane.start, Vec::with_capacity(samples));
    for k in 0..samples {
        steer.push(x.steer);
        let rise = torque[k + 1] - torque[k];
        for piece in 0..pieces {
            x = rk4(x, h, |fraction, x| {
                let input = Input {
                    speed: lane.speed,
                    steer_torque: torque[k] + rise * ((piece as f64 + fraction) / pieces as f64),
                    ..Input::ZERO
                };
                dynamics::derivative(&b, x, &input)
            });
        }
    }
    steer
}

/// Steer angles [rad] with jumps located in time.
fn with_jumps(lane: &Lane, torque: &[f64], samples: usize) -> Result<Vec<f64>> {
    let exact = Parameters {
        steer_smoothing: 0.0,
        steer_rate_smoothing: 0.0,
        ..lane.parameters
    };
    let input = |steer_torque, speed| Input {
        speed,
        steer_torque,
        ..Input::ZERO
    };
    let mut simulation = Simulation::new(
        &exact,
        Formulation::Repaired,
        input(torque[0], lane.speed),
        0.0,
    )?;
    let mut steer = Vec::with_capacity(samples);
    for k in 0..samples {
        steer.push(simulation.state().steer);
        let slope = (torque[k + 1] - torque[k]) / INTERVAL;
        simulation.set(&exact, input(torque[k], lane.speed), input(slope, 0.0))?;
        // a bicycle that falls stays where it is, and shows as a difference
        let _ = simulation.advance((k + 1) as f64 * INTERVAL);
    }
    Ok(steer)
}

/// Largest errors [rad]; none where there is no such ride.
#[derive(Debug, Clone, Copy, Default, Serialize)]
pub struct Errors {
    /// Of rides whose steer angle stays below 10° after the first second.
    pub below_10deg: Option<f64>,
    /// Of the others.
    pub elsewhere: Option<f64>,
}

/// How wrong the batch is.
#[derive(Debug, Clone, Copy)]
pub struct Accuracy {
    /// Against the reference method at 16 kHz, over whole rides.
    pub batch: Errors,
    /// The largest error over the larger of the reference method's at 1 kHz and 1e-5 rad.
    pub worst_share: f64,
    /// Of the smoothing.
    pub smoothing: f64,
}

fn apart(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).fold(0.0, |m, (a, b)| (a - b).abs().max(m))
}

/// Rides the suite.
pub fn accuracy(plan: &Plan) -> Result<Accuracy> {
    let torques = Excitation::ALL.map(|e| e.torque(plan.samples + 1));
    let lanes = lanes()?;
    let under = |torque| lanes.iter().map(move |&lane| Excited { lane, torque });
    let rides: Vec<Excited> = torques.iter().flat_map(|t| under(t)).collect();
    let ridden = ride(&rides, Formulation::Repaired, plan, Wanted::Steer)?;
    let judged: Vec<_> = rides
        .par_iter()
        .zip(&ridden)
        .map(|(Excited { lane, torque }, ridden)| {
            let exact = reference(lane, torque, plan.samples, 80);
            let coarse = apart(&reference(lane, torque, plan.samples, 5), &exact);
            let error = match ridden {
                Ridden::Steer(steer) => apart(steer, &exact),
                // the suite's rides are bounded: one that stops is altogether wrong
                _ => f64::INFINITY,
            };
            let late = &exact[(SETTLED / INTERVAL) as usize..];
            let peak = late.iter().fold(0.0_f64, |m, s| m.max(s.abs()));
            let smoothing = apart(&with_jumps(lane, torque, plan.samples)?, &exact);
            Ok((peak, error, error / coarse.max(1e-5), smoothing))
        })
        .collect::<Result<_>>()?;
    let mut accuracy = Accuracy {
        batch: Errors::default(),
        worst_share: 0.0,
        smoothing: 0.0,
    };
    for (peak, error, share, smoothing) in judged {
        let class = if peak < 10.0_f64.to_radians() {
            &mut accuracy.batch.below_10deg
        } else {
            &mut accuracy.batch.elsewhere
        };
        *class = Some(class.map_or(error, |worst| worst.max(error)));
        accuracy.worst_share = accuracy.worst_share.max(share);
        accuracy.smoothing = accuracy.smoothing.max(smoothing);
    }
    Ok(accuracy)
}
