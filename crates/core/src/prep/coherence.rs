//! Coherence of two signals over a stretch, and a signal's spectrum over time.

use rustfft::FftPlanner;
use rustfft::num_complex::Complex;

use super::spectrum::{degrees_of_freedom, hann, line};
use crate::series::Series;

/// Shortest segment, samples.
const SHORTEST: usize = 16;
/// Least segments of a coherence: one alone is coherent with everything.
const LEAST_SEGMENTS: usize = 3;
/// Part of independent signals whose coherence is above the bound.
const TAIL: f64 = 0.05;
/// Length of a segment of a spectrogram as a part of the samples, its limits, and columns at most.
const PART: usize = 10;
const SEGMENT: [usize; 2] = [32, 512];
const COLUMNS: usize = 240;

/// Ordinary coherence of two signals.
#[derive(Clone, Debug, PartialEq)]
pub struct Coherence {
    /// Frequencies above zero, Hz.
    pub frequency_hz: Vec<f64>,
    /// Magnitude-squared coherence at each, 0 to 1.
    pub coherence: Vec<f64>,
    /// Share of the output's power that follows the input: the mean of the coherence, weighted by the power of the output.
    pub share: f64,
    /// Coherence that independent signals exceed at 5 % of the frequencies.
    pub bound: f64,
}

/// Ordinary coherence of `output` with `input`, both equally spaced by `step_s`, from segments of `length` samples that overlap by half,
/// each less its straight line and under a Hann window: `gamma^2 = |Sxy|^2 / (Sxx Syy)` (Bendat and Piersol, "Random Data", 6.1). The
/// share is `sum gamma^2 Syy / sum Syy`. Independent signals exceed `1 - 0.05^(1 / (K - 1))` in 5 % of cases, with K the number of
/// independent segments (Carter, Knapp and Nuttall, IEEE Trans. Audio Electroacoust. 21, 1973). `None` for signals of different lengths,
/// with missing values, or too short for three segments. A constant input has coherence zero.
pub fn coherence(input: &[f64], output: &[f64], step_s: f64, length: usize) -> Option<Coherence> {
    let is_known = |values: &[f64]| values.iter().all(|value| value.is_finite());
    let count = input.len();
    if count != output.len() || length < SHORTEST || length > count || !is_known(input) || !is_known(output) {
        return None;
    }
    let hop = length / 2;
    let segments = (count - length) / hop + 1;
    if segments < LEAST_SEGMENTS {
        return None;
    }
    let window = hann(length);
    let transform = FftPlanner::new().plan_fft_forward(length);
    let bins = length / 2;
    let (mut xx, mut yy, mut xy) = (vec![0.0; bins], vec![0.0; bins], vec![Complex::new(0.0, 0.0); bins]);
    let mut buffers = [vec![Complex::default(); length], vec![Complex::default(); length]];
    for start in (0..segments).map(|segment| segment * hop) {
        for (buffer, values) in buffers.iter_mut().zip([input, output]) {
            windowed(&values[start..start + length], &window, buffer);
            transform.process(buffer);
        }
        for bin in 0..bins {
            let [x, y] = [buffers[0][bin + 1], buffers[1][bin + 1]];
            xx[bin] += x.norm_sqr();
            yy[bin] += y.norm_sqr();
            xy[bin] += x.conj() * y;
        }
    }
    let of_bin = |bin: usize| {
        let power = xx[bin] * yy[bin];
        if power > 0.0 { (xy[bin].norm_sqr() / power).min(1.0) } else { 0.0 }
    };
    let coherence: Vec<f64> = (0..bins).map(of_bin).collect();
    let power: f64 = yy.iter().sum();
    let followed: f64 = coherence.iter().zip(&yy).map(|(coherence, power)| coherence * power).sum();
    let independent = 0.5 * degrees_of_freedom(segments);
    Some(Coherence {
        frequency_hz: (1..=bins).map(|k| k as f64 / (length as f64 * step_s)).collect(),
        coherence,
        share: if power > 0.0 { followed / power } else { 0.0 },
        bound: 1.0 - TAIL.powf(1.0 / (independent - 1.0)),
    })
}

/// A segment less its straight line under a window.
fn windowed(values: &[f64], window: &[f64], into: &mut [Complex<f64>]) {
    let (mean, slope) = line(values);
    let middle = 0.5 * (values.len() - 1) as f64;
    for (k, (slot, (value, weight))) in into.iter_mut().zip(values.iter().zip(window)).enumerate() {
        *slot = Complex::new((value - mean - slope * (k as f64 - middle)) * weight, 0.0);
    }
}

/// Spectrum of a signal over time.
#[derive(Clone, Debug, PartialEq)]
pub struct Spectrogram {
    /// Middles of the segments, s.
    pub time_s: Vec<f64>,
    /// Frequencies above zero, Hz.
    pub frequency_hz: Vec<f64>,
    /// One-sided density by segment and frequency, square of the signal's unit per Hz.
    pub density: Vec<Vec<f64>>,
}

/// Periodograms of overlapping segments, each less its straight line and under a Hann window, `2 h |X|^2 / sum w^2` (Welch, IEEE Trans.
/// Audio Electroacoust. 15, 1967). Samples are taken as equally spaced by their median step; segments with a gap are left out. `None`
/// for fewer than 64 samples.
pub fn spectrogram(series: &Series) -> Option<Spectrogram> {
    let Series { time_s: time, values } = series.finite();
    let step_s = crate::statistics::median_step(&time).filter(|step| *step > 0.0)?;
    let count = time.len();
    let [least, most] = SEGMENT;
    if count < 2 * least {
        return None;
    }
    let length = (count / PART).next_power_of_two().clamp(least, most);
    let hop = ((count - length) / COLUMNS).max(length / 8);
    let window = hann(length);
    let weight: f64 = window.iter().map(|w| w * w).sum();
    let transform = FftPlanner::new().plan_fft_forward(length);
    let mut buffer = vec![Complex::default(); length];
    let (mut middles_s, mut density) = (Vec::new(), Vec::new());
    for start in (0..=count - length).step_by(hop) {
        let last = start + length - 1;
        // A segment across a gap spans more time than its samples.
        if time[last] - time[start] > 1.05 * step_s * (length - 1) as f64 {
            continue;
        }
        windowed(&values[start..=last], &window, &mut buffer);
        transform.process(&mut buffer);
        middles_s.push(0.5 * (time[start] + time[last]));
        let scale = 2.0 * step_s / weight;
        density.push(buffer[1..=length / 2].iter().map(|bin| scale * bin.norm_sqr()).collect());
    }
    let frequency_hz = (1..=length / 2).map(|k| k as f64 / (length as f64 * step_s)).collect();
    (!density.is_empty()).then_some(Spectrogram { time_s: middles_s, frequency_hz, density })
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Equally distributed values from -0.5 to 0.5 (Knuth's linear congruence).
    fn noise(seed: u64, count: usize) -> Vec<f64> {
        let mut state = seed;
        let next = |_| {
            state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            (state >> 11) as f64 / (1_u64 << 53) as f64 - 0.5
        };
        (0..count).map(next).collect()
    }

    #[test]
    fn coherence_is_the_share_of_power_that_follows_the_input() {
        let (input, other) = (noise(1, 8192), noise(2, 8192));
        // The input through a filter, and as much power that has nothing to do with it.
        let output: Vec<f64> = input.iter().zip(&other).map(|(a, b)| a + b).collect();
        let found = coherence(&input, &output, 0.02, 128).unwrap();
        assert!((found.share - 0.5).abs() < 0.04, "half of the power: {}", found.share);
        let same = coherence(&input, &input, 0.02, 128).unwrap();
        assert!((same.share - 1.0).abs() < 1e-12);
        let none = coherence(&other, &input, 0.02, 128).unwrap();
        assert!(none.share < none.bound, "{} {}", none.share, none.bound);
        let above = none.coherence.iter().filter(|value| **value > none.bound).count();
        assert!(above <= 10, "about 5 % of 64 are above the bound: {above}");
        assert_eq!(coherence(&vec![3.0; 8192], &input, 0.02, 128).unwrap().share, 0.0);
        assert_eq!(coherence(&input[..100], &output[..100], 0.02, 64), None, "two segments");
    }

    #[test]
    fn spectrogram_follows_a_sine_that_changes_its_frequency() {
        let time: Vec<f64> = (0..4000).map(|k| 0.01 * f64::from(k)).collect();
        let wave = |t: &f64| {
            if *t < 20.0 { (5.0 * std::f64::consts::TAU * t).sin() } else { (15.0 * std::f64::consts::TAU * t).sin() }
        };
        let series = Series { values: time.iter().map(wave).collect(), time_s: time.into() };
        let found = spectrogram(&series).unwrap();
        let peak = |column: usize| {
            let density = &found.density[column];
            let at = (0..density.len()).max_by(|&i, &j| density[i].total_cmp(&density[j])).unwrap();
            found.frequency_hz[at]
        };
        let step = found.frequency_hz[0];
        assert!((peak(0) - 5.0).abs() <= step && (peak(found.density.len() - 1) - 15.0).abs() <= step);
        let power: f64 = found.density[0].iter().sum::<f64>() * step;
        assert!((power - 0.5).abs() < 0.01, "half the square of the amplitude: {power}");
    }
}
