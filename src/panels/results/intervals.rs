//! One derivative from every window with its interval, beside the estimate from all of them.

use std::collections::BTreeMap;

use doublet_core::statistics::NORMAL_95;
use doublet_engine::stage::CoefficientFit;
use eframe::egui::{ComboBox, Ui};

use crate::command::{FileCommand, UiCommand};
use crate::panels::overlaid::Overlaid;
use crate::panels::{PanelContext, awaiting, is_window_constant, lacks_estimate};
use crate::widgets::chart::{Chart, ChartCurve, ChartStyle};
use crate::{notation, theme};

/// Distance of the estimates of an overlaid experiment from those of the session, in manoeuvres.
const OFFSET: f64 = 0.18;
/// Longest name below a window.
const NAME_LENGTH: usize = 3;

/// Draws the chart of the chosen derivative.
pub fn show(ctx: &mut PanelContext<'_>, ui: &mut Ui) {
    let Some(pooled) = ctx.snapshot.pooled.latest() else {
        return awaiting(ctx, ui, "the derivatives of every manoeuvre", &lacks_estimate(ctx));
    };
    let names: Vec<&String> = pooled
        .fits
        .iter()
        .filter_map(|fit| fit.fit.as_ref().ok())
        .flat_map(|fit| &fit.names)
        .filter(|name| !is_window_constant(name))
        .collect();
    let chosen = ctx.selection().derivative.clone().filter(|chosen| names.contains(&chosen));
    let Some(mut chosen) = chosen.or_else(|| names.first().map(|name| (*name).clone())) else {
        return crate::panels::empty(ui, "No derivative is estimated.");
    };
    ui.horizontal_wrapped(|ui| {
        let combo = ComboBox::from_id_salt("interval of").selected_text(notation::typeset(&chosen, 13.0));
        let combo = combo.show_ui(ui, |ui| {
            for name in &names {
                ui.selectable_value(&mut chosen, (*name).clone(), notation::typeset(name, 13.0));
            }
        });
        ui.ctx().accesskit_node_builder(combo.response.id, |node| node.set_label("derivative shown"));
        let hint = "Mark values of another session, a table or a Digital DATCOM listing";
        if ui.button("Add reference…").on_hover_text(hint).clicked() {
            ctx.commands.push(UiCommand::File(FileCommand::AddReference));
        }
        if !ctx.references.is_empty() && ui.button("Remove references").clicked() {
            ctx.commands.push(UiCommand::File(FileCommand::ClearReferences));
        }
    });
    if ctx.selection().derivative.is_some() || Some(&&chosen) != names.first() {
        ctx.state.selection.derivative = Some(chosen.clone());
    }
    let chart = chart(ctx, ui, &chosen);
    let height = ui.available_height();
    ctx.chart(ui, &chart, height);
}

/// Estimate and the larger of its standard errors.
pub fn estimate(fits: &[CoefficientFit], name: &str) -> Option<(f64, f64)> {
    fits.iter().find_map(|fit| {
        let estimate = fit.fit.as_ref().ok()?;
        let at = estimate.names.iter().position(|other| other == name)?;
        let corrected = fit.corrected_errors.get(at).copied().filter(|error| error.is_finite());
        Some((estimate.estimates[at], corrected.unwrap_or(estimate.standard_errors[at])))
    })
}

/// Draws the estimates of an experiment, beside those of the session, and its estimate from all manoeuvres.
fn overlay(chart: &mut Chart, ctx: &PanelContext<'_>, other: &Overlaid<'_>, (name, aside): (&str, f64)) {
    let used = ctx.session.active_windows().filter(|window| {
        let fits = ctx.snapshot.windows.get(&window.name).and_then(|results| results.fits.latest());
        fits.is_some_and(|fits| estimate(&fits.fits, name).is_some())
    });
    let mut points = ChartCurve::new(other.name, other.color, ChartStyle::Dots(3.0), Vec::new());
    for (place, window) in used.enumerate() {
        let fits = other.window(&window.name).and_then(|results| results.fits.latest());
        if let Some((value, error)) = fits.and_then(|fits| estimate(&fits.fits, name)) {
            points.points.push([place as f64 + aside, value]);
            points.spread.push(NORMAL_95 * error);
        }
    }
    let last = chart.places.len().saturating_sub(1) as f64;
    if let Some((value, _)) = other.results.pooled.latest().and_then(|pooled| estimate(&pooled.fits, name)) {
        let ends = vec![[-0.5, value], [last + 0.5, value]];
        let of_all = format!("{}, all manoeuvres", other.name);
        chart.curves.push(ChartCurve::new(of_all, other.color, ChartStyle::Dashed, ends));
    }
    chart.curves.push(points);
}

fn chart(ctx: &PanelContext<'_>, ui: &Ui, name: &str) -> Chart {
    let palette = theme::palette(ui);
    let label = format!("{} ± {NORMAL_95} corrected standard errors", notation::derivative(name));
    let mut chart = Chart::new("estimates of every manoeuvre", "manoeuvre", label);
    let mut kinds: BTreeMap<&str, ChartCurve> = BTreeMap::new();
    let used = ctx.session.active_windows();
    let with_estimate = used.filter_map(|window| {
        let fits = ctx.snapshot.windows.get(&window.name)?.fits.latest()?;
        Some((window, estimate(&fits.fits, name)?))
    });
    let mut selected = ChartCurve::new("selected", palette.cursor, ChartStyle::Dots(6.0), Vec::new());
    for (place, (window, (value, error))) in with_estimate.enumerate() {
        let place = place as f64;
        if ctx.selection().is_selected(&window.name) {
            selected.points.push([place, value]);
        }
        let count = kinds.len();
        let kind = if window.kind.is_empty() { "other" } else { window.kind.as_str() };
        let curve = kinds.entry(kind).or_insert_with(|| {
            ChartCurve::new(kind, palette.series[count % palette.series.len()], ChartStyle::Dots(3.5), Vec::new())
        });
        curve.points.push([place, value]);
        curve.spread.push(NORMAL_95 * error);
        chart.places.push((place, window.name.chars().take(NAME_LENGTH).collect::<String>().trim().to_owned()));
    }
    chart.curves.extend(Some(selected).filter(|selected| !selected.points.is_empty()));
    let last = chart.places.len().saturating_sub(1) as f64;
    for (at, other) in Overlaid::all(ctx, ui).into_iter().enumerate() {
        overlay(&mut chart, ctx, &other, (name, OFFSET * (at as f64 + 1.0)));
    }
    if let Some((value, error)) = ctx.snapshot.pooled.latest().and_then(|pooled| estimate(&pooled.fits, name)) {
        let ends = |value: f64| vec![[-0.5, value], [last + 0.5, value]];
        chart.curves.push(ChartCurve::new("all manoeuvres", palette.good, ChartStyle::Line, ends(value)));
        for edge in [value - NORMAL_95 * error, value + NORMAL_95 * error] {
            chart.curves.push(ChartCurve::new("", palette.good, ChartStyle::Dashed, ends(edge)));
        }
    }
    for (at, reference) in ctx.references.iter().enumerate() {
        let color = palette.series[(at + 3) % palette.series.len()];
        let Some((value, error)) = reference.get(name) else { continue };
        let mut mark =
            ChartCurve::new(&reference.name, color, ChartStyle::Line, vec![[-0.5, value], [last + 0.5, value]]);
        if let Some(error) = error {
            mark.spread = vec![NORMAL_95 * error; 2];
        }
        chart.curves.push(mark);
    }
    chart.curves.extend(kinds.into_values());
    chart
}
