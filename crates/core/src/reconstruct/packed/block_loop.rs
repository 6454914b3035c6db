//! The packed filter over a block of steps, forwards and back again.

use crate::reconstruct::filter::parameters::FilterParameters;
use crate::reconstruct::filter::step::{SmoothedOutputs, StepInputs, StepOutputs};
use crate::reconstruct::model::kinematics::Trig;
use crate::reconstruct::model::layout::{ATT, INPUTS, MEASUREMENTS, VEL, WIND};
use crate::reconstruct::model::measurement::MeasurementModel;
use crate::reconstruct::model::transition::Transition;
use crate::reconstruct::numeric::real::Real;
use crate::reconstruct::packed::rts::{ForwardStep, RtsParts, SmootherMemory, smooth_step};
use crate::reconstruct::packed::step::{Estimate, StepParts};

/// The filter over the steps of a block.
#[inline(always)]
pub(crate) fn filter_block<T: StepParts>(
    estimate: &mut Estimate<T>,
    parameters: &FilterParameters<T>,
    inputs: &[StepInputs<T::Lanes>],
    outputs: &mut [StepOutputs<T::Lanes>],
) {
    for (inputs, outputs) in inputs.iter().zip(outputs) {
        let step = StepInputs::<T>::load(inputs);
        let (_, trig) = estimate.predict(&step, parameters);
        let update = estimate.update(&step, &trig, parameters);
        outputs.write(&estimate.x, &estimate.p.all_variances(), &step, &update);
    }
}

/// The filter over the steps of a block again, from `start`, and the smoother back through them: `smoothed` enters at the end of the
/// block and leaves at its start. `memory` is made once and written in place: a step is kilobytes.
#[inline(always)]
pub(crate) fn smooth_block<T: StepParts + RtsParts>(
    start: &Estimate<T>,
    smoothed: &mut Estimate<T>,
    parameters: &FilterParameters<T>,
    inputs: &[StepInputs<T::Lanes>],
    memory: &mut SmootherMemory<T>,
    outputs: &mut [SmoothedOutputs<T::Lanes>],
) {
    let SmootherMemory { forward, workspace } = memory;
    forward.resize(inputs.len(), ForwardStep { phi: Transition::identity(), predicted: *start, updated: *start });
    let mut before = start;
    for (inputs, forward) in inputs.iter().zip(forward.iter_mut()) {
        let step = StepInputs::<T>::load(inputs);
        forward.predicted = *before;
        let (phi, trig) = forward.predicted.predict(&step, parameters);
        forward.phi = phi;
        forward.updated = forward.predicted;
        forward.updated.update(&step, &trig, parameters);
        before = &forward.updated;
    }
    for (k, (inputs, outputs)) in inputs.iter().zip(outputs).enumerate().rev() {
        let step = StepInputs::<T>::load(inputs);
        let before = if k == 0 { start } else { &forward[k - 1].updated };
        if parameters.noise_moments {
            write_measurement_noise(smoothed, &step, parameters, outputs);
        }
        let process = smooth_step(smoothed, workspace, before, &forward[k], &step, parameters);
        outputs.write(&smoothed.x, &smoothed.p.all_variances());
        if parameters.noise_moments {
            for k in 0..INPUTS {
                process[k / 3][k % 3].store(&mut outputs.process_noise[k]);
            }
        }
    }
}

/// Writes the expected square of each measurement's noise given all measurements, `E[v^2] = (z - h(xs))^2 + H Ps H'`, at the end
/// of a step.
#[inline(always)]
fn write_measurement_noise<T: Real>(
    smoothed: &Estimate<T>,
    step: &StepInputs<T>,
    parameters: &FilterParameters<T>,
    outputs: &mut SmoothedOutputs<T::Lanes>,
) {
    let model = MeasurementModel::new(&smoothed.x[VEL], &Trig::new(&smoothed.x[ATT]), &smoothed.x[WIND]);
    let found = smoothed.innovations(&model, step, parameters);
    for k in 0..MEASUREMENTS {
        let (m, i) = (k / 3, k % 3);
        let residual = found.innovation[m][i];
        let variance = found.innovation_variance[m][i] - parameters.noise.measurement[m][i];
        let square = residual.mul_add(residual, variance);
        let square = step.present[m][i].select_above(T::zero(), square, T::splat(f64::NAN));
        square.store(&mut outputs.measurement_noise[k]);
    }
}
