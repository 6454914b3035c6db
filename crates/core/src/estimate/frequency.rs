//! Equation error in the frequency domain.

use nalgebra::{Complex, DMatrix};

use super::least_squares::{check, check_values};
use super::triangle::Triangle;
use super::{EstimateError, Fit};

/// What is taken off each signal before it is transformed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Detrend {
    /// Its mean.
    Mean,
    /// The straight line through its first and last sample, so that both ends are zero.
    Ends,
}

/// Frequencies and treatment.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FrequencySettings {
    /// Lowest frequency, Hz; at least twice the inverse of the shortest window is advisable.
    pub lowest_hz: f64,
    /// Highest frequency, Hz; rigid-body motion ends at about 2 Hz.
    pub highest_hz: f64,
    /// Step of the grid, Hz.
    pub step_hz: f64,
    /// Detrending.
    pub detrend: Detrend,
}

impl Default for FrequencySettings {
    /// 0.1 to 2 Hz in steps of 0.02 Hz, lines through both ends removed.
    fn default() -> Self {
        Self { lowest_hz: 0.1, highest_hz: 2.0, step_hz: 0.02, detrend: Detrend::Ends }
    }
}

/// One window in the time domain, evenly sampled, without constant regressors.
#[derive(Clone, Debug, PartialEq)]
pub struct FrequencyWindow {
    /// Time step, s.
    pub step_s: f64,
    /// Regressors, samples by terms.
    pub x: DMatrix<f64>,
    /// Measurement at each sample.
    pub z: Vec<f64>,
}

/// Equation error in the frequency domain: least squares of the finite Fourier transforms of measurement and regressors over
/// a grid of frequencies, real and imaginary parts together, so that drift, bias and noise outside the band do not count.
///
/// `theta = Re(X* X)^-1 Re(X* z)`, `s^2 = |z - X theta|^2 / (M - p)` over all `M` frequencies of all windows, covariance
/// `s^2 Re(X* X)^-1` (Klein and Morelli, "Aircraft System Identification", 7.2). A grid finer than the inverse of the window
/// repeats information: the covariance is then too small by the ratio of the two. Fitted values and residuals are the real,
/// then the imaginary parts of each window in turn.
///
/// # Errors
/// As for [`super::least_squares`], a constant regressor among them (it is zero without its mean), and a grid that is
/// empty or reaches beyond half the sampling frequency.
pub fn frequency_equation_error(
    names: &[String],
    windows: &[FrequencyWindow],
    settings: &FrequencySettings,
) -> Result<Fit, EstimateError> {
    let grid = grid(settings, windows.iter().map(|window| window.step_s))?;
    let rows = 2 * grid.len();
    let mut x = DMatrix::zeros(rows * windows.len(), names.len());
    let mut z = Vec::with_capacity(rows * windows.len());
    for (index, window) in windows.iter().enumerate() {
        check_values(names, &window.x, &window.z)?;
        let transformed = |values: &[f64]| -> Vec<f64> {
            let spectrum = finite_fourier_transform(&detrended(values, settings.detrend), window.step_s, &grid);
            spectrum.iter().map(|value| value.re).chain(spectrum.iter().map(|value| value.im)).collect()
        };
        for (term, column) in window.x.column_iter().enumerate() {
            let values: Vec<f64> = column.iter().copied().collect();
            x.view_mut((rows * index, term), (rows, 1)).copy_from_slice(&transformed(&values));
        }
        z.extend(transformed(&window.z));
    }
    regress(names, &x, &z, grid.len() * windows.len())
}

/// Least squares of transforms, the real above the imaginary parts of each window, over `frequencies` of all windows together.
pub(super) fn regress(names: &[String], x: &DMatrix<f64>, z: &[f64], frequencies: usize) -> Result<Fit, EstimateError> {
    check(names, x, z)?;
    if frequencies <= names.len() {
        return Err(EstimateError::TooFewSamples { samples: frequencies, parameters: names.len() });
    }
    let triangle = Triangle::reduce(x, z);
    let solution = triangle.solve(names)?;
    let variance = triangle.residual_square() / (frequencies - names.len()) as f64;
    let fitted = x * &solution.estimates;
    Ok(Fit::with_variance(names, z, fitted.as_slice(), solution, variance))
}

/// Finite Fourier transform `integral of x(t) exp(-j w t) dt` from the first sample (t = 0) to the last, at each angular
/// frequency of `omega_rad_s`, exact for straight lines between samples `step_s` apart.
///
/// With `a = w h`: `h (W(a) sum x_k e^(-j a k) + E(a) x_0 + conj(E(a)) e^(-j a (n-1)) x_{n-1})`, `W = 2 (1 - cos a) / a^2`,
/// `E = -(1 - cos a) / a^2 - j (a - sin a) / a^2` (Press et al., "Numerical Recipes", 13.9).
pub fn finite_fourier_transform(values: &[f64], step_s: f64, omega_rad_s: &[f64]) -> Vec<Complex<f64>> {
    omega_rad_s
        .iter()
        .map(|omega| {
            let angle = omega * step_s;
            let sum = values.iter().zip(0..).map(|(value, k)| Complex::from_polar(*value, -angle * f64::from(k))).sum();
            correct_ends(sum, values, step_s, *omega)
        })
        .collect()
}

/// The integral of [`finite_fourier_transform`] from the plain sum `sum x_k e^(-j w k h)` at one angular frequency; zero of no values.
pub fn correct_ends(sum: Complex<f64>, values: &[f64], step_s: f64, omega_rad_s: f64) -> Complex<f64> {
    let Some((&first, &last)) = values.first().zip(values.last()) else { return Complex::new(0.0, 0.0) };
    let turned = Complex::from_polar(last, -omega_rad_s * step_s * (values.len() - 1) as f64);
    integral_of_sum(sum, (Complex::from(first), turned), step_s, omega_rad_s)
}

/// The integral from the plain sum and its first and last addend.
pub(super) fn integral_of_sum(
    sum: Complex<f64>,
    (first, last): (Complex<f64>, Complex<f64>),
    step_s: f64,
    omega_rad_s: f64,
) -> Complex<f64> {
    let (half_weight, end) = corrections(omega_rad_s * step_s);
    let edge = Complex::new(-half_weight, -end);
    (sum * 2.0 * half_weight + edge * first + edge.conj() * last) * step_s
}

/// `(1 - cos a) / a^2` and `(a - sin a) / a^2`, by their series where the differences would cancel.
fn corrections(angle: f64) -> (f64, f64) {
    /// Angle below which the next term of the series, a^6 / 40320, is beyond double precision.
    const SERIES: f64 = 0.01;
    let square = angle * angle;
    if angle.abs() < SERIES {
        return (0.5 - square / 24.0 + square * square / 720.0, angle / 6.0 - angle * square / 120.0);
    }
    ((1.0 - angle.cos()) / square, (angle - angle.sin()) / square)
}

/// Angular frequencies of the grid, rad/s, for records of each of these steps.
pub(super) fn grid(
    settings: &FrequencySettings,
    mut steps_s: impl Iterator<Item = f64>,
) -> Result<Vec<f64>, EstimateError> {
    let FrequencySettings { lowest_hz, highest_hz, step_hz, .. } = *settings;
    let fault = |setting: &str, value, allowed| EstimateError::Setting { setting: setting.to_owned(), value, allowed };
    if !(step_hz > 0.0 && step_hz.is_finite()) {
        return Err(fault("step_hz", step_hz, "positive and finite"));
    }
    if !(lowest_hz > 0.0 && lowest_hz < highest_hz) {
        return Err(fault("lowest_hz", lowest_hz, "positive and below highest_hz"));
    }
    if !steps_s.all(|step_s| step_s > 0.0 && highest_hz < 0.5 / step_s) {
        return Err(fault("highest_hz", highest_hz, "below half the sampling frequency"));
    }
    let count = ((highest_hz - lowest_hz) / step_hz).round() as usize + 1;
    Ok((0..count).map(|k| std::f64::consts::TAU * (lowest_hz + step_hz * k as f64)).collect())
}

/// Values less their trend.
fn detrended(values: &[f64], detrend: Detrend) -> Vec<f64> {
    let Some((&first, &last)) = values.first().zip(values.last()) else { return Vec::new() };
    match detrend {
        Detrend::Mean => {
            let mean = values.iter().sum::<f64>() / values.len() as f64;
            values.iter().map(|value| value - mean).collect()
        }
        Detrend::Ends => {
            let slope = (last - first) / (values.len().max(2) - 1) as f64;
            values.iter().enumerate().map(|(k, value)| value - first - slope * k as f64).collect()
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn transform_of_a_line_matches_its_integral() {
        // x = 1 + 2 t over 0..3 s: integral by parts.
        let step = 0.1;
        let values: Vec<f64> = (0..=30).map(|k| 1.0 + 2.0 * step * f64::from(k)).collect();
        for omega in [1e-3, 0.05, 0.7, 6.0] {
            let j = Complex::new(0.0, 1.0);
            let exact = {
                let end = (-j * omega * 3.0).exp();
                (Complex::from(1.0) - end * 7.0) / (j * omega) + (Complex::from(1.0) - end) * 2.0 / (j * omega).powi(2)
            };
            let found = finite_fourier_transform(&values, step, &[omega])[0];
            // Differences of terms of order 1/omega^2 limit the closed form, not the transform.
            assert!((found - exact).norm() < 1e-14 / (omega * omega) + 1e-11, "{omega}: {found} {exact}");
        }
    }

    #[test]
    fn corrections_join_their_series() {
        for angle in [0.00999, 0.01001] {
            let (half, end) = corrections(angle);
            approx::assert_relative_eq!(half, 0.5 - angle * angle / 24.0 + angle.powi(4) / 720.0, max_relative = 1e-11);
            approx::assert_relative_eq!(end, angle / 6.0 - angle.powi(3) / 120.0, max_relative = 1e-9);
        }
    }
}
