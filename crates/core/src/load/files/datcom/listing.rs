//! Reads the pages of a listing.

use super::cards::{Heading, Lines, numbers};
use super::{
    AileronTable, DatcomConditions, DatcomListing, DownwashTable, DynamicTable, ElevatorTable, ListingError,
    StaticTable,
};
use crate::atmos::GAS_CONSTANT_AIR_J_KG_K;

const STATIC_LABELS: [&str; 12] = ["ALPHA", "CD", "CL", "CM", "CN", "CA", "XCP", "CLA", "CMA", "CYB", "CNB", "CLB"];
const DOWNWASH_LABELS: [&str; 4] = ["ALPHA", "Q/QINF", "EPSLON", "D(EPSLON)/D(ALPHA)"];
const DYNAMIC_LABELS: [&str; 10] = ["ALPHA", "CLQ", "CMQ", "CLAD", "CMAD", "CLP", "CYP", "CNP", "CNR", "CLR"];
const ELEVATOR_LABELS: [&str; 8] = ["DELTA", "D(CL)", "D(CM)", "D(CL MAX)", "D(CD MIN)", "(CLA)D", "(CH)A", "(CH)D"];
const ROLL_LABELS: [&str; 3] = ["DELTAL", "DELTAR", "(CL)ROLL"];

/// Length of one foot, m.
const M_PER_FT: f64 = 0.3048;
/// Pressure of one pound-force per square foot, Pa.
const PA_PER_LB_FT2: f64 = 47.880_26;
/// Force of one pound-force, N.
const N_PER_LB: f64 = 4.448_222;
/// Relative difference from which a repeated header is said to disagree: two units of its last printed digit.
const HEADER_TOLERANCE: f64 = 5e-3;
/// Relative difference from which the printed lift coefficient of level flight is said to disagree.
const LEVEL_FLIGHT_TOLERANCE: f64 = 0.01;

/// What has been read so far.
#[derive(Default)]
struct Reader {
    title: String,
    conditions: Option<DatcomConditions>,
    /// Whether the page at hand is at the first page's flight condition.
    foreign: bool,
    /// Whether the page at hand describes a control on the horizontal tail.
    tail_control: bool,
    /// Factor of the derivatives of the next table to 1/rad.
    per_rad: Option<f64>,
    alpha_rad: Vec<f64>,
    statics: Option<StaticTable>,
    downwash: Option<DownwashTable>,
    dynamic: Option<DynamicTable>,
    elevator: Option<ElevatorTable>,
    aileron: Option<AileronTable>,
    /// Yaw table, printed before the roll table of the same ailerons.
    yaw: Vec<Vec<f64>>,
    weight_n: Option<f64>,
    level_flight_cl: Option<f64>,
    complete: bool,
    warnings: Vec<String>,
}

impl DatcomListing {
    /// Reads a listing from its text.
    ///
    /// Pages of another flight condition than the first are left out, with a warning; so are tables that repeat with
    /// other values. Known faults of the program are recognised: the header of control pages whose pressure and
    /// temperature are converted twice, and a level-flight lift coefficient that takes newtons for pounds.
    ///
    /// # Errors
    /// [`ListingError`] with line and reason, for text that is not a listing, is cut off or holds what is no number.
    pub fn parse(text: &str) -> Result<Self, ListingError> {
        let lines = Lines::new(text);
        let mut reader = Reader::default();
        for index in 0..lines.len() {
            if let Some(line) = lines.get(index) {
                reader.line(&lines, index, line)?;
            }
        }
        reader.finish(lines.len())
    }
}

impl Reader {
    /// Takes in line `index`.
    fn line(&mut self, lines: &Lines<'_>, index: usize, line: &str) -> Result<(), ListingError> {
        if line.contains("CONFIGURATION") {
            self.tail_control = line.contains("TAIL") && line.contains("FLAP");
            if self.title.is_empty() {
                let title = lines.get(index + 1).unwrap_or_default();
                self.title = title.trim_matches(|c: char| c.is_whitespace() || c == '-').to_owned();
            }
        } else if line.contains("DEG K") || line.contains("DEG R") {
            self.header(lines, index, line)?;
        } else if line.contains("END OF JOB") {
            self.complete = true;
        }
        if line.contains("(PER RADIAN)") {
            self.per_rad = Some(1.0);
        } else if line.contains("(PER DEGREE)") {
            self.per_rad = Some(1.0_f64.to_degrees());
        }
        if self.foreign {
            return Ok(());
        }
        if line.contains("VEHICLE WEIGHT") || line.contains("LEVEL FLIGHT LIFT") {
            return self.weight(index, line);
        }
        self.tables(lines, index, line)
    }

    /// Recognises the heading of a table and reads it.
    fn tables(&mut self, lines: &Lines<'_>, index: usize, line: &str) -> Result<(), ListingError> {
        if let Some(heading) = Heading::find(line, &DYNAMIC_LABELS) {
            let columns = lines.table(index, &heading, 1, "dynamic derivatives")?;
            self.dynamic_table(index, columns)
        } else if let Some(heading) = Heading::find(line, &STATIC_LABELS) {
            let columns = lines.table(index, &heading, 4, "static characteristics")?;
            self.static_table(index, columns)
        } else if let Some(heading) = Heading::find(line, &DOWNWASH_LABELS) {
            let mut columns = lines.table(index, &heading, 4, "downwash")?.into_iter();
            let mut next = || columns.next().unwrap_or_default();
            self.check_alpha(index, &next())?;
            let table = DownwashTable { pressure_ratio: next(), downwash_rad: radians(&next()), gradient: next() };
            keep_first(&mut self.downwash, table, "downwash", index, &mut self.warnings);
            Ok(())
        } else if let Some(heading) = Heading::find(line, &ELEVATOR_LABELS) {
            let columns = lines.table(index, &heading, 3, "elevator increments")?;
            self.elevator_table(index, columns);
            Ok(())
        } else if line.contains("(DELTAL-DELTAR)=") {
            let (_, alpha, matrix) = lines.matrix(index, "yaw due to ailerons")?;
            self.check_alpha(index, &alpha)?;
            self.yaw = matrix;
            Ok(())
        } else if line.contains("DELTA =") {
            let (deflection, alpha, matrix) = lines.matrix(index, "induced drag of the control")?;
            self.check_alpha(index, &alpha)?;
            if let Some(elevator) = &mut self.elevator
                && self.tail_control
                && elevator.deflection_rad.len() == deflection.len()
                && elevator.cd_induced.is_empty()
            {
                elevator.cd_induced = matrix;
            }
            Ok(())
        } else if let Some(heading) = Heading::find(line, &ROLL_LABELS) {
            let mut columns = lines.table(index, &heading, 3, "roll due to ailerons")?.into_iter();
            let mut next = || columns.next().unwrap_or_default();
            let (left_rad, right_rad, roll) = (radians(&next()), radians(&next()), next());
            let yaw = std::mem::take(&mut self.yaw);
            let yaw = if yaw.iter().all(|row| row.len() == roll.len()) { yaw } else { Vec::new() };
            let table = AileronTable { left_rad, right_rad, roll, yaw };
            keep_first(&mut self.aileron, table, "roll due to ailerons", index, &mut self.warnings);
            Ok(())
        } else {
            Ok(())
        }
    }

    /// Reads flight condition and reference dimensions below the units in line `index`.
    fn header(&mut self, lines: &Lines<'_>, index: usize, units: &str) -> Result<(), ListingError> {
        const TABLE: &str = "flight conditions";
        let unit = units.split_whitespace().next().unwrap_or_default();
        let (length, pressure, temperature) = match unit {
            "M" => (1.0, 1.0, 1.0),
            "FT" => (M_PER_FT, PA_PER_LB_FT2, 1.0 / 1.8),
            _ => return Err(ListingError::Units { line: index + 1, unit: unit.chars().take(8).collect() }),
        };
        let row = index + 1;
        let line = lines.get(row).unwrap_or_default();
        let values = numbers(line.strip_prefix('0').unwrap_or(line), row, TABLE)?;
        let n = f64::NAN;
        let found = match values[..] {
            [m, h, v, p, t, re, s, c, b, x, z] => [m, h, v, p, t, re, s, c, b, x, z],
            [m, re, s, c, b, x, z] => [m, n, n, n, n, re, s, c, b, x, z],
            _ => {
                let reason = format!("{} values where 11 (or 7 without an atmosphere) are printed", values.len());
                return Err(ListingError::Row { line: row + 1, table: TABLE, reason });
            }
        };
        let conditions = DatcomConditions {
            mach: found[0],
            altitude_m: found[1] * length,
            airspeed_m_s: found[2] * length,
            pressure_pa: found[3] * pressure,
            temperature_k: found[4] * temperature,
            reynolds_per_m: found[5] / length,
            area_m2: found[6] * length * length,
            chord_m: found[7] * length,
            span_m: found[8] * length,
            reference_x_m: found[9] * length,
            reference_z_m: found[10] * length,
        };
        self.page(row, conditions);
        Ok(())
    }

    /// Holds the flight condition of a page against that of the first.
    fn page(&mut self, row: usize, conditions: DatcomConditions) {
        let Some(first) = self.conditions else {
            self.conditions = Some(conditions);
            return;
        };
        let differs = |a: f64, b: f64| (a - b).abs() > HEADER_TOLERANCE * a.abs().max(b.abs());
        self.foreign = differs(first.mach, conditions.mach) || differs(first.altitude_m, conditions.altitude_m);
        if self.foreign {
            self.warnings.push(format!(
                "line {}: page at Mach {} and {} m left out, the first is at Mach {} and {} m",
                row + 1,
                conditions.mach,
                conditions.altitude_m,
                first.mach,
                first.altitude_m
            ));
        } else if differs(first.pressure_pa, conditions.pressure_pa)
            || differs(first.temperature_k, conditions.temperature_k)
        {
            self.warnings.push(format!(
                "line {}: pressure {} Pa and temperature {} K disagree with the first page ({} Pa, {} K), which is used",
                row + 1,
                conditions.pressure_pa,
                conditions.temperature_k,
                first.pressure_pa,
                first.temperature_k
            ));
        }
    }

    /// Reads vehicle weight or level-flight lift coefficient.
    fn weight(&mut self, index: usize, line: &str) -> Result<(), ListingError> {
        const TABLE: &str = "vehicle weight";
        let text = line.split_once('=').map_or("", |(_, text)| text).trim();
        let (number, unit) = text.split_once(char::is_whitespace).unwrap_or((text, ""));
        let refuse = |reason: &str| ListingError::Row { line: index + 1, table: TABLE, reason: reason.to_owned() };
        let value = *numbers(number, index, TABLE)?.first().ok_or_else(|| refuse("no value after '='"))?;
        if line.contains("VEHICLE WEIGHT") {
            let newtons = if unit.trim().starts_with('N') { 1.0 } else { N_PER_LB };
            self.weight_n.get_or_insert(value * newtons);
            return Ok(());
        }
        let (Some(c), Some(weight_n), None) = (self.conditions, self.weight_n, self.level_flight_cl) else {
            return Ok(());
        };
        let density = c.pressure_pa / (GAS_CONSTANT_AIR_J_KG_K * c.temperature_k);
        let cl = weight_n / (0.5 * density * c.airspeed_m_s.powi(2) * c.area_m2);
        if cl.is_finite() {
            self.level_flight_cl = Some(cl);
            if (value - cl).abs() > LEVEL_FLIGHT_TOLERANCE * cl {
                self.warnings.push(format!(
                    "line {}: level-flight lift coefficient {value} is {:.3} times the {cl:.4} its weight and air give, which is used",
                    index + 1,
                    value / cl
                ));
            }
        }
        Ok(())
    }

    /// Factor of a table's derivatives to 1/rad.
    fn derivative_factor(&self, index: usize, table: &'static str) -> Result<f64, ListingError> {
        self.per_rad.ok_or(ListingError::AngleUnit { line: index + 1, table })
    }

    fn static_table(&mut self, index: usize, columns: Vec<Vec<f64>>) -> Result<(), ListingError> {
        let factor = self.derivative_factor(index, "static characteristics")?;
        let mut columns = columns.into_iter();
        let mut next = || columns.next().unwrap_or_default();
        let alpha = next();
        if self.alpha_rad.is_empty() {
            if alpha.windows(2).any(|pair| pair[0] >= pair[1]) {
                let reason = "angles of attack do not increase".to_owned();
                return Err(ListingError::Row { line: index + 1, table: "static characteristics", reason });
            }
            self.alpha_rad = radians(&alpha);
        }
        let (cd, cl, cm, cn, ca, _) = (next(), next(), next(), next(), next(), next());
        let mut slope = || next().into_iter().map(|v| v * factor).collect::<Vec<f64>>();
        let table = StaticTable {
            cd,
            cl,
            cm,
            cn,
            ca,
            cl_alpha: slope(),
            cm_alpha: slope(),
            cy_beta: spread(slope()),
            cn_beta: spread(slope()),
            cl_beta: slope(),
        };
        self.check_alpha(index, &alpha)?;
        keep_first(&mut self.statics, table, "static characteristics", index, &mut self.warnings);
        Ok(())
    }

    fn dynamic_table(&mut self, index: usize, columns: Vec<Vec<f64>>) -> Result<(), ListingError> {
        let factor = self.derivative_factor(index, "dynamic derivatives")?;
        let mut columns = columns.into_iter();
        self.check_alpha(index, &columns.next().unwrap_or_default())?;
        let mut next = || -> Vec<f64> { columns.next().unwrap_or_default().into_iter().map(|v| v * factor).collect() };
        let table = DynamicTable {
            cl_q: spread(next()),
            cm_q: spread(next()),
            cl_alpha_dot: next(),
            cm_alpha_dot: next(),
            cl_p: next(),
            cy_p: next(),
            cn_p: next(),
            cn_r: next(),
            cl_r: next(),
        };
        keep_first(&mut self.dynamic, table, "dynamic derivatives", index, &mut self.warnings);
        Ok(())
    }

    fn elevator_table(&mut self, index: usize, columns: Vec<Vec<f64>>) {
        let mut columns = columns.into_iter();
        let mut next = || columns.next().unwrap_or_default();
        let (deflection_rad, cl, cm) = (radians(&next()), next(), next());
        let cd_min = columns.nth(1).unwrap_or_default();
        if self.tail_control {
            let table = ElevatorTable { deflection_rad, cl, cm, cd_min, cd_induced: Vec::new() };
            match &self.elevator {
                Some(first) if first.cl == table.cl && first.cm == table.cm => {}
                Some(_) => self.warnings.push(repeated("elevator increments", index)),
                None => self.elevator = Some(table),
            }
        }
    }

    /// Checks that a table is against the angles of attack of the first, in deg as printed.
    fn check_alpha(&self, index: usize, alpha_deg: &[f64]) -> Result<(), ListingError> {
        if radians(alpha_deg) == self.alpha_rad {
            return Ok(());
        }
        let reason = format!(
            "{} angles of attack that are not the {} of the static characteristics before it",
            alpha_deg.len(),
            self.alpha_rad.len()
        );
        Err(ListingError::Row { line: index + 1, table: "table below this heading", reason })
    }

    fn finish(self, lines: usize) -> Result<DatcomListing, ListingError> {
        let (Some(conditions), Some(statics)) = (self.conditions, self.statics) else {
            let table = if self.conditions.is_none() { "flight conditions" } else { "static characteristics" };
            return Err(ListingError::Missing { table });
        };
        if !self.complete {
            return Err(ListingError::Truncated { line: lines });
        }
        Ok(DatcomListing {
            title: self.title,
            conditions,
            alpha_rad: self.alpha_rad,
            statics,
            downwash: self.downwash,
            dynamic: self.dynamic,
            elevator: self.elevator,
            aileron: self.aileron,
            level_flight_cl: self.level_flight_cl,
            warnings: self.warnings,
        })
    }
}

/// Keeps `table` where none was read before, and says so where a later one differs.
fn keep_first<T: PartialEq + std::fmt::Debug>(
    slot: &mut Option<T>,
    table: T,
    name: &str,
    index: usize,
    warnings: &mut Vec<String>,
) {
    match slot {
        None => *slot = Some(table),
        // Debug text is equal for equal numbers and for values that are not numbers.
        Some(first) if format!("{first:?}") == format!("{table:?}") => {}
        Some(_) => warnings.push(repeated(name, index)),
    }
}

/// Warning about a table that repeats with other values.
fn repeated(name: &str, index: usize) -> String {
    format!("line {}: {name} differ from the table before, which is used", index + 1)
}

/// A column printed once for all angles of attack, spread over all of them.
fn spread(mut column: Vec<f64>) -> Vec<f64> {
    if let Some((&first, rest)) = column.split_first()
        && rest.iter().all(|v| v.is_nan())
    {
        column.fill(first);
    }
    column
}

fn radians(degrees: &[f64]) -> Vec<f64> {
    degrees.iter().map(|v| v.to_radians()).collect()
}
