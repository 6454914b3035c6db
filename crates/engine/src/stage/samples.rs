//! Samples of a role over a window, on another time base where needed, with their gaps stated.

use std::sync::Arc;

use crate::graph::StageResult;
use crate::session::Preparation;
use doublet_core::prep::{Differentiation, Interpolation, between_samples, resample};
use doublet_core::quantity::Role;
use doublet_core::series::{Channel, Recording, Series, TimeRange, gap_threshold_s};

/// Where `time_s` pauses: start and length of each pause that interpolation may not bridge.
pub fn gaps(recording: &Recording, time_s: &[f64]) -> Vec<(f64, f64)> {
    let longest = recording.max_gap_s.unwrap_or_else(|| gap_threshold_s(time_s));
    time_s.windows(2).filter(|pair| pair[1] - pair[0] > longest).map(|pair| (pair[0], pair[1] - pair[0])).collect()
}

/// Values of `role` at `time_s` by straight lines between its own samples; `None` when the recording has no such role.
pub(crate) fn values_at(recording: &Recording, role: Role, time_s: &[f64]) -> StageResult<Option<Arc<[f64]>>> {
    recording.role(role).map(|channel| channel_at(recording, channel, role.name(), time_s)).transpose()
}

/// Values of a channel of `recording` at `time_s` by straight lines between its own samples; `what` it is goes into the message.
pub(crate) fn channel_at(
    recording: &Recording,
    channel: &Channel,
    what: &str,
    time_s: &[f64],
) -> StageResult<Arc<[f64]>> {
    let (Some(&first), Some(&last)) = (time_s.first(), time_s.last()) else { return Ok(Arc::default()) };
    let step = (last - first) / (time_s.len().max(2) - 1) as f64;
    let margin_s = 5.0_f64.max(2.0 * step);
    let wide = TimeRange { start_s: first - margin_s, end_s: last + margin_s };
    let Series { time_s: own_time, values: own_values } = channel.series.within(wide).finite();
    if *own_time == *time_s {
        return Ok(own_values);
    }
    let place = format!("{what} (channel '{}' of {})", channel.name, channel.source);
    let (Some(&start), Some(&end)) = (own_time.first(), own_time.last()) else {
        return Err(format!(
            "{place} has no samples over {first:.2} s to {last:.2} s: choose a manoeuvre where it was recorded"
        )
        .into());
    };
    // Its first and last sample hold for one of its own intervals beyond them, no longer.
    let interval = (end - start) / (own_time.len().max(2) - 1) as f64;
    if start > first + interval || end < last - interval {
        return Err(format!(
            "{place} was recorded from {start:.2} s to {end:.2} s: move the manoeuvre ({first:.2} s to {last:.2} s) inside"
        ).into());
    }
    if let Some((at, length)) =
        gaps(recording, &own_time).into_iter().find(|(at, length)| *at < last && at + length > first)
    {
        return Err(format!(
            "{place} has a gap of {length:.2} s at {at:.2} s: end the manoeuvre before it or start after"
        )
        .into());
    }
    let wanted: Vec<_> = time_s.iter().map(|time| time.clamp(start, end)).collect();
    let resampled = resample(&own_time, &own_values, &wanted, Interpolation::Linear);
    Ok(resampled.map_err(|error| format!("{place}: {error}"))?.into())
}

/// Values of `role` at the increasing `time_s` by straight lines between its own samples, not a number before the first, behind
/// the last and inside a gap; `None` when the recording has no such role or no finite sample of it.
pub(crate) fn values_where_recorded(recording: &Recording, role: Role, time_s: &[f64]) -> Option<Vec<f64>> {
    let series = &recording.role(role)?.series;
    let is_recorded = series.values.iter().any(|value| value.is_finite());
    is_recorded.then(|| between_samples(series, time_s, recording.max_gap_s, false))
}

/// First and last of some times; not numbers where there are none.
pub(super) fn span(time_s: &[f64]) -> (f64, f64) {
    (time_s.first().copied().unwrap_or(f64::NAN), time_s.last().copied().unwrap_or(f64::NAN))
}

/// Longest half width of the differentiation that moves the accelerometers for the filter, s. The filter averages noise by
/// itself, and nothing gives it back what smoothing takes away.
const LONGEST_FOR_FILTER_S: f64 = 0.06;

/// The differentiation the session asks for, shortened for the filter.
pub(crate) fn short_differentiation(preparation: &Preparation, time_s: &[f64]) -> Differentiation {
    let half_width_s = preparation.differentiation_half_width_s.map(|half_width| half_width.min(LONGEST_FOR_FILTER_S));
    local_quadratic(half_width_s, time_s)
}

/// The differentiation the session asks for, in samples of `time_s`.
pub fn differentiation(preparation: &Preparation, time_s: &[f64]) -> Differentiation {
    local_quadratic(preparation.differentiation_half_width_s, time_s)
}

/// Local quadratic of a half width in samples of `time_s`; without one the central difference of order four.
fn local_quadratic(half_width_s: Option<f64>, time_s: &[f64]) -> Differentiation {
    let Some(half_width_s) = half_width_s else { return Differentiation::Central4 };
    let (first, last) = span(time_s);
    let step = (last - first) / (time_s.len().max(2) - 1) as f64;
    #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "clamped to a small positive range")]
    let half_width = (half_width_s / step).round().clamp(1.0, 1000.0) as usize;
    Differentiation::LocalPolynomial { degree: 2, half_width }
}

#[cfg(test)]
mod tests {
    use doublet_core::series::Series;

    use super::*;

    #[test]
    fn values_are_missing_outside_the_recording_and_in_its_gaps() {
        let time: Vec<f64> = [0.0, 1.0, 2.0, 3.0, 4.0, 14.0, 15.0, 16.0].into();
        let values: Vec<f64> = time.iter().map(|t| if *t == 2.0 { f64::NAN } else { 10.0 * t }).collect();
        let channel = Channel {
            source: String::new(),
            name: String::new(),
            unit: String::new(),
            series: Series { time_s: time.into(), values: values.into() },
        };
        let recording =
            Recording { channels: vec![channel], roles: [(Role::Power1, 0)].into(), ..Recording::default() };
        let at = [-0.5, 0.0, 0.5, 2.0, 3.5, 4.0, 4.5, 13.5, 14.0, 15.25, 16.0, 16.5];
        let found = values_where_recorded(&recording, Role::Power1, &at).unwrap();
        let nan = f64::NAN;
        // The sample that is not a number makes an interval of 2 s, which is no gap; that of 10 s is one.
        let expected = [nan, 0.0, 5.0, 20.0, 35.0, 40.0, nan, nan, 140.0, 152.5, 160.0, nan];
        assert_eq!(format!("{found:?}"), format!("{expected:?}"));
        assert!(values_where_recorded(&recording, Role::Power2, &at).is_none());
    }
}
