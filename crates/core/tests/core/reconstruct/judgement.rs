//! Consistency and observability on recordings whose answer is known.

use doublet_core::reconstruct::consistency::{consistency, observability, weak_states};
use doublet_core::reconstruct::{FilterData, FilterSettings, InputSeries, Measurement, MeasurementSeries, State};

use super::citation::{self, TRUE_GRAVITY};
use super::reference::run;
use crate::shared::shared;

#[test]
fn true_noise_settings_are_found_consistent() {
    let Some(citation) = citation::load() else { return };
    let settings = FilterSettings { gravity_m_s2: TRUE_GRAVITY, ..citation::settings() };
    let found = consistency(&run(&citation.data, &settings), 1.0).unwrap();
    println!("{} in {:?}", found.nis_mean, found.nis_band);
    assert!((found.nis_band[0]..found.nis_band[1]).contains(&found.nis_mean));
    assert_eq!(found.channels.len(), 12);
    for channel in &found.channels {
        println!("{channel:?}");
        assert!((channel.deviation_ratio - 1.0).abs() < 0.05, "{channel:?}");
        assert!(channel.autocorrelation[0].abs() < 3.0 * channel.autocorrelation_limit, "{channel:?}");
    }
}

#[test]
fn a_wrong_noise_setting_is_named() {
    let Some(citation) = citation::load() else { return };
    let mut settings = FilterSettings { gravity_m_s2: TRUE_GRAVITY, ..citation::settings() };
    settings.measurement_noise[Measurement::Airspeed as usize] *= 2.0;
    let found = consistency(&run(&citation.data, &settings), 1.0).unwrap();
    let airspeed = found.channels.iter().find(|channel| channel.measurement == Measurement::Airspeed).unwrap();
    assert!((airspeed.deviation_ratio - 0.5).abs() < 0.02);
    assert!(!airspeed.is_consistent(), "{airspeed:?}");
    assert!(found.nis_mean < found.nis_band[0]);
}

#[test]
fn all_twelve_measurements_make_the_state_observable_at_the_first_iteration() {
    let scale = citation::settings().initial_deviation;
    let x = [0., 0., 0., 80., 1., 6., 0.1, 0.08, 0.5, 0., 0., 0., 0., 0., 0., 6., 2., 1.];
    let input = [0.8, 0.1, -9.8, 0.05, 0.02, 0.01];
    let all = observability(&x, &input, &[true; 12], &scale, TRUE_GRAVITY);
    assert_eq!((all.rank_of_measurements, all.rank), (12, 18));
    assert!(all.unobservable.is_empty());

    // without position and ground velocity nothing tells where the aircraft is, nor the wind
    let mut air_only = [true; 12];
    air_only[..6].fill(false);
    let found = observability(&x, &input, &air_only, &scale, TRUE_GRAVITY);
    assert_eq!(found.rank, 12);
    for state in [State::PositionNorth, State::PositionDown, State::WindNorth, State::WindDown] {
        assert!(found.unobservable.contains(&state), "{:?}", found.unobservable);
    }
    assert!(!found.unobservable.contains(&State::BiasQ));
}

/// Gyro biases of the published reconstruction of the three manoeuvres, rad/s; one estimate for all of them.
const ATTAS_GYRO_BIASES: [f64; 3] = [1.083_75e-3, 3.336_30e-3, 1.003_00e-3];
/// Each manoeuvre alone, without the published sensor corrections, rad/s: half a milliradian per second.
const ATTAS_TOLERANCE: f64 = 5e-4;

#[test]
fn a_recording_without_position_and_ground_velocity_gives_the_published_gyro_biases() {
    for name in ["fAttasElv1", "fAttasAil1", "fAttasRud1"] {
        let Some(path) = shared(&format!("data/attas/{name}.mat")) else { return };
        let mut probe = doublet_core::load::probe(&path).unwrap();
        probe.complete().unwrap();
        let channels: Vec<_> = probe.sources.iter().flat_map(|source| &source.channels).collect();
        let column = |i: usize, factor: f64| -> Vec<f64> {
            let channel = channels.iter().find(|channel| channel.name.ends_with(&format!("[{i}]"))).unwrap();
            channel.values().iter().map(|value| value * factor).collect()
        };
        let deg = std::f64::consts::PI / 180.0;
        let time_s = column(0, 1.0);
        let mut measurements: [MeasurementSeries; 12] = Default::default();
        for (measurement, i, factor) in [
            (Measurement::BankAngle, 9, deg),
            (Measurement::PitchAngle, 10, deg),
            (Measurement::HeadingAngle, 11, deg),
            (Measurement::Airspeed, 14, 1.0),
            (Measurement::AngleOfAttack, 12, deg),
            (Measurement::Sideslip, 13, deg),
        ] {
            measurements[measurement as usize] =
                MeasurementSeries { time_s: time_s.clone().into(), values: column(i, factor).into() };
        }
        let factors = [(1, 1.0), (2, 1.0), (3, 1.0), (6, deg), (7, deg), (8, deg)];
        let columns = factors.map(|(i, factor)| column(i, factor).into());
        let data = FilterData { inputs: InputSeries { time_s: time_s.into(), columns }, measurements };
        let result = run(&data, &FilterSettings { gravity_m_s2: 9.80, ..FilterSettings::default() });
        let last = result.time_s.len() - 1;
        for (k, expected) in ATTAS_GYRO_BIASES.into_iter().enumerate() {
            let found = result.states[State::BiasP as usize + k][last];
            println!("{name} {found:.3e} {expected:.3e}");
            assert!((found - expected).abs() < ATTAS_TOLERANCE, "{name}: {found} {expected}");
        }
        let weak = weak_states(&result, 0.5);
        assert!(weak.iter().any(|weak| weak.state == State::WindNorth));
        assert!(weak.iter().all(|weak| weak.state != State::BiasQ));
    }
}
