//! Studies as flat rows: the same in `results.json` and in their CSV tables.

use doublet_core::sensitivity::NoiseEffect;
use serde::{Serialize, Serializer};

use super::equivalent_levels::{ResponseLevelsRow, response_levels};
use super::responses::{ModeComparisonRow, ResponseRow, SystemRow, flight_rows, mode_comparison_table, response_table};
use super::table::{Table, table};
use crate::graph::StageResult;
use crate::session::Finding;
use crate::snapshot::{ExperimentRow, Snapshot};
use crate::study::{
    CheckedDerivative, ConditionRegression, ControlLag, LagStudy, ManoeuvreStudy, MonteCarloStudy, SensitivityStudy,
    WindowChecks,
};

/// Results of the studies that were asked for; what was not is absent.
#[derive(Clone, Debug, Default, Serialize)]
pub struct StudyResults {
    /// Every derivative for every input quantity.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub sensitivity: Vec<SensitivityRow>,
    /// The same as bars of a tornado chart, the widest first for each derivative.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub tornado: Vec<TornadoRow>,
    /// Error of each derivative by noise and by the quantities of the sensitivity together.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub total_errors: Vec<TotalErrorRow>,
    /// Pooled derivatives without each manoeuvre in turn.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub leave_one_out: Vec<LeftOutRow>,
    /// Derivatives by kind of input.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub input_kinds: Vec<KindRow>,
    /// Share of every term in its coefficient.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub contributions: Vec<ContributionRow>,
    /// Derivatives over the flight condition.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub conditions: Vec<ConditionRow>,
    /// Derivatives of every manoeuvre by other methods.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub checks: Vec<CheckRow>,
    /// Output errors that do not follow their recordings.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub check_findings: Vec<Finding>,
    /// Lag and delay of every control.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub lags: Vec<LagRow>,
    /// Frequency responses of the rates to the controls.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub response: Vec<ResponseRow>,
    /// Parameters of their low-order equivalent systems.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub equivalent_systems: Vec<SystemRow>,
    /// Levels of flying qualities by them.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub equivalent_levels: Vec<ResponseLevelsRow>,
    /// Natural modes by these beside those of the identified model.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub mode_comparison: Vec<ModeComparisonRow>,
    /// Effect of recording noise on the derivatives.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub monte_carlo: Vec<MonteCarloRow>,
    /// The session as it is, then each of its experiments.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub experiments: Vec<ExperimentRow>,
}

/// One derivative of one window by another method, beside its equation-error estimate.
#[derive(Clone, Debug, Serialize)]
pub struct CheckRow {
    /// Manoeuvre.
    pub window: String,
    /// `frequency domain`, `output error` or `filter error`.
    pub method: &'static str,
    /// Motion fitted by output or filter error; empty for the frequency domain.
    pub axis: &'static str,
    /// Derivative; initial states, biases and outputs of output error and the process noise of filter error among them.
    pub derivative: String,
    /// Estimate by this method.
    #[serde(serialize_with = "where_finite")]
    pub estimate: f64,
    #[serde(serialize_with = "where_finite")]
    pub standard_error: f64,
    /// Estimate by equation error in the time domain from the same manoeuvre.
    #[serde(serialize_with = "where_finite")]
    pub equation_error: f64,
    /// Its corrected standard error.
    #[serde(serialize_with = "where_finite")]
    pub equation_standard_error: f64,
    /// Of an output: coefficient of determination of the simulation.
    #[serde(serialize_with = "where_finite")]
    pub r_squared: f64,
    /// Of an output: largest magnitude of recorded minus simulated, SI.
    #[serde(serialize_with = "where_finite")]
    pub largest_deviation: f64,
    /// Of an initial state: its distance from the flight path in joint standard deviations.
    #[serde(serialize_with = "where_finite")]
    pub distance: f64,
    /// Why the estimate is missing.
    pub error: Option<String>,
}

/// What noise of the recording does to one derivative.
#[derive(Clone, Debug, Serialize)]
pub struct MonteCarloRow {
    pub derivative: String,
    pub estimate: f64,
    /// Standard deviation over the realisations.
    pub noise_error: f64,
    /// Mean over the realisations minus the estimate.
    pub shift: f64,
    /// Standard error of the shift.
    pub shift_error: f64,
    /// Estimate minus the shift.
    pub extrapolated: f64,
    /// 2.5 % quantile of the realisations about their mean.
    pub low: f64,
    /// 97.5 % quantile about the mean.
    pub high: f64,
    /// Realisations used.
    pub realisations: usize,
    pub seed: u64,
}

/// Lag or delay of one control.
#[derive(Clone, Debug, Serialize)]
pub struct LagRow {
    pub control: &'static str,
    /// `delay` or `first-order lag`.
    pub kind: &'static str,
    /// Coefficient; empty for all together.
    pub coefficient: &'static str,
    #[serde(serialize_with = "where_finite")]
    pub value_s: f64,
    /// Standard error corrected for correlated residuals, s.
    #[serde(serialize_with = "where_finite")]
    pub standard_error_s: f64,
    /// Coefficient of determination of the fit with the lag or delay found from all coefficients.
    #[serde(serialize_with = "where_finite")]
    pub r_squared: f64,
    /// Why the value is missing.
    pub error: Option<String>,
}

/// One derivative against one quantity.
#[derive(Clone, Debug, Serialize)]
pub struct SensitivityRow {
    /// Table of the thesis.
    pub table: &'static str,
    pub quantity: String,
    /// Unit of its value, its step and its change.
    pub unit: &'static str,
    pub value: f64,
    /// Half width of the central difference.
    pub step: f64,
    pub derivative: String,
    pub estimate: f64,
    /// Estimate one step below.
    pub low: f64,
    /// Estimate one step above.
    pub high: f64,
    /// Change per unit of the quantity.
    pub partial: f64,
    /// Change over one step, per cent of the estimate.
    pub relative_percent: f64,
    /// Change over one step in corrected standard errors.
    pub in_standard_errors: f64,
}

/// One bar of a tornado chart.
#[derive(Clone, Debug, Serialize)]
pub struct TornadoRow {
    pub derivative: String,
    pub quantity: String,
    /// Change of the derivative one step below, per cent.
    pub low_percent: f64,
    /// Change one step above, per cent.
    pub high_percent: f64,
    /// Change over one step in corrected standard errors.
    pub in_standard_errors: f64,
}

/// Total error of one derivative.
#[derive(Clone, Debug, Serialize)]
pub struct TotalErrorRow {
    pub derivative: String,
    /// Pooled estimate.
    pub estimate: f64,
    /// Its corrected standard error.
    pub standard_error: f64,
    /// Root sum of squares of its changes over one step of each quantity.
    pub by_quantities: f64,
    /// Root sum of squares of both.
    pub total: f64,
}

/// One derivative without one window, and the prediction of that window by the others.
#[derive(Clone, Debug, Serialize)]
pub struct LeftOutRow {
    pub coefficient: &'static str,
    /// Manoeuvre left out.
    pub window: String,
    pub derivative: String,
    /// Estimate without the manoeuvre.
    pub estimate: f64,
    /// Its change in standard errors of the full fit.
    pub shift_in_errors: f64,
    /// Coefficient of determination of the coefficient predicted over the manoeuvre with the constants of the others, their mean if
    /// separate.
    #[serde(serialize_with = "where_finite")]
    pub r_squared_identified_constants: f64,
    /// Root mean square of the residual there over the largest observation, per cent.
    #[serde(serialize_with = "where_finite")]
    pub rms_relative_percent_identified_constants: f64,
    /// The first with the constant fitted to the manoeuvre itself.
    #[serde(serialize_with = "where_finite")]
    pub r_squared_own_constant: f64,
    /// The second likewise.
    #[serde(serialize_with = "where_finite")]
    pub rms_relative_percent_own_constant: f64,
}

/// One derivative from manoeuvres of two kinds of input.
#[derive(Clone, Debug, Serialize)]
pub struct KindRow {
    pub coefficient: &'static str,
    pub derivative: String,
    pub first_kind: String,
    /// Number of its manoeuvres.
    pub first_count: usize,
    /// Mean over them.
    pub first_mean: f64,
    /// Standard deviation over them.
    #[serde(serialize_with = "where_finite")]
    pub first_scatter: f64,
    pub second_kind: String,
    /// Number of its manoeuvres.
    pub second_count: usize,
    /// Mean over them.
    pub second_mean: f64,
    /// Standard deviation over them.
    #[serde(serialize_with = "where_finite")]
    pub second_scatter: f64,
    /// Difference of the means over its standard error.
    #[serde(serialize_with = "where_finite")]
    pub difference_in_errors: f64,
}

/// Share of one term in a coefficient over one window.
#[derive(Clone, Debug, Serialize)]
pub struct ContributionRow {
    /// Manoeuvre.
    pub window: String,
    pub coefficient: &'static str,
    /// Derivative of the term.
    pub derivative: String,
    /// Root mean square of the term about its mean over that of the observed coefficient.
    #[serde(serialize_with = "where_finite")]
    pub share: f64,
}

/// One parameter of a derivative as a linear function of the flight condition.
#[derive(Clone, Debug, Serialize)]
pub struct ConditionRow {
    pub derivative: String,
    /// Variables of the regression, `V` m/s, `h` m, `alpha` rad.
    pub variables: String,
    /// `value` at the mean condition, or the variable of the slope.
    pub parameter: String,
    /// Mean of the variable.
    #[serde(serialize_with = "where_finite")]
    pub mean: f64,
    /// Value or slope.
    #[serde(serialize_with = "where_finite")]
    pub estimate: f64,
    #[serde(serialize_with = "where_finite")]
    pub standard_error: f64,
    /// Scatter of the manoeuvres about the line over their stated errors.
    #[serde(serialize_with = "where_finite")]
    pub scatter_ratio: f64,
    pub manoeuvres: usize,
    /// Why the regression failed.
    pub error: Option<String>,
}

/// A number that does not exist is `null` in JSON and empty in CSV.
pub(super) fn where_finite<S: Serializer>(value: &f64, serializer: S) -> Result<S::Ok, S::Error> {
    if value.is_finite() { serializer.serialize_some(value) } else { serializer.serialize_none() }
}

/// Rows of the studies that are up to date.
pub fn build(snapshot: &Snapshot) -> StudyResults {
    let mut results = StudyResults::default();
    if let Some(study) = snapshot.studies.sensitivity.ready() {
        add_sensitivity(&mut results, study);
    }
    if let Some(study) = snapshot.studies.manoeuvres.ready() {
        add_manoeuvres(&mut results, study);
    }
    if let Some(study) = snapshot.studies.checks.ready() {
        results.checks.extend(study.windows.iter().flat_map(|window| check_rows(snapshot, window)));
        results.check_findings = study.findings();
    }
    if let Some(study) = snapshot.studies.lags.ready() {
        results.lags = lag_rows(study);
    }
    if let Some(study) = snapshot.studies.responses.ready() {
        (results.response, results.equivalent_systems) = flight_rows(study);
        results.equivalent_levels = response_levels(study);
        results.mode_comparison = study.compared_modes().map(Into::into).collect();
    }
    if let Some(study) = snapshot.studies.monte_carlo.ready() {
        results.monte_carlo = monte_carlo_rows(study);
    }
    let rows = [&snapshot.studies.experiments, &snapshot.inquiries.experiments];
    let rows = rows.map(|rows| rows.0.iter().filter_map(|(_, slot)| slot.ready()));
    if let Some(known) = rows.into_iter().find(|rows| rows.clone().next().is_some()) {
        results.experiments = known.map(|row| ExperimentRow::clone(row)).collect();
    }
    results
}

fn add_sensitivity(results: &mut StudyResults, study: &SensitivityStudy) {
    for table in &study.tables {
        let quantity = &table.step.quantity;
        results.sensitivity.extend(table.partials.iter().map(|partial| SensitivityRow {
            table: quantity.group().name(),
            quantity: quantity.name(),
            unit: quantity.unit(),
            value: table.step.nominal,
            step: table.step.half_width,
            derivative: partial.derivative.clone(),
            estimate: partial.nominal,
            low: partial.low,
            high: partial.high,
            partial: partial.partial,
            relative_percent: partial.relative_percent,
            in_standard_errors: partial.in_standard_errors,
        }));
    }
    results.tornado.extend(study.tornado.iter().map(|bar| TornadoRow {
        derivative: bar.derivative.clone(),
        quantity: bar.quantity.clone(),
        low_percent: bar.change_percent[0],
        high_percent: bar.change_percent[1],
        in_standard_errors: bar.in_standard_errors,
    }));
}

fn add_manoeuvres(results: &mut StudyResults, study: &ManoeuvreStudy) {
    for found in &study.left_out {
        for left in &found.windows {
            let entries = found.derivatives.iter().zip(&left.estimates).zip(&left.shift_in_errors);
            results.leave_one_out.extend(entries.map(|((derivative, estimate), shift)| LeftOutRow {
                coefficient: found.coefficient.name(),
                window: left.label.clone(),
                derivative: derivative.clone(),
                estimate: *estimate,
                shift_in_errors: *shift,
                r_squared_identified_constants: left.quality_identified.r_squared,
                rms_relative_percent_identified_constants: left.quality_identified.rms_relative_percent,
                r_squared_own_constant: left.quality_own_constant.r_squared,
                rms_relative_percent_own_constant: left.quality_own_constant.rms_relative_percent,
            }));
        }
    }
    results.input_kinds = kind_rows(study);
    for found in &study.contributions {
        results.contributions.extend(found.terms.iter().map(|term| ContributionRow {
            window: found.window.clone(),
            coefficient: found.coefficient.name(),
            derivative: term.derivative.clone(),
            share: term.share,
        }));
    }
    results.conditions.extend(study.conditions.iter().flat_map(condition_rows));
}

/// Derivatives by kind of input.
pub fn kind_rows(study: &ManoeuvreStudy) -> Vec<KindRow> {
    let rows = study.kinds.iter().flat_map(|found| {
        found.derivatives.iter().map(|derivative| KindRow {
            coefficient: found.coefficient.name(),
            derivative: derivative.first.name.clone(),
            first_kind: found.kinds[0].clone(),
            first_count: derivative.first.fits,
            first_mean: derivative.first.estimate[0],
            first_scatter: derivative.first.scatter,
            second_kind: found.kinds[1].clone(),
            second_count: derivative.second.fits,
            second_mean: derivative.second.estimate[0],
            second_scatter: derivative.second.scatter,
            difference_in_errors: derivative.difference_in_errors,
        })
    });
    rows.collect()
}

/// What noise of the recording does to each derivative.
pub fn monte_carlo_rows(study: &MonteCarloStudy) -> Vec<MonteCarloRow> {
    study.effects.iter().map(|effect| monte_carlo_row(study, effect)).collect()
}

fn monte_carlo_row(study: &MonteCarloStudy, effect: &NoiseEffect) -> MonteCarloRow {
    MonteCarloRow {
        derivative: effect.derivative.clone(),
        estimate: effect.estimate,
        noise_error: effect.scatter,
        shift: effect.shift,
        shift_error: effect.shift_error,
        extrapolated: effect.extrapolated(),
        low: effect.quantiles[0],
        high: effect.quantiles[1],
        realisations: study.request.realisations - study.failed,
        seed: study.request.seed,
    }
}

fn check_rows(snapshot: &Snapshot, checks: &WindowChecks) -> Vec<CheckRow> {
    let own = snapshot.windows.get(&checks.window).and_then(|results| results.fits.ready());
    let equation_error = |name: &str| {
        let found = own.iter().flat_map(|fits| &fits.fits).find_map(|fit| {
            let estimate = fit.fit.as_ref().ok()?;
            let index = estimate.names.iter().position(|other| other == name)?;
            Some((estimate.estimates[index], fit.corrected_errors[index]))
        });
        found.unwrap_or((f64::NAN, f64::NAN))
    };
    let mut rows = Vec::new();
    for (method, part, found) in checks.results() {
        let blank = |name: &str| CheckRow {
            window: checks.window.clone(),
            method: method.name,
            axis: part.axis(),
            derivative: name.to_owned(),
            estimate: f64::NAN,
            standard_error: f64::NAN,
            equation_error: f64::NAN,
            equation_standard_error: f64::NAN,
            r_squared: f64::NAN,
            largest_deviation: f64::NAN,
            distance: f64::NAN,
            error: None,
        };
        let found = match found {
            Ok(found) => found,
            Err(error) => {
                rows.push(CheckRow { error: Some(error.to_string()), ..blank(part.name()) });
                continue;
            }
        };
        let row = |derivative: &CheckedDerivative| {
            let (equation_error, equation_standard_error) = equation_error(&derivative.name);
            let (estimate, standard_error) = (derivative.estimate, derivative.standard_error);
            let blank = blank(&derivative.name);
            CheckRow { estimate, standard_error, equation_error, equation_standard_error, ..blank }
        };
        rows.extend(found.derivatives.iter().map(row));
        let flight = found.flight.iter();
        let starts = flight.clone().flat_map(|flight| &flight.starts).map(|start| start.distance);
        let others = found.others.iter().zip(starts.chain(std::iter::repeat(f64::NAN)));
        rows.extend(others.map(|(other, distance)| CheckRow { distance, ..row(other) }));
        rows.extend(flight.flat_map(|flight| &flight.outputs).map(|output| CheckRow {
            r_squared: output.r_squared,
            largest_deviation: output.largest_deviation,
            ..blank(output.output.name())
        }));
    }
    rows
}

/// Lag and delay of every control, from all coefficients and from each.
pub fn lag_rows(study: &LagStudy) -> Vec<LagRow> {
    study.lags.iter().flat_map(rows_of_lag).collect()
}

fn rows_of_lag(lag: &ControlLag) -> Vec<LagRow> {
    let fits = lag.result.iter().flat_map(|search| &search.fits).map(|fit| fit.fit.quality.r_squared);
    let single = lag.by_coefficient().into_iter().zip(fits);
    let single =
        single.map(|((coefficient, found), r_squared)| lag_row(lag, coefficient.name(), found, Some(r_squared)));
    std::iter::once(lag_row(lag, "", lag.found_s(), lag.r_squared())).chain(single).collect()
}

fn lag_row(
    lag: &ControlLag,
    coefficient: &'static str,
    found: StageResult<(f64, f64)>,
    r_squared: Option<f64>,
) -> LagRow {
    let (value_s, standard_error_s) = *found.as_ref().unwrap_or(&(f64::NAN, f64::NAN));
    LagRow {
        control: lag.surface.variable().name(),
        kind: lag.kind.name(),
        coefficient,
        value_s,
        standard_error_s,
        r_squared: r_squared.unwrap_or(f64::NAN),
        error: found.err().map(String::from),
    }
}

fn condition_rows(found: &ConditionRegression) -> Vec<ConditionRow> {
    match &found.result {
        Err(error) => vec![condition_row(found, "value", [f64::NAN; 4], Some(error.to_string()))],
        Ok(result) => {
            let means = std::iter::once(&f64::NAN).chain(&result.mean);
            let fit = &result.fit;
            let values = fit.names.iter().zip(means).zip(fit.estimates.iter().zip(&fit.standard_errors));
            let rows = values.map(|((name, &mean), (&estimate, &error))| {
                condition_row(found, name, [mean, estimate, error, result.scatter_ratio], None)
            });
            rows.collect()
        }
    }
}

fn condition_row(
    found: &ConditionRegression,
    parameter: &str,
    numbers: [f64; 4],
    error: Option<String>,
) -> ConditionRow {
    ConditionRow {
        derivative: found.derivative.clone(),
        variables: found.variables.join(" "),
        parameter: parameter.to_owned(),
        mean: numbers[0],
        estimate: numbers[1],
        standard_error: numbers[2],
        scatter_ratio: numbers[3],
        manoeuvres: found.points.len(),
        error,
    }
}

/// One table per study that was asked for.
pub fn tables(results: &StudyResults) -> Vec<Table> {
    let tables = [
        table("sensitivity", "Sensitivity of the derivatives to their inputs.", &results.sensitivity),
        table("tornado", "Change of each derivative over one step of each quantity.", &results.tornado),
        table("total_errors", "Error of each derivative by noise and by the varied quantities.", &results.total_errors),
        table("leave_one_out", "Pooled derivatives without each manoeuvre in turn.", &results.leave_one_out),
        table("input_kinds", "Derivatives by kind of input.", &results.input_kinds),
        table("contributions", "Share of every term in its coefficient.", &results.contributions),
        table("conditions", "Derivatives over the flight condition.", &results.conditions),
        table("checks", "Derivatives of every manoeuvre by other methods.", &results.checks),
        table("lags", "Delay and first-order lag of every control.", &results.lags),
        response_table(&results.response),
        table("equivalent_systems", "Low-order equivalent systems of the responses.", &results.equivalent_systems),
        Some(mode_comparison_table(&results.mode_comparison)).filter(|table| !table.rows.is_empty()),
        table("monte_carlo", "Effect of measurement noise on each pooled derivative.", &results.monte_carlo),
    ];
    tables.into_iter().flatten().collect()
}
