//! Orthogonal multisines with optimised phases.

use std::f64::consts::{PI, TAU};

use super::SimulateError;

/// Samples per record when a phase set is judged.
const SAMPLES: usize = 512;
/// Rounds of the coordinate search over the phases.
const ROUNDS: usize = 60;

/// A sum of harmonics of `1/T`: `u(t) = A sum_k sqrt(P_k) sin(2 pi k t / T + phi_k)` with equal powers (Morelli,
/// Flight test maneuvers for efficient aerodynamic modeling, Journal of Aircraft 49(6), 2012).
#[derive(Clone, Debug, PartialEq)]
pub struct Multisine {
    /// Record length `T`, s.
    pub period_s: f64,
    /// Amplitude `A`, rad.
    pub amplitude_rad: f64,
    /// Harmonic numbers.
    pub harmonics: Vec<u32>,
    /// Phase of each harmonic, rad.
    pub phases_rad: Vec<f64>,
}

impl Multisine {
    /// Multisines for several controls on disjoint harmonic sets, dealt in turn from `first..=last`, hence orthogonal over
    /// one period; each with Schroeder's phases improved until its peaks stop falling, and shifted in time so that it
    /// begins and ends at zero.
    ///
    /// # Errors
    /// [`SimulateError::TooFewHarmonics`] when there are fewer harmonics than controls.
    pub(crate) fn orthogonal_set(
        period_s: f64,
        amplitude_rad: f64,
        first: u32,
        last: u32,
        controls: usize,
    ) -> Result<Vec<Self>, SimulateError> {
        let available = (last + 1).saturating_sub(first) as usize;
        if controls == 0 || available < controls || first == 0 {
            return Err(SimulateError::TooFewHarmonics { first, last, controls });
        }
        let set = (0..controls).map(|control| {
            let harmonics: Vec<u32> = (first..=last).skip(control).step_by(controls).collect();
            let mut signal = Self { period_s, amplitude_rad, phases_rad: schroeder(harmonics.len()), harmonics };
            signal.optimise();
            signal.begin_at_zero();
            signal
        });
        Ok(set.collect())
    }

    /// Deflection at `time_s`, rad.
    pub fn at(&self, time_s: f64) -> f64 {
        self.amplitude_rad * self.unit(time_s / self.period_s)
    }

    /// Relative peak factor `(max - min) / (2 sqrt(2) rms)`; 1 for a single sine.
    pub fn relative_peak_factor(&self) -> f64 {
        let (mut low, mut high) = (f64::INFINITY, f64::NEG_INFINITY);
        for sample in 0..SAMPLES {
            let value = self.unit(sample as f64 / SAMPLES as f64);
            low = low.min(value);
            high = high.max(value);
        }
        // Equal powers that sum to one: the mean square of the sum of sines is 1/2.
        (high - low) / (2.0 * std::f64::consts::SQRT_2 * 0.5f64.sqrt())
    }

    /// Value for unit amplitude at a fraction of the period.
    fn unit(&self, fraction: f64) -> f64 {
        let weight = (1.0 / self.harmonics.len() as f64).sqrt();
        let waves = self.harmonics.iter().zip(&self.phases_rad);
        weight * waves.map(|(&k, phase)| libm::sin(TAU * f64::from(k) * fraction + phase)).sum::<f64>()
    }

    /// Mean of the sixteenth power: a smooth stand-in for the peak.
    fn peakiness(&self) -> f64 {
        let values = (0..SAMPLES).map(|sample| self.unit(sample as f64 / SAMPLES as f64));
        values.map(|value| (value * value * value * value) * (value * value * value * value)).map(|v| v * v).sum()
    }

    /// Moves one phase at a time, keeps what lowers the peaks, and halves the move when nothing does.
    fn optimise(&mut self) {
        let mut best = self.peakiness();
        let mut step = PI / 4.0;
        for _ in 0..ROUNDS {
            let mut improved = false;
            for index in 0..self.phases_rad.len() {
                for direction in [step, -step] {
                    let kept = self.phases_rad[index];
                    self.phases_rad[index] = kept + direction;
                    let peakiness = self.peakiness();
                    if peakiness < best {
                        best = peakiness;
                        improved = true;
                    } else {
                        self.phases_rad[index] = kept;
                    }
                }
            }
            if !improved {
                step *= 0.5;
            }
        }
    }

    /// Shifts time to the first upward zero crossing.
    fn begin_at_zero(&mut self) {
        let at = |index: usize| self.unit(index as f64 / SAMPLES as f64);
        let crossing = (0..SAMPLES).find(|&index| at(index) <= 0.0 && at(index + 1) > 0.0).unwrap_or(0);
        let (mut low, mut high) = (crossing as f64 / SAMPLES as f64, (crossing + 1) as f64 / SAMPLES as f64);
        for _ in 0..50 {
            let middle = 0.5 * (low + high);
            if self.unit(middle) > 0.0 { high = middle } else { low = middle }
        }
        for (phase, &k) in self.phases_rad.iter_mut().zip(&self.harmonics) {
            *phase = (*phase + TAU * f64::from(k) * low).rem_euclid(TAU);
        }
    }
}

/// Schroeder's phases `phi_k = -pi k (k - 1) / n` for equal powers.
fn schroeder(count: usize) -> Vec<f64> {
    (1..=count).map(|k| -PI * (k * (k - 1)) as f64 / count as f64).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Products of two signals over one period: round-off of 512 terms, -.
    const ORTHOGONAL: f64 = 1e-12;
    /// Start value after 50 bisections, -.
    const ZERO: f64 = 1e-9;
    /// Relative peak factor that counts as optimised (a single sine has 1).
    const GOOD_PEAK_FACTOR: f64 = 1.2;

    #[test]
    fn multisines_are_orthogonal_flat_and_begin_at_zero() {
        let set = Multisine::orthogonal_set(20.0, 0.05, 2, 31, 3).unwrap();
        for (i, a) in set.iter().enumerate() {
            assert!(a.relative_peak_factor() < GOOD_PEAK_FACTOR, "{}", a.relative_peak_factor());
            assert!(a.unit(0.0).abs() < ZERO && a.unit(1.0).abs() < ZERO);
            for b in &set[i + 1..] {
                let product =
                    (0..SAMPLES).map(|s| s as f64 / SAMPLES as f64).map(|f| a.unit(f) * b.unit(f)).sum::<f64>();
                assert!((product / SAMPLES as f64).abs() < ORTHOGONAL);
            }
        }
    }

    #[test]
    fn multisine_rejects_fewer_harmonics_than_controls() {
        let error = Multisine::orthogonal_set(20.0, 0.05, 3, 4, 3).unwrap_err().to_string();
        assert!(error.contains("3 controls") && error.contains("3 to 4"), "{error}");
    }
}
