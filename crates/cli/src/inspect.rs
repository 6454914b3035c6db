//! `doublet inspect`: what a recording holds.

use std::collections::BTreeMap;
use std::path::PathBuf;

use clap::Args;
use doublet_core::load::{
    ChannelInfo, ChannelMap, Gap, ManualChannelMap, Probe, Source, UserNames, guess_with, inspect as read_contents,
    plan, stated_unit,
};
use doublet_core::quantity::{Role, Unit};
use doublet_engine::{builtin, session};
use serde_json::{Value, json};

use crate::questions::list_questions;
use crate::{new, text};

#[derive(Debug, Args)]
pub struct InspectArguments {
    /// File, folder of one file per channel, or builtin:NAME.
    pub recording: PathBuf,
    /// Channel map (file or name of a shipped one) to apply.
    #[arg(long)]
    pub map: Option<String>,
}

/// Prints sources, channels, units, rates, gaps and problems of a recording.
pub fn inspect(arguments: &InspectArguments) -> Result<(), String> {
    let shipped = session::shipped(&arguments.recording);
    let paths = shipped.map_or_else(|| Ok(vec![arguments.recording.clone()]), shipped_recordings)?;
    let read = |path: &PathBuf| read_contents(path).map_err(|error| error.to_string());
    let probes = paths.iter().map(read).collect::<Result<Vec<_>, String>>()?;
    if text::is_json() {
        let described = probes.iter().map(describe).collect::<Result<Vec<_>, String>>()?;
        return match described.as_slice() {
            [one] => text::json(one),
            several => text::json(&json!({ "version": 1, "recordings": several })),
        };
    }
    probes.iter().try_for_each(|probe| print_probe(probe, arguments.map.as_deref()))
}

fn print_probe(probe: &Probe, map: Option<&str>) -> Result<(), String> {
    text::line(&format!("{}: {}", probe.path.display(), probe.format));
    for source in &probe.sources {
        print_source(source);
    }
    for warning in &probe.warnings {
        text::line(&format!("warning: {warning}"));
    }
    probe.sources.iter().for_each(doubts);
    if let Some(name) = map {
        print_plan(probe, &new::channel_map(name)?.1);
    }
    Ok(())
}

/// Recordings of the session `name` that comes with the program, or the file `name` itself.
fn shipped_recordings(name: &str) -> Result<Vec<PathBuf>, String> {
    let prefix = builtin::PREFIX;
    if let Some(text) = builtin::session(name) {
        let session = session::parse(text).map_err(|error| format!("{prefix}{name}: {error}"))?;
        let recordings = session.flights.iter().flat_map(|flight| &flight.recordings);
        let place = |path: &str| path.strip_prefix(prefix).map_or_else(|| Ok(PathBuf::from(path)), builtin::on_disk);
        return recordings.map(|recording| place(&recording.path)).collect();
    }
    let known = || {
        format!("{prefix}{name}: shipped recording not found: use builtin:{}", builtin::sessions().join(", builtin:"))
    };
    Ok(vec![builtin::on_disk(name).map_err(|_| known())?])
}

fn print_source(source: &Source) {
    text::line("");
    let name = if source.name.is_empty() { "(root)" } else { &source.name };
    text::line(name);
    for clock in &source.clocks {
        text::line(&format!(
            "  time '{}': {} samples, {} Hz, {} s to {} s",
            clock.channel,
            clock.samples,
            text::number(clock.rate_hz, 4),
            text::number(clock.start_s, 9),
            text::number(clock.end_s, 9)
        ));
        clock.question.iter().for_each(|question| text::line(&format!("  question: time {question}")));
        print_gaps(&clock.gaps);
        clock.faults.iter().for_each(|fault| text::line(&format!("  time {fault}")));
    }
    for (key, value) in source.notes.iter().take(LISTED_NOTES) {
        let mut lines = value.lines().map(str::trim).filter(|line| !line.is_empty());
        let first = lines.next().unwrap_or_default();
        let more = lines.count();
        let rest = if more > 0 { format!(" (and {more} more lines)") } else { String::new() };
        text::line(&format!("  {key}: {first}{rest}"));
    }
    if source.notes.len() > LISTED_NOTES {
        text::line(&format!("  and {} more lines of text", source.notes.len() - LISTED_NOTES));
    }
    let rows = source.channels.iter().map(|channel| {
        let clock = channel.clock.and_then(|index| source.clocks.get(index));
        vec![
            format!("  {}", channel.name),
            channel.unit.clone().unwrap_or_else(|| "?".to_owned()),
            channel.samples.to_string(),
            clock.map_or_else(|| "-".to_owned(), |clock| text::number(clock.rate_hz, 4)),
            channel.non_finite.map_or_else(|| "-".to_owned(), |count| count.to_string()),
            if channel.is_time { "time" } else { "" }.to_owned(),
        ]
    });
    text::table(&["  channel", "unit", "samples", "Hz", "not finite", ""], &rows.collect::<Vec<_>>());
}

/// Says which channels of a source a map cannot use as they are: of an unknown unit, or with another number of samples than its
/// only clock.
fn doubts(source: &Source) {
    let mut of_unknown_unit: BTreeMap<&str, Vec<&str>> = BTreeMap::new();
    for channel in &source.channels {
        let unit = channel.unit.as_deref().filter(|unit| !unit.is_empty() && Unit::parse(unit).is_err());
        unit.into_iter().for_each(|unit| of_unknown_unit.entry(unit).or_default().push(&channel.name));
    }
    for (unit, channels) in of_unknown_unit {
        let names = channels.join(", ");
        text::line(&format!(
            "warning: {}: unknown unit '{unit}' of {names}; give 'unit' in the channel map",
            source.name
        ));
    }
    for channel in &source.channels {
        let place = format!("warning: {}/{}", source.name, channel.name);
        // A channel far from the number of stamps is a parameter, not a history.
        let near = |stamps: usize| (stamps / 2..=2 * stamps).contains(&channel.samples);
        if let ([clock], None) = (&source.clocks[..], channel.clock)
            && near(clock.samples)
        {
            let (own, stamps) = (channel.samples, clock.samples);
            text::line(&format!(
                "{place} has {own} samples but its time channel '{}' has {stamps}: record it again",
                clock.channel
            ));
        }
    }
}

/// Gaps listed one by one; of many, the longest.
const LISTED_GAPS: usize = 3;

fn print_gaps(gaps: &[Gap]) {
    let mut longest: Vec<_> = gaps.iter().collect();
    longest.sort_by(|a, b| (b.end_s - b.start_s).total_cmp(&(a.end_s - a.start_s)));
    if longest.len() > LISTED_GAPS {
        text::line(&format!("  {} gaps, the longest:", gaps.len()));
    }
    for gap in longest.iter().take(LISTED_GAPS) {
        text::line(&format!("  gap from {} s to {} s", text::number(gap.start_s, 9), text::number(gap.end_s, 9)));
    }
}

/// Lines of text the file carries along that are shown; more are counted.
const LISTED_NOTES: usize = 6;

fn print_plan(probe: &Probe, map: &ChannelMap) {
    let plan = plan(probe, map);
    text::line("");
    let rows: Vec<_> = plan
        .roles
        .iter()
        .map(|(role, assignment)| {
            vec![role.name().to_owned(), assignment.description.clone(), assignment.unit.symbol.to_owned()]
        })
        .collect();
    text::table(&["role", "channel", "unit"], &rows);
    for problem in &plan.problems {
        text::line(&format!("{}: {}", if problem.is_error { "error" } else { "warning" }, problem.text));
    }
}

/// The recording as one document: sources with their channels, and what is to be asked.
fn describe(probe: &Probe) -> Result<Value, String> {
    let names = UserNames::read(&UserNames::folders(std::slice::from_ref(&probe.path)));
    let guessed = guess_with(std::slice::from_ref(probe), &names.map_err(|error| error.to_string())?);
    let sources: Vec<Value> = probe.sources.iter().map(|source| describe_source(source, &guessed)).collect();
    Ok(json!({
        "version": 1,
        "program": doublet_engine::PROGRAM,
        "file": probe.path.display().to_string(),
        "format": probe.format.to_string(),
        "sources": sources,
        "questions": list_questions(probe, &guessed).into_iter().map(|question| question.line()).collect::<Vec<_>>(),
        "warnings": probe.warnings,
    }))
}

fn describe_source(source: &Source, guessed: &ManualChannelMap) -> Value {
    let clock = source.clocks.first();
    let channels = source.channels.iter().map(|channel| describe_channel(source, channel, guessed));
    json!({
        "name": source.name,
        "start_s": clock.map(|clock| clock.start_s),
        "rate_hz": clock.map(|clock| clock.rate_hz),
        "samples": clock.map_or_else(|| count_samples(source), |clock| clock.samples),
        "time": clock.map(|clock| clock.channel.as_str()),
        "time_unit": clock.map(|clock| clock.unit.symbol),
        "channels": channels.collect::<Vec<Value>>(),
    })
}

fn count_samples(source: &Source) -> usize {
    source.channels.iter().map(|channel| channel.samples).max().unwrap_or(0)
}

/// A channel with its values in the unit of the file; numbers are null where none is finite.
fn describe_channel(source: &Source, channel: &ChannelInfo, guessed: &ManualChannelMap) -> Value {
    let finite = || channel.values().iter().copied().filter(|value| value.is_finite());
    let count = finite().count();
    let some = |value: f64| (count > 0).then_some(value);
    let recorded = channel.unit.clone().filter(|unit| !unit.is_empty());
    json!({
        "name": channel.name,
        "unit": recorded.or_else(|| stated_unit(channel).map(|unit| unit.symbol.to_owned())).unwrap_or_default(),
        "samples": channel.samples,
        "finite": count,
        "first": finite().next(),
        "last": finite().next_back(),
        "minimum": some(finite().fold(f64::INFINITY, f64::min)),
        "maximum": some(finite().fold(f64::NEG_INFINITY, f64::max)),
        "mean": some(finite().sum::<f64>() / count as f64),
        "role": find_role(source, channel, guessed).map(Role::name),
    })
}

/// The role a channel looks made for.
fn find_role(source: &Source, channel: &ChannelInfo, guessed: &ManualChannelMap) -> Option<Role> {
    let is_it = |from: &doublet_core::load::ChannelName| from.source == source.name && from.channel == channel.name;
    guessed.rows.iter().find(|(_, row)| is_it(&row.from)).map(|(role, _)| *role)
}
