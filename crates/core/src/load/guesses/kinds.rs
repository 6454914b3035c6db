//! What flew where no recorder says it: by what only a multirotor, a helicopter or a rocket records.

use std::collections::BTreeSet;

use crate::load::contents::{ChannelInfo, Probe, Source};
use crate::load::guesses::motion::{ground_speed, height};
use crate::load::guesses::trace::Trace;
use crate::load::maps::by_hand::{By, ManualChannel, ManualChannelMap};
use crate::load::names::tokens::tokens;
use crate::quantity::Role;

/// Fewest motors of a multirotor.
const FEWEST_MOTORS: usize = 4;
/// Words of motors that are numbered, corners that a motor stands at, and words of what only one kind has.
const MOTORS: [&str; 7] = ["motor", "motors", "rotor", "esc", "m", "mot", "w"];
const CORNERS: [&str; 8] = ["fl", "fr", "bl", "br", "rl", "rr", "lf", "rf"];
const AT_CORNERS: [&str; 3] = ["pwm", "rpm", "thr"];
const KINDS: [(&str, &[&str]); 2] = [
    ("helicopter", &["collective", "swashplate", "swash", "cyclic"]),
    ("rocket", &["rocket", "apogee", "drogue", "liftoff", "burnout"]),
];
/// Fields of `CTUN` that only the copters of ArduPilot log (Log Messages).
const COPTER_FIELDS: [&str; 3] = ["ThH", "ABst", "DSAlt"];
/// Speed over the Earth of what hovers, at most, m/s; height above the lowest point at which it does, at least, m; part of the recording.
const HOVER_M_S: f64 = 2.5;
const HOVER_M: f64 = 3.0;
const HOVER_PART: f64 = 0.2;
/// Climb of a rocket, at least, m/s, and the speed over the Earth that an aeroplane at least has.
const ROCKET_M_S: f64 = 80.0;
const FLIGHT_M_S: f64 = 10.0;
/// Programs of ArduPilot for aeroplanes, as the first message of a log names them.
const PLANE_PROGRAMS: [&str; 2] = ["ArduPlane", "APM:Plane"];
/// Flags of an autopilot's vehicle status that are 1 of a rotary wing (PX4, `VehicleStatus.msg`).
const ROTARY_FLAGS: [&str; 2] = ["vehicle_type", "is_rotary_wing"];

/// Gives a map the kind of what flew; the motors of a multirotor are not engines.
pub(crate) fn settle(map: &mut ManualChannelMap, probes: &[Probe]) {
    map.kind = map.kind.take().or_else(|| find_kind(probes, map));
    if map.kind.as_deref().is_some_and(|kind| kind.starts_with("multirotor")) {
        free_engines(map);
    }
}

/// What flew, where the channels of `probes` say it: by what only one kind records, or by how it moved where no airspeed was recorded.
fn find_kind(probes: &[Probe], map: &ManualChannelMap) -> Option<String> {
    let sources = || probes.iter().flat_map(|probe| &probe.sources);
    if sources().any(is_copter) {
        return Some("multirotor".to_owned());
    }
    let has_airspeed = Role::AIRSPEEDS.into_iter().any(|role| {
        Trace::for_role(map, role, probes).is_none_or(|speed| speed.values.iter().any(|value| *value > FLIGHT_M_S))
            && map.row(role).is_some()
    });
    if has_airspeed {
        return None;
    }
    if sources().any(|source| is_rotary(source) || count_motors(source) >= FEWEST_MOTORS) {
        return Some("multirotor".to_owned());
    }
    let words: BTreeSet<String> =
        sources().flat_map(|source| source.channels.iter().flat_map(|channel| tokens(&channel.name))).collect();
    let found = KINDS.iter().find(|(_, names)| names.iter().any(|name| words.contains(*name)));
    // An aeroplane that is carried, or whose receiver still finds its height, seems to hover.
    let by_motion = || if sources().any(is_plane) { None } else { kind_of_motion(map, probes) };
    found.map(|(kind, _)| *kind).or_else(by_motion).map(str::to_owned)
}

/// Whether a text of the recording names the program of an autopilot for aeroplanes.
fn is_plane(source: &Source) -> bool {
    source.notes.iter().any(|(_, text)| PLANE_PROGRAMS.iter().any(|name| text.starts_with(name)))
}

/// What hovers is a multirotor or a helicopter, what climbs at once faster than any aeroplane a rocket.
fn kind_of_motion(map: &ManualChannelMap, probes: &[Probe]) -> Option<&'static str> {
    let depth = || {
        let mut depth = Trace::for_role(map, Role::PositionDown, probes)?;
        depth.values.iter_mut().for_each(|value| *value = -*value);
        Some(depth)
    };
    let height = height(map, probes).or_else(depth)?;
    let (count, span_s) = (height.values.len(), height.time_s.last()? - height.time_s.first()?);
    let lowest = height.values.iter().copied().filter(|value| value.is_finite()).fold(f64::INFINITY, f64::min);
    let speed = ground_speed(map, probes, false).and_then(|speed| speed.at(&height.time_s));
    let Some(speed) = speed else {
        #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "positive, at most the count")]
        let lag = ((count as f64 / span_s).round() as usize).max(1);
        let climb =
            |k: usize| (height.values[k + lag] - height.values[k]) / (height.time_s[k + lag] - height.time_s[k]);
        let fast = (0..count.checked_sub(lag)?).filter(|k| climb(*k) > ROCKET_M_S && climb(*k) < 1e4).count();
        let has_fixes = map.row(Role::Latitude).is_some();
        return (fast as f64 / count as f64 * span_s > 1.0 && !has_fixes).then_some("rocket");
    };
    let fastest = speed.values.iter().copied().filter(|value| value.is_finite()).fold(0.0, f64::max);
    let is_slow = fastest < 3.0 * FLIGHT_M_S;
    if is_slow && turns_from_track(map, probes) {
        return Some("multirotor or helicopter, which flies sideways or backwards");
    }
    let hovers = height.values.iter().zip(&speed.values);
    let hovers = hovers.filter(|(height, speed)| **height - lowest > HOVER_M && **speed < HOVER_M_S).count();
    let part = hovers as f64 / count as f64;
    let is_hover = part > HOVER_PART && part * span_s > 10.0 && is_slow;
    is_hover.then_some("multirotor or helicopter, which hovers")
}

/// Whether the nose points away from the track for a good part of the flight: no aeroplane flies so. A heading that follows the track
/// whatever its zero and sense is one of other axes.
fn turns_from_track(map: &ManualChannelMap, probes: &[Probe]) -> bool {
    /// Speed at which there is a track, m/s; angle of the nose from it, rad; part of the flight; share of a heading that follows it.
    const MOVES_M_S: f64 = 2.0;
    const AWAY_RAD: f64 = 60.0 * std::f64::consts::PI / 180.0;
    const PART: f64 = 0.2;
    const FOLLOWS: f64 = 0.8;
    let trace = |role| Trace::for_role(map, role, probes);
    let Some(heading) = trace(Role::HeadingAngle) else { return false };
    let [north, east] =
        [Role::VelocityNorth, Role::VelocityEast].map(|role| trace(role).and_then(|speed| speed.at(&heading.time_s)));
    let (Some(north), Some(east)) = (north, east) else { return false };
    let moving: Vec<(f64, f64)> = heading
        .values
        .iter()
        .zip(north.values.iter().zip(&east.values))
        .filter(|(heading, (north, east))| heading.is_finite() && north.hypot(**east) > MOVES_M_S)
        .map(|(heading, (north, east))| (east.atan2(*north), *heading))
        .collect();
    let count = moving.len() as f64;
    let follows = |sense: f64| {
        let angles = moving.iter().map(|(track, heading)| track - sense * heading);
        let (sin, cos) = angles.fold((0.0, 0.0), |(sin, cos), angle| (sin + angle.sin(), cos + angle.cos()));
        sin.hypot(cos) > FOLLOWS * count
    };
    let away = moving.iter().filter(|(track, heading)| (track - heading).cos() < AWAY_RAD.cos()).count();
    4 * moving.len() > heading.values.len() && away as f64 > PART * count && !follows(1.0) && !follows(-1.0)
}

/// Whether a source is a message that only copters log.
fn is_copter(source: &Source) -> bool {
    let has_copter_field = COPTER_FIELDS.iter().any(|name| source.has_channel(name));
    source.name == "MOTB" || (source.name == "CTUN" && has_copter_field && !source.has_channel("NavRoll"))
}

/// Whether the status of an autopilot says that the vehicle is a rotary wing at every time.
fn is_rotary(source: &Source) -> bool {
    let is_one = |channel: &ChannelInfo| {
        let mut finite = channel.values().iter().filter(|value| value.is_finite()).peekable();
        finite.peek().is_some() && finite.all(|value| *value == 1.0)
    };
    source.name.contains("vehicle_status")
        && source.channels.iter().any(|channel| ROTARY_FLAGS.contains(&channel.name.as_str()) && is_one(channel))
}

/// Number or corner of a motor, where a name is one of a motor; `RPM0` is one where nothing stands before.
fn find_motor(name: &str) -> Option<String> {
    let all = tokens(name);
    let is = |words: &[&str], token: &String| words.contains(&token.as_str());
    let of_motor = all.iter().position(|token| is(&MOTORS, token));
    let at = of_motor.or_else(|| all.iter().position(|token| is(&AT_CORNERS, token)))?;
    let next = all.get(at + 1)?;
    let is_numbered =
        next.bytes().all(|byte| byte.is_ascii_digit()) && (of_motor.is_some() || (at == 0 && all[0] == "rpm"));
    (is_numbered || is(&CORNERS, next)).then(|| next.clone())
}

/// Motors of a source that are told apart by a number or by their corner; an odd number is no multirotor, but weights `W0` to `W4`.
fn count_motors(source: &Source) -> usize {
    let motors: BTreeSet<_> = source.channels.iter().filter_map(|channel| find_motor(channel.label())).collect();
    if motors.len() % 2 == 0 { motors.len() } else { 0 }
}

/// Takes the speeds of the motors of a multirotor from the engines.
fn free_engines(map: &mut ManualChannelMap) {
    let is_of_motor = |row: &ManualChannel| row.by != By::File && find_motor(&row.from.channel).is_some();
    for role in [Role::EngineSpeed1, Role::EngineSpeed2] {
        if let Some(row) = map.row(role).filter(|row| is_of_motor(row)).cloned() {
            map.left_out.push((row.from, "a motor of a multirotor".to_owned()));
            map.set(role, None);
        }
    }
}

#[cfg(test)]
mod tests {
    use crate::load::guesses::guess::guess;
    use crate::load::probe_of;
    use crate::quantity::Role;

    #[test]
    fn four_motors_without_an_airspeed_are_a_multirotor() {
        let rows: String = (0..60).map(|k| format!("{},{},{},1,1\n", 0.02 * f64::from(k), k % 7, k % 5)).collect();
        for (head, wanted) in [
            ("time,motor1,motor2,motor3,motor4", Some("multirotor")),
            ("time,motor1,motor2,gear1,gear2", None),
            ("time,motor_fl,motor_fr,w_rl,w_rr", Some("multirotor")),
            ("time,RPM0,RPM1,RPM2,RPM3", Some("multirotor")),
            ("time,W0,W1,W2,W3", Some("multirotor")),
            ("time,pwm_1,pwm_2,pwm_3,pwm_4", None),
            ("time,roll,collective,flaps,fuel", Some("helicopter")),
        ] {
            let probe = probe_of(&format!("{head}\n{rows}"));
            let map = guess(&[probe]);
            assert_eq!(map.kind.as_deref(), wanted, "{head}");
            let of_five = probe_of(&format!("{head},W4\n{}", rows.replace('\n', ",1\n")));
            assert!(!head.contains("W0") || guess(&[of_five]).kind.is_none(), "weights of an estimator");
            assert!(map.row(Role::EngineSpeed1).is_none() && map.row(Role::EngineSpeed2).is_none(), "{head}");
        }
    }

    /// Kind of a flight of 60 s along a circle at 6 m/s, 40 m up, with the nose at an angle to the track.
    fn kind_with_nose(angle: impl Fn(f64) -> f64) -> Option<String> {
        let row = |k: u32| {
            let t = 0.1 * f64::from(k);
            let track = 0.2 * t;
            let (north, east) = (6.0 * track.cos(), 6.0 * track.sin());
            format!(
                "{t:.1},{north:.4},{east:.4},0.0,{:.4},40.0\n",
                (track + angle(t)).rem_euclid(std::f64::consts::TAU)
            )
        };
        let rows: String = (0..600).map(row).collect();
        let units = "time [s],v_north [m/s],v_east [m/s],v_down [m/s],heading [rad],altitude [m]";
        guess(&[probe_of(&format!("{units}\n{rows}"))]).kind
    }

    #[test]
    fn a_nose_that_turns_from_the_track_is_not_an_aeroplane() {
        assert!(kind_with_nose(|t| 0.3 * t).is_some_and(|kind| kind.starts_with("multirotor or helicopter")));
        assert_eq!(kind_with_nose(|_| 0.2), None);
        assert_eq!(kind_with_nose(|_| 1.57), None, "a heading from another zero");
    }
}
