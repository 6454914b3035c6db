//! `doublet inspect`: what a recording holds.

use doublet_core::load::{
    ChannelInfo, ChannelMap, Gap, ManualChannelMap, Probe, Source, guess, inspect as read_contents, plan, stated_unit,
};
use doublet_core::quantity::{Role, Unit};
use doublet_engine::session::Surface;
use serde_json::{Value, json};

use crate::arguments::InspectArguments;
use crate::{new, text};

/// Prints sources, channels, units, rates, gaps and problems of a recording.
///
/// # Errors
/// One line when the recording or the channel map cannot be read.
pub fn inspect(arguments: &InspectArguments) -> Result<(), String> {
    let probe = read_contents(&arguments.recording).map_err(|error| error.to_string())?;
    if arguments.json {
        let document = serde_json::to_string_pretty(&describe(&probe)).map_err(|error| error.to_string())?;
        text::document(&document);
        return Ok(());
    }
    text::line(&format!("{}: {}", probe.path.display(), probe.format));
    for source in &probe.sources {
        print_source(source);
    }
    for warning in &probe.warnings {
        text::line(&format!("warning: {warning}"));
    }
    probe.sources.iter().for_each(doubts);
    if let Some(name) = &arguments.map {
        print_plan(&probe, &new::channel_map(name)?.1);
    }
    Ok(())
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
    for channel in &source.channels {
        let place = format!("warning: {}/{}", source.name, channel.name);
        if let Some(Err(error)) = channel.unit.as_deref().filter(|unit| !unit.is_empty()).map(Unit::parse) {
            text::line(&format!("{place}: {error}; give 'unit' in the channel map"));
        }
        // A channel far from the number of stamps is a parameter, not a history.
        let near = |stamps: usize| (stamps / 2..=2 * stamps).contains(&channel.samples);
        if let ([clock], None) = (&source.clocks[..], channel.clock)
            && near(clock.samples)
        {
            let (own, stamps) = (channel.samples, clock.samples);
            text::line(&format!(
                "{place} has {own} samples, '{}' {stamps}: it has no time; record it again",
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
fn describe(probe: &Probe) -> Value {
    let guessed = guess(std::slice::from_ref(probe));
    let sources: Vec<Value> = probe.sources.iter().map(|source| describe_source(source, &guessed)).collect();
    json!({
        "version": 1,
        "program": doublet_engine::PROGRAM,
        "file": probe.path.display().to_string(),
        "format": probe.format.to_string(),
        "sources": sources,
        "questions": list_questions(probe, &guessed).into_iter().map(|question| question.text).collect::<Vec<_>>(),
        "warnings": probe.warnings,
    })
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

/// What a recording leaves open.
pub struct Question {
    /// The question, with what is taken where it has no answer.
    pub text: String,
    /// Nothing is right before it is answered: there is no time, or it can be read in several units.
    pub must_be_answered: bool,
    /// Role whose unit is asked for.
    pub role: Option<Role>,
}

/// What the file leaves open: the unit of time or its absence, and units of channels that look made for a role.
pub fn list_questions(probe: &Probe, guessed: &ManualChannelMap) -> Vec<Question> {
    let clocks = probe.sources.iter().flat_map(|source| source.clocks.iter().map(move |clock| (source, clock)));
    let of_clocks = clocks.filter_map(|(source, clock)| {
        let text = format!("{}: time {}", source.name, clock.question.as_ref()?);
        Some(Question { text, must_be_answered: clock.is_unit_ambiguous, role: None })
    });
    let without_time =
        probe.sources.iter().filter(|source| plays_role(source, guessed)).filter_map(Source::missing_time);
    let without_time = without_time.map(|text| Question { text, must_be_answered: true, role: None });
    let of_units = guessed.rows.iter().filter_map(|(role, row)| {
        let channel = row.from.find(std::slice::from_ref(probe))?;
        let is_open = !row.is_unit_known && stated_unit(channel).is_none();
        let unit = row.unit.filter(|unit| is_open && unit.symbol != "-")?;
        let (source, name) = (&row.from.source, &channel.name);
        let text = format!(
            "{source}: '{name}', taken for {}, states no unit: its values look like {}",
            role.name(),
            unit.symbol
        );
        Some(Question { text, must_be_answered: false, role: Some(*role) })
    });
    let of_deflections = Surface::ALL.into_iter().filter_map(|surface| ask_deflection(probe, guessed, surface.role()));
    let of_signs = guessed.rows.iter().filter(|(_, row)| row.asks_sign).map(|(role, row)| {
        let (source, name) = (&row.from.source, &row.from.channel);
        let text = format!(
            "{source}: the sign of '{name}', taken for {}, is not documented: it is left as recorded",
            role.name()
        );
        Question { text, must_be_answered: false, role: None }
    });
    of_clocks.chain(without_time).chain(of_deflections).chain(of_units).chain(of_signs).collect()
}

/// Whether a source plays a role in the guess; every one does where none does.
fn plays_role(source: &Source, guessed: &ManualChannelMap) -> bool {
    let rows = guessed.rows.iter().map(|(_, row)| &row.from.source);
    let rows = rows.chain(guessed.attitude.iter().map(|attitude| &attitude.source));
    let mut rows = rows.chain(guessed.velocity.iter().flatten().map(|row| &row.from.source)).peekable();
    rows.peek().is_none() || rows.any(|name| *name == source.name)
}

/// Largest deflection that can be radians or a part of full travel, rad, and from which degrees can be per cent of it, deg.
const LARGEST_PART: f64 = 1.05;
const LEAST_PER_CENT: f64 = 45.0;

/// A deflection without a unit whose values are those of two: nothing in the motion tells them apart, and its derivatives go with it. Of a
/// recorder that gives other angles in radians, radians are not asked for.
fn ask_deflection(probe: &Probe, guessed: &ManualChannelMap, role: Role) -> Option<Question> {
    let probes = std::slice::from_ref(probe);
    let row = guessed.row(role).filter(|row| row.is_unit_open(probes))?;
    let values = row.values(probes)?;
    let largest = values.least.abs().max(values.greatest.abs());
    let angles = [Role::BankAngle, Role::PitchAngle, Role::HeadingAngle, Role::AngleOfAttack, Role::Sideslip];
    let mut units = angles.into_iter().filter_map(|role| guessed.row(role)?.unit);
    let (first, second) = match values.unit.symbol {
        "rad" if largest <= LARGEST_PART && units.any(|unit| unit.symbol == "deg") => {
            ("radians", "parts of full travel")
        }
        "deg" if largest > LEAST_PER_CENT && largest <= 100.0 * LARGEST_PART => ("degrees", "per cent of full travel"),
        _ => return None,
    };
    let (name, channel, symbol) = (role.name(), &row.from.channel, values.unit.symbol);
    let text = format!(
        "{}: '{channel}', taken for {name}, states no unit: {:.3} to {:.3} can be {first} or {second}; say --role \
         {name}={channel},unit={symbol}, or unit=deg,scale=X with the degrees of one",
        row.from.source, values.least, values.greatest
    );
    Some(Question { text, must_be_answered: true, role: Some(role) })
}
