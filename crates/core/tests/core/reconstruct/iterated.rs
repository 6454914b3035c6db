//! The iterated smoother: what it minimises, where it ends, and the problem on which it has nothing to do.

use std::sync::Arc;

use doublet_core::message::Message;
use doublet_core::reconstruct::{
    FilterData, FilterSettings, InputSeries, MeasurementSeries, Reconstruction, SMOOTHER_TOLERANCE, Smoothed,
};
use rand::{RngExt, SeedableRng};

use super::behaviour::window;
use super::citation::{self, TRUE_GRAVITY};
use super::reference::run;

fn smoothed(data: &FilterData, settings: &FilterSettings, passes: usize) -> (Smoothed, Vec<Message>) {
    let settings = FilterSettings { smooth: true, smoother_passes: passes, ..settings.clone() };
    let Reconstruction { smoothed, warnings, .. } = run(data, &settings);
    (smoothed.unwrap(), warnings)
}

fn largest_movement(a: &Smoothed, b: &Smoothed) -> f64 {
    let mut largest: f64 = 0.0;
    for k in 0..18 {
        for i in 0..a.states[k].len() {
            largest = largest.max((a.states[k][i] - b.states[k][i]).abs() / b.deviations[k].at(i));
        }
    }
    largest
}

/// A window whose start is poorly known and whose attitude and air data come rarely: what nonlinearity there is shows.
fn poorly_started() -> Option<(FilterData, FilterSettings)> {
    let citation = citation::load()?;
    let mut data = window(&citation.data, 1_000, 1_600);
    for series in &mut data.measurements[6..] {
        for (k, value) in Arc::make_mut(&mut series.values).iter_mut().enumerate() {
            *value = if k % 50 == 49 { *value } else { f64::NAN };
        }
    }
    let mut settings = FilterSettings { gravity_m_s2: TRUE_GRAVITY, ..citation::settings() };
    settings.initial_deviation[6..9].fill(0.3);
    for (k, state) in [(6, -0.15), (7, 0.25), (8, 0.3)] {
        settings.initial_state[k] = Some(citation.truth[k][1_000] + state);
    }
    Some((data, settings))
}

/// Relative rise of the cost that rounding over hundreds of steps can make.
const COST_ROUNDING: f64 = 1e-9;

#[test]
fn passes_reduce_the_cost_and_end() {
    let Some((data, settings)) = poorly_started() else { return };
    let (plain, _) = smoothed(&data, &settings, 1);
    assert!(plain.costs.is_empty());
    let (first, warnings) = smoothed(&data, &settings, 2);
    assert!(warnings.iter().any(|warning| warning.to_string().contains("iterated smoother")), "{warnings:?}");
    let (last, warnings) = smoothed(&data, &settings, 20);
    println!("{:?}, moved {:.2} sigma", last.costs, largest_movement(&plain, &last));
    assert!(!warnings.iter().any(|warning| warning.to_string().contains("iterated smoother")), "{warnings:?}");
    assert_eq!(first.costs, last.costs[..2]);
    assert!(last.costs.len() > 2 && last.costs.len() < 20);
    assert!(last.costs.windows(2).all(|pair| pair[1] <= pair[0] * (1.0 + COST_ROUNDING)));
    assert!(last.costs[0] - last.costs[last.costs.len() - 1] > 1.0);
    // it does not move from where it ended, and wherever else it goes from there costs more
    let (again, _) = smoothed(&data, &settings, 40);
    assert!(largest_movement(&again, &last) < SMOOTHER_TOLERANCE);
}

/// Error of level flight with noise so small that nothing is left of the nonlinearity.
const LINEAR_SIGMA: f64 = 1e-4;

#[test]
fn a_linear_problem_is_solved_by_the_first_pass() {
    let noise = 1e-5;
    let mut random = rand_chacha::ChaCha8Rng::seed_from_u64(5);
    let mut column = |level: f64, slope: f64, sigma: f64| -> Vec<f64> {
        let mut normal = || (0..12).map(|_| random.random::<f64>()).sum::<f64>() - 6.0;
        (0..300).map(|k| level + slope * f64::from(k) * 0.02 + sigma * normal()).collect()
    };
    let mut settings = FilterSettings::default();
    for deviations in [&mut settings.process_noise[..], &mut settings.measurement_noise[..]] {
        deviations.iter_mut().for_each(|deviation| *deviation = (*deviation * noise).max(1e-9));
    }
    settings.initial_deviation.iter_mut().for_each(|deviation| *deviation *= noise);
    let q = settings.process_noise;
    let r = settings.measurement_noise;
    let time_s: Vec<f64> = (0..300).map(|k| f64::from(k) * 0.02).collect();
    let g = settings.gravity_m_s2;
    let columns = std::array::from_fn(|i| column([0.0, 0.0, -g, 0.0, 0.0, 0.0][i], 0.0, q[i]).into());
    let levels = [0.0, 0.0, -900.0, 80.0, 0.0, 0.0, 0.0, 0.0, 0.0, 80.0, 0.0, 0.0];
    let measurements = std::array::from_fn(|m| MeasurementSeries {
        time_s: time_s.clone().into(),
        values: column(levels[m], if m == 0 { 80.0 } else { 0.0 }, r[m]).into(),
    });
    let data = FilterData { inputs: InputSeries { time_s: time_s.into(), columns }, measurements };
    let (plain, _) = smoothed(&data, &settings, 1);
    let (iterated, _) = smoothed(&data, &settings, 10);
    assert_eq!(iterated.costs.len(), 2);
    let moved = largest_movement(&plain, &iterated);
    println!("{moved:.1e} sigma, cost {:?}", iterated.costs);
    assert!(moved < LINEAR_SIGMA, "{moved}");
    // the expected minimum of a linear problem: one for every measurement
    let measured = 12.0 * 299.0;
    assert!((iterated.costs[1] - measured).abs() < 4.0 * (2.0_f64 * measured).sqrt(), "{}", iterated.costs[1]);
}
