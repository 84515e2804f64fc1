//! exp(A h) and its relatives, and the weights that a step makes of them.
#![expect(
    clippy::needless_range_loop,
    reason = "rows and columns are counted as in the formulae"
)]

use crate::lanes::Pack;

/// A square matrix, rows first.
pub(super) type Matrix<T, const D: usize> = [[T; D]; D];

/// Last power in the series for φ₃ where no entry is above 1/4: what is left out is below 1e-12 of
/// the sum in the worst of matrices, 1e-18 in ordinary ones.
const TERMS: usize = 12;

#[inline(always)]
fn product<T: Pack, const D: usize>(a: &Matrix<T, D>, b: &Matrix<T, D>) -> Matrix<T, D> {
    let mut c = *a;
    for i in 0..D {
        for j in 0..D {
            let mut sum = a[i][0] * b[0][j];
            for k in 1..D {
                sum = sum + a[i][k] * b[k][j];
            }
            c[i][j] = sum;
        }
    }
    c
}

/// φ₀ to φ₃ of A h, φ₀ the exponential, φₖ(z) = z φₖ₊₁(z) + 1/k!; for a step that can be doubled.
#[derive(Clone, Copy)]
pub(super) struct Powers<T, const D: usize> {
    /// Of the step.
    whole: [Matrix<T, D>; 4],
    /// Of half the step.
    half: [Matrix<T, D>; 4],
    /// The step [s].
    step: f64,
}

impl<T: Pack, const D: usize> Powers<T, D> {
    /// Of `a`, for a step of `step` [s]: the series for a step so short that it converges at once,
    /// doubled until it is long enough (Higham 2005).
    #[inline(always)]
    pub fn new(a: &Matrix<T, D>, step: f64) -> Self {
        let mut norm = 0.0_f64;
        for row in a {
            for value in row {
                for lane in 0..T::WIDTH {
                    norm = norm.max(value.lane(lane).abs() * step);
                }
            }
        }
        // a matrix that is not finite gives what is not finite, in whatever number of doublings
        let halvings = ((4.0 * norm).log2().ceil().clamp(1.0, 60.0)) as i32;
        let shortest = step * 0.5_f64.powi(halvings);
        let mut z = *a;
        for row in &mut z {
            for value in row {
                *value = *value * T::from(shortest);
            }
        }
        let nil = [[T::from(0.0); D]; D];
        let mut whole = [nil; 4];
        // φ₃ by its series, 1/(n + 3)! of zⁿ, the others from it: one product after the other
        let series = (0..=TERMS).rev().map(|n| (3, 3, n + 3));
        let recursion = (0..3).rev().map(|k| (k, k + 1, k));
        for (to, from, factorial) in series.chain(recursion) {
            whole[to] = product(&z, &whole[from]);
            let share = 1.0 / (1..=factorial).map(|n| n as f64).product::<f64>();
            for (i, row) in whole[to].iter_mut().enumerate() {
                row[i] = row[i] + T::from(share);
            }
        }
        let mut powers = Self {
            whole,
            half: whole,
            step: shortest,
        };
        for _ in 0..halvings {
            powers.double();
        }
        powers.step = step;
        powers
    }

    /// For twice the step: φₖ(2z) = 2⁻ᵏ (φ₀ φₖ + Σ φⱼ/(k−j)!).
    #[inline(always)]
    pub fn double(&mut self) {
        let mut doubled = self.whole;
        for (double, single) in doubled.iter_mut().zip(&self.whole) {
            *double = product(&self.whole[0], single);
        }
        for i in 0..D {
            for j in 0..D {
                let [_, p1, p2, p3] = &self.whole;
                let (p1, p2, p3) = (p1[i][j], p2[i][j], p3[i][j]);
                let [_, q1, q2, q3] = &mut doubled;
                q1[i][j] = (q1[i][j] + p1) * T::from(0.5);
                q2[i][j] = (q2[i][j] + p1 + p2) * T::from(0.25);
                q3[i][j] = (q3[i][j] + T::from(0.5) * p1 + p2 + p3) * T::from(0.125);
            }
        }
        self.half = self.whole;
        self.whole = doubled;
        self.step *= 2.0;
    }

    /// The weights of a step, the remainder having entries in the rows `rows` only and the steering
    /// torque acting along `torque`, ∂ẋ/∂τ.
    #[inline(always)]
    pub fn weights<const R: usize>(&self, rows: [usize; R], torque: &[T; D]) -> Weights<T, D, R> {
        let [p0, p1, p2, p3] = &self.whole;
        let [half, h1, h2, _] = &self.half;
        let nil = T::from(0.0);
        let h = T::from(self.step);
        let mut weights = Weights {
            free: *p0,
            first: [[nil; R]; D],
            second: [[nil; R]; D],
            bend: [[nil; R]; D],
            early: [nil; D],
            late: [nil; D],
            early_slope: [nil; D],
            late_slope: [nil; D],
            step: self.step,
        };
        for i in 0..D {
            for (r, &j) in rows.iter().enumerate() {
                weights.first[i][r] = h * p1[i][j];
                weights.second[i][r] = h * p2[i][j];
                weights.bend[i][r] = h * (T::from(0.5) * p2[i][j] + p3[i][j]);
            }
            for (j, &unit) in torque.iter().enumerate() {
                // mean and slope about the middle of a force on a half step
                let mean = T::from(0.5) * h * h1[i][j];
                let slope = T::from(0.5) * h * (h2[i][j] - T::from(0.5) * h1[i][j]);
                weights.late[i] = weights.late[i] + mean * unit;
                weights.late_slope[i] = weights.late_slope[i] + slope * unit;
            }
        }
        for i in 0..D {
            for j in 0..D {
                weights.early[i] = weights.early[i] + half[i][j] * weights.late[j];
                weights.early_slope[i] =
                    weights.early_slope[i] + half[i][j] * weights.late_slope[j];
            }
        }
        weights
    }
}

/// What a step multiplies by what.
#[derive(Clone, Copy)]
pub(super) struct Weights<T, const D: usize, const R: usize> {
    /// φ₀: the free motion.
    pub free: Matrix<T, D>,
    /// h φ₁: a remainder that stays.
    pub first: [[T; R]; D],
    /// h φ₂: one that changes evenly, by its change over the step.
    pub second: [[T; R]; D],
    /// h (φ₂/2 + φ₃): its second difference.
    pub bend: [[T; R]; D],
    /// The mean torque of the first half.
    pub early: [T; D],
    /// That of the second.
    pub late: [T; D],
    /// The torque's change over the first half.
    pub early_slope: [T; D],
    /// That over the second.
    pub late_slope: [T; D],
    /// h [s].
    pub step: f64,
}
