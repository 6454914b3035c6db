//! Windows dragged on the traces and remarked on in their table: where their edges land, to the last digit.

use std::path::Path;

use doublet::command::{EditCommand, FileCommand, UiCommand, ViewCommand};
use doublet::panels::Pane;
use doublet_core::series::TimeRange;
use doublet_engine::session::{Edit, WindowEdit};
use egui::accesskit::Role;
use egui::{Key, Modifiers, Pos2, pos2};
use egui_kittest::kittest::{NodeT, Queryable};

use crate::recording::STEP_S;
use crate::workbench::Bench;
use crate::{click, drag, hold, picture, secondary_click};

/// Elevator doublet: its first sample, its change of side and the first sample at rest again, s.
const DOUBLET_S: [f64; 3] = [44.0, 45.0, 46.0];
/// Last sample before the gap and first one after it, s.
const GAP_S: [f64; 2] = [31.0, 33.0];
/// Longest free response a proposal has, s: the motion of this flight never dies down.
const FREE_S: f64 = 10.0;
/// A time that was rounded to a tenth or read from text.
const ROUNDING_S: f64 = 1e-9;

/// Lets the elevator rest from 27 s on but for a doublet, and leaves out what lies in the gap.
fn fly_a_doublet(folder: &Path) {
    let path = folder.join("flight.csv");
    let text = std::fs::read_to_string(&path).expect("the recording is there");
    let line = |line: &str| {
        let time = line.split(',').next().and_then(|time| time.parse::<f64>().ok());
        let Some(time) = time.filter(|&time| time > 27.0) else { return format!("{line}\n") };
        if time > GAP_S[0] + 0.5 * STEP_S && time < GAP_S[1] - 0.5 * STEP_S {
            return String::new();
        }
        let [up, down, rest] = DOUBLET_S.map(|at| time > at - 0.5 * STEP_S);
        let elevator = if rest || !up {
            0.0
        } else if down {
            -0.05
        } else {
            0.05
        };
        let kept = line.rsplit_once(',').map_or(line, |(kept, _)| kept);
        format!("{kept},{elevator}\n")
    };
    std::fs::write(&path, text.lines().map(line).collect::<String>()).expect("the recording can be written");
}

/// The workbench on a flight with a doublet and a gap, its window from 5 s to 25 s chosen.
pub(crate) fn bench<'a>() -> Bench<'a> {
    Bench::open_changed(fly_a_doublet)
}

impl Bench<'_> {
    /// Where the lane shows `time_s`.
    pub(crate) fn at_s(&self, time_s: f64) -> Pos2 {
        let place = |name: &str| self.harness.get_by_role_and_label(Role::Button, name).rect().center();
        let (start, end) = (place("first start"), place("first end"));
        let TimeRange { start_s, end_s } = self.first();
        let share = ((time_s - start_s) / (end_s - start_s)) as f32;
        pos2(
            start.x + share * (end.x - start.x),
            self.harness.get_by_role_and_label(Role::Button, "first").rect().center().y,
        )
    }

    /// The window that is dragged.
    pub(crate) fn first(&self) -> TimeRange {
        self.session().window("first").expect("it is in the session").window
    }

    fn place_first(&mut self, start_s: f64, end_s: f64) {
        let place = WindowEdit::Place { name: "first".to_owned(), window: TimeRange { start_s, end_s } };
        self.harness.state_mut().apply(&Edit::Window(place));
        self.settle();
    }

    /// Drags from the lane at one time to `off` points beside another.
    fn drag_s(&mut self, from_s: f64, to_s: f64, off: f32) {
        let (from, to) = (self.at_s(from_s), self.at_s(to_s) + egui::vec2(off, 0.0));
        drag(&mut self.harness, from, to, 6);
        self.settle();
    }
}

#[test]
fn edges_dragged_near_onset_end_and_gap_land_on_them() {
    let mut bench = bench();
    let found = bench.snapshot().proposals["flight"].ready().expect("the flight was looked through").windows.clone();
    let onset_s = DOUBLET_S[0] - STEP_S;
    let of_doublet = found.iter().find(|found| (found.onset_s - onset_s).abs() < ROUNDING_S);
    let end_s = of_doublet.expect("the doublet is found").manoeuvre.window.end_s;
    assert!((end_s - DOUBLET_S[2] - FREE_S).abs() < ROUNDING_S, "{end_s}");
    // From 5 s to 25 s: the end to the last sample before the gap, 6 points short of it.
    bench.drag_s(25.0, GAP_S[0], -6.0);
    assert!((bench.first().end_s - GAP_S[0]).abs() < ROUNDING_S, "{:?}", bench.first());
    assert_eq!(bench.first().start_s, 5.0);
    // On to where the motion ends, then the start to the onset of the doublet.
    bench.drag_s(GAP_S[0], end_s, 5.0);
    assert_eq!(bench.first().end_s, end_s);
    bench.drag_s(5.0, onset_s, -5.0);
    assert!((bench.first().start_s - onset_s).abs() < ROUNDING_S, "{:?}", bench.first());
    assert_eq!(bench.first().end_s, end_s);
}

#[test]
fn alt_drags_by_samples_alone_and_so_does_a_drag_that_is_not_near() {
    let mut bench = bench();
    let shown_s = |bench: &Bench<'_>, by: f32| {
        let per_s = bench.at_s(25.0).x - bench.at_s(24.0).x;
        f64::from(by / per_s)
    };
    let short_s = shown_s(&bench, 6.0);
    assert!(short_s > 3.0 * STEP_S, "the drag ends some samples before the gap: {short_s} s");
    bench.harness.event(egui::Event::ModifiersChanged(Modifiers::ALT));
    bench.drag_s(25.0, GAP_S[0], -6.0);
    bench.harness.event(egui::Event::ModifiersChanged(Modifiers::NONE));
    let free = bench.first().end_s;
    assert!((free - (GAP_S[0] - short_s)).abs() < STEP_S, "{free}, {short_s} s short");
    let samples = free / STEP_S;
    assert!((samples - samples.round()).abs() < 1e-6, "{samples} is a sample");
    bench.place_first(5.0, 25.0);
    bench.drag_s(25.0, GAP_S[0], -12.0);
    assert!((bench.first().end_s - (GAP_S[0] - 2.0 * short_s)).abs() < STEP_S, "{:?}", bench.first());
}

#[test]
fn a_band_snaps_by_either_edge_to_a_marker_or_another_window_with_its_length_kept() {
    let mut bench = bench();
    let other = doublet_engine::session::Manoeuvre {
        name: "other".to_owned(),
        window: TimeRange { start_s: 53.123, end_s: 58.0 },
        ..bench.session().windows[0].clone()
    };
    bench.harness.state_mut().apply(&Edit::Window(WindowEdit::Add(other)));
    bench.harness.state_mut().state.time.markers_s[0] = Some(9.877);
    bench.settle();
    // 4 points past the marker.
    let to = bench.at_s(9.877 + 10.0) + egui::vec2(4.0, 0.0);
    let from = bench.at_s(15.0);
    hold(&mut bench.harness, from, to, 6);
    assert!(bench.harness.query_by_label("marker A").is_some(), "it says what it snapped to");
    picture(&mut bench.harness, "snapped");
    bench.harness.drop_at(to);
    bench.settle();
    assert!(bench.harness.query_by_label("marker A").is_none(), "the word goes with the drag");
    assert_eq!(bench.first().start_s, 9.877);
    assert!((bench.first().end_s - 29.877).abs() < ROUNDING_S);
    // The end to the other window's start, which lies between samples and near onsets of what moves.
    let from_s = 20.0;
    bench.drag_s(from_s, from_s + 53.123 - 29.877, 0.0);
    assert_eq!(bench.first().end_s, 53.123);
    assert!((bench.first().start_s - 33.123).abs() < ROUNDING_S);
    bench.request(UiCommand::View(ViewCommand::ClearMarkers));
}

#[test]
fn note_typed_in_the_table_shows_over_the_band_and_in_the_results_and_changes_none_of_them() {
    let mut bench = bench();
    bench.show(Pane::Manoeuvres);
    let estimate = bench.snapshot().pooled.ready().expect("the estimate is up to date").clone();
    bench.retype("note of first", "  rough air from 20 s ", Key::Enter);
    assert_eq!(bench.session().window("first").expect("it is there").note, "rough air from 20 s");
    let after = bench.snapshot().pooled.ready().expect("the estimate is up to date").clone();
    assert!(std::sync::Arc::ptr_eq(&estimate, &after), "nothing is estimated anew for a note");
    let shown = |bench: &Bench<'_>| bench.harness.query_all_by_label_contains("rough air from 20 s").count();
    bench.harness.hover_at(pos2(2.0, 2.0));
    bench.harness.run_steps(5);
    let at_rest = shown(&bench);
    let at = bench.at_s(15.0);
    bench.harness.hover_at(at);
    bench.harness.run_steps(30);
    assert_eq!(shown(&bench), at_rest + 1, "hovering over the band shows it");
    picture(&mut bench.harness, "note");
    bench.request(UiCommand::File(FileCommand::Export));
    bench.choose("Save");
    let table = std::fs::read_to_string(bench.folder.path().join("results/windows.csv")).expect("it is written");
    let rows: Vec<&str> = table.lines().collect();
    assert!(rows[0].ends_with(",note") && rows[1].ends_with(",rough air from 20 s"), "{table}");
    bench.request(UiCommand::Edit(EditCommand::Undo));
    assert_eq!(bench.session().window("first").expect("it is there").note, "");
}

#[test]
fn window_looked_at_is_confirmed_by_a_click_and_one_undo_takes_it_back() {
    let mut bench = bench();
    bench.show(Pane::Manoeuvres);
    bench.click("confirmation of first");
    let first = bench.session().window("first").expect("it is there").clone();
    assert_eq!((first.flags.confirmed, first.flags.locked), (true, false));
    assert!(doublet_engine::session::print(bench.session()).expect("it prints").contains("confirmed = true"));
    bench.request(UiCommand::Edit(EditCommand::Undo));
    assert!(!bench.session().window("first").expect("it is there").flags.confirmed);
}

#[test]
fn locked_edges_stay_where_they_are_when_dragged_and_go_where_they_are_typed() {
    let mut bench = bench();
    bench.show(Pane::Manoeuvres);
    let was = bench.first();
    let [end, body, free] = [25.0, 15.0, 28.0].map(|at_s| bench.at_s(at_s));
    let edge_in_plot = end + egui::vec2(0.0, 60.0);
    bench.click("lock of first");
    assert!(bench.session().window("first").expect("it is there").flags.locked);
    for (from, by) in [(end, 40.0), (body, 40.0), (edge_in_plot, 40.0)] {
        let range = bench.harness.state().state.time.range();
        drag(&mut bench.harness, from, from + egui::vec2(by, 0.0), 6);
        bench.settle();
        assert_eq!(bench.first(), was, "a drag from {from:?}");
        assert_eq!(bench.session().windows.len(), 1, "and none is drawn over it from {from:?}");
        bench.harness.state_mut().state.time.zoom_to(range);
        bench.settle();
    }
    picture(&mut bench.harness, "locked");
    let field = |node: &egui_kittest::Node<'_>| node.accesskit_node().role() != Role::Button;
    let at = bench.harness.get_all_by_label("first end").find(field).expect("there is a field").rect().center();
    drag(&mut bench.harness, at, at + egui::vec2(40.0, 0.0), 6);
    bench.settle();
    assert_eq!(bench.first(), was, "the number in the table is not dragged either");
    bench.enter("first end", "27.5");
    assert_eq!(bench.first(), TimeRange { end_s: 27.5, ..was });
    bench.request(UiCommand::Edit(EditCommand::Undo));
    bench.request(UiCommand::Edit(EditCommand::Undo));
    assert!(!bench.session().window("first").expect("it is there").flags.locked, "no drag left a step of undo");
    secondary_click(&mut bench.harness, body);
    bench.choose_containing("Lock or unlock edges");
    assert!(bench.session().window("first").expect("it is there").flags.locked);
    secondary_click(&mut bench.harness, body);
    bench.choose_containing("Lock or unlock edges");
    assert!(!bench.session().window("first").expect("it is there").flags.locked);
    drag(&mut bench.harness, end, free, 6);
    bench.settle();
    assert!((bench.first().end_s - 28.0).abs() < 2.0 * STEP_S, "free again: {:?}", bench.first());
}

/// Names of the windows in the table, from the first row to the last on screen.
fn rows(bench: &Bench<'_>) -> Vec<String> {
    let mut rows: Vec<(f32, String)> = bench
        .session()
        .windows
        .iter()
        .filter_map(|window| {
            let label = format!("name of {}", window.name);
            let top = bench.harness.query_by_label(&label)?.rect().top();
            Some((top, window.name.clone()))
        })
        .collect();
    rows.sort_by(|a, b| a.0.total_cmp(&b.0));
    rows.into_iter().map(|(_, name)| name).collect()
}

#[test]
fn table_of_windows_is_filtered_by_words_use_and_verdict_and_ordered_by_a_click_on_a_title() {
    let mut bench = Bench::shipped_in(1500.0, 1900.0);
    bench.show(Pane::Manoeuvres);
    let all = bench.session().windows.clone();
    assert_eq!(rows(&bench).len(), all.len(), "all are on screen");
    click(&mut bench.harness, "filter manoeuvres", 2);
    bench.harness.get_by_label("filter manoeuvres").type_text("RUDDER 3-2");
    bench.settle();
    let wanted: Vec<String> = all
        .iter()
        .filter(|w| w.name.contains("rudder") && format!("{} {}", w.name, w.kind).contains("3-2"))
        .map(|w| w.name.clone())
        .collect();
    assert!(!wanted.is_empty() && wanted.len() < all.len());
    assert_eq!(rows(&bench), wanted);
    bench.click("Select these");
    let selected: Vec<_> =
        bench.harness.state().state.selection.windows(bench.session()).map(|w| w.name.clone()).collect();
    assert_eq!(selected, wanted, "they are selected");
    picture(&mut bench.harness, "windows_filtered");
    bench.choose("✖");
    assert_eq!(rows(&bench).len(), all.len());
    let title = |bench: &Bench<'_>, name: &str| {
        let nodes = bench.harness.get_all_by_role(Role::ColumnHeader).collect::<Vec<_>>();
        let named = nodes.iter().find(|node| {
            let node = node.accesskit_node();
            node.value().or_else(|| node.label()).is_some_and(|title| title.starts_with(name))
        });
        named.expect("the table has that column").rect().center()
    };
    let at = title(&bench, "Name");
    drag(&mut bench.harness, at, at, 1);
    bench.settle();
    let mut names: Vec<String> = all.iter().map(|window| window.name.clone()).collect();
    names.sort_by_key(|name| name.to_lowercase());
    assert_eq!(rows(&bench), names);
    drag(&mut bench.harness, at, at, 1);
    bench.settle();
    names.reverse();
    assert_eq!(rows(&bench), names, "a second click turns the order");
    bench.click("worst first");
    let verdicts = bench.snapshot().verdicts.ready().expect("all is judged").clone();
    let levels: Vec<_> =
        rows(&bench).iter().map(|name| verdicts.windows.get(name).map(|of| of.verdict.level)).collect();
    assert!(levels.is_sorted_by(|a, b| a >= b) && levels.first() != levels.last(), "{levels:?}");
    picture(&mut bench.harness, "windows_ordered");
}

#[test]
fn manoeuvre_that_cuts_its_input_says_so_in_its_row() {
    let mut bench = Bench::shipped();
    bench.show(Pane::Manoeuvres);
    bench.settle();
    let is_said = |bench: &Bench<'_>| bench.harness.query_by_label_contains("Cuts its input").is_some();
    assert!(!is_said(&bench));
    let TimeRange { end_s, .. } = bench.session().windows[0].window;
    let input = bench.snapshot().proposals["FT1"].ready().expect("it is looked through").windows[0].clone();
    let window = TimeRange { start_s: 0.5 * (input.onset_s + input.input_end_s), end_s };
    let name = bench.session().windows[0].name.clone();
    bench.harness.state_mut().apply(&Edit::Window(WindowEdit::Place { name, window }));
    bench.settle();
    assert!(is_said(&bench));
    picture(&mut bench.harness, "manoeuvre_cut");
}
