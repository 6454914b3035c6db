//! Observed coefficients with fit, residual or prediction in the selected manoeuvre; quality of the prediction of each manoeuvre.

use doublet_core::model::Coefficient;
use doublet_core::series::Series;
use doublet_engine::session::Manoeuvre;
use doublet_engine::stage::{CoefficientFit, FittedSeries, Misfit, MisfitPlace, Prediction};
use eframe::egui::{self, RichText, ScrollArea, Sense, Ui, vec2};
use egui_extras::Column;

use crate::panels::model::{misfit, residuals};
use crate::panels::overlaid::Overlaid;
use crate::panels::{Panel, PanelContext, View, awaiting, choices, dim_if, empty, lacks_estimate, role_color, trouble};
use crate::widgets::grid::texts_grid;
use crate::widgets::heat_strip::{self, HeatStrips};
use crate::widgets::term::column_titles;
use crate::widgets::ticks::draw_time_axis;
use crate::widgets::time_plot::{PlotCache, SpanMark, TIME_AXIS_HEIGHT, TimePlot, Trace, TraceStyle};
use crate::{notation, theme};

/// Width of the panel from which a column stands beside the fits, and that of the column: a part of it between limits.
const BESIDE: f32 = 640.0;
const COLUMN: f32 = 0.32;
const LEAST_COLUMN: f32 = 236.0;
const MOST_COLUMN: f32 = 400.0;

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

pub struct Fits {
    aspect: Aspect,
    studied: Coefficient,
    /// Where the residual was clicked, with the name of the manoeuvre.
    place: Option<(String, MisfitPlace)>,
    cache: PlotCache,
}

impl Default for Fits {
    fn default() -> Self {
        Self { aspect: Aspect::default(), studied: Coefficient::CX, place: None, cache: PlotCache::default() }
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
        let (Some(_), Some(fits)) = (results.aero.latest(), results.fits.latest()) else {
            return awaiting(ctx, ui, "the fits of this manoeuvre", "This manoeuvre has no fit.");
        };
        fits.fits.iter().for_each(|fit| draw_fit_error(fit, ui));
        if self.place.as_ref().is_some_and(|(of, _)| *of != window.name) {
            self.place = None;
        }
        ctx.wanted.misfit = self.place.as_ref().map(|(_, place)| *place);
        let room = ui.available_width();
        if self.aspect != Aspect::Fit || room < BESIDE {
            return self.plots(ctx, ui, window);
        }
        let column = (COLUMN * room).clamp(LEAST_COLUMN, MOST_COLUMN);
        let height = ui.available_height();
        ui.horizontal_top(|ui| {
            let down = egui::Layout::top_down(egui::Align::Min);
            ui.allocate_ui_with_layout(vec2(room - column - 10.0, height), down, |ui| self.plots(ctx, ui, window));
            ui.allocate_ui_with_layout(vec2(column, height), down, |ui| {
                ui.set_width(column);
                let mut place = self.place.as_ref().map(|(_, place)| *place);
                misfit::show(ctx, ui, &mut self.studied, &mut place);
                self.place = self.place.take().zip(place).map(|((of, _), place)| (of, place));
            });
        });
    }
}

impl Fits {
    /// The plots of every coefficient; a click in one looks at its residual there.
    fn plots(&mut self, ctx: &mut PanelContext<'_>, ui: &mut Ui, window: &Manoeuvre) {
        let Some(results) = ctx.results() else { return };
        let stale = results.fits.is_stale();
        let (Some(aero), Some(fits)) = (results.aero.latest(), results.fits.latest()) else { return };
        let colors = theme::palette(ui).series;
        let pooled = ctx.snapshot.pooled.latest();
        let bands = ctx.details().map(|details| details.bands.as_slice()).unwrap_or_default();
        let others = Overlaid::all(ctx, ui);
        let (mut plots, mut coefficients) = (Vec::new(), Vec::new());
        for fit in &fits.fits {
            let name = fit.coefficient.name();
            let series = &aero.series[fit.coefficient as usize];
            let style = TraceStyle::Dots;
            let observed = Trace { stale, style, ..Trace::new("observed", series, colors[7]) };
            let line = |name, series| Trace { stale, ..Trace::new(name, series, colors[0]) };
            let over = |curve: fn(&FittedSeries) -> &Series| overlaid(&others, &window.name, fit.coefficient, curve);
            let traces = match self.aspect {
                Aspect::Prediction => {
                    let predictions = pooled.into_iter().flat_map(|pooled| &pooled.predictions);
                    let is_this = |p: &&Prediction| p.window == window.name && p.coefficient == fit.coefficient;
                    let predicted = predictions.filter(is_this).flat_map(|p| {
                        let identified = Trace { stale, ..Trace::new("identified constant", &p.identified, colors[2]) };
                        [line("own constant", &p.own_constant), identified]
                    });
                    let others = others.iter().filter_map(|other| {
                        let found = other.results.pooled.latest()?.predictions.iter().find(is_this)?;
                        Some(other.trace(&found.own_constant, 1.0))
                    });
                    [observed].into_iter().chain(predicted).chain(others).collect()
                }
                Aspect::Residual => {
                    let own = fit.series.iter().map(|series| line("residual", &series.residual));
                    own.chain(over(|of| &of.residual)).collect()
                }
                _ => {
                    let half = bands.iter().find(|(of, _)| *of == fit.coefficient).map(|(_, half)| half);
                    let sigma = half.filter(|half| half.len() == series.values.len());
                    let own = fit.series.iter().map(|of| Trace { sigma, ..line("fit ± 95 % band", of.fitted()) });
                    [observed].into_iter().chain(own).chain(over(FittedSeries::fitted)).collect()
                }
            };
            plots.push(TimePlot::new(name, "", traces));
            coefficients.push(fit.coefficient);
            if self.aspect == Aspect::Fit {
                let residual = |series| Trace { stale, ..Trace::new("residual", series, colors[4]) };
                let own = fit.series.iter().map(|series| residual(&series.residual));
                let below = own.chain(over(|of| &of.residual)).collect();
                plots.push(TimePlot { levels: vec![0.0], ..TimePlot::new(residual_name(fit), "", below).high(0.6) });
                coefficients.push(fit.coefficient);
            }
        }
        let looked_at = ctx.details().and_then(|details| details.misfit.as_ref()?.as_ref().ok());
        let looked_at = looked_at.filter(|found| self.place.as_ref().is_some_and(|(_, place)| found.place == *place));
        let span = |found: &Misfit| SpanMark { part: found.part, color: colors[4], selected: true };
        let spans: Vec<SpanMark> = looked_at.map(span).into_iter().collect();
        let response = ctx.stack(ui, "fits", View::Window, &mut self.cache, &plots, &spans);
        let row = response.hovered_plot.and_then(|row| coefficients.get(row));
        if let Some((time_s, coefficient)) = response.clicked_s.zip(row.copied()) {
            self.studied = coefficient;
            self.place = Some((window.name.clone(), MisfitPlace { coefficient, time_s }));
        }
    }

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

/// Curves of the fits of a coefficient by the overlaid experiments.
fn overlaid<'a>(
    others: &[Overlaid<'a>],
    window: &str,
    coefficient: Coefficient,
    curve: fn(&'a FittedSeries) -> &'a Series,
) -> impl Iterator<Item = Trace<'a>> {
    others.iter().filter_map(move |other| {
        let fits = other.window(window)?.fits.latest()?;
        let fit = fits.fits.iter().find(|fit| fit.coefficient == coefficient)?;
        Some(other.trace(curve(fit.series.as_ref()?), 1.0))
    })
}

/// Which seconds of the chosen window tell which derivative.
fn information(ctx: &mut PanelContext<'_>, ui: &mut Ui) {
    let Some(details) = ctx.details() else {
        return awaiting(ctx, ui, "the fits of this manoeuvre", "This manoeuvre has no fit.");
    };
    ui.weak("Information on each derivative over time, all other derivatives free. Darker: more. Blank: none.");
    let range = ctx.state.window_time.range();
    let excluded = ctx.window().map_or(&[][..], |window| &window.excluded);
    ScrollArea::vertical().auto_shrink(false).show(ui, |ui| {
        for found in &details.information {
            ui.label(notation::derivative_job(ui, &format!("{}_", found.coefficient.name())));
            let rows: Vec<(String, Vec<f64>)> =
                found.shares.iter().map(|(name, shares)| (notation::derivative(name), shares.clone())).collect();
            let name = format!("information on {}", found.coefficient.name());
            let strips = HeatStrips { name: &name, edges_s: &found.edges_s, rows: &rows, range, excluded };
            ctx.figures.extend(strips.show(ui));
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
fn draw_fit_error(fit: &CoefficientFit, ui: &mut Ui) {
    if let Err(error) = &fit.fit {
        trouble(ui, Some(&format!("{}: {error}", fit.coefficient.name())));
    }
}

/// How well every window is predicted from all identification windows, with their constants and with its own.
fn table(ctx: &mut PanelContext<'_>, ui: &mut Ui) {
    let palette = theme::palette(ui);
    let figures = theme::figures(ui);
    let Some(pooled) = ctx.snapshot.pooled.latest() else { return empty(ui, &lacks_estimate(ctx)) };
    dim_if(ui, ctx.snapshot.pooled.is_stale());
    texts_grid(ui, "predictions")
        .column(Column::remainder().at_least(120.0).clip(true))
        .column(Column::exact(92.0))
        .column(Column::exact(76.0))
        .column(Column::exact(88.0))
        .column(Column::exact(60.0))
        .column(Column::exact(94.0))
        .column(Column::exact(60.0))
        .header(20.0, |header| {
            let titles = ["Manoeuvre", "Use", "Coefficient", "R² identified", "RMS [%]", "R² own const.", "RMS [%]"];
            column_titles(header, titles);
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
