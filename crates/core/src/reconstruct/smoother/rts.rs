//! Rauch-Tung-Striebel smoother of the extended filter over whole matrices (Rauch, Tung & Striebel 1965).

use std::ops::SubAssign;

use nalgebra::SVector;

use crate::reconstruct::filter::ekf::Ekf;
use crate::reconstruct::filter::parameters::FilterParameters;
use crate::reconstruct::filter::step::{StepInputs, Update};
use crate::reconstruct::filter::terms::{
    Process, expected, image, measurement_noise, random_walk, residual, velocity_by_wind, walk_covariance,
};
use crate::reconstruct::model::augmented::{AugmentedMatrix, AugmentedState, groups};
use crate::reconstruct::model::layout::{ATT, INPUTS, STATES, VEL, WIND};
use crate::reconstruct::settings::ValidSettings;
use crate::reconstruct::smoother::dense::{DenseFilter, ForwardStep};

/// The smoothed path and its cost.
pub struct SmoothedPath {
    /// Smoothed state of every event, filled from the end.
    pub states: Vec<AugmentedState>,
    /// Index of the last one filled.
    event: usize,
    /// What the iterated smoother minimises, see [`crate::reconstruct::data::Smoothed::costs`].
    pub cost: f64,
}

impl DenseFilter for Ekf {
    type Prediction = Process;
    type Smoother = SmoothedPath;

    fn new(x: AugmentedState, p: AugmentedMatrix, _settings: &ValidSettings) -> Self {
        Self { x, p, about: None, event: 0 }
    }

    fn estimate(&self) -> (&AugmentedState, &AugmentedMatrix) {
        (&self.x, &self.p)
    }

    fn predict(&mut self, step: &StepInputs<f64>, parameters: &FilterParameters<f64>) -> Process {
        self.predict(step, parameters)
    }

    fn update(&mut self, step: &StepInputs<f64>, parameters: &FilterParameters<f64>) -> Update<f64> {
        self.update(step, parameters)
    }

    fn smoother(&self) -> SmoothedPath {
        SmoothedPath { states: vec![self.x; self.event + 1], event: self.event, cost: 0.0 }
    }

    /// With `W = N (P-)^-1` and the gain `G = Phi^-1 (I - W)`: `x + G (xs - x-)` and
    /// `Phi^-1 ((I - W) (Ps + N) (I - W)' + W (P- - N) W') Phi'^-1`, a sum of covariances only, as Joseph's form of the update is.
    fn smooth_step(
        path: &mut SmoothedPath,
        (x, p): &mut (AugmentedState, AugmentedMatrix),
        forward: &ForwardStep<Self>,
        step: &StepInputs<f64>,
        parameters: &FilterParameters<f64>,
    ) {
        let ForwardStep { before, prediction: Process { phi, noise, .. }, predicted } = forward;
        let end = *x;
        let scale = AugmentedState::from_fn(|k, _| {
            let variance = predicted.p[(k, k)];
            if variance > 0.0 { variance.sqrt().recip() } else { 0.0 }
        });
        let scale = AugmentedMatrix::from_diagonal(&scale);
        // Correlations: of order one, whatever the units. Directions lost to rounding take no part.
        let mut eigen = (scale * predicted.p * scale).symmetric_eigen();
        let least = STATES as f64 * f64::EPSILON * eigen.eigenvalues.max();
        eigen.eigenvalues.apply(|value| *value = if *value > least { value.recip() } else { 0.0 });
        let w = noise * scale * eigen.recompose() * scale;
        let a = AugmentedMatrix::identity() - w;
        let difference = *x - predicted.x;
        let without_noise = phi * before.p * phi.transpose();
        let covariance = a * (*p + noise) * a.transpose() + w * without_noise * w.transpose();
        let back = phi.lu();
        let singular = (AugmentedMatrix::from_element(f64::NAN), AugmentedState::from_element(f64::NAN));
        let half = back.solve(&covariance).unwrap_or(singular.0);
        let covariance = back.solve(&half.transpose()).unwrap_or(singular.0);
        *x = before.x + back.solve(&(a * difference)).unwrap_or(singular.1);
        *p = (covariance + covariance.transpose()) * 0.5;

        path.event -= 1;
        path.states[path.event] = *x;
        path.cost += step_cost(x, &end, noise, step, parameters);
        if path.event == 0 {
            path.cost += weighted_squares(&(*x - before.x), &before.p.diagonal());
        }
    }
}

/// What one step of a path from `begin` to `end` costs: squares of the residuals over R at its end, of the process noise over
/// its covariance `noise`, of the random walks over theirs. The noise is what moves velocity and attitude from where f and the change of
/// wind take them.
fn step_cost(
    begin: &AugmentedState,
    end: &AugmentedState,
    noise: &AugmentedMatrix,
    step: &StepInputs<f64>,
    parameters: &FilterParameters<f64>,
) -> f64 {
    /// First of the states that the inputs' noise moves.
    const MOVING: usize = 3 * VEL;
    let measured = weighted_squares(&residual(step, &expected(end, step).0), &measurement_noise(step, parameters));
    let image = image(begin, step, parameters).0;
    let mut defect = end - image;
    let by_wind = velocity_by_wind(&groups(&image)[ATT]) * defect.fixed_rows::<3>(3 * WIND);
    defect.fixed_rows_mut::<3>(3 * VEL).sub_assign(&by_wind);
    let of_inputs = noise - walk_covariance(&image, step, parameters);
    let variances = of_inputs.fixed_view::<INPUTS, INPUTS>(MOVING, MOVING).into_owned();
    let of_motion = defect.fixed_rows::<INPUTS>(MOVING).into_owned();
    let process = variances.cholesky().map_or(f64::NAN, |factor| of_motion.dot(&factor.solve(&of_motion)));
    let mut walks = random_walk(parameters) * step.dt;
    walks.fixed_rows_mut::<{ MOVING + INPUTS }>(0).fill(0.0);
    measured + process + weighted_squares(&defect, &walks)
}

/// Sum of squares over variances, over the entries that have one.
fn weighted_squares<const N: usize>(values: &SVector<f64, N>, variances: &SVector<f64, N>) -> f64 {
    let pairs = values.iter().zip(variances.iter()).filter(|(_, variance)| **variance > 0.0);
    pairs.map(|(value, variance)| value * value / variance).sum()
}
