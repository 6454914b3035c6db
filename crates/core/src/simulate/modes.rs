//! Natural modes of the aircraft linearised about a trim.

use nalgebra::{Complex, DMatrix, SMatrix, SVector, Vector3};

use super::trim::Trim;
use super::vehicle::{Body, Vehicle};
use crate::motion::State;

/// A natural mode.
#[derive(Clone, Debug, PartialEq)]
pub struct Mode {
    /// `short period`, `phugoid`, `Dutch roll`, `roll subsidence`, `spiral`, or `unnamed` where an eigenvalue has no counterpart in
    /// the motion that usually goes by a name.
    pub name: &'static str,
    /// Real part of the eigenvalue, 1/s; negative is stable.
    pub real_1_s: f64,
    /// Imaginary part, not negative, rad/s; zero for an aperiodic mode.
    pub imaginary_rad_s: f64,
}

impl Mode {
    /// Undamped natural frequency `|s|`, rad/s.
    pub fn frequency_rad_s(&self) -> f64 {
        (self.real_1_s * self.real_1_s + self.imaginary_rad_s * self.imaginary_rad_s).sqrt()
    }

    /// Damping ratio `-Re(s) / |s|`; 1 for a stable, -1 for an unstable aperiodic mode.
    pub fn damping(&self) -> f64 {
        -self.real_1_s / self.frequency_rad_s()
    }

    /// Time constant `-1 / Re(s)`, s; negative when unstable.
    pub fn time_constant_s(&self) -> f64 {
        -1.0 / self.real_1_s
    }

    /// True when it dies out.
    pub fn is_stable(&self) -> bool {
        self.real_1_s < 0.0
    }
}

/// States of the linear model: velocity relative to the ground `u v w`, rates `p q r`, bank, pitch.
const STATES: usize = 8;
/// Longitudinal ones.
const LONGITUDINAL: [usize; 4] = [0, 2, 4, 7];
/// Lateral ones.
const LATERAL: [usize; 4] = [1, 3, 5, 6];

/// System matrix of the motion about a trim in `u v w p q r phi theta` (m/s, rad/s, rad) by central differences; heading,
/// position and the fall of density with altitude are left out.
pub fn system_matrix(vehicle: &Vehicle, body: &Body, trim: &Trim) -> SMatrix<f64, STATES, STATES> {
    /// Steps of the differences: m/s, rad/s, rad.
    const STEPS: [f64; STATES] = [1e-3, 1e-3, 1e-3, 1e-5, 1e-5, 1e-5, 1e-5, 1e-5];
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

/// All modes about a trim, fastest first. They are the eigenvalues of the whole system; their names come from the nearest
/// eigenvalue of the longitudinal or the lateral part.
pub fn modes(vehicle: &Vehicle, body: &Body, trim: &Trim) -> Vec<Mode> {
    let matrix = system_matrix(vehicle, body, trim);
    let part = |rows: [usize; 4]| eigenvalues(DMatrix::from_fn(4, 4, |i, j| matrix[(rows[i], rows[j])]));
    let mut named = name_longitudinal(part(LONGITUDINAL));
    named.extend(name_lateral(part(LATERAL)));
    let mut modes: Vec<Mode> = Vec::with_capacity(STATES);
    for value in eigenvalues(DMatrix::from_iterator(STATES, STATES, matrix.iter().copied())) {
        let nearest = named
            .iter()
            .enumerate()
            .min_by(|(_, a), (_, b)| (a.1 - value).norm().total_cmp(&(b.1 - value).norm()))
            .map(|(index, _)| index);
        let name = nearest.map_or("unnamed", |index| named.remove(index).0);
        modes.push(Mode { name, real_1_s: value.re, imaginary_rad_s: value.im });
    }
    modes.sort_by(|a, b| b.frequency_rad_s().total_cmp(&a.frequency_rad_s()));
    modes
}

/// Eigenvalues with an imaginary part that is not negative: one of each pair.
fn eigenvalues(matrix: DMatrix<f64>) -> Vec<Complex<f64>> {
    let all = matrix.complex_eigenvalues();
    all.iter().copied().filter(|value| value.im >= 0.0).collect()
}

/// Names of the longitudinal eigenvalues: the faster pair is the short period, the slower the phugoid.
fn name_longitudinal(values: Vec<Complex<f64>>) -> Vec<(&'static str, Complex<f64>)> {
    let mut pairs: Vec<_> = values.iter().copied().filter(|value| value.im > 0.0).collect();
    pairs.sort_by(|a, b| b.norm().total_cmp(&a.norm()));
    let names = ["short period", "phugoid"];
    let mut named: Vec<_> = names.into_iter().zip(pairs).collect();
    named.extend(values.into_iter().filter(|value| value.im == 0.0).map(|value| ("unnamed", value)));
    named
}

/// Names of the lateral eigenvalues: the pair is the Dutch roll, the faster real one the roll subsidence, the slower the
/// spiral.
fn name_lateral(values: Vec<Complex<f64>>) -> Vec<(&'static str, Complex<f64>)> {
    let mut named: Vec<_> =
        values.iter().copied().filter(|value| value.im > 0.0).map(|value| ("Dutch roll", value)).collect();
    let mut real: Vec<_> = values.into_iter().filter(|value| value.im == 0.0).collect();
    real.sort_by(|a, b| b.norm().total_cmp(&a.norm()));
    named.extend(["roll subsidence", "spiral"].into_iter().zip(real));
    named
}
