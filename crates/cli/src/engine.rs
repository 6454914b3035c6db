//! `doublet engine`: one condition of an aircraft's engines, with its sensitivities.

use std::path::Path;

use clap::Args;
use doublet_core::atmos::Atmosphere;
use doublet_core::propulsion::{
    DensityRule, EngineModel, EngineOutput, EnginePoint, EngineSensitivities, PointInput, Powerplant, Steps,
    engine_sensitivities,
};
use doublet_core::quantity::Unit;
use doublet_engine::graph::Context;
use doublet_engine::stage;

use crate::{new, text};

#[derive(Debug, Args)]
pub struct EngineArguments {
    /// Aircraft (file or name).
    pub aircraft: String,
    /// Speed of the crankshaft, rev/min.
    #[arg(long, allow_negative_numbers = true)]
    pub rpm: f64,
    /// Absolute manifold pressure, inHg.
    #[arg(long, value_name = "INHG", allow_negative_numbers = true)]
    pub manifold_inhg: f64,
    /// Pressure altitude, ft.
    #[arg(long, value_name = "FT", allow_negative_numbers = true)]
    pub altitude_ft: f64,
    /// Static air temperature at that altitude, degC.
    #[arg(long, value_name = "DEGC", allow_negative_numbers = true)]
    pub oat_c: f64,
    /// True airspeed, kt.
    #[arg(long, value_name = "KT", allow_negative_numbers = true)]
    pub airspeed_kt: f64,
    /// Step of the differences, per cent of each input [default: its resolution].
    #[arg(long, value_name = "PERCENT")]
    pub step_percent: Option<f64>,
    /// Let sea-level temperature change static pressure, as in the thesis.
    #[arg(long)]
    pub thesis_density: bool,
}

/// Units of the sensitivities, in the order of [`PointInput::ALL`].
const INPUT_UNITS: [&str; 5] = ["rpm", "inHg", "K", "m", "m/s"];
/// Units of the outputs, in the order of [`EngineOutput::ALL`].
const OUTPUT_UNITS: [&str; 3] = ["hp", "N", "-"];

/// Prints power, thrust, efficiency, total-pressure rise and their sensitivities at one condition.
pub fn engine(arguments: &EngineArguments) -> Result<(), String> {
    let reference = new::aircraft_reference(&arguments.aircraft)?;
    let loaded = stage::load_aircraft(&Context::new(Path::new(".")), &reference)?;
    let point = point(arguments)?;
    let steps = match arguments.step_percent {
        None => Steps::READING_RESOLUTION,
        Some(percent) => Steps::fraction_of(&point, within("--step-percent", percent, 1e-6, 50.0)? / 100.0),
    };
    let rule =
        if arguments.thesis_density { DensityRule::ThesisSeaLevelTemperature } else { DensityRule::StandardPressure };
    let models = models(&loaded.powerplant);
    if models.is_empty() {
        return Err(format!(
            "{}: no engine has a chart and a propeller map: name them in its [propulsion] section",
            arguments.aircraft
        ));
    }
    let found = models
        .into_iter()
        .map(|(names, model)| {
            let found = engine_sensitivities(model, &point, &steps, rule).map_err(|error| error.to_string())?;
            Ok((names, found))
        })
        .collect::<Result<Vec<_>, String>>()?;
    for (names, found) in found {
        text::line(&format!("engine {}", names.join(" and ")));
        print_state(&found)?;
        print_sensitivities(&found)?;
    }
    Ok(())
}

/// The models of the powerplant with the names of the engines that share them.
fn models(powerplant: &Powerplant) -> Vec<(Vec<&str>, &EngineModel)> {
    let mut models: Vec<(Vec<&str>, &EngineModel)> = Vec::new();
    for engine in &powerplant.engines {
        let Some(model) = &engine.model else { continue };
        match models.iter_mut().find(|(_, known)| *known == model) {
            Some((names, _)) => names.push(&engine.station.name),
            None => models.push((vec![&engine.station.name], model)),
        }
    }
    models
}

/// The condition in SI.
fn point(arguments: &EngineArguments) -> Result<EnginePoint, String> {
    let pressure_altitude_m = si(within("--altitude-ft", arguments.altitude_ft, -2_000.0, 36_000.0)?, "ft")?;
    let standard = Atmosphere::STANDARD;
    let standard_k = standard.temperature_k(pressure_altitude_m).map_err(|error| error.to_string())?;
    let air_temperature_k = si(within("--oat-c", arguments.oat_c, -90.0, 60.0)?, "degC")?;
    Ok(EnginePoint {
        speed_rad_s: si(within("--rpm", arguments.rpm, 0.0, 10_000.0)?, "rpm")?,
        manifold_pressure_pa: si(within("--manifold-inhg", arguments.manifold_inhg, 0.0, 100.0)?, "inHg")?,
        sea_level_temperature_k: standard.sea_level_temperature_k() + air_temperature_k - standard_k,
        pressure_altitude_m,
        airspeed_m_s: si(within("--airspeed-kt", arguments.airspeed_kt, 0.0, 500.0)?, "kt")?,
    })
}

fn within(name: &str, value: f64, low: f64, high: f64) -> Result<f64, String> {
    if (low..=high).contains(&value) {
        Ok(value)
    } else {
        Err(format!("{name} is {value}: allowed is {low} to {high}"))
    }
}

fn si(value: f64, unit: &str) -> Result<f64, String> {
    Unit::parse(unit).map(|unit| unit.to_si(value)).map_err(|error| error.to_string())
}

fn print_state(found: &EngineSensitivities) -> Result<(), String> {
    let state = &found.nominal;
    let rows = [
        ("power, hp", state.power_w / si(1.0, "hp")?, 4),
        ("power, kW", state.power_w / 1000.0, 4),
        ("thrust, N", state.thrust_n, 5),
        ("total-pressure rise / q", state.total_pressure_rise, 4),
        ("propeller efficiency", state.efficiency, 4),
        ("advance ratio J", state.advance_ratio, 4),
        ("power coefficient CP", state.power_coefficient, 4),
    ];
    for (name, value, digits) in rows {
        text::line(&format!("  {name:<24}{:>10}", text::number(value, digits)));
    }
    state.off_range.iter().for_each(|finding| text::line(&format!("  {finding}")));
    Ok(())
}

fn print_sensitivities(found: &EngineSensitivities) -> Result<(), String> {
    let mut rows = Vec::new();
    for (output, name) in EngineOutput::ALL.into_iter().zip(["power, hp", "thrust, N", "rise / q"]) {
        let scale = si(1.0, OUTPUT_UNITS[output as usize])?;
        let mut row = vec![format!("  {name}")];
        for input in PointInput::ALL {
            let per_unit = found.partial(output, input) * si(1.0, INPUT_UNITS[input as usize])? / scale;
            row.push(text::number(per_unit, 4));
        }
        rows.push(row);
    }
    text::table(&["  change", "per rpm", "per inHg", "per K at sea level", "per m", "per m/s"], &rows);
    let [power, thrust, rise] = found.reading_uncertainty(&Steps::READING_RESOLUTION);
    text::line(&format!(
        "  one reading off by its resolution: {} hp, {} N, {}",
        text::number(power / si(1.0, "hp")?, 2),
        text::number(thrust, 2),
        text::number(rise, 2)
    ));
    Ok(())
}
