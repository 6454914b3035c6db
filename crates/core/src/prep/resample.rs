//! Resampling onto another time base.

use serde::{Deserialize, Serialize};

use super::{PrepError, check};

/// What a signal does between its samples.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Interpolation {
    /// Straight lines.
    Linear,
    /// Parabolas with a continuous first derivative, joined midway between samples; the first and last two share one
    /// parabola each ("not a knot"). The thesis (4.4.3) uses it for air data of 1 to 5 Hz; it rings where the signal is
    /// sharp.
    QuadraticSpline,
}

/// Values at `at_s`, each inside the range of `time_s`.
///
/// # Errors
/// Lengths that differ, time that does not increase, fewer than 2 samples (3 for the spline), times outside the range.
pub fn resample(
    time_s: &[f64],
    values: &[f64],
    at_s: &[f64],
    interpolation: Interpolation,
) -> Result<Vec<f64>, PrepError> {
    match interpolation {
        Interpolation::Linear => check(time_s, values, "linear interpolation", 1)?,
        Interpolation::QuadraticSpline => check(time_s, values, "the quadratic spline", 3)?,
    }
    let (start_s, end_s) = (time_s[0], time_s[time_s.len() - 1]);
    if let Some(&time_s) = at_s.iter().find(|&&t| !(t >= start_s && t <= end_s)) {
        return Err(PrepError::OutsideRange { time_s, start_s, end_s });
    }
    Ok(match interpolation {
        Interpolation::Linear => {
            let mut right = 0;
            let value = |&t: &f64| {
                right = first_not_before(time_s, t, right);
                linear(time_s, values, t, right)
            };
            at_s.iter().map(value).collect()
        }
        Interpolation::QuadraticSpline => {
            let spline = QuadraticSpline::through(time_s, values);
            at_s.iter().map(|&t| spline.value(t)).collect()
        }
    })
}

/// First sample not before `t`; times asked for mostly go on from the one before, which was found at `last`.
fn first_not_before(time_s: &[f64], t: f64, last: usize) -> usize {
    /// Samples looked at one by one before all are searched.
    const NEAR: usize = 8;
    let follows = last == 0 || time_s[last - 1] < t;
    let near = time_s[last..].iter().take(NEAR).position(|&sample| sample >= t).filter(|_| follows);
    near.map_or_else(|| time_s.partition_point(|&sample| sample < t), |ahead| last + ahead)
}

/// Value at `t` on the straight line that ends at the sample `right`, the first not before it.
fn linear(time_s: &[f64], values: &[f64], t: f64, right: usize) -> f64 {
    if right == 0 || time_s[right] == t {
        return values[right];
    }
    let fraction = (t - time_s[right - 1]) / (time_s[right] - time_s[right - 1]);
    values[right - 1] + fraction * (values[right] - values[right - 1])
}

/// Piecewise parabola whose knots lie midway between the samples 1 to n-2.
struct QuadraticSpline {
    /// Interior knots.
    knots: Vec<f64>,
    /// Sample each piece is expanded about: time, value, slope, half the curvature.
    pieces: Vec<[f64; 4]>,
}

impl QuadraticSpline {
    /// The spline through all samples; at least three.
    ///
    /// Piece `j` is `f_j + b_j (t - t_j) + c_j (t - t_j)^2` about sample `j = 1 .. n-2`; the first piece also passes through
    /// sample 0 and the last through sample n-1. Continuity of value and slope at the midpoints gives, with
    /// `h_j = t_{j+1} - t_j`, the slope `m` at each midpoint as `(f_{j+1} - f_j) = h_j/4 (b_j + b_{j+1} + 2 m)`, and
    /// `m = b_j + c_j h_j = b_{j+1} - c_{j+1} h_j`: a tridiagonal system in the slopes `b`.
    fn through(time_s: &[f64], values: &[f64]) -> Self {
        let n = time_s.len();
        let step: Vec<f64> = time_s.windows(2).map(|pair| pair[1] - pair[0]).collect();
        let secant: Vec<f64> = (0..n - 1).map(|j| (values[j + 1] - values[j]) / step[j]).collect();
        // Unknown midpoint slopes m_j of the interior midpoints j = 1 .. n-3, between samples j and j+1.
        // From the continuity of value: b_j + b_{j+1} = 4 secant_j - 2 m_j; within piece j between midpoints j-1 and j:
        // b_j = (h_j m_{j-1} + h_{j-1} m_j) / (h_{j-1} + h_j).
        let interior = n.saturating_sub(3);
        if interior == 0 {
            let curvature = (secant[1] - secant[0]) / (step[0] + step[1]);
            let slope = secant[0] + curvature * step[0];
            return Self { knots: Vec::new(), pieces: vec![[time_s[1], values[1], slope, curvature]] };
        }
        let mut lower = vec![0.0; interior];
        let mut diagonal = vec![2.0; interior];
        let mut upper = vec![0.0; interior];
        let mut right = vec![0.0; interior];
        for row in 0..interior {
            let j = row + 1;
            right[row] = 4.0 * secant[j];
            if row > 0 {
                let span = step[j - 1] + step[j];
                lower[row] = step[j] / span;
                diagonal[row] += step[j - 1] / span;
            } else {
                // First piece passes through sample 0: b_1 = secant_0 + c_1 h_0 and m_1 = b_1 + c_1 h_1.
                let span = step[0] + step[1];
                diagonal[row] += step[0] / span;
                right[row] -= secant[0] * step[1] / span;
            }
            if row + 1 < interior {
                let span = step[j] + step[j + 1];
                upper[row] = step[j] / span;
                diagonal[row] += step[j + 1] / span;
            } else {
                // Last piece passes through sample n-1: secant = b + c h and m = b - c h_j.
                let span = step[n - 3] + step[n - 2];
                diagonal[row] += step[n - 2] / span;
                right[row] -= secant[n - 2] * step[n - 3] / span;
            }
        }
        let slope = solve_tridiagonal(&lower, &mut diagonal, &upper, right);
        let pieces = (1..n - 1)
            .map(|j| {
                let (b, c) = if j == 1 {
                    let c = (slope[0] - secant[0]) / (step[0] + step[1]);
                    (secant[0] + c * step[0], c)
                } else if j == n - 2 {
                    let c = (secant[j] - slope[j - 2]) / (step[j - 1] + step[j]);
                    (secant[j] - c * step[j], c)
                } else {
                    let span = step[j - 1] + step[j];
                    let (before, after) = (slope[j - 2], slope[j - 1]);
                    ((step[j] * before + step[j - 1] * after) / span, (after - before) / span)
                };
                [time_s[j], values[j], b, c]
            })
            .collect();
        let knots = (1..n - 2).map(|j| 0.5 * (time_s[j] + time_s[j + 1])).collect();
        Self { knots, pieces }
    }

    /// Value at `t`.
    fn value(&self, t: f64) -> f64 {
        let [at, f, b, c] = self.pieces[self.knots.partition_point(|&knot| knot < t)];
        f + (t - at) * (b + c * (t - at))
    }
}

/// Solution of a tridiagonal system that is diagonally dominant; `diagonal` is used up.
fn solve_tridiagonal(lower: &[f64], diagonal: &mut [f64], upper: &[f64], mut right: Vec<f64>) -> Vec<f64> {
    for row in 1..right.len() {
        let factor = lower[row] / diagonal[row - 1];
        diagonal[row] -= factor * upper[row - 1];
        right[row] -= factor * right[row - 1];
    }
    for row in (0..right.len()).rev() {
        let above = if row + 1 < right.len() { upper[row] * right[row + 1] } else { 0.0 };
        right[row] = (right[row] - above) / diagonal[row];
    }
    right
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn linear_resampling_hits_samples_and_midpoints() {
        let at = [0.0, 0.5, 1.0, 2.0, 3.0];
        assert_eq!(
            resample(&[0.0, 1.0, 3.0], &[1.0, 3.0, -1.0], &at, Interpolation::Linear).unwrap(),
            [1.0, 2.0, 3.0, 1.0, -1.0]
        );
        assert!(matches!(
            resample(&[0.0, 1.0], &[0.0; 2], &[1.5], Interpolation::Linear),
            Err(PrepError::OutsideRange { time_s: 1.5, .. })
        ));
    }

    #[test]
    fn quadratic_spline_matches_the_scipy_interpolation_the_thesis_names() {
        // scipy.interpolate.interp1d(kind="quadratic"), SciPy 1.17, 15 digits.
        let time = [0.0, 1.0, 2.5, 3.0, 4.0, 6.0, 7.0];
        let values = [0.0, 1.0, -1.0, 2.0, 0.5, 3.0, 1.0];
        let at = [0.4, 1.7, 2.8, 3.5, 5.2, 6.6];
        let expected = [
            0.921472851176083, -0.885636220414743, 0.924203121565178, 1.92487817835422, 2.00803693119367,
            2.23199384480106,
        ];
        let found = resample(&time, &values, &at, Interpolation::QuadraticSpline).unwrap();
        for (found, expected) in found.iter().zip(expected) {
            approx::assert_relative_eq!(*found, expected, max_relative = 1e-13);
        }
    }

    #[test]
    fn quadratic_spline_reproduces_a_parabola_at_uneven_times() {
        for count in 3..9 {
            let time: Vec<f64> = (0..count).map(|k| f64::from(k) + 0.2 * f64::from(k % 2)).collect();
            let values: Vec<f64> = time.iter().map(|t| 2.0 - t + 0.5 * t * t).collect();
            let at: Vec<f64> = (0..=100).map(|k| time[time.len() - 1] * f64::from(k) / 100.0).collect();
            for (value, t) in resample(&time, &values, &at, Interpolation::QuadraticSpline).unwrap().iter().zip(&at) {
                approx::assert_relative_eq!(*value, 2.0 - t + 0.5 * t * t, epsilon = 1e-11);
            }
        }
    }
}
