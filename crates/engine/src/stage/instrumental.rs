//! Pooled derivatives by instrumental variables, for flights whose gusts nothing recorded shows.

use doublet_core::estimate::{Coloured, EstimateError, Fit, PooledRegression, instrumental_variables, stacked};
use doublet_core::model::{Coefficient, Structure, Variable};
use doublet_core::statistics::median_step;
use nalgebra::DMatrix;

use super::fit::AeroWindow;

/// What is deflected by a pilot or a test input, not moved by the air.
const INPUTS: [Variable; 6] = [
    Variable::Elevator,
    Variable::Aileron,
    Variable::Rudder,
    Variable::Flap,
    Variable::ElevatorTrim,
    Variable::Stabiliser,
];

/// The regression of `coefficient` without weights and constraints by [`instrumental_variables`], and the covariance for residuals
/// that are correlated inside the manoeuvres. The controls are the instruments: a control system that answers the motion breaks that.
///
/// # Errors
/// As for [`instrumental_variables`].
pub fn by_instruments(
    coefficient: Coefficient,
    regression: &PooledRegression,
    structure: &Structure,
    step_s: f64,
) -> Result<(Fit, DMatrix<f64>), EstimateError> {
    let PooledRegression { names, per_window, windows, .. } = regression;
    let all = stacked(names, per_window, windows)?;
    let terms = structure.terms(coefficient).unwrap_or_default();
    let is_input = |name: &String| {
        let term = terms.iter().find(|term| term.derivative_name(coefficient) == *name);
        term.is_none_or(|term| term.factors().iter().all(|(variable, _)| INPUTS.contains(variable)))
    };
    let shared = regression.shared().count();
    // Constants of single manoeuvres follow the shared derivatives.
    let flags: Vec<bool> =
        all.names.iter().enumerate().map(|(place, name)| place >= shared || is_input(name)).collect();
    let mut end = 0;
    let rows = windows.iter().map(|window| {
        let start = end;
        end += window.z.len();
        start..end
    });
    let rows: Vec<_> = rows.collect();
    let found = instrumental_variables((&all.names, &all.x, &all.z), &flags, &rows, step_s)?;
    let covariance = found.coloured_covariance(&rows, &Coloured::default())?;
    Ok((found.fit, covariance))
}

/// Time between the samples of the first window with coefficients, s.
pub fn sample_step_s(windows: &[AeroWindow<'_>]) -> Option<f64> {
    windows.iter().find_map(|(_, aero)| median_step(&aero.coefficients.time_s))
}
