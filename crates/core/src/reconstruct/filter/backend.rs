//! What every form of the filter offers to a run: blocks of steps forwards and backwards.

use crate::reconstruct::filter::parameters::FilterParameters;
use crate::reconstruct::filter::step::{SmoothedOutputs, StepInputs, StepOutputs};
use crate::reconstruct::model::dense::StateMatrix;
use crate::reconstruct::model::layout::STATES;
use crate::reconstruct::numeric::real::Real;
use crate::reconstruct::settings::ValidSettings;

/// The numbers of a backend in memory.
pub type Lanes<B> = <<B as Backend>::Number as Real>::Lanes;

/// State and covariance of as many windows as [`Backend::Number`] has lanes.
pub(crate) trait Backend: Clone {
    /// What it computes with.
    type Number: Real;
    /// A smoother on its way back.
    type Smoother;

    /// The estimate before the first step: the initial state of each window, at most as many as there are lanes, and the settings'
    /// deviations.
    fn new(initial: &[[f64; STATES]], settings: &ValidSettings) -> Self;

    /// Forwards over the steps of a block, of which `outputs` has at least as many.
    fn filter(
        &mut self,
        parameters: &FilterParameters<Self::Number>,
        inputs: &[StepInputs<Lanes<Self>>],
        outputs: &mut [StepOutputs<Lanes<Self>>],
    );

    /// The smoother at the end of the windows, where `self` is the filtered estimate.
    fn smoother(&self) -> Self::Smoother;

    /// Backwards over the steps of a block, at whose start the filter was `self`.
    fn smooth(
        &self,
        smoother: &mut Self::Smoother,
        parameters: &FilterParameters<Self::Number>,
        inputs: &[StepInputs<Lanes<Self>>],
        outputs: &mut [SmoothedOutputs<Lanes<Self>>],
    );

    /// Covariance of the window in `lane`.
    fn covariance(&self, lane: usize) -> StateMatrix;
}
