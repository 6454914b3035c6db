//! Mass properties over time from the fuel on board.

use doublet_core::airframe::{FuelSplit, HistoryError, Loading, MassHistory};

use super::support::{close, reference, shipped};

/// Fuel of the four tanks of the C337F, kg: mains, auxiliaries, each side alike.
fn loading(main: f64, auxiliary: f64) -> Loading {
    let fuel =
        [("main right", main), ("main left", main), ("auxiliary right", auxiliary), ("auxiliary left", auxiliary)];
    Loading { fuel_kg: fuel.map(|(tank, kg)| (tank.to_owned(), kg)).into(), ..shipped("c337f.toml").standard_loading }
}

fn mains_first() -> FuelSplit {
    let pair = |kind: &str| vec![format!("{kind} right"), format!("{kind} left")];
    FuelSplit::InOrder(vec![pair("main"), pair("auxiliary")])
}

#[test]
fn burning_the_mains_changes_inertia_as_thesis_section_7_2_1_states() {
    let Some(table) = reference("mass_cg.toml") else { return };
    let aircraft = shipped("c337f.toml");
    let condition = |field: &str| table.number(&format!("ft10_conditions.{field}"));
    let (main, auxiliary) = (condition("fuel_main_kg"), condition("fuel_aux_kg"));
    let burnt = -condition("fuel_main_change_kg");
    let start = loading(main / 2.0, auxiliary / 2.0);
    let total = main + auxiliary;
    let history =
        MassHistory::from_total_fuel(&aircraft, &start, &[0.0, 600.0], &[total, total - burnt], &mains_first())
            .unwrap();
    let (first, last) = (history.at(0).inertia, history.at(1).inertia);
    close("mass", history.at(0).mass_kg - history.at(1).mass_kg, burnt, 1e-9);
    // Positions to a centimetre and a loading whose occupants are not printed: 16.7 kg x 0.01 m x 2 x 2.7 m and as much for the cg.
    let changes = [
        ("Ixx", last.xx - first.xx),
        ("Iyy", last.yy - first.yy),
        ("Izz", last.zz - first.zz),
        ("Ixz", last.xz - first.xz),
    ];
    for (name, change) in changes {
        close(name, change, condition(&format!("inertia_change_over_manoeuvres_kg_m2.{name}")), 4.0);
    }
    for axis in 0..3 {
        let travel = history.at(1).cg_from_datum_m[axis] - history.at(0).cg_from_datum_m[axis];
        close("travel", travel, table.point("ft10_conditions.cog_change_over_manoeuvres_m")[axis], 0.0101);
    }
}

#[test]
fn fuel_in_order_empties_one_pair_after_the_other() {
    let aircraft = shipped("c337f.toml");
    let fuel = [300.0, 200.0, 100.0, 50.0, 0.0];
    let history = MassHistory::from_total_fuel(
        &aircraft,
        &loading(100.0, 50.0),
        &[0.0, 1.0, 2.0, 3.0, 4.0],
        &fuel,
        &mains_first(),
    )
    .unwrap();
    let mains = [200.0, 100.0, 0.0, 0.0, 0.0];
    for sample in 0..5 {
        let state = loading(mains[sample] / 2.0, (fuel[sample] - mains[sample]) / 2.0).mass_properties(&aircraft);
        close("mass", history.at(sample).mass_kg, state.mass_kg, 1e-9);
        close("x", history.at(sample).cg_from_datum_m[0], state.cg_from_datum_m[0], 1e-12);
        close("Ixx", history.at(sample).inertia.xx, state.inertia.xx, 1e-8);
    }
}

#[test]
fn fuel_in_proportion_and_by_tank_agree() {
    let aircraft = shipped("c337f.toml");
    let start = loading(100.0, 50.0);
    let time = [0.0, 10.0];
    let total =
        MassHistory::from_total_fuel(&aircraft, &start, &time, &[300.0, 150.0], &FuelSplit::Proportional).unwrap();
    let (main, auxiliary) = ([100.0, 50.0], [50.0, 25.0]);
    let columns: Vec<(String, &[f64])> = vec![
        ("main right".into(), &main),
        ("main left".into(), &main),
        ("auxiliary right".into(), &auxiliary),
        ("auxiliary left".into(), &auxiliary),
    ];
    let tanks = MassHistory::from_tanks(&aircraft, &start, &time, &columns).unwrap();
    for sample in 0..2 {
        close("mass", total.at(sample).mass_kg, tanks.at(sample).mass_kg, 1e-9);
        close("Izz", total.at(sample).inertia.zz, tanks.at(sample).inertia.zz, 1e-8);
    }
}

#[test]
fn history_rejects_fuel_that_cannot_be() {
    let aircraft = shipped("c337f.toml");
    let start = loading(100.0, 50.0);
    let of = |time: &[f64], fuel: &[f64]| {
        MassHistory::from_total_fuel(&aircraft, &start, time, fuel, &mains_first()).unwrap_err()
    };
    assert_eq!(of(&[0.0, 1.0], &[300.0]), HistoryError::Length { field: "fuel mass".into(), found: 1, expected: 2 });
    assert_eq!(of(&[0.0, 0.0], &[300.0, 300.0]), HistoryError::Time { index: 1, time_s: 0.0 });
    let too_much = HistoryError::Fuel {
        field: "fuel mass".into(),
        time_s: 1.0,
        fuel_kg: 400.0,
        lowest_kg: 0.0,
        highest_kg: 300.0,
    };
    assert_eq!(of(&[0.0, 1.0], &[300.0, 400.0]), too_much);
    assert!(matches!(of(&[0.0], &[f64::NAN]), HistoryError::Fuel { .. }));
    let over = MassHistory::from_tanks(&aircraft, &start, &[0.0], &[("main left".into(), &[133.5])]).unwrap_err();
    assert_eq!(over.to_string(), "main left at 0 s is 133.5 kg, allowed is 0 to 132.5 kg");
    let unknown = MassHistory::from_tanks(&aircraft, &start, &[0.0], &[("tip".into(), &[1.0])]).unwrap_err();
    assert!(matches!(unknown, HistoryError::UnknownTank { .. }));
}
