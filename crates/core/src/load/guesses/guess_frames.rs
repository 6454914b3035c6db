//! Guesses of axes: sensors with their axes up, attitude as a quaternion, velocity as ground speed and track.

use crate::load::contents::{ChannelInfo, Probe};
use crate::load::guesses::candidates::{Candidate, best, row};
use crate::load::maps::attitude::QuaternionAxes;
use crate::load::maps::by_hand::{By, ManualChannel, ManualChannelMap, ManualQuaternion};
use crate::load::maps::map::{ATTITUDE, VELOCITY};
use crate::load::names::tokens::end_on;
use crate::quantity::{Role, Unit};
use crate::statistics::median;

/// Names that ROS gives the motion of a body, whose axes are forward, left, up unless the specific force says otherwise.
const ROS_NAMES: [&str; 2] = ["linear_acceleration", "angular_velocity"];
/// Ends of the names of a quaternion's parts `w, x, y, z`, those without a number first.
const PARTS: [[&str; 4]; 4] =
    [["w", "x", "y", "z"], ["real", "i", "j", "k"], ["0", "1", "2", "3"], ["1", "2", "3", "4"]];
/// Ends of the names of quaternions.
const QUATERNIONS: [&str; 4] = ["q", "quat", "quaternion", "orientation"];
/// Largest distance of a quaternion's length from one.
const LENGTH_TOLERANCE: f64 = 1e-2;
/// Tilt of an aircraft that flies upright, rad.
const UPRIGHT_RAD: f64 = 0.5;
/// Part of the other tilt that decides.
const LESS_TILTED: f64 = 0.5;
/// Degrees of a full turn, and of a step of latitude and longitude sent as whole numbers.
const DEGREES_OF_A_TURN: f64 = 360.0;
const FIX_DEG: f64 = 1e-7;
/// Names of ground speed and of the direction of flight over the ground.
const GROUND_SPEEDS: [&str; 10] =
    ["groundspeed", "gs", "gndspd", "gspd", "speedoverground", "sog", "spd", "gpsspeed", "grndspd", "grndspeed"];
const TRACKS: [&str; 16] = [
    "track", "trk", "groundtrack", "trackangle", "truetrack", "course", "cog", "gcrs", "courseoverground",
    "gpsheading", "headinggps", "headmot", "crs", "gpscourse", "gpstrack", "headingofmotion",
];

/// Whether a name in small letters is one of the direction of flight over the ground.
pub(crate) fn is_track(plain: &str) -> bool {
    TRACKS.iter().any(|name| plain == *name || (name.len() > 4 && plain.ends_with(name)))
}

/// Turns what a sensor measures to the left and up, where it measures in such axes: the specific force along z is then +g on the mean.
pub(crate) fn turn_axes_up(map: &mut ManualChannelMap) {
    if !is_up(map) {
        return;
    }
    let turned = [Role::SpecificForceY, Role::SpecificForceZ, Role::PitchRate, Role::YawRate];
    for (role, row) in &mut map.rows {
        if turned.contains(role) && has_ros_name(&row.from.channel) {
            row.turned = true;
        }
    }
}

fn has_ros_name(channel: &str) -> bool {
    ROS_NAMES.iter().any(|name| channel.starts_with(name) || channel.contains(&format!(".{name}")))
}

/// Whether the specific force is measured in axes that are turned.
fn is_up(map: &ManualChannelMap) -> bool {
    map.row(Role::SpecificForceZ).is_some_and(|row| row.turned && has_ros_name(&row.from.channel))
}

/// Whether a channel is one of X-Plane's local axes x east, y up, z south: `____X,____m`.
fn is_local_axis(row: &ManualChannel) -> bool {
    ["____X,", "____Y,", "____Z,"].iter().any(|name| row.from.channel.starts_with(name))
}

/// Position north, east and down from X-Plane's axes east, up and south, which its names `X`, `Y`, `Z` do not tell.
pub(crate) fn exchange_local_axes(map: &mut ManualChannelMap) {
    let place = [Role::PositionNorth, Role::PositionEast, Role::PositionDown];
    let [Some(x), Some(y), Some(z)] = place.map(|role| map.row(role).filter(|row| is_local_axis(row)).cloned()) else {
        return;
    };
    map.set(Role::PositionNorth, Some(ManualChannel { turned: true, ..z }));
    map.set(Role::PositionEast, Some(x));
    map.set(Role::PositionDown, Some(ManualChannel { turned: true, ..y }));
}

/// Position down that is never below its start by more than a little and above it by much is a height: it is turned, and the velocity of
/// the same vector with it.
pub(crate) fn turn_heights(map: &mut ManualChannelMap, probes: &[Probe]) {
    /// Most depth of a height, as a part of its range.
    const MOST_BELOW: f64 = 0.05;
    let Some(row) = map.row(Role::PositionDown).filter(|row| !row.turned && row.by != By::Recorder) else { return };
    if row.from.channel.to_lowercase().contains("down") || row.from.channel.to_lowercase().contains('d') {
        return;
    }
    let Some(values) = row.values(probes) else { return };
    let range = values.greatest - values.least;
    if range <= 0.0 || values.least < -MOST_BELOW * range || values.greatest < range {
        return;
    }
    let source = row.from.source.clone();
    for (role, row) in &mut map.rows {
        let is_of_vector = *role == Role::VelocityDown && row.by == By::Axes && row.from.source == source;
        if *role == Role::PositionDown || is_of_vector {
            row.turned = true;
        }
    }
}

/// Latitude and longitude of more than a turn without a unit are 1e-7 deg, as receivers send them; altitudes of whole numbers beside them
/// without a unit then mm.
pub(crate) fn scale_fixes(map: &mut ManualChannelMap, probes: &[Probe]) {
    let is_open = |row: &ManualChannel| row.is_unit_open(probes);
    let largest = |row: &ManualChannel| row.values(probes).map_or(0.0, |all| all.least.abs().max(all.greatest.abs()));
    let fixes = [Role::Latitude, Role::Longitude];
    let sent =
        fixes.iter().filter_map(|role| map.row(*role)).filter(|row| is_open(row) && largest(row) > DEGREES_OF_A_TURN);
    let Some(source) = sent.map(|row| row.from.source.clone()).next() else { return };
    let is_whole = |row: &ManualChannel| {
        let mut finite = row.from.find(probes).into_iter().flat_map(ChannelInfo::values).filter(|v| v.is_finite());
        finite.all(|value| value.fract() == 0.0)
    };
    for (role, row) in map.rows.iter_mut().filter(|(_, row)| row.from.source == source && is_open(row)) {
        match role {
            Role::Latitude | Role::Longitude => row.scale = FIX_DEG,
            Role::Altitude | Role::GpsAltitude if is_whole(row) => row.unit = Unit::parse("mm").ok(),
            _ => {}
        }
    }
}

/// Attitude from a quaternion, where bank and pitch angle have no channel of their own.
pub(crate) fn add_attitude(map: &mut ManualChannelMap, candidates: &[Candidate<'_>]) {
    if map.attitude.is_some() || (map.row(Role::BankAngle).is_some() && map.row(Role::PitchAngle).is_some()) {
        return;
    }
    let Some((source, parts)) = candidates.iter().find_map(|first| find_quaternion(first, candidates)) else { return };
    let axes = if is_up(map) { QuaternionAxes::Enu } else { QuaternionAxes::Ned };
    map.attitude = Some(ManualQuaternion { source, parts, axes });
    ATTITUDE.into_iter().for_each(|role| map.set(role, None));
}

/// Source and channels of the quaternion that begins with a channel: four of one source whose squares add up to one.
fn find_quaternion(first: &Candidate<'_>, candidates: &[Candidate<'_>]) -> Option<(String, [String; 4])> {
    PARTS.iter().find_map(|parts| read_quaternion(parts, first, candidates))
}

/// The same where the four have these ends.
fn read_quaternion(
    parts: &[&str; 4],
    first: &Candidate<'_>,
    candidates: &[Candidate<'_>],
) -> Option<(String, [String; 4])> {
    // Of `quat_w` the end is no unit.
    let stem = first.full.strip_suffix(parts[0])?;
    QUATERNIONS.iter().find(|name| stem.ends_with(**name))?;
    let part = |end: &str| {
        let name = format!("{stem}{end}");
        candidates.iter().find(|other| other.from.source == first.from.source && other.full == name)
    };
    let all = [Some(first), part(parts[1]), part(parts[2]), part(parts[3])];
    let [Some(w), Some(x), Some(y), Some(z)] = all else { return None };
    let all = [w, x, y, z];
    let count = all.iter().map(|part| part.channel.samples).min()?;
    let length =
        |k: usize| all.iter().map(|part| part.channel.values().get(k).map_or(f64::NAN, |v| v * v)).sum::<f64>();
    let mut finite = (0..count).map(length).filter(|length| length.is_finite()).peekable();
    let is_unit = finite.peek().is_some() && finite.all(|length| (length.sqrt() - 1.0).abs() < LENGTH_TOLERANCE);
    // Numbers do not say which part is the scalar: first, or last where the aircraft is tilted much less so.
    let [a, b, c, d] = all;
    let (first_rad, last_rad) = (median_tilt_rad(all, count), median_tilt_rad([d, a, b, c], count));
    let is_last =
        parts[0].starts_with(char::is_numeric) && last_rad < UPRIGHT_RAD && last_rad < LESS_TILTED * first_rad;
    let all = if is_last { [d, a, b, c] } else { all };
    is_unit.then(|| (first.from.source.clone(), all.map(|part| part.from.channel.clone())))
}

/// Median of the larger of bank and pitch, rad, by the quaternion `w, x, y, z` over `count` samples.
fn median_tilt_rad(parts: [&Candidate<'_>; 4], count: usize) -> f64 {
    let tilt_rad = |k: usize| {
        let quaternion = parts.map(|part| part.channel.values().get(k).copied().unwrap_or(f64::NAN));
        let [phi, theta, _] = QuaternionAxes::Ned.euler_rad(quaternion);
        phi.abs().max(theta.abs())
    };
    let mut tilts: Vec<f64> = (0..count).map(tilt_rad).filter(|tilt_rad| tilt_rad.is_finite()).collect();
    median(&mut tilts).unwrap_or(f64::INFINITY)
}

/// Velocity north and east from ground speed and track of one source, where they have no channels of their own.
pub(crate) fn add_velocity(map: &mut ManualChannelMap, candidates: &[Candidate<'_>]) {
    if map.velocity.is_some() || VELOCITY.iter().any(|role| map.row(*role).is_some()) {
        return;
    }
    let is = |candidate: &Candidate<'_>, name: &str| {
        candidate.plain == name || (name.len() > 2 && name != "spd" && end_on(&candidate.tokens, name))
    };
    let speed = best(candidates, &[], Role::TrueAirspeed, &GROUND_SPEEDS, &is);
    let track = best(candidates, &[], Role::HeadingAngle, &TRACKS, &is);
    let (Some(speed), Some(track)) = (speed, track) else { return };
    let (speed, track) = (&candidates[speed], &candidates[track]);
    let is_one_clock = speed.from.source == track.from.source && speed.channel.clock == track.channel.clock;
    if is_one_clock {
        map.velocity = Some([row(speed, Role::TrueAirspeed), row(track, Role::HeadingAngle)]);
    }
}

/// Attitude and velocity are either mapped or derived: derived where channels of their own do not give all of them.
pub(crate) fn keep_mapped_or_derived(map: &mut ManualChannelMap) {
    let has_all = |map: &ManualChannelMap, roles: &[Role]| roles.iter().all(|role| map.row(*role).is_some());
    if has_all(map, &ATTITUDE) {
        map.attitude = None;
    }
    if has_all(map, &VELOCITY) {
        map.velocity = None;
    }
    let is_derived = [(map.attitude.is_some(), &ATTITUDE[..]), (map.velocity.is_some(), &VELOCITY[..])];
    for (_, roles) in is_derived.into_iter().filter(|(is_derived, _)| *is_derived) {
        map.rows.retain(|(role, row)| !roles.contains(role) || row.by == By::File);
    }
}
