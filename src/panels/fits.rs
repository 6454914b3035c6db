//! Observed coefficients with fit, residual or prediction in the selected manoeuvre; quality of the prediction of each manoeuvre.

use doublet_core::model::Coefficient;
use doublet_engine::stage::CoefficientFit;
use eframe::egui::{self, RichText, ScrollArea, Sense, Ui, vec2};
use egui_extras::{Column, TableBuilder};

use super::{Panel, PanelContext, View, awaiting, choices, empty, residuals, role_color, trouble};
use crate::notation;
use crate::theme;
use crate::widgets::heat_strip::{self, HeatStrips};
use crate::widgets::term::column_title;
use crate::widgets::ticks::draw_time_axis;
use crate::widgets::time_plot::{PlotCache, TIME_AXIS_HEIGHT, TimePlot, Trace, TraceStyle};

/// What is looked at.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
enum Aspect {
    #[default]
    Fit,
    Residual,
    Prediction,
    Contributions,
    Information,
    Whiteness,
    Table,
}

/// The panel.
pub struct Fits {
    aspect: Aspect,
    studied: Coefficient,
    cache: PlotCache,
}

impl Default for Fits {
    fn default() -> Self {
        Self { aspect: Aspect::default(), studied: Coefficient::CX, cache: PlotCache::default() }
    }
}

impl Panel for Fits {
    fn show(&mut self, ctx: &mut PanelContext<'_>, ui: &mut Ui) {
        let all = [
            (Aspect::Fit, "Fit"),
            (Aspect::Residual, "Residual"),
            (Aspect::Prediction, "Prediction"),
            (Aspect::Contributions, "Contributions"),
            (Aspect::Information, "Information"),
            (Aspect::Whiteness, "Whiteness"),
            (Aspect::Table, "Table"),
        ];
        choices(ui, &mut self.aspect, &all);
        if self.aspect == Aspect::Table {
            return table(ctx, ui);
        }
        let Some(window) = ctx.window() else { return empty(ui, "Select a manoeuvre that is in use.") };
        let Some(results) = ctx.results() else { return empty(ui, "This manoeuvre is ignored.") };
        trouble(ui, results.aero.error().or(results.fits.error()));
        match self.aspect {
            Aspect::Contributions => return self.contributions(ctx, ui),
            Aspect::Information => return information(ctx, ui),
            Aspect::Whiteness => return residuals::show(ctx, ui, &mut self.studied),
            _ => {}
        }
        let stale = results.fits.is_stale();
        let (Some(aero), Some(fits)) = (results.aero.latest(), results.fits.latest()) else {
            return awaiting(ctx, ui, "the fits of this manoeuvre", "This manoeuvre has no fit.");
        };
        let colors = theme::palette(ui).series;
        let pooled = ctx.snapshot.pooled.latest();
        let mut plots = Vec::new();
        for fit in &fits.fits {
            let name = fit.coefficient.name();
            let observed = Trace {
                stale,
                style: TraceStyle::Dots,
                ..Trace::new("observed", &aero.series[fit.coefficient as usize], colors[1])
            };
            let line = |name, series| Trace { stale, ..Trace::new(name, series, colors[0]) };
            let traces = match self.aspect {
                Aspect::Prediction => {
                    let predictions = pooled.into_iter().flat_map(|pooled| &pooled.predictions);
                    let of_this = predictions.filter(|p| p.window == window.name && p.coefficient == fit.coefficient);
                    let predicted = of_this.flat_map(|p| {
                        let identified = Trace { stale, ..Trace::new("identified constant", &p.identified, colors[2]) };
                        [line("own constant", &p.own_constant), identified]
                    });
                    [observed].into_iter().chain(predicted).collect()
                }
                Aspect::Residual => fit.series.iter().map(|series| line("residual", &series.residual)).collect(),
                _ => {
                    [observed].into_iter().chain(fit.series.iter().map(|series| line("fit", series.fitted()))).collect()
                }
            };
            plots.push(TimePlot::new(name, "", traces));
            if self.aspect == Aspect::Fit {
                let residual = |series| Trace { stale, ..Trace::new("residual", series, colors[4]) };
                let below = fit.series.iter().map(|series| residual(&series.residual)).collect();
                plots.push(TimePlot { levels: vec![0.0], ..TimePlot::new(residual_name(fit), "", below).high(0.6) });
            }
        }
        for fit in &fits.fits {
            said(fit, ui);
        }
        ctx.stack(ui, "fits", View::Window, &mut self.cache, &plots, &[]);
    }
}

impl Fits {
    /// What each term adds to the fit of each coefficient.
    fn contributions(&mut self, ctx: &mut PanelContext<'_>, ui: &mut Ui) {
        let (Some(details), Some(aero)) = (ctx.details(), ctx.results().and_then(|results| results.aero.latest()))
        else {
            return awaiting(ctx, ui, "the fits of this manoeuvre", "This manoeuvre has no fit.");
        };
        let colors = theme::palette(ui).series;
        let names: Vec<Vec<String>> = details
            .contributions
            .iter()
            .map(|part| part.terms.iter().map(|(name, _)| notation::derivative(name)).collect())
            .collect();
        let plots: Vec<TimePlot<'_>> = details
            .contributions
            .iter()
            .zip(&names)
            .map(|(part, names)| {
                let observed = Trace {
                    style: TraceStyle::Dots,
                    ..Trace::new("observed", &aero.series[part.coefficient as usize], colors[7])
                };
                let terms = part.terms.iter().zip(names).enumerate();
                let terms = terms.map(|(at, ((_, series), name))| Trace::new(name, series, colors[at % 7]));
                TimePlot::new(part.coefficient.name(), "", [observed].into_iter().chain(terms).collect())
            })
            .collect();
        ctx.stack(ui, "contributions", View::Window, &mut self.cache, &plots, &[]);
    }
}

/// Which seconds of the chosen window tell which derivative.
fn information(ctx: &mut PanelContext<'_>, ui: &mut Ui) {
    let Some(details) = ctx.details() else {
        return awaiting(ctx, ui, "the fits of this manoeuvre", "This manoeuvre has no fit.");
    };
    ui.weak("Information on each derivative over time, with all others of its coefficient estimated too. Dark: no information.");
    let range = ctx.state.window_time.range();
    ScrollArea::vertical().auto_shrink(false).show(ui, |ui| {
        for found in &details.information {
            ui.label(notation::derivative_job(ui, &format!("{}_", found.coefficient.name())));
            let rows: Vec<(String, Vec<f64>)> =
                found.shares.iter().map(|(name, shares)| (notation::derivative(name), shares.clone())).collect();
            let name = format!("information on {}", found.coefficient.name());
            ctx.figures.extend(HeatStrips { name: &name, edges_s: &found.edges_s, rows: &rows, range }.show(ui));
        }
        let (axis, _) = ui.allocate_exact_size(vec2(ui.available_width(), TIME_AXIS_HEIGHT), Sense::hover());
        let axis = heat_strip::frame(axis);
        draw_time_axis(ui, axis, range, 84.0);
    });
}

/// What the residual of a coefficient is called.
fn residual_name(fit: &CoefficientFit) -> &'static str {
    match fit.coefficient {
        Coefficient::CX => "ΔCX",
        Coefficient::CY => "ΔCY",
        Coefficient::CZ => "ΔCZ",
        Coefficient::CD => "ΔCD",
        Coefficient::CL => "ΔCL",
        Coefficient::Cl => "ΔCl",
        Coefficient::Cm => "ΔCm",
        Coefficient::Cn => "ΔCn",
    }
}

/// Why a coefficient has no fit.
fn said(fit: &CoefficientFit, ui: &mut Ui) {
    if let Err(error) = &fit.fit {
        trouble(ui, Some(&format!("{}: {error}", fit.coefficient.name())));
    }
}

/// How well every window is predicted from all identification windows, with their constants and with its own.
fn table(ctx: &mut PanelContext<'_>, ui: &mut Ui) {
    let palette = theme::palette(ui);
    let figures = theme::figures(ui);
    let Some(pooled) = ctx.snapshot.pooled.latest() else { return empty(ui, "No identification manoeuvre.") };
    if ctx.snapshot.pooled.is_stale() {
        ui.multiply_opacity(0.45);
    }
    TableBuilder::new(ui)
        .id_salt("predictions")
        .striped(true)
        .auto_shrink(false)
        .cell_layout(egui::Layout::left_to_right(egui::Align::Center))
        .column(Column::remainder().at_least(120.0).clip(true))
        .column(Column::exact(92.0))
        .column(Column::exact(76.0))
        .column(Column::exact(88.0))
        .column(Column::exact(60.0))
        .column(Column::exact(94.0))
        .column(Column::exact(60.0))
        .header(20.0, |mut header| {
            let titles = ["Manoeuvre", "Use", "Coefficient", "R² identified", "RMS [%]", "R² own const.", "RMS [%]"];
            for title in titles {
                header.col(|ui| {
                    column_title(ui, title);
                });
            }
        })
        .body(|body| {
            body.rows(20.0, pooled.predictions.len(), |mut row| {
                let prediction = &pooled.predictions[row.index()];
                row.col(|ui| {
                    ui.label(&prediction.window);
                });
                row.col(|ui| {
                    let color = role_color(palette, prediction.role);
                    ui.label(RichText::new(prediction.role.name()).color(color));
                });
                row.col(|ui| {
                    ui.label(notation::derivative_job(ui, &format!("{}_", prediction.coefficient.name())));
                });
                for quality in [&prediction.quality_identified, &prediction.quality_own_constant] {
                    for text in
                        [notation::fixed(quality.r_squared, 4), notation::fixed(quality.rms_relative_percent, 2)]
                    {
                        row.col(|ui| {
                            ui.label(RichText::new(text).font(figures.clone()));
                        });
                    }
                }
            });
        });
}
