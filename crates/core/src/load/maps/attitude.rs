//! Attitude as a quaternion.

use std::f64::consts::{PI, TAU};

/// Axes that a quaternion turns into each other.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum QuaternionAxes {
    /// Body forward, right, down into north, east, down.
    Ned,
    /// Body forward, left, up into east, north, up (REP 103 of ROS).
    Enu,
}

impl QuaternionAxes {
    crate::named_variants! {
        /// Name in files.
        pub name: Ned "ned", Enu "enu"
    }

    crate::variant_texts! {
        /// The axes in words.
        pub description:
            Ned "body forward, right, down into north, east, down",
            Enu "body forward, left, up into east, north, up",
    }

    /// Euler angles phi, theta, psi, rad, of a quaternion `w, x, y, z` from body to Earth axes; NaN of one without length.
    ///
    /// `phi = atan2(2 (w x + y z), 1 - 2 (x^2 + y^2))`, `theta = asin(2 (w y - z x))`, `psi = atan2(2 (w z + x y), 1 - 2 (y^2 + z^2))`
    /// (Stevens and Lewis, Aircraft Control and Simulation, section 1.8); with axes up, theta is turned and psi counts from north.
    pub fn euler_rad(self, quaternion: [f64; 4]) -> [f64; 3] {
        let norm = quaternion.iter().map(|part| part * part).sum::<f64>().sqrt();
        let [w, x, y, z] = quaternion.map(|part| part / norm);
        let phi = (2.0 * (w * x + y * z)).atan2(1.0 - 2.0 * (x * x + y * y));
        let theta = (2.0 * (w * y - z * x)).clamp(-1.0, 1.0).asin();
        let psi = (2.0 * (w * z + x * y)).atan2(1.0 - 2.0 * (y * y + z * z));
        match self {
            Self::Ned => [phi, theta, psi],
            Self::Enu => [phi, -theta, (std::f64::consts::FRAC_PI_2 - psi + PI).rem_euclid(TAU) - PI],
        }
    }
}

#[cfg(test)]
mod tests {
    use nalgebra::Vector3;

    use crate::load::QuaternionAxes;
    use crate::motion::State;

    #[test]
    fn attitude_of_a_quaternion_is_that_of_the_equations_of_motion() {
        for euler_rad in [[0.3, -0.2, 2.8], [-1.2, 0.7, -3.0], [0.0, 1.4, 0.1]] {
            let state = State::new(Vector3::zeros(), Vector3::zeros(), euler_rad);
            // Its length and its sign tell nothing.
            let found = QuaternionAxes::Ned.euler_rad(state.attitude.map(|part| -2.0 * part));
            let worst = found.iter().zip(euler_rad).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
            assert!(worst < 1e-12, "{found:?}");
        }
    }

    #[test]
    fn attitude_with_axes_up_is_turned() {
        let half = std::f64::consts::FRAC_1_SQRT_2;
        // No turn at all: forward is east.
        let [phi, theta, psi] = QuaternionAxes::Enu.euler_rad([1.0, 0.0, 0.0, 0.0]);
        assert!(phi == 0.0 && theta == 0.0 && (psi - std::f64::consts::FRAC_PI_2).abs() < 1e-15);
        // A quarter turn to the left about the axis up: forward is north.
        let [.., psi] = QuaternionAxes::Enu.euler_rad([half, 0.0, 0.0, half]);
        assert!(psi.abs() < 1e-15, "{psi}");
        // Nose up is a negative turn about the axis to the left.
        let [_, theta, _] = QuaternionAxes::Enu.euler_rad([0.2_f64.cos(), 0.0, -0.2_f64.sin(), 0.0]);
        assert!((theta - 0.4).abs() < 1e-15, "{theta}");
    }
}
