//! Calibrations of the sensors: those of the file, and fitted to readings.

use doublet::command::{EditCommand, UiCommand, ViewCommand};
use doublet::panels::Pane;
use doublet::step::Step;
use doublet_core::load::instruments;
use doublet_engine::calibrate::{Curve, SensorKind, fit, points};
use egui_kittest::kittest::Queryable;

use crate::click;
use crate::picture;
use crate::workbench::Bench;

/// Readings of yoke and aileron about a slope of 0.2, some hundredths of a degree off.
const READINGS: &str = "-80 -16.48\n-60 -12.55\n-40 -8.46\n-20 -4.53\n0 -0.47\n20 3.52\n40 7.46\n60 11.55\n80 15.48\n";

#[test]
fn readings_on_the_ground_give_a_calibration_that_the_flight_then_uses() {
    let mut bench = Bench::shipped_in(1280.0, 720.0);
    bench.request(UiCommand::View(ViewCommand::Step(Step::Signals)));
    bench.show(Pane::Sensors);
    picture(&mut bench.harness, "sensors");
    // What the file has: thesis Table 4.2 and the drum of 4.1.2.
    assert!(bench.harness.query_by_label("radius 12.450 mm").is_some(), "the drum of the file");
    bench.click("yoke, aileron");
    assert!(bench.harness.query_by_label_contains("a1 1.6200e-1").is_some(), "the line of the file");
    click(&mut bench.harness, "readings of the sensor", 2);
    bench.harness.get_by_label("readings of the sensor").type_text(READINGS);
    bench.settle();
    picture(&mut bench.harness, "sensors_fitted");
    let found = fit(&SensorKind::Aileron, 1, &points(READINGS).expect("they are readings")).expect("they are enough");
    let Curve::Polynomial(line) = &found.curve else { panic!("{:?}", found.curve) };
    assert!((line[1] - 0.2).abs() < 2e-4 && (line[0] + 0.5).abs() < 0.03, "{line:?}");
    let shown = format!("a1 {} ± {}", doublet::notation::number(line[1]), doublet::notation::number(found.errors[1]));
    assert!(bench.harness.query_by_label(&shown).is_some(), "{shown}");
    bench.request(UiCommand::View(ViewCommand::Appearance(egui::ThemePreference::Light)));
    picture(&mut bench.harness, "sensors_light");
    // Saved, the flight uses it: one step of undo.
    let before = bench.session().clone();
    let path = bench.folder.path().join("mine.toml");
    bench.click("Save instruments as…");
    bench.enter_file(&path.to_string_lossy());
    let setting = bench.session().flights[0].instruments.clone().expect("the flight has instruments");
    assert!(setting.file.ends_with("mine.toml"), "{}", setting.file);
    let saved = instruments::read(&path).expect("it is an instruments file");
    assert!((saved.control.aileron_slope - line[1]).abs() < 1e-12);
    assert_eq!(bench.snapshot().failures(), [], "everything follows from it");
    bench.request(UiCommand::Edit(EditCommand::Undo));
    assert_eq!(*bench.session(), before);
}
