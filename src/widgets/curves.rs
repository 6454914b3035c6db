//! A channel over what the others say it is, as read and with the fix.

use doublet_core::compatibility::{Curves, Trace};
use eframe::egui::{self, RichText, Ui};
use egui_plot::{Line, Plot, PlotPoints};

use crate::theme;

const SIZE: [f32; 2] = [128.0, 58.0];
/// Room both need beside each other.
pub const WIDTH: f32 = 2.0 * SIZE[0] + 12.0;

/// Draws both, side by side.
pub fn show(ui: &mut Ui, channel: &str, curves: &Curves) {
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
    shown.response.on_hover_ui(|ui| {
        ui.colored_label(palette.series[0], format!("{channel}, {when}"));
        ui.colored_label(palette.ignored, "from the other channels");
        if let (Some(first), Some(last)) = (trace.time_s.first(), trace.time_s.last()) {
            ui.weak(format!("{first:.1} to {last:.1} s of the recording"));
        }
    });
}
