//! Weighted and generalised least squares.

use std::ops::Range;

use nalgebra::{DMatrix, DVector};

use super::covariance::{Coloured, autocorrelation_of_windows, coloured_covariance_within};
use super::least_squares::{check, least_squares};
use super::pooled::{PooledFit, PooledRegression, PooledWindow};
use super::robust::largest_move;
use super::triangle::Triangle;
use super::{EstimateError, Fit};

/// Rounds of a generalised fit.
const ROUNDS: usize = 50;
/// Change of the parameters, in standard errors, that ends them.
const TOLERANCE: f64 = 1e-6;
/// Residual, as a part of the measurement, that is rounding: of an exact fit, which has nothing to whiten.
const ROUNDING: f64 = 1e-13;

/// Weighted least squares `theta = argmin sum w_i v_i^2`, weights inversely proportional to the variance of each sample.
///
/// The covariance is `s^2 (X'WX)^-1` with `s^2 = sum w_i v_i^2 / (n - p)`: `residual_std` is that of a sample of weight one.
/// Fitted values, residuals and quality are those of the samples themselves.
///
/// # Errors
/// As for [`super::least_squares`], and weights that are not positive.
pub fn weighted_least_squares(
    names: &[String],
    x: &DMatrix<f64>,
    z: &[f64],
    weights: &[f64],
) -> Result<Fit, EstimateError> {
    check(names, x, z)?;
    if weights.len() != z.len() {
        return Err(EstimateError::Size { quantity: "weights", expected: z.len(), found: weights.len() });
    }
    if let Some(sample) = weights.iter().position(|&weight| !(weight > 0.0 && weight.is_finite())) {
        return Err(EstimateError::Setting {
            setting: format!("weight of sample {sample}"),
            value: weights[sample],
            allowed: "positive and finite",
        });
    }
    let mut scaled = x.clone();
    for (mut row, weight) in scaled.row_iter_mut().zip(weights) {
        row *= weight.sqrt();
    }
    let scaled_z: Vec<f64> = z.iter().zip(weights).map(|(z, weight)| z * weight.sqrt()).collect();
    transformed(names, x, z, &scaled, &scaled_z)
}

/// Covariance of a weighted fit for correlated residuals, whose products are taken inside each of `windows` only: that of
/// [`super::coloured_covariance`] with rows and residuals times the roots of their weights.
pub fn weighted_coloured_covariance(
    fit: &Fit,
    x: &DMatrix<f64>,
    weights: &[f64],
    windows: &[Range<usize>],
    settings: &Coloured,
) -> Result<DMatrix<f64>, EstimateError> {
    let mut scaled = x.clone();
    for (mut row, weight) in scaled.row_iter_mut().zip(weights) {
        row *= weight.sqrt();
    }
    let residuals: Vec<f64> = fit.residuals.iter().zip(weights).map(|(v, weight)| v * weight.sqrt()).collect();
    coloured_covariance_within(fit, (&scaled, &residuals), windows, settings)
}

/// A generalised fit and the residual model it used.
#[derive(Clone, Debug, PartialEq)]
pub struct GeneralisedFit {
    /// The fit; `residual_std` is that of the innovations of the residual model.
    pub fit: Fit,
    /// Coefficients `a_k` of `v_i = a_1 v_{i-1} + ... + a_m v_{i-m} + e_i`.
    pub autoregression: Vec<f64>,
}

impl GeneralisedFit {
    /// Covariance for the colour that the autoregression leaves in the residuals: that of [`super::coloured_covariance`] with rows
    /// and residuals whitened by it.
    pub fn coloured_covariance(
        &self,
        x: &DMatrix<f64>,
        windows: &[Range<usize>],
        settings: &Coloured,
    ) -> Result<DMatrix<f64>, EstimateError> {
        let (scaled, residuals) = whitened(x, &self.fit.residuals, windows, &self.autoregression);
        let order = self.autoregression.len();
        let mut end = 0;
        let shorter = windows.iter().map(|window| {
            let start = end;
            end += window.len() - order;
            start..end
        });
        coloured_covariance_within(&self.fit, (&scaled, &residuals), &shorter.collect::<Vec<_>>(), settings)
    }
}

/// Generalised least squares for residuals that follow an autoregression of the given `order`: regressors and measurement
/// are whitened by the autoregression of the residual (Yule-Walker equations), fitted, and so on until the parameters stay. An exact fit
/// stays as it is, with an autoregression of zero.
/// `windows` are the uninterrupted stretches of samples; no product or filter crosses from one to the next.
///
/// # Errors
/// As for [`super::least_squares`]; an order of zero or beyond the shortest window, and an iteration that does not settle.
pub fn generalised_least_squares(
    names: &[String],
    x: &DMatrix<f64>,
    z: &[f64],
    windows: &[Range<usize>],
    order: usize,
) -> Result<GeneralisedFit, EstimateError> {
    let shortest = windows.iter().map(ExactSizeIterator::len).min().unwrap_or(0);
    if order == 0 || order >= shortest || windows.iter().any(|window| window.end > z.len()) {
        return Err(wrong_order(order));
    }
    let mut fit = least_squares(names, x, z)?;
    if is_rounding(&fit.residuals, z) {
        return Ok(GeneralisedFit { fit, autoregression: vec![0.0; order] });
    }
    for _ in 0..ROUNDS {
        let autoregression = yule_walker(&fit.residuals, windows, order);
        let (scaled, scaled_z) = whitened(x, z, windows, &autoregression);
        check(names, &scaled, &scaled_z)?;
        let next = transformed(names, x, z, &scaled, &scaled_z)?;
        let is_settled = largest_move(&fit, &next) <= TOLERANCE;
        fit = next;
        if is_settled {
            return Ok(GeneralisedFit { fit, autoregression });
        }
    }
    Err(NOT_SETTLED)
}

/// The error of a generalised fit that does not settle.
const NOT_SETTLED: EstimateError =
    EstimateError::NotConverged { method: "the generalised least-squares fit", iterations: ROUNDS };

fn wrong_order(order: usize) -> EstimateError {
    EstimateError::Setting {
        setting: "order".to_owned(),
        value: order as f64,
        allowed: "at least 1 and less than the samples of the shortest window",
    }
}

impl PooledRegression {
    /// The same regression whitened by an autoregression of its residuals of the given `order`, one for all windows: least squares of it
    /// is [`generalised_least_squares`] under the constraints, and its covariance that of the generalised fit. Each window loses its
    /// first `order` samples.
    ///
    /// # Errors
    /// As for [`PooledRegression::fit`]; an order of zero or beyond the shortest window, and an iteration that does not settle.
    pub fn whitened(&self, order: usize) -> Result<Self, EstimateError> {
        let shortest = self.windows.iter().map(|window| window.z.len()).min().unwrap_or(0);
        if order == 0 || order >= shortest {
            return Err(wrong_order(order));
        }
        let mut found = self.fit()?;
        let rows = found.samples.clone();
        let measured: Vec<f64> = self.windows.iter().flat_map(|window| &window.z).copied().collect();
        let is_exact = is_rounding(&found.fit.residuals, &measured);
        let mut next = self.clone();
        for _ in 0..ROUNDS {
            let fitted = found.fitted(&self.windows);
            let residuals: Vec<f64> = measured.iter().zip(&fitted).map(|(z, y)| z - y).collect();
            let autoregression = if is_exact { vec![0.0; order] } else { yule_walker(&residuals, &rows, order) };
            for (next, PooledWindow { x, z, .. }) in next.windows.iter_mut().zip(&self.windows) {
                (next.x, next.z) = whitened(x, z, std::slice::from_ref(&(0..z.len())), &autoregression);
            }
            let fit = next.fit()?;
            if is_exact || largest_move(&found.fit, &fit.fit) <= TOLERANCE {
                return Ok(next);
            }
            found = fit;
        }
        Err(NOT_SETTLED)
    }
}

impl PooledFit {
    /// Fitted values of windows, one after the other: of those fitted, or of the same with other samples.
    pub fn fitted(&self, windows: &[PooledWindow]) -> Vec<f64> {
        let estimates = DVector::from_column_slice(&self.fit.estimates);
        let value = |(window, columns): (&PooledWindow, &Vec<usize>)| &window.x * estimates.select_rows(columns);
        windows.iter().zip(&self.parameters).flat_map(|pair| value(pair).as_slice().to_vec()).collect()
    }
}

/// Fit of transformed rows, reported for the rows as measured.
fn transformed(
    names: &[String],
    x: &DMatrix<f64>,
    z: &[f64],
    scaled: &DMatrix<f64>,
    scaled_z: &[f64],
) -> Result<Fit, EstimateError> {
    let triangle = Triangle::reduce(scaled, scaled_z);
    let solution = triangle.solve(names)?;
    let variance = triangle.residual_square() / (scaled_z.len() - names.len()) as f64;
    let fitted = x * &solution.estimates;
    Ok(Fit::with_variance(names, z, fitted.as_slice(), solution, variance))
}

/// Whether residuals of a measurement are rounding.
fn is_rounding(residuals: &[f64], z: &[f64]) -> bool {
    let norm = |values: &[f64]| values.iter().map(|value| value * value).sum::<f64>().sqrt();
    norm(residuals) <= ROUNDING * norm(z)
}

/// Coefficients of the autoregression of a residual from its autocorrelation inside the windows.
fn yule_walker(residuals: &[f64], windows: &[Range<usize>], order: usize) -> Vec<f64> {
    let records = windows.iter().map(|window| &residuals[window.clone()]);
    let correlation = autocorrelation_of_windows(records, order);
    let matrix = DMatrix::from_fn(order, order, |i, j| correlation[i.abs_diff(j)]);
    let right = DVector::from_fn(order, |i, _| correlation[i + 1]);
    // The autocorrelation matrix of a record is positive definite unless the residual vanishes, which needs no whitening.
    matrix.cholesky().map_or_else(|| vec![0.0; order], |factor| factor.solve(&right).iter().copied().collect())
}

/// Rows less what the autoregression predicts from the rows before them, without the first `order` rows of each window.
fn whitened(x: &DMatrix<f64>, z: &[f64], windows: &[Range<usize>], autoregression: &[f64]) -> (DMatrix<f64>, Vec<f64>) {
    let kept: Vec<usize> = windows.iter().flat_map(|window| window.start + autoregression.len()..window.end).collect();
    let mut scaled = x.select_rows(&kept);
    let mut scaled_z: Vec<f64> = kept.iter().map(|&row| z[row]).collect();
    for (index, &row) in kept.iter().enumerate() {
        for (lag, coefficient) in (1..).zip(autoregression) {
            scaled_z[index] -= coefficient * z[row - lag];
            for column in 0..x.ncols() {
                scaled[(index, column)] -= coefficient * x[(row - lag, column)];
            }
        }
    }
    (scaled, scaled_z)
}
