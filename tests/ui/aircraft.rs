//! The aircraft to scale and its weighing.

use doublet::command::{UiCommand, ViewCommand};
use doublet::layouts::Step;
use doublet::panels::Pane;
use egui_kittest::kittest::Queryable;

use crate::picture;
use crate::workbench::Bench;

#[test]
fn aircraft_is_drawn_from_above_and_from_the_side_with_its_places() {
    let mut bench = Bench::shipped();
    bench.request(UiCommand::View(ViewCommand::Step(Step::Aircraft)));
    bench.show(Pane::Airframe);
    picture(&mut bench.harness, "airframe");
    for view in ["aircraft from above", "aircraft from the side"] {
        assert!(bench.harness.query_by_label(view).is_some(), "{view}");
    }
    let aircraft = bench.snapshot().aircraft.ready().expect("it is read").clone();
    let seat = &aircraft.aircraft.seats[0];
    // Its slider bears the name too.
    let named = bench.harness.query_all_by_label(&seat.name.replace('_', " ")).count();
    assert!(named >= 2, "{} has its row", seat.name);
}

#[test]
fn readings_of_the_scales_give_mass_and_centre_of_gravity() {
    let mut bench = Bench::shipped();
    bench.request(UiCommand::View(ViewCommand::Step(Step::Aircraft)));
    bench.show(Pane::Airframe);
    bench.click("Weighing");
    let aircraft = bench.snapshot().aircraft.ready().expect("it is read").clone();
    let wheels = aircraft.aircraft.wheels.expect("the file states them");
    // Balance of the moments of 1,400 kg at x = 3.5 m, z = 1.6 m, at two attitudes.
    for (at, pitch_deg) in [(1, -3.0_f64), (2, 4.0)] {
        let arm = 3.5 + 1.6 * pitch_deg.to_radians().tan();
        let main = 1400.0 * (arm - wheels.nose_x_m) / (wheels.main_x_m - wheels.nose_x_m);
        for (name, value) in [
            ("ground pitch", pitch_deg),
            ("aircraft pitch", pitch_deg),
            ("nose", 1400.0 - main),
            ("right", 0.5 * main),
            ("left", 0.5 * main),
        ] {
            bench.enter(&format!("weighing {at} {name}"), &format!("{value:.6}"));
        }
    }
    picture(&mut bench.harness, "weighing");
    assert!(bench.harness.query_by_label("1400.0 kg").is_some(), "the mass");
    assert!(bench.harness.query_by_label_contains("3.5000").is_some(), "its place along the aircraft");
}
