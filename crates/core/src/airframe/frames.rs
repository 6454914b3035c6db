//! Rotations and positions between the frames of `docs/conventions.md`, named so that they chain:
//! `v_body = body_from_ned * v_ned`.

use nalgebra::{Rotation3, Vector3};

/// Rotation that takes components in local Earth axes into body axes, `R_x(phi) R_y(theta) R_z(psi)`.
///
/// Angles in rad, applied in the order heading, pitch, bank. Its transpose is `ned_from_body`. Any angles are valid; at
/// theta = +-90 deg different (phi, psi) give one rotation. Source: Klein and Morelli, Aircraft System Identification,
/// 2nd ed., Eq. 3.18.
pub fn body_from_ned(phi_rad: f64, theta_rad: f64, psi_rad: f64) -> Rotation3<f64> {
    Rotation3::from_euler_angles(phi_rad, theta_rad, psi_rad).inverse()
}

/// Rotation that takes components in body axes into stability axes: `x_s = x cos(alpha) + z sin(alpha)`,
/// `z_s = -x sin(alpha) + z cos(alpha)`, for the angle of attack in rad. Its transpose is `body_from_stability`.
pub(crate) fn stability_from_body(alpha_rad: f64) -> Rotation3<f64> {
    Rotation3::from_axis_angle(&Vector3::y_axis(), alpha_rad)
}

/// Position in body axes, m, of a point given in datum axes (x aft, y right, z up), about a centre of gravity given
/// likewise: `x_b = -(x - x_cg)`, `y_b = y - y_cg`, `z_b = -(z - z_cg)` (thesis 2.3.2).
pub fn body_from_datum(point_from_datum_m: [f64; 3], cg_from_datum_m: [f64; 3]) -> [f64; 3] {
    let [x, y, z] = point_from_datum_m;
    let [x_cg, y_cg, z_cg] = cg_from_datum_m;
    [x_cg - x, y - y_cg, z_cg - z]
}

/// Position in datum axes, m, of a point given in body axes about a centre of gravity given in datum axes: the inverse
/// of [`body_from_datum`].
pub fn datum_from_body(point_body_m: [f64; 3], cg_from_datum_m: [f64; 3]) -> [f64; 3] {
    let [x, y, z] = point_body_m;
    let [x_cg, y_cg, z_cg] = cg_from_datum_m;
    [x_cg - x, y + y_cg, z_cg - z]
}

#[cfg(test)]
mod tests {
    use super::*;
    use approx::assert_abs_diff_eq;
    use proptest::prelude::*;
    use std::f64::consts::{FRAC_PI_2, PI};

    /// Round-off of a few products of numbers of order one.
    const ROUND_OFF: f64 = 1e-12;

    #[test]
    fn body_from_ned_puts_gravity_where_an_accelerometer_feels_it() {
        let down = Vector3::new(0.0, 0.0, 1.0);
        let nose_up = body_from_ned(0.0, 0.3, 1.0) * down;
        assert_abs_diff_eq!(nose_up, Vector3::new(-0.3_f64.sin(), 0.0, 0.3_f64.cos()), epsilon = ROUND_OFF);
        let right_wing_down = body_from_ned(0.3, 0.0, 1.0) * down;
        assert_abs_diff_eq!(right_wing_down, Vector3::new(0.0, 0.3_f64.sin(), 0.3_f64.cos()), epsilon = ROUND_OFF);
    }

    #[test]
    fn body_from_ned_heading_east_sees_east_ahead_and_north_on_the_left() {
        let rotation = body_from_ned(0.0, 0.0, FRAC_PI_2);
        assert_abs_diff_eq!(rotation * Vector3::y(), Vector3::x(), epsilon = ROUND_OFF);
        assert_abs_diff_eq!(rotation * Vector3::x(), -Vector3::y(), epsilon = ROUND_OFF);
    }

    #[test]
    fn stability_axes_lie_along_the_airspeed() {
        let alpha = 0.2_f64;
        let velocity_body = Vector3::new(alpha.cos(), 0.0, alpha.sin());
        assert_abs_diff_eq!(stability_from_body(alpha) * velocity_body, Vector3::x(), epsilon = ROUND_OFF);
    }

    #[test]
    fn a_point_ahead_right_and_above_is_positive_positive_negative_in_body_axes() {
        assert_eq!(body_from_datum([1.0, 0.5, 2.0], [3.5, 0.25, 1.5]), [2.5, 0.25, -0.5]);
    }

    proptest! {
        #[test]
        fn body_from_ned_is_orthonormal_and_gives_its_angles_back(
            phi in -PI..PI, theta in -1.55..1.55, psi in -PI..PI,
        ) {
            let rotation = body_from_ned(phi, theta, psi);
            let product = rotation.matrix() * rotation.matrix().transpose();
            prop_assert!((product - nalgebra::Matrix3::identity()).norm() < ROUND_OFF);
            let (back_phi, back_theta, back_psi) = rotation.inverse().euler_angles();
            // Near theta = 90 deg the angles are ill-conditioned: round-off divided by cos(theta) = 0.02.
            for (a, b) in [(back_phi, phi), (back_theta, theta), (back_psi, psi)] {
                prop_assert!((a - b).abs() < ROUND_OFF / 0.02, "{a} for {b}");
            }
        }

        #[test]
        fn datum_and_body_positions_roundtrip(point in [-9.0..9.0, -9.0..9.0, -9.0..9.0], cg in [-9.0..9.0, -9.0..9.0, -9.0..9.0]) {
            let back = datum_from_body(body_from_datum(point, cg), cg);
            for (a, b) in back.into_iter().zip(point) {
                prop_assert!((a - b).abs() < ROUND_OFF);
            }
        }
    }
}
