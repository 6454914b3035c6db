//! Experiments: named configurations, their results, and the differences between two of them.

use doublet_core::model::{Coefficient, Structure};
use doublet_engine::compare::{ExperimentRow, PRESENT};
use doublet_engine::run::{ExperimentRows, Slot};
use doublet_engine::session::{
    Configuration, Edit, Experiment, ExperimentEdit, Session, cross_experiments, filter_experiments,
    manoeuvre_experiments, noise_experiments, structure_experiments,
};
use doublet_engine::verdict::{Level, VerdictCounts};
use eframe::egui::{self, Align, Button, Color32, Label, Layout, ProgressBar, RichText, ScrollArea, TextEdit, Ui};
use egui_extras::{Column, TableBuilder, TableRow};

use crate::panels::model::experiment_intervals::{Axis, interval};
use crate::panels::model::experiment_tables::{Differences, scores_csv};
use crate::panels::model::terms::PRESETS;
use crate::panels::{EditRequest, Panel, PanelContext, choices, empty, lacks_estimate, overlaid, waiting};
use crate::widgets::level_mark::level_mark;
use crate::widgets::term::{column_title, column_title_called};
use crate::{notation, theme};

/// Titles and widths of the columns behind the name, and how narrow a panel still has them: 0 for one with room for all.
const COLUMNS: [(&str, f32, u8); 8] = [
    ("Verdict", 98.0, 3),
    ("NIS ratio", 58.0, 1),
    ("R²", 50.0, 1),
    ("honest R²", 58.0, 2),
    ("PSE", 66.0, 0),
    ("ΔAIC", 50.0, 2),
    ("ΔBIC", 50.0, 0),
    ("validation error", 86.0, 1),
];
/// Widths of name and overlay, of an interval (least and most), and between columns.
const NAME: f32 = 150.0;
const OVERLAY: f32 = 46.0;
const INTERVAL: [f32; 2] = [44.0, 150.0];
const GAP: f32 = 4.0;
/// Size of the letters above an interval: the longest names fit the least width.
const TITLE: f32 = 11.5;
/// Height of a row, and of the titles, which have two lines.
const ROW: f32 = 20.0;
const HEADER: f32 = 36.0;
/// Part of the height that the table has at most where something is compared below it.
const TABLE_PART: f32 = 0.6;
/// What the mark of the current experiment means.
const CURRENT: &str = "The session has this configuration";
/// Opacity of what is out of date, and of intervals of rows that are not chosen while others are.
const STALE: f32 = 0.5;
const FAINT: f32 = 0.3;

#[derive(Default)]
pub struct Experiments {
    name: String,
    new_name: String,
    coefficient: Option<&'static str>,
    /// Names of the chosen rows, at most two.
    chosen: Vec<String>,
    /// Title of the column that orders the rows, and whether the largest are first.
    order: Option<(String, bool)>,
    /// First derivative shown, where not all fit.
    first: usize,
    differences: Differences,
}

impl Panel for Experiments {
    fn show(&mut self, ctx: &mut PanelContext<'_>, ui: &mut Ui) {
        ctx.wanted.inquiry.experiments = true;
        ui.horizontal_wrapped(|ui| {
            self.keep(ctx, ui);
            add(ctx, ui);
            if ui
                .button("Copy scores as CSV")
                .on_hover_text("Copy the scores of every coefficient to the clipboard")
                .clicked()
            {
                ui.ctx().copy_text(scores_csv(&ctx.snapshot.inquiries.experiments));
            }
            progress(ctx, ui);
        });
        let session = ctx.session;
        self.chosen.retain(|name| name == PRESENT || session.experiment(name).is_some());
        let rows = &ctx.snapshot.inquiries.experiments;
        let coefficients = coefficients(rows.0.iter().filter_map(|(_, slot)| slot.latest()).map(AsRef::as_ref));
        let Some(&first) = coefficients.first() else {
            let is_computed =
                |(_, slot): &(String, Slot<ExperimentRow>)| slot.latest().is_some() || slot.error().is_some();
            if rows.0.is_empty() || !rows.0.iter().all(is_computed) {
                return waiting(ctx, ui, "the experiments");
            }
            return empty(ui, &lacks_estimate(ctx));
        };
        let mut coefficient = self.coefficient.filter(|name| coefficients.contains(name)).unwrap_or(first);
        let all: Vec<_> = coefficients.iter().map(|name| (*name, *name)).collect();
        choices(ui, &mut coefficient, &all);
        let hint = "Click a row, or two to compare; a title orders them; Overlay draws it in the plots.";
        ui.add(Label::new(RichText::new(hint).size(11.0).weak()).truncate()).on_hover_text(hint);
        self.coefficient = Some(coefficient);
        let known: Vec<&ExperimentRow> =
            rows.0.iter().filter_map(|(_, slot)| slot.latest()).map(AsRef::as_ref).collect();
        let axes = Axis::all(session, &known, coefficient);
        let fitting = Fitting::new(ui, axes.len());
        let (all, fits) = (axes.len(), fitting.intervals);
        let show_hidden = |ui: &mut Ui| {
            if fits < all && ui.small_button("Next derivatives").on_hover_text(format!("{fits} of {all} fit")).clicked()
            {
                self.first += fits;
            }
            fitting.name_hidden(ui);
        };
        if fits < all || fitting.narrow > 0 {
            ui.horizontal_wrapped(show_hidden);
        }
        self.first = if fits < all { self.first % all } else { 0 };
        let axes = &axes[self.first..all.min(self.first + fits)];
        let part = if self.chosen.is_empty() { 1.0 } else { TABLE_PART };
        let height = (ROW * (rows.0.len() as f32 + 2.0)).min(part * ui.available_height());
        ui.push_id("board", |ui| {
            ui.spacing_mut().item_spacing.x = GAP;
            self.table(ctx, ui, (coefficient, axes, fitting), height);
        });
        if self.chosen.is_empty() {
            return;
        }
        ui.separator();
        ScrollArea::vertical().id_salt("below the board").auto_shrink(false).show(ui, |ui| {
            self.actions(ctx, ui);
            self.differences.show(ctx, ui, &self.chosen);
        });
    }
}

/// The columns that fit the width of a panel.
#[derive(Clone, Copy)]
struct Fitting {
    narrow: u8,
    /// Number and width of the intervals.
    intervals: usize,
    width: f32,
}

impl Fitting {
    /// As many columns of numbers as leave room for all intervals; where none do, as many intervals as fit.
    fn new(ui: &Ui, derivatives: usize) -> Self {
        let room = ui.available_width() - ui.spacing().scroll.allocated_width() - NAME - OVERLAY - 2.0 * GAP;
        let left = |narrow: u8| room - columns(narrow).map(|(_, width)| width + GAP).sum::<f32>();
        let [least, most] = INTERVAL;
        let has_room = |narrow: &u8| left(*narrow) >= derivatives as f32 * (least + GAP);
        let narrow = (0..=3).find(has_room).unwrap_or(3);
        let fitting = (left(narrow) / (least + GAP)).max(1.0) as usize;
        let intervals = fitting.min(derivatives);
        let width = (left(narrow) / intervals.max(1) as f32 - GAP).clamp(least, most);
        Self { narrow, intervals, width }
    }

    /// Titles and widths of the columns of numbers.
    fn columns(self) -> impl Iterator<Item = (&'static str, f32)> {
        columns(self.narrow)
    }

    /// Names the columns that have no room.
    fn name_hidden(self, ui: &mut Ui) {
        let hidden: Vec<&str> =
            COLUMNS.into_iter().filter(|(.., last)| self.narrow > *last).map(|(title, ..)| title).collect();
        if !hidden.is_empty() {
            let count = notation::plural(hidden.len(), "more column");
            let text = RichText::new(format!("{count}: {} (widen the panel)", hidden.join(", "))).size(11.0).weak();
            ui.label(text);
        }
    }
}

/// Titles and widths of the columns of numbers of a panel that narrow.
fn columns(narrow: u8) -> impl Iterator<Item = (&'static str, f32)> {
    COLUMNS.into_iter().filter(move |(.., last)| narrow <= *last).map(|(title, width, _)| (title, width))
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

    /// Rows in their order: the session first, the others by the column chosen, those without a number last.
    fn ordered<'r>(
        &self,
        rows: &'r ExperimentRows,
        coefficient: &str,
    ) -> Vec<(usize, &'r (String, Slot<ExperimentRow>))> {
        let mut ordered: Vec<_> = rows.0.iter().enumerate().collect();
        let Some((title, is_down)) = &self.order else { return ordered };
        let value = |(_, (_, slot)): &(usize, &(String, Slot<ExperimentRow>))| {
            let value = slot.latest().and_then(|row| number(row, coefficient, title));
            value.filter(|value| !value.is_nan()).map(|value| if *is_down { -value } else { value })
        };
        let present = ordered.len().min(1);
        ordered[present..].sort_by(|a, b| match (value(a), value(b)) {
            (Some(a), Some(b)) => a.total_cmp(&b),
            (a, b) => b.is_some().cmp(&a.is_some()),
        });
        ordered
    }

    /// Takes a click on the title of a column: smallest first, then largest first, then as before.
    fn order_by(&mut self, label: &egui::Response, title: &str) {
        if label.interact(egui::Sense::click()).clicked() {
            self.order = match self.order.take() {
                Some((ordered, false)) if ordered == title => Some((ordered, true)),
                Some((ordered, true)) if ordered == title => None,
                _ => Some((title.to_owned(), false)),
            };
        }
    }

    /// The title of a column; a mark below it where it orders the rows.
    fn title(&mut self, ui: &mut Ui, title: &str) {
        let label = match title {
            "Verdict" => column_title_called(ui, "derivatives\ngood/caution/bad", title),
            _ => column_title(ui, title),
        };
        self.mark(ui, label.rect, title);
        self.order_by(&label, title);
    }

    fn interval_title(&mut self, ui: &mut Ui, axis: &Axis<'_>) {
        let label = ui.centered_and_justified(|ui| ui.label(notation::typeset(axis.name, TITLE))).inner;
        ui.ctx().accesskit_node_builder(label.id, |node| {
            node.set_role(eframe::egui::accesskit::Role::ColumnHeader);
            node.set_label(format!("order by {}", axis.name));
        });
        self.mark(ui, label.rect, axis.name);
        self.order_by(&label.on_hover_text(axis.describe()), axis.name);
    }

    /// A triangle below the title of the column that orders the rows.
    fn mark(&self, ui: &Ui, title: egui::Rect, name: &str) {
        let Some((_, is_down)) = self.order.as_ref().filter(|(ordered, _)| ordered == name) else { return };
        let (base, tip) = if *is_down { (-2.0, 2.0) } else { (2.0, -2.0) };
        let at = egui::pos2(title.center().x, ui.max_rect().bottom() - 3.0);
        let corners = [[-3.5, base], [3.5, base], [0.0, tip]].map(|[x, y]| at + egui::vec2(x, y));
        let color = ui.visuals().strong_text_color();
        ui.painter().add(egui::Shape::convex_polygon(corners.to_vec(), color, egui::Stroke::NONE));
    }

    fn table(
        &mut self,
        ctx: &mut PanelContext<'_>,
        ui: &mut Ui,
        (coefficient, axes, fitting): (&str, &[Axis<'_>], Fitting),
        height: f32,
    ) {
        let overlaid = overlaid::names(ctx.state, ctx.session);
        let mut table = TableBuilder::new(ui)
            .striped(true)
            .sense(egui::Sense::click())
            .max_scroll_height(height)
            .auto_shrink([false, true])
            .cell_layout(Layout::right_to_left(Align::Center))
            .column(Column::remainder().at_least(NAME).clip(true))
            .column(Column::exact(OVERLAY));
        for (_, width) in fitting.columns() {
            table = table.column(Column::exact(width));
        }
        table
            .columns(Column::exact(fitting.width), axes.len())
            .header(HEADER, |mut header| {
                header.col(|_| {});
                header.col(|ui| {
                    column_title(ui, "Overlay");
                });
                for (title, _) in fitting.columns() {
                    header.col(|ui| self.title(ui, title));
                }
                for axis in axes {
                    header.col(|ui| self.interval_title(ui, axis));
                }
            })
            .body(|mut body| {
                for (index, (name, slot)) in self.ordered(&ctx.snapshot.inquiries.experiments, coefficient) {
                    body.row(ROW, |mut row| {
                        let is_chosen = self.chosen.contains(name);
                        row.set_selected(is_chosen);
                        let shown = (coefficient, axes, fitting);
                        let is_faint = !self.chosen.is_empty() && !is_chosen;
                        let switched = cells(&mut row, (index, name.as_str(), is_faint), (slot, &overlaid), shown);
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
            if ui.button("Remove").on_hover_text("One undo step restores it").clicked() {
                ctx.edit(Edit::Experiment(ExperimentEdit::Drop(name)));
                self.chosen.clear();
            }
            if ui.button("Remove all").on_hover_text("One undo step restores them").clicked() {
                self.chosen.clear();
                ctx.edits.push(EditRequest::Begin("remove all experiments".to_owned()));
                let session = ctx.session;
                for experiment in &session.experiments {
                    ctx.edit(Edit::Experiment(ExperimentEdit::Drop(experiment.name.clone())));
                }
                ctx.edits.push(EditRequest::Commit);
            }
        });
    }
}

/// The first name nothing has yet.
pub fn free_name(session: &Session) -> String {
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
        let structures = "The structures of the Model panel, each with the present settings";
        if ui.button("All structures").on_hover_text(structures).clicked() {
            added = Some(PRESETS.map(|(name, structure, _)| with_structure(session, name, structure())).into());
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

/// The present configuration with another structure.
fn with_structure(session: &Session, name: &str, structure: Structure) -> Experiment {
    let configuration = Configuration { structure, ..Configuration::from_session(session) };
    Experiment { name: format!("{name} structure"), configuration: configuration.into() }
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

/// The number of a column in a row: of what is judged, the level and the derivatives that are bad and a caution.
fn number(row: &ExperimentRow, coefficient: &str, title: &str) -> Option<f64> {
    let fit = row.outcome.coefficient(coefficient).and_then(|found| found.fit.as_ref());
    match title {
        "Verdict" => {
            let VerdictCounts { level, caution, bad, .. } = row.outcome.verdict;
            let level = [Level::Good, Level::Caution, Level::Bad].into_iter().position(|other| other == level)?;
            Some(1e6 * level as f64 + 1e3 * bad as f64 + caution as f64)
        }
        "NIS ratio" => row.outcome.nis,
        "R²" => fit.map(|fit| fit.r_squared),
        "honest R²" => fit?.honest_r_squared,
        "PSE" => fit.map(|fit| fit.predicted_squared_error),
        "ΔAIC" => fit?.delta_akaike,
        "ΔBIC" => fit?.delta_bayes,
        "validation error" => row.outcome.validation_error,
        derivative => interval(row, coefficient, derivative).map(|interval| interval.estimate),
    }
}

/// The number of a column as it is written.
fn written(title: &str, value: f64) -> String {
    let decimals = match title {
        "PSE" => return notation::number(value),
        "ΔAIC" | "ΔBIC" => 0,
        "NIS ratio" => 2,
        _ => 4,
    };
    notation::fixed(value, decimals)
}

/// The cells of a row; whether its overlay was switched.
fn cells(
    row: &mut TableRow<'_, '_>,
    (index, name, is_faint): (usize, &str, bool),
    (slot, overlaid): (&Slot<ExperimentRow>, &[String]),
    (coefficient, axes, fitting): (&str, &[Axis<'_>], Fitting),
) -> bool {
    let mut switched = false;
    let latest = slot.latest();
    let opacity = if slot.is_stale() && slot.error().is_none() { STALE } else { 1.0 };
    row.col(|ui| {
        ui.with_layout(Layout::left_to_right(Align::Center), |ui| {
            let (dot, _) = ui.allocate_exact_size(egui::vec2(10.0, 10.0), egui::Sense::hover());
            ui.painter().circle_filled(dot.center(), 4.0, color(ui, index));
            let is_current = index > 0 && latest.is_some_and(|row| row.is_current);
            // Its mark stands before the name: a long name is cut at its end.
            let text = if is_current { format!("✓ {name}") } else { name.to_owned() };
            let label = ui.add(Label::new(notation::typeset(&text, 13.0)).truncate().selectable(false));
            let value = if is_current { format!("{name} (current)") } else { name.to_owned() };
            ui.ctx().accesskit_node_builder(label.id, |node| node.set_value(value));
            let label = if is_current { label.on_hover_text(CURRENT) } else { label };
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
    for (title, _) in fitting.columns().skip(1) {
        row.col(|ui| {
            ui.multiply_opacity(opacity);
            let value = latest.and_then(|row| number(row, coefficient, title));
            let text = value.map_or("–".to_owned(), |value| written(title, value));
            let text = RichText::new(text).font(theme::figures(ui)).size(11.5);
            ui.add(Label::new(text).selectable(false));
        });
    }
    for axis in axes {
        row.col(|ui| {
            ui.multiply_opacity(opacity);
            let color = color(ui, index).gamma_multiply(if is_faint { FAINT } else { 1.0 });
            axis.show(ui, latest.map(AsRef::as_ref), (name, color));
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
