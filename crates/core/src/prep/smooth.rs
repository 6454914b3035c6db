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

#[cfg(test)]
mod tests {
    use super::*;

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
