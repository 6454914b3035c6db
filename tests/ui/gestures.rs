//! What the hand does in a stack of time plots, with the numbers that must result.

use doublet::widgets::figure::FigureForm;
use doublet::widgets::time_plot::time_at;
use doublet::widgets::time_view::TimeRange;
use egui::{Key, Modifiers, Pos2, pos2, vec2};
use egui_kittest::Harness;
use egui_kittest::kittest::Queryable;

use crate::plots::{Bench, harness, middle};
use crate::{click, double_click, drag, secondary_drag};

/// Rounding of a screen position to a value or a time, as a part of what is shown.
const PART: f64 = 0.004;

fn values(harness: &Harness<'_, Bench>, plot: usize) -> (f64, f64) {
    harness.state().seen.values[plot]
}

fn range(harness: &Harness<'_, Bench>) -> TimeRange {
    harness.state().view.range()
}

/// Value at a screen position of a plot.
fn value_at(harness: &Harness<'_, Bench>, plot: usize, at: Pos2) -> f64 {
    let (frame, (low, high)) = (harness.state().seen.frames[plot], values(harness, plot));
    low + (high - low) * f64::from((frame.bottom() - at.y) / frame.height())
}

fn wheel(harness: &mut Harness<'_, Bench>, at: Pos2, by: f32, modifiers: Modifiers) {
    harness.hover_at(at);
    harness.step();
    let (unit, phase) = (egui::MouseWheelUnit::Point, egui::TouchPhase::Move);
    let source = egui::MouseWheelSource::Wheel;
    let event = egui::Event::MouseWheel { unit, delta: vec2(0.0, by), phase, source, modifiers };
    harness.event(egui::Event::ModifiersChanged(modifiers));
    harness.event(event);
    harness.run_steps(14);
    harness.event(egui::Event::ModifiersChanged(Modifiers::NONE));
    harness.run_steps(2);
}

fn close(a: f64, b: f64, size: f64) -> bool {
    (a - b).abs() <= PART * size.abs()
}

#[test]
fn wheel_zooms_time_and_with_shift_the_values_of_one_plot_about_the_pointer() {
    let mut harness = harness(5000, true);
    let at = middle(&harness) + vec2(80.0, 20.0);
    let (full, all) = (range(&harness), values(&harness, 0));
    wheel(&mut harness, at, 120.0, Modifiers::NONE);
    let zoomed = range(&harness);
    assert!(zoomed.length_s() < 0.8 * full.length_s());
    let frame = harness.state().seen.frames[0];
    let here = |range| time_at(frame, range, at.x);
    assert!(close(here(full), here(zoomed), full.length_s()), "the time under the pointer stays");
    let (before, other) = (value_at(&harness, 0, at), values(&harness, 1));
    wheel(&mut harness, at, 120.0, Modifiers::SHIFT);
    assert_eq!(range(&harness), zoomed, "time stays");
    let (low, high) = values(&harness, 0);
    assert!(high - low < 0.8 * (all.1 - all.0), "{low} to {high}");
    assert!(close(value_at(&harness, 0, at), before, all.1 - all.0), "the value under the pointer stays");
    assert_eq!(values(&harness, 1), other, "the other plot stays");
    double_click(&mut harness, at);
    assert_eq!((range(&harness), values(&harness, 0)), (full, all), "a double click fits all");
}

#[test]
fn right_drag_zooms_to_its_box_and_a_level_one_to_its_part_of_time() {
    let mut harness = harness(5000, true);
    let (full, all) = (range(&harness), values(&harness, 0));
    let frame = harness.state().seen.frames[0];
    let (from, to) = (frame.center() + vec2(-100.0, -40.0), frame.center() + vec2(120.0, 30.0));
    let (times, heights) =
        ([from.x, to.x].map(|x| time_at(frame, full, x)), [from, to].map(|at| value_at(&harness, 0, at)));
    secondary_drag(&mut harness, from, to);
    let (zoomed, (low, high)) = (range(&harness), values(&harness, 0));
    assert!(close(zoomed.start_s, times[0], full.length_s()) && close(zoomed.end_s, times[1], full.length_s()));
    assert!(close(high, heights[0], all.1 - all.0) && close(low, heights[1], all.1 - all.0), "{low} to {high}");
    let kept = values(&harness, 0);
    let at = middle(&harness);
    secondary_drag(&mut harness, at, at + vec2(60.0, 4.0));
    assert!(range(&harness).length_s() < zoomed.length_s());
    assert_eq!(values(&harness, 0), kept, "a level drag leaves the values");
}

#[test]
fn drag_on_an_axis_zooms_that_axis_alone() {
    let mut harness = harness(5000, true);
    let (full, all) = (range(&harness), values(&harness, 0));
    let [first, last] = [0, 1].map(|plot| harness.state().seen.frames[plot]);
    let axis = pos2(first.left() - 30.0, first.center().y);
    drag(&mut harness, axis, axis + vec2(0.0, 40.0), 6);
    let (low, high) = values(&harness, 0);
    assert!(high - low < 0.9 * (all.1 - all.0), "{low} to {high}");
    assert!(close(low + high, all.0 + all.1, all.1 - all.0), "about the middle");
    assert_eq!(range(&harness), full);
    double_click(&mut harness, axis);
    assert_eq!(values(&harness, 0), all);
    let axis = pos2(last.center().x, last.bottom() + 12.0);
    drag(&mut harness, axis, axis + vec2(40.0, 0.0), 6);
    let zoomed = range(&harness);
    assert!(zoomed.length_s() < 0.9 * full.length_s());
    assert!(close(zoomed.start_s + zoomed.end_s, full.start_s + full.end_s, full.length_s()), "about the middle");
}

#[test]
fn click_on_a_name_of_the_legend_hides_its_curve_and_shows_it_again() {
    let mut harness = harness(5000, true);
    let curves = |harness: &mut Harness<'_, Bench>| {
        let at = middle(harness);
        crate::secondary_click(harness, at);
        click(harness, "This plot", 4);
        click(harness, "Copy data", 3);
        let request = harness.state_mut().figures.pop().expect("a figure was asked for");
        let text = doublet::widgets::figure::csv(&request.figure);
        text.lines().next().unwrap_or_default().split(',').skip(1).map(str::to_owned).collect::<Vec<_>>()
    };
    let all = curves(&mut harness);
    assert_eq!(all, ["q measured [rad/s]", "q̂ [rad/s]"]);
    let noisy = values(&harness, 0);
    // Beside the edge of the span, which reaches down into the plots.
    let entry = harness.get_by_label("legend q measured").rect().left_center() + vec2(20.0, 0.0);
    crate::drag(&mut harness, entry, entry, 0);
    harness.run_steps(12);
    assert_eq!(curves(&mut harness), all[1..]);
    let smooth = values(&harness, 0);
    assert!(smooth.1 - smooth.0 < noisy.1 - noisy.0, "what is hidden does not set the scale");
    crate::drag(&mut harness, entry, entry, 0);
    harness.run_steps(12);
    assert_eq!(curves(&mut harness), all, "and shows it again");
}

#[test]
fn keys_a_and_b_set_the_markers_and_ctrl_c_takes_picture_or_numbers() {
    let mut harness = harness(5000, true);
    let at = middle(&harness);
    let frame = harness.state().seen.frames[0];
    for (key, by) in [(Key::A, -100.0), (Key::B, 150.0)] {
        harness.hover_at(at + vec2(by, 0.0));
        harness.step();
        harness.key_press(key);
        harness.run_steps(3);
    }
    let expected = [-100.0, 150.0].map(|by| Some(time_at(frame, range(&harness), at.x + by)));
    assert_eq!(harness.state().view.markers_s, expected);
    for (modifiers, form) in
        [(Modifiers::COMMAND, FigureForm::CopyPicture), (Modifiers::COMMAND | Modifiers::SHIFT, FigureForm::Copy)]
    {
        harness.hover_at(at);
        harness.step();
        harness.event_modifiers(egui::Event::Copy, modifiers);
        harness.run_steps(2);
        assert_eq!(harness.state_mut().figures.pop().map(|request| request.form), Some(form));
    }
}

#[test]
fn picture_for_the_clipboard_has_the_pixels_of_the_file() {
    let mut harness = harness(5000, true);
    let at = middle(&harness);
    harness.hover_at(at);
    harness.step();
    harness.event_modifiers(egui::Event::Copy, Modifiers::COMMAND);
    harness.run_steps(2);
    let request = harness.state_mut().figures.pop().expect("a figure was asked for");
    let copied = doublet::widgets::figure::picture(&request.figure).expect("it can be drawn");
    let file = doublet::widgets::figure::png(&request.figure).expect("it can be drawn");
    let file = image::load_from_memory(&file).expect("it is a picture").to_rgba8();
    assert_eq!(copied.size, [file.width() as usize, file.height() as usize]);
    let same = copied.pixels.iter().zip(file.pixels()).all(|(a, b)| a.to_array() == b.0);
    assert!(same, "every pixel");
}
