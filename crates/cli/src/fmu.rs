//! `doublet fmu`: the identified aircraft as a Functional Mock-up Unit.

use std::path::PathBuf;

use clap::Args;
use doublet_dynamics::linear::Simulation;
use doublet_engine::export::write_fmu;
use serde_json::json;

use crate::dynamics::{JudgedArguments, TrimArguments, study};
use crate::output_path::output_path;
use crate::run::check_written;
use crate::text;

#[derive(Debug, Args)]
pub struct FmuArguments {
    /// Initial trim of the flight.
    #[command(flatten)]
    trim: TrimArguments,
    /// File to write; an existing one is replaced.
    #[arg(long, value_name = "FILE", value_parser = output_path())]
    out: PathBuf,
}

/// Writes the unit.
pub fn fmu(arguments: &FmuArguments) -> Result<(), String> {
    check_written(&arguments.out, &arguments.trim.session)?;
    let study = study(&arguments.trim, &JudgedArguments::default())?;
    let name = arguments.out.file_stem().map_or_else(String::new, |name| name.to_string_lossy().into_owned());
    let simulation = Simulation::from_trim(study.model.model.clone(), &study.modes.linearised.trim);
    let names = &study.model.names;
    write_fmu(&simulation, names, &name, &arguments.out).map_err(|error| error.to_string())?;
    let trim = &study.modes.linearised.trim;
    let path = arguments.out.display();
    let (speed, altitude) = (trim.condition.airspeed_m_s, trim.condition.altitude_m);
    text::json(&json!({
        "version": 1, "file": arguments.out, "fmi": "3.0", "derivatives": names, "airspeed_m_s": speed,
        "altitude_m": altitude, "controls_rad": trim.controls_rad, "thrust_n": trim.thrust_n,
    }))?;
    text::line(&format!("{path}: FMI 3.0, begins at {speed:.2} m/s, {altitude:.0} m"));
    study.notes.iter().for_each(|note| text::line(note));
    Ok(())
}
