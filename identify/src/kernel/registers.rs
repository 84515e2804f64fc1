//! Vector registers as numbers of the equations: two in flight, so that one waits while the other is
//! worked on.
//!
//! Arrays serve as well ([`bicycle::lanes::Lanes`]), but a compiler takes minutes to find the vectors
//! in what they make of a whole method of integration. The types stay in this module's parent, which
//! makes them only after it has found the instructions: that is what makes the calls sound.

use bicycle::Real;
use bicycle::lanes::{self, Bits, Pack};
use std::arch::x86_64::{
    __m256d, __m512d, _mm256_add_pd, _mm256_div_pd, _mm256_fmadd_pd, _mm256_mul_pd, _mm256_set1_pd,
    _mm256_sqrt_pd, _mm256_sub_pd, _mm512_add_pd, _mm512_div_pd, _mm512_fmadd_pd, _mm512_mul_pd,
    _mm512_set1_pd, _mm512_sqrt_pd, _mm512_sub_pd,
};
use std::ops::{Add, Div, Mul, Neg, Sub};

/// An expression for each of the two registers.
macro_rules! both {
    ($i:ident => $value:expr) => {
        Self([
            {
                let $i = 0;
                // SAFETY: made only where the instructions are present, see the module
                unsafe { $value }
            },
            {
                let $i = 1;
                // SAFETY: as above
                unsafe { $value }
            },
        ])
    };
}

macro_rules! registers {
    (
        $(#[$what:meta])*
        $Name:ident, $Register:ty, $width:literal, $isa:ident,
        $set:ident $add:ident $sub:ident $mul:ident $div:ident $sqrt:ident $fma:ident
    ) => {
        $(#[$what])*
        #[derive(Debug, Clone, Copy)]
        pub struct $Name([$Register; 2]);

        impl $Name {
            #[inline(always)]
            fn array(self) -> [f64; $width] {
                // SAFETY: two registers are so many doubles, and all bits are doubles
                unsafe { std::mem::transmute(self.0) }
            }
        }

        impl From<f64> for $Name {
            #[inline(always)]
            fn from(value: f64) -> Self {
                both!(_i => $set(value))
            }
        }

        registers!(@operators $Name: Add add $add, Sub sub $sub, Mul mul $mul, Div div $div);

        impl Neg for $Name {
            type Output = Self;
            #[inline(always)]
            fn neg(self) -> Self {
                both!(i => $isa::xor(self.0[i], $set(-0.0)))
            }
        }

        impl Real for $Name {
            fn is_zero(&self) -> bool {
                self.array().iter().all(|x| *x == 0.0)
            }
            #[inline(always)]
            fn sin_cos(self) -> (Self, Self) {
                lanes::sin_cos(self)
            }
            #[inline(always)]
            fn atan(self) -> Self {
                lanes::atan(self)
            }
            #[inline(always)]
            fn sqrt(self) -> Self {
                both!(i => $sqrt(self.0[i]))
            }
            #[inline(always)]
            fn mul_add(self, factor: Self, summand: Self) -> Self {
                both!(i => $fma(self.0[i], factor.0[i], summand.0[i]))
            }
        }

        impl Pack for $Name {
            const WIDTH: usize = $width;

            #[inline(always)]
            fn from_fn(mut f: impl FnMut(usize) -> f64) -> Self {
                let mut all = [0.0; $width];
                for (i, x) in all.iter_mut().enumerate() {
                    *x = f(i);
                }
                // SAFETY: so many doubles are two registers
                Self(unsafe { std::mem::transmute::<[f64; $width], [$Register; 2]>(all) })
            }
            #[inline(always)]
            fn lane(&self, i: usize) -> f64 {
                self.array()[i]
            }
            #[inline(always)]
            fn pick_small(self, limit: f64, below: Self, otherwise: Self) -> Self {
                let size = self.size();
                both!(i => $isa::pick(size.0[i], $set(limit), below.0[i], otherwise.0[i]))
            }
            #[inline(always)]
            fn all_small(self, limit: f64) -> bool {
                let [low, high] = self.size().0;
                // SAFETY: as above
                unsafe { $isa::all_below(low, $set(limit)) & $isa::all_below(high, $set(limit)) }
            }
            #[inline(always)]
            fn rough_reciprocal_root(self) -> Self {
                both!(i => $isa::rough_reciprocal_root(self.0[i]))
            }
            #[inline(always)]
            fn sin_cos_small(self) -> (Self, Self) {
                lanes::sin_cos_small(self)
            }
            #[inline(always)]
            fn atan_small(self) -> Self {
                lanes::atan_small(self)
            }
        }

        impl Bits for $Name {
            #[inline(always)]
            fn size(self) -> Self {
                both!(i => $isa::without($set(-0.0), self.0[i]))
            }
            #[inline(always)]
            fn with_sign_of(self, other: Self) -> Self {
                let size = self.size();
                both!(i => $isa::xor(size.0[i], $isa::and($set(-0.0), other.0[i])))
            }
            #[inline(always)]
            fn turned(self, by: i64, sin: Self, cos: Self) -> Self {
                both!(i => $isa::turned(self.0[i], by, sin.0[i], cos.0[i]))
            }
        }
    };
    (@operators $Name:ident: $($Trait:ident $function:ident $intrinsic:ident),*) => {
        $(impl $Trait for $Name {
            type Output = Self;
            #[inline(always)]
            fn $function(self, other: Self) -> Self {
                both!(i => $intrinsic(self.0[i], other.0[i]))
            }
        })*
    };
}

registers! {
    /// Two registers of AVX-512.
    Avx512, __m512d, 16, wide,
    _mm512_set1_pd _mm512_add_pd _mm512_sub_pd _mm512_mul_pd _mm512_div_pd _mm512_sqrt_pd
    _mm512_fmadd_pd
}
registers! {
    /// Two registers of AVX2.
    Avx2, __m256d, 8, narrow,
    _mm256_set1_pd _mm256_add_pd _mm256_sub_pd _mm256_mul_pd _mm256_div_pd _mm256_sqrt_pd
    _mm256_fmadd_pd
}

/// What the two instruction sets have different names for.
macro_rules! primitives {
    (
        $isa:ident, $features:literal, $Register:ty,
        $xor:ident $andnot:ident $and:ident $to_bits:ident $from_bits:ident
        $set_bits:ident $add_bits:ident $and_bits:ident $left:ident;
        $($rest:item)*
    ) => {
        mod $isa {
            use std::arch::x86_64::*;

            #[inline]
            #[target_feature(enable = $features)]
            pub fn xor(a: $Register, b: $Register) -> $Register {
                $xor(a, b)
            }

            /// `x` without the bits of `bits`.
            #[inline]
            #[target_feature(enable = $features)]
            pub fn without(bits: $Register, x: $Register) -> $Register {
                $andnot(bits, x)
            }

            #[inline]
            #[target_feature(enable = $features)]
            pub fn and(a: $Register, b: $Register) -> $Register {
                $and(a, b)
            }

            /// See [`bicycle::lanes::Bits::turned`].
            #[inline]
            #[target_feature(enable = $features)]
            pub fn turned(x: $Register, by: i64, sin: $Register, cos: $Register) -> $Register {
                let quadrant = $add_bits($to_bits(x), $set_bits(by));
                let value = pick_odd($left::<63>(quadrant), sin, cos);
                let sign = $left::<62>($and_bits(quadrant, $set_bits(2)));
                $xor(value, $from_bits(sign))
            }

            $($rest)*
        }
    };
}

primitives! {
    wide, "avx512f,avx512dq,avx2,fma", __m512d,
    _mm512_xor_pd _mm512_andnot_pd _mm512_and_pd _mm512_castpd_si512 _mm512_castsi512_pd
    _mm512_set1_epi64 _mm512_add_epi64 _mm512_and_si512 _mm512_slli_epi64;

    /// `below` where `size` is below `limit`.
    #[inline]
    #[target_feature(enable = "avx512f,avx512dq,avx2,fma")]
    pub fn pick(size: __m512d, limit: __m512d, below: __m512d, otherwise: __m512d) -> __m512d {
        _mm512_mask_blend_pd(_mm512_cmp_pd_mask::<_CMP_LT_OQ>(size, limit), otherwise, below)
    }

    /// `odd` where the highest bit is set.
    #[inline]
    #[target_feature(enable = "avx512f,avx512dq,avx2,fma")]
    fn pick_odd(bit: __m512i, even: __m512d, odd: __m512d) -> __m512d {
        _mm512_mask_blend_pd(_mm512_movepi64_mask(bit), even, odd)
    }

    #[inline]
    #[target_feature(enable = "avx512f,avx512dq,avx2,fma")]
    pub fn all_below(size: __m512d, limit: __m512d) -> bool {
        _mm512_cmp_pd_mask::<_CMP_LT_OQ>(size, limit) == 0xff
    }

    /// Within 2⁻¹⁴.
    #[inline]
    #[target_feature(enable = "avx512f,avx512dq,avx2,fma")]
    pub fn rough_reciprocal_root(x: __m512d) -> __m512d {
        _mm512_rsqrt14_pd(x)
    }
}

primitives! {
    narrow, "avx2,fma", __m256d,
    _mm256_xor_pd _mm256_andnot_pd _mm256_and_pd _mm256_castpd_si256 _mm256_castsi256_pd
    _mm256_set1_epi64x _mm256_add_epi64 _mm256_and_si256 _mm256_slli_epi64;

    /// `below` where `size` is below `limit`.
    #[inline]
    #[target_feature(enable = "avx2,fma")]
    pub fn pick(size: __m256d, limit: __m256d, below: __m256d, otherwise: __m256d) -> __m256d {
        _mm256_blendv_pd(otherwise, below, _mm256_cmp_pd::<_CMP_LT_OQ>(size, limit))
    }

    /// `odd` where the highest bit is set.
    #[inline]
    #[target_feature(enable = "avx2,fma")]
    fn pick_odd(bit: __m256i, even: __m256d, odd: __m256d) -> __m256d {
        _mm256_blendv_pd(even, odd, _mm256_castsi256_pd(bit))
    }

    #[inline]
    #[target_feature(enable = "avx2,fma")]
    pub fn all_below(size: __m256d, limit: __m256d) -> bool {
        _mm256_movemask_pd(_mm256_cmp_pd::<_CMP_LT_OQ>(size, limit)) == 0xf
    }

    /// Within 3.5 %, see [`bicycle::lanes::ROUGH`].
    #[inline]
    #[target_feature(enable = "avx2,fma")]
    pub fn rough_reciprocal_root(x: __m256d) -> __m256d {
        let half = _mm256_srli_epi64::<1>(_mm256_castpd_si256(x));
        let magic = _mm256_set1_epi64x(bicycle::lanes::ROUGH);
        _mm256_castsi256_pd(_mm256_sub_epi64(magic, half))
    }
}
