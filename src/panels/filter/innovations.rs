//! Check of the noise settings: innovations in their band, normalised innovation squared, advice.

use std::sync::Arc;

use doublet_engine::stage::WindowPath;
use eframe::egui::{Label, RichText, Ui};
use egui_extras::Column;

use crate::panels::filter::noise_advice;
use crate::panels::overlaid::Overlaid;
use crate::panels::{Panel, PanelContext, View, awaiting, choices, consistency_color, empty, trouble};
use crate::widgets::grid::texts_grid;
use crate::widgets::term::column_titles;
use crate::widgets::time_plot::{PlotCache, TimePlot, Trace};
use crate::{notation, theme};

#[derive(Default)]
pub struct Innovations {
    table: bool,
    cache: PlotCache,
}

impl Panel for Innovations {
    fn show(&mut self, ctx: &mut PanelContext<'_>, ui: &mut Ui) {
        let Some(results) = ctx.results() else {
            return awaiting(ctx, ui, "the manoeuvres", "Select a manoeuvre that is in use.");
        };
        let stale = results.path.is_stale();
        let error = results.path.error().map(str::to_owned);
        let latest = results.path.latest().cloned();
        ui.horizontal(|ui| {
            choices(ui, &mut self.table, &[(false, "Plots"), (true, "Advice")]);
            if let Some(consistency) = latest.as_ref().and_then(|path| path.assessment().consistency.as_ref()) {
                let [low, high] = consistency.nis_band_correlated.map(|edge| notation::fixed(edge, 2));
                let [mean, ratio] =
                    [consistency.nis_mean, consistency.nis_ratio].map(|value| notation::fixed(value, 2));
                ui.separator();
                let expected = notation::fixed(consistency.nis_mean / consistency.nis_ratio, 2);
                let text = format!("mean NIS {mean}, expected {expected} (ratio {ratio}, 95 % limits {low} to {high})");
                ui.add(Label::new(text).truncate()).on_hover_text(
                    "NIS: normalised innovation squared of all measurements of an update; its expectation is their number",
                );
            }
        });
        trouble(ui, error.as_deref());
        let Some(path) = latest else {
            return awaiting(ctx, ui, "the path of this manoeuvre", "This manoeuvre has no flight path.");
        };
        if self.table {
            return advice(ctx, &path, ui);
        }
        let palette = theme::palette(ui);
        let Some(consistency) = &path.assessment().consistency else {
            return empty(ui, "No measurements in this manoeuvre.");
        };
        let window = ctx.selection().window.clone().unwrap_or_default();
        let others = Overlaid::all(ctx, ui);
        let others: Vec<_> =
            others.iter().filter_map(|other| Some((other, other.window(&window)?.path.latest()?.series()))).collect();
        let mut nis = vec![Trace { stale, ..Trace::new("NIS", &path.series().nis, palette.series[4]) }];
        nis.extend(others.iter().map(|(other, series)| other.trace(&series.nis, 1.0)));
        let levels = vec![consistency.nis_mean / consistency.nis_ratio];
        let mut plots = vec![TimePlot { levels, ..TimePlot::new("NIS of all", "", nis) }];
        for channel in &consistency.channels {
            let measurement = channel.measurement;
            let index = measurement as usize;
            let (unit, scale) = ctx.unit(measurement.dimension());
            let sigma = Some(&path.series().innovation_deviations[index]);
            let band =
                Trace {
                    scale, stale, sigma, ..Trace::new("± 2σ", &path.series().innovation_zero, palette.series[7])
                };
            let name = notation::measurement(measurement);
            let innovation = Trace {
                scale,
                stale,
                ..Trace::new("innovation", &path.series().innovations[index], palette.series[0])
            };
            let overlaid = others.iter().map(|(other, series)| other.trace(&series.innovations[index], scale));
            let traces = [band, innovation].into_iter().chain(overlaid).collect();
            plots.push(TimePlot { fit_bands: true, ..TimePlot::new(name, unit, traces) });
        }
        ctx.stack(ui, "innovations", View::Window, &mut self.cache, &plots, &[]);
    }
}

/// Titles of the columns of advice.
const TITLES: [&str; 6] = ["Channel", "Updates", "Mean [σ]", "RMS [σ]", "White", "What to change"];
/// Width of all columns but the last, with the spaces between them.
const NUMBERS: f32 = 64.0 + 56.0 + 2.0 * 74.0 + 48.0 + 60.0;

/// What the innovations say about each entry of R.
fn advice(ctx: &PanelContext<'_>, path: &WindowPath, ui: &mut Ui) {
    let figures = theme::figures(ui);
    let channels = path.assessment().consistency.as_ref().map_or(&[][..], |consistency| &consistency.channels);
    let width = (ui.available_width() - NUMBERS).max(120.0);
    let advised: Vec<_> = channels
        .iter()
        .map(|channel| {
            let advice = noise_advice::find(ctx, channel.measurement);
            let advice = advice.map_or_else(String::new, |advice| noise_advice::advice_text(ctx, advice));
            let mut job = notation::typeset_in(&advice, 12.5, consistency_color(ui, channel));
            job.wrap.max_width = width;
            ui.painter().layout_job(job)
        })
        .collect();
    let heights: Vec<f32> = advised.iter().map(|advice| (advice.size().y + 4.0).max(22.0)).collect();
    texts_grid(ui, "advice")
        .column(Column::exact(64.0))
        .column(Column::exact(56.0))
        .columns(Column::exact(74.0), 2)
        .column(Column::exact(48.0))
        .column(Column::remainder().clip(true))
        .header(20.0, |header| column_titles(header, TITLES))
        .body(|body| {
            body.heterogeneous_rows(heights.into_iter(), |mut row| {
                let channel = &channels[row.index()];
                let advice = Arc::clone(&advised[row.index()]);
                row.col(|ui| {
                    ui.label(notation::measurement(channel.measurement));
                });
                let cells = [
                    channel.samples.to_string(),
                    notation::fixed(channel.mean, 2),
                    notation::fixed(channel.deviation_ratio, 2),
                    if channel.is_white { "yes" } else { "no" }.to_owned(),
                ];
                for text in cells {
                    row.col(|ui| {
                        ui.label(RichText::new(text).font(figures.clone()).size(11.0));
                    });
                }
                row.col(|ui| {
                    ui.label(advice);
                });
            });
        });
}
