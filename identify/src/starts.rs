//! Where searches start: points that fill a box evenly, the same for the same seed.

use crate::solver::Limits;
use nalgebra::DVector;
use rand::SeedableRng;
use rand_xoshiro::Xoshiro256PlusPlus;
use sobol_burley::{NUM_DIMENSIONS, sample};

/// Points of one scrambling that `sobol_burley` can tell apart.
const SEQUENCE: u32 = 1 << 16;

/// The random numbers of one job: the same for the same seed and job, unlike those of another.
pub fn stream(seed: u64, job: u64) -> Xoshiro256PlusPlus {
    // an odd multiplier (Steele, Vigna 2021) other than SplitMix64's own increment, with which the
    // states of neighbouring jobs would overlap
    Xoshiro256PlusPlus::seed_from_u64(seed ^ job.wrapping_mul(0xd134_2543_de82_ef95))
}

/// Owen-scrambled Sobol points (Sobol 1967, Burley 2020) within the bounds, without end: a caller
/// passes over points it has no use for and takes as many as it wants. The first 2^k of them lie
/// one in each 2^k-th of every variable's range.
pub fn sobol(limits: &Limits, seed: u64) -> impl Iterator<Item = DVector<f64>> {
    let seed = (seed ^ (seed >> 32)) as u32;
    let (lower, width) = (limits.lower.clone(), &limits.upper - &limits.lower);
    (0_u64..).map(move |index| {
        let block = (index / u64::from(SEQUENCE)) as u32;
        let index = (index % u64::from(SEQUENCE)) as u32;
        DVector::from_fn(lower.len(), |i, _| {
            // more variables than dimensions are padded with other scramblings
            let (pad, dimension) = (i as u32 / NUM_DIMENSIONS, i as u32 % NUM_DIMENSIONS);
            let seed = seed.wrapping_add(block).wrapping_add(pad << 16);
            lower[i] + width[i] * f64::from(sample(index, dimension, seed))
        })
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use rand::Rng;

    fn box_of(n: usize) -> Limits {
        Limits {
            lower: DVector::from_fn(n, |i, _| -1.0 - i as f64),
            upper: DVector::from_fn(n, |i, _| 2.0 * i as f64 + 1.0),
            reach: DVector::from_element(n, 1.0),
        }
    }

    /// How many of `points` lie in each `points.len()`-th of the range of variable `i`.
    fn histogram(points: &[DVector<f64>], limits: &Limits, i: usize) -> Vec<usize> {
        let mut cells = vec![0; points.len()];
        for point in points {
            let part = (point[i] - limits.lower[i]) / (limits.upper[i] - limits.lower[i]);
            assert!((0.0..=1.0).contains(&part), "{point}");
            cells[((part * points.len() as f64) as usize).min(points.len() - 1)] += 1;
        }
        cells
    }

    #[test]
    fn one_point_is_in_each_part_of_every_range() {
        let limits = box_of(5);
        let points: Vec<_> = sobol(&limits, 7).take(32).collect();
        for i in 0..5 {
            assert!(histogram(&points, &limits, i).iter().all(|&n| n == 1));
        }
    }

    #[test]
    fn sobol_points_fill_the_plane_better_than_chance() {
        // the first two variables of 2^8 points: one in each of 16 × 16 squares would be perfect,
        // chance leaves e⁻¹ of them empty; a (t, m, 2) net with t = 0 none at all
        let limits = box_of(2);
        let mut squares = vec![0; 256];
        for point in sobol(&limits, 3).take(256) {
            let cell = |i: usize| {
                let part = (point[i] - limits.lower[i]) / (limits.upper[i] - limits.lower[i]);
                ((part * 16.0) as usize).min(15)
            };
            squares[16 * cell(0) + cell(1)] += 1;
        }
        assert!(squares.iter().all(|&n| n == 1), "{squares:?}");
    }

    #[test]
    fn a_seed_decides_and_another_seed_differs() {
        let limits = box_of(3);
        let first = |seed| -> Vec<_> { sobol(&limits, seed).take(4).collect() };
        assert_eq!(first(1), first(1));
        assert_ne!(first(1), first(2));
        assert_ne!(first(0), first(1 << 32), "the seed's upper half counts");
        let draw = |seed, job| stream(seed, job).random::<u64>();
        assert_eq!(draw(1, 2), draw(1, 2));
        assert!(draw(1, 2) != draw(1, 3) && draw(1, 2) != draw(2, 2));
    }

    #[test]
    fn sobol_goes_on_beyond_one_scrambling_and_beyond_its_dimensions() {
        let wide = box_of(NUM_DIMENSIONS as usize + 3);
        let points: Vec<_> = sobol(&wide, 1).take(8).collect();
        let last = NUM_DIMENSIONS as usize + 2;
        assert!(histogram(&points, &wide, last).iter().all(|&n| n == 1));
        let narrow = box_of(1);
        let far = sobol(&narrow, 1).nth(SEQUENCE as usize).map(|p| p[0]);
        assert!(far.is_some_and(|x| (-1.0..1.0).contains(&x)));
        assert_ne!(far, sobol(&narrow, 1).next().map(|p| p[0]));
    }
}
