//! Unscented Kalman filter and smoother: means and covariances from sigma points instead of Jacobians.
//!
//! Sigma points lie at `spread` standard deviations either way along every column of a square root of the covariance and, in
//! the prediction, of every process noise (Julier & Uhlmann 2004; scaled form of van der Merwe 2004 with beta = 2). With `d`
//! the mean of their images less the image of the centre, weights `w = 1 / (2 spread^2)` and n columns, the covariance of
//! the images is `sum w (y - y0)(y - y0)' + (2 - spread^2 / n) d d'`: a sum of squares, positive whatever the spread.

use nalgebra::SMatrix;

use crate::reconstruct::filter::parameters::FilterParameters;
use crate::reconstruct::filter::step::{StepInputs, Update};
use crate::reconstruct::filter::terms::{difference, measurement_noise, residual, robust_noise, walk_covariance};
use crate::reconstruct::model::augmented::{
    AugmentedMatrix, AugmentedState, MeasurementVector, advance_with_noise, observe,
};
use crate::reconstruct::model::layout::{AUGMENTED_STATES, INPUTS, MEASUREMENTS};

/// Columns of the square root in a prediction.
const COLUMNS: usize = AUGMENTED_STATES + INPUTS;
/// Deviations of the sigma points of a prediction, times the square root of their weight.
type SigmaDeviations = SMatrix<f64, AUGMENTED_STATES, { 2 * COLUMNS }>;

/// State, covariance and the distance of the sigma points.
#[derive(Clone)]
pub struct Ukf {
    pub x: AugmentedState,
    /// Covariance P.
    pub p: AugmentedMatrix,
    /// Distance of the sigma points, standard deviations.
    pub spread: f64,
}

/// A prediction's sigma points.
pub struct SigmaPrediction {
    /// Before the step.
    pub before: SigmaDeviations,
    /// After it, from the image of the centre.
    pub after: SigmaDeviations,
    /// Mean of the images less the image of the centre, times the root of its weight.
    pub shift: AugmentedState,
    /// Covariance of the random walks over the step.
    pub walks: AugmentedMatrix,
}

impl Ukf {
    /// Weight of the centre's part of the covariance with `columns` columns of sigma points.
    fn centre_weight(&self, columns: usize) -> f64 {
        (2.0 - self.spread * self.spread / columns as f64).max(0.0)
    }

    /// Prediction over one step: mean and covariance of the images of the sigma points of state and input noise.
    pub fn predict(&mut self, step: &StepInputs<f64>, parameters: &FilterParameters<f64>) -> SigmaPrediction {
        let root = Root::new(&self.p);
        let weight = 0.5 / (self.spread * self.spread);
        let f = |x: &AugmentedState, noise: &[f64; INPUTS]| {
            advance_with_noise(x, noise, &step.inputs, step.dt, parameters.gravity)
        };
        let centre = f(&self.x, &[0.0; INPUTS]);
        let (mut before, mut after) = (SigmaDeviations::zeros(), SigmaDeviations::zeros());
        let mut shift = AugmentedState::zeros();
        for column in 0..COLUMNS {
            let mut along = AugmentedState::zeros();
            let mut noises = [0.0; INPUTS];
            if column < AUGMENTED_STATES {
                along.copy_from(&root.lower.column(column));
            } else {
                let i = column - AUGMENTED_STATES;
                noises[i] = (parameters.noise.process[i / 3][i % 3] * step.noise_scale).sqrt();
            }
            for (side, distance) in [self.spread, -self.spread].into_iter().enumerate() {
                let image = f(&(self.x + along * distance), &noises.map(|noise| noise * distance));
                let moved = (image - centre) * weight.sqrt();
                shift += moved * weight.sqrt();
                before.set_column(2 * column + side, &(along * (distance * weight.sqrt())));
                after.set_column(2 * column + side, &moved);
            }
        }
        self.x = centre + shift;
        shift *= self.centre_weight(root.columns + INPUTS).sqrt();
        let walks = walk_covariance(&self.x, step, parameters);
        self.p = after * after.transpose() + shift * shift.transpose() + walks;
        SigmaPrediction { before, after, shift, walks }
    }

    /// Update with what was measured at the end of the step: `S` and the covariance with the state from the images of the sigma
    /// points under h.
    pub fn update(&mut self, step: &StepInputs<f64>, parameters: &FilterParameters<f64>) -> Update<f64> {
        let root = Root::new(&self.p);
        let weight = 0.5 / (self.spread * self.spread);
        let (centre, _) = observe(&self.x);
        let mut before = SMatrix::<f64, AUGMENTED_STATES, { 2 * AUGMENTED_STATES }>::zeros();
        let mut images = SMatrix::<f64, MEASUREMENTS, { 2 * AUGMENTED_STATES }>::zeros();
        let mut shift = MeasurementVector::zeros();
        for column in 0..AUGMENTED_STATES {
            for (side, distance) in [self.spread, -self.spread].into_iter().enumerate() {
                let along = root.lower.column(column) * distance;
                let (image, _) = observe(&(self.x + along));
                let moved = difference(&image, step, &centre) * weight.sqrt();
                shift += moved * weight.sqrt();
                before.set_column(2 * column + side, &(along * weight.sqrt()));
                images.set_column(2 * column + side, &moved);
            }
        }
        let innovation = residual(step, &centre) - shift;
        let noise = measurement_noise(step, parameters);
        shift *= self.centre_weight(root.columns).sqrt();
        let mut own = SMatrix::from_diagonal(&noise) + shift * shift.transpose();
        let spread = images * images.transpose();
        let added = robust_noise(&innovation, &(spread + own), parameters.robust_limit);
        own += SMatrix::from_diagonal(&added);
        let s = spread + own;
        let Some(factor) = s.cholesky() else { return Update::failed(&parameters.noise.measurement) };
        let cross = before * images.transpose();
        let gain = factor.solve(&cross.transpose()).transpose();
        self.x += gain * innovation;
        // P - K S K', as the sum of squares it is
        let left = before - gain * images;
        self.p = left * left.transpose() + gain * own * gain.transpose();
        Update::new(&innovation, &s, &factor, &noise, &added)
    }
}

/// Cholesky factor of a covariance that may have states without variance: their columns are zero.
pub struct Root {
    /// Lower triangle L, `P = L L'`.
    pub lower: AugmentedMatrix,
    /// Number of columns that are not zero.
    pub columns: usize,
}

impl Root {
    /// Factor of `p`.
    pub fn new(p: &AugmentedMatrix) -> Self {
        let mut lower = AugmentedMatrix::zeros();
        let mut columns = 0;
        for j in 0..AUGMENTED_STATES {
            let mut pivot = p[(j, j)];
            for k in 0..j {
                pivot -= lower[(j, k)] * lower[(j, k)];
            }
            if pivot <= AUGMENTED_STATES as f64 * f64::EPSILON * p[(j, j)] || pivot.is_nan() {
                continue;
            }
            columns += 1;
            lower[(j, j)] = pivot.sqrt();
            for i in j + 1..AUGMENTED_STATES {
                let mut value = p[(i, j)];
                for k in 0..j {
                    value -= lower[(i, k)] * lower[(j, k)];
                }
                lower[(i, j)] = value / lower[(j, j)];
            }
        }
        Self { lower, columns }
    }

    /// `P^-1 b`, zero in the rows of states without variance.
    pub fn solve(&self, mut b: AugmentedMatrix) -> AugmentedMatrix {
        let l = &self.lower;
        for column in 0..AUGMENTED_STATES {
            for i in 0..AUGMENTED_STATES {
                let known: f64 = (0..i).map(|k| l[(i, k)] * b[(k, column)]).sum();
                b[(i, column)] = over(b[(i, column)] - known, l[(i, i)]);
            }
            for i in (0..AUGMENTED_STATES).rev() {
                let known: f64 = (i + 1..AUGMENTED_STATES).map(|k| l[(k, i)] * b[(k, column)]).sum();
                b[(i, column)] = over(b[(i, column)] - known, l[(i, i)]);
            }
        }
        b
    }
}

/// `value / pivot`, zero where there is no pivot.
fn over(value: f64, pivot: f64) -> f64 {
    if pivot > 0.0 { value / pivot } else { 0.0 }
}
