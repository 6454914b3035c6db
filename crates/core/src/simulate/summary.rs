//! True scalars of a flight, as TOML.

use std::collections::BTreeMap;

use serde::Serialize;

use super::modes::modes;
use super::plan::{Power, Task};
use super::recorder::Clock;
use super::run::Flight;
use super::trim::{Trim, TrimCondition, trim};
use super::truth::FIRST_TANK;
use super::{SimulateError, boxes};
use crate::airframe::{Loading, MassProperties};
use crate::motion::Mode;

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
    mass_kg: f64,
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
        errors: flight.constant_errors().map(|(name, value, _)| (name, value)).collect(),
        derivatives: derivatives.iter().map(|derivative| (derivative.name.clone(), derivative.value)).collect(),
        mode: mode_tables(flight)?,
        manoeuvre: manoeuvre_tables(flight),
    };
    toml::to_string(&table)
        .map_err(|error| SimulateError::Encode { file: "truth.toml".into(), reason: error.to_string() })
}

/// Modes of the aircraft at the condition and loading of the manoeuvres of a segment.
#[derive(Clone, Debug)]
#[expect(missing_docs, reason = "names say it")]
pub struct TrueModes {
    /// True airspeed, m/s.
    pub airspeed_m_s: f64,
    pub altitude_m: f64,
    /// Mass, centre of gravity and inertia at the onset of the middle manoeuvre.
    pub mass: MassProperties,
    pub trim: Trim,
    /// Modes, fastest first.
    pub modes: Vec<Mode>,
}

/// Modes at the conditions of the segments in which manoeuvres are flown, each with the loading at the onset of the middle one of its
/// manoeuvres; that of the start of the segment without manoeuvres.
///
/// # Errors
/// [`SimulateError`]: a loading that is impossible, no trim.
pub fn true_modes(flight: &Flight) -> Result<Vec<TrueModes>, SimulateError> {
    let scenario = &flight.scenario;
    let mut found = Vec::new();
    for (index, segment) in scenario.segments.iter().enumerate().filter(|(_, segment)| segment.phase == "testing") {
        let Task::Level { altitude_m, power: Power::Airspeed { airspeed_m_s, speed_rad_s }, .. } = segment.task else {
            continue;
        };
        let end_s = scenario.segments.get(index + 1).map_or(scenario.duration_s, |next| next.start_s);
        let onsets = scenario.manoeuvres.iter().map(|manoeuvre| manoeuvre.onset_s);
        let onsets: Vec<f64> = onsets.filter(|onset_s| (segment.start_s..end_s).contains(onset_s)).collect();
        let time_s = onsets.get(onsets.len() / 2).copied().unwrap_or(segment.start_s);
        let body = scenario.vehicle.body(&loading_at(flight, time_s))?;
        let condition = TrimCondition {
            airspeed_m_s,
            altitude_m,
            heading_rad: segment.heading_rad,
            engine_speed_rad_s: speed_rad_s,
            wind_ned_m_s: scenario.wind_ned_m_s,
        };
        let trim = trim(&scenario.vehicle, &body, &scenario.atmosphere, &condition)?;
        let modes = modes(&scenario.vehicle, &body, &trim);
        found.push(TrueModes { airspeed_m_s, altitude_m, mass: body.properties, trim, modes });
    }
    Ok(found)
}

/// Loading of a flight at a time, its fuel as flown.
fn loading_at(flight: &Flight, time_s: f64) -> Loading {
    let (scenario, truth) = (&flight.scenario, &flight.truth);
    let mut loading = scenario.loading.clone();
    let at = truth.loading_time_s.partition_point(|own| *own < time_s);
    let at = at.min(truth.loading_time_s.len().saturating_sub(1));
    for (tank, column) in scenario.vehicle.aircraft.tanks.iter().zip(&truth.loading[FIRST_TANK..]) {
        let fuel_kg = column.get(at).copied().unwrap_or(0.0);
        loading.fuel_kg.insert(tank.name.clone(), fuel_kg);
    }
    loading
}

fn mode_tables(flight: &Flight) -> Result<Vec<ModeTable>, SimulateError> {
    // Eigenvalues come from the platform's own arithmetic: nine digits of them are the same everywhere.
    let rounded = |value: f64| (value * 1e6).round() / 1e6;
    let tables = true_modes(flight)?.into_iter().flat_map(|condition| {
        let TrueModes { airspeed_m_s, altitude_m, mass, modes, .. } = condition;
        modes.into_iter().map(move |mode| ModeTable {
            airspeed_m_s: rounded(airspeed_m_s),
            altitude_m: rounded(altitude_m),
            mass_kg: (mass.mass_kg * 1e3).round() / 1e3,
            name: mode.name,
            frequency_rad_s: rounded(mode.frequency_rad_s()),
            damping: rounded(mode.damping()),
            time_constant_s: (mode.time_constant_s() * 1e3).round() / 1e3,
        })
    });
    Ok(tables.collect())
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
