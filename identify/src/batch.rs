//! Many rides on all cores: batches of lanes, with the widest instructions there are, folded into
//! what is wanted of them while they are in the cache.

use crate::error::{Error, Result};
use crate::kernel::{self, Work};
use bicycle::batch::{self, Lane, Plan, See, Unfit};
use bicycle::lanes::Pack;
use bicycle::simulate::Stop;
use bicycle::{Formulation, State};
use nalgebra::Complex;

/// A ride to be simulated: a bicycle with what acts on it.
#[derive(Debug, Clone, Copy)]
pub struct Excited<'a> {
    /// The bicycle, its speed and where it starts.
    pub lane: Lane,
    /// Torque besides the rider law [N m] at each sample; it runs straight between them.
    pub torque: &'a [f64],
}

/// What is wanted of the rides.
#[derive(Debug, Clone, Copy)]
pub enum Wanted<'a> {
    /// The steer angle [rad] at each sample.
    Steer,
    /// Fourier coefficients of the steer angle: sample after sample the weights of each bin, real
    /// and imaginary, as [`crate::spectrum::Analysis::weights`] gives them.
    Band(&'a [[f64; 2]]),
}

/// What came out of a ride.
#[derive(Debug, Clone, PartialEq)]
pub enum Ridden {
    /// Steer angles [rad].
    Steer(Vec<f64>),
    /// Fourier coefficients, one for each bin.
    Band(Vec<Complex<f64>>),
    /// It ended early.
    Stopped(Stop),
}

/// Rides all of `rides` on all cores, results in their order and the same whatever the number of
/// cores.
pub fn ride(
    rides: &[Excited],
    formulation: Formulation,
    plan: &Plan,
    wanted: Wanted,
) -> Result<Vec<Ridden>> {
    let batches = kernel::in_batches(rides, |rides| {
        vec![ride_together(rides, formulation, plan, wanted)]
    });
    let mut ridden = Vec::with_capacity(rides.len());
    for batch in batches {
        ridden.extend(batch?);
    }
    Ok(ridden)
}

/// Rides one batch, of at most [`kernel::Isa::lanes`], on this core.
pub fn ride_together(
    rides: &[Excited],
    formulation: Formulation,
    plan: &Plan,
    wanted: Wanted,
) -> Result<Vec<Ridden>> {
    let short = |ride: &&Excited| ride.torque.len() < plan.samples;
    if let Some(ride) = rides.iter().find(short) {
        return Err(Error::TorqueTooShort {
            expected: plan.samples,
            found: ride.torque.len(),
        });
    }
    let batch = Batch {
        rides,
        formulation,
        plan,
        wanted,
    };
    Ok(kernel::run(batch)?)
}

struct Batch<'a> {
    rides: &'a [Excited<'a>],
    formulation: Formulation,
    plan: &'a Plan,
    wanted: Wanted<'a>,
}

impl Work for Batch<'_> {
    type Output = std::result::Result<Vec<Ridden>, Unfit>;

    #[inline(always)]
    fn run<T: Pack>(self) -> Self::Output {
        let lanes: Vec<Lane> = self.rides.iter().map(|ride| ride.lane).collect();
        let torques: Vec<&[f64]> = self.rides.iter().map(|ride| ride.torque).collect();
        let mut fold = Fold::<T>::new(self.wanted, self.plan);
        let (torques, formulation) = (torques.as_slice(), self.formulation);
        let outcome = batch::ride(&lanes, formulation, self.plan, torques, &mut fold)?;
        let stops = outcome.stops.into_iter().enumerate();
        Ok(stops.map(|(lane, stop)| fold.of(lane, stop)).collect())
    }
}

/// What has been seen of a batch so far.
struct Fold<'a, T> {
    weights: Option<&'a [[f64; 2]]>,
    steer: Vec<T>,
    sums: Vec<[T; 2]>,
}

impl<'a, T: Pack> Fold<'a, T> {
    fn new(wanted: Wanted<'a>, plan: &Plan) -> Self {
        let (weights, bins, samples) = match wanted {
            Wanted::Steer => (None, 0, plan.samples),
            Wanted::Band(weights) => (Some(weights), weights.len() / plan.samples.max(1), 0),
        };
        Self {
            weights,
            steer: Vec::with_capacity(samples),
            sums: vec![[T::from(0.0); 2]; bins],
        }
    }

    fn of(&self, lane: usize, stop: Option<Stop>) -> Ridden {
        let coefficient = |[re, im]: &[T; 2]| Complex::new(re.lane(lane), im.lane(lane));
        match (stop, self.weights) {
            (Some(stop), _) => Ridden::Stopped(stop),
            (None, None) => Ridden::Steer(self.steer.iter().map(|s| s.lane(lane)).collect()),
            (None, Some(_)) => Ridden::Band(self.sums.iter().map(coefficient).collect()),
        }
    }
}

impl<T: Pack> See<T> for Fold<'_, T> {
    #[inline(always)]
    fn sample(&mut self, k: usize, x: &State<T>) {
        let Some(weights) = self.weights else {
            self.steer.push(x.steer);
            return;
        };
        let bins = self.sums.len();
        for (sum, weight) in self.sums.iter_mut().zip(&weights[k * bins..]) {
            sum[0] = T::from(weight[0]).mul_add(x.steer, sum[0]);
            sum[1] = T::from(weight[1]).mul_add(x.steer, sum[1]);
        }
    }
}

#[cfg(test)]
mod tests;
