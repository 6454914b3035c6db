//! `doublet simulate`: a flight whose every answer is known.

use std::path::{Path, PathBuf};

use clap::Args;
use doublet_core::simulate::scenario::Start;
use doublet_core::simulate::{self, InputKind, Scenario, SimulateError, scenario};
use doublet_engine::keep::Staging;

use crate::output_path::output_path;
use crate::progress::Progress;
use crate::text;

#[derive(Debug, Args)]
pub struct SimulateArguments {
    /// Scenario to simulate: a shipped name, or a file of `doublet design`.
    pub scenario: Option<String>,
    /// Folder for the recordings; appears only when complete.
    #[arg(long, value_parser = output_path())]
    pub out: Option<PathBuf>,
    /// Seed of noise, gusts and pilot imperfections; equal seeds give equal bytes.
    #[arg(long, default_value_t = 1)]
    pub seed: u64,
    /// Change a true derivative, for example Cm_alpha=-0.9. Repeatable.
    #[arg(long, value_name = "NAME=VALUE", value_parser = derivative)]
    pub derivative: Vec<(String, f64)>,
    /// Factor on the amplitude of every manoeuvre.
    #[arg(long, default_value_t = 1.0)]
    pub amplitude: f64,
    /// True airspeed of a trimmed scenario, kt.
    #[arg(long, value_name = "KT")]
    pub airspeed_kt: Option<f64>,
    /// Altitude of a trimmed scenario, ft.
    #[arg(long, value_name = "FT")]
    pub altitude_ft: Option<f64>,
    /// List scenarios, aircraft and inputs.
    #[arg(long)]
    pub list: bool,
}

/// Lists scenarios, aircraft and inputs, or flies a scenario and writes what its recorders hold.
pub fn simulate(arguments: &SimulateArguments) -> Result<(), String> {
    if arguments.list {
        list();
        return Ok(());
    }
    let (Some(name), Some(folder)) = (&arguments.scenario, &arguments.out) else {
        return Err(
            "name a scenario and a folder: `doublet simulate demo --out DIR`, or `doublet simulate --list`".into()
        );
    };
    if folder.exists() {
        return Err(format!("{} exists: choose another folder for --out", folder.display()));
    }
    let mut scenario = open(name)?;
    adjust(&mut scenario, arguments)?;
    let progress = Progress::new();
    let flown = simulate::run(&scenario, arguments.seed, &mut |part| {
        #[expect(clippy::cast_possible_truncation, reason = "a part of one for a progress bar")]
        progress.update(part as f32, "flying");
        true
    });
    progress.finish();
    let flight = flown.map_err(|error: SimulateError| error.to_string())?;
    let files = flight.files().map_err(|error| error.to_string())?;
    write(folder, files.iter().map(|file| (file.path.as_ref(), file.bytes.as_slice())))?;
    for file in &files {
        text::line(&format!("{}  {} kB", AsRef::<Path>::as_ref(&file.path).display(), file.bytes.len().div_ceil(1000)));
    }
    text::line(&format!("flight in {}", folder.display()));
    Ok(())
}

/// A scenario that comes with the program, or that of a file (.toml).
pub fn open(name: &str) -> Result<Scenario, String> {
    if Path::new(name).extension().is_some_and(|ending| ending == "toml") {
        let text = doublet_core::load::read_text(Path::new(name)).map_err(|error| format!("{name}: {error}"))?;
        return scenario::parse(&text).map_err(|error| format!("{name}: {error}"));
    }
    scenario::build(name).map_err(|error| error.to_string())
}

/// Metres per second of a knot, metres of a foot: exact.
const M_S_PER_KT: f64 = 1852.0 / 3600.0;
const M_PER_FT: f64 = 0.3048;

fn adjust(scenario: &mut Scenario, arguments: &SimulateArguments) -> Result<(), String> {
    for (name, value) in &arguments.derivative {
        let aero = scenario.vehicle.aero.with_derivative(name, *value).map_err(|error| error.to_string())?;
        scenario.vehicle.aero = aero;
    }
    for manoeuvre in &mut scenario.manoeuvres {
        manoeuvre.amplitude_rad *= arguments.amplitude;
    }
    match &mut scenario.start {
        Start::Trimmed(condition) => {
            if let Some(airspeed) = arguments.airspeed_kt {
                condition.airspeed_m_s = airspeed * M_S_PER_KT;
            }
            if let Some(altitude) = arguments.altitude_ft {
                condition.altitude_m = altitude * M_PER_FT;
            }
        }
        Start::Parked if arguments.airspeed_kt.is_some() || arguments.altitude_ft.is_some() => {
            return Err(format!(
                "scenario '{}' starts on the ground: airspeed and altitude are those of its plan",
                scenario.name
            ));
        }
        Start::Parked => {}
    }
    Ok(())
}

/// Writes all files into `folder`, which appears complete or not at all.
fn write<'a>(folder: &Path, files: impl Iterator<Item = (&'a Path, &'a [u8])>) -> Result<(), String> {
    let staging = Staging::new(folder).map_err(|error| error.to_string())?;
    for (path, bytes) in files {
        let place = staging.path().join(path);
        let written =
            place.parent().map_or(Ok(()), std::fs::create_dir_all).and_then(|()| std::fs::write(&place, bytes));
        written.map_err(|error| format!("{}: {error}", folder.join(path).display()))?;
    }
    staging.put_new().map_err(|error| error.to_string())
}

fn list() {
    text::line("scenarios");
    let rows: Vec<_> = scenario::list()
        .iter()
        .map(|listed| vec![format!("  {}", listed.name), listed.description.to_string()])
        .collect();
    text::list(&rows);
    text::line("aircraft");
    scenario::aircraft().iter().for_each(|name| text::line(&format!("  {name}")));
    text::line("inputs");
    InputKind::ALL.iter().for_each(|kind| text::line(&format!("  {}", kind.name())));
}

/// Reads `NAME=VALUE`.
fn derivative(text: &str) -> Result<(String, f64), String> {
    let (name, value) = text.split_once('=').ok_or("write it as NAME=VALUE, for example Cm_alpha=-0.9")?;
    let value: f64 = value.trim().parse().map_err(|_| format!("'{value}' is not a number"))?;
    Ok((name.trim().to_owned(), value))
}
