//! What is done to a recorded signal before it is used: smoothing, then resampling, never across a gap.

use std::f64::consts::{PI, TAU};
use std::sync::Arc;

use serde::{Deserialize, Serialize};

use super::control_sensors::unwrapped;
use super::{Interpolation, PrepError, Smoothing, check, resample, smooth, stretches};
use crate::series::{Series, gap_threshold_s};

/// Most samples a resampled signal may have: 14 hours at 1 kHz.
const MOST_SAMPLES: f64 = 5e7;

/// New samples at a constant rate.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Resampling {
    /// Samples per second; they lie at whole multiples of its inverse, so that all resampled signals share their stamps.
    pub rate_hz: f64,
    /// What the signal does between its own samples.
    pub interpolation: Interpolation,
}

crate::hash_fields!(Resampling { interpolation; rate_hz });

/// What is done to a signal. The default leaves it as it is.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Treatment {
    /// Smoothing, one after the other.
    pub smoothing: Vec<Smoothing>,
    /// New samples; `None` keeps its own.
    pub resampling: Option<Resampling>,
    /// Longest interval between samples that is bridged, s; `None` for a few of the signal's own.
    pub max_gap_s: Option<f64>,
    /// The signal is an angle, rad, that jumps by whole turns.
    pub wraps: bool,
}

/// A treated signal.
#[derive(Clone, Debug, PartialEq)]
pub struct Treated {
    /// Samples.
    pub series: Series,
    /// Stretches between gaps, each treated by itself.
    pub stretches: usize,
    /// Stretches too short for the smoothing, left as they were, or for the resampling, left out.
    pub short: usize,
    /// Samples that were not finite, left out.
    pub not_finite: usize,
}

/// Treats a signal stretch by stretch between its gaps. Angles that jump by whole turns are followed through the jumps and
/// brought back to their range (-pi to pi, or 0 to 2 pi where nothing is negative).
///
/// # Errors
/// Lengths that differ, time that does not increase, settings out of range.
pub fn treat(series: &Series, treatment: &Treatment) -> Result<Treated, PrepError> {
    check(&series.time_s, &series.values, "a treatment", 0)?;
    if let Some(value) = treatment.max_gap_s.filter(|gap| gap.is_nan() || *gap <= 0.0) {
        return Err(PrepError::Setting { setting: "max_gap_s", value, allowed: "above zero, s" });
    }
    let Series { time_s: time, values } = series.finite();
    if let Some(Resampling { rate_hz, .. }) = treatment.resampling {
        let span_s = time.last().copied().unwrap_or(0.0) - time.first().copied().unwrap_or(0.0);
        if !(rate_hz > 0.0 && rate_hz * span_s <= MOST_SAMPLES) {
            let allowed = "above zero and at most 50 million samples over the recording, Hz";
            return Err(PrepError::Setting { setting: "resample_hz", value: rate_hz, allowed });
        }
    }
    let all_positive = values.iter().all(|&value| value >= 0.0);
    let longest = treatment.max_gap_s.unwrap_or_else(|| gap_threshold_s(&time));
    let ranges = stretches(&time, longest);
    let (mut short, mut new_time, mut new_values) = (0, Vec::new(), Vec::new());
    for range in &ranges {
        let own = &time[range.clone()];
        let mut piece = values[range.clone()].to_vec();
        if treatment.wraps {
            piece = unwrapped(&piece);
        }
        let mut untouched = false;
        for &method in &treatment.smoothing {
            match smooth(own, &piece, method) {
                Ok(smoothed) => piece = smoothed,
                Err(PrepError::TooFewSamples { .. }) => untouched = true,
                Err(error) => return Err(error),
            }
        }
        match treatment.resampling {
            None => {
                new_time.extend_from_slice(own);
                new_values.extend(piece);
            }
            Some(resampling) => {
                let at = grid(own, resampling.rate_hz);
                untouched |= at.is_empty();
                match resample(own, &piece, &at, resampling.interpolation) {
                    Ok(found) => {
                        new_time.extend(at);
                        new_values.extend(found);
                    }
                    Err(PrepError::TooFewSamples { .. }) => untouched = true,
                    Err(error) => return Err(error),
                }
            }
        }
        short += usize::from(untouched);
    }
    if treatment.wraps {
        let lowest = if all_positive { 0.0 } else { -PI };
        new_values.iter_mut().for_each(|value| *value = lowest + (*value - lowest).rem_euclid(TAU));
    }
    Ok(Treated {
        not_finite: series.values.len() - values.len(),
        series: Series { time_s: Arc::from(new_time), values: Arc::from(new_values) },
        stretches: ranges.len(),
        short,
    })
}

/// Whole multiples of the inverse of a rate within the times of a stretch.
fn grid(time_s: &[f64], rate_hz: f64) -> Vec<f64> {
    let (Some(&first), Some(&last)) = (time_s.first(), time_s.last()) else { return Vec::new() };
    #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "bounded by the check of the rate")]
    let count = ((last - first) * rate_hz).floor().max(0.0) as usize + 1;
    let start = (first * rate_hz).ceil();
    let mut at: Vec<f64> = (0..=count).map(|k| (start + k as f64) / rate_hz).collect();
    at.retain(|time| (first..=last).contains(time));
    at.dedup();
    at
}

#[cfg(test)]
mod tests {
    use super::*;

    fn series(time: &[f64], value: impl Fn(f64) -> f64) -> Series {
        Series { time_s: time.into(), values: time.iter().map(|&t| value(t)).collect() }
    }

    #[test]
    fn resampling_keeps_to_the_stretches_between_gaps() {
        let time: Vec<f64> = (0..50).chain(100..103).map(|k| 0.005 + 0.02 * f64::from(k)).collect();
        let line = series(&time, |t| 3.0 * t - 1.0);
        let resampling = Some(Resampling { rate_hz: 100.0, interpolation: Interpolation::QuadraticSpline });
        let treatment = Treatment { resampling, ..Treatment::default() };
        let found = treat(&line, &treatment).unwrap();
        assert_eq!((found.stretches, found.short), (2, 0));
        // From 0.01 to 0.98 s and from 2.01 to 2.04 s, nothing in between.
        assert_eq!(found.series.time_s.len(), 98 + 4);
        assert!(found.series.time_s.iter().all(|t| !(0.985..2.005).contains(t)));
        for (t, value) in found.series.time_s.iter().zip(&*found.series.values) {
            approx::assert_relative_eq!(*value, 3.0 * t - 1.0, epsilon = 1e-12);
        }
        // A stated limit above the pause bridges it; one below the interval leaves nothing to interpolate.
        let bridged = treat(&line, &Treatment { max_gap_s: Some(2.0), ..treatment.clone() }).unwrap();
        assert_eq!((bridged.stretches, bridged.series.time_s.len()), (1, 204));
        let torn = treat(&line, &Treatment { max_gap_s: Some(0.01), ..treatment }).unwrap();
        assert_eq!((torn.short, torn.series.time_s.len()), (53, 0));
    }

    #[test]
    fn smoothing_in_steps_is_that_of_each_step_and_leaves_short_stretches() {
        let time: Vec<f64> = (0..60).chain(200..205).map(|k| 0.02 * f64::from(k)).collect();
        let wave = series(&time, |t| (40.0 * t).sin());
        let steps = [Smoothing::MovingAverage { width: 4 }, Smoothing::LocalPolynomial { degree: 2, half_width: 5 }];
        let found = treat(&wave, &Treatment { smoothing: steps.to_vec(), ..Treatment::default() }).unwrap();
        let first = smooth(&time[..60], &wave.values[..60], steps[0]).unwrap();
        let both = smooth(&time[..60], &first, steps[1]).unwrap();
        assert_eq!(found.series.values[..60], both[..]);
        assert_eq!((found.short, found.series.time_s.len()), (1, 65));
    }

    #[test]
    fn a_heading_through_north_is_followed() {
        let time: Vec<f64> = (0..40).map(|k| 0.1 * f64::from(k)).collect();
        let heading = series(&time, |t| (6.0 + 0.2 * t).rem_euclid(TAU));
        let resampling = Some(Resampling { rate_hz: 50.0, interpolation: Interpolation::Linear });
        let treatment = Treatment { resampling, wraps: true, ..Treatment::default() };
        let found = treat(&heading, &treatment).unwrap().series;
        for (t, value) in found.time_s.iter().zip(&*found.values) {
            let error = (value - 6.0 - 0.2 * t + PI).rem_euclid(TAU) - PI;
            assert!(error.abs() < 1e-12 && (0.0..TAU).contains(value), "{value} at {t}");
        }
    }

    #[test]
    fn treatment_refuses_rates_that_fill_the_memory_and_counts_what_is_not_finite() {
        let two = Series { time_s: [0.0, 1e9].into(), values: [0.0, 1.0].into() };
        let resampling = Some(Resampling { rate_hz: 100.0, interpolation: Interpolation::Linear });
        let treatment = Treatment { resampling, max_gap_s: Some(1e12), ..Treatment::default() };
        assert!(matches!(treat(&two, &treatment), Err(PrepError::Setting { setting: "resample_hz", .. })));
        let spotted = Series { time_s: [0.0, 1.0, 2.0].into(), values: [0.0, f64::NAN, 1.0].into() };
        assert_eq!(treat(&spotted, &Treatment::default()).unwrap().not_finite, 1);
    }
}
