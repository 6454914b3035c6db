//! Triangular factor of a regression, built from blocks of rows.

use std::ops::SubAssign;

use nalgebra::{DMatrix, DVector, RowDVector};

use super::error::{Dependence, EstimateError};

/// Remaining norm of a regressor, as a fraction of its own, below which it counts as dependent on the ones before it.
/// Rounding leaves about 1e-15; beyond 1e-10 the squared condition number exceeds what double precision resolves.
const DEPENDENCE_TOLERANCE: f64 = 1e-10;
/// Share of a regressor, scaled to unit norm, in a dependence below which it is not named.
const SHARE_TOLERANCE: f64 = 1e-6;
/// Rows reduced at a time: a block of a dozen columns stays in the first-level cache.
const BLOCK_ROWS: usize = 256;

/// Upper triangle `R` of `[X z] = Q R` with orthonormal `Q`: all that the estimate, its covariance and the residual sum of
/// squares need of the samples. Triangles of several windows stack into that of all of them.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Triangle {
    /// Upper triangular, one more column than there are regressors.
    factor: DMatrix<f64>,
}

/// Solution of the least-squares problem of a triangle.
pub(super) struct Solution {
    pub estimates: DVector<f64>,
    /// `(X'X)^-1`.
    pub unit_covariance: DMatrix<f64>,
    /// Ratio of the largest to the smallest singular value of `X` with columns scaled to unit norm.
    pub condition_number: f64,
}

impl Triangle {
    /// Triangle of `[X z]`.
    pub fn reduce(x: &DMatrix<f64>, z: &[f64]) -> Self {
        let columns = x.ncols() + 1;
        let mut factor = DMatrix::zeros(0, columns);
        let mut start = 0;
        while start < x.nrows() {
            let rows = BLOCK_ROWS.min(x.nrows() - start);
            let kept = factor.nrows();
            let mut block = DMatrix::zeros(kept + rows, columns);
            block.view_mut((0, 0), (kept, columns)).copy_from(&factor);
            block.view_mut((kept, 0), (rows, x.ncols())).copy_from(&x.rows(start, rows));
            for (k, value) in z[start..start + rows].iter().enumerate() {
                block[(kept + k, columns - 1)] = *value;
            }
            factor = block.qr().r();
            start += rows;
        }
        Self { factor }
    }

    /// Triangle of `parameters` regressors before the first sample.
    pub fn empty(parameters: usize) -> Self {
        Self { factor: DMatrix::zeros(parameters + 1, parameters + 1) }
    }

    /// Takes in one more row `[x z]` after all rows before it were multiplied by `fade`, by plane rotations: O(p^2).
    pub fn append(&mut self, row: &mut [f64], fade: f64) {
        self.factor *= fade;
        for k in 0..row.len().min(self.factor.ncols()) {
            let (diagonal, entry) = (self.factor[(k, k)], row[k]);
            if entry == 0.0 {
                continue;
            }
            let norm = diagonal.hypot(entry);
            let (cos, sin) = (diagonal / norm, entry / norm);
            for (j, value) in row.iter_mut().enumerate().skip(k) {
                let above = self.factor[(k, j)];
                self.factor[(k, j)] = cos * above + sin * *value;
                *value = cos * *value - sin * above;
            }
        }
    }

    /// Triangle with the regressors `columns` only, in that order.
    pub(crate) fn subset(&self, columns: &[usize]) -> Self {
        let z = self.parameters();
        let kept: Vec<usize> = columns.iter().copied().chain(std::iter::once(z)).collect();
        Self { factor: self.factor.select_columns(&kept).qr().r() }
    }

    /// Triangle after the regressors have been given the values `values`: the measurement less their part.
    pub fn less(&self, values: &DVector<f64>) -> Self {
        let mut factor = self.factor.clone();
        let z = self.parameters();
        let part = factor.columns(0, z) * values;
        factor.column_mut(z).sub_assign(&part);
        Self { factor }
    }

    /// Triangle with further rows, each a weight, a regressor and the value it should have.
    pub(crate) fn with_rows(&self, rows: &[(f64, usize, f64)]) -> Self {
        let mut factor = self.factor.clone().resize_vertically(self.factor.nrows() + rows.len(), 0.0);
        for (index, &(weight, column, value)) in rows.iter().enumerate() {
            let row = self.factor.nrows() + index;
            factor[(row, column)] = weight;
            factor[(row, self.parameters())] = weight * value;
        }
        Self { factor: factor.qr().r() }
    }

    /// Sum of squared residuals of the least-squares fit.
    pub(crate) fn residual_square(&self) -> f64 {
        let p = self.parameters();
        if self.factor.nrows() <= p { 0.0 } else { self.factor[(p, p)].powi(2) }
    }

    /// Upper triangle of the regressors and the measurement, scaled by nothing.
    pub fn factor(&self) -> &DMatrix<f64> {
        &self.factor
    }

    /// Number of regressors.
    fn parameters(&self) -> usize {
        self.factor.ncols() - 1
    }

    /// Upper triangle of the regressors with columns scaled to unit norm, and the norms.
    fn scaled(&self) -> (DMatrix<f64>, DVector<f64>) {
        let p = self.parameters();
        let mut regressors = self.factor.columns(0, p).into_owned().resize_vertically(p, 0.0);
        let norms = DVector::from_iterator(p, self.factor.columns(0, p).column_iter().map(|column| column.norm()));
        for (mut column, &norm) in regressors.column_iter_mut().zip(norms.iter()) {
            if norm > 0.0 {
                column /= norm;
            }
        }
        (regressors, norms)
    }

    /// Triangle of the rows of several triangles, each with the columns of the whole that its own stand for.
    pub fn stack<'a>(parts: impl Iterator<Item = (&'a Self, &'a [usize])>, parameters: usize) -> Self {
        let mut rows = Vec::new();
        for (part, columns) in parts {
            for row in part.factor.row_iter() {
                let mut full = RowDVector::zeros(parameters + 1);
                for (value, &column) in row.iter().zip(columns.iter().chain(std::iter::once(&parameters))) {
                    full[column] = *value;
                }
                rows.push(full);
            }
        }
        Self { factor: DMatrix::from_rows(&rows).qr().r() }
    }

    /// Estimates, `(X'X)^-1` and condition number.
    ///
    /// # Errors
    /// [`EstimateError::RankDeficient`] names the regressors that depend on those before them.
    pub fn solve(&self, names: &[String]) -> Result<Solution, EstimateError> {
        let p = self.parameters();
        let (scaled, norms) = self.scaled();
        let dependent = dependences(&scaled, names);
        if !dependent.is_empty() {
            return Err(EstimateError::RankDeficient { rank: p - dependent.len(), parameters: p, dependent });
        }
        let singular = scaled.clone().singular_values();
        let mut estimates = self.factor.view((0, p), (p, 1)).column(0).into_owned();
        let mut inverse = DMatrix::identity(p, p);
        // No diagonal entry is zero: the columns were just found independent.
        scaled.solve_upper_triangular_mut(&mut estimates);
        scaled.solve_upper_triangular_mut(&mut inverse);
        let mut unit_covariance = &inverse * inverse.transpose();
        for i in 0..p {
            estimates[i] /= norms[i];
            for j in 0..p {
                unit_covariance[(i, j)] /= norms[i] * norms[j];
            }
        }
        Ok(Solution { estimates, unit_covariance, condition_number: singular.max() / singular.min() })
    }
}

/// Columns of `scaled` (unit norm or zero) that are sums of the columns before them, by Gram-Schmidt with one
/// re-orthogonalisation.
fn dependences(scaled: &DMatrix<f64>, names: &[String]) -> Vec<Dependence> {
    let p = scaled.ncols();
    let mut basis = DMatrix::zeros(p, 0);
    let mut shares = DMatrix::zeros(0, 0);
    let mut kept: Vec<usize> = Vec::new();
    let mut dependent = Vec::new();
    for j in 0..p {
        let column = scaled.column(j);
        let mut rest = column.into_owned();
        let mut along = DVector::zeros(kept.len());
        for _ in 0..2 {
            let part = basis.tr_mul(&rest);
            rest -= &basis * &part;
            along += part;
        }
        let norm = rest.norm();
        if norm > DEPENDENCE_TOLERANCE {
            let size = kept.len();
            basis = basis.insert_column(size, 0.0);
            basis.set_column(size, &(rest / norm));
            shares = DMatrix::resize(shares, size + 1, size + 1, 0.0);
            shares.view_mut((0, size), (size, 1)).copy_from(&along);
            shares[(size, size)] = norm;
            kept.push(j);
        } else {
            shares.solve_upper_triangular_mut(&mut along);
            let on = kept.iter().zip(along.iter()).filter(|(_, share)| share.abs() > SHARE_TOLERANCE);
            dependent
                .push(Dependence { name: names[j].clone(), on: on.map(|(&index, _)| names[index].clone()).collect() });
        }
    }
    dependent
}
