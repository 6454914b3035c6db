//! Air over a window: altitude, static temperature and density, from what was recorded or the standard atmosphere.

use std::sync::Arc;

use doublet_core::atmos::{Atmosphere, AtmosphereError, density_kg_m3};
use doublet_core::message;
use doublet_core::message::Message;
use doublet_core::quantity::Role;

use super::window_context::WindowContext;
use crate::graph::StageResult;
use crate::session::{Finding, Level};

/// Farthest a recorded temperature may be from the standard one, K: beyond it the channel is not that of the outside air.
const FARTHEST_K: f64 = 30.0;
/// A mean difference from the standard temperature that is stated, K.
const WORTH_SAYING_K: f64 = 20.0;

/// Where the air density of a window comes from.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum AirDensity {
    /// Recorded itself.
    Recorded,
    /// Recorded static pressure and air temperature.
    PressureAndTemperature,
    /// Recorded static pressure at the temperature of the standard atmosphere.
    Pressure,
    /// The standard pressure at the recorded altitude, and the recorded air temperature.
    AltitudeAndTemperature,
    /// The standard atmosphere at the recorded altitude.
    RecordedAltitude,
    /// The standard atmosphere at the height above the sea that the satellites give.
    SatelliteAltitude,
    /// The standard atmosphere at an altitude that nothing recorded: that of the origin which the session assumes, m, and the
    /// climb of the path.
    AssumedAltitude(f64),
}

impl AirDensity {
    /// Name in results.
    pub fn name(self) -> &'static str {
        match self {
            Self::Recorded => "recorded",
            Self::PressureAndTemperature => "recorded pressure and temperature",
            Self::Pressure => "recorded pressure and standard temperature",
            Self::AltitudeAndTemperature => "standard pressure at the recorded altitude and recorded temperature",
            Self::RecordedAltitude => "standard atmosphere at the recorded altitude",
            Self::SatelliteAltitude => "standard atmosphere at the satellite altitude",
            Self::AssumedAltitude(_) => "standard atmosphere at an assumed altitude",
        }
    }

    /// That it is only assumed (`assumed`), where it is.
    pub fn finding(self) -> Option<Finding> {
        let Self::AssumedAltitude(origin_m) = self else { return None };
        let text = message!(
            "Altitude, pressure and density not recorded: density is that of {:.0} m above the sea at the start.",
            origin_m
        );
        let finding = Finding::new(Level::Caution, "assumed", "air density", text);
        let fix_text = "Map the pressure altitude, or check the stated initial altitude.";
        Some(finding.with_fix_text(fix_text).with_setting("Model", "preparation.origin_altitude_m"))
    }

    /// What a window says of it, where it is not recorded.
    fn warning(self) -> Option<Message> {
        let text = match self {
            Self::RecordedAltitude => {
                message!("air density comes from the standard atmosphere at the recorded altitude")
            }
            Self::AssumedAltitude(origin_m) => message!(
                "air density is assumed: standard atmosphere at {:.0} m at the start, plus the climb of the path",
                origin_m
            ),
            Self::Pressure => message!("air density comes from the recorded pressure at standard temperature"),
            Self::SatelliteAltitude => {
                message!("air density comes from the standard atmosphere at the satellite altitude")
            }
            Self::Recorded | Self::PressureAndTemperature | Self::AltitudeAndTemperature => return None,
        };
        Some(text)
    }
}

/// Air over a window, by sample.
#[derive(Clone, Debug)]
pub(super) struct WindowAir {
    /// Altitude above the sea, m.
    pub altitude_m: Arc<[f64]>,
    /// Static temperature, K.
    pub temperature_k: Arc<[f64]>,
    pub density_kg_m3: Arc<[f64]>,
    /// Where the density comes from.
    pub source: AirDensity,
    /// Findings, one line each.
    pub warnings: Vec<Message>,
}

/// Air over a window: density as recorded, else `rho = p / (R T)` with the static pressure as recorded or standard at the altitude, and
/// the static temperature as recorded or standard at the altitude. `down_m` is the path below its origin at `origin_m` above the sea.
pub(super) fn air_over(window: &WindowContext, down_m: &[f64], origin_m: f64) -> StageResult<WindowAir> {
    let (altitude_m, standard) = match window.values(Role::Altitude)? {
        Some(altitude) => (altitude, AirDensity::RecordedAltitude),
        None => altitude_without_channel(window, down_m, origin_m)?,
    };
    let at_altitude = |of: fn(&Atmosphere, f64) -> Result<f64, AtmosphereError>| {
        altitude_m.iter().map(|&m| of(&Atmosphere::STANDARD, m)).collect::<Result<Arc<[f64]>, _>>()
    };
    let mut warnings = Vec::new();
    let recorded_k = window.values(Role::AirTemperature)?;
    let recorded_k = recorded_k.filter(|recorded| is_outside_air(recorded, &altitude_m, &mut warnings));
    let (density_kg_m3, source) = if let Some(density) = window.values(Role::AirDensity)? {
        (density, AirDensity::Recorded)
    } else if let Some(temperature_k) = &recorded_k {
        let (pressure_pa, source) = match window.values(Role::StaticPressure)? {
            Some(pressure) => (pressure, AirDensity::PressureAndTemperature),
            None => (at_altitude(Atmosphere::pressure_pa)?, AirDensity::AltitudeAndTemperature),
        };
        let density = pressure_pa.iter().zip(temperature_k.iter()).map(|(&p, &t)| density_kg_m3(p, t));
        let is_assumed = matches!(standard, AirDensity::AssumedAltitude(_));
        (density.collect::<Result<_, _>>()?, if is_assumed { standard } else { source })
    } else {
        (at_altitude(Atmosphere::density_kg_m3)?, standard)
    };
    warnings.extend(source.warning());
    let temperature_k = match recorded_k {
        Some(recorded) => recorded,
        None => at_altitude(Atmosphere::temperature_k)?,
    };
    Ok(WindowAir { temperature_k, altitude_m, density_kg_m3, source, warnings })
}

/// Whether a recorded temperature can be that of the outside air; says so where it cannot, or where it is far from the standard one.
fn is_outside_air(recorded_k: &[f64], altitude_m: &[f64], warnings: &mut Vec<Message>) -> bool {
    let standard_k = |altitude_m: f64| Atmosphere::STANDARD.temperature_k(altitude_m).unwrap_or(f64::NAN);
    let apart = recorded_k.iter().zip(altitude_m).map(|(recorded, altitude_m)| recorded - standard_k(*altitude_m));
    let mean_k = apart.sum::<f64>() / recorded_k.len().max(1) as f64;
    let side = if mean_k > 0.0 { "above" } else { "below" };
    // Outside the atmosphere of the standard there is nothing to compare with.
    let is_usable = mean_k.is_nan() || mean_k.abs() <= FARTHEST_K;
    if !is_usable {
        warnings.push(message!(
            "air temperature is {:.0} K {} standard, which is implausible: standard temperature used",
            mean_k.abs(),
            side
        ));
    } else if mean_k.abs() > WORTH_SAYING_K {
        warnings.push(message!(
            "air temperature is {:.0} K {} standard: check its channel and unit",
            mean_k.abs(),
            side
        ));
    }
    is_usable
}

/// Altitude of a recording without a pressure altitude: that of its static pressure, else of the satellites, else an assumed one.
fn altitude_without_channel(
    window: &WindowContext,
    down_m: &[f64],
    origin_m: f64,
) -> StageResult<(Arc<[f64]>, AirDensity)> {
    if let Some(pressure) = window.values(Role::StaticPressure)? {
        let altitude = pressure.iter().map(|&pressure| Atmosphere::STANDARD.altitude_m(pressure));
        return Ok((altitude.collect::<Result<_, _>>()?, AirDensity::Pressure));
    }
    if let Some(altitude) = window.values(Role::GpsAltitude)? {
        return Ok((altitude, AirDensity::SatelliteAltitude));
    }
    Ok((down_m.iter().map(|down| origin_m - down).collect(), AirDensity::AssumedAltitude(origin_m)))
}
