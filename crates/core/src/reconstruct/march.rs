//! The kernel over a block of steps: from the numbers that drive them to the record of what they tell.

use super::blocks::Vec3;
use super::covariance::{ATT, GROUPS, VEL, WIND};
use super::kernel::{Estimate, Step, Telling, Tuning};
use super::kinematics::{Observation, Trig};
use super::lanes::Lanes;
use super::layout::{AIR_STATES, INPUTS, MEASUREMENTS, STATES};
use super::real::Real;
use super::schedule::{DRIVE, END, MEASURED, NOISE_SCALE, PRESENT, START};
use super::smoother::{Kept, NoiseSpace, smooth_step};
use super::transition::{Inputs, Transition};

/// Steps of a block, between two looks at the watcher.
pub const BLOCK: usize = 32;
/// Numbers one step tells: states, their deviations, innovations, their deviations, NIS, health, iterations, noise share.
pub const RECORD: usize = 2 * STATES + 2 * MEASUREMENTS + 4;
/// Numbers one step of a form with air-data states tells: those of every form, the air-data states, their deviations.
pub const FULL_RECORD: usize = RECORD + 2 * AIR_STATES;
/// Place of the air-data states, where a form has them.
pub const AIR_DATA: usize = RECORD;
/// Place of their deviations.
pub const AIR_DATA_DEVIATIONS: usize = RECORD + AIR_STATES;
/// Place of the deviations of the states.
pub const DEVIATIONS: usize = STATES;
/// Place of the innovations.
pub const INNOVATIONS: usize = 2 * STATES;
/// Place of their predicted deviations.
pub const INNOVATION_DEVIATIONS: usize = INNOVATIONS + MEASUREMENTS;
/// Place of the normalised innovation squared.
pub const NIS: usize = INNOVATION_DEVIATIONS + MEASUREMENTS;
/// Place of a number that is positive unless the step went wrong.
pub const HEALTH: usize = NIS + 1;
/// Place of the number of linearisations.
pub const ITERATIONS: usize = NIS + 2;
/// Place of the share of the noise in the innovations, `det R / det S`.
pub const NOISE_SHARE: usize = NIS + 3;
/// In a record of the smoother: place of the mean squares of the measurement noises it sees.
pub const SEEN_MEASUREMENT_NOISE: usize = INNOVATIONS;
/// In a record of the smoother: place of the mean squares of the process noises it sees.
pub const SEEN_PROCESS_NOISE: usize = INNOVATION_DEVIATIONS;

/// Pitch angle beyond which Euler angles are refused, rad.
pub const STEEPEST_PITCH_RAD: f64 = 89.0 * std::f64::consts::PI / 180.0;
/// The kernel over `steps` steps.
#[inline(always)]
pub fn run_block<T: Lanes>(
    estimate: &mut Estimate<T>,
    tuning: &Tuning<T>,
    steps: usize,
    drive: &[f64],
    record: &mut [f64],
) {
    for (drive, record) in
        drive.chunks_exact(DRIVE * T::LANES).zip(record.chunks_exact_mut(RECORD * T::LANES)).take(steps)
    {
        let step = read_step::<T>(drive);
        let (_, trig) = estimate.predict(&step, tuning);
        let telling = estimate.update(&step, &trig, tuning);
        tell(&estimate.x, &estimate.p.all_variances(), &step, &telling, record);
    }
}

/// The kernel over `steps` steps from `start`, kept, and back again: `smoothed` enters at the end of the block and leaves
/// at its start.
#[inline(always)]
pub fn smooth_block<T: Lanes>(
    start: &Estimate<T>,
    smoothed: &mut Estimate<T>,
    tuning: &Tuning<T>,
    steps: usize,
    drive: &[f64],
    kept: &mut Vec<Kept<T>>,
    record: &mut [f64],
) {
    // Made once and written in place: a step is kilobytes.
    kept.resize(BLOCK, Kept { before: *start, phi: Transition::nothing(), predicted: *start });
    let mut estimate = *start;
    for (drive, kept) in drive.chunks_exact(DRIVE * T::LANES).zip(kept.iter_mut()).take(steps) {
        let step = read_step::<T>(drive);
        kept.before = estimate;
        let (phi, trig) = estimate.predict(&step, tuning);
        kept.phi = phi;
        kept.predicted = estimate;
        estimate.update(&step, &trig, tuning);
    }
    let mut space = NoiseSpace::new();
    for k in (0..steps).rev() {
        let step = read_step::<T>(&drive[k * DRIVE * T::LANES..]);
        let record = &mut record[k * RECORD * T::LANES..];
        if tuning.see_noise {
            tell_measurement_noise(smoothed, &step, tuning, record);
        }
        let process = smooth_step(smoothed, &mut space, &kept[k], &step, tuning);
        tell_smoothed(&smoothed.x, &smoothed.p.all_variances(), record);
        if tuning.see_noise {
            for field in 0..INPUTS {
                process[field / 3][field % 3].store(&mut record[(SEEN_PROCESS_NOISE + field) * T::LANES..]);
            }
        }
    }
}

/// Writes down what one step leaves behind.
#[inline(always)]
pub fn tell<T: Real>(
    x: &[Vec3<T>; GROUPS],
    variances: &[Vec3<T>; GROUPS],
    step: &Step<T>,
    telling: &Telling<T>,
    record: &mut [f64],
) {
    let mut field = 0;
    let mut poison = T::zero(); // stays zero unless something is not finite
    for g in 0..GROUPS {
        for i in 0..3 {
            let deviation = variances[g][i].sqrt();
            x[g][i].store(&mut record[field * T::LANES..]);
            deviation.store(&mut record[(DEVIATIONS + field) * T::LANES..]);
            poison = (x[g][i] + deviation).mul_add(T::zero(), poison);
            field += 1;
        }
    }
    field = 0;
    let absent = T::splat(f64::NAN);
    for m in 0..4 {
        for i in 0..3 {
            let present = step.present[m][i];
            let innovation = present.select_above(T::zero(), telling.innovation[m][i], absent);
            let deviation = present.select_above(T::zero(), telling.variance[m][i].sqrt(), absent);
            innovation.store(&mut record[(INNOVATIONS + field) * T::LANES..]);
            deviation.store(&mut record[(INNOVATION_DEVIATIONS + field) * T::LANES..]);
            field += 1;
        }
    }
    let steep = x[ATT][1].abs().select_above(T::splat(STEEPEST_PITCH_RAD), T::splat(-1.0), telling.pivot);
    telling.nis.store(&mut record[NIS * T::LANES..]);
    (steep + poison).store(&mut record[HEALTH * T::LANES..]);
    telling.iterations.store(&mut record[ITERATIONS * T::LANES..]);
    telling.noise_share.store(&mut record[NOISE_SHARE * T::LANES..]);
}

/// Writes down the smoothed estimate at the start of a step.
#[inline(always)]
pub fn tell_smoothed<T: Real>(x: &[Vec3<T>; GROUPS], variances: &[Vec3<T>; GROUPS], record: &mut [f64]) {
    for field in 0..STATES {
        let (g, i) = (field / 3, field % 3);
        x[g][i].store(&mut record[field * T::LANES..]);
        variances[g][i].sqrt().store(&mut record[(DEVIATIONS + field) * T::LANES..]);
    }
}

/// Writes down the expected square of each measurement's noise given all measurements,
/// `E[v^2] = (z - h(xs))^2 + H Ps H'`, at the end of a step.
#[inline(always)]
fn tell_measurement_noise<T: Real>(smoothed: &Estimate<T>, step: &Step<T>, tuning: &Tuning<T>, record: &mut [f64]) {
    let trig = Trig::new(&smoothed.x[ATT]);
    let seen = smoothed.innovations(&Observation::new(&smoothed.x[VEL], &trig, &smoothed.x[WIND]), step, tuning);
    for field in 0..MEASUREMENTS {
        let (m, i) = (field / 3, field % 3);
        let residual = seen.innovation[m][i];
        let square = residual.mul_add(residual, seen.variance[m][i] - tuning.measurement[m][i]);
        let square = step.present[m][i].select_above(T::zero(), square, T::splat(f64::NAN));
        square.store(&mut record[(SEEN_MEASUREMENT_NOISE + field) * T::LANES..]);
    }
}

/// The step that `drive` describes.
#[inline(always)]
pub fn read_step<T: Real>(drive: &[f64]) -> Step<T> {
    let zero = [T::zero(); 3];
    let mut start = [zero; 2];
    let mut end = [zero; 2];
    let mut z = [zero; 4];
    let mut present = [zero; 4];
    for g in 0..2 {
        read_triple(&mut start[g], START + 3 * g, drive);
        read_triple(&mut end[g], END + 3 * g, drive);
    }
    for m in 0..4 {
        read_triple(&mut z[m], MEASURED + 3 * m, drive);
        read_triple(&mut present[m], PRESENT + 3 * m, drive);
    }
    let (dt, noise_scale) = (T::load(drive), T::load(&drive[NOISE_SCALE * T::LANES..]));
    Step { dt, noise_scale, inputs: Inputs { start, end }, z, present }
}

#[inline(always)]
fn read_triple<T: Real>(triple: &mut Vec3<T>, field: usize, drive: &[f64]) {
    for i in 0..3 {
        triple[i] = T::load(&drive[(field + i) * T::LANES..]);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::reconstruct::FilterSettings;
    use crate::reconstruct::covariance::Covariance;
    use crate::reconstruct::dense::Dense;
    use crate::reconstruct::form::{Form, tuning};
    #[cfg(target_arch = "x86_64")]
    use crate::reconstruct::lanes::{Eight, Four};
    use crate::reconstruct::lanes::{Two, Width, widest};

    /// A million steps of level flight in every lane, which starts with twice the deviations of the lane before.
    fn fly_a_million_steps<T: Lanes>() {
        let settings = FilterSettings::default().check().unwrap();
        let pitch = (6.0_f64 / 80.0).atan();
        let mut variances = [[T::zero(); 3]; GROUPS];
        for k in 0..STATES {
            let lanes: Vec<f64> =
                (0..T::LANES as i32).map(|lane| (settings.initial_deviation[k] * 2.0_f64.powi(lane)).powi(2)).collect();
            variances[k / 3][k % 3] = T::load(&lanes);
        }
        let mut estimate = Estimate { x: [[T::zero(); 3]; GROUPS], p: Covariance::diagonal(&variances) };
        estimate.x[VEL] = [80.0, 0.0, 6.0].map(T::splat);
        estimate.x[ATT][1] = T::splat(pitch);
        let mut step = vec![0.0; DRIVE];
        (step[0], step[NOISE_SCALE]) = (0.01, 1.0);
        for at in [START, END] {
            step[at] = settings.gravity_m_s2 * pitch.sin();
            step[at + 2] = -settings.gravity_m_s2 * pitch.cos();
        }
        for (m, value) in [(3, 6.0_f64.hypot(80.0)), (7, pitch), (9, 6.0_f64.hypot(80.0)), (10, pitch)] {
            step[MEASURED + m] = value;
        }
        // position is left to the ground velocity: it would move away from a repeated measurement
        step[PRESENT + 3..PRESENT + 12].fill(1.0);
        let steps = 100;
        let drive: Vec<f64> = step.iter().flat_map(|value| vec![*value; T::LANES]).collect::<Vec<f64>>().repeat(steps);
        let mut record = vec![0.0; steps * RECORD * T::LANES];
        let tuning = tuning::<T>(&settings, false);
        for _ in 0..1_000_000 / steps {
            T::run(&mut estimate, &tuning, steps, &drive, &mut record);
            let rows = record.chunks_exact(RECORD * T::LANES);
            let mut health = rows.flat_map(|row| &row[HEALTH * T::LANES..(HEALTH + 1) * T::LANES]);
            assert!(health.all(|health| *health > 0.0));
        }
        for lane in 0..T::LANES {
            let p = estimate.covariance(lane);
            assert_eq!(p, p.transpose());
            let scale = Dense::from_diagonal(&p.diagonal().map(|variance| variance.sqrt().recip()));
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
