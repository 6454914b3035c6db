//! Roles and signs that the change of one channel shows in another: velocity by position, climb by altitude, airspeed by the velocity's length.

use crate::load::contents::{ChannelInfo, Probe};
use crate::load::guesses::candidates::{Candidate, row};
use crate::load::maps::by_hand::{By, ChannelName, ManualChannel, ManualChannelMap};
use crate::load::names::stated_unit::{is_count, name_and_unit};
use crate::quantity::{Role, Unit};
use crate::statistics::median;

/// Lag over which changes are compared, s.
const LAG_S: f64 = 1.0;
/// Most comparisons of one pair.
const MOST_PAIRS: usize = 2000;
/// Fewest comparisons that say something.
const FEWEST_PAIRS: usize = 30;
/// Slopes and least squared correlation of a velocity on the change of its position.
const SAME_SLOPE: std::ops::RangeInclusive<f64> = 0.93..=1.07;
const SAME_R2: f64 = 0.95;
/// Least correlation of a climb with the change of altitude, either way.
const CLIMB_CORRELATION: f64 = 0.8;
/// Largest relative difference of an airspeed from the length of a velocity that it is.
const SAME_LENGTH: f64 = 2e-3;

/// Slope of the change of `place` by the time on the mean of `speed`, and their correlation.
pub(crate) fn compare(time_s: &[f64], place: &[f64], speed: &[f64]) -> Option<(f64, f64)> {
    compare_over(LAG_S, time_s, place, speed)
}

/// The same over a lag in seconds.
pub(crate) fn compare_over(lag_s: f64, time_s: &[f64], place: &[f64], speed: &[f64]) -> Option<(f64, f64)> {
    let count = time_s.len().min(place.len()).min(speed.len());
    let span_s = time_s.get(count.checked_sub(1)?)? - time_s.first()?;
    if span_s.is_nan() || span_s <= lag_s {
        return None;
    }
    #[expect(
        clippy::cast_possible_truncation,
        clippy::cast_sign_loss,
        reason = "positive, at most the count of samples"
    )]
    let lag = ((lag_s * count as f64 / span_s).round() as usize).clamp(1, count);
    let step = (count / MOST_PAIRS).max(1);
    let pair = |k: usize| {
        let seconds = time_s[k + lag] - time_s[k];
        let change = (place[k + lag] - place[k]) / seconds;
        let inside = &speed[k..=k + lag];
        let ends = 0.5 * (inside[0] + inside[lag]);
        let mean = (inside.iter().sum::<f64>() - ends) / lag as f64;
        (seconds > 0.0 && change.is_finite() && mean.is_finite()).then_some((mean, change))
    };
    let pairs: Vec<(f64, f64)> = (0..count.saturating_sub(lag)).step_by(step).filter_map(pair).collect();
    let number = pairs.len() as f64;
    if pairs.len() < FEWEST_PAIRS {
        return None;
    }
    let (sum_x, sum_y) = pairs.iter().fold((0.0, 0.0), |(x, y), pair| (x + pair.0, y + pair.1));
    let (mean_x, mean_y) = (sum_x / number, sum_y / number);
    let (mut xx, mut xy, mut yy) = (0.0, 0.0, 0.0);
    for (x, y) in pairs {
        let (x, y) = (x - mean_x, y - mean_y);
        (xx, xy, yy) = (xx + x * x, xy + x * y, yy + y * y);
    }
    (xx > 0.0 && yy > 0.0).then(|| (xy / xx, xy / (xx * yy).sqrt()))
}

/// Stamps of the clock of a channel, s.
pub(crate) fn stamps_of(from: &ChannelName, probes: &[Probe]) -> Option<Vec<f64>> {
    let source = probes.iter().flat_map(|probe| &probe.sources).find(|source| source.name == from.source)?;
    let clock = source.clocks.get(from.find(probes)?.clock?)?;
    match clock.index {
        Some(index) => {
            let values = source.channels.get(index)?.values();
            Some(values.iter().map(|value| clock.unit.to_si(*value)).collect())
        }
        None => Some((0..clock.samples).map(|k| clock.start_s + k as f64 / clock.rate_hz).collect()),
    }
}

/// Gives the velocities that have no channel yet the channels of the same source that are the slopes of the positions recorded: `u`, `v`, `w`
/// of a recorder that means north, east and down.
pub(crate) fn add_velocity(map: &mut ManualChannelMap, candidates: &[Candidate<'_>], probes: &[Probe]) {
    let pairs = [
        (Role::PositionNorth, Role::VelocityNorth),
        (Role::PositionEast, Role::VelocityEast),
        (Role::PositionDown, Role::VelocityDown),
    ];
    if pairs.iter().any(|(_, velocity)| map.row(*velocity).is_some()) {
        return;
    }
    let mut found = Vec::new();
    for (position, velocity) in pairs {
        let Some(place) = map.row(position).cloned() else { return };
        let Some(index) = find_slope(&place, map, candidates, probes, velocity) else { return };
        found.push((velocity, place, index));
    }
    let indices: Vec<usize> = found.iter().map(|(.., index)| *index).collect();
    if indices[0] == indices[1] || indices[1] == indices[2] || indices[0] == indices[2] {
        return;
    }
    for (velocity, place, index) in found {
        let mut row = row(&candidates[index], velocity);
        (row.by, row.turned) = (By::Physics, place.turned);
        if row.is_unit_open(probes) && place.unit.is_some_and(|unit| unit.symbol == "ft") {
            row.unit = Unit::parse("ft/s").ok();
        }
        map.set(velocity, Some(row));
    }
}

/// The free channel of the source of `place` that is its slope.
fn find_slope(
    place: &ManualChannel,
    map: &ManualChannelMap,
    candidates: &[Candidate<'_>],
    probes: &[Probe],
    velocity: Role,
) -> Option<usize> {
    let time_s = stamps_of(&place.from, probes)?;
    let channel = place.from.find(probes)?;
    let is_free = |candidate: &Candidate<'_>| {
        candidate.from.source == place.from.source
            && candidate.channel.clock == channel.clock
            && candidate.unit.is_none_or(|unit| unit.dimension == velocity.dimension() || is_count(unit))
            && map.rows.iter().all(|(_, row)| row.from != candidate.from)
    };
    let fits = |(index, candidate): (usize, &Candidate<'_>)| {
        let (slope, correlation) = compare(&time_s, channel.values(), candidate.channel.values())?;
        (SAME_SLOPE.contains(&slope) && correlation * correlation > SAME_R2).then_some((index, correlation))
    };
    let fitting = candidates.iter().enumerate().filter(|(_, candidate)| is_free(candidate)).filter_map(fits);
    fitting.max_by(|a, b| a.1.total_cmp(&b.1)).map(|(index, _)| index)
}

/// Turns a velocity down that was found by its axis alone and is the climb by the altitude.
pub(crate) fn turn_climb(map: &mut ManualChannelMap, probes: &[Probe]) {
    let Some(down) = map.row(Role::VelocityDown).filter(|row| row.by == By::Axes) else { return };
    if down.from.channel.to_lowercase().contains("down") {
        return;
    }
    let heights = [Role::Altitude, Role::GpsAltitude];
    let height = heights.iter().filter_map(|role| map.row(*role)).find(|row| row.from.source == down.from.source);
    let Some(height) = height else { return };
    let read = || {
        let (time_s, height, down) =
            (stamps_of(&height.from, probes)?, height.from.find(probes)?, down.from.find(probes)?);
        (height.clock == down.clock).then(|| compare(&time_s, height.values(), down.values()))?
    };
    if let Some((_, correlation)) = read().filter(|(_, correlation)| correlation.abs() > CLIMB_CORRELATION) {
        let turned = correlation > 0.0;
        map.set(Role::VelocityDown, Some(ManualChannel { turned, ..down.clone() }));
    }
}

/// Names of a place as one vector: latitude, longitude and height in either order of the first two.
const PLACES: [&str; 4] = ["lla", "llh", "latlonalt", "lonlatalt"];

/// Gives latitude, longitude and altitude the columns of a vector called so, where its values leave one order only.
pub(crate) fn add_place(map: &mut ManualChannelMap, candidates: &[Candidate<'_>]) {
    let roles = [Role::Latitude, Role::Longitude, Role::Altitude, Role::GpsAltitude];
    if roles.iter().any(|role| map.row(*role).is_some()) {
        return;
    }
    let column = |source: Option<&str>, axis: &str| {
        candidates.iter().position(|candidate| {
            source.is_none_or(|source| candidate.from.source == source)
                && PLACES.iter().any(|name| candidate.plain == format!("{name}{axis}"))
        })
    };
    let Some(first) = column(None, "0") else { return };
    let source = Some(candidates[first].from.source.as_str());
    let (Some(second), Some(height)) = (column(source, "1"), column(source, "2")) else { return };
    let largest = |index: usize| {
        let finite = candidates[index].channel.values().iter().filter(|value| value.is_finite());
        finite.fold(0.0_f64, |most, value| most.max(value.abs()))
    };
    let can_be_latitude = [first, second].map(|index| largest(index) <= 90.0);
    let (latitude, longitude) = match can_be_latitude {
        [true, false] => (first, second),
        [false, true] => (second, first),
        _ => return,
    };
    for (role, index) in [(Role::Latitude, latitude), (Role::Longitude, longitude), (Role::Altitude, height)] {
        let mut row = row(&candidates[index], role);
        row.by = By::Axes;
        map.set(role, Some(row));
    }
}

/// An indicated airspeed that is the length of a velocity recorded beside it is the true one.
pub(crate) fn settle_airspeed(map: &mut ManualChannelMap, probes: &[Probe]) {
    if map.row(Role::TrueAirspeed).is_some() {
        return;
    }
    let Some(speed) = map.row(Role::CalibratedAirspeed).cloned() else { return };
    let sources = probes.iter().flat_map(|probe| &probe.sources);
    let Some(source) = sources.into_iter().find(|source| source.name == speed.from.source) else { return };
    let Some(channel) = speed.from.find(probes) else { return };
    let column = |name: &str| source.channels.iter().find(|other| name_and_unit(&other.name).0 == name);
    let stems = source.channels.iter().filter_map(|other| other.name.strip_suffix("[0]"));
    let axes = |stem: &str| [0, 1, 2].map(|axis| column(&format!("{stem}[{axis}]")));
    if stems.into_iter().any(|stem| is_length(channel, axes(stem))) {
        map.set(Role::CalibratedAirspeed, None);
        map.set(Role::TrueAirspeed, Some(ManualChannel { by: By::Physics, ..speed }));
    }
}

/// Whether a channel is the length of the vector with these components.
fn is_length(channel: &ChannelInfo, axes: [Option<&ChannelInfo>; 3]) -> bool {
    let [Some(x), Some(y), Some(z)] = axes else { return false };
    let count = [x, y, z, channel].iter().map(|one| one.samples.min(one.values().len())).min().unwrap_or(0);
    let length = |k: usize| x.values()[k].hypot(y.values()[k]).hypot(z.values()[k]);
    let apart = |k: usize| (length(k) - channel.values()[k]).abs() / channel.values()[k].abs();
    let mut all: Vec<f64> = (0..count).map(apart).filter(|apart| apart.is_finite()).collect();
    all.len() >= FEWEST_PAIRS && median(&mut all).is_some_and(|apart| apart < SAME_LENGTH)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::load::guesses::guess::guess;
    use crate::load::probe_of;

    #[test]
    fn velocities_are_found_by_the_slopes_of_positions() {
        let row = |k: u32| {
            let t = 0.05 * f64::from(k);
            let (x, y, z) = (20.0 * t + 3.0 * t.sin(), 5.0 * (0.7 * t).cos(), -50.0 + 2.0 * (1.3 * t).sin());
            let (u, v, w) = (20.0 + 3.0 * t.cos(), -3.5 * (0.7 * t).sin(), 2.6 * (1.3 * t).cos());
            format!("{t},{x},{y},{z},{u},{v},{w}\n")
        };
        let text = format!("time,x,y,z,u,v,w\n{}", (0..600).map(row).collect::<String>());
        let probe = probe_of(&text);
        let map = guess(std::slice::from_ref(&probe));
        for (role, name) in [(Role::VelocityNorth, "u"), (Role::VelocityEast, "v"), (Role::VelocityDown, "w")] {
            let found = map.row(role).map(|row| (row.from.channel.as_str(), row.by, row.turned));
            assert_eq!(found, Some((name, By::Physics, false)));
        }
    }
}
