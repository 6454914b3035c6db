//! Experiments: named configurations, their results, and the differences between two of them.

use doublet_core::model::Coefficient;
use doublet_engine::compare::{ExperimentRow, PRESENT, SettingDifference, experiment_differences};
use doublet_engine::run::{ExperimentRows, Slot};
use doublet_engine::session::{
    Configuration, Edit, Experiment, ExperimentEdit, Session, cross_experiments, filter_experiments,
    manoeuvre_experiments, noise_experiments, structure_experiments,
};
use doublet_engine::verdict::VerdictCounts;
use eframe::egui::{
    self, Align, Button, Color32, Grid, Label, Layout, ProgressBar, RichText, ScrollArea, TextEdit, Ui,
};
use egui_extras::{Column, TableBuilder, TableRow};

use crate::notation;
use crate::panels::model::experiment_intervals::{self, Shown};
use crate::panels::overlaid;
use crate::panels::{Panel, PanelContext, choices};
use crate::theme;
use crate::widgets::level_mark::level_mark;
use crate::widgets::term::{column_title, column_title_called};

/// Titles of the columns behind the name.
const TITLES: [&str; 6] = ["Verdict", "NIS", "R²", "honest R²", "ΔAIC", "validation error"];
/// Height of a row.
const ROW: f32 = 20.0;
/// Part of the height that the table has at most.
const TABLE_PART: f32 = 0.45;
/// Opacity of what is out of date.
const STALE: f32 = 0.5;

/// The panel.
#[derive(Default)]
pub struct Experiments {
    name: String,
    new_name: String,
    coefficient: Option<&'static str>,
    /// Names of the chosen rows, at most two.
    chosen: Vec<String>,
    differences: Option<Compared>,
}

/// Two configurations and the settings that differ between them.
struct Compared {
    of: [Configuration; 2],
    settings: Vec<SettingDifference>,
}

impl Panel for Experiments {
    fn show(&mut self, ctx: &mut PanelContext<'_>, ui: &mut Ui) {
        ctx.wanted.inquiry.experiments = true;
        ui.horizontal_wrapped(|ui| {
            self.keep(ctx, ui);
            add(ctx, ui);
            progress(ctx, ui);
        });
        let session = ctx.session;
        self.chosen.retain(|name| name == PRESENT || session.experiment(name).is_some());
        let rows = &ctx.snapshot.inquiries.experiments;
        let coefficients = coefficients(rows.0.iter().filter_map(|(_, slot)| slot.latest()).map(AsRef::as_ref));
        let Some(&first) = coefficients.first() else {
            return crate::panels::awaiting(ctx, ui, "the experiments", "No experiment has derivatives.");
        };
        let mut coefficient = self.coefficient.filter(|name| coefficients.contains(name)).unwrap_or(first);
        let all: Vec<_> = coefficients.iter().map(|name| (*name, *name)).collect();
        ui.horizontal_wrapped(|ui| {
            choices(ui, &mut coefficient, &all);
            ui.weak("Click a row to choose it, two rows to compare them; Overlay draws it in the plots.");
        });
        self.coefficient = Some(coefficient);
        let height = (ROW * (rows.0.len() as f32 + 2.0)).min(TABLE_PART * ui.available_height());
        ui.push_id("board", |ui| self.table(ctx, ui, coefficient, height));
        ui.separator();
        ScrollArea::vertical().id_salt("below the board").auto_shrink(false).show(ui, |ui| {
            self.actions(ctx, ui);
            self.differing(ctx, ui);
            let title = format!("Derivatives of {coefficient} with 95 % intervals");
            ui.label(notation::typeset_in(&title, 11.5, ui.visuals().strong_text_color()));
            let shown = rows.0.iter().enumerate().filter_map(|(index, (name, slot))| {
                let chosen = self.chosen.contains(name);
                let is_faint = !self.chosen.is_empty() && !chosen;
                Some(Shown { row: slot.latest()?, color: color(ui, index), is_faint })
            });
            let shown: Vec<_> = shown.collect();
            experiment_intervals::show(ui, &shown, coefficient);
        });
    }
}

impl Experiments {
    /// A name, and the button that keeps the present configuration under it.
    fn keep(&mut self, ctx: &mut PanelContext<'_>, ui: &mut Ui) {
        let usual = free_name(ctx.session);
        let field = ui.add(TextEdit::singleline(&mut self.name).hint_text(&usual).desired_width(130.0));
        ui.ctx().accesskit_node_builder(field.id, |node| node.set_label("name of the experiment"));
        let typed = self.name.trim();
        let wanted = if typed.is_empty() { usual } else { typed.to_owned() };
        let name = ctx.session.free_experiment_name(&wanted);
        // A name that is taken keeps what it has: the button says which one is used instead.
        let title = if name == wanted { "Keep".to_owned() } else { format!("Keep as {name}") };
        let button = ui.add_enabled(name != PRESENT, Button::new(title));
        let hint = "Save filter, noise, structure, manoeuvres and estimator of the session under this name";
        let is_confirmed = field.lost_focus() && ui.input(|input| input.key_pressed(egui::Key::Enter));
        if button.on_hover_text(hint).clicked() || is_confirmed && name != PRESENT {
            ctx.edit(Edit::Experiment(ExperimentEdit::Keep(name)));
            self.name.clear();
        }
    }

    fn table(&mut self, ctx: &mut PanelContext<'_>, ui: &mut Ui, coefficient: &str, height: f32) {
        let rows = &ctx.snapshot.inquiries.experiments;
        let overlaid = overlaid::names(ctx.state, ctx.session);
        TableBuilder::new(ui)
            .striped(true)
            .sense(egui::Sense::click())
            .max_scroll_height(height)
            .auto_shrink([false, true])
            .cell_layout(Layout::right_to_left(Align::Center))
            .column(Column::remainder().at_least(110.0).clip(true))
            .column(Column::exact(50.0))
            .column(Column::exact(96.0))
            .columns(Column::exact(58.0), TITLES.len() - 2)
            .column(Column::exact(86.0))
            .header(30.0, |mut header| {
                header.col(|_| {});
                header.col(|ui| {
                    column_title(ui, "Overlay");
                });
                for title in TITLES {
                    header.col(|ui| {
                        if title == TITLES[0] {
                            column_title_called(ui, "derivatives\ngood/caution/bad", title);
                            return;
                        }
                        column_title(ui, title);
                    });
                }
            })
            .body(|mut body| {
                for (index, (name, slot)) in rows.0.iter().enumerate() {
                    body.row(ROW, |mut row| {
                        row.set_selected(self.chosen.contains(name));
                        let switched = cells(&mut row, (index, name.as_str()), (slot, &overlaid), coefficient);
                        if switched {
                            overlaid::toggle(ctx.state, ctx.session, name);
                        } else if row.response().clicked() {
                            self.choose(name);
                        }
                    });
                }
            });
    }

    /// Chooses a row, or no more; of three the first is dropped.
    fn choose(&mut self, name: &str) {
        let before = self.chosen.len();
        self.chosen.retain(|chosen| chosen != name);
        if self.chosen.len() == before {
            self.chosen.push(name.to_owned());
        }
        if self.chosen.len() > 2 {
            self.chosen.remove(0);
        }
        self.new_name.clear();
    }

    /// What can be done with the chosen experiment.
    fn actions(&mut self, ctx: &mut PanelContext<'_>, ui: &mut Ui) {
        let [name] = self.chosen.as_slice() else { return };
        let name = name.clone();
        let Some(experiment) = ctx.session.experiment(&name) else { return };
        let is_current = *experiment.configuration == Configuration::from_session(ctx.session);
        ui.horizontal_wrapped(|ui| {
            ui.strong(&name);
            let button = ui.add_enabled(!is_current, Button::new("Make current"));
            let button =
                button.on_hover_text("Use this configuration in the session; one undo step restores the old one");
            if button.on_disabled_hover_text("The session already has this configuration").clicked() {
                ctx.edit(Edit::Experiment(ExperimentEdit::Apply(name.clone())));
            }
            let field = TextEdit::singleline(&mut self.new_name).hint_text("new name").desired_width(110.0);
            let field = ui.add(field);
            ui.ctx().accesskit_node_builder(field.id, |node| node.set_label("new name of the experiment"));
            let to = self.new_name.trim().to_owned();
            let is_free = !to.is_empty() && to != PRESENT && ctx.session.experiment(&to).is_none();
            if ui.add_enabled(is_free, Button::new("Rename")).clicked() {
                ctx.edit(Edit::Experiment(ExperimentEdit::Rename { from: name.clone(), to: to.clone() }));
                ctx.state.overlaid.iter_mut().filter(|one| **one == name).for_each(|one| one.clone_from(&to));
                self.chosen = vec![to];
                self.new_name.clear();
            }
            if ui.button("Remove").clicked() {
                ctx.edit(Edit::Experiment(ExperimentEdit::Drop(name)));
                self.chosen.clear();
            }
        });
    }

    /// Settings that differ between the two chosen rows, or between the chosen one and the session.
    fn differing(&mut self, ctx: &PanelContext<'_>, ui: &mut Ui) {
        let [first, second] = match self.chosen.as_slice() {
            [one] if one != PRESENT => [PRESENT, one.as_str()],
            [first, second] => [first.as_str(), second.as_str()],
            _ => return,
        };
        let Some(of) = configuration(ctx.session, first).zip(configuration(ctx.session, second)) else { return };
        let of = [of.0, of.1];
        if self.differences.as_ref().is_none_or(|known| known.of != of) {
            let settings = experiment_differences(ctx.session, &of[0], &of[1]).unwrap_or_default();
            self.differences = Some(Compared { of, settings });
        }
        let Some(Compared { settings, .. }) = &self.differences else { return };
        if settings.is_empty() {
            ui.label(format!("{first} and {second} have the same settings."));
            return;
        }
        Grid::new("settings that differ").num_columns(3).striped(true).show(ui, |ui| {
            for title in ["Setting", first, second] {
                ui.label(RichText::new(title).size(11.0).weak());
            }
            ui.end_row();
            for difference in settings {
                let value = |value: &Option<String>| match value {
                    Some(value) if difference.unit.is_empty() => value.clone(),
                    Some(value) => format!("{value} {}", difference.unit),
                    None => "not set".to_owned(),
                };
                ui.add(Label::new(&difference.setting).extend());
                for text in [value(&difference.first), value(&difference.second)] {
                    ui.add(Label::new(text).wrap());
                }
                ui.end_row();
            }
        });
    }
}

/// The configuration of a row.
fn configuration(session: &Session, name: &str) -> Option<Configuration> {
    if name == PRESENT {
        return Some(Configuration::from_session(session));
    }
    session.experiment(name).map(|experiment| Configuration::clone(&experiment.configuration))
}

/// The first name nothing has yet.
fn free_name(session: &Session) -> String {
    let mut names = (1..).map(|number| format!("Experiment {number}"));
    names.find(|name| session.experiment(name).is_none()).unwrap_or_default()
}

/// The menu of usual experiments.
fn add(ctx: &mut PanelContext<'_>, ui: &mut Ui) {
    let session = ctx.session;
    let mut added: Option<Vec<Experiment>> = None;
    ui.menu_button("Add experiments", |ui| {
        let filters = "Extended, iterated and unscented filter with smoothed and filtered path; the path as measured";
        if ui.button("All filters").on_hover_text(filters).clicked() {
            added = Some(filter_experiments(session));
        }
        if ui.button("Half and twice the measurement noise").clicked() {
            added = Some(noise_experiments(session));
        }
        let sets = manoeuvre_experiments(session);
        let halves = "Odd manoeuvres identify and even ones validate, then the reverse";
        if ui.button("Odd and even manoeuvres").on_hover_text(halves).clicked() {
            added = Some(sets.clone());
        }
        ui.separator();
        for (coefficient, _) in &session.structure.models {
            let coefficient: Coefficient = *coefficient;
            ui.menu_button(format!("{} without each term", coefficient.name()), |ui| {
                if ui.button("By all manoeuvres").clicked() {
                    added = Some(structure_experiments(session, coefficient));
                }
                if ui.button("By odd and even manoeuvres").on_hover_text(halves).clicked() {
                    added = Some(cross_experiments(&structure_experiments(session, coefficient), &sets));
                }
            });
        }
    });
    if let Some(experiments) = added {
        ctx.edit(Edit::Experiment(ExperimentEdit::Add(experiments)));
    }
}

/// How many rows are computed.
fn progress(ctx: &PanelContext<'_>, ui: &mut Ui) {
    let rows = &ctx.snapshot.inquiries.experiments;
    let part = rows.0.iter().map(|(_, slot)| if let Slot::Running { progress, .. } = slot { *progress } else { 1.0 });
    if let Some((done, all)) = count_experiments(rows) {
        ui.add(ProgressBar::new(part.sum::<f32>() / all as f32).desired_width(120.0).desired_height(8.0));
        ui.weak(format!("{done} of {all} computed"));
    }
}

/// How many experiments are computed, and how many there are; none where nothing is being computed.
pub fn count_experiments(rows: &ExperimentRows) -> Option<(usize, usize)> {
    let all = rows.0.len();
    let left = rows.0.iter().filter(|(_, slot)| matches!(slot, Slot::Running { .. })).count();
    (left > 0).then_some((all - left, all))
}

/// Coefficients that some row has, in their usual order.
fn coefficients<'a>(rows: impl Iterator<Item = &'a ExperimentRow> + Clone) -> Vec<&'static str> {
    let has = |name: &&str| rows.clone().any(|row| row.outcome.coefficient(name).is_some());
    Coefficient::ALL.map(Coefficient::name).into_iter().filter(has).collect()
}

/// Colour of a row: that of text for the session, one of the series for an experiment.
fn color(ui: &Ui, index: usize) -> Color32 {
    let series = &theme::palette(ui).series;
    index.checked_sub(1).map_or(ui.visuals().strong_text_color(), |index| series[index % series.len()])
}

/// The switch that draws an experiment over the session; whether it was clicked.
fn overlay_switch(ui: &mut Ui, name: &str, place: Option<usize>) -> bool {
    let (rect, response) = ui.allocate_exact_size(egui::vec2(30.0, 16.0), egui::Sense::click());
    let faint = ui.visuals().weak_text_color().gamma_multiply(if response.hovered() { 1.0 } else { 0.55 });
    let ink = place.map_or(faint, |place| overlaid::color(ui, place));
    let edge = egui::Stroke::new(1.0, if place.is_some() { ink } else { faint.gamma_multiply(0.6) });
    ui.painter().rect_stroke(rect, 3.0, edge, egui::StrokeKind::Inside);
    let ends = [rect.left_center() + egui::vec2(5.0, 0.0), rect.right_center() - egui::vec2(5.0, 0.0)];
    ui.painter().extend(egui::Shape::dashed_line(&ends, egui::Stroke::new(2.0, ink), 5.0, 3.0));
    let label = format!("overlay {name}");
    response.widget_info(|| egui::WidgetInfo::selected(egui::Role::CheckBox, true, place.is_some(), &label));
    let hint = "Draw its curves over the session: Reconstruction, Innovations, Fits, Intervals";
    response.on_hover_cursor(egui::CursorIcon::PointingHand).on_hover_text(hint).clicked()
}

/// The cells of a row; whether its overlay was switched.
fn cells(
    row: &mut TableRow<'_, '_>,
    (index, name): (usize, &str),
    (slot, overlaid): (&Slot<ExperimentRow>, &[String]),
    coefficient: &str,
) -> bool {
    let mut switched = false;
    let latest = slot.latest();
    let opacity = if slot.is_stale() && slot.error().is_none() { STALE } else { 1.0 };
    row.col(|ui| {
        ui.with_layout(Layout::left_to_right(Align::Center), |ui| {
            let (dot, _) = ui.allocate_exact_size(egui::vec2(10.0, 10.0), egui::Sense::hover());
            ui.painter().circle_filled(dot.center(), 4.0, color(ui, index));
            let is_current = index > 0 && latest.is_some_and(|row| row.is_current);
            let text = if is_current { format!("{name} (current)") } else { name.to_owned() };
            let label = ui.add(Label::new(RichText::new(&text)).truncate().selectable(false));
            if let Some(error) = slot.error() {
                label.on_hover_text(error);
            }
        });
    });
    row.col(|ui| {
        // The session itself is always drawn.
        if index > 0 {
            ui.add_space(6.0);
            switched = overlay_switch(ui, name, overlaid.iter().position(|other| other == name));
        }
    });
    row.col(|ui| {
        ui.multiply_opacity(opacity);
        match (slot.error(), latest) {
            (Some(error), _) => {
                ui.label(RichText::new("failed").color(theme::palette(ui).error)).on_hover_text(error);
            }
            (None, Some(row)) => verdict(ui, row.outcome.verdict),
            (None, None) => drop(ui.weak("–")),
        }
    });
    let fit = latest.and_then(|row| row.outcome.coefficient(coefficient)?.fit.as_ref());
    let outcome = latest.map(|row| &row.outcome);
    let fixed = |value: Option<f64>, digits| value.map_or("–".to_owned(), |value| notation::fixed(value, digits));
    let figures = [
        fixed(outcome.and_then(|outcome| outcome.nis), 2),
        fixed(fit.map(|fit| fit.r_squared), 4),
        fixed(fit.and_then(|fit| fit.honest_r_squared), 4),
        fixed(fit.and_then(|fit| fit.delta_akaike), 0),
        fixed(outcome.and_then(|outcome| outcome.validation_error), 3),
    ];
    for text in figures {
        row.col(|ui| {
            ui.multiply_opacity(opacity);
            let text = RichText::new(text).font(theme::figures(ui)).size(11.5);
            ui.add(Label::new(text).selectable(false));
        });
    }
    switched
}

/// The level of a verdict, and its derivatives that are good, a caution and bad.
fn verdict(ui: &mut Ui, counts: VerdictCounts) {
    let VerdictCounts { level, good, caution, bad } = counts;
    let text = RichText::new(format!("{good}/{caution}/{bad}")).font(theme::figures(ui)).size(11.0);
    let hint = format!("Session {}; derivatives: {good} good, {caution} caution, {bad} bad", level.name());
    ui.add(Label::new(text).selectable(false)).on_hover_text(&hint);
    level_mark(ui, Some(level)).on_hover_text(hint);
}
