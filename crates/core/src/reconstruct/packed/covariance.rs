//! Covariance P of the eighteen states as the lower triangle of 3 x 3 blocks, changed in place.

use crate::reconstruct::model::layout::{ACC, ATT, GROUPS, GYR, POS, VEL, WIND};
use crate::reconstruct::model::transition::Transition;
use crate::reconstruct::numeric::mat3::{
    Mat3, add_product, add_product_transposed, product, scaled, scaled_columns, scaled_rows,
    subtract_product_transposed, sum, transposed, zeros,
};
use crate::reconstruct::numeric::real::Real;
use crate::reconstruct::numeric::vec3::Vec3;

/// Number of blocks in the lower triangle.
pub(crate) const BLOCKS: usize = GROUPS * (GROUPS + 1) / 2;

/// Symmetric 18 x 18 matrix; diagonal blocks are held whole.
#[derive(Clone, Copy)]
pub struct Covariance<T> {
    /// Lower triangle, block row by block row.
    pub blocks: [Mat3<T>; BLOCKS],
}

/// Index of block (`row`, `column`) of the lower triangle.
#[inline(always)]
pub const fn at(row: usize, column: usize) -> usize {
    row * (row + 1) / 2 + column
}

impl<T: Real> Covariance<T> {
    pub fn diagonal(variances: &[Vec3<T>; GROUPS]) -> Self {
        let mut blocks = [zeros(); BLOCKS];
        for g in 0..GROUPS {
            for i in 0..3 {
                blocks[at(g, g)][i][i] = variances[g][i];
            }
        }
        Self { blocks }
    }

    /// Block (`row`, `column`) of the whole matrix.
    #[inline(always)]
    pub fn block(&self, row: usize, column: usize) -> Mat3<T> {
        if row >= column { self.blocks[at(row, column)] } else { transposed(&self.blocks[at(column, row)]) }
    }

    /// Variances of group `g`.
    #[inline(always)]
    pub fn variances(&self, g: usize) -> Vec3<T> {
        let block = &self.blocks[at(g, g)];
        [block[0][0], block[1][1], block[2][2]]
    }

    #[inline(always)]
    pub(crate) fn all_variances(&self) -> [Vec3<T>; GROUPS] {
        let mut variances = [[T::zero(); 3]; GROUPS];
        for g in 0..GROUPS {
            variances[g] = self.variances(g);
        }
        variances
    }

    /// `P <- Phi P Phi' + Gamma Q Gamma'`, with `noise` the variances of specific force and angular rate.
    ///
    /// Phi is the product of three factors that each change the rows of one group, position first: those of velocity
    /// and attitude still hold their old values when position needs them, and so on.
    #[inline(always)]
    pub fn propagate(&mut self, phi: &Transition<T>, noise: &[Vec3<T>; 2]) {
        self.position_rows(phi);
        self.velocity_rows(phi);
        self.attitude_rows(phi);
        self.add_input_noise(phi, noise);
    }

    /// `D <- Phi^-1 D Phi'^-1`, with the blocks of [`Transition::inverse`].
    #[inline(always)]
    pub(crate) fn propagate_back(&mut self, inverse: &Transition<T>) {
        self.attitude_rows(inverse);
        self.velocity_rows(inverse);
        self.position_rows(inverse);
    }

    /// Position: `pos + pos_vel vel + pos_att att + pos_acc acc + pos_gyr gyr + dt wind`.
    #[inline(always)]
    fn position_rows(&mut self, phi: &Transition<T>) {
        let mut rows = [zeros(); GROUPS];
        for j in 0..GROUPS {
            let mut row = sum(&self.block(POS, j), &scaled(&self.block(WIND, j), phi.dt));
            row = add_product(&row, &phi.pos_vel, &self.block(VEL, j));
            row = add_product(&row, &phi.pos_att, &self.block(ATT, j));
            row = add_product(&row, &phi.pos_acc, &self.block(ACC, j));
            rows[j] = add_product(&row, &phi.pos_gyr, &self.block(GYR, j));
        }
        let mut own = sum(&rows[POS], &scaled(&rows[WIND], phi.dt));
        own = add_product_transposed(&own, &rows[VEL], &phi.pos_vel);
        own = add_product_transposed(&own, &rows[ATT], &phi.pos_att);
        own = add_product_transposed(&own, &rows[ACC], &phi.pos_acc);
        rows[POS] = add_product_transposed(&own, &rows[GYR], &phi.pos_gyr);
        self.set_rows(POS, &rows);
    }

    /// Velocity: `vel_vel vel + vel_att att + vel_acc acc + vel_gyr gyr`.
    #[inline(always)]
    fn velocity_rows(&mut self, phi: &Transition<T>) {
        let mut rows = [zeros(); GROUPS];
        for j in 0..GROUPS {
            let mut row = product(&phi.vel_vel, &self.block(VEL, j));
            row = add_product(&row, &phi.vel_att, &self.block(ATT, j));
            row = add_product(&row, &phi.vel_acc, &self.block(ACC, j));
            rows[j] = add_product(&row, &phi.vel_gyr, &self.block(GYR, j));
        }
        let mut own = add_product_transposed(&zeros(), &rows[VEL], &phi.vel_vel);
        own = add_product_transposed(&own, &rows[ATT], &phi.vel_att);
        own = add_product_transposed(&own, &rows[ACC], &phi.vel_acc);
        rows[VEL] = add_product_transposed(&own, &rows[GYR], &phi.vel_gyr);
        self.set_rows(VEL, &rows);
    }

    /// Attitude: `att_att att + att_gyr gyr`.
    #[inline(always)]
    fn attitude_rows(&mut self, phi: &Transition<T>) {
        let mut rows = [zeros(); GROUPS];
        for j in 0..GROUPS {
            let row = product(&phi.att_att, &self.block(ATT, j));
            rows[j] = add_product(&row, &phi.att_gyr, &self.block(GYR, j));
        }
        let own = add_product_transposed(&zeros(), &rows[ATT], &phi.att_att);
        rows[ATT] = add_product_transposed(&own, &rows[GYR], &phi.att_gyr);
        self.set_rows(ATT, &rows);
    }

    /// Replaces the rows and columns of group `g`, of which `rows[g]` is made symmetric.
    #[inline(always)]
    fn set_rows(&mut self, g: usize, rows: &[Mat3<T>; GROUPS]) {
        for j in 0..g {
            self.blocks[at(g, j)] = rows[j];
        }
        self.blocks[at(g, g)] = lower_mirrored(&rows[g]);
        for j in g + 1..GROUPS {
            self.blocks[at(j, g)] = transposed(&rows[j]);
        }
    }

    /// `Gamma Q Gamma'`, where the rows of Gamma are the bias columns of the transition.
    #[inline(always)]
    fn add_input_noise(&mut self, phi: &Transition<T>, noise: &[Vec3<T>; 2]) {
        let acc = [phi.pos_acc, phi.vel_acc];
        let gyr = [phi.pos_gyr, phi.vel_gyr, phi.att_gyr];
        for i in 0..3 {
            let noisy_gyr = scaled_columns(&gyr[i], &noise[1]);
            for j in 0..=i {
                let block = &mut self.blocks[at(i, j)];
                *block = add_product_transposed(block, &noisy_gyr, &gyr[j]);
            }
        }
        for i in 0..2 {
            let noisy_acc = scaled_columns(&acc[i], &noise[0]);
            for j in 0..=i {
                let block = &mut self.blocks[at(i, j)];
                *block = add_product_transposed(block, &noisy_acc, &acc[j]);
            }
        }
        for g in [POS, VEL, ATT] {
            self.blocks[at(g, g)] = lower_mirrored(&self.blocks[at(g, g)]);
        }
    }

    #[inline(always)]
    pub(crate) fn add_diagonal(&mut self, variances: &[Vec3<T>; GROUPS], factor: T) {
        for g in 0..GROUPS {
            for i in 0..3 {
                let entry = &mut self.blocks[at(g, g)][i][i];
                *entry = variances[g][i].mul_add(factor, *entry);
            }
        }
    }

    /// Adds the covariance of a change of wind with variance rates `walk` over `dt` to that of a wind walk already on the diagonal: the
    /// wind changes by dW, the velocity relative to the air by `-C' dW`, the velocity over ground not at all. `c` is C, NED from body.
    #[inline(always)]
    pub(crate) fn add_wind_change(&mut self, walk: &Vec3<T>, dt: T, c: &Mat3<T>) {
        let variances = [walk[0] * dt, walk[1] * dt, walk[2] * dt];
        let weighted = scaled_rows(c, &variances);
        let cross = &mut self.blocks[at(WIND, VEL)];
        *cross = sum(cross, &scaled(&weighted, T::splat(-1.0)));
        let own = add_product(&self.blocks[at(VEL, VEL)], &transposed(c), &weighted);
        self.blocks[at(VEL, VEL)] = lower_mirrored(&own);
    }

    /// `P <- P - W W'` with six whitened columns, in two blocks per group. Diagonal blocks stay symmetric to the bit.
    #[inline(always)]
    pub(crate) fn subtract_square(&mut self, whitened: &[[Mat3<T>; 2]; GROUPS]) {
        for i in 0..GROUPS {
            for j in 0..=i {
                let block = &self.blocks[at(i, j)];
                let block = subtract_product_transposed(block, &whitened[i][0], &whitened[j][0]);
                self.blocks[at(i, j)] = subtract_product_transposed(&block, &whitened[i][1], &whitened[j][1]);
            }
        }
    }
}

/// The block with its lower triangle mirrored to the upper.
#[inline(always)]
fn lower_mirrored<T: Real>(a: &Mat3<T>) -> Mat3<T> {
    [[a[0][0], a[1][0], a[2][0]], [a[1][0], a[1][1], a[2][1]], [a[2][0], a[2][1], a[2][2]]]
}
