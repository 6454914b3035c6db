//! Beside the fits: the residual of one coefficient as spectrum and autocorrelation, and the channels that move with it where it was
//! clicked.

use doublet_core::model::Coefficient;
use doublet_engine::stage::{CoherentChannel, Misfit, MisfitPlace, ResidualStudy};
use eframe::egui::{self, Label, ProgressBar, RichText, ScrollArea, Ui};

use crate::panels::model::residuals;
use crate::panels::{PanelContext, caption, choices, trouble};
use crate::widgets::chart::Chart;
use crate::widgets::spectrum_chart::{spectrum_chart, spectrum_curve, white_bounds};
use crate::{notation, theme};

/// Height of a chart of the column.
const CHART_HEIGHT: f32 = 170.0;
/// Channels listed.
const MOST: usize = 8;
/// Columns of the list of channels.
const SHARE: f32 = 64.0;

/// Draws the column; `place` is forgotten when its list is closed.
pub fn show(ctx: &mut PanelContext<'_>, ui: &mut Ui, chosen: &mut Coefficient, place: &mut Option<MisfitPlace>) {
    ScrollArea::vertical().id_salt("beside the fits").auto_shrink(false).show(ui, |ui| {
        if place.is_some() {
            channels(ctx, ui, place);
            ui.separator();
        } else {
            ui.add(
                Label::new(RichText::new("Click a plot to list the channels coherent with the residual.").weak())
                    .wrap(),
            );
        }
        let studies = ctx.details().map(|details| details.residuals.as_slice()).unwrap_or_default();
        let Some(first) = studies.first() else { return };
        let all: Vec<_> = studies.iter().map(|study| (study.coefficient, study.coefficient.name())).collect();
        let study_of = |coefficient| studies.iter().find(|study| study.coefficient == coefficient).unwrap_or(first);
        let mut shown = study_of(*chosen).coefficient;
        ui.weak("Residual of");
        if choices(ui, &mut shown, &all) {
            *chosen = shown;
        }
        let study = study_of(shown);
        if let Some(chart) = spectrum(study, ui) {
            ctx.chart(ui, &chart, CHART_HEIGHT);
        }
        let correlation = residuals::correlation(study, ui);
        ctx.chart(ui, &correlation, CHART_HEIGHT);
        let verdict = if study.whiteness.is_white() { "White" } else { "Not white" };
        let probability = notation::probability(study.whiteness.probability);
        ui.weak(format!("{verdict}: p-value of white noise {probability}"));
    });
}

/// Spectrum of a residual with the bounds of white noise.
fn spectrum(study: &ResidualStudy, ui: &Ui) -> Option<Chart> {
    let found = study.spectrum.as_ref()?;
    let palette = theme::palette(ui);
    let mut chart = spectrum_chart("spectrum of the residual", &found.frequency_hz, "");
    chart.curves.push(spectrum_curve(study.coefficient.name(), found, 1.0, palette.series[0]));
    chart.curves.extend(white_bounds(found, 1.0, palette.warning));
    Some(chart)
}

/// The channels that move with the residual where it was clicked.
fn channels(ctx: &PanelContext<'_>, ui: &mut Ui, place: &mut Option<MisfitPlace>) {
    let Some(at) = *place else { return };
    ui.horizontal_wrapped(|ui| {
        let time = notation::fixed(at.time_s, 2);
        ui.label(notation::typeset(&format!("Correlated with Δ{} at {time} s", at.coefficient.name()), 13.0));
        if ui.small_button("✖").on_hover_text("Close the list").clicked() {
            *place = None;
        }
    });
    let found = ctx.details().and_then(|details| details.misfit.as_ref());
    match found {
        Some(Ok(found)) if found.place == at => list(ctx, ui, found),
        Some(Err(error)) => trouble(ui, Some(&error.to_string())),
        _ => {
            ui.horizontal(|ui| {
                ui.spinner();
                ui.weak("computing");
            });
        }
    }
}

fn list(ctx: &PanelContext<'_>, ui: &mut Ui, found: &Misfit) {
    let [from, to] = [found.part.start_s, found.part.end_s].map(|time_s| notation::fixed(time_s, 1));
    let size = notation::number(found.residual_deviation);
    let bound = notation::fixed(100.0 * found.bound, 0);
    caption(ui, &format!("{from} to {to} s, residual ± {size}"));
    let figures = theme::figures(ui);
    egui::Grid::new("channels with the residual").num_columns(3).striped(true).spacing([8.0, 3.0]).show(ui, |ui| {
        for title in ["Channel", "Coherent", "Moves by"] {
            ui.label(RichText::new(title).size(11.0).weak());
        }
        ui.end_row();
        for one in found.channels.iter().take(MOST) {
            let (name, moves) = channel_name_and_amplitude(ctx, one);
            let is_chance = one.share < found.bound;
            let ink = if is_chance { ui.visuals().weak_text_color() } else { ui.visuals().text_color() };
            let hover = one.role.map_or(one.name.as_str(), |role| role.description());
            ui.add(Label::new(notation::typeset_in(&name, 13.0, ink)).selectable(false)).on_hover_text(hover);
            let text = format!("{} %", notation::fixed(100.0 * one.share, 0));
            let bar = ProgressBar::new(one.share as f32).desired_width(SHARE).desired_height(13.0).corner_radius(2.0);
            let fill = theme::palette(ui).series[0].gamma_multiply(if is_chance { 0.25 } else { 0.55 });
            let bar = ui.add(bar.fill(fill).text(RichText::new(&text).size(10.5)));
            bar.widget_info(|| {
                egui::WidgetInfo::labeled(egui::Role::Label, true, format!("{} coherent {text}", one.name))
            });
            ui.label(RichText::new(moves).font(figures.clone()).size(11.5).color(ink));
            ui.end_row();
        }
    });
    let hint = format!("Fraction of the residual power coherent with the channel. Below {bound} %: not significant.");
    ui.add(Label::new(RichText::new(hint).size(11.0).weak()).wrap());
}

/// Name of a channel, and how far it moves with its unit.
fn channel_name_and_amplitude(ctx: &PanelContext<'_>, one: &CoherentChannel) -> (String, String) {
    let (name, (unit, scale)) = match one.role {
        Some(role) => (notation::role(role).to_owned(), ctx.state.units.of_role(role)),
        None => (one.name.clone(), (one.unit.as_str(), 1.0)),
    };
    (name, format!("± {} {unit}", notation::number(scale * one.deviation)).trim_end().to_owned())
}
