//! Several numbers advanced together: [`Lanes`], and [`Pack`] for code that runs on lanes and on
//! plain numbers alike.
//!
//! [`Lanes`] are arrays, of any width and for any machine. Vector registers are another [`Pack`], made
//! elsewhere: choosing instructions at run time is unsafe. Either becomes vector instructions only
//! where the whole of a calculation is inlined into a function for which these are switched on; so
//! what is called for every step is marked `inline(always)`.
//!
//! Multiply-adds are fused, and sine, cosine and arctangent are polynomials of their own, so lanes
//! agree with plain numbers to rounding, not to the last bit.

use crate::real::Real;
use std::ops::{Add, Div, Mul, Neg, Sub};

/// N numbers, each of another ride.
#[derive(Debug, Clone, Copy, PartialEq)]
#[repr(align(64))]
pub struct Lanes<const N: usize>(pub [f64; N]);

/// An array of which entry `i` is the expression. A plain loop: closures in a function that names
/// the instruction set are not always inlined.
macro_rules! each {
    ($i:ident => $value:expr) => {{
        let mut all = [0.0; N];
        for ($i, entry) in all.iter_mut().enumerate() {
            *entry = $value;
        }
        Self(all)
    }};
}

/// A number or several: what code written once for lanes and plain numbers needs besides
/// arithmetic.
pub trait Pack: Real + Send + Sync + 'static {
    /// How many numbers.
    const WIDTH: usize;

    /// Number `i` is `f(i)`.
    fn from_fn(f: impl FnMut(usize) -> f64) -> Self;

    /// Number `i`.
    fn lane(&self, i: usize) -> f64;

    /// Where a number's magnitude is below `limit`, that of `below`, else that of `otherwise`; of a
    /// number that is none, `otherwise`.
    #[must_use]
    fn pick_small(self, limit: f64, below: Self, otherwise: Self) -> Self;

    /// Whether every magnitude is below `limit`; false where a number is none.
    fn all_small(self, limit: f64) -> bool;

    /// 1/√x within 3.5 %, of positive numbers: where an iteration for it starts.
    #[must_use]
    fn rough_reciprocal_root(self) -> Self;

    /// Sine and cosine where every magnitude is below π/4.
    fn sin_cos_small(self) -> (Self, Self);

    /// Arctangent where every magnitude is below 7/16.
    #[must_use]
    fn atan_small(self) -> Self;
}

/// Less half a number's bits these are the bits of its reciprocal root, within 3.5 %: the exponent
/// halved and negated, the mantissa along a straight line (Lomont 2003).
pub const ROUGH: i64 = 0x5FE6_EB50_C7B5_37A9;

#[inline(always)]
fn rough_reciprocal_root(x: f64) -> f64 {
    f64::from_bits(ROUGH.cast_unsigned().wrapping_sub(x.to_bits() >> 1))
}

impl Pack for f64 {
    const WIDTH: usize = 1;

    fn from_fn(mut f: impl FnMut(usize) -> f64) -> Self {
        f(0)
    }
    fn lane(&self, _: usize) -> f64 {
        *self
    }
    fn pick_small(self, limit: f64, below: Self, otherwise: Self) -> Self {
        if self.abs() < limit { below } else { otherwise }
    }
    fn all_small(self, limit: f64) -> bool {
        self.abs() < limit
    }
    fn rough_reciprocal_root(self) -> Self {
        rough_reciprocal_root(self)
    }
    fn sin_cos_small(self) -> (Self, Self) {
        self.sin_cos()
    }
    fn atan_small(self) -> Self {
        self.atan()
    }
}

impl<const N: usize> Pack for Lanes<N> {
    const WIDTH: usize = N;

    #[inline(always)]
    fn from_fn(mut f: impl FnMut(usize) -> f64) -> Self {
        each!(i => f(i))
    }
    #[inline(always)]
    fn lane(&self, i: usize) -> f64 {
        self.0[i]
    }
    #[inline(always)]
    fn pick_small(self, limit: f64, below: Self, otherwise: Self) -> Self {
        each!(i => if self.0[i].abs() < limit { below.0[i] } else { otherwise.0[i] })
    }
    #[inline(always)]
    fn all_small(self, limit: f64) -> bool {
        // no early end: a comparison of all at once
        let mut all = true;
        for x in &self.0 {
            all &= x.abs() < limit;
        }
        all
    }
    #[inline(always)]
    fn rough_reciprocal_root(self) -> Self {
        each!(i => rough_reciprocal_root(self.0[i]))
    }
    #[inline(always)]
    fn sin_cos_small(self) -> (Self, Self) {
        sin_cos_small(self)
    }
    #[inline(always)]
    fn atan_small(self) -> Self {
        atan_small(self)
    }
}

impl<const N: usize> From<f64> for Lanes<N> {
    #[inline(always)]
    fn from(value: f64) -> Self {
        Self([value; N])
    }
}

impl<const N: usize> Neg for Lanes<N> {
    type Output = Self;
    #[inline(always)]
    fn neg(self) -> Self {
        each!(i => -self.0[i])
    }
}

macro_rules! operator {
    ($($Trait:ident $function:ident $operator:tt;)*) => {
        $(impl<const N: usize> $Trait for Lanes<N> {
            type Output = Self;
            #[inline(always)]
            fn $function(self, other: Self) -> Self {
                each!(i => self.0[i] $operator other.0[i])
            }
        })*
    };
}
operator! {
    Add add +;
    Sub sub -;
    Mul mul *;
    Div div /;
}

/// What the polynomials for sine, cosine and arctangent need to know of a number's bits.
pub trait Bits: Pack {
    /// Magnitude.
    #[must_use]
    fn size(self) -> Self;

    /// The same magnitude with the sign of `other`.
    #[must_use]
    fn with_sign_of(self, other: Self) -> Self;

    /// Sine of an angle right angles on from one of sine `sin` and cosine `cos`: as many as the last
    /// two bits of `self` and `by` add up to. Bit 0 swaps the two, bit 1 negates.
    #[must_use]
    fn turned(self, by: i64, sin: Self, cos: Self) -> Self;
}

/// 1.5 · 2⁵²: added to a number below 2⁵¹, it leaves the nearest integer in the last bits.
const ROUNDING: f64 = 6755399441055744.0;
/// π/2 less its nearest double.
const FRAC_PI_2_REST: f64 = 6.123233995736766e-17;

/// Sine and cosine on ± π/4, coefficients of z = x², highest first (Cephes, Moshier 1984–2000,
/// `sin.c`): sin x = x + x z S(z), cos x = 1 − z/2 + z² C(z).
#[expect(clippy::excessive_precision, reason = "as their source prints them")]
const SINE: [f64; 6] = [
    1.58962301576546568060e-10,
    -2.50507477628578072866e-8,
    2.75573136213857245213e-6,
    -1.98412698295895385996e-4,
    8.33333333332211858878e-3,
    -1.66666666666666307295e-1,
];
#[expect(clippy::excessive_precision, reason = "as their source prints them")]
const COSINE: [f64; 6] = [
    -1.13585365213876817300e-11,
    2.08757008419747316778e-9,
    -2.75573141792967388112e-7,
    2.48015872888517045348e-5,
    -1.38888888888730564116e-3,
    4.16666666666665929218e-2,
];
/// Arctangent on ± 7/16, coefficients of z = x², highest first (fdlibm, Sun 1993, `s_atan.c`):
/// atan x = x − x z A(z).
#[expect(clippy::excessive_precision, reason = "as their source prints them")]
const ARCTANGENT: [f64; 11] = [
    1.62858201153657823623e-02,
    -3.65315727442169155270e-02,
    4.97687799461593236017e-02,
    -5.83357013379057348645e-02,
    6.66107313738753120669e-02,
    -7.69187620504482999495e-02,
    9.09088713343650656196e-02,
    -1.11111104054623557880e-01,
    1.42857142725034663711e-01,
    -1.99999999998764832476e-01,
    3.33333333333329318027e-01,
];
/// tan(π/8) and tan(3π/8): beyond the first, atan x = π/4 + atan((x−1)/(x+1)), beyond the second
/// π/2 − atan(1/x).
const TAN_PI_8: f64 = 0.41421356237309503;
const TAN_3_PI_8: f64 = 2.414213562373095;

#[inline(always)]
fn polynomial<T: Pack>(coefficients: &[f64], z: T) -> T {
    let mut sum = T::from(coefficients[0]);
    for &c in &coefficients[1..] {
        sum = sum.mul_add(z, T::from(c));
    }
    sum
}

/// Sine and cosine where |x| ≤ π/4.
#[inline(always)]
pub fn sin_cos_small<T: Pack>(x: T) -> (T, T) {
    let z = x * x;
    let sin = (polynomial(&SINE, z) * z).mul_add(x, x);
    let half = z.mul_add(T::from(-0.5), T::from(1.0));
    let cos = (polynomial(&COSINE, z) * z).mul_add(z, half);
    (sin, cos)
}

/// Arctangent where |x| ≤ 7/16.
#[inline(always)]
pub fn atan_small<T: Pack>(x: T) -> T {
    let z = x * x;
    (polynomial(&ARCTANGENT, z) * z).mul_add(-x, x)
}

/// Sine and cosine, within 1.5 ulp where |x| ≤ 10⁶; next to a zero, where less than 1e-13 is left of
/// x, within 1e-32 · |x|.
#[inline(always)]
pub fn sin_cos<T: Bits>(x: T) -> (T, T) {
    // Cody & Waite: x less the nearest multiple of π/2, here in two fused parts
    let shifted = x.mul_add(T::from(std::f64::consts::FRAC_2_PI), T::from(ROUNDING));
    let turns = shifted - T::from(ROUNDING);
    let near = turns.mul_add(T::from(-std::f64::consts::FRAC_PI_2), x);
    let rest = turns.mul_add(T::from(-FRAC_PI_2_REST), near);
    let (sin, cos) = sin_cos_small(rest);
    (shifted.turned(0, sin, cos), shifted.turned(1, sin, cos))
}

/// The one of three that goes with the range of `size`.
#[inline(always)]
fn of_three<T: Pack>(size: T, low: T, middle: T, high: T) -> T {
    let beyond = size.pick_small(TAN_3_PI_8, middle, high);
    size.pick_small(TAN_PI_8, low, beyond)
}

/// Arctangent, within 1.5 ulp.
#[inline(always)]
pub fn atan<T: Bits>(x: T) -> T {
    let (size, one) = (x.size(), T::from(1.0));
    // a quotient for each of three ranges: x, (x−1)/(x+1), −1/x
    let above = of_three(size, size, size - one, -one);
    let below = of_three(size, one, size + one, size);
    let eighths = of_three(size, T::from(0.0), one, T::from(2.0));
    let rest = eighths * T::from(0.5 * FRAC_PI_2_REST);
    let near = atan_small(above / below) + rest;
    let angle = eighths.mul_add(T::from(std::f64::consts::FRAC_PI_4), near);
    angle.with_sign_of(x)
}

impl<const N: usize> Bits for Lanes<N> {
    #[inline(always)]
    fn size(self) -> Self {
        each!(i => self.0[i].abs())
    }
    #[inline(always)]
    fn with_sign_of(self, other: Self) -> Self {
        each!(i => self.0[i].copysign(other.0[i]))
    }
    #[inline(always)]
    fn turned(self, by: i64, sin: Self, cos: Self) -> Self {
        each!(i => {
            let quadrant = self.0[i].to_bits().wrapping_add_signed(by);
            let value = if quadrant & 1 == 0 { sin.0[i] } else { cos.0[i] };
            // bit 1, moved to where the sign is
            f64::from_bits(value.to_bits() ^ ((quadrant & 2) << 62))
        })
    }
}

impl<const N: usize> Real for Lanes<N> {
    /// Whether all are zero: what is decided by it is decided for all lanes alike.
    #[inline(always)]
    fn is_zero(&self) -> bool {
        self.0.iter().all(|x| *x == 0.0)
    }
    #[inline(always)]
    fn sin_cos(self) -> (Self, Self) {
        sin_cos(self)
    }
    #[inline(always)]
    fn atan(self) -> Self {
        atan(self)
    }
    #[inline(always)]
    fn sqrt(self) -> Self {
        each!(i => self.0[i].sqrt())
    }
    #[inline(always)]
    fn mul_add(self, factor: Self, summand: Self) -> Self {
        each!(i => self.0[i].mul_add(factor.0[i], summand.0[i]))
    }
}

#[cfg(test)]
mod tests;
