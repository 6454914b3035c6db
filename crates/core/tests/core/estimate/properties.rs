//! Properties every estimate keeps.

use doublet_core::estimate::{PooledWindow, least_squares, pooled};
use nalgebra::DMatrix;
use proptest::prelude::*;

/// Largest relative change of an estimate that reordering may cause: rounding times the condition number.
const REORDERING: f64 = 1e-12;

/// Regressor matrix of a few incommensurate waves with some noise from `seed`, a constant first.
fn regressors(samples: usize, terms: usize, seed: u64) -> DMatrix<f64> {
    DMatrix::from_fn(samples, terms, |row, column| {
        let phase = (seed % 97) as f64 * 0.11 + column as f64;
        if column == 0 {
            1.0
        } else {
            (row as f64 * 0.013 * (column as f64 + 0.7) + phase).sin() * 0.4_f64.powi(column as i32)
        }
    })
}

/// A measurement no model fits exactly.
fn measurement(x: &DMatrix<f64>, seed: u64) -> Vec<f64> {
    (0..x.nrows())
        .map(|row| {
            let noise = ((row as u64 * 2_654_435_761 + seed * 40_503) % 10_007) as f64 / 10_007.0 - 0.5;
            x.row(row).iter().enumerate().map(|(j, value)| value * (j as f64 + 1.0)).sum::<f64>() + 0.01 * noise
        })
        .collect()
}

/// Names `t0`, `t1`, ...
fn names(count: usize) -> Vec<String> {
    (0..count).map(|index| format!("t{index}")).collect()
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(48))]

    #[test]
    fn estimate_does_not_depend_on_term_order(seed in 0_u64..10_000, order in Just((0..6_usize).collect::<Vec<_>>()).prop_shuffle()) {
        let x = regressors(700, 6, seed);
        let z = measurement(&x, seed);
        let all = names(6);
        let fit = least_squares(&all, &x, &z).unwrap();
        let reordered: Vec<String> = order.iter().map(|&index| all[index].clone()).collect();
        let other = least_squares(&reordered, &x.select_columns(&order), &z).unwrap();
        for name in &all {
            let ((a, s_a), (b, s_b)) = (fit.parameter(name).unwrap(), other.parameter(name).unwrap());
            prop_assert!((a - b).abs() <= REORDERING * a.abs(), "{name}: {a} {b}");
            prop_assert!((s_a - s_b).abs() <= REORDERING * s_a, "{name}: {s_a} {s_b}");
        }
    }

    #[test]
    fn pooled_estimate_does_not_depend_on_window_order(seed in 0_u64..10_000, order in Just((0..5_usize).collect::<Vec<_>>()).prop_shuffle()) {
        let windows: Vec<PooledWindow> = (0..5_u64).map(|index| {
            let x = regressors(150 + 40 * index as usize, 4, seed + 13 * index);
            let z = measurement(&x, seed + index);
            PooledWindow { label: format!("w{index}"), x, z }
        }).collect();
        let own = [true, false, false, false];
        let fit = pooled(&names(4), &own, &windows).unwrap().fit;
        let shuffled: Vec<PooledWindow> = order.iter().map(|&index| windows[index].clone()).collect();
        let other = pooled(&names(4), &own, &shuffled).unwrap().fit;
        for name in &fit.names {
            let ((a, s_a), (b, s_b)) = (fit.parameter(name).unwrap(), other.parameter(name).unwrap());
            prop_assert!((a - b).abs() <= REORDERING * a.abs(), "{name}: {a} {b}");
            prop_assert!((s_a - s_b).abs() <= REORDERING * s_a, "{name}: {s_a} {s_b}");
        }
    }

    #[test]
    fn covariance_is_symmetric_and_positive(seed in 0_u64..10_000, terms in 1_usize..7) {
        let x = regressors(500, terms, seed);
        let fit = least_squares(&names(terms), &x, &measurement(&x, seed)).unwrap();
        prop_assert_eq!(&fit.covariance, &fit.covariance.transpose());
        prop_assert!(fit.covariance.clone().cholesky().is_some());
    }
}

#[test]
fn pooled_fit_equals_one_regression_with_a_constant_per_window() {
    let windows: Vec<PooledWindow> = (0..3_u64)
        .map(|index| {
            let x = regressors(300, 4, 7 * index);
            let z = measurement(&x, index).iter().map(|z| z + index as f64).collect();
            PooledWindow { label: format!("w{index}"), x, z }
        })
        .collect();
    let together = pooled(&names(4), &[true, false, false, false], &windows).unwrap();
    assert_eq!(together.fit.names, ["t1", "t2", "t3", "t0[w0]", "t0[w1]", "t0[w2]"]);
    let mut x = DMatrix::zeros(900, 6);
    let mut z = Vec::new();
    for (index, window) in windows.iter().enumerate() {
        x.view_mut((300 * index, 0), (300, 3)).copy_from(&window.x.columns(1, 3));
        x.view_mut((300 * index, 3 + index), (300, 1)).fill(1.0);
        z.extend_from_slice(&window.z);
    }
    let expected = least_squares(&together.fit.names, &x, &z).unwrap();
    for index in 0..6 {
        approx::assert_relative_eq!(together.fit.estimates[index], expected.estimates[index], max_relative = 1e-11);
        approx::assert_relative_eq!(
            together.fit.standard_errors[index],
            expected.standard_errors[index],
            max_relative = 1e-10
        );
    }
    approx::assert_relative_eq!(together.fit.quality.r_squared, expected.quality.r_squared, max_relative = 1e-12);
    approx::assert_relative_eq!(together.fit.condition_number, expected.condition_number, max_relative = 1e-9);
    assert_eq!(together.samples[1], 300..600);
}

#[test]
fn pooling_breaks_a_dependence_that_holds_inside_each_window() {
    // Inside each window the third term is a multiple of the second, with another factor in each.
    let windows: Vec<PooledWindow> = [-0.92, 0.4]
        .into_iter()
        .map(|factor| {
            let mut x = regressors(200, 3, 1);
            let tied = x.column(1) * factor;
            x.set_column(2, &tied);
            let z = measurement(&x, 5);
            PooledWindow { label: format!("{factor}"), x, z }
        })
        .collect();
    for window in &windows {
        let error = least_squares(&names(3), &window.x, &window.z).unwrap_err();
        assert!(error.to_string().contains("'t2' depends on 't1'"), "{error}");
    }
    let fit = pooled(&names(3), &[true, false, false], &windows).unwrap().fit;
    let ((second, error), (third, _)) = (fit.parameter("t1").unwrap(), fit.parameter("t2").unwrap());
    assert!((second - 2.0).abs() < 4.0 * error && (third - 3.0).abs() < 0.2, "{second} +- {error}, {third}");
}
