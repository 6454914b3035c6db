//! Output error and filter error of the windows of a fit.

use std::sync::Arc;

use doublet_core::replay::MotionAxis;
use doublet_engine::graph::{Control, Stage, StageError};
use doublet_engine::study::{
    CheckRequest, CheckStudy, CheckedDerivative, Estimator, FollowedFlight, MethodEstimates, ModelPart, WindowChecks,
};
use pyo3::prelude::*;
use pyo3::types::PyDict;

use crate::attend::{Show, attend, refuse};
use crate::columns::{matrix, shared};
use crate::fits::{Fitted, context};

/// Output error of every window: window, axis, then either the line why there is none or derivatives, their covariance, outputs and
/// iterations.
pub fn rows<'py>(
    py: Python<'py>,
    fit: &Arc<Fitted>,
    (axis, filter_error): (Option<&str>, bool),
    progress: Option<&Bound<'_, PyAny>>,
) -> PyResult<Vec<Bound<'py, PyDict>>> {
    let axis = axis
        .map(|name| {
            let found = MotionAxis::from_name(name);
            found.ok_or_else(|| refuse(format!("'{name}' is not a motion: use longitudinal, lateral or both")))
        })
        .transpose()?;
    let estimators = Estimator::from_key("filter-error").filter(|_| filter_error).into_iter().collect();
    let (fit, request) = (Arc::clone(fit), CheckRequest { axis, estimators });
    let work =
        move |control: &Control, _: Show<'_>| fit.study(|input| CheckStudy::run(request, input, &context(control)));
    let found = attend(py, "output error", progress, work)?;
    let parts = found.windows.iter().flat_map(|window| {
        by(window, "output-error").into_iter().map(move |(part, estimates)| row(py, window, part, estimates))
    });
    parts.collect()
}

fn row<'py>(
    py: Python<'py>,
    window: &WindowChecks,
    part: ModelPart,
    estimates: Result<&MethodEstimates, &StageError>,
) -> PyResult<Bound<'py, PyDict>> {
    let all = PyDict::new(py);
    all.set_item("window", &window.window)?;
    all.set_item("axis", part.axis())?;
    let estimates = match estimates {
        Err(error) => {
            all.set_item("error", error.to_string())?;
            return Ok(all);
        }
        Ok(estimates) => estimates,
    };
    all.set_item("derivatives", values(&estimates.derivatives))?;
    all.set_item("covariance", matrix(py, &estimates.covariance))?;
    match by(window, "filter-error").into_iter().find(|(other, _)| *other == part) {
        Some((_, Ok(filtered))) => {
            all.set_item("filter_error", values(&filtered.derivatives))?;
            all.set_item("filter_covariance", matrix(py, &filtered.covariance))?;
        }
        Some((_, Err(error))) => all.set_item("filter_trouble", error.to_string())?,
        None => {}
    }
    if let Some(flight) = &estimates.flight {
        all.set_item("iterations", flight.iterations)?;
        all.set_item("outputs", outputs(py, flight)?)?;
    }
    Ok(all)
}

/// By name: time (s), measured, flown, R2.
fn outputs<'py>(py: Python<'py>, flight: &FollowedFlight) -> PyResult<Bound<'py, PyDict>> {
    let all = PyDict::new(py);
    for output in &flight.outputs {
        let columns = [&output.flown.time_s, &output.measured.values, &output.flown.values];
        let [time, measured, flown] = columns.map(|column| shared(py, column));
        all.set_item(output.output.name(), (time?, measured?, flown?, output.r_squared))?;
    }
    Ok(all)
}

/// What the estimator called `key` found, part by part of the model.
fn by<'w>(window: &'w WindowChecks, key: &str) -> Vec<(ModelPart, Result<&'w MethodEstimates, &'w StageError>)> {
    window.results().filter(|(method, ..)| method.key == key).map(|(_, part, found)| (part, found)).collect()
}

/// Names, estimates and standard errors.
fn values(derivatives: &[CheckedDerivative]) -> Vec<(&str, f64, f64)> {
    derivatives.iter().map(|row| (&*row.name, row.estimate, row.standard_error)).collect()
}
