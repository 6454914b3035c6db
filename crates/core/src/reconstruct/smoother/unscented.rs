//! Unscented Rauch-Tung-Striebel smoother (Sarkka 2008).

use crate::reconstruct::filter::parameters::FilterParameters;
use crate::reconstruct::filter::step::{StepInputs, Update};
use crate::reconstruct::filter::ukf::{Root, SigmaPrediction, Ukf};
use crate::reconstruct::model::augmented::{AugmentedMatrix, AugmentedState};
use crate::reconstruct::model::layout::{ACC, AUGMENTED_STATES};
use crate::reconstruct::settings::{Method, ValidSettings};
use crate::reconstruct::smoother::dense::{DenseFilter, ForwardStep};

impl DenseFilter for Ukf {
    type Prediction = SigmaPrediction;
    type Smoother = ();

    fn new(x: AugmentedState, p: AugmentedMatrix, settings: &ValidSettings) -> Self {
        let spread = if let Method::Ukf { spread } = settings.method { spread } else { Method::USUAL_SPREAD };
        Self { x, p, spread }
    }

    fn estimate(&self) -> (&AugmentedState, &AugmentedMatrix) {
        (&self.x, &self.p)
    }

    fn predict(&mut self, step: &StepInputs<f64>, parameters: &FilterParameters<f64>) -> SigmaPrediction {
        self.predict(step, parameters)
    }

    fn update(&mut self, step: &StepInputs<f64>, parameters: &FilterParameters<f64>) -> Update<f64> {
        self.update(step, parameters)
    }

    fn smoother(&self) {}

    /// Gain `G = D (P-)^-1` with the covariance `D` of the states before and after the step. States that do not change over a step
    /// have a row of the identity in `G`.
    fn smooth_step(
        (): &mut (),
        (x, p): &mut (AugmentedState, AugmentedMatrix),
        forward: &ForwardStep<Self>,
        _step: &StepInputs<f64>,
        _parameters: &FilterParameters<f64>,
    ) {
        let SigmaPrediction { before, after, shift, walks } = &forward.prediction;
        let across = after * before.transpose();
        let mut gain = Root::new(&forward.predicted.p).solve(across).transpose();
        for k in (3 * ACC..AUGMENTED_STATES).filter(|&k| walks[(k, k)] == 0.0) {
            gain.fill_row(k, 0.0);
            gain[(k, k)] = 1.0;
        }
        let left = before - gain * after;
        let shift = gain * shift;
        let end = *p + walks;
        *x = forward.before.x + gain * (*x - forward.predicted.x);
        let covariance = left * left.transpose() + shift * shift.transpose() + gain * end * gain.transpose();
        *p = (covariance + covariance.transpose()) * 0.5;
    }
}
