//! Units that the motion decides where none is stated: heights by pressure and climb, speeds by places, angles by the climb, rates by the
//! attitude.

use crate::atmos::{Atmosphere, STANDARD_GRAVITY_M_S2};
use crate::load::contents::Probe;
use crate::load::guesses::motion::{change_correlation, ground_speed, height, places, slope_of, turning, way_of};
use crate::load::guesses::trace::Trace;
use crate::load::maps::by_hand::{ManualChannel, ManualChannelMap};
use crate::quantity::{Role, Unit};
use crate::statistics::median;

/// Correlation, either way, from which a slope says a unit.
const CORRELATION: f64 = 0.9;
/// Largest ratio of a slope to that of a unit, either way.
const RATIO: f64 = 1.2;
/// Largest ratio of an airspeed to the speed over the Earth, either way.
const SPEED_RATIO: f64 = 1.3;
/// The same of the speed at which the bank turns the heading.
const TURN_RATIO: f64 = 1.06;
/// Largest ratio of a climb to the one that speed and pitch make, either way.
const CLIMB_RATIO: f64 = 2.5;

/// Units that heights are recorded in.
const HEIGHTS: [&str; 6] = ["m", "ft", "mm", "cm", "km", "FL"];

/// Settles units in the order in which one decides the next.
pub(crate) fn settle(map: &mut ManualChannelMap, probes: &[Probe]) {
    settle_heights(map, probes);
    settle_climb(map, probes);
    settle_velocity(map, probes);
    settle_speed_by_mach(map, probes);
    settle_speeds(map, probes);
    settle_angles(map, probes);
    settle_rates(map, probes);
    settle_heights_by_pitch(map, probes);
    settle_places(map, probes);
}

/// Product of an airspeed and the pitch, whose units are known: the climb but for the angle of attack.
fn climb_of_pitch(map: &ManualChannelMap, probes: &[Probe], pitch: &ManualChannel) -> Option<Trace> {
    let is_known = |role: &Role| map.row(*role).is_some_and(|row| !row.is_unit_open(probes));
    let speed = Trace::for_role(map, Role::AIRSPEEDS.into_iter().find(is_known)?, probes)?;
    let mut climb = Trace::read(pitch, probes)?.at(&speed.time_s)?;
    climb.values.iter_mut().zip(&speed.values).for_each(|(pitch, speed)| *pitch *= speed);
    Some(climb)
}

/// Heights in metres or feet by the climb that speed and pitch make.
fn settle_heights_by_pitch(map: &mut ManualChannelMap, probes: &[Probe]) {
    let Some(pitch) = map.row(Role::PitchAngle).filter(|row| !row.is_unit_open(probes)) else { return };
    let Some(climb) = climb_of_pitch(map, probes, pitch) else { return };
    for role in [Role::Altitude, Role::GpsAltitude] {
        let Some(row) = map.row(role).filter(|row| row.is_unit_open(probes)).cloned() else { continue };
        let found = Trace::read(&row, probes).and_then(|height| slope_of(&height, climb.clone()));
        let Some((slope, _)) = found.filter(|(_, correlation)| correlation.abs() > 0.8) else { continue };
        if let Some(unit) = unit_of(&row, slope, &["m", "ft"], 1.6) {
            give(map, role, unit);
        }
    }
    settle_climb(map, probes);
}

/// Positions in metres or feet by an airspeed whose unit is known.
fn settle_places(map: &mut ManualChannelMap, probes: &[Probe]) {
    let roles = [Role::PositionNorth, Role::PositionEast];
    if !roles.iter().all(|role| is_open(map, *role, probes)) {
        return;
    }
    let (Some((ground, air)), Some(row)) = (read_speeds(map, probes), map.row(Role::PositionNorth).cloned()) else {
        return;
    };
    if let Some(unit) = unit_of(&row, ground / air, &["m", "ft"], SPEED_RATIO) {
        for role in [Role::PositionNorth, Role::PositionEast, Role::PositionDown] {
            if is_open(map, role, probes) {
                give(map, role, unit);
            }
        }
    }
}

/// Median speed of the positions, in their unit, and of the air, m/s.
fn read_speeds(map: &ManualChannelMap, probes: &[Probe]) -> Option<(f64, f64)> {
    let is_known = |role: &Role| map.row(*role).is_some_and(|row| !row.is_unit_open(probes));
    let speed = Trace::for_role(map, Role::AIRSPEEDS.into_iter().find(is_known)?, probes)?;
    let north = Trace::for_role(map, Role::PositionNorth, probes)?;
    let east = Trace::for_role(map, Role::PositionEast, probes)?.at(&north.time_s)?;
    let mut ground = way_of(&[north, east])?.values;
    let mut air = speed.values;
    air.retain(|value| value.is_finite());
    ground.retain(|value| value.is_finite());
    Some((median(&mut ground)?, median(&mut air).filter(|speed| *speed > 5.0)?))
}

fn is_open(map: &ManualChannelMap, role: Role, probes: &[Probe]) -> bool {
    map.row(role).is_some_and(|row| row.is_unit_open(probes))
}

/// Gives a role, and every other of the same channel, a unit that is known.
fn give(map: &mut ManualChannelMap, role: Role, unit: Unit) {
    let Some(from) = map.row(role).map(|row| row.from.clone()) else { return };
    for (other, row) in &mut map.rows {
        if row.from == from && other.dimension() == unit.dimension {
            row.unit = Some(unit);
            row.is_unit_known = true;
        }
    }
}

/// The unit among `symbols` in whose place a row reads `slope` times what it should.
fn unit_of(row: &ManualChannel, slope: f64, symbols: &[&str], ratio: f64) -> Option<Unit> {
    let read = row.unit?.scale;
    let far = |unit: &Unit| (unit.scale * slope.abs() / read).ln().abs();
    let known = symbols.iter().filter_map(|symbol| Unit::parse(symbol).ok());
    let nearest = known.min_by(|a, b| far(a).total_cmp(&far(b)))?;
    (far(&nearest) < ratio.ln()).then_some(nearest)
}

/// Heights by the static pressure, or by another height whose unit is known.
fn settle_heights(map: &mut ManualChannelMap, probes: &[Probe]) {
    let by_pressure = |map: &ManualChannelMap| {
        let pressure = map.row(Role::StaticPressure).filter(|row| !row.is_unit_open(probes))?;
        let mut trace = Trace::read(pressure, probes)?;
        let altitude_m = |pressure_pa: f64| Atmosphere::STANDARD.altitude_m(pressure_pa).unwrap_or(f64::NAN);
        trace.values.iter_mut().for_each(|value| *value = altitude_m(*value));
        Some(trace)
    };
    let heights = [Role::Altitude, Role::GpsAltitude];
    for role in heights {
        if !is_open(map, role, probes) {
            continue;
        }
        let other = heights.into_iter().find(|other| *other != role && !is_open(map, *other, probes));
        let reference = by_pressure(map).or_else(|| Trace::for_role(map, other?, probes));
        let Some(row) = map.row(role).cloned() else { continue };
        let read = Trace::read(&row, probes);
        let found = reference.zip(read).and_then(|(reference, read)| change_correlation(&read, reference));
        let Some((slope, _)) = found.filter(|(_, correlation)| *correlation > CORRELATION) else { continue };
        if let Some(unit) = unit_of(&row, slope, &HEIGHTS, RATIO) {
            give(map, role, unit);
        }
    }
}

/// Height and climb by each other: where one is known, the other; where neither is, feet and feet per minute by their ratio.
fn settle_climb(map: &mut ManualChannelMap, probes: &[Probe]) {
    let role = Role::VelocityDown;
    let Some(row) = map.row(role).cloned() else { return };
    let Some((slope, correlation)) =
        height(map, probes).zip(Trace::read(&row, probes)).and_then(|(height, speed)| slope_of(&height, speed))
    else {
        return;
    };
    if correlation.abs() < CORRELATION {
        return;
    }
    let heights = [Role::Altitude, Role::GpsAltitude];
    let open = heights.into_iter().filter(|height| is_open(map, *height, probes)).collect::<Vec<_>>();
    let is_height_open =
        heights.into_iter().find(|role| map.row(*role).is_some()).is_some_and(|role| open.contains(&role));
    let speeds = ["m/s", "ft/s", "ft/min", "kt", "km/h"];
    // The slope is the true speed in the place of the one read.
    let found = unit_of(&row, 1.0 / slope, &speeds, RATIO);
    match (is_open(map, role, probes), is_height_open) {
        (true, false) => {
            if let Some(unit) = found {
                give(map, role, unit);
            } else if (slope.abs() / 0.01).ln().abs() < RATIO.ln() && row.unit.is_some_and(|unit| unit.scale == 1.0) {
                set_scale(map, role, 0.01);
            }
        }
        (false, true) => {
            for height in open {
                let Some(row) = map.row(height).cloned() else { continue };
                if let Some(unit) = unit_of(&row, slope, &HEIGHTS, RATIO) {
                    give(map, height, unit);
                }
            }
        }
        (true, true) => {
            let Some((length, speed)) = find_length_and_speed(map, &row, open[0], slope) else { return };
            open.into_iter().for_each(|height| give(map, height, length));
            give(map, role, speed);
            give_to_parts(map, &row, speed, probes);
        }
        (false, false) => {}
    }
}

/// Units of a height and of a climb whose ratio is that of the numbers recorded, where `slope` is the change of the height as read on the
/// climb as read; none where two pairs have that ratio: metres with m/s, feet with ft/s.
fn find_length_and_speed(
    map: &ManualChannelMap,
    climb: &ManualChannel,
    height: Role,
    slope: f64,
) -> Option<(Unit, Unit)> {
    let recorded = slope.abs() * climb.unit?.scale / map.row(height)?.unit?.scale;
    let parse = |symbols: &[&str]| -> Vec<Unit> { symbols.iter().filter_map(|one| Unit::parse(one).ok()).collect() };
    let (lengths, speeds) = (parse(&["m", "ft"]), parse(&["m/s", "ft/s", "ft/min", "kt", "km/h"]));
    let pairs = lengths.iter().flat_map(|length| speeds.iter().map(move |speed| (*length, *speed)));
    let fits = |(length, speed): &(Unit, Unit)| (recorded * length.scale / speed.scale).ln().abs() < RATIO.ln();
    let mut fitting = pairs.filter(fits);
    fitting.next().filter(|_| fitting.next().is_none())
}

/// Gives the velocities north and east the unit of the climb, where their names differ from its name by one letter.
fn give_to_parts(map: &mut ManualChannelMap, climb: &ManualChannel, unit: Unit, probes: &[Probe]) {
    let is_part = |row: &ManualChannel| {
        let (one, other) = (&row.from.channel, &climb.from.channel);
        row.from.source == climb.from.source
            && one.chars().count() == other.chars().count()
            && one.chars().zip(other.chars()).filter(|(a, b)| a != b).count() == 1
    };
    for role in [Role::VelocityNorth, Role::VelocityEast] {
        if is_open(map, role, probes) && map.row(role).is_some_and(is_part) {
            give(map, role, unit);
        }
    }
}

/// Gives a role a factor that is known.
fn set_scale(map: &mut ManualChannelMap, role: Role, scale: f64) {
    if let Some((_, row)) = map.rows.iter_mut().find(|(other, _)| *other == role) {
        (row.scale, row.is_unit_known) = (scale, true);
    }
}

/// Velocities north and east by latitude and longitude, or by positions whose unit is known.
fn settle_velocity(map: &mut ManualChannelMap, probes: &[Probe]) {
    let roles = [Role::VelocityNorth, Role::VelocityEast];
    if !roles.iter().any(|role| is_open(map, *role, probes)) {
        return;
    }
    let Some(places) = places(map, probes) else { return };
    let mut slopes = Vec::new();
    for (place, role) in places.iter().zip(roles) {
        let found = Trace::for_role(map, role, probes).and_then(|speed| slope_of(place, speed));
        slopes.extend(found.filter(|(_, correlation)| correlation.abs() > CORRELATION).map(|(slope, _)| slope));
    }
    let Some(slope) = slopes.iter().copied().max_by(|a, b| a.abs().total_cmp(&b.abs())) else { return };
    if slopes.iter().any(|other| (other / slope).abs() < 1.0 / RATIO) {
        return;
    }
    // A climb of another name has a unit of its own.
    let is_vector = |row: &ManualChannel| map.row(Role::VelocityNorth).is_some_and(|north| north.by == row.by);
    let has_part = map.row(Role::VelocityDown).is_some_and(is_vector);
    let parts = [Role::VelocityNorth, Role::VelocityEast, Role::VelocityDown];
    for role in parts.into_iter().filter(|role| *role != Role::VelocityDown || has_part) {
        let Some(row) = map.row(role).filter(|row| row.is_unit_open(probes)).cloned() else { continue };
        match unit_of(&row, 1.0 / slope, &["m/s", "ft/s", "kt", "km/h"], RATIO) {
            Some(unit) => give(map, role, unit),
            None if (slope.abs() / 0.01).ln().abs() < RATIO.ln() => set_scale(map, role, 0.01),
            None => {}
        }
    }
}

/// The true airspeed by the Mach number: their ratio is the speed of sound.
fn settle_speed_by_mach(map: &mut ManualChannelMap, probes: &[Probe]) {
    /// Speeds of sound from 11 km to a hot day, m/s.
    const SOUND_M_S: [f64; 2] = [285.0, 360.0];
    const LEAST_MACH: f64 = 0.1;
    let Some(row) = map.row(Role::TrueAirspeed).filter(|row| row.is_unit_open(probes)).cloned() else { return };
    let sound = || {
        let mach = Trace::for_role(map, Role::Mach, probes)?;
        let air = Trace::read(&row, probes)?.at(&mach.time_s)?;
        let pairs = mach.values.iter().zip(&air.values).filter(|(mach, _)| **mach > LEAST_MACH);
        median(&mut pairs.map(|(mach, air)| air / mach).filter(|ratio| ratio.is_finite()).collect::<Vec<_>>())
    };
    let (Some(sound), Some(read)) = (sound(), row.unit) else { return };
    let is_sound = |unit: &Unit| {
        let speed = sound * unit.scale / read.scale;
        (SOUND_M_S[0]..SOUND_M_S[1]).contains(&speed)
    };
    let mut fitting =
        ["m/s", "kt", "ft/s", "km/h"].iter().filter_map(|symbol| Unit::parse(symbol).ok()).filter(is_sound);
    if let (Some(unit), None) = (fitting.next(), fitting.next()) {
        give(map, Role::TrueAirspeed, unit);
        // The other airspeed of the recorder is hardly in another one.
        let is_beside = |(role, other): &&mut (Role, ManualChannel)| {
            *role == Role::CalibratedAirspeed && other.from.source == row.from.source && other.is_unit_open(probes)
        };
        map.rows.iter_mut().find(is_beside).into_iter().for_each(|(_, other)| other.unit = Some(unit));
    }
}

/// Airspeeds by the speed over the Earth, which the wind leaves within a part.
fn settle_speeds(map: &mut ManualChannelMap, probes: &[Probe]) {
    /// Greatest height at which an indicated airspeed is near the true one, m.
    const LOW_M: f64 = 3000.0;
    let middle = |trace: Option<Trace>| {
        let mut values = trace?.values;
        values.retain(|value| value.is_finite());
        median(&mut values)
    };
    let by_ground = middle(ground_speed(map, probes, true)).filter(|speed| *speed > 5.0);
    let by_turn = || turn_speed(map, probes);
    let (reference, units, ratio) = match by_ground {
        Some(speed) => (speed, &["m/s", "kt", "km/h"][..], SPEED_RATIO),
        None => match by_turn() {
            Some(speed) => (speed, &["m/s", "kt", "ft/s", "km/h"][..], TURN_RATIO),
            None => return,
        },
    };
    let is_open_height = [Role::Altitude, Role::GpsAltitude].iter().any(|role| is_open(map, *role, probes));
    let lowest = if is_open_height { 0.3048 } else { 1.0 };
    let is_low = middle(height(map, probes)).is_some_and(|height| lowest * height < LOW_M);
    for role in Role::AIRSPEEDS {
        let Some(row) = map.row(role).filter(|row| row.is_unit_open(probes)).cloned() else { continue };
        let Some(air) = middle(Trace::read(&row, probes)).filter(|speed| *speed > 0.0) else { continue };
        let found = unit_of(&row, air / reference, units, ratio);
        if let Some(unit) = found.filter(|_| role == Role::TrueAirspeed || is_low) {
            give(map, role, unit);
        }
    }
}

/// Speed at which the bank turns the heading as recorded, m/s.
fn turn_speed(map: &ManualChannelMap, probes: &[Probe]) -> Option<f64> {
    let is_known = |role: Role| map.row(role).is_some_and(|row| !row.is_unit_open(probes));
    // Bank and heading in one unit that is not known give the same ratio; a wrong unit of both is excluded by the heading's size.
    let is_sure = is_known(Role::BankAngle) || map.row(Role::HeadingAngle)?.unit?.symbol == "deg";
    let (slope, correlation) = turning(map, probes)?.heading_by_bank.filter(|_| is_sure)?;
    (correlation.abs() > CORRELATION && slope != 0.0)
        .then(|| STANDARD_GRAVITY_M_S2 / slope.abs())
        .filter(|speed| *speed > 5.0)
}

const ANGLES: [Role; 3] = [Role::BankAngle, Role::PitchAngle, Role::HeadingAngle];

/// The unit of the attitude by the climb that speed and pitch make.
fn settle_angles(map: &mut ManualChannelMap, probes: &[Probe]) {
    let Some(row) = map.row(Role::PitchAngle).filter(|row| row.is_unit_open(probes)).cloned() else { return };
    let is_known = |role: Role| map.row(role).is_some_and(|row| !row.is_unit_open(probes));
    let slope = || {
        let height = height(map, probes)?;
        let first = [Role::Altitude, Role::GpsAltitude].into_iter().find(|role| map.row(*role).is_some())?;
        if !is_known(first) {
            return None;
        }
        let climb = climb_of_pitch(map, probes, &row)?;
        slope_of(&height, climb).filter(|(_, correlation)| correlation.abs() > 0.7).map(|(slope, _)| slope)
    };
    let Some(unit) = slope().and_then(|slope| unit_of(&row, 1.0 / slope, &["rad", "deg"], CLIMB_RATIO)) else { return };
    for role in ANGLES {
        let is_brother = map.row(role).is_some_and(|other| other.from.source == row.from.source);
        if is_brother && is_open(map, role, probes) {
            give(map, role, unit);
        }
    }
}

/// Gives rates the unit that goes with that of the attitude, where neither is known; it stays to be asked for.
fn agree(map: &mut ManualChannelMap, probes: &[Probe], found: &[(Role, f64)]) {
    for (role, slope) in found {
        let unit = map.row(*role).and_then(|row| unit_of(row, *slope, &["rad/s", "deg/s"], RATIO));
        for (other, row) in &mut map.rows {
            if let Some(unit) = unit.filter(|_| other == role && row.is_unit_open(probes)) {
                row.unit = Some(unit);
            }
        }
    }
}

/// Rates by the change of the attitude, or the attitude by rates whose unit is known.
fn settle_rates(map: &mut ManualChannelMap, probes: &[Probe]) {
    const LEAST: f64 = 0.8;
    let Some(turning) = turning(map, probes) else { return };
    let roles = [Role::RollRate, Role::PitchRate, Role::YawRate];
    let found: Vec<(Role, f64)> = roles
        .into_iter()
        .zip(turning.rates)
        .filter_map(|(role, rate)| {
            rate.filter(|(_, correlation)| correlation.abs() > LEAST).map(|(slope, _)| (role, slope))
        })
        .collect();
    let is_known = |role: Role| !is_open(map, role, probes);
    let are_angles_open = ANGLES.iter().all(|role| map.row(*role).is_none() || is_open(map, *role, probes));
    if are_angles_open {
        let by_rates = found.iter().find(|(role, _)| is_known(*role));
        let Some((_, slope)) = by_rates else {
            return agree(map, probes, &found);
        };
        let Some(row) = map.row(Role::BankAngle).cloned() else { return };
        if let Some(unit) = unit_of(&row, 1.0 / slope, &["rad", "deg"], RATIO) {
            ANGLES.iter().for_each(|role| give(map, *role, unit));
        }
        return;
    }
    let Some((_, slope)) = found.iter().find(|(role, _)| !is_known(*role)) else { return };
    for role in roles {
        let Some(row) = map.row(role).filter(|row| row.is_unit_open(probes)).cloned() else { continue };
        let own = found.iter().find(|(other, _)| *other == role).map_or(*slope, |(_, slope)| *slope);
        match unit_of(&row, own, &["rad/s", "deg/s"], RATIO) {
            Some(unit) => give(map, role, unit),
            None => {
                let milli = row.unit.map_or(1.0, |unit| unit.scale) / own.abs() / 1e-3;
                if let (true, Ok(unit)) = (milli.ln().abs() < RATIO.ln(), Unit::parse("rad/s")) {
                    give(map, role, unit);
                    set_scale(map, role, 1e-3);
                }
            }
        }
    }
}
