//! Steps of one length, Jacobi's and Gauss–Seidel's way.

use super::run::{Account, Points};
use super::{Algorithm, End, Master, Plan};
use crate::{Error, Step};

/// Which participant ended within a step.
pub(super) struct Ended {
    pub seat: usize,
    pub step: Step,
}

impl Master<'_> {
    /// Steps from point to point, a seat n by `every[n]` of them at a time.
    pub(super) fn go(
        &mut self,
        plan: &Plan,
        points: Points,
        every: &[u64],
        account: &mut Account,
    ) -> Result<End, Error> {
        let vary = self
            .seats
            .iter()
            .map(|seat| seat.participant.can_vary_step());
        let vary: Vec<bool> = vary.collect();
        for n in 0..points.count {
            let (from, to) = (points.at(n), points.at(n + 1));
            if self.watch.is_stopped() {
                return Ok(End::Stopped);
            }
            let exchange = n > 0 || plan.initial_exchange;
            // the last steps of those that take several points may be shorter
            let until = |seat: usize| points.at((n + every[seat]).min(points.count));
            // one that takes steps of one length only does not begin one that it cannot finish
            let fits = |seat: usize| vary[seat] || n + every[seat] <= points.count;
            let is_due = |seat: usize| n.is_multiple_of(every[seat]) && fits(seat);
            let order = plan.algorithm;
            if let Some(ended) = self.sweep(from, order, exchange, is_due, until, account)? {
                return Ok(self.end_early(ended, from, account));
            }
            for (seat, every) in every.iter().enumerate() {
                if (n + 1).is_multiple_of(*every) || n + 1 == points.count {
                    if order == Algorithm::Jacobi {
                        self.call(seat, to, |s| s.publish(&mut account.board))?;
                    }
                    let slots = self.seats[seat].slots();
                    account.shown[slots.clone()].copy_from_slice(&account.board[slots]);
                }
            }
            self.watch.record(to, &account.shown, &account.slots);
        }
        Ok(End::Complete)
    }

    /// Each seat that is due sets its inputs, unless there is no `exchange`, and steps; under
    /// Gauss–Seidel it publishes at once.
    pub(super) fn sweep(
        &mut self,
        from: f64,
        algorithm: Algorithm,
        exchange: bool,
        is_due: impl Fn(usize) -> bool,
        until: impl Fn(usize) -> f64,
        account: &mut Account,
    ) -> Result<Option<Ended>, Error> {
        account.steps += 1;
        let board = &mut account.board;
        for seat in 0..self.seats.len() {
            if !is_due(seat) {
                continue;
            }
            let to = until(seat);
            let step = self.call(seat, from, |s| {
                if exchange {
                    s.set_inputs(board)?;
                }
                s.participant.step(from, to - from)
            })?;
            if step != Step::Complete {
                return Ok(Some(Ended { seat, step }));
            }
            if algorithm == Algorithm::GaussSeidel {
                self.call(seat, to, |s| s.publish(board))?;
            }
        }
        Ok(None)
    }

    /// Records what can be seen at the end of a participant that ended within a step from `from`; of
    /// the others what they were at the communication point before.
    pub(super) fn end_early(&mut self, ended: Ended, from: f64, account: &mut Account) -> End {
        let Ended { seat, step } = ended;
        let (mut time, mut said) = (from, Vec::new());
        if let Step::Discarded {
            last_successful_time,
            log,
            ..
        } = step
        {
            said = log;
            // Reading after a discard is for those that can tell the time their values are of
            // (FMI 2.0 §4.2.4).
            if let Some(at) = last_successful_time.filter(|at| at.is_finite() && *at > from)
                && self
                    .call(seat, at, |s| s.publish(&mut account.board))
                    .is_ok()
            {
                time = at;
                let slots = self.seats[seat].slots();
                account.shown[slots.clone()].copy_from_slice(&account.board[slots]);
                self.watch.record(at, &account.shown, &account.slots);
            }
        }
        End::Early {
            member: self.seats[seat].name.clone(),
            time,
            log: said,
        }
    }
}
