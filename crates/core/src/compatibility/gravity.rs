//! A bias of the vertical accelerometer that is a wrong gravity.

use crate::atmos::gravity_m_s2;

/// Least difference of gravity that is worth a word, m/s²: five times the local anomalies the normal formula leaves out.
const WORTH_SAYING_M_S2: f64 = 0.005;
/// The gravity explains the bias when no more than this part of it is left.
const LEFT: f64 = 0.5;

/// A gravity that explains an estimated bias of az.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct GravityExplanation {
    /// Normal gravity at the latitude and altitude, m/s².
    pub gravity_m_s2: f64,
    /// Gravity used less that, m/s²; the bias of az that it makes.
    pub difference_m_s2: f64,
}

/// Whether the gravity a filter used explains the bias of az it found: in level flight az measures `-g`, so the bias (measured less
/// true) takes up `g_used - g`. `None` where gravity is right within 0.005 m/s², explains less than half of the bias, or latitude
/// (rad) and altitude (m) lie outside the range of [`gravity_m_s2`].
pub fn gravity_explains(
    bias_az_m_s2: f64,
    used_m_s2: f64,
    latitude_rad: f64,
    altitude_m: f64,
) -> Option<GravityExplanation> {
    let gravity_m_s2 = gravity_m_s2(latitude_rad, altitude_m).ok()?;
    let difference_m_s2 = used_m_s2 - gravity_m_s2;
    let explains = (bias_az_m_s2 - difference_m_s2).abs() < LEFT * bias_az_m_s2.abs();
    (difference_m_s2.abs() > WORTH_SAYING_M_S2 && explains)
        .then_some(GravityExplanation { gravity_m_s2, difference_m_s2 })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bias_of_a_wrong_gravity_is_told_from_one_of_the_sensor() {
        // 48 degrees north at 1000 m: 9.80588 m/s² by the formula itself.
        let place = (48.0_f64.to_radians(), 1000.0);
        let right = gravity_m_s2(place.0, place.1).unwrap();
        let found = gravity_explains(0.052, right + 0.05, place.0, place.1).unwrap();
        approx::assert_relative_eq!(found.difference_m_s2, 0.05, epsilon = 1e-12);
        assert_eq!(gravity_explains(-0.05, right + 0.05, place.0, place.1), None, "the wrong way");
        assert_eq!(gravity_explains(0.3, right + 0.05, place.0, place.1), None, "mostly the sensor's");
        assert_eq!(gravity_explains(0.003, right + 0.003, place.0, place.1), None, "too little");
    }
}
