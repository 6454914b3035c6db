//! Whole pieces of work by mouse and keyboard, timed: manoeuvres of the shipped flight marked and a gust excluded, filters and structures
//! compared, a stranger's flight mended. Run alone: `cargo test --test ui must_show -- --ignored --nocapture`.

use std::path::{Path, PathBuf};
use std::time::Instant;

use doublet::command::{EditCommand, UiCommand};
use doublet_core::model::Lag;
use doublet_engine::builtin;
use doublet_engine::compare::{ExperimentRow, PRESENT};
use doublet_engine::session::{self, Configuration, Edit, EstimationEdit, Fix, MapRef, Surface};
use doublet_engine::verdict::{Level, VerdictCounts};
use egui::{Key, Modifiers};
use egui_kittest::kittest::Queryable;

use crate::picture;
use crate::workbench::Bench;

/// Manoeuvres that are accepted or corrected, and every how many of them an edge is moved.
const WANTED: usize = 35;
const CORRECTED: usize = 5;
/// Longest times, s.
const MARKING_S: f64 = 180.0;
const COMPARING_S: f64 = 120.0;
/// How much too long the elevator's delay is, s, and the causes that are mended.
const LATE_S: f64 = 0.1;
const CAUSES: usize = 3;
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
    clicks += 1;
    bench.press("Experiments");
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

/// The shipped flight as a stranger made a session of it: climb rate taken for sink rate, knots for m/s, a delay of the elevator too long.
fn spoil(folder: &Path) {
    let mut session = session::parse(builtin::session("demo").expect("it is shipped")).expect("it can be read");
    let map = builtin::text("channel_maps", "demo_flight").expect("it is shipped");
    let mut map: toml::Table = toml::from_str(map).expect("it can be read");
    let roles = map["roles"].as_table_mut().expect("it has roles");
    roles["v_down"].as_table_mut().expect("a row").remove("sign");
    roles["airspeed"].as_table_mut().expect("a row").insert("unit".to_owned(), "m/s".into());
    let text = toml::to_string(&map).expect("it can be written");
    for recording in session.flights.iter_mut().flat_map(|flight| &mut flight.recordings) {
        recording.channel_map = MapRef::Own(text.clone().into());
    }
    let lag = session.preparation.control_lags.get(Surface::Elevator);
    let late = Lag { delay_s: lag.delay_s + LATE_S, ..lag };
    let edit = Edit::Estimation(EstimationEdit::ControlLag(Surface::Elevator, late));
    let session = edit.apply(&session).expect("it applies");
    std::fs::write(folder.join("session.toml"), session::print(&session).expect("it can be written"))
        .expect("there is room");
}

fn counts(bench: &Bench<'_>) -> VerdictCounts {
    VerdictCounts::count(bench.snapshot().verdicts.ready().expect("it is judged"))
}

/// Clicks the button of the worst cause on the summary, `CAUSES` times at most; gives the fixes, and how many clicks they were.
fn apply_causes(bench: &mut Bench<'_>) -> (Vec<String>, usize) {
    let (mut applied, mut clicks): (Vec<String>, usize) = (Vec::new(), 0);
    while clicks < CAUSES {
        // The causes of one kind that are as bad have one button.
        let verdicts = bench.snapshot().verdicts.ready().expect("it is judged").clone();
        let causes = verdicts.session.reasons.iter().filter(|reason| ["physics", "timing"].contains(&reason.code));
        let causes: Vec<_> = causes.filter_map(|reason| Some((reason, reason.fix.as_ref()?))).collect();
        let Some((first, _)) = causes.iter().max_by_key(|(one, _)| (one.level, one.code == "physics")) else { break };
        let same = causes.iter().filter(|(one, _)| (one.code, one.level) == (first.code, first.level));
        let mut fixes: Vec<&Fix> = Vec::new();
        for (_, fix) in same {
            if fixes.iter().all(|known| known.edits != fix.edits) {
                fixes.push(fix);
            }
        }
        picture(&mut bench.harness, &format!("must_mended_{clicks}"));
        let label = format!("Apply: {}", Fix::join(&fixes).expect("there is one").label);
        let button = |bench: &Bench<'_>, act: &dyn Fn(&egui_kittest::Node<'_>)| {
            // The same fix may stand at a derivative as well.
            act(&bench.harness.get_all_by_label(&label).next().expect("the finding has its button"));
        };
        button(bench, &|node| node.scroll_to_me());
        bench.harness.run_steps(3);
        button(bench, &|node| node.click());
        bench.settle();
        // The list is drawn anew once the pointer has left it.
        bench.harness.hover_at(egui::pos2(2.0, 2.0));
        bench.harness.run_steps(3);
        clicks += 1;
        applied.extend(fixes.iter().map(|fix| fix.label.clone()));
    }
    (applied, clicks)
}

#[test]
#[ignore = "measures time: run alone"]
fn three_causes_of_a_strangers_flight_are_applied_to_a_better_verdict() {
    let began = Instant::now();
    let mut bench = Bench::open_changed(spoil);
    let delay_s = |bench: &Bench<'_>| bench.session().preparation.control_lags.get(Surface::Elevator).delay_s;
    let (before, delayed_s) = (counts(&bench), delay_s(&bench));
    let opened_s = began.elapsed().as_secs_f64();
    let (applied, clicks) = apply_causes(&mut bench);
    let after = counts(&bench);
    picture(&mut bench.harness, "must_mended");
    let took_s = began.elapsed().as_secs_f64();
    println!(
        "{applied:?} in {clicks} clicks: {before:?} to {after:?}, {took_s:.1} s, {opened_s:.1} s of them to open it"
    );
    assert!(applied.len() >= CAUSES, "{applied:?}");
    assert!((delayed_s - LATE_S - delay_s(&bench)).abs() < 0.01, "{} s", delay_s(&bench));
    assert_eq!((before.level, after.level, after.bad), (Level::Bad, Level::Good, 0));
    assert!(after.good > before.good + 10, "{before:?} {after:?}");
    bench.request(UiCommand::Edit(EditCommand::Undo));
    bench.settle();
    assert_ne!(counts(&bench), after, "one step");
}

#[test]
#[ignore = "needs a session in DOUBLET_CAUSES: run alone"]
fn causes_of_any_session_are_applied_to_a_better_verdict() {
    let Some(path) = std::env::var_os("DOUBLET_CAUSES").map(PathBuf::from) else {
        println!("no session in DOUBLET_CAUSES");
        return;
    };
    let began = Instant::now();
    let original = path.parent().expect("it is in a folder").to_owned();
    let mut bench = Bench::open_changed(|folder| {
        for entry in std::fs::read_dir(&original).expect("its folder can be read").flatten() {
            if entry.path().is_file() {
                std::fs::copy(entry.path(), folder.join(entry.file_name())).expect("there is room");
            }
        }
        std::fs::copy(&path, folder.join("session.toml")).expect("there is room");
    });
    let before = counts(&bench);
    let opened_s = began.elapsed().as_secs_f64();
    let (applied, clicks) = apply_causes(&mut bench);
    let (after, took_s) = (counts(&bench), began.elapsed().as_secs_f64());
    picture(&mut bench.harness, "must_applied");
    println!(
        "{applied:?} in {clicks} clicks: {before:?} to {after:?}, {took_s:.1} s, {opened_s:.1} s of them to open it"
    );
    assert!(after.level < before.level || after.bad < before.bad, "{before:?} {after:?}");
}
