//! Rauch-Tung-Striebel smoother on the packed form.
//!
//! With the process noise `N = Gamma Q Gamma'` and `P- = Phi P+ Phi' + N` the gain `G = P+ Phi' (P-)^-1` is
//! `Phi^-1 (I - N (P-)^-1)`. So it takes one Cholesky factorisation and as many right-hand sides as there are noises,
//! no product of whole matrices, and the rows of states without noise are the identity: a bias without random walk comes
//! back constant. `smoother::rts` specifies it.

use crate::reconstruct::filter::parameters::FilterParameters;
use crate::reconstruct::filter::step::StepInputs;
use crate::reconstruct::model::kinematics::{Trig, ned_from_body};
use crate::reconstruct::model::layout::{ACC, ATT, GROUPS, GYR, POS, VEL, WIND};
use crate::reconstruct::model::transition::Transition;
use crate::reconstruct::numeric::mat3::{
    Factor, Mat3, add_product, add_times, scaled, scaled_columns, scaled_identity, subtract_product,
    subtract_product_transposed, subtract_times, transposed, zeros,
};
use crate::reconstruct::numeric::real::Real;
use crate::reconstruct::numeric::vec3::{Vec3, difference};
use crate::reconstruct::packed::covariance::{BLOCKS, Covariance, at};
use crate::reconstruct::packed::step::Estimate;

/// The parts of a step backwards, each compiled once for the instructions of a vector by `dispatch`.
pub(crate) trait RtsParts: Real {
    /// [`remove_process_noise`].
    fn remove_process_noise(
        d: &mut [Vec3<Self>; GROUPS],
        big_d: &mut Covariance<Self>,
        workspace: &mut NoiseWorkspace<Self>,
        forward: &ForwardStep<Self>,
        step: &StepInputs<Self>,
        parameters: &FilterParameters<Self>,
    ) -> [Vec3<Self>; 2];

    /// [`Covariance::propagate_back`].
    fn propagate_back(p: &mut Covariance<Self>, inverse: &Transition<Self>);
}

/// Six groups of rows and one group of columns.
type Columns<T> = [Mat3<T>; GROUPS];

/// Most groups of noises: two of the inputs and a random walk on every group of states.
const NOISES: usize = 2 + GROUPS;

/// What the backward pass needs of one step.
#[derive(Clone, Copy)]
pub struct ForwardStep<T> {
    /// Transition over it.
    pub phi: Transition<T>,
    /// Prediction at its end.
    pub predicted: Estimate<T>,
    /// Estimate there with what was measured.
    pub updated: Estimate<T>,
}

/// What a block of steps is smoothed in.
pub struct SmootherMemory<T> {
    /// The steps of the block.
    pub forward: Vec<ForwardStep<T>>,
    /// Of one step.
    pub workspace: Box<NoiseWorkspace<T>>,
}

/// One step backwards from the estimate `before` it: `smoothed` at the end of the step becomes `smoothed` at its start,
/// `x + G (xs - x-)` and `P + G (Ps - P-) G'` (Rauch, Tung & Striebel 1965). Returns what [`remove_process_noise`] does.
#[inline(always)]
pub(crate) fn smooth_step<T: RtsParts>(
    smoothed: &mut Estimate<T>,
    workspace: &mut NoiseWorkspace<T>,
    before: &Estimate<T>,
    forward: &ForwardStep<T>,
    step: &StepInputs<T>,
    parameters: &FilterParameters<T>,
) -> [Vec3<T>; 2] {
    let mut d = smoothed.x;
    for g in 0..GROUPS {
        d[g] = difference(&smoothed.x[g], &forward.predicted.x[g]);
    }
    for b in 0..BLOCKS {
        for i in 0..3 {
            for j in 0..3 {
                smoothed.p.blocks[b][i][j] = smoothed.p.blocks[b][i][j] - forward.predicted.p.blocks[b][i][j];
            }
        }
    }
    let process = T::remove_process_noise(&mut d, &mut smoothed.p, workspace, forward, step, parameters);
    let back = forward.phi.inverse();
    T::propagate_back(&mut smoothed.p, &back);
    let moved = back.apply_back(&d);
    for g in 0..GROUPS {
        for i in 0..3 {
            smoothed.x[g][i] = before.x[g][i] + moved[g][i];
        }
    }
    for b in 0..BLOCKS {
        for i in 0..3 {
            for j in 0..3 {
                smoothed.p.blocks[b][i][j] = smoothed.p.blocks[b][i][j] + before.p.blocks[b][i][j];
            }
        }
    }
    process
}

/// Working space of [`remove_process_noise`], made once for many steps: what each group of noises is and does.
pub struct NoiseWorkspace<T> {
    /// Groups of states that the noise enters: from, to without.
    rows: [(usize, usize); NOISES],
    /// `U = Gamma Q`, in these rows.
    noise: [Columns<T>; NOISES],
    /// `Y = (P-)^-1 Gamma`.
    solved: [Columns<T>; NOISES],
    /// `D Y`, then E.
    e: [Columns<T>; NOISES],
    /// `-Y' D Y / 2` of each pair.
    quadratic: [[Mat3<T>; NOISES]; NOISES],
}

impl<T: Real> NoiseWorkspace<T> {
    /// Zeros.
    pub fn new() -> Self {
        let columns = [[zeros(); GROUPS]; NOISES];
        Self {
            rows: [(0, 0); NOISES],
            noise: columns,
            solved: columns,
            e: columns,
            quadratic: [[zeros(); NOISES]; NOISES],
        }
    }

    /// Fills in noise, `Y` and `D Y` of every group there is; returns how many.
    #[inline(always)]
    fn fill(
        &mut self,
        big_d: &Covariance<T>,
        forward: &ForwardStep<T>,
        step: &StepInputs<T>,
        parameters: &FilterParameters<T>,
    ) -> usize {
        let factor = CovarianceFactor::new(&forward.predicted.p);
        let mut count = 0;
        for c in 0..NOISES {
            let Some(columns) = NoiseColumns::new(c, forward, step, parameters) else { continue };
            self.rows[count] = columns.rows;
            self.solved[count] = factor.solve(&columns);
            for g in columns.rows.0..columns.rows.1 {
                self.noise[count][g] = scaled_columns(&columns.gamma[g], &columns.variances);
            }
            for g in 0..GROUPS {
                let mut row = zeros();
                for k in 0..GROUPS {
                    row = add_product(&row, &big_d.block(g, k), &self.solved[count][k]);
                }
                self.e[count][g] = row;
            }
            count += 1;
        }
        count
    }
}

/// `d <- A d` and `D <- A D A'` with `A = I - Gamma Q Y'`, `Y = (P-)^-1 Gamma`.
///
/// Returns the expected square of each process noise w given all measurements, in terms of Q of whole samples: with
/// `d = xs - x-` and `D = Ps - P-` it is `E[w^2] = (Q Y' d)^2 + diag(Q + Q Y' D Y Q)`. That is the textbook form with the
/// lag-one covariance `Ps G'` (Shumway & Stoffer 1982), projected on the columns of Gamma.
#[inline(always)]
pub(crate) fn remove_process_noise<T: Real>(
    d: &mut [Vec3<T>; GROUPS],
    big_d: &mut Covariance<T>,
    workspace: &mut NoiseWorkspace<T>,
    forward: &ForwardStep<T>,
    step: &StepInputs<T>,
    parameters: &FilterParameters<T>,
) -> [Vec3<T>; 2] {
    let count = workspace.fill(big_d, forward, step, parameters);
    let NoiseWorkspace { rows, noise, solved, e, quadratic } = workspace;
    let old = *d;
    let mut squares = parameters.noise.process;
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
        for g in rows[c].0..rows[c].1 {
            d[g] = subtract_times(&d[g], &noise[c][g], &along);
        }
    }

    // E = D Y - U (Y' D Y) / 2, so that A D A' = D - U E' - E U'
    let half = T::splat(-0.5);
    for c in 0..count {
        for b in 0..=c {
            let mut product = zeros();
            for g in 0..GROUPS {
                product = add_product(&product, &transposed(&solved[b][g]), &e[c][g]);
            }
            if b == c && c < 2 {
                for i in 0..3 {
                    let q = parameters.noise.process[c][i];
                    let gained = (squares[c][i] + product[i][i]) * q * step.noise_scale;
                    squares[c][i] = gained.mul_add(q, q);
                }
            }
            quadratic[b][c] = scaled(&product, half);
            quadratic[c][b] = transposed(&quadratic[b][c]);
        }
    }
    for c in 0..count {
        for b in 0..count {
            for g in rows[b].0..rows[b].1 {
                e[c][g] = add_product(&e[c][g], &noise[b][g], &quadratic[b][c]);
            }
        }
    }
    for c in 0..count {
        let (from, to) = rows[c];
        for i in from..to {
            for j in 0..=i {
                let block = &mut big_d.blocks[at(i, j)];
                *block = subtract_product_transposed(block, &noise[c][i], &e[c][j]);
            }
        }
        for j in from..to {
            for i in j..GROUPS {
                let block = &mut big_d.blocks[at(i, j)];
                *block = subtract_product_transposed(block, &e[c][i], &noise[c][j]);
            }
        }
    }
    squares
}

/// Columns of Gamma that belong to one group of noises, and their variances.
struct NoiseColumns<T> {
    gamma: Columns<T>,
    variances: Vec3<T>,
    /// Groups of states that are not zero in `gamma`: from, to without.
    rows: (usize, usize),
    /// Index in [`ORDER`] of the first of them.
    first: usize,
}

impl<T: Real> NoiseColumns<T> {
    /// The `c`-th group of noises: accelerometers, gyros, then the random walk of each group of states, if it has one. That of the wind
    /// also moves the velocity relative to the air.
    #[inline(always)]
    fn new(c: usize, forward: &ForwardStep<T>, step: &StepInputs<T>, parameters: &FilterParameters<T>) -> Option<Self> {
        let mut gamma = [zeros(); GROUPS];
        if c < 2 {
            let phi = &forward.phi;
            (gamma[POS], gamma[VEL], gamma[ATT]) =
                if c == 0 { (phi.pos_acc, phi.vel_acc, zeros()) } else { (phi.pos_gyr, phi.vel_gyr, phi.att_gyr) };
            let q = parameters.noise.process[c];
            let variances = [q[0] * step.noise_scale, q[1] * step.noise_scale, q[2] * step.noise_scale];
            return Some(if c == 0 {
                Self { gamma, variances, rows: (POS, ATT), first: POSITION_IN_ORDER[VEL] }
            } else {
                Self { gamma, variances, rows: (POS, ACC), first: POSITION_IN_ORDER[ATT] }
            });
        }
        let g = c - 2;
        let walk = parameters.noise.random_walk[g];
        if !(walk[0] + walk[1] + walk[2]).any_above(T::zero()) {
            return None;
        }
        gamma[g] = scaled_identity(T::splat(1.0));
        let variances = [walk[0] * step.dt, walk[1] * step.dt, walk[2] * step.dt];
        let first = POSITION_IN_ORDER[g];
        if g == WIND {
            let c = ned_from_body(&Trig::new(&forward.predicted.x[ATT]));
            gamma[VEL] = scaled(&transposed(&c), T::splat(-1.0));
            return Some(Self { gamma, variances, rows: (VEL, GROUPS), first });
        }
        Some(Self { gamma, variances, rows: (g, g + 1), first })
    }
}

/// Order in which the covariance is factored: groups that noise enters last, so that its columns begin with zeros.
const ORDER: [usize; GROUPS] = [ACC, GYR, WIND, ATT, VEL, POS];
/// Index of each group in [`ORDER`].
const POSITION_IN_ORDER: [usize; GROUPS] = [5, 4, 3, 0, 1, 2];

/// Cholesky factor of the whole covariance, block by block, in [`ORDER`].
struct CovarianceFactor<T> {
    diagonal: [Factor<T>; GROUPS],
    /// Blocks below the diagonal, at their index of the lower triangle.
    below: [Mat3<T>; BLOCKS],
}

impl<T: Real> CovarianceFactor<T> {
    #[inline(always)]
    fn new(p: &Covariance<T>) -> Self {
        let mut below = p.blocks;
        let mut diagonal = [Factor::new(&p.blocks[at(ORDER[0], ORDER[0])]); GROUPS];
        for j in 0..GROUPS {
            let mut own = p.blocks[at(ORDER[j], ORDER[j])];
            for k in 0..j {
                own = subtract_product_transposed(&own, &below[at(j, k)], &below[at(j, k)]);
            }
            diagonal[j] = Factor::new(&own);
            for i in j + 1..GROUPS {
                let mut block = p.block(ORDER[i], ORDER[j]);
                for k in 0..j {
                    block = subtract_product_transposed(&block, &below[at(i, k)], &below[at(j, k)]);
                }
                below[at(i, j)] = diagonal[j].whiten_rows(&block);
            }
        }
        Self { diagonal, below }
    }

    /// `P^-1 Gamma`.
    #[inline(always)]
    fn solve(&self, columns: &NoiseColumns<T>) -> Columns<T> {
        let mut whitened = [zeros(); GROUPS];
        for i in columns.first..GROUPS {
            let mut row = columns.gamma[ORDER[i]];
            for k in columns.first..i {
                row = subtract_product(&row, &self.below[at(i, k)], &whitened[k]);
            }
            whitened[i] = self.diagonal[i].solve(&row);
        }
        let mut x = [zeros(); GROUPS];
        for i in (0..GROUPS).rev() {
            let mut row = whitened[i];
            for k in i + 1..GROUPS {
                row = subtract_product(&row, &transposed(&self.below[at(k, i)]), &x[ORDER[k]]);
            }
            x[ORDER[i]] = self.diagonal[i].solve_transposed(&row);
        }
        x
    }
}
