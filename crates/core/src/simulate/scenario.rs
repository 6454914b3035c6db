//! Scenarios: what is flown, in which air, with which instruments.

use nalgebra::Vector3;
use serde::Deserialize;

use super::instrument_errors::InstrumentErrors;
use super::plan::{DesignedInput, Hands, Manoeuvre, Segment};
use super::trim::TrimCondition;
use super::vehicle::Vehicle;
use super::{SimulateError, flight_plan};
use crate::airframe::Loading;
use crate::atmos::Atmosphere;
use crate::toml_error;

/// Where a flight begins.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Start {
    /// On the ground with engines running.
    Parked,
    /// In steady level flight.
    Trimmed(TrimCondition),
}

/// How much of the truth is kept.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum TruthExtent {
    /// Every step.
    Whole,
    /// Every so many steps, within the recorded intervals of the manoeuvres only, positions in single precision and all else
    /// to 16 significant bits.
    Manoeuvres {
        /// Steps from one sample to the next.
        every: usize,
    },
}

/// Everything that makes a flight, but the seed.
#[derive(Clone, Debug, PartialEq)]
#[expect(missing_docs, reason = "names say it")]
pub struct Scenario {
    pub name: &'static str,
    /// One line on it.
    pub description: &'static str,
    /// Aircraft with its truth.
    pub vehicle: Vehicle,
    /// Loading at the start.
    pub loading: Loading,
    /// The day's atmosphere.
    pub atmosphere: Atmosphere,
    /// Steady wind, m/s.
    pub wind_ned_m_s: Vector3<f64>,
    /// Standard deviation of the gusts, m/s.
    pub gust_m_s: f64,
    /// Altitude of the ground, m.
    pub ground_m: f64,
    pub start: Start,
    /// Segments in order of time.
    pub segments: Vec<Segment>,
    /// Manoeuvres in order of time.
    pub manoeuvres: Vec<Manoeuvre>,
    /// End, s.
    pub duration_s: f64,
    /// Step of the integration, s.
    pub step_s: f64,
    /// Time constant of each control's stretching cable or actuator, s.
    pub control_lag_s: f64,
    /// Largest unsteadiness of the vertical speed the pilot leaves before a manoeuvre, m/s.
    pub unsteadiness_m_s: f64,
    /// Rate of the air-data pod, Hz: 5, or the 1 it falls back to.
    pub pod_rate_hz: f64,
    /// Without noise, bias and resolution.
    pub exact_instruments: bool,
    /// Standard deviations of constant errors of the instruments, which each seed draws.
    pub sensor_accuracy: InstrumentErrors,
    /// Truth kept.
    pub truth: TruthExtent,
    /// UTC at bus time zero, as written in the pod's and the sensors' files, s of the day.
    pub utc_start_s: f64,
}

/// A scenario that can be asked for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Listed {
    /// Name.
    pub name: &'static str,
    /// One line on it.
    pub description: &'static str,
}

/// Shipped scenarios.
const LISTED: [Listed; 8] = [
    Listed {
        name: "ft1",
        description: "C337F, 90 minutes from taxi to landing: 23 manoeuvres at 4,000 ft and 90 kt, six each at two more test points; truth at 100 Hz throughout",
    },
    Listed {
        name: "demo",
        description: "the same flight as shipped: without the waiting, truth to 16 bits and around the manoeuvres only",
    },
    Listed {
        name: "test-point",
        description: "C337F, from trim at 4,000 ft and 90 kt: six manoeuvres in four and a half minutes",
    },
    Listed {
        name: "test-point-1hz",
        description: "the same with the air-data pod at the 1 Hz it falls back to after a calibration",
    },
    Listed {
        name: "coverage",
        description: "C337F, from trim at 4,000 ft and 90 kt: the six manoeuvres of a test point twice over, 25 s apart",
    },
    Listed {
        name: "inputs",
        description: "C337F, from trim at 4,000 ft and 90 kt: every shape of input on the elevator",
    },
    Listed {
        name: "multisine",
        description: "C337F, from trim at 4,000 ft and 90 kt: orthogonal multisines on all three controls at once",
    },
    Listed {
        name: "sweeps",
        description: "C337F, from trim at 4,000 ft and 90 kt: sweeps of frequency on each control in turn",
    },
];

/// Shipped scenarios.
pub fn list() -> &'static [Listed] {
    &LISTED
}

/// Aircraft with an aerodynamic truth.
pub fn aircraft() -> &'static [&'static str] {
    &["c337f"]
}

/// The shipped scenario called `name`.
///
/// # Errors
/// [`SimulateError::UnknownScenario`]; for an aircraft, map or truth file that is not valid, its own error.
pub fn build(name: &str) -> Result<Scenario, SimulateError> {
    let Some(listed) = LISTED.iter().find(|listed| listed.name == name) else {
        let known = LISTED.iter().map(|listed| listed.name).collect();
        return Err(SimulateError::UnknownScenario { name: name.to_owned(), known });
    };
    let mut scenario = match listed.name {
        "test-point" | "test-point-1hz" => flight_plan::test_point(*listed)?,
        "coverage" => flight_plan::test_point_twice(*listed)?,
        "inputs" => flight_plan::all_inputs(*listed)?,
        "multisine" => flight_plan::multisine(*listed)?,
        "sweeps" => flight_plan::sweeps(*listed)?,
        _ => flight_plan::whole_flight(*listed)?,
    };
    match listed.name {
        "demo" => {
            flight_plan::shorten(&mut scenario);
            scenario.truth = TruthExtent::Manoeuvres { every: 1 };
        }
        "test-point-1hz" => scenario.pod_rate_hz = 1.0,
        _ => {}
    }
    Ok(scenario)
}

/// First key of a scenario file, and the version this reads.
pub const FILE_FORMAT: &str = "doublet scenario";
/// Version of scenario files.
pub const FILE_VERSION: u32 = 1;

/// Designed inputs to be flown from trim, as a file states them.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct ScenarioFile {
    format: String,
    version: u32,
    aircraft: String,
    airspeed_m_s: f64,
    altitude_m: f64,
    gust_m_s: Option<f64>,
    rest_s: Option<f64>,
    loading: Option<Loading>,
    #[serde(default)]
    sensor_accuracy: InstrumentErrors,
    #[serde(default)]
    manoeuvre: Vec<ManoeuvreTable>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct ManoeuvreTable {
    name: String,
    duration_s: f64,
    time_s: Vec<f64>,
    #[serde(default)]
    aileron_rad: Vec<f64>,
    #[serde(default)]
    elevator_rad: Vec<f64>,
    #[serde(default)]
    rudder_rad: Vec<f64>,
    #[serde(default)]
    manifold_pa: Vec<f64>,
    sideslip_rad: Option<Vec<f64>>,
    bank_rad: Option<Vec<f64>>,
    #[serde(default)]
    level: bool,
    airspeed_m_s: Option<f64>,
    altitude_m: Option<f64>,
}

/// The scenario of a file (TOML) of designed inputs: `format`, `version`, `aircraft`, `airspeed_m_s`, `altitude_m`, `gust_m_s`, `rest_s`,
/// `[loading]` (fuel, seats, luggage and items, as in a session; without it that of the shipped flight), `[sensor_accuracy]` (standard deviations of
/// constant errors of the instruments by the names of [`crate::quantity::InstrumentError`], which each seed draws) and of each `[[manoeuvre]]` its
/// `name`, `duration_s`, the times `time_s` of its nodes and the deflections `aileron_rad`, `elevator_rad`, `rudder_rad`
/// and the change of manifold pressure `manifold_pa` of all engines at them, those left out being zero. The flight controls are held but for
/// the input, unless the pilot flies the manoeuvre: `sideslip_rad` or `bank_rad` at the nodes, at constant airspeed, or `level = true`, at
/// constant altitude. A manoeuvre with its own `airspeed_m_s` or `altitude_m` begins once the pilot has gone there.
///
/// # Errors
/// [`SimulateError::Scenario`]: a file that is none, columns of different lengths, times that fall; an unknown aircraft.
pub fn parse(text: &str) -> Result<Scenario, SimulateError> {
    /// Time between two inputs unless the file says otherwise, s.
    const REST_S: f64 = 15.0;
    let bad = |reason: String| SimulateError::Scenario { reason };
    let file: ScenarioFile = toml::from_str(text).map_err(|error| bad(toml_error::one_line(text, &error)))?;
    if file.format != FILE_FORMAT || file.version != FILE_VERSION {
        let (format, version) = (file.format, file.version);
        return Err(bad(format!(
            "format \"{format}\" version {version} is not \"{FILE_FORMAT}\" version {FILE_VERSION}"
        )));
    }
    if !aircraft().contains(&file.aircraft.as_str()) {
        return Err(bad(format!("no aircraft is called '{}': use one of {}", file.aircraft, aircraft().join(", "))));
    }
    let base = (file.airspeed_m_s, file.altitude_m);
    let mut inputs = Vec::with_capacity(file.manoeuvre.len());
    for table in file.manoeuvre {
        let condition = (table.airspeed_m_s.unwrap_or(base.0), table.altitude_m.unwrap_or(base.1));
        inputs.push((condition, table.input().map_err(bad)?));
    }
    let listed = Listed { name: "designed", description: "designed inputs from trim" };
    let rest_s = file.rest_s.unwrap_or(REST_S);
    for (key, value) in [("rest_s", rest_s), ("gust_m_s", file.gust_m_s.unwrap_or(0.0))] {
        if !(0.0..=1e4).contains(&value) {
            return Err(bad(format!("{key} = {value} must lie between 0 and 10000")));
        }
    }
    let mut scenario = flight_plan::designed(listed, base, inputs, rest_s)?;
    for (error, deviation) in &file.sensor_accuracy {
        error.check_deviation(*deviation).map_err(|reason| bad(format!("sensor_accuracy: {reason}")))?;
    }
    scenario.sensor_accuracy = file.sensor_accuracy;
    scenario.gust_m_s = file.gust_m_s.unwrap_or(scenario.gust_m_s);
    if let Some(loading) = file.loading {
        let mass = loading.mass_properties(&scenario.vehicle.aircraft);
        let issues = loading.issues(&scenario.vehicle.aircraft, &mass);
        if let Some(issue) = issues.iter().find(|issue| issue.is_impossible()) {
            return Err(bad(format!("loading: {issue}")));
        }
        scenario.loading = loading;
    }
    Ok(scenario)
}

impl ManoeuvreTable {
    /// The input, its columns and times checked.
    fn input(self) -> Result<DesignedInput, String> {
        let count = self.time_s.len();
        let name = self.name;
        let (hands, angle_rad) = match (self.sideslip_rad, self.bank_rad, self.level) {
            (None, None, false) => (Hands::Held, Vec::new()),
            (None, None, true) => (Hands::Level, Vec::new()),
            (Some(angle_rad), None, false) => (Hands::Sideslip, angle_rad),
            (None, Some(angle_rad), false) => (Hands::Turn, angle_rad),
            _ => return Err(format!("manoeuvre '{name}': state one of sideslip_rad, bank_rad and level")),
        };
        let columns = [
            ("aileron_rad", &self.aileron_rad),
            ("elevator_rad", &self.elevator_rad),
            ("rudder_rad", &self.rudder_rad),
            ("manifold_pa", &self.manifold_pa),
            ("the angle", &angle_rad),
        ];
        for (key, column) in columns {
            if !column.is_empty() && column.len() != count {
                return Err(format!("manoeuvre '{name}': {key} has {} values, time_s {count}", column.len()));
            }
        }
        if hands != Hands::Held && columns.iter().take(3).any(|(_, column)| !column.is_empty()) {
            return Err(format!("manoeuvre '{name}': the pilot moves the controls, so no deflection can be stated"));
        }
        let all = self.time_s.iter().chain(columns.iter().flat_map(|(_, column)| column.iter()));
        if all.chain([&self.duration_s]).any(|value| !value.is_finite()) {
            return Err(format!("manoeuvre '{name}': a value is not finite"));
        }
        let falls = self.time_s.windows(2).any(|pair| pair[1] < pair[0]);
        if falls || self.time_s.first().is_some_and(|first| *first < 0.0) {
            return Err(format!("manoeuvre '{name}': time_s must begin at zero or later and never fall"));
        }
        let last_s = self.time_s.last().copied().unwrap_or(0.0);
        if self.duration_s < last_s || self.duration_s > 1e4 {
            return Err(format!("manoeuvre '{name}': duration_s must lie between {last_s}, the last node, and 10000"));
        }
        let at = |column: &[f64], k: usize| column.get(k).copied().unwrap_or(0.0);
        let surfaces = [&self.aileron_rad, &self.elevator_rad, &self.rudder_rad];
        let deflections_rad = (0..count).map(|k| surfaces.map(|column| at(column, k))).collect();
        let (time_s, manifold_pa, held_s) = (self.time_s, self.manifold_pa, self.duration_s);
        Ok(DesignedInput { name, time_s, deflections_rad, manifold_pa, hands, angle_rad, held_s })
    }
}
