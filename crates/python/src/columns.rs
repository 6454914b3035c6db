//! Columns and matrices between Rust and NumPy.

use std::sync::Arc;

use nalgebra::DMatrix;
use numpy::ndarray::{Array2, ArrayView1};
use numpy::{IntoPyArray, PyArray1, PyArray2, PyArrayMethods, PyReadonlyArray1, PyReadonlyArray2};
use pyo3::prelude::*;

use crate::attend::refuse;

/// Keeps a column alive while NumPy looks at it.
#[pyclass(frozen, module = "doublet")]
struct Column {
    values: Arc<[f64]>,
}

/// A shared column as a read-only array that looks at it: nothing is copied.
pub fn shared<'py>(py: Python<'py>, values: &Arc<[f64]>) -> PyResult<Bound<'py, PyArray1<f64>>> {
    let column = Bound::new(py, Column { values: Arc::clone(values) })?;
    let view = ArrayView1::from(&*column.get().values);
    // The array keeps `column`, whose values neither move nor change.
    #[expect(unsafe_code, reason = "NumPy looks at memory that the column keeps alive; it is made read-only at once")]
    let array = unsafe { PyArray1::borrow_from_array(&view, column.clone().into_any()) };
    array.readwrite().make_nonwriteable();
    Ok(array)
}

/// An array that takes the values over: nothing is copied.
pub fn owned(py: Python<'_>, values: Vec<f64>) -> Bound<'_, PyArray1<f64>> {
    values.into_pyarray(py)
}

/// A matrix as an array, row by row.
pub fn matrix<'py>(py: Python<'py>, values: &DMatrix<f64>) -> Bound<'py, PyArray2<f64>> {
    Array2::from_shape_fn(values.shape(), |(i, j)| values[(i, j)]).into_pyarray(py)
}

/// The values of an array, without a copy where they lie side by side.
pub fn slice<'a>(name: &str, array: &'a PyReadonlyArray1<'_, f64>) -> PyResult<&'a [f64]> {
    array
        .as_slice()
        .map_err(|_| refuse(format!("{name} does not lie in one piece: give numpy.ascontiguousarray({name})")))
}

/// A two-dimensional array as a matrix.
pub fn to_matrix(array: &PyReadonlyArray2<'_, f64>) -> DMatrix<f64> {
    let view = array.as_array();
    DMatrix::from_fn(view.nrows(), view.ncols(), |i, j| view[(i, j)])
}
