//! Continuous turbulence of the Dryden form.

use rand::RngExt;
use rand_chacha::ChaCha8Rng;
use rand_distr::StandardNormal;

/// Scale length above 2,000 ft, 1,750 ft (MIL-F-8785C, section 3.7.2.2), m.
const SCALE_LENGTH_M: f64 = 533.4;

/// Dryden gusts along body axes (MIL-F-8785C, section 3.7): independent stationary noises with the power spectra
/// `Phi_u = s^2 2L/(pi V) / (1 + (L w/V)^2)` and `Phi_v = Phi_w = s^2 L/(pi V) (1 + 3 (L w/V)^2) / (1 + (L w/V)^2)^2`,
/// one standard deviation `s` for all three. The shaping filters are advanced exactly for the step. Gust rates are
/// not modelled.
#[derive(Clone, Debug)]
pub struct Dryden {
    sigma_m_s: f64,
    along: f64,
    across: [[f64; 2]; 2],
    airspeed_m_s: f64,
    decay: f64,
    /// Lower factor of the step noise of the two states of a transverse gust.
    factor: [f64; 3],
    ratio: f64,
}

impl Dryden {
    /// Gusts of standard deviation `sigma_m_s`, at rest at first and stationary after a few `L / V`.
    pub fn new(sigma_m_s: f64) -> Self {
        Self {
            sigma_m_s,
            along: 0.0,
            across: [[0.0; 2]; 2],
            airspeed_m_s: 0.0,
            decay: 0.0,
            factor: [0.0; 3],
            ratio: 0.0,
        }
    }

    /// Standard deviation of the gusts along the flight path, m/s, that wander as a random walk of `walk` (m/s per square root of a second)
    /// does: `walk^2 = 2 s^2 V / L` over times that are short beside `L / V`.
    pub fn deviation_of_walk(walk: f64, airspeed_m_s: f64) -> f64 {
        walk * (SCALE_LENGTH_M / (2.0 * airspeed_m_s)).sqrt()
    }

    /// Gust velocity in body axes after another `step_s` at `airspeed_m_s` (below 10 m/s: at 10 m/s), m/s.
    pub fn step(&mut self, airspeed_m_s: f64, step_s: f64, rng: &mut ChaCha8Rng) -> [f64; 3] {
        if self.sigma_m_s == 0.0 {
            return [0.0; 3];
        }
        // The filters follow the airspeed in steps of 1 m/s, which keeps their exponentials out of the loop.
        let airspeed = airspeed_m_s.max(10.0);
        if (airspeed - self.airspeed_m_s).abs() > 1.0 {
            self.tune(airspeed, step_s);
        }
        let decay = self.decay;
        self.along = decay * self.along + (1.0 - decay * decay).sqrt() * normal(rng);
        let [l00, l10, l11] = self.factor;
        let ratio = self.ratio;
        let sigma = self.sigma_m_s;
        let transverse = self.across.each_mut().map(|state| {
            let (n0, n1) = (normal(rng), normal(rng));
            state[1] = decay * (state[1] + ratio * state[0]) + l10 * n0 + l11 * n1;
            state[0] = decay * state[0] + l00 * n0;
            sigma * (3f64.sqrt() * state[0] + (1.0 - 3f64.sqrt()) * state[1])
        });
        [sigma * self.along, transverse[0], transverse[1]]
    }

    /// Transition and step noise for one airspeed. With `tau = L/V` and states `x0 = n/(1 + tau s)`, `x1 = x0/(1 + tau s)`
    /// scaled by `sqrt(tau)`, the transverse gust is `s (sqrt(3) x0 + (1 - sqrt(3)) x1)` of variance `s^2`.
    fn tune(&mut self, airspeed_m_s: f64, step_s: f64) {
        let a = step_s * airspeed_m_s / SCALE_LENGTH_M;
        let e = libm::exp(-2.0 * a);
        let v00 = 0.5 * (1.0 - e);
        let v01 = 0.25 - e * (0.5 * a + 0.25);
        let v11 = 0.25 - e * (0.5 * a * a + 0.5 * a + 0.25);
        let l00 = v00.sqrt();
        let l10 = v01 / l00;
        self.factor = [l00, l10, (v11 - l10 * l10).max(0.0).sqrt()];
        self.decay = libm::exp(-a);
        self.ratio = a;
        self.airspeed_m_s = airspeed_m_s;
    }
}

/// Standard normal deviate.
fn normal(rng: &mut ChaCha8Rng) -> f64 {
    rng.sample(StandardNormal)
}

#[cfg(test)]
mod tests {
    use super::*;
    use rand::SeedableRng;

    /// Four hours hold about 1,200 independent gusts: 3 sigma of the estimated standard deviation, -.
    const STATISTICAL: f64 = 0.08;

    #[test]
    fn gusts_have_the_stated_deviation_and_correlation() {
        let (sigma, airspeed, step) = (1.5, 46.0, 0.05);
        let mut gusts = Dryden::new(sigma);
        let mut rng = ChaCha8Rng::seed_from_u64(3);
        let samples: Vec<[f64; 3]> = (0..288_000).map(|_| gusts.step(airspeed, step, &mut rng)).collect();
        let lag = (SCALE_LENGTH_M / airspeed / step) as usize;
        for axis in 0..3 {
            let covariance = |shift: usize| {
                let pairs = samples.iter().zip(&samples[shift..]);
                pairs.map(|(a, b)| a[axis] * b[axis]).sum::<f64>() / (samples.len() - shift) as f64
            };
            assert!((covariance(0).sqrt() / sigma - 1.0).abs() < STATISTICAL, "axis {axis}: {}", covariance(0).sqrt());
            // Correlation one scale length on: exp(-1) along, exp(-1) (1 - 1/2) across (Dryden's own functions).
            let expected = (-1f64).exp() * if axis == 0 { 1.0 } else { 0.5 };
            assert!((covariance(lag) / covariance(0) - expected).abs() < 2.0 * STATISTICAL, "axis {axis}");
        }
    }
}
