//! Words at instants of the flight, over every plot against its time.

use doublet_engine::report::document::{Colour, Figure, Mark, Panel as FigurePanel};
use doublet_engine::session::Annotation;
use eframe::egui::{CornerRadius, FontId, Id, Rect, Role, Sense, Stroke, Ui, WidgetInfo, pos2, vec2};

use crate::panels::{PanelContext, View};
use crate::widgets::time_plot::{StackResponse, x_at};
use crate::widgets::time_view::TimeRange;
use crate::{notation, theme};

/// Longest words beside a line, points; more is shown by a pause.
const WIDEST: f32 = 150.0;
/// Width of a line in a figure, part of the time shown.
const LINE: f64 = 0.002;

/// The flight a view shows and what of its time.
fn shown(ctx: &mut PanelContext<'_>, view: View) -> Option<(String, TimeRange)> {
    let flight = match view {
        View::Flight => ctx.selection().flight.clone(),
        View::Window => ctx.window().map(|window| window.flight.clone()),
    };
    Some((flight?, ctx.view(view).range()))
}

/// The annotations of a view that lie in what it shows.
fn visible<'a>(ctx: &PanelContext<'a>, flight: &str, range: TimeRange) -> Vec<&'a Annotation> {
    let all = ctx.session.annotations.iter();
    all.filter(|one| one.flight == flight && (range.start_s..=range.end_s).contains(&one.time_s)).collect()
}

/// Draws the annotations over a stack; a click on the words changes them. Takes the wish for a new one.
pub fn show(ctx: &mut PanelContext<'_>, ui: &mut Ui, view: View, response: &StackResponse) {
    let Some((flight, range)) = shown(ctx, view) else { return };
    if let Some(time_s) = ctx.view(view).annotate_s.take() {
        let new = Annotation { flight: flight.clone(), time_s, text: String::new() };
        ctx.state.annotating = Some((new, None));
    }
    let clip = ui.clip_rect();
    let frames: Vec<Rect> = response.frames.iter().copied().filter(|frame| clip.intersects(*frame)).collect();
    let Some(first) = frames.first() else { return };
    let (palette, ink) = (theme::palette(ui), ui.visuals().strong_text_color());
    let mut free = f32::NEG_INFINITY;
    for one in visible(ctx, &flight, range) {
        let x = x_at(*first, range, one.time_s);
        for frame in &frames {
            ui.painter().with_clip_rect(frame.intersect(clip)).vline(
                x,
                frame.y_range(),
                Stroke::new(1.0, palette.accent),
            );
        }
        let font = FontId::proportional(11.0);
        let mut words = one.text.clone();
        let mut galley = ui.painter().layout_no_wrap(words.clone(), font.clone(), ink);
        while galley.size().x > WIDEST && words.pop().is_some() {
            galley = ui.painter().layout_no_wrap(format!("{}…", words.trim_end()), font.clone(), ink);
        }
        let left = (x + 2.0).min(first.right() - galley.size().x - 6.0);
        // What would lie over its neighbour goes a line lower.
        let lower = if left < free { galley.size().y + 4.0 } else { 0.0 };
        let at = pos2(left, first.bottom() - galley.size().y - 6.0 - lower);
        free = left + galley.size().x + 6.0;
        let ground = Rect::from_min_size(at, galley.size() + vec2(6.0, 2.0));
        ui.painter().rect_filled(ground, CornerRadius::same(3), palette.grid);
        let text = galley.text().to_owned();
        ui.painter().galley(ground.min + vec2(3.0, 1.0), galley, ink);
        let id =
            Id::unique(("annotation", format!("{view:?}"), one.time_s.to_bits(), &one.text, response.frames.len()));
        let label = ui.interact(ground, ui.scope_id().with(id), Sense::click());
        label.widget_info(|| WidgetInfo::labeled(Role::Button, true, format!("annotation {text}")));
        let label = label.on_hover_text(format!("{} s: {}", notation::fixed(one.time_s, 2), one.text));
        if label.clicked() {
            ctx.state.annotating = Some((one.clone(), Some(one.clone())));
        }
    }
}

/// Marks the annotations of a view in a figure of it, named in its legend.
pub fn add(ctx: &mut PanelContext<'_>, view: View, figure: &mut Figure) {
    let Some((flight, range)) = shown(ctx, view) else { return };
    for one in visible(ctx, &flight, range) {
        let width_s = LINE * range.length_s();
        for (at, panel) in figure.panels.iter_mut().enumerate() {
            let FigurePanel::Plot(plot) = panel else { continue };
            let words = format!("{} s: {}", notation::fixed(one.time_s, 1), one.text);
            let label = if at == 0 { words.into() } else { "".into() };
            let ends = [one.time_s - 0.5 * width_s, one.time_s + 0.5 * width_s];
            plot.marks.push(Mark::Span { label, colour: Colour::PALETTE[7], ends });
        }
    }
}
