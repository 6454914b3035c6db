//! Rauch-Tung-Striebel smoother on the structured form.
//!
//! With the process noise `N = Gamma Q Gamma'` and `P- = Phi P+ Phi' + N` the gain `G = P+ Phi' (P-)^-1` is
//! `Phi^-1 (I - N (P-)^-1)`. So it takes one Cholesky factorisation and as many right-hand sides as there are noises,
//! no product of whole matrices, and the rows of states without noise are the identity: a bias without random walk comes
//! back constant.

use super::blocks::{
    Block, Factor, Vec3, add_product, add_times, difference, product, scaled, scaled_columns, scaled_identity,
    subtract_product_transposed, subtract_times, sum, transposed, zeros,
};
use super::covariance::{ATT, BLOCKS, Covariance, GROUPS, POS, VEL, at};
use super::kernel::{Estimate, Step, Tuning};
use super::lanes::Lanes;
use super::real::Real;
use super::transition::Transition;

/// Six groups of rows and one group of columns.
type Columns<T> = [Block<T>; GROUPS];

/// Most groups of noises: two of the inputs and a random walk on every group of states.
const NOISES: usize = 2 + GROUPS;

/// What the backward pass needs of one step.
#[derive(Clone, Copy)]
pub struct Kept<T> {
    /// Estimate before the step.
    pub before: Estimate<T>,
    /// Transition over it.
    pub phi: Transition<T>,
    /// Prediction at its end.
    pub predicted: Estimate<T>,
}

/// One step backwards: `smoothed` at the end of the step becomes `smoothed` at its start,
/// `x + G (xs - x-)` and `P + G (Ps - P-) G'` (Rauch, Tung & Striebel 1965). Returns what [`take_noise_out`] does.
#[inline(always)]
pub fn smooth_step<T: Lanes>(
    smoothed: &mut Estimate<T>,
    kept: &Kept<T>,
    step: &Step<T>,
    tuning: &Tuning<T>,
) -> [Vec3<T>; 2] {
    let mut d = smoothed.x;
    for g in 0..GROUPS {
        d[g] = difference(&smoothed.x[g], &kept.predicted.x[g]);
    }
    for b in 0..BLOCKS {
        for i in 0..3 {
            for j in 0..3 {
                smoothed.p.blocks[b][i][j] = smoothed.p.blocks[b][i][j] - kept.predicted.p.blocks[b][i][j];
            }
        }
    }
    let process = T::take_noise_out(&mut d, &mut smoothed.p, kept, step, tuning);
    let back = kept.phi.inverse();
    T::propagate_back(&mut smoothed.p, &back);
    let moved = back.apply_back(&d);
    for g in 0..GROUPS {
        for i in 0..3 {
            smoothed.x[g][i] = kept.before.x[g][i] + moved[g][i];
        }
    }
    for b in 0..BLOCKS {
        for i in 0..3 {
            for j in 0..3 {
                smoothed.p.blocks[b][i][j] = smoothed.p.blocks[b][i][j] + kept.before.p.blocks[b][i][j];
            }
        }
    }
    process
}

/// `d <- A d` and `D <- A D A'` with `A = I - Gamma Q Y'`, `Y = (P-)^-1 Gamma`.
///
/// Returns the expected square of each process noise w given all measurements, in terms of Q of whole samples: with
/// `d = xs - x-` and `D = Ps - P-` it is `E[w^2] = (Q Y' d)^2 + diag(Q + Q Y' D Y Q)`. That is the textbook form with the
/// lag-one covariance `Ps G'` (Shumway & Stoffer 1982), projected on the columns of Gamma.
#[inline(always)]
pub fn take_noise_out<T: Real>(
    d: &mut [Vec3<T>; GROUPS],
    big_d: &mut Covariance<T>,
    kept: &Kept<T>,
    step: &Step<T>,
    tuning: &Tuning<T>,
) -> [Vec3<T>; 2] {
    let factor = CovarianceFactor::new(&kept.predicted.p);
    let mut noise = [[zeros(); GROUPS]; NOISES]; // U = Gamma Q
    let mut solved = [[zeros(); GROUPS]; NOISES]; // Y
    let mut seen = [[zeros(); GROUPS]; NOISES]; // D Y
    let mut count = 0;
    for c in 0..NOISES {
        let Some((gamma, variances)) = noise_columns(c, kept, step, tuning) else { continue };
        solved[count] = factor.solve(&gamma);
        for g in 0..GROUPS {
            noise[count][g] = scaled_columns(&gamma[g], &variances);
        }
        for g in 0..GROUPS {
            let mut row = zeros();
            for k in 0..GROUPS {
                row = add_product(&row, &big_d.block(g, k), &solved[count][k]);
            }
            seen[count][g] = row;
        }
        count += 1;
    }

    let old = *d;
    let mut squares = tuning.process;
    for c in 0..count {
        let mut along = [T::zero(); 3];
        for g in 0..GROUPS {
            along = add_times(&along, &transposed(&solved[c][g]), &old[g]);
        }
        if c < 2 {
            for i in 0..3 {
                squares[c][i] = along[i] * along[i];
            }
        }
        for g in 0..GROUPS {
            d[g] = subtract_times(&d[g], &noise[c][g], &along);
        }
    }

    // E = D Y - U (Y' D Y) / 2, so that A D A' = D - U E' - E U'
    let half = T::splat(-0.5);
    let mut e = seen;
    for c in 0..count {
        for b in 0..count {
            let mut quadratic = zeros();
            for g in 0..GROUPS {
                quadratic = add_product(&quadratic, &transposed(&solved[b][g]), &seen[c][g]);
            }
            if b == c && c < 2 {
                for i in 0..3 {
                    let q = tuning.process[c][i];
                    let gained = (squares[c][i] + quadratic[i][i]) * q * step.noise_scale;
                    squares[c][i] = gained.mul_add(q, q);
                }
            }
            let quadratic = scaled(&quadratic, half);
            for g in 0..GROUPS {
                e[c][g] = add_product(&e[c][g], &noise[b][g], &quadratic);
            }
        }
    }
    for i in 0..GROUPS {
        for j in 0..=i {
            let mut block = big_d.blocks[at(i, j)];
            for c in 0..count {
                block = subtract_product_transposed(&block, &noise[c][i], &e[c][j]);
                block = subtract_product_transposed(&block, &e[c][i], &noise[c][j]);
            }
            big_d.blocks[at(i, j)] = block;
        }
    }
    squares
}

/// Columns of Gamma of the `c`-th group of noises and their variances: accelerometers, gyros, then the random walk of
/// each group of states, if it has one.
#[inline(always)]
fn noise_columns<T: Real>(
    c: usize,
    kept: &Kept<T>,
    step: &Step<T>,
    tuning: &Tuning<T>,
) -> Option<(Columns<T>, Vec3<T>)> {
    let mut gamma = [zeros(); GROUPS];
    if c < 2 {
        let phi = &kept.phi;
        (gamma[POS], gamma[VEL], gamma[ATT]) =
            if c == 0 { (phi.pos_acc, phi.vel_acc, zeros()) } else { (phi.pos_gyr, phi.vel_gyr, phi.att_gyr) };
        let q = tuning.process[c];
        return Some((gamma, [q[0] * step.noise_scale, q[1] * step.noise_scale, q[2] * step.noise_scale]));
    }
    let walk = tuning.random_walk[c - 2];
    if !(walk[0] + walk[1] + walk[2]).any_above(T::zero()) {
        return None;
    }
    gamma[c - 2] = scaled_identity(T::splat(1.0));
    Some((gamma, [walk[0] * step.dt, walk[1] * step.dt, walk[2] * step.dt]))
}

/// Cholesky factor of the whole covariance, block by block.
struct CovarianceFactor<T> {
    diagonal: [Factor<T>; GROUPS],
    /// Blocks below the diagonal, in their place of the lower triangle.
    below: [Block<T>; BLOCKS],
}

impl<T: Real> CovarianceFactor<T> {
    #[inline(always)]
    fn new(p: &Covariance<T>) -> Self {
        let mut below = p.blocks;
        let mut diagonal = [Factor::new(&p.blocks[at(0, 0)]); GROUPS];
        for j in 0..GROUPS {
            let mut own = p.blocks[at(j, j)];
            for k in 0..j {
                own = subtract_product_transposed(&own, &below[at(j, k)], &below[at(j, k)]);
            }
            diagonal[j] = Factor::new(&own);
            for i in j + 1..GROUPS {
                let mut block = p.blocks[at(i, j)];
                for k in 0..j {
                    block = subtract_product_transposed(&block, &below[at(i, k)], &below[at(j, k)]);
                }
                below[at(i, j)] = diagonal[j].whiten_rows(&block);
            }
        }
        Self { diagonal, below }
    }

    /// `P^-1 b`.
    #[inline(always)]
    fn solve(&self, b: &Columns<T>) -> Columns<T> {
        let minus = T::splat(-1.0);
        let mut x = *b;
        for i in 0..GROUPS {
            for k in 0..i {
                let known = product(&self.below[at(i, k)], &x[k]);
                x[i] = sum(&x[i], &scaled(&known, minus));
            }
            x[i] = self.diagonal[i].solve(&x[i]);
        }
        for i in (0..GROUPS).rev() {
            for k in i + 1..GROUPS {
                let known = product(&transposed(&self.below[at(k, i)]), &x[k]);
                x[i] = sum(&x[i], &scaled(&known, minus));
            }
            x[i] = self.diagonal[i].solve_transposed(&x[i]);
        }
        x
    }
}
