//! From recorded samples to a reconstruction: manoeuvres side by side in lanes, block by block.

use std::ops::ControlFlow;

use super::form::{Form, initial_estimate, tuning};
use super::joseph::DenseEstimate;
use super::kernel::{Estimate, Tuning};
#[cfg(target_arch = "x86_64")]
use super::lanes::{Eight, Four};
use super::lanes::{Two, Width, widest};
use super::march::{BLOCK, RECORD};
use super::real::Real;
use super::schedule::{DRIVE, Schedule};
use super::settings::ValidSettings;
use super::window::Window;
use super::{FilterData, ReconstructError, Reconstruction};

/// Called between blocks with the part done, 0 to 1; `Break` cancels.
pub type Watch<'a> = &'a mut dyn FnMut(f64) -> ControlFlow<()>;

/// Reconstructs the flight path of one window.
///
/// Extended or iterated extended Kalman filter over the kinematic model of thesis Eq. 3.7 with the measurements of
/// Eq. 3.8, any subset of them, each at its own times. A measurement between two inertial samples splits the step
/// there. The first inertial sample starts the filter and measurements up to it are not updated with: they may have
/// given the initial state.
///
/// # Errors
/// Data that cannot be filtered, divergence, and cancellation by `watch`; never a result that is not finite.
pub fn reconstruct(
    data: &FilterData,
    settings: &ValidSettings,
    watch: Watch<'_>,
) -> Result<Reconstruction, ReconstructError> {
    let mut results = reconstruct_many(&[data], settings, watch);
    results.pop().unwrap_or(Err(ReconstructError::TooFewSamples { samples: 0 }))
}

/// Reconstructs several windows, as many side by side as the machine has lanes. Results come in the order of `data`,
/// and do not depend on which windows share a group. For several threads, give each the windows of some of the
/// [`lane_groups`].
pub fn reconstruct_many(
    data: &[&FilterData],
    settings: &ValidSettings,
    watch: Watch<'_>,
) -> Vec<Result<Reconstruction, ReconstructError>> {
    reconstruct_with(widest(), data, settings, watch)
}

/// [`reconstruct_many`] with vectors of a given width, or of the widest the machine has if that is less.
pub fn reconstruct_with(
    width: Width,
    data: &[&FilterData],
    settings: &ValidSettings,
    watch: Watch<'_>,
) -> Vec<Result<Reconstruction, ReconstructError>> {
    let width = width.min(widest());
    let mut results: Vec<Option<Result<Reconstruction, ReconstructError>>> = data.iter().map(|_| None).collect();
    let groups = groups_of(width.lanes(), data);
    let total: usize = data.iter().map(|window| window.inputs.time_s.len()).sum();
    let mut done = 0;
    for group in groups {
        let windows: Vec<&FilterData> = group.iter().map(|&k| data[k]).collect();
        let samples: usize = windows.iter().map(|window| window.inputs.time_s.len()).sum();
        let mut part = |part: f64| watch((done as f64 + part * samples as f64) / total.max(1) as f64);
        let outcome = match width {
            Width::Two => run_group::<Estimate<Two>>(&windows, settings, &mut part),
            #[cfg(target_arch = "x86_64")]
            Width::Four => run_group::<Estimate<Four>>(&windows, settings, &mut part),
            #[cfg(target_arch = "x86_64")]
            Width::Eight => run_group::<Estimate<Eight>>(&windows, settings, &mut part),
            #[cfg(not(target_arch = "x86_64"))]
            Width::Four | Width::Eight => run_group::<Estimate<Two>>(&windows, settings, &mut part),
        };
        done += samples;
        for (&k, result) in group.iter().zip(outcome) {
            results[k] = Some(match result {
                Err(error) if error.is_numerical() => {
                    let part = done as f64 / total.max(1) as f64;
                    run_joseph(data[k], settings, &error, &mut |_| watch(part))
                }
                result => result,
            });
        }
    }
    results.into_iter().map(|result| result.unwrap_or(Err(ReconstructError::Cancelled))).collect()
}

/// Number of windows the machine runs side by side.
pub fn lanes() -> usize {
    widest().lanes()
}

/// Groups of windows, by index, that run side by side: as many as there are lanes, of similar length.
pub fn lane_groups(data: &[&FilterData]) -> Vec<Vec<usize>> {
    groups_of(lanes(), data)
}

fn groups_of(lanes: usize, data: &[&FilterData]) -> Vec<Vec<usize>> {
    let mut order: Vec<usize> = (0..data.len()).collect();
    order.sort_by_key(|&k| data[k].inputs.time_s.len());
    order.chunks(lanes).map(<[usize]>::to_vec).collect()
}

/// Part of the time that filtering takes when the path is smoothed as well.
const FILTER_SHARE: f64 = 0.3;

/// Reconstructs as many windows as the form has lanes, or fewer.
fn run_group<F: Form>(
    data: &[&FilterData],
    settings: &ValidSettings,
    watch: Watch<'_>,
) -> Vec<Result<Reconstruction, ReconstructError>> {
    let mut windows: Vec<Result<Window<'_>, ReconstructError>> =
        data.iter().map(|data| Window::new(data, settings)).collect();
    let lanes = F::Number::LANES;
    let mut form = F::new(&initial_estimate(&windows, settings));
    let tuning = tuning::<F::Number>(settings);
    let mut drive = vec![0.0; BLOCK * DRIVE * lanes];
    let mut record = vec![0.0; BLOCK * RECORD * lanes];
    let mut checkpoints = Vec::new();
    let share = if settings.smooth { FILTER_SHARE } else { 1.0 };
    loop {
        if settings.smooth {
            checkpoints.push(Checkpoint { form: form.clone(), schedules: schedules(&windows) });
        }
        let steps = fill::<F::Number>(&mut windows, &mut drive);
        if steps == 0 {
            break;
        }
        form.run(&tuning, steps, &drive, &mut record);
        let mut done: f64 = 1.0;
        for (lane, window) in windows.iter_mut().enumerate() {
            if let Ok(window) = window {
                window.drain::<F::Number>(lane, &record);
                done = done.min(window.part_done());
            }
        }
        if watch(done * share).is_break() {
            return data.iter().map(|_| Err(ReconstructError::Cancelled)).collect();
        }
    }
    if settings.smooth && smooth_group(&mut windows, form.clone(), &tuning, &checkpoints, watch).is_break() {
        return data.iter().map(|_| Err(ReconstructError::Cancelled)).collect();
    }
    let finish = |(lane, window): (usize, Result<Window<'_>, _>)| window?.finish(form.covariance(lane));
    windows.into_iter().enumerate().map(finish).collect()
}

/// Puts the next block of every window into its lane; returns the number of steps of the longest.
fn fill<T: Real>(windows: &mut [Result<Window<'_>, ReconstructError>], drive: &mut [f64]) -> usize {
    let mut steps = 0;
    for (lane, window) in windows.iter_mut().enumerate() {
        if let Ok(window) = window {
            window.fill::<T>(lane, drive);
            steps = steps.max(window.events.len());
        }
    }
    steps
}

/// Where a block began: enough to run it again.
struct Checkpoint<'a, F> {
    form: F,
    schedules: Vec<Option<Schedule<'a>>>,
}

fn schedules<'a>(windows: &[Result<Window<'a>, ReconstructError>]) -> Vec<Option<Schedule<'a>>> {
    windows.iter().map(|window| window.as_ref().ok().map(|window| window.schedule.clone())).collect()
}

/// Goes back through the blocks from the final estimate. Each is filtered again from its checkpoint, so that only one
/// block at a time is held whole.
fn smooth_group<'a, F: Form>(
    windows: &mut [Result<Window<'a>, ReconstructError>],
    mut smoothed: F,
    tuning: &Tuning<F::Number>,
    checkpoints: &[Checkpoint<'a, F>],
    watch: Watch<'_>,
) -> ControlFlow<()> {
    let lanes = F::Number::LANES;
    let mut drive = vec![0.0; BLOCK * DRIVE * lanes];
    let mut record = vec![0.0; BLOCK * RECORD * lanes];
    let mut kept = Vec::with_capacity(BLOCK);
    for window in windows.iter_mut().flatten() {
        window.begin_smoothing();
    }
    for (left, checkpoint) in checkpoints.iter().enumerate().rev() {
        for (window, schedule) in windows.iter_mut().zip(&checkpoint.schedules) {
            if let (Ok(window), Some(schedule)) = (window, schedule) {
                window.schedule = schedule.clone();
            }
        }
        let steps = fill::<F::Number>(windows, &mut drive);
        smoothed.smooth(&checkpoint.form, tuning, steps, &drive, &mut kept, &mut record);
        for (lane, window) in windows.iter_mut().enumerate() {
            if let Ok(window) = window {
                window.drain_smoothed::<F::Number>(lane, &record);
            }
        }
        watch(1.0 - (1.0 - FILTER_SHARE) * left as f64 / checkpoints.len() as f64)?;
    }
    ControlFlow::Continue(())
}

/// Reconstructs one window with the dense Joseph form, after `cause` stopped the packed one.
fn run_joseph(
    data: &FilterData,
    settings: &ValidSettings,
    cause: &ReconstructError,
    watch: Watch<'_>,
) -> Result<Reconstruction, ReconstructError> {
    let mut result =
        run_group::<DenseEstimate>(&[data], settings, watch).pop().unwrap_or_else(|| Err(cause.clone()))?;
    result.warnings.push(format!("recomputed with a dense covariance in Joseph form, because {cause}"));
    Ok(result)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::reconstruct::layout::STATES;
    use crate::reconstruct::{FilterSettings, InputSeries, MeasurementSeries};

    /// Four seconds of a weaving flight, its measurements roughly right; air data at a fifth of the rate.
    fn weaving_flight() -> FilterData {
        let time_s: Vec<f64> = (0..401).map(|k| f64::from(k) * 0.01).collect();
        let wave = |level: f64, size: f64, rate: f64| -> Vec<f64> {
            time_s.iter().map(|t| level + size * (rate * t).sin()).collect()
        };
        let columns = [
            wave(0.7, 0.2, 2.0),
            wave(0.0, 0.3, 3.0),
            wave(-9.8, 0.5, 1.5),
            wave(0.0, 0.1, 3.0),
            wave(0.0, 0.05, 1.5),
            wave(0.0, 0.03, 2.0),
        ];
        let north: Vec<f64> = time_s.iter().map(|t| 80.0 * t).collect();
        let rows = [
            north,
            wave(0.0, 1.0, 1.0),
            wave(-900.0, 0.5, 2.0),
            wave(80.0, 0.1, 1.0),
            wave(0.0, 0.2, 1.0),
            wave(0.0, 0.1, 2.0),
            wave(0.0, 0.03, 3.0),
            wave(0.075, 0.03, 1.5),
            wave(0.0, 0.015, 2.0),
            wave(80.2, 0.1, 1.0),
            wave(0.075, 0.01, 1.5),
            wave(0.0, 0.01, 3.0),
        ];
        let mut measurements = rows.map(|values| MeasurementSeries { time_s: time_s.clone(), values });
        for series in &mut measurements[9..] {
            series.time_s = series.time_s.iter().copied().step_by(5).collect();
            series.values = series.values.iter().copied().step_by(5).collect();
        }
        FilterData { inputs: InputSeries { time_s, columns }, measurements }
    }

    /// Agreement of two forms of the same recursion, in standard deviations; the backward one solves with a covariance
    /// of condition 1e10.
    const FORMS_SIGMA: f64 = 1e-5;

    #[test]
    fn dense_joseph_form_matches_two_packed_lanes_forwards_and_backwards() {
        let data = weaving_flight();
        let mut settings = FilterSettings { smooth: true, ..FilterSettings::default() };
        settings.random_walk[STATES - 1] = 0.05;
        settings.initial_deviation[9] = 0.0;
        let settings = settings.check().unwrap();
        let mut watch = |_: f64| ControlFlow::Continue(());
        let dense = run_group::<DenseEstimate>(&[&data], &settings, &mut watch).remove(0).unwrap();
        let packed = run_group::<Estimate<Two>>(&[&data], &settings, &mut watch).remove(0).unwrap();
        let (dense_smoothed, packed_smoothed) = (dense.smoothed.unwrap(), packed.smoothed.unwrap());
        let mut largest: f64 = 0.0;
        for k in 0..STATES {
            for (states, deviations, others, other_deviations) in [
                (&dense.states[k], &dense.deviations[k], &packed.states[k], &packed.deviations[k]),
                (
                    &dense_smoothed.states[k],
                    &dense_smoothed.deviations[k],
                    &packed_smoothed.states[k],
                    &packed_smoothed.deviations[k],
                ),
            ] {
                for i in 0..401 {
                    let scale = deviations[i].max(1e-12);
                    largest = largest.max((states[i] - others[i]).abs() / scale);
                    largest = largest.max((deviations[i] - other_deviations[i]).abs() / scale);
                }
            }
        }
        assert!(largest < FORMS_SIGMA, "{largest}");
    }
}
