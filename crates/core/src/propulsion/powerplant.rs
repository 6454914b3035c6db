//! Engines placed on an aircraft: thrust, total-pressure rise, moments about the centre of gravity, rotor momentum.

use std::sync::Arc;

use nalgebra::Vector3;
use serde::Deserialize;
use thiserror::Error;

use super::chart::EngineChart;
use super::off_range::{MapVariable, OffRange, OffRanges};
use super::propeller::PropellerMap;
use crate::airframe::EngineStation;

/// Sense of rotation of a rotor seen from behind, looking forward.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Rotation {
    /// Clockwise: angular momentum along +x of the body axes.
    #[default]
    Clockwise,
    /// Counter-clockwise: angular momentum along -x.
    CounterClockwise,
}

impl Rotation {
    /// +1 for clockwise, -1 for counter-clockwise.
    pub fn sign(self) -> f64 {
        match self {
            Self::Clockwise => 1.0,
            Self::CounterClockwise => -1.0,
        }
    }
}

/// How rotor momenta add up.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum RotorSum {
    /// With the sign of each rotation: counter-rotating propellers cancel.
    #[default]
    Signed,
    /// All of one sign, as thesis Eq. A.14 adds them.
    ThesisUnsigned,
}

/// Measured state of one engine.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct EngineInput {
    /// Crankshaft speed, rad/s.
    pub speed_rad_s: f64,
    /// Absolute manifold pressure, Pa.
    pub manifold_pressure_pa: f64,
}

/// The air an engine flies in.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Ambient {
    /// True airspeed, m/s.
    pub airspeed_m_s: f64,
    /// Pressure altitude, m.
    pub pressure_altitude_m: f64,
    /// Static air temperature, K.
    pub air_temperature_k: f64,
    /// Air density, kg/m³.
    pub density_kg_m3: f64,
}

/// What one engine and its propeller deliver.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct EngineState {
    /// Brake power, W.
    pub power_w: f64,
    /// Thrust along the propeller axis, N.
    pub thrust_n: f64,
    /// Propeller efficiency.
    pub efficiency: f64,
    /// Total-pressure rise over dynamic pressure, `eta_p P / (A_eff V q)`; not a number where V is not above zero.
    pub total_pressure_rise: f64,
    /// Advance ratio J.
    pub advance_ratio: f64,
    /// Thrust coefficient C_T; not a number where the engine does not turn.
    pub thrust_coefficient: f64,
    /// Power coefficient C_P.
    pub power_coefficient: f64,
    /// Inputs beyond the chart or the map.
    pub off_range: OffRanges,
}

/// Engine chart and propeller map of a direct-drive engine.
#[derive(Clone, Debug, PartialEq)]
pub struct EngineModel {
    /// Power.
    pub chart: Arc<EngineChart>,
    /// Thrust and efficiency.
    pub propeller: Arc<PropellerMap>,
}

/// Samples of the inputs of one engine over a flight, all of one length.
#[derive(Clone, Copy, Debug)]
pub struct EngineColumns<'a> {
    /// Crankshaft speed, rad/s.
    pub speed_rad_s: &'a [f64],
    /// Absolute manifold pressure, Pa.
    pub manifold_pressure_pa: &'a [f64],
    /// True airspeed, m/s.
    pub airspeed_m_s: &'a [f64],
    /// Pressure altitude, m.
    pub pressure_altitude_m: &'a [f64],
    /// Static air temperature, K.
    pub air_temperature_k: &'a [f64],
    /// Air density, kg/m³.
    pub density_kg_m3: &'a [f64],
}

/// One engine over a flight.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct EngineHistory {
    /// Brake power, W.
    pub power_w: Vec<f64>,
    /// Thrust, N.
    pub thrust_n: Vec<f64>,
    /// Thrust with every input beyond the chart or the map held at its edge, N; `thrust_n` where none is.
    pub thrust_at_edge_n: Vec<f64>,
    /// Propeller efficiency.
    pub efficiency: Vec<f64>,
    /// Advance ratio J; without bound where the engine does not turn.
    pub advance_ratio: Vec<f64>,
    /// Thrust coefficient C_T; not a number where the engine does not turn.
    pub thrust_coefficient: Vec<f64>,
    /// Total-pressure rise over dynamic pressure; not a number where the airspeed is not above zero.
    pub total_pressure_rise: Vec<f64>,
    /// For each input that left a chart or map: its furthest excursion and the number of samples outside.
    pub off_range: Vec<(OffRange, usize)>,
}

/// Input columns of different length.
#[derive(Clone, Debug, PartialEq, Eq, Error)]
#[error("{column} has {found} samples where engine speed has {expected}: resample all engine inputs to one time")]
pub struct ColumnLengthError {
    /// Name of the column.
    pub column: &'static str,
    /// Number of its samples.
    pub found: usize,
    /// Number of samples of engine speed.
    pub expected: usize,
}

impl EngineModel {
    /// Power, thrust and total-pressure rise of one engine.
    ///
    /// `J = V / (n D)`, `C_P = P / (rho n³ D⁵)`, `T = C_T rho n² D⁴` (Eq. 3.29; the thesis text names 3.15),
    /// `dp_t / q = eta_p P / (A_eff V q)` with `q = rho V² / 2` (Eq. 3.25-3.28, a = 0, b = eta_p / A_eff); n in
    /// revolutions per second. Thrust comes from the C_T map, the total-pressure rise from the eta map, as in the
    /// thesis. An engine that does not turn delivers nothing (windmilling drag is not modelled).
    pub fn state(&self, input: EngineInput, ambient: &Ambient) -> EngineState {
        let power = self.chart.power_w(
            input.speed_rad_s, input.manifold_pressure_pa, ambient.pressure_altitude_m, ambient.air_temperature_k,
        );
        let stopped = input.speed_rad_s <= 0.0;
        let power_w = if stopped { 0.0 } else { power.value_w };
        let mut state = self.state_at_power(power_w, input.speed_rad_s, ambient);
        state.off_range.merge(&power.off_range);
        state
    }

    /// The same from a power known otherwise, for example from the engine's monitor, W.
    pub fn state_at_power(&self, power_w: f64, speed_rad_s: f64, ambient: &Ambient) -> EngineState {
        let (density, airspeed) = (ambient.density_kg_m3, ambient.airspeed_m_s);
        let rise_at = |efficiency: f64| {
            let rise = efficiency * power_w / (self.propeller.effective_area_m2() * airspeed);
            if airspeed > 0.0 { rise / (0.5 * density * airspeed * airspeed) } else { f64::NAN }
        };
        if speed_rad_s <= 0.0 {
            return EngineState {
                power_w,
                thrust_n: 0.0,
                efficiency: 0.0,
                total_pressure_rise: rise_at(0.0),
                advance_ratio: f64::INFINITY,
                thrust_coefficient: f64::NAN,
                power_coefficient: 0.0,
                off_range: OffRanges::default(),
            };
        }
        let revolutions_s = speed_rad_s / std::f64::consts::TAU;
        let diameter = self.propeller.diameter_m();
        let advance_ratio = airspeed / (revolutions_s * diameter);
        let power_coefficient = power_w / (density * revolutions_s.powi(3) * diameter.powi(5));
        let point = self.propeller.lookup(advance_ratio, power_coefficient, speed_rad_s, ambient.pressure_altitude_m);
        EngineState {
            power_w,
            thrust_n: self.thrust_n(point.thrust_coefficient, speed_rad_s, density),
            efficiency: point.efficiency,
            total_pressure_rise: rise_at(point.efficiency),
            advance_ratio,
            thrust_coefficient: point.thrust_coefficient,
            power_coefficient,
            off_range: point.off_range,
        }
    }

    /// Thrust with every input held at the edge of the chart or map that it left, N: what is known without extrapolation. `state` is that
    /// of the same input.
    fn thrust_at_edge_n(&self, input: EngineInput, ambient: &Ambient, state: &EngineState) -> f64 {
        if state.off_range.is_empty() || input.speed_rad_s <= 0.0 {
            return state.thrust_n;
        }
        let held = |ranges: &OffRanges, variable: MapVariable, value: f64| {
            ranges.get(variable).map_or(value, |range| value.max(range.low).min(range.high))
        };
        let power = self.chart.power_w(
            held(&state.off_range, MapVariable::EngineSpeed, input.speed_rad_s),
            held(&state.off_range, MapVariable::ManifoldPressure, input.manifold_pressure_pa),
            held(&state.off_range, MapVariable::PressureAltitude, ambient.pressure_altitude_m),
            ambient.air_temperature_k,
        );
        let inside = self.state_at_power(power.value_w, input.speed_rad_s, ambient);
        let ranges = &inside.off_range;
        let point = self.propeller.lookup(
            held(ranges, MapVariable::AdvanceRatio, inside.advance_ratio),
            held(ranges, MapVariable::PowerCoefficient, inside.power_coefficient),
            held(ranges, MapVariable::PropellerSpeed, input.speed_rad_s),
            held(ranges, MapVariable::FlightLevel, ambient.pressure_altitude_m),
        );
        self.thrust_n(point.thrust_coefficient, input.speed_rad_s, ambient.density_kg_m3)
    }

    /// `T = C_T rho n^2 D^4`, N.
    fn thrust_n(&self, thrust_coefficient: f64, speed_rad_s: f64, density_kg_m3: f64) -> f64 {
        let revolutions_s = speed_rad_s / std::f64::consts::TAU;
        thrust_coefficient * density_kg_m3 * revolutions_s.powi(2) * self.propeller.diameter_m().powi(4)
    }

    /// The engine over all samples of a flight.
    ///
    /// # Errors
    /// [`ColumnLengthError`] when the columns differ in length.
    pub fn history(&self, columns: &EngineColumns<'_>) -> Result<EngineHistory, ColumnLengthError> {
        let samples = columns.check()?;
        let mut history = EngineHistory {
            power_w: Vec::with_capacity(samples),
            thrust_n: Vec::with_capacity(samples),
            thrust_at_edge_n: Vec::with_capacity(samples),
            efficiency: Vec::with_capacity(samples),
            advance_ratio: Vec::with_capacity(samples),
            thrust_coefficient: Vec::with_capacity(samples),
            total_pressure_rise: Vec::with_capacity(samples),
            off_range: Vec::new(),
        };
        let mut worst = OffRanges::default();
        let mut outside = [0_usize; MapVariable::ALL.len()];
        for k in 0..samples {
            let input = EngineInput {
                speed_rad_s: columns.speed_rad_s[k],
                manifold_pressure_pa: columns.manifold_pressure_pa[k],
            };
            let ambient = Ambient {
                airspeed_m_s: columns.airspeed_m_s[k],
                pressure_altitude_m: columns.pressure_altitude_m[k],
                air_temperature_k: columns.air_temperature_k[k],
                density_kg_m3: columns.density_kg_m3[k],
            };
            let state = self.state(input, &ambient);
            history.power_w.push(state.power_w);
            history.thrust_n.push(state.thrust_n);
            history.thrust_at_edge_n.push(self.thrust_at_edge_n(input, &ambient, &state));
            history.efficiency.push(state.efficiency);
            history.advance_ratio.push(state.advance_ratio);
            history.thrust_coefficient.push(state.thrust_coefficient);
            history.total_pressure_rise.push(state.total_pressure_rise);
            worst.merge(&state.off_range);
            for finding in state.off_range.iter() {
                outside[finding.variable as usize] += 1;
            }
        }
        history.off_range = worst.iter().map(|finding| (*finding, outside[finding.variable as usize])).collect();
        Ok(history)
    }
}

impl EngineColumns<'_> {
    /// Number of samples, when all columns have the same.
    fn check(&self) -> Result<usize, ColumnLengthError> {
        let expected = self.speed_rad_s.len();
        for (column, found) in [
            ("manifold pressure", self.manifold_pressure_pa.len()),
            ("airspeed", self.airspeed_m_s.len()),
            ("pressure altitude", self.pressure_altitude_m.len()),
            ("air temperature", self.air_temperature_k.len()),
            ("air density", self.density_kg_m3.len()),
        ] {
            if found != expected {
                return Err(ColumnLengthError { column, found, expected });
            }
        }
        Ok(expected)
    }
}

/// One engine on an aircraft.
#[derive(Clone, Debug, PartialEq)]
pub struct Engine {
    /// Name, point of action and incidence of the thrust line.
    pub station: EngineStation,
    /// Sense of rotation of the rotor.
    pub rotation: Rotation,
    /// Moment of inertia of everything that turns with the crankshaft about its axis, kg m².
    pub rotor_inertia_kg_m2: f64,
    /// Chart and propeller map, where known; without them thrust must be recorded.
    pub model: Option<EngineModel>,
}

impl Engine {
    /// Unit vector of the thrust in body axes: `(cos i, 0, -sin i)`.
    pub fn thrust_direction_body(&self) -> Vector3<f64> {
        Vector3::new(self.station.incidence_rad.cos(), 0.0, -self.station.incidence_rad.sin())
    }
}

/// All engines of an aircraft.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Powerplant {
    /// The engines, in the order of the recorded roles (1 left or front, 2 right or rear).
    pub engines: Vec<Engine>,
}

impl Powerplant {
    /// Angular momentum of the rotors in body axes, `h = sum s_i I_i omega_i d_i`, kg m²/s.
    ///
    /// `speed_rad_s` in the order of the engines, missing entries count as zero. The thesis (Eq. A.14) adds the speeds
    /// of the counter-rotating propellers of the C337F with one sign; [`RotorSum::ThesisUnsigned`] does so too.
    pub fn rotor_momentum_body(&self, speed_rad_s: &[f64], sum: RotorSum) -> Vector3<f64> {
        let mut momentum = Vector3::zeros();
        for (engine, &speed) in self.engines.iter().zip(speed_rad_s) {
            let sign = match sum {
                RotorSum::Signed => engine.rotation.sign(),
                RotorSum::ThesisUnsigned => 1.0,
            };
            momentum += sign * engine.rotor_inertia_kg_m2 * speed * engine.thrust_direction_body();
        }
        momentum
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Tolerance of closed-form sums of a few products, N m s.
    const TOLERANCE_N_M_S: f64 = 1e-9;

    fn engine(x_m: f64, z_m: f64, rotation: Rotation) -> Engine {
        Engine {
            station: EngineStation { name: String::new(), position_from_datum_m: [x_m, 0.0, z_m], incidence_rad: 0.0 },
            rotation,
            rotor_inertia_kg_m2: 7.7,
            model: None,
        }
    }

    fn skymaster() -> Powerplant {
        Powerplant {
            engines: vec![engine(0.57, 1.26, Rotation::Clockwise), engine(5.95, 1.47, Rotation::CounterClockwise)],
        }
    }

    #[test]
    fn counter_rotating_rotors_cancel_unless_added_the_thesis_way() {
        let powerplant = skymaster();
        let speeds = [240.0, 240.0];
        assert!(powerplant.rotor_momentum_body(&speeds, RotorSum::Signed).norm() < TOLERANCE_N_M_S);
        let thesis = powerplant.rotor_momentum_body(&speeds, RotorSum::ThesisUnsigned);
        assert!((thesis - Vector3::new(7.7 * 480.0, 0.0, 0.0)).norm() < TOLERANCE_N_M_S, "{thesis}");
    }
}
