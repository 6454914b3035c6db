//! Fit metrics, residual tests, prediction on data not used, tolerance bands.

mod band;
mod contribution;
mod leave_one_out;
mod residual;
mod theil;
mod tolerance;

use nalgebra::DMatrix;

use crate::estimate::{EstimateError, Fit, FitQuality};

pub use band::observation_deviation;
pub use contribution::{Contribution, contributions};
pub use leave_one_out::{LeftOut, leave_one_out};
pub use residual::{Histogram, Whiteness, histogram, whiteness};
pub use theil::{Theil, theil};
pub use tolerance::{BandResult, Histories, Signal, TestResult, Tolerance, ToleranceTest, judge};

/// Prediction of a window the parameters were not estimated from.
#[derive(Clone, Debug, PartialEq)]
pub struct Validation {
    /// Predicted values.
    pub predicted: Vec<f64>,
    /// Measured less predicted.
    pub residuals: Vec<f64>,
    /// Coefficient of determination and root mean square of the residual.
    pub quality: FitQuality,
    /// The same after the constant is set anew, so that the mean residual is zero: the trim of another window is not what
    /// the derivatives predict.
    pub quality_without_offset: FitQuality,
    /// Theil's coefficient and its parts, of the perturbations from the first sample.
    pub theil: Theil,
    /// Whiteness of the residual.
    pub whiteness: Whiteness,
}

/// Predicts `z` by the regressors `x` of another window with the parameters of `fit`, and judges the prediction (thesis
/// 7.1). `columns` gives the parameter of each regressor; `None` for the order of `fit`.
///
/// # Errors
/// Numbers of regressors, samples or parameters that do not fit together.
pub fn validate(
    fit: &Fit,
    columns: Option<&[usize]>,
    x: &DMatrix<f64>,
    z: &[f64],
) -> Result<Validation, EstimateError> {
    let all: Vec<usize> = (0..fit.parameters()).collect();
    let columns = columns.unwrap_or(&all);
    if x.ncols() != columns.len() || columns.iter().any(|&column| column >= fit.parameters()) {
        return Err(EstimateError::Size { quantity: "regressors", expected: fit.parameters(), found: x.ncols() });
    }
    if x.nrows() != z.len() || z.is_empty() {
        return Err(EstimateError::Size { quantity: "rows of the regressors", expected: z.len(), found: x.nrows() });
    }
    let predicted: Vec<f64> = x
        .row_iter()
        .map(|row| row.iter().zip(columns).map(|(value, &column)| value * fit.estimates[column]).sum())
        .collect();
    let residuals: Vec<f64> = z.iter().zip(&predicted).map(|(z, y)| z - y).collect();
    let offset = residuals.iter().sum::<f64>() / residuals.len() as f64;
    let shifted: Vec<f64> = predicted.iter().map(|y| y + offset).collect();
    let from_trim = |values: &[f64]| -> Vec<f64> { values.iter().map(|value| value - z[0]).collect() };
    Ok(Validation {
        quality: FitQuality::compare(z, &predicted),
        quality_without_offset: FitQuality::compare(z, &shifted),
        theil: theil(&from_trim(z), &from_trim(&predicted)),
        whiteness: whiteness(&residuals, residual::DEFAULT_LAGS.min(residuals.len().saturating_sub(1))),
        predicted,
        residuals,
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::estimate::least_squares;

    #[test]
    fn prediction_of_another_window_matches_hand_calculation() {
        let x = DMatrix::from_fn(6, 2, |row, column| if column == 0 { 1.0 } else { row as f64 });
        let names = ["c", "s"].map(str::to_owned);
        let z: Vec<f64> = (0..6).map(|k| 1.0 + 2.0 * f64::from(k)).collect();
        let fit = least_squares(&names, &x, &z).unwrap();
        let shifted: Vec<f64> = z.iter().map(|z| z + 0.5).collect();
        let validation = validate(&fit, None, &x, &shifted).unwrap();
        approx::assert_relative_eq!(validation.quality.rms, 0.5, epsilon = 1e-12);
        approx::assert_relative_eq!(validation.quality_without_offset.rms, 0.0, epsilon = 1e-12);
        approx::assert_relative_eq!(validation.theil.bias, 1.0, epsilon = 1e-10);
        let swapped = DMatrix::from_fn(6, 2, |row, column| if column == 1 { 1.0 } else { row as f64 });
        let same = validate(&fit, Some(&[1, 0]), &swapped, &shifted).unwrap();
        approx::assert_relative_eq!(same.predicted[3], 7.0, epsilon = 1e-12);
        assert!(validate(&fit, Some(&[0]), &x, &shifted).is_err());
        assert!(validate(&fit, None, &x, &shifted[..4]).is_err());
    }
}
