//! Many rides on all cores: batches of lanes, with the widest instructions there are, folded into
//! what is wanted of them while they are in the cache.

use crate::error::{Error, Result};
use crate::kernel::{self, Work};
use bicycle::batch::{self, Lane, Plan, See, Unfit};
use bicycle::lanes::Pack;
use bicycle::simulate::Stop;
use bicycle::{Bicycle, Formulation, Parameters, State};
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
    /// Fourier coefficients of a band.
    Band(Band<'a>),
}

/// Fourier coefficients wanted of rides.
#[derive(Debug, Clone, Copy)]
pub struct Band<'a> {
    /// Samples that are ridden before the record begins.
    pub before: usize,
    /// Rows of the state.
    pub channels: &'a [usize],
    /// Sample after sample of the record the weights of each bin, real and imaginary, as
    /// [`crate::spectrum::Analysis::weights`] gives them.
    pub weights: &'a [[f64; 2]],
}

/// What came out of a ride.
#[derive(Debug, Clone, PartialEq)]
pub enum Ridden {
    /// Steer angles [rad].
    Steer(Vec<f64>),
    /// Fourier coefficients, one for each bin, channel after channel.
    Band(Vec<Vec<Complex<f64>>>),
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
        let mut fold = Fold::<T>::new(&self, &lanes);
        let (torques, formulation) = (torques.as_slice(), self.formulation);
        let outcome = batch::ride(&lanes, formulation, self.plan, torques, &mut fold)?;
        let stops = outcome.stops.into_iter().enumerate();
        Ok(stops.map(|(lane, stop)| fold.of(lane, stop)).collect())
    }
}

/// What has been seen of a batch so far.
struct Fold<'a, T> {
    band: Option<Band<'a>>,
    /// The bicycles and their speeds, where their yaw rate is no state but follows from others.
    bound: Option<(Bicycle<T>, T)>,
    steer: Vec<T>,
    /// Channel after channel.
    sums: Vec<[T; 2]>,
    bins: usize,
}

impl<'a, T: Pack> Fold<'a, T> {
    fn new(batch: &Batch<'a>, lanes: &[Lane]) -> Self {
        let Batch {
            plan,
            wanted,
            formulation,
            ..
        } = *batch;
        let (band, bins, samples) = match wanted {
            Wanted::Steer => (None, 0, plan.samples),
            Wanted::Band(band) => {
                let record = plan.samples.saturating_sub(band.before).max(1);
                (Some(band), band.weights.len() / record, 0)
            }
        };
        let lane = |i: usize| &lanes[i.min(lanes.len() - 1)];
        let bound = lanes.first().and_then(|first| {
            let row = |i: usize| T::from_fn(|lane_| lane(lane_).parameters.get(i));
            let yaw = State::index("yaw_rate")?;
            let seen = band.is_some_and(|band| band.channels.contains(&yaw));
            let still = Bicycle::new(&first.parameters, formulation).order() <= yaw;
            (seen && still).then(|| {
                let parameters = Parameters::from_array(std::array::from_fn(row));
                let speed = T::from_fn(|i| lane(i).speed);
                (Bicycle::new(&parameters, formulation), speed)
            })
        });
        Self {
            band,
            bound,
            steer: Vec::with_capacity(samples),
            sums: vec![[T::from(0.0); 2]; band.map_or(0, |band| band.channels.len() * bins)],
            bins,
        }
    }

    fn of(&self, lane: usize, stop: Option<Stop>) -> Ridden {
        let coefficient = |[re, im]: &[T; 2]| Complex::new(re.lane(lane), im.lane(lane));
        match (stop, self.band) {
            (Some(stop), _) => Ridden::Stopped(stop),
            (None, None) => Ridden::Steer(self.steer.iter().map(|s| s.lane(lane)).collect()),
            (None, Some(_)) => {
                let channels = self.sums.chunks(self.bins.max(1));
                Ridden::Band(
                    channels
                        .map(|c| c.iter().map(coefficient).collect())
                        .collect(),
                )
            }
        }
    }
}

impl<T: Pack> See<T> for Fold<'_, T> {
    #[inline(always)]
    fn sample(&mut self, k: usize, x: &State<T>) {
        let Some(band) = self.band else {
            self.steer.push(x.steer);
            return;
        };
        let Some(k) = k.checked_sub(band.before) else {
            return;
        };
        let mut seen = *x;
        if let Some((bicycle, speed)) = &self.bound {
            seen.yaw_rate = bicycle.yaw_rate(x, *speed);
        }
        let weights = &band.weights[k * self.bins..];
        for (row, sums) in band
            .channels
            .iter()
            .zip(self.sums.chunks_mut(self.bins.max(1)))
        {
            let value = seen.get(*row);
            for (sum, weight) in sums.iter_mut().zip(weights) {
                sum[0] = T::from(weight[0]).mul_add(value, sum[0]);
                sum[1] = T::from(weight[1]).mul_add(value, sum[1]);
            }
        }
    }
}

#[cfg(test)]
mod tests;
