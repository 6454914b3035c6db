//! Snapshots: everything there is to draw, immutable once published.

use std::collections::BTreeMap;
use std::sync::Arc;
use std::time::Duration;

use doublet_core::airframe::LoadedState;

use super::details::Details;
use crate::session::{Manoeuvre, Session};
use crate::stage::{
    AeroWindow, FlightEngines, FlightNoise, FlightPhysics, FlightProposals, FlownMass, Gravity, LoadedAircraft,
    LoadedFlight, PooledFits, ProofOfMatch, WindowAero, WindowFits, WindowPath,
};
use crate::study::{CheckStudy, LagStudy, ManoeuvreStudy, MonteCarloStudy, SensitivityStudy, Study};
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
        last: Option<Arc<T>>,
    },
    /// Up to date.
    Ready(Arc<T>),
    /// Could not be computed.
    Failed {
        /// One line: what, where, what to do.
        error: String,
        /// The output before.
        last: Option<Arc<T>>,
    },
    /// Its run was stopped, or what it follows from has changed since and nothing asked for it again.
    Cancelled {
        /// The output before.
        last: Option<Arc<T>>,
    },
}

impl<T> Slot<T> {
    /// The newest output there is, up to date or not.
    pub fn latest(&self) -> Option<&Arc<T>> {
        match self {
            Self::NotRequested => None,
            Self::Ready(value) => Some(value),
            Self::Running { last, .. } | Self::Failed { last, .. } | Self::Cancelled { last } => last.as_ref(),
        }
    }

    /// The output, if it is up to date.
    pub fn ready(&self) -> Option<&Arc<T>> {
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

    /// Marks the slot as being computed, keeping what it held.
    pub(crate) fn begin(&mut self) {
        *self = Self::Running { progress: 0.0, last: self.latest().cloned() };
    }

    /// Notes that the run ended without an output.
    pub(crate) fn cancel(&mut self) {
        if matches!(self, Self::Running { .. }) {
            *self = Self::Cancelled { last: self.latest().cloned() };
        }
    }

    /// Notes the part done of a running stage.
    pub(crate) fn advance(&mut self, part: f32) {
        if let Self::Running { progress, .. } = self {
            *progress = part;
        }
    }

    /// Marks an output as out of date without anything computing it.
    pub(crate) fn expire(&mut self) {
        if !matches!(self, Self::NotRequested) {
            *self = Self::Cancelled { last: self.latest().cloned() };
        }
    }

    /// Takes the result of the stage.
    pub(crate) fn finish(&mut self, result: Result<Arc<T>, String>) {
        *self = match result {
            Ok(value) => Self::Ready(value),
            Err(error) => Self::Failed { error, last: self.latest().cloned() },
        };
    }
}

/// Results of one manoeuvre window.
#[derive(Clone, Debug, Default)]
pub struct WindowResults {
    /// Reconstructed flight path.
    pub path: Slot<WindowPath>,
    /// Coefficients and the variables they depend on.
    pub aero: Slot<WindowAero>,
    /// Derivatives from this window alone.
    pub fits: Slot<WindowFits>,
}

impl WindowResults {
    /// Why the window has no path, no coefficients or no fits.
    pub fn error(&self) -> Option<&str> {
        [self.path.error(), self.aero.error(), self.fits.error()].into_iter().flatten().next()
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
}

/// Everything a front end can show.
#[derive(Clone, Debug, Default)]
pub struct Snapshot {
    /// Rises with every request.
    pub generation: u64,
    /// What asked for the newest run.
    pub cause: String,
    /// Whether a run is under way.
    pub busy: bool,
    /// Part of the run that is done, 0 to 1.
    pub progress: f32,
    /// The aircraft.
    pub aircraft: Slot<LoadedAircraft>,
    /// Mass properties of the aircraft with the session's loading on board, and where they lie in the envelope.
    pub loaded: Slot<LoadedState>,
    /// Mass properties as flown, by flight.
    pub flown: BTreeMap<String, Slot<FlownMass>>,
    /// Recordings by flight.
    pub flights: BTreeMap<String, Slot<LoadedFlight>>,
    /// Gravity in use; `None` before the flights were read.
    pub gravity: Option<Gravity>,
    /// Engines over each flight; not requested where the recording or the aircraft lacks what their model needs.
    pub engines: BTreeMap<String, Slot<FlightEngines>>,
    /// Channels of each flight against each other.
    pub physics: BTreeMap<String, Slot<FlightPhysics>>,
    /// Windows each flight proposes.
    pub proposals: BTreeMap<String, Slot<FlightProposals>>,
    /// Noise of each flight over its steady windows, and what it proposes.
    pub noise: BTreeMap<String, Slot<FlightNoise>>,
    /// Results by window.
    pub windows: BTreeMap<String, WindowResults>,
    /// Derivatives from all identification windows together, and how well they predict the validation windows.
    pub pooled: Slot<PooledFits>,
    /// What was asked for beside the derivatives.
    pub studies: Studies,
    /// The same by the session's second structure; not requested without one.
    pub second: Slot<PooledFits>,
    /// A closer look at these results; only the background worker computes it, after the run and for what is looked at.
    pub details: Slot<Details>,
    /// Validation windows flown again by the pooled model.
    pub proof: Slot<ProofOfMatch>,
    /// What of all this may be believed; computed last.
    pub verdicts: Slot<Verdicts>,
    /// Newest last.
    pub log: Vec<LogEntry>,
}

/// Results of studies; each is computed when a request asks for it and goes out of date when what it follows from changes.
#[derive(Clone, Debug, Default)]
pub struct Studies {
    /// Manoeuvre against manoeuvre.
    pub manoeuvres: Slot<ManoeuvreStudy>,
    /// Derivatives against what they were computed with.
    pub sensitivity: Slot<SensitivityStudy>,
    /// Every window again in the frequency domain and by output error.
    pub checks: Slot<CheckStudy>,
    /// Lag and delay of every control.
    pub lags: Slot<LagStudy>,
    /// Derivatives under fresh noise of the recording.
    pub monte_carlo: Slot<MonteCarloStudy>,
}

impl Snapshot {
    /// Mass properties as flown at the start of the first flight of `session` that has them, and what they rest on; before they are
    /// known, those of the loading alone.
    pub fn on_board(&self, session: &Session) -> Option<(&LoadedState, &str)> {
        let flown = session.flights.iter().find_map(|flight| self.flown.get(&flight.name)?.latest());
        match flown {
            Some(flown) => Some((&flown.start.state, flown.fuel.words())),
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
        let mut note = |place: String, error: Option<&str>| {
            if let Some(error) = error {
                failures.push((place, error.to_owned()));
            }
        };
        note("aircraft".to_owned(), self.aircraft.error());
        for (name, slot) in &self.flights {
            note(format!("flight '{name}'"), slot.error());
        }
        for (name, slot) in &self.engines {
            note(format!("engines of flight '{name}'"), slot.error());
        }
        for (name, results) in &self.windows {
            note(format!("window '{name}'"), results.error());
        }
        note("pooled estimate".to_owned(), self.pooled.error());
        note(Study::Manoeuvres.name().to_owned(), self.studies.manoeuvres.error());
        note(Study::Sensitivity.name().to_owned(), self.studies.sensitivity.error());
        note("proof of match".to_owned(), self.proof.error());
        note(Study::Checks { axis: None }.name().to_owned(), self.studies.checks.error());
        note(Study::Lags.name().to_owned(), self.studies.lags.error());
        note("Monte Carlo".to_owned(), self.studies.monte_carlo.error());
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
            Some((format!("{} ({place})", fit.coefficient.name()), error.clone()))
        });
        failed.collect()
    }
}
