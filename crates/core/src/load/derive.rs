//! Roles worked out of other channels: position of latitude and longitude, attitude of a quaternion, velocity of ground speed and track.

use std::sync::Arc;

use super::map::{Entry, FlatEarth};
use super::plan::Assignment;
use crate::quantity::{Role, Unit};
use crate::series::{Channel, Recording, Series};

/// Axes that a quaternion turns into each other.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum QuaternionAxes {
    /// Body forward, right, down into north, east, down.
    Ned,
    /// Body forward, left, up into east, north, up (REP 103 of ROS).
    Enu,
}

impl QuaternionAxes {
    /// Every one.
    pub const ALL: [Self; 2] = [Self::Ned, Self::Enu];

    /// Name in files.
    pub fn name(self) -> &'static str {
        match self {
            Self::Ned => "ned",
            Self::Enu => "enu",
        }
    }

    /// The axes in words.
    pub fn description(self) -> &'static str {
        match self {
            Self::Ned => "body forward, right, down into north, east, down",
            Self::Enu => "body forward, left, up into east, north, up",
        }
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
            Self::Enu => [phi, -theta, wrapped(std::f64::consts::FRAC_PI_2 - psi)],
        }
    }
}

/// What a map derives.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Derivations {
    /// Position from fixes.
    pub position: Option<FlatEarth>,
    /// Attitude from the parts `w, x, y, z` of a quaternion.
    pub attitude: Option<(Vec<Entry>, QuaternionAxes)>,
    /// Velocity north and east from ground speed and track over the ground.
    pub velocity: Option<[Entry; 2]>,
}

/// The channels that derived roles are made of.
#[derive(Clone, Debug, Default)]
pub(super) struct DerivedChannels {
    pub attitude: Option<(Vec<Assignment>, QuaternionAxes)>,
    pub velocity: Option<[Assignment; 2]>,
}

/// Attitude.
pub(super) const ATTITUDE: [Role; 3] = [Role::BankAngle, Role::PitchAngle, Role::HeadingAngle];
/// Horizontal velocity over the ground.
pub(super) const VELOCITY: [Role; 2] = [Role::VelocityNorth, Role::VelocityEast];

/// Adds the roles of an attitude given as a quaternion.
pub(super) fn add_attitude(recording: &mut Recording, parts: &[Series], axes: QuaternionAxes) {
    let [w, x, y, z] = parts else { return };
    let count = parts.iter().map(|part| part.values.len()).min().unwrap_or(0);
    let angles: Vec<[f64; 3]> =
        (0..count).map(|k| axes.euler_rad([w.values[k], x.values[k], y.values[k], z.values[k]])).collect();
    for (index, role) in ATTITUDE.into_iter().enumerate() {
        add(recording, role, &w.time_s, angles.iter().map(|angles| angles[index]).collect());
    }
}

/// Adds velocity north and east, `v_g cos(chi)` and `v_g sin(chi)`.
pub(super) fn add_velocity(recording: &mut Recording, speed_m_s: &Series, track_rad: &Series) {
    for (role, part) in VELOCITY.into_iter().zip([f64::cos as fn(f64) -> f64, f64::sin]) {
        let values =
            speed_m_s.values.iter().zip(&*track_rad.values).map(|(speed, track)| speed * part(*track)).collect();
        add(recording, role, &speed_m_s.time_s, values);
    }
}

/// Semi-major axis of the WGS 84 ellipsoid, m (NIMA TR8350.2).
const WGS84_SEMI_MAJOR_M: f64 = 6_378_137.0;
/// First eccentricity squared of the WGS 84 ellipsoid (NIMA TR8350.2).
const WGS84_ECCENTRICITY_SQUARED: f64 = 6.694_379_990_14e-3;

/// Metres north per radian of latitude and metres east per radian of longitude at `latitude_rad` and `altitude_m`.
///
/// `R_M = a (1 - e^2) / (1 - e^2 sin^2)^(3/2)`, `R_N = a / sqrt(1 - e^2 sin^2)`; north `R_M + h`, east `(R_N + h) cos`.
fn metres_per_radian(latitude_rad: f64, altitude_m: f64) -> (f64, f64) {
    let (sin, cos) = latitude_rad.sin_cos();
    let flattening = 1.0 - WGS84_ECCENTRICITY_SQUARED * sin * sin;
    let meridian = WGS84_SEMI_MAJOR_M * (1.0 - WGS84_ECCENTRICITY_SQUARED) / flattening.powf(1.5);
    let normal = WGS84_SEMI_MAJOR_M / flattening.sqrt();
    (meridian + altitude_m, (normal + altitude_m) * cos)
}

/// Adds position north, east and (with an altitude) down, relative to the first finite fix.
pub(super) fn add_position(recording: &mut Recording, derive: &FlatEarth) {
    let series = |role: Role| recording.role(role).map(|channel| channel.series.clone());
    let (Some(latitude), Some(longitude)) = (series(Role::Latitude), series(Role::Longitude)) else { return };
    let altitude = derive.altitude.and_then(series);
    let height = |index: usize| altitude.as_ref().map_or(0.0, |series| series.values[index]);
    let finite = |index: &usize| {
        [latitude.values[*index], longitude.values[*index], height(*index)].iter().all(|v| v.is_finite())
    };
    let Some(first) = (0..latitude.values.len()).find(finite) else { return };
    let (lat0, lon0, h0) = (latitude.values[first], longitude.values[first], height(first));
    let (north, east) = metres_per_radian(lat0, h0);
    let mut made = vec![
        (Role::PositionNorth, latitude.values.iter().map(|lat| north * (lat - lat0)).collect::<Arc<[f64]>>()),
        (Role::PositionEast, longitude.values.iter().map(|lon| east * wrapped(lon - lon0)).collect()),
    ];
    if let Some(altitude) = &altitude {
        made.push((Role::PositionDown, altitude.values.iter().map(|h| h0 - h).collect()));
    }
    for (role, values) in made {
        add(recording, role, &latitude.time_s, values);
    }
    let (time, text) = (latitude.time_s[first], "position is relative to the fix");
    recording.warnings.push(format!(
        "{text} at {time:.3} s: {:.6} deg, {:.6} deg, {h0:.1} m",
        lat0.to_degrees(),
        lon0.to_degrees()
    ));
}

/// Adds a role that no channel holds.
fn add(recording: &mut Recording, role: Role, time_s: &Arc<[f64]>, values: Arc<[f64]>) {
    recording.roles.insert(role, recording.channels.len());
    let series = Series { time_s: Arc::clone(time_s), values };
    let unit = Unit::si(role.dimension()).symbol.to_owned();
    recording.channels.push(Channel { source: "derived".to_owned(), name: role.name().to_owned(), unit, series });
}

/// `angle_rad` brought into -pi..pi.
fn wrapped(angle_rad: f64) -> f64 {
    (angle_rad + std::f64::consts::PI).rem_euclid(std::f64::consts::TAU) - std::f64::consts::PI
}

#[cfg(test)]
mod tests {
    use nalgebra::Vector3;

    use super::QuaternionAxes;
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
