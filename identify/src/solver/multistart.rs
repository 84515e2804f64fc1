//! Local searches from many starts: whether they end in one place.

use super::{Outcome, SAME_COST, numbers};
use crate::checkpoint::Journal;
use crate::error::Result;
use crate::progress::{Event, Watch};
use nalgebra::DVector;
use rayon::prelude::*;
use serde::{Deserialize, Serialize};
use std::sync::{Mutex, PoisonError};

/// Estimates that differ by less than this part of their standard error are the same.
const SAME_ESTIMATE: f64 = 0.1;

/// A problem that can be searched from anywhere, by many threads at a time.
pub trait Searchable: Sync {
    /// One local search, decided by its start alone; an error where there is no way from there.
    fn search(&self, start: &DVector<f64>, watch: &Watch) -> Result<Outcome>;
}

/// One start, and what came of it.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Attempt {
    /// Where it started.
    #[serde(with = "numbers")]
    pub start: DVector<f64>,
    /// Where it ended, or why it could not begin.
    pub outcome: std::result::Result<Outcome, String>,
}

/// Searches from many starts.
#[derive(Debug, Clone, PartialEq)]
pub struct Starts {
    /// The starts that were tried, in order.
    pub attempts: Vec<Attempt>,
    /// How many there were to try; more than attempts only where the search was stopped.
    pub planned: usize,
    /// The attempt that ended lowest, the first of equals.
    pub best: Option<usize>,
}

impl Starts {
    fn new(attempts: Vec<Attempt>, planned: usize) -> Self {
        let cost = |attempt: &Attempt| attempt.outcome.as_ref().map(|o| o.cost).ok();
        let best = attempts
            .iter()
            .enumerate()
            .filter_map(|(i, attempt)| Some((i, cost(attempt)?)))
            .min_by(|(_, a), (_, b)| a.total_cmp(b))
            .map(|(i, _)| i);
        Self {
            attempts,
            planned,
            best,
        }
    }

    /// The lowest end.
    pub fn outcome(&self) -> Option<&Outcome> {
        self.attempts[self.best?].outcome.as_ref().ok()
    }

    /// Whether it was stopped before every start had been searched from to its end.
    pub fn stopped(&self) -> bool {
        let cut = |attempt: &Attempt| attempt.outcome.as_ref().is_ok_and(|o| o.stopped);
        self.attempts.len() < self.planned || self.attempts.iter().any(cut)
    }

    /// Starts from which no search could begin.
    pub fn failures(&self) -> usize {
        self.attempts.iter().filter(|a| a.outcome.is_err()).count()
    }

    /// Which attempts ended where the best did: at its cost to 1e-3 and, for each of `determined`,
    /// (variable, standard error), at its estimate to a tenth of the standard error. Where a
    /// variable is not determined, equal costs lie apart and mean nothing.
    pub fn agreeing(&self, determined: &[(usize, f64)]) -> Vec<bool> {
        let best = self.outcome();
        let agrees = |outcome: &Outcome, best: &Outcome| {
            let near = |&(i, error): &(usize, f64)| {
                (outcome.point[i] - best.point[i]).abs() <= SAME_ESTIMATE * error
            };
            (outcome.cost - best.cost).abs() <= SAME_COST && determined.iter().all(near)
        };
        self.attempts
            .iter()
            .map(|attempt| match (&attempt.outcome, best) {
                (Ok(outcome), Some(best)) => agrees(outcome, best),
                _ => false,
            })
            .collect()
    }
}

/// Searches from each of `starts`, all cores at work; the result does not depend on how many. What
/// has ended is in `journal`, and what `journal` has is not searched for again. A stop gives the
/// starts tried so far, the ones it cut short with their best so far; those are not in the journal.
pub fn multistart(
    problem: &impl Searchable,
    starts: &[DVector<f64>],
    journal: &Journal<Attempt>,
    watch: &Watch,
) -> Result<Starts> {
    let standing = Mutex::new((0, None::<f64>));
    let tell = |attempt: &Attempt| {
        let mut standing = standing.lock().unwrap_or_else(PoisonError::into_inner);
        let (done, best) = &mut *standing;
        *done += 1;
        if let Ok(outcome) = &attempt.outcome {
            *best = Some(best.map_or(outcome.cost, |best| best.min(outcome.cost)));
        }
        watch.tell(Event::Done {
            done: *done,
            of: starts.len() as u64,
            best: *best,
        });
    };
    let attempts = starts
        .par_iter()
        .enumerate()
        .map(|(job, start)| {
            // a job is its start: another design's answer is none to this one
            let known = journal.get(job as u64).filter(|a| a.start == *start);
            let attempt = match known {
                Some(attempt) => attempt,
                None if watch.stopped() => return Ok(None),
                None => {
                    let outcome = problem.search(start, &watch.silent());
                    let attempt = Attempt {
                        start: start.clone(),
                        outcome: outcome.map_err(|cause| cause.to_string()),
                    };
                    if attempt.outcome.as_ref().is_ok_and(|o| o.stopped) {
                        return Ok(Some(attempt));
                    }
                    journal.put(job as u64, &attempt)?
                }
            };
            tell(&attempt);
            Ok(Some(attempt))
        })
        .collect::<Result<Vec<Option<Attempt>>>>()?;
    Ok(Starts::new(
        attempts.into_iter().flatten().collect(),
        starts.len(),
    ))
}

#[cfg(test)]
mod tests;
