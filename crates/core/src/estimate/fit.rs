//! Result of a least-squares fit.

use std::sync::Arc;

use nalgebra::DMatrix;

use super::triangle::Solution;

/// How well fitted or predicted values follow the measurement.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FitQuality {
    /// Coefficient of determination `1 - sum (z - y)^2 / sum (z - mean z)^2`; NaN for a constant measurement.
    pub r_squared: f64,
    /// Root mean square of the residual `sqrt(sum (z - y)^2 / N)` (thesis Eq. 3.17).
    pub rms: f64,
    /// `100 rms / max |z|`, per cent (thesis 6.2.2).
    pub rms_relative_percent: f64,
}

impl FitQuality {
    /// Quality of the values `fitted` against `measured`; both have one length.
    pub fn compare(measured: &[f64], fitted: &[f64]) -> Self {
        let samples = measured.len() as f64;
        let mean = measured.iter().sum::<f64>() / samples;
        let square: f64 = measured.iter().zip(fitted).map(|(z, y)| (z - y).powi(2)).sum();
        let total: f64 = measured.iter().map(|z| (z - mean).powi(2)).sum();
        let largest = measured.iter().fold(0.0_f64, |largest, z| largest.max(z.abs()));
        let rms = (square / samples).sqrt();
        Self { r_squared: 1.0 - square / total, rms, rms_relative_percent: 100.0 * rms / largest }
    }
}

/// What the value of a parameter rests on.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Origin {
    /// The samples alone.
    #[default]
    Data,
    /// The samples and an expectation stated beforehand.
    DataAndPrior,
    /// A stated bound: the samples alone would put it beyond. It has no standard error.
    Bound,
    /// A stated value, without standard error.
    Fixed,
}

impl Origin {
    /// Whether the samples had a say.
    pub fn is_estimated(self) -> bool {
        matches!(self, Self::Data | Self::DataAndPrior)
    }
}

/// Parameters estimated by least squares, with everything said about them. `p` parameters, `n` samples.
#[derive(Clone, Debug, PartialEq)]
pub struct Fit {
    /// Names of the parameters.
    pub names: Vec<String>,
    /// Estimates, p.
    pub estimates: Vec<f64>,
    /// What each of them rests on, p.
    pub origins: Vec<Origin>,
    /// Covariance `s^2 (X'X)^-1` for white residuals (thesis Eq. 3.18), p by p.
    pub covariance: DMatrix<f64>,
    /// `(X'X)^-1`, p by p.
    pub unit_covariance: DMatrix<f64>,
    /// Square roots of the diagonal of the covariance, p.
    pub standard_errors: Vec<f64>,
    /// `100 standard error / |estimate|`, per cent, p.
    pub relative_errors_percent: Vec<f64>,
    /// `estimate / standard error`, p.
    pub t_values: Vec<f64>,
    /// Correlation of the parameters, p by p, ones on the diagonal.
    pub correlation: DMatrix<f64>,
    /// Standard deviation of the residual `s = sqrt(v'v / (n - p))` (thesis Eq. 3.19).
    pub residual_std: f64,
    /// Coefficient of determination and residual root mean square.
    pub quality: FitQuality,
    /// Residuals, measured less fitted, n; shared, as a window may be long.
    pub residuals: Arc<[f64]>,
    /// Ratio of the largest to the smallest singular value of the regressors with columns scaled to unit norm.
    pub condition_number: f64,
}

impl Fit {
    /// Fitted values: `measured`, of which the fit was made, less the residuals.
    pub fn fitted(&self, measured: &[f64]) -> Vec<f64> {
        measured.iter().zip(self.residuals.iter()).map(|(z, v)| z - v).collect()
    }

    /// Number of samples.
    pub fn samples(&self) -> usize {
        self.residuals.len()
    }

    /// Number of parameters.
    pub fn parameters(&self) -> usize {
        self.names.len()
    }

    /// Estimate and standard error of the parameter `name`.
    pub fn parameter(&self, name: &str) -> Option<(f64, f64)> {
        let index = self.names.iter().position(|other| other == name)?;
        Some((self.estimates[index], self.standard_errors[index]))
    }

    /// The fit with another covariance, and the standard errors, t values and correlations that follow from it.
    #[must_use]
    pub(crate) fn with_covariance(mut self, covariance: DMatrix<f64>) -> Self {
        self.standard_errors = standard_errors(&covariance);
        self.relative_errors_percent = ratio(&self.standard_errors, &self.estimates).map(|x| 100.0 * x.abs()).collect();
        self.t_values = ratio(&self.estimates, &self.standard_errors).collect();
        self.correlation = correlation(&covariance);
        self.covariance = covariance;
        self
    }

    /// Fit of `z` with the given solution and fitted values, all parameters estimated from white residuals.
    pub(super) fn assemble(names: &[String], z: &[f64], fitted: &[f64], solution: Solution) -> Self {
        let square: f64 = z.iter().zip(fitted).map(|(z, y)| (z - y).powi(2)).sum();
        let variance = square / (z.len() - names.len()) as f64;
        Self::with_variance(names, z, fitted, solution, variance)
    }

    /// Fit of `z` with the given solution, fitted values and variance of the residual that goes with the solution.
    pub(super) fn with_variance(
        names: &[String],
        z: &[f64],
        fitted: &[f64],
        solution: Solution,
        variance: f64,
    ) -> Self {
        let residuals: Arc<[f64]> = z.iter().zip(fitted).map(|(z, y)| z - y).collect();
        let covariance = &solution.unit_covariance * variance;
        Self {
            origins: vec![Origin::Data; names.len()],
            names: names.to_vec(),
            estimates: solution.estimates.iter().copied().collect(),
            covariance: DMatrix::zeros(0, 0),
            unit_covariance: solution.unit_covariance,
            standard_errors: Vec::new(),
            relative_errors_percent: Vec::new(),
            t_values: Vec::new(),
            correlation: DMatrix::zeros(0, 0),
            residual_std: variance.sqrt(),
            quality: FitQuality::compare(z, fitted),
            residuals,
            condition_number: solution.condition_number,
        }
        .with_covariance(covariance)
    }
}

/// Square roots of the diagonal of a covariance.
pub(super) fn standard_errors(covariance: &DMatrix<f64>) -> Vec<f64> {
    covariance.diagonal().iter().map(|variance| variance.max(0.0).sqrt()).collect()
}

/// Correlation matrix of a covariance; zero where a variance is.
pub(super) fn correlation(covariance: &DMatrix<f64>) -> DMatrix<f64> {
    let deviation = standard_errors(covariance);
    DMatrix::from_fn(covariance.nrows(), covariance.ncols(), |i, j| match deviation[i] * deviation[j] {
        _ if i == j => 1.0,
        0.0 => 0.0,
        product => covariance[(i, j)] / product,
    })
}

/// Quotients of two columns.
fn ratio<'a>(above: &'a [f64], below: &'a [f64]) -> impl Iterator<Item = f64> + 'a {
    above.iter().zip(below).map(|(above, below)| above / below)
}
