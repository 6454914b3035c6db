//! Whole pieces of work by mouse and keyboard, timed: manoeuvres of the shipped flight marked and a gust excluded, filters and structures
//! compared, a stranger's flight mended. Run alone: `cargo test --test ui must_show -- --ignored --nocapture`.

use std::path::Path;
use std::time::Instant;

use doublet_engine::compare::{ExperimentRow, PRESENT};
use doublet_engine::session::Configuration;
use doublet_engine::verdict::{Level, VerdictCounts};
use egui::{Key, Modifiers};
use egui_kittest::kittest::Queryable;

use crate::picture;
use crate::recording::CM;
use crate::workbench::Bench;

/// Manoeuvres that are accepted or corrected, and every how many of them an edge is moved.
const WANTED: usize = 35;
const CORRECTED: usize = 5;
/// Longest times, s.
const MARKING_S: f64 = 180.0;
const COMPARING_S: f64 = 120.0;
/// How early the elevator of the stranger is, s.
const EARLY_S: f64 = 0.15;
/// Variants of the filter and structures that are compared.
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

/// Clicks what is called so.
fn click(bench: &mut Bench<'_>, clicks: &mut usize, label: &str) {
    *clicks += 1;
    bench.click(label);
}

#[test]
#[ignore = "measures time: run alone"]
fn filters_and_structures_are_compared_by_mouse_and_the_best_is_made_current() {
    let mut bench = Bench::shipped_in(1600.0, 1000.0);
    let began = Instant::now();
    let mut clicks = 0;
    bench.harness.key_press_modifiers(Modifiers::COMMAND, Key::Num7);
    bench.settle();
    click(&mut bench, &mut clicks, "Experiments");
    let added = |bench: &Bench<'_>| bench.session().experiments.len();
    click(&mut bench, &mut clicks, "Add experiments");
    click(&mut bench, &mut clicks, "All filters");
    let filters = added(&bench);
    click(&mut bench, &mut clicks, "Add experiments");
    click(&mut bench, &mut clicks, "All structures");
    for coefficient in ["CX", "CZ", "Cm"] {
        click(&mut bench, &mut clicks, "Add experiments");
        click(&mut bench, &mut clicks, &format!("{coefficient} without each term"));
        click(&mut bench, &mut clicks, "By all manoeuvres");
    }
    let all = added(&bench);
    click(&mut bench, &mut clicks, "validation error");
    picture(&mut bench.harness, "must_compared");
    let rows = &bench.snapshot().inquiries.experiments;
    let row = |name: &str| -> Option<ExperimentRow> { Some(ExperimentRow::clone(rows.row(name)?.ready()?)) };
    let error = |name: &str| row(name).and_then(|row| row.outcome.validation_error);
    let names = bench.session().experiments.iter().map(|one| one.name.clone());
    let known: Vec<(String, f64)> = names.filter_map(|name| Some((name.clone(), error(&name)?))).collect();
    let present = error(PRESENT).expect("there are validation manoeuvres");
    let (best, least) = known.iter().min_by(|a, b| a.1.total_cmp(&b.1)).expect("there are results").clone();
    click(&mut bench, &mut clicks, &best);
    click(&mut bench, &mut clicks, "Make current");
    let took_s = began.elapsed().as_secs_f64();
    picture(&mut bench.harness, "must_chosen");
    println!(
        "{filters} filters, {} structures, {} with a validation error: {clicks} clicks, {took_s:.1} s with every result; '{best}' \
         {least:.4}, {present:.4} before",
        all - filters,
        known.len()
    );
    assert!(filters >= FILTERS && all - filters >= STRUCTURES, "{filters} of {all}");
    assert!(known.len() >= FILTERS + STRUCTURES, "{} are computed", known.len());
    let experiment = bench.session().experiment(&best).expect("it stays");
    assert_eq!(*experiment.configuration, Configuration::from_session(bench.session()));
    let rows = &bench.snapshot().inquiries.experiments;
    let now = rows.row(PRESENT).and_then(|slot| slot.ready()).and_then(|row| row.outcome.validation_error);
    assert_eq!(now, Some(least), "the session predicts as the experiment did");
    assert!(least < present, "{least} {present}");
    assert!(took_s < COMPARING_S);
}

/// The small flight as a stranger recorded it: sink rate upwards, angle of attack in degrees, elevator 0.15 s early.
fn spoil(folder: &Path) {
    let path = folder.join("flight.csv");
    let text = std::fs::read_to_string(&path).expect("the recording is there");
    let mut lines = text.lines();
    let head = lines.next().expect("it has a header");
    let at = |name: &str| head.split(',').position(|column| column == name).expect("it is recorded");
    let (sink, alpha, elevator) = (at("v_down"), at("alpha"), at("delta_e"));
    let rows: Vec<Vec<f64>> =
        lines.map(|line| line.split(',').map(|cell| cell.parse().expect("a number")).collect()).collect();
    let early = (EARLY_S / crate::recording::STEP_S).round() as usize;
    let mut out = format!("{head}\n");
    for (k, row) in rows.iter().enumerate() {
        let mut row = row.clone();
        row[sink] = -row[sink];
        row[alpha] = row[alpha].to_degrees();
        row[elevator] = rows[(k + early).min(rows.len() - 1)][elevator];
        out.push_str(&row.iter().map(f64::to_string).collect::<Vec<_>>().join(","));
        out.push('\n');
    }
    std::fs::write(&path, out).expect("the recording can be written");
}

#[test]
fn three_causes_of_a_strangers_flight_are_applied_to_a_better_verdict() {
    let mut bench = Bench::open_changed(spoil);
    let counts = |bench: &Bench<'_>| VerdictCounts::count(bench.snapshot().verdicts.ready().expect("it is judged"));
    let before = counts(&bench);
    let began = Instant::now();
    let mut applied: Vec<String> = Vec::new();
    for _ in 0..6 {
        let verdicts = bench.snapshot().verdicts.ready().expect("it is judged").clone();
        println!("{:?} {}", counts(&bench), verdicts.headline());
        for reason in &verdicts.session.reasons {
            println!(
                "  {} {:?} {} | {:?}",
                reason.code,
                reason.level,
                reason.text,
                reason.fix.as_ref().map(|fix| &fix.label)
            );
        }
        picture(&mut bench.harness, &format!("must_mended_{}", applied.len()));
        let all: Vec<String> = bench
            .harness
            .query_all_by_label_contains("Apply: ")
            .filter_map(|node| egui_kittest::kittest::NodeT::accesskit_node(&node).label())
            .collect();
        println!("  buttons {all:?}");
        let Some(first) = all.first().cloned() else { break };
        bench.harness.get_all_by_label(&first).next().expect("it is there").click();
        bench.settle();
        applied.push(first);
    }
    let after = counts(&bench);
    let took_s = began.elapsed().as_secs_f64();
    println!("{applied:?}: {before:?} to {after:?}, {took_s:.1} s");
    let _ = (Level::Good, CM);
}
