//! Frequency response of a linear model.

use nalgebra::{Complex, DMatrix};

use crate::linear::StateSpace;

/// `C (j w I - A)^-1 B + D` from one input to one output at each angular frequency, rad/s; `None` where the model has no such input or output,
/// or a pole lies on one of the frequencies.
pub fn state_space_response(
    model: &StateSpace,
    input: &str,
    output: &str,
    omega_rad_s: &[f64],
) -> Option<Vec<Complex<f64>>> {
    let (column, row) = (model.input(input)?, model.output(output)?);
    let complex = |matrix: &DMatrix<f64>| matrix.map(|value| Complex::new(value, 0.0));
    let (a, b) = (complex(&model.a), complex(&model.b.columns(column, 1).into_owned()));
    let c = complex(&model.c.rows(row, 1).into_owned());
    let size = a.nrows();
    let at = |&omega: &f64| {
        let shifted = DMatrix::from_diagonal_element(size, size, Complex::new(0.0, omega)) - &a;
        let states = shifted.lu().solve(&b)?;
        Some((&c * states)[(0, 0)] + model.d[(row, column)])
    };
    omega_rad_s.iter().map(at).collect()
}
