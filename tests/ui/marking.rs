//! Manoeuvres marked in the plots by drags, keys and menus, and candidates taken one by one.

use doublet::command::{EditCommand, MarkCommand, UiCommand};
use doublet::panels::Pane;
use doublet_core::series::TimeRange;
use doublet_engine::session::{Edit, Manoeuvre, WindowEdit};
use egui::{Key, Modifiers, Pos2, vec2};
use egui_kittest::kittest::Queryable;

use crate::manoeuvres::bench;
use crate::recording::STEP_S;
use crate::workbench::Bench;
use crate::{drag, hold, picture, secondary_click};

const ALT_SHIFT: Modifiers = Modifiers::ALT.plus(Modifiers::SHIFT);
const CTRL: Modifiers = Modifiers { ctrl: true, command: true, ..Modifiers::NONE };

impl Bench<'_> {
    /// A place in the first plot of the flight.
    fn in_plot(&self, time_s: f64) -> Pos2 {
        self.at_s(time_s) + vec2(0.0, 70.0)
    }

    fn held(&mut self, modifiers: Modifiers, act: impl FnOnce(&mut Self)) {
        self.harness.event(egui::Event::ModifiersChanged(modifiers));
        act(self);
        self.harness.event(egui::Event::ModifiersChanged(Modifiers::NONE));
        self.settle();
    }

    fn mark(&mut self, modifiers: Modifiers, from_s: f64, to_s: f64) {
        let (from, to) = (self.in_plot(from_s), self.in_plot(to_s));
        self.held(modifiers, |bench| drag(&mut bench.harness, from, to, 6));
    }

    /// Presses a key with the pointer at a time.
    fn press_at(&mut self, time_s: f64, key: Key) {
        self.harness.hover_at(self.in_plot(time_s));
        self.harness.run_steps(2);
        self.harness.key_press(key);
        self.settle();
    }

    fn window(&self, at: usize) -> Manoeuvre {
        self.session().windows[at].clone()
    }

    fn undo(&mut self) {
        self.request(UiCommand::Edit(EditCommand::Undo));
    }
}

/// Whether two times are a few points of the screen apart at most.
fn is_near(time_s: f64, expected_s: f64) -> bool {
    (time_s - expected_s).abs() < 3.0 * STEP_S
}

fn covers(part: TimeRange, start_s: f64, end_s: f64) -> bool {
    is_near(part.start_s, start_s) && is_near(part.end_s, end_s)
}

#[test]
fn ctrl_drag_in_a_plot_makes_a_manoeuvre_of_what_it_covers_and_escape_gives_it_up() {
    let mut bench = bench();
    let range = bench.harness.state().state.time.range();
    bench.mark(CTRL, 36.0, 42.0);
    assert_eq!(bench.session().windows.len(), 2);
    assert!(covers(bench.window(1).window, 36.0, 42.0), "{:?}", bench.window(1).window);
    assert_eq!(bench.harness.state().state.selection.window.as_deref(), Some(bench.window(1).name.as_str()));
    assert_eq!(bench.harness.state().state.time.range(), range, "nothing is panned");
    bench.undo();
    assert_eq!(bench.session().windows.len(), 1);
    let (from, to) = (bench.in_plot(36.0), bench.in_plot(42.0));
    bench.held(CTRL, |bench| {
        hold(&mut bench.harness, from, to, 6);
        bench.harness.key_press(Key::Escape);
        bench.harness.run_steps(2);
        bench.harness.drop_at(to);
    });
    assert_eq!(bench.session().windows.len(), 1, "Escape gives it up");
}

#[test]
fn alt_drag_leaves_a_part_out_of_filter_and_fits_and_alt_shift_takes_it_in_again() {
    let mut bench = bench();
    let samples = |bench: &Bench<'_>| {
        let results = &bench.snapshot().windows["first"];
        let aero = results.aero.ready().expect("there are coefficients");
        let path = &results.path.ready().expect("there is a path").reconstruction;
        let updates = path.update_time_s.iter().zip(&path.nis).filter(|(_, nis)| nis.is_finite());
        let inside = |time_s: f64| (12.1..15.9).contains(&time_s);
        (
            aero.coefficients.time_s.iter().filter(|time_s| inside(**time_s)).count(),
            updates.filter(|(time_s, _)| inside(**time_s)).count(),
        )
    };
    let (rows, updates) = samples(&bench);
    assert!(rows > 10 && updates > 10);
    let from = bench.in_plot(12.0);
    let to = bench.in_plot(16.0);
    bench.held(Modifiers::ALT, |bench| {
        hold(&mut bench.harness, from, to, 6);
        picture(&mut bench.harness, "excluding");
        bench.harness.drop_at(to);
        bench.harness.run_steps(2);
    });
    let [part] = bench.window(0).excluded[..] else { panic!("{:?}", bench.window(0).excluded) };
    assert!(covers(part, 12.0, 16.0), "{part:?}");
    assert_eq!(samples(&bench), (0, 0));
    picture(&mut bench.harness, "excluded");
    bench.mark(ALT_SHIFT, 14.0, 18.0);
    let [part] = bench.window(0).excluded[..] else { panic!("{:?}", bench.window(0).excluded) };
    assert!(covers(part, 12.0, 14.0), "{part:?}");
    bench.request(UiCommand::Mark(MarkCommand::Include));
    assert!(bench.window(0).excluded.is_empty());
    assert_eq!(samples(&bench), (rows, updates));
    (0..3).for_each(|_| bench.undo());
    assert!(bench.window(0).excluded.is_empty());
    assert_eq!(bench.harness.state().document.history.undo_label(), None, "each was one step");
    bench.mark(Modifiers::ALT, 38.0, 40.0);
    assert!(bench.window(0).excluded.is_empty(), "outside of every manoeuvre nothing is excluded");
}

#[test]
fn keys_set_the_edges_split_and_exclude_between_the_markers() {
    let mut bench = bench();
    bench.press_at(8.0, Key::OpenBracket);
    bench.press_at(22.0, Key::CloseBracket);
    assert!(covers(bench.first(), 8.0, 22.0), "{:?}", bench.first());
    bench.press_at(12.0, Key::A);
    bench.press_at(13.0, Key::B);
    bench.press_at(20.0, Key::E);
    let [part] = bench.window(0).excluded[..] else { panic!("{:?}", bench.window(0).excluded) };
    assert!(covers(part, 12.0, 13.0), "{part:?}");
    bench.press_at(15.0, Key::S);
    assert_eq!(bench.session().windows.len(), 2);
    assert!(covers(bench.window(0).window, 8.0, 15.0) && covers(bench.window(1).window, 15.0, 22.0));
    assert_eq!((bench.window(0).excluded.len(), bench.window(1).excluded.len()), (1, 0));
    bench.undo();
    bench.press_at(12.5, Key::R);
    assert!(bench.window(0).excluded.is_empty());
    // What cannot be says why and changes nothing.
    let before = bench.first();
    bench.press_at(30.0, Key::S);
    assert_eq!((bench.session().windows.len(), bench.first()), (1, before));
    assert!(bench.harness.state().message.as_ref().expect("it is said").text.contains("split"));
}

#[test]
fn candidates_are_accepted_and_refused_one_by_one() {
    let mut bench = bench();
    let found = bench.snapshot().proposals["flight"].ready().expect("the flight was looked through").windows.clone();
    let open: Vec<_> = found.iter().filter(|one| one.covering_window(bench.session()).is_none()).collect();
    let expected = open.first().expect("the doublet is found").manoeuvre.window;
    let count = open.len();
    picture(&mut bench.harness, "candidates");
    bench.request(UiCommand::Mark(MarkCommand::Accept));
    assert_eq!(bench.session().windows.len(), 2);
    assert_eq!(bench.window(1).window, expected);
    bench.undo();
    (0..count).for_each(|_| bench.request(UiCommand::Mark(MarkCommand::Refuse)));
    bench.request(UiCommand::Mark(MarkCommand::Accept));
    assert_eq!(bench.session().windows.len(), 1, "all were refused");
    assert!(bench.harness.state().message.as_ref().expect("it is said").text.contains("No candidate"));
    bench.request(UiCommand::Mark(MarkCommand::ShowRefused));
    bench.request(UiCommand::Mark(MarkCommand::Accept));
    assert_eq!(bench.session().windows.len(), 2, "offered again");
}

#[test]
fn menus_of_plot_strip_and_row_have_the_commands_of_the_manoeuvre_under_the_pointer() {
    let mut bench = bench();
    bench.show(Pane::Manoeuvres);
    let at = bench.in_plot(15.0);
    secondary_click(&mut bench.harness, at);
    picture(&mut bench.harness, "marking_menu");
    bench.choose_containing("Split manoeuvre here");
    assert_eq!(bench.session().windows.len(), 2);
    assert!(is_near(bench.first().end_s, 15.0), "{:?}", bench.first());
    bench.undo();
    let row = bench.harness.get_by_label("name of first").rect().center();
    secondary_click(&mut bench.harness, row);
    bench.choose_containing("Note on manoeuvre");
    let entry = bench.harness.get_by_label("note");
    entry.focus();
    entry.type_text("smooth air");
    bench.harness.run_steps(2);
    bench.choose("Keep");
    assert_eq!(bench.window(0).note, "smooth air");
    let block = bench.harness.get_by_label_contains("timeline first:").rect().center();
    secondary_click(&mut bench.harness, block);
    bench.choose_containing("Remove manoeuvre");
    assert!(bench.session().windows.is_empty());
}

#[test]
fn insert_without_markers_adds_nothing_and_says_why() {
    let mut bench = bench();
    let before = bench.session().windows.len();
    bench.harness.state_mut().state.time.markers_s = [None; 2];
    bench.harness.key_press(Key::Insert);
    bench.settle();
    assert_eq!(bench.session().windows.len(), before);
    assert!(bench.harness.state().message.as_ref().is_some_and(|message| message.is_error));
}

#[test]
fn a_manoeuvre_that_overlaps_another_is_announced_until_it_is_moved_away() {
    let mut bench = bench();
    let first = bench.window(0);
    let said =
        |bench: &Bench<'_>| bench.harness.state().message.as_ref().is_some_and(|one| one.text.contains(&first.name));
    bench.mark(CTRL, 36.0, 42.0);
    assert!(!said(&bench), "nothing is shared");
    let name = bench.window(1).name;
    let place = |window| Edit::Window(WindowEdit::Place { name: name.clone(), window });
    let TimeRange { start_s, end_s } = first.window;
    let shared = TimeRange { start_s: 0.5 * (start_s + end_s), end_s: end_s + 1.0 };
    bench.harness.state_mut().apply(&place(shared));
    bench.settle();
    assert!(said(&bench), "{:?}", bench.harness.state().message);
    picture(&mut bench.harness, "marking_overlap");
    bench.harness.state_mut().apply(&place(TimeRange { start_s: end_s, end_s: end_s + 1.0 }));
    bench.settle();
    assert!(!said(&bench), "manoeuvres that touch share nothing");
}

impl Bench<'_> {
    /// A place in the strip of the whole flight.
    fn in_strip(&self, time_s: f64) -> Pos2 {
        let rect = self.harness.get_by_label("timeline of the whole flight").rect();
        let full = self.harness.state().state.time.full();
        let share = (time_s - full.start_s) / full.length_s();
        egui::pos2(rect.left() + rect.width() * share as f32, rect.top() + 10.0)
    }
}

#[test]
fn drags_in_the_strip_mark_as_in_the_plots_and_its_menu_has_the_candidate() {
    let mut bench = bench();
    let range = bench.harness.state().state.time.range();
    let (from, to) = (bench.in_strip(36.0), bench.in_strip(42.0));
    bench.held(CTRL, |bench| {
        hold(&mut bench.harness, from, to, 6);
        picture(&mut bench.harness, "marking_strip");
        bench.harness.drop_at(to);
        bench.harness.run_steps(2);
    });
    assert_eq!(bench.session().windows.len(), 2);
    assert!(covers(bench.window(1).window, 36.0, 42.0), "{:?}", bench.window(1).window);
    assert_eq!(bench.harness.state().state.time.range(), range, "the part on screen stays");
    bench.undo();
    let (from, to) = (bench.in_strip(12.0), bench.in_strip(16.0));
    bench.held(Modifiers::ALT, |bench| drag(&mut bench.harness, from, to, 6));
    let [part] = bench.window(0).excluded[..] else { panic!("{:?}", bench.window(0).excluded) };
    assert!(covers(part, 12.0, 16.0), "{part:?}");
    let found = bench.snapshot().proposals["flight"].ready().expect("the flight was looked through").windows.clone();
    let open = found.iter().find(|one| one.covering_window(bench.session()).is_none()).expect("one is open");
    let TimeRange { start_s, end_s } = open.manoeuvre.window;
    let at = bench.in_strip(0.5 * (start_s + end_s));
    secondary_click(&mut bench.harness, at);
    bench.choose_containing("Accept candidate");
    assert_eq!(bench.window(1).window, open.manoeuvre.window);
}

#[test]
fn manoeuvres_over_each_other_are_marked_at_the_time_from_their_onset() {
    let mut bench = bench();
    bench.show(Pane::Gallery);
    bench.choose("Over each other");
    let start_s = bench.first().start_s;
    let found = bench.snapshot().proposals["flight"].ready().expect("the flight was looked through").windows.clone();
    let onsets = found.iter().map(|one| one.onset_s).filter(|onset_s| bench.first().contains(*onset_s));
    let onset_s = onsets.fold(f64::INFINITY, f64::min);
    let onset_s = if onset_s.is_finite() { onset_s } else { start_s };
    // The plots show all of the manoeuvre, from the left end of the frame to the right one.
    let head = bench.harness.get_by_label("Signals").rect();
    let plots = bench.harness.query_all_by_label_contains("plot: ").map(|plot| plot.rect());
    let below = plots.filter(|plot| plot.top() > head.bottom() && plot.left() > head.left());
    let plot = below.min_by(|a, b| a.top().total_cmp(&b.top())).expect("there is a plot");
    let at = |bench: &Bench<'_>, time_s: f64| {
        let part = bench.first();
        let share = (time_s - part.start_s) / (part.end_s - part.start_s);
        egui::pos2(plot.left() + plot.width() * share as f32, plot.center().y)
    };
    let (from, to) = (at(&bench, 12.0), at(&bench, 16.0));
    bench.held(Modifiers::ALT, |bench| {
        hold(&mut bench.harness, from, to, 6);
        picture(&mut bench.harness, "marking_over");
        bench.harness.drop_at(to);
        bench.harness.run_steps(2);
    });
    let [part] = bench.window(0).excluded[..] else { panic!("{:?}", bench.window(0).excluded) };
    assert!(covers(part, 12.0, 16.0), "{part:?} with the onset at {onset_s} s");
    let middle = at(&bench, 20.0);
    secondary_click(&mut bench.harness, middle);
    picture(&mut bench.harness, "marking_over_menu");
    bench.choose_containing("Split manoeuvre here");
    assert_eq!(bench.session().windows.len(), 2);
    assert!(is_near(bench.first().end_s, 20.0), "{:?}", bench.first());
}
