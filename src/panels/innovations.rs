//! Whether the filter believes the right things: innovations in their band, normalised innovations squared, advice.

use doublet_core::reconstruct::Measurement;
use doublet_engine::stage::WindowPath;
use eframe::egui::{self, RichText, Ui};
use egui_extras::{Column, TableBuilder};

use super::{Panel, PanelContext, View, choices, empty, trouble};
use crate::notation;
use crate::theme;
use crate::widgets::time_plot::{PlotCache, TimePlot, Trace};

/// The panel.
#[derive(Default)]
pub struct Innovations {
    table: bool,
    cache: PlotCache,
}

impl Panel for Innovations {
    fn show(&mut self, ctx: &mut PanelContext<'_>, ui: &mut Ui) {
        let Some(results) = ctx.results() else { return empty(ui, "Choose a window that is in use.") };
        let stale = results.path.is_stale();
        let error = results.path.error().map(str::to_owned);
        let latest = results.path.latest().cloned();
        ui.horizontal(|ui| {
            choices(ui, &mut self.table, &[(false, "Plots"), (true, "Advice")]);
            if let Some(path) = &latest {
                let (mean, expected) = (path.consistency.mean_nis, path.consistency.expected_nis);
                ui.separator();
                ui.label(format!("mean NIS {}, expected {}", notation::fixed(mean, 2), notation::fixed(expected, 2)));
            }
        });
        trouble(ui, error.as_deref());
        let Some(path) = latest else { return };
        if self.table {
            return advice(&path, ui);
        }
        let palette = theme::palette(ui);
        let mut plots = vec![TimePlot {
            levels: vec![path.consistency.expected_nis],
            ..TimePlot::new("NIS", "", vec![Trace { stale, ..Trace::new("NIS", &path.series.nis, palette.series[4]) }])
        }];
        for measurement in Measurement::ALL {
            let index = measurement as usize;
            if path.consistency.channels[index].is_none() {
                continue;
            }
            let (unit, scale) = notation::unit(measurement.dimension());
            let sigma = Some(&path.series.innovation_deviations[index]);
            let band =
                Trace { scale, stale, sigma, ..Trace::new("± 2σ", &path.series.innovation_zero, palette.series[7]) };
            let name = notation::measurement(measurement);
            let innovation =
                Trace { scale, stale, ..Trace::new("innovation", &path.series.innovations[index], palette.series[0]) };
            plots.push(TimePlot::new(name, unit, vec![band, innovation]));
        }
        ctx.stack(ui, "innovations", View::Window, &mut self.cache, &plots, &[]);
    }
}

/// What the innovations say about each entry of R.
fn advice(path: &WindowPath, ui: &mut Ui) {
    let palette = theme::palette(ui);
    let figures = theme::figures(ui);
    TableBuilder::new(ui)
        .id_salt("advice")
        .striped(true)
        .auto_shrink(false)
        .cell_layout(egui::Layout::left_to_right(egui::Align::Center))
        .column(Column::exact(64.0))
        .column(Column::exact(56.0))
        .columns(Column::exact(92.0), 2)
        .column(Column::exact(66.0))
        .column(Column::remainder().clip(true))
        .header(20.0, |mut header| {
            for title in ["Channel", "Updates", "Mean", "RMS", "RMS / σ", "What to change"] {
                header.col(|ui| {
                    ui.weak(title);
                });
            }
        })
        .body(|mut body| {
            for (measurement, channel) in Measurement::ALL.into_iter().zip(&path.consistency.channels) {
                let Some(channel) = channel else { continue };
                let (unit, scale) = notation::unit(measurement.dimension());
                body.row(22.0, |mut row| {
                    row.col(|ui| {
                        ui.label(notation::measurement(measurement));
                    });
                    let cells = [
                        channel.samples.to_string(),
                        format!("{} {unit}", notation::number(scale * channel.mean)),
                        format!("{} {unit}", notation::number(scale * channel.rms)),
                        notation::fixed(channel.ratio, 2),
                    ];
                    for text in cells {
                        row.col(|ui| {
                            ui.label(RichText::new(text).font(figures.clone()).size(11.0));
                        });
                    }
                    row.col(|ui| {
                        let color = if channel.advice == "consistent" { palette.good } else { palette.warning };
                        ui.add(egui::Label::new(RichText::new(&channel.advice).color(color)).truncate())
                            .on_hover_text(&channel.advice);
                    });
                });
            }
        });
}
