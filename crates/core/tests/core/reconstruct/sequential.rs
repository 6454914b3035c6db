//! The filter over samples as they come, against the same filter over the whole window.

use std::ops::ControlFlow;

use doublet_core::reconstruct::{
    AIR_STATES, FilterData, FilterSettings, MeasurementSeries, Method, STATES, SequentialFilter, reconstruct,
};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

use super::equality::weaving_flight;

/// Agreement of both, in standard deviations: the vectors they run in round differently.
const EQUAL_SIGMA: f64 = 1e-6;

/// The part of a window from inertial sample `first` to `last`, with the measurements after the first and up to the last.
fn part(data: &FilterData, first: usize, last: usize) -> FilterData {
    let mut part = data.clone();
    let time_s = &data.inputs.time_s;
    part.inputs.time_s = time_s[first..=last].into();
    part.inputs.columns.iter_mut().for_each(|column| *column = column[first..=last].into());
    for series in &mut part.measurements {
        let inside = |time: &f64| *time > time_s[first] + 1e-9 && *time <= time_s[last] + 1e-9;
        let kept = series.time_s.iter().zip(series.values.iter()).filter(|(time, _)| inside(time));
        let (time_s, values): (Vec<f64>, Vec<f64>) = kept.map(|(time, value)| (*time, *value)).unzip();
        *series = MeasurementSeries { time_s: time_s.into(), values: values.into() };
    }
    part
}

#[test]
fn filter_in_parts_matches_the_filter_over_the_window() {
    for seed in 0..12 {
        let random = &mut ChaCha8Rng::seed_from_u64(seed);
        let data = weaving_flight(random);
        // It cannot look back at what follows a spike.
        let robust_limit = if seed >= 8 { 1.5 } else { 0.0 };
        let mut settings = FilterSettings { outlier_limit: 0.0, robust_limit, ..FilterSettings::default() };
        match seed % 4 {
            1 => settings.method = Method::Ekf,
            2 => settings.method = Method::Ukf { spread: Method::USUAL_SPREAD },
            3 => settings.air_data_deviation = [0.01; AIR_STATES],
            _ => {}
        }
        let settings = settings.check().unwrap();
        let whole = reconstruct(&data, &settings, &mut |_| ControlFlow::Continue(())).unwrap();
        let mut filter = SequentialFilter::new(&data, &settings).unwrap();
        let (mut at, last) = (0, data.inputs.time_s.len() - 1);
        let mut likelihood_terms = (0.0, 0);
        while at < last {
            let next = last.min(at + random.random_range(1..60));
            for (k, sample) in filter.advance(&part(&data, at, next)).unwrap().iter().enumerate() {
                let row = at + 1 + k;
                assert_eq!(sample.time_s, whole.time_s[row]);
                for state in 0..STATES {
                    let deviation = whole.deviations[state].at(row);
                    let error = (sample.states[state] - whole.states[state][row]) / deviation;
                    assert!(error.abs() < EQUAL_SIGMA, "seed {seed}, state {state}, sample {row}: {error}");
                    approx::assert_relative_eq!(sample.deviations[state], deviation, max_relative = 1e-6);
                }
                likelihood_terms.0 += sample.nis;
                likelihood_terms.1 += sample.nis_degrees;
            }
            at = next;
        }
        let nis: f64 = whole.nis.iter().filter(|nis| nis.is_finite()).sum();
        approx::assert_relative_eq!(likelihood_terms.0, nis, max_relative = 1e-6);
        assert_eq!(likelihood_terms.1, whole.nis_degrees.iter().map(|count| usize::from(*count)).sum::<usize>());
    }
}
