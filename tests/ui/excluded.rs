//! Excluded parts are hatched wherever a manoeuvre is drawn over its time.

use doublet::command::{EditCommand, UiCommand};
use doublet::panels::Pane;
use doublet::widgets::heat_strip::HeatStrips;
use doublet::widgets::time_view::TimeRange;
use doublet_engine::session::{Edit, WindowEdit};
use egui::{Rect, pos2, vec2};
use egui_kittest::kittest::Queryable;
use image::RgbaImage;

use crate::workbench::Bench;
use crate::{copied_data, picture, widget_harness};

/// The manoeuvre of the small flight, and the part of it that is excluded, s.
const MANOEUVRE_S: [f64; 2] = [5.0, 25.0];
const EXCLUDED_S: [f64; 2] = [10.0, 15.0];

/// The part of the strips that is excluded.
const PART: &[TimeRange] = &[TimeRange { start_s: 5.0, end_s: 10.0 }];

/// Pixels inside `area` that differ between two pictures.
fn differing(one: &RgbaImage, other: &RgbaImage, area: Rect) -> usize {
    let columns = area.left().ceil() as u32..area.right().floor() as u32;
    let rows = || area.top().ceil() as u32..area.bottom().floor() as u32;
    columns
        .flat_map(|x| rows().map(move |y| (x, y)))
        .filter(|&(x, y)| one.get_pixel(x, y) != other.get_pixel(x, y))
        .count()
}

#[test]
fn a_picture_of_the_gallery_is_hatched_where_the_manoeuvre_is_excluded_and_nowhere_else() {
    let mut bench = Bench::open();
    bench.show(Pane::Gallery);
    bench.harness.hover_at(pos2(2.0, 2.0));
    bench.harness.run_steps(3);
    let rect = bench.harness.get_by_label_contains("picture first:").rect();
    let before = picture(&mut bench.harness, "gallery_whole");
    let excluded = vec![TimeRange { start_s: EXCLUDED_S[0], end_s: EXCLUDED_S[1] }];
    bench.harness.state_mut().apply(&Edit::Window(WindowEdit::Exclude { name: "first".to_owned(), excluded }));
    bench.settle();
    let after = picture(&mut bench.harness, "gallery_excluded");
    let inner = rect.shrink(6.0);
    let x = |time_s: f64| {
        let share = (time_s - MANOEUVRE_S[0]) / (MANOEUVRE_S[1] - MANOEUVRE_S[0]);
        inner.left() + inner.width() * share as f32
    };
    let [start, end] = EXCLUDED_S.map(x);
    // Below the name and the mark of the verdict, which may change.
    let part = |from: f32, to: f32| Rect::from_x_y_ranges(from..=to, inner.top() + 18.0..=inner.bottom());
    assert!(differing(&before, &after, part(start + 1.0, end - 1.0)) > 100);
    assert_eq!(differing(&before, &after, part(inner.left(), start - 2.0)), 0);
    assert_eq!(differing(&before, &after, part(end + 2.0, inner.right())), 0);
}

#[test]
fn manoeuvres_over_each_other_are_hatched_from_their_onset_and_named() {
    let mut bench = Bench::open();
    bench.show(Pane::Gallery);
    bench.choose("Over each other");
    bench.harness.hover_at(pos2(2.0, 2.0));
    bench.harness.run_steps(3);
    let before = picture(&mut bench.harness, "over_whole");
    let below = bench.harness.get_by_label("Signals").rect().bottom();
    let excluded = vec![TimeRange { start_s: EXCLUDED_S[0], end_s: EXCLUDED_S[1] }];
    bench.harness.state_mut().apply(&Edit::Window(WindowEdit::Exclude { name: "first".to_owned(), excluded }));
    bench.settle();
    assert!(bench.harness.query_by_label("Hatched: excluded in first").is_some());
    let after = picture(&mut bench.harness, "over_excluded");
    let left = bench.harness.get_by_label("Signals").rect().left();
    let panel = Rect::from_min_max(pos2(left, below + 20.0), pos2(left + 300.0, below + 300.0));
    assert!(differing(&before, &after, panel) > 100);
}

#[test]
fn strips_of_information_are_hatched_inside_the_excluded_part() {
    let rows = [("Cm".to_owned(), vec![0.1, 0.4, 0.3, 0.2])];
    let draw = |excluded: &'static [TimeRange]| {
        let rows = rows.clone();
        let mut harness = widget_harness((500.0, 60.0), true, (), move |ui, _: &mut ()| {
            let edges_s = [0.0, 5.0, 10.0, 15.0, 20.0];
            let range = TimeRange::new(0.0, 20.0);
            let _ = HeatStrips { name: "strips", edges_s: &edges_s, rows: &rows, range, excluded }.show(ui);
        });
        harness.run_steps(2);
        let frame = doublet::widgets::heat_strip::frame(harness.get_by_label("strips").rect());
        (picture(&mut harness, "strips"), frame)
    };
    let ((whole, frame), (hatched, _)) = (draw(&[]), draw(PART));
    let middle = frame.left() + 0.25 * frame.width();
    let part = Rect::from_min_size(pos2(middle, frame.top()), vec2(0.25 * frame.width(), frame.height()));
    assert!(differing(&whole, &hatched, part) > 100);
    let behind = Rect::from_min_max(pos2(part.right() + 2.0, frame.top()), frame.max);
    assert_eq!(differing(&whole, &hatched, behind), 0);
}

/// Excludes the part of the small flight's manoeuvre; pictures before and after.
fn exclude(bench: &mut Bench<'_>, name: &str) -> (RgbaImage, RgbaImage) {
    bench.harness.hover_at(pos2(2.0, 2.0));
    bench.harness.run_steps(3);
    let before = picture(&mut bench.harness, &format!("{name}_whole"));
    let excluded = vec![TimeRange { start_s: EXCLUDED_S[0], end_s: EXCLUDED_S[1] }];
    bench.harness.state_mut().apply(&Edit::Window(WindowEdit::Exclude { name: "first".to_owned(), excluded }));
    bench.settle();
    (before, picture(&mut bench.harness, &format!("{name}_excluded")))
}

#[test]
fn the_strip_and_the_bar_hatch_the_excluded_part_of_a_manoeuvre() {
    let mut bench = Bench::open();
    let share = |rect: Rect, from: f32, to: f32| {
        let x = |share: f32| rect.left() + share * rect.width();
        Rect::from_x_y_ranges(x(from)..=x(to), rect.shrink(3.0).y_range())
    };
    let bar = bench.harness.get_by_role_and_label(egui::accesskit::Role::Button, "first").rect();
    // What catches the pointer is a point wider and two higher than what is drawn.
    let strip = bench.harness.get_by_label_contains("timeline first:").rect().shrink2(vec2(1.0, 2.0));
    let (before, after) = exclude(&mut bench, "lanes");
    for rect in [bar, strip] {
        assert!(differing(&before, &after, share(rect, 0.3, 0.45)) > 10, "{rect:?}");
    }
    // The strip's colour follows the verdict, the bar's does not.
    assert_eq!(differing(&before, &after, share(bar, 0.6, 0.95)), 0);
}

#[test]
fn the_cross_plot_names_what_is_excluded() {
    let mut bench = Bench::open();
    exclude(&mut bench, "cross");
    bench.show(Pane::CrossPlot);
    assert!(bench.harness.query_by_label("legend excluded").is_some());
    picture(&mut bench.harness, "cross_plot_excluded");
    bench.request(UiCommand::Edit(EditCommand::Undo));
    assert!(bench.harness.query_by_label("legend excluded").is_none());
}

#[test]
fn the_ground_track_draws_what_is_excluded_apart() {
    let mut bench = Bench::shipped();
    bench.show(Pane::GroundTrack);
    let window = bench.session().windows[0].clone();
    let (start_s, length_s) = (window.window.start_s, window.window.length_s());
    let excluded = vec![TimeRange { start_s: start_s + 0.2 * length_s, end_s: start_s + 0.8 * length_s }];
    let apart = format!("{}, excluded", window.name);
    let at = bench.harness.get_by_label("ground track").rect().center();
    assert!(!copied_data(&mut bench.harness, at).contains(&apart));
    bench.harness.state_mut().apply(&Edit::Window(WindowEdit::Exclude { name: window.name, excluded }));
    bench.settle();
    assert!(copied_data(&mut bench.harness, at).contains(&apart));
}
