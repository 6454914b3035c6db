//! The report as it will be printed, in the window.

use std::time::{Duration, Instant};

use doublet::command::{EditCommand, UiCommand};
use doublet::panels::Pane;
use doublet::ui_state::HouseStyle;
use doublet_core::model::{Coefficient, Term};
use doublet_engine::notation::significant;
use doublet_engine::report::document::{SectionKind, UnitSystem};
use doublet_engine::session::{Edit, ModelEdit};
use egui_kittest::kittest::Queryable;

use crate::workbench::Bench;
use crate::{click, picture};

#[test]
fn report_is_shown_as_its_pages_and_follows_the_sections_ticked() {
    let mut bench = Bench::open();
    let report = &mut bench.harness.state_mut().state.report;
    report.as_pages = true;
    // Few sections: the typesetter is slow without optimisation.
    let left_out = [SectionKind::Overview, SectionKind::Derivatives];
    report.left_out = SectionKind::ALL.into_iter().filter(|kind| !left_out.contains(kind)).collect();
    bench.show(Pane::Report);
    let count = |bench: &mut Bench<'_>| {
        let begun = Instant::now();
        while bench.harness.query_by_label_contains("typesetting").is_some()
            || bench.harness.query_by_label("page 1 of 1").is_none()
                && bench.harness.query_all_by_label_contains("page 1 of ").count() == 0
        {
            assert!(begun.elapsed() < Duration::from_secs(300), "it is typeset");
            std::thread::sleep(Duration::from_millis(20));
            bench.harness.step();
        }
        // The pictures of what is on screen come behind.
        (0..40).for_each(|_| {
            std::thread::sleep(Duration::from_millis(25));
            bench.harness.step();
        });
        bench.harness.query_all_by_label_contains("page ").filter(|node| node.rect().height() > 300.0).count()
    };
    let with_derivatives = count(&mut bench);
    picture(&mut bench.harness, "report_pages");
    assert!(with_derivatives >= 2, "{with_derivatives} pages");
    let page = bench.harness.get_by_label(&format!("page 1 of {with_derivatives}")).rect();
    assert!((page.height() / page.width() - 297.0 / 210.0).abs() < 0.01, "A4, {page:?}");
    let image = bench.harness.render().expect("it is drawn");
    let dark = image.enumerate_pixels().filter(|(x, y, pixel)| {
        let at = egui::pos2(*x as f32, *y as f32);
        page.contains(at) && pixel.0[..3].iter().all(|part| *part < 120)
    });
    assert!(dark.count() > 500, "there is print on the page");
}

#[test]
fn purpose_and_derivatives_asked_for_are_entered_beside_the_report_and_answered_in_it() {
    let mut bench = Bench::open();
    bench.harness.state_mut().state.report.shown = SectionKind::Purpose;
    bench.show(Pane::Report);
    bench.harness.get_by_label("purpose of the report").scroll_to_me();
    bench.harness.run_steps(3);
    click(&mut bench.harness, "purpose of the report", 2);
    bench.harness.get_by_label("purpose of the report").type_text("Short period at cruise.");
    bench.harness.run_steps(2);
    bench.click("Derivatives asked for: 0");
    assert_eq!(bench.session().report_purpose, "Short period at cruise.");
    bench.click("ask for Cm_q");
    bench.click("ask for Cm_alpha");
    bench.click("ask for Cm_q");
    assert_eq!(bench.session().report_asked, ["Cm_alpha"]);
    picture(&mut bench.harness, "report_purpose");
    let is_shown = |bench: &Bench<'_>, text: &str| bench.harness.query_all_by_label_contains(text).next().is_some();
    assert!(is_shown(&bench, "Derivatives asked for: 1") && is_shown(&bench, "Short period at cruise."));
    let estimate = bench.cm().parameter("Cm_alpha").expect("it is estimated").0;
    assert!(is_shown(&bench, &significant(estimate, 4)), "the report answers with {estimate}");
    // Asked for once more than the model has: it stays in the list until it is taken back.
    let term = Term::parse("alpha").expect("a term");
    let edit = Edit::Model(ModelEdit::SetTerm { coefficient: Coefficient::Cm, term, on: false });
    bench.harness.state_mut().apply(&edit);
    bench.settle();
    bench.click("ask for Cm_alpha");
    assert!(bench.session().report_asked.is_empty());
    (0..6).for_each(|_| bench.request(UiCommand::Edit(EditCommand::Undo)));
    assert_eq!(bench.session().report_purpose, "");
}

#[test]
fn house_style_and_order_of_sections_are_set_beside_the_report_and_kept() {
    let mut bench = Bench::open();
    bench.harness.state_mut().state.report.as_pages = false;
    bench.show(Pane::Report);
    let before = bench.harness.state().state.house.sections();
    assert_eq!(before, SectionKind::ALL);
    let name = before[2].name();
    bench.click(&format!("move {name} up"));
    bench.click(&format!("move {name} up"));
    // The first section stays where it is.
    bench.click(&format!("move {name} up"));
    let order = bench.harness.state().state.house.sections();
    assert_eq!(order[..3], [before[2], before[0], before[1]]);
    assert_eq!(order[3..], before[3..]);
    bench.harness.get_by_label("House style").scroll_to_me();
    bench.harness.run_steps(3);
    bench.click("House style");
    bench.harness.run_steps(10);
    click(&mut bench.harness, "header of the report", 2);
    bench.harness.get_by_label("header of the report").type_text("Flight test department");
    bench.harness.run_steps(2);
    bench.click("kt and ft");
    picture(&mut bench.harness, "report_house_style");
    let house = bench.harness.state().state.house.clone();
    let style = house.style().expect("it has no logo");
    assert_eq!((style.header.as_str(), style.units), ("Flight test department", UnitSystem::Aviation));
    let stored: HouseStyle =
        serde_json::from_str(&serde_json::to_string(&house).expect("it is written")).expect("it is read");
    assert_eq!(stored, house);
    let lost = HouseStyle { logo: "/nowhere/logo.svg".to_owned(), ..house };
    assert!(lost.style().expect_err("there is no such file").contains("logo.svg"));
}
