//! Equations of motion whose right-hand sides are a function of Python.

use std::path::PathBuf;
use std::sync::{Arc, Mutex, PoisonError};

use doublet_core::estimate::{EquationFunction, EquationModel, EquationNames, EquationPoints};
use doublet_core::series::TimeRange;
use doublet_engine::graph::{Control, StageError};
use doublet_engine::study::{EquationRequest, fit_equation_model};
use numpy::{PyArray1, PyArrayMethods};
use pyo3::prelude::*;

use crate::attend::{DoubletError, Show, attend};

/// Names: states, outputs, inputs, parameters with their starts.
type Names = (Vec<String>, Vec<String>, Vec<String>, Vec<(String, f64)>);
/// Columns of inputs and outputs, column of time, interval of the rows, s, windows, s, half width and piece, s.
type Order = (Vec<(String, String)>, Option<String>, Option<f64>, Vec<(f64, f64)>, Option<f64>, Option<f64>);

/// A function of Python: `function(what, states, inputs, parameters)` gives columns for columns. After an exception, or once the work is cancelled, it
/// has no values.
struct Callback {
    function: Py<PyAny>,
    control: Control,
    raised: Arc<Mutex<Option<PyErr>>>,
}

impl std::fmt::Debug for Callback {
    fn fmt(&self, formatter: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        formatter.write_str("function of Python")
    }
}

impl Callback {
    fn call(&self, what: &str, points: EquationPoints<'_>) -> Vec<Vec<f64>> {
        let mut raised = self.raised.lock().unwrap_or_else(PoisonError::into_inner);
        if raised.is_some() || self.control.is_cancelled() {
            return Vec::new();
        }
        Python::attach(|py| {
            let arrays =
                |columns: &[&[f64]]| columns.iter().map(|column| PyArray1::from_slice(py, column)).collect::<Vec<_>>();
            let columns = (arrays(points.states), arrays(points.inputs), arrays(points.parameters));
            let call = || -> PyResult<Vec<Vec<f64>>> {
                let (states, inputs, parameters) = columns;
                let found = self.function.bind(py).call1((what, states, inputs, parameters))?;
                let found: Vec<Bound<'_, PyArray1<f64>>> = found.extract()?;
                found.iter().map(|column| Ok(column.to_vec()?)).collect()
            };
            call().unwrap_or_else(|error| {
                *raised = Some(error);
                Vec::new()
            })
        })
    }
}

impl EquationFunction for Callback {
    fn rates(&self, points: EquationPoints<'_>) -> Vec<Vec<f64>> {
        self.call("rates", points)
    }

    fn shown(&self, points: EquationPoints<'_>) -> Vec<Vec<f64>> {
        self.call("shows", points)
    }
}

/// Fits equations of motion whose right-hand sides are `function` to a table: the document of `doublet equations --json`.
#[pyfunction]
pub fn fit_function(
    py: Python<'_>,
    table: PathBuf,
    names: Names,
    order: Order,
    function: Py<PyAny>,
) -> PyResult<String> {
    let (states, outputs, inputs, parameters) = names;
    let names = EquationNames { states, outputs, inputs, parameters };
    let (columns, time, step_s, windows, half_width_s, piece_s) = order;
    let windows = windows.into_iter().map(|(start_s, end_s)| TimeRange { start_s, end_s }).collect();
    let columns = columns.into_iter().collect();
    let request =
        EquationRequest { columns, time, step_s, windows, half_width_s, piece_s, ..EquationRequest::default() };
    let raised = Arc::new(Mutex::new(None));
    let kept = Arc::clone(&raised);
    let work = move |control: &Control, _: Show<'_>| -> Result<String, StageError> {
        let callback = Callback { function, control: control.clone(), raised: kept };
        let model = EquationModel::with_function(names, Arc::new(callback)).map_err(|error| error.to_string())?;
        let found = fit_equation_model(&table, &model, &request).map_err(|error| error.to_string())?;
        Ok(doublet_cli::equation_document(&found).to_string())
    };
    let found = attend(py, "equations", None, work);
    // What the function raised is the reason of what came of it.
    let raised = raised.lock().unwrap_or_else(PoisonError::into_inner).take();
    match (found, raised) {
        (Err(error), Some(raised)) if error.is_instance_of::<DoubletError>(py) => Err(raised),
        (Ok(_), Some(raised)) => Err(raised),
        (found, _) => found,
    }
}
