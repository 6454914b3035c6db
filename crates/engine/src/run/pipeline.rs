//! From a session to everything that follows from it, in the order of the stages.

use std::collections::{BTreeMap, HashMap};
use std::path::Path;
use std::sync::{Arc, mpsc};
use std::time::{Duration, Instant};

use doublet_core::airframe::LoadedState;
use doublet_core::quantity::Role;
use doublet_core::reconstruct::{FilterData, FilterSettings, Reconstruction, lane_groups};
use doublet_core::series::LONG_WINDOW;
use rayon::prelude::*;

use super::snapshot_builder::{SnapshotBuilder, first_snapshot};
use super::studies;
use crate::graph::{Cache, Cancelled, Context, Control, Key, Keyed, Stage, StageError, StageResult, guarded};
use crate::notation::plural;
use crate::session::{self, Flight, Manoeuvre, PathSource, Session};
use crate::snapshot::{AnySlot, LogEntry, Slot, SlotGroup, Snapshot, WindowResults};
use crate::stage::{
    self, AircraftData, DelaysAndGusts, EstimatedSensorErrors, FlightEngines, FlightPhysics, FlightProposals,
    FlownMass, LoadedAircraft, LoadedFlight, PathErrors, PooledFits, ProofOfMatch, Samples, SensorDelays, SessionGusts,
    SessionNoise, StudyWindow, WidenedFits, WindowAero, WindowFits, WindowPath,
};
use crate::study::{Study, StudyInput};
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
    /// Window to compute and publish before all others.
    pub first: Option<&'a str>,
    /// What to compute beside the derivatives.
    pub studies: &'a [Study],
    /// What asked for it.
    pub cause: &'a str,
    /// Number of the request.
    pub generation: u64,
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
    let windows: Vec<&Manoeuvre> = scope.session.active_windows().collect();
    let (first, steps) = first_snapshot(scope, previous, &windows);
    let builder = SnapshotBuilder::new(first, previous, steps, publish, control);
    let context = Context::new(scope.folder).with_cache(cache).with_control(control, &|_| ());
    let run = Run { scope, windows: &windows, context: &context, builder: &builder };
    let ended = guarded("run", || run.stages().map_err(StageError::from));
    let cancelled = ended == Err(StageError::Cancelled);
    let mut snapshot = builder.read(Snapshot::clone);
    if let Err(reason) = &ended {
        snapshot.end(reason);
    }
    snapshot.busy = false;
    snapshot.progress = 1.0;
    snapshot.files = context.files().into();
    let mut failures = Vec::new();
    let text = if cancelled {
        "cancelled".to_owned()
    } else {
        let verdicts = guarded("verdict", || Ok(verdict::judge(scope.session, &snapshot).into()));
        snapshot.verdicts.finish(verdicts);
        failures = snapshot.failures();
        match failures.len() {
            0 => format!("up to date: {} in use", plural(windows.len(), "manoeuvre")),
            failures => format!("{} in use, {}", plural(windows.len(), "manoeuvre"), plural(failures, "failure")),
        }
    };
    let mut note = |text: String, duration, failed| {
        let cause = scope.cause.to_owned();
        snapshot.log.push(LogEntry { generation: scope.generation, cause, text, duration, failed });
    };
    note(text, started.elapsed(), false);
    if !cancelled {
        failures.into_iter().for_each(|(place, error)| note(format!("{place}: {error}"), Duration::ZERO, true));
        let warning = session::path_warning(scope.session);
        // Said once, not by every run.
        let new = warning.filter(|text| previous.log.iter().all(|line| line.text != *text));
        new.into_iter().for_each(|text| note(text, Duration::ZERO, false));
    }
    let excess = snapshot.log.len().saturating_sub(LOG_LINES);
    snapshot.log.drain(..excess);
    publish(snapshot.clone());
    snapshot
}

/// One run: what is asked for, in which context, and where it is shown.
pub(super) struct Run<'a> {
    pub(super) scope: &'a Scope<'a>,
    windows: &'a [&'a Manoeuvre],
    pub(super) context: &'a Context<'a>,
    pub(super) builder: &'a SnapshotBuilder<'a>,
}

/// The aircraft as its file says, and with the session's loading on board.
type Aircraft = (Keyed<LoadedAircraft>, Keyed<AircraftData>);

struct ReadFlight<'a> {
    flight: &'a Flight,
    loaded: Keyed<LoadedFlight>,
    /// The aircraft with what was on board in this flight.
    aircraft: Option<Keyed<AircraftData>>,
}

/// A window on its way through the filter.
struct Task<'a> {
    manoeuvre: &'a Manoeuvre,
    flight: Keyed<LoadedFlight>,
    aircraft: Option<Keyed<AircraftData>>,
    samples: Keyed<Samples>,
    /// Its path where it is known, or the key it is to be kept under.
    path: Result<Keyed<WindowPath>, Key>,
}

/// A window that has a path.
struct IdentifiedWindow<'a> {
    manoeuvre: &'a Manoeuvre,
    samples: Keyed<Samples>,
    /// With coefficients and fits, where it has them.
    study: Option<StudyWindow<'a>>,
}

/// What the filter made of a window.
type Reconstructed = Result<Reconstruction, StageError>;

/// How paths are reconstructed.
fn path_settings(session: &Session) -> (&FilterSettings, PathSource) {
    (&session.filter, session.preparation.path)
}

fn window_results_mut<'s>(snapshot: &'s mut Snapshot, name: &str) -> &'s mut WindowResults {
    snapshot.windows.entry(name.to_owned()).or_default()
}

fn flight_slot_mut<'s, T>(slots: &'s mut BTreeMap<String, Slot<T>>, flight: &Flight) -> &'s mut Slot<T> {
    slots.entry(flight.name.clone()).or_default()
}

impl<'a> Run<'a> {
    /// Shows what a stage came to in its slot; hands on the output, where there is one.
    fn store_result<T>(
        &self,
        result: Result<Keyed<T>, StageError>,
        slot: impl FnOnce(&mut Snapshot) -> &mut Slot<T>,
    ) -> Result<Option<Keyed<T>>, Cancelled> {
        if matches!(result, Err(StageError::Cancelled)) {
            return Err(Cancelled);
        }
        let known = result.as_ref().ok().cloned();
        self.builder.step(|snapshot| slot(snapshot).finish(result))?;
        Ok(known)
    }

    /// Computes a stage and shows it.
    fn compute<S: Stage>(
        &self,
        params: S::Params<'_>,
        inputs: S::Inputs<'_>,
        slot: impl FnOnce(&mut Snapshot) -> &mut Slot<S::Output>,
    ) -> Result<Option<Keyed<S::Output>>, Cancelled> {
        self.store_result(self.context.get::<S>(params, inputs), slot)
    }

    fn stages(&self) -> Result<(), Cancelled> {
        let session = self.scope.session;
        let aircraft = self.load_aircraft()?;
        let flights = self.load_flights(aircraft.as_ref())?;
        let recording = |name: &str| Some(&flights.iter().find(|read| read.flight.name == name)?.loaded.recording);
        let gravity = stage::gravity(session, recording);
        let session = stage::with_gravity(session, &gravity);
        self.builder.update(|snapshot| snapshot.gravity = Some(gravity))?;
        let session = self.settle_filter(session, &flights)?;
        // Nothing but the verdict hangs on it; beside what long windows take there is no room for it.
        let is_examined = self.has_long_window(&flights);
        if is_examined {
            self.examine_flights(&flights)?;
        }
        let windows = self.identify_windows(&session, &flights)?;
        self.tell_sensor_errors(&session, &windows)?;
        if let Some((aircraft, loaded)) = &aircraft {
            self.weigh(&flights)?;
            let windows: Vec<_> = windows.into_iter().filter_map(|window| window.study).collect();
            let pooled = self.pool(&session, &windows)?;
            windows.par_iter().for_each(|window| _ = window.path.assessment());
            let input =
                StudyInput { settings: session.settings(), aircraft: loaded, windows: &windows, pooled: &pooled };
            self.compute::<ProofOfMatch>(input.settings, (&windows, &pooled), |snapshot| &mut snapshot.proof)?;
            let engines = |ReadFlight { flight, loaded, .. }: &ReadFlight<'_>| {
                let inputs = (loaded, aircraft);
                self.compute::<FlightEngines>((), inputs, |snapshot| flight_slot_mut(&mut snapshot.engines, flight))
                    .map(|_| ())
            };
            flights.par_iter().try_for_each(engines)?;
            if !is_examined {
                self.examine_flights(&flights)?;
            }
            studies::run(self, &input)
        } else {
            self.skip_aircraft()?;
            if is_examined { Ok(()) } else { self.examine_flights(&flights) }
        }
    }

    /// The session with the delays and the gusts of its windows in the filter, where it asks for them.
    fn settle_filter(&self, session: Session, flights: &[ReadFlight<'_>]) -> Result<Session, Cancelled> {
        if !stage::needs_delays_or_gusts(&session) {
            self.builder.update(|snapshot| snapshot.delays_and_gusts = DelaysAndGusts::default())?;
            return Ok(session);
        }
        let samples = |manoeuvre: &&Manoeuvre| {
            let ReadFlight { loaded, aircraft, .. } =
                flights.iter().find(|read| read.flight.name == manoeuvre.flight)?;
            let inputs = (loaded, aircraft.as_ref());
            // A window without samples says why where it is prepared.
            self.context.get::<Samples>((manoeuvre.samples(), &session.preparation), inputs).ok()
        };
        let samples: Vec<_> = self.windows.par_iter().filter_map(samples).collect();
        let gusts = |settings: &FilterSettings| {
            let found = unless_cancelled(self.context.get::<SessionGusts>(settings, &samples))?;
            Ok(found.and_then(|found| found.0.clone()))
        };
        let delays = |settings: &FilterSettings| {
            let found = unless_cancelled(self.context.get::<SensorDelays>(settings, &samples))?;
            Ok(found.map(|found| SensorDelays::clone(&found)))
        };
        let data: Vec<&FilterData> = samples.iter().map(|samples| &*samples.data).collect();
        let flow_delay = || stage::flow_delay_by_lift(&data, &session.filter);
        let found = stage::estimate_in_turn::<Cancelled>(&session, &gusts, &delays, &flow_delay)?;
        let filter = found.added_to(&session.filter);
        self.builder.update(|snapshot| snapshot.delays_and_gusts = found)?;
        Ok(Session { filter, ..session })
    }

    /// Whether some window holds more samples than are worked on side by side.
    fn has_long_window(&self, flights: &[ReadFlight<'_>]) -> bool {
        let samples = |window: &Manoeuvre| {
            let flight = flights.iter().find(|read| read.flight.name == window.flight)?;
            let inertial = flight.loaded.recording.role(Role::SpecificForceZ)?;
            Some(window.window.indices(&inertial.series.time_s).len())
        };
        self.windows.iter().any(|window| samples(window).is_some_and(|samples| samples > LONG_WINDOW))
    }

    /// The aircraft, as its file says and with the session's loading on board.
    fn load_aircraft(&self) -> Result<Option<Aircraft>, Cancelled> {
        let loading = &self.scope.session.loading;
        let aircraft = stage::aircraft_of(self.context, self.scope.session);
        let load = |aircraft: &Keyed<LoadedAircraft>| self.context.get::<AircraftData>(loading.as_ref(), aircraft);
        let loaded = aircraft.as_ref().map_err(Clone::clone).and_then(load);
        let state = loaded.as_ref().map(|loaded| {
            let state = LoadedState::new("on board", &loaded.loaded.aircraft, &loaded.loading);
            Keyed::new(state.into(), loaded.key())
        });
        self.store_result(state.map_err(Clone::clone), |snapshot| &mut snapshot.loaded)?;
        let errors = if let Err(StageError::Aircraft { errors, .. }) = &aircraft { errors.clone() } else { Vec::new() };
        self.builder.update(|snapshot| snapshot.aircraft_errors = errors)?;
        Ok(self.store_result(aircraft, |snapshot| &mut snapshot.aircraft)?.zip(loaded.ok()))
    }

    /// What is left where there is no aircraft.
    fn skip_aircraft(&self) -> Result<(), Cancelled> {
        let error = match self.scope.session.aircraft {
            Some(_) => StageError::from("the aircraft could not be read"),
            None => StageError::NotApplicable,
        };
        self.builder.update(|snapshot| {
            for results in snapshot.windows.values_mut().filter(|results| results.path.error().is_none()) {
                results.aero.fail(&error);
                results.fits.fail(&error);
            }
            snapshot.engines.clear();
            snapshot.flown.clear();
            snapshot.pooled.fail(&error);
            snapshot.proof = Slot::NotRequested;
            snapshot.studies.each_mut("", &mut |_, slot| slot.end(&StageError::Cancelled));
        })
    }

    /// The flights that could be read, with what was on board.
    fn load_flights(&self, aircraft: Option<&Aircraft>) -> Result<Vec<ReadFlight<'a>>, Cancelled> {
        let on_board = |flight: &Flight| -> StageResult<Option<Keyed<AircraftData>>> {
            let Some((aircraft, loaded)) = aircraft else { return Ok(None) };
            let own = flight.loading.as_ref();
            own.map_or(Ok(loaded.clone()), |own| self.context.get::<AircraftData>(Some(own), aircraft)).map(Some)
        };
        let one = |flight: &'a Flight| -> Result<Option<ReadFlight<'a>>, Cancelled> {
            let loaded = self.load_flight(flight)?;
            // Every loading has mass properties: nothing but a stop fails here.
            let aircraft = on_board(flight).map_err(|_| Cancelled)?;
            Ok(loaded.map(|loaded| ReadFlight { flight, loaded, aircraft }))
        };
        let flights: Vec<_> = self.scope.session.flights.par_iter().map(one).collect::<Result<_, _>>()?;
        Ok(flights.into_iter().flatten().collect())
    }

    fn load_flight(&self, flight: &Flight) -> Result<Option<Keyed<LoadedFlight>>, Cancelled> {
        let loaded = self.context.get::<LoadedFlight>(&flight.as_read(), ());
        let loaded = self.store_result(loaded, |snapshot| flight_slot_mut(&mut snapshot.flights, flight))?;
        if loaded.is_none() {
            self.builder.update(|snapshot| {
                flight_slot_mut(&mut snapshot.flown, flight).fail(&"the flight could not be read".into());
                *flight_slot_mut(&mut snapshot.engines, flight) = Slot::NotRequested;
                *flight_slot_mut(&mut snapshot.physics, flight) = Slot::NotRequested;
                *flight_slot_mut(&mut snapshot.proposals, flight) = Slot::NotRequested;
                *flight_slot_mut(&mut snapshot.noise, flight) = Slot::NotRequested;
            })?;
        }
        Ok(loaded)
    }

    /// Mass properties over every flight that was read.
    fn weigh(&self, flights: &[ReadFlight<'_>]) -> Result<(), Cancelled> {
        for ReadFlight { flight, loaded, aircraft } in flights {
            let Some(aircraft) = aircraft else { continue };
            let windows: Vec<_> = self.windows.iter().copied().filter(|window| window.flight == flight.name).collect();
            let inputs = (aircraft, loaded);
            self.compute::<FlownMass>(&windows, inputs, |snapshot| flight_slot_mut(&mut snapshot.flown, flight))?;
        }
        Ok(())
    }

    fn fail_window(&self, manoeuvre: &Manoeuvre, error: &StageError) -> Result<(), Cancelled> {
        if *error == StageError::Cancelled {
            return Err(Cancelled);
        }
        self.builder.step(|snapshot| {
            window_results_mut(snapshot, &manoeuvre.name).each_mut("", &mut |_, slot| slot.fail(error));
        })
    }

    /// A window with its samples and, where it is known, its path; the window fails where it has none.
    fn prepare(
        &self,
        session: &Session,
        manoeuvre: &'a Manoeuvre,
        flights: &[ReadFlight<'_>],
    ) -> Result<Option<Task<'a>>, Cancelled> {
        let name = &manoeuvre.flight;
        let flight = flights.iter().find(|read| read.flight.name == *name);
        let flight = flight.ok_or_else(|| match session.flight(name) {
            Some(_) => StageError::Failed(format!("flight '{name}' could not be read")),
            None => StageError::Failed(format!("the session has no flight '{name}'")),
        });
        let prepared = flight.and_then(|ReadFlight { loaded, aircraft, .. }| {
            let inputs = (loaded, aircraft.as_ref());
            let samples = self.context.get::<Samples>((manoeuvre.samples(), &session.preparation), inputs)?;
            let path = self.context.find::<WindowPath>(&(&session.filter, session.preparation.path), &&samples);
            Ok(Task { manoeuvre, flight: loaded.clone(), aircraft: aircraft.clone(), samples, path })
        });
        prepared.map(Some).or_else(|error| self.fail_window(manoeuvre, &error).map(|()| None))
    }

    /// The windows that have a path, in the order of the session, with coefficients and fits where they have them too. The window looked
    /// at comes first and is published at once; a core that finds no window left to reconstruct forms the coefficients of those that are.
    fn identify_windows(
        &self,
        session: &Session,
        flights: &[ReadFlight<'_>],
    ) -> Result<Vec<IdentifiedWindow<'a>>, Cancelled> {
        let tasks = self.windows.par_iter().map(|window| self.prepare(session, window, flights));
        let tasks: Vec<_> = tasks.collect::<Result<_, _>>()?;
        let tasks: Vec<Task<'a>> = tasks.into_iter().flatten().collect();
        let (mut known, mut missing): (Vec<_>, Vec<_>) = tasks.into_iter().partition(|task| task.path.is_ok());
        let samples = missing.iter().map(|task| task.samples.data.inputs.time_s.len());
        if let Err(error) = stage::fit_in_memory(samples.sum()) {
            missing.drain(..).try_for_each(|task| self.fail_window(task.manoeuvre, &error))?;
        }
        known.sort_by_key(|task| !self.is_looked_at(task.manoeuvre));
        self.warn_of_memory(&missing)?;
        let (sender, found) = mpsc::channel();
        rayon::scope_fifo(|scope| {
            for batch in self.batches(missing) {
                let sender = sender.clone();
                scope.spawn_fifo(move |scope| {
                    let is_alone = batch.len() == 1;
                    let mut found = self.reconstruct_batch(session, batch);
                    found.sort_by_key(|(task, _)| !self.is_looked_at(task.manoeuvre));
                    for (task, path) in found {
                        let at_once = is_alone || self.is_looked_at(task.manoeuvre);
                        let sender = sender.clone();
                        // Nobody listens any more only where the run has panicked.
                        let identify = move || drop(sender.send(self.identify_window(session, task, Some(path))));
                        // Alone it goes on where it is: another thread would not use the memory again that this one has freed.
                        if at_once { identify() } else { scope.spawn_fifo(move |_| identify()) }
                    }
                });
            }
            for task in known {
                let sender = sender.clone();
                scope.spawn_fifo(move |_| drop(sender.send(self.identify_window(session, task, None))));
            }
        });
        drop(sender);
        let found: Vec<_> = found.into_iter().collect::<Result<_, _>>()?;
        let mut windows: Vec<IdentifiedWindow<'a>> = found.into_iter().flatten().collect();
        // The order of the session, whatever was computed first: the estimate does not depend on what the user looks at.
        let order: HashMap<&str, usize> =
            session.windows.iter().enumerate().map(|(index, window)| (window.name.as_str(), index)).collect();
        windows.sort_by_key(|window| order.get(window.manoeuvre.name.as_str()).copied());
        Ok(windows)
    }

    /// Publishes that windows need more memory than is available, before they take it.
    fn warn_of_memory(&self, missing: &[Task<'_>]) -> Result<(), Cancelled> {
        let samples = missing.iter().map(|task| (task.manoeuvre.name.as_str(), task.samples.data.inputs.time_s.len()));
        let Some(finding) = stage::memory_finding(samples) else { return Ok(()) };
        self.builder.update(|snapshot| snapshot.memory = Some(finding))?;
        self.builder.publish_now();
        Ok(())
    }

    /// Whether the results of a window are wanted before all others.
    fn is_looked_at(&self, manoeuvre: &Manoeuvre) -> bool {
        self.scope.first == Some(manoeuvre.name.as_str())
    }

    /// Windows that run side by side in the lanes of one core, those with the window looked at first.
    fn batches(&self, missing: Vec<Task<'a>>) -> Vec<Vec<Task<'a>>> {
        let data: Vec<_> = missing.iter().map(|task| &*task.samples.data).collect();
        let groups = lane_groups(&data, rayon::current_num_threads());
        let mut missing: Vec<_> = missing.into_iter().map(Some).collect();
        let mut batches: Vec<Vec<Task<'a>>> =
            groups.iter().map(|group| group.iter().filter_map(|&index| missing[index].take()).collect()).collect();
        batches.sort_by_key(|batch| !batch.iter().any(|task| self.is_looked_at(task.manoeuvre)));
        batches
    }

    fn reconstruct_batch(&self, session: &Session, batch: Vec<Task<'a>>) -> Vec<(Task<'a>, Reconstructed)> {
        let data: Vec<_> = batch.iter().map(|task| &*task.samples.data).collect();
        let control = self.context.control();
        let found =
            guarded("path", || Ok::<_, StageError>(stage::reconstructions(&data, path_settings(session), control)));
        let found = found.unwrap_or_else(|error| data.iter().map(|_| Err(error.clone())).collect());
        batch.into_iter().zip(found).collect()
    }

    /// Path, coefficients and fits of a window whose path is known or was just reconstructed; none where it has no path.
    fn identify_window(
        &self,
        session: &Session,
        task: Task<'a>,
        reconstructed: Option<Reconstructed>,
    ) -> Result<Option<IdentifiedWindow<'a>>, Cancelled> {
        let manoeuvre = task.manoeuvre;
        let found = guarded("window", || self.form_window(session, task, reconstructed).map_err(StageError::from));
        found.or_else(|error| self.fail_window(manoeuvre, &error).map(|()| None))
    }

    fn form_window(
        &self,
        session: &Session,
        task: Task<'a>,
        reconstructed: Option<Reconstructed>,
    ) -> Result<Option<IdentifiedWindow<'a>>, Cancelled> {
        let Task { manoeuvre, flight, aircraft, samples, path } = task;
        let path = match (path, reconstructed) {
            (Ok(path), _) => path,
            (Err(_), None) => return Ok(None),
            (Err(_), Some(Err(error))) => return self.fail_window(manoeuvre, &error).map(|()| None),
            (Err(key), Some(Ok(found))) => {
                self.context.store::<WindowPath>(key, WindowPath::new(&samples, found, path_settings(session)))
            }
        };
        if path.reconstruction.time_s.len() > LONG_WINDOW {
            // What that takes for a while is not beside what the coefficients of a long window take.
            path.assessment();
        }
        self.store_result(Ok(path.clone()), |snapshot| &mut window_results_mut(snapshot, &manoeuvre.name).path)?;
        let study = match aircraft {
            Some(aircraft) => self.form_coefficients(session, manoeuvre, (flight, &samples, path, aircraft))?,
            None => None,
        };
        if self.is_looked_at(manoeuvre) {
            self.builder.publish_window(&manoeuvre.name);
        }
        Ok(Some(IdentifiedWindow { manoeuvre, samples, study }))
    }

    /// Constant errors of the sensors over the windows that have a path, in the order of the session.
    fn tell_sensor_errors(&self, session: &Session, windows: &[IdentifiedWindow<'a>]) -> Result<(), Cancelled> {
        let windows: Vec<_> = windows.iter().map(|window| (window.manoeuvre, &window.samples)).collect();
        let params = (&session.sensor_errors, &session.filter);
        self.compute::<EstimatedSensorErrors>(params, &windows, |snapshot| &mut snapshot.sensor_errors).map(|_| ())
    }

    fn form_coefficients(
        &self,
        session: &Session,
        manoeuvre: &'a Manoeuvre,
        (flight, samples, path, aircraft): (
            Keyed<LoadedFlight>,
            &Keyed<Samples>,
            Keyed<WindowPath>,
            Keyed<AircraftData>,
        ),
    ) -> Result<Option<StudyWindow<'a>>, Cancelled> {
        let aero = self.context.get::<WindowAero>(&session.preparation, (&flight, samples, &path, &aircraft));
        let fit = |aero: &Keyed<WindowAero>| {
            self.context.get::<WindowFits>((manoeuvre, &session.structure, &session.estimation), aero)
        };
        let fits = aero.as_ref().map_err(Clone::clone).and_then(fit);
        let aero = self.store_result(aero, |snapshot| &mut window_results_mut(snapshot, &manoeuvre.name).aero)?;
        let fits = self.store_result(fits, |snapshot| &mut window_results_mut(snapshot, &manoeuvre.name).fits)?;
        Ok(aero.zip(fits).map(|(aero, fits)| StudyWindow { manoeuvre, flight, aircraft, path, aero, fits }))
    }

    /// Derivatives of all windows together.
    fn pool(&self, session: &Session, windows: &[StudyWindow<'_>]) -> Result<Keyed<PooledFits>, Cancelled> {
        let formed: Vec<_> = windows.iter().map(|window| (window.manoeuvre, &window.aero, &window.fits)).collect();
        let pooled = self.context.get::<PooledFits>((&session.structure, &session.estimation), &formed);
        let pooled = self.store_result(pooled, |snapshot| &mut snapshot.pooled)?.ok_or(Cancelled)?;
        // Derivatives are shown at once; the errors of the path, which take a path more for each, follow.
        self.builder.publish_now();
        let pooled = self.widen(session, windows, pooled)?;
        self.builder.publish_now();
        Ok(pooled)
    }

    /// The pooled fits with the errors of the path in their corrected standard errors, where those can be formed.
    fn widen(
        &self,
        session: &Session,
        windows: &[StudyWindow<'_>],
        pooled: Keyed<PooledFits>,
    ) -> Result<Keyed<PooledFits>, Cancelled> {
        let inputs: Vec<_> = windows.iter().map(|window| (window.manoeuvre, &window.path, &window.aero)).collect();
        let errors = self.context.get::<PathErrors>(session.settings(), &inputs);
        match errors.and_then(|errors| self.context.get::<WidenedFits>((), (&pooled, &errors))) {
            Err(StageError::Cancelled) => Err(Cancelled),
            Err(_) => Ok(pooled),
            Ok(widened) => {
                self.builder.update(|snapshot| snapshot.pooled = Slot::Ready(widened.clone()))?;
                Ok(widened)
            }
        }
    }

    /// Channels of each flight against each other, windows it proposes, and its noise. Nothing but the verdict hangs on them.
    fn examine_flights(&self, flights: &[ReadFlight<'_>]) -> Result<(), Cancelled> {
        let physics = |ReadFlight { flight, loaded, .. }: &ReadFlight<'_>| {
            let recordings = &flight.recordings;
            self.compute::<FlightPhysics>(recordings, loaded, |snapshot| flight_slot_mut(&mut snapshot.physics, flight))
                .map(|_| ())
        };
        let (physics, noise) =
            rayon::join(|| flights.par_iter().try_for_each(physics), || self.find_manoeuvres_and_noise(flights));
        physics.and(noise)
    }

    /// What the flights propose as manoeuvres and as steady, and the noise seen there.
    fn find_manoeuvres_and_noise(&self, flights: &[ReadFlight<'_>]) -> Result<(), Cancelled> {
        let propose = |ReadFlight { flight, loaded, .. }: &ReadFlight<'_>| {
            self.compute::<FlightProposals>(&flight.name, loaded, |snapshot| {
                flight_slot_mut(&mut snapshot.proposals, flight)
            })
        };
        let proposals: Vec<_> = flights.par_iter().map(propose).collect::<Result<_, _>>()?;
        let known = flights.iter().zip(&proposals);
        let known: Vec<_> = known
            .filter_map(|(read, proposals)| Some((read.flight.name.as_str(), &read.loaded, proposals.as_ref()?)))
            .collect();
        let Ok(noise) = self.context.get::<SessionNoise>(&self.scope.session.steady, &known) else {
            return Err(Cancelled);
        };
        self.builder.update(|snapshot| {
            for ((name, ..), found) in known.iter().zip(&noise.0) {
                let found = Keyed::new(Arc::clone(found), noise.key());
                snapshot.noise.insert((*name).to_owned(), Slot::Ready(found));
            }
        })
    }
}

/// What was found, if anything; or that the run was stopped.
fn unless_cancelled<T>(found: StageResult<T>) -> Result<Option<T>, Cancelled> {
    match found {
        Err(StageError::Cancelled) => Err(Cancelled),
        found => Ok(found.ok()),
    }
}
