//! Position from satellite velocity, and the place of the antenna.

use nalgebra::{Rotation3, Vector3};

use super::{PrepError, cumulative_trapezoid};

/// Position north and east of the first sample, m, from ground velocities in m/s by the trapezoidal rule (thesis section
/// 4.4.3); begin the slices where the manoeuvre begins.
///
/// # Errors
/// Lengths that differ, time that does not increase, no samples.
pub fn position_from_velocity(time_s: &[f64], north_m_s: &[f64], east_m_s: &[f64]) -> Result<[Vec<f64>; 2], PrepError> {
    Ok([cumulative_trapezoid(time_s, north_m_s)?, cumulative_trapezoid(time_s, east_m_s)?])
}

/// Position and ground velocity of the centre of gravity (m, m/s, north-east-down) from those of the antenna:
/// `r_cg = r - C l`, `v_cg = v - C (w x l)`.
///
/// `arm_m` is the place `l` of the antenna from the centre of gravity in body axes, `euler_rad` bank, pitch and heading,
/// `C` from body to north-east-down, `rates` the body rates `w` in rad/s.
pub fn satellite_fix_at_cg(
    arm_m: [f64; 3],
    euler_rad: [f64; 3],
    rates: [f64; 3],
    position_m: [f64; 3],
    velocity_m_s: [f64; 3],
) -> ([f64; 3], [f64; 3]) {
    let [phi, theta, psi] = euler_rad;
    let ned_from_body = Rotation3::from_euler_angles(phi, theta, psi);
    let arm = Vector3::from(arm_m);
    let position = Vector3::from(position_m) - ned_from_body * arm;
    let velocity = Vector3::from(velocity_m_s) - ned_from_body * Vector3::from(rates).cross(&arm);
    (position.into(), velocity.into())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn antenna_on_the_tail_swings_outwards_in_a_turn() {
        // Heading east, antenna 5 m aft, yawing right at 0.2 rad/s: it lies 5 m west and moves 1 m/s northwards (to the left).
        let east = std::f64::consts::FRAC_PI_2;
        let (position, velocity) = satellite_fix_at_cg(
            [-5.0, 0.0, 0.0],
            [0.0, 0.0, east],
            [0.0, 0.0, 0.2],
            [0.0, -5.0, 0.0],
            [1.0, 50.0, 0.0],
        );
        for (found, expected) in position.into_iter().chain(velocity).zip([0.0, 0.0, 0.0, 0.0, 50.0, 0.0]) {
            approx::assert_relative_eq!(found, expected, epsilon = 1e-14);
        }
    }

    #[test]
    fn position_integrates_both_velocities_from_zero() {
        let time = [10.0, 10.2, 10.4];
        let [north, east] = position_from_velocity(&time, &[50.0, 50.0, 50.0], &[0.0, 1.0, 2.0]).unwrap();
        approx::assert_relative_eq!(north[2], 20.0, epsilon = 1e-12);
        approx::assert_relative_eq!(east[2], 0.4, epsilon = 1e-12);
    }
}
