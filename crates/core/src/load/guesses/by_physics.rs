//! Roles of recordings whose names say nothing, such as `ch1` or `column[4]`: by the relations between the values of the channels alone.

use crate::load::contents::Probe;
use crate::load::guesses::candidates::{Candidate, row};
use crate::load::guesses::physics::{Series, search};
use crate::load::guesses::slopes::stamps_of;
use crate::load::maps::by_hand::{By, ManualChannel, ManualChannelMap, RunnerUp};
use crate::quantity::{Role, Unit};

/// Words of names that say no more than that something is a channel.
const EMPTY_WORDS: [&str; 28] = [
    "", "c", "ch", "chan", "channel", "channels", "col", "cols", "column", "columns", "d", "data", "f", "field",
    "kanal", "param", "s", "sig", "signal", "spalte", "unnamed", "v", "val", "value", "var", "variable", "voie", "x",
];
/// Least part of the channels whose names say nothing.
const LEAST_EMPTY: f64 = 0.9;
/// Fewest and most channels that are searched.
const CHANNELS: std::ops::RangeInclusive<usize> = 5..=400;

/// Whether a name is a number, or a word for a channel with one.
pub(crate) fn is_empty_name(name: &str) -> bool {
    let word: String = name.chars().filter(|letter| letter.is_alphabetic()).collect::<String>().to_lowercase();
    EMPTY_WORDS.contains(&word.as_str()) && (word.is_empty() || name.chars().any(|letter| letter.is_ascii_digit()))
}

/// Whether the names of a recording say nothing of its channels.
pub(crate) fn names_say_nothing(candidates: &[Candidate<'_>]) -> bool {
    let empty = candidates.iter().filter(|candidate| is_empty_name(&candidate.from.channel)).count();
    CHANNELS.contains(&candidates.len()) && empty as f64 >= LEAST_EMPTY * candidates.len() as f64
}

/// A map with the roles that values alone show, where the names of a recording give none of the motion's roles and values those of the
/// rates.
pub(crate) fn find_unnamed(
    map: &ManualChannelMap,
    free: &[Candidate<'_>],
    probes: &[Probe],
) -> Option<ManualChannelMap> {
    let motion = [
        Role::SpecificForceX,
        Role::SpecificForceZ,
        Role::RollRate,
        Role::PitchRate,
        Role::YawRate,
        Role::BankAngle,
        Role::PitchAngle,
        Role::HeadingAngle,
    ];
    if !map.recorders.is_empty()
        || !CHANNELS.contains(&free.len())
        || motion.iter().any(|role| map.row(*role).is_some())
    {
        return None;
    }
    let mut found = map.clone();
    add_roles(&mut found, free, probes).then_some(found)
}

/// Stamps of the only clock of a recording that has so many, s: for channels of a part without a clock.
fn clock_of_length(samples: usize, probes: &[Probe]) -> Option<Vec<f64>> {
    let sources = probes.iter().flat_map(|probe| &probe.sources);
    let mut all = sources.flat_map(|source| source.clocks.iter().map(move |clock| (source, clock)));
    let (source, clock) = all.clone().find(|(_, clock)| clock.samples == samples)?;
    if all.any(|(_, other)| other.samples == samples && !std::ptr::eq(other, clock)) {
        return None;
    }
    let values = source.channels.get(clock.index?)?.values();
    Some(values.iter().map(|value| clock.unit.to_si(*value)).collect())
}

/// Gives roles the channels whose values are what the others make of them; every one is asked for. True where there are any.
pub(crate) fn add_roles(map: &mut ManualChannelMap, candidates: &[Candidate<'_>], probes: &[Probe]) -> bool {
    let mut stamps: Vec<(&str, Option<usize>, Vec<f64>)> = Vec::new();
    let mut clocks: Vec<usize> = Vec::with_capacity(candidates.len());
    for candidate in candidates {
        let (source, clock) = (candidate.from.source.as_str(), candidate.channel.clock);
        let is_known = |(other, index, _): &(&str, Option<usize>, Vec<f64>)| {
            *other == source && *index == clock && clock.is_some()
        };
        let known = stamps.iter().position(is_known);
        clocks.push(known.unwrap_or_else(|| {
            let own = stamps_of(&candidate.from, probes);
            let lent = || (clock.is_none()).then(|| clock_of_length(candidate.channel.samples, probes)).flatten();
            stamps.push((source, clock, own.or_else(lent).unwrap_or_default()));
            stamps.len() - 1
        }));
    }
    let series: Vec<Series<'_>> = candidates
        .iter()
        .zip(&clocks)
        .map(|(candidate, clock)| Series { time_s: &stamps[*clock].2, values: candidate.channel.values() })
        .collect();
    let all = search(&series);
    for found in &all {
        let Some(candidate) = candidates.get(found.column).filter(|_| map.row(found.role).is_none()) else { continue };
        let unit =
            found.unit.and_then(|unit| Unit::parse(unit).ok()).filter(|unit| unit.dimension == found.role.dimension());
        if candidate.unit.is_some_and(|stated| unit.is_some_and(|unit| unit.dimension != stated.dimension)) {
            continue;
        }
        let start = row(candidate, found.role);
        let made = ManualChannel {
            by: By::Physics,
            unit: unit.filter(|_| candidate.unit.is_none()).or(start.unit),
            turned: found.turned,
            offset: found.offset,
            is_unit_known: unit.is_some(),
            evidence: Some(found.evidence.clone()),
            share: Some(found.share),
            ..start
        };
        map.set(found.role, Some(made));
        if let Some((column, reason)) = &found.runner_up
            && let Some(other) = candidates.get(*column)
        {
            map.runners_up.push((found.role, RunnerUp { from: other.from.clone(), reason: reason.clone() }));
        }
    }
    map.row(Role::RollRate).is_some()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::load::guesses::guess::guess;
    use crate::load::probe_of;

    /// A flight of 40 s whose bank, pitch and heading turn together, with the rates that they make, and one more channel that is noise.
    fn flight(head: &str) -> String {
        let mut text = format!("{head}\n");
        for k in 0..2000_u32 {
            let t = 0.02 * f64::from(k);
            let (phi, theta) = (0.5 * (0.9 * t).sin(), 0.1 + 0.2 * (0.6 * t + 1.0).sin());
            let psi = 0.4 + 0.3 * t + 0.2 * (0.35 * t).sin();
            let (roll, pitch) = (0.45 * (0.9 * t).cos(), 0.12 * (0.6 * t + 1.0).cos());
            let yaw = 0.3 + 0.07 * (0.35 * t).cos();
            let p = roll - yaw * theta.sin();
            let q = pitch * phi.cos() + yaw * phi.sin() * theta.cos();
            let r = yaw * phi.cos() * theta.cos() - pitch * phi.sin();
            let wrapped = psi.to_degrees().rem_euclid(360.0);
            let noise = f64::from((k * 7919) % 101);
            let (phi, theta) = (phi.to_degrees(), theta.to_degrees());
            text += &format!("{t:.2},{noise},{r:.6},{theta:.4},{p:.6},{wrapped:.4},{q:.6},{phi:.4}\n");
        }
        text
    }

    #[test]
    fn rates_and_attitude_are_found_where_names_say_nothing() {
        let probe = probe_of(&flight("time,ch1,ch2,ch3,ch4,ch5,ch6,ch7"));
        let map = guess(std::slice::from_ref(&probe));
        for (role, channel, unit) in [
            (Role::BankAngle, "ch7", "deg"),
            (Role::PitchAngle, "ch3", "deg"),
            (Role::HeadingAngle, "ch5", "deg"),
            (Role::RollRate, "ch4", "rad/s"),
            (Role::PitchRate, "ch6", "rad/s"),
            (Role::YawRate, "ch2", "rad/s"),
        ] {
            let found = map.row(role).unwrap();
            let unit_found = found.unit.map(|unit| unit.symbol);
            assert_eq!(
                (found.from.channel.as_str(), unit_found, found.turned),
                (channel, Some(unit), false),
                "{}",
                role.name()
            );
            assert_eq!(found.by, By::Physics, "what values alone show is asked for");
            assert!(found.evidence.as_deref().is_some_and(|text| text.contains("R2")));
        }
    }

    #[test]
    fn places_are_found_by_the_path_that_they_make() {
        let plain = flight("");
        let (mut north, mut east) = (0.0, 0.0);
        let mut text = "time,ch1,ch2,ch3,ch4,ch5,ch6,ch7,ch8,ch9,ch10\n".to_owned();
        for line in plain.lines().skip(1) {
            let heading = line.split(',').nth(5).and_then(|cell| cell.parse::<f64>().ok()).unwrap().to_radians();
            // 55 m/s in a wind of 8 m/s from the north.
            let (north_m_s, east_m_s) = (55.0 * heading.cos() - 8.0, 55.0 * heading.sin());
            (north, east) = (north + 0.02 * north_m_s, east + 0.02 * east_m_s);
            let latitude = 48.7 + (north / 6.371e6_f64).to_degrees();
            let longitude = 2.35 + (east / 6.371e6_f64 / 48.7_f64.to_radians().cos()).to_degrees();
            text += &format!("{line},{longitude:.9},{:.4},{latitude:.9}\n", east_m_s * 1.943_844);
        }
        let map = guess(&[probe_of(&text)]);
        for (role, channel, unit) in
            [(Role::Latitude, "ch10", "deg"), (Role::Longitude, "ch8", "deg"), (Role::VelocityEast, "ch9", "kt")]
        {
            let found = map.row(role).unwrap();
            assert_eq!((found.from.channel.as_str(), found.unit.unwrap().symbol), (channel, unit), "{}", role.name());
        }
    }

    #[test]
    fn rates_and_attitude_are_found_where_no_name_is_known() {
        let head = "jikoku,zatsuon,yo_kakusokudo,tate_kaku,yoko_kakusokudo,houi_kaku,tate_kakusokudo,yoko_kaku";
        let map = guess(&[probe_of(&flight(head))]);
        for (role, channel) in [
            (Role::BankAngle, "yoko_kaku"),
            (Role::PitchAngle, "tate_kaku"),
            (Role::RollRate, "yoko_kakusokudo"),
            (Role::PitchRate, "tate_kakusokudo"),
            (Role::YawRate, "yo_kakusokudo"),
        ] {
            let found = map.row(role).map(|row| (row.from.channel.as_str(), row.by));
            assert_eq!(found, Some((channel, By::Physics)), "{}", role.name());
        }
    }

    #[test]
    fn names_that_say_something_are_not_searched() {
        for (name, is) in [
            ("ch12", true),
            ("column[3]", true),
            ("17", true),
            ("Var_4", true),
            ("p", false),
            ("x", false),
            ("alpha1", false),
            ("RCOU", false),
        ] {
            assert_eq!(is_empty_name(name), is, "{name}");
        }
    }

    #[test]
    fn noise_alone_plays_no_role() {
        let mut text = "time,ch1,ch2,ch3,ch4,ch5,ch6\n".to_owned();
        let mut state = 1_u64;
        for k in 0..1500_u32 {
            text += &format!("{:.2}", 0.02 * f64::from(k));
            for _ in 0..6 {
                state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
                text += &format!(",{}", (state >> 40) % 1000);
            }
            text += "\n";
        }
        let map = guess(&[probe_of(&text)]);
        assert!(map.rows.is_empty(), "{:?}", map.rows);
    }
}
