use super::*;
use rand::SeedableRng;
use rand_distr::{Distribution, Gamma, StandardNormal};
use rand_xoshiro::Xoshiro256PlusPlus;

/// How often the interval of the ratio holds it, of `sides` rides with `bins` bins each that differ
/// by a factor exp(`scatter` · normal) in amplitude.
fn coverage(sides: [usize; 2], bins: usize, scatter: f64) -> f64 {
    const TRIALS: u32 = 4000;
    let mut rng = Xoshiro256PlusPlus::seed_from_u64(11);
    let noise = Gamma::new(bins as f64, 1.0).expect("bins");
    let mut held = 0;
    for _ in 0..TRIALS {
        let rides = sides.map(|n| Rides {
            powers: (0..n)
                .map(|_| {
                    let own: f64 = StandardNormal.sample(&mut rng);
                    noise.sample(&mut rng) * (2.0 * scatter * own).exp()
                })
                .collect(),
            bins: n * bins,
        });
        let (low, high) = interval([&rides[0], &rides[1]]);
        held += u32::from(low < 1.0 && 1.0 < high);
    }
    f64::from(held) / f64::from(TRIALS)
}

/// 95 % are meant. Where rides scatter about as much as noise does, the larger of the two is taken,
/// which holds up to 98 %; between and for rides of very different scatter the degrees of freedom are
/// an approximation that costs up to 1 %. Three binomial deviations of 4000 are 1 %.
#[test]
fn rides_that_differ_are_held_against_each_other_by_what_they_differ() {
    for n in [2, 3, 5] {
        for scatter in [0.0, 0.1, 0.3, 0.5] {
            let held = coverage([n, n], 20, scatter);
            assert!((0.93..0.99).contains(&held), "{n} rides, {scatter}: {held}");
        }
    }
}

/// A ride alone takes the scatter of the others for its own: 92 % at the worst.
#[test]
fn a_ride_alone_is_taken_to_scatter_as_the_others() {
    for scatter in [0.0, 0.1, 0.3] {
        let held = coverage([1, 3], 20, scatter);
        assert!((0.91..0.98).contains(&held), "{scatter}: {held}");
    }
}

#[test]
fn two_rides_alone_are_noise() {
    let held = coverage([1, 1], 5, 0.0);
    assert!((held - 0.95).abs() < 0.0104, "{held}");
}
