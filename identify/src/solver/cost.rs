//! What a point is worth where not every point has a cost.

use serde::{Deserialize, Serialize};
use std::cmp::Ordering;

/// The least penalty: above every cost of a model that runs, far below the largest number.
const PENALTY: f64 = 1e100;

/// A cost, or the penalty of a point that has none: always finite, larger than every cost, and
/// larger the further the point is from having one (Deb 2000), so that a search that only compares
/// finds its way back.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Cost(f64);

impl Cost {
    /// `cost`, or where that is not finite the penalty of `excess` ≥ 0, how far the point is from
    /// having a cost.
    pub fn new(cost: f64, excess: impl FnOnce() -> f64) -> Self {
        if cost.is_finite() && cost < PENALTY {
            return Self(cost);
        }
        let excess = excess();
        Self(
            PENALTY
                * (1.0
                    + if excess.is_nan() {
                        PENALTY
                    } else {
                        excess.clamp(0.0, PENALTY)
                    }),
        )
    }

    /// Cost or penalty: finite.
    pub fn value(self) -> f64 {
        self.0
    }

    /// How far a point without a cost is from having one, up to rounding; 0 of one with a cost.
    pub fn excess(self) -> f64 {
        (self.0 / PENALTY - 1.0).max(0.0)
    }

    /// Whether it is a penalty.
    pub fn failed(self) -> bool {
        self.0 >= PENALTY
    }
}

impl Eq for Cost {}

impl PartialOrd for Cost {
    fn partial_cmp(&self, other: &Self) -> Option<Ordering> {
        Some(self.cmp(other))
    }
}

impl Ord for Cost {
    fn cmp(&self, other: &Self) -> Ordering {
        self.0.total_cmp(&other.0)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_penalty_is_finite_and_grows_with_the_distance() {
        let fine = Cost::new(1e12, || {
            unreachable!("a cost is not asked how far it is from one")
        });
        assert_eq!((fine.value(), fine.failed()), (1e12, false));
        let excesses = [0.0, 1e-3, 2.5, 1e9, f64::INFINITY];
        for lost in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY, f64::MAX] {
            let penalties = excesses.map(|excess| Cost::new(lost, || excess));
            assert!(penalties.is_sorted_by(|a, b| a < b), "{penalties:?}");
            assert!(
                penalties
                    .iter()
                    .all(|p| p.failed() && p.value().is_finite())
            );
            assert!(fine < penalties[0]);
        }
        assert_eq!(
            Cost::new(f64::NAN, || f64::NAN),
            Cost::new(f64::NAN, || f64::INFINITY)
        );
        assert_eq!(Cost::new(f64::NAN, || -1.0), Cost::new(f64::NAN, || 0.0));
    }
}
