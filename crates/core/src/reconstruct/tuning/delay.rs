//! The delay of a sensor, refined until the measurements are most likely.

use thiserror::Error;

use crate::reconstruct::data::FilterData;
use crate::reconstruct::error::ReconstructError;
use crate::reconstruct::model::layout::Measurement;
use crate::reconstruct::settings::{FilterSettings, SettingError, ValidSettings};

/// A refined delay.
#[derive(Clone, Debug, PartialEq)]
pub struct DelayEstimate {
    /// Delay, s: what the measurements' time stamps are late.
    pub delay_s: f64,
    /// Its standard error from the curvature of the likelihood, `1 / sqrt(-L'')`, s.
    pub standard_error_s: f64,
    /// Delay as it is set, s.
    pub present_s: f64,
    /// Delays tried and the logarithm of the likelihood at each, in order of the delay.
    pub tried: Vec<(f64, f64)>,
}

/// Why there is no delay.
#[derive(Clone, Debug, PartialEq, Error)]
#[expect(missing_docs, reason = "the messages say what variants and fields are")]
pub enum DelayError {
    /// The filter failed.
    #[error(transparent)]
    Filter(#[from] ReconstructError),
    /// Settings outside their range.
    #[error("{0}")]
    Setting(#[from] SettingError),
    #[error(
        "no delay within {range_s} s of the one that is set makes the measurements most likely: search a wider range"
    )]
    NoMaximum { range_s: f64 },
}

/// Delays on the first, coarse scan.
const COARSE: usize = 21;
/// Rounds of closing in.
const ROUNDS: usize = 8;
/// Fall of the logarithm of the likelihood at the ends of the last parabola: two standard errors away.
const FALL: f64 = 2.0;

/// `data` with only those samples of `measurements` that lie inside the window whatever delay within the range is taken: the
/// likelihood then compares equal numbers of them.
pub fn comparable(
    data: &FilterData,
    measurements: &[Measurement],
    settings: &FilterSettings,
    range_s: f64,
) -> FilterData {
    let mut data = data.clone();
    let times = &data.inputs.time_s;
    let (Some(&first), Some(&last)) = (times.first(), times.last()) else { return data };
    for &measurement in measurements {
        let present = settings.measurement_delay_s[measurement as usize];
        let series = &mut data.measurements[measurement as usize];
        let is_inside = |time: f64| time - present - range_s > first && time - present + range_s < last;
        let samples = series.time_s.iter().zip(series.values.iter()).filter(|(time, _)| is_inside(**time));
        let (time_s, values): (Vec<f64>, Vec<f64>) = samples.map(|(time, value)| (*time, *value)).unzip();
        (series.time_s, series.values) = (time_s.into(), values.into());
    }
    data
}

/// Refines the common delay of `measurements` within `range_s` of the first one's present setting: the delay that maximises
/// the likelihood of all measurements (Maine & Iliff 1981 on time shifts as parameters). `evaluate` gives the
/// logarithm of the likelihood of all windows, made [`comparable`] first.
///
/// # Errors
/// What stops the filter, and a likelihood that rises to the end of the range.
pub fn refine_delay(
    settings: &FilterSettings,
    measurements: &[Measurement],
    range_s: f64,
    evaluate: &mut dyn FnMut(&ValidSettings) -> Result<f64, ReconstructError>,
) -> Result<DelayEstimate, DelayError> {
    let present_s = measurements.first().map_or(0.0, |m| settings.measurement_delay_s[*m as usize]);
    let mut tried: Vec<(f64, f64)> = Vec::new();
    let mut at = |delay: f64| -> Result<f64, DelayError> {
        let mut settings = settings.clone();
        measurements.iter().for_each(|m| settings.measurement_delay_s[*m as usize] = delay);
        let valid = settings.check().map_err(|mut errors| errors.remove(0))?;
        let value = evaluate(&valid)?;
        tried.push((delay, value));
        Ok(value)
    };
    let mut step = 2.0 * range_s / (COARSE - 1) as f64;
    let mut best = (present_s, f64::NEG_INFINITY);
    for k in 0..COARSE {
        let delay = present_s - range_s + step * k as f64;
        let value = at(delay)?;
        if value > best.1 {
            best = (delay, value);
        }
    }
    if (best.0 - present_s).abs() > range_s - 0.5 * step {
        return Err(DelayError::NoMaximum { range_s });
    }
    let mut estimate = (best.0, f64::NAN);
    for _ in 0..ROUNDS {
        let (before, middle, after) = (at(estimate.0 - step)?, at(estimate.0)?, at(estimate.0 + step)?);
        let curvature = (before - 2.0 * middle + after) / (step * step);
        if curvature >= 0.0 || curvature.is_nan() {
            return Err(DelayError::NoMaximum { range_s });
        }
        let moved = (0.5 * (before - after) / step / curvature).clamp(-step, step);
        let standard_error_s = (-curvature).sqrt().recip();
        estimate = (estimate.0 + moved, standard_error_s);
        // wide enough that rounding does not show, close enough that a parabola fits
        let next = (2.0 * FALL).sqrt() * standard_error_s;
        let is_close = moved.abs() < 0.02 * standard_error_s && (0.5..2.0).contains(&(step / next));
        if is_close {
            break;
        }
        step = next.clamp(0.1 * step, step.max(next));
    }
    tried.sort_by(|a, b| a.0.total_cmp(&b.0));
    Ok(DelayEstimate { delay_s: estimate.0, standard_error_s: estimate.1, present_s, tried })
}
