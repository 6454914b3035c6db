//! Identification manoeuvres found from the controls: when, on which surface, of which shape.

use std::ops::Range;

use super::control_activity::{Activity, OVERSHOOT, activity, ends, highest, inputs};
use super::pulses::{Excursion, half_crossing};
use super::{PrepError, check};
use crate::quantity::Role;
use crate::series::{Series, TimeRange};
use crate::statistics;

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
    crate::variant_texts! {
        /// Name in tables and files.
        pub name: Doublet "doublet", ThreeTwoOneOne "3-2-1-1", Pulse "pulse", Step "step", Irregular "irregular"
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
    /// Surfaces that make the input: of aileron, elevator and rudder one, or those that move alike at one time.
    pub surfaces: Vec<Role>,
    /// Shape.
    pub shape: ManoeuvreShape,
    /// From the lead-in to the end of the free response, s.
    pub window: TimeRange,
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

/// Why an input is no manoeuvre.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum PassedOver {
    /// It stays below the least amplitude.
    Small,
    /// The control did not rest before it.
    NotRested,
    /// The recording ends before the control rests.
    Unfinished,
    /// The dynamic pressure is too low, or the weight is on the wheels.
    OnGround,
    /// Its shape is too far from any, or another control moves too much.
    Unlike,
    /// Another input at the same time is more like a manoeuvre.
    Overlapped,
}

impl PassedOver {
    crate::variant_texts! {
        /// The reason in words.
        pub reason:
            Small "too small", NotRested "without rest before", Unfinished "not finished when the recording ends",
            OnGround "at too low a dynamic pressure or on the ground", Unlike "of no shape, or with another control",
            Overlapped "under another input",
    }
}

/// Manoeuvres found, and what became of the other inputs.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct ManoeuvreSearch {
    /// Manoeuvres, in order of time.
    pub found: Vec<Manoeuvre>,
    /// Inputs that are none: surface, first movement (s), greatest deflection (rad) and the reason.
    pub passed_over: Vec<(Role, f64, f64, PassedOver)>,
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
    /// The control must rest this long before the input, unless the recording begins there, and be recorded this long after it, unless
    /// the recording is a cut of less than twice the moving median, s.
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

/// An input of one surface.
struct Candidate {
    manoeuvre: Manoeuvre,
    /// Greatest deflection of a pulse, rad.
    highest: f64,
}

/// Manoeuvres in the deflections of aileron, elevator and rudder (rad).
///
/// Each control's deviation from its own resting place (a moving median, so that trim and drift do not matter) is cut into
/// excursions beyond half the least amplitude; excursions that follow each other closely after a rest are one input. A control
/// rests where it stays below 0.35 of the input. Its pulses, bounded where they pass half their height, are compared with the
/// ideal lengths of each shape: `e = rms(d_i / (T p_i) - 1)` with the base time `T` of least squares. The confidence is
/// `1 / (1 + (e / 0.4)^2) / (1 + (s / 0.6)^2) / (1 + (o / 0.5)^2)` with the relative spread `s` of the amplitudes and the greatest
/// deviation `o` of another surface relative to this one's or, where higher, to its own typical input (the median height of its
/// inputs of several pulses). Inputs below a quarter of their surface's typical one are passed over. Inputs of several surfaces
/// that overlap and are at least half as high as the highest, or half as high as their own typical one, are one manoeuvre; of
/// others that overlap, the most confident is kept. A cut in which none is found but a control moves is one irregular manoeuvre.
/// `responses` are the body rates (rad/s) that tell the end of the free response: roll for aileron, pitch for elevator, yaw for
/// rudder; without one it lasts until a control moves, or the longest allowed. `airborne` are the spans in which a manoeuvre may
/// lie from its lead-in to its onset.
///
/// # Errors
/// Lengths that differ, time that does not increase, a least amplitude that is not above zero, a resting time below 1 s.
pub fn find_manoeuvres(
    controls: &[(Role, &Series)],
    responses: &[(Role, &Series)],
    airborne: &[TimeRange],
    settings: &ManoeuvreSettings,
) -> Result<ManoeuvreSearch, PrepError> {
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
    let mut search = ManoeuvreSearch::default();
    let mut candidates: Vec<Candidate> = Vec::new();
    for activity in &activities {
        for (input, rested) in inputs(activity, settings) {
            let highest = highest(input);
            match candidate(activity, input, rested, highest, settings) {
                Ok(candidate) => candidates.push(candidate),
                Err(why) => {
                    search.passed_over.push((activity.surface, activity.time[input[0].samples.start], highest, why));
                }
            }
        }
    }
    let flies = |found: &Manoeuvre| airborne.iter().any(|span| lies_within(span, found, &activities, settings));
    let typical = TypicalInputs::new(&activities, candidates.iter().filter(|one| flies(&one.manoeuvre)));
    let (mut kept, mut passed): (Vec<Candidate>, Vec<(Candidate, PassedOver)>) = (Vec::new(), Vec::new());
    let (candidates, small) = candidates.into_iter().partition(|one| !typical.dwarfs(one));
    let small: Vec<Candidate> = small;
    passed.extend(small.into_iter().map(|one| (one, PassedOver::Small)));
    let mut ranked: Vec<Candidate> = joined(candidates, &typical, settings.lead_in_s)
        .into_iter()
        .map(|mut candidate| {
            candidate.manoeuvre.confidence *= stillness(&candidate, &activities, &typical);
            candidate
        })
        .collect();
    ranked.sort_by(|a, b| b.manoeuvre.confidence.total_cmp(&a.manoeuvre.confidence));
    for candidate in ranked {
        let found = &candidate.manoeuvre;
        let overlaps = |other: &Candidate| overlap(&other.manoeuvre, found);
        if !flies(found) {
            passed.push((candidate, PassedOver::OnGround));
        } else if found.confidence < settings.min_confidence {
            passed.push((candidate, PassedOver::Unlike));
        } else if kept.iter().any(overlaps) {
            passed.push((candidate, PassedOver::Overlapped));
        } else {
            kept.push(candidate);
        }
    }
    for cut in whole_cuts(&activities, settings) {
        let found = &cut.manoeuvre;
        if flies(found) && !kept.iter().any(|other| in_one_stretch(&activities, &other.manoeuvre, found)) {
            kept.push(cut);
        }
    }
    let passed = passed.into_iter().map(|(it, why)| (it.manoeuvre.surfaces[0], it.manoeuvre.onset_s, it.highest, why));
    search.passed_over.extend(passed);
    search.passed_over.sort_by(|a, b| a.1.total_cmp(&b.1));
    search.found = kept.into_iter().map(|candidate| candidate.manoeuvre).collect();
    search.found.sort_by(|a, b| a.onset_s.total_cmp(&b.onset_s));
    for k in 0..search.found.len() {
        let next = search.found.get(k + 1).map_or(f64::INFINITY, |next| next.onset_s);
        let window = window(&search.found[k], next, &activities, responses, settings);
        search.found[k].window = window;
    }
    Ok(search)
}

/// Whether the lead-in of a manoeuvre and its onset lie within a span. The lead-in is shorter where the recording begins.
fn lies_within(span: &TimeRange, found: &Manoeuvre, activities: &[Activity<'_>], settings: &ManoeuvreSettings) -> bool {
    let moved = activities.iter().filter(|activity| found.surfaces.contains(&activity.surface));
    let starts = moved.flat_map(|activity| activity.stretches.iter().map(|range| activity.time[range.start]));
    let begins = starts.filter(|start| *start <= found.onset_s).fold(f64::NEG_INFINITY, f64::max);
    // Air data may begin a little later than the deflections.
    let lead_in = (found.onset_s - settings.lead_in_s).max(begins + settings.max_gap_s).min(found.onset_s);
    span.start_s <= lead_in && found.onset_s <= span.end_s
}

/// The inputs of every cut (a stretch shorter than twice the moving median) as one irregular manoeuvre each: someone cut it out for what
/// its controls do.
fn whole_cuts(activities: &[Activity<'_>], settings: &ManoeuvreSettings) -> Vec<Candidate> {
    let cuts = activities.first().into_iter().flat_map(|activity| {
        activity
            .stretches
            .iter()
            .map(|range| TimeRange { start_s: activity.time[range.start], end_s: activity.time[range.end - 1] })
    });
    let cuts = cuts.filter(|cut| cut.end_s - cut.start_s < 2.0 * settings.resting_s);
    cuts.filter_map(|cut| {
        let mut moved: Vec<(f64, &Activity<'_>)> =
            activities.iter().map(|activity| (activity.greatest(cut.start_s, cut.end_s), activity)).collect();
        moved.sort_by(|a, b| b.0.total_cmp(&a.0));
        let highest = moved.first().map_or(0.0, |(highest, _)| *highest);
        moved.retain(|(greatest, _)| *greatest >= (ALIKE * highest).max(settings.least_amplitude_rad));
        let inside = |at: f64| (cut.start_s..=cut.end_s).contains(&at);
        let inputs = moved.iter().flat_map(|(_, activity)| {
            let times = |e: &Excursion| (activity.time[e.samples.start], activity.time[e.samples.end - 1]);
            activity.excursions.iter().map(times).filter(|(start, _)| inside(*start))
        });
        let (onset_s, input_end_s) = inputs.reduce(|a, b| (a.0.min(b.0), a.1.max(b.1)))?;
        let manoeuvre = Manoeuvre {
            surfaces: moved.iter().map(|(_, activity)| activity.surface).collect(),
            shape: ManoeuvreShape::Irregular,
            window: cut,
            onset_s,
            input_end_s,
            base_time_s: input_end_s - onset_s,
            amplitude_rad: highest,
            pulses: Vec::new(),
            confidence: settings.min_confidence,
        };
        Some(Candidate { manoeuvre, highest })
    })
    .collect()
}

/// Whether two manoeuvres begin in one stretch of the recording.
fn in_one_stretch(activities: &[Activity<'_>], a: &Manoeuvre, b: &Manoeuvre) -> bool {
    let place = |found: &Manoeuvre| {
        let Some(activity) = activities.first() else { return 0 };
        activity.stretches.partition_point(|range| activity.time[range.end - 1] < found.onset_s)
    };
    place(a) == place(b)
}

fn overlap(a: &Manoeuvre, b: &Manoeuvre) -> bool {
    a.onset_s <= b.input_end_s && b.onset_s <= a.input_end_s
}

/// Share of the highest deflection from which on a surface is one of those that make the input.
const ALIKE: f64 = 0.5;

/// The same for a surface that moves by [`ALIKE`] of its own typical input: a rudder of 5 deg beside an aileron of 12 deg.
const BESIDE: f64 = 0.2;

/// Height of each surface's inputs in a recording, against which its other motion is small or large.
struct TypicalInputs(Vec<TypicalInput>);

struct TypicalInput {
    surface: Role,
    /// Of doublets and 3-2-1-1s, rad.
    shaped: Option<f64>,
    /// Of inputs of several pulses, rad.
    any: Option<f64>,
}

impl TypicalInputs {
    fn new<'a>(activities: &[Activity<'_>], candidates: impl Iterator<Item = &'a Candidate> + Clone) -> Self {
        let surfaces = activities.iter().map(|activity| activity.surface);
        Self(surfaces.map(|surface| Self::find_typical(surface, candidates.clone())).collect())
    }

    fn find_typical<'a>(surface: Role, candidates: impl Iterator<Item = &'a Candidate> + Clone) -> TypicalInput {
        let own = candidates.filter(|one| one.manoeuvre.surfaces[0] == surface);
        let shaped = own.clone().filter(|one| {
            let shape = one.manoeuvre.shape;
            matches!(shape, ManoeuvreShape::Doublet | ManoeuvreShape::ThreeTwoOneOne)
        });
        let several = own.filter(|one| one.manoeuvre.pulses.len() > 1);
        TypicalInput { surface, shaped: typical_height(shaped, 0.5), any: typical_height(several, 0.2) }
    }

    fn of_surface(&self, surface: Role) -> Option<&TypicalInput> {
        self.0.iter().find(|typical| typical.surface == surface)
    }

    /// Height of a surface's inputs of several pulses, rad; zero where it has none.
    fn height(&self, surface: Role) -> f64 {
        self.of_surface(surface).and_then(|typical| typical.any).unwrap_or(0.0)
    }

    /// Whether an input is a correction beside the manoeuvres of its surface: below a quarter of their height.
    fn dwarfs(&self, candidate: &Candidate) -> bool {
        let Some(typical) = self.of_surface(candidate.manoeuvre.surfaces[0]) else { return false };
        let height = if candidate.manoeuvre.shape == ManoeuvreShape::Irregular { typical.any } else { typical.shaped };
        height.is_some_and(|height| candidate.highest < 0.25 * height)
    }
}

/// Median height of the inputs above a confidence that are at least half as high as the highest of them, at least two.
fn typical_height<'a>(inputs: impl Iterator<Item = &'a Candidate>, least_confidence: f64) -> Option<f64> {
    let sure = inputs.filter(|one| one.manoeuvre.confidence > least_confidence);
    let mut heights: Vec<f64> = sure.map(|one| one.highest).collect();
    let highest = heights.iter().copied().fold(0.0, f64::max);
    heights.retain(|height| *height >= 0.5 * highest);
    if heights.len() < 2 { None } else { statistics::median(&mut heights) }
}

/// Inputs of several surfaces at one time as one manoeuvre, the others as they are. What begins before the lead-in of another is apart.
fn joined(candidates: Vec<Candidate>, typical: &TypicalInputs, lead_in_s: f64) -> Vec<Candidate> {
    let mut sorted = candidates;
    sorted.sort_by(|a, b| b.highest.total_cmp(&a.highest));
    let mut groups: Vec<Candidate> = Vec::new();
    for candidate in sorted {
        let own = candidate.manoeuvre.surfaces[0];
        let height = typical.height(own);
        let is_typical = height > 0.0 && candidate.highest >= ALIKE * height;
        let least = if is_typical { BESIDE } else { ALIKE };
        let with = |group: &&mut Candidate| {
            !group.manoeuvre.surfaces.contains(&own)
                && candidate.highest >= least * group.highest
                && overlap(&group.manoeuvre, &candidate.manoeuvre)
                && candidate.manoeuvre.onset_s >= group.manoeuvre.onset_s - lead_in_s
        };
        let Some(Candidate { manoeuvre: group, .. }) = groups.iter_mut().find(with) else {
            groups.push(candidate);
            continue;
        };
        let other = candidate.manoeuvre;
        group.surfaces.push(own);
        group.onset_s = group.onset_s.min(other.onset_s);
        group.input_end_s = group.input_end_s.max(other.input_end_s);
        group.confidence = group.confidence.min(other.confidence);
        if group.shape != other.shape {
            group.shape = ManoeuvreShape::Irregular;
        }
    }
    groups
}

/// From 0 to 1: how still the surfaces were that make no part of an input.
fn stillness(candidate: &Candidate, activities: &[Activity<'_>], typical: &TypicalInputs) -> f64 {
    let found = &candidate.manoeuvre;
    let others = activities.iter().filter(|other| !found.surfaces.contains(&other.surface));
    let moved = |other: &Activity<'_>| {
        let against = typical.height(other.surface).max(candidate.highest);
        other.greatest(found.onset_s, found.input_end_s) / against
    };
    share(others.map(moved).fold(0.0, f64::max), 0.5)
}

/// `1 / (1 + (value / scale)^2)`.
fn share(value: f64, scale: f64) -> f64 {
    1.0 / (1.0 + (value / scale).powi(2))
}

/// The manoeuvre an input is, if it is large, rested before and finished.
fn candidate(
    activity: &Activity<'_>,
    input: &[Excursion],
    rested: bool,
    highest: f64,
    settings: &ManoeuvreSettings,
) -> Result<Candidate, PassedOver> {
    if highest < settings.least_amplitude_rad {
        return Err(PassedOver::Small);
    }
    if !rested {
        return Err(PassedOver::NotRested);
    }
    let main: Vec<&Excursion> = input.iter().filter(|e| e.amplitude.abs() >= OVERSHOOT * highest).collect();
    let (Some(first), Some(last)) = (main.first(), main.last()) else { return Err(PassedOver::Small) };
    let (time, deviation) = (activity.time, &activity.deviation[..]);
    // The hand that takes over again at the end of a recording is no input; a cut ends when its maker likes.
    let (stretch_start, stretch_end) = (time[last.stretch.0], time[last.stretch.1 - 1]);
    let is_cut = stretch_end - stretch_start < 2.0 * settings.resting_s;
    let after_s = stretch_end - time[last.samples.end - 1];
    let unfinished = after_s < if is_cut { settings.max_gap_s } else { settings.rest_s };
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
        return Err(PassedOver::Unfinished);
    }
    let (onset_s, input_end_s) = ends(activity, first, last, highest);
    let mean = pulses.iter().map(|pulse| pulse.amplitude_rad.abs()).sum::<f64>() / pulses.len() as f64;
    let variance =
        pulses.iter().map(|pulse| (pulse.amplitude_rad.abs() - mean).powi(2)).sum::<f64>() / pulses.len() as f64;
    let manoeuvre = Manoeuvre {
        surfaces: vec![activity.surface],
        shape,
        window: TimeRange { start_s: onset_s, end_s: input_end_s },
        onset_s,
        input_end_s,
        base_time_s,
        amplitude_rad: mean.copysign(first.amplitude),
        pulses,
        confidence: share(error, 0.4) * share(variance.sqrt() / mean, 0.6),
    };
    Ok(Candidate { manoeuvre, highest })
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
    if error > LIKE { (ManoeuvreShape::Irregular, mean, LIKE) } else { (named, base, error) }
}

/// From the lead-in to where the free response has died down, a control moves again, or the longest allowed.
fn window(
    found: &Manoeuvre,
    next_onset_s: f64,
    activities: &[Activity<'_>],
    responses: &[(Role, &Series)],
    settings: &ManoeuvreSettings,
) -> TimeRange {
    let mut limit = (found.input_end_s + settings.max_free_s).min(next_onset_s);
    let mut start_s = found.onset_s - settings.lead_in_s;
    for activity in activities {
        let moves = |e: &Excursion| activity.time[e.samples.start];
        let next = activity.excursions.partition_point(|e| moves(e) <= found.input_end_s);
        limit = activity.excursions.get(next).map_or(limit, |e| limit.min(moves(e)));
        if found.surfaces.contains(&activity.surface) {
            let within = |range: &&Range<usize>| activity.time[range.end - 1] >= found.onset_s;
            if let Some(range) = activity.stretches.iter().find(within) {
                start_s = start_s.max(activity.time[range.start]);
                limit = limit.min(activity.time[range.end - 1]);
            }
        }
    }
    let response = |surface: &Role| {
        responses.iter().find(|(role, _)| *role == commanded_rate(*surface)).map(|(_, series)| *series)
    };
    let ends = found.surfaces.iter().map(|surface| {
        response(surface).and_then(|response| settled(response, start_s, found, limit, settings.settled_share))
    });
    // Of several surfaces the motion that lasts longest; without a response of one of them the longest allowed.
    let settled = ends.reduce(|a, b| a.zip(b).map(|(a, b)| a.max(b))).flatten();
    TimeRange { start_s, end_s: settled.unwrap_or(limit).max(found.input_end_s).min(limit.max(found.input_end_s)) }
}

fn commanded_rate(surface: Role) -> Role {
    match surface {
        Role::Aileron => Role::RollRate,
        Role::Elevator => Role::PitchRate,
        _ => Role::YawRate,
    }
}

/// Time from which a rate stays within a share of its greatest, about its mean before the onset.
fn settled(response: &Series, start_s: f64, found: &Manoeuvre, limit: f64, share: f64) -> Option<f64> {
    let before = TimeRange { start_s, end_s: found.onset_s }.indices(&response.time_s);
    let resting = response.values.get(before.clone()).filter(|values| !values.is_empty())?;
    let mean = resting.iter().sum::<f64>() / resting.len() as f64;
    let inside = TimeRange { start_s: found.onset_s, end_s: limit }.indices(&response.time_s);
    let deviation = |k: usize| (response.values[k] - mean).abs();
    let greatest = inside.clone().map(deviation).fold(0.0, f64::max);
    let last = inside.clone().rev().find(|&k| deviation(k) > share * greatest)?;
    response.time_s.get(last + 1).copied()
}
