//! `doublet check`: a session or an aircraft file, without writing results.

use std::path::PathBuf;

use clap::Args;
use doublet_engine::check::{Checked, check_file};
use doublet_engine::verdict::{Finding, Level};

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
    for finding in &checked.findings {
        let level = if finding.level == Level::Good { "note" } else { finding.level.name() };
        text::line(&format!("{level}: {finding}"));
    }
    for row in checked.physics.iter().filter(|row| row.level > Level::Good) {
        text::line(&format!("{}: {}: {}", row.level.name(), row.headline, row.evidence));
        if !row.fix_text.is_empty() {
            text::line(&format!("  {}", row.fix_text));
        }
    }
    text::line(&ending(checked));
}

/// How many findings there are, and of which level.
fn ending(checked: &Checked) -> String {
    let against = checked.physics.iter().map(|row| row.level).filter(|level| *level > Level::Good);
    let levels: Vec<Level> = checked.findings.iter().map(|finding| finding.level).chain(against).collect();
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
