//! Findings about sensors that rest at the end of their range while the aircraft moves on.

use doublet_core::reconstruct::Input;
use doublet_core::series::Series;

use super::judge::Evidence;
use super::{Finding, Level};
use crate::session::{Fix, Manoeuvre};

/// Samples in a row at the largest or least value of the recording that count as one rest there.
const IN_A_ROW: usize = 4;
/// Rests, and samples in them, from which the sensor is at its end.
const RESTS: usize = 2;
const SAMPLES: usize = 10;
/// Distance from the end to the next value over the whole range: beyond, the sensor has few steps and rests on any.
const NEXT_VALUE: f64 = 0.01;

/// Accelerometers and gyroscopes that rest at the end of their range in a window: the one that does so longest.
pub(super) fn finding(place: &str, evidence: Evidence<'_>, manoeuvre: &Manoeuvre) -> Option<Finding> {
    let recording = &evidence.snapshot.flights.get(&manoeuvre.flight)?.ready()?.recording;
    let resting = Input::ALL.into_iter().filter_map(|input| {
        let role = input.role();
        let series = &recording.role(role)?.series;
        let inside = &series.values[manoeuvre.window.indices(&series.time_s)];
        // The whole recording is looked at only where the window stays at its own end.
        let resting = extremes(inside).into_iter().filter_map(|end| {
            let samples = inside.iter().filter(|value| **value == end).count();
            (samples >= IN_A_ROW).then_some((end, samples))
        });
        let (end, samples) =
            resting.filter(|(end, _)| rests_at_end(series, *end)).max_by_key(|(_, samples)| *samples)?;
        Some((role, end, samples))
    });
    let (role, end, samples) = resting.max_by_key(|(_, _, samples)| *samples)?;
    let text = format!("{} is saturated at {end:.4} for {samples} samples (limit {IN_A_ROW}).", role.name());
    let finding = Finding::new(Level::Caution, "saturated", place, text).with_figure(samples as f64, IN_A_ROW as f64);
    let fix_text = "Ignore the manoeuvre, fly smaller inputs, or use a wider-range sensor.";
    let fix = Fix::ignore([manoeuvre.name.as_str()]);
    Some(finding.with_fix_text(fix_text).with_setting("Flight", "window.role").with_fix(fix))
}

/// Least and largest finite value.
fn extremes(values: &[f64]) -> [f64; 2] {
    let finite = values.iter().copied().filter(|value| value.is_finite());
    finite.fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], value| [low.min(value), high.max(value)])
}

/// Whether `end` is the least or the largest value of a series, which rests there again and again.
fn rests_at_end(series: &Series, end: f64) -> bool {
    let finite = || series.values.iter().copied().filter(|value| value.is_finite());
    // mostly false after a few samples
    if finite().any(|value| value < end) && finite().any(|value| value > end) {
        return false;
    }
    let distances = finite().map(|value| (value - end).abs());
    let (nearest, farthest) = distances
        .filter(|distance| *distance > 0.0)
        .fold((f64::INFINITY, 0.0), |(nearest, farthest): (f64, f64), distance| {
            (nearest.min(distance), farthest.max(distance))
        });
    if nearest >= NEXT_VALUE * farthest {
        return false;
    }
    let rests = series.values.chunk_by(|a, b| a == b).filter(|run| run[0] == end && run.len() >= IN_A_ROW);
    let (count, samples) = rests.fold((0, 0), |(count, samples), rest| (count + 1, samples + rest.len()));
    count >= RESTS && samples >= SAMPLES
}

#[cfg(test)]
mod tests {
    use super::*;

    fn swing(limit: f64, step: f64) -> Series {
        let time_s: Vec<f64> = (0..1000).map(|k| 0.02 * f64::from(k)).collect();
        let value = |time: &f64| ((0.4 * (2.0 * time).sin() + 0.003 * (31.0 * time).sin()) / step).round() * step;
        let values = time_s.iter().map(|time| value(time).clamp(-limit, limit)).collect();
        Series { time_s: time_s.into(), values }
    }

    #[test]
    fn sensor_at_the_end_of_its_range_is_told_from_one_that_turns_and_one_of_few_steps() {
        let rests = |limit: f64, step: f64| {
            let series = swing(limit, step);
            extremes(&series.values).map(|end| rests_at_end(&series, end))
        };
        assert_eq!(rests(0.3, 1e-6), [true, true]);
        assert_eq!(rests(1.0, 1e-6), [false, false]);
        assert_eq!(rests(1.0, 0.02), [false, false]);
        assert!(!rests_at_end(&swing(0.3, 1e-6), 0.2));
        let mut with_infinite = swing(0.3, 1e-6);
        with_infinite.values = with_infinite.values.iter().copied().chain([f64::INFINITY, f64::NEG_INFINITY]).collect();
        assert!(rests_at_end(&with_infinite, 0.3) && rests_at_end(&with_infinite, -0.3));
    }
}
