//! Angle of attack and sideslip of the air-data pod (thesis section 4.3).

use super::PrepError;
use super::control_surfaces::polynomial;
use crate::airframe::instruments::{LiftCurve, PodCalibration};
use crate::message;
use crate::message::Message;

/// Lowest and highest number the pod shows; at either it may mean anything beyond.
const POD_NUMBERS: [f64; 2] = [0.0, 100.0];
/// Steps in which a calibration is looked over.
const LOOK: usize = 400;

/// Angle of attack, rad, for a number of the pod: `exp(sum_k a_k number^k)` (thesis Table 4.11).
pub fn pod_angle_of_attack(calibration: &PodCalibration, number: f64) -> f64 {
    polynomial(&calibration.exponent, number).exp()
}

/// The pod's own definition of its number (thesis Eq. 4.8): the total pressure of its probes over the square of the airspeed,
/// between those of its low and high probe at the calibration point.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PodDefinition {
    /// Number at the calibration point: 85, or 0.85 for pods that count to one.
    pub at_calibration: f64,
    /// Pressure over the square of the airspeed at the low probe, Pa s²/m².
    pub low: f64,
    /// The same at the high probe.
    pub high: f64,
}

impl PodDefinition {
    /// Number the pod shows: `c (p_t / V^2 - CP_low) / (CP_high - CP_low)`, pressure in Pa, airspeed in m/s. The thesis prints the
    /// two brackets as a product, by which the number would not be `c` at the calibration point.
    ///
    /// # Errors
    /// [`PrepError::Setting`] for an airspeed that is not above zero or probes that are not apart.
    pub fn number(&self, total_pressure_pa: f64, airspeed_m_s: f64) -> Result<f64, PrepError> {
        if !(airspeed_m_s > 0.0 && airspeed_m_s.is_finite()) {
            return Err(PrepError::Setting { setting: "airspeed_m_s", value: airspeed_m_s, allowed: "above zero" });
        }
        let apart = self.high - self.low;
        if !(apart.is_finite() && apart != 0.0) {
            return Err(PrepError::Setting { setting: "high - low", value: apart, allowed: "not zero" });
        }
        Ok(self.at_calibration * (total_pressure_pa / (airspeed_m_s * airspeed_m_s) - self.low) / apart)
    }
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
    pub warnings: Vec<Message>,
}

/// Angle of attack of each number the pod recorded, without those within `margin` of an end of the scale: about three
/// standard deviations of the number's noise, which otherwise lifts a pod that shows nothing off its stop.
pub fn pod_history(calibration: &PodCalibration, numbers: &[f64], margin: f64) -> PodHistory {
    let [low, high] = [POD_NUMBERS[0] + margin, POD_NUMBERS[1] - margin];
    let [rising, _] = pod_working_range(calibration);
    let inside = |number: f64| number > low && number < high;
    let alpha_rad = numbers
        .iter()
        .map(|&number| if inside(number) { pod_angle_of_attack(calibration, number) } else { f64::NAN })
        .collect();
    let count = |holds: &dyn Fn(f64) -> bool| numbers.iter().filter(|&&number| holds(number)).count();
    let total = numbers.len();
    let findings = [
        (
            count(&|n| n <= low),
            message!(
                "at the lower end of its scale (alpha below {:.1} deg, above the speed range of the pod)",
                degrees(calibration, low)
            ),
        ),
        (
            count(&|n| n >= high),
            message!(
                "at the upper end of its scale (alpha above {:.1} deg, beyond the stall)",
                degrees(calibration, high)
            ),
        ),
        (
            count(&|n| inside(n) && n < rising),
            message!("below {:.0}, where calibration {} does not rise", rising, calibration.flight.as_str()),
        ),
    ];
    let warnings = findings
        .into_iter()
        .filter(|(count, _)| *count > 0)
        .map(|(count, what)| message!("pod: {} of {} angle-of-attack readings {}", count, total, what))
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

/// Numbers at equal pressures, at the calibration point and at the stall (thesis section 4.3.1).
const CALIBRATION_NUMBERS: [f64; 3] = [0.0, 85.0, 100.0];

/// Calibration from the angles of attack (rad) at the numbers 0, 85 and 100, as level flight at those airspeeds gives them
/// ([`level_flight_angle_of_attack`], thesis section 4.3.2).
///
/// Its exponent is `a0 + a1 n + am n^m` with the lowest power `m` for which neither factor is negative, so that it rises over the
/// whole scale. The thesis fits a full sixth degree to the same three points, one of many that pass through them, which for one
/// of its two flights does not rise.
///
/// # Errors
/// [`PrepError::Setting`] for angles that are not above zero or do not rise, or rise ever less towards the stall.
pub fn pod_calibration(flight: &str, alpha_rad: [f64; 3]) -> Result<PodCalibration, PrepError> {
    /// Highest power tried.
    const POWERS: i32 = 20;
    let setting = "calibration angle of attack";
    let refuse = |value, allowed| Err(PrepError::Setting { setting, value, allowed });
    if let Some(&value) = alpha_rad.iter().find(|alpha| !(**alpha > 0.0 && alpha.is_finite())) {
        return refuse(value, "above zero, rad");
    }
    let [_, middle, stall] = CALIBRATION_NUMBERS;
    let [first, second, third] = alpha_rad.map(f64::ln);
    let (to_middle, to_stall) = ((second - first) / middle, (third - first) / stall);
    for power in 2..=POWERS {
        let highest = (to_stall - to_middle) / (stall.powi(power - 1) - middle.powi(power - 1));
        let linear = to_middle - highest * middle.powi(power - 1);
        if highest >= 0.0 && linear >= 0.0 && to_stall > 0.0 {
            let mut exponent = vec![0.0; power as usize + 1];
            (exponent[0], exponent[1]) = (first, linear);
            exponent[power as usize] = highest;
            return Ok(PodCalibration { flight: flight.to_owned(), exponent });
        }
    }
    refuse(alpha_rad[2], "rising from 0 over 85 to 100, and ever faster")
}

/// Sideslip without the pod's offset: `beta = measured - offset`, rad.
pub fn sideslip(measured_rad: f64, offset_rad: f64) -> f64 {
    measured_rad - offset_rad
}
