//! `doublet qtg`: objective tests judged on a session, as a qualification test guide.

use std::path::PathBuf;

use clap::Args;
use doublet_engine::qtg::{Qualification, TestFile, document, evaluate, prepare};
use doublet_engine::run::Control;
use doublet_engine::session;
use doublet_report::{DocumentSet, ReportFormat};

use crate::arguments::report_format;
use crate::outcome::Outcome;
use crate::progress::Progress;
use crate::run::{compute_session, named, open_to_run};
use crate::text;

/// Arguments of `qtg`.
#[derive(Debug, Args)]
pub struct QtgArguments {
    /// Session file.
    pub session: PathBuf,
    /// Tests: a file, or one that comes with the program, `builtin:qtg/demo`.
    #[arg(long, value_name = "FILE")]
    pub tests: PathBuf,
    /// Folder for the guide, its results and the copies of its data; files of an earlier guide are replaced, others never are.
    #[arg(long)]
    pub out: PathBuf,
    /// Forms of the guide.
    #[arg(long, value_name = "FORM,FORM", value_delimiter = ',', default_value = "html,pdf", value_parser = report_format())]
    pub format: Vec<String>,
    /// Print the results as one JSON document.
    #[arg(long)]
    pub json: bool,
}

/// Name of the guide and its results, without ending.
const NAME: &str = "qtg";
/// Part of the bar that computing takes; writing takes the rest.
const COMPUTING: f32 = 0.4;

/// Runs the session, judges the tests and writes the guide: bad where a test fails or cannot be judged.
///
/// # Errors
/// One line per thing because of which nothing can be judged or written; nothing is written then.
pub fn qtg(arguments: &QtgArguments) -> Result<Outcome, String> {
    let file = TestFile::open(&arguments.tests)?;
    let opened = open_to_run(&arguments.session)?;
    let prepared = prepare(&opened.session, &file);
    let stopped: Vec<_> = session::check(&prepared).into_iter().filter(session::stops_run).collect();
    if let Some(finding) = stopped.first() {
        return Err(format!(
            "{}: with the windows of {}: {finding}",
            arguments.session.display(),
            arguments.tests.display()
        ));
    }
    let progress = Progress::new();
    let snapshot = compute_session(&prepared, &opened.folder, &[], &progress, COMPUTING);
    let snapshot = snapshot.inspect_err(|_| progress.finish())?;
    let at = |error: &dyn std::fmt::Display| format!("{}: {error}", arguments.tests.display());
    let found = evaluate(&opened.session, &snapshot, &file).map_err(|error| at(&error));
    let found = found.inspect_err(|_| progress.finish())?;
    let guide = document(&opened.session, &snapshot, &file, &found);
    let json = serde_json::to_string_pretty(&found).map_err(|error| error.to_string())?;
    let mut beside = vec![(format!("{NAME}.json"), json.clone().into_bytes())];
    let copies = found.tests.iter().filter_map(|test| test.data.as_ref());
    beside.extend(copies.map(|copy| (copy.name.clone(), copy.text.clone().into_bytes())));
    let formats = named(&ReportFormat::ALL, &arguments.format, |format| format.name());
    let set = DocumentSet { folder: &arguments.out, name: NAME, formats: &formats, beside: &beside };
    let show = |part| progress.show(COMPUTING + (1.0 - COMPUTING) * part, "writing the guide");
    let written = set.write(&guide, "qualification test guide", &Control::default(), &show);
    progress.finish();
    let put = written?;
    if arguments.json {
        text::document(&json);
    } else {
        print(&found);
        put.notes().for_each(|note| text::line(&note));
        text::line(&format!("guide in {}", put.folder.display()));
    }
    Ok(if found.failed + found.not_judged > 0 { Outcome::Bad } else { Outcome::Done })
}

fn print(found: &Qualification) {
    text::line(&format!("{}, percentages {}", found.rule, found.percent));
    let rows = found.tests.iter().map(|test| {
        let outcome = test.outcome.words();
        vec![format!("{outcome} {}", test.id), format!("{}: {}", test.title, text::shortened(&test.reason, 120))]
    });
    text::list(&rows.collect::<Vec<_>>());
    text::line(&found.tally());
}
