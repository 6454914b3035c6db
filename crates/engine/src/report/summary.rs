//! Statistics over the windows, in the form of the thesis' tables.

use super::prediction::{PredictionAgreement, ValidationRow};
use super::results::{
    DerivativeSummaryRow, FitRow, InnovationSummaryRow, ResidualSummaryRow, Results, SpreadRow, WindowRow,
};
use super::studies::TotalErrorRow;
use crate::session::WindowRole;

/// Mean, spread and extremes of some values.
struct Spread {
    count: usize,
    mean: f64,
    deviation: f64,
    minimum: f64,
    maximum: f64,
}

/// Statistics of the finite values; not a number where there are too few.
fn spread(values: impl Iterator<Item = f64>) -> Spread {
    let values: Vec<f64> = values.filter(|value| value.is_finite()).collect();
    let count = values.len() as f64;
    let mean = values.iter().sum::<f64>() / count;
    let square: f64 = values.iter().map(|value| (value - mean).powi(2)).sum();
    Spread {
        count: values.len(),
        mean,
        deviation: if values.len() > 1 { (square / (count - 1.0)).sqrt() } else { f64::NAN },
        minimum: values.iter().copied().fold(f64::NAN, f64::min),
        maximum: values.iter().copied().fold(f64::NAN, f64::max),
    }
}

/// Adds the statistics over the windows to results that have their windows, pooled fits and predictions.
pub fn complete(results: &mut Results) {
    results.wind_and_bias = wind_and_bias(&results.windows);
    results.innovation_summary = innovations(&results.windows);
    results.residual_summary = residuals(results);
    results.derivative_summary = derivatives(results);
    results.validation = validation(results);
    results.studies.total_errors = total_errors(results);
}

/// Noise and all varied quantities together, each of them wrong by its step.
fn total_errors(results: &Results) -> Vec<TotalErrorRow> {
    results.derivative_summary.iter().filter_map(|summary| total_error(results, summary)).collect()
}

fn total_error(results: &Results, summary: &DerivativeSummaryRow) -> Option<TotalErrorRow> {
    let (estimate, standard_error) = (summary.pooled?, summary.corrected_standard_error?);
    let changes = results.studies.sensitivity.iter().filter(|row| row.derivative == summary.name);
    let squares: Vec<f64> = changes.map(|row| (0.5 * (row.high - row.low)).powi(2)).collect();
    let by_quantities = squares.iter().sum::<f64>().sqrt();
    let total = standard_error.hypot(by_quantities);
    let derivative = summary.name.clone();
    let known = !squares.is_empty() && total.is_finite();
    known.then_some(TotalErrorRow { derivative, estimate, standard_error, by_quantities, total })
}

fn wind_and_bias(windows: &[WindowRow]) -> Vec<SpreadRow> {
    let Some(first) = windows.iter().find(|window| !window.states.is_empty()) else { return Vec::new() };
    let named = |prefix: &'static str| first.states.iter().filter(move |row| row.state.starts_with(prefix));
    // Without velocity over ground and position the wind is what it was taken for.
    let is_told = |window: &&WindowRow, state: &str| {
        let is_missing = |name: &&str| window.missing_measurements.contains(name);
        !state.starts_with("wind_") || !["x", "y", "v_north", "v_east"].iter().all(is_missing)
    };
    let of_state = |state: &'static str| {
        let told = windows.iter().filter(move |window| is_told(window, state));
        told.filter_map(move |window| window.states.iter().find(|row| row.state == state))
    };
    let rows = named("wind_").chain(named("bias_")).map(|row| {
        let found = spread(of_state(row.state).map(|row| row.last_second_mean));
        SpreadRow {
            quantity: row.state,
            unit: row.unit,
            windows: found.count,
            mean: found.mean,
            standard_deviation: found.deviation,
            minimum: found.minimum,
            maximum: found.maximum,
        }
    });
    rows.filter(|row| row.windows > 0).collect()
}

fn innovations(windows: &[WindowRow]) -> Vec<InnovationSummaryRow> {
    let mut names: Vec<&'static str> = Vec::new();
    for row in windows.iter().flat_map(|window| &window.innovations) {
        if !names.contains(&row.measurement) {
            names.push(row.measurement);
        }
    }
    let rows = names.into_iter().map(|measurement| {
        let rows = || windows.iter().flat_map(|w| &w.innovations).filter(move |row| row.measurement == measurement);
        let found = spread(rows().map(|row| row.ratio));
        InnovationSummaryRow {
            measurement,
            windows: found.count,
            mean_ratio: found.mean,
            minimum_ratio: found.minimum,
            maximum_ratio: found.maximum,
            white_windows: rows().filter(|row| row.is_white).count(),
        }
    });
    rows.collect()
}

/// Fits of one coefficient, each from one identification window.
fn single_fits<'a>(results: &'a Results, coefficient: &'a str) -> impl Iterator<Item = &'a FitRow> {
    let windows = results.windows.iter().filter(|window| window.role == WindowRole::Identification.name());
    windows.flat_map(|window| &window.fits).filter(move |fit| fit.coefficient == coefficient && fit.error.is_none())
}

/// Coefficients in the order of the pooled estimate, then those only single windows have.
fn coefficients(results: &Results) -> Vec<&'static str> {
    let mut names: Vec<&'static str> = Vec::new();
    for fit in results.pooled.iter().chain(results.windows.iter().flat_map(|window| &window.fits)) {
        if !names.contains(&fit.coefficient) {
            names.push(fit.coefficient);
        }
    }
    names
}

fn residuals(results: &Results) -> Vec<ResidualSummaryRow> {
    let rows = coefficients(results).into_iter().map(|coefficient| {
        let found = spread(single_fits(results, coefficient).map(|fit| fit.rms_relative_percent));
        ResidualSummaryRow {
            coefficient,
            windows: found.count,
            mean_percent: found.mean,
            minimum_percent: found.minimum,
            maximum_percent: found.maximum,
        }
    });
    rows.filter(|row| row.windows > 0).collect()
}

fn derivatives(results: &Results) -> Vec<DerivativeSummaryRow> {
    let mut rows = Vec::new();
    for coefficient in coefficients(results) {
        let pooled = results.pooled.iter().find(|fit| fit.coefficient == coefficient);
        let pooled: Vec<_> = pooled.iter().flat_map(|fit| &fit.derivatives).collect();
        let mut names: Vec<&str> = Vec::new();
        let single = single_fits(results, coefficient).flat_map(|fit| &fit.derivatives);
        // The constant of one window in a pooled fit is trim of that window, no derivative of the aircraft.
        let shared = pooled.iter().copied().filter(|row| !row.name.contains('['));
        for row in shared.chain(single) {
            if !names.contains(&row.name.as_str()) {
                names.push(&row.name);
            }
        }
        names.sort_by_key(|name| !name.ends_with("_0"));
        for name in names {
            let all = pooled.iter().find(|row| row.name == name);
            let single =
                || single_fits(results, coefficient).flat_map(|fit| &fit.derivatives).filter(|r| r.name == name);
            let estimates = spread(single().map(|row| row.estimate));
            let variances = spread(single().map(|row| row.standard_error.powi(2)));
            rows.push(DerivativeSummaryRow {
                coefficient,
                name: name.to_owned(),
                pooled: all.map(|row| row.estimate),
                held: all.and_then(|row| row.held),
                standard_error: all.map(|row| row.standard_error).filter(|error| !error.is_nan()),
                corrected_standard_error: all.map(|row| row.corrected_standard_error).filter(|error| !error.is_nan()),
                scatter: estimates.deviation,
                windows: estimates.count,
                mean: estimates.mean,
                minimum: estimates.minimum,
                maximum: estimates.maximum,
                mean_variance: variances.mean,
                minimum_variance: variances.minimum,
                maximum_variance: variances.maximum,
            });
        }
    }
    rows
}

fn validation(results: &Results) -> Vec<ValidationRow> {
    let rows = coefficients(results).into_iter().map(|coefficient| {
        let tested = || {
            let role = WindowRole::Validation.name();
            results.predictions.iter().filter(move |row| row.role == role && row.coefficient == coefficient)
        };
        let mean = |of: &dyn Fn(&PredictionAgreement) -> f64| spread(tested().map(|row| of(&row.agreement))).mean;
        ValidationRow {
            coefficient,
            windows: tested().count(),
            agreement: PredictionAgreement {
                r_squared_identified_constants: mean(&|row| row.r_squared_identified_constants),
                rms_relative_percent_identified_constants: mean(&|row| row.rms_relative_percent_identified_constants),
                r_squared_own_constant: mean(&|row| row.r_squared_own_constant),
                rms_relative_percent_own_constant: mean(&|row| row.rms_relative_percent_own_constant),
            },
        }
    });
    rows.filter(|row| row.windows > 0).collect()
}

#[cfg(test)]
mod tests {
    use super::spread;

    #[test]
    fn spread_matches_hand_calculation_and_skips_what_is_missing() {
        let found = spread([2.0, f64::NAN, 4.0, 9.0].into_iter());
        assert_eq!((found.count, found.mean, found.minimum, found.maximum), (3, 5.0, 2.0, 9.0));
        // Squares of -3, -1 and 4 sum to 26, over two degrees of freedom.
        assert!((found.deviation - 13.0_f64.sqrt()).abs() < 1e-15);
        assert!(spread([1.0].into_iter()).deviation.is_nan());
    }
}
