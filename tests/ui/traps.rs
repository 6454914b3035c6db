//! What a hand does by accident in its first minutes, and what must not come of it.

use doublet::command::{EditCommand, FileCommand, UiCommand, ViewCommand};
use doublet::panels::Pane;
use doublet::widgets::EditPhase;
use doublet::widgets::quantity_edit::{QuantityEdit, QuantityEdited};
use doublet::widgets::span_editor::SpanEvent;
use doublet_core::series::TimeRange;
use doublet_engine::session::{Edit, WindowEdit};
use egui::accesskit::Role;
use egui::{Key, Pos2, vec2};
use egui_kittest::kittest::Queryable;
use egui_tiles::{Linear, LinearDir, Tiles, Tree};

use crate::plots::Bench as Plots;
use crate::workbench::Bench;
use crate::{click, drag, hold, picture, secondary_drag, widget_harness};

/// A slider's value where the pointer may be off by this much of its rail: half a pixel and the rounding to a tenth.
const SLIDER_SHARE: f64 = 0.02;

#[test]
fn first_drag_of_a_fuel_slider_follows_the_pointer_and_is_one_step_of_undo() {
    let mut bench = Bench::shipped();
    bench.show(Pane::Loading);
    let before = bench.session().loading.clone();
    assert!(
        before.as_ref().is_none_or(|loading| loading.fuel_kg.is_empty()),
        "looking at the fuel leaves it to the record"
    );
    assert_eq!(bench.harness.state().document.history.undo_label(), None);
    let aircraft = bench.snapshot().aircraft.ready().expect("the aircraft is read").aircraft.clone();
    let tank = &aircraft.tanks[0];
    let slider = bench.harness.get_by_role_and_label(Role::Slider, &format!("Fuel {}", tank.name)).rect();
    let at = slider.left_center() + vec2(0.9 * slider.width(), 0.0);
    let to_the_left = vec2(-0.5 * slider.width(), 0.0);
    drag(&mut bench.harness, at, at + to_the_left, 6);
    bench.settle();
    let fuel_kg = bench.session().loading.as_ref().expect("the fuel is stated now").fuel_kg[&tank.name];
    let expected_kg = 0.4 * tank.capacity_kg;
    assert!(
        (fuel_kg - expected_kg).abs() < 0.1 * tank.capacity_kg,
        "{fuel_kg} kg where the pointer shows {expected_kg}"
    );
    assert!(bench.harness.state().document.history.undo_label().is_some(), "the drag can be taken back");
    bench.request(UiCommand::Edit(EditCommand::Undo));
    assert_eq!(bench.session().loading, before, "by one step");
    drag(&mut bench.harness, at, at + to_the_left, 6);
    bench.settle();
    let second_kg = bench.session().loading.as_ref().expect("it is stated again").fuel_kg[&tank.name];
    assert!(
        (second_kg - fuel_kg).abs() < SLIDER_SHARE * tank.capacity_kg,
        "the second drag does what the first did: {second_kg}, {fuel_kg}"
    );
}

#[test]
fn text_that_appears_above_a_field_does_not_end_its_drag() {
    struct State {
        value: f64,
        seen: Vec<QuantityEdited>,
    }
    let state = State { value: 5.0, seen: Vec::new() };
    let mut harness = widget_harness((420.0, 200.0), true, state, |ui, state: &mut State| {
        if state.value != 5.0 {
            ui.label("something is wrong now");
        }
        if let Some(edited) = QuantityEdit::new("field", state.value).per_point(0.1).show(ui) {
            state.value = edited.value;
            state.seen.push(edited);
        }
    });
    harness.run_steps(3);
    let at = harness.get_by_label("field").rect().center();
    drag(&mut harness, at, at + vec2(40.0, 0.0), 8);
    let phases: Vec<_> = harness.state().seen.iter().map(|edited| edited.phase).collect();
    assert_eq!((phases.first(), phases.last()), (Some(&EditPhase::Begin), Some(&EditPhase::Commit)), "{phases:?}");
    let dragged = harness.state().value - 5.0;
    assert!((dragged - 4.0).abs() < 1.0, "40 points at a tenth each: {dragged}");
}

#[test]
fn click_on_a_name_chooses_and_the_next_key_is_a_shortcut() {
    let mut bench = Bench::open();
    bench.show(Pane::Manoeuvres);
    let full = bench.harness.state().state.time.range();
    let at = bench.harness.get_by_label("name of first").rect().center();
    drag(&mut bench.harness, at, at, 1);
    for key in [Key::W, Key::PageDown, Key::PageUp] {
        bench.harness.key_press(key);
        bench.harness.run_steps(2);
    }
    bench.settle();
    assert_eq!(bench.session().windows[0].name, "first");
    assert!(bench.harness.state().state.time.range().length_s() < 0.6 * full.length_s(), "W zoomed to the manoeuvre");
}

#[test]
fn name_is_typed_after_a_double_click_or_f2_and_escape_gives_it_up_without_a_trace() {
    let mut bench = Bench::open();
    bench.show(Pane::Manoeuvres);
    bench.harness.state_mut().state.time.markers_s = [Some(7.0), None];
    bench.retype("name of first", "wnb", Key::Escape);
    assert_eq!(bench.session().windows[0].name, "first");
    assert_eq!(bench.harness.state().document.history.undo_label(), None);
    assert_eq!(bench.harness.state().state.time.markers_s[0], Some(7.0), "Escape went to the name alone");
    bench.retype("note of first", "never", Key::Escape);
    assert_eq!(bench.session().windows[0].note, "");
    bench.retype("name of first", "short period", Key::Enter);
    assert_eq!(bench.session().windows[0].name, "short period");
    assert_eq!(bench.harness.state().state.selection.window.as_deref(), Some("short period"), "it stays chosen");
    bench.harness.key_press(Key::F2);
    bench.harness.run_steps(3);
    picture(&mut bench.harness, "renaming");
    bench.harness.get_by_label("name of short period").type_text("phugoid");
    bench.harness.run_steps(1);
    bench.harness.key_press(Key::Enter);
    bench.settle();
    assert_eq!(bench.session().windows[0].name, "phugoid");
    bench.show(Pane::Noise);
    bench.harness.state_mut().request(UiCommand::Edit(EditCommand::RenameWindow));
    bench.harness.run_steps(4);
    assert!(bench.harness.query_by_label("name of phugoid").is_some(), "the command brings the table to the front");
}

#[test]
fn number_typed_and_given_up_by_escape_is_what_it_was() {
    let mut bench = Bench::open();
    bench.show(Pane::Noise);
    let before = bench.session().filter.clone();
    bench.harness.get_by_label("R alpha").scroll_to_me();
    bench.harness.run_steps(3);
    click(&mut bench.harness, "R alpha", 3);
    bench.harness.key_press_modifiers(egui::Modifiers::COMMAND, Key::A);
    bench.harness.run_steps(1);
    bench.harness.get_by_label("R alpha").type_text("9");
    bench.harness.run_steps(1);
    bench.harness.key_press(Key::Escape);
    bench.settle();
    assert_eq!(bench.session().filter, before);
}

impl Bench<'_> {
    /// Makes the window `first` half a second long: a few points on screen.
    fn narrow(&mut self) -> TimeRange {
        let window = TimeRange { start_s: 20.0, end_s: 20.5 };
        let place = WindowEdit::Place { name: "first".to_owned(), window };
        self.harness.state_mut().apply(&Edit::Window(place));
        self.settle();
        window
    }

    /// Where the lane shows the window `first`.
    fn band(&self) -> egui::Rect {
        self.harness.get_by_role_and_label(Role::Button, "first").rect()
    }
}

#[test]
fn drag_beside_or_on_a_window_a_few_points_wide_leaves_it_as_it_is() {
    let mut bench = Bench::open();
    let window = bench.narrow();
    let band = bench.band();
    assert!(band.width() < 12.0, "{band:?}");
    let below = vec2(0.0, 70.0);
    let beside = [band.left_center() - vec2(2.0, 0.0), band.right_center() + vec2(2.0, 0.0)];
    for from in [band.center(), band.center() + below, beside[0] + below, beside[1] + below] {
        for by in [60.0, -60.0] {
            drag(&mut bench.harness, from, from + vec2(by, 0.0), 6);
            secondary_drag(&mut bench.harness, from, from + vec2(by, 0.0));
            bench.request(UiCommand::View(ViewCommand::ZoomHome));
            bench.settle();
            assert_eq!(bench.session().windows[0].window, window, "dragged from {from:?} by {by}");
            assert_eq!(bench.session().windows.len(), 1);
        }
    }
    // Zoomed in, the same edge is caught.
    bench.request(UiCommand::View(ViewCommand::ZoomToWindow));
    let end = bench.harness.get_by_role_and_label(Role::Button, "first end").rect().center();
    drag(&mut bench.harness, end, end - vec2(60.0, 0.0), 6);
    bench.settle();
    assert!(bench.session().windows[0].window.end_s < window.end_s - 0.05, "{:?}", bench.session().windows[0].window);
}

#[test]
fn drag_that_makes_a_window_narrow_goes_on_to_its_end() {
    let mut bench = Bench::open();
    let end = bench.harness.get_by_role_and_label(Role::Button, "first end").rect().center();
    let band = bench.band();
    let to = egui::pos2(band.left() + 6.0, end.y);
    hold(&mut bench.harness, end, to, 30);
    hold_on(&mut bench, to, to + vec2(60.0, 0.0));
    bench.settle();
    let length_s = bench.session().windows[0].window.end_s - 5.0;
    let expected_s = 20.0 * f64::from(66.0 / band.width());
    assert!((length_s - expected_s).abs() < 0.5, "{length_s} s, the pointer shows {expected_s} s");
}

/// Moves on with the button held and lets go.
fn hold_on(bench: &mut Bench<'_>, from: Pos2, to: Pos2) {
    for step in 1..=6 {
        bench.harness.hover_at(from + (to - from) * (step as f32 / 6.0));
        bench.harness.step();
    }
    bench.harness.drop_at(to);
    bench.harness.run_steps(2);
}

#[test]
fn drag_with_the_secondary_button_zooms_wherever_it_begins_and_edits_nothing() {
    let mut harness = widget_harness((1000.0, 520.0), true, Plots::new(10_001), Plots::show);
    harness.run_steps(3);
    let edge = harness.get_by_label("3-2-1-1 δₑ end").rect().center();
    let body = harness.get_by_label("3-2-1-1 δₑ").rect().center();
    let empty = body + vec2(500.0, 0.0);
    let in_plot = egui::pos2(edge.x, harness.state().seen.frames[1].center().y);
    for from in [edge, body, empty, in_plot] {
        harness.state_mut().events.clear();
        secondary_drag(&mut harness, from, from + vec2(50.0, 0.0));
        let [SpanEvent::Zoomed(part)] = harness.state().events[..] else {
            panic!("from {from:?}: {:?}", harness.state().events)
        };
        let frame = harness.state().seen.frames[0];
        let start_s = 100.0 * f64::from((from.x - frame.left()) / frame.width());
        let length_s = 100.0 * f64::from(50.0 / frame.width());
        assert!((part.start_s - start_s).abs() < 0.2 && (part.length_s() - length_s).abs() < 0.2, "{part:?}");
    }
}

#[test]
fn another_session_shows_all_of_its_recording_and_none_of_what_was_before() {
    let mut bench = Bench::open();
    bench.harness.state_mut().state.time.zoom_to(TimeRange::new(10.0, 20.0));
    bench.harness.state_mut().state.time.markers_s = [Some(12.0), Some(14.0)];
    bench.request(UiCommand::Run(doublet::command::RunCommand::Again));
    assert!(bench.snapshot().log.iter().any(|line| line.cause == "compute again"));
    bench.request(UiCommand::File(FileCommand::OpenShipped));
    let time = &bench.harness.state().state.time;
    assert_eq!(time.range(), time.full());
    assert!(time.full().length_s() > 1000.0, "it is that of the flight: {:?}", time.full());
    assert_eq!(time.markers_s, [None; 2]);
    assert!(bench.snapshot().log.iter().all(|line| line.cause == "first run"), "{:?}", bench.snapshot().log);
    let first = bench.session().windows[0].name.clone();
    assert_eq!(bench.harness.state().state.selection.window, Some(first));
}

#[test]
fn channel_let_go_over_an_axis_of_another_unit_gets_one_of_its_own() {
    let mut bench = Bench::open();
    bench.request(UiCommand::View(ViewCommand::Step(doublet::step::Step::Recording)));
    let plots = |bench: &Bench<'_>| bench.harness.state().state.flight_plots.clone();
    let names = [["z"], ["airspeed"]].map(|plot| plot.map(str::to_owned).to_vec());
    bench.harness.state_mut().state.flight_plots = Some(names.to_vec());
    bench.settle();
    let lane = bench.band();
    // Two plots share the height below the lane: one in the upper half, one in the lower.
    let upper = egui::pos2(lane.center().x, lane.bottom() + 60.0);
    let carry = |bench: &mut Bench<'_>, channel: &str, to: Pos2| {
        let from = bench.harness.get_by_label(channel).rect().center();
        hold(&mut bench.harness, from, to, 8);
        picture(&mut bench.harness, &format!("carried_{channel}"));
        bench.harness.drop_at(to);
        bench.settle();
    };
    carry(&mut bench, "Vd", upper);
    assert_eq!(
        plots(&bench).expect("they changed"),
        [vec!["z".to_owned()], vec!["v_down".to_owned()], vec!["airspeed".to_owned()]]
    );
    carry(&mut bench, "x", upper);
    assert_eq!(plots(&bench).expect("they changed")[0], ["z", "x"], "metres join metres");
}

#[test]
fn tab_of_several_panels_is_called_by_their_names() {
    let mut bench = Bench::open();
    let mut tiles = Tiles::default();
    let inner = [Pane::Flight, Pane::Log].map(|pane| tiles.insert_pane(pane));
    let split = tiles.insert_container(Linear::new_binary(LinearDir::Vertical, inner, 0.5));
    let other = tiles.insert_pane(Pane::Model);
    let root = tiles.insert_tab_tile(vec![split, other]);
    bench.harness.state_mut().state.shown.tree = Tree::new(egui::Id::unique("workbench"), root, tiles);
    bench.settle();
    assert!(bench.harness.query_by_label("Flight · Log").is_some());
    assert!(bench.harness.query_by_label("Vertical").is_none());
}
