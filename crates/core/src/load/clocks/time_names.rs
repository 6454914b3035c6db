//! Names of time vectors, and the unit of time that they state.

use crate::load::names::stated_unit::{head_and_name, split_unit};
use crate::load::names::tokens::tokens;
use crate::quantity::{Dimension, Unit};

/// Names a time vector goes by, best first, in small letters, with the unit at their end taken off; blanks and underscores do not count.
const TIME_NAMES: &[&str] = &[
    "t", "time", "tt", "times", "time_vector", "timestamps", "elapsed", "elapsed_time", "timestamp", "timeus",
    "timems", "time_since_boot", "datetime", "utc", "gpst", "hhmmss", "utc_hhmmss", "utc_time", "time_utc",
    "timestamp_utc", "utc_timestamp", "gps_time", "gps_tow", "gps_sow", "gps_seconds", "gps_time_of_week", "gps_itow",
    "gms", "tow", "sow", "itow", "time_of_week", "seconds_of_week", "local_time", "lcl_time", "time_of_day",
    "_totl,_time", "header_stamp", "publish_time", "log_time", "system_time", "sample_time_fine", "sim_time",
    "simulation_time", "session_time", "flight_time", "mission_time", "mission_elapsed_time", "met", "run_time",
    "epoch", "epoch_time", "unix_time", "millis", "micros", "nanos", "time_startup", "time_boot", "seconds_elapsed",
    "elapsed_seconds", "tiempo", "x_value", "tempo", "время", "时间", "ts", "sys_time", "zeit", "tijd", "zeitstempel",
    "uhrzeit", "messzeit", "utc_zeit", "gps_zeit", "datum_zeit", "temps", "temps_utc", "temps_gps", "horodatage",
    "heure", "heure_utc",
];
/// Names whose unit is that of one message where nothing else says it: `iTOW` of u-blox receivers.
const NAMED_UNITS: &[(&str, &str)] = &[
    ("itow", "ms"),
    ("gps_itow", "ms"),
    ("gms", "ms"),
    ("time_startup", "ns"),
    ("sample_time_fine", "0.1 ms"),
    ("millis", "ms"),
    ("micros", "us"),
    ("nanos", "ns"),
];
/// Names, and last words of names, of what counts rows and is not a time.
const COUNTERS: &[&str] = &[
    "index", "idx", "sample", "samples", "frame", "count", "counter", "row", "line", "no", "nr", "n", "id", "zeile",
    "packetcounter", "packet_counter", "packet", "frame_number", "framenumber", "frame_id", "seq", "ligne", "tick",
    "ticks", "step", "cycle", "iteration",
];
/// The time that PlotJuggler writes, in s.
const PLOT_TIME: &str = "__time";
/// Names that are a unit by themselves.
const UNIT_NAMES: &[&str] = &["sec", "secs", "seconds", "ms", "milliseconds", "us", "usec", "microseconds"];
/// Words of time: a channel whose name holds one and that increases throughout is a time vector.
const TIME_WORDS: &[&str] = &[
    "time", "timestamp", "stamp", "epoch", "uptime", "millis", "micros", "nanos", "elapsed", "clock", "sec", "secs",
    "seconds", "met", "gmt", "gms", "unix", "zaman", "saat", "zeit", "temps", "tiempo", "tempo",
];
/// First words of names that end on a unit of time and are a clock: `gps_ms`.
const CLOCK_OWNERS: &[&str] =
    &["gps", "sys", "system", "boot", "host", "pc", "log", "mcu", "cpu", "unix", "run", "flight"];
/// Words beside one of time that make a duration of it, or the stamp of another sample.
const NO_TIMES: &[&str] = &[
    "remaining", "left", "delta", "dt", "delay", "latency", "duration", "interval", "period", "constant", "endurance",
    "to", "age", "last", "lag", "bat", "battery", "fuel", "hobbs",
];
/// Words of the stamp of the sample before.
const EARLIER: &[&str] = &["pre", "prev", "previous", "t0"];
/// Words behind a `t` that is a time.
const BEHIND_T: &[&str] = &["rel", "abs", "s", "ms", "us", "ns", "sec", "since", "cur", "now", "utc", "gps", "boot"];
/// Ends of names that state the unit of time.
const UNIT_ENDINGS: &[(&str, &str)] =
    &[("_ms", "ms"), ("_us", "us"), ("_ns", "ns"), ("_s", "s"), ("_sec", "s"), ("_usec", "us"), ("_msec", "ms")];

/// A name in small letters, with one sign for all that parts its words.
pub(crate) fn plain_name(name: &str) -> String {
    split_unit(name).0.trim().to_lowercase().replace([' ', '-', '.', '/'], "_")
}

/// Rank of a name among those of time vectors, the best 0, and the unit it states.
pub(crate) fn time_name(name: &str) -> Option<(usize, Option<Unit>)> {
    if name.trim() == PLOT_TIME {
        return Some((0, Unit::parse("s").ok()));
    }
    let (name, head) = split_head(name);
    let plain = plain_name(&name);
    let (stem, unit) = UNIT_ENDINGS
        .iter()
        .find_map(|(ending, unit)| Some((plain.strip_suffix(ending)?, Unit::parse(unit).ok())))
        .unwrap_or((&plain, None));
    let joined = |name: &str| name.replace('_', "");
    let is_stem = |known: &&str| joined(known) == joined(stem);
    let own = || NAMED_UNITS.iter().find(|(known, _)| is_stem(known)).and_then(|(_, unit)| Unit::parse(unit).ok());
    let known = TIME_NAMES.iter().position(is_stem).map(|rank| (rank, unit.or_else(own)));
    let is_unit = || UNIT_NAMES.contains(&plain.as_str()).then(|| (TIME_NAMES.len(), Unit::parse(&plain).ok()));
    known.or_else(is_unit).map(|(rank, unit)| (rank, head.or(unit)))
}

/// A name whose words say that it may be a time vector.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct TimeWord {
    /// Its last word, but for a unit, is one of time.
    pub(crate) is_last: bool,
    /// It is the stamp of an earlier sample.
    pub(crate) is_earlier: bool,
    pub(crate) unit: Option<Unit>,
}

/// What the words of a name say of time; nothing where none is one of time or another makes a duration of it.
pub(crate) fn read_time_word(name: &str) -> Option<TimeWord> {
    /// Ends of names that state the unit: `timeUS`, `t_rel_ms`.
    const UNITS: [(&str, &str); 11] = [
        ("ms", "ms"),
        ("us", "us"),
        ("ns", "ns"),
        ("s", "s"),
        ("sec", "s"),
        ("secs", "s"),
        ("seconds", "s"),
        ("msec", "ms"),
        ("usec", "us"),
        ("millis", "ms"),
        ("micros", "us"),
    ];
    let (name, head) = split_head(name);
    let all = tokens(&name);
    let has = |words: &[&str]| all.iter().any(|token| words.contains(&token.as_str()));
    let last = all.last()?;
    // `timestamp_sample` is the stamp of the sample.
    let is_count = COUNTERS.contains(&last.as_str()) && !(last == "sample" && has(&["timestamp", "stamp"]));
    if has(NO_TIMES) || is_count {
        return None;
    }
    let stated = UNITS.iter().find(|(ending, _)| last == ending).and_then(|(_, unit)| Unit::parse(unit).ok());
    let before = all.get(all.len().checked_sub(2)?).filter(|_| stated.is_some());
    let is_word = |token: &String| TIME_WORDS.contains(&token.as_str());
    let is_t = |token: Option<&String>| token.is_some_and(|token| token == "t");
    let begins_with_t = || is_t(all.first()) && all.get(1).is_some_and(|next| BEHIND_T.contains(&next.as_str()));
    let of_owner = || all.len() == 2 && stated.is_some() && CLOCK_OWNERS.contains(&all[0].as_str());
    if !all.iter().any(is_word) && !begins_with_t() && !is_t(before.or(Some(last))) && !of_owner() {
        return None;
    }
    let is_last = is_word(last) || before.is_some_and(is_word);
    Some(TimeWord { is_last, is_earlier: has(EARLIER), unit: head.or(stated) })
}

/// A name and the unit of time in front of it: `seconds/t`.
fn split_head(name: &str) -> (String, Option<Unit>) {
    let (name, unit) = head_and_name(name);
    match unit.filter(|unit| unit.dimension == Dimension::Time) {
        Some(unit) => (name.to_owned(), Some(unit)),
        None => (name.to_owned(), None),
    }
}

/// Whether a name, or its last word, is one of what counts rows.
pub(crate) fn is_counter(name: &str) -> bool {
    let plain = plain_name(name);
    let plain = plain.trim_matches('_');
    COUNTERS.contains(&plain)
        || tokens(name).last().is_some_and(|last| last.len() > 1 && COUNTERS.contains(&last.as_str()))
}

/// Whether a channel of this name is a time vector.
pub(crate) fn is_time_name(name: &str) -> bool {
    time_name(name).is_some()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn words_of_time_state_their_unit_and_durations_are_not_one() {
        for (name, wanted) in [
            ("host_time", Some((true, None))),
            ("seconds_since_launch", Some((false, None))),
            ("time_since_start_s", Some((false, Some("s")))),
            ("uptime_ms", Some((true, Some("ms")))),
            ("windowTimeUS", Some((true, Some("us")))),
            ("gps_ms", Some((false, Some("ms")))),
            ("t_rel", Some((false, None))),
            ("window_t", Some((false, None))),
            ("timestamp_sample", Some((false, None))),
            ("propagation_index", None),
            ("time_constant", None),
            ("bat_time", None),
            ("vel_n_ms", None),
            ("alpha_t_deg", None),
        ] {
            let found = read_time_word(name).map(|word| (word.is_last, word.unit.map(|unit| unit.symbol)));
            assert_eq!(found, wanted, "{name}");
        }
        for (name, wanted) in [
            ("millis", "ms"),
            ("Micros", "us"),
            ("seconds/t", "s"),
            ("GMS", "ms"),
            ("us", "us"),
            ("SampleTimeFine", "0.1 ms"),
        ] {
            assert_eq!(time_name(name).and_then(|(_, unit)| unit).map(|unit| unit.symbol), Some(wanted), "{name}");
        }
    }

    #[test]
    fn counters_are_known_by_their_last_word() {
        for (name, wanted) in [
            ("propagation_index", true),
            ("sample_no", true),
            ("tick", true),
            ("frame_time", false),
            ("index_s", false),
        ] {
            assert_eq!(is_counter(name), wanted, "{name}");
        }
    }
}
