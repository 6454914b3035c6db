//! What flew where no recorder says it: by what only a multirotor, a helicopter or a rocket records.

use std::collections::BTreeSet;

use super::contents::{ChannelInfo, Probe, Source};
use super::tokens::tokens;

/// Fewest motors of a multirotor.
const FEWEST_MOTORS: usize = 4;
/// Words of motors that are numbered, and of what only one kind has.
const MOTORS: [&str; 3] = ["motor", "rotor", "esc"];
const KINDS: [(&str, &[&str]); 2] =
    [("helicopter", &["collective", "swashplate", "swash"]), ("rocket", &["rocket", "apogee", "drogue"])];
/// Flags of an autopilot's vehicle status that are 1 of a rotary wing (PX4, `VehicleStatus.msg`).
const ROTARY_FLAGS: [&str; 2] = ["vehicle_type", "is_rotary_wing"];

/// What flew, where the channels of `probes` say it and no airspeed (`has_airspeed`) was recorded.
pub(super) fn find_kind(probes: &[Probe], has_airspeed: bool) -> Option<String> {
    if has_airspeed {
        return None;
    }
    let sources = || probes.iter().flat_map(|probe| &probe.sources);
    if sources().any(|source| is_rotary(source) || count_motors(source) >= FEWEST_MOTORS) {
        return Some("multirotor".to_owned());
    }
    let words: BTreeSet<String> =
        sources().flat_map(|source| source.channels.iter().flat_map(|channel| tokens(&channel.name))).collect();
    let found = KINDS.iter().find(|(_, names)| names.iter().any(|name| words.contains(*name)));
    found.map(|(kind, _)| (*kind).to_owned())
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
    use super::super::{guess, probe_of};

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
