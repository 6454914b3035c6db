//! Altitude performance chart of a piston engine: power from engine speed, manifold pressure, altitude and temperature.

use super::grid::{TableError, bracket, check_grid, check_order, check_row};
use super::off_range::{MapVariable, OffRanges};
use crate::atmos::Atmosphere;

/// Power correction per kelvin off the standard temperature: 1 % per 10 degF (chart note; thesis 3.2.4 step 6).
pub(crate) const TEMPERATURE_CORRECTION_PER_K: f64 = 0.01 / (10.0 / 1.8);

/// Full-throttle altitudes nearer to sea level than this take the limit of the slope of AC instead of the chord, m.
const CHORD_LIMIT_M: f64 = 30.0;

/// Relative change of manifold pressure over which that limit is taken.
const LIMIT_STEP: f64 = 0.01;

/// Contents of an engine chart; rows belong to speeds. SI.
#[derive(Clone, Debug, PartialEq)]
pub struct EngineChartData {
    /// Name of the engine.
    pub name: String,
    /// Where the numbers come from, shown wherever results of the chart are.
    pub origin: String,
    /// Speeds of the lines, rad/s, increasing.
    pub speed_rad_s: Vec<f64>,
    /// Manifold pressures of the sea-level chart, Pa, increasing.
    pub manifold_pressure_pa: Vec<f64>,
    /// Sea-level power, W: `[speed][manifold pressure]`.
    pub sea_level_power_w: Vec<Vec<f64>>,
    /// Pressure altitudes of the altitude chart, m, increasing.
    pub altitude_m: Vec<f64>,
    /// Manifold pressure at full throttle, Pa: `[speed][altitude]`, decreasing with altitude.
    pub full_throttle_pressure_pa: Vec<Vec<f64>>,
    /// Power at full throttle, W: `[speed][altitude]`.
    pub full_throttle_power_w: Vec<Vec<f64>>,
}

/// A checked engine chart. Sea-level chart and altitude chart of a naturally aspirated engine, as its manufacturer
/// publishes them for best-power mixture; linear between lines and beyond them.
#[derive(Clone, Debug, PartialEq)]
pub struct EngineChart {
    data: EngineChartData,
}

/// Power read from a chart.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Power {
    /// Brake power at the crankshaft, W.
    pub value_w: f64,
    /// Inputs beyond the chart.
    pub off_range: OffRanges,
}

/// The full-throttle line crossed by a manifold pressure at one engine speed.
struct PointA {
    altitude_m: f64,
    power_w: f64,
    /// Manifold pressures the full-throttle line covers, Pa.
    low_pa: f64,
    high_pa: f64,
}

impl EngineChart {
    /// Checks that grids increase, full-throttle pressures decrease with altitude, and every table fits its grids.
    ///
    /// # Errors
    /// [`TableError`] naming the field, the index and the value.
    pub fn new(data: EngineChartData) -> Result<Self, TableError> {
        check_grid("engine speed", &data.speed_rad_s)?;
        check_grid("manifold pressure", &data.manifold_pressure_pa)?;
        check_grid("altitude", &data.altitude_m)?;
        let tables = [
            ("sea-level power", &data.sea_level_power_w, data.manifold_pressure_pa.len()),
            ("full-throttle manifold pressure", &data.full_throttle_pressure_pa, data.altitude_m.len()),
            ("full-throttle power", &data.full_throttle_power_w, data.altitude_m.len()),
        ];
        for (field, rows, columns) in tables {
            if rows.len() != data.speed_rad_s.len() {
                let expected = data.speed_rad_s.len();
                return Err(TableError::Shape { field: format!("rows of {field}"), found: rows.len(), expected });
            }
            for (line, row) in rows.iter().enumerate() {
                check_row(&format!("{field}[{line}]"), row, columns)?;
            }
        }
        for (line, row) in data.full_throttle_pressure_pa.iter().enumerate() {
            check_order(&format!("full-throttle manifold pressure[{line}]"), row, -1.0)?;
        }
        Ok(Self { data })
    }

    /// What the chart was made from.
    pub fn data(&self) -> &EngineChartData {
        &self.data
    }

    /// Brake power by the six steps of the altitude chart.
    ///
    /// A: altitude h_A and power P_A where the full-throttle line of this speed has this manifold pressure. B, C:
    /// sea-level power P_B at speed and manifold pressure. D: `P = P_B + (P_A - P_B) h_p / h_A`. Temperature:
    /// `P (1 - 0.0018 (T - T_ISA(h_p)))`, 1 % per 10 degF. Each lookup is linear in its inputs and extrapolates
    /// linearly; A is interpolated in speed between the two neighbouring full-throttle lines. Where h_A is within 30 m
    /// of sea level the chord AC is replaced by its limit, the change of `P_A - P_B` over that of h_A with manifold
    /// pressure.
    ///
    /// `speed_rad_s` crankshaft speed; `manifold_pressure_pa` absolute; `pressure_altitude_m`; `air_temperature_k`
    /// static (inlet) temperature. Valid for the mixture of the chart, up to 11 km; an input that is not a number, or an
    /// altitude outside the standard troposphere, gives a power that is not a number. Thesis 3.2.4 steps 1-6, Figure 3.7.
    pub fn power_w(
        &self,
        speed_rad_s: f64,
        manifold_pressure_pa: f64,
        pressure_altitude_m: f64,
        air_temperature_k: f64,
    ) -> Power {
        let data = &self.data;
        let speed = bracket(&data.speed_rad_s, speed_rad_s);
        let a = self.point_a(speed, manifold_pressure_pa);
        let power_b = self.sea_level_power(speed, manifold_pressure_pa);
        let slope = if a.altitude_m.abs() < CHORD_LIMIT_M {
            self.slope_at_sea_level(speed, manifold_pressure_pa)
        } else {
            (a.power_w - power_b) / a.altitude_m
        };
        let standard_k = Atmosphere::STANDARD.temperature_k(pressure_altitude_m).unwrap_or(f64::NAN);
        let above_standard_k = air_temperature_k - standard_k;
        let value_w = (power_b + slope * pressure_altitude_m) * (1.0 - TEMPERATURE_CORRECTION_PER_K * above_standard_k);

        let mut off_range = OffRanges::default();
        let (speeds, pressures) = (&data.speed_rad_s, &data.manifold_pressure_pa);
        off_range.check(MapVariable::EngineSpeed, speed_rad_s, speeds[0], speeds[speeds.len() - 1]);
        let low = pressures[0].max(a.low_pa);
        let high = pressures[pressures.len() - 1].min(a.high_pa);
        off_range.check(MapVariable::ManifoldPressure, manifold_pressure_pa, low, high);
        let (floor, ceiling) = (a.altitude_m.min(0.0), a.altitude_m.max(0.0));
        off_range.check(MapVariable::PressureAltitude, pressure_altitude_m, floor, ceiling);
        Power { value_w, off_range }
    }

    /// Point A: interpolated in speed between the crossings of the two neighbouring full-throttle lines.
    fn point_a(&self, (line, weight): (usize, f64), pressure_pa: f64) -> PointA {
        let data = &self.data;
        let mut point = PointA { altitude_m: 0.0, power_w: 0.0, low_pa: 0.0, high_pa: 0.0 };
        for (row, share) in [(line, 1.0 - weight), (line + 1, weight)] {
            let pressures = &data.full_throttle_pressure_pa[row];
            let last = pressures.len() - 1;
            let lower = pressures.partition_point(|&p| p >= pressure_pa).saturating_sub(1).min(last - 1);
            let t = (pressure_pa - pressures[lower]) / (pressures[lower + 1] - pressures[lower]);
            let between = |values: &[f64]| values[lower] + t * (values[lower + 1] - values[lower]);
            point.altitude_m += share * between(&data.altitude_m);
            point.power_w += share * between(&data.full_throttle_power_w[row]);
            point.low_pa += share * pressures[last];
            point.high_pa += share * pressures[0];
        }
        point
    }

    /// Sea-level power, bilinear in speed and manifold pressure, W.
    fn sea_level_power(&self, (line, weight): (usize, f64), pressure_pa: f64) -> f64 {
        let (column, t) = bracket(&self.data.manifold_pressure_pa, pressure_pa);
        let at = |row: usize| {
            let values = &self.data.sea_level_power_w[row];
            values[column] + t * (values[column + 1] - values[column])
        };
        (1.0 - weight) * at(line) + weight * at(line + 1)
    }

    /// Limit of the slope of AC as A comes down to sea level, W/m.
    fn slope_at_sea_level(&self, speed: (usize, f64), pressure_pa: f64) -> f64 {
        let excess = |pressure: f64| {
            let a = self.point_a(speed, pressure);
            (a.power_w - self.sea_level_power(speed, pressure), a.altitude_m)
        };
        let (low, high) = (excess(pressure_pa * (1.0 - LIMIT_STEP)), excess(pressure_pa * (1.0 + LIMIT_STEP)));
        (low.0 - high.0) / (low.1 - high.1)
    }
}
