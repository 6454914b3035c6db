//! Tables of the studies: each is described once, for the terminal, the window and the report.

use super::results::FitRow;
use super::studies::{CheckRow, ConditionRow, KindRow, LagRow, LeftOutRow, MonteCarloRow};
use super::table::{Cell, Column, Table, TableOf};
use crate::notation::significant;
use crate::study::{CoefficientForms, FormEstimates};

fn finite(value: f64) -> Option<f64> {
    value.is_finite().then_some(value)
}

/// Derivatives by the estimators, beside equation error; why there is none.
pub fn check_table<'r>(rows: impl IntoIterator<Item = &'r CheckRow>) -> Table {
    let caption = "Derivatives of each manoeuvre by other methods, beside time-domain equation error.";
    TableOf::new("checks", caption, rows)
        .text("window", "Manoeuvre", |row| &row.window)
        .text("method", "Method", |row| row.method)
        .text("axis", "Motion", |row| row.axis)
        .symbol("derivative", "Derivative", |row| &row.derivative)
        .maybe("estimate", "Estimate", "", 4, |row| finite(row.estimate))
        .maybe("standard_error", "Std error", "", 2, |row| finite(row.standard_error))
        .maybe("equation_error", "Equation error", "", 4, |row| finite(row.equation_error))
        .maybe("equation_standard_error", "Std error", "", 2, |row| finite(row.equation_standard_error))
        .optional("error", "", |row| row.error.as_deref())
        .done()
}

/// How the outputs of simulations follow their recordings.
pub fn followed_table<'r>(rows: impl IntoIterator<Item = &'r CheckRow>) -> Table {
    let caption = "Fit of output error to the recorded outputs; differences in SI units.";
    TableOf::new("followed", caption, rows)
        .text("window", "Manoeuvre", |row| &row.window)
        .text("axis", "Motion", |row| row.axis)
        .text("output", "Output", |row| &row.derivative)
        .number("r_squared", "R²", "", 3, |row| row.r_squared)
        .number("largest_deviation", "Largest deviation", "", 3, |row| row.largest_deviation)
        .done()
}

/// Lag and delay of every control.
pub fn lag_table(rows: &[LagRow]) -> Table {
    TableOf::new("lags", "Lag and delay of each control.", rows)
        .column(Column::new("lag", "Lag"), |row| Cell::text(format!("{} of {}", row.kind, row.control)))
        .text("from", "From", |row| if row.coefficient.is_empty() { "all" } else { row.coefficient })
        .maybe("value_ms", "Value", "ms", 3, |row| finite(1000.0 * row.value_s))
        .maybe("standard_error_ms", "Std error", "ms", 2, |row| finite(1000.0 * row.standard_error_s))
        .maybe("r_squared", "R²", "", 6, |row| finite(row.r_squared))
        .optional("error", "", |row| row.error.as_deref())
        .done()
}

/// What noise of the recording does to the derivatives, beside their corrected errors in the pooled fits.
pub fn monte_carlo_table(rows: &[MonteCarloRow], pooled: &[FitRow]) -> Table {
    let corrected = |name: &str| {
        let row = pooled.iter().flat_map(|fit| &fit.derivatives).find(|row| row.name == name)?;
        finite(row.corrected_standard_error)
    };
    TableOf::new("monte_carlo", "Effect of measurement noise on each derivative.", rows)
        .symbol("derivative", "Derivative", |row| &row.derivative)
        .number("estimate", "Estimate", "", 5, |row| row.estimate)
        .when(!pooled.is_empty(), |table| {
            table.maybe("corrected_error", "Corrected error", "", 2, |row| corrected(&row.derivative))
        })
        .number("noise_error", "Scatter", "", 2, |row| row.noise_error)
        .number("shift", "Shift", "", 2, |row| row.shift)
        .number("shift_error", "± shift", "", 2, |row| row.shift_error)
        .number("extrapolated", "Without shift", "", 5, |row| row.extrapolated)
        .number("low", "2.5 %", "", 3, |row| row.low)
        .number("high", "97.5 %", "", 3, |row| row.high)
        .done()
}

/// Each manoeuvre predicted by the others, with the derivative that changes most without it.
pub fn left_out_table(rows: &[LeftOutRow]) -> Table {
    let mut most: Vec<&LeftOutRow> = Vec::new();
    for row in rows {
        match most.iter_mut().find(|known| (known.coefficient, &known.window) == (row.coefficient, &row.window)) {
            Some(known) if known.shift_in_errors.abs() > row.shift_in_errors.abs() => {}
            Some(known) => *known = row,
            None => most.push(row),
        }
    }
    TableOf::new("left_out", "Each manoeuvre left out and predicted by the others.", most)
        .text("coefficient", "Coefficient", |row| row.coefficient)
        .text("window", "Manoeuvre", |row| &row.window)
        .number("r_squared", "R², others' constants", "", 3, |row| row.r_squared_identified_constants)
        .number("r_squared_own", "R², own constant", "", 3, |row| row.r_squared_own_constant)
        .symbol("derivative", "Moves most", |row| &row.derivative)
        .number("shift", "by std errors", "", 2, |row| row.shift_in_errors)
        .done()
}

/// Derivatives by kind of input.
pub fn kind_table(rows: &[KindRow]) -> Table {
    let side = |kind: &str, count: usize, mean: f64, scatter: f64| {
        Cell::text(format!("{kind}: {} ± {} ({count})", significant(mean, 4), significant(scatter, 2)))
    };
    TableOf::new("kinds", "Kinds of input: mean and scatter over the manoeuvres.", rows)
        .symbol("derivative", "Derivative", |row| &row.derivative)
        .column(Column::new("first", "First"), |row| {
            side(&row.first_kind, row.first_count, row.first_mean, row.first_scatter)
        })
        .column(Column::new("second", "Second"), |row| {
            side(&row.second_kind, row.second_count, row.second_mean, row.second_scatter)
        })
        .maybe("difference", "Difference in std errors", "", 2, |row| finite(row.difference_in_errors))
        .done()
}

/// Derivatives over the flight condition.
pub fn condition_table(rows: &[ConditionRow]) -> Table {
    TableOf::new("conditions", "Derivatives over the flight condition.", rows)
        .symbol("derivative", "Derivative", |row| &row.derivative)
        .text("variables", "Over", |row| &row.variables)
        .text("parameter", "Parameter", |row| &row.parameter)
        .maybe("estimate", "Estimate", "", 4, |row| finite(row.estimate))
        .maybe("standard_error", "Std error", "", 2, |row| finite(row.standard_error))
        .maybe("scatter_ratio", "Scatter", "", 2, |row| finite(row.scatter_ratio))
        .optional("error", "", |row| row.error.as_deref())
        .done()
}

/// The pooled derivatives of a coefficient by every form of least squares that has them: estimate, conventional standard error, and that corrected
/// for correlated residuals.
pub fn form_table(coefficient: &CoefficientForms) -> Table {
    let caption = "Each estimate with its conventional standard error and that corrected for correlated residuals.";
    let mut table =
        TableOf::new("forms", caption, &coefficient.derivatives).symbol("derivative", "Derivative", |name| name);
    for FormEstimates { form, found } in &coefficient.forms {
        let Ok((fit, corrected)) = found else { continue };
        let own = |name: &str| fit.parameter(name);
        let error = |name: &str| corrected.get(fit.names.iter().position(|other| other == name)?).copied();
        let key = form.replace(' ', "_");
        table = table
            .maybe(&key, form, "", 5, |name| Some(own(name)?.0))
            .maybe(&format!("{key}_standard_error"), "Std error", "", 2, |name| Some(own(name)?.1))
            .maybe(&format!("{key}_corrected_error"), "Corrected", "", 2, |name| error(name));
    }
    table.done()
}
