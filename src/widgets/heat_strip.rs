//! Rows of a quantity over time as strips of colour: the stronger, the more.

use doublet_engine::report::document::{Axis, Figure, Mark, Panel, Plot};
use eframe::egui::{Align2, Mesh, Rect, Role, Sense, Shape, Stroke, StrokeKind, Ui, WidgetInfo, pos2, vec2};

use super::chart::figure_menu;
use super::figure::{FigureRequest, printed};
use super::hatch::hatch;
use super::speak_value;
use super::time_plot::{VALUE_AXIS_WIDTH, x_at};
use super::time_view::TimeRange;
use crate::{notation, theme};

/// Height of a strip and room between two.
const STRIP: f32 = 17.0;
const GAP: f32 = 2.0;
/// Room at the left beside the labels, as in a stack of plots, and at the right.
const ROOM: f32 = 8.0;
const RIGHT: f32 = 18.0;

/// Size of the names, points.
const SIZE: f32 = 11.0;

/// Height of a strip on a page, mm.
const STRIP_MM: f64 = 14.0;

/// Strips over one time axis.
#[derive(Clone, Copy, Debug)]
pub struct HeatStrips<'a> {
    /// What it is, for tests and screen readers.
    pub name: &'a str,
    /// Edges of the parts, s.
    pub edges_s: &'a [f64],
    /// Name of each strip, and one value per part, none below zero.
    pub rows: &'a [(String, Vec<f64>)],
    /// The part of time shown.
    pub range: TimeRange,
    /// Excluded parts, hatched.
    pub excluded: &'a [TimeRange],
}

/// The part of `outer` that the strips have, beside their names.
pub fn frame(outer: Rect) -> Rect {
    Rect::from_x_y_ranges(outer.left() + VALUE_AXIS_WIDTH + ROOM..=outer.right() - RIGHT, outer.y_range())
}

impl HeatStrips<'_> {
    /// Draws the strips; a figure that was asked for in their menu.
    pub fn show(&self, ui: &mut Ui) -> Option<FigureRequest> {
        let height = self.rows.len() as f32 * (STRIP + GAP);
        let (outer, response) = ui.allocate_exact_size(vec2(ui.available_width(), height), Sense::click());
        response.widget_info(|| WidgetInfo::labeled(Role::Image, true, self.name));
        let frame = frame(outer);
        let palette = theme::palette(ui);
        let ink = ui.visuals().text_color();
        let mut under = None;
        for (row, (name, values)) in self.rows.iter().enumerate() {
            let top = outer.top() + row as f32 * (STRIP + GAP);
            let strip = Rect::from_x_y_ranges(frame.x_range(), top..=top + STRIP);
            ui.painter().rect_filled(strip, 0.0, palette.plot_background);
            let most = values.iter().copied().fold(0.0, f64::max).max(f64::MIN_POSITIVE);
            let mut mesh = Mesh::default();
            for (at, (value, edges)) in values.iter().zip(self.edges_s.windows(2)).enumerate() {
                let (left, right) = (x_at(frame, self.range, edges[0]), x_at(frame, self.range, edges[1]));
                let cell = Rect::from_x_y_ranges(left..=right, strip.y_range()).intersect(strip);
                if !cell.is_positive() {
                    continue;
                }
                let part = (value / most).sqrt() as f32;
                mesh.add_colored_rect(cell, palette.plot_background.lerp_to_gamma(palette.series[1], part));
                if response.hover_pos().is_some_and(|pointer| cell.contains(pointer)) {
                    under = Some((row, at));
                }
            }
            ui.painter().add(Shape::mesh(mesh));
            for part in self.excluded {
                let [left, right] = [part.start_s, part.end_s].map(|time_s| x_at(frame, self.range, time_s));
                hatch(ui, Rect::from_x_y_ranges(left..=right, strip.y_range()).intersect(strip));
            }
            ui.painter().rect_stroke(strip, 0.0, Stroke::new(1.0, palette.grid), StrokeKind::Inside);
            let galley = ui.painter().layout_job(notation::typeset_in(name, SIZE, ink));
            let at = Align2::RIGHT_CENTER.anchor_size(pos2(frame.left() - 6.0, strip.center().y), galley.size());
            ui.painter().galley(at.min, galley, ink);
        }
        let form = figure_menu(&response);
        if let Some((row, at)) = under {
            let (name, values) = &self.rows[row];
            let (from, to) = (notation::fixed(self.edges_s[at], 2), notation::fixed(self.edges_s[at + 1], 2));
            let share = notation::fixed(100.0 * values[at], 1);
            let text = format!("{from} to {to} s: {share} % of the information on {name}");
            speak_value(&response, text.clone());
            response.on_hover_text_at_pointer(text);
        }
        form.map(|form| FigureRequest { figure: self.figure(ui), form })
    }

    /// The strips for a page: bars in %, a panel for each.
    fn figure(&self, ui: &Ui) -> Figure {
        let x = Axis { range: Some([self.range.start_s, self.range.end_s]), ..Axis::time() };
        let panel = |(name, values): &(String, Vec<f64>)| {
            let parts = self.edges_s.windows(2).zip(values);
            let bars = parts.map(|(edges, value)| [0.5 * (edges[0] + edges[1]), 100.0 * value]).collect();
            let width = self.edges_s.windows(2).map(|edges| edges[1] - edges[0]).fold(0.0, f64::max);
            let colour = printed(theme::palette(ui).series[1]);
            let marks = vec![Mark::Bars { label: "".into(), colour, width, bars }];
            Panel::Plot(Plot { x: x.clone(), y: Axis::new(name.clone(), "%"), marks })
        };
        Figure::new(
            self.name.replace(' ', "_"),
            self.name.to_owned(),
            (1, STRIP_MM),
            self.rows.iter().map(panel).collect(),
        )
        .with_excluded(self.excluded)
    }
}
