//! Roles worked out of other channels: position of latitude and longitude, attitude of a quaternion, velocity of ground speed and track.

use std::sync::Arc;

use crate::load::maps::attitude::QuaternionAxes;
use crate::load::maps::map::{ATTITUDE, FlatEarth, VELOCITY};
use crate::message;
use crate::quantity::{Role, Unit};
use crate::series::{Channel, DERIVED, Recording, Series};

/// Adds the roles of an attitude given as a quaternion.
pub(crate) fn add_attitude(recording: &mut Recording, parts: &[Series], axes: QuaternionAxes) {
    let [w, x, y, z] = parts else { return };
    let count = parts.iter().map(|part| part.values.len()).min().unwrap_or(0);
    let angles: Vec<[f64; 3]> =
        (0..count).map(|k| axes.euler_rad([w.values[k], x.values[k], y.values[k], z.values[k]])).collect();
    for (index, role) in ATTITUDE.into_iter().enumerate() {
        add(recording, role, &w.time_s, angles.iter().map(|angles| angles[index]).collect());
    }
}

/// Adds velocity north and east, `v_g cos(chi)` and `v_g sin(chi)`.
pub(crate) fn add_velocity(recording: &mut Recording, speed_m_s: &Series, track_rad: &Series) {
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
pub(crate) fn metres_per_radian(latitude_rad: f64, altitude_m: f64) -> (f64, f64) {
    let (sin, cos) = latitude_rad.sin_cos();
    let flattening = 1.0 - WGS84_ECCENTRICITY_SQUARED * sin * sin;
    let meridian = WGS84_SEMI_MAJOR_M * (1.0 - WGS84_ECCENTRICITY_SQUARED) / flattening.powf(1.5);
    let normal = WGS84_SEMI_MAJOR_M / flattening.sqrt();
    (meridian + altitude_m, (normal + altitude_m) * cos)
}

/// Adds position north, east and (with an altitude) down, relative to the first finite fix.
pub(crate) fn add_position(recording: &mut Recording, derive: &FlatEarth) {
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
    recording.warnings.push(message!(
        "{} at {:.3} s: {:.6} deg, {:.6} deg, {:.1} m",
        text,
        time,
        lat0.to_degrees(),
        lon0.to_degrees(),
        h0
    ));
}

/// Adds a role that no channel holds.
fn add(recording: &mut Recording, role: Role, time_s: &Arc<[f64]>, values: Arc<[f64]>) {
    recording.roles.insert(role, recording.channels.len());
    let series = Series { time_s: Arc::clone(time_s), values };
    let unit = Unit::si(role.dimension()).symbol.to_owned();
    recording.channels.push(Channel { source: DERIVED.to_owned(), name: role.name().to_owned(), unit, series });
}

/// `angle_rad` brought into -pi..pi.
pub(crate) fn wrapped(angle_rad: f64) -> f64 {
    (angle_rad + std::f64::consts::PI).rem_euclid(std::f64::consts::TAU) - std::f64::consts::PI
}
