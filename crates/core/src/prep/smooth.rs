//! Smoothing of sampled signals without a shift in time.

use super::local_polynomial::local_polynomial;
use super::{PrepError, check};

/// How a signal is smoothed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Smoothing {
    /// Mean over `width` samples; an even width counts the two outermost samples half, so that nothing shifts.
    MovingAverage {
        /// Samples of the window, at least 1.
        width: usize,
    },
    /// Spencer's graduation over 15 samples, which keeps cubics; over 5 samples from the fourth sample from an end on, none
    /// nearer. The ATTAS results in Jategaonkar, "Flight Vehicle System Identification", were made with it.
    Spencer15,
    /// Polynomial fitted by least squares to the `2 half_width + 1` samples about each sample (Savitzky-Golay).
    LocalPolynomial {
        /// Degree of the polynomial.
        degree: usize,
        /// Samples on each side.
        half_width: usize,
    },
}

/// Smoothed values, one per sample. Near the ends the moving average narrows symmetrically, the polynomial uses the
/// nearest full window. The thesis (4.4.3) smooths inertial samples by a moving average of 4, then a polynomial of
/// degree 2 over 11 samples.
///
/// # Errors
/// Lengths that differ, time that does not increase, a width of zero, fewer samples than the window of the polynomial.
pub fn smooth(time_s: &[f64], values: &[f64], method: Smoothing) -> Result<Vec<f64>, PrepError> {
    match method {
        Smoothing::MovingAverage { width } => {
            check(time_s, values, "the moving average", 1)?;
            if width == 0 {
                return Err(PrepError::Setting { setting: "width", value: 0.0, allowed: "at least 1" });
            }
            Ok(moving_average(values, width))
        }
        Smoothing::Spencer15 => {
            check(time_s, values, "Spencer's graduation", 1)?;
            Ok(spencer(values))
        }
        Smoothing::LocalPolynomial { degree, half_width } => local_polynomial(time_s, values, degree, half_width, 0),
    }
}

/// Mean over `width` samples about each sample, narrower at the ends.
fn moving_average(values: &[f64], width: usize) -> Vec<f64> {
    let half = width / 2;
    (0..values.len())
        .map(|k| {
            let reach = half.min(k).min(values.len() - 1 - k);
            let window = &values[k - reach..=k + reach];
            let sum: f64 = window.iter().sum();
            if reach == half && width.is_multiple_of(2) && half > 0 {
                (sum - 0.5 * (window[0] + window[2 * reach])) / width as f64
            } else {
                sum / window.len() as f64
            }
        })
        .collect()
}

/// Weights of Spencer's 15-point formula in 320ths, from the centre outwards (Whittaker and Robinson, "The Calculus of
/// Observations", section 143).
const SPENCER: [f64; 8] = [74.0, 67.0, 46.0, 21.0, 3.0, -5.0, -6.0, -3.0];
/// Weights over 5 samples in 96ths, from the centre outwards.
const FIVE: [f64; 3] = [34.0, 24.0, 7.0];
/// Samples at each end that stay as they are.
const KEPT: usize = 3;

/// Spencer's graduation, with the shorter formula near the ends.
fn spencer(values: &[f64]) -> Vec<f64> {
    let symmetric = |k: usize, weights: &[f64], sum: f64| {
        let pairs = weights.iter().enumerate().skip(1).map(|(j, weight)| weight * (values[k - j] + values[k + j]));
        (weights[0] * values[k] + pairs.sum::<f64>()) / sum
    };
    (0..values.len())
        .map(|k| match k.min(values.len() - 1 - k) {
            reach if reach < KEPT => values[k],
            reach if reach + 1 < SPENCER.len() => symmetric(k, &FIVE, 96.0),
            _ => symmetric(k, &SPENCER, 320.0),
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn spencer_graduation_keeps_a_cubic_away_from_the_ends_and_is_symmetric() {
        let time: Vec<f64> = (0..40).map(f64::from).collect();
        let cubic: Vec<f64> = time.iter().map(|t| (t / 20.0 - 1.0).powi(3)).collect();
        let smoothed = smooth(&time, &cubic, Smoothing::Spencer15).unwrap();
        for k in 7..33 {
            approx::assert_relative_eq!(smoothed[k], cubic[k], epsilon = 1e-14);
        }
        let reversed: Vec<f64> = cubic.iter().rev().copied().collect();
        let mirrored = smooth(&time, &reversed, Smoothing::Spencer15).unwrap();
        for (forward, backward) in smoothed.iter().zip(mirrored.iter().rev()) {
            approx::assert_relative_eq!(forward, backward, epsilon = 1e-15);
        }
    }

    #[test]
    fn moving_average_keeps_a_straight_line_for_odd_and_even_widths() {
        let time: Vec<f64> = (0..20).map(f64::from).collect();
        let line: Vec<f64> = time.iter().map(|t| 2.0 * t - 3.0).collect();
        for width in 1..8 {
            let smoothed = smooth(&time, &line, Smoothing::MovingAverage { width }).unwrap();
            for (smoothed, original) in smoothed.iter().zip(&line) {
                approx::assert_relative_eq!(smoothed, original, epsilon = 1e-12);
            }
        }
        assert!(smooth(&time, &line, Smoothing::MovingAverage { width: 0 }).is_err());
    }

    #[test]
    fn moving_average_of_four_removes_an_oscillation_of_four_samples() {
        let time: Vec<f64> = (0..40).map(f64::from).collect();
        let wave: Vec<f64> = (0..40).map(|k| [0.0, 1.0, 0.0, -1.0][k % 4]).collect();
        let smoothed = smooth(&time, &wave, Smoothing::MovingAverage { width: 4 }).unwrap();
        for value in &smoothed[2..38] {
            approx::assert_relative_eq!(*value, 0.0, epsilon = 1e-15);
        }
    }
}
