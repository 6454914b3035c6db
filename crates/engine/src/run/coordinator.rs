//! The background worker: one coordinator thread, the latest request wins, results appear as they come.

use std::path::PathBuf;
use std::sync::{Arc, Condvar, Mutex, MutexGuard, PoisonError};
use std::thread::JoinHandle;

use super::control::Control;
use super::details::{Wanted, details};
use super::pipeline::{Scope, run};
use super::snapshot::{Slot, Snapshot};
use crate::graph::Cache;
use crate::session::Session;
use crate::study::Study;

/// Memory the results of past generations may hold.
const CACHE_BYTES: usize = 400 << 20;

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

#[derive(Default)]
struct Inbox {
    pending: Option<(u64, Request)>,
    /// What is looked at, and whether a look at it is due or under way.
    wanted: Wanted,
    look_due: bool,
    looking: Option<Control>,
    generation: u64,
    running: Option<Control>,
    closed: bool,
}

impl Inbox {
    /// Stops the run and the look under way, if any.
    fn stop(&self) {
        self.running.iter().chain(&self.looking).for_each(Control::cancel);
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
    /// Starts the coordinator; `wake` is called after every new snapshot.
    ///
    /// # Errors
    /// When the operating system refuses a thread.
    pub fn start(wake: impl Fn() + Send + Sync + 'static) -> std::io::Result<Self> {
        let shared = Arc::new(Shared {
            inbox: Mutex::default(),
            arrived: Condvar::new(),
            snapshot: Mutex::default(),
            wake: Box::new(wake),
        });
        let for_thread = Arc::clone(&shared);
        let thread = std::thread::Builder::new()
            .name("doublet-coordinator".to_owned())
            .spawn(move || coordinate(&for_thread))?;
        Ok(Self { shared, thread: Some(thread) })
    }

    /// Asks for a run; a run under way is cancelled, a request not yet begun is forgotten. Returns the new generation.
    pub fn request(&self, mut request: Request) -> u64 {
        let mut inbox = lock(&self.shared.inbox);
        request.fresh |= inbox.pending.as_ref().is_some_and(|(_, forgotten)| forgotten.fresh);
        inbox.generation += 1;
        let generation = inbox.generation;
        inbox.pending = Some((generation, request));
        inbox.stop();
        self.shared.arrived.notify_one();
        generation
    }

    /// States what is looked at: [`Snapshot::details`] follows, now and after every run. Cheap while it stays the same.
    pub fn look_at(&self, wanted: &Wanted) {
        let mut inbox = lock(&self.shared.inbox);
        if inbox.wanted != *wanted {
            inbox.wanted = wanted.clone();
            inbox.look_due = true;
            inbox.looking.iter().for_each(Control::cancel);
            self.shared.arrived.notify_one();
        }
    }

    /// Whether a closer look is due or under way.
    pub fn is_looking(&self) -> bool {
        let inbox = lock(&self.shared.inbox);
        inbox.look_due || inbox.looking.is_some()
    }

    /// Stops the run under way, if any.
    pub fn cancel(&self) {
        let mut inbox = lock(&self.shared.inbox);
        inbox.pending = None;
        inbox.running.iter().for_each(Control::cancel);
    }

    /// The newest snapshot; cheap, made to be called once a frame.
    pub fn snapshot(&self) -> Arc<Snapshot> {
        Arc::clone(&lock(&self.shared.snapshot))
    }

    /// Whether a run is under way or waiting.
    pub fn is_busy(&self) -> bool {
        let inbox = lock(&self.shared.inbox);
        inbox.running.is_some() || inbox.pending.is_some()
    }
}

impl Drop for Engine {
    fn drop(&mut self) {
        let mut inbox = lock(&self.shared.inbox);
        inbox.closed = true;
        inbox.pending = None;
        inbox.stop();
        drop(inbox);
        self.shared.arrived.notify_one();
        if let Some(thread) = self.thread.take() {
            // A coordinator that died has nothing left to clean up.
            let _ = thread.join();
        }
    }
}

/// What is to be done next.
enum Job {
    Run(u64, Request, Control),
    Look(Wanted, Control),
}

/// Waits for a request, runs it, publishes what comes; looks closer when nothing is to be run.
fn coordinate(shared: &Shared) {
    let cache = Cache::new(CACHE_BYTES);
    let mut session: Option<Arc<Session>> = None;
    while let Some(job) = next(shared) {
        let previous = Arc::clone(&lock(&shared.snapshot));
        let publish = |snapshot: Snapshot| {
            // An older generation never overwrites a newer one: requests are run one at a time, in order.
            *lock(&shared.snapshot) = Arc::new(snapshot);
            (shared.wake)();
        };
        match job {
            Job::Run(generation, request, control) => {
                let scope = Scope {
                    session: &request.session,
                    folder: &request.folder,
                    first: request.first.as_deref(),
                    studies: &request.studies,
                    cause: &request.cause,
                    generation,
                };
                let previous = if request.fresh { Arc::default() } else { previous };
                run(&scope, &previous, &cache, &control, &publish);
                session = Some(Arc::clone(&request.session));
                let mut inbox = lock(&shared.inbox);
                inbox.running = None;
                inbox.look_due = true;
            }
            Job::Look(wanted, control) => {
                let found = session.as_ref().map(|session| details(session, &previous, &wanted, &control));
                if let Some(Ok(found)) = found {
                    publish(Snapshot { details: Slot::Ready(Arc::new(found)), ..Snapshot::clone(&previous) });
                }
                lock(&shared.inbox).looking = None;
            }
        }
        (shared.wake)();
    }
}

fn next(shared: &Shared) -> Option<Job> {
    let mut inbox = lock(&shared.inbox);
    loop {
        if inbox.closed {
            return None;
        }
        if let Some((generation, request)) = inbox.pending.take() {
            let control = Control::default();
            inbox.running = Some(control.clone());
            return Some(Job::Run(generation, request, control));
        }
        if std::mem::take(&mut inbox.look_due) {
            let control = Control::default();
            inbox.looking = Some(control.clone());
            return Some(Job::Look(inbox.wanted.clone(), control));
        }
        inbox = shared.arrived.wait(inbox).unwrap_or_else(PoisonError::into_inner);
    }
}
