//! Noise of channels over steady parts.

use doublet_core::airframe::instruments::StatedNoise;
use doublet_core::prep::{NoiseOrigin, NoiseSums, PrepError, WHITE_LEVEL, noise_proposal, noise_statistics};
use doublet_core::series::{Series, TimeRange};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use rand_distr::StandardNormal;

/// Noise of the pitch gyro, thesis Table 4.15, rad/s.
const SIGMA: f64 = 1.20e-3;

/// A gyro at 50 Hz: noise of correlation `keep` from sample to sample on a trend.
fn gyro(keep: f64, resolution: f64, seed: u64) -> Series {
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    let time: Vec<f64> = (0..3000).map(|k| 0.02 * f64::from(k)).collect();
    let mut noise = 0.0;
    let values = time.iter().map(|t| {
        noise = keep * noise + (1.0 - keep * keep).sqrt() * SIGMA * rng.sample::<f64, _>(StandardNormal);
        let value = 2e-3 + 3e-4 * t + noise;
        if resolution > 0.0 { (value / resolution).round() * resolution } else { value }
    });
    Series { values: values.collect(), time_s: time.into() }
}

const WINDOWS: [TimeRange; 3] = [
    TimeRange { start_s: 2.0, end_s: 12.0 },
    TimeRange { start_s: 20.0, end_s: 30.0 },
    TimeRange { start_s: 41.0, end_s: 51.0 },
];

#[test]
fn noise_statistics_recover_truth_deviation_of_white_noise_on_a_trend() {
    /// Four standard errors of a standard deviation over 1,500 samples, relative.
    const SCATTER: f64 = 0.075;
    let mut white = 0;
    for seed in 0..40 {
        let found = noise_statistics(&gyro(0.0, 0.0, seed), &WINDOWS, 1).unwrap();
        assert_eq!((found.samples, found.windows), (1503, 3));
        assert!((found.std / SIGMA - 1.0).abs() < SCATTER && (found.difference_std / SIGMA - 1.0).abs() < SCATTER);
        assert!(found.lag_one.abs() < 0.1);
        white += usize::from(found.whiteness > 0.05);
    }
    // 95 % of white noises pass at 5 %: 38 of 40, three standard deviations of 1.4 below.
    assert!(white >= 33, "{white} of 40");
}

#[test]
fn coloured_noise_is_told_from_white() {
    let found = noise_statistics(&gyro(0.8, 0.0, 3), &WINDOWS, 1).unwrap();
    assert!((found.lag_one - 0.8).abs() < 0.08, "{}", found.lag_one);
    assert!(found.whiteness < 1e-6 && found.difference_std < 0.55 * found.std);
}

#[test]
fn one_white_noise_in_twenty_is_called_coloured_however_many_windows_it_is_in() {
    let short = |count: usize, length_s: f64| -> Vec<TimeRange> {
        let start = |k: usize| 3.0 * k as f64;
        (0..count).map(|k| TimeRange { start_s: start(k), end_s: start(k) + length_s }).collect()
    };
    // One long window, three, twenty of 75 samples, each with its own line taken off.
    let cases = [vec![TimeRange { start_s: 0.0, end_s: 60.0 }], WINDOWS.to_vec(), short(20, 1.5)];
    for windows in cases {
        let white = |seed| noise_statistics(&gyro(0.0, 0.0, seed), &windows, 1).unwrap().whiteness >= WHITE_LEVEL;
        let share = (0..2000).filter(|&seed| !white(seed)).count() as f64 / 2000.0;
        println!("{} windows: {:.2} % called coloured", windows.len(), 100.0 * share);
        // 2,000 sequences at 5 %: three standard deviations either way.
        assert!((0.035..0.065).contains(&share), "{} windows: {share}", windows.len());
    }
}

#[test]
fn proposals_are_what_was_measured_or_stated_and_nothing_else() {
    let stated = StatedNoise { std: 1e-2, source: "bench".to_owned(), always: false };
    let judged = StatedNoise { always: true, ..stated.clone() };
    // 1,000 white samples of 0.0018 give 0.0018, whatever was stated for want of them.
    let mut rng = ChaCha8Rng::seed_from_u64(5);
    let time: Vec<f64> = (0..1000).map(|k| 0.02 * f64::from(k)).collect();
    let values = time.iter().map(|_| 0.0018 * rng.sample::<f64, _>(StandardNormal)).collect();
    let whole = [TimeRange { start_s: 0.0, end_s: 20.0 }];
    let white = noise_statistics(&Series { time_s: time.into(), values }, &whole, 2).unwrap();
    for stated in [None, Some(&stated)] {
        let choice = noise_proposal(Ok(&white), stated).unwrap();
        // Four standard errors of a standard deviation over 1,000 samples.
        assert!((choice.proposed / 0.0018 - 1.0).abs() < 0.09, "{choice:?}");
        assert!(matches!(choice.origin, NoiseOrigin::Windows(_)));
    }
    assert_eq!(noise_proposal(Ok(&white), Some(&judged)).unwrap().proposed, 1e-2);
    // A recorder much coarser than its noise shows steps, here of a still channel that flickers once.
    let mut still = vec![0.25; 600];
    still[300] = 0.26;
    let coarse = Series { time_s: (0..600).map(|k| 0.02 * f64::from(k)).collect(), values: still.into() };
    let coarse = noise_statistics(&coarse, &[TimeRange { start_s: 0.0, end_s: 12.0 }], 0).unwrap();
    let choice = noise_proposal(Ok(&coarse), None).unwrap();
    assert!(matches!(choice.origin, NoiseOrigin::Resolution(_)));
    assert!((choice.proposed - 0.01 / 12f64.sqrt()).abs() < 1e-9);
    // What is no noise, or was not recorded, gives the reason or what is stated.
    let coloured = noise_statistics(&gyro(0.9, 0.0, 2), &WINDOWS, 1).unwrap();
    let reason = noise_proposal(Ok(&coloured), None).unwrap_err();
    assert!(reason.contains("lag-one correlation 0.9") && reason.contains("(limit 0.5)"), "{reason}");
    assert_eq!(noise_proposal(Ok(&coloured), Some(&stated)).unwrap().origin, NoiseOrigin::Stated("bench".to_owned()));
    assert_eq!(noise_proposal(Err("it is not recorded".to_owned()), None).unwrap_err(), "it is not recorded");
}

#[test]
fn noise_of_several_recordings_is_pooled_by_their_samples() {
    let [one, other] = [gyro(0.0, 0.0, 7), gyro(0.0, 0.0, 8)];
    let loud = Series { values: other.values.iter().map(|value| 3.0 * value).collect(), ..other };
    let mut sums = NoiseSums::new(1);
    sums.add(&one, &WINDOWS).unwrap();
    sums.add(&loud, &WINDOWS[..1]).unwrap();
    let found = sums.statistics().unwrap();
    assert_eq!((found.samples, found.windows), (4 * 501, 4));
    // Three windows of variance 1 and one of 9: 3 on the mean.
    assert!((found.std / SIGMA / 3f64.sqrt() - 1.0).abs() < 0.1, "{}", found.std / SIGMA);
}

#[test]
fn noise_statistics_reject_windows_without_samples() {
    let refused = noise_statistics(&gyro(0.0, 0.0, 1), &[TimeRange { start_s: 100.0, end_s: 110.0 }], 1);
    assert!(matches!(refused, Err(PrepError::TooFewSamples { needed: 9, found: 0, .. })), "{refused:?}");
    assert!(noise_statistics(&gyro(0.0, 0.0, 1), &[], 1).is_err());
}

#[test]
fn channel_that_rests_on_one_step_in_the_windows_has_the_noise_of_that_step() {
    const STEP: f64 = 0.004;
    let time_s: Vec<f64> = (0..3000).map(|k| 0.02 * f64::from(k)).collect();
    let moving = |t: f64| if t > 52.0 { (0.02 * (t - 52.0).sin() / STEP).round() * STEP } else { 0.0 };
    let values = time_s.iter().map(|&t| moving(t)).collect();
    let found = noise_statistics(&Series { time_s: time_s.clone().into(), values }, &WINDOWS, 1).unwrap();
    assert!(found.std < 1e-12 && (found.resolution - STEP).abs() < 1e-12, "{found:?}");
    let choice = noise_proposal(Ok(&found), None).unwrap();
    assert!(
        (choice.proposed - STEP / 12f64.sqrt()).abs() < 1e-12 && matches!(choice.origin, NoiseOrigin::Resolution(_))
    );
    // What never moves at all tells nothing.
    let still = Series { values: vec![0.3; time_s.len()].into(), time_s: time_s.into() };
    let found = noise_statistics(&still, &WINDOWS, 1).unwrap();
    assert!(found.resolution == 0.0 && found.std < 1e-12);
}
