//! Offset and drift recovered.

use doublet_core::align::{
    AlignError, ClockEstimate, ClockFitSettings, ClockModel, ClockPair, ClockSearch, clock_fit_pairs,
};
use doublet_core::series::Series;

use super::support::Motion;

/// Largest error of an offset, s, and of a drift: what flight-path reconstruction can stand.
const OFFSET_S: f64 = 5e-3;
const DRIFT: f64 = 2e-5;
/// Clocks of thesis Table 4.14, flight FT1.0.
const MONITOR: ClockModel = ClockModel { offset_s: -0.734, drift: -4.51e-5 };
const POD: ClockModel = ClockModel { offset_s: -258.810, drift: -1.43e-4 };
/// Length of the synthetic flights, s.
const DURATION_S: f64 = 3000.0;

/// Reference at 50 Hz, other recorder at 5 Hz with noise and resolution of a pod's bank angle.
fn recorded(clock: ClockModel, rate_hz: f64, seed: u64) -> (Series, Series) {
    let motion = Motion::new(DURATION_S, seed);
    let reference = motion.record(ClockModel::REFERENCE, 50.0, DURATION_S, [6e-4, 2.7e-4], seed + 1000);
    let other = motion.record(clock, rate_hz, DURATION_S, [9e-4, 1.7e-3], seed + 2000);
    (reference, other)
}

/// Clock from one quantity that both recorders have.
fn clock_fit(reference: &Series, other: &Series, settings: &ClockFitSettings) -> Result<ClockEstimate, AlignError> {
    clock_fit_pairs(&[ClockPair { name: "shared channel", reference, other, inverted: false }], settings)
}

#[test]
fn clock_fit_recovers_truth_offset_and_drift_from_anywhere() {
    for (clock, rate_hz) in [(MONITOR, 1.0 / 0.18), (POD, 5.0), (POD, 1.0)] {
        let (reference, other) = recorded(clock, rate_hz, 3);
        let found = clock_fit(&reference, &other, &ClockFitSettings::default()).unwrap();
        let (offset, drift) = (found.model.offset_s - clock.offset_s, found.model.drift - clock.drift);
        println!(
            "{rate_hz:.2} Hz: offset {offset:+.2e} s of {:.1e}, drift {drift:+.1e} of {:.1e}",
            found.offset_sd_s, found.drift_sd
        );
        assert!(offset.abs() < OFFSET_S && drift.abs() < DRIFT, "{found:?}");
    }
}

#[test]
fn clock_fit_is_consistent_with_its_standard_errors() {
    /// Flights. The mean square of an error over its standard error is 1.4 where seven degrees of freedom gave the latter
    /// (Student's t); over 24 flights it scatters by 0.57: the band is three of them above and two below.
    const FLIGHTS: u64 = 24;
    const BAND: std::ops::Range<f64> = 0.26..3.1;
    let (mut offset_squares, mut drift_squares) = (0.0, 0.0);
    for seed in 0..FLIGHTS {
        let (reference, other) = recorded(POD, 5.0, 10 + seed);
        let search = ClockSearch::About(ClockModel { offset_s: -259.0, drift: 0.0 });
        let found = clock_fit(&reference, &other, &ClockFitSettings { search, ..Default::default() }).unwrap();
        let (own, sd) = found.best_known;
        offset_squares += ((found.model.reference_s(own) - POD.reference_s(own)) / sd).powi(2);
        drift_squares += ((found.model.drift - POD.drift) / found.drift_sd).powi(2);
    }
    let (offset, drift) = (offset_squares / FLIGHTS as f64, drift_squares / FLIGHTS as f64);
    println!("mean square of normalised errors: offset {offset:.2}, drift {drift:.2}");
    assert!(BAND.contains(&offset) && BAND.contains(&drift));
}

#[test]
fn chunks_that_disagree_are_left_out_and_said_so() {
    let (reference, other) = recorded(POD, 5.0, 5);
    // For a quarter of the flight the recorder logged with a stale buffer, 0.3 s late.
    let late = |&t: &f64| if (1000.0..1700.0).contains(&t) { t + 0.3 } else { t };
    let mut time: Vec<f64> = other.time_s.iter().map(late).collect();
    let mut values: Vec<f64> = other.values.to_vec();
    let overlap: Vec<bool> = time.iter().map(|t| (1700.0..1700.4).contains(t)).collect();
    let keep = |k: usize| !overlap[k];
    time = time.iter().enumerate().filter(|(k, _)| keep(*k)).map(|(_, t)| *t).collect();
    values = values.iter().enumerate().filter(|(k, _)| keep(*k)).map(|(_, v)| *v).collect();
    let spoilt = Series { time_s: time.into(), values: values.into() };
    let found = clock_fit(&reference, &spoilt, &ClockFitSettings::default()).unwrap();
    assert!(
        (found.model.reference_s(0.0) - POD.offset_s).abs() < OFFSET_S && (found.model.drift - POD.drift).abs() < DRIFT
    );
    let left_out: Vec<_> = found.chunks.iter().filter(|chunk| !chunk.used).collect();
    assert!(left_out.iter().any(|chunk| (chunk.residual_s + 0.3).abs() < 0.02), "{:?}", found.chunks);
}

#[test]
fn pairs_combine_with_their_signs_and_drift_can_be_held() {
    let (reference, other) = recorded(MONITOR, 1.0 / 0.18, 7);
    let negative = Series { time_s: other.time_s.clone(), values: other.values.iter().map(|v| -v).collect() };
    let pairs = [
        ClockPair { name: "bank", reference: &reference, other: &other, inverted: false },
        ClockPair { name: "load factor", reference: &reference, other: &negative, inverted: true },
    ];
    let found = clock_fit_pairs(&pairs, &ClockFitSettings::default()).unwrap();
    assert!((found.model.offset_s - MONITOR.offset_s).abs() < OFFSET_S);
    assert!(found.chunks.iter().any(|chunk| chunk.pair == 1 && chunk.used));
    let search = ClockSearch::About(ClockModel { offset_s: -0.5, drift: MONITOR.drift });
    let held = ClockFitSettings { fit_drift: false, search, ..Default::default() };
    let found = clock_fit_pairs(&pairs, &held).unwrap();
    assert_eq!((found.model.drift, found.drift_sd), (MONITOR.drift, 0.0));
    assert!((found.model.offset_s - MONITOR.offset_s).abs() < OFFSET_S);
}

#[test]
fn clock_fit_rejects_strangers_stills_and_bad_stamps() {
    let (reference, other) = recorded(POD, 5.0, 5);
    let (_, stranger) = recorded(POD, 5.0, 99);
    let settings = ClockFitSettings::default();
    let refused = clock_fit(&reference, &stranger, &settings).unwrap_err();
    assert!(matches!(refused, AlignError::NoAgreement { .. }), "{refused}");
    assert!(!refused.to_string().contains('\n'));
    let still = Series { time_s: other.time_s.clone(), values: other.values.iter().map(|_| 1.0).collect() };
    assert!(matches!(clock_fit(&reference, &still, &settings), Err(AlignError::Still { .. })));
    let none = Series { time_s: [].into(), values: [].into() };
    assert!(matches!(clock_fit(&reference, &none, &settings), Err(AlignError::Still { .. })));
    let backward = Series { time_s: [0.0, 2.0, 1.0].into(), values: [0.0, 1.0, 2.0].into() };
    assert!(matches!(clock_fit(&backward, &other, &settings), Err(AlignError::Signal { .. })));
    let stray = Series { time_s: [0.0, 1.0, 2.0, 1e12].into(), values: [0.0, 1.0, 0.0, 1.0].into() };
    let refused = clock_fit(&stray, &other, &settings).unwrap_err();
    assert!(refused.to_string().contains("1000000000000 s"), "{refused}");
    let zero_step = ClockFitSettings { step_s: 0.0, ..settings };
    assert!(matches!(clock_fit(&reference, &other, &zero_step), Err(AlignError::Setting { setting: "step_s", .. })));
    assert!(matches!(clock_fit_pairs(&[], &settings), Err(AlignError::Setting { .. })));
}
