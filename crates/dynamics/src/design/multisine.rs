//! Orthogonal multisines with optimised phases for several surfaces at once.

use std::f64::consts::{PI, TAU};

/// Samples per period of the highest harmonic when peaks are judged.
const SAMPLES_PER_HARMONIC: usize = 24;
/// Rounds of the search over the phases.
const ROUNDS: usize = 40;
/// Exponent of the mean that stands for the peak while phases are sought.
const EXPONENT: i32 = 16;

/// A multisine of one surface: harmonics of `1/T`, their amplitudes and phases.
#[derive(Clone, Debug, PartialEq)]
pub struct Multisine {
    /// Record length `T`, s.
    pub period_s: f64,
    /// Harmonic number, amplitude and phase (rad) of each line.
    pub lines: Vec<(usize, f64, f64)>,
}

impl Multisine {
    /// Value `sum_k a_k sin(2 pi k t / T + phi_k)`.
    pub fn at(&self, time_s: f64) -> f64 {
        let angle = TAU * time_s / self.period_s;
        self.lines.iter().map(|&(k, amplitude, phase)| amplitude * (k as f64 * angle + phase).sin()).sum()
    }

    /// Samples over one period, evenly spaced, fine enough for its highest harmonic.
    fn samples(&self) -> Vec<f64> {
        let highest = self.lines.iter().map(|line| line.0).max().unwrap_or(1);
        let count = SAMPLES_PER_HARMONIC * highest;
        (0..count).map(|index| self.at(self.period_s * index as f64 / count as f64)).collect()
    }
}

/// Relative peak factor `(max - min) / (2 sqrt(2) rms)` of samples; 1 for a single sine (Klein and Morelli, 9.3).
pub fn relative_peak_factor(samples: &[f64]) -> f64 {
    let (low, high) = samples.iter().fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), &v| (l.min(v), h.max(v)));
    let rms = (samples.iter().map(|value| value * value).sum::<f64>() / samples.len() as f64).sqrt();
    (high - low) / (2.0 * std::f64::consts::SQRT_2 * rms)
}

/// Multisines `u_j(t) = sum_{k in I_j} A sqrt(P_k) sin(2 pi k t / T + phi_k)` of unit peak on disjoint harmonic sets `I_j`, dealt in turn from
/// `first..=last`: orthogonal over one period (Morelli, J. Aircraft 49(6), 2012). The power of a line is `k^tilt` of the surface over the
/// sum of them. Phases begin as Schroeder's, `phi_k = -2 pi sum_{l<k} (k - l) P_l`, and move one at a time while the mean of the 16th power
/// falls; time is shifted so that each begins and ends at zero. The peak is that of the sum, not of its lines.
///
/// Empty where there are fewer harmonics than surfaces.
pub fn orthogonal_multisines(period_s: f64, first: usize, last: usize, tilts: &[f64]) -> Vec<Multisine> {
    let surfaces = tilts.len();
    if surfaces == 0 || first == 0 || last + 1 < first + surfaces {
        return Vec::new();
    }
    let numbers = |surface: usize| (first..=last).skip(surface).step_by(surfaces).collect::<Vec<usize>>();
    let tilts = tilts.iter().enumerate();
    tilts.map(|(surface, tilt)| shape_multisine(period_s, first, &numbers(surface), *tilt)).collect()
}

/// Of the harmonics `numbers`, with peak one.
fn shape_multisine(period_s: f64, first: usize, numbers: &[usize], tilt: f64) -> Multisine {
    let weights: Vec<f64> = numbers.iter().map(|&k| (k as f64 / first as f64).powf(tilt)).collect();
    let total: f64 = weights.iter().sum();
    let powers: Vec<f64> = weights.iter().map(|weight| weight / total).collect();
    let phases = schroeder(&powers);
    let lines = numbers.iter().zip(&powers).zip(phases).map(|((&k, power), phase)| (k, power.sqrt(), phase));
    let mut signal = Multisine { period_s, lines: lines.collect() };
    flatten(&mut signal);
    begin_at_zero(&mut signal);
    let peak = signal.samples().iter().fold(0.0, |peak: f64, value| peak.max(value.abs()));
    signal.lines.iter_mut().for_each(|line| line.1 /= peak);
    signal
}

/// Schroeder's phases for relative powers that sum to one (IEEE Trans. Information Theory 16, 1970).
fn schroeder(powers: &[f64]) -> Vec<f64> {
    (0..powers.len())
        .map(|k| -TAU * powers[..k].iter().enumerate().map(|(l, power)| (k - l) as f64 * power).sum::<f64>())
        .collect()
}

/// Moves one phase at a time, keeps what lowers the peaks, and halves the move when nothing does.
fn flatten(signal: &mut Multisine) {
    let highest = signal.lines.iter().map(|line| line.0).max().unwrap_or(1);
    // Half the resolution of the final judgement: the sixteenth power is smooth.
    let count = SAMPLES_PER_HARMONIC / 2 * highest;
    let wave = |k: usize, amplitude: f64, phase: f64, index: usize| {
        amplitude * (TAU * (k * index % count) as f64 / count as f64 + phase).sin()
    };
    let mut sum: Vec<f64> = (0..count)
        .map(|index| signal.lines.iter().map(|&(k, amplitude, phase)| wave(k, amplitude, phase, index)).sum())
        .collect();
    let table: Vec<(f64, f64)> = (0..count).map(|index| (TAU * index as f64 / count as f64).sin_cos()).collect();
    let mut best: f64 = sum.iter().map(|value| value.powi(EXPONENT)).sum();
    let mut step = PI / 4.0;
    for _ in 0..ROUNDS {
        let mut improved = false;
        for line in &mut signal.lines {
            for direction in [step, -step] {
                let (k, amplitude, phase) = *line;
                // a sin(x + phase + d) - a sin(x + phase), with sin and cos of x from the table.
                let ((s0, c0), (s1, c1)) = (phase.sin_cos(), (phase + direction).sin_cos());
                let (along, across) = (amplitude * (c1 - c0), amplitude * (s1 - s0));
                let change = |index: usize| {
                    let (sin, cos) = table[k * index % count];
                    along * sin + across * cos
                };
                let peaks: f64 = sum.iter().enumerate().map(|(i, value)| (value + change(i)).powi(EXPONENT)).sum();
                if peaks < best {
                    sum.iter_mut().enumerate().for_each(|(index, value)| *value += change(index));
                    line.2 = phase + direction;
                    best = peaks;
                    improved = true;
                }
            }
        }
        if !improved {
            step *= 0.5;
        }
    }
}

/// Shifts time to the first upward zero crossing.
fn begin_at_zero(signal: &mut Multisine) {
    let samples = signal.samples();
    let step_s = signal.period_s / samples.len() as f64;
    let crossing = (0..samples.len()).find(|&i| samples[i] <= 0.0 && samples[(i + 1) % samples.len()] > 0.0);
    let crossing = crossing.unwrap_or(0) as f64;
    let (mut low, mut high) = (crossing * step_s, (crossing + 1.0) * step_s);
    for _ in 0..50 {
        let middle = 0.5 * (low + high);
        if signal.at(middle) > 0.0 { high = middle } else { low = middle }
    }
    let turn = TAU * low / signal.period_s;
    signal.lines.iter_mut().for_each(|line| line.2 = (line.2 + line.0 as f64 * turn).rem_euclid(TAU));
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Products over one period and values at its ends: rounding of some hundred terms.
    const ROUNDING: f64 = 1e-9;

    #[test]
    fn schroeders_phases_are_the_published_ones_for_equal_powers() {
        for (k, phase) in schroeder(&[0.1; 10]).into_iter().enumerate() {
            // phi_n = phi_1 - pi n (n - 1) / N, with n = k + 1 (Klein and Morelli, Eq. 9.34).
            let published = -PI * ((k + 1) * k) as f64 / 10.0;
            approx::assert_relative_eq!(phase, published, epsilon = 1e-12);
        }
    }

    #[test]
    fn multisines_are_orthogonal_begin_at_zero_and_have_a_unit_peak() {
        let set = orthogonal_multisines(20.0, 2, 31, &[0.0, 0.0, -1.0]);
        for (index, signal) in set.iter().enumerate() {
            let samples = signal.samples();
            assert!(signal.at(0.0).abs() < ROUNDING && signal.at(20.0).abs() < ROUNDING);
            let fine = (0..20_000).map(|i| signal.at(1e-3 * f64::from(i)).abs()).fold(0.0, f64::max);
            assert!((0.999..1.002).contains(&fine), "peak {fine}");
            let factor = relative_peak_factor(&samples);
            // Ten lines: published optimised sets have 1.0 to 1.2 (Morelli 2012); powers that fall are harder to flatten.
            assert!(factor < if index < 2 { 1.2 } else { 1.35 }, "{factor}");
            for other in &set[index + 1..] {
                let product: f64 =
                    (0..1000).map(|i| 0.02 * f64::from(i)).map(|t| signal.at(t) * other.at(t)).sum::<f64>() / 1000.0;
                assert!(product.abs() < ROUNDING, "{product}");
            }
        }
        assert!(orthogonal_multisines(20.0, 3, 4, &[0.0; 3]).is_empty());
    }

    #[test]
    fn single_sine_has_the_peak_factor_of_one() {
        let sine: Vec<f64> = (0..400).map(|i| (TAU * f64::from(i) / 400.0).sin()).collect();
        approx::assert_relative_eq!(relative_peak_factor(&sine), 1.0, epsilon = 1e-12);
    }
}
