//! Independent checks of every window: the same derivatives by other methods.

use doublet_core::replay::MotionAxis;
use rayon::prelude::*;

use super::StudyInput;
use super::estimators::{
    Estimator, EstimatorSet, FollowedFlight, MethodEstimates, ModelPart, PartEstimates, WindowEstimation,
};
use crate::graph::{Context, Footprint, Stage, StageError, StageResult};
use crate::session::{Finding, Level, Place};
use crate::stage::StudyWindow;

/// What is checked.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub struct CheckRequest {
    /// Motion that is followed; none: that of each window's surface.
    pub axis: Option<MotionAxis>,
    /// Estimators that run beside those that always do.
    pub estimators: EstimatorSet,
}

impl CheckRequest {
    /// The estimators of both, of the motion of the first.
    #[must_use]
    pub fn and(self, other: Self) -> Self {
        Self { estimators: self.estimators.union(other.estimators), ..self }
    }
}

/// MethodEstimates of one window by one estimator.
#[derive(Clone, Debug)]
pub struct MethodChecks {
    pub method: &'static Estimator,
    /// What it found, part by part of the model.
    pub parts: Vec<PartEstimates>,
}

#[derive(Clone, Debug)]
pub struct WindowChecks {
    pub window: String,
    /// One entry per estimator, in their order.
    pub methods: Vec<MethodChecks>,
}

/// Checks of all windows.
#[derive(Clone, Debug, Default)]
pub struct CheckStudy {
    /// What was asked for.
    pub request: CheckRequest,
    /// One entry per window not ignored.
    pub windows: Vec<WindowChecks>,
}

impl CheckStudy {
    /// MethodEstimates whose flight does not follow its recording, window by window.
    pub fn findings(&self) -> Vec<Finding> {
        self.windows.iter().flat_map(WindowChecks::findings).collect()
    }
}

impl WindowChecks {
    /// What every estimator found for every part of the model, or why there is nothing.
    pub fn results(
        &self,
    ) -> impl Iterator<Item = (&'static Estimator, ModelPart, Result<&MethodEstimates, &StageError>)> {
        let parts = self.methods.iter().flat_map(|found| found.parts.iter().map(|part| (found.method, part)));
        parts.map(|(method, found)| (method, found.part, found.result.as_ref()))
    }

    /// Every derivative with the estimator it is by.
    pub fn estimates(&self) -> impl Iterator<Item = (&'static Estimator, ModelPart, &MethodEstimates)> {
        self.results().filter_map(|(method, part, found)| Some((method, part, found.ok()?)))
    }

    /// The flights that are compared with the recording.
    pub fn flights(&self) -> impl Iterator<Item = &FollowedFlight> {
        self.estimates().filter_map(|(_, _, found)| found.flight.as_ref())
    }

    /// Flights that do not follow the recording of this window (`follows`), and motions that no estimator could fly.
    pub fn findings(&self) -> Vec<Finding> {
        let mut found = Vec::new();
        for (method, part, result) in self.results() {
            match result {
                Ok(estimates) => {
                    found.extend(estimates.flight.iter().flat_map(|flight| flight.findings(&self.window)));
                }
                // An estimator that starts from output error fails with it.
                Err(error) if !part.axis().is_empty() && !method.on_request => {
                    let place = Place::in_manoeuvre(&self.window, format!("{} ({})", method.name, part.axis()));
                    let text = format!("Output error failed: {error}.");
                    let finding = Finding::new(Level::Caution, "follows", place, text);
                    let fix_text = "Remove a term or shorten the manoeuvre.";
                    found.push(finding.with_fix_text(fix_text).with_setting("Studies", ""));
                }
                Err(_) => {}
            }
        }
        found
    }
}

impl Footprint for CheckStudy {
    fn bytes(&self) -> usize {
        let flights = self.windows.iter().flat_map(WindowChecks::flights);
        let samples = |flight: &FollowedFlight| flight.outputs.iter().map(|o| o.flown.values.len() * 24).sum::<usize>();
        flights.map(samples).sum::<usize>() + 4096 * self.windows.len()
    }
}

/// MethodEstimates every window again by every estimator that runs.
impl Stage for CheckStudy {
    type Params<'a> = CheckRequest;
    type Inputs<'a> = &'a StudyInput<'a>;
    type Output = Self;
    const NAME: &'static str = "independent checks";

    fn run(request: CheckRequest, input: &StudyInput<'_>, context: &Context<'_>) -> StageResult<Self> {
        let context = context.parts(input.windows.len());
        let windows = input.windows.par_iter().map(|window| check_window(window, input, request, &context));
        Ok(CheckStudy { request, windows: windows.collect::<StageResult<_>>()? })
    }
}

fn check_window<'a>(
    window: &'a StudyWindow<'a>,
    input: &'a StudyInput<'a>,
    request: CheckRequest,
    context: &'a Context<'a>,
) -> StageResult<WindowChecks> {
    context.checkpoint()?;
    let estimation = WindowEstimation::new(input, window, request, context);
    let by = |method: &'static Estimator| MethodChecks { method, parts: estimation.by(method) };
    let methods = request.estimators.running().map(by).collect();
    context.checkpoint()?;
    context.step();
    Ok(WindowChecks { window: window.manoeuvre.name.clone(), methods })
}
