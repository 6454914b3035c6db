//! Names of channels without what all channels of their source begin or end with: `Roll_deg` of `Roll_deg_ATT_Flight1`.

use std::collections::BTreeMap;

use crate::load::clocks::time_names::is_time_name;
use crate::load::contents::Source;
use crate::load::names::foreign_names::is_role_name;
use crate::load::names::role_names::is_known;
use crate::load::names::stated_unit::{is_count, name_and_unit, parse_loosely};
use crate::load::names::tokens::{forbidden, tokens};

/// Fewest channels of a source that show what is common, most of which names are compared, and the part of them that have it.
const LEAST_CHANNELS: usize = 3;
const MOST_CHANNELS: usize = 5000;
const COMMON_SHARE: f64 = 0.8;
/// What parts the words of a name.
const SIGNS: [char; 5] = ['_', ' ', '-', '.', ':'];

/// Gives the channels of a source the names by which they are recognised where most begin or end alike and more are recognised
/// without that. What is a unit, or forbids every role, stays.
pub(crate) fn label_channels(source: &mut Source) {
    let names: Vec<&str> = source.channels.iter().map(|channel| channel.name.as_str()).collect();
    if !(LEAST_CHANNELS..=MOST_CHANNELS).contains(&names.len()) {
        return;
    }
    let end = find_common(&names, |name| name.match_indices(SIGNS).map(|(at, _)| &name[at..]).collect());
    let begin =
        find_common(&names, |name| name.match_indices(SIGNS).map(|(at, sign)| &name[..at + sign.len()]).collect());
    if end.is_empty() && begin.is_empty() {
        return;
    }
    let without_end: Vec<&str> = names.iter().map(|name| name.strip_suffix(&end).unwrap_or(name)).collect();
    let labels: Vec<&str> = without_end.iter().map(|name| name.strip_prefix(&begin).unwrap_or(name)).collect();
    let count = |names: &[&str]| names.iter().filter(|name| is_recognised(name)).count();
    let best = [labels, without_end].into_iter().max_by_key(|labels| count(labels));
    let Some(best) = best.filter(|labels| count(labels) > count(&names)) else { return };
    let best: Vec<Option<String>> =
        best.iter().zip(&names).map(|(label, name)| (label != name).then(|| (*label).to_owned())).collect();
    for (channel, label) in source.channels.iter_mut().zip(best) {
        channel.label = label;
    }
}

/// The longest of the parts of names that most names have and that may be taken off; empty where none is.
fn find_common(names: &[&str], parts: impl Fn(&str) -> Vec<&str>) -> String {
    let mut counts: BTreeMap<&str, usize> = BTreeMap::new();
    for name in names {
        for part in parts(name).into_iter().filter(|part| leaves_a_name(name, part)) {
            *counts.entry(part).or_default() += 1;
        }
    }
    let is_common = |count: usize| count as f64 >= COMMON_SHARE * names.len() as f64;
    let may_go = |part: &str| {
        let is_unit = |word: &str| parse_loosely(word).is_some_and(|unit| !is_count(unit));
        forbidden(part).is_none() && !part.split(SIGNS).any(is_unit)
    };
    let all = counts.into_iter().filter(|(part, count)| is_common(*count) && may_go(part));
    all.map(|(part, _)| part).max_by_key(|part| part.len()).unwrap_or_default().to_owned()
}

/// Whether letters are left of a name without a part at one of its ends.
fn leaves_a_name(name: &str, part: &str) -> bool {
    let rest = name.strip_suffix(part).or_else(|| name.strip_prefix(part)).unwrap_or_default();
    rest.chars().any(char::is_alphabetic)
}

/// Whether a name is one of time, or ends on one of a role.
fn is_recognised(name: &str) -> bool {
    let (stem, _) = name_and_unit(name);
    let all = tokens(&stem);
    is_time_name(name) || is_role_name(&stem) || (0..all.len()).any(|from| is_known(&all[from..].concat()))
}

#[cfg(test)]
mod tests {
    use crate::load::guesses::guess::guess;
    use crate::load::probe_of;
    use crate::quantity::Role;

    /// Labels of the channels of a table with these names.
    fn labels(head: &str) -> Vec<Option<String>> {
        let row = |k: usize| {
            (0..head.split(',').count()).map(|column| format!("{}", k * 7 % (column + 5))).collect::<Vec<_>>()
        };
        let rows: String = (0..20).map(|k| row(k).join(",") + "\n").collect();
        probe_of(&format!("{head}\n{rows}")).sources[0].channels.iter().map(|channel| channel.label.clone()).collect()
    }

    #[test]
    fn what_all_names_end_on_is_taken_off_where_it_hides_them() {
        let named = |names: [&str; 4]| names.map(|name| Some(name.to_owned())).to_vec();
        assert_eq!(
            labels("Roll_deg_ATT_7_Run3,Pitch_deg_ATT_7_Run3,Yaw_deg_ATT_7_Run3,Time_US_ATT_7_Run3"),
            named(["Roll_deg", "Pitch_deg", "Yaw_deg", "Time_US"])
        );
        assert_eq!(labels("time,roll_x9,pitch_x9,yaw_x9,flap_x9")[1..], named(["roll", "pitch", "yaw", "flap"]));
        for head in [
            "gps_lat,gps_lon,gps_alt,gps_speed",
            "roll_deg,pitch_deg,yaw_deg,flap_deg",
            "roll_setpoint,pitch_setpoint,yaw_setpoint,flap_setpoint",
            "x_a,x_b,x_c,x_d",
            "gyro_x,gyro_y,gyro_z",
        ] {
            assert!(labels(head).iter().all(Option::is_none), "{head}");
        }
    }

    #[test]
    fn names_without_their_common_end_give_time_unit_and_role() {
        let row = |k: u32| format!("{},{},{},{}\n", 60_000_000 + 40_000 * k, 20 + k % 3, k % 4, 30 + k % 2);
        let rows: String = (0..50).map(row).collect();
        let probe =
            probe_of(&format!("Time_US_TAB_R5,Roll_degrees_TAB_R5,Flap_%_TAB_R5,Airspeed_mpers_TAB_R5\n{rows}"));
        let clock = &probe.sources[0].clocks[0];
        assert_eq!((clock.unit.symbol, clock.rate_hz.round()), ("us", 25.0));
        let map = guess(std::slice::from_ref(&probe));
        let unit = |role| map.row(role).and_then(|row| row.unit).map(|unit| unit.symbol);
        assert_eq!((unit(Role::BankAngle), unit(Role::Flap)), (Some("deg"), None));
        assert_eq!(unit(Role::TrueAirspeed), Some("m/s"));
    }
}
