//! Correlation of the estimates of all coefficients together.

use doublet_core::model::{Term, regressors};
use doublet_core::statistics::median_step;
use nalgebra::{DMatrix, DVector};

use crate::export::IdentifiedCoefficient;
use crate::stage::{AeroWindow, CoefficientFit};

/// Time over which the errors of an estimate are taken as correlated, s.
const MEMORY_S: f64 = 2.0;

/// Correlation of all parameters of these coefficients, in their order. The error of least squares is the sum over the samples of
/// `(X'X)^-1 x(k) e(k)`; its covariance, within and across coefficients, is that of these sums with the residuals as they are, correlated in
/// time and with each other: the estimator of Newey and West (1987) with Bartlett's weights over two seconds, window by window. A
/// mean of constants, one per window, has what its windows' mean residuals and the other parameters leave it.
///
/// None where a coefficient's regressors cannot be had again.
pub(super) fn correlation(
    fits: &[(&CoefficientFit, &IdentifiedCoefficient)],
    windows: &[AeroWindow<'_>],
) -> Option<DMatrix<f64>> {
    let sizes: Vec<usize> = fits.iter().map(|(_, coefficient)| coefficient.parameters.len()).collect();
    let size: usize = sizes.iter().sum();
    let scores = fits.iter().map(|(fit, coefficient)| scores(fit, coefficient, windows)).collect::<Option<Vec<_>>>()?;
    let mut covariance = DMatrix::zeros(size, size);
    for (manoeuvre, aero) in windows {
        let of_window = |scores: &Vec<(String, DMatrix<f64>)>| {
            scores.iter().find(|(name, _)| *name == manoeuvre.name).map(|(_, matrix)| matrix.clone())
        };
        let found: Vec<Option<DMatrix<f64>>> = scores.iter().map(of_window).collect();
        let Some(samples) = found.iter().flatten().map(DMatrix::ncols).next() else { continue };
        let mut together = DMatrix::zeros(size, samples);
        let mut row = 0;
        for (matrix, rows) in found.iter().zip(&sizes) {
            if let Some(matrix) = matrix.as_ref().filter(|matrix| matrix.ncols() == samples) {
                together.view_mut((row, 0), matrix.shape()).copy_from(matrix);
            }
            row += rows;
        }
        let step_s = median_step(&aero.data.time_s)?;
        covariance += long_run(&together, (MEMORY_S / step_s).round() as usize);
    }
    let sigma = DVector::from_fn(size, |index, _| f64::sqrt(covariance[(index, index)]));
    Some(DMatrix::from_fn(size, size, |i, j| {
        let scale = sigma[i] * sigma[j];
        if i == j {
            1.0
        } else if scale > 0.0 {
            covariance[(i, j)] / scale
        } else {
            0.0
        }
    }))
}

/// Covariance of the sum of the columns with Bartlett's weights over `lags`: the mean outer product of moving sums of that length.
fn long_run(scores: &DMatrix<f64>, lags: usize) -> DMatrix<f64> {
    let (rows, samples) = scores.shape();
    let length = lags + 1;
    let mut sums = DMatrix::zeros(rows, samples + lags);
    let mut sum = DVector::zeros(rows);
    for column in 0..samples + lags {
        if column < samples {
            sum += scores.column(column);
        }
        if column >= length {
            sum -= scores.column(column - length);
        }
        sums.set_column(column, &sum);
    }
    &sums * sums.transpose() / length as f64
}

/// What each sample of each window adds to the error of each parameter of a coefficient.
fn scores(
    fit: &CoefficientFit,
    coefficient: &IdentifiedCoefficient,
    windows: &[AeroWindow<'_>],
) -> Option<Vec<(String, DMatrix<f64>)>> {
    let parameters = &coefficient.parameters;
    // A derivative without error was not estimated; a mean constant follows from the others.
    let mean = |term: &Term| term.is_constant() && coefficient.mean_constant;
    let estimated = |index: &usize| parameters[*index].standard_error > 0.0 && !mean(&parameters[*index].term);
    let places: Vec<usize> = (0..parameters.len()).filter(estimated).collect();
    let terms: Vec<Term> = places.iter().map(|&place| parameters[place].term.clone()).collect();
    let total: usize = fit.windows.iter().map(|(_, samples)| samples).sum();
    let mut parts = Vec::new();
    let mut information = DMatrix::zeros(terms.len(), terms.len());
    let mut middle = DVector::zeros(terms.len());
    for ((name, _), (_, residual)) in fit.windows.iter().zip(&fit.series) {
        let (_, aero) = windows.iter().find(|(manoeuvre, _)| manoeuvre.name == *name)?;
        let mut x = regressors(&terms, &aero.variables).ok()?;
        if x.nrows() != residual.values.len() {
            return None;
        }
        if coefficient.mean_constant {
            let means = DVector::from_iterator(x.ncols(), x.column_iter().map(|column| column.mean()));
            x.column_iter_mut().zip(means.iter()).for_each(|(mut column, mean)| column.add_scalar_mut(-mean));
            middle += means * (x.nrows() as f64 / total as f64);
        }
        information += x.tr_mul(&x);
        parts.push((name.clone(), x, residual.values.clone()));
    }
    let inverse = information.cholesky()?.inverse();
    let constant = parameters.iter().position(|parameter| mean(&parameter.term));
    let score = |(name, x, residual): (String, DMatrix<f64>, std::sync::Arc<[f64]>)| {
        let residual = DVector::from_column_slice(&residual);
        let mut own = &inverse * x.transpose();
        own.column_iter_mut().zip(residual.iter()).for_each(|(mut column, residual)| column *= *residual);
        let mut all = DMatrix::zeros(parameters.len(), residual.len());
        for (row, &place) in places.iter().enumerate() {
            all.set_row(place, &own.row(row));
        }
        if let Some(place) = constant {
            all.set_row(place, &(residual.transpose() / total as f64 - middle.transpose() * &own));
        }
        (name, all)
    };
    Some(parts.into_iter().map(score).collect())
}
