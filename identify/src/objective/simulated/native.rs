//! Our own equations, simulated: on lanes, or where jumps are exact, one by one.

use super::{Coefficients, Job, Record, Simulated};
use crate::batch::{Band, Excited, Ridden, Wanted, ride_together};
use crate::error::{Error, Result};
use crate::kernel;
use bicycle::batch::{Lane, Plan};
use bicycle::simulate::{self, Simulation};
use bicycle::{Bicycle, Formulation, Input, Output, State};

/// Longest step \[s\]: an error below 1.2e-4 rad on bounded rides, some thousandth of a bin where the
/// mean of K rides scatters by 1/√K.
const STEP: f64 = 5e-3;

/// Rides `jobs` on all cores, results in their order.
pub(super) fn ride(
    simulated: &Simulated,
    formulation: Formulation,
    jobs: &[Job],
) -> Vec<Result<Coefficients>> {
    kernel::in_batches(jobs, |jobs| together(simulated, formulation, jobs))
}

/// Rides `jobs`, as many as there are lanes.
fn together(
    simulated: &Simulated,
    formulation: Formulation,
    jobs: &[Job],
) -> Vec<Result<Coefficients>> {
    let record = &simulated.record;
    let torques: Vec<Vec<f64>> = jobs.iter().map(|job| record.torque(job)).collect();
    // what cannot ride with the others rides alone, or not at all
    let lanes: Vec<Result<Option<Lane>>> = jobs.iter().map(|job| lane(job, formulation)).collect();
    let fit = lanes.iter().zip(&torques).filter_map(|(lane, torque)| {
        let lane = lane.as_ref().ok().copied().flatten()?;
        Some(Excited { lane, torque })
    });
    let fit: Vec<Excited> = fit.collect();
    let wanted = Wanted::Band(Band {
        before: record.before,
        channels: &record.states,
        weights: &simulated.weights,
    });
    let plan = Plan {
        interval: record.step,
        samples: record.length(),
        steps_per_sample: (record.step / STEP - 1e-9).ceil() as usize,
    };
    let ridden = if fit.is_empty() {
        Ok(Vec::new())
    } else {
        ride_together(&fit, formulation, &plan, wanted)
    };
    let mut ridden = match ridden {
        Ok(ridden) => ridden.into_iter(),
        Err(error) => {
            let why = error.to_string();
            return jobs
                .iter()
                .map(|_| Err(Error::Search(why.clone())))
                .collect();
        }
    };
    let result = |((lane, job), torque): ((Result<Option<Lane>>, &Job), &Vec<f64>)| {
        if lane?.is_none() {
            return alone(record, formulation, job, torque);
        }
        match ridden.next() {
            Some(Ridden::Band(channels)) => Ok(channels),
            Some(Ridden::Stopped(stop)) => Err(Error::Stopped(stop)),
            Some(Ridden::Steer(_)) | None => unreachable!("a band for every lane"),
        }
    };
    lanes
        .into_iter()
        .zip(jobs)
        .zip(&torques)
        .map(result)
        .collect()
}

/// The ride as a lane; none where its jumps are exact, which lanes do not know.
fn lane(job: &Job, formulation: Formulation) -> Result<Option<Lane>> {
    let (parameters, drive) = job.setting;
    simulate::check(&Bicycle::new(parameters, formulation), drive.speed)?;
    let p = parameters;
    let jumps = (!formulation.has_four_bodies() && p.steer_smoothing <= 0.0)
        || (p.coulomb_friction != 0.0 && p.steer_rate_smoothing <= 0.0);
    Ok((!jumps).then_some(Lane {
        parameters: *parameters,
        speed: drive.speed,
        start: State::ZERO,
    }))
}

/// The ride by the reference stepper, the torque over each internal step its mean.
pub(super) fn alone(
    record: &Record,
    formulation: Formulation,
    job: &Job,
    torque: &[f64],
) -> Result<Coefficients> {
    let (parameters, drive) = job.setting;
    let input = |steer_torque| Input {
        speed: drive.speed,
        steer_torque,
        ..Input::default()
    };
    let pieces = (record.step / parameters.internal_step).round().max(1.0) as usize;
    let mut simulation = Simulation::new(parameters, formulation, input(0.0), 0.0)?;
    let seen = record.channels.iter();
    let seen = seen.map(|name| Output::index(name).expect("states are seen, too"));
    let seen: Vec<usize> = seen.collect();
    let mut channels = vec![Vec::with_capacity(record.length()); seen.len()];
    for sample in 0..record.length() {
        let output = simulation.output();
        for (channel, row) in channels.iter_mut().zip(&seen) {
            channel.push(output.get(*row));
        }
        let t = sample as f64 * record.step;
        for piece in 0..pieces {
            let middle = (piece as f64 + 0.5) / pieces as f64;
            let held = torque[sample] + middle * (torque[sample + 1] - torque[sample]);
            simulation.set(parameters, input(held), Input::ZERO)?;
            simulation.advance(t + record.step * (piece + 1) as f64 / pieces as f64)?;
        }
    }
    Ok(record.coefficients(&channels))
}
