//! The report as it will be printed, in the window.

use std::time::{Duration, Instant};

use doublet::panels::Pane;
use doublet_engine::report::document::SectionKind;
use egui_kittest::kittest::Queryable;

use crate::picture;
use crate::workbench::Bench;

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
