//! Instrument files: how the sensors of one installation turn into deflections, angles and fuel.
//!
//! TOML with `format = "doublet instruments"` and `version = 1`, in the units the calibrations were made in; everything behind
//! this file is SI. Unknown keys are refused with their line. Applied by `prep::control_surfaces`, `prep::air_data`, `prep::fuel`.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use serde::Deserialize;
use thiserror::Error;

use super::FileHeader;
use crate::airframe::instruments::{
    AirDataCalibration, ControlLinkage, FuelProbe, Instruments, LiftCurve, PedalCurve, PodCalibration, SensorMount,
    StatedNoise,
};
use crate::quantity::Role;
use crate::schema::{Refused, schema_of};
use crate::toml_error;

const FORMAT: &str = "doublet instruments";
const VERSION: u32 = 1;
/// International avoirdupois pound, kg (exact).
const POUND_KG: f64 = 0.453_592_37;

/// Why an instrument file cannot be used.
#[derive(Debug, Error)]
#[expect(missing_docs, reason = "the messages say what variants and fields are")]
pub enum InstrumentError {
    #[error("cannot read {}: {source}", path.display())]
    Unreadable { path: PathBuf, source: std::io::Error },
    #[error(
        "not an instrument file of version {VERSION}: format is '{format}', version {version}; expected '{FORMAT}'"
    )]
    Format { format: String, version: u32 },
    /// A key is unknown, missing or of the wrong kind.
    #[error("line {line}: {message}")]
    Syntax { line: usize, message: String },
    /// A value that cannot be.
    #[error("{key} is {value}, allowed is {allowed}")]
    Value { key: String, value: f64, allowed: &'static str },
    #[error("noise '{source_name}': role '{role}' not found, use the names of a channel map")]
    Role { source_name: String, role: String },
    #[error(
        "fuel_probe '{tank}': {actual} values of actual_lb, {displayed} of displayed_lb: give equally many, at least 2"
    )]
    Columns { tank: String, actual: usize, displayed: usize },
}

/// Reads an instrument file.
///
/// # Errors
/// [`InstrumentError`]: unreadable, of another format, a key with its line, a value out of range.
pub fn read(path: &Path) -> Result<Instruments, InstrumentError> {
    let unreadable = |source| InstrumentError::Unreadable { path: path.to_owned(), source };
    parse(&crate::load::read_text(path).map_err(unreadable)?)
}

/// Reads the text of an instrument file.
pub fn parse(text: &str) -> Result<Instruments, InstrumentError> {
    let header: FileHeader = toml::from_str(text).map_err(|error| syntax(text, &error))?;
    if header.format != FORMAT || header.version != VERSION {
        return Err(InstrumentError::Format { format: header.format, version: header.version });
    }
    let file: File = toml::from_str(text).map_err(|error| syntax(text, &error))?;
    let instruments = file.into_si()?;
    check(&instruments)?;
    Ok(instruments)
}

/// JSON Schema of instruments files.
pub fn schema() -> Result<serde_json::Value, Refused> {
    schema_of::<File>(FORMAT)
}

fn syntax(text: &str, error: &toml::de::Error) -> InstrumentError {
    let line = toml_error::line(text, error).unwrap_or(1);
    InstrumentError::Syntax { line, message: toml_error::message(error) }
}

/// Refuses what no installation can have.
fn check(instruments: &Instruments) -> Result<(), InstrumentError> {
    let control = &instruments.control;
    let positive = [
        ("control.drum_radius_mm", control.drum_radius_m),
        ("control.outboard_ratio", control.outboard_ratio),
        ("control.elevator.string_cm", control.string_m),
        ("air_data.lift_curve.cl_alpha_per_deg", instruments.air_data.lift_curve.slope_per_rad),
        ("air_data.lift_curve.area_m2", instruments.air_data.lift_curve.area_m2.unwrap_or(1.0)),
    ];
    if let Some((key, value)) = positive.into_iter().find(|(_, value)| !(*value > 0.0 && value.is_finite())) {
        return Err(InstrumentError::Value { key: key.to_owned(), value, allowed: POSITIVE });
    }
    if !(control.offset_m >= 0.0 && control.offset_m < control.string_m) {
        let key = "control.elevator.offset_cm".to_owned();
        return Err(InstrumentError::Value {
            key,
            value: 100.0 * control.offset_m,
            allowed: "zero to the string's length",
        });
    }
    if let Some(pedal) = control.pedals.iter().find(|pedal| !pedal.range_m[0].lt(&pedal.range_m[1])) {
        let key = format!("control.pedal '{}' range_m", pedal.sensor);
        return Err(InstrumentError::Value { key, value: pedal.range_m[1], allowed: "above its lower end" });
    }
    for probe in &instruments.fuel_probes {
        let (actual, displayed) = (probe.actual_kg.len(), probe.displayed_kg.len());
        if actual != displayed || actual < 2 {
            return Err(InstrumentError::Columns { tank: probe.tank.clone(), actual, displayed });
        }
        let rising = probe.actual_kg.windows(2).find(|pair| !pair[0].lt(&pair[1]));
        let falling = probe.displayed_kg.windows(2).find(|pair| !pair[0].le(&pair[1]));
        for (column, fault) in [("actual_lb", rising), ("displayed_lb", falling)] {
            if let Some(pair) = fault {
                let key = format!("fuel_probe '{}' {column}", probe.tank);
                return Err(InstrumentError::Value { key, value: pair[1] / POUND_KG, allowed: "above the one before" });
            }
        }
    }
    Ok(())
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct File {
    #[serde(rename = "format")]
    _format: String,
    #[serde(rename = "version")]
    _version: u32,
    name: String,
    #[serde(default)]
    notes: Vec<String>,
    control: ControlTable,
    air_data: AirDataTable,
    #[serde(default)]
    fuel_probe: Vec<ProbeTable>,
    #[serde(default)]
    noise: Vec<NoiseTable>,
}

/// Standard deviations by role from one source, SI.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct NoiseTable {
    source: String,
    #[serde(default)]
    always: bool,
    std: BTreeMap<String, f64>,
}

impl NoiseTable {
    fn into_roles(self, noise: &mut BTreeMap<Role, StatedNoise>) -> Result<(), InstrumentError> {
        let Self { source, always, std } = self;
        for (name, std) in std {
            let role = Role::from_name(&name)
                .ok_or_else(|| InstrumentError::Role { source_name: source.clone(), role: name.clone() })?;
            if !(std > 0.0 && std.is_finite()) {
                return Err(InstrumentError::Value { key: format!("noise {name}"), value: std, allowed: POSITIVE });
            }
            noise.insert(role, StatedNoise { std, source: source.clone(), always });
        }
        Ok(())
    }
}

/// Range of what cannot be zero.
const POSITIVE: &str = "finite and above zero";

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct ControlTable {
    reference_sensor: String,
    #[serde(default)]
    latency_s: f64,
    attitude_noise_deg: [f64; 3],
    drum_radius_mm: f64,
    outboard_ratio: f64,
    aileron: AileronTable,
    elevator: ElevatorTable,
    #[serde(default)]
    pedal: Vec<PedalTable>,
    #[serde(default)]
    mount: Vec<SensorMount>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct AileronTable {
    slope_deg_per_deg: f64,
    intercept_deg: f64,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct ElevatorTable {
    slope_deg_per_cm: f64,
    intercept_deg: f64,
    string_cm: f64,
    offset_cm: f64,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct PedalTable {
    sensor: String,
    deflection_deg_per_m: [f64; 6],
    range_m: [f64; 2],
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct AirDataTable {
    #[serde(default)]
    sideslip_offset_deg: f64,
    lift_curve: LiftCurveTable,
    #[serde(default)]
    pod: Vec<PodTable>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct LiftCurveTable {
    cl_alpha_per_deg: f64,
    cl_at_zero_alpha: f64,
    #[serde(default)]
    area_m2: Option<f64>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct PodTable {
    flight: String,
    exponent: Vec<f64>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct ProbeTable {
    tank: String,
    actual_lb: Vec<f64>,
    displayed_lb: Vec<f64>,
}

impl File {
    fn into_si(self) -> Result<Instruments, InstrumentError> {
        let mut noise = BTreeMap::new();
        self.noise.into_iter().try_for_each(|table| table.into_roles(&mut noise))?;
        let pounds = |values: Vec<f64>| values.into_iter().map(|lb| lb * POUND_KG).collect();
        let probe = |table: ProbeTable| FuelProbe {
            tank: table.tank,
            actual_kg: pounds(table.actual_lb),
            displayed_kg: pounds(table.displayed_lb),
        };
        Ok(Instruments {
            name: self.name,
            notes: self.notes,
            control: self.control.into_si(),
            air_data: self.air_data.into_si(),
            fuel_probes: self.fuel_probe.into_iter().map(probe).collect(),
            noise,
        })
    }
}

impl ControlTable {
    fn into_si(self) -> ControlLinkage {
        const CM: f64 = 0.01;
        ControlLinkage {
            reference_sensor: self.reference_sensor,
            latency_s: self.latency_s,
            attitude_noise_rad: self.attitude_noise_deg.map(f64::to_radians),
            drum_radius_m: self.drum_radius_mm / 1000.0,
            aileron_slope: self.aileron.slope_deg_per_deg,
            aileron_intercept_rad: self.aileron.intercept_deg.to_radians(),
            elevator_slope_rad_m: self.elevator.slope_deg_per_cm.to_radians() / CM,
            elevator_intercept_rad: self.elevator.intercept_deg.to_radians(),
            string_m: self.elevator.string_cm * CM,
            offset_m: self.elevator.offset_cm * CM,
            outboard_ratio: self.outboard_ratio,
            pedals: self.pedal.into_iter().map(read_pedal).collect(),
            mounts: self.mount,
        }
    }
}

fn read_pedal(table: PedalTable) -> PedalCurve {
    PedalCurve {
        sensor: table.sensor,
        coefficients: table.deflection_deg_per_m.map(f64::to_radians),
        range_m: table.range_m,
    }
}

impl AirDataTable {
    fn into_si(self) -> AirDataCalibration {
        let degree = 1f64.to_radians();
        let pod = |table: PodTable| {
            let mut exponent = table.exponent;
            // A factor of the exponential is a term of its exponent.
            exponent.iter_mut().take(1).for_each(|first| *first += degree.ln());
            PodCalibration { flight: table.flight, exponent }
        };
        let curve = self.lift_curve;
        AirDataCalibration {
            sideslip_offset_rad: self.sideslip_offset_deg.to_radians(),
            lift_curve: LiftCurve {
                slope_per_rad: curve.cl_alpha_per_deg / degree,
                at_zero_alpha: curve.cl_at_zero_alpha,
                area_m2: curve.area_m2,
            },
            pods: self.pod.into_iter().map(pod).collect(),
        }
    }
}
