//! Recordings of several recorders made into one new session: their clocks, and one left out.

use std::path::{Path, PathBuf};

use doublet_core::quantity::Role;
use egui::accesskit::Role as Kind;
use egui_kittest::kittest::{NodeT, Queryable};

use crate::begin::Dropped;
use crate::workbench::Bench;
use crate::{click, picture};

/// How late the clock of the second recorder is, s.
const LATE_S: f64 = 1.5;

/// The small flight as two recorders wrote it: inertial sensors, and all else with the pitch angle on a clock of its own.
fn two_recorders(folder: &Path) -> [PathBuf; 2] {
    let text = std::fs::read_to_string(folder.join("flight.csv")).expect("the flight is there");
    let rows: Vec<Vec<&str>> = text.lines().map(|line| line.split(',').collect()).collect();
    let inertial = ["time", "ax", "ay", "az", "p", "q", "r", "phi", "theta", "psi"];
    let write = |name: &str, late_s: f64, is_own: &dyn Fn(&str) -> bool| {
        let line = |row: &Vec<&str>| {
            let own = row.iter().zip(&rows[0]).filter(|(_, column)| is_own(column)).map(|(cell, column)| {
                let time_s = cell.parse::<f64>().ok().filter(|_| *column == "time");
                time_s.map_or_else(|| (*cell).to_owned(), |time_s| format!("{:.4}", time_s + late_s))
            });
            own.collect::<Vec<_>>().join(",")
        };
        let path = folder.join(name);
        std::fs::write(&path, rows.iter().map(line).collect::<Vec<_>>().join("\n")).expect("it can be written");
        path
    };
    let is_air = |column: &str| ["time", "theta"].contains(&column) || !inertial.contains(&column);
    [write("inertial.csv", 0.0, &|column| inertial.contains(&column)), write("air.csv", LATE_S, &is_air)]
}

#[test]
fn recorders_of_one_flight_are_merged_with_their_clocks_and_the_shift_can_be_refused() {
    let mut bench = Bench::open();
    for path in two_recorders(bench.folder.path()) {
        let dropped = std::sync::Arc::new(Dropped(path));
        bench.harness.input_mut().dropped_files.push(dropped);
    }
    bench.harness.run_steps(2);
    bench.wait_for("Create session");
    assert!(bench.harness.query_by_label_contains("2 recordings are merged into one flight").is_some());
    let shift = format!("Shift the clock of air by {} s", doublet::notation::fixed(-LATE_S, 1));
    bench.wait_for(&shift);
    picture(&mut bench.harness, "new_session_recorders");
    click(&mut bench.harness, &shift, 3);
    bench.wait_until("the shift is refused", |bench| bench.harness.query_by_label(&shift).is_none());
    click(&mut bench.harness, "Shift the clock of air to that of the others", 3);
    bench.wait_for(&shift);
    bench.choose_entry("aircraft", "none: flight path only");
    bench.harness.get_by_label("Create session").click();
    bench.wait_until_made();
    let clocks = bench.session().flights[0].clocks.clone();
    assert_eq!(clocks.iter().map(|clock| clock.source.as_str()).collect::<Vec<_>>(), ["air"]);
    assert!((clocks[0].offset_s + LATE_S).abs() < 0.06 && !clocks[0].fit.is_empty(), "{clocks:?}");
    let flight = bench.snapshot().flights.values().next().and_then(|slot| slot.ready()).expect("it is read").clone();
    let alpha = &flight.recording.role(Role::AngleOfAttack).expect("alpha is recorded").series;
    assert!(alpha.time_s[0].abs() < 0.02, "on the clock of the inertial sensors: {}", alpha.time_s[0]);
}

#[test]
fn recording_is_left_out_of_a_new_session_and_a_refused_shift_is_not_made() {
    let mut bench = Bench::open();
    for path in two_recorders(bench.folder.path()) {
        bench.harness.input_mut().dropped_files.push(std::sync::Arc::new(Dropped(path)));
    }
    bench.harness.run_steps(2);
    bench.wait_for("Create session");
    let shift = format!("Shift the clock of air by {} s", doublet::notation::fixed(-LATE_S, 1));
    bench.wait_for(&shift);
    click(&mut bench.harness, &shift, 3);
    bench.choose_entry("aircraft", "none: flight path only");
    bench.harness.get_by_label("Create session").click();
    bench.wait_until_made();
    assert!(bench.session().flights[0].clocks.is_empty(), "{:?}", bench.session().flights[0].clocks);
    for path in two_recorders(bench.folder.path()) {
        bench.harness.input_mut().dropped_files.push(std::sync::Arc::new(Dropped(path)));
    }
    bench.harness.run_steps(2);
    bench.choose("Discard");
    bench.wait_for("Create session");
    click(&mut bench.harness, "remove air.csv", 2);
    bench.wait_until("one is left", |bench| {
        let is_there = |part: &str| bench.harness.query_all_by_label_contains(part).next().is_some();
        is_there("Create session") && !is_there("air.csv")
    });
    assert!(bench.harness.query_by_label_contains("are merged into one flight").is_none());
    bench.step("Channels");
    let channel = |role: &str| {
        let name = format!("channel of {role}");
        bench.harness.get_by_role_and_label(Kind::ComboBox, &name).accesskit_node().value()
    };
    assert_eq!(channel("q").as_deref(), Some("q"));
    assert_ne!(channel("alpha").as_deref(), Some("alpha"));
}
