//! Residuals of the chosen window: autocorrelation with the band of white noise, histogram beside a normal distribution.

use doublet_core::model::Coefficient;
use doublet_engine::stage::ResidualStudy;
use eframe::egui::Ui;

use crate::panels::{PanelContext, awaiting, choices};
use crate::widgets::chart::{Chart, ChartCurve, ChartStyle};
use crate::{notation, theme};

/// Draws both charts of the coefficient that is chosen above them.
pub fn show(ctx: &mut PanelContext<'_>, ui: &mut Ui, chosen: &mut Coefficient) {
    let studies = ctx.details().map(|details| details.residuals.as_slice()).unwrap_or_default();
    let Some(first) = studies.first() else {
        return awaiting(ctx, ui, "the fits of this manoeuvre", "This manoeuvre has no fit.");
    };
    let all: Vec<_> = studies.iter().map(|study| (study.coefficient, study.coefficient.name())).collect();
    let study_of = |coefficient| studies.iter().find(|study| study.coefficient == coefficient).unwrap_or(first);
    // A coefficient this window lacks stays chosen for the next window; the one shown in its place is highlighted.
    let mut shown = study_of(*chosen).coefficient;
    if choices(ui, &mut shown, &all) {
        *chosen = shown;
    }
    let study = study_of(shown);
    let (probability, verdict) =
        (study.whiteness.probability, if study.whiteness.is_white() { "white" } else { "not white" });
    ui.weak(format!("{verdict}: p-value of white noise {}", notation::probability(probability)));
    let height = 0.5 * ui.available_height() - 6.0;
    let correlation = correlation(study, ui);
    ctx.chart(ui, &correlation, height);
    let histogram = histogram(study, ui);
    ctx.chart(ui, &histogram, height);
}

/// Autocorrelation of a residual with the bounds of white noise.
pub fn correlation(study: &ResidualStudy, ui: &Ui) -> Chart {
    let palette = theme::palette(ui);
    let values = study.whiteness.autocorrelation.iter().enumerate();
    let points: Vec<_> = values.map(|(lag, value)| [lag as f64 * study.step_s, *value]).collect();
    let mut chart = Chart::new("autocorrelation of the residual", "lag [s]", "autocorrelation");
    let band = study.whiteness.band;
    let color = palette.warning;
    let end = points.last().map_or(0.0, |point| point[0]);
    for (edge, name) in [(band, "95 % band of white noise"), (-band, "")] {
        chart.curves.push(ChartCurve::new(name, color, ChartStyle::Dashed, vec![[0.0, edge], [end, edge]]));
    }
    let name = study.coefficient.name();
    chart.curves.push(ChartCurve::new(name, palette.series[0], ChartStyle::Line, points));
    chart
}

fn histogram(study: &ResidualStudy, ui: &Ui) -> Chart {
    let palette = theme::palette(ui);
    let histogram = &study.histogram;
    let middle = |bin: usize| histogram.left + (bin as f64 + 0.5) * histogram.width;
    let counts = histogram.counts.iter().enumerate().map(|(bin, count)| [middle(bin), *count as f64]);
    let normal = histogram.normal.iter().enumerate().map(|(bin, count)| [middle(bin), *count]);
    let mut chart =
        Chart::new("histogram of the residual", format!("residual of {}", study.coefficient.name()), "samples");
    let bars = ChartStyle::Bars(0.95 * histogram.width);
    chart.curves.push(ChartCurve::new("residual", palette.series[0], bars, counts.collect()));
    chart.curves.push(ChartCurve::new("normal", palette.series[1], ChartStyle::Line, normal.collect()));
    chart
}
