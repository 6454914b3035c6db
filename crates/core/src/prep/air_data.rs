//! Angle of attack and sideslip of the air-data pod (thesis section 4.3).

use super::PrepError;
use super::control_surfaces::polynomial;
use crate::load::instruments::{LiftCurve, PodCalibration};

/// Lowest and highest number the pod shows; at either it may mean anything beyond.
const POD_NUMBERS: [f64; 2] = [0.0, 100.0];
/// Steps in which a calibration is looked over.
const LOOK: usize = 400;

/// Angle of attack, rad, for a number of the pod: `exp(sum_k a_k number^k)` (thesis Table 4.11).
pub fn pod_angle_of_attack(calibration: &PodCalibration, number: f64) -> f64 {
    polynomial(&calibration.exponent, number).exp()
}

/// Numbers from and to which the calibration rises all the way, the stretch that ends at the stall; beyond it one angle has
/// two numbers.
pub fn pod_working_range(calibration: &PodCalibration) -> [f64; 2] {
    let [low, high] = POD_NUMBERS;
    let number = |k: usize| low + (high - low) * k as f64 / LOOK as f64;
    let exponent = |k: usize| polynomial(&calibration.exponent, number(k));
    let turn = (1..=LOOK).rev().find(|&k| exponent(k) <= exponent(k - 1));
    [turn.map_or(low, number), high]
}

/// Angles of attack of a pod's history.
#[derive(Clone, Debug, PartialEq)]
pub struct PodHistory {
    /// Angle of attack, rad; NaN where the number is at an end of its scale and shows nothing.
    pub alpha_rad: Vec<f64>,
    /// What was outside the working range, one line each.
    pub warnings: Vec<String>,
}

/// Angle of attack of each number the pod recorded, without those that stand at an end of the scale.
pub fn pod_history(calibration: &PodCalibration, numbers: &[f64]) -> PodHistory {
    let [low, high] = POD_NUMBERS;
    let [rising, _] = pod_working_range(calibration);
    let inside = |number: f64| number > low && number < high;
    let alpha_rad = numbers
        .iter()
        .map(|&number| if inside(number) { pod_angle_of_attack(calibration, number) } else { f64::NAN })
        .collect();
    let count = |holds: &dyn Fn(f64) -> bool| numbers.iter().filter(|&&number| holds(number)).count();
    let of = numbers.len();
    let findings = [
        (
            count(&|n| n <= low),
            format!("at 0, faster than the pod can tell (alpha below {:.1} deg)", degrees(calibration, low)),
        ),
        (
            count(&|n| n >= high),
            format!("at 100, beyond the stall (alpha above {:.1} deg)", degrees(calibration, high)),
        ),
        (
            count(&|n| inside(n) && n < rising),
            format!("below {rising:.0}, where calibration {} does not rise", calibration.flight),
        ),
    ];
    let warnings = findings
        .into_iter()
        .filter(|(count, _)| *count > 0)
        .map(|(count, what)| format!("pod: {count} of {of} angle-of-attack numbers {what}"))
        .collect();
    PodHistory { alpha_rad, warnings }
}

fn degrees(calibration: &PodCalibration, number: f64) -> f64 {
    pod_angle_of_attack(calibration, number).to_degrees()
}

/// Angle of attack, rad, in steady level flight from the lift equation (thesis section 4.3.2):
/// `alpha = (2 m g / (rho V^2 S) - CL0) / CL_alpha`.
///
/// True airspeed in m/s, density in kg/m³, area in m²; thrust carries no weight in it.
pub fn level_flight_angle_of_attack(
    curve: &LiftCurve,
    mass_kg: f64,
    gravity_m_s2: f64,
    airspeed_m_s: f64,
    density_kg_m3: f64,
    area_m2: f64,
) -> f64 {
    let lift = 2.0 * mass_kg * gravity_m_s2 / (density_kg_m3 * airspeed_m_s * airspeed_m_s * area_m2);
    (lift - curve.at_zero_alpha) / curve.slope_per_rad
}

/// Calibration through the points of a calibration flight: number and angle of attack (rad) of each, two or more, as the
/// zero, the calibration point and the stall (thesis section 4.3.2). Its exponent is the polynomial of lowest degree through
/// the logarithms; the thesis's sixth degree through three points is one of many.
///
/// # Errors
/// [`PrepError::TooFewSamples`] for fewer than two points, [`PrepError::Setting`] for an angle that is not above zero, numbers that repeat
/// or a calibration that does not rise over all numbers.
pub fn pod_calibration(flight: &str, points: &[(f64, f64)]) -> Result<PodCalibration, PrepError> {
    if points.len() < 2 {
        let method = "a calibration of the pod";
        return Err(PrepError::TooFewSamples { method, needed: 2, found: points.len() });
    }
    if let Some(&(_, value)) = points.iter().find(|(_, alpha)| !(*alpha > 0.0 && alpha.is_finite())) {
        return Err(PrepError::Setting { setting: "calibration angle of attack", value, allowed: "above zero, rad" });
    }
    // Newton's divided differences, expanded into powers.
    let mut differences: Vec<f64> = points.iter().map(|(_, alpha)| alpha.ln()).collect();
    for order in 1..points.len() {
        for k in (order..points.len()).rev() {
            differences[k] = (differences[k] - differences[k - 1]) / (points[k].0 - points[k - order].0);
        }
    }
    let mut exponent = vec![0.0; points.len()];
    for k in (0..points.len()).rev() {
        for power in (1..points.len()).rev() {
            exponent[power] = exponent[power - 1] - points[k].0 * exponent[power];
        }
        exponent[0] = differences[k] - points[k].0 * exponent[0];
    }
    let calibration = PodCalibration { flight: flight.to_owned(), exponent };
    let rises_from = pod_working_range(&calibration)[0];
    if rises_from > POD_NUMBERS[0] || calibration.exponent.iter().any(|a| !a.is_finite()) {
        let setting = "number from which the calibration rises";
        return Err(PrepError::Setting { setting, value: rises_from, allowed: "0: give points with rising angles" });
    }
    Ok(calibration)
}

/// Sideslip without the pod's offset: `beta = measured - offset`, rad.
pub fn sideslip(measured_rad: f64, offset_rad: f64) -> f64 {
    measured_rad - offset_rad
}
