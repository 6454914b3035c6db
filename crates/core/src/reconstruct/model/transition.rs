//! Discrete transition over one step: state by Runge-Kutta, Jacobian by the exponential series to third order.

use crate::reconstruct::model::kinematics::{KinematicsJacobian, Rates, Trig, rates};
use crate::reconstruct::model::layout::{ACC, ATT, GROUPS, GYR, POS, VEL, WIND};
use crate::reconstruct::numeric::mat3::{
    Mat3, add_product, add_times, cross, cross_squared, inverse, product, scaled, scaled_identity, sum, zeros,
};
use crate::reconstruct::numeric::real::Real;
use crate::reconstruct::numeric::vec3::{Vec3, add_scaled, difference};

/// Specific force, m/s^2, and angular rate, rad/s, at the two ends of a step, as measured.
#[derive(Clone, Copy)]
pub struct Inputs<T> {
    /// At the start: specific force, angular rate.
    pub start: [Vec3<T>; 2],
    pub end: [Vec3<T>; 2],
}

impl<T: Real> Inputs<T> {
    /// Halfway, which is also the mean over the step.
    #[inline(always)]
    pub fn middle(&self) -> [Vec3<T>; 2] {
        let mut middle = self.start;
        for s in 0..2 {
            for i in 0..3 {
                middle[s][i] = (self.start[s][i] + self.end[s][i]) * T::splat(0.5);
            }
        }
        middle
    }
}

/// The states that move: position, velocity, attitude.
#[derive(Clone, Copy)]
pub struct Motion<T> {
    /// Position, NED, m.
    pub pos: Vec3<T>,
    /// Velocity relative to the air, body axes, m/s.
    pub vel: Vec3<T>,
    /// Bank, pitch, heading, rad.
    pub att: Vec3<T>,
}

impl<T: Real> Motion<T> {
    #[inline(always)]
    fn advanced(&self, rates: &Rates<T>, dt: T) -> Self {
        Self {
            pos: add_scaled(&self.pos, &rates.pos, dt),
            vel: add_scaled(&self.vel, &rates.vel, dt),
            att: add_scaled(&self.att, &rates.att, dt),
        }
    }
}

/// What does not change over a step: biases of accelerometers and gyros, wind, gravity.
#[derive(Clone, Copy)]
pub struct Constants<T> {
    /// Accelerometer biases, m/s^2.
    pub bias_acc: Vec3<T>,
    /// Gyro biases, rad/s.
    pub bias_gyr: Vec3<T>,
    /// Wind, NED, m/s.
    pub wind: Vec3<T>,
    /// Gravity, m/s^2.
    pub gravity: T,
}

impl<T: Real> Constants<T> {
    #[inline(always)]
    fn rates(&self, motion: &Motion<T>, trig: &Trig<T>, measured: &[Vec3<T>; 2]) -> Rates<T> {
        let force = difference(&measured[0], &self.bias_acc);
        let rate = difference(&measured[1], &self.bias_gyr);
        rates(&motion.vel, trig, &force, &rate, &self.wind, self.gravity)
    }
}

/// Motion after `dt` by the classical Runge-Kutta scheme of order four (thesis Eq. D.4), input linear over the step.
#[inline(always)]
pub fn integrate<T: Real>(
    start: &Motion<T>,
    trig: &Trig<T>,
    constants: &Constants<T>,
    inputs: &Inputs<T>,
    dt: T,
) -> Motion<T> {
    let half = dt * T::splat(0.5);
    let middle = inputs.middle();
    let k1 = constants.rates(start, trig, &inputs.start);
    let stage = start.advanced(&k1, half);
    let k2 = constants.rates(&stage, &trig.turned(&start.att, &stage.att), &middle);
    let stage = start.advanced(&k2, half);
    let k3 = constants.rates(&stage, &trig.turned(&start.att, &stage.att), &middle);
    let stage = start.advanced(&k3, dt);
    let k4 = constants.rates(&stage, &trig.turned(&start.att, &stage.att), &inputs.end);
    let (sixth, third) = (dt * T::splat(1.0 / 6.0), dt * T::splat(1.0 / 3.0));
    start.advanced(&k1, sixth).advanced(&k2, third).advanced(&k3, third).advanced(&k4, sixth)
}

/// Predicts the state over one step of length `dt`, s; returns the transition and sines and cosines of the predicted attitude.
/// F is taken at the state before the step, or at the predicted one if `at_prediction`, and the mean of the inputs.
#[inline(always)]
pub(crate) fn predict_state<T: Real>(
    x: &mut [Vec3<T>; GROUPS],
    inputs: &Inputs<T>,
    dt: T,
    gravity: T,
    at_prediction: bool,
) -> (Transition<T>, Trig<T>) {
    let prior = Motion { pos: x[POS], vel: x[VEL], att: x[ATT] };
    let trig = Trig::new(&prior.att);
    let constants = Constants { bias_acc: x[ACC], bias_gyr: x[GYR], wind: x[WIND], gravity };
    let predicted = integrate(&prior, &trig, &constants, inputs, dt);
    let predicted_trig = trig.turned(&prior.att, &predicted.att);

    let rate = difference(&inputs.middle()[1], &x[GYR]);
    let (vel, at_trig) = if at_prediction { (predicted.vel, predicted_trig) } else { (prior.vel, trig) };
    let phi = Transition::new(&KinematicsJacobian::new(&vel, &at_trig, &rate, gravity), dt);
    (x[POS], x[VEL], x[ATT]) = (predicted.pos, predicted.vel, predicted.att);
    (phi, predicted_trig)
}

/// Blocks of the transition matrix Phi = I + F dt + F^2 dt^2/2 + F^3 dt^3/6 that are neither zero nor identity;
/// position by wind is `dt I`. The bias columns are also the noise input matrix Gamma = (integral of exp(F s) ds) G,
/// because noise enters where the biases do.
#[derive(Clone, Copy)]
pub struct Transition<T> {
    /// Length of the step, s.
    pub dt: T,
    /// Position by velocity.
    pub pos_vel: Mat3<T>,
    /// Position by attitude.
    pub pos_att: Mat3<T>,
    /// Position by accelerometer bias.
    pub pos_acc: Mat3<T>,
    /// Position by gyro bias.
    pub pos_gyr: Mat3<T>,
    /// Velocity by velocity.
    pub vel_vel: Mat3<T>,
    /// Velocity by attitude.
    pub vel_att: Mat3<T>,
    /// Velocity by accelerometer bias.
    pub vel_acc: Mat3<T>,
    /// Velocity by gyro bias.
    pub vel_gyr: Mat3<T>,
    /// Attitude by attitude.
    pub att_att: Mat3<T>,
    /// Attitude by gyro bias.
    pub att_gyr: Mat3<T>,
}

impl<T: Real> Transition<T> {
    /// Over no time: the identity.
    #[inline(always)]
    pub fn identity() -> Self {
        let (identity, zero) = (scaled_identity(T::splat(1.0)), zeros());
        Self {
            dt: T::zero(),
            pos_vel: zero,
            pos_att: zero,
            pos_acc: zero,
            pos_gyr: zero,
            vel_vel: identity,
            vel_att: zero,
            vel_acc: zero,
            vel_gyr: zero,
            att_att: identity,
            att_gyr: zero,
        }
    }

    /// Over `dt` with the Jacobian `f` constant.
    #[inline(always)]
    pub fn new(f: &KinematicsJacobian<T>, dt: T) -> Self {
        let dt2 = dt * dt * T::splat(0.5);
        let dt3 = dt * dt * dt * T::splat(1.0 / 6.0);
        let identity = scaled_identity(T::splat(1.0));
        let turned = [-f.rate[0], -f.rate[1], -f.rate[2]];
        let (m, m_squared) = (cross(&turned), cross_squared(&turned));
        let (n, e) = (&f.vel_att, &f.att_att);

        // First and second integrals of the exponentials of M = velocity' by velocity and E = attitude' by attitude.
        let m1 = add_scaled_blocks(&add_scaled_blocks(&scaled_identity(dt), &m, dt2), &m_squared, dt3);
        let m2 = add_scaled_blocks(&scaled_identity(dt2), &m, dt3);
        let e2 = add_scaled_blocks(&scaled_identity(dt2), e, dt3);
        let e1 = add_product(&scaled_identity(dt), e, &e2);
        // Second integral of velocity by attitude: N dt^2/2 + (M N + N E) dt^3/6.
        let n2 = sum(&product(&m2, n), &scaled(&product(n, e), dt3));
        // First integral: N dt + (M N + N E) dt^2/2 + (M M N + M N E + N E E) dt^3/6.
        let vel_att = add_product(&product(&m1, n), &n2, e);

        let noise = product(n, &f.att_gyr);
        let vel_gyr = add_product(&product(&m1, &f.vel_gyr), &n2, &f.att_gyr);
        let fall = add_scaled_blocks(&product(&m2, &f.vel_gyr), &noise, dt3);
        let e2_gyr = product(&e2, &f.att_gyr);
        Self {
            dt,
            pos_vel: product(&f.pos_vel, &m1),
            pos_att: add_product(&product(&f.pos_att, &e1), &f.pos_vel, &n2),
            pos_acc: scaled(&product(&f.pos_vel, &m2), T::splat(-1.0)),
            pos_gyr: add_product(&product(&f.pos_vel, &fall), &f.pos_att, &e2_gyr),
            vel_vel: add_product(&identity, &m, &m1),
            vel_att,
            vel_acc: scaled(&m1, T::splat(-1.0)),
            vel_gyr,
            att_att: add_product(&identity, e, &e1),
            att_gyr: product(&e1, &f.att_gyr),
        }
    }

    /// Blocks of the inverse matrix in the same places. Its factors apply in the opposite order: see
    /// `Covariance::propagate_back` of the packed form.
    #[inline(always)]
    pub fn inverse(&self) -> Self {
        let minus = T::splat(-1.0);
        let vel_vel = inverse(&self.vel_vel);
        let att_att = inverse(&self.att_att);
        let (vel_minus, att_minus) = (scaled(&vel_vel, minus), scaled(&att_att, minus));
        Self {
            dt: -self.dt,
            pos_vel: scaled(&self.pos_vel, minus),
            pos_att: scaled(&self.pos_att, minus),
            pos_acc: scaled(&self.pos_acc, minus),
            pos_gyr: scaled(&self.pos_gyr, minus),
            vel_vel,
            vel_att: product(&vel_minus, &self.vel_att),
            vel_acc: product(&vel_minus, &self.vel_acc),
            vel_gyr: product(&vel_minus, &self.vel_gyr),
            att_att,
            att_gyr: product(&att_minus, &self.att_gyr),
        }
    }

    /// `Phi^-1 d` for a vector, where `self` holds the blocks of [`Transition::inverse`].
    #[inline(always)]
    pub(crate) fn apply_back(&self, d: &[Vec3<T>; GROUPS]) -> [Vec3<T>; GROUPS] {
        let mut x = *d;
        let zero = [T::zero(); 3];
        x[ATT] = add_times(&add_times(&zero, &self.att_att, &d[ATT]), &self.att_gyr, &d[GYR]);
        let vel = add_times(&add_times(&zero, &self.vel_vel, &d[VEL]), &self.vel_att, &x[ATT]);
        x[VEL] = add_times(&add_times(&vel, &self.vel_acc, &d[ACC]), &self.vel_gyr, &d[GYR]);
        let pos = add_times(&add_scaled(&d[POS], &d[WIND], self.dt), &self.pos_vel, &x[VEL]);
        let pos = add_times(&add_times(&pos, &self.pos_att, &x[ATT]), &self.pos_acc, &d[ACC]);
        x[POS] = add_times(&pos, &self.pos_gyr, &d[GYR]);
        x
    }
}

/// `a + factor b`.
#[inline(always)]
fn add_scaled_blocks<T: Real>(a: &Mat3<T>, b: &Mat3<T>, factor: T) -> Mat3<T> {
    [add_scaled(&a[0], &b[0], factor), add_scaled(&a[1], &b[1], factor), add_scaled(&a[2], &b[2], factor)]
}
