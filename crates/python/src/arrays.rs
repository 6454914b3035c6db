//! Functions of arrays that need neither session nor aircraft.

use doublet_core::motion::natural_modes as modes_of;
use doublet_core::prep::{
    Differentiation, Smoothing, differentiate as differentiate_samples, smooth as smooth_samples,
};
use doublet_dynamics::frequency::{FrequencyRecord, SpectralSettings, responses};
use doublet_dynamics::linear::StateSpace;
use doublet_engine::graph::StageError;
use nalgebra::DMatrix;
use numpy::{Complex64, IntoPyArray, PyArray1, PyReadonlyArray1, PyReadonlyArray2};
use pyo3::prelude::*;
use pyo3::types::{PyComplex, PyDict};

use crate::attend::{detached, refuse};
use crate::columns::{owned, slice, to_matrix};

/// Values over time turned into others at the same times; Python's other threads run meanwhile.
fn at_same_times<'py, E: std::fmt::Display + Send>(
    (time, values): (&PyReadonlyArray1<'py, f64>, &PyReadonlyArray1<'py, f64>),
    py: Python<'py>,
    work: impl FnOnce(&[f64], &[f64]) -> Result<Vec<f64>, E> + Send,
) -> PyResult<Bound<'py, PyArray1<f64>>> {
    let (time, values) = (slice("time", time)?, slice("values", values)?);
    Ok(owned(py, detached(py, "values over time", || work(time, values))?))
}

/// Smoothed values of evenly or unevenly sampled `values`.
#[pyfunction]
pub fn smooth<'py>(
    py: Python<'py>,
    time: PyReadonlyArray1<'py, f64>,
    values: PyReadonlyArray1<'py, f64>,
    method: &str,
    width: usize,
    degree: usize,
) -> PyResult<Bound<'py, PyArray1<f64>>> {
    let method = match method {
        "moving-average" => Smoothing::MovingAverage { width },
        "spencer" => Smoothing::Spencer15,
        "polynomial" => Smoothing::LocalPolynomial { degree, half_width: width / 2 },
        other => {
            return Err(refuse(format!("'{other}' is not a smoothing: use moving-average, polynomial or spencer")));
        }
    };
    at_same_times((&time, &values), py, |time, values| smooth_samples(time, values, method))
}

/// Slopes of `values` over `time`.
#[pyfunction]
pub fn differentiate<'py>(
    py: Python<'py>,
    time: PyReadonlyArray1<'py, f64>,
    values: PyReadonlyArray1<'py, f64>,
    method: &str,
    width: usize,
    degree: usize,
) -> PyResult<Bound<'py, PyArray1<f64>>> {
    let method = match method {
        "central" => Differentiation::Central4,
        "polynomial" => Differentiation::LocalPolynomial { degree, half_width: width / 2 },
        other => return Err(refuse(format!("'{other}' is not a differentiation: use central or polynomial"))),
    };
    at_same_times((&time, &values), py, |time, values| differentiate_samples(time, values, method))
}

/// Frequency responses of an output to each input with the others held, over records of one time step each.
#[pyfunction]
pub fn frequency_response<'py>(
    py: Python<'py>,
    records: Vec<(f64, Vec<PyReadonlyArray1<'py, f64>>, PyReadonlyArray1<'py, f64>)>,
    omega: Vec<f64>,
    windows: Vec<f64>,
    overlap: f64,
) -> PyResult<Vec<Bound<'py, PyDict>>> {
    let column = |array: &PyReadonlyArray1<'py, f64>| slice("a signal", array).map(<[f64]>::to_vec);
    let record = |(step_s, inputs, output): &(f64, Vec<_>, _)| -> PyResult<FrequencyRecord> {
        let inputs = inputs.iter().map(column).collect::<PyResult<_>>()?;
        Ok(FrequencyRecord { step_s: *step_s, inputs, output: column(output)? })
    };
    let records = records.iter().map(record).collect::<PyResult<Vec<_>>>()?;
    let settings = SpectralSettings { omega_rad_s: omega, windows_s: windows, overlap, for_fit: false };
    let found = detached(py, "frequency response", || responses(&records, &settings))?;
    found
        .iter()
        .map(|response| {
            let points = &response.points;
            let all = PyDict::new(py);
            all.set_item("omega", owned(py, points.iter().map(|point| point.omega_rad_s).collect()))?;
            let values: Vec<Complex64> = points.iter().map(|p| Complex64::new(p.response.re, p.response.im)).collect();
            all.set_item("response", values.into_pyarray(py))?;
            all.set_item("phase", owned(py, response.phases_rad()))?;
            all.set_item("coherence", owned(py, points.iter().map(|point| point.coherence).collect()))?;
            all.set_item("multiple_coherence", owned(py, points.iter().map(|p| p.multiple_coherence).collect()))?;
            all.set_item("relative_std", owned(py, points.iter().map(|point| point.relative_sd).collect()))?;
            all.set_item("averages", owned(py, points.iter().map(|point| point.averages).collect()))?;
            Ok(all)
        })
        .collect()
}

/// Natural modes of `x' = A x` whose states are called `states`.
#[pyfunction]
pub fn natural_modes<'py>(
    py: Python<'py>,
    a: PyReadonlyArray2<'py, f64>,
    states: Vec<String>,
) -> PyResult<Vec<Bound<'py, PyDict>>> {
    let a = to_matrix(&a);
    if a.nrows() != a.ncols() || a.nrows() != states.len() {
        let (rows, columns) = a.shape();
        return Err(refuse(format!(
            "A is {rows} by {columns} and there are {} states: give one name per row and column",
            states.len()
        )));
    }
    if a.is_empty() {
        return Err(refuse("A is empty: give at least one state"));
    }
    if a.iter().any(|value| !value.is_finite()) {
        return Err(refuse("A has a value that is not finite"));
    }
    let names: Vec<&str> = states.iter().map(String::as_str).collect();
    let model = StateSpace::of_states("given", &names, &[], a.clone(), DMatrix::zeros(a.nrows(), 0));
    let meanings = model
        .meanings()
        .ok_or_else(|| refuse("states are among u v w p q r phi theta psi north east h V alpha beta"))?;
    let modes = detached(py, "modes", || Ok::<_, StageError>(modes_of(&a, &meanings)))?;
    modes
        .iter()
        .map(|mode| {
            let all = PyDict::new(py);
            all.set_item("name", mode.name)?;
            all.set_item("eigenvalue", PyComplex::from_doubles(py, mode.real_1_s, mode.imaginary_rad_s))?;
            all.set_item("frequency", mode.frequency_rad_s())?;
            all.set_item("damping", mode.damping())?;
            all.set_item("participation", owned(py, mode.participation.clone()))?;
            Ok(all)
        })
        .collect()
}
