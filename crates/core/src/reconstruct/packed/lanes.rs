//! Vectors of numbers, one manoeuvre per lane.
//!
//! The vector instructions are enabled in the entry points of `dispatch` and nowhere else, and an entry point is reached only after
//! the machine was asked: that is why `unsafe` is allowed here.
#![allow(unsafe_code)]

use std::ops::{Add, Div, Mul, Neg, Sub};

#[cfg(target_arch = "x86_64")]
pub use x86::{Eight, Four};

use crate::reconstruct::numeric::real::Real;

/// Two lanes that every 64-bit machine has.
#[derive(Clone, Copy)]
pub struct Two(wide::f64x2);

macro_rules! operators {
    ($vector:ident, $add:expr, $sub:expr, $mul:expr, $div:expr) => {
        operators!($vector, Add, add, $add);
        operators!($vector, Sub, sub, $sub);
        operators!($vector, Mul, mul, $mul);
        operators!($vector, Div, div, $div);

        impl Neg for $vector {
            type Output = Self;

            #[inline(always)]
            fn neg(self) -> Self {
                Self::splat(0.0) - self
            }
        }
    };
    ($vector:ident, $operator:ident, $name:ident, $operate:expr) => {
        impl $operator for $vector {
            type Output = Self;

            #[inline(always)]
            fn $name(self, other: Self) -> Self {
                // SAFETY: plain arithmetic; reached only in code compiled for the instructions.
                #[allow(unused_unsafe)]
                Self(unsafe { $operate(self.0, other.0) })
            }
        }
    };
}

operators!(Two, Add::add, Sub::sub, Mul::mul, Div::div);

impl Real for Two {
    type Lanes = [f64; 2];

    #[inline(always)]
    fn splat(value: f64) -> Self {
        Self(wide::f64x2::splat(value))
    }

    #[inline(always)]
    fn load(values: &[f64; 2]) -> Self {
        Self(wide::f64x2::from(*values))
    }

    #[inline(always)]
    fn store(self, into: &mut [f64; 2]) {
        *into = *self.0.as_array();
    }

    #[inline(always)]
    fn mul_add(self, factor: Self, term: Self) -> Self {
        Self(self.0.mul_add(factor.0, term.0))
    }

    #[inline(always)]
    fn neg_mul_add(self, factor: Self, term: Self) -> Self {
        Self(self.0.mul_neg_add(factor.0, term.0))
    }

    #[inline(always)]
    fn sqrt(self) -> Self {
        Self(self.0.sqrt())
    }

    #[inline(always)]
    fn select_above(self, limit: Self, above: Self, other: Self) -> Self {
        Self(self.0.simd_gt(limit.0).select(above.0, other.0))
    }

    #[inline(always)]
    fn any_above(self, limit: Self) -> bool {
        self.0.simd_gt(limit.0).any()
    }
}

#[cfg(target_arch = "x86_64")]
mod x86 {
    use std::arch::x86_64::*;

    use super::*;

    /// Four lanes of AVX2 with fused multiplication and addition.
    #[derive(Clone, Copy)]
    pub struct Four(__m256d);

    /// Eight lanes of AVX-512.
    #[derive(Clone, Copy)]
    pub struct Eight(__m512d);

    operators!(Four, _mm256_add_pd, _mm256_sub_pd, _mm256_mul_pd, _mm256_div_pd);
    operators!(Eight, _mm512_add_pd, _mm512_sub_pd, _mm512_mul_pd, _mm512_div_pd);

    macro_rules! real {
        ($vector:ident, $lanes:literal, $splat:ident, $load:ident, $store:ident, $fma:ident, $fnma:ident, $sqrt:ident,
         $above:expr, $select:expr, $any:expr) => {
            // SAFETY of all: arithmetic on registers, reached only in code compiled for the instructions; memory is
            // an array of as many lanes.
            impl Real for $vector {
                type Lanes = [f64; $lanes];

                #[inline(always)]
                fn splat(value: f64) -> Self {
                    Self(unsafe { $splat(value) })
                }

                #[inline(always)]
                fn load(values: &[f64; $lanes]) -> Self {
                    Self(unsafe { $load(values.as_ptr()) })
                }

                #[inline(always)]
                fn store(self, into: &mut [f64; $lanes]) {
                    unsafe { $store(into.as_mut_ptr(), self.0) }
                }

                #[inline(always)]
                fn mul_add(self, factor: Self, term: Self) -> Self {
                    Self(unsafe { $fma(self.0, factor.0, term.0) })
                }

                #[inline(always)]
                fn neg_mul_add(self, factor: Self, term: Self) -> Self {
                    Self(unsafe { $fnma(self.0, factor.0, term.0) })
                }

                #[inline(always)]
                fn sqrt(self) -> Self {
                    Self(unsafe { $sqrt(self.0) })
                }

                #[inline(always)]
                fn select_above(self, limit: Self, above: Self, other: Self) -> Self {
                    Self(unsafe { $select(other.0, above.0, $above(self.0, limit.0)) })
                }

                #[inline(always)]
                fn any_above(self, limit: Self) -> bool {
                    unsafe { $any($above(self.0, limit.0)) != 0 }
                }
            }
        };
    }

    real!(
        Four, 4, _mm256_set1_pd, _mm256_loadu_pd, _mm256_storeu_pd, _mm256_fmadd_pd, _mm256_fnmadd_pd, _mm256_sqrt_pd,
        _mm256_cmp_pd::<_CMP_GT_OQ>, _mm256_blendv_pd, _mm256_movemask_pd
    );
    real!(
        Eight,
        8,
        _mm512_set1_pd,
        _mm512_loadu_pd,
        _mm512_storeu_pd,
        _mm512_fmadd_pd,
        _mm512_fnmadd_pd,
        _mm512_sqrt_pd,
        _mm512_cmp_pd_mask::<_CMP_GT_OQ>,
        select_eight,
        u8::from
    );

    #[inline(always)]
    unsafe fn select_eight(other: __m512d, above: __m512d, mask: __mmask8) -> __m512d {
        // SAFETY: arithmetic on registers, reached only in code compiled for AVX-512.
        unsafe { _mm512_mask_blend_pd(mask, other, above) }
    }
}
