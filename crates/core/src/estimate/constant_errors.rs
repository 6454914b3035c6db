//! Errors of sensors that are constant over all windows, from the innovations of a filter with and without them.

use std::ops::Range;

use nalgebra::{DMatrix, DVector};

use super::EstimateError;
use crate::reconstruct::Reconstruction;

/// Constant errors of sensors, each estimated from all windows together.
#[derive(Clone, Debug, PartialEq)]
pub struct ConstantErrors {
    /// Estimate of each, unit of its step.
    pub estimates: Vec<f64>,
    /// Their covariance by the deviations the filter predicts.
    pub predicted: DMatrix<f64>,
    /// Their covariance by the scatter between the windows.
    pub scattered: DMatrix<f64>,
    /// What the innovations say of them, without what was known beforehand.
    pub information: DMatrix<f64>,
    /// Standard deviations that decide whether samples are corrected: of the prediction plus the scatter of the scores that are not freed,
    /// times `G / (G - p)` for `G` windows and `p` errors. Few windows then correct nothing by their own scatter.
    pub cautious_deviations: Vec<f64>,
}

/// What one window, or a span of one, says of the errors: `A = sum N' S^-1 N` and `b = sum N' S^-1 nu`.
#[derive(Clone, Debug, PartialEq)]
pub struct InnovationEvidence {
    information: DMatrix<f64>,
    gradient: DVector<f64>,
}

impl InnovationEvidence {
    /// From the innovations `nu` of a window and those of the same window freed of each error by a step: `N = (nu_k - nu) / step_k`.
    ///
    /// Innovations count with the deviations the filter predicts, each by itself. Those of other times than `nominal` has are left out.
    pub fn new(nominal: &Reconstruction, freed: &[(&Reconstruction, f64)]) -> Self {
        Self::of_samples(nominal, freed, 0..usize::MAX)
    }

    /// The same of each of the equal spans of at least `span_s` that the window is divided into.
    pub fn of_spans(nominal: &Reconstruction, freed: &[(&Reconstruction, f64)], span_s: f64) -> Vec<Self> {
        let samples = nominal.time_s.len();
        let duration_s = nominal.time_s.last().zip(nominal.time_s.first()).map_or(0.0, |(last, first)| last - first);
        #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "a number of spans")]
        let spans = ((duration_s / span_s) as usize).clamp(1, samples.max(1));
        (0..spans)
            .map(|span| Self::of_samples(nominal, freed, span * samples / spans..(span + 1) * samples / spans))
            .collect()
    }

    fn of_samples(nominal: &Reconstruction, freed: &[(&Reconstruction, f64)], range: Range<usize>) -> Self {
        let count = freed.len();
        let (mut information, mut gradient) = (DMatrix::zeros(count, count), DVector::zeros(count));
        let mut slopes = vec![0.0; count];
        for (index, (innovations, deviations)) in
            nominal.innovations.iter().zip(&nominal.innovation_deviations).enumerate()
        {
            let samples = innovations.iter().zip(deviations).enumerate().take(range.end).skip(range.start);
            for (at, (&innovation, deviation)) in samples {
                if !(innovation.is_finite() && deviation > 0.0) {
                    continue;
                }
                for (slope, (other, step)) in slopes.iter_mut().zip(freed) {
                    let moved = other.innovations[index].get(at).map_or(0.0, |other| other - innovation);
                    *slope = if moved.is_finite() { moved / (step * deviation) } else { 0.0 };
                }
                for (row, slope) in slopes.iter().enumerate() {
                    gradient[row] += slope * innovation / deviation;
                    for (column, other) in slopes.iter().enumerate().take(row + 1) {
                        information[(row, column)] += slope * other;
                    }
                }
            }
        }
        information.fill_upper_triangle_with_lower_triangle();
        Self { information, gradient }
    }
}

/// Errors that make the innovations of all windows smallest, one step of Gauss and Newton from none:
/// `e = -B b`, `B = (A + P^-1)^-1`, with `A` and `b` summed over the windows and `P` the squares of `prior_deviations`, what is known of each
/// error beforehand. `B` is their covariance where the innovations are as the filter predicts. Innovations of flight data are larger and
/// correlated: the scatter between windows gives `B (sum_w h_w h_w' + P^-1) B`, `h_w = S (I - S B S)^-1/2 S^-1 g_w`, `g_w = b_w + A_w e`,
/// `S S = A_w`. The factor frees the scores of what the estimate itself took of each, so that the scatter is that of the filter on average
/// where its prediction holds, whatever a window says of each error (Bell and McCaffrey, Survey Methodology 28(2), 2002).
///
/// # Errors
/// Prior deviations that are not positive, windows of other numbers of errors.
pub fn constant_errors(
    windows: &[InnovationEvidence],
    prior_deviations: &[f64],
) -> Result<ConstantErrors, EstimateError> {
    let count = prior_deviations.len();
    if let Some(&value) = prior_deviations.iter().find(|value| !(**value > 0.0 && value.is_finite())) {
        return Err(EstimateError::Setting {
            setting: "prior standard deviation of a constant error".to_owned(),
            value,
            allowed: "positive and finite",
        });
    }
    let prior =
        DMatrix::from_diagonal(&DVector::from_iterator(count, prior_deviations.iter().map(|d| (d * d).recip())));
    let (mut information, mut gradient) = (DMatrix::zeros(count, count), DVector::zeros(count));
    for window in windows {
        if window.gradient.len() != count {
            let found = window.gradient.len();
            return Err(EstimateError::Size { quantity: "constant errors", expected: count, found });
        }
        information += &window.information;
        gradient += &window.gradient;
    }
    let factor = (&information + &prior).cholesky().ok_or_else(|| EstimateError::Setting {
        setting: "innovations".to_owned(),
        value: f64::NAN,
        allowed: "finite",
    })?;
    let estimates = -factor.solve(&gradient);
    let predicted = symmetric(&factor.inverse());
    let deviations = DVector::from_column_slice(prior_deviations);
    let widening = windows.len() as f64 / (windows.len() as f64 - count as f64).max(1.0);
    let (mut scatter, mut unfreed) = (prior.clone(), prior);
    for window in windows {
        let score = freed_score(window, &estimates, &predicted, &deviations);
        scatter += &score * score.transpose();
        let score = &window.gradient + &window.information * &estimates;
        unfreed += &score * score.transpose() * widening;
    }
    let between = |scatter: DMatrix<f64>| symmetric(&(&predicted * scatter * &predicted));
    let scattered = between(scatter);
    let cautious = (&predicted + between(unfreed)).diagonal().map(f64::sqrt);
    let list = |values: DVector<f64>| values.iter().copied().collect();
    let (estimates, cautious_deviations) = (list(estimates), list(cautious));
    Ok(ConstantErrors { estimates, predicted, scattered, information, cautious_deviations })
}

fn symmetric(matrix: &DMatrix<f64>) -> DMatrix<f64> {
    0.5 * (matrix + matrix.transpose())
}

/// The score of a window freed of what the estimate took of it, in units of the prior `deviations`, which bring all errors to one scale.
fn freed_score(
    window: &InnovationEvidence,
    estimates: &DVector<f64>,
    covariance: &DMatrix<f64>,
    deviations: &DVector<f64>,
) -> DVector<f64> {
    /// Share of the largest eigenvalue below which a window says nothing.
    const NOTHING: f64 = 1e-12;
    let scale = DMatrix::from_diagonal(deviations);
    let unscale = DMatrix::from_diagonal(&deviations.map(f64::recip));
    let score = &scale * (&window.gradient + &window.information * estimates);
    let own = symmetric(&(&scale * &window.information * &scale)).symmetric_eigen();
    let largest = own.eigenvalues.max();
    let said: Vec<usize> = (0..own.eigenvalues.len()).filter(|&k| own.eigenvalues[k] > NOTHING * largest).collect();
    if said.is_empty() {
        return DVector::zeros(score.len());
    }
    let axes = own.eigenvectors.select_columns(&said);
    let root = DVector::from_iterator(said.len(), said.iter().map(|&k| own.eigenvalues[k].sqrt()));
    let (grow, shrink) = (DMatrix::from_diagonal(&root), DMatrix::from_diagonal(&root.map(f64::recip)));
    let of_axes = &grow * axes.transpose();
    let taken = symmetric(&(&of_axes * &unscale * covariance * &unscale * of_axes.transpose()));
    let left = (DMatrix::identity(said.len(), said.len()) - taken).symmetric_eigen();
    let factor = left.eigenvalues.map(|value| if value > NOTHING { value.sqrt().recip() } else { 0.0 });
    let freed = &left.eigenvectors * DMatrix::from_diagonal(&factor) * left.eigenvectors.transpose();
    let along = &axes * grow * freed * shrink * axes.transpose() * score;
    unscale * along
}

impl ConstantErrors {
    /// Variance of what moves by `slopes` with each: the larger of the filter's prediction and of the scatter between windows.
    pub fn variance(&self, slopes: &[f64]) -> f64 {
        let slopes = DVector::from_column_slice(slopes);
        let by = |covariance: &DMatrix<f64>| slopes.dot(&(covariance * &slopes));
        by(&self.predicted).max(by(&self.scattered))
    }

    /// Standard deviation of each.
    pub fn deviations(&self) -> Vec<f64> {
        let both = self.predicted.diagonal().zip_map(&self.scattered.diagonal(), f64::max);
        both.iter().map(|variance| variance.sqrt()).collect()
    }

    /// Mean square of the error that they give to an estimate which moves by `slopes` with each: `slopes' (C + e e') slopes`. What was
    /// found and is still in the samples counts as well as what is not known of it.
    pub fn mean_square(&self, slopes: &[f64]) -> f64 {
        let moved: f64 = slopes.iter().zip(&self.estimates).map(|(slope, estimate)| slope * estimate).sum();
        self.variance(slopes) + moved * moved
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn errors_come_back_from_windows_whose_innovations_they_explain() {
        let windows: Vec<_> = (0..5).map(|w| evidence(f64::from(w), 0.05)).collect();
        let found = constant_errors(&windows, &[1.0, 1.0]).unwrap();
        approx::assert_relative_eq!(found.estimates[0], 0.2, epsilon = 0.01);
        approx::assert_relative_eq!(found.estimates[1], -0.1, epsilon = 0.01);
        assert!(found.deviations().iter().all(|deviation| *deviation < 0.05));
        // One that nothing is seen of keeps what was known before.
        let none = InnovationEvidence { information: DMatrix::zeros(2, 2), gradient: DVector::zeros(2) };
        let open = constant_errors(&[none], &[0.3, 0.4]).unwrap();
        assert_eq!(open.estimates, [0.0, 0.0]);
        approx::assert_relative_eq!(open.deviations()[0], 0.3, epsilon = 1e-12);
        approx::assert_relative_eq!(open.deviations()[1], 0.4, epsilon = 1e-12);
        assert!(constant_errors(&windows, &[0.0, 1.0]).is_err());
    }

    fn evidence(seed: f64, noise: f64) -> InnovationEvidence {
        let (mut information, mut gradient) = (DMatrix::zeros(2, 2), DVector::zeros(2));
        for k in 0..400 {
            let t = 0.05 * f64::from(k) + seed;
            let slopes = DVector::from_vec(vec![t.sin(), (1.7 * t).cos() + 0.3]);
            // Freed of the errors (0.2, -0.1) the innovation is noise.
            let innovation = -(0.2 * slopes[0] - 0.1 * slopes[1]) + noise * (97.0 * t).sin();
            information += &slopes * slopes.transpose();
            gradient += slopes * innovation;
        }
        InnovationEvidence { information, gradient }
    }

    /// Draws of windows whose innovations are white with the deviation the filter predicts: each error's deviation by the scatter is that of
    /// the prediction, and that of the estimates, whether windows are few or many.
    #[test]
    fn the_scatter_is_that_predicted_where_innovations_are_as_predicted() {
        use rand::{RngExt, SeedableRng};
        use rand_distr::StandardNormal;
        const DRAWS: usize = 2000;
        let mut rng = rand_chacha::ChaCha8Rng::seed_from_u64(5);
        for count in [4_usize, 10, 40] {
            let (mut scattered, mut squares, mut predicted) = ([0.0; 3], [0.0; 3], [0.0; 3]);
            for _ in 0..DRAWS {
                let windows: Vec<_> = (0..count).map(|w| white(w, || rng.sample::<f64, _>(StandardNormal))).collect();
                let found = constant_errors(&windows, &[50.0, 50.0, 50.0]).unwrap();
                for k in 0..3 {
                    scattered[k] += found.scattered[(k, k)] / DRAWS as f64;
                    squares[k] += found.estimates[k].powi(2) / DRAWS as f64;
                    predicted[k] = found.predicted[(k, k)];
                }
            }
            for k in 0..3 {
                assert!((scattered[k] / predicted[k] - 1.0).abs() < 0.1, "{count}: {scattered:?} for {predicted:?}");
                assert!((squares[k] / predicted[k] - 1.0).abs() < 0.15, "{count}: {squares:?} for {predicted:?}");
            }
        }
    }

    /// A window of 30 white innovations whose slopes differ from window to window.
    fn white(window: usize, mut noise: impl FnMut() -> f64) -> InnovationEvidence {
        let (mut information, mut gradient) = (DMatrix::zeros(3, 3), DVector::zeros(3));
        for k in 0..30 {
            let t = 0.3 * f64::from(k) + window as f64;
            let slopes =
                DVector::from_vec(vec![t.sin(), if window.is_multiple_of(2) { t.cos() } else { 0.1 }, 0.5 + 0.02 * t]);
            information += &slopes * slopes.transpose();
            gradient += slopes * noise();
        }
        InnovationEvidence { information, gradient }
    }
}
