//! Integration of sampled signals, and the stretches between gaps it may not cross.

use std::ops::Range;

use super::{PrepError, check};

/// Running integral by the trapezoidal rule, zero at the first sample, unit of the values times s:
/// `I_k = I_(k-1) + (t_k - t_(k-1)) (f_(k-1) + f_k) / 2` (thesis Eq. D.3).
///
/// # Errors
/// Lengths that differ, time that does not increase, no samples.
pub fn cumulative_trapezoid(time_s: &[f64], values: &[f64]) -> Result<Vec<f64>, PrepError> {
    check(time_s, values, "the trapezoidal rule", 1)?;
    let mut integral = Vec::with_capacity(values.len());
    let mut sum = 0.0;
    integral.push(sum);
    for (time, value) in time_s.windows(2).zip(values.windows(2)) {
        sum += 0.5 * (time[1] - time[0]) * (value[0] + value[1]);
        integral.push(sum);
    }
    Ok(integral)
}

/// Index ranges of the stretches of an increasing time vector that have no interval longer than `max_gap_s`.
pub fn stretches(time_s: &[f64], max_gap_s: f64) -> Vec<Range<usize>> {
    let mut start = 0;
    let mut found = Vec::new();
    for k in 1..=time_s.len() {
        if k == time_s.len() || time_s[k] - time_s[k - 1] > max_gap_s {
            found.push(start..k);
            start = k;
        }
    }
    found
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn trapezoids_are_exact_for_a_line_at_uneven_times() {
        let time = [0.0, 0.5, 2.0, 2.25];
        let integral = cumulative_trapezoid(&time, &time.map(|t| 2.0 * t + 1.0)).unwrap();
        for (found, t) in integral.iter().zip(time) {
            approx::assert_relative_eq!(*found, t * t + t, epsilon = 1e-14);
        }
        assert!(cumulative_trapezoid(&[0.0, 0.0], &[1.0, 1.0]).is_err());
    }

    #[test]
    fn stretches_end_at_gaps() {
        assert_eq!(stretches(&[0.0, 0.1, 0.2, 5.0, 5.1, 9.0], 1.0), [0..3, 3..5, 5..6]);
        assert!(stretches(&[], 1.0).is_empty());
    }
}
