//! Control surfaces that were recorded in what is not an angle: per cent of travel, volts, counts.

use crate::load::contents::{ChannelInfo, Probe};
use crate::load::guesses::by_words::{goes_by_whole_name, names_sensor_of};
use crate::load::guesses::candidates::Candidate;
use crate::load::guesses::guess::nameable_candidates;
use crate::load::maps::by_hand::{By, ChannelName, ManualChannelMap};
use crate::load::names::stated_unit::{is_count, is_signal_unit, parse_loosely, stated_unit};
use crate::quantity::{Dimension, Role};

/// What such signals are measured in besides: per cent, the length of a pulse, that of a string.
const OTHERS: [Dimension; 3] = [Dimension::Dimensionless, Dimension::Time, Dimension::Length];

/// The channel that goes by the name of the control surface `role`, or of its sensor, and was recorded in a unit that is not one of angles, and that unit.
/// None where another channel of `map` plays the role, or what it reads has a unit.
pub fn find_surface_signal(probes: &[Probe], map: &ManualChannelMap, role: Role) -> Option<(ChannelName, String)> {
    if let Some(row) = map.row(role) {
        let unit = row.from.find(probes).and_then(signal_unit);
        return unit.filter(|_| row.by == By::Name && row.is_unit_open(probes)).map(|unit| (row.from.clone(), unit));
    }
    let candidates = nameable_candidates(probes);
    let is_free = |from: &ChannelName| {
        map.rows.iter().all(|(_, row)| row.from != *from) && map.all_left_out().all(|(out, _)| out != from)
    };
    let is_named = |candidate: &Candidate<'_>| goes_by_whole_name(candidate, role) || names_sensor_of(candidate, role);
    let mut named = candidates.iter().filter(|candidate| is_free(&candidate.from) && is_named(candidate));
    named.find_map(|candidate| Some((candidate.from.clone(), signal_unit(candidate.channel)?)))
}

/// The unit of a channel, as recorded, where it is one of signals.
fn signal_unit(channel: &ChannelInfo) -> Option<String> {
    let recorded = channel.unit.as_deref().map(str::trim).filter(|unit| !unit.is_empty());
    if let Some(recorded) = recorded.filter(|unit| parse_loosely(unit).is_none()) {
        return is_signal_unit(recorded).then(|| recorded.to_owned());
    }
    let unit = stated_unit(channel).filter(|unit| OTHERS.contains(&unit.dimension) && !is_count(*unit))?;
    Some(recorded.unwrap_or(unit.symbol).to_owned())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::load::guesses::guess::guess;
    use crate::load::probe_of;

    /// Channel and unit of the elevator of a table whose other channel it is beside.
    fn signal_of(head: &str) -> Option<(String, String)> {
        let probes = [probe_of(&format!("time,{head},note\n0.0,5,1\n0.1,60,1\n0.2,-50,1\n"))];
        let found = find_surface_signal(&probes, &guess(&probes), Role::Elevator);
        found.map(|(from, unit)| (from.channel, unit))
    }

    #[test]
    fn surfaces_in_per_cent_volts_and_counts_are_found_and_angles_and_sticks_are_not() {
        for (head, unit) in [("Elevator [%]", "%"), ("Elevator [V]", "V"), ("elevator [counts]", "counts")] {
            let name = head.split(' ').next().map(str::to_owned);
            assert_eq!(signal_of(head), name.map(|name| (name, unit.to_owned())), "{head}");
        }
        for (head, name, unit) in [
            ("Elevator (V)", "Elevator", "V"),
            ("Elevator pot [V]", "Elevator pot", "V"),
            ("elevator_lvdt [mV]", "elevator_lvdt", "mV"),
            ("Elevator string pot (counts)", "Elevator string pot", "counts"),
        ] {
            assert_eq!(signal_of(head), Some((name.to_owned(), unit.to_owned())), "{head}");
        }
        for head in [
            "Elevator pot [deg]", "Elevator supply [V]", "Elevator [deg]", "Elevator", "Elevator stick [%]",
            "Elevator trim [%]", "Elevator [N]",
        ] {
            assert_eq!(signal_of(head), None, "{head}");
        }
    }
}
