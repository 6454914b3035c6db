//! Least-squares polynomials over a moving window of samples.

use nalgebra::{DMatrix, DVector};

use super::{PrepError, check, even_step};

/// Value (`derivative = 0`) or slope (`derivative = 1`) at each sample of the polynomial of `degree` fitted by least
/// squares to the `2 half_width + 1` samples about it; at the ends the nearest full window. For an even step this is the
/// filter of Savitzky and Golay (Anal. Chem. 36, 1964, p. 1627).
pub(super) fn local_polynomial(
    time_s: &[f64],
    values: &[f64],
    degree: usize,
    half_width: usize,
    derivative: usize,
) -> Result<Vec<f64>, PrepError> {
    let width = 2 * half_width + 1;
    if degree >= width {
        return Err(PrepError::Degree { degree, width });
    }
    check(time_s, values, "the local polynomial", width)?;
    let last_start = values.len() - width;
    let even = values.len() > 1 && even_step(time_s).is_ok();
    let at = |k: usize| {
        let start = k.saturating_sub(half_width).min(last_start);
        let window = start..start + width;
        let weights = weights(&time_s[window.clone()], time_s[k], degree, derivative);
        weights.iter().zip(&values[window]).map(|(weight, value)| weight * value).sum::<f64>()
    };
    if !even {
        return Ok((0..values.len()).map(at).collect());
    }
    let inside = moving_sum(values, &weights(&time_s[..width], time_s[half_width], degree, derivative));
    let last_inside = half_width + inside.len();
    Ok((0..half_width).map(at).chain(inside).chain((last_inside..values.len()).map(at)).collect())
}

/// `sum_k weights[k] values[i + k]` for every `i` that has all its neighbours. Weight by weight, so that samples go side by side.
pub(super) fn moving_sum(values: &[f64], weights: &[f64]) -> Vec<f64> {
    let mut sums = vec![0.0; (values.len() + 1).saturating_sub(weights.len())];
    for (weight, values) in weights.iter().zip((0..).map_while(|k| values.get(k..))) {
        for (sum, value) in sums.iter_mut().zip(values) {
            *sum += weight * value;
        }
    }
    sums
}

/// Weights of the samples at `window` in the value or slope of the fitted polynomial at `at`.
///
/// With the Vandermonde matrix `V = Q R` in the scaled time `(t - at) / s`, the coefficients are `R^-1 Q' f`, and the
/// weights of coefficient `d` are row `d` of `R^-1 Q'`.
pub(super) fn weights(window: &[f64], at: f64, degree: usize, derivative: usize) -> Vec<f64> {
    let scale = (window[window.len() - 1] - window[0]).max(f64::MIN_POSITIVE);
    let vandermonde =
        DMatrix::from_fn(window.len(), degree + 1, |row, power| ((window[row] - at) / scale).powi(power as i32));
    let qr = vandermonde.qr();
    let mut unit = DVector::zeros(degree + 1);
    unit[derivative] = 1.0;
    qr.r().tr_solve_upper_triangular_mut(&mut unit);
    let weights = qr.q() * unit;
    weights.iter().map(|weight| weight / scale.powi(derivative as i32)).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn weights_match_savitzky_golay_table() {
        // Savitzky and Golay 1964, table I (smoothing, quadratic, 5 points) and table IV (first derivative, 5 points).
        let window = [-2.0, -1.0, 0.0, 1.0, 2.0];
        for (weight, numerator) in weights(&window, 0.0, 2, 0).iter().zip([-3.0, 12.0, 17.0, 12.0, -3.0]) {
            approx::assert_relative_eq!(*weight, numerator / 35.0, epsilon = 1e-14);
        }
        for (weight, numerator) in weights(&window, 0.0, 2, 1).iter().zip([-2.0, -1.0, 0.0, 1.0, 2.0]) {
            approx::assert_relative_eq!(*weight, numerator / 10.0, epsilon = 1e-14);
        }
    }

    #[test]
    fn cubic_comes_back_exactly_at_uneven_times_and_at_the_ends() {
        let time: Vec<f64> = (0..30).map(|k| f64::from(k) * 0.1 + 0.03 * f64::from(k % 3)).collect();
        let cubic: Vec<f64> = time.iter().map(|t| t.powi(3) - 2.0 * t).collect();
        let value = local_polynomial(&time, &cubic, 3, 4, 0).unwrap();
        let slope = local_polynomial(&time, &cubic, 3, 4, 1).unwrap();
        for k in 0..30 {
            approx::assert_relative_eq!(value[k], cubic[k], epsilon = 1e-11);
            approx::assert_relative_eq!(slope[k], 3.0 * time[k].powi(2) - 2.0, epsilon = 1e-9);
        }
        assert_eq!(local_polynomial(&time, &cubic, 3, 1, 0), Err(PrepError::Degree { degree: 3, width: 3 }));
    }
}
