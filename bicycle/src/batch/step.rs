//! One step of the two-step method.
#![expect(
    clippy::needless_range_loop,
    reason = "rows and columns are counted as in the formulae"
)]

use super::exponential::Weights;
use crate::lanes::Pack;

/// What is left of the equations when the linear part and the jumps are taken away.
pub(super) trait Remainder<T, const D: usize, const R: usize> {
    /// The rows of the state in which something is left.
    const ROWS: [usize; R];
    /// d [N m], of `−d sign θ̇`.
    fn friction(&self) -> T;
    /// The squares of the smoothing widths of sign θ [rad²] and sign θ̇ [rad²/s²].
    fn widths(&self) -> [T; 2];
    /// The rest at a state.
    fn at(&self, x: &[T; D]) -> Rest<T, R>;
}

/// The rest at a state.
#[derive(Clone, Copy)]
pub(super) struct Rest<T, const R: usize> {
    /// Rows of the smooth remainder.
    pub smooth: [T; R],
    /// What multiplies sign θ in the steering torque [N m].
    pub sign_torque: T,
}

/// Row of a state.
const STEER_RATE: usize = 1;
const STEER: usize = 3;

/// 1/√x of a positive number, within 1e-11.
#[inline(always)]
pub(super) fn reciprocal_root<T: Pack>(x: T) -> T {
    let mut y = x.rough_reciprocal_root();
    for _ in 0..2 {
        // third order: 1/√(1−e) = 1 + e/2 + 3e²/8 + …, and 1 − e = x y²
        let e = (-(x * y)).mul_add(y, T::from(1.0));
        let slope = e.mul_add(T::from(0.375), T::from(0.5));
        y = (y * e).mul_add(slope, y);
    }
    y
}

/// √(x² + ε²) and x/√(x² + ε²).
#[inline(always)]
fn smoothed<T: Pack>(x: T, square: T) -> (T, T) {
    let size = x.mul_add(x, square);
    let reciprocal = reciprocal_root(size);
    (size * reciprocal, x * reciprocal)
}

/// A smoothed sign along a path through three points, straight between them: its mean over each
/// half, exactly, `(x₀ + x₁)/(R₀ + R₁)` with R = √(x² + ε²), and its value at each point.
#[inline(always)]
fn along<T: Pack>(x: [T; 3], square: T, start: (T, T)) -> ([T; 2], [T; 3]) {
    let (r0, s0) = start;
    let (rm, sm) = smoothed(x[1], square);
    let (r1, s1) = smoothed(x[2], square);
    let (early, late) = (r0 + rm, rm + r1);
    let both = T::from(1.0) / (early * late);
    (
        [
            (x[0] + x[1]) * (late * both),
            (x[1] + x[2]) * (early * both),
        ],
        [s0, sm, s1],
    )
}

/// A torque over the two halves of a step.
#[derive(Clone, Copy)]
struct Halves<T> {
    mean: [T; 2],
    change: [T; 2],
}

/// A ride under way.
#[derive(Clone, Copy)]
pub(super) struct Motion<T, const D: usize, const R: usize> {
    /// The state.
    pub x: [T; D],
    /// The rest here, one and two steps before.
    rests: [Rest<T, R>; 3],
    /// The torque of the jumps as the last step ended [N m].
    jumps: T,
}

impl<T: Pack, const D: usize, const R: usize> Motion<T, D, R> {
    /// At rest in its past: the first step is then one of first order, and has to be short.
    #[inline(always)]
    pub fn new<M: Remainder<T, D, R>>(m: &M, x: [T; D]) -> Self {
        let rest = m.at(&x);
        let [square, rate_square] = m.widths();
        let (_, steer) = smoothed(x[STEER], square);
        let (_, rate) = smoothed(x[STEER_RATE], rate_square);
        Self {
            x,
            rests: [rest; 3],
            jumps: rest.sign_torque * steer - m.friction() * rate,
        }
    }

    /// Starts the lanes that have `fallen` anew, upright; the others do not notice.
    #[inline(never)]
    pub fn raise<M: Remainder<T, D, R>>(&mut self, m: &M, fallen: &[bool]) {
        let pick = |new: T, old: T| {
            T::from_fn(|lane| {
                if fallen[lane] {
                    new.lane(lane)
                } else {
                    old.lane(lane)
                }
            })
        };
        self.x = self.x.map(|row| pick(T::from(0.0), row));
        let fresh = Self::new(m, self.x);
        for (own, new) in self.rests.iter_mut().zip(&fresh.rests) {
            for (own, new) in own.smooth.iter_mut().zip(new.smooth) {
                *own = pick(new, *own);
            }
            own.sign_torque = pick(new.sign_torque, own.sign_torque);
        }
        self.jumps = pick(fresh.jumps, self.jumps);
    }

    /// From here on each step is twice as long.
    #[inline(always)]
    pub fn lengthen(&mut self) {
        self.rests[1] = self.rests[2];
    }

    /// One step, the torque from outside going evenly from `torque[0]` to `torque[1]` [N m].
    #[inline(always)]
    pub fn step<M: Remainder<T, D, R>>(&mut self, m: &M, w: &Weights<T, D, R>, torque: [T; 2]) {
        let [now, before, _] = self.rests;
        let widths = m.widths();
        let leg = Leg {
            steer: self.x[STEER],
            steer_rate: self.x[STEER_RATE],
            starts: [
                smoothed(self.x[STEER], widths[0]),
                smoothed(self.x[STEER_RATE], widths[1]),
            ],
            widths,
            friction: m.friction(),
            sign_torque: now.sign_torque,
            step: w.step,
        };
        let quarter = (torque[1] - torque[0]) * T::from(0.25);
        let outside = Halves {
            mean: [torque[0] + quarter, torque[1] - quarter],
            change: [quarter + quarter; 2],
        };

        // predictor: the remainder goes on as it went, the jumps first stay as they were
        let mut base = self.x;
        for (sum, (free, (first, second))) in base
            .iter_mut()
            .zip(w.free.iter().zip(w.first.iter().zip(&w.second)))
        {
            *sum = free[0] * self.x[0];
            for j in 1..D {
                *sum = free[j].mul_add(self.x[j], *sum);
            }
            for r in 0..R {
                let change = now.smooth[r] - before.smooth[r];
                *sum = first[r].mul_add(now.smooth[r], *sum);
                *sum = second[r].mul_add(change, *sum);
            }
        }
        let held = Halves {
            mean: [self.jumps; 2],
            change: [T::from(0.0); 2],
        };
        let foreseen = now.sign_torque + (now.sign_torque - before.sign_torque);
        let ahead = w.pushed(&base, &outside, &held);
        let ahead = w.pushed(&base, &outside, &leg.jumps(&ahead, foreseen));
        // corrector
        let next = m.at(&ahead);
        for r in 0..R {
            let bend = next.smooth[r] - now.smooth[r] - (now.smooth[r] - before.smooth[r]);
            for i in 0..D {
                base[i] = w.bend[i][r].mul_add(bend, base[i]);
            }
        }
        let last = leg.jumps(&ahead, next.sign_torque);
        self.x = w.pushed(&base, &outside, &last);
        self.jumps = last.change[1].mul_add(T::from(0.5), last.mean[1]);
        self.rests = [next, now, before];
    }
}

impl<T: Pack, const D: usize, const R: usize> Weights<T, D, R> {
    /// Where the torques take a motion that would go to `x` without them.
    #[inline(always)]
    fn pushed(&self, x: &[T; D], outside: &Halves<T>, jumps: &Halves<T>) -> [T; D] {
        let mut pushed = *x;
        let mean = [
            jumps.mean[0] + outside.mean[0],
            jumps.mean[1] + outside.mean[1],
        ];
        let change = [
            jumps.change[0] + outside.change[0],
            jumps.change[1] + outside.change[1],
        ];
        for i in 0..D {
            let early = self.early[i].mul_add(mean[0], pushed[i]);
            let late = self.late[i].mul_add(mean[1], early);
            let early_slope = self.early_slope[i].mul_add(change[0], late);
            pushed[i] = self.late_slope[i].mul_add(change[1], early_slope);
        }
        pushed
    }
}

/// What a step knows of the jumps before it is made.
struct Leg<T> {
    steer: T,
    steer_rate: T,
    starts: [(T, T); 2],
    widths: [T; 2],
    friction: T,
    sign_torque: T,
    step: f64,
}

impl<T: Pack> Leg<T> {
    /// The jumps along the way to `x`, Hermite's in the middle, where sign θ is multiplied by
    /// `sign_torque`.
    #[inline(always)]
    fn jumps<const D: usize>(&self, x: &[T; D], sign_torque: T) -> Halves<T> {
        let half = T::from(0.5);
        let (steer, rate) = (x[STEER], x[STEER_RATE]);
        let middle = (self.steer + steer)
            .mul_add(half, (self.steer_rate - rate) * T::from(0.125 * self.step));
        let middle_rate = (steer - self.steer).mul_add(
            T::from(1.5 / self.step),
            (self.steer_rate + rate) * T::from(-0.25),
        );
        let steers = [self.steer, middle, steer];
        let rates = [self.steer_rate, middle_rate, rate];
        let (s, at) = along(steers, self.widths[0], self.starts[0]);
        let (rub, rubs) = along(rates, self.widths[1], self.starts[1]);
        let (b0, b1) = (self.sign_torque, sign_torque);
        let bm = (b0 + b1) * half;
        let turns = [b0 * at[0], bm * at[1], b1 * at[2]];
        let early = (b0 + bm) * half * s[0];
        let late = (bm + b1) * half * s[1];
        Halves {
            mean: [
                (-self.friction).mul_add(rub[0], early),
                (-self.friction).mul_add(rub[1], late),
            ],
            change: [
                (-self.friction).mul_add(rubs[1] - rubs[0], turns[1] - turns[0]),
                (-self.friction).mul_add(rubs[2] - rubs[1], turns[2] - turns[1]),
            ],
        }
    }
}
