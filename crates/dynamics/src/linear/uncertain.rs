//! An identified model with the covariance of its derivatives, and what that makes of a linear model.

use nalgebra::{Cholesky, DMatrix, DVector};
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, StandardNormal};

use super::{Condition, FlightModel, LinearError, Linearised, Method, Part, StateSpace, linearise};

/// A model and the covariance of its derivatives.
#[derive(Clone, Debug, PartialEq)]
pub struct UncertainModel {
    /// Model with the estimates.
    pub model: FlightModel,
    /// Name of each derivative, in the order of the model's entries.
    pub names: Vec<String>,
    /// Covariance of the derivatives, in that order.
    pub covariance: DMatrix<f64>,
}

/// A linear model and the same with each derivative a little larger and smaller, the trim following it.
#[derive(Clone, Debug, PartialEq)]
pub struct Sensitivities {
    /// The linear model itself.
    pub nominal: Linearised,
    /// What each derivative that has an error changes.
    pub changes: Vec<Change>,
}

/// Linear models on both sides of a derivative's estimate.
#[derive(Clone, Debug, PartialEq)]
pub struct Change {
    /// Index of the derivative.
    pub index: usize,
    /// Distance of each side.
    pub step: f64,
    /// Model with the derivative larger.
    pub above: Linearised,
    /// Model with it smaller.
    pub below: Linearised,
}

impl Change {
    /// Slope of a matrix of the linear model.
    pub fn slope(&self, of: impl Fn(&Linearised) -> DMatrix<f64>) -> DMatrix<f64> {
        (of(&self.above) - of(&self.below)) / (2.0 * self.step)
    }
}

impl UncertainModel {
    /// A model known exactly.
    pub fn exact(model: FlightModel) -> Self {
        let entries = model.derivatives.entries();
        let names: Vec<_> = entries.iter().map(|entry| entry.term.derivative_name(entry.coefficient)).collect();
        let covariance = DMatrix::zeros(names.len(), names.len());
        Self { model, names, covariance }
    }

    /// Standard error of the derivative at `index`.
    pub fn standard_error(&self, index: usize) -> f64 {
        self.covariance[(index, index)].max(0.0).sqrt()
    }

    /// Estimates of the derivatives.
    pub fn values(&self) -> DVector<f64> {
        let entries = self.model.derivatives.entries();
        DVector::from_iterator(entries.len(), entries.iter().map(|entry| entry.value))
    }

    /// The model with other values of its derivatives.
    pub fn with_values(&self, values: &DVector<f64>) -> FlightModel {
        let mut model = self.model.clone();
        values.iter().enumerate().for_each(|(index, &value)| model.derivatives.set(index, value));
        model
    }

    /// The linear model on both sides of every derivative that has an error, for central differences, trimmed anew each time.
    pub fn sensitivities(&self, condition: &Condition) -> Result<Sensitivities, LinearError> {
        /// Step as a fraction of the derivative and of its error.
        const FRACTION: f64 = 1e-3;
        let nominal = linearise(&self.model, condition, Method::Analytic)?;
        let values = self.values();
        let mut changes = Vec::new();
        for index in (0..values.len()).filter(|&index| self.standard_error(index) > 0.0) {
            let step = FRACTION * values[index].abs().max(self.standard_error(index));
            let side = |step: f64| {
                let mut moved = values.clone();
                moved[index] += step;
                linearise(&self.with_values(&moved), condition, Method::Analytic)
            };
            changes.push(Change { index, step, above: side(step)?, below: side(-step)? });
        }
        Ok(Sensitivities { nominal, changes })
    }

    /// Samples of the derivatives: `count` draws of the normal distribution with the estimates as mean and this covariance, the same
    /// for the same seed.
    pub fn samples(&self, count: usize, seed: u64) -> Vec<DVector<f64>> {
        let values = self.values();
        let size = values.len();
        // Derivatives without error, and what rounding takes from the definiteness of the covariance, get a factor of zero.
        let sigma = DVector::from_fn(size, |index, _| self.standard_error(index));
        let correlation = DMatrix::from_fn(size, size, |i, j| {
            let scale = sigma[i] * sigma[j];
            if i == j {
                1.0
            } else if scale > 0.0 {
                self.covariance[(i, j)] / scale
            } else {
                0.0
            }
        });
        let factor = factor(correlation);
        let mut random = ChaCha8Rng::seed_from_u64(seed);
        let draw = |_| {
            let normal = DVector::from_fn(size, |_, _| {
                let value: f64 = StandardNormal.sample(&mut random);
                value
            });
            &values + (&factor * normal).component_mul(&sigma)
        };
        (0..count).map(draw).collect()
    }
}

/// Lower factor of a correlation matrix; where rounding leaves it not positive definite, the root by its eigenvalues, negative ones as zero.
fn factor(correlation: DMatrix<f64>) -> DMatrix<f64> {
    if let Some(cholesky) = Cholesky::new(correlation.clone()) {
        return cholesky.l();
    }
    let size = correlation.nrows();
    let Some(eigen) = doublet_core::decompose::symmetric(correlation) else { return DMatrix::zeros(size, size) };
    let roots = eigen.eigenvalues.map(|value| value.max(0.0).sqrt());
    &eigen.eigenvectors * DMatrix::from_diagonal(&roots)
}

impl Sensitivities {
    /// Covariance of the entries of `[A B]` of a part of the motion, column by column: of A first, then of B.
    pub fn covariance(&self, model: &UncertainModel, part: Part) -> DMatrix<f64> {
        let entries = |linearised: &Linearised| {
            let StateSpace { a, b, .. } = linearised.part(part);
            DMatrix::from_iterator(a.len() + b.len(), 1, a.iter().chain(b.iter()).copied())
        };
        let slopes: Vec<_> = self.changes.iter().map(|change| change.slope(entries).column(0).into_owned()).collect();
        if slopes.is_empty() {
            return DMatrix::zeros(0, 0);
        }
        let jacobian = DMatrix::from_columns(&slopes);
        let moved: Vec<usize> = self.changes.iter().map(|change| change.index).collect();
        let covariance = model.covariance.select_rows(&moved).select_columns(&moved);
        &jacobian * covariance * jacobian.transpose()
    }
}
