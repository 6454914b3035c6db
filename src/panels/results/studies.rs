//! Studies on request: comparison of manoeuvres, independent checks, effect of noise, lags; each with its progress.

use doublet_engine::report::{kind_rows, kind_table, lag_rows, lag_table, monte_carlo_rows, monte_carlo_table};
use doublet_engine::run::Slot;
use doublet_engine::study::{
    CheckRequest, CheckStudy, ConditionRegression, ESTIMATORS, Estimator, EstimatorSet, ManoeuvreStudy,
    MonteCarloRequest, STUDIES, Study, StudyInfo, WindowChecks,
};
use eframe::egui::{self, Align, Button, ComboBox, DragValue, Label, Layout, ProgressBar, RichText, ScrollArea, Ui};
use egui_extras::Column;

use crate::command::{RunCommand, UiCommand, ViewCommand};
use crate::panels::{Pane, Panel, PanelContext, choices, empty, offer, trouble};
use crate::widgets::chart::{Chart, ChartCurve, ChartStyle};
use crate::widgets::document_view::draw_table;
use crate::widgets::grid::figures_grid;
use crate::widgets::term::column_title;
use crate::{notation, theme};

/// Width of the list of studies.
const LIST: f32 = 208.0;
/// Width of a number, and the least of what a row is about.
const CELL: f32 = 86.0;
const FIRST: f32 = 150.0;
/// Height of a row of a table.
const ROW: f32 = 19.0;
/// Realisations to begin with, and their seed.
const REALISATIONS: usize = 100;
const SEED: u64 = 1;

/// A study with results of its own in this panel.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Chosen {
    Condition,
    LeftOut,
    Kinds,
    Checks,
    MonteCarlo,
    Lags,
}

pub struct Studies {
    chosen: Chosen,
    derivative: Option<String>,
    variable: usize,
    realisations: usize,
    estimators: EstimatorSet,
}

impl Default for Studies {
    fn default() -> Self {
        Self {
            chosen: Chosen::Condition,
            derivative: None,
            variable: 0,
            realisations: REALISATIONS,
            estimators: EstimatorSet::default(),
        }
    }
}

/// How far a study is, without what it holds.
enum State {
    Open,
    Running(f32),
    Ready,
    Stale,
    Failed(String),
}

fn state<T>(slot: &Slot<T>) -> State {
    match slot {
        Slot::NotRequested => State::Open,
        Slot::Running { progress, .. } => State::Running(*progress),
        Slot::Ready(_) => State::Ready,
        Slot::Cancelled { .. } => State::Stale,
        Slot::Failed { error, .. } => State::Failed(error.clone()),
    }
}

impl Panel for Studies {
    fn show(&mut self, ctx: &mut PanelContext<'_>, ui: &mut Ui) {
        egui::Panel::left("list of studies").resizable(false).exact_size(LIST).show(ui, |ui| {
            ScrollArea::vertical().auto_shrink(false).show(ui, |ui| self.list(ctx, ui));
        });
        let ground = egui::Frame::new().inner_margin(egui::Margin { left: 8, ..Default::default() });
        egui::CentralPanel::default().frame(ground).show(ui, |ui| self.results(ctx, ui));
    }
}

impl Studies {
    fn checks(&self) -> Study {
        Study::Checks(CheckRequest { axis: None, estimators: self.estimators })
    }

    fn monte_carlo(&self) -> Study {
        Study::MonteCarlo(MonteCarloRequest { realisations: self.realisations, seed: SEED })
    }

    /// Every study: what it says, how far it is, the button that computes it.
    fn list(&mut self, ctx: &mut PanelContext<'_>, ui: &mut Ui) {
        let studies = &ctx.snapshot.studies;
        let manoeuvres = [
            (Chosen::Condition, "Over airspeed and altitude"),
            (Chosen::LeftOut, "Each manoeuvre left out"),
            (Chosen::Kinds, "Kinds of input"),
        ];
        entry(ctx, ui, "manoeuvres", (Study::Manoeuvres, state(&studies.manoeuvres)));
        self.aspects(ui, &manoeuvres);
        entry(ctx, ui, "checks", (self.checks(), state(&studies.checks)));
        for estimator in Estimator::on_request() {
            ui.horizontal(|ui| {
                ui.add_space(10.0);
                let mut is_wanted = self.estimators.contains(estimator);
                if ui
                    .checkbox(&mut is_wanted, format!("with {}", estimator.name))
                    .on_hover_text(estimator.about)
                    .changed()
                {
                    self.estimators = self.estimators.with(estimator, is_wanted);
                }
            });
        }
        self.aspects(ui, &[(Chosen::Checks, "By manoeuvre")]);
        entry(ctx, ui, "monte-carlo", (self.monte_carlo(), state(&studies.monte_carlo)));
        ui.horizontal(|ui| {
            ui.add_space(10.0);
            ui.add(DragValue::new(&mut self.realisations).range(10..=2000)).on_hover_text("Realisations");
            ui.weak("realisations");
        });
        self.aspects(ui, &[(Chosen::MonteCarlo, "Scatter and shift")]);
        entry(ctx, ui, "lags", (Study::Lags, state(&studies.lags)));
        self.aspects(ui, &[(Chosen::Lags, "Table")]);
        ui.separator();
        for (name, pane) in [
            ("Sensitivity ▸", Pane::Sensitivity),
            ("Frequency responses ▸", Pane::Responses),
            ("Modes and levels ▸", Pane::Dynamics),
            ("Proof of match ▸", Pane::Match),
        ] {
            if ui.link(name).clicked() {
                ctx.commands.push(UiCommand::View(ViewCommand::Show(pane)));
            }
        }
    }

    fn aspects(&mut self, ui: &mut Ui, aspects: &[(Chosen, &str)]) {
        for &(aspect, name) in aspects {
            ui.horizontal(|ui| {
                ui.add_space(10.0);
                ui.selectable_value(&mut self.chosen, aspect, name);
            });
        }
        ui.add_space(8.0);
    }

    fn results(&mut self, ctx: &mut PanelContext<'_>, ui: &mut Ui) {
        let studies = &ctx.snapshot.studies;
        let manoeuvres = (Study::Manoeuvres, &studies.manoeuvres);
        match self.chosen {
            Chosen::Condition => shown(ctx, ui, manoeuvres, |ctx, ui, study| self.condition(ctx, ui, study)),
            Chosen::LeftOut => shown(ctx, ui, manoeuvres, left_out),
            Chosen::Kinds => shown(ctx, ui, manoeuvres, |_, ui, study| match study.kinds.is_empty() {
                true => empty(ui, "All manoeuvres have the same kind of input."),
                false => draw_table(&kind_table(&kind_rows(study)), ui),
            }),
            Chosen::Checks => shown(ctx, ui, (self.checks(), &studies.checks), checks),
            Chosen::MonteCarlo => shown(ctx, ui, (self.monte_carlo(), &studies.monte_carlo), |_, ui, study| {
                let done = study.request.realisations - study.failed;
                ui.weak(format!(
                    "{done} realisations; {} failed. The scatter contains measurement noise only.",
                    study.failed
                ));
                draw_table(&monte_carlo_table(&monte_carlo_rows(study), &[]), ui);
            }),
            Chosen::Lags => shown(ctx, ui, (Study::Lags, &studies.lags), |_, ui, study| {
                ui.weak("A negative delay means a late recording (recorder clock). Set it in Model ▸ Axes, reference, thrust and lags.");
                draw_table(&lag_table(&lag_rows(study)), ui);
            }),
        }
    }

    /// One derivative of every window over one variable of the condition, with the line of the regression.
    fn condition(&mut self, ctx: &mut PanelContext<'_>, ui: &mut Ui, study: &ManoeuvreStudy) {
        let two: Vec<&ConditionRegression> = study.conditions.iter().filter(|one| one.variables.len() == 2).collect();
        let wanted = self.derivative.clone().or_else(|| ctx.selection().derivative.clone());
        let found = two.iter().find(|one| Some(&one.derivative) == wanted.as_ref());
        // The damping in pitch moves most with the condition; anything else where it is not modelled.
        let first = || two.iter().find(|one| one.derivative == "Cm_q").or(two.first());
        let Some(regression) = found.or_else(first).copied() else {
            return empty(ui, "No derivative is estimated from single manoeuvres.");
        };
        ui.horizontal_wrapped(|ui| {
            let combo = ComboBox::from_id_salt("derivative over the condition");
            let combo = combo.selected_text(notation::typeset(&regression.derivative, 13.0)).show_ui(ui, |ui| {
                for one in &two {
                    let name = notation::typeset(&one.derivative, 13.0);
                    if ui.selectable_label(one.derivative == regression.derivative, name).clicked() {
                        self.derivative = Some(one.derivative.clone());
                    }
                }
            });
            ui.ctx().accesskit_node_builder(combo.response.id, |node| node.set_label("derivative over the condition"));
            choices(ui, &mut self.variable, &[(0, "airspeed"), (1, "altitude")]);
        });
        match &regression.result {
            Ok(found) => {
                let parameters = found.fit.estimates.iter().zip(&found.fit.standard_errors);
                let texts: Vec<String> = parameters
                    .zip(["at the mean", "per m/s", "per m"])
                    .map(|((value, error), per)| {
                        format!("{per} {} ± {}", notation::within(*value, *error), notation::number(*error))
                    })
                    .collect();
                let scatter = notation::fixed(found.scatter_ratio, 2);
                ui.weak(format!("{}; scatter about the line {scatter} times the standard errors", texts.join(", ")));
            }
            Err(error) => trouble(ui, Some(&error.to_string())),
        }
        let palette = theme::palette(ui);
        let labels = ["airspeed [m/s]", "altitude [m]"];
        let mut chart = Chart::new(
            "derivative over the flight condition",
            labels[self.variable],
            notation::derivative(&regression.derivative),
        );
        let place = |point: &doublet_core::estimate::ConditionPoint| [point.condition[self.variable], point.estimate];
        let points = regression.points.iter().map(|(_, point)| place(point)).collect();
        let spread = regression.points.iter().map(|(_, point)| 2.0 * point.standard_error).collect();
        let dots = ChartCurve::new("manoeuvres, ± 2 standard errors", palette.series[1], ChartStyle::Dots(3.0), points);
        chart.curves.push(ChartCurve { spread, ..dots });
        if let Some(line) = regression.line(self.variable) {
            let about = "regression, the other variable at its mean";
            chart.curves.push(ChartCurve::new(about, palette.series[0], ChartStyle::Line, line.to_vec()));
        }
        let height = ui.available_height();
        ctx.chart(ui, &chart, height);
    }
}

/// The study called `key` in the list.
fn entry(ctx: &mut PanelContext<'_>, ui: &mut Ui, key: &str, (study, state): (Study, State)) {
    let Some(&StudyInfo { title: name, about, .. }) = STUDIES.iter().find(|row| row.key == key) else { return };
    ui.horizontal(|ui| {
        ui.add(Label::new(RichText::new(name).strong()).truncate()).on_hover_text(about);
    });
    ui.horizontal(|ui| {
        ui.add_space(10.0);
        let running = matches!(state, State::Running(_));
        let word = match &state {
            State::Open => "Compute",
            _ => "Compute again",
        };
        let label = format!("compute {name}");
        let button = ui.add_enabled(!running, Button::new(word).small()).on_hover_text(about);
        ui.ctx().accesskit_node_builder(button.id, |node| node.set_label(label.as_str()));
        if button.clicked() {
            ctx.commands.push(UiCommand::Run(RunCommand::Study(study)));
        }
        let palette = theme::palette(ui);
        match state {
            State::Running(progress) => {
                ui.add(ProgressBar::new(progress).desired_width(50.0).desired_height(8.0));
                if ui.small_button("Cancel").clicked() {
                    ctx.commands.push(UiCommand::Run(RunCommand::Cancel));
                }
            }
            State::Ready => drop(ui.label(RichText::new("✔").color(palette.good)).on_hover_text("up to date")),
            State::Stale => {
                ui.label(RichText::new("out of date").size(11.0).color(palette.warning));
            }
            State::Failed(error) => {
                ui.label(RichText::new("⚠ failed").size(11.0).color(palette.error)).on_hover_text(error);
            }
            State::Open => {}
        }
    });
}

/// What a study found, pale where it is out of date; what it would find, and the button that computes it, where it is not computed.
fn shown<T>(
    ctx: &mut PanelContext<'_>,
    ui: &mut Ui,
    (study, slot): (Study, &Slot<T>),
    show: impl FnOnce(&mut PanelContext<'_>, &mut Ui, &T),
) {
    trouble(ui, slot.error());
    let Some(found) = slot.latest() else {
        if let Slot::Running { progress, .. } = slot {
            ui.add(ProgressBar::new(*progress).desired_width(220.0).desired_height(8.0));
            return;
        }
        let row = STUDIES.iter().find(|row| std::mem::discriminant(&(row.make)()) == std::mem::discriminant(&study));
        let text = row.map_or_else(String::new, |row| format!("{}: {} Not computed yet.", row.title, row.about));
        if offer(ui, &text, "Compute now") {
            ctx.commands.push(UiCommand::Run(RunCommand::Study(study)));
        }
        return;
    };
    if slot.is_stale() {
        ui.multiply_opacity(0.5);
    }
    show(ctx, ui, found);
}

/// A table whose first column is as wide as there is room for; it scrolls sideways where there is little.
fn table(ui: &mut Ui, id: &str, titles: &[&str], rows: &[Vec<String>], selected: impl Fn(usize) -> bool) {
    let others = (titles.len() - 1) as f32 * (CELL + ui.spacing().item_spacing.x);
    let first = (ui.available_width() - others).max(FIRST);
    ScrollArea::horizontal().id_salt(("sideways", id)).show(ui, |ui| cells(ui, id, (titles, first), rows, selected));
}

fn cells(
    ui: &mut Ui,
    id: &str,
    (titles, first): (&[&str], f32),
    rows: &[Vec<String>],
    selected: impl Fn(usize) -> bool,
) {
    let figures = theme::figures(ui);
    figures_grid(ui, id)
        .column(Column::exact(first).clip(true))
        .columns(Column::exact(CELL), titles.len() - 1)
        .header(20.0, |mut header| {
            for (at, title) in titles.iter().enumerate() {
                header.col(|ui| {
                    if at == 0 {
                        ui.with_layout(Layout::left_to_right(Align::Center), |ui| column_title(ui, title));
                    } else {
                        column_title(ui, title);
                    }
                });
            }
        })
        .body(|body| {
            body.rows(ROW, rows.len(), |mut line| {
                let at = line.index();
                line.set_selected(selected(at));
                for (column, text) in rows[at].iter().enumerate() {
                    line.col(|ui| {
                        if column == 0 {
                            ui.with_layout(Layout::left_to_right(Align::Center), |ui| {
                                ui.add(Label::new(notation::typeset(text, 13.0)).truncate());
                            });
                        } else {
                            ui.label(RichText::new(text).font(figures.clone()).size(11.5));
                        }
                    });
                }
            });
        });
}

/// Largest change of a derivative without each window, and how the others predict that window.
fn left_out(ctx: &mut PanelContext<'_>, ui: &mut Ui, study: &ManoeuvreStudy) {
    ui.weak("Influence of each manoeuvre: largest change of a derivative without it, in standard errors, and its prediction by the others.");
    let mut rows = Vec::new();
    let mut windows = Vec::new();
    for found in &study.left_out {
        for one in &found.windows {
            let shifts = found.derivatives.iter().zip(&one.shift_in_errors);
            let most = shifts.max_by(|a, b| a.1.abs().total_cmp(&b.1.abs()));
            let Some((name, shift)) = most else { continue };
            rows.push(vec![
                one.label.clone(),
                found.coefficient.name().to_owned(),
                notation::derivative(name),
                notation::fixed(*shift, 1),
                notation::fixed(one.quality_identified.r_squared, 4),
                own_constant(one.quality_identified.r_squared, one.quality_own_constant.r_squared),
            ]);
            windows.push(one.label.clone());
        }
    }
    let titles = ["Manoeuvre", "Coefficient", "Moves most", "by σ", "R² predicted", "R² own const."];
    let chosen = ctx.selection().window.clone();
    table(ui, "left out", &titles, &rows, |at| Some(&windows[at]) == chosen.as_ref());
}

/// R² of the prediction with a constant of the window's own; a dash where the windows share theirs.
fn own_constant(shared: f64, own: f64) -> String {
    if shared == own { "–".to_owned() } else { notation::fixed(own, 4) }
}

/// The chosen window by equation error, in the frequency domain and by output error.
fn checks(ctx: &mut PanelContext<'_>, ui: &mut Ui, study: &CheckStudy) {
    let name = ctx.selection().window.clone().unwrap_or_default();
    let Some(found) = study.windows.iter().find(|one| one.window == name) else {
        return empty(ui, "Select a manoeuvre that is in use.");
    };
    ui.weak(format!("{name}: the same derivatives by each method, with standard errors"));
    let own = ctx.results().and_then(|results| results.fits.latest()).cloned();
    let time = |derivative: &str| {
        own.iter().flat_map(|fits| &fits.fits).find_map(|fit| {
            let at = fit.fit.as_ref().ok()?.names.iter().position(|name| name == derivative)?;
            Some((fit.fit.as_ref().ok()?.estimates[at], *fit.corrected_errors.get(at)?))
        })
    };
    for (method, part, result) in found.results() {
        let line = result.err().map(|error| format!("{}, {}: {error}", method.name, part.name()));
        trouble(ui, line.as_deref());
    }
    let methods: Vec<_> = ESTIMATORS.iter().filter(|one| found.estimates().any(|(by, ..)| by.key == one.key)).collect();
    let mut titles = vec!["Derivative", "time", "±"];
    titles.extend(methods.iter().flat_map(|method| [method.name, "±"]));
    table(ui, "checks", &titles, &check_rows(found, &methods, time), |_| false);
    for (method, _, estimates) in found.estimates().filter(|(method, ..)| method.on_request) {
        let others = estimates.others.iter().map(|other| match other.standard_error.is_finite() {
            true => format!("{} {}", other.name, notation::within(other.estimate, other.standard_error)),
            false => format!("{} {}", other.name, notation::number(other.estimate)),
        });
        ui.weak(format!("{}, SI, noise per root second: {}", method.name, others.collect::<Vec<_>>().join(", ")));
    }
}

/// A derivative by a method, with its standard error.
fn estimate_by(found: &WindowChecks, method: &str, name: &str) -> Option<(f64, f64)> {
    let own = found.estimates().filter(|(by, ..)| by.key == method).flat_map(|(_, _, found)| &found.derivatives);
    let row = own.into_iter().find(|row| row.name == name)?;
    Some((row.estimate, row.standard_error))
}

/// An estimate and its standard error.
fn estimate_cells(estimate: Option<(f64, f64)>) -> [String; 2] {
    match estimate {
        Some((value, error)) => [notation::within(value, error), notation::number(error)],
        None => ["–".to_owned(), "–".to_owned()],
    }
}

fn check_rows(
    found: &WindowChecks,
    methods: &[&Estimator],
    time: impl Fn(&str) -> Option<(f64, f64)>,
) -> Vec<Vec<String>> {
    let mut names: Vec<&str> = Vec::new();
    for row in found.estimates().flat_map(|(_, _, found)| &found.derivatives) {
        if time(&row.name).is_some() && !row.name.ends_with("_0") && !names.contains(&&*row.name) {
            names.push(&row.name);
        }
    }
    let row = |name: &str| {
        let numbers = methods.iter().flat_map(|method| estimate_cells(estimate_by(found, method.key, name)));
        std::iter::once(notation::derivative(name)).chain(estimate_cells(time(name))).chain(numbers).collect()
    };
    names.into_iter().map(row).collect()
}
