//! `doublet report`: everything a session asks for, as a report.

use std::path::Path;

use doublet_engine::report::document::{SectionKind, Style};
use doublet_engine::run::Control;
use doublet_engine::study::Study;
use doublet_engine::study::dynamics::is_modelled;
use doublet_engine::{builtin, session};
use doublet_report::{Order, ReportFormat};

use crate::arguments::ReportArguments;
use crate::outcome::Outcome;
use crate::prior::compare;
use crate::progress::Progress;
use crate::run::{compute, named, outcome};
use crate::text;

/// Part of the bar that computing takes; writing takes the rest.
const COMPUTING: f32 = 0.3;

/// Runs the session and writes the report: bad where the verdict is.
///
/// # Errors
/// One line per thing because of which nothing can be computed or written; nothing is written then.
pub fn report(arguments: &ReportArguments) -> Result<Outcome, String> {
    let style = arguments.style.as_deref().map(Style::open).transpose()?.unwrap_or_default();
    // In the order they are named.
    let asked = |name: &String| SectionKind::from_name(name);
    let sections: Vec<SectionKind> = match (arguments.sections.as_slice(), style.sections.as_slice()) {
        ([], []) => SectionKind::ALL.to_vec(),
        ([], of_style) => of_style.to_vec(),
        (names, _) => names.iter().filter_map(asked).collect(),
    };
    // What was not asked for by name is left out where the session's model cannot be trimmed.
    let modelled = || session::open(&arguments.session).is_ok_and(|opened| is_modelled(&opened.session));
    let trims = !arguments.sections.is_empty() || !style.sections.is_empty() || modelled();
    let studies = sections.iter().filter_map(|section| section.study());
    let studies = studies.filter(|study| trims || !matches!(study, Study::Dynamics(_)));
    let asked = |study| match study {
        Study::Dynamics(request) => Study::Dynamics(arguments.judged.added_to(request)),
        other => other,
    };
    let studies: Vec<Study> = studies.map(asked).collect();
    let progress = Progress::new();
    let (session, snapshot) = compute(&arguments.session, &studies, &progress, COMPUTING)?;
    let order = Order {
        folder: arguments.out.clone(),
        name: file_name_of(&arguments.session),
        formats: named(&ReportFormat::ALL, &arguments.format, |format| format.name()),
        sections,
        without_appendix: arguments.no_appendix,
        prior: arguments
            .prior
            .as_ref()
            .map(|file| compare(&arguments.session, file, (&session, &snapshot)))
            .transpose()?,
        style,
    };
    let show = |part| progress.update(COMPUTING + (1.0 - COMPUTING) * part, "writing the report");
    let written = doublet_report::write(&session, &snapshot, &order, &Control::default(), &show);
    progress.finish();
    let put = written?;
    put.notes().for_each(|note| text::line(&note));
    put.files.iter().for_each(|path| text::line(&format!("report in {}", path.display())));
    Ok(outcome(&snapshot, false))
}

/// Name of the report: that of the session file, or of the shipped session without `builtin:`. Windows refuses a colon.
fn file_name_of(session: &Path) -> String {
    let stem = session.file_stem().unwrap_or_default().to_string_lossy();
    stem.strip_prefix(builtin::PREFIX).unwrap_or(&stem).to_owned()
}
