//! Spikes are left out, jumps and clean recordings stay as they are.

use std::sync::Arc;

use doublet_core::reconstruct::{FilterData, FilterSettings, Measurement, Method};

use super::behaviour::window;
use super::citation::{self, TRUE_GRAVITY};
use super::reference::run;

/// Spikes: of each measurement, which samples, how large in SI.
const SPIKES: [(Measurement, &[usize], f64); 5] = [
    (Measurement::PositionDown, &[120, 700], 60.0),
    (Measurement::VelocityNorth, &[200, 201, 640], 4.0),
    (Measurement::PitchAngle, &[300], 0.3),
    (Measurement::Airspeed, &[400, 900], -30.0),
    // At the time of another spike, and once more in its echo.
    (Measurement::AngleOfAttack, &[400, 420], 0.2),
];

fn settings() -> FilterSettings {
    FilterSettings { gravity_m_s2: TRUE_GRAVITY, ..citation::settings() }
}

fn spiked(data: &FilterData) -> FilterData {
    let mut data = data.clone();
    for (measurement, samples, size) in SPIKES {
        let values = Arc::make_mut(&mut data.measurements[measurement as usize].values);
        samples.iter().for_each(|&sample| values[sample] += size);
    }
    data
}

#[test]
fn spikes_are_left_out_and_nothing_else() {
    let Some(citation) = citation::load() else { return };
    let clean = window(&citation.data, 0, 1_000);
    let spiked = spiked(&clean);
    for method in [Method::Ekf, Method::USUAL_IEKF, Method::Ukf { spread: Method::USUAL_SPREAD }] {
        let settings = FilterSettings { method, ..settings() };
        let (found, expected) = (run(&spiked, &settings), run(&clean, &settings));
        for measurement in Measurement::ALL {
            let times = &spiked.measurements[measurement as usize].time_s;
            let samples: Vec<f64> = SPIKES
                .iter()
                .filter(|(of, ..)| *of == measurement)
                .flat_map(|(_, samples, _)| samples.iter().map(|&sample| times[sample]))
                .collect();
            let outliers: Vec<f64> =
                found.outliers[measurement as usize].iter().map(|outlier| outlier.time_s).collect();
            assert_eq!(outliers, samples, "{method:?} {}", measurement.name());
        }
        assert!(expected.outliers.iter().all(Vec::is_empty), "{:?}", expected.outliers);
        // Ten of 12,000 samples are fewer: the path is that of the clean recording.
        let last = found.time_s.len() - 1;
        for state in 0..found.states.len() {
            let error = found.states[state][last] - expected.states[state][last];
            assert!(error.abs() < 0.2 * found.deviations[state].at(last), "{method:?} state {state}");
        }
    }
}

#[test]
fn a_jump_of_a_sensor_and_a_limit_of_zero_leave_every_sample() {
    let Some(citation) = citation::load() else { return };
    let mut data = window(&citation.data, 0, 1_000);
    let values = Arc::make_mut(&mut data.measurements[Measurement::VelocityEast as usize].values);
    values[500..].iter_mut().for_each(|value| *value += 5.0);
    let jumped = run(&data, &settings());
    assert!(jumped.outliers.iter().all(Vec::is_empty), "{:?}", jumped.outliers);

    let spiked = spiked(&data);
    let every = run(&spiked, &FilterSettings { outlier_limit: 0.0, ..settings() });
    assert!(every.outliers.iter().all(Vec::is_empty));
}

#[test]
fn outliers_of_a_late_measurement_keep_their_recorded_times() {
    let Some(citation) = citation::load() else { return };
    let mut data = spiked(&window(&citation.data, 0, 1_000));
    let mut settings = settings();
    let series = &mut data.measurements[Measurement::Airspeed as usize];
    series.time_s = series.time_s.iter().map(|time| time + 0.25).collect();
    settings.measurement_delay_s[Measurement::Airspeed as usize] = 0.25;
    let found = run(&data, &settings);
    let outliers = &found.outliers[Measurement::Airspeed as usize];
    let series = &data.measurements[Measurement::Airspeed as usize];
    assert_eq!(outliers.len(), 2);
    for (outlier, sample) in outliers.iter().zip([400, 900]) {
        assert_eq!(outlier.time_s, series.time_s[sample]);
        assert_eq!(outlier.value, series.values[sample]);
    }
    let without = data.without(&found.outliers);
    let lost = without.measurements.iter().flat_map(|series| series.values.iter()).filter(|value| value.is_nan());
    assert_eq!(lost.count(), SPIKES.iter().map(|(_, samples, _)| samples.len()).sum::<usize>());
}
