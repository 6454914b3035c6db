//! Two sessions beside each other.

use doublet::command::{FileCommand, UiCommand, ViewCommand};
use doublet::step::Step;
use doublet_core::model::Coefficient;
use doublet_core::reconstruct::Input;
use doublet_engine::run::Snapshot;
use doublet_engine::session::{self, Edit, NoiseChannel};
use egui_kittest::kittest::Queryable;

use crate::click;
use crate::picture;
use crate::workbench::Bench;

/// Draws frames until both sessions are computed.
fn settle_both(bench: &mut Bench<'_>) {
    let begun = std::time::Instant::now();
    bench.settle();
    while bench.harness.state().is_busy_beside() {
        assert!(begun.elapsed().as_secs() < 300, "the second session is computed");
        std::thread::sleep(std::time::Duration::from_millis(5));
        bench.harness.step();
    }
    bench.harness.run_steps(3);
}

#[test]
fn a_second_session_stands_beside_the_first_with_one_zoom_and_one_cursor() {
    let mut bench = Bench::open();
    // The same flight under another noise.
    let path = bench.folder.path().join("other.toml");
    let noise = Edit::noise(NoiseChannel::Input(Input::PitchRate), 0.01);
    let other = noise.apply(bench.session()).expect("it can be changed");
    std::fs::write(&path, session::print(&other).expect("it can be written")).expect("there is room");
    let ctx = bench.harness.ctx.clone();
    bench.request(UiCommand::View(ViewCommand::Step(Step::Model)));
    bench.harness.state_mut().open_beside(&path, &ctx);
    settle_both(&mut bench);
    picture(&mut bench.harness, "second_session");
    let fits = |snapshot: &Snapshot| {
        let fits = snapshot.windows["first"].fits.ready().expect("it is fitted");
        fits.fits.iter().find(|fit| fit.coefficient == Coefficient::Cm).expect("Cm is fitted").fit.clone()
    };
    let (own, beside) = (bench.snapshot().clone(), bench.harness.state().beside().expect("it is open").0.clone());
    let estimates = [&own, &beside].map(|snapshot| fits(snapshot).expect("there is a fit").estimates);
    assert_ne!(estimates[0], estimates[1], "each side has its own results");
    // The cursor of one is that of the other.
    let all: Vec<_> = bench.harness.get_all_by_label_contains("plot: ΔCm").map(|plot| plot.rect()).collect();
    assert_eq!(all.len(), 2, "one on either side");
    let mut centres = [all[0].center(), all[1].center()];
    centres.sort_by(|a, b| a.x.total_cmp(&b.x));
    let [left, right] = centres;
    assert!(left.x < 750.0 && right.x > 750.0, "{left:?} {right:?}");
    for at in [left, right] {
        bench.harness.hover_at(at);
        bench.harness.run_steps(3);
        let cursor_s = bench.harness.state().state.window_time.cursor_s.expect("it stands somewhere");
        assert_eq!(bench.harness.state().beside().and_then(|(_, cursor_s)| cursor_s), Some(cursor_s));
    }
    // A screen reader hears its values.
    let spoken: Vec<_> = bench.harness.get_all_by_label_contains("plot: ΔCm").filter_map(|plot| plot.value()).collect();
    assert!(spoken.len() == 2 && spoken.iter().all(|text| text.contains("residual")), "{spoken:?}");
    assert_ne!(spoken[0], spoken[1], "each reads its own curve");
    click(&mut bench.harness, "second session: Derivatives", 3);
    picture(&mut bench.harness, "second_session_derivatives");
    bench.request(UiCommand::File(FileCommand::CloseBeside));
    assert!(bench.harness.state().beside().is_none());
}
