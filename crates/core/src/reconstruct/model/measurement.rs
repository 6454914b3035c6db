//! Navigation model `z = h(x)` (thesis Eq. 3.8) and its Jacobian `H = dh/dx`.
//!
//! Axes and angles as in `docs/conventions.md`. Singular at zero airspeed (flow angles).

use crate::reconstruct::model::kinematics::{Trig, ned_by_attitude, ned_from_body, ned_from_body_times};
use crate::reconstruct::model::layout::{AIR, ATTITUDE};
use crate::reconstruct::numeric::mat3::Mat3;
use crate::reconstruct::numeric::real::Real;
use crate::reconstruct::numeric::vec3::Vec3;

/// The part of the navigation model h that is not linear: ground velocity `C vel + wind` and air data, with the blocks of H.
/// Position and attitude are measured as they are; ground velocity by wind is the identity.
#[derive(Clone, Copy)]
pub struct MeasurementModel<T> {
    /// Ground velocity, NED, m/s.
    pub ground: Vec3<T>,
    /// Of ground velocity by velocity: C.
    pub ground_vel: Mat3<T>,
    /// Of ground velocity by attitude.
    pub ground_att: Mat3<T>,
    /// True airspeed, m/s, angle of attack and sideslip, rad.
    pub air: Vec3<T>,
    /// Of air data by velocity.
    pub air_vel: Mat3<T>,
}

impl<T: Real> MeasurementModel<T> {
    /// At velocity `vel`, m/s, attitude `trig` and `wind`, NED, m/s.
    #[inline(always)]
    pub fn new(vel: &Vec3<T>, trig: &Trig<T>, wind: &Vec3<T>) -> Self {
        let ned = ned_from_body_times(vel, trig);
        let [u, v, w] = *vel;
        let (zero, one) = (T::zero(), T::splat(1.0));
        let plane_squared = u.mul_add(u, w * w);
        let speed_squared = v.mul_add(v, plane_squared);
        let (plane, speed) = (plane_squared.sqrt(), speed_squared.sqrt());
        let per_speed = one / speed;
        let per_plane_squared = one / plane_squared;
        let slip = -(v / (plane * speed_squared));
        Self {
            ground: [ned[0] + wind[0], ned[1] + wind[1], ned[2] + wind[2]],
            ground_vel: ned_from_body(trig),
            ground_att: ned_by_attitude(vel, &ned, trig),
            air: [speed, w.atan2(u), v.atan2(plane)],
            air_vel: [
                [u * per_speed, v * per_speed, w * per_speed],
                [-(w * per_plane_squared), zero, u * per_plane_squared],
                [slip * u, plane * per_speed * per_speed, slip * w],
            ],
        }
    }
}

/// Measured less expected of measurement `i` of a triple, angles brought into half a turn.
#[inline(always)]
pub fn residual<T: Real>(triple: usize, i: usize, measured: T, expected: T) -> T {
    let difference = measured - expected;
    if triple == ATTITUDE || (triple == AIR && i > 0) { difference.wrapped() } else { difference }
}
