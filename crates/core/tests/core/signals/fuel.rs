//! Fuel from probes and flow: thesis section 4.2.

use doublet_core::airframe::instruments::FuelProbe;
use doublet_core::prep::{FuelSettings, PrepError, fuel_from_flow, fuel_history, fuel_reading};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use rand_distr::StandardNormal;

use super::support::c337f;

const POUND_KG: f64 = 0.453_592_37;

fn probe(tank: &str) -> FuelProbe {
    c337f().fuel_probes.into_iter().find(|probe| probe.tank == tank).unwrap()
}

#[test]
fn readings_match_tables_4_9_and_4_10_at_their_points_and_between() {
    let settings = FuelSettings::default();
    for (tank, displayed_lb, actual_lb) in [
        ("main left", 146.0, 182.51),
        ("main left", 211.0, 232.29),
        ("main left", 30.0, 33.18 + 16.60 * 10.0 / 19.0),
        ("main right", 66.0, 49.78),
        ("main right", 163.5, 157.625),
        ("auxiliary left", 18.0, 33.18),
        ("auxiliary left", 92.0, 111.17),
        ("auxiliary right", 107.0, 116.14),
        // The 47 lb the left main probe showed at 16.59 lb is no point of the curve.
        ("main left", 47.0, 66.37 + 16.59 * 6.0 / 15.0),
    ] {
        let found = fuel_reading(&probe(tank), displayed_lb * POUND_KG, &settings).mass_kg / POUND_KG;
        assert!((found - actual_lb).abs() < 1e-6, "{tank} at {displayed_lb} lb: {found} for {actual_lb}");
    }
}

#[test]
fn blind_zones_are_the_empty_auxiliaries_the_full_mains_and_the_step_of_the_left_main() {
    let settings = FuelSettings::default();
    for (tank, displayed_lb, blind, least_lb, most_lb) in [
        ("auxiliary right", 0.0, true, 0.0, 16.6 + 0.5 * 16.59 / 27.0),
        ("main right", 276.0, true, 282.06 - 0.5 * 16.59 / 5.0, 292.02),
        ("main left", 290.0, true, 282.06 - 0.5 * 16.59 / 2.0, 292.02),
        ("auxiliary left", 95.0, true, 111.17 - 0.5 * 11.62 / 7.0, 111.17),
        ("main left", 40.0, true, 49.78 + 0.5 * 16.59 / 2.0, 66.37 - 0.5 * 16.59 / 2.0),
        ("main left", 150.0, false, 0.0, 292.0),
        ("main right", 100.0, false, 0.0, 292.0),
    ] {
        let found = fuel_reading(&probe(tank), displayed_lb * POUND_KG, &settings);
        assert_eq!(found.blind, blind, "{tank} at {displayed_lb}: {found:?}");
        if blind {
            let (least, most) = (found.least_kg / POUND_KG, found.most_kg / POUND_KG);
            assert!((least - least_lb).abs() < 0.1 && (most - most_lb).abs() < 0.1, "{tank}: {least} to {most}");
        }
    }
}

#[test]
fn history_recovers_truth_fuel_of_a_burning_tank_and_reports_its_blind_time() {
    /// Error that a mass of 2,000 kg does not notice, kg (5 lb).
    const ERROR_KG: f64 = 5.0 * POUND_KG;
    let mut rng = ChaCha8Rng::seed_from_u64(2);
    let probe = probe("auxiliary right");
    let time: Vec<f64> = (0..3600).map(f64::from).collect();
    // 110 lb burnt down to nothing over the hour, shown to the pound with half a pound of slosh.
    let truth: Vec<f64> = time.iter().map(|t| 110.0 * POUND_KG * (1.0 - t / 3600.0)).collect();
    let shown: Vec<f64> = truth
        .iter()
        .map(|&actual| {
            let k = probe.actual_kg.partition_point(|&value| value <= actual).clamp(1, probe.actual_kg.len() - 1);
            let fraction = (actual - probe.actual_kg[k - 1]) / (probe.actual_kg[k] - probe.actual_kg[k - 1]);
            let shown = probe.displayed_kg[k - 1] + fraction * (probe.displayed_kg[k] - probe.displayed_kg[k - 1]);
            ((shown / POUND_KG + 0.5 * rng.sample::<f64, _>(StandardNormal)).round().max(0.0)) * POUND_KG
        })
        .collect();
    let history = fuel_history(&time, &[(&probe, &shown[..])], &FuelSettings::default()).unwrap();
    assert!(history.total_kg.windows(2).all(|pair| pair[1] <= pair[0]));
    // Blind from 16.59 lb down.
    let blind_s = 3600.0 * (1.0 - 16.59 / 110.0);
    let worst = (0..3600)
        .filter(|&k| time[k] < blind_s - 90.0)
        .map(|k| (history.total_kg[k] - truth[k]).abs())
        .fold(0.0, f64::max);
    println!("worst error outside the blind zone {:.2} lb", worst / POUND_KG);
    assert!(worst < ERROR_KG);
    let last = history.blind.last().unwrap();
    assert!((last.window.end_s - 3599.0).abs() < 1e-9 && last.least_kg == 0.0 && last.tank == "auxiliary right");
    assert!(history.blind.iter().all(|zone| zone.window.start_s > blind_s - 150.0), "{:?}", history.blind);
}

#[test]
fn fuel_from_flow_integrates_and_bad_input_is_refused() {
    let left = fuel_from_flow(&[0.0, 10.0, 30.0], &[0.01, 0.02, 0.02], 100.0).unwrap();
    assert!((left[1] - 99.85).abs() < 1e-12 && (left[2] - 99.45).abs() < 1e-12);
    let probe = probe("main left");
    let settings = FuelSettings { resolution_kg: 0.0, ..Default::default() };
    assert!(matches!(fuel_history(&[0.0], &[(&probe, &[1.0])], &settings), Err(PrepError::Setting { .. })));
    let refused = fuel_history(&[0.0, 1.0], &[(&probe, &[1.0])], &FuelSettings::default());
    assert!(matches!(refused, Err(PrepError::Length { .. })));
    let held = fuel_history(&[0.0, 1.0], &[(&probe, &[50.0, f64::NAN])], &FuelSettings::default()).unwrap();
    assert_eq!(held.total_kg[0], held.total_kg[1]);
}
