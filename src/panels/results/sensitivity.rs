//! Sensitivity of each derivative to the input quantities (thesis 7.2): tornado chart and tables, on request.

use doublet_core::sensitivity::TornadoBar;
use doublet_engine::run::Slot;
use doublet_engine::study::{STEP_FRACTION, SensitivityStudy, Study};
use eframe::egui::{self, ComboBox, RichText, ScrollArea, Ui};
use egui_extras::Column;

use crate::command::{RunCommand, UiCommand};
use crate::panels::{Panel, PanelContext, choices, dim_if, empty, offer, study_button, trouble};
use crate::widgets::chart::{Chart, ChartCurve, ChartStyle};
use crate::widgets::csv_text::csv_text;
use crate::widgets::grid::figures_grid;
use crate::{notation, theme};

const BARS: usize = 10;
/// Changes below this are left out of the chart, per cent.
const LEAST_PERCENT: f64 = 0.01;

#[derive(Default)]
pub struct Sensitivity {
    table: bool,
}

impl Panel for Sensitivity {
    fn show(&mut self, ctx: &mut PanelContext<'_>, ui: &mut Ui) {
        let slot = &ctx.snapshot.studies.sensitivity;
        let mut copied = false;
        ui.horizontal_wrapped(|ui| {
            let hint = "Repeats both steps with every quantity lower and higher; takes seconds";
            study_button(ctx, ui, (Study::Sensitivity, slot), "Compute sensitivity", hint);
            choices(ui, &mut self.table, &[(false, "Tornado"), (true, "Table")]);
            copied = ui.button("Copy as CSV").clicked();
        });
        trouble(ui, slot.error());
        let Some(study) = slot.latest() else {
            let text = "Sensitivity of each derivative to its inputs.";
            if !matches!(slot, Slot::Running { .. }) && offer(ui, text, "Compute it") {
                ctx.commands.push(UiCommand::Run(RunCommand::Study(Study::Sensitivity)));
            }
            return;
        };
        if copied {
            ui.ctx().copy_text(csv(study));
        }
        dim_if(ui, slot.is_stale());
        match self.table {
            true => table(ctx, ui, study),
            false => tornado(ctx, ui, study),
        }
    }
}

/// Bars of the chosen derivative, the widest first.
fn tornado(ctx: &mut PanelContext<'_>, ui: &mut Ui, study: &SensitivityStudy) {
    let mut names: Vec<&String> = study.tornado.iter().map(|bar| &bar.derivative).collect();
    names.dedup();
    let chosen = ctx.selection().derivative.clone().filter(|chosen| names.contains(&chosen));
    // Of constants hardly anybody asks first.
    let slope =
        names.iter().find(|name| name.as_str() == "Cm_alpha").or(names.iter().find(|name| !name.ends_with("_0")));
    let Some(mut chosen) = chosen.or_else(|| slope.or(names.first()).map(|name| (*name).clone())) else {
        return empty(ui, "No derivative depends on the varied quantities.");
    };
    let before = chosen.clone();
    ui.horizontal_wrapped(|ui| {
        let combo = ComboBox::from_id_salt("sensitivity of").selected_text(notation::typeset(&chosen, 13.0));
        combo.show_ui(ui, |ui| {
            for name in &names {
                ui.selectable_value(&mut chosen, (*name).clone(), notation::typeset(name, 13.0));
            }
        });
        ui.weak(format!("every quantity ± {} %, centre of gravity by that part of the chord", 100.0 * STEP_FRACTION));
    });
    if chosen != before {
        ctx.state.selection.derivative = Some(chosen.clone());
    }
    let moved = |bar: &&TornadoBar| bar.change_percent.iter().any(|change| change.abs() > LEAST_PERCENT);
    let own = study.tornado.iter().filter(|bar| bar.derivative == chosen).filter(moved);
    let mut bars: Vec<&TornadoBar> = own.collect();
    let width = |bar: &TornadoBar| bar.change_percent.iter().fold(0.0, |most: f64, change| most.max(change.abs()));
    bars.sort_by(|one, other| width(other).total_cmp(&width(one)));
    bars.truncate(BARS);
    let palette = theme::palette(ui);
    // The widest at the top.
    let place = |at: usize| -(at as f64);
    let across = format!("change of {} [%]", notation::derivative(&chosen));
    let mut chart = Chart::new("tornado of sensitivity", across, "");
    for (side, (name, color)) in [("lower", palette.series[0]), ("higher", palette.series[1])].into_iter().enumerate() {
        let shift = 0.2 * (1.0 - 2.0 * side as f64);
        let points = bars.iter().enumerate().map(|(at, bar)| [bar.change_percent[side], place(at) + shift]);
        chart.curves.push(ChartCurve::new(name, color, ChartStyle::LevelBars(0.36), points.collect()));
    }
    let words = bars
        .iter()
        .enumerate()
        .map(|(at, bar)| (place(at), doublet_engine::notation::sensitivity_quantity(&bar.quantity).to_owned()));
    chart.upright_places = words.collect();
    let height = ui.available_height();
    ctx.chart(ui, &chart, height);
}

/// Relative change of every derivative over one step of every quantity.
fn table(ctx: &mut PanelContext<'_>, ui: &mut Ui, study: &SensitivityStudy) {
    let Some(first) = study.tables.first() else { return };
    let figures = theme::figures(ui);
    ui.weak("Change of each derivative over one step, per cent of itself; orange above one standard error");
    ScrollArea::horizontal().show(ui, |ui| {
        figures_grid(ui, "sensitivity")
            .column(Column::exact(62.0))
            .columns(Column::exact(66.0), study.tables.len())
            .header(20.0, |mut header| {
                header.col(|_| {});
                for table in &study.tables {
                    header.col(|ui| {
                        let step = &table.step;
                        let text = RichText::new(doublet_engine::notation::sensitivity_quantity(&step.quantity.name()))
                            .size(11.0);
                        let hint = format!(
                            "{} ± {} {}",
                            notation::number(step.nominal),
                            notation::number(step.half_width),
                            step.quantity.unit()
                        );
                        ui.add(egui::Label::new(text).truncate()).on_hover_text(hint);
                    });
                }
            })
            .body(|body| {
                body.rows(20.0, first.partials.len(), |mut row| {
                    let name = &first.partials[row.index()].derivative;
                    row.set_selected(ctx.selection().derivative.as_ref() == Some(name));
                    row.col(|ui| {
                        ui.with_layout(egui::Layout::left_to_right(egui::Align::Center), |ui| {
                            ui.label(notation::derivative_job(ui, name));
                        });
                    });
                    for table in &study.tables {
                        row.col(|ui| {
                            let Some(partial) = table.partials.iter().find(|partial| partial.derivative == *name)
                            else {
                                return;
                            };
                            let mut text = RichText::new(notation::fixed(partial.relative_percent, 2));
                            if partial.in_standard_errors.abs() > 1.0 {
                                text = text.color(theme::palette(ui).warning);
                            }
                            ui.label(text.font(figures.clone()).size(11.0)).on_hover_text(format!(
                                "{} per {}",
                                partial.partial,
                                table.step.quantity.unit()
                            ));
                        });
                    }
                });
            });
    });
}

/// All tables as text for other programs.
fn csv(study: &SensitivityStudy) -> String {
    let titles =
        ["derivative", "quantity", "unit", "value", "step", "low", "nominal", "high", "partial", "relative_percent"];
    let mut rows = Vec::new();
    for table in &study.tables {
        let step = &table.step;
        let (quantity, unit) = (step.quantity.name(), step.quantity.unit());
        for p in &table.partials {
            let values = [step.nominal, step.half_width, p.low, p.nominal, p.high, p.partial, p.relative_percent];
            rows.push((&p.derivative, quantity.clone(), unit, values));
        }
    }
    csv_text(&titles, rows)
}
