//! `doublet prior`: what was known before the flight, what the flight says, both combined, and whether they contradict each other.

use std::path::{Path, PathBuf};

use clap::Args;
use doublet_core::estimate::{Known, Posterior, combine};
use doublet_core::load::datcom::DatcomListing;
use doublet_engine::export::{IdentifiedCoefficient, IdentifiedModel};
use nalgebra::{DMatrix, DVector};
use serde_json::{Value, json};

use crate::run::computed;
use crate::text::number;
use crate::{datcom, text};

/// Probability below which a difference counts as a contradiction.
const CONTRADICTION: f64 = 0.01;

/// Arguments of `prior`.
#[derive(Debug, Args)]
pub struct PriorArguments {
    /// Session file.
    session: PathBuf,
    /// Earlier estimate: results.json of another run, a table with the columns name, mean and deviation (.csv), or a Digital DATCOM
    /// listing.
    #[arg(long, value_name = "FILE")]
    prior: PathBuf,
    /// Standard deviation of a listing's derivatives as a part of their size; that of a control derivative or damping may be larger.
    #[arg(long, default_value_t = 0.2)]
    relative: f64,
    /// Angle of attack the listing is read at, deg; level flight unless given.
    #[arg(long, value_name = "DEG", allow_negative_numbers = true)]
    alpha_deg: Option<f64>,
    /// Aircraft whose normalisation of rates the listing is turned into.
    #[arg(long)]
    aircraft: Option<String>,
    /// Print one JSON document.
    #[arg(long)]
    json: bool,
}

/// Prints prior, flight and both combined for every derivative, and the test of their conflict for every coefficient.
///
/// # Errors
/// One line: a session without a model, an earlier estimate that cannot be read.
pub fn prior(arguments: &PriorArguments) -> Result<(), String> {
    let known = read(arguments)?;
    let (session, snapshot) = computed(&arguments.session, &[])?;
    let model = IdentifiedModel::new(&session, &snapshot).map_err(|error| error.to_string())?;
    let mut rows = Vec::new();
    let mut tests = Vec::new();
    for coefficient in &model.coefficients {
        let find = |name: &str| known.iter().find(|(known, _)| known == name).map(|(_, known)| *known);
        let priors: Vec<Option<Known>> = coefficient.parameters.iter().map(|row| find(&row.name)).collect();
        if priors.iter().all(Option::is_none) {
            continue;
        }
        let flight: Vec<f64> = coefficient.parameters.iter().map(|row| row.value).collect();
        let found = combine(&flight, &covariance(coefficient), &priors);
        let found = found.ok_or_else(|| format!("{}: its errors are zero", coefficient.coefficient.name()))?;
        tests.push((coefficient.coefficient.name(), found.distance, found.probability));
        rows.extend(derivatives(coefficient, &priors, &found));
    }
    if rows.is_empty() {
        return Err(format!("{}: it has no derivative of the session's model", arguments.prior.display()));
    }
    if arguments.json {
        print_json(&rows, &tests);
    } else {
        print_tables(&rows, &tests);
    }
    Ok(())
}

/// Covariance of the derivatives of a coefficient, from the corrected errors.
fn covariance(coefficient: &IdentifiedCoefficient) -> DMatrix<f64> {
    let errors = coefficient.parameters.iter().map(|row| row.standard_error);
    let errors = DMatrix::from_diagonal(&DVector::from_iterator(coefficient.parameters.len(), errors));
    &errors * &coefficient.correlation * &errors
}

/// A derivative: name, prior, flight, combined, each with its deviation; conflict and its probability.
struct Row {
    name: String,
    prior: Option<Known>,
    flight: Known,
    combined: Known,
    conflict: Option<(f64, f64)>,
}

fn derivatives(coefficient: &IdentifiedCoefficient, priors: &[Option<Known>], found: &Posterior) -> Vec<Row> {
    let row = |(index, row): (usize, &doublet_engine::export::Parameter)| Row {
        name: row.name.clone(),
        prior: priors[index],
        flight: Known { mean: row.value, deviation: row.standard_error },
        combined: Known { mean: found.values[index], deviation: found.covariance[(index, index)].max(0.0).sqrt() },
        conflict: found.conflicts[index].zip(found.probabilities[index]),
    };
    coefficient.parameters.iter().enumerate().map(row).collect()
}

/// Derivatives known before, by name.
fn read(arguments: &PriorArguments) -> Result<Vec<(String, Known)>, String> {
    let path = &arguments.prior;
    let refuse = |what: &str| format!("{}: {what}", path.display());
    let known = match path.extension().and_then(|ending| ending.to_str()) {
        Some("json") => {
            let row =
                |row: datcom::Identified| (row.name, Known { mean: row.estimate, deviation: row.corrected_error });
            datcom::identified(path)?.into_iter().map(row).collect()
        }
        Some("csv") => read_table(path)?,
        _ => {
            if !(arguments.relative > 0.0 && arguments.relative.is_finite()) {
                return Err(format!("--relative is {}: it must be above zero", arguments.relative));
            }
            let listing = DatcomListing::read(path).map_err(|error| error.to_string())?;
            let aircraft = arguments.aircraft.as_deref().map(datcom::aircraft_data).transpose()?;
            let alpha = arguments.alpha_deg.map(f64::to_radians).or_else(|| listing.level_flight_alpha_rad());
            let alpha = alpha
                .ok_or_else(|| refuse("it does not tell the angle of attack of level flight: give --alpha-deg"))?;
            let found = datcom::predicted(&listing, alpha, aircraft.as_ref()).map_err(|error| refuse(&error))?;
            let row = |value: f64| Known { mean: value, deviation: arguments.relative * value.abs() };
            found.into_iter().map(|known| (known.name.to_owned(), row(known.value))).collect::<Vec<_>>()
        }
    };
    let usable = |known: &Known| known.mean.is_finite() && known.deviation.is_finite() && known.deviation > 0.0;
    let known: Vec<_> = known.into_iter().filter(|(_, known)| usable(known)).collect();
    if known.is_empty() { Err(refuse("it has no derivative with a deviation above zero")) } else { Ok(known) }
}

/// Rows `name, mean, deviation` under a header.
fn read_table(path: &Path) -> Result<Vec<(String, Known)>, String> {
    let content = doublet_core::load::read_text(path).map_err(|error| format!("{}: {error}", path.display()))?;
    let row = |(index, line): (usize, &str)| {
        let cells: Vec<&str> = line.split(',').map(str::trim).collect();
        let [name, mean, deviation] = cells[..] else { return Err(index + 1) };
        let number = |cell: &str| cell.parse::<f64>().map_err(|_| index + 1);
        Ok((name.to_owned(), Known { mean: number(mean)?, deviation: number(deviation)? }))
    };
    let lines = content.lines().enumerate().skip(1).filter(|(_, line)| !line.trim().is_empty());
    lines
        .map(row)
        .collect::<Result<_, _>>()
        .map_err(|line| format!("{}: line {line} is not `name,mean,deviation` with two numbers", path.display()))
}

/// A coefficient, its squared distance with the degrees of freedom, and the probability of one as large.
type Test = (&'static str, (f64, usize), f64);

fn print_tables(rows: &[Row], tests: &[Test]) {
    let cell = |known: &Known| format!("{} +- {}", number(known.mean, 4), number(known.deviation, 2));
    let cells = rows.iter().map(|row| {
        let conflict = row.conflict.map_or_else(String::new, |(z, probability)| {
            let word = if probability < CONTRADICTION { ", contradicts" } else { "" };
            format!("{} deviations{word}", number(z, 2))
        });
        let prior = row.prior.as_ref().map_or_else(|| "-".to_owned(), cell);
        vec![row.name.clone(), prior, cell(&row.flight), cell(&row.combined), conflict]
    });
    text::table(&["derivative", "prior", "flight", "combined", "flight less prior"], &cells.collect::<Vec<_>>());
    text::line("");
    for (name, (distance, degrees), probability) in tests {
        let word = if *probability < CONTRADICTION { "prior and flight contradict each other" } else { "agree" };
        text::line(&format!(
            "{name}: {word}; squared distance {} over {degrees}, as large in {} % of cases",
            number(*distance, 3),
            number(100.0 * probability, 2)
        ));
    }
}

fn print_json(rows: &[Row], tests: &[Test]) {
    let known = |known: &Known| json!({ "value": known.mean, "standard_error": known.deviation });
    let row = |row: &Row| {
        json!({
            "name": row.name, "prior": row.prior.as_ref().map(known), "flight": known(&row.flight), "combined": known(&row.combined),
            "deviations": row.conflict.map(|(z, _)| z), "probability": row.conflict.map(|(_, probability)| probability),
        })
    };
    let test = |(name, (distance, degrees), probability): &Test| json!({ "coefficient": name, "distance": distance, "degrees_of_freedom": degrees, "probability": probability });
    let rows: Vec<Value> = rows.iter().map(row).collect();
    let tests: Vec<Value> = tests.iter().map(test).collect();
    text::document(&json!({ "version": 1, "derivatives": rows, "coefficients": tests }).to_string());
}
