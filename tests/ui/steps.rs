//! From the start page through the steps: layouts, the strip of the whole flight, several windows at once, the tour.

use doublet::app::files::Files;
use doublet::app::{Document, Mark, Workbench, mark};
use doublet::command::{EditCommand, FileCommand, HelpCommand, UiCommand, ViewCommand};
use doublet::layouts::LayoutKey;
use doublet::panels::Pane;
use doublet::step::Step;
use doublet_engine::session::WindowRole;
use doublet_engine::verdict::Level;
use egui::accesskit::Role;
use egui::{Key, Modifiers, pos2};
use egui_kittest::kittest::Queryable;

use crate::workbench::Bench;
use crate::{builder, drag, picture};

/// A window without a session.
fn nothing_open<'a>() -> Bench<'a> {
    let mut harness = builder(1366.0, 768.0).build_eframe(|cc| {
        let mut app = Workbench::new(cc, Workbench::nothing_open()).expect("a thread starts");
        app.files = Files::without_system();
        app
    });
    harness.run_steps(3);
    let mut bench = Bench { harness, folder: tempfile::tempdir().expect("there is room for a folder") };
    bench.settle();
    bench
}

fn shown(bench: &Bench<'_>) -> LayoutKey {
    bench.harness.state().state.shown.key.clone()
}

#[test]
fn window_without_a_session_begins_with_the_start_page_and_opens_what_is_chosen_there() {
    let mut bench = nothing_open();
    assert!(bench.harness.state().is_on_start_page());
    assert!(!bench.harness.state().document.history.is_modified(), "there is nothing to save");
    picture(&mut bench.harness, "start_page");
    bench.choose("open Cessna 337F, simulated flight: doublets and 3-2-1-1 at 4,000 ft and 90 kt");
    assert!(!bench.harness.state().is_on_start_page());
    assert_eq!(bench.harness.state().document.shipped, Some(Document::SHIPPED));
    assert_eq!(shown(&bench), LayoutKey::Step(Step::Results));
    assert!(bench.snapshot().verdicts.ready().is_some());
    bench.request(UiCommand::View(ViewCommand::StartPage));
    let thumbnail = bench.harness.state().state.thumbnails.values().next().expect("it was kept").clone();
    assert_eq!(thumbnail.title, bench.session().title);
    assert_eq!(thumbnail.windows.len(), bench.session().windows.len());
    assert!(thumbnail.altitude.iter().flatten().all(|place| (0.0..=1.0).contains(place)));
    picture(&mut bench.harness, "start_page_again");
    bench.choose_containing("Back to ");
    assert!(!bench.harness.state().is_on_start_page());
}

#[test]
fn every_step_shows_its_layout_and_says_how_far_it_is() {
    let mut bench = Bench::shipped_in(1366.0, 768.0);
    let marks: Vec<Mark> = Step::ALL
        .map(|step| {
            let app = bench.harness.state();
            mark(step, app.document.history.present(), bench.snapshot(), None)
        })
        .to_vec();
    let verdict = bench.snapshot().verdicts.ready().expect("it was judged").session.level;
    assert_eq!((verdict, marks[Step::Results as usize]), (Level::Good, Mark::Done));
    assert_eq!(marks[Step::Model as usize], Mark::Look(Level::Caution), "CX alone is to be looked at, in the model");
    assert_eq!(marks[Step::Recording as usize], Mark::Done);
    assert_eq!(marks[Step::Report as usize], Mark::Open, "none was written");
    for (step, mark) in Step::ALL.into_iter().zip(marks) {
        let label = format!("step {}: {}", step.title(), mark.name());
        bench.harness.get_by_role_and_label(Role::Button, &label).click();
        bench.settle();
        assert_eq!(shown(&bench), LayoutKey::Step(step));
        picture(&mut bench.harness, &format!("step_{}", step.title()));
    }
}

#[test]
fn strip_of_the_flight_chooses_windows_and_moves_what_is_on_screen() {
    let mut bench = Bench::open();
    bench.request(UiCommand::View(ViewCommand::Step(Step::Recording)));
    let strip = bench.harness.get_by_label("timeline of the whole flight").rect();
    let full = bench.harness.state().state.time.full();
    let at = |part: f32| pos2(strip.left() + part * strip.width(), strip.top() + 12.0);
    let range = |bench: &Bench<'_>| bench.harness.state().state.time.range();
    // A new brush over the second quarter.
    drag(&mut bench.harness, at(0.25), at(0.5), 6);
    let drawn = range(&bench);
    let per_point = full.length_s() / f64::from(strip.width());
    assert!((drawn.start_s - full.start_s - 0.25 * full.length_s()).abs() < 3.0 * per_point, "{drawn:?}");
    assert!((drawn.length_s() - 0.25 * full.length_s()).abs() < 3.0 * per_point, "{drawn:?}");
    // Its body moves it, its edge widens it, one step back each.
    drag(&mut bench.harness, at(0.375), at(0.625), 6);
    let moved = range(&bench);
    assert!((moved.length_s() - drawn.length_s()).abs() < 1e-9);
    assert!((moved.start_s - drawn.start_s - 0.25 * full.length_s()).abs() < 3.0 * per_point, "{moved:?}");
    drag(&mut bench.harness, at(0.75), at(0.9), 6);
    let widened = range(&bench);
    assert!((widened.start_s - moved.start_s).abs() < 1e-9 && widened.end_s > moved.end_s + 0.1 * full.length_s());
    bench.request(UiCommand::View(ViewCommand::ZoomBack));
    assert_eq!(range(&bench), moved);
    // The window in the strip brings itself on screen.
    let judged = bench.snapshot().verdicts.ready().expect("it was judged").windows["first"].verdict.level;
    bench.harness.get_by_role_and_label(Role::Button, &format!("timeline first: {}", judged.name())).click();
    bench.settle();
    let window = bench.session().windows[0].window;
    assert!(range(&bench).start_s <= window.start_s && range(&bench).end_s >= window.end_s);
}

/// Clicks a window of the strip with keys held.
fn click_in_strip(bench: &mut Bench<'_>, name: &str, modifiers: Modifiers) {
    let is_block = |label: &str| label.starts_with(&format!("timeline {name}:"));
    let node = bench.harness.get_by(|node| node.label().is_some_and(|label| is_block(&label)));
    let at = node.rect().center();
    bench.harness.hover_at(at);
    bench.harness.step();
    for pressed in [true, false] {
        let button = egui::PointerButton::Primary;
        bench.harness.event_modifiers(egui::Event::PointerButton { pos: at, button, pressed, modifiers }, modifiers);
        bench.harness.step();
    }
    bench.settle();
}

#[test]
fn several_windows_are_selected_used_and_removed_in_one_step_each() {
    let mut bench = Bench::shipped_in(1366.0, 768.0);
    let names: Vec<String> = bench.session().windows.iter().map(|window| window.name.clone()).collect();
    let roles = |bench: &Bench<'_>| bench.session().windows.iter().map(|window| window.role).collect::<Vec<_>>();
    let before = roles(&bench);
    assert!(before[..4].iter().all(|role| *role == WindowRole::Identification));
    click_in_strip(&mut bench, &names[0], Modifiers::NONE);
    click_in_strip(&mut bench, &names[3], Modifiers::SHIFT);
    click_in_strip(&mut bench, &names[1], Modifiers::COMMAND);
    let selection = bench.harness.state().state.selection.clone();
    let selected: Vec<&str> = selection.windows(bench.session()).map(|window| window.name.as_str()).collect();
    assert_eq!(selected, [names[0].as_str(), &names[2], &names[3]]);
    bench.harness.key_press(Key::V);
    bench.settle();
    let mut expected = before.clone();
    [0, 2, 3].into_iter().for_each(|at| expected[at] = WindowRole::Validation);
    assert_eq!(roles(&bench), expected);
    bench.show(Pane::Manoeuvres);
    assert!(bench.harness.query_by_label("3 selected:").is_some());
    picture(&mut bench.harness, "several_windows");
    bench.request(UiCommand::Edit(EditCommand::Undo));
    assert_eq!(roles(&bench), before, "one step of undo");
    bench.harness.key_press(Key::Delete);
    bench.settle();
    assert_eq!(bench.session().windows.len(), names.len() - 3);
    bench.request(UiCommand::Edit(EditCommand::Undo));
    assert_eq!(bench.session().windows.len(), names.len());
}

#[test]
fn removed_window_leaves_the_nearest_one_chosen_and_undo_does_not_jump_to_the_first() {
    let mut bench = Bench::shipped_in(1366.0, 768.0);
    let names: Vec<String> = bench.session().windows.iter().map(|window| window.name.clone()).collect();
    click_in_strip(&mut bench, &names[20], Modifiers::NONE);
    bench.harness.key_press(Key::Delete);
    bench.settle();
    let chosen = bench.harness.state().state.selection.window.clone().expect("one is chosen");
    assert!([&names[19], &names[21]].contains(&&chosen), "{chosen}");
}

#[test]
fn layout_is_kept_under_a_name_and_found_in_the_menu() {
    let mut bench = Bench::open();
    bench.request(UiCommand::View(ViewCommand::Step(Step::Model)));
    bench.request(UiCommand::View(ViewCommand::KeepLayout));
    bench.harness.get_by_label("name of the layout").type_text("my model");
    bench.harness.run_steps(2);
    bench.choose("Keep");
    assert_eq!(shown(&bench), LayoutKey::Named("my model".to_owned()));
    bench.request(UiCommand::View(ViewCommand::Step(Step::Filter)));
    bench.harness.get_by_role_and_label(Role::Button, "Layout").click();
    bench.harness.run_steps(3);
    bench.harness.get_by_role_and_label(Role::Button, "my model").click();
    bench.settle();
    assert_eq!(shown(&bench), LayoutKey::Named("my model".to_owned()));
    assert!(bench.harness.state().state.shown.holds(Pane::Model));
}

#[test]
fn tour_passes_every_step_with_the_panel_it_speaks_of_on_screen() {
    let mut bench = nothing_open();
    bench.choose("Five-minute tour");
    let mut visited = Vec::new();
    while let Some(stop) = bench.harness.state().tour_stop() {
        assert_eq!(stop, visited.len());
        let LayoutKey::Step(step) = shown(&bench) else { panic!("a stop is at a step") };
        visited.push(step);
        picture(&mut bench.harness, &format!("tour_{stop}"));
        let next = bench.harness.query_by_label("Next stop").is_some();
        bench.choose(if next { "Next stop" } else { "End the tour" });
    }
    for step in [Step::Recording, Step::Channels, Step::Aircraft, Step::Manoeuvres, Step::Filter, Step::Model] {
        assert!(visited.contains(&step), "{}", step.title());
    }
    assert_eq!((visited[0], visited.last()), (Step::Results, Some(&Step::Report)));
    bench.request(UiCommand::Help(HelpCommand::Tour));
    assert_eq!(bench.harness.state().tour_stop(), Some(0));
    bench.harness.key_press(Key::Escape);
    bench.settle();
    assert_eq!(bench.harness.state().tour_stop(), None, "Escape ends it");
    bench.harness.key_press_modifiers(Modifiers::ALT, Key::Home);
    bench.settle();
    assert!(bench.harness.state().is_on_start_page(), "Home alone would show the whole recording");
}

/// The pictures of the shipped flights, and the variable that asks for them to be written anew.
const SHIPPED_FLIGHTS: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/src/app/shipped_flights.json");
const WRITE: &str = "DOUBLET_WRITE_SHIPPED_FLIGHTS";

#[test]
fn pictures_of_the_shipped_flights_are_those_their_sessions_give_and_stand_on_the_first_start_page() {
    let mut bench = nothing_open();
    let mut found = std::collections::BTreeMap::new();
    for name in doublet_engine::builtin::sessions() {
        bench.request(UiCommand::File(FileCommand::OpenShippedSession(name)));
        bench.request(UiCommand::View(ViewCommand::StartPage));
        let key = std::path::PathBuf::from(format!("{}{name}", doublet_engine::builtin::PREFIX));
        let mut thumbnail = bench.harness.state().state.thumbnails[&key].clone();
        thumbnail.opened.clear();
        found.insert(name.to_owned(), thumbnail);
    }
    if std::env::var_os(WRITE).is_some() {
        let text = serde_json::to_string(&found).expect("it can be written") + "\n";
        std::fs::write(SHIPPED_FLIGHTS, text).expect("the file can be written");
    }
    let shipped = std::fs::read_to_string(SHIPPED_FLIGHTS).expect("it is there");
    let shipped: std::collections::BTreeMap<String, doublet::ui_state::Thumbnail> =
        serde_json::from_str(&shipped).expect("it can be read");
    assert_eq!(shipped.keys().collect::<Vec<_>>(), found.keys().collect::<Vec<_>>());
    for (name, one) in &found {
        let known = &shipped[name];
        assert_eq!((&known.title, &known.verdict), (&one.title, &one.verdict), "write it anew by {WRITE}");
        let pairs = known.windows.iter().zip(&one.windows).chain(known.altitude.iter().zip(&one.altitude));
        assert_eq!((known.windows.len(), known.altitude.len()), (one.windows.len(), one.altitude.len()));
        assert!(pairs.flat_map(|(a, b)| a.iter().zip(b)).all(|(a, b)| (a - b).abs() < 1e-3), "{name}");
    }
    let mut first = nothing_open();
    for (size, name) in [([1280.0, 720.0], "start_first_1280"), ([1600.0, 1000.0], "start_first_1600")] {
        first.harness.set_size(egui::vec2(size[0], size[1]));
        first.harness.run_steps(3);
        picture(&mut first.harness, name);
    }
    assert!(first.harness.query_by_label_contains("not opened yet").is_none(), "each has its picture");
    assert!(first.harness.query_all_by_label_contains("Complete analysis").next().is_some());
    assert_eq!(crate::painted::faults(&first), [""; 0]);
}
