//! Filters over whole matrices, driven block by block: forwards, and backwards from what the forward steps leave.

use crate::reconstruct::filter::backend::Backend;
use crate::reconstruct::filter::parameters::FilterParameters;
use crate::reconstruct::filter::step::{BLOCK, SmoothedOutputs, StepInputs, StepOutputs, Update};
use crate::reconstruct::model::augmented::{AugmentedMatrix, AugmentedState, groups};
use crate::reconstruct::model::dense::StateMatrix;
use crate::reconstruct::model::layout::{AIR_STATES, STATES};
use crate::reconstruct::settings::ValidSettings;

/// A filter over the augmented state, and its smoother.
pub(crate) trait DenseFilter: Clone {
    /// What the smoother needs of a prediction besides the estimates before and after it.
    type Prediction;
    /// What the smoother holds besides its estimate.
    type Smoother;

    /// From the estimate before the first step.
    fn new(x: AugmentedState, p: AugmentedMatrix, settings: &ValidSettings) -> Self;

    /// State and covariance.
    fn estimate(&self) -> (&AugmentedState, &AugmentedMatrix);

    /// Prediction over a step.
    fn predict(&mut self, step: &StepInputs<f64>, parameters: &FilterParameters<f64>) -> Self::Prediction;

    /// Update with the measurements at its end.
    fn update(&mut self, step: &StepInputs<f64>, parameters: &FilterParameters<f64>) -> Update<f64>;

    /// The smoother at the end of the window.
    fn smoother(&self) -> Self::Smoother;

    /// One step backwards: `smoothed` enters at the end of the step and leaves at its start.
    fn smooth_step(
        smoother: &mut Self::Smoother,
        smoothed: &mut (AugmentedState, AugmentedMatrix),
        forward: &ForwardStep<Self>,
        step: &StepInputs<f64>,
        parameters: &FilterParameters<f64>,
    );
}

/// What the backward pass needs of one step.
pub struct ForwardStep<F: DenseFilter> {
    /// Estimate before the step.
    pub before: F,
    /// The prediction over it.
    pub prediction: F::Prediction,
    /// Estimate at its end before the update.
    pub predicted: F,
}

/// A smoother on its way back through the blocks.
pub struct DenseSmoother<F: DenseFilter> {
    /// Smoothed state and covariance.
    pub smoothed: (AugmentedState, AugmentedMatrix),
    /// What the filter's own smoother holds.
    pub own: F::Smoother,
    /// Steps of the block, filtered again.
    forward: Vec<ForwardStep<F>>,
}

impl<F: DenseFilter> Backend for F {
    type Number = f64;
    type Smoother = DenseSmoother<F>;

    fn new(initial: &[[f64; STATES]], settings: &ValidSettings) -> Self {
        let mut x = AugmentedState::zeros();
        let mut variances = AugmentedState::zeros();
        for k in 0..STATES {
            x[k] = initial.first().map_or(0.0, |initial| initial[k]);
            variances[k] = settings.initial_deviation[k].powi(2);
        }
        for k in 0..AIR_STATES {
            variances[STATES + k] = settings.air_data_deviation[k].powi(2);
        }
        F::new(x, AugmentedMatrix::from_diagonal(&variances), settings)
    }

    fn filter(
        &mut self,
        parameters: &FilterParameters<f64>,
        inputs: &[StepInputs<[f64; 1]>],
        outputs: &mut [StepOutputs<[f64; 1]>],
    ) {
        for (inputs, outputs) in inputs.iter().zip(outputs) {
            let step = StepInputs::load(inputs);
            self.predict(&step, parameters);
            let update = self.update(&step, parameters);
            let (x, p) = self.estimate();
            outputs.write(&groups(x), &groups(&p.diagonal()), &step, &update);
            for k in 0..AIR_STATES {
                outputs.air_data[k] = [x[STATES + k]];
                outputs.air_data_deviation[k] = [p[(STATES + k, STATES + k)].sqrt()];
            }
        }
    }

    fn smoother(&self) -> DenseSmoother<F> {
        let (x, p) = self.estimate();
        DenseSmoother { smoothed: (*x, *p), own: DenseFilter::smoother(self), forward: Vec::with_capacity(BLOCK) }
    }

    fn smooth(
        &self,
        smoother: &mut DenseSmoother<F>,
        parameters: &FilterParameters<f64>,
        inputs: &[StepInputs<[f64; 1]>],
        outputs: &mut [SmoothedOutputs<[f64; 1]>],
    ) {
        let DenseSmoother { smoothed, own, forward } = smoother;
        forward.clear();
        let mut filtered = self.clone();
        for inputs in inputs {
            let step = StepInputs::load(inputs);
            let before = filtered.clone();
            let prediction = filtered.predict(&step, parameters);
            forward.push(ForwardStep { before, prediction, predicted: filtered.clone() });
            filtered.update(&step, parameters);
        }
        for ((inputs, forward), outputs) in inputs.iter().zip(forward).zip(outputs).rev() {
            F::smooth_step(own, smoothed, forward, &StepInputs::load(inputs), parameters);
            let (x, p) = &*smoothed;
            outputs.write(&groups(x), &groups(&p.diagonal()));
            for k in 0..AIR_STATES {
                outputs.air_data[k] = [x[STATES + k]];
                outputs.air_data_deviation[k] = [p[(STATES + k, STATES + k)].sqrt()];
            }
        }
    }

    fn covariance(&self, _lane: usize) -> StateMatrix {
        self.estimate().1.fixed_view::<STATES, STATES>(0, 0).into_owned()
    }
}
