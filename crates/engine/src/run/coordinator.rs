//! The background worker: one coordinator thread, the latest request wins, results appear as they come.

use std::path::PathBuf;
use std::sync::{Arc, Condvar, Mutex, MutexGuard, PoisonError};
use std::thread::JoinHandle;

use super::control::Control;
use super::pipeline::{Scope, run};
use super::snapshot::Snapshot;
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
}

#[derive(Default)]
struct Inbox {
    pending: Option<(u64, Request)>,
    generation: u64,
    running: Option<Control>,
    closed: bool,
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
    pub fn request(&self, request: Request) -> u64 {
        let mut inbox = lock(&self.shared.inbox);
        inbox.generation += 1;
        let generation = inbox.generation;
        inbox.pending = Some((generation, request));
        if let Some(running) = &inbox.running {
            running.cancel();
        }
        self.shared.arrived.notify_one();
        generation
    }

    /// Stops the run under way, if any.
    pub fn cancel(&self) {
        let mut inbox = lock(&self.shared.inbox);
        inbox.pending = None;
        if let Some(running) = &inbox.running {
            running.cancel();
        }
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
        if let Some(running) = &inbox.running {
            running.cancel();
        }
        drop(inbox);
        self.shared.arrived.notify_one();
        if let Some(thread) = self.thread.take() {
            // A coordinator that died has nothing left to clean up.
            let _ = thread.join();
        }
    }
}

/// Waits for a request, runs it, publishes what comes.
fn coordinate(shared: &Shared) {
    let cache = Cache::new(CACHE_BYTES);
    while let Some((generation, request, control)) = next(shared) {
        let previous = Arc::clone(&lock(&shared.snapshot));
        let publish = |snapshot: Snapshot| {
            // An older generation never overwrites a newer one: requests are run one at a time, in order.
            *lock(&shared.snapshot) = Arc::new(snapshot);
            (shared.wake)();
        };
        let scope = Scope {
            session: &request.session,
            folder: &request.folder,
            first: request.first.as_deref(),
            studies: &request.studies,
            cause: &request.cause,
            generation,
        };
        run(&scope, &previous, &cache, &control, &publish);
        lock(&shared.inbox).running = None;
        (shared.wake)();
    }
}

fn next(shared: &Shared) -> Option<(u64, Request, Control)> {
    let mut inbox = lock(&shared.inbox);
    loop {
        if inbox.closed {
            return None;
        }
        if let Some((generation, request)) = inbox.pending.take() {
            let control = Control::default();
            inbox.running = Some(control.clone());
            return Some((generation, request, control));
        }
        inbox = shared.arrived.wait(inbox).unwrap_or_else(PoisonError::into_inner);
    }
}
