//! What a flight asks of the hand, by keyboard and clicks alone, timed: manoeuvres accepted and corrected, a gust excluded, filters and
//! structures compared. Run alone: `cargo test --test ui must_show -- --ignored --nocapture`.

use std::time::Instant;

use doublet::app::{Document, Workbench};
use doublet::command::{UiCommand, ViewCommand};
use doublet::panels::Pane;
use doublet::step::Step;
use doublet_engine::compare::{ExperimentRow, PRESENT};
use doublet_engine::run::Slot;
use doublet_engine::verdict::VerdictCounts;
use egui::{Key, Modifiers};
use egui_kittest::kittest::Queryable;

use crate::workbench::Bench;
use crate::{builder, picture};

/// Manoeuvres that are accepted or corrected, and every how many of them an edge is moved.
const WANTED: usize = 35;
const CORRECTED: usize = 5;
/// Longest times, s.
const MARKING_S: f64 = 180.0;
const COMPARING_S: f64 = 120.0;
/// Filters and structures that are compared.
const FILTERS: usize = 6;
const STRUCTURES: usize = 12;

struct Hand<'b, 'a> {
    bench: &'b mut Bench<'a>,
    actions: usize,
}

impl Hand<'_, '_> {
    fn key(&mut self, key: Key) {
        self.keys(Modifiers::NONE, key);
    }

    fn keys(&mut self, modifiers: Modifiers, key: Key) {
        self.actions += 1;
        self.bench.harness.key_press_modifiers(modifiers, key);
        self.bench.harness.run_steps(2);
    }

    fn click(&mut self, label: &str) {
        self.actions += 1;
        self.bench.harness.get_by_label(label).click();
        self.bench.harness.run_steps(3);
    }

    fn windows(&self) -> usize {
        self.bench.session().windows.len()
    }
}

#[test]
#[ignore = "measures time: run alone"]
fn manoeuvres_of_the_shipped_flight_are_marked_by_keyboard_and_a_gust_is_excluded() {
    let mut bench = Bench::shipped_in(1280.0, 720.0);
    bench.harness.hover_at(egui::pos2(640.0, 718.0));
    let began = Instant::now();
    let mut hand = Hand { bench: &mut bench, actions: 0 };
    hand.keys(Modifiers::COMMAND, Key::Num5);
    // The manoeuvres of the session go: all are marked anew.
    hand.keys(Modifiers::COMMAND.plus(Modifiers::SHIFT), Key::A);
    hand.key(Key::Delete);
    hand.bench.settle();
    assert_eq!(hand.windows(), 0);
    let (mut done, mut corrected) = (0, 0);
    while done < WANTED {
        let before = hand.windows();
        // The first press behind a correction brings the next candidate on screen, the second accepts it.
        hand.key(Key::Y);
        if hand.windows() == before {
            hand.key(Key::Y);
        }
        if hand.windows() == before {
            break;
        }
        done += 1;
        if done % CORRECTED == 0 {
            let name = hand.bench.harness.state().state.selection.window.clone().expect("the new one is chosen");
            let was = hand.bench.session().window(&name).expect("it is there").window;
            // Marker A in the middle of what is seen, moved by keys to where the manoeuvre shall end.
            hand.key(Key::W);
            hand.key(Key::A);
            (0..12).for_each(|_| hand.keys(Modifiers::COMMAND, Key::ArrowRight));
            hand.key(Key::CloseBracket);
            let now = hand.bench.session().window(&name).expect("it is there").window;
            assert!(now.end_s != was.end_s && now.start_s == was.start_s, "{was:?} {now:?}");
            corrected += 1;
        }
    }
    hand.bench.settle();
    picture(&mut hand.bench.harness, "must_marked");
    // A gust in the last one, between the markers.
    hand.key(Key::W);
    hand.key(Key::Escape);
    hand.key(Key::A);
    hand.key(Key::B);
    (0..8).for_each(|_| hand.keys(Modifiers::COMMAND.plus(Modifiers::SHIFT), Key::ArrowRight));
    hand.key(Key::E);
    hand.bench.settle();
    let excluded = hand.bench.session().windows.iter().filter(|window| !window.excluded.is_empty()).count();
    let (actions, took_s) = (hand.actions, began.elapsed().as_secs_f64());
    picture(&mut bench.harness, "must_excluded");
    println!(
        "{done} accepted, {corrected} of them corrected, a gust excluded: {actions} keys, {took_s:.1} s with every result computed"
    );
    assert_eq!(excluded, 1);
    assert!(done >= WANTED, "{done} of {WANTED}");
    assert!(took_s < MARKING_S);
    assert!(bench.snapshot().pooled.ready().is_some());
}

#[test]
#[ignore = "measures time: run alone"]
fn filters_and_structures_are_compared_and_the_best_is_taken() {
    let mut bench = Bench::shipped_in(1280.0, 720.0);
    let began = Instant::now();
    let mut hand = Hand { bench: &mut bench, actions: 0 };
    hand.bench.request(UiCommand::View(ViewCommand::Step(Step::Model)));
    hand.bench.show(Pane::Experiments);
    hand.click("Add experiments");
    hand.click("All filters");
    for (coefficient, _) in hand.bench.session().structure.models.clone().iter().take(4) {
        hand.click("Add experiments");
        hand.click(&format!("{} without each term", coefficient.name()));
        hand.click("By all manoeuvres");
    }
    let count = hand.bench.session().experiments.len();
    let filters = hand
        .bench
        .session()
        .experiments
        .iter()
        .filter(|one| one.configuration.structure == hand.bench.session().structure);
    let filters = filters.count();
    assert!(filters >= FILTERS && count - filters >= STRUCTURES, "{filters} filters of {count}");
    hand.bench.settle();
    let rows = hand.bench.snapshot().inquiries.experiments.0.clone();
    let all = rows.iter().all(|(_, slot)| matches!(slot, Slot::Ready(_)) || slot.error().is_some());
    assert!(all && rows.len() == count + 1);
    picture(&mut hand.bench.harness, "must_board");
    // The best predicts the validation manoeuvres best.
    let error = |row: &(String, Slot<ExperimentRow>)| {
        row.1.ready().and_then(|row| row.outcome.validation_error).unwrap_or(f64::INFINITY)
    };
    let best =
        rows.iter().filter(|row| row.0 != PRESENT).min_by(|a, b| error(a).total_cmp(&error(b))).expect("there are");
    let (name, least) = (best.0.clone(), error(best));
    hand.bench.harness.get_by_label(&name).scroll_to_me();
    hand.bench.harness.run_steps(2);
    hand.click(&name);
    hand.click("Make current");
    hand.bench.settle();
    let (actions, took_s) = (hand.actions, began.elapsed().as_secs_f64());
    picture(&mut bench.harness, "must_chosen");
    println!(
        "{filters} filters and {} structures compared, '{name}' taken (validation error {least:.4}): {actions} clicks, {took_s:.1} s",
        count - filters
    );
    assert!(took_s < COMPARING_S);
}

/// Session of a stranger's flight whose fixes are applied.
const STRANGER: &str = "DOUBLET_STRANGER";
/// Fixes that are applied.
const FIXES: usize = 3;

#[test]
#[ignore = "needs a session of a stranger's flight, by DOUBLET_STRANGER"]
fn three_fixes_of_a_strangers_flight_lead_to_a_better_verdict() {
    let Some(path) = std::env::var_os(STRANGER) else { return };
    let mut harness = builder(1280.0, 720.0).build_eframe(move |cc| {
        let document = Document::open(path.as_ref()).expect("the session opens");
        Workbench::new(cc, document).expect("a thread starts")
    });
    harness.run_steps(2);
    let mut bench = Bench { harness, folder: tempfile::tempdir().expect("there is room for a folder") };
    bench.settle();
    bench.show(Pane::Summary);
    let began = Instant::now();
    let counts = |bench: &Bench<'_>| VerdictCounts::count(bench.snapshot().verdicts.ready().expect("it was judged"));
    let before = counts(&bench);
    println!("before: {before:?}");
    picture(&mut bench.harness, "must_stranger_before");
    for number in 1..=FIXES {
        let tried: Vec<_> = bench
            .snapshot()
            .inquiries
            .fixes
            .0
            .iter()
            .filter_map(|(fix, slot)| Some((fix.clone(), slot.ready()?.verdict)))
            .collect();
        // The one that leaves least that is bad.
        let best = tried.into_iter().min_by_key(|(_, verdict)| (verdict.bad, verdict.caution));
        let (fix, promised) = best.expect("there is a fix");
        let label = format!("Apply: {}", fix.label);
        bench.harness.get_all_by_label(&label).next().expect("it has a button").scroll_to_me();
        bench.harness.run_steps(3);
        bench.harness.get_all_by_label(&label).next().expect("it has a button").click();
        bench.settle();
        println!("{number}. {}: promised {promised:?}, now {:?}", fix.label, counts(&bench));
        assert_eq!(counts(&bench), promised);
    }
    picture(&mut bench.harness, "must_stranger_after");
    let after = counts(&bench);
    println!("{FIXES} fixes in {:.1} s", began.elapsed().as_secs_f64());
    assert!(after.bad < before.bad || after.level < before.level, "{before:?} {after:?}");
    assert_eq!(bench.harness.state().document.history.steps().0.len(), FIXES, "one step of undo each");
}
