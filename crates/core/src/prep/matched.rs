//! The smoothing that a differentiation carries with it.

use super::{Differentiation, PrepError, check, differentiate, local_polynomial, step_within};

/// Smoothing `G` with which a differentiation of sampled signals is the slope of the smoothed signal: `D f = G f'`.
///
/// Every difference formula is a weighted sum of the increments between neighbouring samples,
/// `D f = sum_k d_k f_k = sum_j c_j (f_{j+1} - f_j)` with `c_j = sum_{k>j} d_k`, and an increment is the integral of the slope. With
/// that integral by the four-point formula `h (-1, 13, 13, -1) / 24`, exact for cubics, `G` is a symmetric weighting of samples.
/// Where `y' = theta x` holds, `D y = theta G x` holds as well, whatever `D` loses of the fastest motion: regressors smoothed by
/// `G` take away the bias that differentiation brings into an equation error. Its own error is of the fourth order of the step.
///
/// (Filtering both sides of an equation by one linear operator: Klein and Morelli, "Aircraft System Identification", 5.3; the
/// modulating functions of Shinbrot, NACA TN 3288, are the same idea.)
#[derive(Clone, Debug, PartialEq)]
pub struct MatchedSmoothing {
    kernel: Vec<f64>,
}

/// Largest departure of a step from the mean one, as a fraction of it: stamps that their recorder rounds, as to milliseconds, leave the
/// smoothing as it is, for it spans many of them.
const JITTER: f64 = 0.3;

/// Weights of four samples in the integral over the middle one of their three intervals, in steps.
const INTEGRAL: [f64; 4] = [-1.0 / 24.0, 13.0 / 24.0, 13.0 / 24.0, -1.0 / 24.0];

impl MatchedSmoothing {
    /// The smoothing that goes with `method` on the samples at `time_s`.
    ///
    /// # Errors
    /// Those of [`differentiate`], steps that differ by more than rounding, and fewer samples than the smoothing spans.
    pub fn new(time_s: &[f64], method: Differentiation) -> Result<Self, PrepError> {
        check(time_s, time_s, "the matched smoothing", 2 * (method.half_width() + 1) + 1)?;
        let step = step_within(time_s, JITTER)?;
        let width = 2 * method.half_width() + 1;
        // Five samples are the least any method takes.
        let samples = width.max(5);
        let grid: Vec<f64> = (0..samples).map(|k| k as f64 * step).collect();
        let weights = match method {
            Differentiation::LocalPolynomial { degree, .. } if samples == width && (1..width).contains(&degree) => {
                let slope = local_polynomial::weights(&grid, grid[samples / 2], degree, 1);
                slope.into_iter().map(|weight| weight * step).collect()
            }
            _ => impulse_response(&grid, step, method)?,
        };
        let mut increments = vec![0.0; samples - 1];
        let mut sum = 0.0;
        for j in (0..samples - 1).rev() {
            sum += weights[j + 1];
            increments[j] = sum;
        }
        let mut kernel = vec![0.0; samples + 2];
        for (j, increment) in increments.iter().enumerate() {
            for (k, weight) in INTEGRAL.iter().enumerate() {
                kernel[j + k] += increment * weight;
            }
        }
        Ok(Self { kernel })
    }

    /// Samples at each end of a record that [`MatchedSmoothing::apply`] leaves out.
    pub fn reach(&self) -> usize {
        self.kernel.len() / 2
    }

    /// Smoothed values of all samples that have [`MatchedSmoothing::reach`] neighbours on either side.
    pub fn apply(&self, values: &[f64]) -> Vec<f64> {
        local_polynomial::moving_sum(values, &self.kernel)
    }
}

/// Derivative at the middle of `grid` of a signal that is `step` at one sample and zero at the others, for each sample.
fn impulse_response(grid: &[f64], step: f64, method: Differentiation) -> Result<Vec<f64>, PrepError> {
    let at = |k: usize| {
        let mut impulse = vec![0.0; grid.len()];
        impulse[k] = step;
        Ok(differentiate(grid, &impulse, method)?[grid.len() / 2])
    };
    (0..grid.len()).map(at).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    const STEP_S: f64 = 0.02;

    fn methods() -> [Differentiation; 4] {
        [
            Differentiation::Central4,
            Differentiation::Central { half_width: 3 },
            Differentiation::LocalPolynomial { degree: 2, half_width: 3 },
            Differentiation::LocalPolynomial { degree: 2, half_width: 10 },
        ]
    }

    #[test]
    fn smoothed_slope_is_the_derivative_of_the_samples_to_fourth_order() {
        /// Frequency of fast control motion, rad/s.
        const FREQUENCY: f64 = 12.0;
        // The four-point integral errs by 11/720 (w h)^4 of the slope.
        let allowed = 11.0 / 720.0 * (FREQUENCY * STEP_S).powi(4) * FREQUENCY;
        let time: Vec<f64> = (0..100).map(|k| f64::from(k) * STEP_S).collect();
        let wave: Vec<f64> = time.iter().map(|t| (FREQUENCY * t).sin()).collect();
        let slope: Vec<f64> = time.iter().map(|t| FREQUENCY * (FREQUENCY * t).cos()).collect();
        for method in methods() {
            let matched = MatchedSmoothing::new(&time, method).unwrap();
            let derived = differentiate(&time, &wave, method).unwrap();
            let smoothed = matched.apply(&slope);
            let reach = matched.reach();
            assert_eq!(smoothed.len(), 100 - 2 * reach);
            for (a, b) in smoothed.iter().zip(&derived[reach..]) {
                assert!((a - b).abs() < allowed, "{method:?}: {a} against {b}");
            }
        }
        // What is matched is worth having: the wide derivative itself loses most of this wave.
        let wide = differentiate(&time, &wave, methods()[3]).unwrap();
        assert!((wide[50] - slope[50]).abs() > 0.3 * slope[50].abs());
    }

    #[test]
    fn kernel_sums_to_one_and_is_symmetric() {
        let time: Vec<f64> = (0..60).map(|k| f64::from(k) * STEP_S).collect();
        for method in methods() {
            let kernel = MatchedSmoothing::new(&time, method).unwrap().kernel;
            approx::assert_relative_eq!(kernel.iter().sum::<f64>(), 1.0, epsilon = 1e-12);
            for (a, b) in kernel.iter().zip(kernel.iter().rev()) {
                approx::assert_relative_eq!(a, b, epsilon = 1e-12);
            }
        }
    }

    #[test]
    fn stamps_cut_to_milliseconds_are_matched_by_a_local_polynomial() {
        let method = Differentiation::LocalPolynomial { degree: 2, half_width: 10 };
        let time: Vec<f64> =
            (0..300).map(|k| (20.0 * f64::from(k) + 0.9 * f64::from(k % 7 % 2)).floor() * 1e-3).collect();
        let cut: Vec<f64> = time.iter().enumerate().map(|(k, t)| if k % 11 == 3 { t - 1e-3 } else { *t }).collect();
        let wave: Vec<f64> = cut.iter().map(|t| (4.0 * t).sin()).collect();
        let slope: Vec<f64> = cut.iter().map(|t| 4.0 * (4.0 * t).cos()).collect();
        let matched = MatchedSmoothing::new(&cut, method).unwrap();
        let (smoothed, derived) = (matched.apply(&slope), differentiate(&cut, &wave, method).unwrap());
        for (a, b) in smoothed.iter().zip(&derived[matched.reach()..]) {
            assert!((a - b).abs() < 0.02, "{a} against {b}");
        }
    }

    #[test]
    fn uneven_steps_and_short_records_are_rejected() {
        let method = Differentiation::Central4;
        let mut time: Vec<f64> = (0..6).map(f64::from).collect();
        assert!(matches!(MatchedSmoothing::new(&time, method), Err(PrepError::TooFewSamples { .. })));
        time.extend([6.5, 7.0]);
        assert!(matches!(MatchedSmoothing::new(&time, method), Err(PrepError::UnevenStep { .. })));
    }
}
