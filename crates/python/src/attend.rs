//! Errors as exceptions, and work that leaves Python free, reports its progress, can be interrupted and survives a fork.

use std::sync::atomic::{AtomicU32, Ordering};
use std::sync::mpsc::{RecvTimeoutError, channel};
use std::sync::{Arc, Mutex, PoisonError};
use std::time::Duration;

use doublet_engine::graph::{Control, StageError, guarded};
use doublet_engine::run::Job;
use doublet_engine::session::Finding;
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;
use rayon::{ThreadPool, ThreadPoolBuilder};

pyo3::create_exception!(
    doublet,
    DoubletError,
    PyValueError,
    "Error of doublet in one sentence: what, where and what to do, as on the command line."
);

/// A refusal as an exception.
pub fn refuse(error: impl std::fmt::Display) -> PyErr {
    DoubletError::new_err(error.to_string())
}

/// Process that loaded the module: the threads of the global pool exist in it alone.
static HOME: AtomicU32 = AtomicU32::new(0);
/// Pool of a process that was forked from it, with the process that made the pool.
static POOL: Mutex<Option<(u32, Arc<ThreadPool>)>> = Mutex::new(None);

/// Notes which process loads the module.
pub fn note_process() {
    HOME.store(std::process::id(), Ordering::Relaxed);
}

/// Does `work` with threads of this process. A fork copies no threads, so that a forked process uses a pool of its own.
pub fn pooled<T: Send>(work: impl FnOnce() -> T + Send) -> T {
    let process = std::process::id();
    if process == HOME.load(Ordering::Relaxed) {
        return work();
    }
    match pool_of(process) {
        Some(pool) => pool.install(work),
        None => work(),
    }
}

/// The pool of a forked process; `None` where the operating system refuses threads.
fn pool_of(process: u32) -> Option<Arc<ThreadPool>> {
    let build = || ThreadPoolBuilder::new().build().ok().map(Arc::new);
    // A thread that another fork did not copy may have held the lock: then the pool serves one call.
    let Ok(mut known) = POOL.try_lock() else { return build() };
    match &*known {
        Some((owner, pool)) if *owner == process => Some(Arc::clone(pool)),
        _ => {
            let pool = build()?;
            // The pool of the parent has no threads here that could end.
            std::mem::forget(known.replace((process, Arc::clone(&pool))));
            Some(pool)
        }
    }
}

/// Does `work` while other Python threads run; a panic in it becomes the same exception as a refusal.
pub fn detached<T: Send, E: std::fmt::Display + Send>(
    py: Python<'_>,
    name: &str,
    work: impl FnOnce() -> Result<T, E> + Send,
) -> PyResult<T> {
    py.detach(|| guarded(name, || pooled(|| work().map_err(|error| error.to_string())))).map_err(refuse)
}

/// Tells the part that is done, 0 to 1, from any thread.
pub type Show<'a> = &'a (dyn Fn(f32) + Sync);

pub fn warn(py: Python<'_>, finding: &Finding) -> PyResult<()> {
    let text = format!("{} {}", finding.text, finding.fix_text);
    py.import("doublet._errors")?.call_method1("warn", (text,)).map(|_| ())
}

/// Findings of work under way, each once, that become warnings while it goes on.
#[derive(Clone, Default)]
pub struct Notices(Arc<Mutex<Vec<(Finding, bool)>>>);

impl Notices {
    /// Adds a finding that is not there yet.
    pub fn add(&self, finding: &Finding) {
        let mut all = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        if !all.iter().any(|(known, _)| known.code == finding.code) {
            all.push((finding.clone(), false));
        }
    }

    /// Warns of those that are new.
    fn warn(&self, py: Python<'_>) -> PyResult<()> {
        let fresh: Vec<Finding> = {
            let mut all = self.0.lock().unwrap_or_else(PoisonError::into_inner);
            let fresh = all.iter_mut().filter(|(_, is_given)| !is_given);
            fresh.map(|(finding, is_given)| (*is_given = true, finding.clone()).1).collect()
        };
        fresh.iter().try_for_each(|finding| warn(py, finding))
    }
}

/// Time between two looks at Python's signals.
const LOOK: Duration = Duration::from_millis(50);

/// Does `work` in a thread while other Python threads run; `progress` is called with the part done, 0 to 1, and Ctrl-C cancels.
pub fn attend<T: Send + 'static, E: Into<StageError> + Send>(
    py: Python<'_>,
    name: &str,
    progress: Option<&Bound<'_, PyAny>>,
    work: impl FnOnce(&Control, Show<'_>) -> Result<T, E> + Send + 'static,
) -> PyResult<T> {
    attend_with(py, name, (progress, &Notices::default()), work)
}

/// As [`attend`]; the notices of the work become warnings while it goes on.
pub fn attend_with<T: Send + 'static, E: Into<StageError> + Send>(
    py: Python<'_>,
    name: &str,
    (progress, notices): (Option<&Bound<'_, PyAny>>, &Notices),
    work: impl FnOnce(&Control, Show<'_>) -> Result<T, E> + Send + 'static,
) -> PyResult<T> {
    let (told, mut steps) = channel::<()>();
    let wake = move || {
        // Nobody listens any more where the wait was interrupted.
        let _ = told.send(());
    };
    let part = Arc::new(AtomicU32::new(0.0_f32.to_bits()));
    let done = Arc::clone(&part);
    let pooled_work = move |control: &Control, _: &(dyn Fn(f32) + Sync)| {
        pooled(|| work(control, &move |part: f32| done.store(part.to_bits(), Ordering::Relaxed)))
    };
    let job = Job::start(name, wake, pooled_work)?;
    let mut shown = -1.0;
    loop {
        // A receiver is one thread's alone: it goes there and comes back.
        let waited;
        (steps, waited) = py.detach(move || {
            let waited = steps.recv_timeout(LOOK);
            (steps, waited)
        });
        let part = f32::from_bits(part.load(Ordering::Relaxed));
        let told = match progress {
            Some(progress) if part > shown => progress.call1((part,)).map(|_| ()),
            _ => Ok(()),
        };
        shown = part;
        if let Err(error) = told.and_then(|()| notices.warn(py)).and_then(|()| py.check_signals()) {
            job.cancel();
            py.detach(move || drop(job));
            return Err(error);
        }
        if waited == Err(RecvTimeoutError::Disconnected) {
            break;
        }
    }
    py.detach(move || job.finish()).map_err(refuse)
}
