//! Deflections of a control about its resting place, and the inputs in them.

use std::ops::Range;

use super::manoeuvres::ManoeuvreSettings;
use super::pulses::{Excursion, excursions};
use super::stretches;
use crate::quantity::Role;
use crate::series::{Series, TimeRange};
use crate::statistics;

/// Excursions lower than this share of an input's highest are overshoot of the hand, or the motion of a control that is never at rest.
pub(super) const OVERSHOOT: f64 = 0.35;

/// One surface's deflection and where it left its resting place.
pub(super) struct Activity<'a> {
    pub surface: Role,
    pub time: &'a [f64],
    pub deviation: Vec<f64>,
    pub stretches: Vec<Range<usize>>,
    /// Noise of each stretch, rad.
    noise: Vec<f64>,
    pub excursions: Vec<Excursion>,
}

pub(super) fn activity<'a>(surface: Role, series: &'a Series, settings: &ManoeuvreSettings) -> Activity<'a> {
    let time = &series.time_s[..];
    let stretches = stretches(time, settings.max_gap_s);
    let mut deviation = vec![0.0; time.len()];
    let (mut found, mut noise) = (Vec::new(), Vec::new());
    for range in &stretches {
        let values = &series.values[range.clone()];
        let resting = resting_place(&time[range.clone()], values, settings.resting_s);
        for ((slot, value), rest) in deviation[range.clone()].iter_mut().zip(values).zip(resting) {
            *slot = if value.is_finite() { value - rest } else { 0.0 };
        }
        found.extend(excursions(&deviation, range.clone(), 0.5 * settings.least_amplitude_rad));
        noise.push(median_step(&deviation[range.clone()]));
    }
    Activity { surface, time, deviation, stretches, noise, excursions: found }
}

/// Median step from sample to sample: 0.95 of the standard deviation of white noise.
fn median_step(deviation: &[f64]) -> f64 {
    let mut steps: Vec<f64> = deviation.windows(2).map(|pair| (pair[1] - pair[0]).abs()).collect();
    statistics::median(&mut steps).unwrap_or(0.0)
}

/// Moving median, worked out every twentieth of its length and joined by straight lines; one median where the stretch is not
/// twice as long.
fn resting_place(time: &[f64], values: &[f64], length_s: f64) -> Vec<f64> {
    let median = |range: Range<usize>| {
        let mut inside: Vec<f64> = values[range].iter().copied().filter(|value| value.is_finite()).collect();
        statistics::median(&mut inside).unwrap_or(0.0)
    };
    let (start, end) = (time[0], time[time.len() - 1]);
    if end - start < 2.0 * length_s {
        return vec![median(0..time.len()); time.len()];
    }
    let step = length_s / 20.0;
    let count = ((end - start) / step).floor() as usize;
    let knots: Vec<f64> = (0..=count)
        .map(|k| {
            // The whole length everywhere: near the ends the nearest one.
            let from = (start + k as f64 * step - 0.5 * length_s).clamp(start, end - length_s);
            median(TimeRange { start_s: from, end_s: from + length_s }.indices(time))
        })
        .collect();
    time.iter()
        .map(|t| {
            let place = ((t - start) / step).min(count as f64);
            let left = (place as usize).min(count - 1);
            knots[left] + (knots[left + 1] - knots[left]) * (place - left as f64)
        })
        .collect()
}

/// Excursions of one input and whether the control rested before them.
///
/// Consecutive excursions without a pause within one stretch belong together. Where that is longer than an input can be, the control never
/// rests (it is stabilised, or flown in gusts): it is cut where the deflection stays below [`OVERSHOOT`] of the highest for [`BETWEEN_S`].
/// Rest is relative to the input for the same reason. Many pulses go on after a short pause. What came before a stretch is unknown: its
/// first input counts as rested.
pub(super) fn inputs<'a>(activity: &'a Activity<'_>, settings: &ManoeuvreSettings) -> Vec<(&'a [Excursion], bool)> {
    let all = &activity.excursions[..];
    let follows = |k: usize| all[k].stretch == all[k - 1].stretch && activity.pause_s(k - 1, k) <= settings.join_s;
    let mut found: Vec<Input> = Vec::new();
    let mut from = 0;
    for k in 1..=all.len() {
        if k < all.len() && follows(k) {
            continue;
        }
        for input in cut(activity, from..k, settings) {
            let rested = activity.rested(&input, settings.rest_s);
            match found.last_mut().filter(|before| !rested && continues(activity, before, &input, settings)) {
                Some(before) => {
                    (before.last, before.strong) = (input.last, before.strong + input.strong);
                    before.highest = before.highest.max(input.highest);
                }
                None => found.push(Input { rested, ..input }),
            }
        }
        from = k;
    }
    found.into_iter().map(|input| (&all[input.first..=input.last], input.rested)).collect()
}

/// Weaker motion for longer than this separates two inputs of a control that never rests, s.
const BETWEEN_S: f64 = 3.0;

/// Excursions from `first` to `last` of an activity.
struct Input {
    first: usize,
    last: usize,
    /// How many reach [`OVERSHOOT`] of the highest.
    strong: usize,
    /// Greatest deflection, rad.
    highest: f64,
    rested: bool,
}

/// Excursions without a pause as inputs, weak ones left out at both ends.
fn cut(activity: &Activity<'_>, chain: Range<usize>, settings: &ManoeuvreSettings) -> Vec<Input> {
    /// Longest input relative to the moving median, which is at least twice as long as the inputs it was set for.
    const LONGEST: f64 = 1.25;
    let all = &activity.excursions[..];
    let never_rests = -activity.pause_s(chain.end - 1, chain.start) > LONGEST * settings.resting_s;
    let least = OVERSHOOT * highest(&all[chain.clone()]);
    let mut found: Vec<Input> = Vec::new();
    for k in chain.filter(|&k| all[k].amplitude.abs() >= least) {
        let height = all[k].amplitude.abs();
        match found.last_mut().filter(|input| !never_rests || activity.pause_s(input.last, k) <= BETWEEN_S) {
            Some(input) => {
                (input.last, input.strong, input.highest) = (k, input.strong + 1, input.highest.max(height));
            }
            None => found.push(Input { first: k, last: k, strong: 1, highest: height, rested: true }),
        }
    }
    found
}

/// Whether an unrested input is the rest of the many pulses before it.
fn continues(activity: &Activity<'_>, before: &Input, input: &Input, settings: &ManoeuvreSettings) -> bool {
    /// More pulses than a 3-2-1-1 has.
    const MANY: usize = 5;
    let all = &activity.excursions[..];
    before.strong >= MANY
        && all[before.last].stretch == all[input.first].stretch
        && activity.pause_s(before.last, input.first) < settings.rest_s
        && input.highest >= 0.5 * before.highest
}

/// Greatest deflection of excursions, rad.
pub(super) fn highest(excursions: &[Excursion]) -> f64 {
    excursions.iter().map(|excursion| excursion.amplitude.abs()).fold(0.0, f64::max)
}

/// First movement and return of an input, s: where the control leaves and meets its resting place to a twentieth of its
/// highest deflection or four times its noise.
pub(super) fn ends(activity: &Activity<'_>, first: &Excursion, last: &Excursion, highest: f64) -> (f64, f64) {
    let (start, end) = first.stretch;
    let stretch = activity.stretches.partition_point(|range| range.end < end);
    let noise = activity.noise.get(stretch).copied().unwrap_or(0.0);
    let rest = (0.05 * highest).max(4.0 * noise);
    let resting = |&k: &usize| activity.deviation[k].abs() <= rest;
    let before = (start..first.samples.start).rev().find(resting).unwrap_or(first.samples.start);
    let after = (last.samples.end..end).find(resting).unwrap_or(last.samples.end - 1);
    (activity.time[before], activity.time[after])
}

impl Activity<'_> {
    /// Greatest deviation between two times, rad.
    pub(super) fn greatest(&self, start_s: f64, end_s: f64) -> f64 {
        let inside = TimeRange { start_s, end_s }.indices(self.time);
        self.deviation[inside].iter().map(|value| value.abs()).fold(0.0, f64::max)
    }
    /// Time from the end of one excursion to the start of another, s.
    fn pause_s(&self, before: usize, after: usize) -> f64 {
        self.time[self.excursions[after].samples.start] - self.time[self.excursions[before].samples.end - 1]
    }

    /// Whether the control rested before an input: stayed below [`OVERSHOOT`] of its highest for `rest_s`.
    fn rested(&self, input: &Input, rest_s: f64) -> bool {
        let least = OVERSHOOT * input.highest;
        let same = |k: &usize| self.excursions[*k].stretch == self.excursions[input.first].stretch;
        let before = (0..input.first).rev().take_while(same).find(|&k| self.excursions[k].amplitude.abs() >= least);
        before.is_none_or(|before| self.pause_s(before, input.first) >= rest_s)
    }
}
