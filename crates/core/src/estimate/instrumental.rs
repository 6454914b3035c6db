//! Instrumental variables: derivatives of an aircraft that something unrecorded moves as well.

use std::ops::Range;

use nalgebra::{DMatrix, DVector};

use super::covariance::{Coloured, coloured_covariance_within};
use super::least_squares::check;
use super::triangle::{Solution, Triangle};
use super::{EstimateError, Fit};

/// Filters of each input, and how much faster each is than the one before.
const FILTERS: i32 = 5;
const FASTER: f64 = 2.0;
/// Time constant of the slowest filter, part of the usual window.
const SLOWEST: f64 = 0.25;
/// Part of an instrument outside the ones before it below which it is one of them.
const DEPENDENT: f64 = 1e-6;

/// An estimate by instrumental variables.
#[derive(Clone, Debug, PartialEq)]
pub struct InstrumentalFit {
    /// The fit; residuals are `z - X theta`.
    pub fit: Fit,
    /// `X - k M X`, which the residuals are orthogonal to, n by p.
    projected: DMatrix<f64>,
}

impl InstrumentalFit {
    /// Covariance for correlated residuals, whose products are taken inside each of `windows` only: `D M D` of
    /// [`super::coloured_covariance`] with `X - k M X` for the regressors and `D = (X'(I - k M) X)^-1`.
    pub fn coloured_covariance(
        &self,
        windows: &[Range<usize>],
        settings: &Coloured,
    ) -> Result<DMatrix<f64>, EstimateError> {
        let Self { fit, projected } = self;
        let triangle = Triangle::reduce(projected, &fit.residuals);
        let unit_covariance = triangle.solve(&fit.names)?.unit_covariance;
        let products = unit_covariance.clone().try_inverse().ok_or(NOT_INVERTIBLE)?;
        let of_projected = Fit { unit_covariance, ..fit.clone() };
        let covariance = coloured_covariance_within(&of_projected, (projected, &fit.residuals), windows, settings)?;
        let weight = &fit.unit_covariance * products;
        Ok(&weight * covariance * weight.transpose())
    }
}

const NEEDED: &str = "at least one per regressor other than inputs: move the controls";
const NOT_INVERTIBLE: EstimateError =
    EstimateError::NotConverged { method: "the inversion of the instruments' products", iterations: 1 };

/// Estimates of `z = X theta + v` whose residual `v` is correlated with the regressors, as gusts make it that no vane shows: the
/// aircraft follows the gust, so that the part of `alpha` known from the path answers the moment that the gust makes, and least
/// squares takes that for a small `Cm_alpha`.
///
/// What the controls do is not correlated with gusts. Instruments are therefore the regressors flagged in `is_input` (controls and
/// constants) and the controls behind first-order filters `1 / (tau s + 1)` with five time constants from a quarter of the median
/// window down, each half the one before. With `P` the projection on them and `M = I - P`, the estimate of limited-information
/// maximum likelihood is
///
/// `theta = (X'(I - k M) X)^-1 X'(I - k M) z`, `k = min eig((W'M W)^-1 W'M_1 W)`, `W = [z X_2]`
///
/// with `X_2` the regressors that are no inputs and `M_1` the residual maker of the inputs alone (Anderson and Rubin, Annals of
/// Mathematical Statistics 20, 1949; Soderstrom and Stoica, "Instrumental Variable Methods for System Identification", 1983). Where
/// the controls move the aircraft little, errors grow, and the estimate does not go toward that of least squares.
///
/// `names`: p parameters; `x`: n by p; `z`: n; `windows`: the rows of each window, of one step `step_s`. The covariance is
/// `s^2 (X'(I - k M) X)^-1` and supposes white residuals.
///
/// # Errors
/// As for [`super::least_squares`], and controls that do not move enough for the regressors there are.
pub fn instrumental_variables(
    (names, x, z): (&[String], &DMatrix<f64>, &[f64]),
    is_input: &[bool],
    windows: &[Range<usize>],
    step_s: f64,
) -> Result<InstrumentalFit, EstimateError> {
    check(names, x, z)?;
    if is_input.len() != names.len() {
        return Err(EstimateError::Size { quantity: "input flags", expected: names.len(), found: is_input.len() });
    }
    if !(step_s > 0.0 && step_s.is_finite()) {
        let (setting, allowed) = ("sample step".to_owned(), "positive and finite");
        return Err(EstimateError::Setting { setting, value: step_s, allowed });
    }
    let inputs: Vec<usize> = (0..names.len()).filter(|&column| is_input[column]).collect();
    let others: Vec<usize> = (0..names.len()).filter(|&column| !is_input[column]).collect();
    let mut basis = Vec::new();
    for &column in &inputs {
        extend(&mut basis, x.column(column).into_owned());
    }
    let own = basis.len();
    for &column in &inputs {
        filtered(&x.column(column).into_owned(), windows, step_s).into_iter().for_each(|one| extend(&mut basis, one));
    }
    let instruments = basis.len() - own;
    if instruments < others.len() {
        let (setting, allowed) = ("number of instruments".to_owned(), NEEDED);
        return Err(EstimateError::Setting { setting, value: instruments as f64, allowed });
    }
    let mut endogenous = DMatrix::zeros(z.len(), others.len() + 1);
    endogenous.column_mut(0).copy_from_slice(z);
    for (place, &column) in others.iter().enumerate() {
        endogenous.set_column(place + 1, &x.column(column));
    }
    let outside = without(&endogenous, &basis);
    let k = smallest_ratio(&without(&endogenous, &basis[..own]), &outside);
    let mut projected = x.clone();
    for (place, &column) in others.iter().enumerate() {
        projected.column_mut(column).axpy(-k, &outside.column(place + 1), 1.0);
    }
    solve((names, x, z), projected)
}

/// The fit whose residuals are orthogonal to `projected`.
fn solve(
    (names, x, z): (&[String], &DMatrix<f64>, &[f64]),
    projected: DMatrix<f64>,
) -> Result<InstrumentalFit, EstimateError> {
    let condition_number = Triangle::reduce(&projected, z).solve(names)?.condition_number;
    let scale = DVector::from_iterator(names.len(), projected.column_iter().map(|column| column.norm().recip()));
    let normal = projected.tr_mul(x);
    let scaled = DMatrix::from_fn(names.len(), names.len(), |i, j| {
        0.5 * (normal[(i, j)] + normal[(j, i)]) * scale[i] * scale[j]
    });
    let inverse = scaled.try_inverse().ok_or(NOT_INVERTIBLE)?;
    let unit_covariance = DMatrix::from_fn(names.len(), names.len(), |i, j| inverse[(i, j)] * scale[i] * scale[j]);
    let estimates = &unit_covariance * projected.tr_mul(&DVector::from_column_slice(z));
    let fitted = x * &estimates;
    let fit = Fit::assemble(names, z, fitted.as_slice(), Solution { estimates, unit_covariance, condition_number });
    Ok(InstrumentalFit { fit, projected })
}

/// Takes `column` into an orthonormal basis, unless it is made of what is there.
fn extend(basis: &mut Vec<DVector<f64>>, mut column: DVector<f64>) {
    let size = column.norm();
    for _ in 0..2 {
        for one in basis.iter() {
            let part = one.dot(&column);
            column.axpy(-part, one, 1.0);
        }
    }
    let norm = column.norm();
    if norm > DEPENDENT * size {
        basis.push(column / norm);
    }
}

/// The columns less their parts along an orthonormal basis.
fn without(columns: &DMatrix<f64>, basis: &[DVector<f64>]) -> DMatrix<f64> {
    let mut rest = columns.clone();
    for one in basis {
        let parts = rest.tr_mul(one);
        for (mut column, part) in rest.column_iter_mut().zip(parts.iter()) {
            column.axpy(-part, one, 1.0);
        }
    }
    rest
}

/// Smallest eigenvalue of `(B'B)^-1 A'A`; one where `B` leaves nothing of some column, as an exact fit does.
fn smallest_ratio(above: &DMatrix<f64>, below: &DMatrix<f64>) -> f64 {
    let scale = DVector::from_iterator(above.ncols(), above.column_iter().map(|column| column.norm().recip()));
    let product = |columns: &DMatrix<f64>| {
        let square = columns.tr_mul(columns);
        DMatrix::from_fn(square.nrows(), square.ncols(), |i, j| square[(i, j)] * scale[i] * scale[j])
    };
    let Some(factor) = product(below).cholesky() else { return 1.0 };
    let Some(left) = factor.l().solve_lower_triangular(&product(above)) else { return 1.0 };
    let Some(both) = factor.l().solve_lower_triangular(&left.transpose()) else { return 1.0 };
    let ratio = both.symmetric_eigenvalues().min();
    if ratio.is_finite() { ratio.max(1.0) } else { 1.0 }
}

/// An input behind each filter, at rest at the start of each window.
fn filtered(input: &DVector<f64>, windows: &[Range<usize>], step_s: f64) -> Vec<DVector<f64>> {
    let mut lengths: Vec<f64> = windows.iter().map(|window| window.len() as f64).collect();
    let length_s = crate::statistics::median(&mut lengths).unwrap_or(0.0) * step_s;
    let behind = |filter: i32| {
        let kept = (-step_s * FASTER.powi(filter) / (SLOWEST * length_s)).exp();
        let mut output = DVector::zeros(input.len());
        for window in windows {
            let mut state = 0.0;
            for sample in window.clone() {
                state = kept * state + (1.0 - kept) * (input[sample] - input[window.start]);
                output[sample] = state;
            }
        }
        output
    };
    (0..FILTERS).map(behind).collect()
}
