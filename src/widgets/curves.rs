//! A channel that contradicts others: what is wrong, and the channel over what the others say it is, as read and with the fix.

use doublet_core::compatibility::{Curves, Trace};
use doublet_engine::stage::PhysicsRow;
use eframe::egui::{self, Label, RichText, Ui};
use egui_plot::{Line, Plot, PlotPoints};

use super::readout::readable;
use super::speak_value;
use crate::{notation, theme};

const SIZE: [f32; 2] = [128.0, 58.0];
/// Room both need beside each other.
const WIDTH: f32 = 2.0 * SIZE[0] + 12.0;
/// Least width left to the words beside the curves.
const WORDS: f32 = 220.0;

/// Draws in a horizontal row what is wrong in a few words, its figures and its fix, below them `more`, and beside them the curves where there is
/// room. `at` is its place among the contradictions: two may be of one channel.
pub fn draw_contradiction(ui: &mut Ui, at: usize, row: &PhysicsRow, more: impl FnOnce(&mut Ui)) {
    let curves = row.curves.as_ref().filter(|_| ui.available_width() > WORDS + WIDTH);
    ui.vertical(|ui| {
        ui.set_width(ui.available_width() - curves.map_or(0.0, |_| WIDTH));
        ui.spacing_mut().item_spacing.y = 1.0;
        let (ink, weak) = (ui.visuals().strong_text_color(), ui.visuals().weak_text_color());
        ui.add(Label::new(notation::typeset_in(&row.headline.to_string(), 13.0, ink)).wrap());
        let figures =
            if row.fix_text.is_empty() { row.evidence.clone() } else { format!("{}; {}", row.evidence, row.fix_text) };
        ui.add(Label::new(notation::typeset_in(&figures, 11.0, weak)).wrap());
        more(ui);
    });
    if let Some(curves) = curves {
        ui.push_id(at, |ui| show(ui, &row.channel, curves));
    }
}

/// Draws both, side by side.
fn show(ui: &mut Ui, channel: &str, curves: &Curves) {
    ui.horizontal_top(|ui| {
        ui.spacing_mut().item_spacing.x = 4.0;
        for (when, trace) in [("as read", &curves.before), ("with the fix", &curves.after)] {
            ui.vertical(|ui| figure(ui, channel, when, trace));
        }
    });
}

fn figure(ui: &mut Ui, channel: &str, when: &str, trace: &Trace) {
    ui.spacing_mut().item_spacing.y = 0.0;
    ui.label(RichText::new(when).size(10.0).weak());
    let palette = theme::palette(ui);
    let name = format!("{channel} {when}");
    let shown = Plot::new(ui.scope_id().with(("curves", &name)))
        .width(SIZE[0])
        .height(SIZE[1])
        .show_axes(false)
        .show_grid(false)
        .allow_drag(false)
        .allow_scroll(false)
        .allow_zoom(false)
        .allow_boxed_zoom(false)
        .label_formatter(|_| None)
        .show(ui, |plot| {
            for (values, color) in [(&trace.others, palette.ignored), (&trace.channel, palette.series[0])] {
                let points: PlotPoints<'_> =
                    trace.time_s.iter().zip(values).map(|(time, value)| [*time, *value]).collect();
                plot.line(Line::new("", points).color(color).width(1.4).allow_hover(false));
            }
        });
    shown.response.widget_info(|| egui::WidgetInfo::labeled(egui::Role::Image, true, format!("curves of {name}")));
    if let (Some(first), Some(last)) = (trace.time_s.first(), trace.time_s.last()) {
        let span = format!("{first:.1} to {last:.1} s of the recording");
        let here = shown.response.hover_pos().map(|at| shown.transform.value_from_position(at).x);
        speak_value(&shown.response, here.map_or(span, |time_s| spoken(trace, time_s)));
    }
    shown.response.on_hover_ui(|ui| {
        ui.colored_label(palette.series[0], format!("{channel}, {when}"));
        ui.colored_label(palette.ignored, "from the other channels");
        if let (Some(first), Some(last)) = (trace.time_s.first(), trace.time_s.last()) {
            ui.weak(format!("{first:.1} to {last:.1} s of the recording"));
        }
    });
}

/// The values of both curves at a time.
fn spoken(trace: &Trace, time_s: f64) -> String {
    let at = trace.time_s.partition_point(|time| *time < time_s).min(trace.time_s.len().saturating_sub(1));
    let value = |values: &[f64]| values.get(at).map_or_else(|| "–".to_owned(), |value| readable(*value));
    format!("at {time_s:.2} s: {}, from the other channels {}", value(&trace.channel), value(&trace.others))
}
