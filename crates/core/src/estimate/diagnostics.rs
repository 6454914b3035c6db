//! What the regressors and the fit allow to conclude.

use nalgebra::{DMatrix, DVector};

use super::fit::correlation as correlation_of;
use super::{EstimateError, Fit, least_squares};

/// Correlation of the regressors, each less its mean; zero for a constant column, one on the diagonal. `x`: samples by
/// regressors. Beyond 0.9 two regressors can hardly be told apart (Klein and Morelli).
pub fn regressor_correlation(x: &DMatrix<f64>) -> DMatrix<f64> {
    let mut centred = x.clone();
    for mut column in centred.column_iter_mut() {
        let mean = column.mean();
        let largest = column.amax();
        column.add_scalar_mut(-mean);
        // What rounding leaves of a constant column is not a variation.
        if column.amax() <= largest * f64::EPSILON * 16.0 {
            column.fill(0.0);
        }
    }
    correlation_of(&centred.tr_mul(&centred))
}

/// Variance inflation factor of each regressor, `1 / (1 - R2_j)` with `R2_j` of regressor `j` fitted by a constant and the
/// others; above 10 is serious. NaN for a constant regressor, which has none.
///
/// # Errors
/// Those of the fits: too few samples, or regressors that depend on each other.
pub fn variance_inflation(names: &[String], x: &DMatrix<f64>) -> Result<Vec<f64>, EstimateError> {
    let correlation = regressor_correlation(x);
    let varying: Vec<usize> = (0..x.ncols()).filter(|&j| x.column(j).max() > x.column(j).min()).collect();
    let mut factors = vec![f64::NAN; x.ncols()];
    // A fit of the centred regressors has (X'X)^-1 in units of their correlation: its diagonal is 1 / (1 - R2_j).
    let centred = DMatrix::from_fn(x.nrows(), varying.len(), |row, j| {
        let column = x.column(varying[j]);
        column[row] - column.mean()
    });
    if varying.len() < 2 {
        varying.iter().for_each(|&j| factors[j] = correlation[(j, j)]);
        return Ok(factors);
    }
    let kept: Vec<String> = varying.iter().map(|&j| names[j].clone()).collect();
    let fit = least_squares(&kept, &centred, &vec![0.0; x.nrows()])?;
    for (index, &j) in varying.iter().enumerate() {
        factors[j] = fit.unit_covariance[(index, index)] * centred.column(index).norm_squared();
    }
    Ok(factors)
}

/// Partial F of each parameter, `(estimate / standard error)^2`: the drop of the explained sum of squares without it, over
/// the residual variance. About 4 is significant at 95 %; 20 is the practice in aircraft identification (Klein and
/// Morelli).
pub fn partial_f(fit: &Fit) -> Vec<f64> {
    fit.t_values.iter().map(|t| t * t).collect()
}

/// Leverage of each sample, `h_ii = x_i' (X'X)^-1 x_i`; between 0 and 1, sums to the number of parameters.
pub(crate) fn leverages(fit: &Fit, x: &DMatrix<f64>) -> Vec<f64> {
    let projected = x * &fit.unit_covariance;
    projected.row_iter().zip(x.row_iter()).map(|(a, b)| a.dot(&b)).collect()
}

/// Part of what all samples tell of each parameter that each of them tells, samples by parameters: `(X C)_ij^2 / C_jj` with
/// `C = (X'X)^-1`. `(X C)_j / C_jj` is the regressor less what the others explain of it; its square over `s^2` is the information of the
/// sample on the parameter with the others free. Each column adds up to one.
pub fn information_shares(fit: &Fit, x: &DMatrix<f64>) -> DMatrix<f64> {
    let mut shares = x * &fit.unit_covariance;
    for (j, mut column) in shares.column_iter_mut().enumerate() {
        let variance = fit.unit_covariance[(j, j)];
        column.iter_mut().for_each(|value| *value = *value * *value / variance);
    }
    shares
}

/// Predicted residual sum of squares `sum (v_i / (1 - h_ii))^2`: what is left when each sample is predicted by a fit to the
/// others.
pub fn press(fit: &Fit, x: &DMatrix<f64>) -> f64 {
    fit.residuals.iter().zip(leverages(fit, x)).map(|(v, h)| (v / (1.0 - h)).powi(2)).sum()
}

/// Predicted squared error `v'v / N + sigma2_max p / N` (Klein and Morelli, "Aircraft System Identification", 5.4): its
/// minimum over model size guards against too many terms. `noise_variance_max`: largest plausible variance of the noise;
/// `None` for that of the measurement, `sum (z - mean z)^2 / N`.
pub fn predicted_squared_error(fit: &Fit, noise_variance_max: Option<f64>) -> f64 {
    let samples = fit.samples() as f64;
    let residual = fit.residuals.iter().map(|v| v * v).sum::<f64>() / samples;
    let largest = noise_variance_max.unwrap_or_else(|| residual / (1.0 - fit.quality.r_squared));
    residual + largest * fit.parameters() as f64 / samples
}

/// Contribution of each term: root mean square of `estimate * (regressor - its mean)` over that of the measurement less
/// its mean. Terms below 0.005 are candidates to drop.
pub fn contributions(fit: &Fit, x: &DMatrix<f64>) -> Vec<f64> {
    let fitted = x * DVector::from_column_slice(&fit.estimates);
    let measured = deviation(fitted.iter().zip(fit.residuals.iter()).map(|(y, v)| y + v));
    let terms = fit.estimates.iter().zip(x.column_iter());
    terms.map(|(estimate, column)| estimate.abs() * deviation(column.iter().copied()) / measured).collect()
}

fn deviation(values: impl Iterator<Item = f64>) -> f64 {
    let values: Vec<f64> = values.collect();
    let mean = values.iter().sum::<f64>() / values.len() as f64;
    (values.iter().map(|value| (value - mean).powi(2)).sum::<f64>() / values.len() as f64).sqrt()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Rounding of sums over a few dozen samples.
    const ROUNDING: f64 = 1e-11;

    /// Names, regressors (constant, wave, mixture) and measurement.
    fn example() -> (Vec<String>, DMatrix<f64>, Vec<f64>) {
        let x = DMatrix::from_fn(40, 3, |row, column| match column {
            0 => 1.0,
            1 => (row as f64 * 0.4).sin(),
            _ => 0.8 * (row as f64 * 0.4).sin() + 0.3 * (row as f64 * 1.3).cos() + 2.0,
        });
        let z = (0..40).map(|k| 1.0 + f64::from(k % 7) * 0.1 + 2.0 * x[(k as usize, 2)]).collect();
        (["1", "a", "b"].map(str::to_owned).to_vec(), x, z)
    }

    #[test]
    fn press_matches_deletion_of_each_sample() {
        let (names, x, z) = example();
        let fit = least_squares(&names, &x, &z).unwrap();
        let mut expected = 0.0;
        for k in 0..40 {
            let mut shorter = z.clone();
            let measured = shorter.remove(k);
            let other = least_squares(&names, &x.clone().remove_row(k), &shorter).unwrap();
            let predicted: f64 = x.row(k).iter().zip(&other.estimates).map(|(x, estimate)| x * estimate).sum();
            expected += (measured - predicted).powi(2);
        }
        approx::assert_relative_eq!(press(&fit, &x), expected, max_relative = ROUNDING);
        approx::assert_relative_eq!(leverages(&fit, &x).iter().sum::<f64>(), 3.0, epsilon = ROUNDING);
    }

    #[test]
    fn information_shares_add_up_to_one_and_say_what_a_stretch_left_out_costs() {
        let (names, x, z) = example();
        let fit = least_squares(&names, &x, &z).unwrap();
        let shares = information_shares(&fit, &x);
        for column in shares.column_iter() {
            approx::assert_relative_eq!(column.sum(), 1.0, epsilon = ROUNDING);
        }
        // Without a sample the variance of a parameter grows as a rank-one update says: by its share over what its leverage leaves.
        let leverage = leverages(&fit, &x);
        for k in [0, 7, 33] {
            let mut shorter = z.clone();
            shorter.remove(k);
            let other = least_squares(&names, &x.clone().remove_row(k), &shorter).unwrap();
            for j in 0..3 {
                let growth = other.unit_covariance[(j, j)] / fit.unit_covariance[(j, j)] - 1.0;
                approx::assert_relative_eq!(growth, shares[(k, j)] / (1.0 - leverage[k]), max_relative = 1e-9);
            }
        }
    }

    #[test]
    fn partial_f_is_the_drop_of_explained_square_over_the_variance() {
        let (names, x, z) = example();
        let full = least_squares(&names, &x, &z).unwrap();
        let without = least_squares(&names[..2], &x.columns(0, 2).into_owned(), &z).unwrap();
        let square = |fit: &Fit| fit.residuals.iter().map(|v| v * v).sum::<f64>();
        let drop = (square(&without) - square(&full)) / full.residual_std.powi(2);
        approx::assert_relative_eq!(partial_f(&full)[2], drop, max_relative = ROUNDING);
    }

    #[test]
    fn inflation_matches_the_correlation_of_two_regressors() {
        let (names, x, _) = example();
        let correlation = regressor_correlation(&x)[(1, 2)];
        let factors = variance_inflation(&names, &x).unwrap();
        assert!(factors[0].is_nan());
        approx::assert_relative_eq!(factors[1], 1.0 / (1.0 - correlation * correlation), max_relative = ROUNDING);
        approx::assert_relative_eq!(factors[2], factors[1], max_relative = ROUNDING);
    }

    #[test]
    fn predicted_squared_error_charges_each_term() {
        let (names, x, z) = example();
        let fit = least_squares(&names, &x, &z).unwrap();
        let mean = z.iter().sum::<f64>() / 40.0;
        let variance = z.iter().map(|z| (z - mean).powi(2)).sum::<f64>() / 40.0;
        approx::assert_relative_eq!(
            predicted_squared_error(&fit, None),
            fit.quality.rms.powi(2) + variance * 3.0 / 40.0,
            max_relative = ROUNDING
        );
        assert!(contributions(&fit, &x)[2] > 0.9 && contributions(&fit, &x)[0] < 1e-12);
    }
}
