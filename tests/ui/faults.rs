//! A panic in a part of the window stays in that part.

use doublet::widgets::guarded::draw_guarded;
use egui_kittest::Harness;
use egui_kittest::kittest::Queryable;

use crate::widget_harness;

/// Two parts of a window, one of which may panic.
#[derive(Default)]
struct Parts {
    is_broken: bool,
    fault: Option<String>,
    panics: usize,
}

fn show(ui: &mut egui::Ui, parts: &mut Parts) {
    let is_broken = parts.is_broken;
    let has_panicked = draw_guarded("Flight", &mut parts.fault, ui, |ui| {
        ui.horizontal(|ui| {
            ui.label("first part");
            assert!(!is_broken, "as the test asked");
            ui.label("its end");
        });
    });
    parts.panics += usize::from(has_panicked);
    ui.label("second part");
}

#[test]
fn a_part_that_panics_shows_one_line_and_is_drawn_again_on_request() {
    let mut harness: Harness<'_, Parts> = widget_harness((500.0, 200.0), true, Parts::default(), show);
    harness.run_steps(2);
    assert!(harness.query_by_label("its end").is_some() && harness.query_by_label("Try again").is_none());

    harness.state_mut().is_broken = true;
    harness.run_steps(4);
    let line = harness.state().fault.clone().expect("the panic is noted");
    assert!(line.starts_with("Flight: internal error of doublet at ") && line.contains("as the test asked"), "{line}");
    assert!(line.contains("faults.rs:") && !line.contains('\n'), "{line}");
    assert_eq!(harness.state().panics, 1, "a part that failed is not drawn until it is tried again");
    assert!(harness.query_by_label("first part").is_none());
    assert!(harness.query_by_label("second part").is_some() && harness.query_by_label(&format!("⚠ {line}")).is_some());

    harness.get_by_label("Try again").click();
    harness.run_steps(3);
    assert_eq!(harness.state().panics, 2, "still broken");
    harness.state_mut().is_broken = false;
    harness.get_by_label("Try again").click();
    harness.run_steps(3);
    assert!(harness.query_by_label("its end").is_some() && harness.query_by_label("Try again").is_none());
    assert_eq!((harness.state().panics, &harness.state().fault), (2, &None));
}
