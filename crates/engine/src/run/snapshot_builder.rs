//! The snapshot of a run under construction.

use std::sync::{Mutex, MutexGuard, PoisonError};
use std::time::{Duration, Instant};

use super::snapshot::Snapshot;
use crate::graph::{Cancelled, Control};

/// Shortest time between two published snapshots of one run.
const PUBLISH_INTERVAL: Duration = Duration::from_millis(8);
/// A run that is over sooner replaces what is shown at once: greying it for a moment would flicker, and drawing takes the cores the
/// run needs.
const CALM: Duration = Duration::from_millis(100);

/// The snapshot under construction, published as it grows.
pub(super) struct SnapshotBuilder<'a> {
    snapshot: Mutex<Snapshot>,
    /// When the next snapshot may be published.
    due: Mutex<Instant>,
    publish: &'a (dyn Fn(Snapshot) + Sync),
    control: &'a Control,
    steps: usize,
    done: Mutex<usize>,
}

fn lock<T>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}

impl<'a> SnapshotBuilder<'a> {
    /// A builder for a run of `steps` steps, which begins now. The first run of all has nothing to replace and shows at once what it does.
    pub(super) fn new(
        snapshot: Snapshot,
        is_first: bool,
        steps: usize,
        publish: &'a (dyn Fn(Snapshot) + Sync),
        control: &'a Control,
    ) -> Self {
        let calm = if is_first { Duration::ZERO } else { CALM };
        let due = Mutex::new(Instant::now() + calm);
        let builder = Self { snapshot: Mutex::new(snapshot), due, publish, control, steps, done: Mutex::new(0) };
        if is_first {
            builder.show();
        }
        builder
    }

    /// Changes the snapshot and publishes it when the last time is long enough ago. A cancelled run changes nothing more.
    pub(super) fn update(&self, change: impl FnOnce(&mut Snapshot)) -> Result<(), Cancelled> {
        self.control.checkpoint()?;
        let mut snapshot = lock(&self.snapshot);
        change(&mut snapshot);
        // Whoever holds the clock is publishing: waiting for it with the snapshot locked would stop every other stage.
        if let Ok(mut due) = self.due.try_lock()
            && Instant::now() >= *due
        {
            *due = Instant::now() + PUBLISH_INTERVAL;
            let copy = snapshot.clone();
            drop(snapshot);
            (self.publish)(copy);
        }
        Ok(())
    }

    /// Publishes what there is, whenever the last time was.
    pub(super) fn show(&self) {
        *lock(&self.due) = Instant::now() + PUBLISH_INTERVAL;
        let copy = lock(&self.snapshot).clone();
        (self.publish)(copy);
    }

    /// What the snapshot under construction says.
    pub(super) fn read<T>(&self, look: impl FnOnce(&Snapshot) -> T) -> T {
        look(&lock(&self.snapshot))
    }

    /// Like [`SnapshotBuilder::update`], and counts one step of the run as done.
    pub(super) fn step(&self, change: impl FnOnce(&mut Snapshot)) -> Result<(), Cancelled> {
        let mut done = lock(&self.done);
        *done += 1;
        let part = *done as f32 / self.steps.max(1) as f32;
        drop(done);
        self.update(|snapshot| {
            snapshot.progress = part.min(1.0);
            change(snapshot);
        })
    }
}
