//! Findings about sensors that rest at the end of their range while the aircraft moves on.

use std::ops::Range;

use doublet_core::message;
use doublet_core::reconstruct::Input;
use doublet_core::series::{Series, TimeRange};

use super::judge::Evidence;
use super::{Finding, Level, spoilt};
use crate::session::{Manoeuvre, Place};
use crate::snapshot::Snapshot;
use crate::stage::LoadedFlight;

/// Samples in a row at the largest or least value of the recording that count as one rest there.
const IN_A_ROW: usize = 4;
/// Rests, and samples in them, from which the sensor is at its end.
const RESTS: usize = 2;
const SAMPLES: usize = 10;
/// Distance from the end to the next value over the whole range: beyond, the sensor has few steps and rests on any.
const NEXT_VALUE: f64 = 0.01;

/// A sensor that rests at an end of its range in a manoeuvre.
pub(super) struct Rest {
    pub(super) input: Input,
    end: f64,
    samples: usize,
    /// From first to last sample of each rest, at either end.
    pub(super) parts: Vec<TimeRange>,
}

/// The accelerometers and gyroscopes that rest at the end of their range in a manoeuvre, outside its excluded parts.
pub(super) fn rests(snapshot: &Snapshot, manoeuvre: &Manoeuvre) -> Vec<Rest> {
    let Some(flight) = snapshot.flights.get(&manoeuvre.flight).and_then(|slot| slot.ready()) else { return Vec::new() };
    Input::ALL.into_iter().filter_map(|input| longest_rest(flight, manoeuvre, input)).collect()
}

fn longest_rest(flight: &LoadedFlight, manoeuvre: &Manoeuvre, input: Input) -> Option<Rest> {
    let series = &flight.recording.role(input.role())?.series;
    let inside = manoeuvre.window.indices(&series.time_s);
    // The whole recording is looked at only where the window stays at its own end.
    let ends = extremes(&series.values[inside.clone()]).into_iter().filter_map(|end| {
        let (samples, parts) = at_end(series, inside.clone(), manoeuvre, end);
        (samples >= IN_A_ROW).then_some(Rest { input, end, samples, parts })
    });
    let ends: Vec<Rest> = ends.filter(|rest| rests_at_end(series, rest.end)).collect();
    let parts = ends.iter().flat_map(|rest| rest.parts.iter().copied()).collect();
    ends.into_iter().max_by_key(|rest| rest.samples).map(|longest| Rest { parts, ..longest })
}

/// How many samples at `end` are not excluded, and where they are.
fn at_end(series: &Series, inside: Range<usize>, manoeuvre: &Manoeuvre, end: f64) -> (usize, Vec<TimeRange>) {
    let is_left =
        |index: &usize| series.values[*index] == end && manoeuvre.excluded_at(series.time_s[*index]).is_none();
    let indices: Vec<usize> = inside.filter(is_left).collect();
    let parts = indices.chunk_by(|a, b| a + 1 == *b);
    let part = |run: &[usize]| TimeRange { start_s: series.time_s[run[0]], end_s: series.time_s[run[run.len() - 1]] };
    (indices.len(), parts.map(part).collect())
}

/// The sensor that rests longest at the end of its range in a manoeuvre.
pub(super) fn finding(place: &Place, evidence: Evidence<'_>, manoeuvre: &Manoeuvre) -> Option<Finding> {
    let Rest { input, end, samples, .. } =
        rests(evidence.snapshot, manoeuvre).into_iter().max_by_key(|rest| rest.samples)?;
    let text =
        message!("{} is saturated at {:.4} for {} samples (limit {}).", input.role().name(), end, samples, IN_A_ROW);
    let finding = Finding::new(Level::Caution, "saturated", place, text).with_figure(samples as f64, IN_A_ROW as f64);
    let fix_text = "Exclude these samples, use smaller inputs, or use a wider-range sensor.";
    let finding = finding.with_fix_text(fix_text).with_setting("Manoeuvres", "manoeuvre.exclude");
    Some(finding.with_fix(spoilt::fix(evidence, manoeuvre)))
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
