//! `doublet prior`: what was known before the flight, what the flight says, both combined, and whether they contradict each other.

use std::path::{Path, PathBuf};

use clap::Args;
use doublet_core::load::datcom::DatcomListing;
use doublet_engine::graph::Context;
use doublet_engine::prior::{PriorRequest, PriorStudy, PriorValue};
use doublet_engine::report::{Reference, reference};
use doublet_engine::run::{Snapshot, answer};
use doublet_engine::session::Session;
use serde_json::json;

use crate::run::computed;
use crate::{datcom, text};

/// Relative standard deviation of derivatives stated without one.
const RELATIVE: f64 = 0.2;

#[derive(Debug, Args)]
pub struct PriorArguments {
    /// Session file.
    session: PathBuf,
    /// Earlier estimate: results.json, CSV (name, mean, std error), or Digital DATCOM listing.
    #[arg(long, value_name = "FILE")]
    prior: PathBuf,
    /// Relative standard deviation of the listing's derivatives.
    #[arg(long, default_value_t = RELATIVE)]
    relative: f64,
    /// Angle of attack for the listing, deg [default: level flight].
    #[arg(long, value_name = "DEG", allow_negative_numbers = true)]
    alpha_deg: Option<f64>,
    /// Aircraft for the rate normalisation of the listing.
    #[arg(long)]
    aircraft: Option<String>,
}

/// Prints prior, flight and both combined for every derivative, and the test of their conflict for every coefficient.
pub fn prior(arguments: &PriorArguments) -> Result<(), String> {
    let request = request(arguments)?;
    let (session, snapshot) = computed(&arguments.session, &[])?;
    let study = combine(&request, &session, &snapshot)?;
    text::json(&json!({ "version": 1, "derivatives": study.derivatives, "coefficients": study.coefficients }))?;
    print(&study);
    Ok(())
}

/// An earlier estimate in a file beside a flight that is computed, with the defaults of `prior`.
pub fn compare(path: &Path, prior: &Path, (session, snapshot): (&Session, &Snapshot)) -> Result<PriorStudy, String> {
    let (alpha_deg, aircraft) = (None, None);
    let (path, prior) = (path.to_owned(), prior.to_owned());
    let arguments = PriorArguments { session: path, prior, relative: RELATIVE, alpha_deg, aircraft };
    combine(&request(&arguments)?, session, snapshot)
}

fn request(arguments: &PriorArguments) -> Result<PriorRequest, String> {
    Ok(PriorRequest { name: arguments.prior.display().to_string(), known: read(arguments)? })
}

fn combine(request: &PriorRequest, session: &Session, snapshot: &Snapshot) -> Result<PriorStudy, String> {
    let context = Context::new(Path::new(""));
    let found = answer::<PriorStudy>(session, snapshot, request, &context).map_err(|error| error.to_string())?;
    Ok(PriorStudy::clone(found.shared()))
}

/// Derivatives known before, by name.
fn read(arguments: &PriorArguments) -> Result<Vec<PriorValue>, String> {
    let path = &arguments.prior;
    let refuse = |what: &str| format!("{}: {what}", path.display());
    let known = match path.extension().and_then(|ending| ending.to_str()) {
        Some("json") => {
            let value = |(name, mean, error): (String, f64, Option<f64>)| {
                let deviation = error.unwrap_or(f64::NAN);
                PriorValue { name, mean, deviation }
            };
            reference(path)?.values.into_iter().map(value).collect()
        }
        Some("csv") => read_table(path)?,
        _ => {
            if !(arguments.relative > 0.0 && arguments.relative.is_finite()) {
                return Err(format!("--relative is {}: it must be above zero", arguments.relative));
            }
            let listing = DatcomListing::read(path).map_err(|error| error.to_string())?;
            let aircraft = arguments.aircraft.as_deref().map(datcom::aircraft_data).transpose()?;
            let alpha = arguments.alpha_deg.map(f64::to_radians).or_else(|| listing.level_flight_alpha_rad());
            let alpha = alpha.ok_or_else(|| refuse("angle of attack in level flight unknown: give --alpha-deg"))?;
            let found = datcom::predicted(&listing, alpha, aircraft.as_ref()).map_err(|error| refuse(&error))?;
            let values = found.into_iter().map(|known| (known.name.to_owned(), known.value, None));
            let reference = Reference { name: path.display().to_string(), values: values.collect() };
            PriorRequest::of_reference(&reference, arguments.relative).known
        }
    };
    if known.iter().any(PriorValue::is_usable) {
        Ok(known)
    } else {
        Err(refuse("it has no derivative with a standard deviation above zero"))
    }
}

/// Rows `name, mean, standard error` under a header.
fn read_table(path: &Path) -> Result<Vec<PriorValue>, String> {
    let content = doublet_core::load::read_text(path).map_err(|error| format!("{}: {error}", path.display()))?;
    let lines = content.lines().enumerate().skip(1).filter(|(_, line)| !line.trim().is_empty());
    lines
        .map(|(index, line)| parse_row(index, line))
        .collect::<Result<_, _>>()
        .map_err(|line| format!("{}: line {line} is not `name,mean,std error` with two numbers", path.display()))
}

fn parse_row(index: usize, line: &str) -> Result<PriorValue, usize> {
    let cells: Vec<&str> = line.split(',').map(str::trim).collect();
    let [name, mean, deviation] = cells[..] else { return Err(index + 1) };
    let number = |cell: &str| cell.parse::<f64>().map_err(|_| index + 1);
    Ok(PriorValue { name: name.to_owned(), mean: number(mean)?, deviation: number(deviation)? })
}

fn print(study: &PriorStudy) {
    text::show(&study.table());
    text::line("");
    study.coefficients.iter().for_each(|row| text::line(&row.to_string()));
}
