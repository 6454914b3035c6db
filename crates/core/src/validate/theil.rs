//! Theil's inequality coefficient.

/// Theil's coefficient of a prediction, and what its mean square error is made of.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Theil {
    /// `U = sqrt(mean (z-y)^2) / (sqrt(mean z^2) + sqrt(mean y^2))`: 0 for a perfect prediction, 1 for none; up to 0.25 to 0.3
    /// is accepted in flight-vehicle work. NaN when both are zero throughout.
    pub coefficient: f64,
    /// Share of the mean square error from a difference of means.
    pub bias: f64,
    /// Share from a difference of standard deviations.
    pub variance: f64,
    /// Share from imperfect correlation; the three sum to 1.
    pub covariance: f64,
}

/// Theil's inequality coefficient and the decomposition `MSE = (mean z - mean y)^2 + (s_z - s_y)^2 + 2 (1 - rho) s_z s_y`
/// (Theil, "Economic Forecasts and Policy", 1961; Jategaonkar, "Flight Vehicle System Identification", 11.2.2).
///
/// `measured` and `predicted` are perturbations from trim of one length: an offset common to both would make the
/// coefficient look small. The shares of a perfect prediction are zero.
pub fn theil(measured: &[f64], predicted: &[f64]) -> Theil {
    let samples = measured.len() as f64;
    let mean = |values: &mut dyn Iterator<Item = f64>| values.sum::<f64>() / samples;
    let (mean_z, mean_y) = (mean(&mut measured.iter().copied()), mean(&mut predicted.iter().copied()));
    let deviation_z = mean(&mut measured.iter().map(|z| (z - mean_z).powi(2))).sqrt();
    let deviation_y = mean(&mut predicted.iter().map(|y| (y - mean_y).powi(2))).sqrt();
    let error = mean(&mut measured.iter().zip(predicted).map(|(z, y)| (z - y).powi(2)));
    let size = mean(&mut measured.iter().map(|z| z * z)).sqrt() + mean(&mut predicted.iter().map(|y| y * y)).sqrt();
    let coefficient = error.sqrt() / size;
    if error == 0.0 {
        return Theil { coefficient, bias: 0.0, variance: 0.0, covariance: 0.0 };
    }
    let bias = (mean_z - mean_y).powi(2) / error;
    let variance = (deviation_z - deviation_y).powi(2) / error;
    Theil { coefficient, bias, variance, covariance: (1.0 - bias - variance).max(0.0) }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn theil_names_the_kind_of_error() {
        let wave: Vec<f64> = (0..200).map(|k| (f64::from(k) * 0.1 * std::f64::consts::PI).sin()).collect();
        let shifted: Vec<f64> = wave.iter().map(|value| value + 0.2).collect();
        let scaled: Vec<f64> = wave.iter().map(|value| 1.5 * value).collect();
        let quarter: Vec<f64> = (0..200).map(|k| (f64::from(k) * 0.1 * std::f64::consts::PI).cos()).collect();
        approx::assert_relative_eq!(theil(&wave, &shifted).bias, 1.0, epsilon = 1e-12);
        approx::assert_relative_eq!(theil(&wave, &scaled).variance, 1.0, epsilon = 1e-12);
        // Whole periods: both have mean square 1/2, the error has mean square 1.
        let found = theil(&wave, &quarter);
        approx::assert_relative_eq!(found.covariance, 1.0, epsilon = 1e-12);
        approx::assert_relative_eq!(found.coefficient, 0.5_f64.sqrt(), epsilon = 1e-12);
        assert_eq!(theil(&wave, &wave).coefficient, 0.0);
        let opposite: Vec<f64> = wave.iter().map(|value| -value).collect();
        approx::assert_relative_eq!(theil(&wave, &opposite).coefficient, 1.0, epsilon = 1e-12);
    }
}
