//! Power spectral density of a recorded signal.

use rustfft::FftPlanner;
use rustfft::num_complex::Complex;
use statrs::distribution::{ChiSquared, ContinuousCDF};

use super::stretches;
use crate::series::Series;

/// Power spectral density, one-sided.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Spectrum {
    /// Frequencies above zero, Hz.
    pub frequency_hz: Vec<f64>,
    /// Density, square of the signal's unit per Hz.
    pub density: Vec<f64>,
    /// Degrees of freedom of each density.
    pub degrees: f64,
}

impl Spectrum {
    /// Lower and upper bound of the density of white noise of the same power, square of the unit per Hz: at each frequency 95 % lie
    /// between `S chi2_0.025 / nu` and `S chi2_0.975 / nu` with S the mean density and nu the degrees of freedom (Bendat and Piersol,
    /// "Random Data", 8.5.1).
    pub fn white_band(&self) -> [f64; 2] {
        let mean = self.density.iter().sum::<f64>() / self.density.len() as f64;
        let quantile = |part: f64| ChiSquared::new(self.degrees).map_or(f64::NAN, |chi| chi.inverse_cdf(part));
        [TAIL, 1.0 - TAIL].map(|part| mean * quantile(part) / self.degrees)
    }
}

/// Part of the cases on either side of a 95 % band.
const TAIL: f64 = 0.025;
/// Correlation of the squares of neighbouring segments that overlap by half under a Hann window (Welch 1967).
const NEIGHBOURS: f64 = 1.0 / 36.0;

/// Degrees of freedom of the mean of the periodograms of `segments` that overlap by half under a Hann window:
/// `2 K / (1 + 2 c (K - 1) / K)` with c the correlation of neighbouring squares.
pub(super) fn degrees_of_freedom(segments: usize) -> f64 {
    let count = segments as f64;
    2.0 * count / (1.0 + 2.0 * NEIGHBOURS * (count - 1.0) / count)
}

pub(super) fn hann(length: usize) -> Vec<f64> {
    (0..length).map(|k| (std::f64::consts::PI * (k as f64 + 0.5) / length as f64).sin().powi(2)).collect()
}

/// Longest segment, samples.
const LONGEST: usize = 1024;
/// Shortest segment, samples.
const SHORTEST: usize = 32;
/// Steps longer than this many median ones end a stretch.
const UNEVEN: f64 = 1.5;

/// Spectrum by the mean of the periodograms of segments that overlap by half, each less its straight line and under a Hann
/// window (Welch, IEEE Trans. Audio Electroacoust. 15, 1967). Segments cross no gap; `None` where no stretch is long enough.
pub fn spectrum(series: &Series) -> Option<Spectrum> {
    let Series { time_s: time, values } = series.finite();
    let step_s = crate::statistics::median_step(&time).unwrap_or(0.0);
    let ranges = stretches(&time, UNEVEN * step_s);
    let longest = ranges.iter().map(std::ops::Range::len).max().unwrap_or(0);
    if longest < SHORTEST || step_s.is_nan() || step_s <= 0.0 {
        return None;
    }
    let length = (longest / 2 + 1).next_power_of_two().min(LONGEST).min(longest);
    let window = hann(length);
    let weight: f64 = window.iter().map(|w| w * w).sum();
    let transform = FftPlanner::new().plan_fft_forward(length);
    let mut density = vec![0.0; length / 2];
    let mut segments = 0_u32;
    let mut buffer = vec![Complex::default(); length];
    for range in ranges {
        let mut start = range.start;
        while start + length <= range.end {
            let piece = &values[start..start + length];
            let (mean, slope) = line(piece);
            for (k, (slot, value)) in buffer.iter_mut().zip(piece).enumerate() {
                let trend = mean + slope * (k as f64 - 0.5 * (length - 1) as f64);
                *slot = Complex::new((value - trend) * window[k], 0.0);
            }
            transform.process(&mut buffer);
            density.iter_mut().zip(&buffer[1..]).for_each(|(sum, bin)| *sum += bin.norm_sqr());
            segments += 1;
            start += length / 2;
        }
    }
    let scale = 2.0 * step_s / (weight * f64::from(segments));
    let frequency_hz = (1..=length / 2).map(|k| k as f64 / (length as f64 * step_s)).collect();
    Some(Spectrum {
        frequency_hz,
        density: density.into_iter().map(|sum| sum * scale).collect(),
        degrees: degrees_of_freedom(segments as usize),
    })
}

/// Mean and slope per sample of equally spaced values.
pub(super) fn line(values: &[f64]) -> (f64, f64) {
    let n = values.len() as f64;
    let mean = values.iter().sum::<f64>() / n;
    let (xy, xx) = values.iter().enumerate().fold((0.0, 0.0), |(xy, xx), (k, value)| {
        let x = k as f64 - 0.5 * (n - 1.0);
        (xy + x * (value - mean), xx + x * x)
    });
    (mean, xy / xx)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn power_of_a_sine_on_a_trend_across_a_gap_is_half_its_square() {
        /// The sine's own power apart, what the ends of the segments leak: well below a per cent under a Hann window.
        const LEAK: f64 = 5e-3;
        let (amplitude, frequency) = (0.3, 4.1);
        let time: Vec<f64> = (0..9000).map(|k| 0.02 * f64::from(k)).filter(|t| !(60.0..75.0).contains(t)).collect();
        let wave = |t: &f64| amplitude * (std::f64::consts::TAU * frequency * t).sin() + 0.01 * t;
        let values: Vec<f64> = time.iter().map(wave).collect();
        let found = spectrum(&Series { time_s: time.into(), values: values.into() }).unwrap();
        let step = found.frequency_hz[0];
        let power: f64 = found.density.iter().sum::<f64>() * step;
        approx::assert_relative_eq!(power, 0.5 * amplitude * amplitude, max_relative = LEAK);
        let peak = (0..found.density.len()).max_by(|&i, &j| found.density[i].total_cmp(&found.density[j])).unwrap();
        assert!((found.frequency_hz[peak] - frequency).abs() < step);
        approx::assert_relative_eq!(*found.frequency_hz.last().unwrap(), 25.0, epsilon = 1e-9);
    }

    #[test]
    fn white_noise_lies_in_its_band_and_a_sine_above_it() {
        let mut state = 5_u64;
        let mut next = || {
            state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            (state >> 11) as f64 / (1_u64 << 53) as f64 - 0.5
        };
        let time: Vec<f64> = (0..6000).map(|k| 0.02 * f64::from(k)).collect();
        let values: Vec<f64> = time.iter().map(|_| next()).collect();
        let found = spectrum(&Series { time_s: time.clone().into(), values: values.clone().into() }).unwrap();
        let [low, high] = found.white_band();
        let inside = found.density.iter().filter(|density| (low..high).contains(density)).count();
        let part = inside as f64 / found.density.len() as f64;
        assert!((0.91..0.98).contains(&part), "95 %: {part}");
        let with: Vec<f64> = time.iter().zip(&values).map(|(t, v)| v + (7.0 * t).sin()).collect();
        let found = spectrum(&Series { time_s: time.into(), values: with.into() }).unwrap();
        assert!(found.density.iter().copied().fold(0.0, f64::max) > found.white_band()[1]);
    }

    #[test]
    fn too_little_has_no_spectrum() {
        let short: Vec<f64> = (0..31).map(f64::from).collect();
        assert_eq!(spectrum(&Series { time_s: short.clone().into(), values: short.into() }), None);
        assert_eq!(spectrum(&Series { time_s: [].into(), values: [].into() }), None);
    }
}
