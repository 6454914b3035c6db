//! From recorded samples to a reconstruction: manoeuvres side by side in lanes, block by block.

use std::borrow::Cow;
use std::ops::ControlFlow;
use std::rc::Rc;

use super::form::{Form, tuning};
use super::full::X;
use super::joseph::DenseEstimate;
use super::kernel::{Estimate, Tuning};
#[cfg(target_arch = "x86_64")]
use super::lanes::{Eight, Four};
use super::lanes::{Two, Width, widest};
use super::march::BLOCK;
use super::real::Real;
use super::schedule::{DRIVE, Schedule};
use super::settings::{Method, SMOOTHER_TOLERANCE, ValidSettings};
use super::unscented::UnscentedEstimate;
use super::window::{NoiseSeen, Window, Windows, drain, drain_smoothed};
use super::{FilterData, ReconstructError, Reconstruction, Smoothed};

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
    let delayed: Vec<Cow<'_, FilterData>> = data.iter().map(|data| without_delay(data, settings)).collect();
    let data: Vec<&FilterData> = delayed.iter().map(AsRef::as_ref).collect();
    let results = run_all(width, &data, settings, watch);
    results.into_iter().map(|result| result.map(|(result, _)| result)).collect()
}

/// A window's result, and the noises its smoother saw where it was to look.
pub type Outcome = Result<(Reconstruction, Option<NoiseSeen>), ReconstructError>;

/// Reconstructs windows, and tells the noises the smoother sees.
pub fn reconstruct_seeing_noise(data: &[&FilterData], settings: &ValidSettings, watch: Watch<'_>) -> Vec<Outcome> {
    let delayed: Vec<Cow<'_, FilterData>> = data.iter().map(|data| without_delay(data, settings)).collect();
    let data: Vec<&FilterData> = delayed.iter().map(AsRef::as_ref).collect();
    in_lanes(widest(), &data, settings, true, watch)
}

/// Reconstructs windows in the form that the settings need.
fn run_all(width: Width, data: &[&FilterData], settings: &ValidSettings, watch: Watch<'_>) -> Vec<Outcome> {
    let has_air_data = settings.air_data_deviation.iter().any(|deviation| *deviation > 0.0);
    let unscented = matches!(settings.method, Method::Ukf { .. });
    let iterated = settings.smooth && settings.smoother_passes > 1;
    if !(unscented || has_air_data || iterated) {
        return in_lanes(width, data, settings, false, watch);
    }
    let count = data.len() as f64;
    let one = |(k, data): (usize, &&FilterData)| {
        let part = &mut |part: f64| watch((k as f64 + part) / count);
        if iterated {
            return smooth_iterated(data, settings, part).map(|result| (result, None));
        }
        let mut results = if unscented {
            run_group::<UnscentedEstimate>(&[data], settings, false, part)
        } else {
            run_group::<DenseEstimate>(&[data], settings, false, part)
        };
        let (mut result, _) = results.pop().unwrap_or(Err(ReconstructError::Cancelled))?;
        if has_air_data {
            result.warnings.push(
                "air-data states multiply what they correct: one pass can be far more certain of them than it should; smooth with more passes"
                    .to_owned(),
            );
        }
        Ok((result, None))
    };
    data.iter().enumerate().map(one).collect()
}

/// Reconstructs windows side by side.
fn in_lanes(
    width: Width,
    data: &[&FilterData],
    settings: &ValidSettings,
    see_noise: bool,
    watch: Watch<'_>,
) -> Vec<Outcome> {
    let width = width.min(widest());
    let mut results: Vec<Option<Outcome>> = data.iter().map(|_| None).collect();
    let groups = groups_of(width.lanes(), data);
    let total: usize = data.iter().map(|window| window.inputs.time_s.len()).sum();
    let mut done = 0;
    for group in groups {
        let windows: Vec<&FilterData> = group.iter().map(|&k| data[k]).collect();
        let samples: usize = windows.iter().map(|window| window.inputs.time_s.len()).sum();
        let mut part = |part: f64| watch((done as f64 + part * samples as f64) / total.max(1) as f64);
        // Few windows waste wide lanes: half as many cost little more than half.
        let width = if width == Width::Eight && group.len() <= Width::Four.lanes() { Width::Four } else { width };
        let outcome = match width {
            Width::Two => run_group::<Estimate<Two>>(&windows, settings, see_noise, &mut part),
            #[cfg(target_arch = "x86_64")]
            Width::Four => run_group::<Estimate<Four>>(&windows, settings, see_noise, &mut part),
            #[cfg(target_arch = "x86_64")]
            Width::Eight => run_group::<Estimate<Eight>>(&windows, settings, see_noise, &mut part),
            #[cfg(not(target_arch = "x86_64"))]
            Width::Four | Width::Eight => run_group::<Estimate<Two>>(&windows, settings, see_noise, &mut part),
        };
        done += samples;
        for (&k, result) in group.iter().zip(outcome) {
            results[k] = Some(match result {
                Err(error) if error.is_numerical() => {
                    let part = done as f64 / total.max(1) as f64;
                    run_joseph(data[k], settings, &error, &mut |_| watch(part)).map(|result| (result, None))
                }
                result => result,
            });
        }
    }
    results.into_iter().map(|result| result.unwrap_or(Err(ReconstructError::Cancelled))).collect()
}

/// The measurements at the times they were true: each sample's own less the delay of its measurement.
fn without_delay<'a>(data: &'a FilterData, settings: &ValidSettings) -> Cow<'a, FilterData> {
    if settings.measurement_delay_s.iter().all(|delay| *delay == 0.0) {
        return Cow::Borrowed(data);
    }
    let mut data = data.clone();
    for (series, delay) in data.measurements.iter_mut().zip(settings.measurement_delay_s) {
        series.time_s.iter_mut().for_each(|time| *time -= delay);
    }
    Cow::Owned(data)
}

/// Number of windows the machine runs side by side.
pub fn lanes() -> usize {
    widest().lanes()
}

/// Groups of windows, by index, that run side by side: as many as there are lanes, of similar length. What is left over when
/// `workers` have had the same number of groups is halved where all of them can then help.
pub fn lane_groups(data: &[&FilterData], workers: usize) -> Vec<Vec<usize>> {
    let mut groups = groups_of(lanes(), data);
    let left_over = groups.len() % workers.max(1);
    if 2 * left_over <= workers {
        for group in groups.split_off(groups.len() - left_over) {
            let (first, second) = group.split_at(group.len().div_ceil(2));
            groups.extend([first, second].into_iter().filter(|half| !half.is_empty()).map(<[usize]>::to_vec));
        }
    }
    groups
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
    see_noise: bool,
    watch: Watch<'_>,
) -> Vec<Outcome> {
    let mut windows: Vec<Result<Window<'_>, ReconstructError>> =
        data.iter().map(|data| Window::new(data, settings)).collect();
    let form = F::new(&windows, settings);
    let tuning = tuning::<F::Number>(settings, see_noise);
    match pass(&mut windows, form, &tuning, settings.smooth, watch) {
        ControlFlow::Break(()) => data.iter().map(|_| Err(ReconstructError::Cancelled)).collect(),
        ControlFlow::Continue((form, _)) => {
            let finish = |(lane, window): (usize, Result<Window<'_>, _>)| {
                let (result, seen) = window?.finish(form.covariance(lane))?;
                Ok((result, see_noise.then_some(seen)))
            };
            windows.into_iter().enumerate().map(finish).collect()
        }
    }
}

/// Filters the windows from `form`, and smooths them where asked; returns the estimate at the end and, smoothed, at the start.
fn pass<'a, F: Form>(
    windows: &mut Windows<'a>,
    mut form: F,
    tuning: &Tuning<F::Number>,
    smooth: bool,
    watch: Watch<'_>,
) -> ControlFlow<(), (F, Option<F>)> {
    let lanes = F::Number::LANES;
    let mut drive = vec![0.0; BLOCK * DRIVE * lanes];
    let mut record = vec![0.0; BLOCK * F::ROW * lanes];
    let longest = windows.iter().flatten().map(|window| window.result.time_s.len()).max().unwrap_or(0);
    let mut checkpoints = Checkpoints::new(if smooth { longest / BLOCK + 2 } else { 0 }, windows.len());
    let share = if smooth { FILTER_SHARE } else { 1.0 };
    loop {
        if smooth {
            checkpoints.push(&form, windows);
        }
        let steps = fill::<F::Number>(windows, &mut drive);
        if steps == 0 {
            break;
        }
        form.run(tuning, steps, &drive, &mut record);
        drain::<F>(windows, &record);
        let done = windows.iter().flatten().map(Window::part_done).fold(1.0, f64::min);
        watch(done * share)?;
    }
    if !smooth {
        return ControlFlow::Continue((form, None));
    }
    let smoothed = smooth_group(windows, form.clone(), tuning, &checkpoints, watch)?;
    ControlFlow::Continue((form, Some(smoothed)))
}

/// Puts the next block of every window into its lane; returns the number of steps of the longest.
fn fill<T: Real>(windows: &mut Windows<'_>, drive: &mut [f64]) -> usize {
    let mut steps = 0;
    for (lane, window) in windows.iter_mut().enumerate() {
        if let Ok(window) = window {
            window.fill::<T>(lane, drive);
            steps = steps.max(window.events.len());
        }
    }
    steps
}

/// Where the blocks began: enough to run them again.
struct Checkpoints<'a, F> {
    forms: Vec<F>,
    /// As many as there are windows for each form.
    schedules: Vec<Option<Schedule<'a>>>,
}

impl<'a, F: Form> Checkpoints<'a, F> {
    fn new(blocks: usize, windows: usize) -> Self {
        Self { forms: Vec::with_capacity(blocks), schedules: Vec::with_capacity(blocks * windows) }
    }

    fn push(&mut self, form: &F, windows: &Windows<'a>) {
        self.forms.push(form.clone());
        self.schedules.extend(windows.iter().map(|window| window.as_ref().ok().map(|window| window.schedule.clone())));
    }
}

/// Goes back through the blocks from the final estimate. Each is filtered again from its checkpoint, so that only one
/// block at a time is held whole.
fn smooth_group<'a, F: Form>(
    windows: &mut Windows<'a>,
    mut smoothed: F,
    tuning: &Tuning<F::Number>,
    checkpoints: &Checkpoints<'a, F>,
    watch: Watch<'_>,
) -> ControlFlow<(), F> {
    let lanes = F::Number::LANES;
    let mut drive = vec![0.0; BLOCK * DRIVE * lanes];
    let mut record = vec![0.0; BLOCK * F::ROW * lanes];
    let mut kept = Vec::with_capacity(BLOCK);
    for window in windows.iter_mut().flatten() {
        window.begin_smoothing();
    }
    smoothed.begin_smoothing();
    let blocks = checkpoints.forms.len();
    for (left, form) in checkpoints.forms.iter().enumerate().rev() {
        let schedules = &checkpoints.schedules[left * windows.len()..];
        for (window, schedule) in windows.iter_mut().zip(schedules) {
            if let (Ok(window), Some(schedule)) = (window, schedule) {
                window.schedule = schedule.clone();
            }
        }
        let steps = fill::<F::Number>(windows, &mut drive);
        smoothed.smooth(form, tuning, steps, &drive, &mut kept, &mut record);
        drain_smoothed::<F>(windows, tuning.see_noise, &record);
        watch(1.0 - (1.0 - FILTER_SHARE) * left as f64 / blocks as f64)?;
    }
    ControlFlow::Continue(smoothed)
}

/// Reconstructs one window and smooths it again and again, each pass linearised about the smoothed path of the one before: the
/// Gauss-Newton iteration on the whole path (Bell 1994). What the filter says, innovations included, is that of the plain
/// filter; only the smoothed path is the last one's.
fn smooth_iterated(
    data: &FilterData,
    settings: &ValidSettings,
    watch: Watch<'_>,
) -> Result<Reconstruction, ReconstructError> {
    let passes = settings.smoother_passes;
    let tuning = tuning::<f64>(settings, false);
    let mut result: Option<Reconstruction> = None;
    let mut about: Option<Rc<[X]>> = None;
    let mut costs = Vec::new();
    for k in 0..passes {
        let mut windows = [Window::new(data, settings)];
        let mut form = DenseEstimate::new(&windows, settings);
        form.about = about;
        let mut part = |part: f64| watch((k as f64 + part) / passes as f64);
        let ControlFlow::Continue((form, Some(smoothed))) = pass(&mut windows, form, &tuning, true, &mut part) else {
            return Err(ReconstructError::Cancelled);
        };
        let [window] = windows;
        let (found, _) = window?.finish(form.covariance(0))?;
        costs.push(smoothed.cost);
        about = Some(smoothed.path.into());
        let Some(result) = &mut result else {
            result = Some(found);
            continue;
        };
        let movement = match (&result.smoothed, &found.smoothed) {
            (Some(before), Some(now)) => movement(before, now),
            _ => 0.0,
        };
        result.smoothed = found.smoothed;
        if movement < SMOOTHER_TOLERANCE {
            break;
        }
        if k + 1 == passes {
            result.warnings.push(format!(
                "the iterated smoother still moves by {movement:.1e} standard deviations after {passes} passes: allow more"
            ));
        }
    }
    let mut result = match (result, settings.method) {
        // The filter the settings name; the passes began with an extended one.
        (Some(result), Method::Ukf { .. }) => {
            let outcome = run_group::<UnscentedEstimate>(&[data], settings, false, watch).pop();
            let (unscented, _) = outcome.unwrap_or(Err(ReconstructError::Cancelled))?;
            Reconstruction { smoothed: result.smoothed, ..unscented }
        }
        (Some(result), _) => result,
        (None, _) => return Err(ReconstructError::Cancelled),
    };
    if let Some(smoothed) = &mut result.smoothed {
        smoothed.costs = costs;
    }
    Ok(result)
}

/// Largest difference of two smoothed paths, in standard deviations of the second.
fn movement(before: &Smoothed, now: &Smoothed) -> f64 {
    let mut largest: f64 = 0.0;
    for ((before, now), deviations) in before.states.iter().zip(&now.states).zip(&now.deviations) {
        for ((before, now), deviation) in before.iter().zip(now).zip(deviations) {
            if *deviation > 0.0 {
                largest = largest.max((now - before).abs() / deviation);
            }
        }
    }
    largest
}

/// Reconstructs one window with the dense Joseph form, after `cause` stopped the packed one.
fn run_joseph(
    data: &FilterData,
    settings: &ValidSettings,
    cause: &ReconstructError,
    watch: Watch<'_>,
) -> Result<Reconstruction, ReconstructError> {
    let outcome = run_group::<DenseEstimate>(&[data], settings, false, watch).pop();
    let (mut result, _) = outcome.unwrap_or_else(|| Err(cause.clone()))?;
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
        let dense = run_group::<DenseEstimate>(&[&data], &settings, false, &mut watch).remove(0).unwrap().0;
        let packed = run_group::<Estimate<Two>>(&[&data], &settings, false, &mut watch).remove(0).unwrap().0;
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
