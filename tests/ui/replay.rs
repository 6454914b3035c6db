//! The flight played: what the picture and its numbers say, and that nothing moves while nothing plays.

use doublet::command::{UiCommand, ViewCommand};
use doublet::panels::Pane;
use doublet::step::Step;
use doublet_core::reconstruct::State;
use doublet_engine::aircraft::instant;
use egui_kittest::kittest::Queryable;

use crate::workbench::Bench;
use crate::{FRAME_S, click, picture};

#[test]
fn replay_follows_the_flight_while_it_plays_and_stands_still_otherwise() {
    let mut bench = Bench::shipped_in(1280.0, 720.0);
    bench.request(UiCommand::View(ViewCommand::Step(Step::Recording)));
    bench.show(Pane::Replay);
    let window = bench.session().windows[0].clone();
    let start_s = window.window.start_s;
    let cursor = |bench: &Bench<'_>| bench.harness.state().state.time.cursor_s;
    assert_eq!(cursor(&bench), None, "nothing plays");
    click(&mut bench.harness, "4×", 2);
    click(&mut bench.harness, "▶ Play", 40);
    click(&mut bench.harness, "⏸ Pause", 4);
    let now_s = cursor(&bench).expect("the plots follow");
    let expected = 4.0 * 40.0 * f64::from(FRAME_S);
    assert!((now_s - start_s - expected).abs() < 0.2 * expected, "{} s for {expected}", now_s - start_s);
    picture(&mut bench.harness, "replay");
    // Numbers of the picture are those of the path.
    let flight = window.flight.clone();
    let now = instant(bench.snapshot(), &flight, Some(&window), now_s);
    let [bank, ..] = now.reconstructed.attitude_rad.expect("the manoeuvre has a path");
    let path = bench.snapshot().windows[&window.name].path.ready().expect("it is up to date").clone();
    let series = &path.series().states[State::BankAngle as usize];
    let after = series.time_s.partition_point(|&time_s| time_s < now_s);
    let (low, high) =
        (series.values[after - 1].min(series.values[after]), series.values[after - 1].max(series.values[after]));
    assert!((low..=high).contains(&bank), "{bank} between {low} and {high}");
    let shown = doublet::notation::fixed(bank.to_degrees(), 2);
    assert!(bench.harness.query_all_by_label(&shown).next().is_some(), "{shown} is shown");
    let elevator = now.controls_rad[1].expect("it is recorded").to_degrees();
    let shown = format!("elevator {} deg", doublet::notation::fixed(elevator, 2));
    assert!(bench.harness.query_by_label(&shown).is_some(), "{shown}");
    // Paused it stays where it is and asks for no frame.
    bench.harness.run_steps(5);
    assert_eq!(cursor(&bench), Some(now_s));
    assert!(!bench.harness.ctx.has_requested_repaint(), "nothing is drawn while nothing moves");
    bench.request(UiCommand::View(ViewCommand::Appearance(egui::ThemePreference::Light)));
    picture(&mut bench.harness, "replay_light");
    click(&mut bench.harness, "Side by side", 3);
    picture(&mut bench.harness, "replay_side_by_side");
    assert!(bench.harness.query_all_by_label("reconstructed").count() >= 1);
}
