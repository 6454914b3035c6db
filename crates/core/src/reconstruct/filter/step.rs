//! What one step of a filter is given and what it yields. `T` is a number, a vector of lanes, or the lanes in memory; arrays and
//! groups of three are in the order of `model::layout`.

use crate::reconstruct::model::layout::{AIR_STATES, ATT, GROUPS, INPUTS, MEASUREMENTS, STATES, TRIPLES};
use crate::reconstruct::model::transition::Inputs;
use crate::reconstruct::numeric::real::Real;
use crate::reconstruct::numeric::vec3::Vec3;

/// Steps of a block: what a filter is given at once, between two calls of the watcher.
pub const BLOCK: usize = 32;

/// Pitch angle beyond which Euler angles are refused, rad.
pub(crate) const STEEPEST_PITCH_RAD: f64 = 89.0 * std::f64::consts::PI / 180.0;

/// Everything one step is given.
#[repr(C)]
#[derive(Clone, Copy)]
pub struct StepInputs<T> {
    /// Length, s.
    pub dt: T,
    /// Ratio of the sampling interval to `dt`: white noise held for part of an interval has that much more variance.
    pub noise_scale: T,
    /// Inertial measurements at both ends, SI.
    pub inputs: Inputs<T>,
    /// Measurements at the end, SI; any finite number where there is none.
    pub measured: [Vec3<T>; TRIPLES],
    /// 1 where there is a measurement, 0 elsewhere.
    pub present: [Vec3<T>; TRIPLES],
}

impl<T: Copy> StepInputs<T> {
    /// The same value everywhere; zero is a step of no length and no measurement, which changes nothing.
    #[inline(always)]
    pub(crate) fn uniform(value: T) -> Self {
        let triple = [value; 3];
        let inputs = Inputs { start: [triple; 2], end: [triple; 2] };
        Self { dt: value, noise_scale: value, inputs, measured: [triple; TRIPLES], present: [triple; TRIPLES] }
    }
}

impl<L: AsMut<[f64]>> StepInputs<L> {
    /// Zeros in one lane.
    pub fn clear(&mut self, lane: usize) {
        self.dt.as_mut()[lane] = 0.0;
        self.noise_scale.as_mut()[lane] = 0.0;
        let inputs = self.inputs.start.iter_mut().chain(&mut self.inputs.end);
        let triples = inputs.chain(&mut self.measured).chain(&mut self.present);
        triples.flatten().for_each(|value| value.as_mut()[lane] = 0.0);
    }
}

impl<T: Real> StepInputs<T> {
    /// The step in memory.
    #[inline(always)]
    pub fn load(memory: &StepInputs<T::Lanes>) -> Self {
        let mut step = Self::uniform(T::zero());
        step.dt = T::load(&memory.dt);
        step.noise_scale = T::load(&memory.noise_scale);
        for i in 0..3 {
            for g in 0..2 {
                step.inputs.start[g][i] = T::load(&memory.inputs.start[g][i]);
                step.inputs.end[g][i] = T::load(&memory.inputs.end[g][i]);
            }
            for m in 0..TRIPLES {
                step.measured[m][i] = T::load(&memory.measured[m][i]);
                step.present[m][i] = T::load(&memory.present[m][i]);
            }
        }
        step
    }
}

/// What a measurement update yields besides the estimate.
#[derive(Clone, Copy)]
pub struct Update<T> {
    /// Innovations `z - h(x-)`, zero where nothing was measured.
    pub innovation: [Vec3<T>; TRIPLES],
    /// Their variances, the diagonal of `S = H P- H' + R`.
    pub innovation_variance: [Vec3<T>; TRIPLES],
    /// Variances of the measurements' noise as the update takes them: R, more where [`Update::weigh`] finds a large innovation.
    pub noise: [Vec3<T>; TRIPLES],
    /// Normalised innovation squared, `nu' S^-1 nu`, with S of `noise`.
    pub nis: T,
    /// `det R / det S` over what was measured, with S of `noise`; `ln |S|` follows from it.
    pub det_ratio: T,
    /// Number of linearisations.
    pub iterations: T,
    /// Smallest pivot of the factorisation of S: not positive where S is not positive definite.
    pub smallest_pivot: T,
}

impl<T: Real> Update<T> {
    /// Huber's weight `w = min(1, limit / |nu / sigma|)` of each innovation nu of predicted deviation sigma (Huber 1964): the noise grows
    /// until the innovation's variance is `sigma^2 / w`, so that alone it corrects the state as an innovation at the limit does.
    #[inline(always)]
    pub fn weigh(&mut self, limit: f64) {
        let zero = T::zero();
        for m in 0..TRIPLES {
            for i in 0..3 {
                let variance = self.innovation_variance[m][i];
                let allowed = variance.sqrt() * T::splat(limit);
                let excess = self.innovation[m][i].abs() / allowed - T::splat(1.0);
                let excess = excess.select_above(zero, excess, zero);
                self.noise[m][i] = variance.mul_add(excess, self.noise[m][i]);
            }
        }
    }
}

/// Everything one step yields: the estimate at its end and what its innovations say.
#[repr(C)]
#[derive(Clone, Copy, Default)]
pub struct StepOutputs<T> {
    /// Estimate of each state, SI.
    pub state: [T; STATES],
    /// Its standard deviation.
    pub deviation: [T; STATES],
    /// Innovation of each measurement; NaN where there was none.
    pub innovation: [T; MEASUREMENTS],
    /// Its predicted standard deviation; NaN where there was none.
    pub innovation_deviation: [T; MEASUREMENTS],
    /// As in [`Update`].
    pub nis: T,
    /// As in [`Update`].
    pub det_ratio: T,
    /// As in [`Update`].
    pub iterations: T,
    /// As in [`Update`]; -1 beyond [`STEEPEST_PITCH_RAD`], NaN where an estimate is not finite.
    pub smallest_pivot: T,
    /// Estimate of each sensor error; not written by a form without them.
    pub air_data: [T; AIR_STATES],
    /// Its standard deviation.
    pub air_data_deviation: [T; AIR_STATES],
}

impl<L: Copy> StepOutputs<L> {
    /// Writes everything but the sensor errors.
    #[inline(always)]
    pub fn write<T: Real<Lanes = L>>(
        &mut self,
        x: &[Vec3<T>; GROUPS],
        variances: &[Vec3<T>; GROUPS],
        step: &StepInputs<T>,
        update: &Update<T>,
    ) {
        let mut poison = T::zero(); // stays zero unless something is not finite
        for k in 0..STATES {
            let (value, deviation) = (x[k / 3][k % 3], variances[k / 3][k % 3].sqrt());
            value.store(&mut self.state[k]);
            deviation.store(&mut self.deviation[k]);
            poison = (value + deviation).mul_add(T::zero(), poison);
        }
        let absent = T::splat(f64::NAN);
        for k in 0..MEASUREMENTS {
            let (m, i) = (k / 3, k % 3);
            let present = step.present[m][i];
            let deviation = update.innovation_variance[m][i].sqrt();
            present.select_above(T::zero(), update.innovation[m][i], absent).store(&mut self.innovation[k]);
            present.select_above(T::zero(), deviation, absent).store(&mut self.innovation_deviation[k]);
        }
        let steep = x[ATT][1].abs().select_above(T::splat(STEEPEST_PITCH_RAD), T::splat(-1.0), update.smallest_pivot);
        update.nis.store(&mut self.nis);
        update.det_ratio.store(&mut self.det_ratio);
        update.iterations.store(&mut self.iterations);
        (steep + poison).store(&mut self.smallest_pivot);
    }
}

/// Everything one step backwards yields: the smoothed estimate at its start, and the expected squares of the noises given all
/// measurements, which are written only where they are asked for.
#[repr(C)]
#[derive(Clone, Copy, Default)]
pub struct SmoothedOutputs<T> {
    /// Smoothed estimate of each state, SI.
    pub state: [T; STATES],
    /// Its standard deviation.
    pub deviation: [T; STATES],
    /// Expected square of each measurement's noise, `E[v^2]`; NaN where there was no measurement.
    pub measurement_noise: [T; MEASUREMENTS],
    /// Expected square of each input's noise, `E[w^2]`.
    pub process_noise: [T; INPUTS],
    /// Smoothed estimate of each sensor error; not written by a form without them.
    pub air_data: [T; AIR_STATES],
    /// Its standard deviation.
    pub air_data_deviation: [T; AIR_STATES],
}

impl<L: Copy> SmoothedOutputs<L> {
    /// Writes the estimate.
    #[inline(always)]
    pub fn write<T: Real<Lanes = L>>(&mut self, x: &[Vec3<T>; GROUPS], variances: &[Vec3<T>; GROUPS]) {
        for k in 0..STATES {
            x[k / 3][k % 3].store(&mut self.state[k]);
            variances[k / 3][k % 3].sqrt().store(&mut self.deviation[k]);
        }
    }
}
