//! What flew where no recorder says it: by what only a multirotor, a helicopter or a rocket records.

use std::collections::BTreeSet;

use crate::load::contents::{ChannelInfo, Probe, Source};
use crate::load::guesses::motion::ground_speed;
use crate::load::guesses::motion::height;
use crate::load::guesses::trace::Trace;
use crate::load::maps::by_hand::ManualChannelMap;
use crate::load::names::tokens::tokens;
use crate::quantity::Role;

/// Fewest motors of a multirotor.
const FEWEST_MOTORS: usize = 4;
/// Words of motors that are numbered, and of what only one kind has.
const MOTORS: [&str; 7] = ["motor", "motors", "rotor", "esc", "m", "mot", "w"];
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
/// Flags of an autopilot's vehicle status that are 1 of a rotary wing (PX4, `VehicleStatus.msg`).
const ROTARY_FLAGS: [&str; 2] = ["vehicle_type", "is_rotary_wing"];

/// What flew, where the channels of `probes` say it: by what only one kind records, or by how it moved where no airspeed was recorded.
pub(crate) fn find_kind(probes: &[Probe], map: &ManualChannelMap) -> Option<String> {
    let sources = || probes.iter().flat_map(|probe| &probe.sources);
    if sources().any(is_copter) {
        return Some("multirotor".to_owned());
    }
    let has_airspeed = [Role::TrueAirspeed, Role::CalibratedAirspeed].into_iter().any(|role| {
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
    found.map(|(kind, _)| *kind).or_else(|| kind_of_motion(map, probes)).map(str::to_owned)
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
    let hovers = height.values.iter().zip(&speed.values);
    let hovers = hovers.filter(|(height, speed)| **height - lowest > HOVER_M && **speed < HOVER_M_S).count();
    let fastest = speed.values.iter().copied().filter(|value| value.is_finite()).fold(0.0, f64::max);
    let part = hovers as f64 / count as f64;
    let is_hover = part > HOVER_PART && part * span_s > 10.0 && fastest < 3.0 * FLIGHT_M_S;
    is_hover.then_some("multirotor or helicopter, which hovers")
}

/// Whether a source is a message that only copters log.
fn is_copter(source: &Source) -> bool {
    let has = |name: &str| source.channels.iter().any(|channel| channel.name == name);
    source.name == "MOTB" || (source.name == "CTUN" && COPTER_FIELDS.iter().any(|name| has(name)) && !has("NavRoll"))
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

/// Motors of a source that are told apart by a number.
fn count_motors(source: &Source) -> usize {
    let number = |channel: &ChannelInfo| {
        let all = tokens(&channel.name);
        let at = all.iter().position(|token| MOTORS.contains(&token.as_str()))?;
        all.get(at + 1).filter(|token| token.bytes().all(|byte| byte.is_ascii_digit())).cloned()
    };
    source.channels.iter().filter_map(number).collect::<BTreeSet<_>>().len()
}

#[cfg(test)]
mod tests {
    use crate::load::guesses::guess::guess;
    use crate::load::probe_of;

    #[test]
    fn four_motors_without_an_airspeed_are_a_multirotor() {
        let rows: String = (0..60).map(|k| format!("{},{},{},1,1\n", 0.02 * f64::from(k), k % 7, k % 5)).collect();
        for (head, wanted) in [
            ("time,motor1,motor2,motor3,motor4", Some("multirotor")),
            ("time,motor1,motor2,gear1,gear2", None),
            ("time,roll,collective,flaps,fuel", Some("helicopter")),
        ] {
            let probe = probe_of(&format!("{head}\n{rows}"));
            assert_eq!(guess(&[probe]).kind.as_deref(), wanted, "{head}");
        }
    }
}
