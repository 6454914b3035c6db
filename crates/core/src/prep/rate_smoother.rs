//! Angular acceleration as a state: a smoother over the samples of a rate.

use super::{PrepError, check};

/// Bandwidths among which the likelihood chooses, rad/s; the widest is that of the samples themselves.
const NARROWEST_RAD_S: f64 = 0.5;
/// Bandwidths looked at before the best is refined.
const GRID: usize = 16;
/// Steps of the refinement by golden section.
const REFINEMENTS: usize = 20;
/// Variance of the first slope over that of the noise per sample, times the squared step: nothing is known of it.
const DIFFUSE: f64 = 1e8;

/// Rate and its slope, one each per sample.
#[derive(Clone, Debug, PartialEq)]
pub struct SmoothedRate {
    /// Rate, unit of the samples.
    pub rate: Vec<f64>,
    /// Slope, unit of the samples per second.
    pub slope: Vec<f64>,
    /// Bandwidth the likelihood chose, rad/s.
    pub bandwidth_rad_s: f64,
}

/// State (rate, slope) and the three entries of its symmetric covariance over the noise variance of a sample.
#[derive(Clone, Copy)]
struct Moments {
    x: [f64; 2],
    p: [f64; 3],
}

/// Slope of a sampled rate by a Rauch-Tung-Striebel smoother over the model `w' = a`, `a' = n` with white `n` of density
/// `q` and white noise of variance `r` on the samples, any increasing time.
///
/// The ratio `q / r` is that of the largest likelihood, with `r` taken out of it (Kitagawa and Gersch, "Smoothness Priors Analysis of Time
/// Series", 1996, ch. 2); it is stated as the bandwidth `(q / (r h))^(1/4)` for the mean step `h`. For even samples the result is the cubic smoothing
/// spline of that ratio (Wahba 1978).
///
/// # Errors
/// Lengths that differ, time that does not increase, fewer than five samples, values that are not finite.
pub fn smoothed_rate(time_s: &[f64], values: &[f64]) -> Result<SmoothedRate, PrepError> {
    check(time_s, values, "the smoother of a rate", 5)?;
    if let Some(&value) = values.iter().find(|value| !value.is_finite()) {
        return Err(PrepError::Setting { setting: "a sample of the rate", value, allowed: "a finite number" });
    }
    let step_s = (time_s[time_s.len() - 1] - time_s[0]) / (time_s.len() - 1) as f64;
    let widest = (std::f64::consts::PI / step_s).max(2.0 * NARROWEST_RAD_S);
    let (low, high) = (NARROWEST_RAD_S.ln(), widest.ln());
    let ratio = |log_bandwidth: f64| (4.0 * log_bandwidth).exp() * step_s;
    let cost = |log_bandwidth: f64| minus_log_likelihood(time_s, values, ratio(log_bandwidth));
    let width = (high - low) / GRID as f64;
    let grid = (0..=GRID).map(|k| low + width * k as f64);
    let best = grid
        .map(|at| (cost(at), at))
        .fold((f64::INFINITY, high), |best, next| if next.0 < best.0 { next } else { best })
        .1;
    let at = refined(cost, (best - width).max(low), (best + width).min(high));
    let (rate, slope) = smoother(time_s, values, ratio(at));
    Ok(SmoothedRate { rate, slope, bandwidth_rad_s: at.exp() })
}

/// Least point of `cost` between two by golden section.
fn refined(cost: impl Fn(f64) -> f64, mut low: f64, mut high: f64) -> f64 {
    let golden = (5.0_f64.sqrt() - 1.0) / 2.0;
    for _ in 0..REFINEMENTS {
        let (left, right) = (high - golden * (high - low), low + golden * (high - low));
        if cost(left) < cost(right) { high = right } else { low = left }
    }
    0.5 * (low + high)
}

/// Before the first sample: the rate is that sample within its noise, the slope is open.
fn first(time_s: &[f64], values: &[f64]) -> Moments {
    Moments { x: [values[0], 0.0], p: [1.0, 0.0, DIFFUSE / (time_s[1] - time_s[0]).powi(2)] }
}

/// Prediction over `dt` with `ratio = q / r`.
fn predicted(at: &Moments, dt: f64, ratio: f64) -> Moments {
    let ([w, a], [ww, wa, aa]) = (at.x, at.p);
    let noise = [ratio * dt.powi(3) / 3.0, ratio * dt.powi(2) / 2.0, ratio * dt];
    let p = [ww + dt * (2.0 * wa + dt * aa) + noise[0], wa + dt * aa + noise[1], aa + noise[2]];
    Moments { x: [w + dt * a, a], p }
}

/// Update with a sample; also the innovation and its variance over that of the noise.
fn updated(prior: &Moments, value: f64) -> (Moments, f64, f64) {
    let [ww, wa, aa] = prior.p;
    let (innovation, s) = (value - prior.x[0], ww + 1.0);
    let (kw, ka) = (ww / s, wa / s);
    let x = [prior.x[0] + kw * innovation, prior.x[1] + ka * innovation];
    (Moments { x, p: [ww / s, wa / s, aa - ka * wa] }, innovation, s)
}

/// Half of `n ln (sum v^2 / s) + sum ln s`: minus the logarithm of the likelihood at the best noise variance, but for a constant. The
/// second sample fixes the slope and tells nothing of the ratio.
fn minus_log_likelihood(time_s: &[f64], values: &[f64], ratio: f64) -> f64 {
    let mut at = first(time_s, values);
    let (mut squares, mut logarithms) = (0.0, 0.0);
    for k in 1..values.len() {
        let (next, innovation, s) = updated(&predicted(&at, time_s[k] - time_s[k - 1], ratio), values[k]);
        at = next;
        if k > 1 {
            squares += innovation * innovation / s;
            logarithms += s.ln();
        }
    }
    0.5 * ((values.len() - 2) as f64 * squares.max(f64::MIN_POSITIVE).ln() + logarithms)
}

/// Rate and slope given all samples.
fn smoother(time_s: &[f64], values: &[f64], ratio: f64) -> (Vec<f64>, Vec<f64>) {
    let mut filtered = vec![first(time_s, values)];
    for k in 1..values.len() {
        filtered.push(updated(&predicted(&filtered[k - 1], time_s[k] - time_s[k - 1], ratio), values[k]).0);
    }
    let last = values.len() - 1;
    let mut path = vec![[0.0; 2]; values.len()];
    path[last] = filtered[last].x;
    for k in (0..last).rev() {
        let dt = time_s[k + 1] - time_s[k];
        let (at, prior) = (&filtered[k], predicted(&filtered[k], dt, ratio));
        let ([ww, wa, aa], [pww, pwa, paa]) = (at.p, prior.p);
        let determinant = pww * paa - pwa * pwa;
        // G = P Phi' (P-)^-1
        let cross = [[ww + dt * wa, wa], [wa + dt * aa, aa]];
        let d = [path[k + 1][0] - prior.x[0], path[k + 1][1] - prior.x[1]];
        let weighted = [(paa * d[0] - pwa * d[1]) / determinant, (pww * d[1] - pwa * d[0]) / determinant];
        path[k] = [0, 1].map(|i| at.x[i] + cross[i][0] * weighted[0] + cross[i][1] * weighted[1]);
    }
    path.into_iter().map(|[rate, slope]| (rate, slope)).unzip()
}

#[cfg(test)]
mod tests {
    use nalgebra::{DMatrix, DVector};

    use super::*;

    const STEP_S: f64 = 0.02;

    /// Noise of deviation `sigma` with a fixed sequence.
    fn noise(sigma: f64, samples: usize) -> Vec<f64> {
        let mut state = 1_u64;
        let mut uniform = || {
            state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            (state >> 11) as f64 / (1_u64 << 53) as f64 - 0.5
        };
        (0..samples).map(|_| sigma * (0..12).map(|_| uniform()).sum::<f64>()).collect()
    }

    #[test]
    fn smoother_is_the_weighted_least_squares_of_samples_and_motion() {
        // Unknowns w_0, a_0, w_1, ...: samples w_k = z_k, and what the motion leaves, weighted by its covariance.
        let time: Vec<f64> = (0..12).map(|k| f64::from(k) * STEP_S + 0.003 * f64::from(k % 3)).collect();
        let values: Vec<f64> = time.iter().map(|t| (9.0 * t).sin()).zip(noise(0.1, 12)).map(|(a, b)| a + b).collect();
        let ratio = 3e4;
        let n = values.len();
        let mut normal = DMatrix::<f64>::zeros(2 * n, 2 * n);
        let mut right = DVector::<f64>::zeros(2 * n);
        // The first sample enters as the start and its slope hardly at all.
        for k in 0..n {
            normal[(2 * k, 2 * k)] += 1.0;
            right[2 * k] += values[k];
        }
        normal[(1, 1)] += (time[1] - time[0]).powi(2) / DIFFUSE;
        for k in 1..n {
            let dt = time[k] - time[k - 1];
            let covariance =
                DMatrix::from_row_slice(2, 2, &[dt.powi(3) / 3.0, dt * dt / 2.0, dt * dt / 2.0, dt]) * ratio;
            let weight = covariance.try_inverse().unwrap();
            let mut defect = DMatrix::<f64>::zeros(2, 2 * n);
            (defect[(0, 2 * k)], defect[(0, 2 * k - 2)], defect[(0, 2 * k - 1)]) = (1.0, -1.0, -dt);
            (defect[(1, 2 * k + 1)], defect[(1, 2 * k - 1)]) = (1.0, -1.0);
            normal += defect.transpose() * weight * defect;
        }
        let expected = normal.lu().solve(&right).unwrap();
        let (rate, slope) = smoother(&time, &values, ratio);
        for k in 0..n {
            approx::assert_relative_eq!(rate[k], expected[2 * k], epsilon = 1e-7);
            approx::assert_relative_eq!(slope[k], expected[2 * k + 1], epsilon = 1e-5);
        }
    }

    #[test]
    fn slope_of_a_noisy_rate_is_nearer_the_truth_than_that_of_a_local_quadratic() {
        let samples = 600;
        let time: Vec<f64> = (0..samples).map(|k| f64::from(k) * STEP_S).collect();
        let truth = |t: f64| (3.0 * t).cos() + 0.5 * (7.0 * t).sin();
        let slope = |t: f64| -3.0 * (3.0 * t).sin() + 3.5 * (7.0 * t).cos();
        let values: Vec<f64> =
            time.iter().zip(noise(0.005, samples as usize)).map(|(t, noise)| truth(*t) + noise).collect();
        let found = smoothed_rate(&time, &values).unwrap();
        let quadratic = super::super::Differentiation::LocalPolynomial { degree: 2, half_width: 10 };
        let local = super::super::differentiate(&time, &values, quadratic).unwrap();
        let rms = |column: &[f64]| {
            let inside = 20..580;
            let squares: f64 = inside.clone().map(|k| (column[k] - slope(time[k])).powi(2)).sum();
            (squares / inside.len() as f64).sqrt()
        };
        let (smooth, local) = (rms(&found.slope), rms(&local));
        assert!(smooth < 0.4 * local && local < 1.0, "{smooth} {local} at {} rad/s", found.bandwidth_rad_s);
    }

    #[test]
    fn straight_line_has_its_slope_everywhere() {
        let time: Vec<f64> = (0..50).map(|k| f64::from(k) * STEP_S).collect();
        let values: Vec<f64> = time.iter().map(|t| 0.3 - 1.7 * t).collect();
        let found = smoothed_rate(&time, &values).unwrap();
        found.slope.iter().for_each(|slope| approx::assert_relative_eq!(*slope, -1.7, epsilon = 1e-5));
        assert!(smoothed_rate(&time, &[f64::NAN; 50]).is_err());
    }
}
