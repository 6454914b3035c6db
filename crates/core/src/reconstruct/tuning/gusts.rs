//! Intensity of the gusts: the random walk of the wind that makes the measurements most likely.
//!
//! A gust is modelled as a change of wind dW, which leaves the velocity over ground and changes the velocity relative to the air by
//! `-C' dW` (`filter::terms::walk_covariance`). First-order Gauss-Markov gusts of deviation sigma and length L (Dryden's longitudinal
//! spectrum, MIL-F-8785C 3.7.2) change at airspeed V with the variance rate `2 sigma^2 V / L` within times well below L / V. The
//! measured ground velocity holds the slow part, so that a random walk of this rate stands for the gusts without their length.

use std::ops::ControlFlow;

use rayon::prelude::*;

use crate::reconstruct::data::FilterData;
use crate::reconstruct::error::ReconstructError;
use crate::reconstruct::model::layout::State;
use crate::reconstruct::run::{lane_groups, reconstruct_many};
use crate::reconstruct::settings::{FilterSettings, ValidSettings};

/// Gusts over windows: the wind's random walk that makes their measurements most likely.
#[derive(Clone, Debug, PartialEq)]
pub struct Gusts {
    /// Random walk of the horizontal components of the wind and of the vertical one, m/s per square root of a second.
    pub walk: [f64; 2],
    /// Standard error of the logarithm of each, from the curvature of the likelihood; `None` where it is only bounded from above.
    pub log_standard_error: [Option<f64>; 2],
    /// Gain of the logarithm of the likelihood over a wind that does not change by gusts.
    pub gain: f64,
}

/// Gain of the logarithm of the likelihood above which gusts are significant. Two parameters of no effect gain as much once in
/// 20,000 times. Errors of the model, as late sensors, can gain more in calm air.
const SIGNIFICANT_GAIN: f64 = 10.0;
/// Random walks tried at first, m/s per square root of a second: from still air to severe turbulence.
const TRIED: [f64; 6] = [0.03, 0.08, 0.2, 0.5, 1.2, 3.0];
/// Factors either way by which each walk is refined, one round each.
const STEPS: [f64; 3] = [1.6, 1.35, 1.35];
/// Samples that are enough to determine two numbers; windows beyond are left out evenly.
const ENOUGH_SAMPLES: usize = 20_000;

impl Gusts {
    /// Whether the likelihood of the measurements calls for them.
    pub fn is_significant(&self) -> bool {
        self.gain > SIGNIFICANT_GAIN
    }

    /// The settings with these gusts beside the random walk of the wind they state: variances add.
    #[must_use]
    pub fn added_to(&self, settings: &FilterSettings) -> FilterSettings {
        with_walk(settings, self.walk)
    }
}

/// The settings with gusts of these walks beside the random walk of the wind they state.
fn with_walk(settings: &FilterSettings, [horizontal, vertical]: [f64; 2]) -> FilterSettings {
    let mut settings = settings.clone();
    for (state, walk) in [(State::WindNorth, horizontal), (State::WindEast, horizontal), (State::WindDown, vertical)] {
        let stated = &mut settings.random_walk[state as usize];
        *stated = stated.hypot(walk);
    }
    settings
}

/// Estimates the gusts over windows with the noises of `settings`: the likelihood over one walk for all components first, then each by
/// parabolas over its logarithm. `None` where no window can be filtered or the settings are outside their range.
///
/// # Errors
/// [`ReconstructError::Cancelled`] where `is_stopped` says so.
pub fn estimate_gusts(
    data: &[&FilterData],
    settings: &FilterSettings,
    is_stopped: &(dyn Fn() -> bool + Sync),
) -> Result<Option<Gusts>, ReconstructError> {
    let clean = clean_windows(data, settings, is_stopped)?;
    let data: Vec<&FilterData> = clean.iter().collect();
    let plain = settings.simplified(false);
    // A window that the filter fails on, still or at a walk, adds nothing to the gain of that walk.
    let Some(still) = likelihoods(&data, &plain, [0.0; 2], is_stopped)? else { return Ok(None) };
    let gain = |walk: [f64; 2]| -> Result<f64, ReconstructError> {
        let Some(found) = likelihoods(&data, &plain, walk, is_stopped)? else { return Ok(f64::NEG_INFINITY) };
        Ok(found.iter().zip(&still).map(|(found, still)| found - still).filter(|gain| gain.is_finite()).sum())
    };
    if still.iter().all(|value| value.is_nan()) {
        return Ok(None);
    }
    let mut best = ([0.0; 2], 0.0);
    for walk in TRIED {
        let found = gain([walk; 2])?;
        if found > best.1 {
            best = ([walk; 2], found);
        }
    }
    let mut log_standard_error = [None; 2];
    if best.1 > SIGNIFICANT_GAIN {
        for factor in STEPS {
            for axis in [1, 0] {
                let scaled = |by: f64| {
                    let mut walk = best.0;
                    walk[axis] *= by;
                    walk
                };
                let (below, above) = (gain(scaled(factor.recip()))?, gain(scaled(factor))?);
                let step = factor.ln();
                let curvature = (below - 2.0 * best.1 + above) / (step * step);
                log_standard_error[axis] = (curvature < 0.0).then(|| (-curvature).sqrt().recip());
                let moved = if curvature < 0.0 {
                    (0.5 * (below - above) / step / curvature).clamp(-FURTHEST * step, FURTHEST * step)
                } else {
                    step * (above - below).signum()
                };
                let walk = scaled(moved.exp());
                let found = gain(walk)?;
                let candidates = [(walk, found), (scaled(factor.recip()), below), (scaled(factor), above)];
                for candidate in candidates {
                    if candidate.1 > best.1 {
                        best = candidate;
                    }
                }
            }
        }
    }
    Ok(Some(Gusts { walk: best.0, log_standard_error, gain: best.1 }))
}

/// Longest step of a parabola, in steps of its points.
const FURTHEST: f64 = 3.0;

/// Longest window that gusts are estimated from, samples. The paths of a longer one would take more memory than its results.
const LONGEST_WINDOW: usize = 60_000;

/// Every so many windows that their samples together are about 20,000, without those of more than 60,000.
fn select_windows<'a>(data: &[&'a FilterData]) -> Vec<&'a FilterData> {
    let data: Vec<&FilterData> =
        data.iter().copied().filter(|window| window.inputs.time_s.len() <= LONGEST_WINDOW).collect();
    let samples: usize = data.iter().map(|window| window.inputs.time_s.len()).sum();
    let every = samples.div_ceil(ENOUGH_SAMPLES).clamp(1, data.len().max(1));
    data.iter().step_by(every).copied().collect()
}

/// Every so many windows that their samples together are about 20,000, without those of more than 60,000 and without the outliers that
/// a filter with `settings` finds in them.
///
/// # Errors
/// [`ReconstructError::Cancelled`] where `is_stopped` says so.
pub fn clean_windows(
    data: &[&FilterData],
    settings: &FilterSettings,
    is_stopped: &(dyn Fn() -> bool + Sync),
) -> Result<Vec<FilterData>, ReconstructError> {
    let mut data: Vec<FilterData> = select_windows(data).into_iter().cloned().collect();
    let plain = FilterSettings { outlier_limit: settings.outlier_limit, ..settings.simplified(false) };
    let Some(settings) = plain.check().ok().filter(|settings| settings.outlier_limit > 0.0) else { return Ok(data) };
    data.par_iter_mut().try_for_each(|window| remove_outliers(window, &settings, is_stopped))?;
    Ok(data)
}

fn remove_outliers(
    window: &mut FilterData,
    settings: &ValidSettings,
    is_stopped: &(dyn Fn() -> bool + Sync),
) -> Result<(), ReconstructError> {
    let mut watch = |_| if is_stopped() { ControlFlow::Break(()) } else { ControlFlow::Continue(()) };
    match reconstruct_many(&[&*window], settings, &mut watch).pop() {
        Some(Err(ReconstructError::Cancelled)) => return Err(ReconstructError::Cancelled),
        Some(Ok(run)) if run.outliers.iter().any(|outliers| !outliers.is_empty()) => {
            *window = window.without(&run.outliers);
        }
        _ => {}
    }
    Ok(())
}

/// Logarithm of the likelihood of each window with gusts of this walk; not a number where the filter fails.
fn likelihoods(
    data: &[&FilterData],
    settings: &FilterSettings,
    walk: [f64; 2],
    is_stopped: &(dyn Fn() -> bool + Sync),
) -> Result<Option<Vec<f64>>, ReconstructError> {
    let Ok(settings) = with_walk(settings, walk).check() else { return Ok(None) };
    let groups = lane_groups(data, rayon::current_num_threads());
    let of_group = |group: &Vec<usize>| {
        likelihoods_of_lanes(&group.iter().map(|&index| data[index]).collect::<Vec<_>>(), &settings, is_stopped)
    };
    let found: Vec<Vec<f64>> = groups.par_iter().map(of_group).collect::<Result<_, _>>()?;
    let mut values = vec![f64::NAN; data.len()];
    for (group, found) in groups.iter().zip(found) {
        for (&index, value) in group.iter().zip(found) {
            values[index] = value;
        }
    }
    Ok(Some(values))
}

fn likelihoods_of_lanes(
    windows: &[&FilterData],
    settings: &ValidSettings,
    is_stopped: &(dyn Fn() -> bool + Sync),
) -> Result<Vec<f64>, ReconstructError> {
    let mut watch = |_| if is_stopped() { ControlFlow::Break(()) } else { ControlFlow::Continue(()) };
    let found = reconstruct_many(windows, settings, &mut watch);
    let values = found.into_iter().map(|found| match found {
        Ok(path) => Ok(path.log_likelihood),
        Err(ReconstructError::Cancelled) => Err(ReconstructError::Cancelled),
        Err(_) => Ok(f64::NAN),
    });
    values.collect()
}
