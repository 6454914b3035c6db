//! The extended filter with a dense covariance in Joseph form: slow, the last to lose positive definiteness, and the one that
//! has air-data states. It takes over a window on which the packed form failed, and carries the iterated smoother.

use std::rc::Rc;

use nalgebra::{SMatrix, SVector};

use super::ReconstructError;
use super::covariance::{ATT, VEL, WIND};
use super::dense::Dense;
use super::form::Form;
use super::full::{
    Full, Sensitivity, X, Z, groups, noise, observe, presence, random_walk, residual, start, tell_full,
    tell_full_smoothed, telling, telling_nothing, widened,
};
use super::kernel::{Step, Telling, Tuning, predict_state};
use super::layout::{INPUTS, STATES};
use super::march::{FULL_RECORD, read_step};
use super::schedule::DRIVE;
use super::settings::ValidSettings;
use super::transition::Transition;
use super::window::Window;

/// State and dense covariance, and where to linearise.
#[derive(Clone)]
pub struct DenseEstimate {
    /// State.
    pub x: X,
    /// Covariance.
    pub p: Full,
    /// Path to linearise about, one state per event, the start first; without it the estimate itself.
    pub about: Option<Rc<[X]>>,
    /// Events passed.
    pub place: usize,
    /// Going backwards: the smoothed path, one state per event, filled from its end.
    pub path: Vec<X>,
    /// Going backwards: what the path costs, see [`super::Smoothed::costs`].
    pub cost: f64,
}

/// What the backward pass needs of one step.
pub struct DenseKept {
    before: DenseEstimate,
    transition: Full,
    noise: Full,
    predicted: DenseEstimate,
}

impl Form for DenseEstimate {
    type Number = f64;
    type Kept = DenseKept;
    const ROW: usize = FULL_RECORD;

    fn new(windows: &[Result<Window<'_>, ReconstructError>], settings: &ValidSettings) -> Self {
        let (x, p) = start(windows, settings);
        Self { x, p, about: None, place: 0, path: Vec::new(), cost: 0.0 }
    }

    fn run(&mut self, tuning: &Tuning<f64>, steps: usize, drive: &[f64], record: &mut [f64]) {
        for (drive, record) in drive.chunks_exact(DRIVE).zip(record.chunks_exact_mut(FULL_RECORD)).take(steps) {
            let step = read_step::<f64>(drive);
            self.predict(&step, tuning);
            let telling = self.update(&step, tuning);
            tell_full(&self.x, &self.p, &step, &telling, record);
        }
    }

    fn begin_smoothing(&mut self) {
        self.path = vec![self.x; self.place + 1];
    }

    fn smooth(
        &mut self,
        start: &Self,
        tuning: &Tuning<f64>,
        steps: usize,
        drive: &[f64],
        kept: &mut Vec<DenseKept>,
        record: &mut [f64],
    ) {
        kept.clear();
        let mut filtered = start.clone();
        for drive in drive.chunks_exact(DRIVE).take(steps) {
            let step = read_step::<f64>(drive);
            let before = filtered.clone();
            let (transition, noise) = filtered.predict(&step, tuning);
            kept.push(DenseKept { before, transition, noise, predicted: filtered.clone() });
            filtered.update(&step, tuning);
        }
        for k in (0..steps).rev() {
            let step = read_step::<f64>(&drive[k * DRIVE..]);
            let end = self.x;
            self.smooth_step(&kept[k]);
            self.place -= 1;
            self.path[self.place] = self.x;
            self.cost += cost(&self.x, &end, &kept[k], &step, tuning);
            if self.place == 0 {
                self.cost += weighted_squares(&(self.x - kept[k].before.x), &kept[k].before.p.diagonal());
            }
            tell_full_smoothed(&self.x, &self.p, &mut record[k * FULL_RECORD..]);
        }
    }

    fn covariance(&self, _lane: usize) -> Dense {
        self.p.fixed_view::<STATES, STATES>(0, 0).into_owned()
    }
}

impl DenseEstimate {
    /// `x <- f(c) + Phi (x - c)` about the linearisation point c, which is x itself without a path to linearise about, and
    /// `P <- Phi P Phi' + N` with `N = Gamma Q Gamma'` and the random walks; returns Phi and N.
    fn predict(&mut self, step: &Step<f64>, tuning: &Tuning<f64>) -> (Full, Full) {
        let from = self.about.as_ref().map_or(self.x, |about| about[self.place]);
        let (to, phi) = advance(&from, step, tuning);
        let transition = widened(&phi.dense());
        let mut variances = SVector::<f64, INPUTS>::zeros();
        for i in 0..INPUTS {
            variances[i] = tuning.process[i / 3][i % 3] * step.noise_scale;
        }
        let mut gamma = transition.fixed_columns::<INPUTS>(9).into_owned();
        gamma.fixed_rows_mut::<INPUTS>(9).fill(0.0);
        let mut noise = gamma * SMatrix::from_diagonal(&variances) * gamma.transpose();
        noise += Full::from_diagonal(&(random_walk(tuning) * step.dt));
        self.x = to + transition * (self.x - from);
        self.p = transition * self.p * transition.transpose() + noise;
        self.place += 1;
        (transition, noise)
    }

    /// One step backwards, with `W = N (P-)^-1` and the gain `G = Phi^-1 (I - W)`:
    /// `x + G (xs - x-)` and `Phi^-1 ((I - W) (Ps + N) (I - W)' + W (P- - N) W') Phi'^-1`, a sum of covariances only, as
    /// Joseph's form of the update is.
    fn smooth_step(&mut self, kept: &DenseKept) {
        let scale = X::from_fn(|k, _| {
            let variance = kept.predicted.p[(k, k)];
            if variance > 0.0 { variance.sqrt().recip() } else { 0.0 }
        });
        let scale = Full::from_diagonal(&scale);
        // Correlations: of order one, whatever the units. Directions lost to rounding take no part.
        let mut eigen = (scale * kept.predicted.p * scale).symmetric_eigen();
        let least = STATES as f64 * f64::EPSILON * eigen.eigenvalues.max();
        eigen.eigenvalues.apply(|value| *value = if *value > least { value.recip() } else { 0.0 });
        let noise_part = kept.noise * scale * eigen.recompose() * scale;
        let kept_part = Full::identity() - noise_part;
        let ahead = self.x - kept.predicted.x;
        let without_noise = kept.transition * kept.before.p * kept.transition.transpose();
        let covariance = kept_part * (self.p + kept.noise) * kept_part.transpose()
            + noise_part * without_noise * noise_part.transpose();
        let back = kept.transition.lu();
        let nowhere = (Full::from_element(f64::NAN), X::from_element(f64::NAN));
        let half = back.solve(&covariance).unwrap_or(nowhere.0);
        let covariance = back.solve(&half.transpose()).unwrap_or(nowhere.0);
        self.x = kept.before.x + back.solve(&(kept_part * ahead)).unwrap_or(nowhere.1);
        self.p = (covariance + covariance.transpose()) * 0.5;
    }

    /// `P <- (I - K H) P (I - K H)' + K R K'` (Joseph, in Bucy & Joseph 1968).
    fn update(&mut self, step: &Step<f64>, tuning: &Tuning<f64>) -> Telling<f64> {
        let predicted = self.x;
        let mut point = self.about.as_ref().map_or(predicted, |about| about[self.place]);
        let noise = noise(step, tuning);
        let mut told: Option<Telling<f64>> = None;
        loop {
            let (expected, h) = seen(&point, step);
            let residual = residual(step, &expected) - h * (predicted - point);
            let cross = self.p * h.transpose();
            let s = h * cross + SMatrix::from_diagonal(&noise);
            let Some(factor) = s.cholesky() else { return telling_nothing(tuning) };
            let telling = told.get_or_insert_with(|| telling(&residual, &s, &factor, &noise));
            let gain = factor.solve(&cross.transpose()).transpose();
            let next = predicted + gain * residual;
            let moved = self.about.is_none()
                && (0..STATES).filter(|k| ITERATED.contains(&(k / 3))).any(|k| {
                    let change = next[k] - point[k];
                    change * change > tuning.tolerance_squared * self.p[(k, k)]
                });
            point = next;
            if telling.iterations as usize >= tuning.max_iterations || !moved {
                let kept = Full::identity() - gain * h;
                let updated =
                    kept * self.p * kept.transpose() + gain * SMatrix::from_diagonal(&noise) * gain.transpose();
                self.p = (updated + updated.transpose()) * 0.5;
                self.x = point;
                return *telling;
            }
            telling.iterations += 1.0;
        }
    }
}

/// Groups of states whose change decides whether to iterate: velocity, attitude, wind.
const ITERATED: [usize; 3] = [VEL, ATT, WIND];

/// Expected measurements, and H with zeros in the rows of what is absent.
fn seen(x: &X, step: &Step<f64>) -> (Z, Sensitivity) {
    let (expected, mut h) = observe(x);
    for (m, present) in presence(step).iter().enumerate() {
        h.row_mut(m).scale_mut(*present);
    }
    (expected, h)
}

/// The state after a step, and the transition.
fn advance(x: &X, step: &Step<f64>, tuning: &Tuning<f64>) -> (X, Transition<f64>) {
    let mut moved = groups(x);
    let (phi, _) = predict_state(&mut moved, step, tuning);
    let ahead = X::from_fn(|k, _| if k < STATES { moved[k / 3][k % 3] } else { x[k] });
    (ahead, phi)
}

/// What one step of a path from `begin` to `end` costs: squares of the residuals over R at its end, of the process noise over
/// its covariance, of the random walks over theirs. The noise is what moves velocity and attitude from where f takes them.
fn cost(begin: &X, end: &X, kept: &DenseKept, step: &Step<f64>, tuning: &Tuning<f64>) -> f64 {
    let measured = weighted_squares(&residual(step, &observe(end).0), &noise(step, tuning));
    let defect = end - advance(begin, step, tuning).0;
    let moving = 3 * VEL;
    let variances = kept.noise.fixed_view::<INPUTS, INPUTS>(moving, moving).into_owned();
    let of_motion = defect.fixed_rows::<INPUTS>(moving).into_owned();
    let process = variances.cholesky().map_or(f64::NAN, |factor| of_motion.dot(&factor.solve(&of_motion)));
    let mut walks = random_walk(tuning) * step.dt;
    walks.fixed_rows_mut::<9>(0).fill(0.0);
    measured + process + weighted_squares(&defect, &walks)
}

/// Sum of squares over variances, over the entries that have one.
fn weighted_squares<const N: usize>(values: &SVector<f64, N>, variances: &SVector<f64, N>) -> f64 {
    let pairs = values.iter().zip(variances.iter()).filter(|(_, variance)| **variance > 0.0);
    pairs.map(|(value, variance)| value * value / variance).sum()
}
