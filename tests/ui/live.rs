//! A flight watched in the window.

use std::time::{Duration, Instant};

use doublet::command::{UiCommand, ViewCommand};
use doublet::notation::Units;
use doublet::panels::Pane;
use doublet_engine::notation;
use egui_kittest::kittest::{NodeT, Queryable};

use crate::picture;
use crate::workbench::Bench;

/// Longest wait for the first seconds of a flight flown again.
const PATIENCE: Duration = Duration::from_secs(60);

#[test]
fn a_flight_flown_again_shows_estimates_with_error_bars_and_lamps() {
    let mut bench = Bench::open();
    bench.show(Pane::Live);
    bench.harness.get_by_label("Live limits").focus();
    bench.harness.get_by_label("Live limits").type_text("alpha=-4deg:14deg n_z=0.5:2");
    bench.harness.run_steps(2);
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
    // Limits are read as they were typed, what was flown beside them in the same unit.
    let shown = bench.harness.get_by_label_contains(" deg (\u{2212}4 to 14)");
    let text = shown.accesskit_node().value().or_else(|| shown.accesskit_node().label()).expect("it is a text");
    let least: f64 = text["α ".len()..].split(' ').next().and_then(|least| least.parse().ok()).expect("it is a number");
    assert!(text.starts_with("α ") && (0.5..14.0).contains(&least), "{text}");
    assert!(bench.harness.query_by_label_contains("n_z").is_some());
    bench.request(UiCommand::View(ViewCommand::Units(Units::Si)));
    assert!(bench.harness.query_by_label_contains(" rad (\u{2212}0.06981 to 0.2443)").is_some());
}
