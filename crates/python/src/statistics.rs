//! Least squares and the covariance of its estimates for residuals that are not white, of arrays.

use doublet_core::estimate::{
    Coloured, Constraint, Fit, OrthogonalSettings, PooledRegression, PooledWindow, StepwiseSettings,
    coloured_covariance as covariance_of, least_squares, orthogonal, stepwise, weighted_coloured_covariance,
    weighted_least_squares,
};
use doublet_engine::stage::describe_origin;
use nalgebra::DMatrix;
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
    let text = |error: doublet_core::estimate::EstimateError| error.to_string();
    match method {
        "ols" => Ok((0..names.len()).collect()),
        "stepwise" => Ok(stepwise(names, x, z, &forced, &StepwiseSettings::default()).map_err(text)?.selected),
        "orthogonal" => Ok(orthogonal(names, x, z, &forced, &OrthogonalSettings::default()).map_err(text)?.selected),
        other => Err(format!("'{other}' is not a method: use ols, stepwise or orthogonal")),
    }
}

/// Ends of the stretches of rows of one group.
fn stretches(groups: &[i64]) -> Vec<std::ops::Range<usize>> {
    let mut found: Vec<std::ops::Range<usize>> = Vec::new();
    for (row, group) in groups.iter().enumerate() {
        match found.last_mut() {
            Some(last) if groups[last.start] == *group => last.end = row + 1,
            _ => found.push(row..row + 1),
        }
    }
    found
}

/// A fit, and the covariance of its estimates for coloured residuals.
type Both = (Fit, DMatrix<f64>);

fn grouped(
    names: &[String],
    x: &DMatrix<f64>,
    z: &[f64],
    rows: &[std::ops::Range<usize>],
    constraints: Vec<Constraint>,
) -> Result<Both, doublet_core::estimate::EstimateError> {
    let window = |(index, rows): (usize, &std::ops::Range<usize>)| PooledWindow {
        label: index.to_string(),
        x: x.rows(rows.start, rows.len()).into_owned(),
        z: z[rows.clone()].to_vec(),
    };
    let windows = rows.iter().enumerate().map(window).collect();
    let regression =
        PooledRegression { names: names.to_vec(), per_window: vec![false; names.len()], constraints, windows };
    let pooled = regression.fit()?;
    let covariance = pooled.coloured_covariance(&regression.windows, &Coloured::default())?;
    Ok((pooled.fit, covariance))
}

/// Least squares of `y` on the columns of `x`, with errors for white and for coloured residuals.
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
    given: Vec<(String, String, f64, f64)>,
) -> PyResult<Bound<'py, PyDict>> {
    let (x, z) = (to_matrix(&x), slice("y", &y)?);
    if groups.as_ref().is_some_and(|groups| groups.len() != z.len()) {
        return Err(refuse("groups has another number of entries than y: give one per row"));
    }
    let chosen = detached(py, "choice of columns", || chosen(&names, &x, z, method))?;
    let x = x.select_columns(&chosen);
    let kept: Vec<String> = chosen.iter().map(|&index| names[index].clone()).collect();
    let mut constraints = Vec::new();
    if !given.is_empty() {
        constraints = vec![Constraint::Free; kept.len()];
        for (name, kind, first, second) in given {
            let at = kept.iter().position(|known| *known == name);
            let at =
                at.ok_or_else(|| refuse(format!("no column is called '{name}': there are {}", kept.join(", "))))?;
            constraints[at] = constraint(&kind, first, second)?;
        }
    }
    let weights: Option<Vec<f64>> = deviations
        .map(|deviations| {
            Ok::<_, PyErr>(slice("deviations", &deviations)?.iter().map(|deviation| deviation.powi(-2)).collect())
        })
        .transpose()?;
    if weights.is_some() && !constraints.is_empty() {
        return Err(refuse("constraints and standard deviations cannot be combined: leave one out"));
    }
    let settings = Coloured::default();
    let whole = 0..z.len();
    let rows = groups.as_deref().map_or_else(|| vec![whole.clone()], stretches);
    let (fit, covariance) = detached(py, "least squares", || match weights {
        Some(weights) => {
            let fit = weighted_least_squares(&kept, &x, z, &weights)?;
            let covariance = weighted_coloured_covariance(&fit, &x, &weights, &rows, &settings)?;
            Ok((fit, covariance))
        }
        None if rows.len() == 1 && constraints.is_empty() => {
            let fit = least_squares(&kept, &x, z)?;
            let covariance = covariance_of(&fit, &x, &settings)?;
            Ok((fit, covariance))
        }
        None => grouped(&kept, &x, z, &rows, constraints),
    })?;
    described(py, &fit, z, &covariance)
}

/// A fit as Python takes it.
fn described<'py>(py: Python<'py>, fit: &Fit, z: &[f64], covariance: &DMatrix<f64>) -> PyResult<Bound<'py, PyDict>> {
    let all = PyDict::new(py);
    all.set_item("names", &fit.names)?;
    all.set_item("estimates", owned(py, fit.estimates.clone()))?;
    all.set_item("white", matrix(py, &fit.covariance))?;
    all.set_item("coloured", matrix(py, covariance))?;
    all.set_item("correlation", matrix(py, &fit.correlation))?;
    all.set_item("held", fit.origins.iter().map(|&origin| describe_origin(origin)).collect::<Vec<_>>())?;
    all.set_item("residuals", owned(py, fit.residuals.to_vec()))?;
    all.set_item("fitted", owned(py, fit.fitted(z)))?;
    all.set_item("r2", fit.quality.r_squared)?;
    all.set_item("residual_std", fit.residual_std)?;
    all.set_item("condition", fit.condition_number)?;
    Ok(all)
}

/// Covariance of the estimates of ordinary least squares of residuals `residuals` on `x`, p by p, for coloured residuals.
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
