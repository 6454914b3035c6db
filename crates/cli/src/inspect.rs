//! `doublet inspect`: what a recording holds.

use doublet_core::load::{ChannelMap, Gap, Probe, Source, inspect as read_contents, plan};
use doublet_core::quantity::Unit;

use crate::arguments::InspectArguments;
use crate::{new, text};

/// Prints sources, channels, units, rates, gaps and problems of a recording.
///
/// # Errors
/// One line when the recording or the channel map cannot be read.
pub fn inspect(arguments: &InspectArguments) -> Result<(), String> {
    let probe = read_contents(&arguments.recording).map_err(|error| error.to_string())?;
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
