//! Identification manoeuvres found from the controls: when, on which surface, of which shape.

use std::ops::Range;

use super::pulses::{Excursion, excursions, half_crossing};
use super::{PrepError, check, stretches};
use crate::quantity::Role;
use crate::series::{Series, Window};

/// Shape of a control input.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum ManoeuvreShape {
    /// Two pulses of one length to either side.
    Doublet,
    /// Four alternating pulses whose lengths are as 3, 2, 1, 1.
    ThreeTwoOneOne,
    /// One pulse.
    Pulse,
    /// One deflection that stays.
    Step,
    /// None of these.
    Irregular,
}

impl ManoeuvreShape {
    /// Name in tables and files.
    pub fn name(self) -> &'static str {
        match self {
            Self::Doublet => "doublet",
            Self::ThreeTwoOneOne => "3-2-1-1",
            Self::Pulse => "pulse",
            Self::Step => "step",
            Self::Irregular => "irregular",
        }
    }
}

/// One deflection to one side.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Pulse {
    /// Where it passes half its height, or half way from the pulse before, s.
    pub start_s: f64,
    /// Where it falls to half its height, or half way to the pulse after, s.
    pub end_s: f64,
    /// Mean of its upper half, with its sign, rad.
    pub amplitude_rad: f64,
}

/// A manoeuvre.
#[derive(Clone, Debug, PartialEq)]
pub struct Manoeuvre {
    /// Surface: aileron, elevator or rudder.
    pub surface: Role,
    /// Shape.
    pub shape: ManoeuvreShape,
    /// From the lead-in to the end of the free response, s.
    pub window: Window,
    /// First movement of the control, s.
    pub onset_s: f64,
    /// Return of the control, s.
    pub input_end_s: f64,
    /// Length of the shortest ideal pulse, s.
    pub base_time_s: f64,
    /// Amplitude with the sign of the first pulse, rad.
    pub amplitude_rad: f64,
    /// Pulses in order.
    pub pulses: Vec<Pulse>,
    /// From 0 to 1: how near the shape is to the ideal, and how still the other surfaces were.
    pub confidence: f64,
}

/// How manoeuvres are looked for.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ManoeuvreSettings {
    /// Least deflection from the control's own resting place, rad.
    pub least_amplitude_rad: f64,
    /// Length of the moving median that gives the resting place, s; at least twice the longest input.
    pub resting_s: f64,
    /// Longest pause between pulses of one input, s.
    pub join_s: f64,
    /// The control must rest this long before the input, and be recorded this long after it, s.
    pub rest_s: f64,
    /// A single pulse from this length on is a step, s.
    pub step_s: f64,
    /// Window before the onset, s; the thesis flies 2 to 3 s steadily (section 4.4.1).
    pub lead_in_s: f64,
    /// Longest free response after the input, s.
    pub max_free_s: f64,
    /// The motion has died down where the rate stays below this share of its greatest.
    pub settled_share: f64,
    /// Less confident findings are left out.
    pub min_confidence: f64,
    /// Longest interval between samples that is no gap, s.
    pub max_gap_s: f64,
}

impl Default for ManoeuvreSettings {
    /// 0.5 deg; median over 20 s; pause 0.6 s; rest 1 s; step from 3 s; 3 s before and up to 10 s after; settled at a tenth;
    /// confidence 0.2; gaps from 0.5 s.
    fn default() -> Self {
        Self {
            least_amplitude_rad: 0.5f64.to_radians(),
            resting_s: 20.0,
            join_s: 0.6,
            rest_s: 1.0,
            step_s: 3.0,
            lead_in_s: 3.0,
            max_free_s: 10.0,
            settled_share: 0.1,
            min_confidence: 0.2,
            max_gap_s: 0.5,
        }
    }
}

/// One surface's deflection and where it left its resting place.
struct Activity<'a> {
    surface: Role,
    time: &'a [f64],
    deviation: Vec<f64>,
    stretches: Vec<Range<usize>>,
    excursions: Vec<Excursion>,
}

/// Manoeuvres in the deflections of aileron, elevator and rudder (rad), in order of time.
///
/// Each control's deviation from its own resting place (a moving median, so that trim and drift do not matter) is cut into
/// excursions beyond half the least amplitude; excursions that follow each other closely after a rest are one input. Its
/// pulses, bounded where they pass half their height, are compared with the ideal lengths of each shape:
/// `e = rms(d_i / (T p_i) - 1)` with the base time `T` of least squares. The confidence is
/// `1 / (1 + (e / 0.4)^2) / (1 + (s / 0.6)^2) / (1 + (o / 0.5)^2)` with the relative spread `s` of the amplitudes and the greatest
/// deviation `o` of another surface relative to this one's. Of inputs that overlap, the most confident is kept. `responses` are
/// the body rates (rad/s) that tell the end of the free response: roll for aileron, pitch for elevator, yaw for rudder; without
/// one it lasts until a control moves, or the longest allowed.
///
/// # Errors
/// Lengths that differ, time that does not increase, a least amplitude that is not above zero, a resting time below 1 s.
pub fn find_manoeuvres(
    controls: &[(Role, &Series)],
    responses: &[(Role, &Series)],
    settings: &ManoeuvreSettings,
) -> Result<Vec<Manoeuvre>, PrepError> {
    /// Shortest moving median, s.
    const SHORTEST_S: f64 = 1.0;
    let (least, resting) = (settings.least_amplitude_rad, settings.resting_s);
    if !(least > 0.0 && least.is_finite()) {
        let setting = "least_amplitude_rad";
        return Err(PrepError::Setting { setting, value: least, allowed: "finite and above zero" });
    }
    if !(resting >= SHORTEST_S && resting.is_finite()) {
        return Err(PrepError::Setting { setting: "resting_s", value: resting, allowed: "finite, at least 1 s" });
    }
    let mut activities = Vec::with_capacity(controls.len());
    for (surface, series) in controls {
        check(&series.time_s, &series.values, "the search for manoeuvres", 1)?;
        activities.push(activity(*surface, series, settings));
    }
    let mut found = Vec::new();
    for (index, activity) in activities.iter().enumerate() {
        for input in inputs(activity, settings) {
            let others = activities.iter().enumerate().filter(|(other, _)| *other != index).map(|(_, other)| other);
            found.extend(manoeuvre(activity, input, others, settings));
        }
    }
    found.sort_by(|a, b| b.confidence.total_cmp(&a.confidence));
    let mut kept: Vec<Manoeuvre> = Vec::new();
    for candidate in found {
        let apart = |other: &Manoeuvre| candidate.input_end_s < other.onset_s || other.input_end_s < candidate.onset_s;
        if kept.iter().all(apart) {
            kept.push(candidate);
        }
    }
    kept.sort_by(|a, b| a.onset_s.total_cmp(&b.onset_s));
    for k in 0..kept.len() {
        let next = kept.get(k + 1).map_or(f64::INFINITY, |next| next.onset_s);
        let window = window(&kept[k], next, &activities, responses, settings);
        kept[k].window = window;
    }
    Ok(kept)
}

fn activity<'a>(surface: Role, series: &'a Series, settings: &ManoeuvreSettings) -> Activity<'a> {
    let time = &series.time_s[..];
    let stretches = stretches(time, settings.max_gap_s);
    let mut deviation = vec![0.0; time.len()];
    let mut found = Vec::new();
    for range in &stretches {
        let values = &series.values[range.clone()];
        let resting = resting_place(&time[range.clone()], values, settings.resting_s);
        for ((slot, value), rest) in deviation[range.clone()].iter_mut().zip(values).zip(resting) {
            *slot = if value.is_finite() { value - rest } else { 0.0 };
        }
        found.extend(excursions(&deviation, range.clone(), 0.5 * settings.least_amplitude_rad));
    }
    Activity { surface, time, deviation, stretches, excursions: found }
}

/// Moving median, worked out every twentieth of its length and joined by straight lines; one median where the stretch is not
/// twice as long.
fn resting_place(time: &[f64], values: &[f64], length_s: f64) -> Vec<f64> {
    let median = |range: Range<usize>| {
        let mut inside: Vec<f64> = values[range].iter().copied().filter(|value| value.is_finite()).collect();
        let middle = inside.len() / 2;
        if inside.is_empty() { 0.0 } else { *inside.select_nth_unstable_by(middle, f64::total_cmp).1 }
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
            median(Window { start_s: from, end_s: from + length_s }.indices(time))
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

/// Excursions of one input: consecutive ones without a pause, after a rest and within one stretch.
fn inputs<'a>(activity: &'a Activity<'_>, settings: &ManoeuvreSettings) -> Vec<&'a [Excursion]> {
    let (time, all) = (activity.time, &activity.excursions[..]);
    let mut found = Vec::new();
    let mut from = 0;
    for k in 1..=all.len() {
        let joined = k < all.len()
            && all[k].stretch == all[k - 1].stretch
            && time[all[k].samples.start] - time[all[k - 1].samples.end - 1] <= settings.join_s;
        if joined {
            continue;
        }
        let group = &all[from..k];
        let start = time[group[0].samples.start];
        let rested_since = match all[..from].last() {
            Some(before) if before.stretch == group[0].stretch => time[before.samples.end - 1],
            _ => time[group[0].stretch.0],
        };
        if start - rested_since >= settings.rest_s {
            found.push(group);
        }
        from = k;
    }
    found
}

/// The manoeuvre an input is, if it is large and like enough.
fn manoeuvre<'a>(
    activity: &Activity<'_>,
    input: &[Excursion],
    others: impl Iterator<Item = &'a Activity<'a>>,
    settings: &ManoeuvreSettings,
) -> Option<Manoeuvre> {
    /// Pulses lower than this share of the highest are the hand's overshoot.
    const OVERSHOOT: f64 = 0.35;
    let highest = input.iter().map(|excursion| excursion.amplitude.abs()).fold(0.0, f64::max);
    if highest < settings.least_amplitude_rad {
        return None;
    }
    let main: Vec<&Excursion> = input.iter().filter(|e| e.amplitude.abs() >= OVERSHOOT * highest).collect();
    let (first, last) = (main.first()?, main.last()?);
    let (time, deviation) = (activity.time, &activity.deviation[..]);
    // The hand that takes over again at the end of a recording is no input.
    let unfinished = time[last.stretch.1 - 1] - time[last.samples.end - 1] < settings.rest_s;
    let mut bounds = vec![half_crossing(time, deviation, first, true)];
    bounds.extend(main.windows(2).map(|pair| 0.5 * (time[pair[0].samples.end - 1] + time[pair[1].samples.start])));
    bounds.push(half_crossing(time, deviation, last, false));
    let pulses: Vec<Pulse> = main
        .iter()
        .zip(bounds.windows(2))
        .map(|(e, bound)| Pulse { start_s: bound[0], end_s: bound[1], amplitude_rad: e.amplitude })
        .collect();
    let (shape, base_time_s, error) = shape(&pulses, settings.step_s);
    if unfinished && shape != ManoeuvreShape::Step {
        return None;
    }
    let (onset_s, input_end_s) = ends(activity, first, last, highest);
    let mean = pulses.iter().map(|pulse| pulse.amplitude_rad.abs()).sum::<f64>() / pulses.len() as f64;
    let variance =
        pulses.iter().map(|pulse| (pulse.amplitude_rad.abs() - mean).powi(2)).sum::<f64>() / pulses.len() as f64;
    let other = others.map(|other| other.greatest(onset_s, input_end_s)).fold(0.0, f64::max) / highest;
    let factor = |value: f64, scale: f64| 1.0 / (1.0 + (value / scale).powi(2));
    let confidence = factor(error, 0.4) * factor(variance.sqrt() / mean, 0.6) * factor(other, 0.5);
    let manoeuvre = Manoeuvre {
        surface: activity.surface,
        shape,
        window: Window { start_s: onset_s, end_s: input_end_s },
        onset_s,
        input_end_s,
        base_time_s,
        amplitude_rad: mean.copysign(first.amplitude),
        pulses,
        confidence,
    };
    (confidence >= settings.min_confidence).then_some(manoeuvre)
}

/// Shape whose ideal lengths are nearest, its base time (s) and the relative error of the lengths.
fn shape(pulses: &[Pulse], step_s: f64) -> (ManoeuvreShape, f64, f64) {
    /// Lengths further from the ideal than this are no such shape: half of their own length.
    const LIKE: f64 = 0.5;
    let alternating = pulses.windows(2).all(|pair| pair[0].amplitude_rad * pair[1].amplitude_rad < 0.0);
    let lengths: Vec<f64> = pulses.iter().map(|pulse| pulse.end_s - pulse.start_s).collect();
    let (named, ideal): (ManoeuvreShape, &[f64]) = match lengths[..] {
        [length] if length >= step_s => return (ManoeuvreShape::Step, length, 0.0),
        [length] => return (ManoeuvreShape::Pulse, length, 0.0),
        [_, _] if alternating => (ManoeuvreShape::Doublet, &[1.0, 1.0]),
        [_, _, _, _] if alternating => (ManoeuvreShape::ThreeTwoOneOne, &[3.0, 2.0, 1.0, 1.0]),
        _ => (ManoeuvreShape::Irregular, &[]),
    };
    let mean = lengths.iter().sum::<f64>() / lengths.len() as f64;
    if ideal.is_empty() {
        return (named, mean, LIKE);
    }
    let square: f64 = ideal.iter().map(|p| p * p).sum();
    let base = lengths.iter().zip(ideal).map(|(d, p)| d * p).sum::<f64>() / square;
    let errors = lengths.iter().zip(ideal).map(|(d, p)| (d / (base * p) - 1.0).powi(2));
    let error = (errors.sum::<f64>() / lengths.len() as f64).sqrt();
    if error > LIKE { (ManoeuvreShape::Irregular, mean, error) } else { (named, base, error) }
}

/// First movement and return of an input, s: where the control leaves and meets its resting place to a twentieth of its
/// highest deflection or four times its noise.
fn ends(activity: &Activity<'_>, first: &Excursion, last: &Excursion, highest: f64) -> (f64, f64) {
    let (start, end) = first.stretch;
    let mut steps: Vec<f64> = activity.deviation[start..end].windows(2).map(|pair| (pair[1] - pair[0]).abs()).collect();
    let middle = steps.len() / 2;
    // The median step of white noise is 0.95 of its standard deviation.
    let noise = if steps.is_empty() { 0.0 } else { *steps.select_nth_unstable_by(middle, f64::total_cmp).1 };
    let rest = (0.05 * highest).max(4.0 * noise);
    let resting = |&k: &usize| activity.deviation[k].abs() <= rest;
    let before = (start..first.samples.start).rev().find(resting).unwrap_or(first.samples.start);
    let after = (last.samples.end..end).find(resting).unwrap_or(last.samples.end - 1);
    (activity.time[before], activity.time[after])
}

impl Activity<'_> {
    /// Greatest deviation between two times, rad.
    fn greatest(&self, start_s: f64, end_s: f64) -> f64 {
        let inside = Window { start_s, end_s }.indices(self.time);
        self.deviation[inside].iter().map(|value| value.abs()).fold(0.0, f64::max)
    }
}

/// From the lead-in to where the free response has died down, a control moves again, or the longest allowed.
fn window(
    found: &Manoeuvre,
    next_onset_s: f64,
    activities: &[Activity<'_>],
    responses: &[(Role, &Series)],
    settings: &ManoeuvreSettings,
) -> Window {
    let mut limit = (found.input_end_s + settings.max_free_s).min(next_onset_s);
    let mut start_s = found.onset_s - settings.lead_in_s;
    for activity in activities {
        let moved = activity.excursions.iter().map(|e| activity.time[e.samples.start]);
        limit = moved.filter(|&t| t > found.input_end_s).fold(limit, f64::min);
        if activity.surface == found.surface {
            let within = |range: &&Range<usize>| activity.time[range.end - 1] >= found.onset_s;
            if let Some(range) = activity.stretches.iter().find(within) {
                start_s = start_s.max(activity.time[range.start]);
                limit = limit.min(activity.time[range.end - 1]);
            }
        }
    }
    let rate = match found.surface {
        Role::Aileron => Role::RollRate,
        Role::Elevator => Role::PitchRate,
        _ => Role::YawRate,
    };
    let response = responses.iter().find(|(role, _)| *role == rate).map(|(_, series)| *series);
    let settled = response.and_then(|response| settled(response, start_s, found, limit, settings.settled_share));
    Window { start_s, end_s: settled.unwrap_or(limit).max(found.input_end_s).min(limit.max(found.input_end_s)) }
}

/// Time from which a rate stays within a share of its greatest, about its mean before the onset.
fn settled(response: &Series, start_s: f64, found: &Manoeuvre, limit: f64, share: f64) -> Option<f64> {
    let before = Window { start_s, end_s: found.onset_s }.indices(&response.time_s);
    let resting = response.values.get(before.clone()).filter(|values| !values.is_empty())?;
    let mean = resting.iter().sum::<f64>() / resting.len() as f64;
    let inside = Window { start_s: found.onset_s, end_s: limit }.indices(&response.time_s);
    let deviation = |k: usize| (response.values[k] - mean).abs();
    let greatest = inside.clone().map(deviation).fold(0.0, f64::max);
    let last = inside.clone().rev().find(|&k| deviation(k) > share * greatest)?;
    response.time_s.get(last + 1).copied()
}
