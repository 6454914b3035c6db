//! Gravity on and above the reference ellipsoid.

use std::f64::consts::FRAC_PI_2;

use thiserror::Error;

/// Standard acceleration of gravity, m/s² (3rd CGPM, 1901; ISO 2533).
pub const STANDARD_GRAVITY_M_S2: f64 = 9.806_65;

/// Semi-major axis of the WGS 84 ellipsoid, m.
const SEMI_MAJOR_AXIS_M: f64 = 6_378_137.0;
/// Flattening of the WGS 84 ellipsoid.
const FLATTENING: f64 = 1.0 / 298.257_223_563;
/// First eccentricity squared of the WGS 84 ellipsoid.
const ECCENTRICITY_SQUARED: f64 = FLATTENING * (2.0 - FLATTENING);
/// Normal gravity at the equator, m/s².
const EQUATOR_GRAVITY_M_S2: f64 = 9.780_325_335_9;
/// Somigliana's constant `(b gamma_pole) / (a gamma_equator) - 1`.
const SOMIGLIANA: f64 = 0.001_931_852_652_41;
/// Centrifugal to gravitational acceleration at the equator, `omega^2 a^2 b / GM`.
const CENTRIFUGAL_RATIO: f64 = 0.003_449_786_506_84;

/// Highest altitude at which the second-order free-air expansion is used, m; its error there is below 1e-5 m/s².
const HIGHEST_M: f64 = 30_000.0;
/// Lowest altitude accepted, m.
const LOWEST_M: f64 = -1_000.0;

/// Latitude or altitude outside the range of the gravity formula.
#[derive(Clone, Copy, Debug, PartialEq, Error)]
#[expect(missing_docs, reason = "the messages say what the fields are")]
pub enum GravityError {
    /// Latitude beyond a pole, or not a number.
    #[error("latitude is {latitude_rad} rad, allowed is -pi/2 to pi/2")]
    Latitude { latitude_rad: f64 },
    /// Altitude outside the range of the free-air expansion, or not a number.
    #[error("altitude is {altitude_m} m, allowed is {LOWEST_M} to {HIGHEST_M} m")]
    Altitude { altitude_m: f64 },
}

/// Normal gravity at a geodetic latitude and a height above the ellipsoid, m/s²: the default of a flight's gravity.
///
/// `gamma0 = gamma_e (1 + k sin^2 phi) / sqrt(1 - e^2 sin^2 phi)` (Somigliana), then the second-order free-air change
/// `gamma = gamma0 (1 - 2 (1 + f + m - 2 f sin^2 phi) h / a + 3 h^2 / a^2)`.
///
/// Latitude in rad, height in m from -1000 to 30000. Local anomalies (to about 1e-3 m/s²) are not in it. Source: NIMA
/// TR8350.2, World Geodetic System 1984, 3rd ed., equations 4-1 and 4-3.
///
/// # Errors
/// [`GravityError`] outside these ranges.
pub fn gravity_m_s2(latitude_rad: f64, altitude_m: f64) -> Result<f64, GravityError> {
    if !(-FRAC_PI_2..=FRAC_PI_2).contains(&latitude_rad) {
        return Err(GravityError::Latitude { latitude_rad });
    }
    if !(LOWEST_M..=HIGHEST_M).contains(&altitude_m) {
        return Err(GravityError::Altitude { altitude_m });
    }
    let s2 = latitude_rad.sin().powi(2);
    let surface = EQUATOR_GRAVITY_M_S2 * (1.0 + SOMIGLIANA * s2) / (1.0 - ECCENTRICITY_SQUARED * s2).sqrt();
    let h = altitude_m / SEMI_MAJOR_AXIS_M;
    Ok(surface * (1.0 - 2.0 * (1.0 + FLATTENING + CENTRIFUGAL_RATIO - 2.0 * FLATTENING * s2) * h + 3.0 * h * h))
}

#[cfg(test)]
mod tests {
    use super::*;
    use approx::assert_abs_diff_eq;

    /// Printed digits of the published values, m/s².
    const PUBLISHED: f64 = 1e-9;
    /// Half a unit of the last printed digit of the free-air gradient, 1/s².
    const GRADIENT: f64 = 5e-10;

    #[test]
    fn gravity_at_pole_and_equator_matches_wgs84() {
        assert_abs_diff_eq!(gravity_m_s2(0.0, 0.0).unwrap(), 9.780_325_335_9, epsilon = PUBLISHED);
        assert_abs_diff_eq!(gravity_m_s2(FRAC_PI_2, 0.0).unwrap(), 9.832_184_937_8, epsilon = PUBLISHED);
    }

    #[test]
    fn gravity_falls_with_height_by_the_free_air_gradient() {
        let latitude = 45.0_f64.to_radians();
        let gradient = (gravity_m_s2(latitude, 100.0).unwrap() - gravity_m_s2(latitude, -100.0).unwrap()) / 200.0;
        // The conventional normal free-air gradient, -0.3086 mGal/m.
        assert_abs_diff_eq!(gradient, -3.086e-6, epsilon = GRADIENT);
    }

    #[test]
    fn gravity_rejects_positions_off_the_earth() {
        assert!(gravity_m_s2(1.6, 0.0).is_err());
        assert!(gravity_m_s2(f64::NAN, 0.0).is_err());
        assert!(gravity_m_s2(0.9, 4.0e5).is_err());
        assert!(gravity_m_s2(0.9, f64::NAN).is_err());
    }
}
