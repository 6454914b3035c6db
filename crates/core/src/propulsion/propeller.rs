//! Propeller performance maps: efficiency and thrust coefficient of a constant-speed propeller.

use super::grid::{TableError, bracket, check_grid, check_positive, check_row};
use super::off_range::{MapVariable, OffRanges};

/// One map, at one pressure altitude and engine speed.
#[derive(Clone, Debug, PartialEq)]
pub struct PropellerMapTable {
    /// Pressure altitude, m.
    pub flight_level_m: f64,
    /// Engine speed, rad/s.
    pub speed_rad_s: f64,
    /// Efficiency: `[power coefficient][advance ratio]`.
    pub efficiency: Vec<Vec<f64>>,
    /// Thrust coefficient: `[power coefficient][advance ratio]`.
    pub thrust_coefficient: Vec<Vec<f64>>,
}

/// Contents of a propeller map. SI.
#[derive(Clone, Debug, PartialEq)]
pub struct PropellerMapData {
    /// Name of the propeller.
    pub name: String,
    /// Where the numbers come from, shown wherever results of the map are.
    pub origin: String,
    /// Diameter, m.
    pub diameter_m: f64,
    /// Area the thrust acts on in the total-pressure rise, m²: disc less spinner.
    pub effective_area_m2: f64,
    /// Pressure altitudes of the maps, m, increasing.
    pub flight_level_m: Vec<f64>,
    /// Engine speeds of the maps, rad/s, increasing.
    pub speed_rad_s: Vec<f64>,
    /// Advance ratios, increasing.
    pub advance_ratio: Vec<f64>,
    /// Power coefficients, increasing.
    pub power_coefficient: Vec<f64>,
    /// One table for each pair of pressure altitude and engine speed, in any order.
    pub tables: Vec<PropellerMapTable>,
}

/// A checked propeller map, linear in advance ratio, power coefficient, pressure altitude and engine speed inside and
/// outside its grids.
#[derive(Clone, Debug, PartialEq)]
pub struct PropellerMap {
    /// What it was made from, without its tables.
    data: PropellerMapData,
    /// Efficiency and thrust coefficient side by side: `[flight level][speed][power coefficient][advance ratio]`.
    values: Vec<[f64; 2]>,
}

/// What a propeller map says at one point.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PropellerPoint {
    /// Propeller efficiency eta_p = T V / P.
    pub efficiency: f64,
    /// Thrust coefficient C_T = T / (rho n² D⁴).
    pub thrust_coefficient: f64,
    /// Inputs beyond the map.
    pub off_range: OffRanges,
}

impl PropellerMap {
    /// Checks that grids increase, that every pair of altitude and speed has one table, and that tables fit the grids.
    ///
    /// # Errors
    /// [`TableError`] naming the field, the index and the value.
    pub fn new(data: PropellerMapData) -> Result<Self, TableError> {
        check_positive("diameter", data.diameter_m)?;
        check_positive("effective area", data.effective_area_m2)?;
        check_grid("flight level", &data.flight_level_m)?;
        check_grid("engine speed", &data.speed_rad_s)?;
        check_grid("advance ratio", &data.advance_ratio)?;
        check_grid("power coefficient", &data.power_coefficient)?;
        let (columns, rows) = (data.advance_ratio.len(), data.power_coefficient.len());
        let expected = data.flight_level_m.len() * data.speed_rad_s.len();
        if data.tables.len() != expected {
            return Err(TableError::Shape { field: "list of maps".to_owned(), found: data.tables.len(), expected });
        }
        let mut values = Vec::with_capacity(expected * columns * rows);
        for &flight_level_m in &data.flight_level_m {
            for &speed_rad_s in &data.speed_rad_s {
                let of_pair =
                    |t: &&PropellerMapTable| t.flight_level_m == flight_level_m && t.speed_rad_s == speed_rad_s;
                let count = data.tables.iter().filter(of_pair).count();
                let Some(table) = data.tables.iter().find(of_pair).filter(|_| count == 1) else {
                    return Err(TableError::MapCount { flight_level_m, speed_rad_s, count });
                };
                append_table(table, rows, columns, &mut values)?;
            }
        }
        Ok(Self { data: PropellerMapData { tables: Vec::new(), ..data }, values })
    }

    /// Name of the propeller.
    pub fn name(&self) -> &str {
        &self.data.name
    }

    /// Where the numbers come from.
    pub fn origin(&self) -> &str {
        &self.data.origin
    }

    /// Diameter D, m.
    pub fn diameter_m(&self) -> f64 {
        self.data.diameter_m
    }

    /// Effective area A_eff of the total-pressure rise, m².
    pub(crate) fn effective_area_m2(&self) -> f64 {
        self.data.effective_area_m2
    }

    /// Efficiency and thrust coefficient, linear in J and C_P inside each map, then in pressure altitude and speed.
    ///
    /// `J = V / (n D)`, `C_P = P / (rho n³ D⁵)` with n in revolutions per second (thesis Eq. 3.29);
    /// `speed_rad_s` engine speed; `pressure_altitude_m`. Beyond a grid the outermost pair extrapolates linearly and
    /// the input is named in [`PropellerPoint::off_range`]. Thesis 3.2.4, Table 3.1.
    pub fn lookup(
        &self,
        advance_ratio: f64,
        power_coefficient: f64,
        speed_rad_s: f64,
        pressure_altitude_m: f64,
    ) -> PropellerPoint {
        let (level, level_w) = bracket(&self.data.flight_level_m, pressure_altitude_m);
        let (speed, speed_w) = bracket(&self.data.speed_rad_s, speed_rad_s);
        let (row, row_w) = bracket(&self.data.power_coefficient, power_coefficient);
        let (column, column_w) = bracket(&self.data.advance_ratio, advance_ratio);
        let columns = self.data.advance_ratio.len();
        let mut sum = [0.0; 2];
        for (l, lw) in [(level, 1.0 - level_w), (level + 1, level_w)] {
            for (s, sw) in [(speed, 1.0 - speed_w), (speed + 1, speed_w)] {
                for (r, rw) in [(row, 1.0 - row_w), (row + 1, row_w)] {
                    let start =
                        ((l * self.data.speed_rad_s.len() + s) * self.data.power_coefficient.len() + r) * columns;
                    let (left, right) = (self.values[start + column], self.values[start + column + 1]);
                    let weight = lw * sw * rw;
                    for k in 0..2 {
                        sum[k] += weight * (left[k] + column_w * (right[k] - left[k]));
                    }
                }
            }
        }
        let mut off_range = OffRanges::default();
        for (variable, grid, value) in [
            (MapVariable::AdvanceRatio, &self.data.advance_ratio, advance_ratio),
            (MapVariable::PowerCoefficient, &self.data.power_coefficient, power_coefficient),
            (MapVariable::PropellerSpeed, &self.data.speed_rad_s, speed_rad_s),
            (MapVariable::FlightLevel, &self.data.flight_level_m, pressure_altitude_m),
        ] {
            off_range.check(variable, value, grid[0], grid[grid.len() - 1]);
        }
        PropellerPoint { efficiency: sum[0], thrust_coefficient: sum[1], off_range }
    }
}

/// Checks one table and appends its efficiency and thrust coefficient.
fn append_table(
    table: &PropellerMapTable,
    rows: usize,
    columns: usize,
    values: &mut Vec<[f64; 2]>,
) -> Result<(), TableError> {
    for (field, lines) in [("efficiency", &table.efficiency), ("thrust coefficient", &table.thrust_coefficient)] {
        if lines.len() != rows {
            let field = format!("rows of {field} at {} m, {} rad/s", table.flight_level_m, table.speed_rad_s);
            return Err(TableError::Shape { field, found: lines.len(), expected: rows });
        }
        for (index, line) in lines.iter().enumerate() {
            check_row(&format!("{field}[{index}]"), line, columns)?;
        }
    }
    for (efficiency, thrust) in table.efficiency.iter().zip(&table.thrust_coefficient) {
        values.extend(efficiency.iter().zip(thrust).map(|(&eta, &ct)| [eta, ct]));
    }
    Ok(())
}
