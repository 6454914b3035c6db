//! Whole matrices of the block forms, where speed does not matter.

use nalgebra::SMatrix;

use super::blocks::Block;
use super::covariance::{ACC, ATT, GYR, POS, VEL, WIND};
use super::kernel::{AIR, ATTITUDE, GROUND, POSITION};
use super::kinematics::{KinematicsJacobian, Observation};
use super::layout::{MEASUREMENTS, STATES};
use super::transition::Transition;

/// Square matrix over the states.
pub type Dense = SMatrix<f64, STATES, STATES>;

/// Writes `block` at block (`row`, `column`).
fn put<const R: usize>(matrix: &mut SMatrix<f64, R, STATES>, row: usize, column: usize, block: &Block<f64>) {
    for i in 0..3 {
        for j in 0..3 {
            matrix[(3 * row + i, 3 * column + j)] = block[i][j];
        }
    }
}

/// `factor` times the identity.
fn identity(factor: f64) -> Block<f64> {
    [[factor, 0.0, 0.0], [0.0, factor, 0.0], [0.0, 0.0, factor]]
}

impl KinematicsJacobian<f64> {
    /// The whole matrix F.
    pub fn dense(&self) -> Dense {
        let [p, q, r] = self.rate;
        let mut f = Dense::zeros();
        put(&mut f, POS, VEL, &self.pos_vel);
        put(&mut f, POS, ATT, &self.pos_att);
        put(&mut f, POS, WIND, &identity(1.0));
        put(&mut f, VEL, VEL, &[[0.0, r, -q], [-r, 0.0, p], [q, -p, 0.0]]);
        put(&mut f, VEL, ATT, &self.vel_att);
        put(&mut f, VEL, ACC, &identity(-1.0));
        put(&mut f, VEL, GYR, &self.vel_gyr);
        put(&mut f, ATT, ATT, &self.att_att);
        put(&mut f, ATT, GYR, &self.att_gyr);
        f
    }
}

impl Observation<f64> {
    /// The whole measurement matrix H.
    pub fn dense(&self) -> SMatrix<f64, MEASUREMENTS, STATES> {
        let mut h = SMatrix::zeros();
        put(&mut h, POSITION, POS, &identity(1.0));
        put(&mut h, GROUND, VEL, &self.ground_vel);
        put(&mut h, GROUND, ATT, &self.ground_att);
        put(&mut h, GROUND, WIND, &identity(1.0));
        put(&mut h, ATTITUDE, ATT, &identity(1.0));
        put(&mut h, AIR, VEL, &self.air_vel);
        h
    }
}

impl Transition<f64> {
    /// The whole matrix Phi.
    pub fn dense(&self) -> Dense {
        let mut phi = Dense::identity();
        put(&mut phi, POS, VEL, &self.pos_vel);
        put(&mut phi, POS, ATT, &self.pos_att);
        put(&mut phi, POS, ACC, &self.pos_acc);
        put(&mut phi, POS, GYR, &self.pos_gyr);
        put(&mut phi, POS, WIND, &identity(self.dt));
        put(&mut phi, VEL, VEL, &self.vel_vel);
        put(&mut phi, VEL, ATT, &self.vel_att);
        put(&mut phi, VEL, ACC, &self.vel_acc);
        put(&mut phi, VEL, GYR, &self.vel_gyr);
        put(&mut phi, ATT, ATT, &self.att_att);
        put(&mut phi, ATT, GYR, &self.att_gyr);
        phi
    }
}
