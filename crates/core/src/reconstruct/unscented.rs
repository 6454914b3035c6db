//! Unscented Kalman filter and smoother: means and covariances from sigma points instead of Jacobians.
//!
//! Sigma points lie at `spread` standard deviations either way along every column of a square root of the covariance and, in
//! the prediction, of every process noise (Julier & Uhlmann 2004; scaled form of van der Merwe 2004 with beta = 2). With `d`
//! the mean of their images less the image of the centre, weights `w = 1 / (2 spread^2)` and n columns, the covariance of
//! the images is `sum w (y - y0)(y - y0)' + (2 - spread^2 / n) d d'`: a sum of squares, positive whatever the spread.

use nalgebra::SMatrix;

use super::ReconstructError;
use super::covariance::{ACC, ATT, GYR, POS, VEL, WIND};
use super::dense::Dense;
use super::form::Form;
use super::full::{
    FULL, Full, X, Z, groups, noise, observe, random_walk, residual, start, tell_full, tell_full_smoothed, telling,
    telling_nothing,
};
use super::kernel::{Step, Telling, Tuning};
use super::kinematics::Trig;
use super::layout::{INPUTS, MEASUREMENTS, STATES, State};
use super::march::{FULL_RECORD, read_step};
use super::schedule::DRIVE;
use super::settings::{Method, ValidSettings};
use super::transition::{Constants, Motion, integrate};
use super::window::Window;

/// Columns of the square root in a prediction.
const COLUMNS: usize = FULL + INPUTS;
/// Deviations of the sigma points of a prediction, times the square root of their weight.
type Points = SMatrix<f64, FULL, { 2 * COLUMNS }>;

/// State, covariance and the distance of the sigma points.
#[derive(Clone)]
pub struct UnscentedEstimate {
    x: X,
    p: Full,
    /// In standard deviations.
    spread: f64,
}

/// What the backward pass needs of one step.
pub struct UnscentedKept {
    before: UnscentedEstimate,
    predicted: UnscentedEstimate,
    ahead: Ahead,
    /// Covariance of the random walks over the step.
    walked: X,
}

/// A prediction's sigma points.
struct Ahead {
    /// Before the step.
    from: Points,
    /// After it, from the image of the centre.
    to: Points,
    /// Mean of the images less the image of the centre, times the root of its weight.
    shift: X,
}

impl Form for UnscentedEstimate {
    type Number = f64;
    type Kept = UnscentedKept;
    const ROW: usize = FULL_RECORD;

    fn new(windows: &[Result<Window<'_>, ReconstructError>], settings: &ValidSettings) -> Self {
        let (x, p) = start(windows, settings);
        let spread = if let Method::Ukf { spread } = settings.method { spread } else { Method::USUAL_SPREAD };
        Self { x, p, spread }
    }

    fn run(&mut self, tuning: &Tuning<f64>, steps: usize, drive: &[f64], record: &mut [f64]) {
        for (drive, record) in drive.chunks_exact(DRIVE).zip(record.chunks_exact_mut(FULL_RECORD)).take(steps) {
            let step = read_step::<f64>(drive);
            self.predict(&step, tuning);
            let telling = self.update(&step, tuning);
            tell_full(&self.x, &self.p, &step, &telling, record);
        }
    }

    fn smooth(
        &mut self,
        start: &Self,
        tuning: &Tuning<f64>,
        steps: usize,
        drive: &[f64],
        kept: &mut Vec<UnscentedKept>,
        record: &mut [f64],
    ) {
        kept.clear();
        let mut filtered = start.clone();
        for drive in drive.chunks_exact(DRIVE).take(steps) {
            let step = read_step::<f64>(drive);
            let before = filtered.clone();
            let ahead = filtered.predict(&step, tuning);
            let walked = random_walk(tuning) * step.dt;
            kept.push(UnscentedKept { before, predicted: filtered.clone(), ahead, walked });
            filtered.update(&step, tuning);
        }
        for (kept, record) in kept.iter().zip(record.chunks_exact_mut(FULL_RECORD)).rev() {
            self.smooth_step(kept);
            tell_full_smoothed(&self.x, &self.p, record);
        }
    }

    fn covariance(&self, _lane: usize) -> Dense {
        self.p.fixed_view::<STATES, STATES>(0, 0).into_owned()
    }
}

impl UnscentedEstimate {
    /// Weight of `d d'` with `n` columns.
    fn centre_weight(&self, columns: usize) -> f64 {
        (2.0 - self.spread * self.spread / columns as f64).max(0.0)
    }

    fn predict(&mut self, step: &Step<f64>, tuning: &Tuning<f64>) -> Ahead {
        let root = Root::new(&self.p);
        let weight = 0.5 / (self.spread * self.spread);
        let centre = advance(&self.x, &[0.0; INPUTS], step, tuning);
        let mut ahead = Ahead { from: Points::zeros(), to: Points::zeros(), shift: X::zeros() };
        for column in 0..COLUMNS {
            let mut along = X::zeros();
            let mut noises = [0.0; INPUTS];
            if column < FULL {
                along.copy_from(&root.lower.column(column));
            } else {
                let i = column - FULL;
                noises[i] = (tuning.process[i / 3][i % 3] * step.noise_scale).sqrt();
            }
            for (side, distance) in [self.spread, -self.spread].into_iter().enumerate() {
                let image = advance(&(self.x + along * distance), &noises.map(|noise| noise * distance), step, tuning);
                let moved = (image - centre) * weight.sqrt();
                ahead.shift += moved * weight.sqrt();
                ahead.from.set_column(2 * column + side, &(along * (distance * weight.sqrt())));
                ahead.to.set_column(2 * column + side, &moved);
            }
        }
        self.x = centre + ahead.shift;
        ahead.shift *= self.centre_weight(root.columns + INPUTS).sqrt();
        self.p = ahead.to * ahead.to.transpose()
            + ahead.shift * ahead.shift.transpose()
            + Full::from_diagonal(&(random_walk(tuning) * step.dt));
        ahead
    }

    fn update(&mut self, step: &Step<f64>, tuning: &Tuning<f64>) -> Telling<f64> {
        let root = Root::new(&self.p);
        let weight = 0.5 / (self.spread * self.spread);
        let (centre, _) = observe(&self.x);
        let mut from = SMatrix::<f64, FULL, { 2 * FULL }>::zeros();
        let mut images = SMatrix::<f64, MEASUREMENTS, { 2 * FULL }>::zeros();
        let mut shift = Z::zeros();
        for column in 0..FULL {
            for (side, distance) in [self.spread, -self.spread].into_iter().enumerate() {
                let along = root.lower.column(column) * distance;
                let (image, _) = observe(&(self.x + along));
                // the residual of a step that measured `image` is their difference, angles within half a turn
                let moved = residual(&measuring(&image, step), &centre) * weight.sqrt();
                shift += moved * weight.sqrt();
                from.set_column(2 * column + side, &(along * weight.sqrt()));
                images.set_column(2 * column + side, &moved);
            }
        }
        let innovation = residual(step, &centre) - shift;
        let noise = noise(step, tuning);
        shift *= self.centre_weight(root.columns).sqrt();
        let own = SMatrix::from_diagonal(&noise) + shift * shift.transpose();
        let s = images * images.transpose() + own;
        let Some(factor) = s.cholesky() else { return telling_nothing(tuning) };
        let cross = from * images.transpose();
        let gain = factor.solve(&cross.transpose()).transpose();
        self.x += gain * innovation;
        // P - K S K', as the sum of squares it is
        let left = from - gain * images;
        self.p = left * left.transpose() + gain * own * gain.transpose();
        telling(&innovation, &s, &factor, &noise)
    }

    /// Unscented Rauch-Tung-Striebel step (Sarkka 2008): gain `G = D (P-)^-1` with the covariance `D` of the states before and
    /// after the step. States that do not change over a step have a row of the identity in `G`.
    fn smooth_step(&mut self, kept: &UnscentedKept) {
        let Ahead { from, to, shift } = &kept.ahead;
        let across = to * from.transpose();
        let mut gain = Root::new(&kept.predicted.p).solve(across).transpose();
        for k in (State::BiasAx as usize..FULL).filter(|&k| kept.walked[k] == 0.0) {
            gain.fill_row(k, 0.0);
            gain[(k, k)] = 1.0;
        }
        let left = from - gain * to;
        let shift = gain * shift;
        let walked = self.p + Full::from_diagonal(&kept.walked);
        self.x = kept.before.x + gain * (self.x - kept.predicted.x);
        let covariance = left * left.transpose() + shift * shift.transpose() + gain * walked * gain.transpose();
        self.p = (covariance + covariance.transpose()) * 0.5;
    }
}

/// `step` with `z` measured.
fn measuring(z: &Z, step: &Step<f64>) -> Step<f64> {
    let mut measured = *step;
    for m in 0..MEASUREMENTS {
        measured.z[m / 3][m % 3] = z[m];
    }
    measured
}

/// The state after a step, with `noises` in the inertial measurements.
fn advance(x: &X, noises: &[f64; INPUTS], step: &Step<f64>, tuning: &Tuning<f64>) -> X {
    let before = groups(x);
    let motion = Motion { pos: before[POS], vel: before[VEL], att: before[ATT] };
    let mut constants =
        Constants { bias_acc: before[ACC], bias_gyr: before[GYR], wind: before[WIND], gravity: tuning.gravity };
    for i in 0..3 {
        constants.bias_acc[i] += noises[i];
        constants.bias_gyr[i] += noises[3 + i];
    }
    let moved = integrate(&motion, &Trig::new(&motion.att), &constants, &step.inputs, step.dt);
    let mut after = *x;
    for i in 0..3 {
        (after[i], after[3 + i], after[6 + i]) = (moved.pos[i], moved.vel[i], moved.att[i]);
    }
    after
}

/// Cholesky factor of a covariance that may have states without variance: their columns are zero.
struct Root {
    lower: Full,
    /// Number of columns that are not zero.
    columns: usize,
}

impl Root {
    fn new(p: &Full) -> Self {
        let mut lower = Full::zeros();
        let mut columns = 0;
        for j in 0..FULL {
            let mut pivot = p[(j, j)];
            for k in 0..j {
                pivot -= lower[(j, k)] * lower[(j, k)];
            }
            if pivot <= FULL as f64 * f64::EPSILON * p[(j, j)] || pivot.is_nan() {
                continue;
            }
            columns += 1;
            lower[(j, j)] = pivot.sqrt();
            for i in j + 1..FULL {
                let mut value = p[(i, j)];
                for k in 0..j {
                    value -= lower[(i, k)] * lower[(j, k)];
                }
                lower[(i, j)] = value / lower[(j, j)];
            }
        }
        Self { lower, columns }
    }

    /// `P^-1 b`, zero in the rows of states without variance.
    fn solve(&self, mut b: Full) -> Full {
        let l = &self.lower;
        for column in 0..FULL {
            for i in 0..FULL {
                let known: f64 = (0..i).map(|k| l[(i, k)] * b[(k, column)]).sum();
                b[(i, column)] = over(b[(i, column)] - known, l[(i, i)]);
            }
            for i in (0..FULL).rev() {
                let known: f64 = (i + 1..FULL).map(|k| l[(k, i)] * b[(k, column)]).sum();
                b[(i, column)] = over(b[(i, column)] - known, l[(i, i)]);
            }
        }
        b
    }
}

/// `value / pivot`, zero where there is no pivot.
fn over(value: f64, pivot: f64) -> f64 {
    if pivot > 0.0 { value / pivot } else { 0.0 }
}
