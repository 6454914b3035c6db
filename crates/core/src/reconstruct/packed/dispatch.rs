//! The packed filter compiled for the instructions of each vector: the parts of its steps, and its blocks as a backend.
//!
//! Vector instructions are enabled in the functions below and nowhere else, and they are reached only after the machine was asked:
//! that is why `unsafe` is allowed here.
#![allow(unsafe_code)]

use crate::reconstruct::filter::backend::Backend;
use crate::reconstruct::filter::parameters::FilterParameters;
use crate::reconstruct::filter::step::{BLOCK, SmoothedOutputs, StepInputs, StepOutputs, Update};
use crate::reconstruct::model::dense::StateMatrix;
use crate::reconstruct::model::kinematics::Trig;
use crate::reconstruct::model::layout::{GROUPS, STATES};
use crate::reconstruct::model::transition::{Transition, predict_state};
use crate::reconstruct::numeric::real::Real;
use crate::reconstruct::numeric::vec3::Vec3;
use crate::reconstruct::packed::block_loop::{filter_block, smooth_block};
use crate::reconstruct::packed::covariance::Covariance;
use crate::reconstruct::packed::lanes::Two;
#[cfg(target_arch = "x86_64")]
use crate::reconstruct::packed::lanes::{Eight, Four};
use crate::reconstruct::packed::rts::{ForwardStep, NoiseWorkspace, RtsParts, SmootherMemory, remove_process_noise};
use crate::reconstruct::packed::step::{Estimate, Prediction, StepParts};
use crate::reconstruct::settings::ValidSettings;

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
    /// Name of the instructions.
    pub fn name(self) -> &'static str {
        match self {
            Self::Two if cfg!(target_arch = "x86_64") => "SSE2",
            Self::Two => "two lanes",
            Self::Four => "AVX2",
            Self::Eight => "AVX-512",
        }
    }

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

/// A vector with the packed filter compiled for its instructions. Only on a machine that [`widest`] found to have them.
pub(crate) trait Vector: StepParts + RtsParts {
    /// [`filter_block`].
    fn filter_block(
        estimate: &mut Estimate<Self>,
        parameters: &FilterParameters<Self>,
        inputs: &[StepInputs<Self::Lanes>],
        outputs: &mut [StepOutputs<Self::Lanes>],
    );

    /// [`smooth_block`].
    fn smooth_block(
        start: &Estimate<Self>,
        smoothed: &mut Estimate<Self>,
        parameters: &FilterParameters<Self>,
        inputs: &[StepInputs<Self::Lanes>],
        memory: &mut SmootherMemory<Self>,
        outputs: &mut [SmoothedOutputs<Self::Lanes>],
    );
}

/// A function that calls the generic one of the given path, compiled for the given instructions.
macro_rules! part {
    ($($features:literal)?, $name:ident = $generic:path, ($($argument:ident: $type:ty),*) $(-> $result:ty)?) => {
        fn $name($($argument: $type),*) $(-> $result)? {
            $(#[target_feature(enable = $features)])?
            #[inline(never)]
            fn compiled($($argument: $type),*) $(-> $result)? {
                $generic($($argument),*)
            }
            // SAFETY: `widest` has found the features.
            #[allow(unused_unsafe)]
            unsafe {
                compiled($($argument),*)
            }
        }
    };
}

/// Compiles the packed filter for the instructions of a vector.
macro_rules! compiled {
    ($vector:ident, $lanes:literal $(, $features:literal)?) => {
        impl StepParts for $vector {
            part!($($features)?, predict_state = predict_step, (
                x: &mut [Vec3<$vector>; GROUPS],
                step: &StepInputs<$vector>,
                parameters: &FilterParameters<$vector>
            ) -> (Transition<$vector>, Trig<$vector>));
            part!($($features)?, propagate = Covariance::propagate, (
                p: &mut Covariance<$vector>,
                phi: &Transition<$vector>,
                noise: &[Vec3<$vector>; 2]
            ));
            part!($($features)?, update_linear = Estimate::update_linear, (
                estimate: &mut Estimate<$vector>,
                step: &StepInputs<$vector>,
                parameters: &FilterParameters<$vector>,
                update: &mut Update<$vector>
            ));
            part!($($features)?, update_iterated = Estimate::update_iterated, (
                estimate: &mut Estimate<$vector>,
                step: &StepInputs<$vector>,
                prediction: &Prediction<$vector>,
                parameters: &FilterParameters<$vector>,
                update: &mut Update<$vector>
            ));
        }

        impl RtsParts for $vector {
            part!($($features)?, remove_process_noise = remove_process_noise, (
                d: &mut [Vec3<$vector>; GROUPS],
                big_d: &mut Covariance<$vector>,
                workspace: &mut NoiseWorkspace<$vector>,
                forward: &ForwardStep<$vector>,
                step: &StepInputs<$vector>,
                parameters: &FilterParameters<$vector>
            ) -> [Vec3<$vector>; 2]);
            part!($($features)?, propagate_back = Covariance::propagate_back, (
                p: &mut Covariance<$vector>,
                inverse: &Transition<$vector>
            ));
        }

        impl Vector for $vector {
            part!($($features)?, filter_block = filter_block, (
                estimate: &mut Estimate<$vector>,
                parameters: &FilterParameters<$vector>,
                inputs: &[StepInputs<[f64; $lanes]>],
                outputs: &mut [StepOutputs<[f64; $lanes]>]
            ));
            part!($($features)?, smooth_block = smooth_block, (
                start: &Estimate<$vector>,
                smoothed: &mut Estimate<$vector>,
                parameters: &FilterParameters<$vector>,
                inputs: &[StepInputs<[f64; $lanes]>],
                memory: &mut SmootherMemory<$vector>,
                outputs: &mut [SmoothedOutputs<[f64; $lanes]>]
            ));
        }
    };
}

compiled!(Two, 2);
#[cfg(target_arch = "x86_64")]
compiled!(Four, 4, "avx2,fma");
#[cfg(target_arch = "x86_64")]
compiled!(Eight, 8, "avx512f,fma");

/// [`predict_state`] over a step.
#[inline(always)]
fn predict_step<T: Real>(
    x: &mut [Vec3<T>; GROUPS],
    step: &StepInputs<T>,
    parameters: &FilterParameters<T>,
) -> (Transition<T>, Trig<T>) {
    predict_state(x, &step.inputs, step.dt, parameters.gravity, parameters.at_prediction)
}

/// The smoothed estimate on its way back through the blocks, and the memory it takes.
pub struct PackedSmoother<T> {
    smoothed: Estimate<T>,
    memory: SmootherMemory<T>,
}

impl<T: Vector> Backend for Estimate<T> {
    type Number = T;
    type Smoother = PackedSmoother<T>;

    /// A lane without a window gets the initial state of the first.
    fn new(initial: &[[f64; STATES]], settings: &ValidSettings) -> Self {
        let mut x = [[T::zero(); 3]; GROUPS];
        let mut variances = x;
        for k in 0..STATES {
            let mut lanes = T::Lanes::default();
            lanes.as_mut().fill(initial.first().map_or(0.0, |first| first[k]));
            for (lane, initial) in lanes.as_mut().iter_mut().zip(initial) {
                *lane = initial[k];
            }
            x[k / 3][k % 3] = T::load(&lanes);
            variances[k / 3][k % 3] = T::splat(settings.initial_deviation[k].powi(2));
        }
        Self { x, p: Covariance::diagonal(&variances) }
    }

    fn filter(
        &mut self,
        parameters: &FilterParameters<T>,
        inputs: &[StepInputs<T::Lanes>],
        outputs: &mut [StepOutputs<T::Lanes>],
    ) {
        T::filter_block(self, parameters, inputs, outputs);
    }

    fn smoother(&self) -> PackedSmoother<T> {
        let memory = SmootherMemory { forward: Vec::with_capacity(BLOCK), workspace: Box::new(NoiseWorkspace::new()) };
        PackedSmoother { smoothed: *self, memory }
    }

    fn smooth(
        &self,
        smoother: &mut PackedSmoother<T>,
        parameters: &FilterParameters<T>,
        inputs: &[StepInputs<T::Lanes>],
        outputs: &mut [SmoothedOutputs<T::Lanes>],
    ) {
        T::smooth_block(self, &mut smoother.smoothed, parameters, inputs, &mut smoother.memory, outputs);
    }

    fn covariance(&self, lane: usize) -> StateMatrix {
        let mut lanes = T::Lanes::default();
        let mut covariance = StateMatrix::zeros();
        for i in 0..STATES {
            for j in 0..STATES {
                self.p.block(i / 3, j / 3)[i % 3][j % 3].store(&mut lanes);
                covariance[(i, j)] = lanes.as_ref()[lane];
            }
        }
        covariance
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::reconstruct::model::layout::{ATT, VEL};
    use crate::reconstruct::settings::FilterSettings;

    /// A million steps of level flight in every lane, which starts with twice the deviations of the lane before.
    fn fly_a_million_steps<T: Vector>() {
        let settings = FilterSettings::default().check().unwrap();
        let pitch = (6.0_f64 / 80.0).atan();
        let mut variances = [[T::zero(); 3]; GROUPS];
        for k in 0..STATES {
            let mut lanes = T::Lanes::default();
            for (lane, variance) in lanes.as_mut().iter_mut().enumerate() {
                *variance = (settings.initial_deviation[k] * f64::powi(2.0, lane as i32)).powi(2);
            }
            variances[k / 3][k % 3] = T::load(&lanes);
        }
        let mut estimate = Estimate { x: [[T::zero(); 3]; GROUPS], p: Covariance::diagonal(&variances) };
        estimate.x[VEL] = [80.0, 0.0, 6.0].map(T::splat);
        estimate.x[ATT][1] = T::splat(pitch);
        let every_lane = |value: f64| {
            let mut lanes = T::Lanes::default();
            lanes.as_mut().fill(value);
            lanes
        };
        let mut step = StepInputs::uniform(every_lane(0.0));
        (step.dt, step.noise_scale) = (every_lane(0.01), every_lane(1.0));
        let force = [settings.gravity_m_s2 * pitch.sin(), 0.0, -settings.gravity_m_s2 * pitch.cos()].map(every_lane);
        (step.inputs.start[0], step.inputs.end[0]) = (force, force);
        for (m, value) in [(3, 6.0_f64.hypot(80.0)), (7, pitch), (9, 6.0_f64.hypot(80.0)), (10, pitch)] {
            step.measured[m / 3][m % 3] = every_lane(value);
        }
        // position is left to the ground velocity: it would move away from a repeated measurement
        step.present[1..].fill([every_lane(1.0); 3]);
        let steps = 100;
        let inputs = vec![step; steps];
        let mut outputs = vec![StepOutputs::default(); steps];
        let parameters = FilterParameters::new(&settings, false);
        for _ in 0..1_000_000 / steps {
            estimate.filter(&parameters, &inputs, &mut outputs);
            let mut pivots = outputs.iter().flat_map(|outputs| outputs.smallest_pivot.as_ref());
            assert!(pivots.all(|pivot| *pivot > 0.0));
        }
        for lane in 0..T::Lanes::default().as_ref().len() {
            let p = estimate.covariance(lane);
            assert_eq!(p, p.transpose());
            let scale = StateMatrix::from_diagonal(&p.diagonal().map(|variance| variance.sqrt().recip()));
            assert!((scale * p * scale).symmetric_eigenvalues().min() > 0.0);
        }
    }

    #[test]
    fn covariance_stays_symmetric_and_positive_over_a_million_steps() {
        match widest() {
            #[cfg(target_arch = "x86_64")]
            Width::Eight => fly_a_million_steps::<Eight>(),
            #[cfg(target_arch = "x86_64")]
            Width::Four => fly_a_million_steps::<Four>(),
            _ => fly_a_million_steps::<Two>(),
        }
    }
}
