//! Weighings against thesis Tables 5.4 to 5.8 and against an aircraft weighed by calculation.

use doublet_core::airframe::FixedItem;
use doublet_core::airframe::WheelStations;
use doublet_core::airframe::weighing::{
    WeighingError, WeighingResult, WheelReactions, centre_of_gravity, without_items,
};

use super::support::{Table, close, reference, shipped};

const WHEELS: WheelStations = WheelStations { nose_x_m: 1.45, main_x_m: 3.84, main_y_m: 1.24 };
/// Half a unit of the last printed digit of a position, m.
const PRINTED_M: f64 = 0.005;
/// Half a unit of the last digit of the independent regression, m.
const REGRESSION_M: f64 = 6e-4;

/// A printed series, its ground pitches moved by `shift_deg` where they are not level.
fn series(table: &Table, name: &str, shift_deg: impl Fn(usize) -> f64) -> Vec<WheelReactions> {
    let rows = table.rows(&format!("weighing.{name}"));
    let reactions = |(index, row): (usize, &Vec<f64>)| WheelReactions {
        ground_pitch_rad: (if row[0] == 0.0 { 0.0 } else { row[0] + shift_deg(index) }).to_radians(),
        aircraft_pitch_rad: row[1].to_radians(),
        nose_kg: row[7],
        main_right_kg: row[8],
        main_left_kg: row[9],
    };
    rows.iter().enumerate().map(reactions).collect()
}

fn weighed(table: &Table, name: &str) -> WeighingResult {
    centre_of_gravity(&series(table, name, |_| 0.0), &WHEELS).unwrap()
}

#[test]
fn printed_weighings_give_the_regression_of_thesis_table_5_6() {
    let Some(table) = reference("mass_cg.toml") else { return };
    let chord = shipped("c337f.toml").mean_chord().unwrap();
    // x, z, R2 and R by an independent regression of the printed weighings; Table 5.6 prints R as R2.
    for (name, x, z, r_squared, r) in
        [("low_fuel", 3.602, 1.784, 0.966, 0.983), ("full_fuel", 3.641, 1.822, 0.948, 0.974)]
    {
        let found = weighed(&table, name);
        let printed = |field: &str| table.number(&format!("regression.{name}.{field}"));
        close("x", found.x_m, x, REGRESSION_M);
        close("z", found.z_ground_m, z, REGRESSION_M);
        close("R2", found.r_squared, r_squared, 6e-4);
        close("R", found.correlation, r, 6e-4);
        close("x as printed", found.x_m, printed("x_cg_g_m"), PRINTED_M);
        close("% MAC as printed", 100.0 * chord.fraction(found.x_m), printed("x_cg_pct_mac"), 100.0 * PRINTED_M / 1.68);
        close("strut as printed", found.strut_pitch_rad.to_degrees(), printed("dtheta_deg"), 0.06);
        close("R2 as printed", found.correlation, printed("R2_printed"), 2e-3);
    }
}

#[test]
fn printed_heights_of_thesis_table_5_6_lie_within_the_rounding_of_pitch() {
    let Some(table) = reference("mass_cg.toml") else { return };
    for name in ["low_fuel", "full_fuel"] {
        let heights: Vec<f64> = (0..16)
            .map(|bits: usize| {
                let shifted = series(&table, name, |row| if bits >> row & 1 == 1 { 0.05 } else { -0.05 });
                centre_of_gravity(&shifted, &WHEELS).unwrap().z_ground_m
            })
            .collect();
        let (lowest, highest) = heights.iter().fold((f64::MAX, f64::MIN), |(a, b), &z| (a.min(z), b.max(z)));
        let printed = table.number(&format!("regression.{name}.z_cg_g_m"));
        assert!(
            lowest - PRINTED_M <= printed && printed <= highest + PRINTED_M,
            "{printed} not in {lowest}..{highest}"
        );
    }
}

#[test]
fn strut_correction_of_the_printed_heights_matches_thesis_eq_5_6() {
    let Some(table) = reference("mass_cg.toml") else { return };
    for name in ["low_fuel", "full_fuel"] {
        let found = weighed(&table, name);
        let printed = |field: &str| table.number(&format!("regression.{name}.{field}"));
        let correction = printed("z_cg_g_m") - printed("z_cg_ac_m");
        close("correction", found.z_ground_m - found.z_m, correction, PRINTED_M);
    }
}

#[test]
fn level_weighing_matches_the_measured_columns_of_thesis_table_5_8() {
    let Some(table) = reference("mass_cg.toml") else { return };
    for (name, mean_mass) in [("low_fuel", 1586.0), ("full_fuel", 1750.0)] {
        let found = weighed(&table, name);
        let [x, y, _] = table.point(&format!("validation.{name}.measured_m"));
        close("x", found.level_x_m, x, PRINTED_M);
        close("y", found.level_y_m, y, PRINTED_M);
        close("mass", found.mass_kg, mean_mass, 0.5);
        assert!(found.mass_spread_kg <= 5.0, "scales agree within their 1 kg each and the fuel burnt by none");
    }
}

#[test]
fn empty_height_follows_from_the_weighings_of_thesis_table_5_7() {
    let Some(table) = reference("mass_cg.toml") else { return };
    let aircraft = shipped("c337f.toml");
    // Printed 1.74 and 1.73 m; the full-fuel one is 1.76 m from the printed weighings, within the rounding of their pitch.
    for (name, printed, tolerance) in
        [("low_fuel", "z_cg_OEW_from_low_m", PRINTED_M), ("full_fuel", "z_cg_OEW_from_full_m", 0.035)]
    {
        let found = weighed(&table, name);
        let fuel = &table.rows(&format!("weighing.{name}"))[0][3..7];
        let order = ["main right", "main left", "auxiliary right", "auxiliary left"];
        let items: Vec<FixedItem> = order
            .into_iter()
            .zip(fuel)
            .map(|(name, &mass_kg)| {
                let tank = aircraft.tanks.iter().find(|tank| tank.name == name).unwrap();
                FixedItem { name: name.into(), mass_kg, cg_from_datum_m: tank.cg_from_datum_m }
            })
            .collect();
        let whole = FixedItem {
            name: name.into(),
            mass_kg: found.mass_kg,
            cg_from_datum_m: [found.level_x_m, found.level_y_m, found.z_m],
        };
        let empty = without_items(&whole, &items).unwrap();
        close("z", empty.cg_from_datum_m[2], table.number(&format!("regression.{printed}")), tolerance);
        // The weighings give 1376.7 kg without fuel, 5.4 kg below the 1382.1 kg that count trapped fuel once more.
        close("mass", empty.mass_kg, 1376.75, 0.1);
        // Putting the fuel back gives what was weighed.
        let parts = items.iter().chain([&empty]);
        let moment: f64 = parts.map(|part| part.mass_kg * part.cg_from_datum_m[0]).sum();
        close("x", moment / found.mass_kg, found.level_x_m, 1e-12);
    }
}

/// Readings of an aircraft of 1500 kg at `cg` (m from the datum), by moments about the wheels.
fn calculated(cg: [f64; 3], pitch_rad: f64) -> WheelReactions {
    let (mass, [x, y, z]) = (1500.0, cg);
    let main = mass * (x + z * pitch_rad.tan() - WHEELS.nose_x_m) / (WHEELS.main_x_m - WHEELS.nose_x_m);
    let difference = mass * y / WHEELS.main_y_m;
    WheelReactions {
        ground_pitch_rad: pitch_rad,
        aircraft_pitch_rad: pitch_rad,
        nose_kg: mass - main,
        main_right_kg: (main + difference) / 2.0,
        main_left_kg: (main - difference) / 2.0,
    }
}

#[test]
fn weighing_recovers_a_calculated_centre_of_gravity() {
    let cg = [3.2, 0.02, 1.7];
    let readings: Vec<_> = [0.0, 0.04, 0.09, 0.12].map(|pitch| calculated(cg, pitch)).into();
    let found = centre_of_gravity(&readings, &WHEELS).unwrap();
    for (found, expected) in [(found.x_m, cg[0]), (found.level_y_m, cg[1]), (found.z_m, cg[2]), (found.r_squared, 1.0)]
    {
        close("exact data", found, expected, 1e-9);
    }
    assert!(found.x_error_m.unwrap() < 1e-9 && found.z_error_m.unwrap() < 1e-8);
    let two = centre_of_gravity(&readings[..2], &WHEELS).unwrap();
    close("two attitudes", two.z_m, cg[2], 1e-9);
    assert_eq!((two.x_error_m, two.z_error_m), (None, None));
}

#[test]
fn standard_errors_match_the_covariance_of_the_normal_equations() {
    let mut readings: Vec<_> = [0.0, 0.03, 0.07, 0.1, 0.13].map(|pitch| calculated([3.2, 0.0, 1.7], pitch)).into();
    for (reading, error) in readings.iter_mut().zip([1.0, -2.0, 0.5, 2.0, -1.5]) {
        reading.nose_kg += error;
    }
    let found = centre_of_gravity(&readings, &WHEELS).unwrap();
    let design = nalgebra::DMatrix::from_fn(
        5,
        2,
        |row, column| {
            if column == 0 { 1.0 } else { readings[row].ground_pitch_rad.tan() }
        },
    );
    let arms = nalgebra::DVector::from_fn(5, |row, _| {
        let reading = &readings[row];
        (1.45 * reading.nose_kg + 3.84 * (reading.main_right_kg + reading.main_left_kg)) / reading.total_kg()
    });
    let information = (design.transpose() * &design).cholesky().unwrap();
    let solution = information.solve(&(design.transpose() * &arms));
    let variance = (&arms - &design * &solution).norm_squared() / 3.0;
    let covariance = information.inverse() * variance;
    close("x", found.x_m, solution[0], 1e-10);
    close("z", found.z_ground_m, solution[1], 1e-9);
    close("x error", found.x_error_m.unwrap(), covariance[(0, 0)].sqrt(), 1e-10);
    close("z error", found.z_error_m.unwrap(), covariance[(1, 1)].sqrt(), 1e-9);
}

#[test]
fn weighing_rejects_what_gives_no_height() {
    let level = calculated([3.2, 0.0, 1.7], 0.0);
    assert_eq!(centre_of_gravity(&[level], &WHEELS), Err(WeighingError::TooFew { count: 1 }));
    assert_eq!(centre_of_gravity(&[level, level], &WHEELS), Err(WeighingError::NoSpread { spread_rad: 0.0 }));
    let broken = WheelReactions { nose_kg: f64::NAN, ..calculated([3.2, 0.0, 1.7], 0.1) };
    let error = centre_of_gravity(&[level, broken], &WHEELS).unwrap_err();
    assert_eq!(error.to_string(), "weighing 2: nose_kg is NaN, allowed is 0 to 1e6 kg");
    let item = FixedItem { name: "all".into(), mass_kg: 10.0, cg_from_datum_m: [0.0; 3] };
    assert!(matches!(without_items(&item, std::slice::from_ref(&item)), Err(WeighingError::NothingLeft { .. })));
}
