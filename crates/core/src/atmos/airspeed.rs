//! True airspeed of a calibrated or equivalent one or of a Mach number, static temperature of a total one.

use super::isa::{GAS_CONSTANT_AIR_J_KG_K, HEAT_CAPACITY_RATIO_AIR};

/// Sea-level speed of sound of the standard, m/s, and pressure, Pa: the reference of calibrated airspeed.
const SEA_LEVEL_SOUND_M_S: f64 = 340.294;
const SEA_LEVEL_PRESSURE_PA: f64 = 101_325.0;

/// Mach number of a calibrated airspeed at a static pressure in subsonic flow: `qc = p0 ((1 + M0^2 / 5)^3.5 - 1)`,
/// `M^2 = 5 ((qc / p + 1)^(2/7) - 1)`.
pub fn mach_of_calibrated(calibrated_m_s: f64, pressure_pa: f64) -> f64 {
    let sea_level = 1.0 + 0.2 * (calibrated_m_s / SEA_LEVEL_SOUND_M_S).powi(2);
    let impact_pa = SEA_LEVEL_PRESSURE_PA * (sea_level.powf(3.5) - 1.0);
    mach_of_impact(impact_pa, pressure_pa)
}

/// Mach number of an equivalent airspeed at a static pressure: `M = (V_e / a0) (p0 / p)^(1/2)`, as `rho0 V_e^2 = gamma p M^2`.
pub fn mach_of_equivalent(equivalent_m_s: f64, pressure_pa: f64) -> f64 {
    equivalent_m_s / SEA_LEVEL_SOUND_M_S * (SEA_LEVEL_PRESSURE_PA / pressure_pa).sqrt()
}

/// Mach number of an impact pressure at a static pressure in subsonic flow; not a number below zero.
fn mach_of_impact(impact_pa: f64, pressure_pa: f64) -> f64 {
    (5.0 * ((impact_pa / pressure_pa + 1.0).powf(2.0 / 7.0) - 1.0)).sqrt()
}

/// Calibrated airspeed of an impact pressure `qc` in subsonic flow, m/s: `V_c = a0 (5 ((qc / p0 + 1)^(2/7) - 1))^(1/2)`; not a number below
/// zero.
pub fn calibrated_of_impact_m_s(impact_pa: f64) -> f64 {
    SEA_LEVEL_SOUND_M_S * mach_of_impact(impact_pa, SEA_LEVEL_PRESSURE_PA)
}

/// True airspeed of a calibrated one at a static pressure and temperature, m/s; not a number where one of them is impossible.
pub fn true_of_calibrated_m_s(calibrated_m_s: f64, pressure_pa: f64, temperature_k: f64) -> f64 {
    true_of_mach_m_s(mach_of_calibrated(calibrated_m_s, pressure_pa), temperature_k)
}

/// True airspeed at a Mach number and a static temperature, m/s: `V = M (gamma R T)^(1/2)`.
pub fn true_of_mach_m_s(mach: f64, temperature_k: f64) -> f64 {
    mach * (HEAT_CAPACITY_RATIO_AIR * GAS_CONSTANT_AIR_J_KG_K * temperature_k).sqrt()
}

/// Static temperature of a total one at a Mach number, K, for a probe that recovers the whole rise: `T = T_t / (1 + M^2 / 5)`.
pub fn static_of_total_temperature_k(total_k: f64, mach: f64) -> f64 {
    total_k / (1.0 + 0.2 * mach * mach)
}

/// Static temperature of a total one at a true airspeed, K, for a probe that recovers the whole rise: `T = T_t - V^2 / (7 R)`.
pub fn static_at_airspeed_k(total_k: f64, airspeed_m_s: f64) -> f64 {
    total_k - airspeed_m_s * airspeed_m_s / (7.0 * GAS_CONSTANT_AIR_J_KG_K)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn calibrated_airspeed_gives_the_mach_number_of_the_tables() {
        // 250 kt calibrated at 10,000 ft of the standard atmosphere is Mach 0.4523 (standard conversion tables).
        let mach = mach_of_calibrated(250.0 * 0.514_444, 69_681.7);
        approx::assert_relative_eq!(mach, 0.4523, max_relative = 2e-3);
        // At sea level true and calibrated airspeed are one.
        approx::assert_relative_eq!(mach_of_calibrated(100.0, 101_325.0) * 340.294, 100.0, max_relative = 1e-9);
        // The impact pressure of 250 kt is 10,510 Pa (the same tables).
        approx::assert_relative_eq!(calibrated_of_impact_m_s(10_510.0) / 0.514_444, 250.0, max_relative = 2e-3);
        // On the ground the recorder's zero gives no speed.
        approx::assert_relative_eq!(true_of_calibrated_m_s(0.0, 101_325.0, 288.15), 0.0);
    }

    #[test]
    fn static_temperature_follows_from_the_total_one_by_mach_number_or_airspeed() {
        // NACA 1135: at Mach 0.80 T / T_t = 0.8865.
        let static_k = static_of_total_temperature_k(250.0, 0.80);
        approx::assert_relative_eq!(static_k / 250.0, 0.8865, max_relative = 1e-4);
        let airspeed_m_s = true_of_mach_m_s(0.80, static_k);
        approx::assert_relative_eq!(static_at_airspeed_k(250.0, airspeed_m_s), static_k, max_relative = 1e-12);
    }
}
