//! True scalars of a flight, as TOML.

use std::collections::BTreeMap;

use serde::Serialize;

use super::SimulateError;
use super::boxes;
use super::modes::modes;
use super::plan::{Power, Task};
use super::recorder::Clock;
use super::run::Flight;
use super::trim::{TrimCondition, trim};
use super::truth::Truth;

/// Clocks of the recorders, by the name of their group in the truth file.
pub fn clocks() -> [(&'static str, Clock); 4] {
    [
        ("bus", Clock::REFERENCE),
        ("engine_monitor", boxes::MONITOR_CLOCK),
        ("pod", boxes::POD_CLOCK),
        ("control_sensors", boxes::CONTROL_CLOCK),
    ]
}

#[derive(Serialize)]
struct Scalars {
    format: &'static str,
    version: u32,
    scenario: &'static str,
    seed: u64,
    aircraft: String,
    wind_ned_m_s: [f64; 3],
    gust_m_s: f64,
    gravity_m_s2: f64,
    sea_level_pressure_pa: f64,
    sea_level_temperature_k: f64,
    accelerometer_from_datum_m: [f64; 3],
    control_sensor_delay_s: f64,
    control_lag_s: f64,
    note: &'static str,
    clocks: BTreeMap<&'static str, ClockTable>,
    errors: BTreeMap<&'static str, f64>,
    derivatives: BTreeMap<String, f64>,
    mode: Vec<ModeTable>,
    manoeuvre: Vec<ManoeuvreTable>,
}

#[derive(Serialize)]
struct ClockTable {
    offset_s: f64,
    drift: f64,
}

#[derive(Serialize)]
struct ModeTable {
    airspeed_m_s: f64,
    altitude_m: f64,
    name: &'static str,
    frequency_rad_s: f64,
    damping: f64,
    time_constant_s: f64,
}

#[derive(Serialize)]
struct ManoeuvreTable {
    number: usize,
    surface: &'static str,
    shape: &'static str,
    spoilt: bool,
    test_point: u8,
    start_s: f64,
    onset_s: f64,
    input_end_s: f64,
    end_s: f64,
    amplitude_rad: f64,
    base_time_s: f64,
    start_delay_s: f64,
}

/// The scalars of a flight. Derivatives are those of the aerodynamic force alone: an identification that leaves the
/// thrust inside CX finds `CX_0` larger by thrust over dynamic pressure and area.
pub(crate) fn scalars(flight: &Flight) -> Result<String, SimulateError> {
    let scenario = &flight.scenario;
    let derivatives = scenario.vehicle.aero.derivatives();
    let table = Scalars {
        format: "doublet truth",
        version: 1,
        scenario: scenario.name,
        seed: flight.seed,
        aircraft: scenario.vehicle.aircraft.name.clone(),
        wind_ned_m_s: scenario.wind_ned_m_s.into(),
        gust_m_s: scenario.gust_m_s,
        gravity_m_s2: crate::atmos::STANDARD_GRAVITY_M_S2,
        sea_level_pressure_pa: scenario.atmosphere.sea_level_pressure_pa(),
        sea_level_temperature_k: scenario.atmosphere.sea_level_temperature_k(),
        accelerometer_from_datum_m: boxes::ACCELEROMETER_FROM_DATUM_M,
        control_sensor_delay_s: boxes::CONTROL_DELAY_S,
        control_lag_s: scenario.control_lag_s,
        note: "body-axes derivatives about the centre of gravity without thrust, per rad, qc/V, pb/2V, rb/2V; times in s of the bus clock; t_bus = offset + (1 + drift) t_own",
        clocks: clocks()
            .into_iter()
            .map(|(name, Clock { offset_s, drift })| (name, ClockTable { offset_s, drift }))
            .collect(),
        errors: Truth::biases().into_iter().map(|(name, value, _)| (name, value)).collect(),
        derivatives: derivatives.iter().map(|derivative| (derivative.name.clone(), derivative.value)).collect(),
        mode: mode_tables(flight)?,
        manoeuvre: manoeuvre_tables(flight),
    };
    toml::to_string(&table)
        .map_err(|error| SimulateError::Encode { file: "truth.toml".into(), reason: error.to_string() })
}

/// Modes at the conditions of the segments in which manoeuvres are flown, with the loading of the start.
fn mode_tables(flight: &Flight) -> Result<Vec<ModeTable>, SimulateError> {
    let scenario = &flight.scenario;
    let body = scenario.vehicle.body(&scenario.loading)?;
    let mut tables = Vec::new();
    for segment in scenario.segments.iter().filter(|segment| segment.phase == "testing") {
        let Task::Level { altitude_m, power: Power::Airspeed { airspeed_m_s, speed_rad_s }, .. } = segment.task else {
            continue;
        };
        let condition = TrimCondition {
            airspeed_m_s,
            altitude_m,
            heading_rad: segment.heading_rad,
            engine_speed_rad_s: speed_rad_s,
            wind_ned_m_s: scenario.wind_ned_m_s,
        };
        let trim = trim(&scenario.vehicle, &body, &scenario.atmosphere, &condition)?;
        // Eigenvalues come from the platform's own arithmetic: nine digits of them are the same everywhere.
        let rounded = |value: f64| (value * 1e6).round() / 1e6;
        tables.extend(modes(&scenario.vehicle, &body, &trim).into_iter().map(|mode| ModeTable {
            airspeed_m_s: rounded(airspeed_m_s),
            altitude_m: rounded(altitude_m),
            name: mode.name,
            frequency_rad_s: rounded(mode.frequency_rad_s()),
            damping: rounded(mode.damping()),
            time_constant_s: (mode.time_constant_s() * 1e3).round() / 1e3,
        }));
    }
    Ok(tables)
}

fn manoeuvre_tables(flight: &Flight) -> Vec<ManoeuvreTable> {
    let manoeuvres = flight.manoeuvres.iter().zip(&flight.start_delays_s).enumerate();
    let table = manoeuvres.map(|(index, (flown, &start_delay_s))| {
        let manoeuvre = &flown.manoeuvre;
        let (start_s, end_s) = manoeuvre.recorded_s();
        ManoeuvreTable {
            number: index + 1,
            surface: manoeuvre.surface.name(),
            shape: manoeuvre.kind.name(),
            spoilt: manoeuvre.spoilt,
            test_point: manoeuvre.test_point,
            start_s,
            onset_s: manoeuvre.onset_s,
            input_end_s: manoeuvre.onset_s + flown.duration_s(),
            end_s,
            amplitude_rad: manoeuvre.amplitude_rad,
            base_time_s: manoeuvre.dt_s,
            start_delay_s,
        }
    });
    table.collect()
}
