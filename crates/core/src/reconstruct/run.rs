//! From recorded samples to a reconstruction: the one place where the form of filter and smoother is chosen, and windows are put
//! side by side.

use std::borrow::Cow;
use std::ops::ControlFlow;

use crate::message;
use crate::reconstruct::collect::{NoiseMoments, Window};
use crate::reconstruct::data::{FilterData, Reconstruction};
use crate::reconstruct::error::ReconstructError;
use crate::reconstruct::events::{check, without_delay};
use crate::reconstruct::filter::backend::Backend;
use crate::reconstruct::filter::ekf::Ekf;
use crate::reconstruct::filter::initial::initial_state;
use crate::reconstruct::filter::parameters::FilterParameters;
use crate::reconstruct::filter::ukf::Ukf;
use crate::reconstruct::model::layout::STATES;
use crate::reconstruct::outliers::{OutlierSearch, PASSES};
use crate::reconstruct::packed::dispatch::{Width, widest};
use crate::reconstruct::packed::lanes::Two;
#[cfg(target_arch = "x86_64")]
use crate::reconstruct::packed::lanes::{Eight, Four};
use crate::reconstruct::packed::step::Estimate;
use crate::reconstruct::pass::{Watch, run_pass};
use crate::reconstruct::settings::{Method, ValidSettings};
use crate::reconstruct::smoother::iterated::{Pass, iterate};

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
    let punctual: Vec<Cow<'_, FilterData>> = data.iter().map(|data| without_delay(data, settings)).collect();
    let punctual: Vec<&FilterData> = punctual.iter().map(AsRef::as_ref).collect();
    let results = reconstruct_all(width, &punctual, settings, watch);
    if settings.outlier_limit == 0.0 {
        return results;
    }
    leave_out_outliers(width, data, &punctual, settings, results, watch)
}

/// Windows whose innovations show outliers ([`OutlierSearch`]), run again without them; `recorded` as `data` before delays were taken off.
fn leave_out_outliers(
    width: Width,
    recorded: &[&FilterData],
    data: &[&FilterData],
    settings: &ValidSettings,
    mut results: Vec<Result<Reconstruction, ReconstructError>>,
    watch: Watch<'_>,
) -> Vec<Result<Reconstruction, ReconstructError>> {
    let filter = settings.filter_alone();
    let mut searches: Vec<(usize, OutlierSearch<'_>)> = Vec::new();
    for (k, (data, result)) in data.iter().zip(&results).enumerate() {
        let mut search = OutlierSearch::new(data, settings.outlier_limit);
        if result.as_ref().is_ok_and(|run| search.search(run)) {
            searches.push((k, search));
        }
    }
    if searches.is_empty() {
        return results;
    }
    let mut watch = |_| watch(1.0);
    let mut open: Vec<usize> = (0..searches.len()).collect();
    for _ in 1..PASSES {
        let remaining: Vec<FilterData> = open.iter().map(|&at| searches[at].1.data()).collect();
        let found = reconstruct_all(width, &remaining.iter().collect::<Vec<_>>(), &filter, &mut watch);
        let mut found = found.into_iter();
        open.retain(|&at| found.next().is_some_and(|run| run.is_ok_and(|run| searches[at].1.search(&run))));
        if open.is_empty() {
            break;
        }
    }
    for (_, search) in &mut searches {
        search.put_back();
    }
    searches.retain(|(_, search)| search.found_any());
    let remaining: Vec<FilterData> = searches.iter().map(|(_, search)| search.data()).collect();
    let found = reconstruct_all(width, &remaining.iter().collect::<Vec<_>>(), settings, &mut watch);
    for ((k, search), result) in searches.iter().zip(found) {
        match result {
            Ok(run) => results[*k] = Ok(Reconstruction { outliers: search.outliers(recorded[*k]), ..run }),
            Err(ReconstructError::Cancelled) => results[*k] = Err(ReconstructError::Cancelled),
            // The path with every sample stays.
            Err(_) => {}
        }
    }
    results
}

/// Reconstructs windows with every sample.
fn reconstruct_all(
    width: Width,
    data: &[&FilterData],
    settings: &ValidSettings,
    watch: Watch<'_>,
) -> Vec<Result<Reconstruction, ReconstructError>> {
    let kind = FilterKind::select(settings);
    if kind == FilterKind::Packed {
        let results = run_packed(width, data, settings, false, watch);
        return results.into_iter().map(|result| result.map(|(result, _)| result)).collect();
    }
    let count = data.len() as f64;
    let windows = data.iter().enumerate();
    windows.map(|(k, data)| run_dense(kind, data, settings, &mut |part| watch((k as f64 + part) / count))).collect()
}

/// A window's result, and the moments of the noises where they were asked for.
pub type Outcome = Result<(Reconstruction, Option<NoiseMoments>), ReconstructError>;

/// Filters and smooths windows in the packed form, and sums the expected squares of the noises given all measurements.
pub(crate) fn reconstruct_with_noise_moments(
    data: &[&FilterData],
    settings: &ValidSettings,
    watch: Watch<'_>,
) -> Vec<Outcome> {
    let data: Vec<Cow<'_, FilterData>> = data.iter().map(|data| without_delay(data, settings)).collect();
    let data: Vec<&FilterData> = data.iter().map(AsRef::as_ref).collect();
    run_packed(widest(), &data, settings, true, watch)
}

/// Forms of filter and smoother.
#[derive(Clone, Copy, PartialEq, Eq)]
enum FilterKind {
    /// Extended or iterated filter and its smoother, in 3 x 3 blocks, windows side by side: the fast one.
    Packed,
    /// The same over whole matrices, with sensor errors among the states.
    Dense,
    Unscented,
    /// Smoothed again and again over whole matrices; the path of the filter is that of the method.
    Iterated,
}

impl FilterKind {
    /// The form that the settings need.
    fn select(settings: &ValidSettings) -> Self {
        if settings.smooth && settings.smoother_passes > 1 {
            Self::Iterated
        } else if matches!(settings.method, Method::Ukf { .. }) {
            Self::Unscented
        } else if has_sensor_errors(settings) {
            Self::Dense
        } else {
            Self::Packed
        }
    }
}

/// Whether any sensor error is a state.
fn has_sensor_errors(settings: &ValidSettings) -> bool {
    settings.air_data_deviation.iter().any(|deviation| *deviation > 0.0)
}

/// Reconstructs one window over whole matrices.
fn run_dense(
    kind: FilterKind,
    data: &FilterData,
    settings: &ValidSettings,
    watch: Watch<'_>,
) -> Result<Reconstruction, ReconstructError> {
    let mut result = match kind {
        FilterKind::Iterated => return run_iterated(data, settings, watch),
        FilterKind::Unscented => run_one::<Ukf>(data, settings, watch)?,
        FilterKind::Dense | FilterKind::Packed => run_one::<Ekf>(data, settings, watch)?,
    };
    if has_sensor_errors(settings) {
        result.warnings.push(message!(
            "air-data states multiply what they correct: one pass can be far more certain of them than it should; smooth with more passes"
        ));
    }
    Ok(result)
}

/// Reconstructs windows side by side in the packed form; one it fails on for numerical reasons, over whole matrices.
fn run_packed(
    width: Width,
    data: &[&FilterData],
    settings: &ValidSettings,
    noise_moments: bool,
    watch: Watch<'_>,
) -> Vec<Outcome> {
    let width = width.min(widest());
    let mut results: Vec<Outcome> = data.iter().map(|_| Err(ReconstructError::NoResult)).collect();
    let total: usize = data.iter().map(|window| window.inputs.time_s.len()).sum();
    let mut done = 0;
    for group in groups_of(width.lanes(), data) {
        let windows: Vec<&FilterData> = group.iter().map(|&k| data[k]).collect();
        let samples: usize = windows.iter().map(|window| window.inputs.time_s.len()).sum();
        let mut part = |part: f64| watch((done as f64 + part * samples as f64) / total.max(1) as f64);
        // Few windows waste wide lanes: half as many cost little more than half.
        let width = if width == Width::Eight && group.len() <= Width::Four.lanes() { Width::Four } else { width };
        let outcomes = match width {
            Width::Two => run_group::<Estimate<Two>>(&windows, settings, noise_moments, &mut part),
            #[cfg(target_arch = "x86_64")]
            Width::Four => run_group::<Estimate<Four>>(&windows, settings, noise_moments, &mut part),
            #[cfg(target_arch = "x86_64")]
            Width::Eight => run_group::<Estimate<Eight>>(&windows, settings, noise_moments, &mut part),
            #[cfg(not(target_arch = "x86_64"))]
            Width::Four | Width::Eight => run_group::<Estimate<Two>>(&windows, settings, noise_moments, &mut part),
        };
        done += samples;
        for (&k, outcome) in group.iter().zip(outcomes) {
            results[k] = match outcome {
                Err(cause) if cause.is_numerical() => {
                    let part = done as f64 / total.max(1) as f64;
                    run_one::<Ekf>(data[k], settings, &mut |_| watch(part)).map(|mut result| {
                        let cause = cause.to_string();
                        result
                            .warnings
                            .push(message!("recomputed with a dense covariance in Joseph form, because {}", cause));
                        (result, None)
                    })
                }
                outcome => outcome,
            };
        }
    }
    results
}

/// Name of the vector instructions the filter uses on this machine, for example `AVX-512`.
pub fn instructions() -> &'static str {
    widest().name()
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

/// A window before its first step.
fn prepare<'a>(data: &'a FilterData, settings: &ValidSettings) -> Result<Window<'a>, ReconstructError> {
    check(data)?;
    let mut warnings = Vec::new();
    let x = initial_state(data, settings, &mut warnings);
    Ok(Window::new(data, settings, x, warnings))
}

/// Reconstructs as many windows as the backend has lanes, or fewer.
pub(crate) fn run_group<B: Backend>(
    data: &[&FilterData],
    settings: &ValidSettings,
    noise_moments: bool,
    watch: Watch<'_>,
) -> Vec<Outcome> {
    let mut windows: Vec<_> = data.iter().map(|data| prepare(data, settings)).collect();
    let state = |window: &Window<'_>| window.result.states.each_ref().map(|column| column[0]);
    let first = windows.iter().flatten().map(state).next().unwrap_or([0.0; STATES]);
    let initial: Vec<[f64; STATES]> = windows.iter().map(|window| window.as_ref().map_or(first, state)).collect();
    let parameters = FilterParameters::new(settings, noise_moments);
    match run_pass(&mut windows, B::new(&initial, settings), &parameters, settings.smooth, watch) {
        ControlFlow::Break(()) => data.iter().map(|_| Err(ReconstructError::Cancelled)).collect(),
        ControlFlow::Continue((filter, _)) => {
            let finish = |(lane, window): (usize, Result<Window<'_>, _>)| {
                let (result, moments) = window?.finish(filter.covariance(lane))?;
                Ok((result, noise_moments.then_some(moments)))
            };
            windows.into_iter().enumerate().map(finish).collect()
        }
    }
}

/// Reconstructs one window.
fn run_one<B: Backend>(
    data: &FilterData,
    settings: &ValidSettings,
    watch: Watch<'_>,
) -> Result<Reconstruction, ReconstructError> {
    let outcome = run_group::<B>(&[data], settings, false, watch).pop();
    outcome.unwrap_or(Err(ReconstructError::TooFewSamples { samples: 0 })).map(|(result, _)| result)
}

/// Reconstructs one window and smooths it again and again, each pass linearised about the smoothed path of the one before.
fn run_iterated(
    data: &FilterData,
    settings: &ValidSettings,
    watch: Watch<'_>,
) -> Result<Reconstruction, ReconstructError> {
    let passes = settings.smoother_passes;
    let parameters = FilterParameters::new(settings, false);
    let found = iterate(passes, |k, about| {
        let window = prepare(data, settings)?;
        let x = window.result.states.each_ref().map(|column| column[0]);
        let filter = Ekf { about, ..Backend::new(&[x], settings) };
        let mut windows = [Ok(window)];
        let mut part = |part: f64| watch((k as f64 + part) / passes as f64);
        let ControlFlow::Continue((filter, Some(smoother))) =
            run_pass(&mut windows, filter, &parameters, true, &mut part)
        else {
            return Err(ReconstructError::Cancelled);
        };
        let [window] = windows;
        let (result, _) = window?.finish(filter.covariance(0))?;
        Ok(Pass { result, path: smoother.own.states, cost: smoother.own.cost })
    })?;
    let found = found.ok_or(ReconstructError::NoResult)?;
    if let Method::Ukf { .. } = settings.method {
        // The filter the settings name; the passes began with an extended one.
        return Ok(Reconstruction { smoothed: found.smoothed, ..run_one::<Ukf>(data, settings, watch)? });
    }
    Ok(found)
}
