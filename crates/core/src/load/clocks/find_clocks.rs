//! Which channels of a source are time vectors, and which channel has which.

use crate::load::clock::Clock;
use crate::load::clocks::counter::unwrap_counter;
use crate::load::clocks::labels::label_channels;
use crate::load::clocks::time_names::{TimeWord, is_counter, plain_name, read_time_word, time_name};
use crate::load::contents::{ChannelInfo, Source};
use crate::load::names::foreign_names::is_role_name;
use crate::load::names::stated_unit::stated_unit;
use crate::quantity::{Dimension, Unit};
use crate::statistics::median;

/// The name of a time vector that means another quantity where it does not increase.
const UNSURE: &str = "ts";
/// How far the median intervals of two time vectors of one table may differ, in parts of one.
const SAME_INTERVAL: f64 = 0.02;

/// The first column of a table and the unit of time it states, where nothing says that it is another quantity: neither a unit, nor a name
/// of a role, nor one of a counter of rows.
fn first_column(source: &Source) -> Option<(usize, Option<Unit>)> {
    let Some(index) = source.first_column else {
        let of_matrix = source.channels.iter().position(|channel| matches!(channel.column(), Some((_, 0))));
        return of_matrix.map(|index| (index, None));
    };
    let channel = &source.channels[index];
    if is_role_name(channel.label()) || is_counter(channel.label()) {
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
    label_channels(source);
    let mut candidates: Vec<(usize, usize, Option<Unit>)> = Vec::new();
    for (index, channel) in source.channels.iter().enumerate() {
        let rank = time_name(channel.label()).map(|(rank, _)| rank).or(channel.is_time_of_day.then_some(usize::MAX));
        let Some(rank) = rank.filter(|_| channel.samples > 1) else { continue };
        match channel.unit.as_deref().map(Unit::parse) {
            Some(Ok(unit)) if unit.dimension == Dimension::Time => candidates.push((rank, index, Some(unit))),
            Some(_) => {}
            None => candidates.push((rank, index, None)),
        }
    }
    candidates.sort_by_key(|&(rank, index, _)| (rank, index));
    for (_, index, unit) in candidates {
        let samples = source.channels[index].samples;
        if source.clocks.iter().all(|clock| clock.samples != samples) {
            fetch(source, index);
            let channel = &source.channels[index];
            if channel.label().to_lowercase() == UNSURE && !increases(channel.values()) {
                continue;
            }
            add_clock(source, index, unit);
        }
    }
    add_own_clocks(source, &mut fetch);
    add_named_by_word(source, &mut fetch);
    add_first_column(source, &mut fetch);
    if let (Some(start), Some(rate)) = (source.start_time_s.or(Some(0.0)), source.sample_rate_hz) {
        add_even_clocks(source, start, rate);
    }
    assign_clocks(source);
}

/// Whether values increase throughout.
fn increases(values: &[f64]) -> bool {
    values.len() > 2 && values.windows(2).all(|pair| pair[0] < pair[1])
}

/// Adds the clocks of lengths that have none and of which a channel has a word of time in its name and increases throughout. The last
/// word counts before others; where several are equally good, the first is used and asked about.
fn add_named_by_word(source: &mut Source, fetch: &mut impl FnMut(&mut Source, usize)) {
    let mut found: Vec<(TimeWord, usize)> = Vec::new();
    for index in 0..source.channels.len() {
        let channel = &source.channels[index];
        if source.clocks.iter().any(|clock| clock.samples == channel.samples) {
            continue;
        }
        // `_ms` is also metres per second.
        let is_other =
            || stated_unit(channel).is_some_and(|unit| unit.dimension != Dimension::Time && unit.symbol != "m/s");
        let Some(word) = read_time_word(channel.label()).filter(|_| !is_other()) else { continue };
        fetch(source, index);
        if increases(source.channels[index].values()) {
            found.push((word, index));
        }
    }
    let rank = |word: &TimeWord| (word.is_earlier, !word.is_last);
    found.sort_by_key(|(word, index)| (rank(word), *index));
    for (word, index) in &found {
        let samples = source.channels[*index].samples;
        if source.clocks.iter().any(|clock| clock.samples == samples) {
            continue;
        }
        let unit = source.channels[*index].unit.as_deref().and_then(|unit| Unit::parse(unit).ok()).or(word.unit);
        add_clock(source, *index, unit);
        let equal =
            found.iter().filter(|(other, at)| rank(other) == rank(word) && source.channels[*at].samples == samples);
        if !word.is_last || equal.count() > 1 {
            ask_about_last(source, "its name says so and it increases");
        }
    }
}

/// Asks about the clock added last.
fn ask_about_last(source: &mut Source, why: &str) {
    if let Some(clock) = source.clocks.last_mut() {
        clock.question = Some(format!("'{}' is used as time: {why}; state another in the channel map", clock.channel));
    }
}

/// Without any clock the first column of a table counts when it increases. Of a table without names a later column with the same
/// interval and more even steps counts instead: the first is then the time at which a row was written.
fn add_first_column(source: &mut Source, fetch: &mut impl FnMut(&mut Source, usize)) {
    let Some((first, unit)) = first_column(source).filter(|_| source.clocks.is_empty()) else { return };
    fetch(source, first);
    if !increases(source.channels[first].values()) {
        return;
    }
    let is_nameless = source.channels[first].column().is_some();
    let later = is_nameless.then(|| find_more_even(source, first)).flatten();
    add_clock(source, later.unwrap_or(first), unit);
    let which = if later.is_some() { "its steps are the most even" } else { "it is the first column" };
    ask_about_last(source, &format!("{which} and increases"));
}

/// The column of a table whose median interval is that of the column `first` and whose steps are more even.
fn find_more_even(source: &Source, first: usize) -> Option<usize> {
    let (interval, spread) = measure_steps(source.channels[first].values())?;
    (0..source.channels.len()).filter(|index| *index != first && increases(source.channels[*index].values())).find(
        |index| {
            measure_steps(source.channels[*index].values())
                .is_some_and(|(other, even)| (other - interval).abs() < SAME_INTERVAL * interval && even < 0.5 * spread)
        },
    )
}

/// Median interval and mean distance from it.
fn measure_steps(values: &[f64]) -> Option<(f64, f64)> {
    let mut steps: Vec<f64> = values.windows(2).map(|pair| pair[1] - pair[0]).collect();
    let interval = median(&mut steps)?;
    let spread = steps.iter().map(|step| (step - interval).abs()).sum::<f64>() / steps.len() as f64;
    Some((interval, spread))
}

/// Adds the clocks of lengths that have none yet: `motor_time` of a struct in which motors have stamps of their own.
fn add_own_clocks(source: &mut Source, fetch: &mut impl FnMut(&mut Source, usize)) {
    for index in 0..source.channels.len() {
        let channel = &source.channels[index];
        let (name, samples) = (plain_name(channel.label()), channel.samples);
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
    let stated = stated.or_else(|| time_name(channel.label())?.1);
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
            "GPS SOW [s]", "GPS TOW", "TOW [s]", "GPS_TOW", "Zeit [s]", "temps", "Temps (s)", "UTC", "timestamp",
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

    #[test]
    fn a_later_column_with_a_word_of_time_that_increases_is_the_time() {
        let text = |head: &str, step: f64| {
            let row = |k: u32| format!("{},{},{:.3}\n", k % 5, 20 + k % 3, 1000.0 + step * f64::from(k));
            format!("{head}\n{}", (0..50).map(row).collect::<String>())
        };
        for (name, step, asks) in [
            ("millis", 20.0, false),
            ("uptime_ms", 20.0, false),
            ("host_time", 0.02, false),
            ("rosbag_timestamp", 0.02, false),
            ("seconds_since_launch", 0.02, true),
            ("time_since_start_s", 0.02, true),
            ("window_t", 0.02, true),
            ("t_rel", 0.02, true),
            ("us", 20_000.0, false),
            ("seconds/t", 0.02, false),
        ] {
            let (channel, _, rate_hz, question) = time_of(&text(&format!("roll,pitch,{name}"), step)).unwrap();
            assert_eq!((channel.as_str(), rate_hz, question.is_some()), (name, 50.0, asks), "{question:?}");
        }
        for name in ["distance", "time_constant", "endurance_time"] {
            assert_eq!(time_of(&text(&format!("roll,pitch,{name}"), 0.02)), None, "{name}");
        }
        let both = "propagation_index,time_pre,time_cur\n0,5.00,5.02\n1,5.02,5.04\n2,5.04,5.06\n3,5.06,5.08\n";
        assert_eq!(time_of(both).unwrap().0, "time_cur");
    }

    #[test]
    fn of_two_times_without_names_the_more_even_one_is_taken() {
        let row = |k: u32| {
            let t = 0.02 * f64::from(k);
            format!("{:.6},{t:.2},{}\n", 7.0 + t + 1e-4 * f64::from(2 * k % 3), k % 4)
        };
        let (channel, _, rate_hz, question) = time_of(&(0..60).map(row).collect::<String>()).unwrap();
        assert_eq!((channel.as_str(), rate_hz), ("column[1]", 50.0));
        assert!(question.unwrap().contains("its steps are the most even"));
    }
}
