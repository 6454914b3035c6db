//! `doublet aircraft`: the aircraft that come with the program, and files of others from few figures.

use std::path::{Path, PathBuf};

use clap::{Args, Subcommand};
use doublet_core::airframe::AircraftClass;
use doublet_engine::begin::PlainAircraft;
use doublet_engine::graph::{Context, Keyed};
use doublet_engine::{builtin, keep, stage};
use serde_json::json;

use crate::output_path::output_path;
use crate::text;

#[derive(Debug, Args)]
pub struct AircraftArguments {
    #[command(subcommand)]
    command: AircraftCommand,
}

#[derive(Debug, Subcommand)]
enum AircraftCommand {
    /// List the aircraft that come with the program.
    List,
    /// Print the file of an aircraft that comes with the program.
    Show {
        /// Its name.
        name: String,
    },
    /// Write an aircraft file from a few numbers.
    New {
        /// Name of the aircraft.
        name: String,
        /// File to write; an existing file is not replaced.
        #[arg(short, long, value_parser = output_path())]
        output: PathBuf,
        #[command(flatten)]
        plain: PlainArguments,
    },
}

/// An aircraft described by its numbers.
#[derive(Debug, Args)]
pub struct PlainArguments {
    /// Reference area, m2, of an aircraft described by its numbers.
    #[arg(long, value_name = "M2", requires_all = ["span", "chord", "mass"])]
    area: Option<f64>,
    /// Span, m.
    #[arg(long, value_name = "M", requires = "area")]
    span: Option<f64>,
    /// Mean chord, m.
    #[arg(long, value_name = "M", requires = "area")]
    chord: Option<f64>,
    /// Mass, kg.
    #[arg(long, value_name = "KG", requires = "area")]
    mass: Option<f64>,
    /// Moments and product of inertia about the centre of gravity, kg m2.
    #[arg(long, value_name = "IXX,IYY,IZZ[,IXZ]", requires = "area", value_parser = inertia, conflicts_with = "class")]
    inertia: Option<[f64; 4]>,
    /// Class for estimated inertia: single-propeller, twin-propeller, fuselage-jets, two-wing-jets or four-wing-jets.
    #[arg(long, requires = "length", value_parser = class)]
    class: Option<AircraftClass>,
    /// Length, m, for the inertia of its class.
    #[arg(long, value_name = "M", requires = "class")]
    length: Option<f64>,
}

/// Reads the name of a class.
fn class(name: &str) -> Result<AircraftClass, String> {
    let known = || AircraftClass::ALL.map(AircraftClass::name).join(", ");
    AircraftClass::from_name(name).ok_or_else(|| format!("give one of {}", known()))
}

impl PlainArguments {
    /// The aircraft the arguments describe; none where they describe none.
    pub fn describe(&self, name: &str) -> Result<Option<PlainAircraft>, String> {
        let (Some(area_m2), Some(span_m), Some(chord_m), Some(mass_kg)) = (self.area, self.span, self.chord, self.mass)
        else {
            return Ok(None);
        };
        let [xx, yy, zz, xz_kg_m2] = self.inertia.unwrap_or_default();
        let moments_kg_m2 = [xx, yy, zz];
        let name = name.to_owned();
        let mut plain = PlainAircraft { name, area_m2, span_m, chord_m, mass_kg, moments_kg_m2, xz_kg_m2, note: None };
        match (self.inertia, self.class, self.length) {
            (Some(_), ..) => {}
            (None, Some(class), Some(length_m)) => plain.set_inertia(class, length_m),
            _ => return Err("the inertia is missing: give --inertia, or --class and --length".to_owned()),
        }
        Ok(Some(plain))
    }
}

/// Lists, prints or makes aircraft files.
pub fn aircraft(arguments: &AircraftArguments) -> Result<(), String> {
    match &arguments.command {
        AircraftCommand::List => list(),
        AircraftCommand::Show { name } => {
            let known = || builtin::aircraft().join(", ");
            let found = builtin::text("aircraft", name).filter(|_| builtin::aircraft().contains(&name.as_str()));
            let found = found.ok_or_else(|| format!("aircraft '{name}' not found: give one of {}", known()))?;
            text::json_or(&json!({ "version": 1, "aircraft": found }), found.trim_end())
        }
        AircraftCommand::New { name, output, plain } => {
            let plain = plain.describe(name)?.ok_or("give --area, --span, --chord and --mass")?;
            write(&plain, output)?;
            let [xx, yy, zz] = plain.moments_kg_m2;
            text::json(&json!({ "version": 1, "file": output, "moments_kg_m2": [xx, yy, zz], "note": plain.note }))?;
            text::line(&format!("{}: Ixx {xx:.0}, Iyy {yy:.0}, Izz {zz:.0} kg m2", output.display()));
            plain.note.iter().for_each(|note| text::line(note));
            Ok(())
        }
    }
}

fn list() -> Result<(), String> {
    let context = Context::new(Path::new("."));
    let load = |name: &&'static str| {
        let loaded = stage::load_aircraft(&context, &format!("{}{name}", builtin::PREFIX));
        Ok((*name, loaded.map_err(|error| error.to_string())?))
    };
    let found = builtin::aircraft().iter().map(load).collect::<Result<Vec<_>, String>>()?;
    if text::is_json() {
        let row = |(name, loaded): &(&str, Keyed<stage::LoadedAircraft>)| {
            let reference = loaded.aircraft.reference;
            json!({ "name": name, "title": loaded.aircraft.name, "area_m2": reference.area_m2, "span_m": reference.span_m, "chord_m": reference.chord_m })
        };
        let rows: Vec<_> = found.iter().map(row).collect();
        return text::json(&json!({ "version": 1, "aircraft": rows }));
    }
    for (name, loaded) in &found {
        let reference = loaded.aircraft.reference;
        text::line(&format!(
            "{name:<24} {} (S {} m2, b {} m, c {} m)",
            loaded.aircraft.name, reference.area_m2, reference.span_m, reference.chord_m
        ));
    }
    Ok(())
}

/// Writes an aircraft to a file that is not there yet.
pub fn write(plain: &PlainAircraft, path: &Path) -> Result<(), String> {
    if path.exists() {
        return Err(format!("{} exists: choose another name, or name it with --aircraft", path.display()));
    }
    keep::replace(path, plain.text()?.as_bytes()).map_err(|error| format!("{}: {error}", path.display()))
}

/// Reads `IXX,IYY,IZZ` or `IXX,IYY,IZZ,IXZ`, kg m².
fn inertia(text: &str) -> Result<[f64; 4], String> {
    let numbers: Vec<f64> = text
        .split(',')
        .map(|number| number.trim().parse().map_err(|_| format!("'{number}' is not a number")))
        .collect::<Result<_, _>>()?;
    match numbers[..] {
        [xx, yy, zz] => Ok([xx, yy, zz, 0.0]),
        [xx, yy, zz, xz] => Ok([xx, yy, zz, xz]),
        _ => Err("give IXX,IYY,IZZ or IXX,IYY,IZZ,IXZ in kg m2".to_owned()),
    }
}
