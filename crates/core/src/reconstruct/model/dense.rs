//! The Jacobians F and H and the transition Phi as whole matrices, where speed does not matter.

use nalgebra::SMatrix;

use crate::reconstruct::model::kinematics::KinematicsJacobian;
use crate::reconstruct::model::layout::{
    ACC, AIR, ATT, ATTITUDE, GROUND, GYR, MEASUREMENTS, POS, POSITION, STATES, VEL, WIND,
};
use crate::reconstruct::model::measurement::MeasurementModel;
use crate::reconstruct::model::transition::Transition;
use crate::reconstruct::numeric::mat3::{Mat3, scaled_identity};

/// Square matrix over the states.
pub(crate) type StateMatrix = SMatrix<f64, STATES, STATES>;

/// Writes `block` at block (`row`, `column`).
fn put<const R: usize>(matrix: &mut SMatrix<f64, R, STATES>, row: usize, column: usize, block: &Mat3<f64>) {
    for i in 0..3 {
        for j in 0..3 {
            matrix[(3 * row + i, 3 * column + j)] = block[i][j];
        }
    }
}

impl KinematicsJacobian<f64> {
    /// The whole matrix F.
    pub fn dense(&self) -> StateMatrix {
        let [p, q, r] = self.rate;
        let mut f = StateMatrix::zeros();
        put(&mut f, POS, VEL, &self.pos_vel);
        put(&mut f, POS, ATT, &self.pos_att);
        put(&mut f, POS, WIND, &scaled_identity(1.0));
        put(&mut f, VEL, VEL, &[[0.0, r, -q], [-r, 0.0, p], [q, -p, 0.0]]);
        put(&mut f, VEL, ATT, &self.vel_att);
        put(&mut f, VEL, ACC, &scaled_identity(-1.0));
        put(&mut f, VEL, GYR, &self.vel_gyr);
        put(&mut f, ATT, ATT, &self.att_att);
        put(&mut f, ATT, GYR, &self.att_gyr);
        f
    }
}

impl MeasurementModel<f64> {
    /// The whole measurement matrix H.
    pub fn dense(&self) -> SMatrix<f64, MEASUREMENTS, STATES> {
        let mut h = SMatrix::zeros();
        put(&mut h, POSITION, POS, &scaled_identity(1.0));
        put(&mut h, GROUND, VEL, &self.ground_vel);
        put(&mut h, GROUND, ATT, &self.ground_att);
        put(&mut h, GROUND, WIND, &scaled_identity(1.0));
        put(&mut h, ATTITUDE, ATT, &scaled_identity(1.0));
        put(&mut h, AIR, VEL, &self.air_vel);
        h
    }
}

impl Transition<f64> {
    /// The whole matrix Phi.
    pub fn dense(&self) -> StateMatrix {
        let mut phi = StateMatrix::identity();
        put(&mut phi, POS, VEL, &self.pos_vel);
        put(&mut phi, POS, ATT, &self.pos_att);
        put(&mut phi, POS, ACC, &self.pos_acc);
        put(&mut phi, POS, GYR, &self.pos_gyr);
        put(&mut phi, POS, WIND, &scaled_identity(self.dt));
        put(&mut phi, VEL, VEL, &self.vel_vel);
        put(&mut phi, VEL, ATT, &self.vel_att);
        put(&mut phi, VEL, ACC, &self.vel_acc);
        put(&mut phi, VEL, GYR, &self.vel_gyr);
        put(&mut phi, ATT, ATT, &self.att_att);
        put(&mut phi, ATT, GYR, &self.att_gyr);
        phi
    }
}

#[cfg(test)]
mod tests {
    use nalgebra::SVector;
    use num_dual::DualNum;

    use super::*;
    use crate::reconstruct::model::kinematics::{Trig, rates};

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
        let (value, exact): (_, StateMatrix) = num_dual::jacobian(|x| f(&x), &x);
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
        let model = MeasurementModel::new(&[x[3], x[4], x[5]], &trig, &[x[15], x[16], x[17]]);
        assert!((model.dense() - exact).amax() < ROUNDING * exact.amax());
        for i in 0..3 {
            assert!((model.ground[i] - value[3 + i]).abs() < ROUNDING * value.amax());
            assert!((model.air[i] - value[9 + i]).abs() < ROUNDING * value.amax());
        }
    }
}
