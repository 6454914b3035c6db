//! Channels of one quantity from several sensors, such as `IRS1_ROLL` and `IRS2_ROLL`: one that does not move, is a spare one or contradicts the
//! others plays no role.

use std::f64::consts::{PI, TAU};

use crate::load::guesses::candidates::Candidate;
use crate::load::maps::by_hand::ManualChannelMap;
use crate::load::names::role_names::NAMES;
use crate::load::names::tokens::{end_on, essence};
use crate::quantity::{Dimension, Role};
use crate::statistics::{extent, median, quantile};

/// Words that part the sensors of one quantity.
const SENSORS: [&str; 26] = [
    "1", "2", "3", "4", "01", "02", "03", "04", "a", "b", "c", "l", "r", "lh", "rh", "left", "right", "fo", "capt",
    "cap", "lt", "rt", "unit", "no", "sys", "system",
];
/// Words of the one that counts, and of those that stand by for it.
const FIRST: [&str; 5] = ["voted", "vote", "primary", "pri", "main"];
const STANDBY: [&str; 9] = ["aux", "auxiliary", "secondary", "sec", "backup", "standby", "stby", "spare", "redundant"];
/// Quantities of which an aircraft has one.
const ROLES: [Role; 23] = [
    Role::SpecificForceX,
    Role::SpecificForceY,
    Role::SpecificForceZ,
    Role::RollRate,
    Role::PitchRate,
    Role::YawRate,
    Role::VelocityNorth,
    Role::VelocityEast,
    Role::VelocityDown,
    Role::BankAngle,
    Role::PitchAngle,
    Role::HeadingAngle,
    Role::TrueAirspeed,
    Role::CalibratedAirspeed,
    Role::EquivalentAirspeed,
    Role::Mach,
    Role::AngleOfAttack,
    Role::Sideslip,
    Role::Altitude,
    Role::GpsAltitude,
    Role::Latitude,
    Role::Longitude,
    Role::AirTemperature,
];
/// Part of a recording over which a channel does not change that stands still, and of one that does not.
const STILL_SHARE: f64 = 0.25;
const LIVE_SHARE: f64 = 0.05;
/// How many times as far from two others as these are from each other a channel is that contradicts them, and the least part of what the
/// middle half of their values spans.
const APART: f64 = 10.0;
const LEAST_PART: f64 = 0.05;

/// A channel of a group: its place among the candidates and the words of its name without those of its sensor.
struct Member {
    index: usize,
    words: Vec<String>,
    is_first: bool,
    is_standby: bool,
}

/// Takes channels from `candidates` of whose quantity another channel is the better one; where one is taken, the first that stays goes by
/// the words of the quantity alone.
pub(crate) fn keep_the_best(map: &mut ManualChannelMap, candidates: &mut Vec<Candidate<'_>>) {
    let mut left: Vec<usize> = Vec::new();
    for group in groups_of(candidates) {
        let out = find_worse(&group, candidates);
        if out.is_empty() {
            continue;
        }
        let stays = |one: &&Member| out.iter().all(|(index, _)| *index != one.index);
        let mut remaining = group.iter().filter(stays);
        let Some(next) = remaining.next() else { continue };
        let first = remaining.find(|one| one.is_first).filter(|_| !next.is_first).unwrap_or(next);
        let candidate = &mut candidates[first.index];
        candidate.tokens.clone_from(&first.words);
        candidate.plain = first.words.concat();
        candidate.words.clone_from(&candidate.plain);
        candidate.essence = essence(&first.words);
        for (index, why) in out {
            map.left_out.push((candidates[index].from.clone(), why));
            left.push(index);
        }
    }
    let mut index = 0;
    candidates.retain(|_| {
        index += 1;
        !left.contains(&(index - 1))
    });
}

/// Groups of channels of one source, clock and dimension whose names differ in the sensor alone.
fn groups_of(candidates: &[Candidate<'_>]) -> Vec<Vec<Member>> {
    let mut groups: Vec<Vec<Member>> = Vec::new();
    for (index, candidate) in candidates.iter().enumerate() {
        let Some(member) = member(index, candidate) else { continue };
        let is_alike = |group: &&mut Vec<Member>| {
            let other = &candidates[group[0].index];
            let dimension = |one: &Candidate<'_>| one.unit.map(|unit| unit.dimension);
            group[0].words == member.words
                && other.from.source == candidate.from.source
                && other.channel.clock == candidate.channel.clock
                && dimension(other) == dimension(candidate)
        };
        match groups.iter_mut().find(is_alike) {
            Some(group) => group.push(member),
            None => groups.push(vec![member]),
        }
    }
    groups.retain(|group| group.len() > 1);
    groups
}

/// The member of a group that a channel can be, where the words of its name without its sensor's are those of a quantity.
fn member(index: usize, candidate: &Candidate<'_>) -> Option<Member> {
    let has = |words: &[&str]| candidate.tokens.iter().any(|token| words.contains(&token.as_str()));
    let is_sensor = |token: &str| [&SENSORS[..], &FIRST, &STANDBY].iter().any(|words| words.contains(&token));
    // `q1` is the part of a quaternion or vector, `q_ch_1` a channel.
    let is_channel = |token: &&String| ["ch", "chan", "channel"].contains(&token.as_str());
    let mut words: Vec<String> =
        candidate.tokens.iter().filter(|token| !is_sensor(token) && !is_channel(token)).cloned().collect();
    // The yaw rate `r` is no right side.
    if words.is_empty() {
        words.extend(candidate.tokens.first().cloned());
    }
    let is_short = words.concat().len() < 2;
    if is_short && !candidate.tokens.iter().any(|token| is_channel(&token)) && !has(&FIRST) {
        return None;
    }
    let (joined, inner) = (words.concat(), essence(&words));
    let is_name = |name: &&str| *name == joined || *name == inner || (name.len() > 2 && end_on(&words, name));
    let is_role = NAMES.iter().any(|(role, names)| ROLES.contains(role) && names.iter().any(&is_name));
    is_role.then(|| Member { index, words, is_first: has(&FIRST), is_standby: has(&STANDBY) })
}

/// Channels of a group that play no role, and why.
fn find_worse(group: &[Member], candidates: &[Candidate<'_>]) -> Vec<(usize, String)> {
    let name = |member: &Member| format!("'{}'", candidates[member.index].from.channel);
    let still: Vec<f64> = group.iter().map(|member| still_share(&candidates[member.index])).collect();
    let live = group.iter().zip(&still).find(|(_, share)| **share < LIVE_SHARE).map(|(member, _)| name(member));
    let mut out: Vec<(usize, String)> = Vec::new();
    if let Some(live) = &live {
        let dead = group.iter().zip(&still).filter(|(_, share)| **share > STILL_SHARE);
        out.extend(dead.map(|(member, _)| (member.index, format!("does not move while {live} does"))));
    }
    let stays = |out: &[(usize, String)], member: &Member| out.iter().all(|(index, _)| *index != member.index);
    let alive: Vec<&Member> = group.iter().filter(|member| stays(&out, member)).collect();
    for (member, others) in find_apart(&alive, candidates) {
        out.push((member.index, format!("contradicts {} and {}", name(others[0]), name(others[1]))));
    }
    let first = group.iter().find(|member| member.is_first && stays(&out, member));
    let first = first.or_else(|| group.iter().find(|member| !member.is_standby && stays(&out, member)));
    if let Some(first) = first {
        let less = |member: &&Member| member.index != first.index && (first.is_first || member.is_standby);
        let standby: Vec<&Member> = group.iter().filter(less).filter(|member| stays(&out, member)).collect();
        out.extend(standby.into_iter().map(|member| (member.index, format!("{} is of the main sensor", name(first)))));
    }
    out
}

/// Longest part of a channel's samples over which it does not change; all of it where it has hardly any value.
fn still_share(candidate: &Candidate<'_>) -> f64 {
    let values = candidate.channel.values();
    let (mut longest, mut run, mut count, mut last) = (0_usize, 0_usize, 0_usize, f64::NAN);
    for value in values.iter().filter(|value| value.is_finite()) {
        run = if *value == last { run + 1 } else { 0 };
        (longest, last, count) = (longest.max(run), *value, count + 1);
    }
    if count < 2 || 20 * count < values.len() { 1.0 } else { longest as f64 / (count - 1) as f64 }
}

/// Members that differ from two others, which agree, each with these two.
fn find_apart<'m>(alive: &[&'m Member], candidates: &[Candidate<'_>]) -> Vec<(&'m Member, [&'m Member; 2])> {
    if alive.len() < 3 {
        return Vec::new();
    }
    let pairs = (0..alive.len()).flat_map(|one| (0..one).map(move |other| (other, one)));
    let apart = |one: usize, other: usize| apart(&candidates[alive[one].index], &candidates[alive[other].index]);
    let Some((one, other, near)) =
        pairs.filter_map(|(one, other)| Some((one, other, apart(one, other)?))).min_by(|a, b| a.2.total_cmp(&b.2))
    else {
        return Vec::new();
    };
    let Some(span) = middle_half(&candidates[alive[one].index]) else { return Vec::new() };
    let is_far = |index: &usize| {
        let far = [one, other].into_iter().filter_map(|agreed| apart(agreed, *index)).fold(f64::INFINITY, f64::min);
        far.is_finite() && far > (APART * near).max(LEAST_PART * span)
    };
    let others = (0..alive.len()).filter(|index| *index != one && *index != other).filter(is_far);
    others.map(|index| (alive[index], [alive[one], alive[other]])).collect()
}

/// Values of a channel in SI where it has a unit, by index.
fn read<'v>(candidate: &'v Candidate<'_>) -> impl Iterator<Item = f64> + 'v {
    let unit = candidate.unit;
    candidate.channel.values().iter().map(move |value| unit.map_or(*value, |unit| unit.to_si(*value)))
}

/// Median distance of two channels; angles over a turn.
fn apart(one: &Candidate<'_>, other: &Candidate<'_>) -> Option<f64> {
    let is_angle = one.unit.is_some_and(|unit| unit.dimension == Dimension::Angle);
    let wrap = |difference: f64| if is_angle { (difference + PI).rem_euclid(TAU) - PI } else { difference };
    let both = read(one).zip(read(other)).map(|(a, b)| wrap(a - b).abs());
    median(&mut both.filter(|distance| distance.is_finite()).collect::<Vec<_>>())
}

/// What the middle half of the values of a channel spans.
fn middle_half(candidate: &Candidate<'_>) -> Option<f64> {
    let mut values: Vec<f64> = read(candidate).filter(|value| value.is_finite()).collect();
    extent(&values)?;
    values.sort_by(f64::total_cmp);
    Some(quantile(&values, 0.75) - quantile(&values, 0.25))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::load::guesses::guess::guess;
    use crate::load::probe_of;

    /// Channel of a role in a recording of 20 s with three columns beside time, made by `row` of the time.
    fn channel_of(head: &str, row: impl Fn(f64) -> [f64; 3], role: Role) -> (Option<String>, Vec<String>) {
        let line = |k: u32| {
            let t = 0.02 * f64::from(k);
            let [a, b, c] = row(t);
            format!("{t:.2},{a:.4},{b:.4},{c:.4}\n")
        };
        let text = format!("time,{head}\n{}", (0..1000).map(line).collect::<String>());
        let map = guess(&[probe_of(&text)]);
        let out = map.left_out.iter().map(|(from, _)| from.channel.clone()).collect();
        (map.row(role).map(|row| row.from.channel.clone()), out)
    }

    #[test]
    fn of_sensors_of_one_quantity_the_one_that_stands_still_plays_no_role() {
        let wave = |t: f64| 3.0 * (0.7 * t).sin();
        for (head, role, used) in [
            ("IRS1_PITCH (deg),IRS2_PITCH (deg),IRS3_PITCH (deg)", Role::PitchAngle, "IRS2_PITCH"),
            ("AOA_1 [deg],AOA_2 [deg],note", Role::AngleOfAttack, "AOA_2"),
            ("TAS_L (m/s),TAS_R (m/s),note", Role::TrueAirspeed, "TAS_R"),
        ] {
            let found =
                channel_of(head, |t| [if t < 5.0 { 4.0 + wave(t) } else { 4.0 }, 4.0 + wave(t), 4.01 + wave(t)], role);
            assert_eq!(found.0.as_deref(), Some(used), "{head}");
            assert_eq!(found.1.len(), 1, "{head}");
        }
        // A constant channel without one that moves is what it is.
        let (used, out) = channel_of("TAS_1 (m/s),TAS_2 (m/s),note", |t| [50.0, 50.0, t], Role::TrueAirspeed);
        assert_eq!((used.as_deref(), out.len()), (Some("TAS_1"), 0));
    }

    #[test]
    fn of_three_the_one_that_contradicts_the_others_plays_no_role() {
        let wave = |t: f64| 3.0 * (0.7 * t).sin();
        let row = |t: f64| [4.0 + wave(t), wave(t), 0.02 + wave(t)];
        let (used, out) = channel_of("Pitch 1 (deg),Pitch 2 (deg),Pitch 3 (deg)", row, Role::PitchAngle);
        assert_eq!((used.as_deref(), &out[..]), (Some("Pitch 2"), &["Pitch 1".to_owned()][..]));
        let three = |t: f64| [0.01 + wave(t), wave(t), 0.02 + wave(t)];
        let (used, out) = channel_of("Pitch 1 (deg),Pitch 2 (deg),Pitch 3 (deg)", three, Role::PitchAngle);
        assert_eq!((used.as_deref(), out.len()), (Some("Pitch 1"), 0));
        // Headings either side of north agree.
        let north = |t: f64| {
            [(359.9 + wave(t)).rem_euclid(360.0), wave(t).rem_euclid(360.0), (0.1 + wave(t)).rem_euclid(360.0)]
        };
        let (used, out) = channel_of("HDG1 (deg),HDG2 (deg),HDG3 (deg)", north, Role::HeadingAngle);
        assert_eq!((used.as_deref(), out.len()), (Some("HDG1"), 0));
    }

    #[test]
    fn the_main_or_voted_one_is_used_and_parts_of_vectors_are_no_sensors() {
        let wave = |t: f64| 3.0 * (0.7 * t).sin();
        let row = |t: f64| [2.0 + wave(t), 0.1 + wave(t), wave(t)];
        for (head, used) in [
            ("THETA_CH_A (deg),THETA_CH_B (deg),THETA_VOTED (deg)", "THETA_VOTED"),
            ("aux pitch (deg),main pitch (deg),note", "main pitch"),
        ] {
            assert_eq!(channel_of(head, row, Role::PitchAngle).0.as_deref(), Some(used), "{head}");
        }
        let rates = channel_of("R_CH_A (deg/s),R_CH_B (deg/s),R_VOTED (deg/s)", row, Role::YawRate);
        assert_eq!(rates.0.as_deref(), Some("R_VOTED"));
        let (_, out) = channel_of("q1,q2,q3", |t| [1.0, 0.0, wave(t)], Role::PitchRate);
        assert!(out.is_empty(), "{out:?}");
    }
}
