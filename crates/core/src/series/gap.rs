//! The one rule for gaps: what filters and smoothing do not bridge, no plot bridges either.

use crate::statistics::median;

/// A pause between samples counts as a gap when it is longer than this many sampling intervals and [`GAP_S`].
const GAP_INTERVALS: f64 = 3.5;
/// Shortest pause that counts as a gap, s.
const GAP_S: f64 = 0.25;
/// Intervals looked at, spread evenly, to find the typical one.
const PROBES: usize = 8192;

/// Longest interval of `time_s` that is not a gap, s: 3.5 times its median interval, 0.25 s at least.
pub fn gap_threshold_s(time_s: &[f64]) -> f64 {
    let intervals = time_s.len().saturating_sub(1);
    let stride = intervals.div_ceil(PROBES).max(1);
    let mut probes: Vec<f64> = (0..intervals).step_by(stride).map(|at| time_s[at + 1] - time_s[at]).collect();
    median(&mut probes).map_or(GAP_S, |typical| (GAP_INTERVALS * typical).max(GAP_S))
}

/// Value at `time_s` by a straight line between its neighbours; `None` outside the samples or in a gap.
pub fn value_at(time: &[f64], values: &[f64], gap_s: f64, time_s: f64) -> Option<f64> {
    let after = time.partition_point(|&t| t < time_s);
    if after == time.len() || (after == 0 && time[0] > time_s) {
        return None;
    }
    if time[after] == time_s {
        return Some(values[after]).filter(|v| v.is_finite());
    }
    let (t0, t1, v0, v1) = (time[after - 1], time[after], values[after - 1], values[after]);
    let value = v0 + (v1 - v0) * (time_s - t0) / (t1 - t0);
    (t1 - t0 <= gap_s && value.is_finite()).then_some(value)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_pause_is_a_gap_beyond_a_few_intervals_and_a_quarter_of_a_second() {
        let regular = |step_s: f64| (0..20_000).map(|k| f64::from(k) * step_s).collect::<Vec<_>>();
        assert_eq!(gap_threshold_s(&regular(0.01)), 0.25);
        assert_eq!(gap_threshold_s(&regular(1.0)), 3.5);
        assert_eq!(gap_threshold_s(&[7.0]), 0.25);
    }

    #[test]
    fn value_under_the_cursor_is_interpolated_but_never_across_a_gap() {
        let time = [0.0, 1.0, 2.0, 12.0];
        let values = [0.0, 10.0, f64::NAN, 3.0];
        assert_eq!(value_at(&time, &values, 4.5, 0.25), Some(2.5));
        assert_eq!(value_at(&time, &values, 4.5, 1.0), Some(10.0));
        assert_eq!(value_at(&time, &values, 4.5, 1.5), None);
        assert_eq!(value_at(&time, &values, 4.5, 5.0), None);
        assert_eq!(value_at(&time, &values, 4.5, 12.0), Some(3.0));
        assert_eq!(value_at(&time, &values, 4.5, 12.1), None);
        assert_eq!(value_at(&time, &values, 4.5, -0.1), None);
    }
}
