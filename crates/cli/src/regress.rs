//! `doublet regress`: least squares on the columns of a table.

use std::path::{Path, PathBuf};

use clap::{Args, ValueEnum};
use doublet_engine::keep;
use doublet_engine::study::{TableFit, TableRegression, TermChoice, regress_table};
use serde_json::{Value, json};

use crate::output_path::output_path;
use crate::text;

#[derive(Debug, Args)]
pub struct RegressArguments {
    /// Table: text, or any recording whose channels are the columns, unconverted.
    pub table: PathBuf,
    /// Column to fit, or an expression of columns.
    #[arg(long, value_name = "NAME")]
    pub y: String,
    /// Terms, comma-separated: "1", columns, or expressions such as alpha^2 or q*2.1/(2*V).
    #[arg(long, value_name = "TERM,TERM")]
    pub terms: String,
    /// Row interval, s, if the table has no time (for --out).
    #[arg(long, value_name = "S")]
    pub dt: Option<f64>,
    /// Column with the standard deviation of each row [default: equal].
    #[arg(long, value_name = "NAME")]
    pub deviations: Option<String>,
    /// Selection of the terms.
    #[arg(long, value_enum, default_value_t = Choice::All)]
    pub method: Choice,
    /// CSV file for measured values, fitted values and residuals.
    #[arg(long, value_name = "FILE", value_parser = output_path())]
    pub out: Option<PathBuf>,
}

/// Selection of terms.
#[derive(Clone, Copy, Debug, ValueEnum)]
pub enum Choice {
    /// All terms.
    All,
    /// Stepwise, by partial correlation and partial F.
    Stepwise,
    /// Orthogonal functions, to the least predicted squared error.
    Orthogonal,
}

/// Fits a column of a table and prints the estimates with their errors.
pub fn regress(arguments: &RegressArguments) -> Result<(), String> {
    if let Some(dt) = arguments.dt.filter(|dt| !(dt.is_finite() && *dt > 0.0)) {
        return Err(format!("--dt {dt}: the interval must be above 0 s"));
    }
    if let Some(out) = &arguments.out {
        keep::check_apart(out, [arguments.table.clone()])?;
    }
    let regression = TableRegression {
        output: arguments.y.trim().to_owned(),
        terms: split_terms(&arguments.terms)?,
        deviations: arguments.deviations.clone(),
        choice: match arguments.method {
            Choice::All => TermChoice::All,
            Choice::Stepwise => TermChoice::Stepwise,
            Choice::Orthogonal => TermChoice::Orthogonal,
        },
    };
    let found = regress_table(&arguments.table, &regression).map_err(|error| error.to_string())?;
    if let Some(out) = &arguments.out {
        write_rows(out, &found, arguments.dt)?;
    }
    text::json(&describe(&regression.output, &found))?;
    print(&regression.output, &found);
    Ok(())
}

/// Terms of a list; commas inside brackets or quotes belong to a term.
pub fn split_terms(text: &str) -> Result<Vec<String>, String> {
    let mut terms = vec![String::new()];
    let (mut depth, mut is_quoted) = (0_i32, false);
    for letter in text.chars() {
        match letter {
            '(' | '{' => depth += 1,
            ')' | '}' => depth -= 1,
            '"' => is_quoted = !is_quoted,
            ',' if depth <= 0 && !is_quoted => {
                terms.push(String::new());
                continue;
            }
            _ => {}
        }
        if let Some(term) = terms.last_mut() {
            term.push(letter);
        }
    }
    let terms: Vec<String> = terms.iter().map(|term| term.trim().to_owned()).collect();
    if let Some(index) = terms.iter().position(String::is_empty) {
        return Err(format!("--terms '{text}': term {} is empty", index + 1));
    }
    if let Some((index, term)) = terms.iter().enumerate().find(|(index, term)| terms[..*index].contains(term)) {
        return Err(format!("--terms '{text}': '{term}' appears twice, again as term {}", index + 1));
    }
    Ok(terms)
}

fn describe(output: &str, found: &TableFit) -> Value {
    let fit = &found.fit;
    let derivatives = (0..fit.parameters()).map(|index| {
        json!({
            "name": fit.names[index],
            "term": found.terms[index],
            "estimate": fit.estimates[index],
            "standard_error": fit.standard_errors[index],
            "corrected_standard_error": found.corrected_standard_errors[index],
            "relative_error_percent": fit.relative_errors_percent[index],
            "t": fit.t_values[index],
        })
    });
    let derivatives: Vec<Value> = derivatives.collect();
    let rows: Vec<Vec<f64>> = fit.correlation.row_iter().map(|row| row.iter().copied().collect()).collect();
    json!({
        "version": 1,
        "program": doublet_engine::PROGRAM,
        "y": output,
        "samples": fit.samples(),
        "rows": found.rows_in_table,
        "r_squared": fit.quality.r_squared,
        "residual_deviation": fit.residual_std,
        "rms": fit.quality.rms,
        "condition_number": fit.condition_number,
        "press": found.press,
        "predicted_squared_error": found.predicted_squared_error,
        "derivatives": derivatives,
        "parameter_correlation": rows,
        "dropped": found.dropped,
    })
}

fn print(output: &str, found: &TableFit) {
    let (fit, number) = (&found.fit, |value: f64| text::number(value, 6));
    text::line(&format!("{output} over {} of {} rows", fit.samples(), found.rows_in_table));
    let rows: Vec<Vec<String>> = (0..fit.parameters())
        .map(|index| {
            vec![
                format!("  {}", fit.names[index]),
                number(fit.estimates[index]),
                text::number(fit.standard_errors[index], 3),
                text::number(found.corrected_standard_errors[index], 3),
                text::number(fit.t_values[index], 3),
            ]
        })
        .collect();
    text::table(&["  parameter", "estimate", "std error", "corrected", "t"], &rows);
    text::line(&format!(
        "R2 {}, residual {}, PRESS {}, predicted squared error {}, condition number {}",
        number(fit.quality.r_squared),
        text::number(fit.residual_std, 4),
        text::number(found.press, 4),
        text::number(found.predicted_squared_error, 4),
        text::number(fit.condition_number, 3)
    ));
    if !found.dropped.is_empty() {
        text::line(&format!("not taken: {}", found.dropped.join(", ")));
    }
}

/// Writes a line per row used: its number or time, and what was measured, fitted and left.
fn write_rows(path: &Path, found: &TableFit, dt: Option<f64>) -> Result<(), String> {
    let mut lines = vec![format!("{},measured,fitted,residual", if dt.is_some() { "time_s" } else { "row" })];
    let fitted = found.fit.fitted(&found.measured);
    for (index, row) in found.rows.iter().enumerate() {
        let at = dt.map_or_else(|| row.to_string(), |dt| (dt * *row as f64).to_string());
        lines.push(format!("{at},{},{},{}", found.measured[index], fitted[index], found.fit.residuals[index]));
    }
    let text = lines.join("\n") + "\n";
    keep::replace(path, text.as_bytes())
        .map_err(|error| format!("{}: {error}; name a file that can be written", path.display()))
}
