//! `doublet run`: everything a session asks for, into a folder.

use std::path::{Path, PathBuf};

use clap::Args;
use clap::builder::{PossibleValue, PossibleValuesParser, TypedValueParser};
use doublet_engine::check::warn_once;
use doublet_engine::graph::Cache;
use doublet_engine::keep;
use doublet_engine::report::{self, HistoryFormat, Outputs, TableFormat};
use doublet_engine::run::{Control, Scope, Snapshot, run as run_stages};
use doublet_engine::session::{self, Opened, Place, Session};
use doublet_engine::study::Study;
use doublet_engine::verdict::{Level, list_failures};

use crate::outcome::Outcome;
use crate::output_path::output_path;
use crate::progress::Progress;
use crate::{summary, text};

#[derive(Debug, Args)]
pub struct RunArguments {
    /// Session file.
    pub session: PathBuf,
    /// Folder for the results; appears only when complete.
    #[arg(long, value_parser = output_path())]
    pub out: PathBuf,
    /// Additional studies to compute.
    #[arg(long, value_name = "STUDY,...", value_delimiter = ',', value_parser = study())]
    pub with: Vec<Study>,
    /// Formats of the tables.
    #[arg(long, value_name = "FORM,FORM", value_delimiter = ',', default_value = "csv", value_parser = table_format())]
    pub tables: Vec<String>,
    /// Formats of the time histories.
    #[arg(long, value_name = "FORM,FORM", value_delimiter = ',', default_value = "hdf5", value_parser = history_format())]
    pub histories: Vec<String>,
    /// Include every recorded channel in the time histories.
    #[arg(long)]
    pub recordings: bool,
    /// Exit with code 3 also if the verdict is caution.
    #[arg(long)]
    pub strict: bool,
    /// Print all manoeuvres, tables and findings.
    #[arg(long)]
    pub verbose: bool,
}

/// Memory for intermediate results of one run, which its studies ask for again; without studies nothing does.
pub const CACHE_BYTES: usize = 2 << 30;

/// Opens the session and computes everything it asks for; the bar goes up to `share` of its length. What fails leaves its error in
/// its place and does not take the rest with it.
pub fn compute(path: &Path, studies: &[Study], progress: &Progress, share: f32) -> Result<(Session, Snapshot), String> {
    let opened = open_to_run(path)?;
    let snapshot = compute_session(&opened.session, &opened.folder, studies, progress, share)?;
    Ok((opened.session, snapshot))
}

/// Opens a session that can be run.
pub fn open_to_run(path: &Path) -> Result<Opened, String> {
    let opened = session::open(path).map_err(|error| format!("{}: {error}", path.display()))?;
    let stopped: Vec<_> = session::check(&opened.session).into_iter().filter(session::stops_run).collect();
    if stopped.is_empty() {
        return Ok(opened);
    }
    Err(lines(stopped.iter().map(|finding| format!("{}: {finding}", path.display())).collect()))
}

/// Checks that a file to be written is neither the session or recording `source` nor what that names.
pub fn check_written(written: &Path, source: &Path) -> Result<(), String> {
    keep::check_apart(written, [source.to_path_buf()])?;
    if source.extension().is_none_or(|ending| ending != "toml") {
        return Ok(());
    }
    // What cannot be read says so where it is read.
    session::open(source).map_or(Ok(()), |opened| session::check_output(&opened.session, &opened.folder, written))
}

/// The session with its relative paths from the folder `to` in place of `from`; an empty one is the working folder.
pub fn rebase(session: &Session, from: &Path, to: &Path) -> Result<Session, String> {
    let absolute = |folder: &Path| {
        let folder = if folder == Path::new("") { Path::new(".") } else { folder };
        std::path::absolute(folder).map_err(|error| format!("{}: {error}", folder.display()))
    };
    Ok(session::rebased(session, &absolute(from)?, &absolute(to)?))
}

/// Computes a session whose relative paths start from `folder`.
pub fn compute_session(
    session: &Session,
    folder: &Path,
    studies: &[Study],
    progress: &Progress,
    share: f32,
) -> Result<Snapshot, String> {
    let warn = warn_once(|finding| progress.error_line(&format!("{}: {finding}", finding.level.name())));
    let publish = |snapshot: Snapshot| {
        progress.update(share * snapshot.progress, "computing");
        warn(snapshot);
    };
    let scope = Scope { session, folder, first: None, studies, cause: "run", generation: 1 };
    let cache = Cache::new(if studies.is_empty() { 0 } else { CACHE_BYTES });
    let snapshot = run_stages(&scope, &Snapshot::default(), &cache, &Control::default(), &publish);
    let failures = snapshot.failures();
    let computed = snapshot.windows.values().any(|window| window.path.ready().is_some());
    if !(computed || failures.is_empty()) {
        return Err(lines(list_failures(&failures)));
    }
    Ok(snapshot)
}

/// A session and everything that follows from it, studies included. Windows and coefficients that failed are said and left out.
pub fn computed(path: &Path, studies: &[Study]) -> Result<(Session, Snapshot), String> {
    let progress = Progress::new();
    let result = compute(path, studies, &progress, 1.0);
    progress.finish();
    let (session, snapshot) = result?;
    let is_study = |(place, _): &(Place, String)| studies.iter().any(|study| place.is_named(study.name()));
    let (without, failed): (Vec<_>, Vec<_>) = failed(&snapshot).into_iter().partition(is_study);
    list_failures(&failed).iter().for_each(|failure| print_error(failure));
    if without.is_empty() { Ok((session, snapshot)) } else { Err(lines(list_failures(&without))) }
}

/// Everything that failed, with its place: stages, then coefficients.
fn failed(snapshot: &Snapshot) -> Vec<(Place, String)> {
    snapshot.failures().into_iter().chain(snapshot.failed_fits()).collect()
}

/// Says what could not be computed beside what could.
pub fn print_error(error: &str) {
    text::error_line(&format!("error: {error}"));
}

/// How a command ends that does the same for every coefficient and did it for `done` of them.
pub fn some_done(done: usize) -> Result<(), String> {
    if done > 0 { Ok(()) } else { Err("no coefficient has data to fit: mark a manoeuvre as identification".to_owned()) }
}

/// Says what failed, a line each, and how the command ends by the verdict; `strict` takes a caution for bad.
pub fn outcome(snapshot: &Snapshot, strict: bool) -> Outcome {
    list_failures(&failed(snapshot)).iter().for_each(|failure| print_error(failure));
    match snapshot.verdicts.ready().map(|verdicts| verdicts.session.level) {
        Some(Level::Caution) if strict => Outcome::Bad,
        Some(level) => level.into(),
        None => Outcome::Bad,
    }
}

/// Runs the session and writes the results: bad where the verdict is, and with `--strict` where it is a caution.
///
/// # Errors
/// One line per thing because of which nothing can be computed or written; nothing is written then.
pub fn run(arguments: &RunArguments) -> Result<Outcome, String> {
    /// Part of the bar that computing takes; writing takes the rest.
    const COMPUTING: f32 = 0.8;
    report::check_target(&arguments.out).map_err(|error| error.to_string())?;
    let progress = Progress::new();
    let (session, snapshot) = compute(&arguments.session, &arguments.with, &progress, COMPUTING)?;
    let outputs = Outputs {
        tables: named(&TableFormat::ALL, &arguments.tables, |format| format.name()),
        histories: named(&HistoryFormat::ALL, &arguments.histories, |format| format.name()),
        recordings: arguments.recordings,
    };
    let show = |part| progress.update(COMPUTING + (1.0 - COMPUTING) * part, "writing");
    let written = report::write(&session, &snapshot, &arguments.out, &outputs, &Control::default(), &show);
    progress.finish();
    let put = written.map_err(|error| error.to_string())?;
    if text::is_json() {
        text::json(&report::build(&session, &snapshot))?;
    }
    summary::print(&session, &snapshot, arguments.verbose);
    let outcome = outcome(&snapshot, arguments.strict);
    put.notes().for_each(|note| text::line(&note));
    text::line(&format!("results in {}", put.folder.display()));
    Ok(outcome)
}

/// Those of `all` whose names were given, each once.
pub fn named<T: Copy>(all: &[T], names: &[String], name: impl Fn(T) -> &'static str) -> Vec<T> {
    all.iter().copied().filter(|&item| names.iter().any(|given| given == name(item))).collect()
}

/// Several messages as one error, a line each.
fn lines(messages: Vec<String>) -> String {
    messages.join("\nerror: ")
}

fn table_format() -> PossibleValuesParser {
    TableFormat::ALL.map(TableFormat::name).into()
}

/// Names of formats of time histories.
fn history_format() -> PossibleValuesParser {
    HistoryFormat::ALL.map(HistoryFormat::name).into()
}

fn study() -> impl TypedValueParser<Value = Study> {
    let keys = Study::keys().map(|(key, about)| PossibleValue::new(key).help(about));
    PossibleValuesParser::new(keys).try_map(|key| Study::from_key(&key).ok_or("not a study"))
}
