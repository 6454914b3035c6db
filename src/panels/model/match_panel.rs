//! Proof of match: a validation manoeuvre as measured and as simulated by the model, with tolerance bands, pass or fail.

use doublet_core::validate::{BandResult, TestResult};
use doublet_engine::stage::{ProofOfMatch, WindowReplay};
use eframe::egui::{self, RichText, Ui};
use egui_extras::Column;

use crate::panels::{Panel, PanelContext, View, awaiting, choices, dim_if, empty, lacks_estimate, trouble};
use crate::widgets::grid::texts_grid;
use crate::widgets::term::column_titles;
use crate::widgets::time_plot::{PlotCache, TimePlot, Trace, TraceStyle};
use crate::{notation, theme};

#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
enum Aspect {
    #[default]
    Bands,
    Signals,
    Theil,
    Tests,
}

#[derive(Default)]
pub struct Match {
    aspect: Aspect,
    cache: PlotCache,
}

impl Panel for Match {
    fn show(&mut self, ctx: &mut PanelContext<'_>, ui: &mut Ui) {
        let all = [
            (Aspect::Bands, "Bands"),
            (Aspect::Signals, "All signals"),
            (Aspect::Theil, "Theil"),
            (Aspect::Tests, "All tests"),
        ];
        choices(ui, &mut self.aspect, &all);
        let slot = &ctx.snapshot.proof;
        trouble(ui, slot.error());
        let stale = slot.is_stale();
        let Some(proof) = slot.latest() else { return awaiting(ctx, ui, "the simulation", &lacks_estimate(ctx)) };
        if self.aspect == Aspect::Tests {
            return tests(ctx, proof, stale, ui);
        }
        let replay = match ctx.window().and_then(|window| proof.window(&window.name)) {
            None => return offer(ctx, proof, ui),
            Some(Err(error)) => return trouble(ui, Some(&error.to_string())),
            Some(Ok(replay)) => replay.clone(),
        };
        for test in &replay.tests {
            verdict(test, ui);
        }
        if replay.tests.is_empty() {
            ui.weak(format!("No test of {} applies to this manoeuvre.", proof.tolerances));
        }
        if self.aspect == Aspect::Theil {
            return theil(&replay, stale, ui);
        }
        self.plots(ctx, &replay, stale, ui);
    }
}

impl Match {
    /// Measured with its band, simulated on top.
    fn plots(&mut self, ctx: &mut PanelContext<'_>, replay: &WindowReplay, stale: bool, ui: &mut Ui) {
        let colors = theme::palette(ui).series;
        let units = ctx.state.units;
        let shown = |half_band: bool| half_band || self.aspect == Aspect::Signals;
        let signals = replay.series.iter().filter(|series| shown(series.half_band.is_some()));
        let plots: Vec<_> = signals
            .map(|series| {
                let (unit, scale) = units.for_dimension(series.signal.dimension());
                let measured = Trace {
                    scale,
                    stale,
                    sigma: series.half_band.as_ref(),
                    style: TraceStyle::Dashed,
                    ..Trace::new("measured", &series.measured, colors[1])
                };
                let simulated = Trace { scale, stale, ..Trace::new("simulated", &series.simulated, colors[0]) };
                TimePlot::new(notation::signal(series.signal), unit, vec![measured, simulated])
            })
            .collect();
        if plots.is_empty() {
            return empty(ui, "No tolerance band for this manoeuvre: show all signals.");
        }
        ctx.stack(ui, "match", View::Window, &mut self.cache, &plots, &[]);
    }
}

/// The windows that were flown again, to choose from.
fn offer(ctx: &mut PanelContext<'_>, proof: &ProofOfMatch, ui: &mut Ui) {
    if proof.windows.is_empty() {
        return empty(ui, "The model simulates validation manoeuvres: mark a manoeuvre as validation.");
    }
    ui.vertical_centered(|ui| {
        ui.add_space((0.3 * ui.available_height()).max(0.0));
        ui.weak("The model simulates validation manoeuvres: select one, or mark this manoeuvre as validation.");
        ui.add_space(6.0);
        egui::ScrollArea::vertical().id_salt("validation manoeuvres").show(ui, |ui| {
            for (window, _) in &proof.windows {
                if ui.button(window.as_str()).clicked() {
                    ctx.choose(window);
                }
            }
        });
    });
}

/// One test in one line: its bands and how much of each is used.
fn verdict(test: &TestResult, ui: &mut Ui) {
    let palette = theme::palette(ui);
    ui.horizontal_wrapped(|ui| {
        let (text, color) = if test.passed() { ("pass", palette.good) } else { ("fail", palette.error) };
        ui.label(RichText::new(text).strong().color(color));
        ui.strong(format!("{} {}", test.id, test.name));
        let choices: Vec<_> =
            test.requirements.iter().map(|bands| bands.iter().map(used).collect::<Vec<_>>().join(" or ")).collect();
        ui.add(egui::Label::new(choices.join(", and ")).wrap())
            .on_hover_text("Largest difference as a fraction of the tolerance (limit 100 %).");
    });
}

fn used(band: &BandResult) -> String {
    format!("{} {} %", notation::signal(band.tolerance.signal), notation::fixed(100.0 * band.worst_ratio, 0))
}

/// Theil's coefficient of every signal and what its error is made of.
fn theil(replay: &WindowReplay, stale: bool, ui: &mut Ui) {
    dim_if(ui, stale);
    let figures = theme::figures(ui);
    texts_grid(ui, "theil")
        .column(Column::remainder().at_least(120.0).clip(true))
        .columns(Column::exact(86.0), 4)
        .header(20.0, |header| column_titles(header, ["Signal", "Theil U", "Bias", "Variance", "Covariance"]))
        .body(|body| {
            body.rows(20.0, replay.theil.len(), |mut row| {
                let (signal, theil) = &replay.theil[row.index()];
                row.col(|ui| {
                    ui.label(notation::signal(*signal)).on_hover_text(signal.description());
                });
                for value in [theil.coefficient, theil.bias, theil.variance, theil.covariance] {
                    row.col(|ui| {
                        ui.label(RichText::new(notation::fixed(value, 3)).font(figures.clone()));
                    });
                }
            });
        });
}

/// Every test of every window; a click chooses the window.
fn tests(ctx: &mut PanelContext<'_>, proof: &ProofOfMatch, stale: bool, ui: &mut Ui) {
    let palette = theme::palette(ui);
    ui.weak(&proof.tolerances);
    let rows: Vec<(&str, Option<&TestResult>, Option<String>)> = proof
        .windows
        .iter()
        .flat_map(|(window, replay)| match replay {
            Ok(replay) => replay.tests.iter().map(|test| (window.as_str(), Some(test), None)).collect(),
            Err(error) => vec![(window.as_str(), None, Some(error.to_string()))],
        })
        .collect();
    if rows.is_empty() {
        return empty(ui, "No validation manoeuvre has a test: mark one as validation and set its surface.");
    }
    dim_if(ui, stale);
    texts_grid(ui, "tests")
        .column(Column::exact(170.0).clip(true))
        .column(Column::exact(240.0).clip(true))
        .column(Column::exact(56.0))
        .column(Column::remainder().clip(true))
        .header(20.0, |header| column_titles(header, ["Manoeuvre", "Test", "", "Fraction of the tolerance used"]))
        .body(|body| {
            body.rows(20.0, rows.len(), |mut row| {
                let (window, test, error) = &rows[row.index()];
                row.col(|ui| {
                    if ui.add(egui::Label::new(*window).truncate().sense(egui::Sense::click())).clicked() {
                        ctx.choose(window);
                    }
                });
                row.col(|ui| {
                    ui.label(test.map(|test| format!("{} {}", test.id, test.name)).unwrap_or_default());
                });
                row.col(|ui| {
                    let passed = test.is_some_and(TestResult::passed);
                    let (text, color) = if passed { ("pass", palette.good) } else { ("fail", palette.error) };
                    ui.label(RichText::new(text).strong().color(color));
                });
                row.col(|ui| {
                    let used =
                        |test: &TestResult| test.requirements.iter().flatten().map(used).collect::<Vec<_>>().join("  ");
                    let text = error.clone().unwrap_or_else(|| test.map(used).unwrap_or_default());
                    ui.label(text);
                });
            });
        });
}
