//! What the filter does with gaps, other times, known shifts, company, and data it cannot run on.

use std::ops::ControlFlow;
use std::sync::Arc;

use doublet_core::reconstruct::{
    Deviations, FilterData, FilterSettings, Measurement, ReconstructError, Reconstruction, State, Width, reconstruct,
    reconstruct_many, reconstruct_with,
};

use super::citation;
use super::dense::{Step, Z};
use super::reference::{EQUAL_SETTINGS_SIGMA, largest_difference, largest_difference_of, run};

/// The part of the recording from sample `first` to before `last`.
pub fn window(data: &FilterData, first: usize, last: usize) -> FilterData {
    let mut window = data.clone();
    window.inputs.time_s = data.inputs.time_s[first..last].into();
    for column in &mut window.inputs.columns {
        *column = column[first..last].into();
    }
    for series in &mut window.measurements {
        series.time_s = series.time_s[first..last].into();
        series.values = series.values[first..last].into();
    }
    window
}

fn error(data: &FilterData, settings: &FilterSettings) -> ReconstructError {
    reconstruct(data, &settings.check().unwrap(), &mut |_| ControlFlow::Continue(())).unwrap_err()
}

#[test]
fn missing_measurements_match_the_dense_filter_without_their_rows() {
    let Some(citation) = citation::load() else { return };
    let mut data = window(&citation.data, 0, 1_500);
    for (m, series) in data.measurements.iter_mut().enumerate() {
        for (k, value) in Arc::make_mut(&mut series.values).iter_mut().enumerate().skip(1) {
            // position every tenth sample, one airspeed gap, the others each missing now and then
            let absent = match m {
                0..=2 => k % 10 != 0,
                9 => (400..900).contains(&k),
                _ => (k * (m + 3)) % 7 == 0,
            };
            if absent {
                *value = f64::NAN;
            }
        }
    }
    let settings = citation::settings();
    assert!(largest_difference(&data, &settings) < EQUAL_SETTINGS_SIGMA);
    let counted: usize = run(&data, &settings).innovations[9].iter().filter(|value| value.is_finite()).count();
    assert_eq!(counted, 1_499 - 500);
}

#[test]
fn measurements_between_inertial_samples_split_the_step() {
    let Some(citation) = citation::load() else { return };
    let whole = window(&citation.data, 0, 1_001);
    let mut data = whole.clone();
    let every_second = |values: &[f64]| values.iter().copied().step_by(2).collect::<Vec<f64>>();
    data.inputs.time_s = every_second(&whole.inputs.time_s).into();
    data.inputs.columns = std::array::from_fn(|i| every_second(&whole.inputs.columns[i]).into());

    let settings = citation::settings();
    let result = run(&data, &settings);
    assert_eq!(result.update_time_s.len(), 1_001);
    assert_eq!(result.states[0].len(), 501);
    let times = &whole.inputs.time_s;
    let at = |k: usize| -> [f64; 6] {
        std::array::from_fn(|i| {
            let column = &data.inputs.columns[i];
            if k.is_multiple_of(2) {
                return column[k / 2];
            }
            let part = (times[k] - times[k - 1]) / (times[k + 1] - times[k - 1]);
            column[k / 2] + part * (column[k / 2 + 1] - column[k / 2])
        })
    };
    let steps: Vec<Step> = (1..1_001)
        .map(|k| {
            let first = (k - 1) / 2 * 2;
            let dt = times[k] - times[k - 1];
            Step {
                dt,
                noise_scale: (times[first + 2] - times[first]) / dt,
                start: at(k - 1),
                end: at(k),
                z: Z::from_fn(|m, _| whole.measurements[m].values[k]),
                present: [true; 12],
            }
        })
        .collect();
    assert!(largest_difference_of(&result, &steps, &settings) < EQUAL_SETTINGS_SIGMA);
}

#[test]
fn results_do_not_depend_on_the_company() {
    let Some(citation) = citation::load() else { return };
    let windows: Vec<FilterData> = (0..9).map(|k| window(&citation.data, 500 * k, 500 * k + 700 - 50 * k)).collect();
    let settings = citation::settings().check().unwrap();
    let mut progress = 0.0;
    let mut watch = |part: f64| {
        assert!((progress..=1.0).contains(&part));
        progress = part;
        ControlFlow::Continue(())
    };
    let together = reconstruct_many(&windows.iter().collect::<Vec<_>>(), &settings, &mut watch);
    for (window, together) in windows.iter().zip(together) {
        let alone = reconstruct(window, &settings, &mut |_| ControlFlow::Continue(())).unwrap();
        assert_eq!(alone.states, together.unwrap().states);
    }
}

/// Fused and separate rounding over hundreds of steps, in standard deviations.
const WIDTHS_SIGMA: f64 = 1e-6;

#[test]
fn every_width_of_vector_gives_the_same_path() {
    let Some(citation) = citation::load() else { return };
    let windows: Vec<FilterData> = (0..3).map(|k| window(&citation.data, 500 * k, 500 * k + 400 + 50 * k)).collect();
    let windows: Vec<&FilterData> = windows.iter().collect();
    let settings = FilterSettings { smooth: true, ..citation::settings() }.check().unwrap();
    let of_width = |width| reconstruct_with(width, &windows, &settings, &mut |_| ControlFlow::Continue(()));
    let portable = of_width(Width::Two);
    for width in [Width::Four, Width::Eight] {
        for (portable, wide) in portable.iter().zip(of_width(width)) {
            let (portable, wide) = (portable.as_ref().unwrap(), wide.unwrap());
            let smoothed = [portable, &wide].map(|result| result.smoothed.as_ref().unwrap());
            for k in 0..18 {
                let filtered = portable.states[k].iter().zip(&wide.states[k]).zip(&portable.deviations[k]);
                let smoothed = smoothed[0].states[k].iter().zip(&smoothed[1].states[k]).zip(&smoothed[0].deviations[k]);
                for ((a, b), sigma) in filtered.chain(smoothed) {
                    assert!((a - b).abs() < WIDTHS_SIGMA * sigma, "{width:?} {k}: {a} {b} {sigma}");
                }
            }
        }
    }
}

#[test]
fn a_known_bias_stays_where_it_is() {
    let Some(citation) = citation::load() else { return };
    let mut settings = citation::settings();
    settings.initial_deviation[State::BiasAz as usize] = 0.0;
    settings.initial_state[State::BiasAz as usize] = Some(0.03);
    let result = run(&window(&citation.data, 0, 500), &settings);
    assert!(result.states[State::BiasAz as usize].iter().all(|value| *value == 0.03));
}

fn finite(result: &Reconstruction) -> bool {
    all_finite(&result.states, &result.deviations)
}

fn all_finite(states: &[Vec<f64>; 18], deviations: &[Deviations; 18]) -> bool {
    states.iter().flatten().all(|value| value.is_finite()) && deviations.iter().flatten().all(f64::is_finite)
}

#[test]
fn extreme_noise_settings_fall_back_smoothed_and_say_so_or_name_an_error() {
    let Some(citation) = citation::load() else { return };
    let data = window(&citation.data, 0, 600);
    let mut fallen_back = 0;
    for factor in [1e2, 1e3, 1e4] {
        let mut settings = FilterSettings { smooth: true, ..citation::settings() };
        settings.measurement_noise.iter_mut().for_each(|noise| *noise = (*noise / factor).max(1e-9));
        settings.initial_deviation.iter_mut().for_each(|deviation| *deviation = (*deviation * factor * 10.0).min(9e5));
        match reconstruct(&data, &settings.check().unwrap(), &mut |_| ControlFlow::Continue(())) {
            Ok(result) => {
                assert!(finite(&result));
                let smoothed = result.smoothed.as_ref().unwrap();
                assert!(all_finite(&smoothed.states, &smoothed.deviations));
                println!("{factor}: {:?}", result.warnings);
                fallen_back +=
                    usize::from(result.warnings.iter().any(|warning| warning.to_string().contains("Joseph")));
            }
            Err(error) => println!("{factor}: {error}"),
        }
    }
    assert!(fallen_back > 0);
}

#[test]
fn refuses_data_it_cannot_filter() {
    let Some(citation) = citation::load() else { return };
    let settings = citation::settings();
    let data = window(&citation.data, 0, 50);
    assert_eq!(error(&window(&data, 0, 1), &settings), ReconstructError::TooFewSamples { samples: 1 });

    let mut unordered = data.clone();
    let times = Arc::make_mut(&mut unordered.inputs.time_s);
    times[7] = times[6];
    assert!(matches!(error(&unordered, &settings), ReconstructError::UnorderedTime { sample: 7, .. }));

    let mut gap = data.clone();
    Arc::make_mut(&mut gap.inputs.columns[4])[20] = f64::NAN;
    assert!(matches!(error(&gap, &settings), ReconstructError::InputNotFinite { input: "q", .. }));

    let mut short = data.clone();
    let beta = &mut short.measurements[Measurement::Sideslip as usize].values;
    *beta = beta[1..].into();
    let expected = ReconstructError::UnequalLengths { channel: "beta", values: 49, times: 50 };
    assert_eq!(error(&short, &settings), expected);

    let cancelled = reconstruct(&data, &settings.check().unwrap(), &mut |_| ControlFlow::Break(()));
    assert_eq!(cancelled.unwrap_err(), ReconstructError::Cancelled);
}

#[test]
fn a_loop_ends_with_the_time_it_went_vertical() {
    let Some(citation) = citation::load() else { return };
    let mut data = window(&citation.data, 0, 600);
    for series in &mut data.measurements[..] {
        (series.time_s, series.values) = (Arc::new([0.0]), Arc::new([series.values[0]]));
    }
    Arc::make_mut(&mut data.inputs.columns[4]).fill(0.4);
    match error(&data, &citation::settings()) {
        ReconstructError::NearVertical { time_s, theta_deg } => {
            // from 4.5 deg at 22.9 deg/s
            assert!((3.6..3.8).contains(&time_s) && theta_deg > 89.0, "{time_s} {theta_deg}");
        }
        other => panic!("{other}"),
    }
}

#[test]
fn states_known_exactly_at_the_start_are_filtered_and_smoothed() {
    let Some(citation) = citation::load() else { return };
    let path = |first: usize, known: &[State], deviation: f64| {
        let data = window(&citation.data, first, first + 400);
        let mut settings = FilterSettings { smooth: true, ..citation::settings() };
        known.iter().for_each(|&state| settings.initial_deviation[state as usize] = deviation);
        reconstruct(&data, &settings.check().unwrap(), &mut |_| ControlFlow::Continue(()))
    };
    let alone = State::ALL.map(|state| vec![state]).into_iter();
    for known in alone.chain([vec![State::PitchAngle, State::BankAngle, State::HeadingAngle]]) {
        for first in [0, 200, 400] {
            let found = path(first, &known, 0.0).unwrap_or_else(|error| panic!("{known:?}: {error}"));
            let nearly = path(first, &known, 1e-9).unwrap();
            let (found, nearly) = (found.smoothed.unwrap(), nearly.smoothed.unwrap());
            for &state in &known {
                let (states, deviations) = (&found.states[state as usize], &found.deviations[state as usize]);
                assert!(deviations.iter().all(|deviation| deviation.is_finite()), "{state:?}");
                // The limit of ever better knowledge: no jump between a zero and a billionth.
                assert!(
                    deviations.at(0) < 1e-8 && (states[0] - nearly.states[state as usize][0]).abs() < 1e-7,
                    "{state:?}"
                );
            }
        }
    }
}
