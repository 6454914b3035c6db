//! Time responses of a linear model and the phasors of its modes.

use nalgebra::{Complex, DMatrix, DVector};

use super::Mode;
use crate::linear::StateSpace;

/// Outputs over time, one column per sample, from zero deviation: the inputs (one row per input, one column per sample) held over each
/// step, the states advanced exactly by the matrix exponential of `[A B; 0 0] step`.
pub fn respond(model: &StateSpace, inputs: &DMatrix<f64>, step_s: f64) -> DMatrix<f64> {
    let (n, m) = (model.a.nrows(), model.b.ncols());
    let mut augmented = DMatrix::zeros(n + m, n + m);
    augmented.view_mut((0, 0), (n, n)).copy_from(&(&model.a * step_s));
    augmented.view_mut((0, n), (n, m)).copy_from(&(&model.b * step_s));
    let exponential = augmented.exp();
    let (over_step, from_input) = (exponential.view((0, 0), (n, n)), exponential.view((0, n), (n, m)));
    let mut state = DVector::zeros(n);
    let mut outputs = DMatrix::zeros(model.c.nrows(), inputs.ncols());
    for (k, input) in inputs.column_iter().enumerate() {
        outputs.set_column(k, &(&model.c * &state + &model.d * input));
        state = over_step * &state + from_input * input;
    }
    outputs
}

/// Amplitude and phase of each state of a mode relative to `reference`, whose phasor is one; the entries of the eigenvector as they are
/// where that state does not move.
pub fn phasors(mode: &Mode, reference: usize) -> Vec<Complex<f64>> {
    let unit = mode.shape.get(reference).copied().filter(|entry| entry.norm() > 0.0);
    mode.shape.iter().map(|entry| unit.map_or(*entry, |unit| entry / unit)).collect()
}
