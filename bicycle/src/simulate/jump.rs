//! The two jumps, sign θ in (2) and the Coulomb friction in (9): which side a bicycle is on, and
//! when friction holds its fork (Filippov 1988, *Differential Equations with Discontinuous
//! Righthand Sides*).
//!
//! A sign jumps where its width is 0. The side follows from the state alone, so that nothing has to
//! be remembered: it is the sign of the angle or rate and, where that is zero, the side to which
//! the fork is on its way.

use crate::dynamics::{Bicycle, Nonlinear, derivative_with, output_with};
use crate::real::Real;
use crate::state::{Input, Output, Path, State};

/// One side of the jumps: the signs there, 1 or −1; `None` where a sign does not jump.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Side {
    steer: Option<f64>,
    steer_rate: Option<f64>,
}

impl Side {
    /// The side that a fork turning `towards` (1 left, −1 right) is on.
    fn towards(b: &Bicycle, x: &State, towards: f64) -> Self {
        let sign = |value: f64| {
            if value == 0.0 {
                towards
            } else {
                value.signum()
            }
        };
        let p = &b.p;
        // without Coulomb friction there is nothing to jump
        let friction_jumps = p.steer_rate_smoothing == 0.0 && p.coulomb_friction != 0.0;
        // nor does the trail of the four-body bicycle
        let trail_jumps = p.steer_smoothing == 0.0 && b.four_bodies.is_none();
        Self {
            steer: trail_jumps.then(|| sign(x.steer)),
            steer_rate: friction_jumps.then(|| sign(x.steer_rate)),
        }
    }

    fn nonlinear<T: Real>(self, b: &Bicycle<T>, x: &State<T>, speed: T) -> Nonlinear<T> {
        let smooth = Nonlinear::at(b, x, speed);
        Nonlinear {
            steer_sign: self.steer.map_or(smooth.steer_sign, T::from),
            steer_rate_sign: self.steer_rate.map_or(smooth.steer_rate_sign, T::from),
            ..smooth
        }
    }

    fn derivative<T: Real>(self, b: &Bicycle<T>, x: &State<T>, u: &Input<T>) -> State<T> {
        derivative_with(b, x, u, &self.nonlinear(b, x, u.speed))
    }
}

/// The sides to which a fork can turn from a state; one and the same where none of its jumps is in
/// between.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Sides {
    left: Side,
    right: Side,
}

impl Sides {
    /// Those of a state.
    pub fn at(b: &Bicycle, x: &State) -> Self {
        let [left, right] = [1.0, -1.0].map(|way| {
            let towards = if x.steer_rate == 0.0 {
                way
            } else {
                x.steer_rate.signum()
            };
            Side::towards(b, x, towards)
        });
        Self { left, right }
    }

    /// Whether a jump lies between them. Then [`Self::mode`] evaluates the equations twice, else
    /// not at all.
    pub fn are_parted(&self) -> bool {
        self.left != self.right
    }

    /// How the bicycle goes on from that state.
    pub fn mode(self, b: &Bicycle, x: &State, u: &Input) -> Mode {
        if !self.are_parted() {
            return Mode::Moving(self.left);
        }
        let [left, right] = self.accelerations(b, x, u);
        if left <= 0.0 && 0.0 <= right && left < right {
            Mode::Held(self)
        } else if left >= -right {
            // driven apart, the fork goes where it is driven harder
            Mode::Moving(self.left)
        } else {
            Mode::Moving(self.right)
        }
    }

    /// θ̈ [rad/s²] of a fork that turns left, and of one that turns right.
    fn accelerations<T: Real>(self, b: &Bicycle<T>, x: &State<T>, u: &Input<T>) -> [T; 2] {
        [self.left, self.right].map(|side| side.derivative(b, x, u).steer_rate)
    }
}

/// The share of the left side in the mean of both at which the fork stays at rest, from θ̈ on either
/// side.
fn share<T: Real>([left, right]: [T; 2]) -> T {
    // The last summand matters only where all else is zero: 0/0 becomes 0.
    right / (right - left + T::from(f64::MIN_POSITIVE))
}

/// The mean of both sides; to the last bit what they have in common.
fn mean<T: Real>(share: T, left: T, right: T) -> T {
    right + share * (left - right)
}

/// How a bicycle goes on between two events. It keeps the signs of its side, so that its equations
/// are smooth, beyond the jump as well.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum Mode {
    /// On one side of every jump.
    Moving(Side),
    /// θ̇ = 0: either side drives the fork back to rest. What the jumps contribute is the mean of
    /// both sides at which θ̈ = 0.
    Held(Sides),
}

impl Mode {
    /// That of a state.
    pub fn at(b: &Bicycle, x: &State, u: &Input) -> Self {
        Sides::at(b, x).mode(b, x, u)
    }

    /// How often [`Self::derivative`] evaluates the equations.
    pub fn evaluations(self) -> u64 {
        match self {
            Self::Moving(_) => 1,
            Self::Held(_) => 2,
        }
    }

    /// Time derivative of the state.
    pub fn derivative(self, b: &Bicycle, x: &State, u: &Input) -> State {
        match self {
            Self::Moving(side) => side.derivative(b, x, u),
            Self::Held(Sides { left, right }) => {
                let [left, right] = [left, right].map(|side| side.derivative(b, x, u));
                // a stage may lie beyond the end of the hold, where neither side is meant
                let share = share([left.steer_rate, right.steer_rate]).clamp(0.0, 1.0);
                State {
                    steer_rate: 0.0,
                    ..left.zip(&right, |left, right| mean(share, left, right))
                }
            }
        }
    }

    /// How far the end of this mode is: positive as long as it lasts, negative beyond. In units of
    /// its own, but continuous along a motion.
    pub fn margin(self, b: &Bicycle, x: &State, u: &Input) -> f64 {
        match self {
            Self::Moving(Side { steer, steer_rate }) => {
                let beyond = |sign: Option<f64>, value| sign.map_or(f64::INFINITY, |s| s * value);
                beyond(steer, x.steer).min(beyond(steer_rate, x.steer_rate))
            }
            Self::Held(sides) => {
                let [left, right] = sides.accelerations(b, x, u);
                right.min(-left)
            }
        }
    }

    /// How often [`Self::margin`] evaluates the equations.
    pub fn margin_evaluations(self) -> u64 {
        match self {
            Self::Moving(_) => 0,
            Self::Held(_) => 2,
        }
    }

    /// The state at the end of this mode: on the jump, not a rounding beyond it.
    pub fn landed(self, x: &State) -> State {
        let on = |sign: Option<f64>, value: f64| match sign {
            Some(sign) if sign * value < 0.0 => 0.0,
            _ => value,
        };
        match self {
            Self::Moving(Side { steer, steer_rate }) => State {
                steer: on(steer, x.steer),
                steer_rate: on(steer_rate, x.steer_rate),
                ..*x
            },
            Self::Held(_) => *x,
        }
    }

    /// What stands for the nonlinear terms, over any scalar. A sign that jumps is constant on its
    /// side; the mean of a held fork moves with the state.
    fn nonlinear<T: Real>(self, b: &Bicycle<T>, x: &State<T>, u: &Input<T>) -> Nonlinear<T> {
        match self {
            Self::Moving(side) => side.nonlinear(b, x, u.speed),
            Self::Held(sides) => {
                let share = share(sides.accelerations(b, x, u));
                let left = sides.left.nonlinear(b, x, u.speed);
                let right = sides.right.nonlinear(b, x, u.speed);
                Nonlinear {
                    steer_sign: mean(share, left.steer_sign, right.steer_sign),
                    steer_rate_sign: mean(share, left.steer_rate_sign, right.steer_rate_sign),
                    ..left
                }
            }
        }
    }

    /// Everything that can be seen of a bicycle in this mode, over any scalar.
    pub fn output<T: Real>(
        self,
        b: &Bicycle<T>,
        x: &State<T>,
        path: &Path<T>,
        u: &Input<T>,
    ) -> Output<T> {
        let mut seen = output_with(b, x, path, u, &self.nonlinear(b, x, u));
        // the side to which a straight fork is on its way is no matter of where it is seen
        let trail_jumps = b.four_bodies.is_none() && b.p.steer_smoothing.is_zero();
        if trail_jumps && x.steer.is_zero() {
            seen.effective_trail = b.p.trail * x.roll.cos();
        }
        match self {
            Self::Moving(_) => seen,
            Self::Held(_) => Output {
                steer_acceleration: T::from(0.0),
                ..seen
            },
        }
    }
}

/// Everything that can be seen at a state, the jumps as a simulation takes them: [`crate::dynamics::output`]
/// where none is near, with the signs of the side to which the fork is on its way where θ = 0 or
/// θ̇ = 0, and a steer acceleration of 0 where friction holds it.
pub fn output(b: &Bicycle, x: &State, path: &Path, u: &Input) -> Output {
    Mode::at(b, x, u).output(b, x, path, u)
}
