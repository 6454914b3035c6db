//! Studies: what a session is asked beyond its derivatives, computed on request because it takes longer than a frame.

mod checks;
mod coverage;
pub mod dynamics;
mod equations;
mod equivalent;
mod flight_responses;
mod followed;
mod lags;
mod manoeuvres;
mod mode_coverage;
mod monte_carlo;
mod response;
mod sensitivity;
mod table;

use std::sync::Arc;

pub use checks::{CheckRequest, CheckStudy, CheckedDerivative, WindowChecks};
pub use coverage::{Coverage, DerivativeCoverage, coverage};
pub(crate) use coverage::{Estimate, estimates, flown_aircraft, flown_loading, fly, record_flight, summarise, windows};
pub use dynamics::{DynamicsRequest, DynamicsStudy};
pub use equations::{
    EquationError, EquationRequest, EquationStudy, equation_schema, equation_text, fit_equation_model, fit_equations,
    names_of_equations, shipped_equations,
};
pub use equivalent::{EquivalentStudy, FitMethod, equivalent_study};
pub use flight_responses::{FlightResponses, SurfaceResponse};
pub use followed::{FilteredFlight, FollowedFlight, FollowedOutput, FollowedStart};
pub use lags::{ControlLag, LagKind, LagStudy};
pub use manoeuvres::{
    CoefficientLeftOut, ConditionRegression, KindComparison, ManoeuvreStudy, TermContribution, WindowContributions,
};
pub use mode_coverage::{FigureCoverage, ModeCoverage, mode_coverage};
pub use monte_carlo::MonteCarloStudy;
pub use response::{ResponseError, ResponseRequest, ResponseStudy, ResponseWindow, session_responses, table_responses};
pub use sensitivity::{STEP_FRACTION, SensitivityStudy};
pub use table::{TableError, TableFit, TableRegression, TermChoice, regress_table};

use crate::graph::{Keyed, Stage};
use crate::session::Settings;
use crate::stage::{AeroWindow, AircraftData, PooledFits, StudyWindow};

/// Something to study beside the derivatives.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Study {
    /// Manoeuvre against manoeuvre: each left out in turn, kinds of input compared, contributions of terms, derivatives over the
    /// flight condition.
    Manoeuvres,
    /// Derivatives against what they were computed with (thesis 7.2.1).
    Sensitivity,
    /// Every window again in the frequency domain, by output error and, where asked, by filter error.
    Checks(CheckRequest),
    /// Lag and delay of every control, found by the fit.
    Lags,
    /// Frequency responses of the rates to the controls with their equivalent systems.
    Responses,
    /// Derivatives under fresh noise of the recording.
    MonteCarlo {
        /// Number of realisations.
        realisations: usize,
        /// Seed of their noise: the same seed gives the same numbers, whatever the number of threads.
        seed: u64,
    },
    /// Linear model, modes and flying qualities about a trim.
    Dynamics(DynamicsRequest),
    /// Experiments of the session side by side.
    Experiments,
}

impl Study {
    /// Name in messages.
    pub fn name(self) -> &'static str {
        match self {
            Self::Manoeuvres => ManoeuvreStudy::NAME,
            Self::Sensitivity => SensitivityStudy::NAME,
            Self::Checks(_) => CheckStudy::NAME,
            Self::Lags => LagStudy::NAME,
            Self::Responses => FlightResponses::NAME,
            Self::MonteCarlo { .. } => MonteCarloStudy::NAME,
            Self::Dynamics(_) => DynamicsStudy::NAME,
            Self::Experiments => "experiment",
        }
    }
}

/// What a study looks at: settings of the session and all that was computed from it.
#[derive(Clone, Copy, Debug, Hash)]
pub struct StudyInput<'a> {
    /// Settings of the session.
    pub settings: Settings<'a>,
    /// Aircraft and loading.
    pub aircraft: &'a Keyed<AircraftData>,
    /// Windows not ignored, in the order of the session.
    pub windows: &'a [StudyWindow<'a>],
    /// Derivatives from all identification windows together.
    pub pooled: &'a Keyed<PooledFits>,
}

impl<'a> StudyInput<'a> {
    /// Windows with their coefficients.
    pub fn aero(&self) -> Vec<AeroWindow<'a>> {
        self.windows.iter().map(|window| (window.manoeuvre, Arc::clone(window.aero.shared()))).collect()
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
