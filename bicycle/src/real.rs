//! The scalar of the equations: plain numbers, dual numbers, lanes.

use num_dual::{Dual2SVec64, DualNum, DualSVec64};
use std::ops::{Add, Div, Mul, Neg, Sub};

/// What the equations ask of a scalar.
///
/// Plain numbers take sine, cosine and arctangent from the `libm` crate, not from the platform,
/// so that a trajectory is the same to the last bit wherever it is computed.
pub trait Real:
    Copy
    + From<f64>
    + Neg<Output = Self>
    + Add<Output = Self>
    + Sub<Output = Self>
    + Mul<Output = Self>
    + Div<Output = Self>
{
    /// Whether the number itself is zero, whatever is carried along with it.
    fn is_zero(&self) -> bool;
    /// Sine and cosine.
    fn sin_cos(self) -> (Self, Self);
    /// Arctangent.
    #[must_use]
    fn atan(self) -> Self;
    /// Square root.
    #[must_use]
    fn sqrt(self) -> Self;

    /// `self · factor + summand`: fused on lanes, rounded twice on plain numbers, which are to be
    /// the same on machines that cannot fuse.
    #[must_use]
    #[inline(always)]
    fn mul_add(self, factor: Self, summand: Self) -> Self {
        self * factor + summand
    }

    /// Sine.
    #[must_use]
    #[inline(always)]
    fn sin(self) -> Self {
        self.sin_cos().0
    }
    /// Cosine.
    #[must_use]
    #[inline(always)]
    fn cos(self) -> Self {
        self.sin_cos().1
    }
}

impl Real for f64 {
    fn is_zero(&self) -> bool {
        *self == 0.0
    }
    fn sin_cos(self) -> (Self, Self) {
        libm::sincos(self)
    }
    fn atan(self) -> Self {
        libm::atan(self)
    }
    fn sqrt(self) -> Self {
        f64::sqrt(self)
    }
}

macro_rules! dual {
    ($Dual:ident) => {
        impl<const N: usize> Real for $Dual<N> {
            fn is_zero(&self) -> bool {
                self.re == 0.0
            }
            fn sin_cos(self) -> (Self, Self) {
                DualNum::sin_cos(&self)
            }
            fn atan(self) -> Self {
                DualNum::atan(&self)
            }
            fn sqrt(self) -> Self {
                DualNum::sqrt(&self)
            }
        }
    };
}
dual!(DualSVec64);
dual!(Dual2SVec64);

/// The sign of `x`, smoothed over `width` (same unit): x/√(x² + width²), odd and smooth; with
/// width 0 the jump itself, 0 at 0.
#[inline(always)]
pub fn sign<T: Real>(x: T, width: T) -> T {
    // The last summand matters only where width and x are both zero: 0/0 becomes 0.
    x / (x * x + width * width + T::from(f64::MIN_POSITIVE)).sqrt()
}
