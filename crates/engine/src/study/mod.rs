//! Studies: what a session is asked beyond its derivatives, computed on request because it takes longer than a frame.

mod checks;
mod coverage;
pub mod dynamics;
mod equations;
mod equivalent;
mod equivalent_levels;
mod estimators;
mod flight_responses;
mod identified;
mod lags;
mod least_squares;
mod manoeuvres;
mod mode_comparison;
mod mode_coverage;
mod monte_carlo;
mod response;
mod sensitivity;
mod systems;
mod table;

use std::sync::Arc;

pub use checks::{CheckRequest, CheckStudy, MethodChecks, WindowChecks};
pub use coverage::{Coverage, DerivativeCoverage, coverage};
pub(crate) use coverage::{Estimate, estimates, flown_aircraft, flown_loading, fly, record_flight, summarise, windows};
pub use dynamics::{DynamicsRequest, DynamicsStudy};
pub use equations::{
    EquationError, EquationRequest, EquationStudy, equation_schema, equation_text, fit_equation_model, fit_equations,
    names_of_equations, shipped_equations,
};
pub use equivalent::{EquivalentStudy, FitMethod, equivalent_study};
pub use equivalent_levels::EquivalentLevels;
pub use estimators::{
    CheckedDerivative, ESTIMATORS, Estimator, EstimatorSet, FollowedFlight, FollowedOutput, FollowedStart,
    MethodEstimates, ModelPart, PartEstimates,
};
pub use flight_responses::{FlightResponses, SurfaceResponse};
pub(crate) use identified::identified;
pub use identified::{IdentifiedCoefficient, Parameter};
pub use lags::{ControlLag, LagKind, LagStudy};
pub use least_squares::{CoefficientForms, FormEstimates, FormRequest, least_squares_forms};
pub use manoeuvres::{
    CoefficientLeftOut, ConditionRegression, KindComparison, ManoeuvreStudy, TermContribution, WindowContributions,
};
pub use mode_comparison::{Bounded, ModeComparison, ModeQuantity};
pub use mode_coverage::{FigureCoverage, ModeCoverage, mode_coverage};
pub use monte_carlo::{MonteCarloRequest, MonteCarloStudy};
pub use response::{ResponseError, ResponseRequest, ResponseStudy, ResponseWindow, session_responses, table_responses};
pub use sensitivity::{STEP_FRACTION, SensitivityStudy};
pub use table::{TableError, TableFit, TableRegression, TermChoice, regress_table};

use crate::graph::{Keyed, Stage};
use crate::session::Settings;
use crate::stage::{AeroWindow, AircraftData, PooledFits, StudyWindow};

/// A study under the name by which it is asked for.
#[derive(Debug)]
pub struct StudyInfo {
    /// Name on the command line and in Python.
    pub key: &'static str,
    /// Name in the window.
    pub title: &'static str,
    /// What it computes.
    pub about: &'static str,
    /// The study as it is computed where nothing else is stated.
    pub make: fn() -> Study,
}

macro_rules! studies {
    ($($(#[$doc:meta])* $study:ident $(($request:ty = $usual:expr))?: $stage:expr, $key:literal, $title:literal, $about:literal;)*) => {
        /// Something to study beside the derivatives.
        #[derive(Clone, Copy, Debug, PartialEq, Eq)]
        pub enum Study {
            $($(#[$doc])* $study $(($request))?,)*
        }

        impl Study {
            /// Name in messages.
            pub fn name(self) -> &'static str {
                match self { $(Self::$study { .. } => $stage,)* }
            }
        }

        /// The studies, in the order in which they are listed.
        pub const STUDIES: &[StudyInfo] =
            &[$(StudyInfo { key: $key, title: $title, about: $about, make: || Study::$study $(($usual as $request))? },)*];
    };
}

// To add one: its stage in this folder and its row here; its slot in `snapshot/mod.rs` and its line in `run/studies.rs`; its rows and their table in
// `report/studies.rs`. The command line, Python and the window list what stands here.
studies! {
    /// Derivatives against what they were computed with (thesis 7.2.1).
    Sensitivity: SensitivityStudy::NAME, "sensitivity", "Sensitivity", "Sensitivity of the derivatives to their inputs.";
    /// Manoeuvre against manoeuvre: each left out in turn, kinds of input compared, contributions of terms, derivatives over the
    /// flight condition.
    Manoeuvres: ManoeuvreStudy::NAME, "manoeuvres", "Between manoeuvres",
        "Leave one out, doublets against 3-2-1-1, derivatives over flight condition.";
    /// Every window again by other estimators.
    Checks(CheckRequest = CheckRequest::default()): CheckStudy::NAME, "checks", "Independent checks",
        "Every manoeuvre in the frequency domain and by output error.";
    /// Lag and delay of every control, found by the fit.
    Lags: LagStudy::NAME, "lags", "Lags of the controls", "Fitted delay and first-order lag of every control.";
    /// Frequency responses of the rates to the controls with their equivalent systems.
    Responses: FlightResponses::NAME, "responses", "Frequency responses", "Frequency responses of the rates to the controls.";
    /// Derivatives under fresh noise of the recording.
    MonteCarlo(MonteCarloRequest = MonteCarloRequest::default()): MonteCarloStudy::NAME, "monte-carlo", "Monte Carlo",
        "Scatter of the derivatives under fresh measurement noise.";
    /// Linear model, modes and flying qualities about a trim.
    Dynamics(DynamicsRequest = DynamicsRequest::default()): DynamicsStudy::NAME, "dynamics", "Modes and levels",
        "Linear model, modes and flying qualities at the median condition.";
    /// Experiments of the session side by side.
    Experiments: EXPERIMENT, "experiments", "Experiments", "Experiments of the session side by side.";
}

/// Name of the stage that runs an experiment.
pub(crate) const EXPERIMENT: &str = "experiment";

impl Study {
    /// The study called `key`: a row of [`STUDIES`], or checks with the estimator of this name.
    pub fn from_key(key: &str) -> Option<Self> {
        let row = STUDIES.iter().find(|row| row.key == key).map(|row| (row.make)());
        let with =
            |estimator| Self::Checks(CheckRequest { axis: None, estimators: EstimatorSet::from_iter([estimator]) });
        row.or_else(|| Estimator::from_key(key).filter(|estimator| estimator.on_request).map(with))
    }

    /// Every name that [`Study::from_key`] knows, with what it computes.
    pub fn keys() -> impl Iterator<Item = (&'static str, &'static str)> {
        let estimators = Estimator::on_request().map(|estimator| (estimator.key, estimator.about));
        STUDIES.iter().map(|row| (row.key, row.about)).chain(estimators)
    }
}

/// What a study looks at: settings of the session and all that was computed from it.
#[derive(Clone, Copy, Debug, Hash)]
pub struct StudyInput<'a> {
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
