//! `doublet check`: a session or an aircraft file, without writing results.

use std::path::PathBuf;

use clap::Args;
use doublet_engine::check::{Checked, check_file};
use doublet_engine::session::Place;
use doublet_engine::verdict::{Finding, Level, list_places};

use crate::outcome::Outcome;
use crate::text;

#[derive(Debug, Args)]
pub struct CheckArguments {
    /// Session or aircraft file.
    pub file: PathBuf,
}

/// Checks a session or an aircraft file and prints what it says: bad where anything found is.
pub fn check(arguments: &CheckArguments) -> Result<Outcome, String> {
    let warn = |finding: &Finding| text::error_line(&format!("{}: {finding}", finding.level.name()));
    let checked = check_file(&arguments.file, &warn);
    text::json(&checked)?;
    print(&checked);
    Ok(checked.level().into())
}

fn print(checked: &Checked) {
    if !checked.subject.is_empty() {
        text::line(&checked.subject);
    }
    let findings = gathered(&checked.findings);
    for (finding, places) in &findings {
        let level = if finding.level == Level::Good { "note" } else { finding.level.name() };
        // A finding begins with its place.
        let whole = finding.to_string();
        let sentence = whole.strip_prefix(&finding.place.to_string()).unwrap_or(&whole);
        text::line(&format!("{level}: {}{sentence}", list_places(places)));
    }
    for row in checked.physics.iter().filter(|row| row.level > Level::Good) {
        text::line(&format!("{}: {}: {}", row.level.name(), row.headline, row.evidence));
        if !row.fix_text.is_empty() {
            text::line(&format!("  {}", row.fix_text));
        }
    }
    let against = checked.physics.iter().map(|row| row.level).filter(|level| *level > Level::Good);
    text::line(&ending(&findings.iter().map(|(finding, _)| finding.level).chain(against).collect::<Vec<_>>()));
}

/// Findings that differ in their place alone, with the places, in their order.
fn gathered(findings: &[Finding]) -> Vec<(&Finding, Vec<&Place>)> {
    let mut groups: Vec<(&Finding, Vec<&Place>)> = Vec::new();
    for finding in findings {
        let is_same = |known: &Finding| {
            (known.level, known.code, &known.text, &known.fix_text)
                == (finding.level, finding.code, &finding.text, &finding.fix_text)
        };
        match groups.iter_mut().find(|(known, _)| is_same(known)) {
            Some((_, places)) => places.push(&finding.place),
            None => groups.push((finding, vec![&finding.place])),
        }
    }
    groups
}

/// How many findings are printed, and of which level.
fn ending(levels: &[Level]) -> String {
    let count = |level: Level| levels.iter().filter(|other| **other == level).count();
    let parts = [(count(Level::Bad), "bad"), (count(Level::Caution), "caution"), (count(Level::Good), "notes")];
    let parts: Vec<_> =
        parts.iter().filter(|(count, _)| *count > 0).map(|(count, of)| format!("{count} {of}")).collect();
    match levels.len() {
        0 => "no findings".to_owned(),
        1 => format!("1 finding: {}", parts.join(", ").replace("notes", "note")),
        many => format!("{many} findings: {}", parts.join(", ")),
    }
}
