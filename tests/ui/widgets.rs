//! Span editor, quantity edit and matrix view under the pointer and the keyboard.

use doublet::widgets::EditPhase;
use doublet::widgets::matrix_view::MatrixView;
use doublet::widgets::quantity_edit::{self, QuantityEdit, QuantityEdited};
use doublet::widgets::span_editor::SpanEvent;
use doublet::widgets::time_plot::time_at;
use doublet::widgets::time_view::TimeRange;
use egui::{Key, pos2, vec2};
use egui_kittest::Harness;
use egui_kittest::kittest::Queryable;

use crate::plots::Bench;
use crate::rasteriser::holds_color;
use crate::{click, drag, hold, picture, widget_harness};

/// Samples of the recording on the bench.
const SAMPLES: usize = 10_001;
/// Time between them, s.
const STEP_S: f64 = 0.01;

fn bench<'a>() -> Harness<'a, Bench> {
    let mut harness = widget_harness((1000.0, 420.0), true, Bench::new(SAMPLES), Bench::show);
    harness.run_steps(3);
    harness
}

/// Phases of the drags of span `wanted`, and where it was last.
fn drags(events: &[SpanEvent], wanted: u64) -> (Vec<EditPhase>, TimeRange) {
    let of = |event: &SpanEvent| match *event {
        SpanEvent::Dragged { id, phase, part } if id == wanted => Some((phase, part)),
        _ => None,
    };
    let found: Vec<_> = events.iter().filter_map(of).collect();
    (found.iter().map(|(phase, _)| *phase).collect(), found.last().expect("the span was dragged").1)
}

#[test]
fn dragging_an_edge_of_a_span_moves_it_to_samples_in_one_edit() {
    let mut harness = bench();
    let end = harness.get_by_label("3-2-1-1 δₑ end").rect().center();
    let (frame, range) = (harness.state().seen.frames[0], harness.state().view.range());
    drag(&mut harness, end, end + vec2(87.0, 3.0), 8);
    let (phases, last) = drags(&harness.state().events, 1);
    assert_eq!(phases.first(), Some(&EditPhase::Begin));
    assert_eq!(phases.last(), Some(&EditPhase::Commit));
    assert!(phases[1..phases.len() - 1].iter().all(|phase| *phase == EditPhase::Change) && phases.len() > 4);
    assert_eq!(last.start_s, 10.0);
    let moved_s = time_at(frame, range, end.x + 87.0) - time_at(frame, range, end.x);
    assert!((last.end_s - 25.0 - moved_s).abs() <= 0.5 * STEP_S + 1e-9, "{last:?}, {moved_s} s");
    let samples = last.end_s / STEP_S;
    assert!((samples - samples.round()).abs() < 1e-9, "{samples} is no sample");
}

#[test]
fn edge_of_the_selected_span_can_be_caught_inside_the_plots() {
    let mut harness = bench();
    let edge = harness.get_by_label("3-2-1-1 δₑ start").rect();
    let at = pos2(edge.center().x, harness.state().seen.frames[1].center().y);
    drag(&mut harness, at, at + vec2(-40.0, 0.0), 5);
    let (phases, last) = drags(&harness.state().events, 1);
    assert_eq!(phases.last(), Some(&EditPhase::Commit));
    assert!(last.start_s < 10.0 && last.end_s == 25.0, "{last:?}");
    assert_eq!(harness.state().view.range(), harness.state().view.full(), "the plots did not pan");
}

#[test]
fn moving_a_span_keeps_its_length_and_escape_gives_the_move_up() {
    let mut harness = bench();
    let body = harness.get_by_label("doublet δₐ").rect().center();
    drag(&mut harness, body, body + vec2(-150.0, 0.0), 6);
    let (_, last) = drags(&harness.state().events, 2);
    assert!((last.length_s() - 12.0).abs() < 1e-9 && last.start_s < 30.0, "{last:?}");
    harness.state_mut().events.clear();
    hold(&mut harness, body, body + vec2(100.0, 0.0), 4);
    harness.key_press(Key::Escape);
    harness.run_steps(2);
    harness.drop_at(body + vec2(100.0, 0.0));
    harness.run_steps(2);
    let (phases, last) = drags(&harness.state().events, 2);
    assert_eq!(phases.last(), Some(&EditPhase::Cancel));
    assert_eq!((last.start_s, last.end_s), (40.0, 52.0));
}

#[test]
fn a_click_selects_a_span_and_a_drag_in_the_empty_lane_draws_one() {
    let mut harness = bench();
    click(&mut harness, "doublet δₐ", 2);
    assert_eq!(harness.state().events, [SpanEvent::Selected(2)]);
    harness.state_mut().events.clear();
    let lane = harness.get_by_label("Draw a new manoeuvre").rect();
    let [from, to] = [0.80, 0.90].map(|share| pos2(lane.left() + share * lane.width(), lane.center().y));
    drag(&mut harness, from, to, 5);
    let [SpanEvent::Drawn(drawn)] = harness.state().events[..] else { panic!("{:?}", harness.state().events) };
    assert!((drawn.start_s - 80.0).abs() < 0.2 && (drawn.end_s - 90.0).abs() < 0.2, "{drawn:?}");
}

/// A field as a panel uses it: what it reports is taken at once.
struct Field {
    value: f64,
    logarithmic: bool,
    seen: Vec<QuantityEdited>,
}

const DEGREES: f64 = 180.0 / std::f64::consts::PI;

fn field<'a>(value: f64, logarithmic: bool) -> Harness<'a, Field> {
    let state = Field { value, logarithmic, seen: Vec::new() };
    let mut harness = widget_harness((420.0, 80.0), true, state, |ui, field: &mut Field| {
        let edit = QuantityEdit::new("Standard deviation of q", field.value).unit("deg/s", DEGREES);
        let edit = edit.allowed(1e-6..=0.5);
        let edit = if field.logarithmic { edit.logarithmic() } else { edit.per_point(0.5) };
        if let Some(edited) = edit.show(ui) {
            field.value = edited.value;
            field.seen.push(edited);
        }
    });
    harness.run_steps(2);
    harness
}

#[test]
fn a_typed_quantity_arrives_exactly_in_si_as_one_commit() {
    let mut harness = field(0.01, true);
    click(&mut harness, "Standard deviation of q", 2);
    harness.get_by_label("Standard deviation of q").type_text("0.75");
    harness.run_steps(2);
    assert!(harness.state().seen.is_empty(), "nothing is taken while typing");
    harness.key_press(Key::Enter);
    harness.run_steps(2);
    assert_eq!(harness.state().seen, [QuantityEdited { phase: EditPhase::Commit, value: 0.75 / DEGREES }]);
}

#[test]
fn leaving_a_field_as_it_was_or_typing_no_number_changes_nothing() {
    for text in ["", "fast", "nan"] {
        let mut harness = field(0.012_345_678_9, true);
        click(&mut harness, "Standard deviation of q", 2);
        if !text.is_empty() {
            harness.get_by_label("Standard deviation of q").type_text(text);
            harness.run_steps(2);
        }
        harness.key_press(Key::Enter);
        harness.run_steps(2);
        assert_eq!(harness.state().seen, [], "typed {text:?}");
        assert_eq!(harness.state().value, 0.012_345_678_9);
    }
}

#[test]
fn escape_in_a_typed_number_brings_the_value_back() {
    let mut harness = field(0.5, false);
    let name = "Standard deviation of q";
    click(&mut harness, name, 2);
    harness.key_press_modifiers(egui::Modifiers::COMMAND, Key::A);
    harness.run_steps(1);
    harness.get_by_label(name).type_text("9");
    harness.run_steps(1);
    harness.key_press(Key::Escape);
    harness.run_steps(3);
    assert_eq!((harness.state().value, harness.state().seen.as_slice()), (0.5, [].as_slice()));
}

#[test]
fn a_logarithmic_drag_multiplies_and_is_one_edit() {
    let mut harness = field(0.01, true);
    let at = harness.get_by_label("Standard deviation of q").rect().center();
    drag(&mut harness, at, at + vec2(100.0, 0.0), 20);
    let seen = &harness.state().seen;
    assert_eq!(seen[0], QuantityEdited { phase: EditPhase::Begin, value: 0.01 });
    assert_eq!(seen.iter().filter(|edited| edited.phase == EditPhase::Commit).count(), 1);
    assert_eq!(seen.last().unwrap().phase, EditPhase::Commit);
    // 100 points are one decade, less the few points egui needs to tell a drag from a click.
    let decades = (harness.state().value / 0.01).log10();
    assert!((0.85..=1.02).contains(&decades), "{decades} decades");
    let at_one = harness.state().value;
    drag(&mut harness, at, at + vec2(-100.0, 0.0), 20);
    let back = (harness.state().value / at_one).log10();
    assert!((back + decades).abs() < 0.05, "{back} decades back");
}

#[test]
fn escape_in_a_drag_brings_the_value_back() {
    let mut harness = field(0.1, false);
    let at = harness.get_by_label("Standard deviation of q").rect().center();
    hold(&mut harness, at, at + vec2(40.0, 0.0), 8);
    assert!(harness.state().value > 0.1);
    harness.key_press(Key::Escape);
    harness.run_steps(2);
    harness.drop_at(at + vec2(40.0, 0.0));
    harness.run_steps(2);
    assert_eq!(harness.state().value, 0.1);
    assert_eq!(harness.state().seen.last().unwrap().phase, EditPhase::Cancel);
}

#[test]
fn a_value_out_of_range_is_kept_and_explained_beside_the_field() {
    let mut harness = field(2.0, true);
    picture(&mut harness, "quantity_out_of_range");
    assert!(harness.query_by_label_contains("must be").is_some());
    harness.state_mut().value = 0.1;
    harness.run_steps(2);
    assert!(harness.query_by_label_contains("must be").is_none());
}

#[test]
fn field_that_is_sought_is_scrolled_to_and_marked_for_some_seconds() {
    let names: Vec<String> = (0..60).map(|field| format!("field {field}")).collect();
    let mut harness = widget_harness((300.0, 200.0), true, names, |ui, names| {
        egui::ScrollArea::vertical().auto_shrink(false).show(ui, |ui| {
            for name in names.iter() {
                let _ = QuantityEdit::new(name, 1.0).show(ui);
            }
        });
    });
    harness.run_steps(3);
    let is_shown = |harness: &Harness<'_, Vec<String>>| {
        harness.query_by_label("field 50").is_some_and(|node| node.rect().top() > 0.0 && node.rect().bottom() < 200.0)
    };
    assert!(!is_shown(&harness));
    let plain = picture(&mut harness, "quantity_before");
    let accent = doublet::theme::palette_of(true).accent;
    assert!(!holds_color(&plain, accent, 3));
    quantity_edit::seek(&harness.ctx, "field 50".to_owned());
    harness.run_steps(4);
    let marked = (0..60).any(|_| {
        harness.step();
        is_shown(&harness) && holds_color(&picture(&mut harness, "quantity_sought"), accent, 3)
    });
    assert!(marked);
}

#[test]
fn the_matrix_shows_its_colours_and_names_the_cell_under_the_pointer() {
    let labels = ["0", "α", "α̇ c/V", "q c/V", "δₑ", "alpha_squared_product"];
    let size = labels.len();
    let mut values: Vec<f64> = (0..size * size)
        .map(|at| ((at / size) as f64 - (at % size) as f64) / 4.0)
        .map(|v| v.clamp(-1.0, 1.0))
        .collect();
    (0..size).for_each(|k| values[k * size + k] = 1.0 + 1e-12);
    values[size + 4] = f64::NAN;
    for (dark, name) in [(true, "matrix_dark"), (false, "matrix_light")] {
        let (values, hovered) = (values.clone(), None);
        let mut harness = widget_harness((420.0, 400.0), dark, hovered, move |ui, hovered| {
            let matrix = MatrixView {
                name: "Correlation of regressors",
                labels: &labels,
                values: &values,
                full_scale: 1.0,
                notable: 0.9,
                stale: false,
            };
            *hovered = matrix.show(ui).0;
        });
        harness.run_steps(2);
        let rect = harness.get_by_label("Correlation of regressors").rect();
        harness.hover_at(rect.center() + vec2(0.0, 40.0));
        harness.run_steps(20);
        let (row, column) = harness.state().expect("a cell is under the pointer");
        assert!(row < size && column < size);
        let image = picture(&mut harness, name);
        assert!(holds_color(&image, doublet::theme::palette_of(dark).diverging[1], 3));
    }
}
