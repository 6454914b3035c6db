//! Vectors of numbers, one manoeuvre per lane, and the kernel compiled for each of them.
//!
//! The vector instructions are enabled in the entry points below and nowhere else, and an entry point is reached only
//! after the machine was asked: that is why `unsafe` is allowed here.
#![allow(unsafe_code)]

use std::ops::{Add, Div, Mul, Neg, Sub};

use super::blocks::Vec3;
use super::covariance::{Covariance, GROUPS};
use super::kernel::{Estimate, Predicted, Step, Telling, Tuning, predict_state};
use super::kinematics::{Observation, Trig};
use super::march::{run_block, smooth_block};
use super::real::Real;
use super::smoother::{Kept, NoiseSpace, take_noise_out};
use super::transition::Transition;
#[cfg(target_arch = "x86_64")]
pub use x86::{Eight, Four};

/// A vector with the kernel compiled for its instructions, in parts that are each compiled once. Only on a machine that
/// [`widest`] found to have them.
pub trait Lanes: Real {
    /// [`run_block`].
    fn run(estimate: &mut Estimate<Self>, tuning: &Tuning<Self>, steps: usize, drive: &[f64], record: &mut [f64]);

    /// [`smooth_block`].
    fn smooth(
        start: &Estimate<Self>,
        smoothed: &mut Estimate<Self>,
        tuning: &Tuning<Self>,
        steps: usize,
        drive: &[f64],
        kept: &mut Vec<Kept<Self>>,
        record: &mut [f64],
    );

    /// [`predict_state`].
    fn predict_state(
        x: &mut [Vec3<Self>; GROUPS],
        step: &Step<Self>,
        tuning: &Tuning<Self>,
    ) -> (Transition<Self>, Trig<Self>);

    /// [`Covariance::propagate`].
    fn propagate(p: &mut Covariance<Self>, phi: &Transition<Self>, noise: &[Vec3<Self>; 2]);

    /// [`Estimate::update_linear`].
    fn update_linear(
        estimate: &mut Estimate<Self>,
        step: &Step<Self>,
        tuning: &Tuning<Self>,
        telling: &mut Telling<Self>,
    );

    /// [`Estimate::update_iterated`].
    fn update_iterated(
        estimate: &mut Estimate<Self>,
        model: &Observation<Self>,
        trig: &Trig<Self>,
        step: &Step<Self>,
        before: &Predicted<Self>,
        tuning: &Tuning<Self>,
        telling: &mut Telling<Self>,
    );

    /// [`take_noise_out`].
    fn take_noise_out(
        d: &mut [Vec3<Self>; GROUPS],
        big_d: &mut Covariance<Self>,
        space: &mut NoiseSpace<Self>,
        kept: &Kept<Self>,
        step: &Step<Self>,
        tuning: &Tuning<Self>,
    ) -> [Vec3<Self>; 2];

    /// [`Covariance::propagate_back`].
    fn propagate_back(p: &mut Covariance<Self>, inverse: &Transition<Self>);
}

/// A function that calls the part of the kernel of the given path, compiled for the given instructions.
macro_rules! part {
    ($($features:literal)?, $name:ident = $kernel:path, ($($argument:ident: $type:ty),*) $(-> $result:ty)?) => {
        fn $name($($argument: $type),*) $(-> $result)? {
            $(#[target_feature(enable = $features)])?
            #[inline(never)]
            fn compiled($($argument: $type),*) $(-> $result)? {
                $kernel($($argument),*)
            }
            // SAFETY: `widest` has found the features.
            #[allow(unused_unsafe)]
            unsafe {
                compiled($($argument),*)
            }
        }
    };
}

/// Compiles the kernel for the instructions of a vector.
macro_rules! compiled {
    ($vector:ident $(, $features:literal)?) => {
        impl Lanes for $vector {
            part!($($features)?, run = run_block, (
                estimate: &mut Estimate<$vector>,
                tuning: &Tuning<$vector>,
                steps: usize,
                drive: &[f64],
                record: &mut [f64]
            ));
            part!($($features)?, smooth = smooth_block, (
                start: &Estimate<$vector>,
                smoothed: &mut Estimate<$vector>,
                tuning: &Tuning<$vector>,
                steps: usize,
                drive: &[f64],
                kept: &mut Vec<Kept<$vector>>,
                record: &mut [f64]
            ));
            part!($($features)?, predict_state = predict_state, (
                x: &mut [Vec3<$vector>; GROUPS],
                step: &Step<$vector>,
                tuning: &Tuning<$vector>
            ) -> (Transition<$vector>, Trig<$vector>));
            part!($($features)?, propagate = Covariance::propagate, (
                p: &mut Covariance<$vector>,
                phi: &Transition<$vector>,
                noise: &[Vec3<$vector>; 2]
            ));
            part!($($features)?, update_linear = Estimate::update_linear, (
                estimate: &mut Estimate<$vector>,
                step: &Step<$vector>,
                tuning: &Tuning<$vector>,
                telling: &mut Telling<$vector>
            ));
            part!($($features)?, update_iterated = Estimate::update_iterated, (
                estimate: &mut Estimate<$vector>,
                model: &Observation<$vector>,
                trig: &Trig<$vector>,
                step: &Step<$vector>,
                before: &Predicted<$vector>,
                tuning: &Tuning<$vector>,
                telling: &mut Telling<$vector>
            ));
            part!($($features)?, take_noise_out = take_noise_out, (
                d: &mut [Vec3<$vector>; GROUPS],
                big_d: &mut Covariance<$vector>,
                space: &mut NoiseSpace<$vector>,
                kept: &Kept<$vector>,
                step: &Step<$vector>,
                tuning: &Tuning<$vector>
            ) -> [Vec3<$vector>; 2]);
            part!($($features)?, propagate_back = Covariance::propagate_back, (
                p: &mut Covariance<$vector>,
                inverse: &Transition<$vector>
            ));
        }
    };
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

compiled!(Two);

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

    compiled!(Four, "avx2,fma");
    compiled!(Eight, "avx512f,fma");
}
