//! Fourier sums on evenly spaced frequencies by the chirp-z transform.

use std::sync::Arc;

use doublet_core::estimate::correct_ends;
use rustfft::num_complex::Complex;
use rustfft::{Fft, FftPlanner};

/// Fourier sums `sum x_k e^(-j w_m k h)` at `w_m = first + m spacing` by a convolution (Rabiner, Schafer and Rader, with Bluestein's
/// `k m = (k^2 + m^2 - (m - k)^2) / 2`), for any spacing and number of frequencies, planned once for records of one length.
pub struct ChirpZ {
    samples: usize,
    step_s: f64,
    omega_rad_s: Vec<f64>,
    /// `e^(-j (w_0 k + dw k^2 / 2) h)` of every sample.
    before: Vec<Complex<f64>>,
    /// `e^(-j dw h m^2 / 2)` of every frequency.
    after: Vec<Complex<f64>>,
    /// Transform of the chirp that is convolved with, over the length of the transforms.
    kernel: Vec<Complex<f64>>,
    forward: Arc<dyn Fft<f64>>,
    inverse: Arc<dyn Fft<f64>>,
}

impl ChirpZ {
    /// Plan for records of `samples` values `step_s` apart and `count` frequencies from `first_rad_s`, `spacing_rad_s` apart.
    pub fn new(samples: usize, step_s: f64, first_rad_s: f64, spacing_rad_s: f64, count: usize) -> Self {
        let length = (samples + count).next_power_of_two();
        let half = 0.5 * spacing_rad_s * step_s;
        let square = |k: usize| (k as f64) * (k as f64);
        let turn = |angle: f64| Complex::from_polar(1.0, angle);
        let mut kernel = vec![Complex::new(0.0, 0.0); length];
        for (m, slot) in kernel.iter_mut().take(count).enumerate() {
            *slot = turn(half * square(m));
        }
        for k in 1..samples {
            kernel[length - k] = turn(half * square(k));
        }
        let mut planner = FftPlanner::new();
        let (forward, inverse) = (planner.plan_fft_forward(length), planner.plan_fft_inverse(length));
        forward.process(&mut kernel);
        let scale = 1.0 / length as f64;
        kernel.iter_mut().for_each(|value| *value *= scale);
        Self {
            samples,
            step_s,
            omega_rad_s: (0..count).map(|m| first_rad_s + spacing_rad_s * m as f64).collect(),
            before: (0..samples).map(|k| turn(-first_rad_s * step_s * k as f64 - half * square(k))).collect(),
            after: (0..count).map(|m| turn(-half * square(m))).collect(),
            kernel,
            forward,
            inverse,
        }
    }

    /// Angular frequencies, rad/s.
    pub fn omega_rad_s(&self) -> &[f64] {
        &self.omega_rad_s
    }

    /// The sums of the first `samples` values; missing ones count as zero.
    pub fn sums(&self, values: &[f64]) -> Vec<Complex<f64>> {
        let mut work = vec![Complex::new(0.0, 0.0); self.kernel.len()];
        for ((slot, value), turn) in work.iter_mut().zip(values.iter().take(self.samples)).zip(&self.before) {
            *slot = turn * *value;
        }
        self.forward.process(&mut work);
        work.iter_mut().zip(&self.kernel).for_each(|(slot, factor)| *slot *= factor);
        self.inverse.process(&mut work);
        work.iter().zip(&self.after).map(|(value, turn)| value * turn).collect()
    }

    /// Finite Fourier transforms `integral x e^(-j w t) dt`, exact for straight lines between samples.
    pub fn integrals(&self, values: &[f64]) -> Vec<Complex<f64>> {
        let sums = self.sums(values).into_iter().zip(&self.omega_rad_s);
        sums.map(|(sum, omega)| correct_ends(sum, values, self.step_s, *omega)).collect()
    }
}

/// Fourier sums `sum x_k e^(-j w k h)` at any frequencies, each by turning one phasor from sample to sample.
pub(super) fn fourier_sums(values: &[f64], step_s: f64, omega_rad_s: &[f64]) -> Vec<Complex<f64>> {
    omega_rad_s.iter().map(|&omega| fourier_sum(values, step_s, omega)).collect()
}

fn fourier_sum(values: &[f64], step_s: f64, omega_rad_s: f64) -> Complex<f64> {
    let turn = Complex::from_polar(1.0, -omega_rad_s * step_s);
    let mut phasor = Complex::new(1.0, 0.0);
    let mut sum = Complex::new(0.0, 0.0);
    for value in values {
        sum += phasor * *value;
        phasor *= turn;
    }
    sum
}

#[cfg(test)]
mod tests {
    use doublet_core::estimate::finite_fourier_transform;

    use super::*;

    #[test]
    fn chirp_z_matches_the_direct_transform_on_any_even_grid() {
        let values: Vec<f64> = (0..517).map(|k| (0.03 * f64::from(k)).sin() + 0.2 * f64::from(k % 7)).collect();
        for (first, spacing, count) in [(0.1, 0.013, 620), (0.0, 0.5, 40), (3.0, 0.002, 900)] {
            let plan = ChirpZ::new(values.len(), 0.05, first, spacing, count);
            let direct = finite_fourier_transform(&values, 0.05, plan.omega_rad_s());
            let sums = fourier_sums(&values, 0.05, plan.omega_rad_s());
            let scale = direct.iter().map(|value| value.norm()).fold(0.0, f64::max);
            for (m, found) in plan.integrals(&values).iter().enumerate() {
                assert!((found - direct[m]).norm() < 1e-11 * scale, "{first} {spacing}: {found} {}", direct[m]);
            }
            for (found, sum) in plan.sums(&values).iter().zip(&sums) {
                assert!((found - sum).norm() < 1e-10 * scale / 0.05);
            }
        }
    }
}
