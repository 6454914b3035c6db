//! Units and signs of a guessed channel map that the motion shows.

use doublet_core::compatibility::ChannelFix;
use doublet_core::load::{self, By, ChannelName, ManualChannel, ManualChannelMap, Probe};
use doublet_core::quantity::Role;

use super::{apply_fix, compare, plan_by_hand};
use crate::session::{Level, Surface};
use crate::stage::FlightPhysics;

/// A guess with other sensors of the same quantities instead of those that the other channels contradict, where this leaves fewer
/// contradictions. The channel that a recorder defines stays.
pub(super) fn take_other_sensors(probes: &[Probe], guess: ManualChannelMap) -> ManualChannelMap {
    let mut taken = guess;
    for _ in 0..PASSES {
        let mut others: Vec<(Role, ChannelName)> = taken
            .rows
            .iter()
            .filter(|(_, row)| matches!(row.by, By::Name | By::Axes) && row.other_side.is_none())
            .filter_map(|(role, _)| Some((*role, taken.runner_up(*role)?.from.clone())))
            .collect();
        if others.is_empty() {
            break;
        }
        let Ok(physics) = plan_by_hand(probes, &taken).and_then(|plan| compare(&plan)) else { break };
        let now = weigh(&physics);
        others.retain(|(role, _)| physics.contradictions().any(|row| row.channel == role.name()));
        let with_other = |(role, from): (Role, ChannelName)| {
            let next = with_sensor(probes, &taken, role, from)?;
            Some((weigh_contradictions(probes, &next), next))
        };
        let best = others.into_iter().filter_map(with_other).min_by_key(|(weight, _)| *weight);
        match best {
            Some((weight, next)) if weight < now => taken = next,
            _ => break,
        }
    }
    taken
}

/// A map in which a role is read from another channel, in the same way; none where its unit is of another kind.
fn with_sensor(probes: &[Probe], map: &ManualChannelMap, role: Role, from: ChannelName) -> Option<ManualChannelMap> {
    let before = map.row(role)?;
    let row = load::guess_row(probes, role, &from);
    if row.is_unit_open(probes) != before.is_unit_open(probes) {
        return None;
    }
    let unit = if row.is_unit_open(probes) { before.unit } else { row.unit };
    let ManualChannel { turned, offset, by, fit, asks_sign, is_unit_known, .. } = *before;
    let mut next = map.clone();
    // Position down of an altitude is of the same channel.
    for (_, other) in next.rows.iter_mut().filter(|(other, row)| *other != role && row.from == before.from) {
        (other.from, other.unit) = (from.clone(), unit);
    }
    let why = format!("other channels contradict it and agree with '{}'", from.channel);
    next.left_out.push((before.from.clone(), why));
    next.runners_up.retain(|(other, _)| *other != role);
    next.set(role, Some(ManualChannel { unit, turned, offset, by, fit, asks_sign, is_unit_known, ..row }));
    Some(next)
}

/// How much the channels of a map contradict each other; much more than anything where it cannot be read.
fn weigh_contradictions(probes: &[Probe], map: &ManualChannelMap) -> usize {
    let physics = plan_by_hand(probes, map).and_then(|plan| compare(&plan));
    physics.map_or(usize::MAX, |physics| weigh(&physics))
}

/// How much channels contradict each other.
fn weigh(physics: &FlightPhysics) -> usize {
    const OF_BAD: usize = 3;
    physics.contradictions().map(|row| if row.level == Level::Bad { OF_BAD } else { 1 }).sum()
}

/// A guess with the units and signs that the motion shows. Where a channel states no unit and the others contradict the one it was taken
/// for by the factor of another, that is taken; so is the sign of a control or of a channel whose sign is not documented, where its response
/// is the reverse. A unit that is stated stays, whatever contradicts it.
pub(super) fn settle_by_motion(probes: &[Probe], guess: ManualChannelMap) -> ManualChannelMap {
    let is_ground_open =
        |map: &ManualChannelMap| map.velocity.as_ref().is_some_and(|[speed, _]| speed.is_unit_open(probes));
    let is_open = |map: &ManualChannelMap, role: Role| match map.row(role) {
        Some(row) => row.is_unit_open(probes),
        None => OF_GROUND_SPEED.contains(&role) && is_ground_open(map),
    };
    let has_open_row = |(role, row): &(Role, ManualChannel)| row.is_unit_open(probes) || is_sign_open(*role, row);
    if !is_ground_open(&guess) && !guess.rows.iter().any(has_open_row) {
        return guess;
    }
    let mut settled = guess;
    // One unit hides another: what is compared with a climb in m/s tells nothing while that is in ft/min.
    for _ in 0..PASSES {
        // What cannot be read is said by what needs it.
        let Ok(physics) = plan_by_hand(probes, &settled).and_then(|plan| compare(&plan)) else { break };
        let changes = physics.contradictions().filter_map(|row| Some((row.level, row.change.as_ref()?)));
        let mut next = changes.fold(settled.clone(), |map, (level, change)| match change {
            ChannelFix::Scale { role, units: Some(_), factor, offset }
                if *factor > 0.0 && *offset == 0.0 && is_open(&map, *role) =>
            {
                // A factor that is no other unit of the row stays a contradiction.
                let scale = |map: &ManualChannelMap| map.row(*role).map(|row| row.scale);
                let fixed = apply_fix(&map, change, probes);
                if scale(&fixed) == scale(&map) { fixed } else { map }
            }
            ChannelFix::Scale { role, units: None, factor, offset }
                if (*factor, *offset, level) == (-1.0, 0.0, Level::Bad)
                    && map.row(*role).is_some_and(|row| is_sign_open(*role, row)) =>
            {
                apply_fix(&map, change, probes)
            }
            _ => map,
        });
        load::share_rate_unit(&mut next, probes);
        if next == settled {
            break;
        }
        settled = next;
    }
    settled
}

/// Whether nothing states the sign of a row: recorders differ in that of a control, which only its response shows.
fn is_sign_open(role: Role, row: &ManualChannel) -> bool {
    let is_control = Surface::ALL.into_iter().any(|surface| surface.role() == role);
    row.asks_sign || (is_control && matches!(row.by, By::Name | By::Axes | By::Physics))
}

/// Roles that may be derived of ground speed and track.
pub(super) const OF_GROUND_SPEED: [Role; 2] = [Role::VelocityNorth, Role::VelocityEast];
/// Most passes over the units of a guess.
const PASSES: usize = 3;
