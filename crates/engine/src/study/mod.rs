//! Studies: what a session is asked beyond its derivatives, computed on request because it takes longer than a frame.

mod checks;
mod coverage;
mod followed;
mod judged_flights;
mod lags;
mod manoeuvres;
mod monte_carlo;
mod sensitivity;

use std::sync::Arc;
use std::sync::atomic::{AtomicUsize, Ordering};

pub use checks::{CheckStudy, CheckedDerivative, WindowChecks, checks};
pub use coverage::{Coverage, DerivativeCoverage, coverage};
pub use followed::{FollowedFlight, FollowedOutput, FollowedStart};
pub use judged_flights::{JudgedFlights, flown, judged_flights};
pub use lags::{ControlLag, LagKind, LagStudy, lags};
pub use manoeuvres::{
    CoefficientLeftOut, ConditionRegression, KindComparison, ManoeuvreStudy, TermContribution, WindowContributions,
    manoeuvres,
};
pub use monte_carlo::{MonteCarloStudy, monte_carlo};
pub use sensitivity::{STEP_FRACTION, SensitivityStudy, sensitivity};

use doublet_core::replay::MotionAxis;

use crate::run::{Cancelled, Control};
use crate::session::{Manoeuvre, Session};
use crate::stage::{AeroWindow, AircraftData, LoadedFlight, PooledFits, WindowAero, WindowFits, WindowPath};

/// Something to study beside the derivatives.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Study {
    /// Manoeuvre against manoeuvre: each left out in turn, kinds of input compared, contributions of terms, derivatives over the
    /// flight condition.
    Manoeuvres,
    /// Derivatives against what they were computed with (thesis 7.2.1).
    Sensitivity,
    /// Every window again in the frequency domain and by output error.
    Checks {
        /// Motion that output error follows; none: that of each window's surface.
        axis: Option<MotionAxis>,
    },
    /// Lag and delay of every control, found by the fit.
    Lags,
    /// Derivatives under fresh noise of the recording.
    MonteCarlo {
        /// Number of realisations.
        realisations: usize,
        /// Seed of their noise: the same seed gives the same numbers, whatever the number of threads.
        seed: u64,
    },
}

impl Study {
    /// Name in messages.
    pub fn name(self) -> &'static str {
        match self {
            Self::Manoeuvres => "comparison of manoeuvres",
            Self::Sensitivity => "sensitivity",
            Self::Checks { .. } => "independent checks",
            Self::Lags => "lags of the controls",
            Self::MonteCarlo { .. } => "Monte Carlo",
        }
    }
}

/// A window with everything computed from it.
#[derive(Clone, Debug)]
pub struct StudyWindow<'a> {
    /// Window.
    pub manoeuvre: &'a Manoeuvre,
    /// Flight it lies in.
    pub flight: Arc<LoadedFlight>,
    /// Path.
    pub path: Arc<WindowPath>,
    /// Coefficients and variables.
    pub aero: Arc<WindowAero>,
    /// Derivatives from it alone.
    pub fits: Arc<WindowFits>,
}

/// What a study looks at: the session and all that was computed from it.
#[derive(Clone, Copy, Debug)]
pub struct Subject<'a> {
    /// Session.
    pub session: &'a Session,
    /// Aircraft and loading.
    pub aircraft: &'a AircraftData,
    /// Windows not ignored, in the order of the session.
    pub windows: &'a [StudyWindow<'a>],
    /// Derivatives from all identification windows together.
    pub pooled: &'a PooledFits,
}

impl<'a> Subject<'a> {
    /// Windows with their coefficients.
    pub fn aero(&self) -> Vec<AeroWindow<'a>> {
        self.windows.iter().map(|window| (window.manoeuvre, Arc::clone(&window.aero))).collect()
    }

    /// Pooled derivatives all windows share: name, estimate and corrected standard error.
    pub fn derivatives(&self) -> Vec<(String, f64, f64)> {
        let mut found = Vec::new();
        for fit in &self.pooled.fits {
            let Ok(estimate) = &fit.fit else { continue };
            let rows = estimate.names.iter().zip(&estimate.estimates).zip(&fit.corrected_errors);
            let shared = rows.filter(|((name, _), _)| !name.ends_with(']'));
            found.extend(shared.map(|((name, value), error)| (name.clone(), *value, *error)));
        }
        found
    }
}

/// Why a study has no result.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum StudyError {
    /// It was stopped.
    Cancelled,
    /// One line: what, where, what to do.
    Failed(String),
}

impl From<Cancelled> for StudyError {
    fn from(_: Cancelled) -> Self {
        Self::Cancelled
    }
}

impl From<String> for StudyError {
    fn from(error: String) -> Self {
        Self::Failed(error)
    }
}

/// Cancellation and progress of one study.
pub struct Watch<'a> {
    control: &'a Control,
    progress: &'a (dyn Fn(f32) + Sync),
    done: AtomicUsize,
    total: usize,
}

impl<'a> Watch<'a> {
    /// A study of `total` parts; `progress` is told the part done, 0 to 1, after each.
    pub fn new(control: &'a Control, progress: &'a (dyn Fn(f32) + Sync)) -> Self {
        Self { control, progress, done: AtomicUsize::new(0), total: 1 }
    }

    /// The same for a study of `total` parts.
    #[must_use]
    pub fn parts(&self, total: usize) -> Watch<'a> {
        Watch { control: self.control, progress: self.progress, done: AtomicUsize::new(0), total }
    }

    /// Goes on, or ends the study.
    ///
    /// # Errors
    /// [`StudyError::Cancelled`] once it was asked to stop.
    pub fn checkpoint(&self) -> Result<(), StudyError> {
        Ok(self.control.checkpoint()?)
    }

    /// Handle on the run.
    pub fn control(&self) -> &'a Control {
        self.control
    }

    /// Counts one part as done.
    pub fn step(&self) {
        let done = self.done.fetch_add(1, Ordering::Relaxed) + 1;
        (self.progress)(done as f32 / self.total.max(1) as f32);
    }
}
