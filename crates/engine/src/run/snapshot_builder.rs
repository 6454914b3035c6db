//! The snapshot of a run under construction.

use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Mutex, MutexGuard, PoisonError};
use std::time::{Duration, Instant};

use super::pipeline::Scope;
use crate::graph::{Cancelled, Control};
use crate::session::Manoeuvre;
use crate::snapshot::{SlotGroup, Snapshot};

/// Shortest time between two published snapshots of one run.
const PUBLISH_INTERVAL: Duration = Duration::from_millis(8);
/// A run that is over sooner replaces what is shown at once: greying it for a moment would flicker, and drawing takes the cores the
/// run needs.
const CALM: Duration = Duration::from_millis(100);

/// The snapshot under construction, published as it grows.
pub(super) struct SnapshotBuilder<'a> {
    snapshot: Mutex<Snapshot>,
    /// What was shown before the run.
    previous: &'a Snapshot,
    /// Whether anything but the window looked at was published.
    has_published: AtomicBool,
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
        previous: &'a Snapshot,
        steps: usize,
        publish: &'a (dyn Fn(Snapshot) + Sync),
        control: &'a Control,
    ) -> Self {
        let is_first = previous.generation == 0;
        let calm = if is_first { Duration::ZERO } else { CALM };
        let due = Mutex::new(Instant::now() + calm);
        let (snapshot, done, has_published) = (Mutex::new(snapshot), Mutex::new(0), AtomicBool::new(false));
        let builder = Self { snapshot, previous, has_published, due, publish, control, steps, done };
        if is_first {
            builder.publish_now();
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
            self.has_published.store(true, Ordering::Relaxed);
            let copy = snapshot.clone();
            drop(snapshot);
            (self.publish)(copy);
        }
        Ok(())
    }

    /// Publishes what there is, whenever the last time was.
    pub(super) fn publish_now(&self) {
        *lock(&self.due) = Instant::now() + PUBLISH_INTERVAL;
        self.has_published.store(true, Ordering::Relaxed);
        let copy = lock(&self.snapshot).clone();
        (self.publish)(copy);
    }

    /// Publishes the new results of one window at once. Everything else on screen stays as it was until the run replaces it, so that
    /// nothing is greyed for a moment.
    pub(super) fn publish_window(&self, name: &str) {
        let results = self.read(|snapshot| snapshot.windows.get(name).cloned());
        let Some(results) = results.filter(|results| !results.is_same(self.previous.windows.get(name))) else { return };
        // Whoever holds the clock publishes: what is older must not come after it.
        let due = lock(&self.due);
        if self.has_published.load(Ordering::Relaxed) {
            drop(due);
            return self.publish_now();
        }
        let mut shown = self.previous.clone();
        shown.windows.insert(name.to_owned(), results);
        (self.publish)(shown);
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

/// The previous snapshot without what left the session, everything else marked as running; and the number of its slots.
pub(super) fn first_snapshot(scope: &Scope<'_>, previous: &Snapshot, windows: &[&Manoeuvre]) -> (Snapshot, usize) {
    let mut snapshot = Snapshot {
        generation: scope.generation,
        cause: scope.cause.to_owned(),
        busy: true,
        progress: 0.0,
        memory: None,
        ..previous.clone()
    };
    let flights: Vec<&str> = scope.session.flights.iter().map(|flight| flight.name.as_str()).collect();
    let windows: Vec<&str> = windows.iter().map(|window| window.name.as_str()).collect();
    snapshot.follow(&flights, &windows);
    let Snapshot { details, mut studies, mut inquiries, .. } = snapshot.clone();
    let mut slots = 0;
    snapshot.each_mut("", &mut |_, slot| {
        slot.begin();
        slots += 1;
    });
    studies.each_mut("", &mut |name, slot| {
        if scope.studies.iter().any(|study| study.name() == name) { slot.begin() } else { slot.expire() }
    });
    snapshot.studies = studies;
    inquiries.each_mut("", &mut |_, slot| slot.expire());
    snapshot.inquiries = inquiries;
    if details.latest().is_none() {
        snapshot.details = details;
    }
    (snapshot, slots)
}
