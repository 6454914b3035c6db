//! Which channels of a source are time vectors, and which channel has which.

use crate::load::clock::Clock;
use crate::load::clocks::counter::unwrap_counter;
use crate::load::contents::{ChannelInfo, Source};
use crate::load::names::foreign_names::is_role_name;
use crate::load::names::stated_unit::split_unit;
use crate::quantity::{Dimension, Unit};

/// Names a time vector goes by, best first, in small letters, with the unit at their end taken off; blanks and underscores do not count.
const TIME_NAMES: &[&str] = &[
    "t",
    "time",
    "tt",
    "times",
    "time_vector",
    "timestamps",
    "elapsed",
    "elapsed_time",
    "timestamp",
    "timeus",
    "timems",
    "time_since_boot",
    "datetime",
    "utc",
    "gpst",
    "hhmmss",
    "utc_hhmmss",
    "utc_time",
    "time_utc",
    "timestamp_utc",
    "utc_timestamp",
    "gps_time",
    "gps_tow",
    "gps_sow",
    "gps_seconds",
    "gps_time_of_week",
    "gps_itow",
    "tow",
    "sow",
    "itow",
    "time_of_week",
    "seconds_of_week",
    "local_time",
    "lcl_time",
    "time_of_day",
    "_totl,_time",
    "header_stamp",
    "publish_time",
    "log_time",
    "system_time",
    "sample_time_fine",
    "sim_time",
    "simulation_time",
    "session_time",
    "flight_time",
    "mission_time",
    "run_time",
    "time_startup",
    "time_boot",
    "seconds_elapsed",
    "elapsed_seconds",
    "tiempo",
    "x_value",
    "tempo",
    "время",
    "时间",
    "ts",
    "sys_time",
    "zeit",
    "tijd",
    "zeitstempel",
    "uhrzeit",
    "messzeit",
    "utc_zeit",
    "gps_zeit",
    "datum_zeit",
    "temps",
    "temps_utc",
    "temps_gps",
    "horodatage",
    "heure",
    "heure_utc",
];
/// The one of them that means another quantity where it does not increase.
const UNSURE: &str = "ts";
/// Names whose unit is that of one message where nothing else says it: `iTOW` of u-blox receivers.
const NAMED_UNITS: &[(&str, &str)] = &[("itow", "ms"), ("gps_itow", "ms"), ("time_startup", "ns")];
/// Names of what counts rows and is no time.
const COUNTERS: &[&str] = &[
    "index",
    "idx",
    "sample",
    "samples",
    "frame",
    "count",
    "counter",
    "row",
    "line",
    "no",
    "nr",
    "n",
    "id",
    "zeile",
    "packetcounter",
    "packet_counter",
    "packet",
    "frame_number",
    "framenumber",
    "frame_id",
    "seq",
    "ligne",
];
/// Names that are a unit by themselves.
const UNIT_NAMES: &[&str] = &["sec", "seconds", "ms", "milliseconds"];
/// Ends of names that state the unit of time.
const UNIT_ENDINGS: &[(&str, &str)] =
    &[("_ms", "ms"), ("_us", "us"), ("_ns", "ns"), ("_s", "s"), ("_sec", "s"), ("_usec", "us"), ("_msec", "ms")];

/// A name in small letters, with one sign for all that parts its words.
fn plain_name(name: &str) -> String {
    split_unit(name).0.trim().to_lowercase().replace([' ', '-', '.', '/'], "_")
}

/// Rank of a name among those of time vectors, the best 0, and the unit it states.
fn time_name(name: &str) -> Option<(usize, Option<Unit>)> {
    let plain = plain_name(name);
    let (stem, unit) = UNIT_ENDINGS
        .iter()
        .find_map(|(ending, unit)| Some((plain.strip_suffix(ending)?, Unit::parse(unit).ok())))
        .unwrap_or((&plain, None));
    let joined = |name: &str| name.replace('_', "");
    let is_stem = |known: &&str| joined(known) == joined(stem);
    let own = || NAMED_UNITS.iter().find(|(known, _)| is_stem(known)).and_then(|(_, unit)| Unit::parse(unit).ok());
    let known = TIME_NAMES.iter().position(is_stem).map(|rank| (rank, unit.or_else(own)));
    let is_unit = || UNIT_NAMES.contains(&plain.as_str()).then(|| (TIME_NAMES.len(), Unit::parse(&plain).ok()));
    known.or_else(is_unit)
}

/// Whether a channel of this name is a time vector.
pub(crate) fn is_time_name(name: &str) -> bool {
    time_name(name).is_some()
}

/// The first column of a table and the unit of time it states, where nothing says that it is another quantity: neither a unit, nor a name
/// of a role, nor one of a counter of rows.
fn first_column(source: &Source) -> Option<(usize, Option<Unit>)> {
    let Some(index) = source.first_column else {
        let of_matrix = source.channels.iter().position(|channel| matches!(channel.column(), Some((_, 0))));
        return of_matrix.map(|index| (index, None));
    };
    let channel = &source.channels[index];
    if is_role_name(&channel.name) || COUNTERS.contains(&plain_name(&channel.name).trim_matches('_')) {
        return None;
    }
    match channel.unit.as_deref().map(Unit::parse) {
        None => Some((index, None)),
        Some(Ok(unit)) if unit.dimension == Dimension::Time => Some((index, Some(unit))),
        Some(_) => None,
    }
}

/// Finds the time vectors of `source` by name and gives every channel the one of its length.
///
/// Without such a name the first column of a table counts when it increases strictly. Values still in the file are
/// fetched through `fetch`; a channel that cannot be fetched is no clock.
pub(crate) fn find_clocks(source: &mut Source, mut fetch: impl FnMut(&mut Source, usize)) {
    let mut candidates: Vec<(usize, usize, Option<Unit>)> = Vec::new();
    for (index, channel) in source.channels.iter().enumerate() {
        let rank = time_name(&channel.name).map(|(rank, _)| rank).or(channel.is_time_of_day.then_some(usize::MAX));
        let Some(rank) = rank.filter(|_| channel.samples > 1) else { continue };
        match channel.unit.as_deref().map(Unit::parse) {
            Some(Ok(unit)) if unit.dimension == Dimension::Time => candidates.push((rank, index, Some(unit))),
            Some(_) => {}
            None => candidates.push((rank, index, None)),
        }
    }
    candidates.sort_by_key(|&(rank, index, _)| (rank, index));
    let increases = |values: &[f64]| values.len() > 2 && values.windows(2).all(|pair| pair[0] < pair[1]);
    for (_, index, unit) in candidates {
        let samples = source.channels[index].samples;
        if source.clocks.iter().all(|clock| clock.samples != samples) {
            fetch(source, index);
            let channel = &source.channels[index];
            if channel.name.to_lowercase() == UNSURE && !increases(channel.values()) {
                continue;
            }
            add_clock(source, index, unit);
        }
    }
    add_own_clocks(source, &mut fetch, increases);
    if source.clocks.is_empty()
        && let Some((index, unit)) = first_column(source)
    {
        fetch(source, index);
        if increases(source.channels[index].values()) {
            add_clock(source, index, unit);
            let guessed = |clock: &mut Clock| {
                clock.question = Some(format!(
                    "'{}' is used as time: it is the first column and increases; state another in the channel map",
                    clock.channel
                ));
            };
            source.clocks.iter_mut().for_each(guessed);
        }
    }
    if let (Some(start), Some(rate)) = (source.start_time_s.or(Some(0.0)), source.sample_rate_hz) {
        add_even_clocks(source, start, rate);
    }
    assign_clocks(source);
}

/// Adds the clocks of lengths that have none yet: `motor_time` of a struct in which motors have stamps of their own.
fn add_own_clocks(source: &mut Source, fetch: &mut impl FnMut(&mut Source, usize), increases: impl Fn(&[f64]) -> bool) {
    for index in 0..source.channels.len() {
        let channel = &source.channels[index];
        let (name, samples) = (plain_name(&channel.name), channel.samples);
        let is_other = channel.unit.as_deref().is_some_and(|unit| {
            Unit::parse(unit).is_ok_and(|unit| unit.dimension != Dimension::Time && unit.symbol != "-")
        });
        let is_alone = source.clocks.is_empty() || source.clocks.iter().any(|clock| clock.samples == samples);
        let has_brothers = || source.channels.iter().filter(|other| other.samples == samples).count() > 1;
        if is_alone || is_other || !name.ends_with("_time") || !has_brothers() {
            continue;
        }
        fetch(source, index);
        if increases(source.channels[index].values()) {
            add_clock(source, index, None);
        }
    }
}

/// Adds the clock of a channel in the unit stated, otherwise in seconds until [`crate::load::clocks::time_unit::settle_units`] has looked at it.
fn add_clock(source: &mut Source, index: usize, unit: Option<Unit>) {
    let channel = &mut source.channels[index];
    if channel.values().is_empty() {
        return;
    }
    channel.is_time = true;
    source.clocks.push(clock_of(channel, index, unit));
}

/// The clock of the channel at `index` in a unit stated by file or map, or by its name; otherwise in seconds.
pub(crate) fn clock_of(channel: &ChannelInfo, index: usize, stated: Option<Unit>) -> Clock {
    let stated = stated.or_else(|| time_name(&channel.name)?.1);
    let unit = stated.unwrap_or(Unit::si(Dimension::Time));
    let time_s: Vec<f64> = unwrap_counter(channel.values()).iter().map(|&value| unit.to_si(value)).collect();
    Clock { is_unit_stated: stated.is_some(), ..Clock::examine(&channel.name, index, unit, &time_s) }
}

/// Adds a computed clock for every length of channel that has none.
pub(crate) fn add_even_clocks(source: &mut Source, start_s: f64, rate_hz: f64) {
    let lengths: std::collections::BTreeSet<usize> = source.channels.iter().map(|channel| channel.samples).collect();
    for samples in lengths.into_iter().filter(|&samples| samples > 1) {
        if source.clocks.iter().all(|clock| clock.samples != samples) {
            source.clocks.push(Clock {
                channel: EVEN.to_owned(),
                unit: Unit::si(Dimension::Time),
                samples,
                rate_hz,
                start_s,
                end_s: start_s + (samples - 1) as f64 / rate_hz,
                gaps: Vec::new(),
                faults: Vec::new(),
                restarts: Vec::new(),
                fault_count: 0,
                repeated: 0,
                is_unit_stated: true,
                question: None,
                is_unit_ambiguous: false,
                coarse: None,
                index: None,
            });
        }
    }
}

/// Name of a computed clock.
const EVEN: &str = "start_time + sample_rate";

/// Points every channel to the clock of its length.
pub(crate) fn assign_clocks(source: &mut Source) {
    for channel in &mut source.channels {
        channel.clock = source.clocks.iter().position(|clock| clock.samples == channel.samples);
    }
}

/// Gives a group or struct without a time vector the one of the nearest above it that fits its channels; `root` is the one above all.
pub(crate) fn inherit_clocks(sources: &mut [Source], root: &str) {
    for index in 0..sources.len() {
        if !sources[index].clocks.is_empty() {
            continue;
        }
        let fits = |above: &Source| {
            let name = &sources[index].name;
            let is_above =
                above.name == root || name.strip_prefix(&above.name).is_some_and(|rest| rest.starts_with(['/', '.']));
            let mut lengths = sources[index].channels.iter().map(|channel| channel.samples);
            let clock = above.clocks.iter().find(|clock| lengths.any(|samples| samples == clock.samples));
            clock.filter(|_| is_above).map(|clock| (above.name.len(), clock.clone()))
        };
        let nearest = sources.iter().enumerate().filter(|(other, _)| *other != index);
        let nearest = nearest.filter_map(|(other, above)| fits(above).map(|(depth, clock)| (depth, other, clock)));
        let Some((_, other, clock)) = nearest.max_by_key(|(depth, ..)| *depth) else { continue };
        let Some(time) = clock.index.map(|time| sources[other].channels[time].clone()) else { continue };
        let clock = Clock { index: Some(sources[index].channels.len()), ..clock };
        sources[index].channels.push(time);
        sources[index].clocks.push(clock);
        assign_clocks(&mut sources[index]);
    }
}

#[cfg(test)]
mod tests {
    use crate::load::guesses::guess::guess;
    use crate::load::probe_of;
    use crate::quantity::Role;

    /// Channel, start and rate of the time of a text, and what is asked about it.
    fn time_of(text: &str) -> Option<(String, f64, f64, Option<String>)> {
        let probe = probe_of(text);
        let clock = probe.sources[0].clocks.first()?;
        Some((clock.channel.clone(), clock.start_s, (clock.rate_hz * 1e3).round() / 1e3, clock.question.clone()))
    }

    #[test]
    fn stamps_with_a_date_are_the_time() {
        type Written = fn(u32) -> String;
        let stamps: [(&str, Written); 5] = [
            ("Timestamp", |ms| format!("2026-05-12 10:23:11.{ms:03}")),
            ("Datum/Zeit", |ms| format!("\"2026-05-12 10:23:11,{ms:03}\"")),
            ("recorded at", |ms| format!("2026-05-12T10:23:11.{ms:03}Z")),
            ("time", |ms| format!("2026-05-12 12:23:11.{ms:03}000+02:00")),
            ("Zeit", |ms| format!("12.05.2026 10:23:11.{ms:03}")),
        ];
        for (name, stamp) in stamps {
            let row = |k: u32| format!("{},0.{k},-9.8381\n", stamp(20 * k));
            let rows: String = (0..4).map(row).collect();
            let found = time_of(&format!("{name},Roll [deg],AZ [m/s2]\n{rows}"));
            assert_eq!(found, Some((name.to_owned(), 1_778_581_391.0, 50.0, None)), "{name}");
        }
    }

    #[test]
    fn clock_times_are_read_beside_decimal_commas() {
        for mark in ['.', ','] {
            let row = |k: u32| format!("10:23:11{mark}{:03};-0,0{k};1,75\n", 20 * k);
            let rows: String = (0..4).map(row).collect();
            let text = format!("Uhrzeit;Rollwinkel;Nickwinkel\nhh:mm:ss;°;°\n{rows}");
            assert_eq!(time_of(&text), Some(("Uhrzeit".to_owned(), 37_391.0, 50.0, None)), "{mark}");
            assert_eq!(probe_of(&text).sources[0].channels[1].values()[3], -0.03);
        }
    }

    #[test]
    fn names_of_receivers_and_of_other_languages_are_the_time() {
        let text = |name: &str, step: f64| {
            let row = |k: u32| format!("{:.2},{}\n", 388_800.0 + step * f64::from(k), k % 3);
            format!("{name},q\n{}", (0..50).map(row).collect::<String>())
        };
        for name in [
            "GPS SOW [s]",
            "GPS TOW",
            "TOW [s]",
            "GPS_TOW",
            "Zeit [s]",
            "temps",
            "Temps (s)",
            "UTC",
            "timestamp",
            "GPSTime",
        ] {
            let (_, start_s, rate_hz, question) = time_of(&text(name, 0.02)).unwrap();
            assert_eq!((start_s, rate_hz, question), (388_800.0, 50.0, None), "{name}");
        }
        let (_, start_s, rate_hz, question) = time_of(&text("iTOW", 20.0)).unwrap();
        assert_eq!((start_s, rate_hz, question), (388.8, 50.0, None), "milliseconds of the receiver's message");
    }

    #[test]
    fn the_first_named_column_is_time_where_nothing_says_that_it_is_another_quantity() {
        let text = |name: &str| {
            let row = |k: u32| format!("{:.2},{}\n", 0.02 * f64::from(k), k % 3);
            format!("{name},q\n{}", (0..50).map(row).collect::<String>())
        };
        for name in ["Bordrechner [s]", "Bordrechner"] {
            let (channel, _, rate_hz, question) = time_of(&text(name)).unwrap();
            assert_eq!((channel.as_str(), rate_hz), ("Bordrechner", 50.0));
            assert!(question.unwrap().contains("'Bordrechner' is used as time: it is the first column"), "{name}");
        }
        for name in ["Alt", "Höhe", "Weg [m]", "Index", "Nr."] {
            assert_eq!(time_of(&text(name)), None, "{name}");
        }
        assert_eq!(time_of("1.5\n2.5\n3.5\n4.5\n"), None, "a single column");
        let rows: String = (0..9).map(|k| format!("{k},{}\n", k % 3)).collect();
        let probe = probe_of(&format!("alt,q\n{rows}"));
        assert!(guess(std::slice::from_ref(&probe)).row(Role::Altitude).is_some());
    }
}
