//! Vectors of numbers, one manoeuvre per lane, and the kernel compiled for each of them.
//!
//! The vector instructions are enabled in the entry points below and nowhere else, and an entry point is reached only
//! after the machine was asked: that is why `unsafe` is allowed here.
#![allow(unsafe_code)]

use std::ops::{Add, Div, Mul, Neg, Sub};

use super::kernel::{Estimate, Tuning};
use super::real::Real;
use super::run::{run_block, smooth_block};
use super::smoother::Kept;
#[cfg(target_arch = "x86_64")]
pub use x86::{Eight, Four};

/// A vector with the kernel compiled for its instructions.
pub trait Lanes: Real {
    /// [`run_block`] with the instructions of this vector. Only on a machine that [`widest`] found to have them.
    fn run(estimate: &mut Estimate<Self>, tuning: &Tuning<Self>, steps: usize, drive: &[f64], record: &mut [f64]);

    /// [`smooth_block`], likewise.
    fn smooth(
        start: &Estimate<Self>,
        smoothed: &mut Estimate<Self>,
        tuning: &Tuning<Self>,
        steps: usize,
        drive: &[f64],
        kept: &mut Vec<Kept<Self>>,
        record: &mut [f64],
    );
}

/// Sets of vector instructions, in order of width.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Width {
    /// Two lanes, on any machine.
    Two,
    /// AVX2 and FMA.
    Four,
    /// AVX-512.
    Eight,
}

impl Width {
    /// Number of lanes.
    pub fn lanes(self) -> usize {
        match self {
            Self::Two => 2,
            Self::Four => 4,
            Self::Eight => 8,
        }
    }
}

/// The widest this machine has.
pub fn widest() -> Width {
    #[cfg(target_arch = "x86_64")]
    {
        if is_x86_feature_detected!("avx512f") && is_x86_feature_detected!("fma") {
            return Width::Eight;
        }
        if is_x86_feature_detected!("avx2") && is_x86_feature_detected!("fma") {
            return Width::Four;
        }
    }
    Width::Two
}

/// Widest vector of any machine.
pub const MOST_LANES: usize = 8;

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

impl Lanes for Two {
    fn run(estimate: &mut Estimate<Self>, tuning: &Tuning<Self>, steps: usize, drive: &[f64], record: &mut [f64]) {
        run_block(estimate, tuning, steps, drive, record);
    }

    fn smooth(
        start: &Estimate<Self>,
        smoothed: &mut Estimate<Self>,
        tuning: &Tuning<Self>,
        steps: usize,
        drive: &[f64],
        kept: &mut Vec<Kept<Self>>,
        record: &mut [f64],
    ) {
        smooth_block(start, smoothed, tuning, steps, drive, kept, record);
    }
}

operators!(Two, Add::add, Sub::sub, Mul::mul, Div::div);

impl Real for Two {
    const LANES: usize = 2;

    #[inline(always)]
    fn splat(value: f64) -> Self {
        Self(wide::f64x2::splat(value))
    }

    #[inline(always)]
    fn load(values: &[f64]) -> Self {
        Self(wide::f64x2::from([values[0], values[1]]))
    }

    #[inline(always)]
    fn store(self, into: &mut [f64]) {
        into[..2].copy_from_slice(self.0.as_array());
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
            // touched after its length was checked.
            impl Real for $vector {
                const LANES: usize = $lanes;

                #[inline(always)]
                fn splat(value: f64) -> Self {
                    Self(unsafe { $splat(value) })
                }

                #[inline(always)]
                fn load(values: &[f64]) -> Self {
                    let values = &values[..$lanes];
                    Self(unsafe { $load(values.as_ptr()) })
                }

                #[inline(always)]
                fn store(self, into: &mut [f64]) {
                    let into = &mut into[..$lanes];
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
        Four,
        4,
        _mm256_set1_pd,
        _mm256_loadu_pd,
        _mm256_storeu_pd,
        _mm256_fmadd_pd,
        _mm256_fnmadd_pd,
        _mm256_sqrt_pd,
        _mm256_cmp_pd::<_CMP_GT_OQ>,
        _mm256_blendv_pd,
        _mm256_movemask_pd
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

    macro_rules! compiled {
        ($vector:ident, $features:literal) => {
            impl Lanes for $vector {
                fn run(
                    estimate: &mut Estimate<Self>,
                    tuning: &Tuning<Self>,
                    steps: usize,
                    drive: &[f64],
                    record: &mut [f64],
                ) {
                    #[target_feature(enable = $features)]
                    fn compiled(
                        estimate: &mut Estimate<$vector>,
                        tuning: &Tuning<$vector>,
                        steps: usize,
                        drive: &[f64],
                        record: &mut [f64],
                    ) {
                        run_block(estimate, tuning, steps, drive, record);
                    }
                    // SAFETY: `widest` has found the features.
                    unsafe { compiled(estimate, tuning, steps, drive, record) }
                }

                fn smooth(
                    start: &Estimate<Self>,
                    smoothed: &mut Estimate<Self>,
                    tuning: &Tuning<Self>,
                    steps: usize,
                    drive: &[f64],
                    kept: &mut Vec<Kept<Self>>,
                    record: &mut [f64],
                ) {
                    #[target_feature(enable = $features)]
                    fn compiled(
                        start: &Estimate<$vector>,
                        smoothed: &mut Estimate<$vector>,
                        tuning: &Tuning<$vector>,
                        steps: usize,
                        drive: &[f64],
                        kept: &mut Vec<Kept<$vector>>,
                        record: &mut [f64],
                    ) {
                        smooth_block(start, smoothed, tuning, steps, drive, kept, record);
                    }
                    // SAFETY: `widest` has found the features.
                    unsafe { compiled(start, smoothed, tuning, steps, drive, kept, record) }
                }
            }
        };
    }

    compiled!(Four, "avx2,fma");
    compiled!(Eight, "avx512f,fma");
}
