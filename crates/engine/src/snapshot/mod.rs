//! Snapshots: everything there is to draw, immutable once published.

mod details;
mod enough;
mod experiments;
mod named_slots;
mod slots;
mod study_input;
mod verdicts;

use std::collections::BTreeMap;
use std::path::PathBuf;
use std::sync::Arc;
use std::time::Duration;

use doublet_core::airframe::{AircraftError, LoadedState};

use crate::graph::{FileStamp, Keyed, Stage, StageError};
use crate::prior::PriorStudy;
use crate::session::{Finding, Manoeuvre, Place, Session};
use crate::stage::{
    AeroWindow, DelaysAndGusts, EstimatedSensorErrors, FlightEngines, FlightNoise, FlightPhysics, FlightProposals,
    FlownMass, Gravity, LoadedAircraft, LoadedFlight, PooledFits, ProofOfMatch, WindowAero, WindowFits, WindowPath,
};
use crate::study::{
    CheckStudy, DynamicsStudy, EXPERIMENT, FlightResponses, LagStudy, ManoeuvreStudy, MonteCarloStudy, SensitivityStudy,
};
pub use details::{Details, WindowDetails};
pub use enough::{DerivativeRow, Enough, NextRow, WindowInformation};
pub use experiments::{
    CoefficientOutcome, DerivativeOutcome, ExperimentOutcome, ExperimentRow, ExperimentRows, FitOutcome, Interval,
    MeasurementNis, OverlaidResults, Overlays, PRESENT, SettingDifference, TriedFixes,
};
pub use named_slots::NamedSlots;
pub use slots::Slot;
pub(crate) use slots::{AnySlot, SlotGroup};
use slots::{follow, slots};
pub use study_input::{answer, with_study_input};
pub use verdicts::{Cause, Consequence, DerivativeVerdict, Effect, FitVerdict, VerdictCounts, Verdicts, WindowVerdict};

slots! {
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

/// By window.
impl SlotGroup for BTreeMap<String, WindowResults> {
    fn follow(&mut self, _: &[&str], windows: &[&str]) {
        follow(self, windows);
    }

    fn each_mut(&mut self, what: &str, visit: &mut dyn FnMut(&str, &mut dyn AnySlot)) {
        self.values_mut().for_each(|results| results.each_mut(what, visit));
    }

    fn each(&self, what: &str, visit: &mut dyn FnMut(Place, &dyn AnySlot)) {
        // The stages of a manoeuvre have its place.
        self.iter().for_each(|(name, results)| {
            results.each(what, &mut |_, slot| visit(Place::manoeuvre(name), slot));
        });
    }
}

impl WindowResults {
    /// Why the window has no path, no coefficients or no fits.
    pub fn error(&self) -> Option<&str> {
        [self.path.error(), self.aero.error(), self.fits.error()].into_iter().flatten().next()
    }

    /// Whether `other` holds the same outputs, each up to date.
    pub(crate) fn is_same(&self, other: Option<&Self>) -> bool {
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
        /// What is impossible in the data of the aircraft.
        pub aircraft_errors: Vec<AircraftError>,
        /// Files and folders the run read, as they were then.
        pub files: Arc<BTreeMap<PathBuf, FileStamp>>,
        /// That the manoeuvres under way need more memory than is available; it is published before they are computed.
        pub memory: Option<Finding>,
        /// Newest last.
        pub log: Vec<LogEntry>,
    }
    slots {
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
        /// Noise of each flight over its steady parts, and what it proposes.
        noise: BTreeMap<String, Slot<FlightNoise>>,
        /// Results by window.
        windows: BTreeMap<String, WindowResults> => "manoeuvre",
        /// Constant errors of the sensors over all windows; not requested where the session asks for none.
        sensor_errors: Slot<EstimatedSensorErrors> => EstimatedSensorErrors::NAME,
        /// Derivatives from all identification windows together, and how well they predict the validation windows.
        pooled: Slot<PooledFits> => PooledFits::NAME,
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
        experiments: ExperimentRows => EXPERIMENT,
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
    pub(crate) fn end(&mut self, reason: &StageError) {
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
    pub fn failures(&self) -> Vec<(Place, String)> {
        let mut failures = Vec::new();
        self.each("", &mut |place, slot| failures.extend(slot.failure().map(|error| (place, error.to_owned()))));
        // The stages of a window fail with the first of them.
        failures.dedup_by(|later, earlier| later.0 == earlier.0);
        failures
    }

    /// Every coefficient that has no estimate, with its place: `(place, error)`. A window's own failure counts only where there is
    /// no pooled estimate; otherwise it is a row of its table.
    pub fn failed_fits(&self) -> Vec<(Place, String)> {
        let pooled = self.pooled.ready().filter(|pooled| !pooled.fits.is_empty());
        let fits: Vec<_> = match &pooled {
            Some(pooled) => pooled.fits.iter().map(|fit| (None, fit)).collect(),
            None => self
                .windows
                .iter()
                .flat_map(|(name, results)| {
                    results
                        .fits
                        .ready()
                        .into_iter()
                        .flat_map(move |fits| fits.fits.iter().map(|fit| (Some(name.as_str()), fit)))
                })
                .collect(),
        };
        let failed = fits.into_iter().filter_map(|(window, fit)| {
            let error = fit.fit.as_ref().err()?;
            Some((Place::derivative(fit.coefficient.name(), window), error.to_string()))
        });
        failed.collect()
    }
}
