//! Least squares as samples come.

use std::collections::VecDeque;

use nalgebra::{DMatrix, DVector};

use super::EstimateError;
use super::covariance::Taper;
use super::fit::{correlation, standard_errors};
use super::triangle::Triangle;

/// Least squares a sample at a time, with exponential forgetting: the triangle of `[X z]` is rotated on, so that without forgetting the
/// estimate is that of [`super::least_squares`] over all samples so far (Golub and Van Loan, "Matrix Computations", 6.5).
///
/// For residuals that are correlated in time the products of rows up to a number of lags apart are summed as well, `A_k = sum a_i
/// a_{i+k}'` with `a = [x z]`: the autocorrelation of the residual of the present estimate, `R(k) = c' A_k c / N` with
/// `c = [-theta 1]`, and the middle of `D M D`, follow from them at any moment without the samples (Grauer and Morelli,
/// "Modeling uncertainty for recursive least squares", NTRS 20160007740, by another recursion).
#[derive(Clone, Debug)]
pub struct RecursiveLeastSquares {
    names: Vec<String>,
    /// Forgetting factor of one sample.
    factor: f64,
    triangle: Triangle,
    /// Last rows, the newest first.
    rows: VecDeque<DVector<f64>>,
    /// `A_k` for each lag, of zero first.
    products: Vec<DMatrix<f64>>,
    taper: Taper,
    /// Effective number of samples, the sum of their weights.
    samples: f64,
}

/// Parameters as they are estimated now.
#[derive(Clone, Debug, PartialEq)]
pub struct RecursiveEstimate {
    /// Names of the parameters.
    pub names: Vec<String>,
    /// Estimates.
    pub estimates: Vec<f64>,
    /// Standard errors for white residuals.
    pub standard_errors: Vec<f64>,
    /// Standard errors for residuals as they are, correlated over the lags that are kept.
    pub corrected_standard_errors: Vec<f64>,
    /// Correlation of the parameters.
    pub correlation: DMatrix<f64>,
    /// Sum of the weights of the samples.
    pub samples: f64,
    /// Standard deviation of the residual.
    pub residual_std: f64,
}

impl RecursiveLeastSquares {
    /// Before the first sample. `forgetting` is the number of samples after which one counts 1/e, none where all count alike; `lags` the
    /// largest lag of the correlation of residuals, weighted by `taper`.
    ///
    /// # Errors
    /// No parameters, and a forgetting that is not above one sample.
    pub fn new(names: &[String], forgetting: Option<f64>, lags: usize, taper: Taper) -> Result<Self, EstimateError> {
        if names.is_empty() {
            return Err(EstimateError::NoParameters);
        }
        let factor = match forgetting {
            None => 1.0,
            Some(samples) if samples > 1.0 => (-1.0 / samples).exp(),
            Some(value) => {
                let setting = "forgetting".to_owned();
                return Err(EstimateError::Setting { setting, value, allowed: "above one sample" });
            }
        };
        let columns = names.len() + 1;
        Ok(Self {
            names: names.to_vec(),
            factor,
            triangle: Triangle::empty(names.len()),
            rows: VecDeque::with_capacity(lags + 1),
            products: vec![DMatrix::zeros(columns, columns); lags + 1],
            taper,
            samples: 0.0,
        })
    }

    /// Takes in one sample: regressors and measurement. One that is not finite, or not of the right size, is left out.
    pub fn push(&mut self, x: &[f64], z: f64) {
        if x.len() != self.names.len() || !x.iter().all(|value| value.is_finite()) || !z.is_finite() {
            return self.interrupt();
        }
        let row = DVector::from_iterator(x.len() + 1, x.iter().copied().chain(std::iter::once(z)));
        if self.rows.len() == self.products.len() {
            self.rows.pop_back();
        }
        self.rows.push_front(row.clone());
        for (product, before) in self.products.iter_mut().zip(&self.rows) {
            product.ger(1.0, before, &row, self.factor);
        }
        for product in self.products.iter_mut().skip(self.rows.len()) {
            *product *= self.factor;
        }
        let mut row: Vec<f64> = row.iter().copied().collect();
        self.triangle.append(&mut row, self.factor.sqrt());
        self.samples = self.samples * self.factor + 1.0;
    }

    /// What comes next does not follow what came last: no product is taken across.
    pub fn interrupt(&mut self) {
        self.rows.clear();
    }

    /// Parameters with the samples so far.
    ///
    /// # Errors
    /// Fewer samples than parameters and one, and regressors that depend on each other, named.
    pub fn estimate(&self) -> Result<RecursiveEstimate, EstimateError> {
        let parameters = self.names.len();
        let degrees = self.samples - parameters as f64;
        if degrees <= 0.0 {
            #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "a small count")]
            return Err(EstimateError::TooFewSamples { samples: self.samples as usize, parameters });
        }
        let solution = self.triangle.solve(&self.names)?;
        let variance = self.triangle.residual_square() / degrees;
        let covariance = &solution.unit_covariance * variance;
        let corrected = self.corrected(&solution.unit_covariance, &solution.estimates);
        Ok(RecursiveEstimate {
            names: self.names.clone(),
            standard_errors: standard_errors(&covariance),
            corrected_standard_errors: standard_errors(&corrected),
            correlation: correlation(&covariance),
            estimates: solution.estimates.iter().copied().collect(),
            samples: self.samples,
            residual_std: variance.sqrt(),
        })
    }

    /// `D M D` with `M = sum_k w_k R(k) (A_k + A_k')` over the regressors, zero lag once.
    fn corrected(&self, unit: &DMatrix<f64>, estimates: &DVector<f64>) -> DMatrix<f64> {
        let parameters = self.names.len();
        let residual = DVector::from_fn(parameters + 1, |k, _| if k < parameters { -estimates[k] } else { 1.0 });
        let mut middle = DMatrix::zeros(parameters, parameters);
        let weights = self.taper.weights(self.products.len() - 1);
        for (lag, (product, weight)) in self.products.iter().zip(weights).enumerate() {
            let correlation = (product * &residual).dot(&residual) / self.samples;
            let regressors = product.view((0, 0), (parameters, parameters));
            middle += regressors * (weight * correlation);
            if lag > 0 {
                middle += regressors.transpose() * (weight * correlation);
            }
        }
        unit * middle * unit
    }
}
