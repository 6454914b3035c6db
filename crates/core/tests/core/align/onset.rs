//! A control sensor aligned by the aircraft's first response.

use doublet_core::align::{AlignError, OnsetSettings, onset_alignment};
use doublet_core::series::{Series, TimeRange};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use rand_distr::StandardNormal;

/// Onset of the doublet, s.
const ONSET_S: f64 = 4.0;

/// Hand-flown doublet: half cosines of a quarter of a second between its levels, rad.
fn doublet(t: f64) -> f64 {
    let edge = |at: f64| 0.5 * (1.0 - (std::f64::consts::PI * ((t - at) / 0.25).clamp(0.0, 1.0)).cos());
    0.035 * (edge(ONSET_S) - 2.0 * edge(ONSET_S + 0.9) + edge(ONSET_S + 1.8))
}

/// Pitch acceleration of a short period of 3.5 rad/s and damping 0.6 to that doublet at 50 Hz with the noise of the gyro's
/// derivative, pitch rate and attitude, and the elevator at 60 Hz stamped `late_s` too late.
fn recorded(late_s: f64, seed: u64) -> (Series, Series, [Series; 2]) {
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    let (step, mut q, mut theta) = (1e-3, 0.0, 0.0);
    let (mut time, mut values, mut motion) = (Vec::new(), Vec::new(), [Vec::new(), Vec::new()]);
    for k in 0..8000 {
        let t = f64::from(k) * step;
        let q_dot = -12.0 * doublet(t) - 4.2 * q - 12.25 * theta;
        if k % 20 == 0 {
            time.push(t);
            for (column, value) in motion.iter_mut().zip([q, theta]) {
                column.push(value + 5e-4 * rng.sample::<f64, _>(StandardNormal));
            }
            values.push(q_dot + 5e-3 * rng.sample::<f64, _>(StandardNormal));
        }
        q += q_dot * step;
        theta += q * step;
    }
    let response = Series { time_s: time.into(), values: values.into() };
    let motion = motion.map(|column| Series { time_s: response.time_s.clone(), values: column.into() });
    let stamps: Vec<f64> = (0..480).map(|k| f64::from(k) / 60.0).collect();
    let elevator = stamps.iter().map(|&t| doublet(t) + 3e-4 * rng.sample::<f64, _>(StandardNormal)).collect();
    (Series { time_s: stamps.iter().map(|t| t + late_s).collect(), values: elevator }, response, motion)
}

#[test]
fn onset_alignment_recovers_truth_shift_within_two_milliseconds() {
    /// What the thesis reached by hand, s.
    const PRECISION_S: f64 = 2e-3;
    let window = TimeRange { start_s: ONSET_S - 1.0, end_s: ONSET_S + 1.2 };
    for (late_s, seed) in [(0.030, 1), (-0.120, 2), (0.217, 3), (0.0, 4), (0.030, 5)] {
        let (control, response, [rate, pitch]) = recorded(late_s, seed);
        let found = onset_alignment(&control, &response, &[&rate, &pitch], window, &OnsetSettings::default()).unwrap();
        println!("late {late_s}: shift {:+.4} s, standard error {:.4} s", found.shift_s, found.shift_sd_s);
        assert!((found.shift_s + late_s).abs() < PRECISION_S && found.shift_sd_s < PRECISION_S, "{found:?}");
        assert!(found.share > 0.95);
    }
}

#[test]
fn onset_alignment_is_consistent_with_its_standard_error() {
    /// Recordings. The mean square of an error over its standard error is one; over 40 recordings it scatters by 0.22: the band is
    /// three of them to either side, and wider above, since the control's own noise is not in the standard error.
    const RECORDINGS: u64 = 40;
    const BAND: std::ops::Range<f64> = 0.33..2.0;
    let window = TimeRange { start_s: ONSET_S - 1.0, end_s: ONSET_S + 1.2 };
    let mut squares = 0.0;
    for seed in 100..100 + RECORDINGS {
        let (control, response, [rate, pitch]) = recorded(0.03, seed);
        let found = onset_alignment(&control, &response, &[&rate, &pitch], window, &OnsetSettings::default()).unwrap();
        squares += ((found.shift_s + 0.03) / found.shift_sd_s).powi(2);
    }
    let mean = squares / RECORDINGS as f64;
    println!("mean square of normalised errors: {mean:.2}");
    assert!(BAND.contains(&mean), "{mean}");
}

#[test]
fn onset_alignment_rejects_noise_and_windows_without_samples() {
    let (control, response, [rate, pitch]) = recorded(0.0, 9);
    let settings = OnsetSettings::default();
    let quiet = TimeRange { start_s: 1.0, end_s: 3.0 };
    let refused = onset_alignment(&control, &response, &[&rate, &pitch], quiet, &settings);
    assert!(matches!(refused, Err(AlignError::NoResponse { .. } | AlignError::ShiftAtEnd { .. })), "{refused:?}");
    let outside = TimeRange { start_s: 7.5, end_s: 9.5 };
    let refused = onset_alignment(&control, &response, &[&rate, &pitch], outside, &settings);
    assert!(matches!(refused, Err(AlignError::OnsetSamples { found: 0, .. })), "{refused:?}");
    let other = Series { time_s: control.time_s.clone(), values: control.values.clone() };
    let refused = onset_alignment(&control, &response, &[&other], quiet, &settings);
    assert!(matches!(refused, Err(AlignError::Signal { .. })), "{refused:?}");
    let wide = OnsetSettings { range_s: 1e9, ..settings };
    let refused = onset_alignment(&control, &response, &[], quiet, &wide);
    assert!(matches!(refused, Err(AlignError::Setting { setting: "range_s", .. })), "{refused:?}");
    let far = OnsetSettings { range_s: 0.05, ..settings };
    let (late, response, [rate, pitch]) = recorded(0.3, 9);
    let window = TimeRange { start_s: ONSET_S - 1.0, end_s: ONSET_S + 1.2 };
    assert!(matches!(
        onset_alignment(&late, &response, &[&rate, &pitch], window, &far),
        Err(AlignError::ShiftAtEnd { .. })
    ));
}
