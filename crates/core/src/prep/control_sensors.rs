//! How far a sensor on a yoke or a pulley has turned about its own z axis.

use nalgebra::{Matrix3, Rotation3, UnitQuaternion};

use super::{Differentiation, PrepError, cumulative_trapezoid, differentiate};

/// Attitudes of a sensor, sensor to local Earth, one per stamp.
#[derive(Clone, Copy, Debug)]
pub enum SensorAttitude<'a> {
    /// Bank, pitch and heading, rad; wrapped or not.
    Euler {
        /// Bank, rad.
        phi: &'a [f64],
        /// Pitch, rad.
        theta: &'a [f64],
        /// Heading, rad.
        psi: &'a [f64],
    },
    /// Unit quaternion; either sign.
    Quaternion {
        /// Scalar part.
        e0: &'a [f64],
        /// Component along x.
        ex: &'a [f64],
        /// Component along y.
        ey: &'a [f64],
        /// Component along z.
        ez: &'a [f64],
    },
}

impl<'a> SensorAttitude<'a> {
    /// The attitudes of some of the stamps.
    pub fn within(&self, range: std::ops::Range<usize>) -> Option<Self> {
        let part = |values: &'a [f64]| values.get(range.clone());
        Some(match *self {
            Self::Euler { phi, theta, psi } => Self::Euler { phi: part(phi)?, theta: part(theta)?, psi: part(psi)? },
            Self::Quaternion { e0, ex, ey, ez } => {
                Self::Quaternion { e0: part(e0)?, ex: part(ex)?, ey: part(ey)?, ez: part(ez)? }
            }
        })
    }

    /// Number of attitudes all components have.
    fn len(&self) -> usize {
        match self {
            Self::Euler { phi, theta, psi } => phi.len().min(theta.len()).min(psi.len()),
            Self::Quaternion { e0, ex, ey, ez } => e0.len().min(ex.len()).min(ey.len()).min(ez.len()),
        }
    }

    /// Matrix from local Earth to sensor axes at one stamp.
    fn sensor_from_earth(&self, k: usize) -> Matrix3<f64> {
        let earth_from_sensor = match self {
            Self::Euler { phi, theta, psi } => Rotation3::from_euler_angles(phi[k], theta[k], psi[k]),
            Self::Quaternion { e0, ex, ey, ez } => {
                let quaternion = nalgebra::Quaternion::new(e0[k], ex[k], ey[k], ez[k]);
                UnitQuaternion::from_quaternion(quaternion).to_rotation_matrix()
            }
        };
        earth_from_sensor.matrix().transpose()
    }
}

/// Values without the jumps of a whole turn between samples.
pub(crate) fn unwrapped(values: &[f64]) -> Vec<f64> {
    let mut turns = 0.0;
    let mut last = values.first().copied().unwrap_or(0.0);
    let mut result = Vec::with_capacity(values.len());
    for &value in values {
        turns -= ((value - last) / std::f64::consts::TAU).round() * std::f64::consts::TAU;
        last = value;
        result.push(value + turns);
    }
    result
}

/// Angular rates of a sensor about its own axes, rad/s, each as long as the time vector.
///
/// From Euler angles `p = phi' - sin(theta) psi'`, `q = cos(phi) theta' + sin(phi) cos(theta) psi'`,
/// `r = -sin(phi) theta' + cos(phi) cos(theta) psi'` (thesis Eq. 4.1-4.3); from a quaternion
/// `w = 2 (e0 e' - e0' e - e x e')`. Derivatives by `method`; the thesis uses [`Differentiation::Central4`]. Euler angles are
/// singular where the sensor's x axis stands upright.
///
/// # Errors
/// Those of [`differentiate`].
pub fn sensor_rates(
    time_s: &[f64],
    attitude: &SensorAttitude<'_>,
    method: Differentiation,
) -> Result<[Vec<f64>; 3], PrepError> {
    let slope = |values: &[f64]| differentiate(time_s, values, method);
    let mut rates = [vec![0.0; time_s.len()], vec![0.0; time_s.len()], vec![0.0; time_s.len()]];
    match *attitude {
        SensorAttitude::Euler { phi, theta, psi } => {
            let (phi_dot, theta_dot, psi_dot) =
                (slope(&unwrapped(phi))?, slope(&unwrapped(theta))?, slope(&unwrapped(psi))?);
            for k in 0..time_s.len() {
                let ((sin_phi, cos_phi), (sin_theta, cos_theta)) = (phi[k].sin_cos(), theta[k].sin_cos());
                rates[0][k] = phi_dot[k] - sin_theta * psi_dot[k];
                rates[1][k] = cos_phi * theta_dot[k] + sin_phi * cos_theta * psi_dot[k];
                rates[2][k] = -sin_phi * theta_dot[k] + cos_phi * cos_theta * psi_dot[k];
            }
        }
        SensorAttitude::Quaternion { e0, ex, ey, ez } => {
            let e = continuous([e0, ex, ey, ez]);
            let dot = [slope(&e[0])?, slope(&e[1])?, slope(&e[2])?, slope(&e[3])?];
            for k in 0..time_s.len() {
                let [w, x, y, z] = [e[0][k], e[1][k], e[2][k], e[3][k]];
                let [dw, dx, dy, dz] = [dot[0][k], dot[1][k], dot[2][k], dot[3][k]];
                rates[0][k] = 2.0 * (w * dx - dw * x - (y * dz - z * dy));
                rates[1][k] = 2.0 * (w * dy - dw * y - (z * dx - x * dz));
                rates[2][k] = 2.0 * (w * dz - dw * z - (x * dy - y * dx));
            }
        }
    }
    Ok(rates)
}

/// Quaternions of one sign: a quaternion and its negative are the same attitude.
fn continuous(parts: [&[f64]; 4]) -> [Vec<f64>; 4] {
    let count = parts.iter().map(|part| part.len()).min().unwrap_or(0);
    let mut result = parts.map(|part| part[..count].to_vec());
    for k in 1..count {
        let along: f64 = result.iter().map(|part| part[k] * part[k - 1]).sum();
        if along < 0.0 {
            result.iter_mut().for_each(|part| part[k] = -part[k]);
        }
    }
    result
}

/// A sensor fixed to the aircraft, and how the turning one is set against it.
#[derive(Clone, Copy, Debug)]
pub struct SensorReference<'a> {
    /// Attitudes of the fixed sensor, at the stamps of the turning one.
    pub attitude: SensorAttitude<'a>,
    /// Rows: axes of the turning sensor in axes of the fixed one, at zero turn.
    pub sensor_from_reference: [[f64; 3]; 3],
}

/// Turn of a sensor about its own z axis since the first stamp, rad, as the thesis works it out (section 4.1.2): the rate
/// about z by Eq. 4.3, less that of the aircraft about the same axis where a reference is given, integrated by Eq. D.3.
///
/// The aircraft's rate about the axis is `a . w` with the rates `w` of the reference sensor and the axis `a`, the third row of
/// `sensor_from_reference`. The thesis gives a reference for the yoke alone; a pulley without one also shows what the
/// aircraft turns about its axis. One stretch without gaps at a time (see [`super::stretches`]).
///
/// # Errors
/// Those of [`differentiate`].
pub fn integrated_turn(
    time_s: &[f64],
    sensor: &SensorAttitude<'_>,
    reference: Option<&SensorReference<'_>>,
    method: Differentiation,
) -> Result<Vec<f64>, PrepError> {
    let [_, _, mut rate] = sensor_rates(time_s, sensor, method)?;
    if let Some(reference) = reference {
        let [p, q, r] = sensor_rates(time_s, &reference.attitude, method)?;
        let [x, y, z] = reference.sensor_from_reference[2];
        for (k, rate) in rate.iter_mut().enumerate() {
            *rate -= x * p[k] + y * q[k] + z * r[k];
        }
    }
    cumulative_trapezoid(time_s, &rate)
}

/// Turn of a sensor about its own z axis against a fixed one, rad, from both attitudes at each stamp; without jumps, the first
/// value between -pi and pi.
///
/// With `S = R_z(turn) M F` of the matrices from Earth to sensor `S` and to reference `F` and the mount `M`, the turn is that of
/// `D = S F^T M^T` about z: `atan2(D_01 - D_10, D_00 + D_11)`. Unlike [`integrated_turn`] it starts at the true angle, whatever
/// the control's position when the recording began, does not drift, and takes out every motion of the aircraft.
///
/// # Errors
/// [`PrepError::Length`] when the two differ in length.
pub fn attitude_turn(sensor: &SensorAttitude<'_>, reference: &SensorReference<'_>) -> Result<Vec<f64>, PrepError> {
    if sensor.len() != reference.attitude.len() {
        return Err(PrepError::Length { time: sensor.len(), values: reference.attitude.len() });
    }
    let rows = reference.sensor_from_reference;
    let mount = Matrix3::from_fn(|i, j| rows[i][j]);
    let turn = |k: usize| {
        let d = sensor.sensor_from_earth(k) * reference.attitude.sensor_from_earth(k).transpose() * mount.transpose();
        (d[(0, 1)] - d[(1, 0)]).atan2(d[(0, 0)] + d[(1, 1)])
    };
    Ok(unwrapped(&(0..sensor.len()).map(turn).collect::<Vec<_>>()))
}

/// Standard deviation of the integrated turn of a sensor at rest, rad.
///
/// Differences and trapezoids telescope: what remains of the noise at an instant are its five samples with the weights
/// -1/24, 1/4, 7/12, 1/4, -1/24, whose squares sum to 15/32. The noise does not grow with time.
pub fn integrated_turn_noise(euler: [f64; 3], noise: [f64; 3]) -> f64 {
    let ((sin_phi, cos_phi), cos_theta) = (euler[0].sin_cos(), euler[1].cos());
    (sin_phi * noise[1]).hypot(cos_phi * cos_theta * noise[2]) * (15.0f64 / 32.0).sqrt()
}
