//! Sensors away from the centre of gravity: accelerometers, vanes and nose booms, there and back.

/// Specific force at a point of the aircraft from that at its centre of gravity, m/s².
///
/// `a_point = a_cg + w' x r + w x (w x r)` with `w = (p, q, r)`, all in body axes, and the position `r` of the point from the
/// centre of gravity in m. Rates in rad/s, angular accelerations in rad/s².
pub fn accelerometer_at(position_m: [f64; 3], cg_m_s2: [f64; 3], rates: [f64; 3], angular: [f64; 3]) -> [f64; 3] {
    let arm = arm_acceleration(position_m, rates, angular);
    std::array::from_fn(|axis| cg_m_s2[axis] + arm[axis])
}

/// Specific force at the centre of gravity from that measured by an accelerometer at `position_m` from it (thesis
/// Eq. 4.10, with the position of the sensor instead of its negative); the inverse of [`accelerometer_at`].
pub fn acceleration_at_cg(
    position_m: [f64; 3],
    measured_m_s2: [f64; 3],
    rates: [f64; 3],
    angular: [f64; 3],
) -> [f64; 3] {
    let arm = arm_acceleration(position_m, rates, angular);
    std::array::from_fn(|axis| measured_m_s2[axis] - arm[axis])
}

/// Acceleration of a point relative to the centre of gravity of a rigid body, m/s².
fn arm_acceleration([x, y, z]: [f64; 3], [p, q, r]: [f64; 3], [p_dot, q_dot, r_dot]: [f64; 3]) -> [f64; 3] {
    [
        -(q * q + r * r) * x + (p * q - r_dot) * y + (p * r + q_dot) * z,
        (p * q + r_dot) * x - (p * p + r * r) * y + (q * r - p_dot) * z,
        (p * r - q_dot) * x + (q * r + p_dot) * y - (p * p + q * q) * z,
    ]
}

/// Flow-angle vanes on a boom: position, and what the flow about the aircraft does to the angles.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FlowVane {
    /// Position from the centre of gravity in body axes, m.
    pub position_m: [f64; 3],
    /// Upwash: the angle-of-attack vane shows `1 + upwash` times the local angle.
    pub upwash: f64,
    /// Sidewash: the sideslip vane shows `1 + sidewash` times the local angle.
    pub sidewash: f64,
    /// Offset of the angle-of-attack vane, rad.
    pub alpha_offset_rad: f64,
    /// Offset of the sideslip vane, rad.
    pub beta_offset_rad: f64,
}

impl FlowVane {
    /// A vane at `position_m` in undisturbed flow.
    pub fn at(position_m: [f64; 3]) -> Self {
        Self { position_m, upwash: 0.0, sidewash: 0.0, alpha_offset_rad: 0.0, beta_offset_rad: 0.0 }
    }

    /// Velocity of the vane relative to the centre of gravity, `w x r`, m/s.
    fn velocity(&self, [p, q, r]: [f64; 3]) -> [f64; 3] {
        let [x, y, z] = self.position_m;
        [q * z - r * y, r * x - p * z, p * y - q * x]
    }
}

/// Airspeed at the boom, and angles `(alpha, beta)` its vanes show, from airspeed and angles at the centre of gravity.
///
/// Local velocity `v_vane = v_cg + w x r`; `alpha = (1 + upwash) atan2(w, u) + offset`,
/// `beta = (1 + sidewash) atan2(v, sqrt(u^2 + w^2)) + offset` of the local components. Rates in rad/s.
pub fn flow_angles_at_vanes(
    vane: &FlowVane,
    airspeed_m_s: f64,
    alpha_rad: f64,
    beta_rad: f64,
    rates: [f64; 3],
) -> (f64, f64, f64) {
    let arm = vane.velocity(rates);
    let centre = velocity(airspeed_m_s, alpha_rad, beta_rad);
    let (speed, alpha, beta) = flow(std::array::from_fn(|axis| centre[axis] + arm[axis]));
    (speed, (1.0 + vane.upwash) * alpha + vane.alpha_offset_rad, (1.0 + vane.sidewash) * beta + vane.beta_offset_rad)
}

/// Airspeed and flow angles `(V, alpha, beta)` at the centre of gravity from those at the boom; the inverse of
/// [`flow_angles_at_vanes`].
pub fn flow_angles_at_cg(
    vane: &FlowVane,
    airspeed_m_s: f64,
    alpha_rad: f64,
    beta_rad: f64,
    rates: [f64; 3],
) -> (f64, f64, f64) {
    let alpha = (alpha_rad - vane.alpha_offset_rad) / (1.0 + vane.upwash);
    let beta = (beta_rad - vane.beta_offset_rad) / (1.0 + vane.sidewash);
    let local = velocity(airspeed_m_s, alpha, beta);
    let arm = vane.velocity(rates);
    flow(std::array::from_fn(|axis| local[axis] - arm[axis]))
}

/// Velocity components in body axes (thesis Eq. 4.9).
fn velocity(airspeed: f64, alpha: f64, beta: f64) -> [f64; 3] {
    [airspeed * alpha.cos() * beta.cos(), airspeed * beta.sin(), airspeed * alpha.sin() * beta.cos()]
}

/// Airspeed, angle of attack and sideslip of velocity components (thesis Eq. 3.8).
fn flow([u, v, w]: [f64; 3]) -> (f64, f64, f64) {
    ((u * u + v * v + w * w).sqrt(), w.atan2(u), v.atan2(u.hypot(w)))
}

#[cfg(test)]
mod tests {
    use super::*;

    const RATES: [f64; 3] = [0.4, -0.2, 0.1];
    const ANGULAR: [f64; 3] = [0.9, 0.5, -0.3];

    #[test]
    fn lever_arm_matches_cross_products() {
        let position = nalgebra::Vector3::new(-1.01, 0.886, 0.103);
        let (rates, angular) = (nalgebra::Vector3::from(RATES), nalgebra::Vector3::from(ANGULAR));
        let expected = angular.cross(&position) + rates.cross(&rates.cross(&position));
        let found = accelerometer_at(position.into(), [0.0; 3], RATES, ANGULAR);
        for axis in 0..3 {
            approx::assert_relative_eq!(found[axis], expected[axis], epsilon = 1e-15);
        }
    }

    #[test]
    fn accelerometer_position_there_and_back_roundtrips() {
        let position = [1.2, -0.4, 0.3];
        let measured = accelerometer_at(position, [0.3, -0.2, -9.7], RATES, ANGULAR);
        let back = acceleration_at_cg(position, measured, RATES, ANGULAR);
        for (found, expected) in back.into_iter().zip([0.3, -0.2, -9.7]) {
            approx::assert_relative_eq!(found, expected, epsilon = 1e-14);
        }
    }

    #[test]
    fn pitching_nose_boom_shows_less_incidence_and_there_and_back_roundtrips() {
        let vane = FlowVane {
            upwash: 0.08,
            sidewash: -0.05,
            alpha_offset_rad: 0.01,
            beta_offset_rad: -0.02,
            ..FlowVane::at([13.08, -0.01, -0.027])
        };
        let clean = FlowVane::at([10.0, 0.0, 0.0]);
        let (_, alpha, _) = flow_angles_at_vanes(&clean, 100.0, 0.05, 0.0, [0.0, 0.1, 0.0]);
        // atan((w - q x) / u) with w = 100 sin(0.05), q x = 1 m/s
        approx::assert_relative_eq!(
            alpha,
            ((100.0 * 0.05_f64.sin() - 1.0) / (100.0 * 0.05_f64.cos())).atan(),
            epsilon = 1e-15
        );
        let (speed, alpha, beta) = flow_angles_at_vanes(&vane, 90.0, 0.1, -0.06, RATES);
        let (speed, alpha, beta) = flow_angles_at_cg(&vane, speed, alpha, beta, RATES);
        approx::assert_relative_eq!(speed, 90.0, epsilon = 1e-12);
        approx::assert_relative_eq!(alpha, 0.1, epsilon = 1e-14);
        approx::assert_relative_eq!(beta, -0.06, epsilon = 1e-14);
    }
}
