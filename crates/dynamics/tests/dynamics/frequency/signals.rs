//! Random and swept records of known systems.

use std::f64::consts::TAU;

use nalgebra::Complex;
use rand::{Rng, RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use rand_distr::StandardNormal;
use rustfft::FftPlanner;

pub fn seeded(seed: u64) -> ChaCha8Rng {
    ChaCha8Rng::seed_from_u64(seed)
}

pub fn normal(rng: &mut impl Rng) -> f64 {
    rng.sample(StandardNormal)
}

/// Records of a random signal of two-sided density `density` up to 6 Hz, as transforms over a whole circular record.
pub struct Circular {
    pub rate_hz: f64,
    pub samples: usize,
}

impl Circular {
    /// 600 s at 20 Hz.
    pub const REFERENCE: Self = Self { rate_hz: 20.0, samples: 12_000 };
    const BAND_HZ: f64 = 6.0;

    /// Transform of white noise of this density in the band.
    pub fn noise(&self, density: f64, rng: &mut impl Rng) -> Vec<Complex<f64>> {
        let deviation = (density * self.rate_hz).sqrt();
        let mut values: Vec<Complex<f64>> =
            (0..self.samples).map(|_| Complex::new(deviation * normal(rng), 0.0)).collect();
        FftPlanner::new().plan_fft_forward(self.samples).process(&mut values);
        for (k, value) in values.iter_mut().enumerate() {
            if self.frequency_hz(k).abs() > Self::BAND_HZ {
                *value = Complex::new(0.0, 0.0);
            }
        }
        values
    }

    fn frequency_hz(&self, k: usize) -> f64 {
        let k = k as f64;
        let count = self.samples as f64;
        self.rate_hz * if k < 0.5 * count { k / count } else { k / count - 1.0 }
    }

    /// Transform of the response to a transform.
    pub fn through(&self, input: &[Complex<f64>], system: impl Fn(Complex<f64>) -> Complex<f64>) -> Vec<Complex<f64>> {
        let at = |k: usize| system(Complex::new(0.0, TAU * self.frequency_hz(k)));
        input.iter().enumerate().map(|(k, value)| value * at(k)).collect()
    }

    /// Samples of a transform.
    pub fn samples_of(&self, transform: &[Complex<f64>]) -> Vec<f64> {
        let mut values = transform.to_vec();
        FftPlanner::new().plan_fft_inverse(self.samples).process(&mut values);
        values.iter().map(|value| value.re / self.samples as f64).collect()
    }
}

/// Sum of transforms.
pub fn sum(parts: &[&[Complex<f64>]]) -> Vec<Complex<f64>> {
    (0..parts[0].len()).map(|k| parts.iter().map(|part| part[k]).sum()).collect()
}

/// Logarithmic sweep of unit amplitude from 0.1 rad/s to 2 pi rad/s in 110 s with a linear fade over its last 2 s, then 10 s of nothing.
pub fn sweep(time_s: f64) -> f64 {
    const LENGTH_S: f64 = 110.0;
    const FADE_S: f64 = 2.0;
    if !(0.0..=LENGTH_S).contains(&time_s) {
        return 0.0;
    }
    let (low, rate) = (0.1, (TAU / 0.1f64).ln() / LENGTH_S);
    let angle = low * ((rate * time_s).exp() - 1.0) / rate;
    angle.sin() * ((LENGTH_S - time_s) / FADE_S).min(1.0)
}

/// Response of `K (s + z) / (s^2 + 2 zeta w s + w^2)` to straight lines between samples of an input that arrives late, by Runge-Kutta
/// steps a sixteenth of the samples apart.
pub fn second_order_response(input: &[f64], step_s: f64, [gain, z, zeta, omega, delay_s]: [f64; 5]) -> Vec<f64> {
    const FINE: usize = 16;
    let at = |time_s: f64| {
        let place = (time_s - delay_s) / step_s;
        if place <= 0.0 || place >= (input.len() - 1) as f64 {
            return 0.0;
        }
        let low = place.floor() as usize;
        input[low] + (place - low as f64) * (input[low + 1] - input[low])
    };
    // y = K (x' + z x), x'' + 2 zeta w x' + w^2 x = u.
    let slope = |[x, v]: [f64; 2], u: f64| [v, u - 2.0 * zeta * omega * v - omega * omega * x];
    let moved = |[x, v]: [f64; 2], [dx, dv]: [f64; 2], h: f64| [x + h * dx, v + h * dv];
    let h = step_s / FINE as f64;
    let mut state = [0.0, 0.0];
    let mut output = Vec::with_capacity(input.len());
    for k in 0..input.len() {
        output.push(gain * (state[1] + z * state[0]));
        for fine in 0..FINE {
            let time = step_s * k as f64 + h * fine as f64;
            let (start, middle, end) = (at(time), at(time + 0.5 * h), at(time + h));
            let a = slope(state, start);
            let b = slope(moved(state, a, 0.5 * h), middle);
            let c = slope(moved(state, b, 0.5 * h), middle);
            let d = slope(moved(state, c, h), end);
            let mean = [0, 1].map(|i| (a[i] + 2.0 * b[i] + 2.0 * c[i] + d[i]) / 6.0);
            state = moved(state, mean, h);
        }
    }
    output
}

/// Mean and standard deviation.
pub fn moments(values: &[f64]) -> (f64, f64) {
    let mean = values.iter().sum::<f64>() / values.len() as f64;
    let square = values.iter().map(|value| (value - mean).powi(2)).sum::<f64>() / (values.len() - 1) as f64;
    (mean, square.sqrt())
}
