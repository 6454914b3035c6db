//! What can be taken away from plots: pictures, drawings, numbers, and what lies between two markers.

use doublet::command::{UiCommand, ViewCommand};
use doublet::widgets::figure::{FigureForm, csv};
use doublet::widgets::time_view::TimeRange;
use egui_kittest::kittest::Queryable;

use crate::plots::{harness, middle};
use crate::workbench::Bench;
use crate::{click, copied, picture, secondary_click};

/// Rounding of printed numbers to five digits, relative.
const PRINTED: f64 = 1e-4;

/// The cells of a line of comma-separated text.
fn numbers(line: &str) -> Vec<f64> {
    line.split(',').filter_map(|cell| cell.parse().ok()).collect()
}

#[test]
fn table_between_the_markers_holds_differences_slope_and_statistics() {
    let mut harness = harness(5000, true);
    let (a, b) = (5.0, 9.0);
    harness.state_mut().view.markers_s = [Some(a), Some(b)];
    harness.run_steps(3);
    assert!(harness.query_by_label("B − A 4.000 s").is_some());
    picture(&mut harness, "readout");
    harness.get_by_label("Copy").click();
    harness.step();
    let text = copied(&harness).expect("the table is in the clipboard");
    // The second row is the smooth wave of `plots::Bench`: the product of two sines at 100 Hz.
    let wave = |k: usize| (k as f64 * 0.008).sin() * (k as f64 * 0.0013).cos();
    let inside: Vec<f64> = (500..=900).map(wave).collect();
    let count = inside.len() as f64;
    let expected = [
        wave(500),
        wave(900),
        wave(900) - wave(500),
        (wave(900) - wave(500)) / (b - a),
        inside.iter().copied().fold(f64::INFINITY, f64::min),
        inside.iter().copied().fold(f64::NEG_INFINITY, f64::max),
        inside.iter().sum::<f64>() / count,
        (inside.iter().map(|v| v * v).sum::<f64>() / count).sqrt(),
    ];
    let row = text.lines().nth(2).expect("one line per trace");
    for (found, expected) in numbers(row).iter().zip(expected) {
        assert!((found - expected).abs() < 1e-9, "{found} is not {expected}: {row}");
    }
    assert_eq!(numbers(row).len(), expected.len());
}

#[test]
fn menu_of_a_plot_copies_every_sample_on_screen_and_nothing_else() {
    let mut harness = harness(5000, true);
    harness.state_mut().view.zoom_to(TimeRange::new(10.0, 12.0));
    harness.run_steps(2);
    let at = middle(&harness);
    secondary_click(&mut harness, at);
    harness.get_by_label_contains("This plot").click();
    harness.run_steps(4);
    picture(&mut harness, "plot_menu");
    click(&mut harness, "Copy data", 2);
    let request = harness.state_mut().figures.pop().expect("a figure was asked for");
    assert_eq!((request.form, request.figure.panels.len()), (FigureForm::Copy, 1));
    let text = csv(&request.figure);
    let mut lines = text.lines();
    assert_eq!(lines.next(), Some("time [s],q measured [rad/s],q̂ [rad/s]"));
    let rows: Vec<Vec<f64>> = lines.map(numbers).collect();
    assert_eq!(rows.len(), 201, "2 s at 100 Hz with both ends");
    let wave = |k: f64| (k * 0.008).sin() * (k * 0.0013).cos();
    for (row, k) in rows.iter().zip(1000..) {
        assert!((row[0] - 0.01 * f64::from(k)).abs() < 1e-9 && (row[2] - wave(f64::from(k))).abs() < 1e-12, "{row:?}");
    }
    // The drawing shows the same part: its last number is the right end of the frame.
    let svg = doublet_report::svg::svg(&request.figure, "p");
    assert!(svg.contains("stroke-dasharray=\"4 2.5\"") && svg.contains("time [s]"));
}

#[test]
fn plots_of_the_flight_are_saved_as_drawing_picture_and_numbers() {
    let mut bench = Bench::open();
    let place = bench.harness.get_by_role_and_label(egui::accesskit::Role::Button, "first").rect();
    let plot = place.center() + egui::vec2(0.0, 60.0);
    for (form, name) in
        [("Save as SVG…", "plots.svg"), ("Save as PNG…", "plots.png"), ("Save data as CSV…", "plots.csv")]
    {
        secondary_click(&mut bench.harness, plot);
        bench.harness.get_by_label_contains("All 5 plots").click();
        bench.harness.run_steps(4);
        click(&mut bench.harness, form, 3);
        bench.enter_file(name);
        let path = bench.folder.path().join(name);
        assert!(std::fs::metadata(&path).is_ok_and(|file| file.len() > 1000), "{name} is written");
    }
    let svg = std::fs::read_to_string(bench.folder.path().join("plots.svg")).expect("it can be read");
    assert!(svg.contains("<path") && svg.contains("h [m]") | svg.contains("V [m/s]"), "traces and labels are drawn");
    let picture = image::open(bench.folder.path().join("plots.png")).expect("it is a picture");
    assert!(picture.width() > 600);
    let csv = std::fs::read_to_string(bench.folder.path().join("plots.csv")).expect("it can be read");
    let airspeed = csv.lines().next().and_then(|head| head.split(',').position(|name| name == "V [m/s]"));
    let row =
        csv.lines().nth(1).and_then(|line| line.split(',').nth(airspeed?)).and_then(|cell| cell.parse::<f64>().ok());
    assert!(row.is_some_and(|v| (v / crate::recording::AIRSPEED_M_S - 1.0).abs() < PRINTED), "{row:?}");
}

#[test]
fn units_of_aviation_show_knots_and_type_knots() {
    let mut bench = Bench::open();
    bench.request(UiCommand::View(ViewCommand::Units(doublet::notation::Units::Aviation)));
    bench.show(doublet::panels::Pane::Noise);
    bench.enter("R airspeed", "0.5");
    let typed = bench.session().filter.measurement_noise[doublet_core::reconstruct::Measurement::Airspeed as usize];
    assert!((typed - 0.5 * 1852.0 / 3600.0).abs() < 1e-12, "{typed} m/s");
    assert!(bench.harness.query_all_by_label("kt").next().is_some(), "the unit is beside the field");
    picture(&mut bench.harness, "units_aviation");
}
