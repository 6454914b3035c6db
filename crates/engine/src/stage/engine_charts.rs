//! What a propeller map and an engine model say by themselves, for charts.

use doublet_core::propulsion::{
    DensityRule, EngineModel, EnginePoint, EngineSensitivities, MapVariable, PropellerMap, Steps, engine_sensitivities,
};

use crate::graph::StageResult;

/// Power coefficients drawn, from the lowest of the map to the highest.
const LINES: usize = 6;
/// Advance ratios on each line.
const POINTS: usize = 60;

/// A propeller map at one engine speed and pressure altitude (thesis Fig. 6.17).
#[derive(Clone, Debug, PartialEq)]
pub struct PropellerCurves {
    pub name: String,
    /// Where its numbers come from.
    pub origin: String,
    /// Engine speed, rad/s.
    pub speed_rad_s: f64,
    /// Pressure altitude, m.
    pub altitude_m: f64,
    /// A line for each power coefficient.
    pub lines: Vec<PropellerLine>,
}

/// Efficiency and thrust coefficient over the advance ratio at one power coefficient.
#[derive(Clone, Debug, PartialEq)]
pub struct PropellerLine {
    /// `C_P = P / (rho n³ D⁵)`.
    pub power_coefficient: f64,
    /// Advance ratio `J = V / (n D)` and efficiency `eta_p = T V / P`.
    pub efficiency: Vec<[f64; 2]>,
    /// Advance ratio and thrust coefficient `C_T = T / (rho n² D⁴)`.
    pub thrust: Vec<[f64; 2]>,
}

/// The map inside its own range, at `speed_rad_s` and `altitude_m`.
pub fn propeller_curves(map: &PropellerMap, speed_rad_s: f64, altitude_m: f64) -> PropellerCurves {
    // Far outside the map names its range.
    let outside = map.lookup(f64::MAX.sqrt(), f64::MAX.sqrt(), speed_rad_s, altitude_m).off_range;
    let range = |variable| outside.get(variable).map_or([0.0, 1.0], |range| [range.low, range.high]);
    let (across, lines) = (range(MapVariable::AdvanceRatio), range(MapVariable::PowerCoefficient));
    let steps = |[low, high]: [f64; 2], count: usize| {
        (0..count).map(move |at| low + (high - low) * at as f64 / (count - 1) as f64)
    };
    let line = |power_coefficient: f64| {
        let at = |advance_ratio| (advance_ratio, map.lookup(advance_ratio, power_coefficient, speed_rad_s, altitude_m));
        let points: Vec<_> = steps(across, POINTS).map(at).collect();
        PropellerLine {
            power_coefficient,
            efficiency: points.iter().map(|(ratio, point)| [*ratio, point.efficiency]).collect(),
            thrust: points.iter().map(|(ratio, point)| [*ratio, point.thrust_coefficient]).collect(),
        }
    };
    PropellerCurves {
        name: map.name().to_owned(),
        origin: map.origin().to_owned(),
        speed_rad_s,
        altitude_m,
        lines: steps(lines, LINES).map(line).collect(),
    }
}

/// Partial derivatives of power, thrust and total-pressure rise at `point`, over the reading resolution of thesis 7.2.2
/// (Tables 7.13-7.14).
pub fn engine_partials(model: &EngineModel, point: &EnginePoint) -> StageResult<EngineSensitivities> {
    let found = engine_sensitivities(model, point, &Steps::READING_RESOLUTION, DensityRule::StandardPressure);
    found.map_err(|error| error.to_string().into())
}
