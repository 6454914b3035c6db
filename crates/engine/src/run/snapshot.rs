//! Snapshots: everything there is to draw, immutable once published.

use std::collections::BTreeMap;
use std::path::PathBuf;
use std::sync::Arc;
use std::time::Duration;

use doublet_core::airframe::LoadedState;

use super::details::Details;
use super::experiments::ExperimentRows;
use super::overlays::Overlays;
use super::tried_fixes::TriedFixes;
use crate::compare::ExperimentOutcome;
use crate::graph::{FileStamp, Keyed, Stage, StageError};
use crate::planning::Enough;
use crate::prior::PriorStudy;
use crate::session::{Manoeuvre, Session};
use crate::stage::{
    AeroWindow, DelaysAndGusts, EstimatedSensorErrors, FlightEngines, FlightNoise, FlightPhysics, FlightProposals,
    FlownMass, Gravity, LoadedAircraft, LoadedFlight, PooledFits, ProofOfMatch, WindowAero, WindowFits, WindowPath,
};
use crate::study::{
    CheckStudy, DynamicsStudy, FlightResponses, LagStudy, ManoeuvreStudy, MonteCarloStudy, SensitivityStudy,
};
use crate::verdict::Verdicts;

/// State of one stage's output. What was there before stays visible until it is replaced.
#[derive(Clone, Debug, Default)]
pub enum Slot<T> {
    /// Nothing asked for it yet.
    #[default]
    NotRequested,
    /// Being computed.
    Running {
        /// Part done, 0 to 1.
        progress: f32,
        /// The output before.
        last: Option<Keyed<T>>,
    },
    /// Up to date.
    Ready(Keyed<T>),
    /// Could not be computed.
    Failed {
        /// One line: what, where, what to do.
        error: String,
        /// The output before.
        last: Option<Keyed<T>>,
    },
    /// Its run was stopped, or what it follows from has changed since and nothing asked for it again.
    Cancelled {
        /// The output before.
        last: Option<Keyed<T>>,
    },
}

impl<T> Slot<T> {
    /// The newest output there is, up to date or not.
    pub fn latest(&self) -> Option<&Arc<T>> {
        self.keyed().map(Keyed::shared)
    }

    /// The same with its key.
    pub fn keyed(&self) -> Option<&Keyed<T>> {
        match self {
            Self::NotRequested => None,
            Self::Ready(value) => Some(value),
            Self::Running { last, .. } | Self::Failed { last, .. } | Self::Cancelled { last } => last.as_ref(),
        }
    }

    /// The output, if it is up to date.
    pub fn ready(&self) -> Option<&Arc<T>> {
        if let Self::Ready(value) = self { Some(value.shared()) } else { None }
    }

    /// The same with its key.
    pub(crate) fn ready_keyed(&self) -> Option<&Keyed<T>> {
        if let Self::Ready(value) = self { Some(value) } else { None }
    }

    /// Why there is no up-to-date output.
    pub fn error(&self) -> Option<&str> {
        if let Self::Failed { error, .. } = self { Some(error) } else { None }
    }

    /// Whether the newest output is out of date.
    pub fn is_stale(&self) -> bool {
        !matches!(self, Self::Ready(_) | Self::NotRequested)
    }

    /// Notes the part done of a running stage.
    pub(crate) fn advance(&mut self, part: f32) {
        if let Self::Running { progress, .. } = self {
            *progress = part;
        }
    }

    /// Takes the result of the stage.
    pub(crate) fn finish(&mut self, result: Result<Keyed<T>, StageError>) {
        match result {
            Ok(value) => *self = Self::Ready(value),
            Err(error) => self.fail(&error),
        }
    }
}

impl<T> From<T> for Slot<T> {
    fn from(value: T) -> Self {
        Self::Ready(value.into())
    }
}

/// What a run does to a slot, whatever it holds.
pub(crate) trait AnySlot {
    /// Marks it as being computed, keeping what it held.
    fn begin(&mut self);
    /// Notes that the run ended without an output, for this reason.
    fn end(&mut self, reason: &StageError);
    /// Marks it as out of date without anything computing it.
    fn expire(&mut self);
    /// Notes that its stage failed, was stopped or does not apply.
    fn fail(&mut self, error: &StageError);
    /// Why there is no up-to-date output.
    fn failure(&self) -> Option<&str>;
}

impl<T> AnySlot for Slot<T> {
    fn begin(&mut self) {
        *self = Self::Running { progress: 0.0, last: self.keyed().cloned() };
    }

    fn end(&mut self, reason: &StageError) {
        if matches!(self, Self::Running { .. }) {
            self.fail(reason);
        }
    }

    fn expire(&mut self) {
        if !matches!(self, Self::NotRequested) {
            *self = Self::Cancelled { last: self.keyed().cloned() };
        }
    }

    fn fail(&mut self, error: &StageError) {
        match error {
            StageError::NotApplicable => *self = Self::NotRequested,
            StageError::Cancelled => self.expire(),
            error => *self = Self::Failed { error: error.to_string(), last: self.keyed().cloned() },
        }
    }

    fn failure(&self) -> Option<&str> {
        self.error()
    }
}

/// Slots that are made, begun, cancelled and failed together.
pub(crate) trait SlotGroup {
    /// Makes room for the flights and windows of a session and forgets all others.
    fn follow(&mut self, _flights: &[&str], _windows: &[&str]) {}
    /// Every slot with what it is.
    fn each_mut(&mut self, what: &str, visit: &mut dyn FnMut(&str, &mut dyn AnySlot));
    /// Every slot with its place, such as `engines of flight 'a'`: what, then the name of the flight or window.
    fn each(&self, what: &str, visit: &mut dyn FnMut(String, &dyn AnySlot));
}

impl<T> SlotGroup for Slot<T> {
    fn each_mut(&mut self, what: &str, visit: &mut dyn FnMut(&str, &mut dyn AnySlot)) {
        visit(what, self);
    }

    fn each(&self, what: &str, visit: &mut dyn FnMut(String, &dyn AnySlot)) {
        visit(what.to_owned(), self);
    }
}

/// By flight.
impl<T> SlotGroup for BTreeMap<String, Slot<T>> {
    fn follow(&mut self, flights: &[&str], _: &[&str]) {
        follow(self, flights);
    }

    fn each_mut(&mut self, what: &str, visit: &mut dyn FnMut(&str, &mut dyn AnySlot)) {
        self.values_mut().for_each(|slot| visit(what, slot));
    }

    fn each(&self, what: &str, visit: &mut dyn FnMut(String, &dyn AnySlot)) {
        self.iter().for_each(|(name, slot)| visit(format!("{what} '{name}'"), slot));
    }
}

/// By window.
impl SlotGroup for BTreeMap<String, WindowResults> {
    fn follow(&mut self, _: &[&str], windows: &[&str]) {
        follow(self, windows);
    }

    fn each_mut(&mut self, what: &str, visit: &mut dyn FnMut(&str, &mut dyn AnySlot)) {
        self.values_mut().for_each(|results| results.each_mut(what, visit));
    }

    fn each(&self, what: &str, visit: &mut dyn FnMut(String, &dyn AnySlot)) {
        self.iter().for_each(|(name, results)| results.each(&format!("{what} '{name}'"), visit));
    }
}

fn follow<T: Default>(slots: &mut BTreeMap<String, T>, names: &[&str]) {
    slots.retain(|name, _| names.contains(&name.as_str()));
    names.iter().for_each(|name| {
        slots.entry((*name).to_owned()).or_default();
    });
}

/// Declares slots once: the fields of a struct, and with them everything a run does to all of its slots. With the name of its stage
/// behind it a failure of a slot is told as one of the run, at that place.
macro_rules! slots {
    (@place) => { "" };
    (@place $place:expr) => { $place };
    (
        $(#[$about:meta])* pub struct $name:ident {
            $($(#[$plain_doc:meta])* pub $plain:ident: $plain_type:ty,)*
        }
        slots { $($(#[$doc:meta])* $slot:ident: $type:ty $(=> $place:expr)?,)* }
    ) => {
        $(#[$about])*
        #[derive(Clone, Debug, Default)]
        pub struct $name {
            $($(#[$plain_doc])* pub $plain: $plain_type,)*
            $($(#[$doc])* pub $slot: $type,)*
        }

        impl SlotGroup for $name {
            fn follow(&mut self, flights: &[&str], windows: &[&str]) {
                $(self.$slot.follow(flights, windows);)*
            }

            fn each_mut(&mut self, _: &str, visit: &mut dyn FnMut(&str, &mut dyn AnySlot)) {
                $(self.$slot.each_mut(slots!(@place $($place)?), visit);)*
            }

            #[allow(unused_variables, reason = "a group may have no slot whose failures are those of the run")]
            fn each(&self, what: &str, visit: &mut dyn FnMut(String, &dyn AnySlot)) {
                $($(self.$slot.each(&format!("{what}{}", $place), visit);)?)*
            }
        }
    };
}

slots! {
    /// Results of one manoeuvre window.
    pub struct WindowResults {}
    slots {
        /// Reconstructed flight path.
        path: Slot<WindowPath> => "",
        /// Coefficients and the variables they depend on.
        aero: Slot<WindowAero> => "",
        /// Derivatives from this window alone.
        fits: Slot<WindowFits> => "",
    }
}

impl WindowResults {
    /// Why the window has no path, no coefficients or no fits.
    pub fn error(&self) -> Option<&str> {
        [self.path.error(), self.aero.error(), self.fits.error()].into_iter().flatten().next()
    }

    /// Whether `other` holds the same outputs, each up to date.
    pub(super) fn is_same(&self, other: Option<&Self>) -> bool {
        let keys = |of: &Self| {
            let Self { path, aero, fits } = of;
            [path.ready_keyed().map(Keyed::key), aero.ready_keyed().map(Keyed::key), fits.ready_keyed().map(Keyed::key)]
        };
        let own = keys(self);
        own.iter().all(Option::is_some) && other.is_some_and(|other| keys(other) == own)
    }
}

/// A line of the log: what was computed, why, how long it took.
#[derive(Clone, Debug, PartialEq)]
pub struct LogEntry {
    /// Generation of the run.
    pub generation: u64,
    /// What asked for the run.
    pub cause: String,
    /// What was computed, or what went wrong.
    pub text: String,
    /// How long it took.
    pub duration: Duration,
    /// Whether it says what could not be computed.
    pub failed: bool,
}

slots! {
    /// Everything a front end can show.
    pub struct Snapshot {
        /// Rises with every request.
        pub generation: u64,
        /// What asked for the newest run.
        pub cause: String,
        /// Whether a run is under way.
        pub busy: bool,
        /// Part of the run that is done, 0 to 1.
        pub progress: f32,
        /// Gravity in use; `None` before the flights were read.
        pub gravity: Option<Gravity>,
        /// Delays of the measurements and gusts over the windows; `None` where the session states them or they cannot be estimated.
        pub delays_and_gusts: DelaysAndGusts,
        /// Files and folders the run read, as they were then.
        pub files: Arc<BTreeMap<PathBuf, FileStamp>>,
        /// Newest last.
        pub log: Vec<LogEntry>,
    }
    slots {
        /// The aircraft.
        aircraft: Slot<LoadedAircraft> => LoadedAircraft::NAME,
        /// Mass properties of the aircraft with the session's loading on board, and where they lie in the envelope.
        loaded: Slot<LoadedState>,
        /// Mass properties as flown, by flight.
        flown: BTreeMap<String, Slot<FlownMass>>,
        /// Recordings by flight.
        flights: BTreeMap<String, Slot<LoadedFlight>> => LoadedFlight::NAME,
        /// Engines over each flight; not requested where the recording or the aircraft lacks what their model needs.
        engines: BTreeMap<String, Slot<FlightEngines>> => FlightEngines::NAME,
        /// Channels of each flight against each other.
        physics: BTreeMap<String, Slot<FlightPhysics>>,
        /// Windows each flight proposes.
        proposals: BTreeMap<String, Slot<FlightProposals>>,
        /// Noise of each flight over its steady windows, and what it proposes.
        noise: BTreeMap<String, Slot<FlightNoise>>,
        /// Results by window.
        windows: BTreeMap<String, WindowResults> => "manoeuvre",
        /// Constant errors of the sensors over all windows; not requested where the session asks for none.
        sensor_errors: Slot<EstimatedSensorErrors> => EstimatedSensorErrors::NAME,
        /// Derivatives from all identification windows together, and how well they predict the validation windows.
        pooled: Slot<PooledFits> => PooledFits::NAME,
        /// The same by the session's second structure; not requested without one.
        second: Slot<PooledFits>,
        /// Validation windows flown again by the pooled model.
        proof: Slot<ProofOfMatch> => ProofOfMatch::NAME,
        /// What was asked for beside the derivatives.
        studies: Studies => "",
        /// What is asked of the identified model while it is looked at; only the background worker computes it.
        inquiries: Inquiries,
        /// A closer look at these results; only the background worker computes it, after the run and for what is looked at.
        details: Slot<Details>,
        /// What of all this may be believed; computed last.
        verdicts: Slot<Verdicts> => "verdict",
    }
}

slots! {
    /// Results of studies; each is computed when a request asks for it and goes out of date when what it follows from changes.
    pub struct Studies {}
    slots {
        /// Manoeuvre against manoeuvre.
        manoeuvres: Slot<ManoeuvreStudy> => ManoeuvreStudy::NAME,
        /// Derivatives against what they were computed with.
        sensitivity: Slot<SensitivityStudy> => SensitivityStudy::NAME,
        /// Every window again in the frequency domain and by output error.
        checks: Slot<CheckStudy> => CheckStudy::NAME,
        /// Lag and delay of every control.
        lags: Slot<LagStudy> => LagStudy::NAME,
        /// Frequency responses of the rates to the controls.
        responses: Slot<FlightResponses> => FlightResponses::NAME,
        /// Derivatives under fresh noise of the recording.
        monte_carlo: Slot<MonteCarloStudy> => MonteCarloStudy::NAME,
        /// Linear model, modes and flying qualities about a trim.
        dynamics: Slot<DynamicsStudy> => DynamicsStudy::NAME,
        /// Experiments of the session side by side.
        experiments: ExperimentRows => ExperimentOutcome::NAME,
    }
}

slots! {
    /// Answers to what is asked of the identified model; each goes out of date with a run and is computed again while it is looked at.
    pub struct Inquiries {}
    slots {
        /// Linear model, modes and flying qualities about a trim.
        dynamics: Slot<DynamicsStudy>,
        /// Whether what was flown is enough.
        enough: Slot<Enough>,
        /// The flight against an earlier estimate.
        prior: Slot<PriorStudy>,
        /// Experiments of the session side by side.
        experiments: ExperimentRows,
        /// Experiments drawn over the session.
        overlaid: Overlays,
        /// Fixes of the findings on screen, each with the verdict there would be.
        fixes: TriedFixes,
    }
}

impl Snapshot {
    /// Ends what still runs for this reason.
    pub(super) fn end(&mut self, reason: &StageError) {
        (self.busy, self.progress) = (false, 1.0);
        self.each_mut("", &mut |_, slot| slot.end(reason));
    }

    /// Modes and levels: as the run was asked for them, or as they are looked at.
    pub fn dynamics(&self) -> &Slot<DynamicsStudy> {
        let (studied, looked_at) = (&self.studies.dynamics, &self.inquiries.dynamics);
        if studied.ready().is_none() && looked_at.ready().is_some() { looked_at } else { studied }
    }

    /// The session with the filter that its paths are reconstructed with: gravity in use, estimated delays and gusts.
    pub fn settle(&self, session: &Session) -> Session {
        let mut filter = self.delays_and_gusts.added_to(&session.filter);
        filter.gravity_m_s2 = self.gravity_m_s2(session);
        Session { filter, ..session.clone() }
    }

    /// Gravity the paths are reconstructed with, m/s²: that in use, or the session's before the flights were read.
    pub fn gravity_m_s2(&self, session: &Session) -> f64 {
        self.gravity.as_ref().map_or(session.filter.gravity_m_s2, |used| used.m_s2)
    }

    /// Mass properties as flown at the start of the first flight of `session` that has them, and what they rest on; before they are
    /// known, those of the loading alone.
    pub fn on_board(&self, session: &Session) -> Option<(&LoadedState, &str)> {
        let flown = session.flights.iter().find_map(|flight| self.flown.get(&flight.name)?.latest());
        match flown {
            Some(flown) => Some((&flown.start.state, flown.fuel.description())),
            None => Some((self.loaded.latest()?.as_ref(), "fuel of the loading: no flight is read")),
        }
    }

    /// The windows of `session` whose coefficients are up to date, in its order.
    pub fn aero<'a>(&self, session: &'a Session) -> Vec<AeroWindow<'a>> {
        let formed = |window: &'a Manoeuvre| Some((window, Arc::clone(self.windows.get(&window.name)?.aero.ready()?)));
        session.windows.iter().filter_map(formed).collect()
    }

    /// Every stage that failed, with its place: `(place, error)`.
    pub fn failures(&self) -> Vec<(String, String)> {
        let mut failures = Vec::new();
        self.each("", &mut |place, slot| failures.extend(slot.failure().map(|error| (place, error.to_owned()))));
        // The stages of a window fail with the first of them.
        failures.dedup_by(|later, earlier| later.0 == earlier.0);
        failures
    }

    /// Every coefficient that has no estimate, with its place: `(place, error)`. A window's own failure counts only where there is
    /// no pooled estimate; otherwise it is a row of its table.
    pub fn failed_fits(&self) -> Vec<(String, String)> {
        let pooled = self.pooled.ready().filter(|pooled| !pooled.fits.is_empty());
        let fits: Vec<_> = match &pooled {
            Some(pooled) => pooled.fits.iter().map(|fit| ("pooled", fit)).collect(),
            None => self
                .windows
                .iter()
                .flat_map(|(name, results)| {
                    results
                        .fits
                        .ready()
                        .into_iter()
                        .flat_map(move |fits| fits.fits.iter().map(|fit| (name.as_str(), fit)))
                })
                .collect(),
        };
        let failed = fits.into_iter().filter_map(|(place, fit)| {
            let error = fit.fit.as_ref().err()?;
            Some((format!("{} ({place})", fit.coefficient.name()), error.to_string()))
        });
        failed.collect()
    }
}
