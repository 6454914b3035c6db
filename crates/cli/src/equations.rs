//! `doublet equations`: parameters of equations of motion from the columns of a table.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use clap::Args;
use doublet_core::estimate::{EquationFault, EquationFit, FilterErrorFit, ProcessNoise};
use doublet_core::load::read_text;
use doublet_core::series::TimeRange;
use doublet_engine::study::{
    EquationRequest, EquationStudy, equation_text, fit_equations, names_of_equations, shipped_equations,
};
use serde_json::{Value, json};

use crate::outcome::Outcome;
use crate::text;

#[derive(Debug, Args)]
pub struct EquationArguments {
    /// Table: text, or any recording whose channels are the columns, unconverted.
    pub table: PathBuf,
    /// File of equations, or short-period, longitudinal or lateral.
    #[arg(long, value_name = "FILE")]
    pub equations: String,
    /// Column or expression of an input or output: alpha=ALPHA*pi/180.
    #[arg(long, value_name = "NAME=COLUMN", value_parser = pair)]
    pub column: Vec<(String, String)>,
    /// Override a constant of the equations.
    #[arg(long, value_name = "NAME=VALUE", value_parser = number)]
    pub constant: Vec<(String, f64)>,
    /// Time column, s, or an expression of columns.
    #[arg(long, value_name = "COLUMN")]
    pub time: Option<String>,
    /// Row interval, s, if the table has no time.
    #[arg(long, value_name = "S", conflicts_with = "time")]
    pub dt: Option<f64>,
    /// Time range to use, s [default: all rows]. Repeatable.
    #[arg(long, value_name = "START:END", value_parser = window)]
    pub window: Vec<TimeRange>,
    /// Half-width of the differentiation in equation error, s.
    #[arg(long, value_name = "S", value_parser = positive)]
    pub half_width: Option<f64>,
    /// Piece length of output error, s, for unstable motions.
    #[arg(long, value_name = "S", value_parser = positive)]
    pub piece: Option<f64>,
}

fn pair(text: &str) -> Result<(String, String), String> {
    let (name, column) = text.split_once('=').ok_or("write it as NAME=COLUMN")?;
    Ok((name.trim().to_owned(), column.trim().to_owned()))
}

fn number(text: &str) -> Result<(String, f64), String> {
    let (name, value) = pair(text)?;
    let value = value.parse::<f64>().ok().filter(|value| value.is_finite());
    Ok((name, value.ok_or_else(|| format!("'{text}': the value must be a number"))?))
}

fn positive(text: &str) -> Result<f64, String> {
    let value = text.parse::<f64>().ok().filter(|value| value.is_finite() && *value > 0.0);
    value.ok_or_else(|| format!("'{text}' must be a length above 0 s"))
}

fn window(text: &str) -> Result<TimeRange, String> {
    let (start, end) = text.split_once(':').ok_or("write it as START:END, in s")?;
    let time = |text: &str| text.trim().parse::<f64>().map_err(|_| format!("'{text}' must be a time in s"));
    let (start_s, end_s) = (time(start)?, time(end)?);
    if start_s < end_s {
        Ok(TimeRange { start_s, end_s })
    } else {
        Err(format!("'{text}': the end is not after the start"))
    }
}

/// Fits equations of motion and prints their parameters by all methods.
pub fn equations(arguments: &EquationArguments) -> Result<Outcome, String> {
    if let Some(dt) = arguments.dt.filter(|dt| !(dt.is_finite() && *dt > 0.0)) {
        return Err(format!("--dt {dt}: the interval must be above 0 s"));
    }
    let text = match shipped_equations(&arguments.equations) {
        Some(text) => text.to_owned(),
        None => {
            let file = Path::new(&arguments.equations);
            let known = names_of_equations().join(", ");
            let missing = |error| format!("{}: {error}; name a file, or one of {known}", arguments.equations);
            read_text(file).map_err(missing)?
        }
    };
    let constants: BTreeMap<String, f64> = arguments.constant.iter().cloned().collect();
    let equations = equation_text(&text, &constants).map_err(|error| format!("{}: {error}", arguments.equations))?;
    let request = EquationRequest {
        equations,
        columns: arguments.column.iter().cloned().collect(),
        time: arguments.time.clone(),
        step_s: arguments.dt,
        windows: arguments.window.clone(),
        half_width_s: arguments.half_width,
        piece_s: arguments.piece,
    };
    let found = fit_equations(&arguments.table, &request).map_err(|error| error.to_string())?;
    text::json(&equation_document(&found))?;
    print(&found);
    text::verdict(&found.verdict);
    Ok(found.verdict.level.into())
}

fn describe_result(result: Result<&EquationFit, &EquationFault>) -> Value {
    match result {
        Ok(found) => describe_fit(found, found.fit.names.len()),
        Err(error) => json!({ "error": error.to_string() }),
    }
}

/// Filter error: its fit, with the noise that drives the states.
fn describe_filter(result: &Result<FilterErrorFit, EquationFault>) -> Value {
    let found = match result {
        Ok(found) => found,
        Err(error) => return json!({ "error": error.to_string() }),
    };
    let mut described = describe_fit(&found.estimate, found.estimate.fit.names.len() - found.process_noise.len());
    let process = found.process_noise.iter().map(|noise| {
        json!({ "state": noise.state, "intensity": noise.intensity, "log_error": noise.log_error, "is_none": noise.is_none })
    });
    described["process_noise"] = process.collect();
    let measurement = found.estimate.compared.iter().zip(&found.measurement_noise);
    described["measurement_noise"] =
        measurement.map(|(name, value)| json!({ "name": name, "standard_deviation": value })).collect();
    described
}

/// Parameters, initial states up to `end`, and outputs.
fn describe_fit(found: &EquationFit, end: usize) -> Value {
    let fit = &found.fit;
    let row = |index: usize| describe_parameter(found, index);
    let outputs = found
        .compared
        .iter()
        .zip(&fit.quality)
        .map(|(name, quality)| json!({ "name": name, "r_squared": quality.r_squared, "rms": quality.rms }));
    let outputs: Vec<Value> = outputs.collect();
    let covariance = |row: usize| -> Vec<f64> {
        (0..found.parameters).map(|column| found.corrected_covariance[(row, column)]).collect()
    };
    json!({
        "parameters": (0..found.parameters).map(row).collect::<Vec<_>>(),
        "covariance": (0..found.parameters).map(covariance).collect::<Vec<_>>(),
        "initial": (found.parameters..end).map(row).collect::<Vec<_>>(),
        "outputs": outputs,
        "samples": found.time_s.len(),
    })
}

fn describe_parameter(found: &EquationFit, index: usize) -> Value {
    json!({
        "name": found.fit.names[index],
        "estimate": found.fit.estimates[index],
        "standard_error": found.fit.standard_errors[index],
        "corrected_standard_error": found.corrected_errors[index],
    })
}

/// The document of `doublet equations --json`.
pub fn equation_document(found: &EquationStudy) -> Value {
    json!({
        "version": 1,
        "program": concat!("doublet ", env!("CARGO_PKG_VERSION")),
        "records": found.records.len(),
        "equation_error": describe_result(found.equation_error.as_ref()),
        "output_error": describe_result(found.output_error.as_ref()),
        "filter_error": describe_filter(&found.filter_error),
        "is_driven_by_noise": found.is_driven_by_noise(),
        "verdict": found.verdict,
    })
}

fn print(found: &EquationStudy) {
    let all = [
        ("equation error", found.equation_error.as_ref()),
        ("output error", found.output_error.as_ref()),
        ("filter error", found.filter_error.as_ref().map(|filter| &filter.estimate)),
    ];
    let fits: Vec<(&str, &EquationFit)> = all.iter().filter_map(|(name, fit)| Some((*name, fit.ok()?))).collect();
    let mut rows = Vec::new();
    if let Some((_, first)) = fits.first() {
        for index in 0..first.parameters {
            let mut row = vec![first.fit.names[index].clone()];
            for (_, found) in &fits {
                row.push(text::number(found.fit.estimates[index], 5));
                row.push(text::number(found.corrected_errors[index], 2));
            }
            rows.push(row);
        }
    }
    let mut header = vec!["parameter"];
    for (name, _) in &fits {
        header.extend([*name, "corrected error"]);
    }
    text::table(&header, &rows);
    for (name, found) in &fits {
        let fit_quality_text = |(output, quality): (&String, &doublet_core::estimate::FitQuality)| {
            format!("{output} {}", text::number(quality.r_squared, 4))
        };
        let quality: Vec<String> = found.compared.iter().zip(&found.fit.quality).map(fit_quality_text).collect();
        text::line(&format!("{name}: R2 of {}", quality.join(", ")));
    }
    if let Ok(filter) = &found.filter_error {
        let shown = |noise: &ProcessNoise| {
            let value = if noise.is_none { "none".to_owned() } else { text::number(noise.intensity, 3) };
            format!("{} {value}", noise.state)
        };
        let noise: Vec<String> = filter.process_noise.iter().map(shown).collect();
        text::line(&format!("filter error: process noise per root second of {}", noise.join(", ")));
    }
    if found.is_driven_by_noise() {
        text::line("Process noise drives the motion: use the parameters of filter error.");
    }
    for (name, error) in all.iter().filter_map(|(name, fit)| Some((name, fit.err()?))) {
        text::line(&format!("{name}: {error}"));
    }
}
