//! `doublet compatibility`: constant errors of the sensors over the windows of a session, taken into it where asked.

use std::path::PathBuf;

use clap::{Args, ValueEnum};
use doublet_core::estimate::SensorError;
use doublet_core::reconstruct::Measurement;
use doublet_engine::report;
use doublet_engine::session::{self, SensorErrorMethod, Session};

use crate::progress::Progress;
use crate::run::{compute_session, open_to_run};
use crate::text;

#[derive(Debug, Args)]
pub struct CompatibilityArguments {
    /// Session file.
    pub session: PathBuf,
    /// Errors common to all manoeuvres: bias_SENSOR, scale_SENSOR, misalignment_x, _y, _z.
    #[arg(long, value_name = "ERROR,ERROR", value_delimiter = ',', value_parser = error)]
    pub free: Vec<SensorError>,
    /// Errors estimated per manoeuvre.
    #[arg(long, alias = "per-window", value_name = "ERROR,ERROR", value_delimiter = ',', value_parser = error)]
    pub per_manoeuvre: Vec<SensorError>,
    /// Measurements compared.
    #[arg(long, value_name = "NAME,NAME", value_delimiter = ',', value_parser = measurement)]
    pub outputs: Vec<Measurement>,
    /// Estimate a wind in each manoeuvre.
    #[arg(long)]
    pub wind: bool,
    /// Noise model: measurements only, or inertial samples too.
    #[arg(long, value_enum)]
    pub method: Option<SensorMethod>,
    /// Manoeuvres to use, by name [default: all not ignored].
    #[arg(long, alias = "windows", value_name = "NAME,NAME", value_delimiter = ',')]
    pub manoeuvres: Vec<String>,
    /// Save the common errors to the session, which then corrects for them.
    #[arg(long)]
    pub take: bool,
}

/// Noise model.
#[derive(Clone, Copy, Debug, ValueEnum)]
pub enum SensorMethod {
    /// Measurements only, sized by their residuals.
    OutputError,
    /// Inertial samples and measurements, by the filter settings.
    FilterError,
}

fn error(name: &str) -> Result<SensorError, String> {
    SensorError::from_name(name.trim()).ok_or_else(|| {
        let all: Vec<String> = SensorError::all().map(|error| error.to_string()).collect();
        format!("error '{name}' not found: use {}", all.join(", "))
    })
}

fn measurement(name: &str) -> Result<Measurement, String> {
    let known = || Measurement::ALL.map(Measurement::name).join(", ");
    Measurement::from_name(name.trim()).ok_or_else(|| format!("measurement '{name}' not found: use {}", known()))
}

/// Estimates errors of the sensors, prints them, takes them where asked.
pub fn compatibility(arguments: &CompatibilityArguments) -> Result<(), String> {
    let opened = open_to_run(&arguments.session)?;
    let mut asked = opened.session.clone();
    ask(&mut asked, arguments)?;
    let stopped = session::check(&asked).into_iter().find(session::stops_run);
    if let Some(finding) = stopped {
        return Err(finding.to_string());
    }
    let progress = Progress::new();
    let snapshot = compute_session(&asked, &opened.folder, &[], &progress, 1.0);
    progress.finish();
    let snapshot = snapshot?;
    let found = snapshot
        .sensor_errors
        .ready()
        .ok_or_else(|| snapshot.sensor_errors.error().unwrap_or("sensor errors were not estimated").to_owned())?;
    let rows = report::sensor_error_rows(&found.0);
    text::json(&rows)?;
    text::show(&report::error_table(&rows));
    text::line("");
    text::show(&report::sensor_output_table(&rows));
    if arguments.take {
        let mut next = opened.session;
        for row in found.0.errors.iter().filter(|row| row.window.is_none()) {
            next.sensor_errors.free.retain(|error| *error != row.error);
            next.preparation.known_errors.0.insert(row.error, row.value);
        }
        session::save(&next, &arguments.session).map_err(|error| error.to_string())?;
        let text = format!("{} now corrects them; the old file is kept as *.bak", arguments.session.display());
        text::error_line(&text);
    }
    Ok(())
}

/// What the arguments ask for, in the place of what the session does.
fn ask(session: &mut Session, arguments: &CompatibilityArguments) -> Result<(), String> {
    if let Some(unknown) = arguments.manoeuvres.iter().find(|name| session.window(name).is_none()) {
        return Err(format!("manoeuvre '{unknown}' not found in the session"));
    }
    if !arguments.manoeuvres.is_empty() {
        session.windows.retain(|window| arguments.manoeuvres.contains(&window.name));
    }
    let errors = &mut session.sensor_errors;
    if !(arguments.free.is_empty() && arguments.per_manoeuvre.is_empty()) {
        errors.free.clone_from(&arguments.free);
        errors.per_window.clone_from(&arguments.per_manoeuvre);
        errors
            .random_walk
            .0
            .retain(|error, _| arguments.free.contains(error) || arguments.per_manoeuvre.contains(error));
    }
    if !arguments.outputs.is_empty() {
        errors.outputs.clone_from(&arguments.outputs);
    }
    errors.wind |= arguments.wind;
    match arguments.method {
        Some(SensorMethod::OutputError) => errors.method = SensorErrorMethod::OutputError,
        Some(SensorMethod::FilterError) => errors.method = SensorErrorMethod::FilterError,
        None => {}
    }
    match errors.is_empty() {
        true => Err(
            "no sensor error to estimate: name some by --free scale_alpha,bias_q, or in [sensor_errors] of the session"
                .to_owned(),
        ),
        false => Ok(()),
    }
}
