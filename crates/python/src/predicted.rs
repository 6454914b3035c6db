//! What follows from a fit and a path for the measurements: covariance of all estimates, predicted measurements, simulated manoeuvres.

use std::sync::Arc;

use doublet_core::model::Structure;
use doublet_core::reconstruct::{MEASUREMENTS, Measurement};
use doublet_core::series::Series;
use doublet_core::validate::Signal;
use doublet_engine::graph::StageError;
use doublet_engine::session::{Estimation, Preparation};
use doublet_engine::stage::{
    AeroWindow, CoefficientFit, PooledFits, ReplayWindow, Tolerances, WindowPath, model_of_window, replay,
};
use doublet_engine::study::dynamics::joint_covariance;
use nalgebra::DMatrix;
use pyo3::prelude::*;
use pyo3::types::PyDict;

use crate::attend::{detached, refuse};
use crate::columns::{owned, shared};

/// Covariance of the estimates of all coefficients, in order: correlations by [`joint_covariance`], or those of each coefficient alone where
/// its regression cannot be formed again, with the corrected errors. Zero for what is held.
pub fn covariance(
    pooled: &PooledFits,
    windows: &[AeroWindow<'_>],
    settings: (&Structure, &Estimation),
) -> DMatrix<f64> {
    let fits: Vec<&CoefficientFit> = pooled.fits.iter().filter(|fit| fit.fit.is_ok()).collect();
    let joint = joint_covariance(&fits, windows, settings).unwrap_or_else(|| alone(&fits));
    let estimated = fits.iter().filter_map(|fit| fit.fit.as_ref().ok().map(|found| (*fit, found)));
    let errors = estimated.flat_map(|(fit, found)| {
        let held = found.origins.iter().map(|origin| origin.is_estimated());
        fit.corrected_errors.iter().zip(held).map(|(error, is_estimated)| if is_estimated { *error } else { 0.0 })
    });
    let errors: Vec<f64> = errors.map(|error| if error.is_finite() { error } else { 0.0 }).collect();
    DMatrix::from_fn(errors.len(), errors.len(), |i, j| {
        let scale = (joint[(i, i)] * joint[(j, j)]).sqrt();
        let correlation = if i == j { 1.0 } else { 0.5 * (joint[(i, j)] + joint[(j, i)]) / scale };
        if correlation.is_finite() { correlation * (errors[i] * errors[j]) } else { 0.0 }
    })
}

/// Correlations within each coefficient, none across.
fn alone(fits: &[&CoefficientFit]) -> DMatrix<f64> {
    let blocks: Vec<&DMatrix<f64>> =
        fits.iter().filter_map(|fit| fit.fit.as_ref().ok()).map(|found| &found.correlation).collect();
    let size = blocks.iter().map(|block| block.nrows()).sum();
    let mut all = DMatrix::zeros(size, size);
    let mut start = 0;
    for block in blocks {
        all.view_mut((start, start), block.shape()).copy_from(block);
        start += block.nrows();
    }
    all
}

/// Measurements of a path by name, each with its time as recorded (s), its values, the predictions of the filter before each sample with
/// their standard deviations, and the values of the reconstructed states, SI. Without a filter and outside its samples predictions are not
/// numbers. `delays_s` are those that the filter took off.
pub fn measurements<'py>(
    py: Python<'py>,
    path: &WindowPath,
    delays_s: &[f64; MEASUREMENTS],
) -> PyResult<Bound<'py, PyDict>> {
    let (series, reconstruction) = (path.series(), &path.reconstruction);
    let all = PyDict::new(py);
    for measurement in Measurement::ALL {
        let at = measurement as usize;
        let Series { time_s, values } = &series.measured[at];
        if values.is_empty() {
            continue;
        }
        let times: Vec<f64> = time_s.iter().map(|time| time - delays_s[at]).collect();
        let updates = &reconstruction.update_time_s;
        let update = |time: &f64| {
            let after = updates.partition_point(|update| *update < time - SAME_TIME_S);
            updates.get(after).filter(|update| (*update - time).abs() <= SAME_TIME_S).map(|_| after)
        };
        let places: Vec<Option<usize>> = times.iter().map(update).collect();
        let of_filter = |column: &[f64]| -> Vec<f64> {
            let value = |place: &Option<usize>| place.and_then(|place| column.get(place)).copied().unwrap_or(f64::NAN);
            places.iter().map(value).collect()
        };
        let innovations = of_filter(&reconstruction.innovations[at]);
        let predicted = values.iter().zip(&innovations).map(|(value, innovation)| value - innovation).collect();
        let reconstructed = times.iter().map(|time| between(&series.reconstructed[at], *time)).collect();
        let row = PyDict::new(py);
        row.set_item("time", shared(py, time_s)?)?;
        row.set_item("measured", shared(py, values)?)?;
        row.set_item("predicted", owned(py, predicted))?;
        row.set_item("predicted_std", owned(py, of_filter(&reconstruction.innovation_deviations[at].to_vec())))?;
        row.set_item("reconstructed", owned(py, reconstructed))?;
        all.set_item(measurement.name(), row)?;
    }
    Ok(all)
}

/// Times that differ by less are one, s.
const SAME_TIME_S: f64 = 1e-9;

/// The value of a series at a time, on the line between its samples.
fn between(series: &Series, time_s: f64) -> f64 {
    let last = series.values.len().saturating_sub(1);
    let after = series.time_s.partition_point(|&t| t < time_s).clamp(1.min(last), last);
    let before = after.saturating_sub(1);
    let (start, step) = (series.time_s[before], series.time_s[after] - series.time_s[before]);
    let part = if step > 0.0 { ((time_s - start) / step).clamp(0.0, 1.0) } else { 0.0 };
    series.values[before] + part * (series.values[after] - series.values[before])
}

/// A manoeuvre flown by the pooled model from its recorded controls: by signal time (s), reconstructed and simulated values, SI.
pub fn simulated<'py>(
    py: Python<'py>,
    window: &ReplayWindow<'_>,
    (pooled, structure): (&PooledFits, &Structure),
    (preparation, gravity_m_s2): (&Preparation, f64),
) -> PyResult<Bound<'py, PyDict>> {
    let found = detached(py, "simulation", || {
        let model = model_of_window(pooled, structure, window)?;
        let found = replay(window, &model, preparation, gravity_m_s2, &Tolerances::builtin()?)?;
        Ok::<_, StageError>(found)
    });
    let found = found.map_err(|error| refuse(format!("manoeuvre '{}': {}", window.manoeuvre.name, error.value(py))))?;
    let all = PyDict::new(py);
    let time: Arc<[f64]> = found.measured.time_s.as_slice().into();
    for signal in Signal::ALL {
        let row = PyDict::new(py);
        row.set_item("time", shared(py, &time)?)?;
        row.set_item("measured", owned(py, found.measured.get(signal).to_vec()))?;
        row.set_item("simulated", owned(py, found.simulated.get(signal).to_vec()))?;
        all.set_item(signal.name(), row)?;
    }
    Ok(all)
}
