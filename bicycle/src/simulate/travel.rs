//! One internal step: pieces between events, each of the same method.

use super::jump::{Mode, Sides};
use super::{Moment, Simulation, Stop};
use crate::state::State;
use std::f64::consts::FRAC_PI_2;

/// Pieces of one internal step at most. Two are the rule where something happens; more come where a
/// fork swings about θ = 0 between jumps that drive it back from either side, in arcs that shrink
/// to nothing in finite time.
const PIECES: usize = 16;

/// Halvings of a piece within which its end is located: 2⁻⁴⁵ of its length, which is 3e-17 s in a
/// step of 1 ms.
const HALVINGS: i32 = 45;

impl Simulation {
    /// One internal step of `h` from `from`; on a stop, `here` is left where it happened.
    ///
    /// It ends at each jump that it meets and goes on from there. After [`PIECES`] pieces the last
    /// one runs to the end of the step without asking for jumps (the next step begins on the right
    /// side again); a fork that swings about θ = 0 has then come to rest there. So a step never
    /// takes more than 8000 derivatives, a stop apart; without events it takes 4, and 12 while the
    /// fork is held.
    pub(super) fn travel(&mut self, from: Moment, h: f64) -> Result<Moment, Stop> {
        let (mut at, mut rest, mut crossings) = (from, h, 0);
        for piece in 1..=PIECES {
            let last = piece == PIECES;
            if last && crossings > 1 {
                at = self.settled(at);
            }
            let mode = self.mode(&at);
            let (mut length, mut to) = (rest, self.rk4(at, rest, mode));
            let ends = !last && self.margin(&to, mode) < 0.0;
            if ends {
                (length, to) = self.end_of_mode(at, rest, to, mode);
            }
            self.look_for_stop(at, length, &to, mode)?;
            if !ends {
                return Ok(to);
            }
            at = Moment {
                state: mode.landed(&to.state),
                ..to
            };
            crossings += usize::from(at.state.steer == 0.0 && to.state.steer != 0.0);
            rest -= length;
            if rest <= 0.0 {
                break;
            }
        }
        Ok(at)
    }

    fn mode(&mut self, at: &Moment) -> Mode {
        let (b, u) = (&self.bicycle, self.ramp.at(at.time));
        let sides = Sides::at(b, &at.state);
        if sides.are_parted() {
            self.derivatives += 2;
        }
        sides.mode(b, &at.state, &u)
    }

    fn margin(&mut self, at: &Moment, mode: Mode) -> f64 {
        self.derivatives += mode.margin_evaluations();
        mode.margin(&self.bicycle, &at.state, &self.ramp.at(at.time))
    }

    /// The same moment with the fork straight and at rest, where it would stay so.
    fn settled(&mut self, at: Moment) -> Moment {
        let state = State {
            steer: 0.0,
            steer_rate: 0.0,
            ..at.state
        };
        let straight = Moment { state, ..at };
        match self.mode(&straight) {
            Mode::Held(_) => straight,
            Mode::Moving(_) => at,
        }
    }

    /// Length of the piece from `from` to the end of `mode`, which `to`, after a piece of `h`, is
    /// beyond, and the first moment there.
    ///
    /// The ITP method (Oliveira & Takahashi 2020, ACM TOMS 47(1), κ₁ = 0.2/h, κ₂ = 2, n₀ = 1): about
    /// ten pieces, and never more than one more than bisection takes.
    fn end_of_mode(&mut self, from: Moment, h: f64, to: Moment, mode: Mode) -> (f64, Moment) {
        let margin_from = self.margin(&from, mode);
        let margin_to = self.margin(&to, mode);
        let (mut before, mut after) = ((0.0, margin_from), (h, margin_to));
        let mut end = to;
        let finest = h * 0.5f64.powi(HALVINGS);
        for k in 0..=HALVINGS {
            let width = after.0 - before.0;
            if width <= finest {
                break;
            }
            let middle = before.0 + 0.5 * width;
            let falsi = (before.0 * after.1 - after.0 * before.1) / (after.1 - before.1);
            let inward = (middle - falsi).signum();
            // across the end to be found, or the far end of the bracket would stay
            let nudge = (0.2 * width * width / h).max(0.5 * finest);
            let guess = if nudge <= (middle - falsi).abs() {
                falsi + inward * nudge
            } else {
                middle
            };
            // how far from the middle still keeps the promise
            let reach = h * 0.5f64.powi(k) - 0.5 * width;
            let length = if (guess - middle).abs() <= reach {
                guess
            } else {
                middle - inward * reach
            };
            let moment = self.rk4(from, length, mode);
            let margin = self.margin(&moment, mode);
            if margin < 0.0 {
                (after, end) = ((length, margin), moment);
            } else {
                before = (length, margin);
            }
        }
        (after.0, end)
    }

    /// Ends the simulation if it has reached the steer limit or lies on its side at `to`, at the
    /// end of a piece of `h` from `from`.
    fn look_for_stop(&mut self, from: Moment, h: f64, to: &Moment, mode: Mode) -> Result<(), Stop> {
        let limit = self.bicycle.p.steer_limit;
        let at_limit = |m: &Moment| m.state.steer.abs() >= limit;
        let fallen = |m: &Moment| {
            m.state.roll.abs() > FRAC_PI_2 || !m.state.to_array().iter().all(|v| v.is_finite())
        };
        if at_limit(to) {
            let [_, at] = self.locate(from, h, mode, at_limit);
            return Err(self.end(at, Stop::SteerLimit { t: at.time }));
        }
        if fallen(to) {
            let [last, _] = self.locate(from, h, mode, fallen);
            return Err(self.end(last, Stop::Diverged { t: last.time }));
        }
        Ok(())
    }

    fn end(&mut self, at: Moment, stop: Stop) -> Stop {
        self.here = at;
        self.ahead = true;
        self.stop = Some(stop);
        stop
    }

    /// The last moment before `happened` and the first at which it has, next to each other to the
    /// last bit of h, within a piece of `h` at whose end it has: bisection on the length of a piece
    /// of the same method.
    fn locate(
        &mut self,
        from: Moment,
        h: f64,
        mode: Mode,
        happened: impl Fn(&Moment) -> bool,
    ) -> [Moment; 2] {
        let (mut before, mut after, mut last) = (0.0, h, from);
        loop {
            let middle = 0.5 * (before + after);
            if middle <= before || middle >= after {
                return [last, self.rk4(from, after, mode)];
            }
            let moment = self.rk4(from, middle, mode);
            if happened(&moment) {
                after = middle;
            } else {
                (before, last) = (middle, moment);
            }
        }
    }
}
