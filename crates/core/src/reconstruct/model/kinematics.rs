//! Kinematic model `x' = f(x, u)` (thesis Eq. 3.7) and its Jacobian `F = df/dx`.
//!
//! Axes and angles as in `docs/conventions.md`. Singular at a pitch angle of +-90 deg.

use crate::reconstruct::numeric::mat3::{Mat3, cross};
use crate::reconstruct::numeric::real::Real;
use crate::reconstruct::numeric::vec3::Vec3;

/// Sines and cosines of bank, pitch and heading.
#[derive(Clone, Copy)]
pub struct Trig<T> {
    pub sin: Vec3<T>,
    /// Cosines.
    pub cos: Vec3<T>,
}

/// Angle increment, rad, up to which the series of [`Trig::turned`] is exact to rounding.
const SERIES_LIMIT_RAD: f64 = 0.25;

impl<T: Real> Trig<T> {
    /// Of the attitude `att` (bank, pitch, heading), rad.
    #[inline(always)]
    pub fn new(att: &Vec3<T>) -> Self {
        let mut trig = Self { sin: *att, cos: *att };
        for i in 0..3 {
            (trig.sin[i], trig.cos[i]) = att[i].sin_cos();
        }
        trig
    }

    /// Of the attitude `to`, from those of the nearby attitude `from`: addition theorem with short series.
    #[inline(always)]
    pub fn turned(&self, from: &Vec3<T>, to: &Vec3<T>) -> Self {
        let mut trig = *self;
        let mut largest = T::zero();
        for i in 0..3 {
            let d = to[i] - from[i];
            let z = d * d;
            largest = z.select_above(largest, z, largest);
            let sin = series(z, [1.0 / 6.0, 1.0 / 20.0, 1.0 / 42.0, 1.0 / 72.0]) * d;
            let cos_less_1 = -(z * T::splat(0.5)) * series(z, [1.0 / 12.0, 1.0 / 30.0, 1.0 / 56.0, 1.0 / 90.0]);
            trig.sin[i] = self.sin[i].mul_add(cos_less_1, self.cos[i].mul_add(sin, self.sin[i]));
            trig.cos[i] = self.cos[i].mul_add(cos_less_1, self.sin[i].neg_mul_add(sin, self.cos[i]));
        }
        if largest.any_above(T::splat(SERIES_LIMIT_RAD * SERIES_LIMIT_RAD)) {
            return Self::new(to);
        }
        trig
    }
}

/// `1 - a z (1 - b z (1 - c z (1 - d z)))`.
#[inline(always)]
fn series<T: Real>(z: T, factors: [f64; 4]) -> T {
    let one = T::splat(1.0);
    let mut sum = one;
    for k in [3, 2, 1, 0] {
        sum = (z * T::splat(factors[k])).neg_mul_add(sum, one);
    }
    sum
}

/// Time derivative of the states that move.
#[derive(Clone, Copy)]
pub struct Rates<T> {
    /// Of position, NED, m/s.
    pub pos: Vec3<T>,
    /// Of airspeed, body axes, m/s^2.
    pub vel: Vec3<T>,
    /// Of bank, pitch and heading, rad/s.
    pub att: Vec3<T>,
}

/// Kinematic model f (thesis Eq. 3.7): position' = C vel + wind, vel' = force + C' g - rate x vel, attitude' = T rate.
///
/// `force` is the specific force, m/s^2, and `rate` the angular rate, rad/s, both in body axes and free of bias;
/// `vel` the velocity relative to the air in body axes, `wind` that of the air over the ground in NED, m/s.
#[inline(always)]
pub fn rates<T: Real>(
    vel: &Vec3<T>,
    trig: &Trig<T>,
    force: &Vec3<T>,
    rate: &Vec3<T>,
    wind: &Vec3<T>,
    g: T,
) -> Rates<T> {
    let ([sphi, stheta, _], [cphi, ctheta, _]) = (trig.sin, trig.cos);
    let ([u, v, w], [p, q, r]) = (*vel, *rate);
    let turning = q.mul_add(sphi, r * cphi);
    let heading_rate = turning / ctheta;
    let air = ned_from_body_times(vel, trig);
    Rates {
        pos: [air[0] + wind[0], air[1] + wind[1], air[2] + wind[2]],
        vel: [
            stheta.neg_mul_add(g, force[0]) + r.mul_add(v, -(q * w)),
            (ctheta * sphi).mul_add(g, force[1]) + p.mul_add(w, -(r * u)),
            (ctheta * cphi).mul_add(g, force[2]) + q.mul_add(u, -(p * v)),
        ],
        att: [heading_rate.mul_add(stheta, p), q.mul_add(cphi, -(r * sphi)), heading_rate],
    }
}

/// `C vel`: a vector of body axes in NED.
#[inline(always)]
pub(crate) fn ned_from_body_times<T: Real>(vel: &Vec3<T>, trig: &Trig<T>) -> Vec3<T> {
    let ([sphi, stheta, spsi], [cphi, ctheta, cpsi]) = (trig.sin, trig.cos);
    let [u, v, w] = *vel;
    let below = v.mul_add(sphi, w * cphi);
    let aside = v.mul_add(cphi, -(w * sphi));
    let ahead = u.mul_add(ctheta, below * stheta);
    [ahead.mul_add(cpsi, -(aside * spsi)), ahead.mul_add(spsi, aside * cpsi), below.mul_add(ctheta, -(u * stheta))]
}

/// Rotation C from body axes to NED.
#[inline(always)]
pub fn ned_from_body<T: Real>(trig: &Trig<T>) -> Mat3<T> {
    let ([sphi, stheta, spsi], [cphi, ctheta, cpsi]) = (trig.sin, trig.cos);
    let (ss, cs) = (sphi * stheta, cphi * stheta);
    [
        [ctheta * cpsi, ss.mul_add(cpsi, -(cphi * spsi)), cs.mul_add(cpsi, sphi * spsi)],
        [ctheta * spsi, ss.mul_add(spsi, cphi * cpsi), cs.mul_add(spsi, -(sphi * cpsi))],
        [-stheta, sphi * ctheta, cphi * ctheta],
    ]
}

/// Derivative of `C vel` by bank, pitch and heading; `ned` is `C vel`.
#[inline(always)]
pub(crate) fn ned_by_attitude<T: Real>(vel: &Vec3<T>, ned: &Vec3<T>, trig: &Trig<T>) -> Mat3<T> {
    let ([sphi, stheta, spsi], [cphi, ctheta, cpsi]) = (trig.sin, trig.cos);
    let [u, v, w] = *vel;
    let below = v.mul_add(sphi, w * cphi);
    let aside = v.mul_add(cphi, -(w * sphi));
    let ahead = u.mul_add(ctheta, below * stheta);
    let lifted = aside * stheta;
    [
        [lifted.mul_add(cpsi, below * spsi), ned[2] * cpsi, -ned[1]],
        [lifted.mul_add(spsi, -(below * cpsi)), ned[2] * spsi, ned[0]],
        [aside * ctheta, -ahead, T::zero()],
    ]
}

/// Blocks of the Jacobian F of the kinematic model that are not zero, identity or minus identity:
/// pos' by wind is I, vel' by accelerometer bias is -I.
#[derive(Clone, Copy)]
pub struct KinematicsJacobian<T> {
    /// Of position' by velocity: C.
    pub pos_vel: Mat3<T>,
    /// Of position' by attitude.
    pub pos_att: Mat3<T>,
    /// Angular rate, rad/s: velocity' by velocity is `-cross(rate)`.
    pub rate: Vec3<T>,
    /// Of velocity' by attitude.
    pub vel_att: Mat3<T>,
    /// Of velocity' by gyro bias: `-cross(vel)`.
    pub vel_gyr: Mat3<T>,
    /// Of attitude' by attitude.
    pub att_att: Mat3<T>,
    /// Of attitude' by gyro bias.
    pub att_gyr: Mat3<T>,
}

impl<T: Real> KinematicsJacobian<T> {
    /// At velocity `vel`, m/s, attitude `trig`, bias-free angular rate `rate`, rad/s, and gravity `g`, m/s^2.
    #[inline(always)]
    pub fn new(vel: &Vec3<T>, trig: &Trig<T>, rate: &Vec3<T>, g: T) -> Self {
        let ([sphi, stheta, _], [cphi, ctheta, _]) = (trig.sin, trig.cos);
        let [_, q, r] = *rate;
        let (zero, one) = (T::zero(), T::splat(1.0));
        let secant = one / ctheta;
        let tangent = stheta * secant;
        let turning = q.mul_add(sphi, r * cphi);
        let pitching = q.mul_add(cphi, -(r * sphi));
        let turning_secant = turning * secant;
        let reversed = [-vel[0], -vel[1], -vel[2]];
        Self {
            pos_vel: ned_from_body(trig),
            pos_att: ned_by_attitude(vel, &ned_from_body_times(vel, trig), trig),
            rate: *rate,
            vel_att: [
                [zero, -(g * ctheta), zero],
                [g * ctheta * cphi, -(g * stheta * sphi), zero],
                [-(g * ctheta * sphi), -(g * stheta * cphi), zero],
            ],
            vel_gyr: cross(&reversed),
            att_att: [
                [pitching * tangent, turning_secant * secant, zero],
                [-turning, zero, zero],
                [pitching * secant, turning_secant * tangent, zero],
            ],
            att_gyr: [
                [-one, -(sphi * tangent), -(cphi * tangent)],
                [zero, -cphi, sphi],
                [zero, -(sphi * secant), -(cphi * secant)],
            ],
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn turned_trigonometry_matches_fresh_for_small_and_large_angles() {
        let from = [0.4, -0.2, 2.1];
        for step in [1e-3, 0.1, 0.24, 0.7] {
            let to = [from[0] + step, from[1] - step, from[2] + step];
            let (turned, fresh) = (Trig::new(&from).turned(&from, &to), Trig::new(&to));
            for i in 0..3 {
                assert!((turned.sin[i] - fresh.sin[i]).abs() < 1e-13 && (turned.cos[i] - fresh.cos[i]).abs() < 1e-13);
            }
        }
    }
}
