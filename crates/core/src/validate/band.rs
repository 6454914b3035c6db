//! The band in which a fit expects its observations.

use nalgebra::DMatrix;

use crate::estimate::Fit;

/// Standard deviation of an observation about its fitted value at each sample, in units of the measurement:
/// `sqrt(s^2 + x' D R D x)`, with s the standard deviation of the residual, R the correlation of the parameters (p by p) and D the
/// diagonal of their errors (Klein and Morelli, "Aircraft System Identification", 5.1.4). `x`: regressors, n by p, in the order of the
/// fit; `errors`: corrected standard errors, p, so that residuals correlated in time count; one that is not finite is replaced by the
/// conventional one. Plus and minus 1.96 times it hold 95 % of the observations of a fit whose residuals are normal. Empty where the
/// sizes do not agree.
pub fn observation_deviation(fit: &Fit, errors: &[f64], x: &DMatrix<f64>) -> Vec<f64> {
    let count = fit.parameters();
    if x.ncols() != count || errors.len() != count || fit.correlation.nrows() != count {
        return Vec::new();
    }
    let error = |at: usize| {
        let error = if errors[at].is_finite() { errors[at] } else { fit.standard_errors[at] };
        if error.is_finite() { error } else { 0.0 }
    };
    let finite = |value: f64| if value.is_finite() { value } else { 0.0 };
    let covariance = DMatrix::from_fn(count, count, |i, j| error(i) * finite(fit.correlation[(i, j)]) * error(j));
    let projected = x * covariance;
    let of_sample = |(a, b): (nalgebra::RowDVector<f64>, nalgebra::RowDVector<f64>)| {
        (fit.residual_std.powi(2) + a.dot(&b).max(0.0)).sqrt()
    };
    let rows = projected.row_iter().zip(x.row_iter());
    rows.map(|(a, b)| of_sample((a.into_owned(), b.into_owned()))).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::estimate::least_squares;

    #[test]
    fn observations_lie_in_their_band_as_often_as_stated_and_it_widens_away_from_the_data() {
        let at = |k: usize| k as f64 / 200.0 - 1.0;
        let mut state = 7_u64;
        let mut uniform = || {
            state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            (state >> 11) as f64 / (1_u64 << 53) as f64
        };
        // Twelve uniform values less six are close to normal with unit deviation.
        let mut normal = || (0..12).map(|_| uniform()).sum::<f64>() - 6.0;
        let x = DMatrix::from_fn(400, 2, |row, column| if column == 0 { 1.0 } else { at(row) });
        let z: Vec<f64> = (0..400).map(|row| 2.0 + 3.0 * at(row) + 0.4 * normal()).collect();
        let fit = least_squares(&["a".to_owned(), "b".to_owned()], &x, &z).unwrap();
        let band = observation_deviation(&fit, &fit.standard_errors, &x);
        let inside = fit.residuals.iter().zip(&band).filter(|(v, s)| v.abs() < 1.96 * **s).count();
        assert!((370..=390).contains(&inside), "95 % of 400: {inside}");
        assert!(band[0] > band[200] && (band[200] / 0.4 - 1.0).abs() < 0.1, "{} {}", band[0], band[200]);
        assert!(observation_deviation(&fit, &[], &x).is_empty());
    }
}
