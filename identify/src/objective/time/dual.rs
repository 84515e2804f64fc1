//! Dual numbers over lanes: a value and its derivatives along D directions, for many windows at
//! once. (Those of num-dual ask more of their number than lanes have; they are the oracle here.)

use bicycle::Real;
use bicycle::lanes::Pack;
use std::ops::{Add, Div, Mul, Neg, Sub};

/// re + Σ eps_d ε_d with ε_d ε_e = 0.
#[derive(Debug, Clone, Copy)]
pub(super) struct Dual<T, const D: usize> {
    /// The value.
    pub re: T,
    /// Its derivatives.
    pub eps: [T; D],
}

impl<T: Pack, const D: usize> Dual<T, D> {
    /// A value that moves along no direction.
    #[inline(always)]
    pub fn constant(re: T) -> Self {
        Self {
            re,
            eps: [T::from(0.0); D],
        }
    }

    /// f(self), with f and f′ at the value given.
    #[inline(always)]
    fn chain(mut self, value: T, slope: T) -> Self {
        self.re = value;
        for eps in &mut self.eps {
            *eps = *eps * slope;
        }
        self
    }
}

impl<T: Pack, const D: usize> From<f64> for Dual<T, D> {
    #[inline(always)]
    fn from(value: f64) -> Self {
        Self::constant(T::from(value))
    }
}

impl<T: Pack, const D: usize> Neg for Dual<T, D> {
    type Output = Self;
    #[inline(always)]
    fn neg(self) -> Self {
        self.chain(-self.re, T::from(-1.0))
    }
}

impl<T: Pack, const D: usize> Add for Dual<T, D> {
    type Output = Self;
    #[inline(always)]
    fn add(mut self, other: Self) -> Self {
        self.re = self.re + other.re;
        for d in 0..D {
            self.eps[d] = self.eps[d] + other.eps[d];
        }
        self
    }
}

impl<T: Pack, const D: usize> Sub for Dual<T, D> {
    type Output = Self;
    #[inline(always)]
    fn sub(mut self, other: Self) -> Self {
        self.re = self.re - other.re;
        for d in 0..D {
            self.eps[d] = self.eps[d] - other.eps[d];
        }
        self
    }
}

impl<T: Pack, const D: usize> Mul for Dual<T, D> {
    type Output = Self;
    #[inline(always)]
    fn mul(mut self, other: Self) -> Self {
        for d in 0..D {
            self.eps[d] = self.eps[d].mul_add(other.re, self.re * other.eps[d]);
        }
        self.re = self.re * other.re;
        self
    }
}

impl<T: Pack, const D: usize> Div for Dual<T, D> {
    type Output = Self;
    #[inline(always)]
    fn div(mut self, other: Self) -> Self {
        let inverse = T::from(1.0) / other.re;
        self.re = self.re * inverse;
        for d in 0..D {
            self.eps[d] = other.eps[d].mul_add(-self.re, self.eps[d]) * inverse;
        }
        self
    }
}

impl<T: Pack, const D: usize> Real for Dual<T, D> {
    #[inline(always)]
    fn is_zero(&self) -> bool {
        self.re.is_zero()
    }
    #[inline(always)]
    fn sin_cos(self) -> (Self, Self) {
        let (sin, cos) = self.re.sin_cos();
        (self.chain(sin, cos), self.chain(cos, -sin))
    }
    #[inline(always)]
    fn atan(self) -> Self {
        let slope = T::from(1.0) / self.re.mul_add(self.re, T::from(1.0));
        self.chain(self.re.atan(), slope)
    }
    #[inline(always)]
    fn sqrt(self) -> Self {
        let root = self.re.sqrt();
        self.chain(root, T::from(0.5) / root)
    }
}
