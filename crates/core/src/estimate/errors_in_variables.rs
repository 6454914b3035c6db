//! Regressors that carry noise themselves.

use nalgebra::{DMatrix, DVector};

use super::least_squares::check;
use super::triangle::{Solution, Triangle};
use super::{EstimateError, Fit};

/// Least squares corrected for noise of the regressors: `theta = (X'X - N S)^-1 X'z`.
///
/// Noise of a regressor pulls its ordinary estimate toward zero by about `var_x / (var_x + var_noise)`; subtracting the
/// expected part `N S` of `X'X` undoes it. `noise_covariance`: mean covariance `S` of the regressors' noise, p by p, zero for
/// exact ones (constants, controls). The covariance is `s^2 A^-1 X'X A^-1` with `A = X'X - N S`. (Fuller, "Measurement Error
/// Models", 1987, 2.2.)
///
/// # Errors
/// As for [`super::least_squares`]; noise as large as the regressors themselves.
pub fn errors_in_variables(
    names: &[String],
    x: &DMatrix<f64>,
    z: &[f64],
    noise_covariance: &DMatrix<f64>,
) -> Result<Fit, EstimateError> {
    check(names, x, z)?;
    let p = names.len();
    if noise_covariance.shape() != (p, p) {
        return Err(EstimateError::Size {
            quantity: "rows of the noise covariance",
            expected: p,
            found: noise_covariance.nrows(),
        });
    }
    let triangle = Triangle::reduce(x, z);
    let condition_number = triangle.solve(names)?.condition_number;
    let factor = triangle.factor();
    let normal = factor.columns(0, p).tr_mul(&factor.columns(0, p));
    let right = factor.columns(0, p).tr_mul(&factor.column(p));
    // Unit diagonal: the factorisation then does not depend on the units of the regressors.
    let scale = normal.diagonal().map(|square| 1.0 / square.sqrt());
    let scaled = |matrix: &DMatrix<f64>| DMatrix::from_fn(p, p, |i, j| matrix[(i, j)] * scale[i] * scale[j]);
    let corrected =
        scaled(&(&normal - noise_covariance * z.len() as f64)).cholesky().ok_or_else(|| EstimateError::Setting {
            setting: "noise covariance".to_owned(),
            value: noise_covariance.diagonal().max(),
            allowed: "smaller than the variation of the regressors",
        })?;
    let estimates = corrected.solve(&right.component_mul(&scale)).component_mul(&scale);
    let half = corrected.solve(&scaled(&normal));
    let unit_covariance = scaled(&corrected.solve(&half.transpose()));
    let fitted = x * &estimates;
    Ok(Fit::assemble(names, z, fitted.as_slice(), Solution { estimates, unit_covariance, condition_number }))
}

/// Total least squares: the smallest change of measurement and noisy regressors, each in units of its noise, that makes
/// them fit exactly.
///
/// `regressor_noise`: standard deviation of the noise of each regressor, zero for exact ones; `measurement_noise`: that of
/// the measurement; only ratios matter. Exact regressors are taken out by triangularisation, then the smallest singular
/// vector of the rest gives the parameters (Van Huffel and Vandewalle, "The Total Least Squares Problem", 1991, 3.6). The
/// covariance is that of [`errors_in_variables`] with the noise the smallest singular value implies.
///
/// # Errors
/// As for [`super::least_squares`]; noise that is negative, and a problem without a finite solution.
pub fn total_least_squares(
    names: &[String],
    x: &DMatrix<f64>,
    z: &[f64],
    regressor_noise: &[f64],
    measurement_noise: f64,
) -> Result<Fit, EstimateError> {
    check(names, x, z)?;
    check_noise(names, regressor_noise, measurement_noise)?;
    let noisy: Vec<usize> = (0..names.len()).filter(|&index| regressor_noise[index] > 0.0).collect();
    let order: Vec<usize> =
        (0..names.len()).filter(|index| !noisy.contains(index)).chain(noisy.iter().copied()).collect();
    let exact = names.len() - noisy.len();
    let triangle = Triangle::reduce(x, z).subset(&order);
    let mut rest =
        triangle.factor().view((exact, exact), (triangle.factor().nrows() - exact, noisy.len() + 1)).into_owned();
    for (column, &index) in noisy.iter().enumerate() {
        rest.column_mut(column).scale_mut(1.0 / regressor_noise[index]);
    }
    rest.column_mut(noisy.len()).scale_mut(1.0 / measurement_noise);
    let decomposition = rest.svd(false, true);
    let smallest = decomposition.singular_values.imin();
    let no_solution = || EstimateError::Setting {
        setting: "regressor noise".to_owned(),
        value: regressor_noise.iter().copied().fold(0.0, f64::max),
        allowed: "smaller than the variation of the regressors",
    };
    let vectors = decomposition.v_t.ok_or_else(no_solution)?;
    let last = vectors[(smallest, noisy.len())];
    if last.abs() < f64::EPSILON {
        return Err(no_solution());
    }
    // The noise that the smallest singular value implies, in units of the given deviations.
    let level = decomposition.singular_values[smallest].powi(2) / z.len() as f64;
    let noise =
        DVector::from_iterator(names.len(), regressor_noise.iter().map(|deviation| level * deviation * deviation));
    errors_in_variables(names, x, z, &DMatrix::from_diagonal(&noise))
}

/// Checks the noise levels of a total least-squares problem.
fn check_noise(names: &[String], regressor_noise: &[f64], measurement_noise: f64) -> Result<(), EstimateError> {
    if regressor_noise.len() != names.len() {
        return Err(EstimateError::Size {
            quantity: "noise levels",
            expected: names.len(),
            found: regressor_noise.len(),
        });
    }
    let fault = |name: &str, value: f64, allowed| EstimateError::Setting {
        setting: format!("noise of {name}"),
        value,
        allowed,
    };
    if !(measurement_noise > 0.0 && measurement_noise.is_finite()) {
        return Err(fault("the measurement", measurement_noise, "positive and finite"));
    }
    match regressor_noise.iter().position(|&value| !(value >= 0.0 && value.is_finite())) {
        Some(index) => Err(fault(&names[index], regressor_noise[index], "finite and not negative")),
        None => Ok(()),
    }
}
