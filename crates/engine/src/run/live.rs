//! A flight watched in the background.

use std::collections::{BTreeMap, VecDeque};
use std::path::PathBuf;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::thread::{JoinHandle, sleep};
use std::time::Instant;

use crate::graph::{StageResult, guarded};
use crate::live::{Limit, LiveUpdate, LiveWatch, Opening};
use crate::planning::open_flight;

/// Interval of updates in the window, s.
const UPDATE_S: f64 = 0.25;
/// Most findings that are kept.
const FINDINGS: usize = 100;

/// What is to be watched in the background.
#[derive(Clone, Debug, Default)]
pub struct LiveOrder {
    /// The flight.
    pub opening: Opening,
    /// Times real time of a recording; none for as fast as it goes.
    pub speed: Option<f64>,
    /// What is not to be passed.
    pub limits: Vec<Limit>,
    /// New folder for everything that came.
    pub record: Option<PathBuf>,
}

/// An estimate over time.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct EstimateTrace {
    /// Time, s, and estimate.
    pub points: Vec<[f64; 2]>,
    /// Twice the standard error at each.
    pub spread: Vec<f64>,
}

impl EstimateTrace {
    /// Its part since the error has stayed within some times the latest one: what was written of the first seconds, before the inputs say
    /// anything, would leave of the rest a line.
    pub fn settled(&self) -> (&[[f64; 2]], &[f64]) {
        /// How many times the latest error one may be.
        const TIMES: f64 = 8.0;
        let most = TIMES * self.spread.last().copied().unwrap_or(0.0);
        let first = self.spread.iter().rposition(|spread| *spread > most).map_or(0, |last| last + 1);
        (self.points.get(first..).unwrap_or_default(), self.spread.get(first..).unwrap_or_default())
    }
}

/// Everything seen of a flight so far.
#[derive(Clone, Debug, Default)]
pub struct LiveView {
    /// The last update.
    pub latest: Option<LiveUpdate>,
    /// Quantities of the motion at the updates: time, s, and value, SI.
    pub traces: BTreeMap<String, Vec<[f64; 2]>>,
    /// Derivatives at the updates.
    pub estimates: BTreeMap<String, EstimateTrace>,
    /// Findings so far, each with its time of flight, s; the latest of many.
    pub findings: VecDeque<(f64, String)>,
    /// What was chosen, a line each.
    pub notes: Vec<String>,
    /// What went wrong.
    pub error: Option<String>,
    /// Session of what was recorded.
    pub session: Option<PathBuf>,
    /// Nothing comes any more.
    pub is_finished: bool,
}

impl LiveView {
    fn add(&mut self, update: LiveUpdate) {
        for (name, value) in &update.state {
            self.traces.entry(name.clone()).or_default().push([update.time_s, *value]);
        }
        for derivative in &update.derivatives {
            if let (Some(estimate), Some(error)) = (derivative.estimate, derivative.standard_error) {
                let trace = self.estimates.entry(derivative.name.clone()).or_default();
                trace.points.push([update.time_s, estimate]);
                trace.spread.push(2.0 * error);
            }
        }
        self.findings.extend(update.findings.iter().map(|finding| (update.time_s, finding.clone())));
        while self.findings.len() > FINDINGS {
            self.findings.pop_front();
        }
        self.latest = Some(update);
    }
}

/// A flight watched in the background until it ends, it is stopped or this is dropped.
pub struct LiveThread {
    view: Arc<Mutex<Arc<LiveView>>>,
    stop: Arc<AtomicBool>,
    thread: Option<JoinHandle<()>>,
}

fn lock(view: &Mutex<Arc<LiveView>>) -> MutexGuard<'_, Arc<LiveView>> {
    view.lock().unwrap_or_else(PoisonError::into_inner)
}

impl LiveThread {
    /// Begins to watch; `wake` is called after every update.
    pub fn start(order: LiveOrder, wake: impl Fn() + Send + 'static) -> std::io::Result<Self> {
        let (view, stop) = (Arc::<Mutex<Arc<LiveView>>>::default(), Arc::<AtomicBool>::default());
        let (shared, stopped) = (Arc::clone(&view), Arc::clone(&stop));
        let watch = move || {
            let watched = guarded("live", || watch(&order, &shared, &stopped, &wake));
            let error = watched.err().map(|error| error.to_string());
            let mut guard = lock(&shared);
            let view = Arc::make_mut(&mut guard);
            (view.error, view.is_finished) = (error, true);
            drop(guard);
            wake();
        };
        let thread = std::thread::Builder::new().name("doublet-live".to_owned()).spawn(watch)?;
        Ok(Self { view, stop, thread: Some(thread) })
    }

    /// Everything seen so far.
    pub fn view(&self) -> Arc<LiveView> {
        Arc::clone(&lock(&self.view))
    }

    /// Ends it; what was recorded becomes a session.
    pub fn stop(&self) {
        self.stop.store(true, Ordering::Relaxed);
    }
}

impl Drop for LiveThread {
    fn drop(&mut self) {
        self.stop();
        if let Some(thread) = self.thread.take() {
            // A thread that failed has nothing more to say.
            let _ = thread.join();
        }
    }
}

/// Watches to the end.
fn watch(order: &LiveOrder, shared: &Mutex<Arc<LiveView>>, stop: &AtomicBool, wake: &dyn Fn()) -> StageResult<()> {
    let watched = open_flight(&order.opening)?;
    let (mut settings, notes) = (watched.settings, watched.notes);
    settings.update_s = UPDATE_S;
    settings.limit(&order.limits);
    let speed = order.speed.filter(|_| watched.is_recorded);
    let mut live = LiveWatch::new(watched.source, watched.map, settings, speed, order.opening.wait)?;
    if let Some(folder) = &order.record {
        live.record(folder, watched.session.as_ref(), watched.aircraft.as_deref())?;
    }
    Arc::make_mut(&mut lock(shared)).notes = notes;
    let mut failed: StageResult<()> = Ok(());
    loop {
        if stop.load(Ordering::Relaxed) {
            live.stop();
        }
        let step = match live.step(Instant::now()) {
            Ok(step) => step,
            Err(line) => {
                // The recording has its session all the same.
                live.stop();
                failed = Err(line.into());
                break;
            }
        };
        if !step.updates.is_empty() {
            let mut guard = lock(shared);
            let view = Arc::make_mut(&mut guard);
            step.updates.into_iter().for_each(|update| view.add(update));
            drop(guard);
            wake();
        }
        if step.is_finished {
            break;
        }
        if let Some(rest) = step.rest {
            sleep(rest);
        }
    }
    Arc::make_mut(&mut lock(shared)).notes.extend(live.recording_errors());
    if let Some(recorded) = live.finish()? {
        let mut guard = lock(shared);
        let view = Arc::make_mut(&mut guard);
        view.notes.extend(recorded.notes);
        view.session = Some(recorded.session);
    }
    failed
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_trace_begins_where_its_error_is_of_the_order_of_the_latest() {
        let spread = vec![90.0, 40.0, 0.5, 9.0, 2.0, 1.0, 0.5];
        let points: Vec<[f64; 2]> = (0..7).map(|k| [f64::from(k), 1.0]).collect();
        let trace = EstimateTrace { points, spread };
        // Eight times the latest error are 4: the last above that is the fourth.
        assert_eq!(trace.settled(), (&[[4.0, 1.0], [5.0, 1.0], [6.0, 1.0]][..], &[2.0, 1.0, 0.5][..]));
        assert_eq!(EstimateTrace::default().settled(), (&[][..], &[][..]));
    }
}
