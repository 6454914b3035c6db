//! All manoeuvres side by side, or several superimposed and aligned at their onset: input, response and model on one time scale.

use doublet_engine::session::{Manoeuvre, Surface};
use eframe::egui::{self, Align2, FontId, Rect, RichText, Role, ScrollArea, Sense, Stroke, Ui, WidgetInfo, vec2};

use crate::panels::manoeuvres::proposals::{curve, hatch_excluded, picture_menu, roles};
use crate::panels::recording::overlay::Overlay;
use crate::panels::{Panel, PanelContext, empty, role_color, select, windows_by_time};
use crate::widgets::level_mark;
use crate::{notation, theme};

/// Least and largest width of a picture, and its height over its width.
const LEAST_WIDTH: f32 = 170.0;
const LARGEST_WIDTH: f32 = 420.0;
const SHAPE: f32 = 0.55;
/// Room between two, and for the scroll bar.
const GAP: f32 = 6.0;
const SCROLL_BAR: f32 = 12.0;

#[derive(Clone, Copy, PartialEq, Eq)]
enum Shown {
    All,
    Of(Surface),
}

pub struct Gallery {
    shown: Shown,
    /// Whether they lie over each other instead of side by side.
    over: bool,
    overlay: Overlay,
}

impl Default for Gallery {
    fn default() -> Self {
        Self { shown: Shown::All, over: false, overlay: Overlay::default() }
    }
}

impl Panel for Gallery {
    fn show(&mut self, ctx: &mut PanelContext<'_>, ui: &mut Ui) {
        let choices = [
            (Shown::All, "All"),
            (Shown::Of(Surface::Elevator), "Elevator"),
            (Shown::Of(Surface::Aileron), "Aileron"),
            (Shown::Of(Surface::Rudder), "Rudder"),
        ];
        ui.horizontal_wrapped(|ui| {
            crate::panels::choices(ui, &mut self.over, &[(false, "Side by side"), (true, "Over each other")]);
            ui.separator();
            crate::panels::choices(ui, &mut self.shown, &choices);
        });
        if !self.over {
            ui.weak("Blue: control, orange: response.");
        }
        let mut shown = windows_by_time(ctx.session);
        shown.retain(|window| match self.shown {
            Shown::All => true,
            Shown::Of(surface) => window.surface == Some(surface),
        });
        if shown.is_empty() {
            return empty(ui, "No manoeuvre: draw one above the plots of the flight.");
        }
        if self.over {
            return self.overlay.show(ctx, ui, &shown);
        }
        let longest_s = shown.iter().map(|window| window.window.length_s()).fold(0.0, f64::max);
        let width = picture_width(ui.available_size() - vec2(SCROLL_BAR, 0.0), shown.len());
        ScrollArea::vertical().auto_shrink(false).show(ui, |ui| {
            ui.horizontal_wrapped(|ui| {
                ui.spacing_mut().item_spacing = vec2(GAP, GAP);
                shown.iter().for_each(|window| picture(ctx, ui, window, (width, longest_s)));
            });
        });
    }
}

/// The largest width with which `count` pictures fit `room`; as narrow as they may be where they need scrolling.
fn picture_width(room: egui::Vec2, count: usize) -> f32 {
    let width = |columns: usize| (room.x + GAP) / columns as f32 - GAP;
    let fewest = ((room.x + GAP) / (LARGEST_WIDTH + GAP)).ceil().max(1.0) as usize;
    let most = ((room.x + GAP) / (LEAST_WIDTH + GAP)).floor().max(1.0) as usize;
    let fit = |columns: &usize| count.div_ceil(*columns) as f32 * (SHAPE * width(*columns) + GAP) <= room.y;
    width((fewest..=most).find(fit).unwrap_or(most))
}

/// Input and response of one window; `longest_s` is as wide as the picture.
fn picture(ctx: &mut PanelContext<'_>, ui: &mut Ui, window: &Manoeuvre, (width, longest_s): (f32, f64)) {
    let palette = theme::palette(ui);
    let (rect, response) = ui.allocate_exact_size(vec2(width, SHAPE * width), Sense::click());
    let judged = ctx.snapshot.verdicts.latest().and_then(|verdicts| verdicts.windows.get(&window.name));
    let level = judged.map(|judged| judged.verdict.level);
    let word = level.map_or("not judged", |level| level.name());
    let label = format!("picture {}: {word}", window.name);
    response.widget_info(|| WidgetInfo::labeled(Role::Button, true, &label));
    if !ui.is_rect_visible(rect) {
        return;
    }
    let selected = ctx.selection().is_selected(&window.name);
    let edge = if selected { Stroke::new(2.0, palette.accent) } else { Stroke::new(1.0, palette.grid) };
    let painter = ui.painter_at(rect);
    painter.rect(rect, 4.0, ui.visuals().extreme_bg_color, edge, egui::StrokeKind::Inside);
    let part = (window.window.length_s() / longest_s.max(1e-9)) as f32;
    let inner = rect.shrink2(vec2(6.0, 6.0));
    let plot = Rect::from_min_max(inner.min + vec2(0.0, 16.0), inner.max);
    let plot = Rect::from_min_size(plot.min, vec2(plot.width() * part, plot.height()));
    let loaded = ctx.snapshot.flights.get(&window.flight).and_then(|slot| slot.latest());
    for (role, color) in roles(window.surface).into_iter().zip([palette.series[0], palette.series[1]]) {
        let Some(channel) = loaded.and_then(|loaded| loaded.recording.role(role)) else { continue };
        painter.line(curve(&channel.series, window, plot), Stroke::new(1.2, color));
    }
    hatch_excluded(ui, window, plot);
    level_mark::paint(&painter, inner.left_top() + vec2(5.0, 6.0), 4.0, level, level_mark::color(ui, level));
    let font = FontId::proportional(11.0);
    let color = role_color(palette, window.role);
    painter.text(inner.left_top() + vec2(14.0, -1.0), Align2::LEFT_TOP, &window.name, font, color);
    picture_menu(ctx, &response, window);
    let [control, rate] = roles(window.surface).map(notation::role);
    let response = response.on_hover_ui(|ui| {
        ui.label(RichText::new(&window.name).strong());
        ui.label(format!("{}, {word}", window.role.name()));
        ui.label(format!(
            "{control} and {rate}, each over its own range, {} s",
            notation::fixed(window.window.length_s(), 2)
        ));
    });
    if response.clicked() {
        let modifiers = ui.input(|input| input.modifiers);
        select(ctx.state, ctx.session, &window.name, modifiers);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn pictures_use_the_room_there_is() {
        let needed = |width: f32, room: egui::Vec2, count: usize| {
            let columns = ((room.x + GAP) / (width + GAP)).round();
            (count as f32 / columns).ceil() * (SHAPE * width + GAP)
        };
        for (room, count) in [(vec2(1900.0, 1300.0), 35), (vec2(900.0, 800.0), 12)] {
            let width = picture_width(room, count);
            assert!((LEAST_WIDTH..=LARGEST_WIDTH).contains(&width) && needed(width, room, count) <= room.y, "{width}");
        }
        assert!(picture_width(vec2(1900.0, 1300.0), 35) > 1.5 * LEAST_WIDTH);
        // More than fit are scrolled, each at least as wide as it may be.
        let width = picture_width(vec2(600.0, 500.0), 35);
        assert!(width >= LEAST_WIDTH && needed(width, vec2(600.0, 500.0), 35) > 500.0);
        // A panel narrower than a picture has one in a row.
        assert_eq!(picture_width(vec2(100.0, 500.0), 3), 100.0);
    }
}
