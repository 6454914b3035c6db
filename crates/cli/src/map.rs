//! `doublet map`: a channel map guessed for recordings, and those that come with the program.

use std::fmt::Write as _;
use std::path::PathBuf;

use clap::Args;
use doublet_core::load::{ManualChannel, Probe};
use doublet_core::quantity::Role;
use doublet_engine::begin::{self, Inspected};
use doublet_engine::confidence::weigh;
use doublet_engine::run::Control;
use doublet_engine::stage::{FlightPhysics, PhysicsRow};
use doublet_engine::{builtin, keep};
use serde_json::json;

use crate::outcome::Outcome;
use crate::output_path::output_path;
use crate::questions::{Question, changes, group, list_questions};
use crate::role_option::{FORM, says_unit, set_roles};
use crate::{text, time_option};

#[derive(Debug, Args)]
pub struct MapArguments {
    /// Recordings of one flight.
    #[arg(required_unless_present_any = ["list", "show"])]
    pub recordings: Vec<PathBuf>,
    /// Output file [default: print the map].
    #[arg(long, value_name = "FILE", value_parser = output_path())]
    pub write: Option<PathBuf>,
    /// List the maps that come with the program.
    #[arg(long, conflicts_with_all = ["recordings", "write", "show"])]
    pub list: bool,
    /// Print a map that comes with the program.
    #[arg(long, value_name = "NAME", conflicts_with_all = ["recordings", "write"])]
    pub show: Option<String>,
    /// Override a role's channel: SI value = scale x (value + offset). Repeatable.
    #[arg(long, value_name = FORM, conflicts_with_all = ["list", "show"])]
    pub role: Vec<String>,
    /// Time channel of a source and its unit. Repeatable.
    #[arg(long, value_name = time_option::FORM, conflicts_with_all = ["list", "show"])]
    pub time: Vec<String>,
}

/// Prints or writes the map that names, units and values of the channels suggest, as a start to be looked at; bad where the time can be
/// read in two ways.
pub fn map(arguments: &MapArguments) -> Result<Outcome, String> {
    if arguments.list {
        let names = builtin::names("channel_maps");
        text::json(&json!({ "version": 1, "maps": names }))?;
        names.iter().for_each(|name| text::line(name));
        return Ok(Outcome::Done);
    }
    if let Some(name) = &arguments.show {
        let known = || builtin::names("channel_maps").join(", ");
        let text = builtin::text("channel_maps", name);
        let text = text.ok_or_else(|| format!("channel map '{name}' not found: give one of {}", known()))?;
        text::json_or(&json!({ "version": 1, "map": text }), text)?;
        return Ok(Outcome::Done);
    }
    let mut inspected = begin::inspect(&arguments.recordings, &Control::default(), &|_| {})?;
    set_roles(&mut inspected, &arguments.role)?;
    time_option::set_times(&mut inspected, &arguments.time)?;
    let asked = ask(&inspected, &arguments.role);
    // What cannot be read is said by what needs it.
    let compared = begin::plan_by_hand(&inspected.probes, &inspected.guess).and_then(|plan| begin::compare(&plan)).ok();
    let against = compared.as_ref().map(find_contradictions).unwrap_or_default();
    let written = write_map(&inspected, &asked, &against)?;
    if let Some(path) = &arguments.write {
        if path.exists() {
            return Err(format!("{} exists: choose another name", path.display()));
        }
        keep::replace(path, written.as_bytes()).map_err(|error| format!("{}: {error}", path.display()))?;
    }
    if text::is_json() {
        let (roles, unused) = describe_roles(&inspected, compared.as_ref());
        text::json(&json!({
            "version": 1,
            "map": written,
            "recorders": inspected.guess.recorders,
            "names": inspected.names,
            "kind": inspected.guess.kind,
            "roles": roles,
            "unused": unused,
            "derived": inspected.guess.derivations(),
            "contradictions": against,
            "questions": asked.iter().map(|question| question.line()).collect::<Vec<_>>(),
        }))?;
    } else if let Some(path) = &arguments.write {
        asked.iter().for_each(|question| text::line(&format!("question: {}", question.line())));
        text::line(&format!("{}: check every row, then use it with --map", path.display()));
    } else {
        text::document(written.trim_end());
    }
    Ok(if asked.iter().any(|question| question.must_be_answered) { Outcome::Bad } else { Outcome::Done })
}

/// What the recordings leave open, but for the units of roles that the options `--role` say; what is asked for the same reason is one question.
pub fn ask(inspected: &Inspected, options: &[String]) -> Vec<Question> {
    let all = inspected.probes.iter().flat_map(|probe| list_questions(probe, &inspected.guess));
    group(all.filter(|question| !question.role.is_some_and(|role| says_unit(role, options))).collect())
}

/// Roles of the guess with their channels, and the channels left out with the reason of each.
fn describe_roles(
    inspected: &Inspected,
    compared: Option<&FlightPhysics>,
) -> (Vec<serde_json::Value>, Vec<serde_json::Value>) {
    let guess = &inspected.guess;
    let weighed = weigh(&inspected.probes, guess, compared);
    let roles = guess.rows.iter().zip(&weighed).map(|((role, row), weighed)| {
        let runner_up = weighed.runner_up.as_ref();
        let runner_up = runner_up
            .map(|other| json!({ "source": other.from.source, "channel": other.from.channel, "reason": other.reason }));
        json!({
            "role": role.name(),
            "source": row.from.source,
            "channel": row.from.channel,
            "other_side": row.other_side.as_ref().map(|other| json!({ "channel": other.channel, "sign": other.sign })),
            "unit": row.unit.map(|unit| unit.symbol),
            "sign": if row.turned { -1 } else { 1 },
            "scale": row.scale,
            "offset": row.offset,
            "unit_is_open": row.is_unit_open(&inspected.probes),
            "confidence": (1000.0 * weighed.confidence).round() / 1000.0,
            "evidence": weighed.evidence,
            "values": explain_row(*role, row, &inspected.probes),
            "runner_up": runner_up,
        })
    });
    let unused = guess.all_left_out();
    let unused = unused.map(|(from, why)| json!({ "source": from.source, "channel": from.channel, "reason": why }));
    (roles.collect(), unused.collect())
}

/// The guess as the text of a channel map, with the reason of every row, what is left open, and what contradicts it.
fn write_map(inspected: &Inspected, asked: &[Question], against: &[String]) -> Result<String, String> {
    let guess = &inspected.guess;
    let map = guess.text().map_err(|error| error.to_string())?;
    let mut written =
        "# Guessed from the names, units and values of the channels: check every row before use.\n".to_owned();
    for file in &inspected.names {
        _ = writeln!(written, "# Names: {}", text::harmless(&file.display().to_string()));
    }
    for question in asked {
        _ = writeln!(written, "# Question: {}", text::harmless(&question.line()));
    }
    for line in against {
        _ = writeln!(written, "# Contradiction: {}", text::harmless(line));
    }
    if let Some(kind) = guess.kind.as_deref().filter(|kind| *kind != "aeroplane") {
        _ = writeln!(written, "# Finding: not an aeroplane: {}", text::harmless(kind));
    }
    for line in guess.derivations() {
        _ = writeln!(written, "# {}", text::harmless(&line));
    }
    for line in map.lines() {
        let role = line.strip_prefix("[roles.").and_then(|line| Role::from_name(line.strip_suffix(']')?));
        if let Some((role, row)) = role.and_then(|role| Some((role, guess.row(role)?))) {
            _ = writeln!(written, "# {}", text::harmless(&explain_row(role, row, &inspected.probes)));
        }
        written.push_str(line);
        written.push('\n');
    }
    Ok(written)
}

/// What speaks against the guess among the channels themselves.
fn find_contradictions(physics: &FlightPhysics) -> Vec<String> {
    let line = |row: &PhysicsRow| match row.fix_text.as_str() {
        "" => row.headline.to_string(),
        fix_text => format!("{}; {fix_text}", row.headline),
    };
    physics.contradictions().map(line).collect()
}

/// Why a channel is taken for a role, in which unit, with which sign, scale and offset, and the values it then has.
pub fn explain_row(role: Role, row: &ManualChannel, probes: &[Probe]) -> String {
    let why = begin::unit_reason(row, probes);
    let values = row.values(probes).map_or_else(String::new, |values| {
        let number = |value: f64| text::number(value, 4);
        let (least, greatest, first) = (number(values.least), number(values.greatest), number(values.first));
        format!(": {least} to {greatest} {}, first {first}", values.unit.symbol)
    });
    let evidence = row.evidence.as_ref().map_or_else(String::new, |evidence| format!(" ({evidence})"));
    let by = row.by.description();
    let changes: String = changes(row).iter().map(|change| format!(", {change}")).collect();
    let (name, channels, source) = (role.name(), row.channels(), &row.from.source);
    format!("{name}: {channels} of {source} {by}{evidence}, unit {why}{changes}{values}")
}
