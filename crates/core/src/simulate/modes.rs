//! Motion of the aircraft linearised about a trim.

use nalgebra::{DMatrix, SMatrix, SVector, Vector3};

use super::trim::Trim;
use super::vehicle::{Body, Vehicle};
use crate::motion::{Mode, MotionState, State, natural_modes};

/// States of the linear model: velocity relative to the air `u v w`, rates `p q r`, bank, pitch.
const STATES: usize = 8;

/// What they are.
const MEANINGS: [MotionState; STATES] = [
    MotionState::Speed,
    MotionState::Sideslip,
    MotionState::Heave,
    MotionState::RollRate,
    MotionState::PitchRate,
    MotionState::YawRate,
    MotionState::Bank,
    MotionState::Pitch,
];

/// System matrix of the motion about a trim in `u v w p q r phi theta` (m/s, rad/s, rad) by central differences; heading,
/// position and the fall of density with altitude are left out. A steady wind moves the aircraft without changing its motion relative to
/// the air, so the matrix is that of still air.
pub fn system_matrix(vehicle: &Vehicle, body: &Body, trim: &Trim) -> SMatrix<f64, STATES, STATES> {
    /// Steps of the differences: m/s, rad/s, rad.
    const STEPS: [f64; STATES] = [1e-3, 1e-3, 1e-3, 1e-5, 1e-5, 1e-5, 1e-5, 1e-5];
    // Without the heading among the states a wind over the ground would turn with the aircraft.
    let mut still = *trim;
    still.state.velocity_ned_m_s -= trim.environment.wind_ned_m_s;
    still.environment.wind_ned_m_s = Vector3::zeros();
    let trim = &still;
    let mut matrix = SMatrix::<f64, STATES, STATES>::zeros();
    for column in 0..STATES {
        let mut step = SVector::<f64, STATES>::zeros();
        step[column] = STEPS[column];
        let ahead = rate(vehicle, body, trim, &step);
        let behind = rate(vehicle, body, trim, &-step);
        matrix.set_column(column, &((ahead - behind) / (2.0 * STEPS[column])));
    }
    matrix
}

/// Rates of the eight states a small step away from the trim.
fn rate(vehicle: &Vehicle, body: &Body, trim: &Trim, step: &SVector<f64, STATES>) -> SVector<f64, STATES> {
    let [phi, theta, psi] = trim.state.euler_rad();
    let velocity = trim.state.body_from_ned() * trim.state.velocity_ned_m_s + Vector3::new(step[0], step[1], step[2]);
    let (phi, theta) = (phi + step[6], theta + step[7]);
    let mut state = State::new(trim.state.position_ned_m, Vector3::zeros(), [phi, theta, psi]);
    // Trims are straight: no rates of their own.
    state.rates_rad_s = Vector3::new(step[3], step[4], step[5]);
    let body_from_ned = state.body_from_ned();
    state.velocity_ned_m_s = body_from_ned.tr_mul(&velocity);
    let loads = vehicle.loads(body, &state, &trim.environment);
    let acceleration = body_from_ned * loads.acceleration_ned_m_s2 - state.rates_rad_s.cross(&velocity);
    let angular = loads.angular_acceleration_rad_s2;
    let [p, q, r] = [step[3], step[4], step[5]];
    let (sin, cos) = libm::sincos(phi);
    let tan = libm::tan(theta);
    SVector::from([
        acceleration.x,
        acceleration.y,
        acceleration.z,
        angular.x,
        angular.y,
        angular.z,
        p + (q * sin + r * cos) * tan,
        q * cos - r * sin,
    ])
}

/// All modes about a trim, fastest first: those of the whole system.
pub fn modes(vehicle: &Vehicle, body: &Body, trim: &Trim) -> Vec<Mode> {
    let matrix = system_matrix(vehicle, body, trim);
    natural_modes(&DMatrix::from_iterator(STATES, STATES, matrix.iter().copied()), &MEANINGS)
}
