//! The background worker: one coordinator thread, the latest request wins, results appear as they come.

use std::path::PathBuf;
use std::sync::{Arc, Condvar, Mutex, MutexGuard, PoisonError};
use std::thread::JoinHandle;

use super::details::{DetailRequest, details};
use super::inquiries::inquire;
use super::pipeline::{Scope, run};
use crate::graph::{Cache, Context, Control, StageError, guarded};
use crate::session::Session;
use crate::snapshot::Snapshot;
use crate::study::Study;

/// Memory the results of past generations may hold, bytes.
pub const CACHE_BYTES: usize = 256 << 20;

/// A wish for everything that follows from a session.
#[derive(Clone, Debug)]
pub struct Request {
    /// The session.
    pub session: Arc<Session>,
    /// Folder its relative paths start from.
    pub folder: PathBuf,
    /// Window to compute first.
    pub first: Option<String>,
    /// What to compute beside the derivatives.
    pub studies: Vec<Study>,
    /// What asked for it, for the log.
    pub cause: String,
    /// The first of a session just opened: neither results nor log of the one before stay visible.
    pub fresh: bool,
}

/// What is to be done next, a run before a closer look.
enum Job {
    Run(u64, Request),
    Detail(Box<DetailRequest>),
}

#[derive(Default)]
struct Inbox {
    /// The run to do next.
    pending: Option<(u64, Request)>,
    /// What is looked at closer, and whether that is due.
    details: DetailRequest,
    details_due: bool,
    generation: u64,
    /// Handle on the job under way, and whether it is a run.
    running: Option<(Control, bool)>,
    closed: bool,
}

impl Inbox {
    /// Stops the job under way if it is a run, or if it is a closer look, as asked.
    fn stop(&self, runs: bool, details: bool) {
        let stopped = self.running.iter().filter(|(_, is_run)| if *is_run { runs } else { details });
        stopped.for_each(|(control, _)| control.cancel());
    }

    /// The next job with a handle on it.
    fn next(&mut self) -> Option<(Job, Control)> {
        let due = std::mem::take(&mut self.details_due);
        let job = match self.pending.take() {
            Some((generation, request)) => Job::Run(generation, request),
            None if due => Job::Detail(Box::new(self.details.clone())),
            None => return None,
        };
        let control = Control::default();
        self.running = Some((control.clone(), matches!(job, Job::Run(..))));
        Some((job, control))
    }
}

struct Shared {
    inbox: Mutex<Inbox>,
    arrived: Condvar,
    snapshot: Mutex<Arc<Snapshot>>,
    wake: Box<dyn Fn() + Send + Sync>,
}

/// Locks even when another thread died holding the lock: the data behind it are replaced as a whole and stay consistent.
fn lock<T>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}

/// The engine in the background.
pub struct Engine {
    shared: Arc<Shared>,
    thread: Option<JoinHandle<()>>,
}

impl Engine {
    /// Starts the coordinator, which keeps outputs of stages in `cache`; `wake` is called after every new snapshot.
    ///
    /// # Errors
    /// When the operating system refuses a thread.
    pub fn start(cache: Arc<Cache>, wake: impl Fn() + Send + Sync + 'static) -> std::io::Result<Self> {
        let shared = Arc::new(Shared {
            inbox: Mutex::default(),
            arrived: Condvar::new(),
            snapshot: Mutex::default(),
            wake: Box::new(wake),
        });
        let for_thread = Arc::clone(&shared);
        let thread = std::thread::Builder::new()
            .name("doublet-coordinator".to_owned())
            .spawn(move || coordinate(&for_thread, &cache))?;
        Ok(Self { shared, thread: Some(thread) })
    }

    /// Asks for a run; a run under way is cancelled, a request not yet begun is forgotten. Returns the new generation.
    pub fn request(&self, mut request: Request) -> u64 {
        let mut inbox = lock(&self.shared.inbox);
        request.fresh |= inbox.pending.as_ref().is_some_and(|(_, forgotten)| forgotten.fresh);
        inbox.generation += 1;
        let generation = inbox.generation;
        inbox.pending = Some((generation, request));
        inbox.stop(true, true);
        self.shared.arrived.notify_one();
        generation
    }

    /// States what is looked at: [`Snapshot::details`] follows, now and after every run. Cheap while it stays the same.
    pub fn request_details(&self, request: &DetailRequest) {
        let mut inbox = lock(&self.shared.inbox);
        if inbox.details != *request {
            inbox.details = request.clone();
            inbox.details_due = true;
            inbox.stop(false, true);
            self.shared.arrived.notify_one();
        }
    }

    /// Whether a closer look is due or under way.
    pub fn has_details_due(&self) -> bool {
        let inbox = lock(&self.shared.inbox);
        inbox.details_due || matches!(inbox.running, Some((_, false)))
    }

    /// Stops the run under way, if any.
    pub fn cancel(&self) {
        let mut inbox = lock(&self.shared.inbox);
        inbox.pending = None;
        inbox.stop(true, false);
    }

    /// The newest snapshot; cheap, made to be called once a frame.
    pub fn snapshot(&self) -> Arc<Snapshot> {
        Arc::clone(&lock(&self.shared.snapshot))
    }

    /// Whether a run is under way or waiting.
    pub fn is_busy(&self) -> bool {
        let inbox = lock(&self.shared.inbox);
        inbox.pending.is_some() || matches!(inbox.running, Some((_, true)))
    }
}

impl Drop for Engine {
    fn drop(&mut self) {
        let mut inbox = lock(&self.shared.inbox);
        inbox.closed = true;
        inbox.pending = None;
        inbox.stop(true, true);
        drop(inbox);
        self.shared.arrived.notify_one();
        if let Some(thread) = self.thread.take() {
            // A coordinator that died has nothing left to clean up.
            let _ = thread.join();
        }
    }
}

/// Waits for a job, does it, publishes what comes.
fn coordinate(shared: &Shared, cache: &Cache) {
    let mut done: Option<Request> = None;
    while let Some((job, control)) = next(shared) {
        let previous = Arc::clone(&lock(&shared.snapshot));
        let publish = |snapshot: Snapshot| {
            // An older generation never overwrites a newer one: requests are run one at a time, in order.
            *lock(&shared.snapshot) = Arc::new(snapshot);
            (shared.wake)();
        };
        let is_run = matches!(job, Job::Run(..));
        let work = || match (job, &done) {
            (Job::Run(generation, request), _) => {
                let scope = Scope {
                    session: &request.session,
                    folder: &request.folder,
                    first: request.first.as_deref(),
                    studies: &request.studies,
                    cause: &request.cause,
                    generation,
                };
                let previous = if request.fresh { Arc::default() } else { previous };
                run(&scope, &previous, cache, &control, &publish);
                Ok(Some(request))
            }
            (Job::Detail(wanted), Some(Request { session, folder, .. })) => {
                let context = Context::new(folder).with_cache(cache).with_control(&control, &|_| ());
                let mut shown = Snapshot::clone(&previous);
                // A look that was stopped is taken anew; what failed is shown with its reason.
                let found = details(session, &previous, &wanted, &context);
                if !matches!(found, Err(StageError::Cancelled)) {
                    shown.details.finish(found);
                    publish(shown.clone());
                }
                inquire(session, &mut shown, &wanted.inquiry, &context, &publish);
                Ok(None)
            }
            (Job::Detail(_), None) => Ok(None),
        };
        match guarded::<_, StageError>("analysis", work) {
            Ok(ran) => done = ran.or(done),
            Err(error) => {
                let mut shown = Snapshot::clone(&lock(&shared.snapshot));
                shown.end(&error);
                if !is_run {
                    shown.details.finish(Err(error));
                }
                publish(shown);
            }
        }
        let mut inbox = lock(&shared.inbox);
        inbox.running = None;
        inbox.details_due |= is_run;
        drop(inbox);
        (shared.wake)();
    }
}

/// The next job, once there is one; `None` when the engine is gone.
fn next(shared: &Shared) -> Option<(Job, Control)> {
    let mut inbox = lock(&shared.inbox);
    while !inbox.closed {
        if let Some(job) = inbox.next() {
            return Some(job);
        }
        inbox = shared.arrived.wait(inbox).unwrap_or_else(PoisonError::into_inner);
    }
    None
}
