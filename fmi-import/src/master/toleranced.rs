//! Steps as short as a tolerance asks for: each is made once whole and, from the same state, in
//! halves; the difference is the error of the halves (Hairer, Nørsett & Wanner 1993, *Solving
//! Ordinary Differential Equations I*, §II.4; for co-simulation Schierz, Arnold & Clauß 2012).
//!
//! Values held over a step make a method of first order: its error in a step of h is C h², that of
//! two halves C h²/2, and so is the difference. What steps may add to the error within [`MEMORY`] is
//! the tolerance. So the error stays within it where the system forgets within that time, as one
//! that a controller holds does; one that amplifies errors amplifies these too. An output that
//! says that it depends on an input at once lags by a step: its error is of the first order and does
//! not add up, so it may be the whole tolerance in each step.

use super::exchange::Seat;
use super::run::{Account, Points};
use super::step::Ended;
use super::{End, Master, Plan};
use crate::simulate::NEGLIGIBLE;
use crate::{Error, Step};

/// Time in which steps may add the tolerance to the error \[s\].
const MEMORY: f64 = 1.0;
/// Steps are cut no further than to this share of the plan's: a relay that switches at once would
/// have them cut without end.
const SHORTEST: f64 = 1e-3;
/// Aimed at, of the error allowed.
const SAFETY: f64 = 0.8;
/// A step is at most so much longer than the one before.
const GROWTH: f64 = 4.0;
/// And at least so much of it.
const SHRINKAGE: f64 = 0.1;

/// How a trial went.
enum Trial {
    /// The error, as a tolerance that would just allow it.
    Error(f64),
    /// A participant ended in it.
    Ended(Ended, f64),
}

impl Master<'_> {
    /// Whether the plan can be carried out with steps that are cut.
    pub(super) fn check_tolerance(&mut self, plan: &Plan, tolerance: f64) -> Result<(), Error> {
        if !(tolerance.is_finite() && tolerance > 0.0) {
            return Err(Error::Plan {
                what: "tolerance",
                expected: "a positive number",
                found: tolerance,
            });
        }
        for seat in &self.seats {
            let reason = if !seat.participant.can_keep() {
                "can go back to a state it was in (canGetAndSetFMUstate)"
            } else if !seat.participant.can_vary_step() {
                "takes steps of any length (canHandleVariableCommunicationStepSize)"
            } else if seat
                .step
                .is_some_and(|own| own.to_bits() != plan.step.to_bits())
            {
                "has no step of its own"
            } else {
                continue;
            };
            return Err(Error::Untolerant {
                member: seat.name.clone(),
                reason,
            });
        }
        Ok(())
    }

    /// Steps from point to point in as many pieces as the tolerance needs.
    pub(super) fn go_within(
        &mut self,
        plan: &Plan,
        points: Points,
        tolerance: f64,
        account: &mut Account,
    ) -> Result<End, Error> {
        let mut wanted = plan.step;
        let mut exchange = plan.initial_exchange;
        for n in 0..points.count {
            let (mut from, to) = (points.at(n), points.at(n + 1));
            while from < to {
                if self.watch.is_stopped() {
                    return Ok(End::Stopped);
                }
                let pieces = ((to - from) / wanted - NEGLIGIBLE).ceil().max(1.0);
                let next = if pieces > 1.0 {
                    from + (to - from) / pieces
                } else {
                    to
                };
                let h = next - from;
                let shortest = h <= 1.001 * SHORTEST * plan.step;
                for seat in 0..self.seats.len() {
                    self.call(seat, from, |s| s.participant.keep())?;
                }
                let before = account.board.clone();
                let excess = match self.attempt(plan, from, next, exchange, account)? {
                    Trial::Error(error) => error / tolerance,
                    // an end of its own will; a step that cannot be computed may be one too long
                    Trial::Ended(ended, at) => {
                        let terminated = matches!(
                            ended.step,
                            Step::Discarded {
                                terminated: true,
                                ..
                            }
                        );
                        if terminated || shortest {
                            return Ok(self.end_early(ended, at, account));
                        }
                        f64::INFINITY
                    }
                };
                // errors over what is allowed fall with h
                wanted = h * (SAFETY / excess).clamp(SHRINKAGE, GROWTH);
                if excess <= 1.0 || shortest {
                    account.forced += u64::from(excess > 1.0);
                    from = next;
                    exchange = true;
                } else {
                    account.taken_back += 1;
                    account.board = before;
                    self.go_back(from)?;
                }
                wanted = wanted.clamp(SHORTEST * plan.step, plan.step);
            }
            account.shown.copy_from_slice(&account.board);
            self.watch.record(to, &account.shown, &account.slots);
        }
        Ok(End::Complete)
    }

    /// One step from `from` to `to` and, from the same state, two halves, which stay.
    fn attempt(
        &mut self,
        plan: &Plan,
        from: f64,
        to: f64,
        exchange: bool,
        account: &mut Account,
    ) -> Result<Trial, Error> {
        let before = account.board.clone();
        if let Some(ended) = self.step_all(plan, from, to, exchange, account)? {
            return Ok(Trial::Ended(ended, from));
        }
        let whole = std::mem::replace(&mut account.board, before);
        self.go_back(from)?;
        let middle = 0.5 * (from + to);
        if let Some(ended) = self.step_all(plan, from, middle, exchange, account)? {
            return Ok(Trial::Ended(ended, from));
        }
        if let Some(ended) = self.step_all(plan, middle, to, true, account)? {
            return Ok(Trial::Ended(ended, middle));
        }
        let share = (to - from) / MEMORY;
        let exchanged = self.seats.iter().flat_map(Seat::exchanged);
        let differences = exchanged.map(|output| {
            let difference = (whole[output.slot] - account.board[output.slot]).abs();
            let allowed = if output.lags { 1.0 } else { share };
            difference / (output.nominal * allowed)
        });
        // a difference that is no number is too large
        let worse = |worst: f64, error: f64| {
            if worst.is_nan() || error <= worst {
                worst
            } else {
                error
            }
        };
        let worst = differences.fold(0.0, worse);
        Ok(Trial::Error(if worst.is_nan() {
            f64::INFINITY
        } else {
            worst
        }))
    }

    fn step_all(
        &mut self,
        plan: &Plan,
        from: f64,
        to: f64,
        exchange: bool,
        account: &mut Account,
    ) -> Result<Option<Ended>, Error> {
        let ended = self.sweep(from, plan.algorithm, exchange, |_| true, |_| to, account)?;
        if ended.is_none() {
            for seat in 0..self.seats.len() {
                self.call(seat, to, |s| s.publish(&mut account.board))?;
            }
        }
        Ok(ended)
    }

    fn go_back(&mut self, time: f64) -> Result<(), Error> {
        (0..self.seats.len())
            .try_for_each(|seat| self.call(seat, time, |s| s.participant.go_back()))
    }
}
