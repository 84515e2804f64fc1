//! The formulations that have no method of their own: the reference method, on lanes.

use super::watch::Watch;
use super::{Ended, Plan, See, Torque};
use crate::dynamics::{Bicycle, derivative};
use crate::lanes::Pack;
use crate::parameters::Parameters;
use crate::quantity::Vector;
use crate::simulate::{STAGES, stability_limit};
use crate::state::{Input, State};

/// Longest step [s]: 1.4e-4 rad at worst over whole rides.
const LONGEST: f64 = 1e-3;

/// Steps to a sample that every bicycle's decaying modes decay with.
fn pieces(bicycles: &[(Bicycle, f64)], interval: f64) -> usize {
    let limits = bicycles.iter().map(|(b, v)| stability_limit(b, *v));
    let longest = limits.fold(LONGEST, f64::min);
    // rounding aside; what is stiffer than a thousand steps to a sample has diverged by itself
    (interval / longest - 1e-9).ceil().clamp(1.0, 1000.0) as usize
}

/// Rides the bicycles from `x`, every step by [`STAGES`].
#[inline(always)]
pub(super) fn ride<T: Pack>(
    bicycles: &[(Bicycle, f64)],
    mut x: State<T>,
    plan: &Plan,
    outside: &impl Torque<T>,
    watch: &mut Watch<T>,
    see: &mut impl See<T>,
) -> Ended {
    let row = |i: usize| T::from_fn(|lane| bicycles[lane].0.p.get(i));
    let parameters = Parameters::from_array(std::array::from_fn(row));
    let b = Bicycle::new(&parameters, bicycles[0].0.formulation);
    let speed = T::from_fn(|lane| bicycles[lane].1);
    let pieces = pieces(bicycles, plan.interval);
    let h = plan.interval / pieces as f64;
    let mut derivatives = 0;
    for sample in 0..plan.samples {
        if watch.is_down(sample, x.roll, x.steer) {
            let fallen = watch.fallen();
            x = x.map(|row| T::from_fn(|lane| if fallen[lane] { 0.0 } else { row.lane(lane) }));
        }
        see.sample(sample, &x);
        if sample + 1 == plan.samples {
            break;
        }
        let (from, to) = (outside.at(sample), outside.at(sample + 1));
        for piece in 0..pieces {
            let (mut sum, mut stage) = (x, x);
            // no closure: what is not inlined for certain loses the lanes' instructions
            for (fraction, weight, reach) in STAGES {
                let at = (piece as f64 + fraction) / pieces as f64;
                let input = Input {
                    speed,
                    steer_torque: from + (to - from) * T::from(at),
                    ..Input::ZERO.map(T::from)
                };
                let slope = derivative(&b, &stage, &input);
                sum = sum.along(T::from(weight * h), &slope);
                stage = x.along(T::from(reach * h), &slope);
            }
            x = sum;
        }
        derivatives += 4 * pieces as u64;
    }
    Ended { derivatives }
}
