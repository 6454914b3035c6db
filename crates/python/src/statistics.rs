//! Least squares and the covariance of its estimates for residuals that are not white, of arrays.

use std::ops::Range;

use doublet_core::estimate::{
    Coloured, Constraint, EstimateError, Fit, FitQuality, OrthogonalSettings, PooledRegression, PooledWindow,
    StepwiseSettings, coloured_covariance as covariance_of, generalised_least_squares, least_squares, orthogonal,
    stepwise, weighted_coloured_covariance, weighted_least_squares,
};
use doublet_engine::stage::describe_origin;
use nalgebra::{DMatrix, DVector};
use numpy::{PyArray2, PyReadonlyArray1, PyReadonlyArray2};
use pyo3::prelude::*;
use pyo3::types::PyDict;

use crate::attend::{detached, refuse};
use crate::columns::{matrix, owned, slice, to_matrix};
use crate::fits::constraint;

/// Columns that stay, by the way they are chosen.
fn chosen(names: &[String], x: &DMatrix<f64>, z: &[f64], method: &str) -> Result<Vec<usize>, String> {
    let forced: Vec<usize> =
        (0..names.len()).filter(|&index| x.column(index).iter().all(|&value| value == 1.0)).collect();
    let text = |error: EstimateError| error.to_string();
    match method {
        "ols" | "gls" => Ok((0..names.len()).collect()),
        "stepwise" => Ok(stepwise(names, x, z, &forced, &StepwiseSettings::default()).map_err(text)?.selected),
        "orthogonal" => Ok(orthogonal(names, x, z, &forced, &OrthogonalSettings::default()).map_err(text)?.selected),
        other => Err(format!("'{other}' is not a method: use ols, gls, stepwise or orthogonal")),
    }
}

/// Ends of the stretches of rows of one group.
fn stretches(groups: &[i64]) -> Vec<Range<usize>> {
    let mut found: Vec<Range<usize>> = Vec::new();
    for (row, group) in groups.iter().enumerate() {
        match found.last_mut() {
            Some(last) if groups[last.start] == *group => last.end = row + 1,
            _ => found.push(row..row + 1),
        }
    }
    found
}

/// A fit of a measurement, and the covariance of its estimates for correlated residuals.
type Both = (Fit, DMatrix<f64>);

/// How rows count.
enum Weighing {
    /// All alike.
    Equal,
    /// By the standard deviation of each: weights.
    Given(Vec<f64>),
    /// Large residuals less (Huber).
    Huber,
    /// By an autoregression of the residuals, of this order.
    Autoregression(usize),
}

impl Weighing {
    fn new(method: &str, order: usize, is_huber: bool, deviations: Option<&[f64]>) -> PyResult<Self> {
        match (method == "gls", is_huber, deviations) {
            (false, false, None) => Ok(Self::Equal),
            (false, false, Some(deviations)) => {
                Ok(Self::Given(deviations.iter().map(|deviation| deviation.powi(-2)).collect()))
            }
            (false, true, None) => Ok(Self::Huber),
            (true, false, None) => Ok(Self::Autoregression(order)),
            _ => Err(refuse("method gls, Huber's weights and std exclude each other: give one of them")),
        }
    }
}

/// Regressors of records, rows of a record together.
struct Records<'a> {
    names: &'a [String],
    x: &'a DMatrix<f64>,
    z: &'a [f64],
    rows: &'a [Range<usize>],
}

impl Records<'_> {
    fn fit(&self, weighing: &Weighing, constraints: Vec<Constraint>) -> Result<Both, EstimateError> {
        let (Self { names, x, z, rows }, settings) = (self, Coloured::default());
        match weighing {
            Weighing::Given(weights) => {
                let fit = weighted_least_squares(names, x, z, weights)?;
                let covariance = weighted_coloured_covariance(&fit, x, weights, rows, &settings)?;
                Ok((fit, covariance))
            }
            Weighing::Autoregression(order) => {
                let found = generalised_least_squares(names, x, z, rows, *order)?;
                let covariance = found.coloured_covariance(x, rows, &settings)?;
                Ok((found.fit, covariance))
            }
            Weighing::Huber => self.pooled(&self.regression(constraints).with_pseudo_values()?),
            Weighing::Equal if rows.len() == 1 && constraints.is_empty() => {
                let fit = least_squares(names, x, z)?;
                let covariance = covariance_of(&fit, x, &settings)?;
                Ok((fit, covariance))
            }
            Weighing::Equal => self.pooled(&self.regression(constraints)),
        }
    }

    fn regression(&self, constraints: Vec<Constraint>) -> PooledRegression {
        let window = |(index, rows): (usize, &Range<usize>)| PooledWindow {
            label: index.to_string(),
            x: self.x.rows(rows.start, rows.len()).into_owned(),
            z: self.z[rows.clone()].to_vec(),
        };
        let windows = self.rows.iter().enumerate().map(window).collect();
        PooledRegression { names: self.names.to_vec(), per_window: vec![false; self.names.len()], constraints, windows }
    }

    /// The fit of a regression of these rows; of pseudo-values too its residuals are those of the measurement.
    fn pooled(&self, regression: &PooledRegression) -> Result<Both, EstimateError> {
        let pooled = regression.fit()?;
        let covariance = pooled.coloured_covariance(&regression.windows, &Coloured::default())?;
        Ok((pooled.fit, covariance))
    }
}

/// Least squares of `y` on the columns of `x`, with errors for white and for correlated residuals.
#[pyfunction]
#[allow(clippy::too_many_arguments, reason = "what the Python function has by name")]
pub fn lstsq<'py>(
    py: Python<'py>,
    x: PyReadonlyArray2<'py, f64>,
    y: PyReadonlyArray1<'py, f64>,
    names: Vec<String>,
    groups: Option<Vec<i64>>,
    deviations: Option<PyReadonlyArray1<'py, f64>>,
    method: &str,
    order: usize,
    is_huber: bool,
    given: Vec<(String, String, f64, f64)>,
) -> PyResult<Bound<'py, PyDict>> {
    let (x, z) = (to_matrix(&x), slice("y", &y)?);
    if groups.as_ref().is_some_and(|groups| groups.len() != z.len()) {
        return Err(refuse("groups has another number of entries than y: give one per row"));
    }
    let deviations = deviations.as_ref().map(|deviations| slice("deviations", deviations)).transpose()?;
    let weighing = Weighing::new(method, order, is_huber, deviations)?;
    if matches!(weighing, Weighing::Given(_) | Weighing::Autoregression(_)) && !given.is_empty() {
        return Err(refuse("constraints cannot be combined with std or method gls: leave one out"));
    }
    let chosen = detached(py, "choice of columns", || chosen(&names, &x, z, method))?;
    let x = x.select_columns(&chosen);
    let kept: Vec<String> = chosen.iter().map(|&index| names[index].clone()).collect();
    let constraints = constraints(&kept, given)?;
    let rows = groups.as_deref().map_or_else(|| std::iter::once(0..z.len()).collect(), stretches);
    let records = Records { names: &kept, x: &x, z, rows: &rows };
    let (fit, covariance) = detached(py, "least squares", || records.fit(&weighing, constraints))?;
    described(py, &fit, (&x, z), &covariance)
}

/// Constraints of the columns that were chosen; none where none is given.
fn constraints(kept: &[String], given: Vec<(String, String, f64, f64)>) -> PyResult<Vec<Constraint>> {
    if given.is_empty() {
        return Ok(Vec::new());
    }
    let mut constraints = vec![Constraint::Free; kept.len()];
    for (name, kind, first, second) in given {
        let at = kept.iter().position(|known| *known == name);
        let at = at.ok_or_else(|| refuse(format!("no column is called '{name}': there are {}", kept.join(", "))))?;
        constraints[at] = constraint(&kind, first, second)?;
    }
    Ok(constraints)
}

/// A fit as Python takes it: fitted values, residuals and R2 are those of the measurement, of pseudo-values too.
fn described<'py>(
    py: Python<'py>,
    fit: &Fit,
    (x, z): (&DMatrix<f64>, &[f64]),
    covariance: &DMatrix<f64>,
) -> PyResult<Bound<'py, PyDict>> {
    let fitted: Vec<f64> = (x * DVector::from_column_slice(&fit.estimates)).iter().copied().collect();
    let residuals: Vec<f64> = z.iter().zip(&fitted).map(|(z, fitted)| z - fitted).collect();
    let all = PyDict::new(py);
    all.set_item("names", &fit.names)?;
    all.set_item("estimates", owned(py, fit.estimates.clone()))?;
    all.set_item("white", matrix(py, &fit.covariance))?;
    all.set_item("coloured", matrix(py, covariance))?;
    all.set_item("correlation", matrix(py, &fit.correlation))?;
    all.set_item("held", fit.origins.iter().map(|&origin| describe_origin(origin)).collect::<Vec<_>>())?;
    all.set_item("r2", FitQuality::compare(z, &fitted).r_squared)?;
    all.set_item("residuals", owned(py, residuals))?;
    all.set_item("fitted", owned(py, fitted))?;
    all.set_item("residual_std", fit.residual_std)?;
    all.set_item("condition", fit.condition_number)?;
    Ok(all)
}

/// Covariance of the estimates of ordinary least squares of residuals `residuals` on `x`, p by p, for correlated residuals.
#[pyfunction]
pub fn coloured_covariance<'py>(
    py: Python<'py>,
    x: PyReadonlyArray2<'py, f64>,
    y: PyReadonlyArray1<'py, f64>,
) -> PyResult<Bound<'py, PyArray2<f64>>> {
    let (x, z) = (to_matrix(&x), slice("y", &y)?);
    let names: Vec<String> = (0..x.ncols()).map(|column| format!("x{column}")).collect();
    let found = detached(py, "covariance", || {
        let fit = least_squares(&names, &x, z)?;
        covariance_of(&fit, &x, &Coloured::default())
    })?;
    Ok(matrix(py, &found))
}
