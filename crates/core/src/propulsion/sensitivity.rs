//! Sensitivity of power, thrust and total-pressure rise to the inputs of the engine model (thesis 7.2.2).

use super::powerplant::{Ambient, EngineInput, EngineModel, EngineState};
use crate::atmos::{Atmosphere, AtmosphereError, density_kg_m3};

/// How the density follows from pressure altitude and sea-level temperature.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum DensityRule {
    /// Static pressure is the standard pressure at the pressure altitude, which is what pressure altitude means.
    #[default]
    StandardPressure,
    /// The sea-level temperature enters the pressure too, as in the thesis: `p = p0 (1 - L h / T_sl)^5.2559`.
    ThesisSeaLevelTemperature,
}

/// Inputs of the engine model at one point.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct EnginePoint {
    /// Crankshaft speed, rad/s.
    pub speed_rad_s: f64,
    /// Absolute manifold pressure, Pa.
    pub manifold_pressure_pa: f64,
    /// Static air temperature at sea level, K; it falls with the standard lapse rate.
    pub sea_level_temperature_k: f64,
    /// Pressure altitude, m.
    pub pressure_altitude_m: f64,
    /// True airspeed, m/s.
    pub airspeed_m_s: f64,
}

/// An input of [`EnginePoint`].
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum PointInput {
    /// Engine speed, rad/s.
    EngineSpeed,
    /// Manifold pressure, Pa.
    ManifoldPressure,
    /// Sea-level temperature, K.
    SeaLevelTemperature,
    /// Pressure altitude, m.
    PressureAltitude,
    /// True airspeed, m/s.
    Airspeed,
}

/// An output of the engine model.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum EngineOutput {
    /// Brake power, W.
    Power,
    /// Thrust, N.
    Thrust,
    /// Total-pressure rise over dynamic pressure.
    TotalPressureRise,
}

impl PointInput {
    /// All of them, in the column order of thesis Tables 7.13-7.14.
    pub const ALL: [Self; 5] =
        [Self::EngineSpeed, Self::ManifoldPressure, Self::SeaLevelTemperature, Self::PressureAltitude, Self::Airspeed];
}

impl EngineOutput {
    /// All of them, in the row order of thesis Tables 7.13-7.14.
    pub const ALL: [Self; 3] = [Self::Power, Self::Thrust, Self::TotalPressureRise];
}

/// Half-widths of the central differences, one per input in the order of [`PointInput::ALL`], SI.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Steps(pub [f64; 5]);

impl Steps {
    /// Reading resolution of thesis 7.2.2: 5 rpm, 0.05 inHg, 0.125 K, 0.15 m, 0.016 m/s.
    pub const READING_RESOLUTION: Self =
        Self([5.0 * std::f64::consts::TAU / 60.0, 0.05 * 3386.389, 0.125, 0.15, 0.016]);

    /// A fraction of each value of `point`, for example 0.05 for ±5 %. The thesis names this beside the absolute
    /// steps, which its numbers agree with; where the step crosses a line of the chart the two differ.
    pub fn fraction_of(point: &EnginePoint, fraction: f64) -> Self {
        Self(point.values().map(|value| fraction * value.abs()))
    }
}

/// Partial derivatives of the engine model at one point.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct EngineSensitivities {
    /// Values at the point itself.
    pub nominal: EngineState,
    /// `d output / d input` in SI units: rows [`EngineOutput::ALL`], columns [`PointInput::ALL`].
    pub partials: [[f64; 5]; 3],
}

impl EngineSensitivities {
    /// `d output / d input`, SI.
    pub fn partial(&self, output: EngineOutput, input: PointInput) -> f64 {
        self.partials[output as usize][input as usize]
    }

    /// Largest change of each output that one input off by its reading resolution causes, `max |partial| step`.
    ///
    /// Thesis 7.2.2 quotes 0.5 hp, 6 N and 0.002 for it.
    pub fn reading_uncertainty(&self, resolution: &Steps) -> [f64; 3] {
        self.partials.map(|row| row.iter().zip(resolution.0).map(|(d, step)| (d * step).abs()).fold(0.0, f64::max))
    }
}

impl EnginePoint {
    /// Values in the order of [`PointInput::ALL`].
    fn values(&self) -> [f64; 5] {
        [
            self.speed_rad_s, self.manifold_pressure_pa, self.sea_level_temperature_k, self.pressure_altitude_m,
            self.airspeed_m_s,
        ]
    }

    /// The point with these values, in the order of [`PointInput::ALL`].
    fn from_values(values: [f64; 5]) -> Self {
        let [speed_rad_s, manifold_pressure_pa, sea_level_temperature_k, pressure_altitude_m, airspeed_m_s] = values;
        Self { speed_rad_s, manifold_pressure_pa, sea_level_temperature_k, pressure_altitude_m, airspeed_m_s }
    }

    /// The air at this point: temperature `T_sl - L h`, density by `rule`.
    ///
    /// # Errors
    /// [`AtmosphereError`] for a temperature or altitude outside the troposphere's range.
    pub fn ambient(&self, rule: DensityRule) -> Result<Ambient, AtmosphereError> {
        let altitude_m = self.pressure_altitude_m;
        let standard = Atmosphere::STANDARD;
        let day = Atmosphere::new(standard.sea_level_pressure_pa(), self.sea_level_temperature_k)?;
        let air_temperature_k = day.temperature_k(altitude_m)?;
        let pressure_pa = match rule {
            DensityRule::StandardPressure => standard.pressure_pa(altitude_m)?,
            DensityRule::ThesisSeaLevelTemperature => day.pressure_pa(altitude_m)?,
        };
        Ok(Ambient {
            airspeed_m_s: self.airspeed_m_s,
            pressure_altitude_m: altitude_m,
            air_temperature_k,
            density_kg_m3: density_kg_m3(pressure_pa, air_temperature_k)?,
        })
    }
}

/// Power, thrust and total-pressure rise at `point` and their central differences to its five inputs.
///
/// `d y / d x = (y(x + step) - y(x - step)) / (2 step)` (thesis Eq. 7.1). A total-pressure rise that is not defined
/// (airspeed not above zero) leaves its row not a number; so does a step of zero in its column. Thesis 7.2.2,
/// Tables 7.13-7.14.
///
/// # Errors
/// [`AtmosphereError`] where the point or a step from it leaves the troposphere's range.
pub fn engine_sensitivities(
    model: &EngineModel,
    point: &EnginePoint,
    steps: &Steps,
    rule: DensityRule,
) -> Result<EngineSensitivities, AtmosphereError> {
    let state_at = |values: [f64; 5]| {
        let point = EnginePoint::from_values(values);
        let input = EngineInput { speed_rad_s: point.speed_rad_s, manifold_pressure_pa: point.manifold_pressure_pa };
        Ok(model.state(input, &point.ambient(rule)?))
    };
    let outputs = |state: &EngineState| [state.power_w, state.thrust_n, state.total_pressure_rise];
    let values = point.values();
    let mut partials = [[0.0; 5]; 3];
    for (input, step) in steps.0.into_iter().enumerate() {
        let (mut low, mut high) = (values, values);
        low[input] -= step;
        high[input] += step;
        let (low, high) = (outputs(&state_at(low)?), outputs(&state_at(high)?));
        for output in 0..partials.len() {
            partials[output][input] = (high[output] - low[output]) / (2.0 * step);
        }
    }
    Ok(EngineSensitivities { nominal: state_at(values)?, partials })
}
