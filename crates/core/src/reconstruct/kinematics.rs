//! Flight mechanics of the filter: kinematic model f (thesis Eq. 3.7), navigation model h (Eq. 3.8), their Jacobians.
//!
//! Axes and angles as in `docs/conventions.md`. Singular at a pitch angle of +-90 deg (attitude rates) and at zero
//! airspeed (flow angles).

use super::blocks::{Block, Vec3, cross};
use super::real::Real;

/// Sines and cosines of bank, pitch and heading.
#[derive(Clone, Copy)]
pub struct Trig<T> {
    /// Sines.
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
fn ned_from_body_times<T: Real>(vel: &Vec3<T>, trig: &Trig<T>) -> Vec3<T> {
    let ([sphi, stheta, spsi], [cphi, ctheta, cpsi]) = (trig.sin, trig.cos);
    let [u, v, w] = *vel;
    let below = v.mul_add(sphi, w * cphi);
    let aside = v.mul_add(cphi, -(w * sphi));
    let ahead = u.mul_add(ctheta, below * stheta);
    [ahead.mul_add(cpsi, -(aside * spsi)), ahead.mul_add(spsi, aside * cpsi), below.mul_add(ctheta, -(u * stheta))]
}

/// Rotation C from body axes to NED.
#[inline(always)]
fn ned_from_body<T: Real>(trig: &Trig<T>) -> Block<T> {
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
fn ned_by_attitude<T: Real>(vel: &Vec3<T>, ned: &Vec3<T>, trig: &Trig<T>) -> Block<T> {
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
    pub pos_vel: Block<T>,
    /// Of position' by attitude.
    pub pos_att: Block<T>,
    /// Angular rate, rad/s: velocity' by velocity is `-cross(rate)`.
    pub rate: Vec3<T>,
    /// Of velocity' by attitude.
    pub vel_att: Block<T>,
    /// Of velocity' by gyro bias: `-cross(vel)`.
    pub vel_gyr: Block<T>,
    /// Of attitude' by attitude.
    pub att_att: Block<T>,
    /// Of attitude' by gyro bias.
    pub att_gyr: Block<T>,
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

/// The part of the navigation model h that is not linear: ground velocity and air data, with their Jacobians.
/// Position and attitude are measured as they are; ground velocity by wind is the identity.
#[derive(Clone, Copy)]
pub struct Observation<T> {
    /// Ground velocity, NED, m/s.
    pub ground: Vec3<T>,
    /// Of ground velocity by velocity: C.
    pub ground_vel: Block<T>,
    /// Of ground velocity by attitude.
    pub ground_att: Block<T>,
    /// True airspeed, m/s, angle of attack and sideslip, rad.
    pub air: Vec3<T>,
    /// Of air data by velocity.
    pub air_vel: Block<T>,
}

impl<T: Real> Observation<T> {
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

#[cfg(test)]
mod tests {
    use nalgebra::SVector;
    use num_dual::DualNum;

    use super::*;
    use crate::reconstruct::dense::Dense;

    /// Rounding of an analytic against a dual-number derivative, relative to the largest entry.
    const ROUNDING: f64 = 1e-10;
    const GRAVITY: f64 = 9.81;
    const INPUT: [f64; 6] = [0.3, -0.2, -9.6, 0.15, 0.07, -0.05];

    /// Thesis Eq. 3.7, written out.
    fn f<D: DualNum<Primitive = f64> + Copy>(x: &SVector<D, 18>) -> SVector<D, 18> {
        let (u, v, w, phi, theta, psi) = (x[3], x[4], x[5], x[6], x[7], x[8]);
        let [ax, ay, az, p, q, r]: [D; 6] = std::array::from_fn(|i| -x[9 + i] + INPUT[i]);
        let ground = h(x);
        let zero = D::from(0.0);
        let mut rates = SVector::from([zero; 18]);
        (rates[0], rates[1], rates[2]) = (ground[3], ground[4], ground[5]);
        rates[3] = ax - theta.sin() * GRAVITY - q * w + r * v;
        rates[4] = ay + theta.cos() * phi.sin() * GRAVITY + p * w - r * u;
        rates[5] = az + theta.cos() * phi.cos() * GRAVITY - p * v + q * u;
        rates[6] = p + q * phi.sin() * theta.tan() + r * phi.cos() * theta.tan();
        rates[7] = q * phi.cos() - r * phi.sin();
        rates[8] = (q * phi.sin() + r * phi.cos()) / theta.cos() + psi * 0.0;
        rates
    }

    /// Thesis Eq. 3.8, written out.
    fn h<D: DualNum<Primitive = f64> + Copy>(x: &SVector<D, 18>) -> SVector<D, 12> {
        let (u, v, w, phi, theta, psi) = (x[3], x[4], x[5], x[6], x[7], x[8]);
        let forward = u * theta.cos() + (v * phi.sin() + w * phi.cos()) * theta.sin();
        let sideways = v * phi.cos() - w * phi.sin();
        SVector::from([
            x[0],
            x[1],
            x[2],
            forward * psi.cos() - sideways * psi.sin() + x[15],
            forward * psi.sin() + sideways * psi.cos() + x[16],
            -u * theta.sin() + (v * phi.sin() + w * phi.cos()) * theta.cos() + x[17],
            phi,
            theta,
            psi,
            (u * u + v * v + w * w).sqrt(),
            w.atan2(u),
            v.atan2((u * u + w * w).sqrt()),
        ])
    }

    const POINT: [f64; 18] =
        [10.0, -20.0, -900.0, 78.0, -3.0, 6.0, 0.4, -0.2, 2.1, 0.02, -0.01, 0.03, 1e-3, -2e-3, 3e-3, 6.0, -2.0, 1.0];

    #[test]
    fn kinematics_jacobian_matches_dual_numbers() {
        let x = SVector::from(POINT);
        let (value, exact): (_, Dense) = num_dual::jacobian(|x| f(&x), &x);
        let (vel, att) = ([x[3], x[4], x[5]], [x[6], x[7], x[8]]);
        let force = std::array::from_fn(|i| INPUT[i] - x[9 + i]);
        let rate = std::array::from_fn(|i| INPUT[3 + i] - x[12 + i]);
        let trig = Trig::new(&att);
        let found = KinematicsJacobian::new(&vel, &trig, &rate, GRAVITY).dense();
        assert!((found - exact).amax() < ROUNDING * exact.amax());
        let rates = rates(&vel, &trig, &force, &rate, &[x[15], x[16], x[17]], GRAVITY);
        for (k, found) in rates.pos.into_iter().chain(rates.vel).chain(rates.att).enumerate() {
            assert!((found - value[k]).abs() < ROUNDING * value.amax(), "{k}");
        }
    }

    #[test]
    fn navigation_jacobian_matches_dual_numbers() {
        let x = SVector::from(POINT);
        let (value, exact) = num_dual::jacobian(|x| h(&x), &x);
        let trig = Trig::new(&[x[6], x[7], x[8]]);
        let model = Observation::new(&[x[3], x[4], x[5]], &trig, &[x[15], x[16], x[17]]);
        assert!((model.dense() - exact).amax() < ROUNDING * exact.amax());
        for i in 0..3 {
            assert!((model.ground[i] - value[3 + i]).abs() < ROUNDING * value.amax());
            assert!((model.air[i] - value[9 + i]).abs() < ROUNDING * value.amax());
        }
    }

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
