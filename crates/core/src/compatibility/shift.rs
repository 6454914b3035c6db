//! Stamps of one recorder against those of the others: the time shift at which its channels fit theirs.
//!
//! Every kinematic relation between channels of one source and of others is evaluated with the samples of that source taken earlier
//! or later; the part of the variance it leaves unexplained, `u = 1 - r2`, is least where the clocks agree. The relations that hold
//! there are put together by least squares weighted with `n / u`.

use std::ops::Range;

use rayon::prelude::*;

use super::changes::ChannelFix;
use super::line::Line;
use super::motion::{COMPARED, Motion, reference};
use super::outcome::Relation;
use super::relations::Kinematic;
use super::rows::{Agreement, CompatibilityRow};
use crate::quantity::Role;
use crate::series::{DERIVED, Recording};

/// Least shift that is named, s: filters and transport in sensors stay below, 0.17 s of a recorded air-data computer, too.
const LEAST_S: f64 = 0.2;
/// Farthest shift looked for, s.
const FARTHEST_S: f64 = 3.0;
/// The same as a part of the longest segment.
const PART_OF_SEGMENT: f64 = 0.25;
/// Steps of the search, and of its refinement, s.
const COARSE_S: f64 = 0.2;
const FINE_S: [f64; 2] = [0.1, 0.05];
/// Segments a relation is evaluated in: those in which it varies most.
const SEGMENTS: usize = 3;
/// A relation tells a shift when it leaves less than this unexplained at its best.
const TELLS: f64 = 0.1;
/// What it leaves at least counts so: no relation is exact.
const LEAST_LEFT: f64 = 2e-3;
/// Most of the unexplained that is left at the shift in a relation that agrees.
const LEFT: f64 = 0.5;
/// Relations that speak against a shift say at most this part of what all of them gain.
const MOST_AGAINST: f64 = 0.5;
/// Relations agree whose own shifts lie this near to the common one, s, or as a part of it.
const AGREEMENT_S: f64 = 0.1;
const AGREEMENT: f64 = 0.15;
/// Sources whose shift explains as much as another's, but for this part.
const AS_GOOD: f64 = 0.1;

/// A source whose stamps do not fit the others.
struct Shifted {
    source: String,
    /// Its stamps are late by this, s.
    late_s: f64,
    /// What the relations gain, `sum n ln(u before / u after)`.
    gain: f64,
    /// The relations that agree: their own shifts near it, and what they leave before and after.
    agreeing: Vec<(&'static Kinematic, f64, [f64; 2])>,
}

/// A relation with the segments it is evaluated in.
struct SegmentedRelation {
    relation: &'static Kinematic,
    segments: Vec<Range<usize>>,
    /// Pairs that count, half of them: they overlap.
    weight: f64,
}

/// Part of the variance over some segments that a relation leaves unexplained.
fn unexplained(relation: &Kinematic, motion: &Motion, segments: &[Range<usize>]) -> f64 {
    let lines = segments.iter().filter_map(|one| Line::of_all(&relation.pairs(motion, one)));
    let (left, all) = lines.fold((0.0, 0.0), |(left, all), line| {
        let variance = line.spread_y.powi(2);
        (left + variance * (1.0 - line.r2), all + variance)
    });
    if all > 0.0 { (left / all).max(LEAST_LEFT) } else { 1.0 }
}

/// Sources whose stamps are shifted against the others, and the recording with them put right.
pub(super) fn find(
    recording: &Recording,
    time_factor: f64,
    motion: Motion,
    relations: &[Relation],
) -> (Vec<CompatibilityRow>, Motion) {
    let sources = sources(recording);
    let mut rows = Vec::new();
    let (mut recording, mut motion) = (recording.clone(), motion);
    let main = reference(&recording).map(|channel| channel.source.clone());
    let mut open: Vec<&(String, Vec<Role>)> = sources.iter().collect();
    while open.len() > 1 {
        let relations = segmented(&motion, relations);
        let mut found: Vec<Shifted> =
            open.par_iter().filter_map(|(source, roles)| shift_of(source, roles, &motion, &relations)).collect();
        let most = found.iter().map(|one| one.gain).fold(0.0, f64::max);
        // Of two that explain as much the flight's own clock stays.
        found.retain(|one| one.gain >= (1.0 - AS_GOOD) * most);
        found.sort_by_key(|one| Some(&one.source) == main.as_ref());
        let Some(best) = found.into_iter().next() else { break };
        for channel in recording.channels.iter_mut().filter(|channel| channel.source == best.source) {
            let series = &mut channel.series;
            series.time_s = series.time_s.iter().map(|time| time - best.late_s / time_factor).collect();
        }
        let Some(after) = Motion::new(&recording, time_factor) else { break };
        rows.push(row(&best, &motion, &after));
        open.retain(|(source, _)| *source != best.source);
        motion = after;
    }
    (rows, motion)
}

/// Sources of the channels that are compared, with their roles. What was worked out of others has no clock of its own.
fn sources(recording: &Recording) -> Vec<(String, Vec<Role>)> {
    let mut sources: Vec<(String, Vec<Role>)> = Vec::new();
    for role in COMPARED {
        let Some(channel) = recording.role(role).filter(|channel| channel.source != DERIVED) else { continue };
        match sources.iter_mut().find(|(source, _)| *source == channel.source) {
            Some((_, roles)) => roles.push(role),
            None => sources.push((channel.source.clone(), vec![role])),
        }
    }
    sources
}

/// The shift of one source against the others; `None` where its stamps fit, or nothing tells.
fn shift_of(source: &str, roles: &[Role], motion: &Motion, relations: &[SegmentedRelation]) -> Option<Shifted> {
    let farthest_s = farthest_s(motion);
    let crossing: Vec<&SegmentedRelation> =
        relations.iter().filter(|one| crosses(one.relation, roles, motion)).collect();
    if crossing.is_empty() {
        return None;
    }
    let mut over: Vec<_> = crossing.iter().flat_map(|one| one.segments.iter().cloned()).collect();
    over.sort_unstable_by_key(|segment| segment.start);
    over.dedup();
    let part = motion.part(&over);
    let places = |one: &SegmentedRelation| -> Vec<Range<usize>> {
        let at = one.segments.iter().filter_map(|segment| over.iter().position(|other| other == segment));
        at.map(|index| part.segments[index].clone()).collect()
    };
    let segments: Vec<_> = crossing.iter().map(|one| places(one)).collect();
    let left = |late_s: f64| -> Vec<f64> {
        let moved = part.earlier(motion, &over, roles, late_s / motion.step_s);
        crossing.iter().zip(&segments).map(|(one, segments)| unexplained(one.relation, &moved, segments)).collect()
    };
    let now = left(0.0);
    #[expect(clippy::cast_possible_truncation, reason = "a few seconds over tenths")]
    let count = (farthest_s / COARSE_S).floor() as i32;
    let grid: Vec<(f64, Vec<f64>)> =
        (-count..=count).map(|k| f64::from(k) * COARSE_S).map(|late_s| (late_s, left(late_s))).collect();
    let weight = |(index, one): (usize, &&SegmentedRelation)| {
        let least = grid.iter().map(|(_, left)| left[index]).fold(f64::INFINITY, f64::min);
        if least < TELLS { one.weight / least } else { 0.0 }
    };
    let weights: Vec<f64> = crossing.iter().enumerate().map(weight).collect();
    let sum = |left: &[f64]| left.iter().zip(&weights).map(|(left, weight)| left * weight).sum::<f64>();
    let (mut late_s, _) = grid.iter().map(|(late_s, left)| (*late_s, sum(left))).min_by(|a, b| a.1.total_cmp(&b.1))?;
    for step_s in FINE_S {
        let [before, at, after] = [late_s - step_s, late_s, late_s + step_s].map(|late_s| sum(&left(late_s)));
        late_s += step_s * vertex(before, at, after);
    }
    let (then, [sooner, later]) = (left(late_s), [-1.0, 1.0].map(|way| left(late_s + way * COARSE_S)));
    let near_s = AGREEMENT_S.max(AGREEMENT * late_s.abs());
    let mut agreeing = Vec::new();
    let (mut gain, mut against) = (0.0, 0.0);
    for (index, one) in crossing.iter().enumerate().filter(|(index, _)| weights[*index] > 0.0) {
        let gained = one.weight * (now[index] / then[index]).ln();
        let apart_s = COARSE_S * vertex(sooner[index], then[index], later[index]);
        gain += gained;
        if then[index] > LEFT * now[index] {
            against -= gained.min(0.0);
        } else if apart_s.abs() <= near_s {
            agreeing.push((one.relation, late_s + apart_s, [now[index], then[index]]));
        } else {
            against += gained;
        }
    }
    let is_found = late_s.abs() >= LEAST_S && !agreeing.is_empty() && gain > 0.0 && against < MOST_AGAINST * gain;
    is_found.then(|| Shifted { source: source.to_owned(), late_s, gain, agreeing })
}

/// Farthest shift looked for, s.
fn farthest_s(motion: &Motion) -> f64 {
    let longest = motion.segments.iter().map(|segment| segment.len()).max().unwrap_or(0);
    FARTHEST_S.min(PART_OF_SEGMENT * motion.step_s * longest as f64)
}

/// Whether a relation holds between the roles of a source and other channels.
fn crosses(relation: &Kinematic, roles: &[Role], motion: &Motion) -> bool {
    let mut entering = COMPARED.iter().filter(|role| relation.involves(**role) && motion.has(**role));
    let own = entering.clone().any(|role| roles.contains(role));
    own && entering.any(|role| !roles.contains(role))
}

/// Relations that apply, each with the segments it varies most in, their ends left free.
fn segmented(motion: &Motion, relations: &[Relation]) -> Vec<SegmentedRelation> {
    #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "a few seconds over steps")]
    let free = (farthest_s(motion) / motion.step_s).ceil() as usize + 2;
    let kinematic =
        relations.par_iter().filter_map(|one| if let Relation::Kinematic(one) = one { Some(*one) } else { None });
    let with_segments = kinematic.filter(|one| one.applies(motion)).map(|relation| {
        let inner = motion.segments.iter().filter(|segment| segment.len() > 3 * free);
        let inner = inner.map(|segment| segment.start + free..segment.end - free);
        let mut varying: Vec<_> = inner.filter_map(|one| Some((relation.variation(motion, &one)?, one))).collect();
        varying.sort_by(|a, b| b.0.total_cmp(&a.0));
        let segments: Vec<_> = varying.into_iter().take(SEGMENTS).map(|(_, segment)| segment).collect();
        let pairs: usize = segments.iter().map(|segment| relation.pairs(motion, segment).len()).sum();
        SegmentedRelation { relation, segments, weight: pairs as f64 / 2.0 }
    });
    with_segments.filter(|one| !one.segments.is_empty()).collect()
}

/// Place of the least of a parabola through three points one apart, from the middle one, at most one away.
fn vertex(before: f64, at: f64, after: f64) -> f64 {
    let curvature = before - 2.0 * at + after;
    if curvature > 0.0 { (0.5 * (before - after) / curvature).clamp(-1.0, 1.0) } else { 0.0 }
}

/// What there is to say of a shifted source.
fn row(found: &Shifted, before: &Motion, after: &Motion) -> CompatibilityRow {
    let mut agreeing: Vec<_> = found.agreeing.iter().collect();
    agreeing.sort_by(|a, b| a.2[1].total_cmp(&b.2[1]));
    let describe = |(relation, own_s, [was, is]): &&(&'static Kinematic, f64, [f64; 2])| {
        let (name, with) = (relation.compared.name(), relation.with);
        format!("{name} against {with} {:+.2} s (R2 {:.3}, then {:.3})", own_s, 1.0 - was, 1.0 - is)
    };
    let comparisons: Vec<String> = agreeing.iter().take(4).map(describe).collect();
    let evidence = format!(
        "{} comparison{} with other sources fit best after this shift: {}",
        agreeing.len(),
        if agreeing.len() == 1 { "" } else { "s" },
        comparisons.join("; ")
    );
    // One comparison alone can be a slow sensor.
    let agreement = if agreeing.len() > 1 { Agreement::Contradicts } else { Agreement::Doubtful };
    let fix = ChannelFix::Shift { source: found.source.clone(), late_s: found.late_s };
    let mut row = CompatibilityRow::of_clock(agreement, Some(fix), evidence, None, agreeing.len());
    row.curves = agreeing.first().and_then(|(relation, ..)| Relation::Kinematic(relation).curves(before, after));
    row.r2 = agreeing.first().map(|(_, _, [was, _])| 1.0 - was);
    row
}
