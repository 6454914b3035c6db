//! Period and damping of a free oscillation by its extremes (logarithmic decrement); [`super::measured`] fits the whole record.

use thiserror::Error;

/// A free oscillation by its extremes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Decrement {
    /// Period of the damped oscillation, s.
    pub period_s: f64,
    /// Its standard error from the scatter of the extremes, s; zero where only three are there.
    pub period_error_s: f64,
    /// Damping ratio.
    pub damping: f64,
    /// Its standard error.
    pub damping_error: f64,
    /// Undamped natural frequency, rad/s.
    pub frequency_rad_s: f64,
    /// Amplitude one period later over that before.
    pub amplitude_ratio_per_cycle: f64,
    /// Extremes used.
    pub extremes: usize,
}

impl Decrement {
    /// Real part of the eigenvalue, 1/s.
    pub fn real_1_s(&self) -> f64 {
        -self.damping * self.frequency_rad_s
    }

    /// Time to half the amplitude where it decays, s.
    pub fn time_to_half_s(&self) -> Option<f64> {
        (self.real_1_s() < 0.0).then(|| -std::f64::consts::LN_2 / self.real_1_s())
    }

    /// Time to double the amplitude where it grows, s.
    pub fn time_to_double_s(&self) -> Option<f64> {
        (self.real_1_s() > 0.0).then(|| std::f64::consts::LN_2 / self.real_1_s())
    }
}

/// Why there is no decrement.
#[derive(Clone, Debug, PartialEq, Error)]
pub enum DecrementError {
    /// Columns of different length.
    #[error("time has {times} samples, the signal {values}")]
    Length {
        /// Samples of time.
        times: usize,
        /// Samples of the signal.
        values: usize,
    },
    /// Too few extremes.
    #[error("{found} extremes in the record: at least three are needed, and more for a standard error")]
    TooFew {
        /// Extremes found.
        found: usize,
    },
}

/// Smallest swing between extremes that counts, as a share of the largest.
const SMALLEST_SWING: f64 = 0.02;

/// Reads period and damping of `x(t) = offset + a exp(-zeta w t) cos(w sqrt(1 - zeta^2) t + phase)`: its extremes, by a parabola through
/// three samples each, are half a period apart, and successive swings between them, which know no offset, fall by
/// `exp(-pi zeta / sqrt(1 - zeta^2))`. Both come from straight lines through all of them.
///
/// # Errors
/// [`DecrementError`], one line.
pub fn logarithmic_decrement(time_s: &[f64], values: &[f64]) -> Result<Decrement, DecrementError> {
    if time_s.len() != values.len() {
        return Err(DecrementError::Length { times: time_s.len(), values: values.len() });
    }
    let extremes = extremes(time_s, values);
    if extremes.len() < 3 {
        return Err(DecrementError::TooFew { found: extremes.len() });
    }
    let times: Vec<f64> = extremes.iter().map(|(time, _)| *time).collect();
    let swings: Vec<f64> = extremes.windows(2).map(|pair| (pair[1].1 - pair[0].1).abs().ln()).collect();
    let (half_period, half_error) = slope(&times);
    let (fall, fall_error) = slope(&swings);
    // fall = -pi zeta / sqrt(1 - zeta^2).
    let ratio = -fall / std::f64::consts::PI;
    let damping = ratio / (1.0 + ratio * ratio).sqrt();
    let frequency = std::f64::consts::PI / half_period * (1.0 + ratio * ratio).sqrt();
    Ok(Decrement {
        period_s: 2.0 * half_period,
        period_error_s: 2.0 * half_error,
        damping,
        damping_error: fall_error / std::f64::consts::PI / (1.0 + ratio * ratio).powf(1.5),
        frequency_rad_s: frequency,
        amplitude_ratio_per_cycle: (2.0 * fall).exp(),
        extremes: extremes.len(),
    })
}

/// Slope of values over their index by least squares and its standard error.
fn slope(values: &[f64]) -> (f64, f64) {
    let count = values.len() as f64;
    let (mean_index, mean) = ((count - 1.0) / 2.0, values.iter().sum::<f64>() / count);
    let (mut square, mut product) = (0.0, 0.0);
    for (index, value) in values.iter().enumerate() {
        let off = index as f64 - mean_index;
        square += off * off;
        product += off * (value - mean);
    }
    let slope = product / square;
    let residual = |(index, value): (usize, &f64)| value - mean - slope * (index as f64 - mean_index);
    let rest: f64 = values.iter().enumerate().map(residual).map(|rest| rest * rest).sum();
    let error = if values.len() > 2 { (rest / (count - 2.0) / square).sqrt() } else { 0.0 };
    (slope, error)
}

/// Times and values of the extremes inside the stretch, alternating; swings below a share of the largest are noise.
fn extremes(time_s: &[f64], values: &[f64]) -> Vec<(f64, f64)> {
    let lowest = values.iter().copied().fold(f64::INFINITY, f64::min);
    let highest = values.iter().copied().fold(f64::NEG_INFINITY, f64::max);
    let least = SMALLEST_SWING * (highest - lowest);
    let mut found: Vec<usize> = Vec::new();
    let (mut candidate, mut rising): (usize, Option<bool>) = (0, None);
    let mut least_index = 0;
    for (k, &value) in values.iter().enumerate() {
        match rising {
            None => {
                // The first direction: the farthest sample so far is where the first swing begins.
                if value > values[candidate] {
                    candidate = k;
                }
                if value < values[least_index] {
                    least_index = k;
                }
                if values[candidate] - value > least {
                    found.push(candidate);
                    (candidate, rising) = (k, Some(false));
                } else if value - values[least_index] > least {
                    found.push(least_index);
                    (candidate, rising) = (k, Some(true));
                }
            }
            Some(up) => {
                let further = if up { value > values[candidate] } else { value < values[candidate] };
                if further {
                    candidate = k;
                } else if (value - values[candidate]).abs() > least {
                    found.push(candidate);
                    (candidate, rising) = (k, Some(!up));
                }
            }
        }
    }
    let inside = |&&k: &&usize| k > 0 && k + 1 < values.len();
    found.iter().filter(inside).map(|&k| vertex(time_s, values, k)).collect()
}

/// Vertex of the parabola through sample `k` and its neighbours.
fn vertex(time_s: &[f64], values: &[f64], k: usize) -> (f64, f64) {
    let (before, after) = (time_s[k - 1] - time_s[k], time_s[k + 1] - time_s[k]);
    let (low, high) = (values[k - 1] - values[k], values[k + 1] - values[k]);
    // value = slope t + curve t^2 about the sample.
    let curve = (high / after - low / before) / (after - before);
    let slope = low / before - curve * before;
    if curve == 0.0 {
        return (time_s[k], values[k]);
    }
    let at = (-0.5 * slope / curve).clamp(before, after);
    (time_s[k] + at, values[k] + slope * at + curve * at * at)
}
