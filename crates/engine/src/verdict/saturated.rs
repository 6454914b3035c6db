//! Findings about sensors that rest at the end of their range while the aircraft moves on.

use doublet_core::reconstruct::Input;
use doublet_core::series::Series;

use super::judge::Evidence;
use super::{Finding, Level};
use crate::session::Manoeuvre;

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
        // The ends of the whole recording are looked for only where the window stays at its own.
        let resting = extremes(inside).into_iter().filter_map(|end| {
            let samples = inside.iter().filter(|value| **value == end).count();
            (samples >= IN_A_ROW).then_some((end, samples))
        });
        let (end, samples) =
            resting.filter(|(end, _)| ends(series).contains(end)).max_by_key(|(_, samples)| *samples)?;
        Some((role, end, samples))
    });
    let (role, end, samples) = resting.max_by_key(|(_, _, samples)| *samples)?;
    let text = format!(
        "{} rests at {end:.4}, the end of what was recorded of it, for {samples} samples (limit {IN_A_ROW}): the sensor is at the end of its \
         range and the motion went on",
        role.name()
    );
    let finding = Finding::new(Level::Caution, "saturated", place, text).with_figure(samples as f64, IN_A_ROW as f64);
    let cure = "leave the window out, or move less; a sensor of a wider range is wanted";
    Some(finding.with_cure(cure).with_setting("Flight", "window.role"))
}

/// Least and largest finite value.
fn extremes(values: &[f64]) -> [f64; 2] {
    let finite = values.iter().copied().filter(|value| value.is_finite());
    finite.fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], value| [low.min(value), high.max(value)])
}

/// Least and largest value of a series, where it rests there again and again.
fn ends(series: &Series) -> Vec<f64> {
    let finite = || series.values.iter().copied().filter(|value| value.is_finite());
    let [low, high] = extremes(&series.values);
    let next_low = finite().filter(|value| *value > low).fold(f64::INFINITY, f64::min);
    let next_high = finite().filter(|value| *value < high).fold(f64::NEG_INFINITY, f64::max);
    let near = |end: f64, next: f64| (end - next).abs() < NEXT_VALUE * (high - low);
    let rests = |end: f64| {
        let runs = series.values.chunk_by(|a, b| a == b).filter(|run| run[0] == end && run.len() >= IN_A_ROW);
        let (count, samples) = runs.fold((0, 0), |(count, samples), run| (count + 1, samples + run.len()));
        count >= RESTS && samples >= SAMPLES
    };
    [(low, next_low), (high, next_high)]
        .into_iter()
        .filter(|(end, next)| near(*end, *next) && rests(*end))
        .map(|(end, _)| end)
        .collect()
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
        assert_eq!(ends(&swing(0.3, 1e-6)), [-0.3, 0.3]);
        assert_eq!(ends(&swing(1.0, 1e-6)), [0.0; 0]);
        assert_eq!(ends(&swing(1.0, 0.02)), [0.0; 0]);
    }
}
