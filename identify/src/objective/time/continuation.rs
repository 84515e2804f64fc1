//! Long windows by way of short ones. Where errors of a start grow, a search over long windows
//! finds its optimum only from near it: the windows are halved until a search may begin at what
//! was measured, and doubled again with the parameters and states found. (Multiple shooting with
//! ever fewer nodes: Bock 1987.)

use super::Time;
use crate::objective::together::{Member, Together};
use nalgebra::DVector;

/// Windows are halved no further than to this many samples for each state of a start.
const SAMPLES: usize = 4;

impl Time {
    /// How often the windows have to be halved before a search may begin at what was measured.
    pub(super) fn halvings(&self) -> u32 {
        let longest = self.windows.iter().map(ExactSizeIterator::len).max();
        let mut samples = longest.unwrap_or(0);
        let mut halvings = 0;
        while samples as f64 * self.step > self.immediate && samples > 2 * SAMPLES * self.order {
            samples = samples.div_ceil(2);
            halvings += 1;
        }
        halvings
    }

    /// The same with each window cut in 2^`halvings` parts.
    #[must_use]
    pub(super) fn halved(&self, halvings: u32) -> Self {
        let mut halved = self.clone();
        for _ in 0..halvings {
            let parts = halved.windows.iter().flat_map(|window| {
                let middle = window.start.midpoint(window.end);
                [window.start..middle, middle..window.end]
            });
            halved.windows = parts.collect();
        }
        halved
    }

    /// The same with windows short enough for a search to begin at what was measured.
    #[must_use]
    pub(super) fn immediate(&self) -> Self {
        self.halved(self.halvings())
    }
}

/// The rides with ever longer windows; the last are their own. A search begins with the first, and
/// goes on from each to the next by [`carry`].
pub fn stages(rides: &Together<Time>) -> Vec<Together<Time>> {
    let halvings = |member: &Member<Time>| member.landscape.halvings();
    let most = rides.members.iter().map(halvings).max().unwrap_or(0);
    let stage = |left: u32| {
        let mut stage = rides.clone();
        for member in &mut stage.members {
            member.landscape = member
                .landscape
                .halved(left.min(member.landscape.halvings()));
        }
        stage
    };
    (0..=most).rev().map(stage).collect()
}

/// The variables of `longer` from those found with `shorter`: each window begins where the first
/// of its parts did.
pub fn carry(shorter: &Together<Time>, z: &DVector<f64>, longer: &Together<Time>) -> DVector<f64> {
    let mut at = longer.shared();
    let mut carried = z.as_slice()[..at].to_vec();
    for (short, long) in shorter.members.iter().zip(&longer.members) {
        let (short, long) = (&short.landscape, &long.landscape);
        for window in &long.windows {
            let same = |part: &std::ops::Range<usize>| part.start == window.start;
            let part = short.windows.iter().position(same);
            let part = part.expect("the first of its parts starts where the window does");
            carried.extend_from_slice(&z.as_slice()[at + part * short.order..][..short.order]);
        }
        at += short.windows.len() * short.order;
    }
    DVector::from_vec(carried)
}
