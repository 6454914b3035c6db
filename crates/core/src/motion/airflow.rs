//! Flow past the aircraft.

use nalgebra::Vector3;

/// Flow past the aircraft.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Airflow {
    /// Velocity relative to the air in body axes, m/s.
    pub velocity_body_m_s: Vector3<f64>,
    /// True airspeed, m/s.
    pub airspeed_m_s: f64,
    /// Angle of attack, rad.
    pub alpha_rad: f64,
    /// Sideslip, rad.
    pub beta_rad: f64,
    /// Dynamic pressure, Pa.
    pub dynamic_pressure_pa: f64,
}

impl Airflow {
    /// Flow of a velocity relative to the air (thesis Eq. 3.8); no flow angles below walking pace.
    pub fn new(velocity_body_m_s: Vector3<f64>, density_kg_m3: f64) -> Self {
        let [u, v, w] = [velocity_body_m_s.x, velocity_body_m_s.y, velocity_body_m_s.z];
        let square = u * u + v * v + w * w;
        let airspeed_m_s = square.sqrt();
        let flowing = u > 1.0;
        Self {
            velocity_body_m_s,
            airspeed_m_s,
            alpha_rad: if flowing { libm::atan2(w, u) } else { 0.0 },
            beta_rad: if flowing { libm::atan2(v, (u * u + w * w).sqrt()) } else { 0.0 },
            dynamic_pressure_pa: 0.5 * density_kg_m3 * square,
        }
    }
}
