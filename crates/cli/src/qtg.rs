//! `doublet qtg`: objective tests judged on a session, as a qualification test guide.

use std::path::PathBuf;

use clap::Args;
use doublet_engine::qtg::{CARDS, Constants, IndexStatus, NAME, Qualification, TestFile, judge};
use doublet_engine::run::Control;
use doublet_report::{DocumentSet, ReportFormat};

use crate::arguments::{REPORTS, report_format};
use crate::outcome::Outcome;
use crate::output_path::output_path;
use crate::progress::Progress;
use crate::run::{named, open_to_run};
use crate::text;

#[derive(Debug, Args)]
pub struct QtgArguments {
    /// Session file.
    pub session: PathBuf,
    /// Tests: a file, or a shipped one such as builtin:qtg/demo.
    #[arg(long, value_name = "FILE")]
    pub tests: PathBuf,
    /// Constants of the identification, or refitted to each manoeuvre [default: as FILE].
    #[arg(long, value_name = "WHICH", value_parser = ["identification", "refit"])]
    pub constants: Option<String>,
    /// Folder for the guide; only files of an earlier guide are replaced.
    #[arg(long, value_parser = output_path())]
    pub out: PathBuf,
    /// Formats of the guide.
    #[arg(long, value_name = "FORM,FORM", value_delimiter = ',', default_value = REPORTS, value_parser = report_format())]
    pub format: Vec<String>,
}

/// Part of the bar that computing takes; writing takes the rest.
const COMPUTING: f32 = 0.4;

/// Runs the session, judges the tests and writes the guide: bad where a test fails or cannot be judged.
///
/// # Errors
/// One line per thing because of which nothing can be judged or written; nothing is written then.
pub fn qtg(arguments: &QtgArguments) -> Result<Outcome, String> {
    let mut file = TestFile::open(&arguments.tests)?;
    let asked = arguments.constants.as_deref().and_then(Constants::from_name);
    file.constants = asked.unwrap_or(file.constants);
    let opened = open_to_run(&arguments.session)?;
    let progress = Progress::new();
    let show = |part: f32| progress.update(COMPUTING * part, "computing");
    let judged = judge(&opened.session, &opened.folder, &file, &Control::default(), &show);
    let judged = judged.map_err(|error| format!("{}: {error}", arguments.tests.display()));
    let judged = judged.inspect_err(|_| progress.finish())?;
    let (found, beside) = (&judged.found, judged.beside()?);
    let formats = named(&ReportFormat::ALL, &arguments.format, |format| format.name());
    let set = DocumentSet { folder: &arguments.out, name: NAME, formats: &formats, beside: &beside };
    let show = |part| progress.update(COMPUTING + (1.0 - COMPUTING) * part, "writing the guide");
    let written = set.write(&judged.guide, "qualification test guide", &Control::default(), &show);
    progress.finish();
    let put = written?;
    text::json(found)?;
    print(found);
    put.notes().for_each(|note| text::line(&note));
    text::line(&format!("guide in {}", put.folder.display()));
    if judged.cards.is_some() {
        let (cards, session) = (put.folder.join(CARDS), arguments.session.display());
        let cards = cards.display();
        text::line(&format!("cards of the missing tests: doublet campaign {cards} --session {session} --out DIR"));
    }
    Ok(if found.failed + found.not_judged > 0 { Outcome::Bad } else { Outcome::Done })
}

fn print(found: &Qualification) {
    text::line(&format!("{}, percentages {}, constants of the {}", found.rule, found.percent, found.constants));
    if !found.certainty.is_empty() {
        text::line(&format!("certainty: {}", found.certainty));
    }
    let rows = found.tests.iter().map(|test| {
        let outcome = test.outcome.label();
        vec![format!("{outcome} {}", test.id), format!("{}: {}", test.title, text::shortened(&test.reason, 120))]
    });
    text::list(&rows.collect::<Vec<_>>());
    text::line(&found.tally());
    let missing = found.index.iter().filter(|row| row.status == IndexStatus::Missing).map(|row| row.id.as_str());
    let missing: Vec<&str> = missing.collect();
    if !missing.is_empty() {
        text::line(&format!("tests of the rule without a record: {}", missing.join(", ")));
    }
}
