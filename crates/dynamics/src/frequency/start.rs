//! Starting values of a transfer function from points of its response.

use nalgebra::{Complex, DMatrix, DVector};

use super::transfer::{Delay, TransferFunction, factors};

/// A measured response with its relative weight.
#[derive(Clone, Copy, Debug)]
pub(super) struct Sample {
    pub omega: f64,
    pub response: Complex<f64>,
    /// Inverse of the standard deviation of the relative error.
    pub weight: f64,
}

/// Delays tried, as parts of the one that turns the highest frequency by half a turn.
const DELAYS: usize = 13;
/// Iterations that put the last denominator under the equation error.
const ITERATIONS: usize = 8;

/// The transfer function of these orders nearest to the samples among those found for a row of delays by iterated linear least squares,
/// `(N - D' H e^(j w tau)) / D_last = s^n H e^(j w tau) / D_last` (Sanathanan and Koerner). `None` where no equation can be solved.
pub(super) fn starting_values(samples: &[Sample], (m, n): (usize, usize), delay: Delay) -> Option<TransferFunction> {
    let highest = samples.iter().map(|sample| sample.omega).fold(0.0, f64::max);
    let longest_s = std::f64::consts::PI / highest;
    let delays: Vec<f64> = match delay {
        Delay::Fixed(delay_s) => vec![delay_s],
        Delay::Free => (0..DELAYS).map(|k| longest_s * k as f64 / (DELAYS - 1) as f64).collect(),
    };
    let found = delays.iter().filter_map(|&delay_s| linear(samples, (m, n), delay_s));
    found.min_by(|a, b| a.1.total_cmp(&b.1)).map(|(model, _)| model)
}

/// Best of the iterations for one delay, and its weighted relative square error.
fn linear(samples: &[Sample], (m, n): (usize, usize), delay_s: f64) -> Option<(TransferFunction, f64)> {
    // Frequencies about one: powers of them stay comparable.
    let unit = (samples.iter().map(|sample| sample.omega.ln()).sum::<f64>() / samples.len() as f64).exp();
    let mut last = vec![Complex::new(1.0, 0.0); samples.len()];
    let mut best: Option<(TransferFunction, f64)> = None;
    for _ in 0..ITERATIONS {
        let (numerator, denominator) = solve(samples, &last, (m, n), delay_s, unit)?;
        for (last, sample) in last.iter_mut().zip(samples) {
            let s = Complex::new(0.0, sample.omega / unit);
            *last = polynomial(&denominator, s) + s.powu(n as u32);
        }
        let scaled = |coefficients: &[f64], order: usize| -> Vec<f64> {
            coefficients.iter().enumerate().map(|(k, c)| c * unit.powi((order - k) as i32)).collect()
        };
        let gain = numerator[m];
        if gain == 0.0 {
            continue;
        }
        let monic: Vec<f64> = numerator[..m].iter().map(|c| c / gain).collect();
        let model = TransferFunction {
            gain: gain * unit.powi((n - m) as i32),
            numerator: factors(&scaled(&monic, m)),
            denominator: factors(&scaled(&denominator, n)),
            delay_s,
        };
        let error = |sample: &Sample| {
            let relative = (model.at(sample.omega) - sample.response) / sample.response;
            // Far off is far off: one point must not rule out a start.
            sample.weight * sample.weight * relative.norm_sqr().min(4.0)
        };
        let cost: f64 = samples.iter().map(error).sum();
        if cost.is_finite() && best.as_ref().is_none_or(|(_, least)| cost < *least) {
            best = Some((model, cost));
        }
    }
    best
}

fn polynomial(coefficients: &[f64], s: Complex<f64>) -> Complex<f64> {
    coefficients.iter().rev().fold(Complex::new(0.0, 0.0), |sum, c| sum * s + c)
}

/// Coefficients of numerator (0 to m) and denominator (0 to n - 1) of the weighted linear equation.
fn solve(
    samples: &[Sample],
    last: &[Complex<f64>],
    (m, n): (usize, usize),
    delay_s: f64,
    unit: f64,
) -> Option<(Vec<f64>, Vec<f64>)> {
    let size = m + 1 + n;
    let mut normal = DMatrix::<f64>::zeros(size, size);
    let mut right = DVector::<f64>::zeros(size);
    let mut row = vec![Complex::new(0.0, 0.0); size];
    for (sample, last) in samples.iter().zip(last) {
        let s = Complex::new(0.0, sample.omega / unit);
        let advanced = sample.response * Complex::from_polar(1.0, sample.omega * delay_s);
        let weight = sample.weight / (sample.response.norm() * last.norm());
        for (k, slot) in row.iter_mut().enumerate() {
            *slot = if k <= m { s.powu(k as u32) } else { -advanced * s.powu((k - m - 1) as u32) } * weight;
        }
        let target = advanced * s.powu(n as u32) * weight;
        for i in 0..size {
            right[i] += (row[i].conj() * target).re;
            for j in 0..size {
                normal[(i, j)] += (row[i].conj() * row[j]).re;
            }
        }
    }
    let solution = normal.lu().solve(&right)?;
    let values = solution.as_slice();
    values.iter().all(|value| value.is_finite()).then(|| (values[..=m].to_vec(), values[m + 1..].to_vec()))
}
