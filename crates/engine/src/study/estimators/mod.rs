//! Estimators of the derivatives of one manoeuvre. To add one: its file here and a row in [`ESTIMATORS`]. The command line, results, report,
//! findings and the window follow.

mod filter_error;
mod frequency_domain;
mod output_error;

use std::cell::OnceCell;

use doublet_core::model::Coefficient;
use doublet_core::replay::MotionAxis;
use nalgebra::DMatrix;

use output_error::OutputErrorFlight;
pub use output_error::{FollowedFlight, FollowedOutput, FollowedStart};

use super::StudyInput;
use super::checks::CheckRequest;
use crate::graph::{Context, StageResult};
use crate::session::Surface;
use crate::stage::StudyWindow;

#[derive(Debug)]
pub struct Estimator {
    /// Name in tables, findings and `results.json`.
    pub name: &'static str,
    /// Name on the command line.
    pub key: &'static str,
    /// What it does.
    pub about: &'static str,
    /// Whether it is left out unless it is asked for: it takes longer than the others together.
    pub on_request: bool,
    estimate: fn(&WindowEstimation<'_>) -> Vec<PartEstimates>,
}

/// The estimators, in the order of their results.
pub const ESTIMATORS: [Estimator; 3] = [
    Estimator {
        name: "frequency domain",
        key: "frequency-domain",
        about: "Equation error in the frequency domain.",
        on_request: false,
        estimate: frequency_domain::estimate,
    },
    Estimator {
        name: "output error",
        key: "output-error",
        about: "Output error: simulation from the recorded controls, the other axis as reconstructed.",
        on_request: false,
        estimate: output_error::estimate,
    },
    Estimator {
        name: "filter error",
        key: "filter-error",
        about: "Output error with process noise, for gusts. Takes several times longer.",
        on_request: true,
        estimate: filter_error::estimate,
    },
];

impl Estimator {
    /// Those that run where they are asked for.
    pub fn on_request() -> impl Iterator<Item = &'static Self> {
        ESTIMATORS.iter().filter(|one| one.on_request)
    }

    /// The one with this name on the command line.
    pub fn from_key(key: &str) -> Option<&'static Self> {
        ESTIMATORS.iter().find(|one| one.key == key)
    }
}

/// Estimators that are asked for beside those that always run.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub struct EstimatorSet([bool; ESTIMATORS.len()]);

impl EstimatorSet {
    /// The estimators of both.
    #[must_use]
    pub fn union(mut self, other: Self) -> Self {
        self.0.iter_mut().zip(other.0).for_each(|(own, other)| *own |= other);
        self
    }

    /// Whether `estimator` is asked for.
    pub fn contains(self, estimator: &Estimator) -> bool {
        self.0.into_iter().zip(&ESTIMATORS).any(|(is_wanted, one)| is_wanted && one.key == estimator.key)
    }

    /// With `estimator`, or without it.
    #[must_use]
    pub fn with(mut self, estimator: &Estimator, is_wanted: bool) -> Self {
        for (own, other) in self.0.iter_mut().zip(&ESTIMATORS) {
            *own = if other.key == estimator.key { is_wanted } else { *own };
        }
        self
    }

    /// Those that run.
    pub fn running(self) -> impl Iterator<Item = &'static Estimator> {
        let asked = self.0.into_iter().zip(&ESTIMATORS);
        asked.filter(|(is_wanted, one)| *is_wanted || !one.on_request).map(|(_, one)| one)
    }
}

impl FromIterator<&'static Estimator> for EstimatorSet {
    fn from_iter<I: IntoIterator<Item = &'static Estimator>>(estimators: I) -> Self {
        estimators.into_iter().fold(Self::default(), |all, one| all.with(one, true))
    }
}

/// What one fit of an estimator is of.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ModelPart {
    /// The derivatives of one coefficient.
    Coefficient(Coefficient),
    /// The derivatives of a motion together.
    Motion(MotionAxis),
}

impl ModelPart {
    /// Name in tables.
    pub fn name(self) -> &'static str {
        match self {
            Self::Coefficient(coefficient) => coefficient.name(),
            Self::Motion(axis) => axis.name(),
        }
    }

    /// The motion; empty for a coefficient.
    pub fn axis(self) -> &'static str {
        if let Self::Motion(axis) = self { axis.name() } else { "" }
    }
}

/// A derivative by one estimator.
#[derive(Clone, Debug, PartialEq)]
pub struct CheckedDerivative {
    pub name: String,
    pub estimate: f64,
    /// Standard error: of independent frequencies, or corrected for correlated residuals.
    pub standard_error: f64,
}

/// What an estimator found for one part of the model in one manoeuvre.
#[derive(Clone, Debug)]
pub struct PartEstimates {
    pub part: ModelPart,
    /// Estimates, or one line why there are none.
    pub result: StageResult<MethodEstimates>,
}

/// Estimates of one part of the model.
#[derive(Clone, Debug, Default)]
pub struct MethodEstimates {
    pub derivatives: Vec<CheckedDerivative>,
    /// Their covariance: of independent frequencies, or corrected for correlated residuals.
    pub covariance: DMatrix<f64>,
    /// What else it estimates: initial states, biases, process noise.
    pub others: Vec<CheckedDerivative>,
    /// The simulation, of an estimator that compares one with the recording.
    pub flight: Option<FollowedFlight>,
}

/// A manoeuvre that is estimated, with what its estimators share.
pub(super) struct WindowEstimation<'a> {
    input: &'a StudyInput<'a>,
    window: &'a StudyWindow<'a>,
    context: &'a Context<'a>,
    /// The motions that are followed, each by output error as soon as an estimator needs it.
    motions: Vec<(MotionAxis, OnceCell<StageResult<OutputErrorFlight<'a>>>)>,
}

impl<'a> WindowEstimation<'a> {
    /// The estimation of `window`: of the motion asked for, or of those its surface moves.
    pub(super) fn new(
        input: &'a StudyInput<'a>,
        window: &'a StudyWindow<'a>,
        request: CheckRequest,
        context: &'a Context<'a>,
    ) -> Self {
        let motions = request.axis.as_ref().map_or_else(|| axes(window.manoeuvre.surface), std::slice::from_ref);
        Self { input, window, context, motions: motions.iter().map(|&axis| (axis, OnceCell::new())).collect() }
    }

    /// What `estimator` finds.
    pub(super) fn by(&self, estimator: &Estimator) -> Vec<PartEstimates> {
        (estimator.estimate)(self)
    }

    /// Estimates of every motion by `estimate`, which is given output error over it.
    fn by_motion(
        &self,
        estimate: impl Fn(&OutputErrorFlight<'a>) -> StageResult<MethodEstimates>,
    ) -> Vec<PartEstimates> {
        let of_motion = |(axis, flight): &(MotionAxis, OnceCell<_>)| {
            let flight = flight.get_or_init(|| OutputErrorFlight::fit(self.input, self.window, *axis, self.context));
            let result = flight.as_ref().map_err(Clone::clone).and_then(&estimate);
            PartEstimates { part: ModelPart::Motion(*axis), result }
        };
        self.motions.iter().map(of_motion).collect()
    }
}

/// Motion a manoeuvre of `surface` excites.
fn axes(surface: Option<Surface>) -> &'static [MotionAxis] {
    match surface {
        Some(Surface::Elevator) => &[MotionAxis::Longitudinal],
        Some(Surface::Aileron | Surface::Rudder) => &[MotionAxis::Lateral],
        None => &[MotionAxis::Longitudinal, MotionAxis::Lateral],
    }
}
