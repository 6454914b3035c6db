//! Every layout at every usual size and scale, dark and light: no text is cut at a side, none lies over another.

use doublet::command::{UiCommand, ViewCommand};
use doublet::panels::Pane;
use doublet::step::Step;
use egui::epaint::{ClippedShape, Shape, TextShape};
use egui::{Rect, ThemePreference, vec2};

use crate::picture;
use crate::workbench::Bench;

/// Sizes of windows, points, with the pixels of a point: the last is a screen of 1920 x 1080 at one and a half times the size of text.
const SIZES: [([f32; 2], f32); 4] =
    [([1280.0, 720.0], 1.0), ([1600.0, 1000.0], 1.0), ([2560.0, 1440.0], 1.0), ([1280.0, 720.0], 1.5)];
/// What may be lost at a side, and what two texts may share, points.
const SLACK: f32 = 2.0;
/// Rows of tables and lists end where they scroll: only sides are looked at there.
const LEAST_PART: f32 = 0.6;

/// A text on screen: where it would be, what is seen of it.
struct Text {
    words: String,
    whole: Rect,
    seen: Rect,
}

fn texts(shapes: &[ClippedShape]) -> Vec<Text> {
    let mut found = Vec::new();
    for shape in shapes {
        walk(&shape.shape, shape.clip_rect, &mut found);
    }
    found
}

fn walk(shape: &Shape, clip: Rect, found: &mut Vec<Text>) {
    match shape {
        Shape::Vec(shapes) => shapes.iter().for_each(|shape| walk(shape, clip, found)),
        Shape::Text(text) => found.extend(of(text, clip)),
        _ => {}
    }
}

/// A text that stands level and is seen for the most part of its height; what ends in an ellipsis says itself that it is cut.
fn of(text: &TextShape, clip: Rect) -> Option<Text> {
    let words = text.galley.text().trim().to_owned();
    let visible = text.fallback_color.a() > 0 && text.opacity_factor > 0.0;
    if words.is_empty() || text.angle != 0.0 || !visible {
        return None;
    }
    let whole = text.galley.mesh_bounds.translate(text.pos.to_vec2());
    let seen = whole.intersect(clip);
    (seen.is_positive() && seen.height() >= LEAST_PART * whole.height()).then_some(Text { words, whole, seen })
}

/// The words on screen.
pub fn texts_of(bench: &Bench<'_>) -> impl Iterator<Item = String> {
    texts(&bench.harness.output().shapes).into_iter().map(|text| text.words)
}

/// Texts that lose more than an edge at a side, and pairs that lie over each other.
pub fn faults(bench: &Bench<'_>) -> Vec<String> {
    faults_of(&texts(&bench.harness.output().shapes))
}

/// The same of what is drawn from a text that begins with `first` on, as in a window over the panels; without one, what is cut at a side.
pub fn faults_from(bench: &Bench<'_>, first: &str) -> Vec<String> {
    let texts = texts(&bench.harness.output().shapes);
    let at = texts.iter().position(|text| !first.is_empty() && text.words.starts_with(first));
    let is_over = |fault: &String| at.is_none() && fault.contains("' lies over '");
    faults_of(&texts[at.unwrap_or(0)..]).into_iter().filter(|fault| !is_over(fault)).collect()
}

fn faults_of(texts: &[Text]) -> Vec<String> {
    let mut faults = Vec::new();
    for text in texts {
        let lost = text.whole.width() - text.seen.width();
        if lost > SLACK && text.seen.width() > SLACK {
            faults.push(format!("'{}' loses {lost:.0} points at {:?}", text.words, text.seen));
        }
    }
    for (at, one) in texts.iter().enumerate() {
        for other in &texts[at + 1..] {
            let shared = one.seen.intersect(other.seen);
            if shared.width() > SLACK && shared.height() > SLACK + 1.0 && one.words != other.words {
                faults.push(format!("'{}' lies over '{}' at {shared:?}", other.words, one.words));
            }
        }
    }
    faults
}

/// Places and opacities, 0 to 1, of the texts `words` below `top`.
pub fn opacities(bench: &Bench<'_>, words: &str, top: f32) -> Vec<(Rect, f32)> {
    fn walk(shape: &Shape, words: &str, found: &mut Vec<(Rect, f32)>) {
        match shape {
            Shape::Vec(shapes) => shapes.iter().for_each(|shape| walk(shape, words, found)),
            Shape::Text(text) if text.galley.text() == words => {
                let place = text.galley.mesh_bounds.translate(text.pos.to_vec2());
                found.push((place, f32::from(text.fallback_color.a()) / 255.0 * text.opacity_factor));
            }
            _ => {}
        }
    }
    let mut found = Vec::new();
    bench.harness.output().shapes.iter().for_each(|shape| walk(&shape.shape, words, &mut found));
    found.retain(|(place, _)| place.top() > top);
    found
}

/// Short texts of tables that break over two lines: of those called `cells`.
pub fn broken(bench: &Bench<'_>, cells: &[String]) -> Vec<String> {
    let shapes = bench.harness.output().shapes.iter();
    let mut broken = Vec::new();
    let mut look = |shape: &Shape| {
        if let Shape::Text(text) = shape
            && text.galley.rows.len() > 1
            && cells.iter().any(|cell| cell == text.galley.text())
        {
            broken.push(text.galley.text().to_owned());
        }
    };
    for shape in shapes {
        match &shape.shape {
            Shape::Vec(shapes) => shapes.iter().for_each(&mut look),
            shape => look(shape),
        }
    }
    broken
}

#[test]
fn no_text_is_cut_or_covered_in_any_layout_at_any_size_in_either_theme() {
    let mut bench = Bench::shipped_in(1366.0, 768.0);
    let themes = [ThemePreference::Dark, ThemePreference::Light];
    // Drawing takes longer than all else, and nothing of it is looked at here.
    let is_drawn = std::env::var_os(crate::PICTURES).is_some();
    let mut all = Vec::new();
    for (at, step) in Step::ALL.into_iter().enumerate() {
        bench.request(UiCommand::View(ViewCommand::Step(step)));
        for (place, ([width, height], scale)) in SIZES.into_iter().enumerate() {
            // Every size in both themes, every step in both: what a theme changes is no place of a text.
            let theme = themes[(at + place) % 2];
            // The size is in points of the scale before until a frame is drawn.
            bench.harness.set_pixels_per_point(scale);
            bench.harness.step();
            bench.harness.set_size(vec2(width, height));
            bench.harness.state_mut().request(UiCommand::View(ViewCommand::Appearance(theme)));
            bench.harness.hover_at(egui::pos2(0.5 * width, height - 3.0));
            bench.harness.run_steps(4);
            let name = format!("{}_{width}_{scale}_{theme:?}", step.title());
            all.extend(faults(&bench).into_iter().map(|fault| format!("{name}: {fault}")));
            if is_drawn {
                picture(&mut bench.harness, &name);
            }
        }
    }
    assert!(all.is_empty(), "{} faults:\n{}", all.len(), all.join("\n"));
}

#[test]
fn no_text_of_any_panel_is_cut_or_covered_on_a_laptop() {
    let mut bench = Bench::shipped_in(1280.0, 720.0);
    let mut all = Vec::new();
    for &pane in Pane::ALL {
        bench.show(pane);
        bench.harness.hover_at(egui::pos2(640.0, 717.0));
        bench.harness.run_steps(6);
        // A row of tabs scrolls: the open one is seen whole, others may go beyond its sides.
        let is_beyond = |fault: &str, tab: Pane| fault.starts_with(&format!("'{}' loses", tab.short_title()));
        let others = || Pane::ALL.iter().filter(|other| **other != pane);
        let found = faults(&bench).into_iter().filter(|fault| !others().any(|other| is_beyond(fault, *other)));
        all.extend(found.map(|fault| format!("{}: {fault}", pane.title())));
        if std::env::var_os(crate::PICTURES).is_some() {
            picture(&mut bench.harness, &format!("laptop_{}", pane.title().replace(' ', "_")));
        }
    }
    assert!(all.is_empty(), "{} faults:\n{}", all.len(), all.join("\n"));
}
