//! Units that the size of values decides where none is stated: what gravity, the air, a turn and the Earth allow.

use std::f64::consts::{FRAC_PI_2, PI};

use crate::atmos::STANDARD_GRAVITY_M_S2;
use crate::load::contents::Probe;
use crate::load::maps::by_hand::{By, ManualChannel, ManualChannelMap};
use crate::load::names::words::plain_letters;
use crate::quantity::{Role, Unit};
use crate::statistics::{extent, median};

/// Standard acceleration of free fall in the units that accelerations are recorded in.
const GRAVITIES: [(&str, f64); 3] = [("m/s^2", STANDARD_GRAVITY_M_S2), ("ft/s^2", 32.174), ("g", 1.0)];
/// Largest ratio of the median specific force of a flight to one g, either way.
const GRAVITY_RATIO: f64 = 1.35;
/// The same of one that can still be flown.
const FLOWN_RATIO: f64 = 1.8;
/// Least part of the specific force that is along z in the median.
const LEAST_ALONG: f64 = 0.5;
/// Static pressures from sea level to 11 km, in units of which none can be taken for another.
const PRESSURES: [(&str, [f64; 2]); 6] = [
    ("Pa", [20_000.0, 110_000.0]),
    ("hPa", [220.0, 1100.0]),
    ("kPa", [34.0, 110.0]),
    ("psi", [3.2, 14.9]),
    ("inHg", [15.0, 32.5]),
    ("psf", [1150.0, 2300.0]),
];
/// Least static pressure of the air that aeroplanes fly in, Pa.
const LEAST_PRESSURE_PA: f64 = 5000.0;
/// Largest angle in radians that is not more than a turn.
const TURN_RAD: f64 = 6.4;
/// Speeds over the ground of what flies, m/s: above in radians it is none, below in degrees it is hardly one.
const SPEEDS_M_S: [f64; 2] = [2.0, 700.0];
/// Mean radius of the Earth, m.
pub(crate) const EARTH_M: f64 = 6.371e6;

/// Settles the units of a guess that the size of its values decides, and leaves out accelerations without gravity.
pub(crate) fn settle(map: &mut ManualChannelMap, probes: &[Probe]) {
    settle_attitude(map, probes);
    exchange_load_factors(map, probes);
    settle_forces(map, probes);
    settle_pressure(map, probes);
    settle_fixes(map, probes);
    settle_temperature(map, probes);
    settle_flow_angles(map, probes);
    settle_flight_level(map, probes);
    drop_per_cent(map, probes);
    drop_parts(map, probes);
}

/// Axes whose y is up call the load factor along it `Ny`, or the acceleration `AccY`: of the two the one near one g is the normal load factor.
fn exchange_load_factors(map: &mut ManualChannelMap, probes: &[Probe]) {
    let [side, normal] = [Role::SpecificForceY, Role::SpecificForceZ].map(|role| map.row(role).cloned());
    let Some(side) = side.filter(|row| row.by == By::Name || row.by == By::Axes) else { return };
    let is_factor = plain_letters(&side.from.channel).ends_with("ny");
    // A load factor without a unit is in g.
    let in_g = |row: &ManualChannel| {
        if is_factor { 1.0 } else { row.unit.map_or(1.0, |unit| unit.scale / STANDARD_GRAVITY_M_S2) }
    };
    let is_near_one = |row: &ManualChannel| {
        median(&mut columns_of(row, probes)).is_some_and(|middle| (0.7..1.3).contains(&(middle * in_g(row))))
    };
    if is_near_one(&side) && !normal.as_ref().is_some_and(is_near_one) {
        map.set(Role::SpecificForceZ, Some(side));
        map.set(Role::SpecificForceY, normal);
    }
}

/// Leaves out thrust and power without a unit that stay between zero and one: they are parts of the full one.
fn drop_parts(map: &mut ManualChannelMap, probes: &[Probe]) {
    for role in [Role::Thrust1, Role::Thrust2, Role::Power1, Role::Power2] {
        let Some(row) = map.row(role).filter(|row| row.is_unit_open(probes)) else { continue };
        let is_part = recorded_extent(row, probes).is_some_and(|[least, most]| least >= 0.0 && most <= 1.0);
        if is_part && row.by == By::Name {
            leave_out(map, role, "between 0 and 1: a part of the full one");
        }
    }
}

/// Leaves out engine speeds in rpm below those of any engine: they are per cent of its largest speed.
fn drop_per_cent(map: &mut ManualChannelMap, probes: &[Probe]) {
    /// Largest value of a flight, in per cent.
    const REACHED: std::ops::Range<f64> = 20.0..130.0;
    for role in [Role::EngineSpeed1, Role::EngineSpeed2] {
        let Some(row) = map.row(role).filter(|row| row.by == By::Name).cloned() else { continue };
        let is_rpm = row.unit.is_some_and(|unit| unit.symbol == "rpm");
        if is_rpm && row.values(probes).is_some_and(|values| REACHED.contains(&values.greatest)) {
            map.left_out.push((row.from, format!("all values below {}: per cent, not rpm", REACHED.end)));
            map.set(role, None);
        }
    }
}

/// Gives open rows of `roles` a unit that is known.
fn give(map: &mut ManualChannelMap, probes: &[Probe], roles: &[Role], unit: &str) {
    let Ok(unit) = Unit::parse(unit) else { return };
    for (role, row) in &mut map.rows {
        if roles.contains(role) && row.is_unit_open(probes) {
            row.unit = Some(unit);
            row.is_unit_known = true;
        }
    }
}

/// Attitude of one recorder shares its unit: degrees where its heading exceeds a turn in radians, or the unit that another angle states.
fn settle_attitude(map: &mut ManualChannelMap, probes: &[Probe]) {
    let roles = [Role::BankAngle, Role::PitchAngle, Role::HeadingAngle];
    let stated = roles.iter().filter_map(|role| map.row(*role)).find(|row| !row.is_unit_open(probes));
    let stated = stated.and_then(|row| Some((row.unit?.symbol, row.from.source.clone())));
    let largest = |role: Role| {
        map.row(role).and_then(|row| recorded_extent(row, probes)).map_or(0.0, |[least, most]| most.max(-least))
    };
    // A compass shows degrees beside attitudes in radians.
    let is_of_attitude = map.row(Role::HeadingAngle).is_some_and(|row| {
        let name = plain_letters(&row.from.channel);
        ["yaw", "psi"].iter().any(|own| name.contains(own))
    });
    let exceeds = largest(Role::BankAngle) > 1.01 * PI || largest(Role::PitchAngle) > 1.01 * FRAC_PI_2;
    let is_degrees = largest(Role::HeadingAngle) > TURN_RAD && (is_of_attitude || exceeds);
    if is_degrees && largest(Role::PitchAngle) <= 90.0 {
        give(map, probes, &roles, "deg");
    } else if let Some((symbol, source)) = stated {
        let of_source: Vec<Role> =
            roles.into_iter().filter(|role| map.row(*role).is_some_and(|row| row.from.source == source)).collect();
        give(map, probes, &of_source, symbol);
    }
}

/// Least and greatest finite value as recorded.
fn recorded_extent(row: &ManualChannel, probes: &[Probe]) -> Option<[f64; 2]> {
    extent(row.from.find(probes)?.values())
}

/// The unit of specific forces is that in which their median size is one g; where their unit is not stated and no gravity is in them they
/// are left out.
pub(crate) fn settle_forces(map: &mut ManualChannelMap, probes: &[Probe]) {
    let roles = [Role::SpecificForceX, Role::SpecificForceY, Role::SpecificForceZ];
    let rows: Vec<&ManualChannel> = roles.iter().filter_map(|role| map.row(*role)).collect();
    let (Some(down), true) = (map.row(Role::SpecificForceZ), rows.iter().any(|row| row.is_unit_open(probes))) else {
        return;
    };
    let of_one_source: Vec<&&ManualChannel> = rows.iter().filter(|row| row.from.source == down.from.source).collect();
    let columns: Vec<&[f64]> =
        of_one_source.iter().filter_map(|row| row.from.find(probes)).map(|channel| channel.values()).collect();
    let count = columns.iter().map(|values| values.len()).min().unwrap_or(0);
    let size = |k: usize| columns.iter().map(|values| values[k] * values[k]).sum::<f64>().sqrt();
    let mut sizes: Vec<f64> = (0..count).map(size).filter(|size| size.is_finite()).collect();
    let Some(size) = median(&mut sizes) else { return };
    let near = |one: f64, ratio: f64| size > one / ratio && size < one * ratio;
    let mut along: Vec<f64> = columns_of(down, probes);
    let along = median(&mut along).unwrap_or(0.0).abs();
    if columns.len() == 3 && size >= 0.7 && along < LEAST_ALONG * size && rows.iter().all(|row| row.by != By::Recorder)
    {
        roles
            .into_iter()
            .for_each(|role| leave_out(map, role, "gravity is not along z: not the specific force of the body"));
        return;
    }
    if let Some((symbol, _)) = GRAVITIES.iter().find(|(_, one)| near(*one, GRAVITY_RATIO)) {
        give(map, probes, &roles, symbol);
        return;
    }
    if near(1000.0, GRAVITY_RATIO) {
        give(map, probes, &roles, "g");
        map.rows.iter_mut().filter(|(role, _)| roles.contains(role)).for_each(|(_, row)| row.scale = 1e-3);
        return;
    }
    let mut down = columns_of(down, probes);
    // One g is taken off the normal load factor of some recorders.
    let is_taken_off = size < 0.7 && columns.len() < 3;
    let is_flown = GRAVITIES.iter().any(|(_, one)| near(*one, FLOWN_RATIO));
    let has_none = size < 0.7 && columns.len() == 3 && median(&mut down).is_some_and(|middle| middle.abs() < 0.35);
    if has_none || !(is_taken_off || is_flown) {
        for role in roles {
            let open = |row: &&ManualChannel| row.by != By::Recorder && row.is_unit_open(probes);
            if let Some(row) = map.row(role).filter(open).cloned() {
                map.left_out.push((row.from, "no gravity in it: not the specific force".to_owned()));
                map.set(role, None);
            }
        }
    }
}

/// Temperatures of the air that are far below any in kelvin are taken for degrees Celsius.
fn settle_temperature(map: &mut ManualChannelMap, probes: &[Probe]) {
    /// Temperatures of the air, degC.
    const AIR_DEG_C: [f64; 2] = [-95.0, 60.0];
    let Ok(celsius) = Unit::parse("degC") else { return };
    for role in [Role::AirTemperature, Role::TotalTemperature] {
        let Some(row) = map.row(role).filter(|row| row.is_unit_open(probes)) else { continue };
        let is_celsius =
            recorded_extent(row, probes).is_some_and(|[least, most]| least >= AIR_DEG_C[0] && most <= AIR_DEG_C[1]);
        if is_celsius {
            map.set(role, Some(ManualChannel { unit: Some(celsius), ..row.clone() }));
        }
    }
}

/// An altitude that is called a flight level is in hundreds of feet.
fn settle_flight_level(map: &mut ManualChannelMap, probes: &[Probe]) {
    let is_level = |row: &ManualChannel| ["fl", "flightlevel"].contains(&plain_letters(&row.from.channel).as_str());
    if map.row(Role::Altitude).is_some_and(is_level) {
        give(map, probes, &[Role::Altitude], "FL");
    }
}

/// Flow angles without a unit are taken for degrees where the attitude beside them is known to be in degrees.
fn settle_flow_angles(map: &mut ManualChannelMap, probes: &[Probe]) {
    let Ok(degrees) = Unit::parse("deg") else { return };
    let Some(pitch) = map.row(Role::PitchAngle).filter(|row| !row.is_unit_open(probes) && row.unit == Some(degrees))
    else {
        return;
    };
    let source = pitch.from.source.clone();
    for (role, row) in &mut map.rows {
        let is_flow = matches!(role, Role::AngleOfAttack | Role::Sideslip);
        if is_flow && row.from.source == source && row.is_unit_open(probes) {
            row.unit = Some(degrees);
        }
    }
}

fn settle_pressure(map: &mut ManualChannelMap, probes: &[Probe]) {
    let Some(row) = map.row(Role::StaticPressure).filter(|row| row.by != By::Recorder).cloned() else { return };
    let Some([least, most]) = recorded_extent(&row, probes) else { return };
    if !row.is_unit_open(probes) {
        let unit = row.unit.unwrap_or(Unit::si(Role::StaticPressure.dimension()));
        if unit.to_si(least) < LEAST_PRESSURE_PA && !plain_letters(&row.from.channel).contains("stat") {
            leave_out(map, Role::StaticPressure, "not a pressure of the atmosphere");
        }
        return;
    }
    let mut fitting = PRESSURES.iter().filter(|(_, [low, high])| least >= *low && most <= *high).peekable();
    let middle = median(&mut columns_of(&row, probes)).unwrap_or(0.0);
    let is_of_air = PRESSURES.iter().any(|(_, [low, high])| (*low..=*high).contains(&middle));
    if !is_of_air {
        leave_out(map, Role::StaticPressure, "not a pressure of the atmosphere");
        return;
    }
    if let (Some((symbol, _)), None) = (fitting.next(), fitting.next()) {
        give(map, probes, &[Role::StaticPressure], symbol);
    }
}

/// Finite values of a row as recorded.
fn columns_of(row: &ManualChannel, probes: &[Probe]) -> Vec<f64> {
    let values = row.from.find(probes).map_or(&[][..], |channel| channel.values());
    values.iter().copied().filter(|value| value.is_finite()).collect()
}

/// Takes a role its channel, which is listed with the reason.
fn leave_out(map: &mut ManualChannelMap, role: Role, why: &str) {
    if let Some(row) = map.row(role).cloned() {
        map.left_out.push((row.from, why.to_owned()));
        map.set(role, None);
    }
}

/// Latitude and longitude share their unit: degrees where one exceeds what radians can be, otherwise the one in which the flight is neither
/// faster than anything nor stands still.
fn settle_fixes(map: &mut ManualChannelMap, probes: &[Probe]) {
    let roles = [Role::Latitude, Role::Longitude];
    let [Some(latitude), Some(longitude)] = roles.map(|role| map.row(role)) else { return };
    if !latitude.is_unit_open(probes) && !longitude.is_unit_open(probes) {
        return;
    }
    let stated = [latitude, longitude].into_iter().find(|row| !row.is_unit_open(probes)).and_then(|row| row.unit);
    if let Some(unit) = stated {
        give(map, probes, &roles, unit.symbol);
        return;
    }
    let (Some(one), Some(other)) = (recorded_extent(latitude, probes), recorded_extent(longitude, probes)) else {
        return;
    };
    let most = |[least, most]: [f64; 2]| most.max(-least);
    if latitude.scale != 1.0 || longitude.scale != 1.0 {
        give(map, probes, &roles, "deg");
    } else if most(one) > FRAC_PI_2 || most(other) > PI {
        let is_place = most(one) <= 90.0 && most(other) <= 360.0;
        if is_place {
            give(map, probes, &roles, "deg");
        } else {
            let why = "beyond 90 degrees of latitude or 360 of longitude: state its unit and scale";
            roles.into_iter().for_each(|role| leave_out(map, role, why));
        }
    } else if let Some(speed) = speed_in_radians(latitude, longitude, probes) {
        if speed > SPEEDS_M_S[1] {
            give(map, probes, &roles, "deg");
        } else if speed.to_radians() < SPEEDS_M_S[0] {
            give(map, probes, &roles, "rad");
        } else {
            // A receiver gives degrees; nothing here excludes radians, so that it is asked.
            let degrees = Unit::parse("deg").ok();
            map.rows.iter_mut().filter(|(role, _)| roles.contains(role)).for_each(|(_, row)| row.unit = degrees);
        }
    }
}

/// Speed over the ground in the mean where latitude and longitude are in radians, m/s.
fn speed_in_radians(latitude: &ManualChannel, longitude: &ManualChannel, probes: &[Probe]) -> Option<f64> {
    let source = probes.iter().flat_map(|probe| &probe.sources).find(|source| source.name == latitude.from.source)?;
    let clock = source.clocks.get(latitude.from.find(probes)?.clock?)?;
    let (north, east) = (latitude.from.find(probes)?.values(), longitude.from.find(probes)?.values());
    let pairs = north.iter().zip(east).filter(|(a, b)| a.is_finite() && b.is_finite() && **a != 0.0);
    let places: Vec<(f64, f64)> = pairs.map(|(a, b)| (*a, *b)).collect();
    let way: f64 =
        places.windows(2).map(|two| (two[1].0 - two[0].0).hypot((two[1].1 - two[0].1) * two[0].0.cos())).sum();
    let span_s = clock.end_s - clock.start_s;
    (span_s > 0.0 && way > 0.0).then(|| way * EARTH_M / span_s)
}
