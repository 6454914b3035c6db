//! Deflections from the turns of yoke and pulleys (thesis section 4.1.3). Signs: `docs/conventions.md`.

use crate::airframe::instruments::{ControlLinkage, PedalCurve};
use crate::message;
use crate::message::{Message, quoted};

/// How the column's travel follows from its string.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
pub enum ColumnFormula {
    /// The right triangle of string, offset and column.
    #[default]
    Exact,
    /// Thesis Eq. 4.5, which reads 1.1 to 2.0 % too little for travels up to 4 cm.
    Thesis,
}

/// How deflections are formed.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
pub struct DeflectionSettings {
    /// Formula of the column's travel.
    pub column: ColumnFormula,
    /// Adds the intercept of the elevator's fit, which the thesis leaves out.
    pub elevator_intercept: bool,
}

/// Forward travel of the column, m, for a string shortened by `displacement_m` from its neutral length `string_m`, with the
/// pulley `offset_m` beside the column's line.
///
/// `dl = sqrt(x0^2 - b^2) - sqrt((x0 - dx)^2 - b^2)`; thesis Eq. 4.5 `dl = dx sqrt(1 - (b / (x0 - dx))^2)`, whose factor belongs
/// in the denominator. NaN where the string would be shorter than the offset.
pub fn column_travel(displacement_m: f64, string_m: f64, offset_m: f64, formula: ColumnFormula) -> f64 {
    let left = string_m - displacement_m;
    if left < offset_m {
        return f64::NAN;
    }
    match formula {
        ColumnFormula::Exact => {
            (string_m * string_m - offset_m * offset_m).sqrt() - (left * left - offset_m * offset_m).sqrt()
        }
        ColumnFormula::Thesis => displacement_m * (1.0 - (offset_m / left).powi(2)).sqrt(),
    }
}

/// Aileron deflection, rad, of a yoke turned counter-clockwise by `yoke_rad` (thesis Table 4.2).
pub fn aileron_deflection(linkage: &ControlLinkage, yoke_rad: f64) -> f64 {
    linkage.aileron_slope * yoke_rad + linkage.aileron_intercept_rad
}

/// Elevator deflection, rad, of a column drum turned by `drum_rad` from neutral, positive as the string winds up (thesis Eq.
/// 4.4-4.5, Table 4.3). NaN beyond the end of the string.
pub fn elevator_deflection(linkage: &ControlLinkage, drum_rad: f64, settings: DeflectionSettings) -> f64 {
    let displacement = drum_rad * linkage.drum_radius_m;
    let travel = column_travel(displacement, linkage.string_m, linkage.offset_m, settings.column);
    let intercept = if settings.elevator_intercept { linkage.elevator_intercept_rad } else { 0.0 };
    linkage.elevator_slope_rad_m * travel + intercept
}

/// Rudder deflection, rad, of a pedal drum turned by `drum_rad` from neutral, and whether its string was held at the end of
/// its curve's range (thesis Table 4.4). Outboard (negative) deflections are scaled to inboard ones by the ratio of the stops.
pub fn rudder_deflection(linkage: &ControlLinkage, pedal: &PedalCurve, drum_rad: f64) -> (f64, bool) {
    let displacement = drum_rad * linkage.drum_radius_m;
    let [low, high] = pedal.range_m;
    let held = displacement.clamp(low, high);
    let deflection = polynomial(&pedal.coefficients, held);
    let scaled = if deflection < 0.0 { linkage.outboard_ratio * deflection } else { deflection };
    (scaled, held != displacement)
}

/// Rudder deflections of a history of drum turns, rad, and a warning where the curve's range was left.
pub fn rudder_history(linkage: &ControlLinkage, pedal: &PedalCurve, drum_rad: &[f64]) -> (Vec<f64>, Option<Message>) {
    let readings = drum_rad.iter().map(|&turn| rudder_deflection(linkage, pedal, turn));
    let (values, held): (Vec<f64>, Vec<bool>) = readings.unzip();
    let count = held.iter().filter(|&&held| held).count();
    let [low, high] = pedal.range_m;
    let warning = (count > 0).then(|| {
        message!(
            "sensor {}: {} of {} samples beyond the calibrated string displacement of {} to {} m, held at its end",
            quoted(&pedal.sensor),
            count,
            values.len(),
            low,
            high
        )
    });
    (values, warning)
}

/// Standard deviation of a deflection from that of the turn it follows from, `|d deflection / d turn| turn_noise` (thesis Eq.
/// 4.6), by a central difference of `deflection` over one standard deviation either way.
pub fn deflection_noise(deflection: impl Fn(f64) -> f64, turn_rad: f64, turn_noise_rad: f64) -> f64 {
    0.5 * (deflection(turn_rad + turn_noise_rad) - deflection(turn_rad - turn_noise_rad)).abs()
}

/// Value of a polynomial, lowest power first.
pub(super) fn polynomial(coefficients: &[f64], x: f64) -> f64 {
    coefficients.iter().rev().fold(0.0, |sum, a| sum * x + a)
}
