//! The chain from a recording on: inspected, guessed, made into a session, saved, checked, run by the worker of the window, and its
//! results, report and export formed.

use std::path::Path;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::{Arc, Condvar, Mutex, PoisonError};

use doublet_engine::begin;
use doublet_engine::check::check_session;
use doublet_engine::export::{self, Format, IdentifiedModel};
use doublet_engine::graph::Cache;
use doublet_engine::report;
use doublet_engine::report::document::{self, SectionKind};
use doublet_engine::run::{Control, DetailRequest, Engine, Request, Snapshot};
use doublet_engine::session::{self, PathSource, Session};

use super::guess_session::guess_session;

/// Memory for what runs share: the aircraft.
const CACHE_BYTES: usize = 16 << 20;
/// Manoeuvres of a session and their length, s.
const MANOEUVRES: usize = 2;
const LENGTH_S: f64 = 4.0;

/// The worker of the window, and what it wakes.
struct Worker {
    engine: Engine,
    wake: Arc<(Mutex<()>, Condvar)>,
}

thread_local! {
    static WORKER: Worker = {
        let wake = Arc::<(Mutex<()>, Condvar)>::default();
        let called = Arc::clone(&wake);
        let call = move || {
            let _guard = called.0.lock().unwrap_or_else(PoisonError::into_inner);
            called.1.notify_all();
        };
        let engine = Engine::start(Arc::new(Cache::new(CACHE_BYTES)), call).expect("a thread can be started");
        Worker { engine, wake }
    };
}

impl Worker {
    /// What follows from a session, and a closer look at its first manoeuvre.
    fn compute(&self, session: &Session, folder: &Path) -> Arc<Snapshot> {
        let (folder, cause) = (folder.to_owned(), "fuzz".to_owned());
        let (session, first) = (Arc::new(session.clone()), session.windows.first().map(|one| one.name.clone()));
        let details = DetailRequest { window: first.clone(), filters: true, ..DetailRequest::default() };
        self.engine.request(Request { session, folder, first, studies: Vec::new(), cause, fresh: true });
        self.engine.request_details(&details);
        let mut guard = self.wake.0.lock().unwrap_or_else(PoisonError::into_inner);
        while self.engine.is_busy() || self.engine.has_details_due() {
            // The worker may end between the question and the wait.
            let patience = std::time::Duration::from_millis(20);
            guard = self.wake.1.wait_timeout(guard, patience).unwrap_or_else(PoisonError::into_inner).0;
        }
        self.engine.snapshot()
    }
}

/// How far a recording came.
#[derive(Clone, Copy)]
enum Reached {
    Refused,
    Inspected,
    Session,
    Checked,
    Results,
    Report,
    Model,
}

/// Names of [`Reached`].
const STEPS: [&str; 7] = ["refused", "inspected", "session", "checked", "results", "report", "model"];
/// How many recordings ended there.
static ENDED: [AtomicUsize; 7] = [const { AtomicUsize::new(0) }; 7];

/// How many recordings ended at which step, in one line.
pub fn counts() -> String {
    let counts = STEPS.iter().zip(&ENDED).map(|(step, count)| format!("{step} {}", count.load(Ordering::Relaxed)));
    counts.collect::<Vec<_>>().join(", ")
}

/// Executions after which the counts are written.
const WRITTEN_EVERY: usize = 1000;

/// Writes the counts when the thread that fuzzes ends.
struct Written;

impl Drop for Written {
    fn drop(&mut self) {
        write_counts();
    }
}

thread_local! {
    static WRITTEN: Written = const { Written };
}

/// Writes the counts of this process into the folder that `DOUBLET_FUZZ_COUNTS` names.
fn write_counts() {
    let Some(folder) = std::env::var_os("DOUBLET_FUZZ_COUNTS") else { return };
    let path = Path::new(&folder).join(format!("recording_chain-{}.txt", std::process::id()));
    if let Err(error) = std::fs::write(&path, counts() + "\n") {
        eprintln!("{}: {error}", path.display());
    }
}

/// A recording from its bytes to its report and model, as far as it goes.
pub fn recording_chain(data: &[u8]) {
    WRITTEN.with(|_| ());
    ENDED[chain(data) as usize].fetch_add(1, Ordering::Relaxed);
    if ENDED.iter().map(|count| count.load(Ordering::Relaxed)).sum::<usize>() % WRITTEN_EVERY == 0 {
        write_counts();
    }
}

/// As [`recording_chain`]. An error of the program itself, which the worker makes a line of, is a panic here.
fn chain(data: &[u8]) -> Reached {
    let path = super::scratch("csv");
    std::fs::write(&path, data).expect("the scratch file can be written");
    let Ok(inspected) = begin::inspect_for(std::slice::from_ref(&path), None, &Control::default(), &|_| {}) else {
        return Reached::Refused;
    };
    let choice = data.iter().fold(0_usize, |sum, byte| sum.wrapping_mul(31).wrapping_add(usize::from(*byte)));
    let Ok(mut session) = guess_session(&inspected) else { return Reached::Inspected };
    session.preparation.path = [PathSource::Smoothed, PathSource::Filtered, PathSource::Measured][choice % 3];
    session.windows.truncate(MANOEUVRES);
    session.windows.iter_mut().for_each(|one| one.window.end_s = one.window.end_s.min(one.window.start_s + LENGTH_S));
    let text = session::print(&session).expect("a session has a saved form");
    let Ok(session) = session::parse(&text) else { return Reached::Inspected };
    let folder = path.parent().unwrap_or(Path::new("/"));
    let checked = check_session(&session, folder, &|_| ());
    checked.findings.iter().for_each(|finding| assert_no_fault(&finding.to_string()));
    if session::check(&session).iter().any(session::stops_run) {
        return Reached::Session;
    }
    let snapshot = WORKER.with(|worker| worker.compute(&session, folder));
    let failures = snapshot.failures().into_iter().chain(snapshot.failed_fits());
    failures.for_each(|(_, line)| assert_no_fault(&line));
    snapshot.details.error().iter().for_each(|line| assert_no_fault(line));
    let results = report::build(&session, &snapshot);
    serde_json::to_string(&results).expect("results have a form as JSON");
    if snapshot.windows.values().all(|one| one.path.ready().is_none()) {
        return Reached::Checked;
    }
    if snapshot.pooled.ready().is_none() {
        return Reached::Results;
    }
    let document = document::build(&session, &snapshot, &results, &SectionKind::ALL, None);
    assert!(!document.sections.is_empty(), "a report has sections");
    let Ok(model) = IdentifiedModel::new(&session, &snapshot) else { return Reached::Report };
    match export::write(&model, &Format::ALL, &super::scratch("models")) {
        Ok(_) => Reached::Model,
        Err(error) => {
            assert_no_fault(&error.to_string());
            Reached::Report
        }
    }
}

fn assert_no_fault(line: &str) {
    assert!(!line.contains("internal error"), "{line}");
}
