//! Engine comparison of thesis 6.3: on signals with known answers and on the ten instants of Table 6.11.

use doublet_core::propulsion::{PhaseOfFlight, compare_power, difference_correlation, phase_table};
use doublet_core::series::TimeRange;

use super::support::{HP, numbers, reference};

/// Round-off of sums over a few samples, relative.
const ROUND_OFF: f64 = 1e-12;
/// Digits of the independent computation (numpy 2 corrcoef) quoted below.
const QUOTED: f64 = 5e-7;

#[test]
fn comparison_recovers_truth_of_made_columns() {
    // Monitor 10 W low and noisy by +-3 W: rms sqrt(100 + 9), correlation known in closed form.
    let modelled: Vec<f64> = (0..8).map(|k| 100.0 + 10.0 * f64::from(k / 2)).collect();
    let monitor: Vec<f64> =
        modelled.iter().enumerate().map(|(k, p)| p - 10.0 + if k % 2 == 0 { 3.0 } else { -3.0 }).collect();
    let comparison = compare_power(&modelled, &monitor);
    assert_eq!(comparison.samples, 8);
    assert!((comparison.rms_w - 109.0_f64.sqrt()).abs() < ROUND_OFF * 100.0);
    // Variance of the steps 125, of the noise 9, uncorrelated: R2 = 125 / 134.
    assert!((comparison.r_squared - 125.0 / 134.0).abs() < ROUND_OFF, "{}", comparison.r_squared);
    assert!((comparison.mean_modelled_w - comparison.mean_monitor_w - 10.0).abs() < ROUND_OFF * 100.0);
    let noise: Vec<f64> = (0..8).map(|k| if k % 2 == 0 { -1.0 } else { 1.0 }).collect();
    let constant = [5.0; 8];
    let found = difference_correlation(
        &modelled,
        &monitor,
        &[("noise", &noise), ("power", &modelled), ("constant", &constant)],
    );
    assert!((found[0].coefficient - 1.0).abs() < ROUND_OFF);
    assert!(found[1].coefficient.abs() < ROUND_OFF);
    assert!(found[2].coefficient.is_nan(), "a variable that does not vary has no correlation");
    assert_eq!(found[2].variable, "constant");
}

#[test]
fn comparison_leaves_out_samples_that_are_not_numbers() {
    let modelled = [1.0, f64::NAN, 2.0, 4.0];
    let monitor = [1.0, 5.0, f64::INFINITY, 3.0];
    let comparison = compare_power(&modelled, &monitor);
    assert_eq!((comparison.samples, comparison.rms_w), (2, 0.5_f64.sqrt()));
    let nothing = compare_power(&[], &[]);
    assert!(nothing.samples == 0 && nothing.rms_w.is_nan() && nothing.r_squared.is_nan());
}

#[test]
fn phases_compare_only_their_own_samples() {
    let time = [0.0, 1.0, 2.0, 3.0, 4.0];
    let modelled = [10.0, 10.0, 20.0, 20.0, 30.0];
    let monitor = [9.0, 11.0, 22.0, 18.0, 30.0];
    let phase =
        |name: &str, start_s, end_s| PhaseOfFlight { name: name.to_owned(), window: TimeRange { start_s, end_s } };
    let rows = phase_table(
        &time,
        &modelled,
        &monitor,
        &[phase("climb", 2.0, 3.0), phase("taxi", 0.0, 1.0), phase("none", 9.0, 10.0)],
    );
    assert_eq!((rows[0].name.as_str(), rows[0].comparison.samples, rows[0].comparison.rms_w), ("climb", 2, 2.0));
    assert_eq!((rows[1].comparison.samples, rows[1].comparison.rms_w), (2, 1.0));
    assert_eq!(rows[2].comparison.samples, 0);
}

/// Tables 6.12 and 6.13 were made from the whole flight, which is not published; the ten instants of Table 6.11 are held
/// against an independent computation, and in sign and order against the two tables.
#[test]
fn comparison_of_the_published_instants_matches_an_independent_computation() {
    let Some(engine) = reference("engine.toml") else { return };
    let rows: Vec<Vec<f64>> =
        engine["operating_points"]["rows"].as_array().unwrap().iter().map(|row| numbers(&row["v"])).collect();
    let column = |index: usize, factor: f64| -> Vec<f64> { rows.iter().map(|row| factor * row[index]).collect() };
    // R2, rms in hp, correlation of the difference with power, manifold pressure and speed: numpy.
    let expected = [
        [0.983_103_191, 9.332_869_87, 0.623_570_168, 0.722_196_445, 0.333_875_940],
        [0.978_930_417, 8.369_066_26, 0.244_973_631, 0.285_137_397, 0.058_049_826],
    ];
    for (which, side) in ["front", "aft"].into_iter().enumerate() {
        let (modelled, monitor) = (column(4 + which, HP), column(6 + which, HP));
        let (pressure, speed) = (column(2 + which, 1.0), column(which, 1.0));
        let comparison = compare_power(&modelled, &monitor);
        let correlation = difference_correlation(
            &modelled,
            &monitor,
            &[("power", &modelled), ("manifold pressure", &pressure), ("speed", &speed)],
        );
        let found = [
            comparison.r_squared,
            comparison.rms_w / HP,
            correlation[0].coefficient,
            correlation[1].coefficient,
            correlation[2].coefficient,
        ];
        for (value, expected) in found.iter().zip(expected[which]) {
            assert!((value - expected).abs() < QUOTED * expected.max(1.0), "{side}: {value} is not {expected}");
        }
        // The whole flight of Table 6.12 is steadier than ten instants chosen to differ: R2 within 0.01, rms within 2.5 hp.
        let printed = &engine["mvp_comparison"][side];
        assert!((found[0] - printed["R2"].as_float().unwrap()).abs() < 0.01);
        assert!((found[1] - printed["RMS_hp"].as_float().unwrap()).abs() < 2.5);
        // Table 6.13 columns P_mod, p_z, N are all positive.
        let table = numbers(&engine["delta_P_correlation"][side]);
        for (value, printed) in found[2..].iter().zip([table[0], table[1], table[4]]) {
            assert!(value * printed > 0.0, "{side}: {value} and {printed} differ in sign");
        }
    }
}
