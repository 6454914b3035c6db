//! Unsaved work written in the background, so that no edit waits for the disk.

use std::sync::{Arc, Condvar, Mutex, MutexGuard, PoisonError};
use std::thread::JoinHandle;
use std::time::{Duration, Instant};

use crate::autosave::{Autosave, AutosaveFile};
use crate::graph::{StageError, StageResult, guarded};

/// Shortest time between two writes: a drag does not wear the disk out.
const INTERVAL: Duration = Duration::from_millis(200);

/// What is to be done next.
enum Job {
    Write(Autosave),
    Clear,
}

impl Job {
    fn perform(&self, slot: &AutosaveFile) -> StageResult<()> {
        let done = match self {
            Self::Write(autosave) => slot.write(autosave),
            Self::Clear => slot.clear(),
        };
        done.map_err(|error| error.to_string().into())
    }
}

#[derive(Default)]
struct Inbox {
    pending: Option<Job>,
    working: bool,
    hurry: bool,
    closed: bool,
    error: Option<String>,
}

#[derive(Default)]
struct Shared {
    inbox: Mutex<Inbox>,
    changed: Condvar,
}

/// Writes the newest autosave to its slot. An edit handed over is on the disk a fifth of a second and one write later.
pub struct Autosaver {
    shared: Arc<Shared>,
    thread: Option<JoinHandle<()>>,
}

fn lock(shared: &Shared) -> MutexGuard<'_, Inbox> {
    shared.inbox.lock().unwrap_or_else(PoisonError::into_inner)
}

impl Autosaver {
    /// Starts writing to `slot`.
    pub fn start(slot: AutosaveFile) -> std::io::Result<Self> {
        let shared = Arc::<Shared>::default();
        let for_thread = Arc::clone(&shared);
        let thread = std::thread::Builder::new()
            .name("doublet-autosave".to_owned())
            .spawn(move || while step(&for_thread, &|job| job.perform(&slot)) {})?;
        Ok(Self { shared, thread: Some(thread) })
    }

    /// Keeps `autosave` in place of any before.
    pub fn keep(&self, autosave: Autosave) {
        lock(&self.shared).pending = Some(Job::Write(autosave));
        self.shared.changed.notify_all();
    }

    /// Forgets what is kept.
    pub fn clear(&self) {
        lock(&self.shared).pending = Some(Job::Clear);
        self.shared.changed.notify_all();
    }

    /// Waits until all that was asked for is on the disk.
    pub fn settle(&self) -> StageResult<()> {
        let mut inbox = lock(&self.shared);
        inbox.hurry = true;
        self.shared.changed.notify_all();
        while inbox.pending.is_some() || inbox.working {
            inbox = self.shared.changed.wait(inbox).unwrap_or_else(PoisonError::into_inner);
        }
        inbox.hurry = false;
        inbox.error.clone().map_or(Ok(()), |line| Err(line.into()))
    }

    /// Why the last write failed, if it did.
    pub fn error(&self) -> Option<String> {
        lock(&self.shared).error.clone()
    }
}

impl Drop for Autosaver {
    fn drop(&mut self) {
        lock(&self.shared).closed = true;
        self.shared.changed.notify_all();
        if let Some(thread) = self.thread.take() {
            // What was pending is written before the thread ends.
            let _ = thread.join();
        }
    }
}

/// Waits for one job and performs it; `false` once there is none and never will be.
fn step(shared: &Shared, perform: &dyn Fn(&Job) -> StageResult<()>) -> bool {
    let mut inbox = lock(shared);
    let job = loop {
        if let Some(job) = inbox.pending.take() {
            break job;
        }
        if inbox.closed {
            return false;
        }
        inbox = shared.changed.wait(inbox).unwrap_or_else(PoisonError::into_inner);
    };
    inbox.working = true;
    drop(inbox);
    let begun = Instant::now();
    // A panic is an error of this write: the thread goes on, and whoever waits for the disk is told.
    let outcome = guarded::<_, StageError>("autosave", || perform(&job));
    let mut inbox = lock(shared);
    inbox.working = false;
    inbox.error = outcome.err().map(|error| error.to_string());
    shared.changed.notify_all();
    while let Some(left) = INTERVAL.checked_sub(begun.elapsed()).filter(|_| !inbox.hurry && !inbox.closed) {
        inbox = shared.changed.wait_timeout(inbox, left).unwrap_or_else(PoisonError::into_inner).0;
    }
    true
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_write_that_panics_is_an_error_and_the_next_one_is_made() {
        let shared = Shared::default();
        let ask = || {
            let mut inbox = lock(&shared);
            (inbox.pending, inbox.hurry) = (Some(Job::Clear), true);
        };
        ask();
        assert!(step(&shared, &|_| panic!("index out of bounds")));
        let line = lock(&shared).error.clone().unwrap_or_default();
        assert!(line.starts_with("autosave: internal error of doublet at engine/src/run/autosaver.rs:"), "{line}");
        assert!(line.contains("index out of bounds") && !line.contains('\n') && !lock(&shared).working, "{line}");
        ask();
        assert!(step(&shared, &|_| Ok(())));
        assert_eq!(lock(&shared).error, None);
    }
}
