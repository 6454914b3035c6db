//! Angle of attack of the pod: thesis section 4.3.

use doublet_core::airframe::instruments::PodCalibration;
use doublet_core::atmos::{Atmosphere, STANDARD_GRAVITY_M_S2};
use doublet_core::prep::{
    PodDefinition, PrepError, level_flight_angle_of_attack, pod_angle_of_attack, pod_calibration, pod_history,
    pod_working_range, sideslip,
};

use super::support::c337f;

/// Angles quoted to two decimals, deg.
const HALF_DIGIT_DEG: f64 = 0.005;
const KNOT_M_S: f64 = 1852.0 / 3600.0;

fn calibration(flight: &str) -> PodCalibration {
    c337f().air_data.pods.into_iter().find(|pod| pod.flight == flight).unwrap()
}

#[test]
fn pod_angles_match_table_4_11_at_its_three_points() {
    for (flight, points) in
        [("FT0.2", [(0.0, 4.06), (85.0, 6.08), (100.0, 10.81)]), ("FT1.0", [(0.0, 4.75), (85.0, 8.05), (100.0, 11.45)])]
    {
        for (number, published) in points {
            let found = pod_angle_of_attack(&calibration(flight), number).to_degrees();
            assert!((found - published).abs() < HALF_DIGIT_DEG + 1e-3, "{flight} at {number}: {found}");
        }
    }
}

#[test]
fn lift_curve_gives_the_angle_at_zero_of_both_calibrations() {
    let curve = c337f().air_data.lift_curve;
    let atmosphere = Atmosphere::default();
    // Section 4.3.3: mass, airspeed at the pod's zero, altitude; ISA of the altitude.
    for (mass_kg, airspeed_kt, altitude_ft, expected_deg) in
        [(1778.0, 96.0, 3000.0, 4.06), (2044.0, 101.0, 4000.0, 4.62)]
    {
        let density = atmosphere.density_kg_m3(altitude_ft * 0.3048).unwrap();
        let airspeed = airspeed_kt * KNOT_M_S;
        let alpha = level_flight_angle_of_attack(&curve, mass_kg, STANDARD_GRAVITY_M_S2, airspeed, density, 18.7);
        // Airspeed is printed to the knot, worth 0.16 deg: the figures are met to a hundredth.
        assert!((alpha.to_degrees() - expected_deg).abs() < 0.011, "{}", alpha.to_degrees());
    }
    // Zero-lift angle -3.879 deg, thesis 4.3.2 with its sign put right: 0.333/0.086 to the digits of the slope.
    assert!((-(curve.at_zero_alpha / curve.slope_per_rad).to_degrees() + 3.879).abs() < 0.01);
}

#[test]
fn working_range_leaves_out_where_a_calibration_falls() {
    // FT0.2 falls from 4.063 deg at 0 to 3.968 deg at 32.9; FT1.0 rises throughout.
    let [from, to] = pod_working_range(&calibration("FT0.2"));
    assert!((from - 32.9).abs() < 0.5 && to == 100.0, "{from}");
    assert!((pod_angle_of_attack(&calibration("FT0.2"), 32.9).to_degrees() - 3.968).abs() < HALF_DIGIT_DEG);
    assert_eq!(pod_working_range(&calibration("FT1.0")), [0.0, 100.0]);
    let history = pod_history(&calibration("FT0.2"), &[0.0, 0.4, 10.0, 50.0, 100.0], 1.0);
    let known: Vec<bool> = history.alpha_rad.iter().map(|alpha| alpha.is_finite()).collect();
    assert_eq!(known, [false, false, true, true, false]);
    assert_eq!(history.warnings.len(), 3);
    assert!(
        history.warnings[0].to_string().contains("2 of 5") && history.warnings[2].to_string().contains("below 33"),
        "{:?}",
        history.warnings
    );
    assert!(pod_history(&calibration("FT1.0"), &[20.0, 98.0], 1.0).warnings.is_empty());
}

#[test]
fn new_calibration_passes_through_its_points_rises_and_comes_near_the_published_one() {
    let published = calibration("FT1.0");
    let points = [0.0, 85.0, 100.0].map(|number| pod_angle_of_attack(&published, number));
    let found = pod_calibration("FT2.0", points).unwrap();
    for (number, alpha) in [0.0, 85.0, 100.0].into_iter().zip(points) {
        assert!((pod_angle_of_attack(&found, number) - alpha).abs() < 1e-12);
    }
    assert_eq!(pod_working_range(&found), [0.0, 100.0]);
    for number in 0..100 {
        let apart = pod_angle_of_attack(&found, f64::from(number)) - pod_angle_of_attack(&published, f64::from(number));
        // Two curves through the same three points, deg.
        assert!(apart.to_degrees().abs() < 0.15, "at {number}: {}", apart.to_degrees());
    }
    // FT0.2's points do allow a curve that rises.
    let points = [4.063f64, 6.082, 10.810].map(f64::to_radians);
    assert_eq!(pod_working_range(&pod_calibration("FT0.2", points).unwrap()), [0.0, 100.0]);
    for falling in [[-0.1, 0.1, 0.2], [0.2, 0.1, 0.3], [0.1, 0.2, 0.15], [0.1, f64::NAN, 0.2]] {
        assert!(matches!(pod_calibration("x", falling), Err(PrepError::Setting { .. })), "{falling:?}");
    }
}

#[test]
fn sideslip_loses_the_offset_of_section_4_4_3() {
    let offset = c337f().air_data.sideslip_offset_rad;
    assert!((sideslip(0.0, offset).to_degrees() + 0.72).abs() < 1e-12);
}

#[test]
fn pod_number_is_zero_at_equal_pressures_and_its_constant_at_the_calibration_point() {
    // Section 4.3.1: 85, or 0.85, at 1.15 times the least speed, 80.5 kt; 0 where both probes see the low probe's pressure.
    let airspeed = 80.5 * KNOT_M_S;
    let (low_pa, high_pa) = (900.0, 1100.0);
    let over_square = |pressure: f64| pressure / (airspeed * airspeed);
    for constant in [85.0, 0.85] {
        let pod = PodDefinition { at_calibration: constant, low: over_square(low_pa), high: over_square(high_pa) };
        assert!(pod.number(low_pa, airspeed).unwrap().abs() < 1e-12);
        let calibrated = pod.number(high_pa, airspeed).unwrap();
        assert!((calibrated / constant - 1.0).abs() < 1e-12);
        // Stall: the pressure ratio 100/85 of the way up from the low probe.
        let stall = pod.number(low_pa + (high_pa - low_pa) * 100.0 / 85.0, airspeed).unwrap();
        assert!((stall / constant - 100.0 / 85.0).abs() < 1e-9);
        // The same pressures at a higher speed say less.
        assert!(pod.number(high_pa, 1.1 * airspeed).unwrap() < calibrated);
        assert!(pod.number(high_pa, 0.0).is_err());
    }
    assert!(PodDefinition { at_calibration: 85.0, low: 0.4, high: 0.4 }.number(900.0, 40.0).is_err());
}
