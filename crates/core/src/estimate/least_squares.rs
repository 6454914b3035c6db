//! Ordinary least squares.

use nalgebra::DMatrix;

use super::triangle::Triangle;
use super::{EstimateError, Fit};

/// Ordinary least squares `theta = argmin |z - X theta|^2` (thesis Eq. 3.15-3.19), by orthogonal triangularisation of
/// `[X z]`, never through the normal equations.
///
/// `names`: p names of the parameters; `x`: n by p regressors; `z`: n measurements. The covariance supposes white residuals
/// of constant variance.
///
/// # Errors
/// Sizes that differ, values that are not finite, fewer than p + 1 samples, and regressors that depend on each other,
/// named.
pub fn least_squares(names: &[String], x: &DMatrix<f64>, z: &[f64]) -> Result<Fit, EstimateError> {
    check(names, x, z)?;
    let solution = Triangle::reduce(x, z).solve(names)?;
    let fitted = x * &solution.estimates;
    Ok(Fit::assemble(names, z, fitted.as_slice(), solution))
}

/// Checks sizes and values of a regression.
pub(super) fn check(names: &[String], x: &DMatrix<f64>, z: &[f64]) -> Result<(), EstimateError> {
    check_values(names, x, z)?;
    if z.len() <= names.len() {
        return Err(EstimateError::TooFewSamples { samples: z.len(), parameters: names.len() });
    }
    Ok(())
}

/// Checks sizes and values of some rows of a regression.
pub(super) fn check_values(names: &[String], x: &DMatrix<f64>, z: &[f64]) -> Result<(), EstimateError> {
    if names.is_empty() {
        return Err(EstimateError::NoParameters);
    }
    if x.ncols() != names.len() {
        return Err(EstimateError::Size { quantity: "regressors", expected: names.len(), found: x.ncols() });
    }
    if x.nrows() != z.len() {
        return Err(EstimateError::Size { quantity: "rows of the regressors", expected: z.len(), found: x.nrows() });
    }
    for (name, column) in names.iter().zip(x.column_iter()) {
        if let Some(sample) = column.iter().position(|value| !value.is_finite()) {
            return Err(EstimateError::NotFinite { name: name.clone(), sample });
        }
    }
    match z.iter().position(|value| !value.is_finite()) {
        Some(sample) => Err(EstimateError::NotFinite { name: "measurement".to_owned(), sample }),
        None => Ok(()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Names `a`, `b`, `c`, ...
    fn letters(count: usize) -> Vec<String> {
        ('a'..).take(count).map(String::from).collect()
    }

    #[test]
    fn line_through_points_matches_textbook_answer() {
        // y = 1 + 2 x with residuals 1 -1 -1 1: slope 2, intercept 1, s^2 = 4/2, Sxx = 5.
        let x = DMatrix::from_fn(4, 2, |row, column| if column == 0 { 1.0 } else { row as f64 });
        let fit = least_squares(&letters(2), &x, &[2.0, 2.0, 4.0, 8.0]).unwrap();
        approx::assert_relative_eq!(fit.estimates[0], 1.0, epsilon = 1e-14);
        approx::assert_relative_eq!(fit.estimates[1], 2.0, epsilon = 1e-14);
        approx::assert_relative_eq!(fit.residual_std, 2.0_f64.sqrt(), epsilon = 1e-14);
        approx::assert_relative_eq!(fit.standard_errors[1], (2.0_f64 / 5.0).sqrt(), epsilon = 1e-14);
        approx::assert_relative_eq!(fit.standard_errors[0], (2.0_f64 * (0.25 + 2.25 / 5.0)).sqrt(), epsilon = 1e-14);
        approx::assert_relative_eq!(fit.quality.r_squared, 1.0 - 4.0 / 24.0, epsilon = 1e-14);
        approx::assert_relative_eq!(fit.quality.rms_relative_percent, 100.0 / 8.0, epsilon = 1e-12);
        approx::assert_relative_eq!(fit.correlation[(0, 1)], -1.5 / 3.5_f64.sqrt(), epsilon = 1e-14);
    }

    #[test]
    fn dependent_regressors_are_rejected_by_name() {
        let mut x = DMatrix::from_fn(600, 5, |row, column| ((row * (column + 1)) as f64 * 0.37).sin());
        x.column_mut(0).fill(1.0);
        x.column_mut(2).fill(0.0311);
        let blend = x.column(1) * 4e-6 - x.column(3) * 7e3;
        x.set_column(4, &blend);
        let error = least_squares(&letters(5), &x, &vec![1.0; 600]).unwrap_err();
        assert_eq!(
            error.to_string(),
            "the regressors have rank 3 of 5: 'c' depends on 'a', 'e' depends on 'd'; \
             remove terms or add manoeuvres that excite them"
        );
        x.column_mut(4).fill(0.0);
        let error = least_squares(&letters(5), &x, &vec![1.0; 600]).unwrap_err();
        assert!(error.to_string().contains("'e' is zero throughout"), "{error}");
    }

    #[test]
    fn bad_input_is_rejected() {
        let x = DMatrix::from_fn(3, 2, |row, column| (row + column) as f64);
        let names = letters(2);
        assert!(matches!(least_squares(&names, &x, &[0.0; 4]), Err(EstimateError::Size { .. })));
        assert!(matches!(least_squares(&letters(3), &x, &[0.0; 3]), Err(EstimateError::Size { .. })));
        assert_eq!(
            least_squares(&letters(2), &x.rows(0, 2).into_owned(), &[0.0; 2]),
            Err(EstimateError::TooFewSamples { samples: 2, parameters: 2 })
        );
        assert_eq!(
            least_squares(&names, &x, &[0.0, f64::NAN, 0.0]),
            Err(EstimateError::NotFinite { name: "measurement".to_owned(), sample: 1 })
        );
        assert_eq!(least_squares(&[], &DMatrix::zeros(3, 0), &[0.0; 3]), Err(EstimateError::NoParameters));
    }
}
