//! Velocity and heading by the slope of latitude and longitude: which axis is north, which way each goes, whether the heading follows it.

use std::f64::consts::{FRAC_PI_2, PI, TAU};

use crate::load::contents::Probe;
use crate::load::guesses::motion::{
    FEWEST_PAIRS, MOST_PAIRS, PLACE_CORRELATION, RATE_CORRELATION, change_correlation, fit_line, is_free, lag_of,
    places, slope_of, turning,
};
use crate::load::guesses::trace::Trace;
use crate::load::maps::by_hand::{By, ManualChannel, ManualChannelMap};
use crate::load::names::stated_unit::stated_unit;
use crate::load::names::tokens::tokens;
use crate::quantity::Role;
use crate::statistics::median;

/// Span over which the slope of a place is taken, s.
const SPAN_S: f64 = 2.0;
/// Least median speed over the Earth whose levels are compared, m/s.
const LEAST_SPEED: f64 = 3.0;
/// Largest median distance of a velocity from the slope of the fixes, as a part of the speed.
const NEAR: f64 = 0.2;
/// Largest ratio of a distance to the one of another reading.
const CLEARLY: f64 = 0.4;

/// Whether the name of a velocity or place says north or east.
fn says_axis(row: &ManualChannel) -> bool {
    let all = tokens(&row.from.channel);
    ["north", "east", "n", "e", "vn", "ve", "pn", "pe"].iter().any(|word| all.iter().any(|token| token == word))
}

/// How two channels are north and east.
struct Reading {
    /// They are exchanged.
    is_exchanged: bool,
    /// Whether the one that is north and the one that is east are turned.
    turned: [bool; 2],
}

/// Velocities and positions whose names say axes alone: exchanged where latitude and longitude say that x is east, left out where they are
/// no velocity over the Earth.
pub(crate) fn settle_horizontal(map: &mut ManualChannelMap, probes: &[Probe]) {
    let Some([north, east]) = places(map, probes) else { return };
    for (roles, is_speed) in
        [([Role::VelocityNorth, Role::VelocityEast], true), ([Role::PositionNorth, Role::PositionEast], false)]
    {
        let [Some(x), Some(y)] = roles.map(|role| map.row(role).cloned()) else { continue };
        if [&x, &y].iter().any(|row| row.by == By::Recorder || says_axis(row)) {
            continue;
        }
        let against = |place: &Trace, row: &ManualChannel| {
            let other = Trace::read(row, probes)?;
            let found = if is_speed { slope_of(place, other) } else { change_correlation(place, other) };
            found.map(|(_, correlation)| correlation)
        };
        let all = [against(&north, &x), against(&north, &y), against(&east, &x), against(&east, &y)];
        let by_level = || is_speed.then(|| read_levels([&north, &east], [&x, &y], all, probes)).flatten();
        if let Some(found) = by_level().or_else(|| read_changes(all)) {
            let rows = if found.is_exchanged { [y, x] } else { [x, y] };
            for ((role, row), turned) in roles.into_iter().zip(rows).zip(found.turned) {
                map.set(role, Some(ManualChannel { turned: row.turned ^ turned, asks_sign: false, ..row }));
            }
        } else if is_speed
            && x.by == By::Axes
            && all.iter().all(|one| one.is_some_and(|one| one.abs() < 0.5))
            && [(&north, &x), (&east, &y)].into_iter().any(|(place, row)| is_far(place, row, probes))
        {
            for role in [Role::VelocityNorth, Role::VelocityEast, Role::VelocityDown] {
                if let Some(row) = map.row(role).filter(|row| row.by == By::Axes).cloned() {
                    map.left_out.push((row.from, "not the change of latitude and longitude".to_owned()));
                    map.set(role, None);
                }
            }
        }
    }
}

/// The reading in which changes go together; `all` are the correlations of north with x and y, then of east with x and y.
fn read_changes(all: [Option<f64>; 4]) -> Option<Reading> {
    let [Some(nx), Some(ny), Some(ex), Some(ey)] = all else { return None };
    let strong = |correlation: f64| correlation.abs() > PLACE_CORRELATION;
    if strong(nx) && strong(ey) && nx.abs() + ey.abs() >= ny.abs() + ex.abs() {
        Some(Reading { is_exchanged: false, turned: [nx < 0.0, ey < 0.0] })
    } else {
        (strong(ny) && strong(ex)).then_some(Reading { is_exchanged: true, turned: [ny < 0.0, ex < 0.0] })
    }
}

/// The reading in which velocities have the size of the slopes of north and east, which says it on a straight flight too; a component that
/// is near zero takes its sign from the changes.
fn read_levels(
    places: [&Trace; 2],
    rows: [&ManualChannel; 2],
    changes: [Option<f64>; 4],
    probes: &[Probe],
) -> Option<Reading> {
    // Of north with x and y, of east with x and y, each as recorded and turned.
    let mut apart = [[0.0; 2]; 4];
    let mut sizes = [0.0; 2];
    for (index, both) in apart.iter_mut().enumerate() {
        for (sign, one) in [1.0, -1.0].into_iter().zip(both) {
            let (distance, size) = compare_level(places[index / 2], rows[index % 2], sign, probes)?;
            (*one, sizes[index / 2]) = (distance, size);
        }
    }
    let speed = f64::hypot(sizes[0], sizes[1]);
    let nearest = |index: usize| f64::min(apart[index][0], apart[index][1]);
    let (plain, exchanged) = (nearest(0) + nearest(3), nearest(1) + nearest(2));
    let (best, other) = (plain.min(exchanged), plain.max(exchanged));
    if speed < LEAST_SPEED || best > NEAR * speed || best > CLEARLY * other {
        return None;
    }
    let is_exchanged = exchanged < plain;
    let indices = if is_exchanged { [1, 2] } else { [0, 3] };
    let turned = indices.map(|index| {
        let [as_recorded, turned] = apart[index];
        let by_change = changes[index].filter(|correlation| correlation.abs() > PLACE_CORRELATION);
        if as_recorded.min(turned) < CLEARLY * as_recorded.max(turned) {
            turned < as_recorded
        } else {
            by_change.is_some_and(|correlation| correlation < 0.0)
        }
    });
    Some(Reading { is_exchanged, turned })
}

/// Median distance of a velocity, times a sign, from the slope of a place, and the median size of that slope, m/s.
fn compare_level(place: &Trace, row: &ManualChannel, sign: f64, probes: &[Probe]) -> Option<(f64, f64)> {
    let speed = Trace::read(row, probes)?.at(&place.time_s)?;
    let lag = lag_of(&place.time_s, SPAN_S)?;
    let slope = |k: usize| (place.values[k + lag] - place.values[k]) / (place.time_s[k + lag] - place.time_s[k]);
    let pairs = (0..place.values.len() - lag).map(|k| (slope(k), sign * speed.values[k + lag / 2]));
    let (mut apart, mut sizes): (Vec<f64>, Vec<f64>) =
        pairs.filter(|(a, b)| a.is_finite() && b.is_finite()).map(|(a, b)| ((a - b).abs(), a.abs())).unzip();
    Some((median(&mut apart)?, median(&mut sizes)?))
}

/// Whether a velocity is not near the slope of a place, which it need not follow where both are constant.
fn is_far(place: &Trace, row: &ManualChannel, probes: &[Probe]) -> bool {
    compare_level(place, row, 1.0, probes).is_some_and(|(apart, size)| apart > 0.3 * size + 2.0)
}

/// Direction of what moves north and east, rad from north to the east; not of what stands.
fn direction(north: Trace, east: &Trace) -> Trace {
    let angle = |(north, east): (&f64, &f64)| if north.hypot(*east) > 2.0 { east.atan2(*north) } else { f64::NAN };
    let values = north.values.iter().zip(&east.values).map(angle).collect();
    Trace { values, ..north }
}

/// Direction of the velocities over the Earth.
pub(crate) fn track(map: &ManualChannelMap, probes: &[Probe]) -> Option<Trace> {
    let north = Trace::for_role(map, Role::VelocityNorth, probes)?;
    let east = Trace::for_role(map, Role::VelocityEast, probes)?.at(&north.time_s)?;
    Some(direction(north, &east))
}

/// Direction of the way between latitudes and longitudes.
fn track_of_fixes(map: &ManualChannelMap, probes: &[Probe]) -> Option<Trace> {
    let places = places(map, probes)?;
    let lag = lag_of(&places[0].time_s, SPAN_S)?;
    let slope = |place: &Trace| {
        let seconds = |k: usize| place.time_s[k + lag] - place.time_s[k];
        let values = (0..place.values.len() - lag).map(|k| (place.values[k + lag] - place.values[k]) / seconds(k));
        let middle = |k: usize| 0.5 * (place.time_s[k] + place.time_s[k + lag]);
        Trace { time_s: (0..place.values.len() - lag).map(middle).collect(), values: values.collect() }
    };
    let [north, east] = places.each_ref().map(slope);
    Some(direction(north, &east))
}

/// The track of velocities whose axes are said, or else of latitude and longitude; the axes of a velocity that its name does not say are no
/// evidence.
fn find_known_track(map: &ManualChannelMap, probes: &[Probe]) -> Option<Trace> {
    let is_said = |role: Role| map.row(role).is_some_and(|row| row.by != By::Axes || says_axis(row));
    let is_decided = is_said(Role::VelocityNorth) && is_said(Role::VelocityEast);
    if is_decided { track(map, probes) } else { track_of_fixes(map, probes) }
}

/// Slope, rad/s, and correlation of the rate of turn of the track on the tangent of the bank, both over some seconds: banked lift turns the
/// velocity at once, while the heading also moves with the sideslip.
pub(crate) fn fit_track_to_bank(map: &ManualChannelMap, probes: &[Probe]) -> Option<(f64, f64)> {
    /// Span, s, over which both are taken: much longer than a receiver is late.
    const TURN_S: f64 = 2.0;
    /// Largest bank, rad, of a turn that keeps its height.
    const MOST_RAD: f64 = 1.2;
    let bank = Trace::for_role(map, Role::BankAngle, probes)?.unwrapped();
    let track = find_known_track(map, probes)?.unwrapped().at(&bank.time_s)?;
    let (count, lag) = (bank.time_s.len(), lag_of(&bank.time_s, TURN_S)?);
    let step = (count / MOST_PAIRS).max(1);
    let pair = |k: usize| {
        let inside = &bank.values[k..=k + lag];
        let mean = inside.iter().map(|bank| bank.tan()).sum::<f64>() / inside.len() as f64;
        let turn = (track.values[k + lag] - track.values[k]) / (bank.time_s[k + lag] - bank.time_s[k]);
        (mean, if inside.iter().all(|bank| bank.abs() < MOST_RAD) { turn } else { f64::NAN })
    };
    fit_line(&(0..count - lag).step_by(step).map(pair).collect::<Vec<_>>())
}

/// Whether the heading follows the track; an angle of the mathematicians, from east to the north, is set so that it does, and asked for.
pub(crate) fn settle_heading(map: &mut ManualChannelMap, probes: &[Probe]) -> bool {
    /// Largest median distance of a heading from the track, rad.
    const DRIFT_RAD: f64 = 0.35;
    let known = find_known_track(map, probes);
    let may_turn = known.is_some();
    let read = || {
        let row = map.row(Role::HeadingAngle)?.clone();
        let track = known.or_else(|| track(map, probes))?;
        let heading = Trace::read(&row, probes)?.at(&track.time_s)?;
        Some((row, heading, track))
    };
    let Some((row, heading, track)) = read() else { return false };
    let apart = |sign: f64, offset: f64| {
        let one = |(heading, track): (&f64, &f64)| ((sign * heading + offset - track + PI).rem_euclid(TAU) - PI).abs();
        let mut all: Vec<f64> =
            heading.values.iter().zip(&track.values).map(one).filter(|apart| apart.is_finite()).collect();
        (all.len() >= FEWEST_PAIRS).then(|| median(&mut all)).flatten().unwrap_or(PI)
    };
    let (clockwise, mathematical) = (apart(1.0, 0.0), apart(-1.0, FRAC_PI_2));
    if clockwise < DRIFT_RAD && clockwise < 0.5 * mathematical {
        return true;
    }
    // Where the yaw rate says that the heading is right, only more than any wind can make speaks against it.
    let least = if agrees_with_rate(map, &row, probes) { 2.0 * DRIFT_RAD } else { 0.0 };
    let unit = row.unit.filter(|_| may_turn && is_free(&row) && !row.turned && row.offset == 0.0);
    let is_mathematical = mathematical < DRIFT_RAD && mathematical < 0.5 * clockwise && clockwise > least;
    if let Some(unit) = unit.filter(|_| is_mathematical) {
        // psi = -(raw - a quarter of a turn).
        let offset = -unit.from_si(FRAC_PI_2);
        map.set(Role::HeadingAngle, Some(ManualChannel { turned: true, offset, asks_sign: true, ..row }));
        return true;
    }
    false
}

/// Whether a heading that states its unit turns as the yaw rate beside it says, both as recorded.
fn agrees_with_rate(map: &ManualChannelMap, heading: &ManualChannel, probes: &[Probe]) -> bool {
    let has_unit = heading.from.find(probes).is_some_and(|channel| stated_unit(channel).is_some());
    let is_plain = map.row(Role::YawRate).is_some_and(|row| row.by == By::Name && !row.turned);
    let correlation = || turning(map, probes)?.rates[2].map(|(_, correlation)| correlation);
    has_unit && is_plain && correlation().is_some_and(|correlation| correlation > RATE_CORRELATION)
}
