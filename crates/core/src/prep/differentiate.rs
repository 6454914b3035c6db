//! Differentiation of sampled signals.

use super::local_polynomial::local_polynomial;
use super::{PrepError, check, even_step};

/// How a signal is differentiated.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Differentiation {
    /// Central difference of order four, of order two one-sided over the two samples at each end (thesis Eq. D.1-D.2).
    Central4,
    /// Central difference of order `2 half_width`; near the ends of the order the samples there allow, down to a one-sided
    /// difference of order two at the first and last sample. High orders do not smooth: they suit signals already smooth.
    Central {
        /// Samples on each side, 1 to 8.
        half_width: usize,
    },
    /// Slope of a polynomial fitted by least squares to the `2 half_width + 1` samples about each sample; near the
    /// ends the nearest full window. Any increasing time.
    LocalPolynomial {
        /// Degree of the polynomial, at least 1.
        degree: usize,
        /// Samples on each side.
        half_width: usize,
    },
}

impl Differentiation {
    /// Samples on each side that the derivative inside a record takes.
    pub fn half_width(self) -> usize {
        match self {
            Self::Central4 => 2,
            Self::Central { half_width } | Self::LocalPolynomial { half_width, .. } => half_width,
        }
    }
}

/// First derivative of `values` with respect to time, one per sample, unit of the values per second.
///
/// `Central4`: `f' = (-f(t+2h) + 8 f(t+h) - 8 f(t-h) + f(t-2h)) / (12 h)`, at the ends
/// `f' = (-3 f(t) + 4 f(t+h) - f(t+2h)) / (2 h)` and its mirror image (thesis Eq. D.1-D.2).
///
/// `Central`: `f' = sum_{j=1..m} 2 (-1)^(j+1) (m!)^2 / (j (m-j)! (m+j)!) (f(t+jh) - f(t-jh)) / (2 h)`.
///
/// # Errors
/// Lengths that differ, time that does not increase, fewer than 5 samples (or than the window of the polynomial), and
/// for central differences a step that is not constant.
pub fn differentiate(time_s: &[f64], values: &[f64], method: Differentiation) -> Result<Vec<f64>, PrepError> {
    match method {
        Differentiation::Central4 => {
            check(time_s, values, "the central difference of order four", 5)?;
            Ok(central4(values, even_step(time_s)?))
        }
        Differentiation::Central { half_width } => {
            check(time_s, values, "the central difference", 3)?;
            if !(1..=MAX_HALF_WIDTH).contains(&half_width) {
                return Err(PrepError::Setting {
                    setting: "half_width",
                    value: half_width as f64,
                    allowed: "1 to 8 samples on each side",
                });
            }
            Ok(central(values, even_step(time_s)?, half_width))
        }
        Differentiation::LocalPolynomial { degree, half_width } => {
            if degree == 0 {
                return Err(PrepError::Setting {
                    setting: "degree",
                    value: 0.0,
                    allowed: "at least 1 to differentiate",
                });
            }
            local_polynomial(time_s, values, degree, half_width, 1)
        }
    }
}

/// Largest half width of a central difference: order 16.
const MAX_HALF_WIDTH: usize = 8;

/// Central differences of the highest order up to `2 half_width` that the samples about each sample allow.
fn central(f: &[f64], h: f64, half_width: usize) -> Vec<f64> {
    let weights: Vec<Vec<f64>> = (0..=half_width).map(central_weights).collect();
    let n = f.len();
    (0..n)
        .map(|k| match half_width.min(k).min(n - 1 - k) {
            0 if k == 0 => (-3.0 * f[0] + 4.0 * f[1] - f[2]) / (2.0 * h),
            0 => (3.0 * f[k] - 4.0 * f[k - 1] + f[k - 2]) / (2.0 * h),
            reach => (1..=reach).map(|j| weights[reach][j - 1] * (f[k + j] - f[k - j])).sum::<f64>() / h,
        })
        .collect()
}

/// Weight of the pair of samples at distance `j = 1..=m` in the central difference of order `2 m`:
/// `(-1)^(j+1) (m!)^2 / (j (m-j)! (m+j)!)`.
fn central_weights(m: usize) -> Vec<f64> {
    let mut ratio = 1.0;
    (1..=m)
        .map(|j| {
            ratio *= (m + 1 - j) as f64 / (m + j) as f64;
            if j % 2 == 1 { ratio / j as f64 } else { -ratio / j as f64 }
        })
        .collect()
}

/// Thesis Eq. D.1 inside, D.2 over two samples at each end.
fn central4(f: &[f64], h: f64) -> Vec<f64> {
    let n = f.len();
    (0..n)
        .map(|k| match k {
            0 | 1 => (-3.0 * f[k] + 4.0 * f[k + 1] - f[k + 2]) / (2.0 * h),
            _ if k + 2 >= n => (3.0 * f[k] - 4.0 * f[k - 1] + f[k - 2]) / (2.0 * h),
            _ => (-f[k + 2] + 8.0 * f[k + 1] - 8.0 * f[k - 1] + f[k - 2]) / (12.0 * h),
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Rounding of a difference quotient with a step of 0.01 s and values of order one.
    const ROUNDING: f64 = 1e-12;

    #[test]
    fn central_difference_is_exact_for_a_quartic_inside_and_a_parabola_at_the_ends() {
        let time: Vec<f64> = (0..40).map(|k| 0.25 * f64::from(k)).collect();
        let quartic: Vec<f64> = time.iter().map(|t| 0.01 * t.powi(4) - t).collect();
        let slope = differentiate(&time, &quartic, Differentiation::Central4).unwrap();
        for k in 2..38 {
            approx::assert_relative_eq!(
                slope[k],
                0.04 * time[k].powi(3) - 1.0,
                max_relative = ROUNDING,
                epsilon = 1e-11
            );
        }
        let parabola: Vec<f64> = time.iter().map(|t| 3.0 * t * t).collect();
        let slope = differentiate(&time, &parabola, Differentiation::Central4).unwrap();
        for k in 0..40 {
            approx::assert_relative_eq!(slope[k], 6.0 * time[k], epsilon = 1e-10);
        }
    }

    #[test]
    fn central_difference_of_order_2m_is_exact_for_powers_up_to_2m() {
        let time: Vec<f64> = (-12..=12).map(|k| f64::from(k) / 12.0).collect();
        for half_width in 1..=8 {
            for power in 0..=2 * half_width as i32 {
                let values: Vec<f64> = time.iter().map(|t| t.powi(power)).collect();
                let slope = differentiate(&time, &values, Differentiation::Central { half_width }).unwrap();
                for k in half_width..time.len() - half_width {
                    let exact = if power == 0 { 0.0 } else { f64::from(power) * time[k].powi(power - 1) };
                    approx::assert_relative_eq!(slope[k], exact, epsilon = 1e-10);
                }
            }
        }
        assert_eq!(central_weights(8)[0], 8.0 / 9.0);
        assert!(differentiate(&time, &time, Differentiation::Central { half_width: 9 }).is_err());
    }

    #[test]
    fn differentiation_rejects_short_uneven_and_backward_time() {
        let central = Differentiation::Central4;
        assert!(matches!(
            differentiate(&[0.0, 1.0, 2.0, 3.0], &[0.0; 4], central),
            Err(PrepError::TooFewSamples { needed: 5, found: 4, .. })
        ));
        let uneven = [0.0, 1.0, 2.0, 3.5, 4.0];
        assert!(matches!(differentiate(&uneven, &[0.0; 5], central), Err(PrepError::UnevenStep { .. })));
        let backward = [0.0, 1.0, 0.5, 3.0, 4.0];
        assert!(matches!(
            differentiate(&backward, &[0.0; 5], central),
            Err(PrepError::TimeNotIncreasing { time_s: 1.0 })
        ));
        assert!(matches!(differentiate(&[0.0; 5], &[0.0; 4], central), Err(PrepError::Length { time: 5, values: 4 })));
    }
}
