//! A flight watched in the window.

use std::time::{Duration, Instant};

use doublet::panels::Pane;
use doublet_engine::notation;
use egui_kittest::kittest::Queryable;

use crate::picture;
use crate::workbench::Bench;

/// Longest wait for the first seconds of a flight flown again.
const PATIENCE: Duration = Duration::from_secs(60);

#[test]
fn a_flight_flown_again_shows_estimates_with_error_bars_and_lamps() {
    let mut bench = Bench::open();
    bench.show(Pane::Live);
    let started = Instant::now();
    bench.harness.get_by_role_and_label(egui::accesskit::Role::Button, "Watch").click();
    bench.harness.run_steps(2);
    while bench.harness.query_by_label_contains("enough:").is_none() {
        assert!(started.elapsed() < PATIENCE, "the first estimates come in time");
        std::thread::sleep(Duration::from_millis(20));
        bench.harness.step();
    }
    bench.harness.get_by_role_and_label(egui::accesskit::Role::Button, "Stop").click();
    bench.harness.run_steps(2);
    while bench.harness.query_by_label("Watch").is_none() {
        assert!(started.elapsed() < PATIENCE, "it stops");
        std::thread::sleep(Duration::from_millis(20));
        bench.harness.step();
    }
    let name = notation::derivative("Cm_delta_e");
    bench.harness.get_by_role_and_label(egui::accesskit::Role::Link, &name).click();
    bench.harness.run_steps(2);
    assert!(bench.harness.query_by_label_contains("0 lost, 0 late").is_some(), "counts are said");
    picture(&mut bench.harness, "live");
}
