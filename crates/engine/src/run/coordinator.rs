//! The background worker: one coordinator thread, the latest request wins, results appear as they come. A second thread computes the
//! experiments of the session beside it, so that a closer look neither waits for a row nor stops one.

use std::path::PathBuf;
use std::sync::{Arc, Condvar, Mutex, MutexGuard, PoisonError};
use std::thread::JoinHandle;

use super::details::{DetailRequest, details};
use super::experiments::experiment_rows;
use super::inquiries::inquire;
use super::pipeline::{Scope, run};
use crate::graph::{Cache, Context, Control, StageError, guarded};
use crate::session::Session;
use crate::snapshot::{ExperimentRows, SlotGroup, Snapshot};
use crate::study::Study;

/// Memory the results of past generations may hold, bytes.
pub const CACHE_BYTES: usize = 256 << 20;

/// A wish for everything that follows from a session.
#[derive(Clone, Debug)]
pub struct Request {
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
    /// The run done last with its generation.
    ran: Option<(u64, Arc<Request>)>,
    /// Whether the experiments of that run are due, and the handle on them while they are computed.
    experiments_due: bool,
    experiments: Option<Control>,
    closed: bool,
}

impl Inbox {
    /// Stops the job under way if it is a run, or if it is a closer look, as asked.
    fn stop(&self, runs: bool, details: bool) {
        let stopped = self.running.iter().filter(|(_, is_run)| if *is_run { runs } else { details });
        stopped.for_each(|(control, _)| control.cancel());
    }

    /// Stops the experiments under way.
    fn stop_experiments(&self) {
        self.experiments.iter().for_each(Control::cancel);
    }

    /// The run whose experiments are to be computed now, with a handle on them: once no run is due.
    fn next_experiments(&mut self) -> Option<((u64, Arc<Request>), Control)> {
        let is_running = self.pending.is_some() || matches!(self.running, Some((_, true)));
        if !self.experiments_due || is_running {
            return None;
        }
        let ran = self.ran.clone()?;
        self.experiments_due = false;
        let control = Control::default();
        self.experiments = Some(control.clone());
        Some((ran, control))
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
    threads: Vec<JoinHandle<()>>,
}

impl Engine {
    /// Starts the coordinator, which keeps outputs of stages in `cache`; `wake` is called after every new snapshot.
    pub fn start(cache: Arc<Cache>, wake: impl Fn() + Send + Sync + 'static) -> std::io::Result<Self> {
        let shared = Arc::new(Shared {
            inbox: Mutex::default(),
            arrived: Condvar::new(),
            snapshot: Mutex::default(),
            wake: Box::new(wake),
        });
        let mut engine = Self { shared, threads: Vec::new() };
        for (name, work) in [("doublet-coordinator", coordinate as Work), ("doublet-experiments", compare as Work)] {
            let (shared, cache) = (Arc::clone(&engine.shared), Arc::clone(&cache));
            let thread = std::thread::Builder::new().name(name.to_owned()).spawn(move || work(&shared, &cache))?;
            engine.threads.push(thread);
        }
        Ok(engine)
    }

    /// Asks for a run; a run under way is cancelled, a request not yet begun is forgotten. Returns the new generation.
    pub fn request(&self, mut request: Request) -> u64 {
        let mut inbox = lock(&self.shared.inbox);
        request.fresh |= inbox.pending.as_ref().is_some_and(|(_, forgotten)| forgotten.fresh);
        inbox.generation += 1;
        let generation = inbox.generation;
        inbox.pending = Some((generation, request));
        inbox.stop(true, true);
        inbox.stop_experiments();
        self.shared.arrived.notify_all();
        generation
    }

    /// States what is looked at: [`Snapshot::details`] follows, now and after every run. Cheap while it stays the same.
    pub fn request_details(&self, request: &DetailRequest) {
        let mut inbox = lock(&self.shared.inbox);
        if inbox.details == *request {
            return;
        }
        let mut former = std::mem::replace(&mut inbox.details, request.clone());
        let compares = request.inquiry.experiments;
        if former.inquiry.experiments != compares {
            inbox.experiments_due = compares;
            if !compares {
                inbox.stop_experiments();
            }
        }
        former.inquiry.experiments = compares;
        if former != *request {
            inbox.details_due = true;
            inbox.stop(false, true);
        }
        self.shared.arrived.notify_all();
    }

    /// Whether a closer look or an experiment is due or under way.
    pub fn has_details_due(&self) -> bool {
        let inbox = lock(&self.shared.inbox);
        let compares = inbox.experiments.is_some() || inbox.experiments_due && inbox.ran.is_some();
        compares || inbox.details_due || matches!(inbox.running, Some((_, false)))
    }

    /// Stops the run under way, if any.
    pub fn cancel(&self) {
        let mut inbox = lock(&self.shared.inbox);
        if inbox.pending.take().is_some() {
            // The request that is dropped had stopped them.
            inbox.details_due = true;
            inbox.experiments_due |= inbox.details.inquiry.experiments;
        }
        inbox.stop(true, false);
        drop(inbox);
        self.shared.arrived.notify_all();
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
        inbox.stop_experiments();
        drop(inbox);
        self.shared.arrived.notify_all();
        for thread in self.threads.drain(..) {
            // A thread that died has nothing left to clean up.
            let _ = thread.join();
        }
    }
}

/// What a thread of the engine does.
type Work = fn(&Shared, &Cache);

/// Waits for a job, does it, publishes what comes.
fn coordinate(shared: &Shared, cache: &Cache) {
    let mut done: Option<(u64, Arc<Request>)> = None;
    while let Some((job, control)) = next(shared, Inbox::next) {
        let previous = Arc::clone(&lock(&shared.snapshot));
        let is_run = matches!(job, Job::Run(..));
        let publish = |snapshot: Snapshot| publish(shared, snapshot, is_run);
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
                Ok(Some((generation, Arc::new(request))))
            }
            (Job::Detail(wanted), Some((_, request))) => {
                let Request { session, folder, .. } = &**request;
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
        inbox.experiments_due |= is_run && inbox.details.inquiry.experiments;
        inbox.ran.clone_from(&done);
        drop(inbox);
        shared.arrived.notify_all();
        (shared.wake)();
    }
}

fn publish(shared: &Shared, mut snapshot: Snapshot, is_run: bool) {
    // An older generation never overwrites a newer one: requests are run one at a time, in order.
    let mut shown = lock(&shared.snapshot);
    if !is_run {
        // Experiments go on beside a closer look.
        snapshot.inquiries.experiments.clone_from(&shown.inquiries.experiments);
    }
    *shown = Arc::new(snapshot);
    drop(shown);
    (shared.wake)();
}

/// Computes the experiments of the run done last, whenever they are due.
fn compare(shared: &Shared, cache: &Cache) {
    while let Some(((generation, request), control)) = next(shared, Inbox::next_experiments) {
        let show = |rows: &ExperimentRows| {
            let mut shown = lock(&shared.snapshot);
            if shown.generation == generation {
                Arc::make_mut(&mut shown).inquiries.experiments.clone_from(rows);
                drop(shown);
                (shared.wake)();
            }
        };
        let mut rows = lock(&shared.snapshot).inquiries.experiments.clone();
        let work = || {
            let context = Context::new(&request.folder).with_cache(cache).with_control(&control, &|_| ());
            experiment_rows(&request.session, &mut rows, &context, &show)
        };
        // A row that was not computed says so itself.
        if let Err(error) = guarded::<_, StageError>("experiments", work) {
            let mut rows = lock(&shared.snapshot).inquiries.experiments.clone();
            rows.each_mut("", &mut |_, slot| slot.end(&error));
            show(&rows);
        }
        lock(&shared.inbox).experiments = None;
        (shared.wake)();
    }
}

/// The next job of a thread, once there is one; `None` when the engine is gone.
fn next<T>(shared: &Shared, take: fn(&mut Inbox) -> Option<T>) -> Option<T> {
    let mut inbox = lock(&shared.inbox);
    while !inbox.closed {
        if let Some(job) = take(&mut inbox) {
            return Some(job);
        }
        inbox = shared.arrived.wait(inbox).unwrap_or_else(PoisonError::into_inner);
    }
    None
}
