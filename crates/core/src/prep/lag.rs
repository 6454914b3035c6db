//! Lag and delay of a signal.

use super::{Interpolation, PrepError, check, resample};

/// Output of a first-order lag `tau y' + y = x` driven by `values`, linear between samples, starting in equilibrium.
///
/// Exact over each step h for a linear input: with `e = exp(-h / tau)` and the slope `s = (x1 - x0) / h`,
/// `y1 = x1 - s tau + (y0 - x0 + s tau) e`. A time constant of zero returns the input.
///
/// # Errors
/// Lengths that differ, time that does not increase, a time constant that is negative or not finite.
pub fn first_order_lag(time_s: &[f64], values: &[f64], time_constant_s: f64) -> Result<Vec<f64>, PrepError> {
    check(time_s, values, "the lag", 1)?;
    check_not_negative("time constant", time_constant_s)?;
    if time_constant_s == 0.0 {
        return Ok(values.to_vec());
    }
    let mut output = Vec::with_capacity(values.len());
    let mut y = values[0];
    output.push(y);
    for (time, x) in time_s.windows(2).zip(values.windows(2)) {
        let step = time[1] - time[0];
        let ramp = (x[1] - x[0]) / step * time_constant_s;
        y = x[1] - ramp + (y - x[0] + ramp) * (-step / time_constant_s).exp();
        output.push(y);
    }
    Ok(output)
}

/// Signal `values(t - delay_s)`, linear between samples; before the first sample it holds the first value, after the last, where a
/// negative delay reaches, the last.
///
/// # Errors
/// Lengths that differ, time that does not increase, a delay that is not finite.
pub fn delay(time_s: &[f64], values: &[f64], delay_s: f64) -> Result<Vec<f64>, PrepError> {
    check(time_s, values, "the delay", 1)?;
    if !delay_s.is_finite() {
        return Err(PrepError::Setting { setting: "delay", value: delay_s, allowed: "finite, s" });
    }
    if delay_s == 0.0 {
        return Ok(values.to_vec());
    }
    let earlier: Vec<f64> = time_s.iter().map(|t| (t - delay_s).clamp(time_s[0], time_s[time_s.len() - 1])).collect();
    resample(time_s, values, &earlier, Interpolation::Linear)
}

/// Checks that a duration is finite and not negative.
fn check_not_negative(setting: &'static str, value: f64) -> Result<(), PrepError> {
    if value >= 0.0 && value.is_finite() {
        return Ok(());
    }
    Err(PrepError::Setting { setting, value, allowed: "finite and not negative, s" })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lag_of_a_ramp_matches_its_closed_solution_at_uneven_times() {
        let tau = 0.08;
        let time: Vec<f64> = (0..50).map(|k| 0.02 * f64::from(k) + 0.005 * f64::from(k % 2)).collect();
        let ramp: Vec<f64> = time.iter().map(|t| 3.0 * t).collect();
        for (lagged, t) in first_order_lag(&time, &ramp, tau).unwrap().iter().zip(&time) {
            approx::assert_relative_eq!(*lagged, 3.0 * (t - tau * (1.0 - (-t / tau).exp())), epsilon = 1e-13);
        }
    }

    #[test]
    fn delay_shifts_a_line_and_holds_the_first_value() {
        let time: Vec<f64> = (0..11).map(|k| 0.1 * f64::from(k)).collect();
        let delayed = delay(&time, &time, 0.25).unwrap();
        for (value, t) in delayed.iter().zip(&time) {
            approx::assert_relative_eq!(*value, (t - 0.25).max(0.0), epsilon = 1e-14);
        }
        for (value, t) in delay(&time, &time, -0.25).unwrap().iter().zip(&time) {
            approx::assert_relative_eq!(*value, (t + 0.25).min(1.0), epsilon = 1e-14);
        }
        assert!(matches!(delay(&time, &time, f64::INFINITY), Err(PrepError::Setting { setting: "delay", .. })));
        assert!(matches!(first_order_lag(&time, &time, f64::NAN), Err(PrepError::Setting { .. })));
    }
}
