//! Rigid-body motion over a flat, non-rotating Earth, the flow it meets, its integration and its natural modes.

mod airflow;
mod modes;

use nalgebra::{Matrix3, Vector3};

use crate::airframe::InertiaTensor;

pub use airflow::Airflow;
pub use modes::{Mode, MotionState, natural_modes};

/// Position, velocity, attitude and rates of a rigid body.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct State {
    /// Position of the centre of gravity in local Earth axes, m.
    pub position_ned_m: Vector3<f64>,
    /// Velocity over the ground in local Earth axes, m/s.
    pub velocity_ned_m_s: Vector3<f64>,
    /// Unit quaternion `w, x, y, z` that turns local Earth axes into body axes.
    pub attitude: [f64; 4],
    /// Roll, pitch and yaw rate in body axes, rad/s.
    pub rates_rad_s: Vector3<f64>,
}

/// Rate of change of a [`State`].
#[derive(Clone, Copy, Debug)]
pub struct Rate {
    /// Velocity over the ground, m/s.
    pub position: Vector3<f64>,
    /// Acceleration over the ground, m/s².
    pub velocity: Vector3<f64>,
    /// Rate of the quaternion, 1/s.
    pub attitude: [f64; 4],
    /// Angular acceleration in body axes, rad/s².
    pub rates: Vector3<f64>,
}

impl State {
    /// State with the attitude `phi, theta, psi` (rad; 3-2-1 order of `docs/conventions.md`).
    pub fn new(position_ned_m: Vector3<f64>, velocity_ned_m_s: Vector3<f64>, euler_rad: [f64; 3]) -> Self {
        let attitude = quaternion(euler_rad);
        Self { position_ned_m, velocity_ned_m_s, attitude, rates_rad_s: Vector3::zeros() }
    }

    /// Rotation matrix from local Earth to body axes (thesis Eq. A.16 with the sign of `docs/conventions.md`).
    pub fn body_from_ned(&self) -> Matrix3<f64> {
        let [w, x, y, z] = self.attitude;
        Matrix3::new(
            w * w + x * x - y * y - z * z,
            2.0 * (x * y + w * z),
            2.0 * (x * z - w * y),
            2.0 * (x * y - w * z),
            w * w - x * x + y * y - z * z,
            2.0 * (y * z + w * x),
            2.0 * (x * z + w * y),
            2.0 * (y * z - w * x),
            w * w - x * x - y * y + z * z,
        )
    }

    /// Bank, pitch and heading angle, rad; heading in (-pi, pi]. Singular at a pitch of 90 deg.
    pub fn euler_rad(&self) -> [f64; 3] {
        let m = self.body_from_ned();
        let pitch = libm::asin((-m[(0, 2)]).clamp(-1.0, 1.0));
        [libm::atan2(m[(1, 2)], m[(2, 2)]), pitch, libm::atan2(m[(0, 1)], m[(0, 0)])]
    }

    /// `self + rate * h`, without normalising the quaternion.
    fn plus(&self, rate: &Rate, h: f64) -> Self {
        Self {
            position_ned_m: self.position_ned_m + rate.position * h,
            velocity_ned_m_s: self.velocity_ned_m_s + rate.velocity * h,
            attitude: std::array::from_fn(|i| self.attitude[i] + rate.attitude[i] * h),
            rates_rad_s: self.rates_rad_s + rate.rates * h,
        }
    }

    /// Rate of the quaternion, `dq/dt = q * (0, omega) / 2`, 1/s.
    fn attitude_rate(&self) -> [f64; 4] {
        let [w, x, y, z] = self.attitude;
        let [p, q, r] = [self.rates_rad_s.x, self.rates_rad_s.y, self.rates_rad_s.z];
        [
            0.5 * (-x * p - y * q - z * r),
            0.5 * (w * p + y * r - z * q),
            0.5 * (w * q + z * p - x * r),
            0.5 * (w * r + x * q - y * p),
        ]
    }

    /// Rate of change of the state for an acceleration over the ground (m/s², local Earth axes) and an angular
    /// acceleration (rad/s², body axes).
    pub fn rate(&self, acceleration_ned_m_s2: Vector3<f64>, angular_acceleration_rad_s2: Vector3<f64>) -> Rate {
        Rate {
            position: self.velocity_ned_m_s,
            velocity: acceleration_ned_m_s2,
            attitude: self.attitude_rate(),
            rates: angular_acceleration_rad_s2,
        }
    }
}

/// Quaternion `w, x, y, z` of bank, pitch and heading, rad.
fn quaternion([phi, theta, psi]: [f64; 3]) -> [f64; 4] {
    let (s1, c1) = libm::sincos(phi / 2.0);
    let (s2, c2) = libm::sincos(theta / 2.0);
    let (s3, c3) = libm::sincos(psi / 2.0);
    [c1 * c2 * c3 + s1 * s2 * s3, s1 * c2 * c3 - c1 * s2 * s3, c1 * s2 * c3 + s1 * c2 * s3, c1 * c2 * s3 - s1 * s2 * c3]
}

/// Inertia tensor (kg m²) with its factor, so that Euler's equation is solved without an inverse.
#[derive(Clone, Copy, Debug)]
pub struct FactoredInertia {
    tensor: Matrix3<f64>,
    factor: Matrix3<f64>,
}

impl FactoredInertia {
    /// Factors a tensor in body axes about the centre of gravity; `None` unless it is positive definite.
    pub fn new(tensor: &InertiaTensor) -> Option<Self> {
        let tensor = tensor.matrix();
        let factor = tensor.cholesky()?.l();
        Some(Self { tensor, factor })
    }

    /// The tensor, kg m².
    pub fn tensor(&self) -> &Matrix3<f64> {
        &self.tensor
    }

    /// Angular acceleration from Euler's equation with the angular momentum `h` of rotors,
    /// `I w' = M - w x (I w + h)` (thesis Eq. A.11 and A.14), rad/s²; all in body axes.
    pub fn angular_acceleration(
        &self,
        moment_n_m: Vector3<f64>,
        rates_rad_s: Vector3<f64>,
        rotor_momentum_n_m_s: Vector3<f64>,
    ) -> Vector3<f64> {
        let momentum = self.tensor * rates_rad_s + rotor_momentum_n_m_s;
        self.solve(moment_n_m - rates_rad_s.cross(&momentum))
    }

    /// Solves `I x = b` by the two triangles of the factor.
    fn solve(&self, b: Vector3<f64>) -> Vector3<f64> {
        let l = &self.factor;
        let y0 = b.x / l[(0, 0)];
        let y1 = (b.y - l[(1, 0)] * y0) / l[(1, 1)];
        let y2 = (b.z - l[(2, 0)] * y0 - l[(2, 1)] * y1) / l[(2, 2)];
        let z = y2 / l[(2, 2)];
        let y = (y1 - l[(2, 1)] * z) / l[(1, 1)];
        let x = (y0 - l[(1, 0)] * y - l[(2, 0)] * z) / l[(0, 0)];
        Vector3::new(x, y, z)
    }
}

/// One step of the classical fourth-order Runge-Kutta method (thesis Eq. D.4 with its missing `f`), then the quaternion
/// normalised. `rate` gets the fraction of the step (0, 1/2, 1) and the state there.
pub fn runge_kutta(state: &State, h: f64, mut rate: impl FnMut(f64, &State) -> Rate) -> State {
    let k1 = rate(0.0, state);
    runge_kutta_from(state, &k1, h, rate)
}

/// [`runge_kutta`] when the rate at the start of the step is known already.
pub(crate) fn runge_kutta_from(state: &State, k1: &Rate, h: f64, mut rate: impl FnMut(f64, &State) -> Rate) -> State {
    let k2 = rate(0.5, &state.plus(k1, 0.5 * h));
    let k3 = rate(0.5, &state.plus(&k2, 0.5 * h));
    let k4 = rate(1.0, &state.plus(&k3, h));
    let mut next = state.plus(k1, h / 6.0).plus(&k2, h / 3.0).plus(&k3, h / 3.0).plus(&k4, h / 6.0);
    let norm = next.attitude.iter().map(|e| e * e).sum::<f64>().sqrt();
    next.attitude.iter_mut().for_each(|e| *e /= norm);
    next
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Round-off of a few products of sines, -.
    const ROUND_OFF: f64 = 1e-14;

    #[test]
    fn attitude_matches_product_of_elementary_rotations() {
        let [phi, theta, psi]: [f64; 3] = [0.3, -0.4, 2.5];
        let state = State::new(Vector3::zeros(), Vector3::zeros(), [phi, theta, psi]);
        let rx = Matrix3::new(1.0, 0.0, 0.0, 0.0, phi.cos(), phi.sin(), 0.0, -phi.sin(), phi.cos());
        let ry = Matrix3::new(theta.cos(), 0.0, -theta.sin(), 0.0, 1.0, 0.0, theta.sin(), 0.0, theta.cos());
        let rz = Matrix3::new(psi.cos(), psi.sin(), 0.0, -psi.sin(), psi.cos(), 0.0, 0.0, 0.0, 1.0);
        assert!((state.body_from_ned() - rx * ry * rz).amax() < ROUND_OFF);
        for (angle, expected) in state.euler_rad().into_iter().zip([phi, theta, psi]) {
            assert!((angle - expected).abs() < ROUND_OFF);
        }
    }

    #[test]
    fn inertia_rejects_a_tensor_that_is_not_positive() {
        assert!(FactoredInertia::new(&InertiaTensor { xz: -2.0, ..InertiaTensor::diagonal(1.0, 1.0, 1.0) }).is_none());
    }
}
