//! Calibrations of sensors fitted to readings on the ground, and an instruments file that has them.

use doublet_core::load::instruments::parse;
use doublet_engine::builtin;
use doublet_engine::calibrate::{Curve, SensorKind, calibrations, fit, points, with_calibration};

/// Deterministic scatter of mean zero, a few parts of `size`.
fn scatter(k: usize, size: f64) -> f64 {
    size * (7.3 * k as f64 + 1.1).sin()
}

#[test]
fn radius_of_the_drum_follows_from_five_turns() {
    // Thesis 4.1.2: 12.45 mm; readings of a tape with millimetres, once a turn.
    let readings: Vec<[f64; 2]> =
        (0..=5).map(|turn| 360.0 * f64::from(turn)).map(|deg: f64| [deg, (12.45 * deg.to_radians()).round()]).collect();
    let found = fit(&SensorKind::Drum, 1, &readings).unwrap();
    let (radius, error) = found.drum_radius_mm(&SensorKind::Drum).unwrap();
    assert!((radius - 12.45).abs() < 0.03 && error < 0.02, "{radius} +- {error} mm");
    assert!(found.r_squared > 0.9999, "{}", found.r_squared);
}

#[test]
fn line_of_the_aileron_is_found_under_the_scatter_of_an_inclinometer() {
    // Thesis Table 4.2: slope 0.162, intercept -0.060; an inclinometer is good to 0.1 deg.
    let readings: Vec<[f64; 2]> = (-9_i32..=9)
        .enumerate()
        .map(|(k, step)| (k, 10.0 * f64::from(step)))
        .map(|(k, yoke)| [yoke, 0.162 * yoke - 0.060 + scatter(k, 0.1)])
        .collect();
    let found = fit(&SensorKind::Aileron, 1, &readings).unwrap();
    let Curve::Polynomial(line) = &found.curve else { panic!("{:?}", found.curve) };
    assert!((line[1] - 0.162).abs() < 3.0 * found.errors[1] && found.errors[1] < 5e-4, "{line:?} {:?}", found.errors);
    assert!((line[0] + 0.060).abs() < 3.0 * found.errors[0], "{line:?} {:?}", found.errors);
    assert!(found.deviation > 0.05 && found.deviation < 0.1, "{}", found.deviation);
}

#[test]
fn polynomial_of_a_pedal_and_the_range_it_falls_in_are_those_of_the_thesis() {
    // Thesis Table 4.4, right pedal, and the range in which it only falls.
    let printed = [1.207e-1, -3.155e2, -1.098e3, -3.074e4, -8.065e4, 9.752e6];
    let truth = Curve::Polynomial(printed.to_vec());
    let readings: Vec<[f64; 2]> = (-65..=75).map(|mm| f64::from(mm) / 1000.0).map(|s| [s, truth.at(s)]).collect();
    let found = fit(&SensorKind::Pedal("right_pedal".to_owned()), 5, &readings).unwrap();
    let Curve::Polynomial(all) = &found.curve else { panic!("{:?}", found.curve) };
    for (value, expected) in all.iter().zip(printed) {
        assert!((value / expected - 1.0).abs() < 1e-6, "{all:?}");
    }
    let [low, high] = found.range;
    assert!((low + 0.0540).abs() < 5e-4 && (high - 0.0668).abs() < 5e-4, "{:?}", found.range);
}

#[test]
fn exponent_of_the_pod_goes_through_its_three_points() {
    // Thesis 4.3.2, FT0.2: angles of attack at the numbers 0, 85 and 100.
    let readings = [[0.0, 4.063], [85.0, 6.082], [100.0, 10.810]];
    let found = fit(&SensorKind::Pod("FT0.2".to_owned()), 2, &readings).unwrap();
    assert!(found.residuals.iter().all(|residual| residual.abs() < 1e-9), "{:?}", found.residuals);
    assert!(fit(&SensorKind::Pod(String::new()), 2, &[[0.0, 0.0], [1.0, 1.0], [2.0, 2.0]]).is_err());
}

#[test]
fn one_reading_that_lets_the_probe_fall_is_left_out() {
    // Thesis Table 4.9, left main tank: 47 lb at 16.59 lb is the outlier.
    let actual = [0.0, 16.59, 33.18, 49.78, 66.37, 82.96, 99.55, 116.14, 132.74, 149.33, 165.92, 182.51, 199.1, 215.7];
    let shown = [0.0, 47.0, 20.0, 39.0, 41.0, 56.0, 68.0, 85.0, 100.0, 113.0, 130.0, 146.0, 164.0, 182.0];
    let readings: Vec<[f64; 2]> = actual.into_iter().zip(shown).map(|(actual, shown)| [actual, shown]).collect();
    let found = fit(&SensorKind::Probe("main left".to_owned()), 0, &readings).unwrap();
    let left_out: Vec<usize> = (0..found.used.len()).filter(|&at| !found.used[at]).collect();
    assert_eq!(left_out, [1]);
    // Printed greatest deviation of what is left: 36.5 lb, at 110 l.
    let counted = found.residuals.iter().zip(&found.used).filter(|(_, used)| **used);
    let greatest = counted.map(|(residual, _)| residual.abs()).fold(0.0, f64::max);
    assert!((greatest - 36.51).abs() < 1e-9, "{greatest}");
}

#[test]
fn readings_are_two_numbers_a_line_and_anything_else_is_named() {
    assert_eq!(points("1 2\n\n3;4 # again\n\u{2212}5\t6.5").unwrap(), [[1.0, 2.0], [3.0, 4.0], [-5.0, 6.5]]);
    let refused = points("1 2\n3 four").unwrap_err();
    assert!(refused.contains("line 2") && refused.contains("3 four"), "{refused}");
    assert!(fit(&SensorKind::Aileron, 1, &[[0.0, 1.0]]).unwrap_err().contains("2 readings are needed"));
}

fn text() -> &'static str {
    builtin::text("aircraft", "c337f_instruments").unwrap()
}

#[test]
fn every_calibration_of_the_file_is_there_with_its_numbers() {
    let all = calibrations(text()).unwrap();
    assert_eq!(all.len(), 3 + 2 + 2 + 4);
    assert!((all[0].drum_radius_mm().unwrap() - 12.45).abs() < 1e-12);
    assert_eq!(all[1].curve, Curve::Polynomial(vec![-0.060, 0.162]));
    assert!((all[2].curve.at(4.0) - (2.386 * 4.0 + 1.401)).abs() < 1e-12);
    assert_eq!(all[3].range, Some([-0.0540, 0.0668]));
    // Thesis: the angle of attack of FT0.2 at the number 85.
    assert!((all[5].curve.at(85.0) - 6.082).abs() < 1e-3, "{}", all[5].curve.at(85.0));
}

#[test]
fn fitted_calibrations_are_what_the_analysis_reads_and_the_rest_stays() {
    let line: Vec<[f64; 2]> = (-5..=5).map(f64::from).map(|x| [10.0 * x, 2.0 * x - 0.5]).collect();
    let mut now = text().to_owned();
    for (kind, degree) in [
        (SensorKind::Aileron, 1),
        (SensorKind::Pedal("right_pedal".to_owned()), 3),
        (SensorKind::Drum, 1),
        (SensorKind::Probe("main right".to_owned()), 0),
    ] {
        let readings = match &kind {
            SensorKind::Probe(_) => vec![[0.0, 0.0], [50.0, 40.0], [100.0, 95.0]],
            _ => line.clone(),
        };
        now = with_calibration(&now, &kind, &fit(&kind, degree, &readings).unwrap()).unwrap();
    }
    let (before, after) = (parse(text()).unwrap(), parse(&now).unwrap());
    assert!((after.control.aileron_slope - 0.2).abs() < 1e-12);
    assert!((after.control.aileron_intercept_rad.to_degrees() + 0.5).abs() < 1e-12);
    assert!((after.control.drum_radius_m - 1e-3 * 0.2_f64.to_degrees()).abs() < 1e-12);
    assert!((after.control.pedals[0].coefficients[1] - 0.2_f64.to_radians()).abs() < 1e-9);
    assert_eq!(after.fuel_probes[1].actual_kg.len(), 3);
    assert_eq!(after.fuel_probes[0], before.fuel_probes[0]);
    assert_eq!(after.control.elevator_slope_rad_m, before.control.elevator_slope_rad_m);
    assert!(now.contains("# fitted to 11 readings, R2 1.00000"), "{now}");
    assert!(now.contains("# Indication against fuel in the tank: Tables 4.9 and 4.10."), "{now}");
}
