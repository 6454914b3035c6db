//! Which channels of a source are time vectors, and which channel has which.

use super::clock::Clock;
use super::contents::{ChannelInfo, Source};
use super::text_layout::split_unit;
use crate::quantity::{Dimension, Unit};

/// Names a time vector goes by, best first, in small letters, with the unit at their end taken off.
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
    "utc",
    "utc_time",
    "gps_time",
    "gps_tow",
    "tow",
    "local_time",
    "lcl_time",
    "time_of_day",
    "_totl,_time",
    "header_stamp",
    "publish_time",
    "log_time",
    "zeit",
    "temps",
];
/// Names that are a unit by themselves.
const UNIT_NAMES: &[&str] = &["sec", "seconds", "ms", "milliseconds"];
/// Ends of names that state the unit of time.
const UNIT_ENDINGS: &[(&str, &str)] =
    &[("_ms", "ms"), ("_us", "us"), ("_ns", "ns"), ("_s", "s"), ("_sec", "s"), ("_usec", "us"), ("_msec", "ms")];

/// Rank of a name among those of time vectors, the best 0, and the unit it states.
fn time_name(name: &str) -> Option<(usize, Option<Unit>)> {
    let plain = split_unit(name).0.trim().to_lowercase().replace([' ', '-', '.'], "_");
    let (stem, unit) = UNIT_ENDINGS
        .iter()
        .find_map(|(ending, unit)| Some((plain.strip_suffix(ending)?, Unit::parse(unit).ok())))
        .unwrap_or((&plain, None));
    let known = TIME_NAMES.iter().position(|known| *known == stem).map(|rank| (rank, unit));
    let is_unit = || UNIT_NAMES.contains(&plain.as_str()).then(|| (TIME_NAMES.len(), Unit::parse(&plain).ok()));
    known.or_else(is_unit)
}

/// Finds the time vectors of `source` by name and gives every channel the one of its length.
///
/// Without such a name the first column of a table counts when it increases strictly. Values still in the file are
/// fetched through `fetch`; a channel that cannot be fetched is no clock.
pub(super) fn find_clocks(source: &mut Source, mut fetch: impl FnMut(&mut Source, usize)) {
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
    for (_, index, unit) in candidates {
        let samples = source.channels[index].samples;
        if source.clocks.iter().all(|clock| clock.samples != samples) {
            fetch(source, index);
            add_clock(source, index, unit);
        }
    }
    if source.clocks.is_empty() {
        let first = source.channels.iter().position(|channel| matches!(channel.column(), Some((_, 0))));
        let increases = |values: &[f64]| values.len() > 2 && values.windows(2).all(|pair| pair[0] < pair[1]);
        if let Some(index) = first {
            fetch(source, index);
            if increases(source.channels[index].values()) {
                add_clock(source, index, None);
                let guessed = |clock: &mut Clock| {
                    clock.question = Some(format!(
                        "'{}' is taken for it, as the first column, which increases; name the right one in the map's [[time]]",
                        clock.channel
                    ));
                };
                source.clocks.iter_mut().for_each(guessed);
            }
        }
    }
    if let (Some(start), Some(rate)) = (source.start_time_s.or(Some(0.0)), source.sample_rate_hz) {
        add_even_clocks(source, start, rate);
    }
    assign_clocks(source);
}

/// Adds the clock of a channel in the unit stated, otherwise in seconds until [`super::time_unit::settle_units`] has looked at it.
fn add_clock(source: &mut Source, index: usize, unit: Option<Unit>) {
    let channel = &mut source.channels[index];
    if channel.values().is_empty() {
        return;
    }
    channel.is_time = true;
    source.clocks.push(clock_of(channel, index, unit));
}

/// The clock of the channel at `index` in a unit stated by file or map, or by its name; otherwise in seconds.
pub(super) fn clock_of(channel: &ChannelInfo, index: usize, stated: Option<Unit>) -> Clock {
    let stated = stated.or_else(|| time_name(&channel.name)?.1);
    let unit = stated.unwrap_or(Unit::si(Dimension::Time));
    let time_s: Vec<f64> = channel.values().iter().map(|&value| unit.to_si(value)).collect();
    Clock { is_unit_stated: stated.is_some(), ..Clock::examine(&channel.name, index, unit, &time_s) }
}

/// Adds a computed clock for every length of channel that has none.
pub(super) fn add_even_clocks(source: &mut Source, start_s: f64, rate_hz: f64) {
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
                fault_count: 0,
                is_unit_stated: true,
                question: None,
                is_unit_ambiguous: false,
                index: None,
            });
        }
    }
}

/// Name of a computed clock.
const EVEN: &str = "start_time + sample_rate";

/// Points every channel to the clock of its length.
pub(super) fn assign_clocks(source: &mut Source) {
    for channel in &mut source.channels {
        channel.clock = source.clocks.iter().position(|clock| clock.samples == channel.samples);
    }
}
