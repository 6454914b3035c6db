//! Linear interpolation and extrapolation on increasing grids, and the checks their tables need.

use thiserror::Error;

/// A chart or map whose tables do not fit together.
#[derive(Clone, Debug, PartialEq, Error)]
#[expect(missing_docs, reason = "the messages say what variants and fields are")]
pub enum TableError {
    #[error("{field} has {found} values, at least {needed} are needed")]
    TooShort { field: &'static str, found: usize, needed: usize },
    #[error("{field} has {found} values where its grid has {expected}")]
    Shape { field: String, found: usize, expected: usize },
    #[error("{field}[{index}] is {value}: values must be finite and {order} strictly")]
    Order { field: String, index: usize, value: f64, order: &'static str },
    /// A value that is not allowed.
    #[error("{field} is {value}, allowed is {allowed}")]
    Value { field: String, value: f64, allowed: &'static str },
    #[error(
        "the propeller map for flight level {flight_level_m} m and {speed_rad_s} rad/s is given {count} times, once is needed"
    )]
    MapCount { flight_level_m: f64, speed_rad_s: f64, count: usize },
}

/// Lower index and weight of the upper neighbour for `value` on the strictly increasing `grid` of two values or more.
///
/// `f(value) = (1 - w) f[i] + w f[i + 1]`; outside the grid the weight leaves 0..1 and the same formula extrapolates
/// linearly from the outermost pair. Not a number in, not a number out.
pub(super) fn bracket(grid: &[f64], value: f64) -> (usize, f64) {
    let lower = grid.partition_point(|&g| g < value).saturating_sub(1).min(grid.len().saturating_sub(2));
    (lower, (value - grid[lower]) / (grid[lower + 1] - grid[lower]))
}

/// Checks that `values` holds `expected` finite numbers.
pub(super) fn check_row(field: &str, values: &[f64], expected: usize) -> Result<(), TableError> {
    if values.len() != expected {
        return Err(TableError::Shape { field: field.to_owned(), found: values.len(), expected });
    }
    match values.iter().position(|v| !v.is_finite()) {
        Some(index) => Err(TableError::Value {
            field: format!("{field}[{index}]"),
            value: values[index],
            allowed: "a finite number",
        }),
        None => Ok(()),
    }
}

/// Checks that `values` are finite and increase strictly (`sign` 1) or decrease strictly (`sign` -1).
pub(super) fn check_order(field: &str, values: &[f64], sign: f64) -> Result<(), TableError> {
    let order = if sign > 0.0 { "increase" } else { "decrease" };
    for (index, &value) in values.iter().enumerate() {
        let ordered = index == 0 || sign * (value - values[index - 1]) > 0.0;
        if !value.is_finite() || !ordered {
            return Err(TableError::Order { field: field.to_owned(), index, value, order });
        }
    }
    Ok(())
}

/// Checks a grid: at least two values, strictly increasing.
pub(super) fn check_grid(field: &'static str, values: &[f64]) -> Result<(), TableError> {
    if values.len() < 2 {
        return Err(TableError::TooShort { field, found: values.len(), needed: 2 });
    }
    check_order(field, values, 1.0)
}

/// Checks a number that must be finite and above zero.
pub(super) fn check_positive(field: &str, value: f64) -> Result<(), TableError> {
    if value.is_finite() && value > 0.0 {
        return Ok(());
    }
    Err(TableError::Value { field: field.to_owned(), value, allowed: "a finite number above 0" })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bracket_interpolates_inside_and_extrapolates_from_the_outermost_pair() {
        let grid = [1.0, 2.0, 4.0];
        assert_eq!(bracket(&grid, 3.0), (1, 0.5));
        assert_eq!(bracket(&grid, 0.0), (0, -1.0));
        assert_eq!(bracket(&grid, 5.0), (1, 1.5));
        assert_eq!(bracket(&grid, 1.0), (0, 0.0));
        assert!(bracket(&grid, f64::NAN).1.is_nan());
    }
}
