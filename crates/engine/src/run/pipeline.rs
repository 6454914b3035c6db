//! From a session to everything that follows from it, in the order of the stages.

use std::collections::HashMap;
use std::path::Path;
use std::sync::Arc;
use std::time::{Duration, Instant};

use doublet_core::airframe::LoadedState;
use doublet_core::model::Structure;
use doublet_core::reconstruct::{FilterData, lane_groups};
use rayon::prelude::*;

use super::board::Board;
use super::control::{Cancelled, Control};
use super::flights::{KeyedFlight, load_flights, model_engines, propose};
use super::physics;
use super::proof;
use super::snapshot::{LogEntry, Slot, Snapshot, WindowResults};
use super::studies;
use crate::graph::{Cache, Key, KeyBuilder};
use crate::session::{self, Manoeuvre, Session, WindowRole};
use crate::stage::{
    self, AeroWindow, AircraftData, LoadedAircraft, LoadedFlight, PooledFits, Samples, Surroundings, WindowPath,
};
use crate::study::{Study, StudyWindow, Subject};
use crate::verdict;

/// How many lines the log keeps.
const LOG_LINES: usize = 500;

/// What a run is asked for.
#[derive(Clone, Copy, Debug)]
pub struct Scope<'a> {
    /// Session to follow.
    pub session: &'a Session,
    /// Folder its relative paths start from.
    pub folder: &'a Path,
    /// Window to compute first.
    pub first: Option<&'a str>,
    /// What to compute beside the derivatives.
    pub studies: &'a [Study],
    /// What asked for it.
    pub cause: &'a str,
    /// Number of the request.
    pub generation: u64,
}

/// A window with what its stages need and the key of its flight.
struct Task<'a> {
    manoeuvre: &'a Manoeuvre,
    flight: Arc<LoadedFlight>,
    flight_key: Key,
}

/// A window whose path is known.
struct Reconstructed<'a> {
    task: &'a Task<'a>,
    path: Arc<WindowPath>,
    key: Key,
}

/// Computes everything the session asks for, publishing snapshots on the way; returns the last one.
///
/// Outputs found in `cache` are not computed again. A stage that fails leaves its error in its slot and does not stop the others.
pub fn run(
    scope: &Scope<'_>,
    previous: &Snapshot,
    cache: &Cache,
    control: &Control,
    publish: &(dyn Fn(Snapshot) + Sync),
) -> Snapshot {
    let started = Instant::now();
    let windows = active_windows(scope.session);
    let steps = 2 + 4 * scope.session.flights.len() + 3 * windows.len() + scope.studies.len();
    let board =
        Board::new(first_snapshot(scope, previous, &windows), previous.generation == 0, steps, publish, control);
    let cancelled = stages(scope, &windows, cache, &board).is_err();
    let mut snapshot = board.read(Snapshot::clone);
    snapshot.busy = false;
    snapshot.progress = 1.0;
    let text = if cancelled {
        cancel_running(&mut snapshot);
        "cancelled".to_owned()
    } else {
        let verdicts = verdict::judge(scope.session, &snapshot);
        snapshot.verdicts.finish(Ok(Arc::new(verdicts)));
        match snapshot.failures().len() {
            0 => format!("up to date: {} in use", plural(windows.len(), "window")),
            failures => format!("{} in use, {}", plural(windows.len(), "window"), plural(failures, "failure")),
        }
    };
    let mut note = |text: String, duration| {
        let cause = scope.cause.to_owned();
        snapshot.log.push(LogEntry { generation: scope.generation, cause, text, duration });
    };
    note(text, started.elapsed());
    if !cancelled {
        let failures = board.read(Snapshot::failures);
        failures.into_iter().for_each(|(place, error)| note(format!("{place}: {error}"), Duration::ZERO));
        let warning = session::path_warning(scope.session);
        // Said once, not by every run.
        let new = warning.filter(|text| previous.log.iter().all(|line| line.text != *text));
        new.into_iter().for_each(|text| note(text, Duration::ZERO));
    }
    let excess = snapshot.log.len().saturating_sub(LOG_LINES);
    snapshot.log.drain(..excess);
    publish(snapshot.clone());
    snapshot
}

fn plural(count: usize, noun: &str) -> String {
    format!("{count} {noun}{}", if count == 1 { "" } else { "s" })
}

/// Windows that are not ignored.
fn active_windows(session: &Session) -> Vec<&Manoeuvre> {
    session.windows.iter().filter(|window| window.role != WindowRole::Ignored).collect()
}

/// The previous snapshot without what left the session, everything else marked as running.
fn first_snapshot(scope: &Scope<'_>, previous: &Snapshot, windows: &[&Manoeuvre]) -> Snapshot {
    let mut snapshot = Snapshot {
        generation: scope.generation,
        cause: scope.cause.to_owned(),
        busy: true,
        progress: 0.0,
        ..previous.clone()
    };
    snapshot.flights.retain(|name, _| scope.session.flight(name).is_some());
    snapshot.flown.retain(|name, _| scope.session.flight(name).is_some());
    snapshot.engines.retain(|name, _| scope.session.flight(name).is_some());
    snapshot.physics.retain(|name, _| scope.session.flight(name).is_some());
    snapshot.proposals.retain(|name, _| scope.session.flight(name).is_some());
    snapshot.noise.retain(|name, _| scope.session.flight(name).is_some());
    snapshot.windows.retain(|name, _| windows.iter().any(|window| window.name == *name));
    for window in windows {
        let results = snapshot.windows.entry(window.name.clone()).or_default();
        results.path.begin();
        results.aero.begin();
        results.fits.begin();
    }
    for flight in &scope.session.flights {
        snapshot.flights.entry(flight.name.clone()).or_default().begin();
        snapshot.flown.entry(flight.name.clone()).or_default().begin();
        snapshot.engines.entry(flight.name.clone()).or_default().begin();
        snapshot.physics.entry(flight.name.clone()).or_default().begin();
        snapshot.proposals.entry(flight.name.clone()).or_default().begin();
        snapshot.noise.entry(flight.name.clone()).or_default().begin();
    }
    snapshot.aircraft.begin();
    snapshot.loaded.begin();
    snapshot.pooled.begin();
    snapshot.proof.begin();
    snapshot.verdicts.begin();
    studies::begin(&mut snapshot.studies, scope.studies);
    if scope.session.second_structure.is_some() {
        snapshot.second.begin();
    }
    if snapshot.details.latest().is_some() {
        snapshot.details.begin();
    }
    snapshot
}

fn cancel_running(snapshot: &mut Snapshot) {
    snapshot.aircraft.cancel();
    snapshot.loaded.cancel();
    snapshot.flights.values_mut().for_each(Slot::cancel);
    snapshot.flown.values_mut().for_each(Slot::cancel);
    snapshot.engines.values_mut().for_each(Slot::cancel);
    snapshot.physics.values_mut().for_each(Slot::cancel);
    snapshot.proposals.values_mut().for_each(Slot::cancel);
    snapshot.noise.values_mut().for_each(Slot::cancel);
    for results in snapshot.windows.values_mut() {
        results.path.cancel();
        results.aero.cancel();
        results.fits.cancel();
    }
    snapshot.pooled.cancel();
    snapshot.proof.cancel();
    snapshot.verdicts.cancel();
    studies::cancel(&mut snapshot.studies);
    snapshot.second.cancel();
}

fn stages(scope: &Scope<'_>, windows: &[&Manoeuvre], cache: &Cache, board: &Board<'_>) -> Result<(), Cancelled> {
    let aircraft = load_aircraft(scope, cache, board)?;
    let flights = load_flights(scope, cache, board)?;
    let recording = |name: &str| Some(&flights.iter().find(|flight| flight.name == name)?.loaded.as_ref()?.recording);
    let gravity = stage::gravity(scope.session, recording);
    let session = stage::with_gravity(scope.session, &gravity);
    let scope = &Scope { session: &session, ..*scope };
    board.update(|snapshot| snapshot.gravity = Some(gravity))?;
    let tasks = tasks(windows, &flights, board)?;
    let known = aircraft.as_ref().ok().map(|keyed| (&keyed.data, keyed.loaded_key));
    let paths = reconstruct_all(scope, &tasks, known, cache, board)?;
    let KeyedAircraft { data: aircraft, file_key, loaded_key } = match aircraft {
        Ok(keyed) => keyed,
        Err(reason) => return without_aircraft(scope, &flights, &paths, &reason, cache, board),
    };
    weigh(&flights, windows, &aircraft, board)?;
    let windows = form_coefficients(scope, &paths, (&aircraft, loaded_key), cache, board)?;
    let (pooled, key) = pool(scope, &windows, cache, board)?;
    let windows: Vec<_> = windows.into_iter().map(|(window, _)| window).collect();
    let subject = Subject { session: scope.session, aircraft: &aircraft, windows: &windows, pooled: &pooled };
    proof::prove(&subject, key, cache, board)?;
    model_engines(&flights, (&aircraft.loaded, file_key), cache, board)?;
    physics::compare(scope.session, &flights, cache, board)?;
    propose(scope, &flights, cache, board)?;
    studies::Runner { subject, key, wanted: scope.studies, cache, board }.run()
}

/// Why there is no aircraft.
enum NoAircraft {
    /// The session names none: nothing that needs one is asked for.
    NotChosen,
    /// It could not be read.
    Failed,
}

impl NoAircraft {
    /// What becomes of an output that needs the aircraft.
    fn settle<T>(&self, slot: &mut Slot<T>) {
        match self {
            Self::NotChosen => *slot = Slot::NotRequested,
            Self::Failed => slot.finish(Err("the aircraft could not be read".to_owned())),
        }
    }
}

/// What is left of a run without an aircraft: flight paths and proposals.
fn without_aircraft(
    scope: &Scope<'_>,
    flights: &[KeyedFlight<'_>],
    paths: &[Reconstructed<'_>],
    reason: &NoAircraft,
    cache: &Cache,
    board: &Board<'_>,
) -> Result<(), Cancelled> {
    for path in paths {
        board.step(|snapshot| {
            if let Some(results) = snapshot.windows.get_mut(&path.task.manoeuvre.name) {
                reason.settle(&mut results.aero);
                reason.settle(&mut results.fits);
            }
        })?;
    }
    board.step(|snapshot| {
        snapshot.engines.clear();
        snapshot.flown.clear();
        reason.settle(&mut snapshot.pooled);
        snapshot.second = Slot::NotRequested;
        snapshot.proof = Slot::NotRequested;
        studies::cancel(&mut snapshot.studies);
    })?;
    physics::compare(scope.session, flights, cache, board)?;
    propose(scope, flights, cache, board)
}

/// The aircraft with the keys of its file and of the file with the session's loading.
struct KeyedAircraft {
    data: AircraftData,
    file_key: Key,
    loaded_key: Key,
}

fn load_aircraft(
    scope: &Scope<'_>,
    cache: &Cache,
    board: &Board<'_>,
) -> Result<Result<KeyedAircraft, NoAircraft>, Cancelled> {
    let Some(path) = &scope.session.aircraft else {
        board.step(|snapshot| {
            snapshot.aircraft = Slot::NotRequested;
            snapshot.loaded = Slot::NotRequested;
        })?;
        return Ok(Err(NoAircraft::NotChosen));
    };
    let loading = scope.session.loading.as_ref();
    let read = || -> Result<(Arc<LoadedAircraft>, KeyedAircraft), String> {
        let text = stage::text(scope.folder, path, "aircraft")?;
        let files = stage::aircraft_files(scope.folder, path);
        let key = files.iter().fold(KeyBuilder::new("aircraft", 2).text(path).text(&text), |key, file| key.file(file));
        let key = key.finish();
        let loaded = cache.get_or_try(key, || stage::load_aircraft(scope.folder, path))?;
        let data = stage::aircraft_data(Arc::clone(&loaded), loading).map_err(|error| format!("{path}: {error}"))?;
        let loaded_key = KeyBuilder::new("loading", 1).key(key).parameters(&loading).finish();
        Ok((loaded, KeyedAircraft { data, file_key: key, loaded_key }))
    };
    let (result, state, data) = match read() {
        Ok((loaded, keyed)) => {
            let state = LoadedState::new("on board", &loaded.aircraft, &keyed.data.loading);
            (Ok(loaded), Ok(Arc::new(state)), Ok(keyed))
        }
        Err(error) => (Err(error.clone()), Err(error), Err(NoAircraft::Failed)),
    };
    board.step(|snapshot| {
        snapshot.aircraft.finish(result);
        snapshot.loaded.finish(state);
    })?;
    Ok(data)
}

/// Mass properties over every flight that was read.
fn weigh(
    flights: &[KeyedFlight<'_>],
    windows: &[&Manoeuvre],
    aircraft: &AircraftData,
    board: &Board<'_>,
) -> Result<(), Cancelled> {
    for flight in flights {
        let of_flight: Vec<_> = windows.iter().copied().filter(|window| window.flight == flight.name).collect();
        let flown = match &flight.loaded {
            Some(loaded) => stage::flown(aircraft, &loaded.recording, &of_flight).map(Arc::new),
            None => Err("the flight could not be read".to_owned()),
        };
        board.update(|snapshot| snapshot.flown.entry(flight.name.to_owned()).or_default().finish(flown))?;
    }
    Ok(())
}

/// The windows whose flight was read; the others fail.
fn tasks<'a>(
    windows: &[&'a Manoeuvre],
    flights: &[KeyedFlight<'a>],
    board: &Board<'_>,
) -> Result<Vec<Task<'a>>, Cancelled> {
    let mut tasks = Vec::new();
    for &manoeuvre in windows {
        let name = &manoeuvre.flight;
        let error = match flights.iter().find(|flight| flight.name == name) {
            Some(KeyedFlight { loaded: Some(loaded), key, .. }) => {
                tasks.push(Task { manoeuvre, flight: Arc::clone(loaded), flight_key: *key });
                continue;
            }
            Some(_) => format!("flight '{name}' could not be read"),
            None => format!("the session has no flight '{name}'"),
        };
        board.step(|snapshot| fail_window(snapshot, &manoeuvre.name, &error))?;
    }
    Ok(tasks)
}

fn fail_window(snapshot: &mut Snapshot, window: &str, error: &str) {
    if let Some(WindowResults { path, aero, fits }) = snapshot.windows.get_mut(window) {
        path.finish(Err(error.to_owned()));
        aero.finish(Err(error.to_owned()));
        fits.finish(Err(error.to_owned()));
    }
}

/// Samples of a window, ready for the filter.
struct Prepared<'a> {
    task: &'a Task<'a>,
    samples: Arc<Samples>,
    key: Key,
}

fn reconstruct_all<'a>(
    scope: &Scope<'a>,
    tasks: &'a [Task<'a>],
    aircraft: Option<(&AircraftData, Key)>,
    cache: &Cache,
    board: &Board<'_>,
) -> Result<Vec<Reconstructed<'a>>, Cancelled> {
    let session = scope.session;
    let (aircraft, aircraft_key) = match aircraft {
        Some((aircraft, key)) => (Some(aircraft), key),
        None => (None, KeyBuilder::new("no aircraft", 1).finish()),
    };
    let prepare = |task: &'a Task<'a>| -> Result<Option<Prepared<'a>>, Cancelled> {
        let window = task.manoeuvre.window;
        let key = samples_key("samples", task, aircraft_key, session);
        let samples = || stage::samples(&task.flight.recording, window, aircraft, &session.preparation);
        match cache.get_or_try(key, samples) {
            Ok(samples) => Ok(Some(Prepared { task, key: path_key(samples.content, session), samples })),
            Err(error) => {
                board.step(|snapshot| fail_window(snapshot, &task.manoeuvre.name, &error))?;
                Ok(None)
            }
        }
    };
    let prepared: Vec<_> = tasks.par_iter().map(prepare).collect::<Result<_, _>>()?;
    let mut known = Vec::new();
    let mut missing = Vec::new();
    for item in prepared.into_iter().flatten() {
        match cache.get::<WindowPath>(item.key) {
            Some(path) => {
                show_path(board, &item.task.manoeuvre.name, Ok(Arc::clone(&path)))?;
                known.push(Reconstructed { task: item.task, path, key: item.key });
            }
            None => missing.push(item),
        }
    }
    let data: Vec<_> = missing.iter().map(|item| &*item.samples.data).collect();
    let groups = lane_groups(&data, rayon::current_num_threads());
    let mut missing: Vec<_> = missing.into_iter().map(Some).collect();
    let mut batches: Vec<Vec<Prepared<'a>>> =
        groups.iter().map(|group| group.iter().filter_map(|&index| missing[index].take()).collect()).collect();
    batches.sort_by_key(|batch| !batch.iter().any(|item| scope.first == Some(item.task.manoeuvre.name.as_str())));
    // One after the other to whoever is free: halves dealt out beforehand would leave the large groups to one core.
    let computed = batches.into_iter().par_bridge().map(|batch| reconstruct_batch(session, batch, cache, board));
    known.extend(computed.collect::<Result<Vec<_>, _>>()?.into_iter().flatten());
    Ok(known)
}

/// Runs windows side by side in the lanes of one core.
fn reconstruct_batch<'a>(
    session: &Session,
    batch: Vec<Prepared<'a>>,
    cache: &Cache,
    board: &Board<'_>,
) -> Result<Vec<Reconstructed<'a>>, Cancelled> {
    board.control.checkpoint()?;
    let (tasks, samples): (Vec<_>, Vec<_>) =
        batch.into_iter().map(|item| ((item.task, item.key), item.samples)).unzip();
    let mut reconstructed = Vec::new();
    for ((task, key), result) in tasks.into_iter().zip(stage::paths(&samples, session, board.control)) {
        board.control.checkpoint()?;
        let result = result.map(|path| cache.insert(key, path));
        if let Ok(path) = &result {
            reconstructed.push(Reconstructed { task, path: Arc::clone(path), key });
        }
        show_path(board, &task.manoeuvre.name, result)?;
    }
    Ok(reconstructed)
}

fn show_path(board: &Board<'_>, window: &str, result: Result<Arc<WindowPath>, String>) -> Result<(), Cancelled> {
    board.step(|snapshot| match result {
        Err(error) => fail_window(snapshot, window, &error),
        Ok(path) => {
            if let Some(slots) = snapshot.windows.get_mut(window) {
                slots.path.finish(Ok(path));
            }
        }
    })
}

/// What the samples of a window depend on, and what was recorded around them.
fn samples_key(stage: &'static str, task: &Task<'_>, aircraft_key: Key, session: &Session) -> Key {
    let key = KeyBuilder::new(stage, 1).key(task.flight_key).key(aircraft_key);
    key.parameters(&task.manoeuvre.window).parameters(&session.preparation).finish()
}

/// What the path depends on: the samples the filter gets and its settings.
fn path_key(content: Key, session: &Session) -> Key {
    KeyBuilder::new("path", 2).key(content).parameters(&session.filter).parameters(&session.preparation.path).finish()
}

fn form_coefficients<'a>(
    scope: &Scope<'a>,
    paths: &[Reconstructed<'a>],
    (aircraft, aircraft_key): (&AircraftData, Key),
    cache: &Cache,
    board: &Board<'_>,
) -> Result<Vec<(StudyWindow<'a>, Key)>, Cancelled> {
    let session = scope.session;
    let surroundings = |task: &Task<'_>, data: &FilterData| {
        let key = samples_key("surroundings", task, aircraft_key, session);
        cache.get_or_try(key, || Surroundings::new(&task.flight.recording, data, aircraft, &session.preparation))
    };
    let one = |item: &Reconstructed<'a>| -> Result<Option<(StudyWindow<'a>, Key)>, Cancelled> {
        let Reconstructed { task, path, key } = item;
        let key = KeyBuilder::new("aero", 1)
            .key(*key)
            .key(task.flight_key)
            .key(aircraft_key)
            .parameters(&session.preparation)
            .finish();
        let result = cache.get_or_try(key, || {
            let around = surroundings(task, &path.data)?;
            stage::aero(&around, &path.reconstruction, aircraft, &session.preparation)
        });
        let aero = result.as_ref().ok().cloned();
        let manoeuvre = task.manoeuvre;
        let fits = aero.as_ref().map(|aero| {
            let key = KeyBuilder::new("fits", 1)
                .key(key)
                .parameters(&manoeuvre.settings())
                .parameters(&session.structure)
                .parameters(&session.estimation)
                .finish();
            cache.get(key).unwrap_or_else(|| {
                cache.insert(key, stage::window_fits(manoeuvre, aero, &session.structure, &session.estimation))
            })
        });
        let error = result.as_ref().err().cloned();
        board.step(|snapshot| {
            if let Some(slots) = snapshot.windows.get_mut(&manoeuvre.name) {
                slots.aero.finish(result);
                slots.fits.finish(fits.clone().ok_or_else(|| error.unwrap_or_default()));
            }
        })?;
        let (flight, path) = (Arc::clone(&task.flight), Arc::clone(path));
        let known = aero.zip(fits);
        Ok(known.map(|(aero, fits)| (StudyWindow { manoeuvre, flight, path, aero, fits }, key)))
    };
    let aero: Vec<_> = paths.par_iter().map(one).collect::<Result<_, _>>()?;
    let mut aero: Vec<_> = aero.into_iter().flatten().collect();
    // The order of the session, whatever was computed first: the estimate does not depend on what the user looks at.
    let order: HashMap<&str, usize> =
        scope.session.windows.iter().enumerate().map(|(index, window)| (window.name.as_str(), index)).collect();
    aero.sort_by_key(|(window, _)| order.get(window.manoeuvre.name.as_str()).copied());
    Ok(aero)
}

fn pool(
    scope: &Scope<'_>,
    windows: &[(StudyWindow<'_>, Key)],
    cache: &Cache,
    board: &Board<'_>,
) -> Result<(Arc<PooledFits>, Key), Cancelled> {
    let session = scope.session;
    let aero: Vec<AeroWindow<'_>> =
        windows.iter().map(|(window, _)| (window.manoeuvre, Arc::clone(&window.aero))).collect();
    let by = |structure: &Structure| {
        let mut key = KeyBuilder::new("pooled", 1).parameters(structure).parameters(&session.estimation);
        for (window, aero_key) in windows {
            key = key.key(*aero_key).parameters(&window.manoeuvre.settings());
        }
        let key = key.finish();
        let pooled = cache.get(key);
        (pooled.unwrap_or_else(|| cache.insert(key, stage::pooled_fits(&aero, structure, &session.estimation))), key)
    };
    let (pooled, key) = by(&session.structure);
    board.step(|snapshot| snapshot.pooled.finish(Ok(Arc::clone(&pooled))))?;
    let second = session.second_structure.as_ref().map(by);
    board.update(|snapshot| match second {
        Some((second, _)) => snapshot.second.finish(Ok(second)),
        None => snapshot.second = Slot::NotRequested,
    })?;
    board.show();
    Ok((pooled, key))
}
