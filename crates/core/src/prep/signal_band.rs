//! Up to which frequency a signal stands out of its noise.

use super::spectrum::spectrum;
use crate::series::Series;
use crate::statistics::median;

/// Bins whose median is the density at the middle one: a single line of vibration is no signal.
const SMOOTHED: usize = 7;
/// Segments, of two samples a bin and overlapping by half, below which a spectrum is too uncertain.
const LEAST_SEGMENTS: usize = 8;

/// Highest frequency, Hz, at which the power spectral density of `series` is at least twice that of its noise: the motion has as much
/// power there as the noise. The noise is white, its density the median over the upper third of the frequencies. `None` where the recording is
/// too short for a spectrum or nothing stands out.
pub fn signal_band_hz(series: &Series) -> Option<f64> {
    let found = spectrum(series)?;
    let bins = found.density.len();
    if series.values.len() < bins * LEAST_SEGMENTS || bins < 3 * SMOOTHED {
        return None;
    }
    let noise = median(&mut found.density[2 * bins / 3..].to_vec())?;
    let stands_out = |window: &[f64]| median(&mut window.to_vec()).is_some_and(|density| density > 2.0 * noise);
    let last = found.density.windows(SMOOTHED).rposition(stands_out)?;
    found.frequency_hz.get(last + SMOOTHED / 2).copied()
}

#[cfg(test)]
mod tests {
    use rand::{RngExt, SeedableRng};
    use rand_chacha::ChaCha8Rng;
    use rand_distr::StandardNormal;

    use super::*;

    /// White noise of one through two first-order lags of 0.1 s, beside white noise of deviation `noise`.
    fn motion_with_noise(noise: f64, samples: usize) -> Series {
        let mut random = ChaCha8Rng::seed_from_u64(5);
        let (step_s, lag_s) = (0.02, 0.1);
        let (mut first, mut second) = (0.0, 0.0);
        let values = (0..samples).map(|_| {
            first += step_s / lag_s * (random.sample::<f64, _>(StandardNormal) - first);
            second += step_s / lag_s * (first - second);
            second + noise * random.sample::<f64, _>(StandardNormal)
        });
        let values: Vec<f64> = values.collect();
        let time_s: Vec<f64> = (0..samples).map(|k| k as f64 * step_s).collect();
        Series { time_s: time_s.into(), values: values.into() }
    }

    #[test]
    fn band_ends_where_motion_and_noise_have_equal_power() {
        // |1 / (1 + (w T)^2)|^2 = noise^2: w T = sqrt(1 / noise - 1).
        for noise in [0.1, 0.3] {
            let expected = (1.0 / noise - 1.0_f64).sqrt() / 0.1 / std::f64::consts::TAU;
            let found = signal_band_hz(&motion_with_noise(noise, 20_000)).unwrap();
            assert!((found / expected - 1.0).abs() < 0.25, "noise {noise}: {found} Hz, expected {expected} Hz");
        }
    }

    #[test]
    fn noise_alone_and_a_short_recording_have_no_band() {
        let mut noise = motion_with_noise(0.0, 20_000);
        let mut random = ChaCha8Rng::seed_from_u64(6);
        noise.values = (0..20_000).map(|_| random.sample::<f64, _>(StandardNormal)).collect();
        assert_eq!(signal_band_hz(&noise), None);
        assert_eq!(signal_band_hz(&motion_with_noise(0.1, 500)), None);
    }
}
