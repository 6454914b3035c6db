//! The structures of the session beside each other: how well each fits, what its terms cost, how well it predicts.

use doublet_core::model::{Coefficient, Structure};
use doublet_engine::session::{Edit, KeptStructure, ModelEdit};
use doublet_engine::stage::{ScoredStructure, StructureScore};
use eframe::egui::{Align, Button, Color32, Label, Layout, RichText, TextEdit, Ui};
use egui_extras::{Column, TableBuilder};

use crate::notation;
use crate::panels::{PanelContext, choices};
use crate::theme;
use crate::widgets::chart::{Chart, ChartCurve, ChartStyle};
use crate::widgets::csv_text::csv_text;
use crate::widgets::term::column_title;

/// Titles of the columns.
const TITLES: [&str; 8] = ["Structure", "Terms", "R²", "PSE", "AIC", "BIC", "honest R²", ""];
/// Height of a row, and least of the chart.
const ROW: f32 = 21.0;
const CHART: f32 = 120.0;
/// What the present structure and the second are called.
const NOW: &str = "now";
const SECOND: &str = "B";

/// The board's state.
#[derive(Default)]
pub struct Board {
    coefficient: Option<Coefficient>,
    name: String,
}

/// The structures there are, by name.
fn structures(ctx: &PanelContext<'_>) -> Vec<(String, Structure)> {
    let session = ctx.session;
    let second = session.second_structure.iter().map(|structure| (SECOND.to_owned(), structure.clone()));
    let kept = session.kept_structures.iter().map(|kept| (kept.name.clone(), kept.structure.clone()));
    std::iter::once((NOW.to_owned(), session.structure.clone())).chain(second).chain(kept).collect()
}

impl Board {
    /// Draws it; copies the table first where that was asked for.
    pub fn show(&mut self, ctx: &mut PanelContext<'_>, ui: &mut Ui, copy: bool) {
        let structures = structures(ctx);
        ctx.wanted.structures.clone_from(&structures);
        ui.horizontal_wrapped(|ui| self.keep(ctx, ui, &structures));
        let scored = ctx.snapshot.details.latest().map(|details| details.structures.as_slice()).unwrap_or_default();
        let coefficients: Vec<Coefficient> =
            Coefficient::ALL.into_iter().filter(|one| scored.iter().any(|of| score(of, *one).is_some())).collect();
        let Some(&first) = coefficients.first() else {
            ui.weak("Waiting for the estimates");
            return;
        };
        let mut shown = self.coefficient.filter(|one| coefficients.contains(one)).unwrap_or(first);
        let all: Vec<_> = coefficients.iter().map(|one| (*one, one.name())).collect();
        choices(ui, &mut shown, &all);
        self.coefficient = Some(shown);
        if copy {
            ui.ctx().copy_text(csv(scored));
        }
        if ctx.snapshot.details.is_stale() {
            ui.multiply_opacity(0.6);
        }
        // The table is as high as its rows; the chart has the rest.
        let height = (ui.available_height() - ROW * (scored.len() as f32 + 2.0)).max(CHART);
        table(ctx, ui, scored, &structures, shown);
        ui.add_space(4.0);
        let chart = chart(ui, scored, shown);
        ctx.chart(ui, &chart, height - 10.0);
    }

    /// A name, and the button that keeps the present structure under it.
    fn keep(&mut self, ctx: &mut PanelContext<'_>, ui: &mut Ui, structures: &[(String, Structure)]) {
        let usual = (1..).map(|number| format!("structure {number}"));
        let free = |name: &String| structures.iter().all(|(other, _)| other != name);
        let usual = usual.into_iter().find(free).unwrap_or_default();
        let field = ui.add(TextEdit::singleline(&mut self.name).hint_text(&usual).desired_width(120.0));
        ui.ctx().accesskit_node_builder(field.id, |node| node.set_label("name of the structure"));
        let typed = self.name.trim();
        let name = if typed.is_empty() { usual } else { typed.to_owned() };
        let possible = name != NOW && name != SECOND;
        let button = ui.add_enabled(possible, Button::new("Keep the current structure"));
        let button = button.on_hover_text("The session stores it under this name while you change terms");
        if button.on_disabled_hover_text("This name is reserved").clicked() {
            let structure = ctx.session.structure.clone();
            ctx.edit(Edit::Model(ModelEdit::Keep(KeptStructure { name, structure })));
            self.name.clear();
        }
    }
}

fn score(of: &ScoredStructure, coefficient: Coefficient) -> Option<&StructureScore> {
    of.scores.iter().find(|(one, _)| *one == coefficient).and_then(|(_, score)| score.as_ref().ok())
}

/// The figures of one score in the order of the columns, and whether the larger is the better.
fn figures(score: &StructureScore) -> [(f64, bool); 5] {
    [
        (score.r_squared, true),
        (score.predicted_squared_error, false),
        (score.akaike, false),
        (score.bayes, false),
        (score.validation_r_squared.unwrap_or(f64::NAN), true),
    ]
}

fn written(column: usize, value: f64) -> String {
    match column {
        0 | 4 => notation::fixed(value, 4),
        2 | 3 => notation::fixed(value, 0),
        _ => notation::number(value),
    }
}

/// One row per structure; the best of each column is strong.
fn table(
    ctx: &mut PanelContext<'_>,
    ui: &mut Ui,
    scored: &[ScoredStructure],
    structures: &[(String, Structure)],
    coefficient: Coefficient,
) {
    let all: Vec<[(f64, bool); 5]> = scored.iter().filter_map(|of| score(of, coefficient)).map(figures).collect();
    let best: [f64; 5] = std::array::from_fn(|column| {
        let values = all.iter().map(|figures| figures[column]).filter(|(value, _)| value.is_finite());
        let better = |a: (f64, bool), b: (f64, bool)| if (a.0 > b.0) == a.1 { a } else { b };
        values.reduce(better).map_or(f64::NAN, |(value, _)| value)
    });
    TableBuilder::new(ui)
        .id_salt("board of structures")
        .striped(true)
        .vscroll(false)
        .cell_layout(Layout::right_to_left(Align::Center))
        .column(Column::remainder().at_least(84.0).clip(true))
        .column(Column::exact(46.0))
        .columns(Column::exact(64.0), 5)
        .column(Column::exact(72.0))
        .header(20.0, |mut header| {
            for title in TITLES {
                header.col(|ui| {
                    column_title(ui, title);
                });
            }
        })
        .body(|mut body| {
            for of in scored {
                body.row(ROW, |mut row| {
                    let found = score(of, coefficient);
                    row.col(|ui| {
                        ui.with_layout(Layout::left_to_right(Align::Center), |ui| {
                            ui.add(Label::new(&of.name).truncate()).on_hover_text(terms(structures, of, coefficient));
                        });
                    });
                    row.col(|ui| number(ui, found.map_or("–".to_owned(), |score| score.parameters.to_string()), false));
                    for column in 0..5 {
                        let value = found.map_or(f64::NAN, |score| figures(score)[column].0);
                        row.col(|ui| number(ui, written(column, value), all.len() > 1 && value == best[column]));
                    }
                    row.col(|ui| take(ctx, ui, &of.name, structures));
                });
            }
        });
}

fn number(ui: &mut Ui, text: String, strong: bool) {
    let text = RichText::new(text).font(theme::figures(ui)).size(11.5);
    ui.label(if strong { text.strong().color(theme::palette(ui).good) } else { text });
}

/// The terms of a structure in one line.
fn terms(structures: &[(String, Structure)], of: &ScoredStructure, coefficient: Coefficient) -> String {
    let structure = structures.iter().find(|(name, _)| *name == of.name).map(|(_, structure)| structure);
    let terms = structure.and_then(|structure| structure.terms(coefficient)).unwrap_or_default();
    terms.iter().map(|term| notation::term(&term.to_string()).to_string()).collect::<Vec<_>>().join(" + ")
}

/// Makes a structure the present one, or keeps it no longer.
fn take(ctx: &mut PanelContext<'_>, ui: &mut Ui, name: &str, structures: &[(String, Structure)]) {
    let Some((_, structure)) = structures.iter().find(|(other, _)| other == name).filter(|_| name != NOW) else {
        return;
    };
    if name != SECOND {
        let forget = ui.small_button("✖").on_hover_text("Remove it from the session");
        let label = format!("forget {name}");
        ui.ctx().accesskit_node_builder(forget.id, |node| node.set_label(label.as_str()));
        if forget.clicked() {
            ctx.edit(Edit::Model(ModelEdit::Forget(name.to_owned())));
        }
    }
    let is_present = *structure == ctx.session.structure;
    let button = ui.add_enabled(!is_present, Button::new("Take").small());
    let label = format!("take {name}");
    ui.ctx().accesskit_node_builder(button.id, |node| node.set_label(label.as_str()));
    let button = button.on_hover_text("Make it the current structure; one undo step restores the old one");
    if button.on_disabled_hover_text("This is the current structure").clicked() {
        ctx.edit(Edit::Model(ModelEdit::Structure(structure.clone())));
    }
}

/// R² of fit and of prediction of every structure.
fn chart(ui: &Ui, scored: &[ScoredStructure], coefficient: Coefficient) -> Chart {
    let palette = theme::palette(ui);
    let mut chart = Chart::new("board of structures", "", format!("R² of {}", coefficient.name()));
    let points = |of: &dyn Fn(&StructureScore) -> f64| -> Vec<[f64; 2]> {
        let values = scored.iter().enumerate().map(|(at, one)| (at, score(one, coefficient)));
        values.map(|(at, found)| [at as f64, found.map_or(f64::NAN, of)]).collect()
    };
    chart.places = scored.iter().enumerate().map(|(at, of)| (at as f64, of.name.clone())).collect();
    let fitted = points(&|score| score.r_squared);
    let predicted = points(&|score| score.validation_r_squared.unwrap_or(f64::NAN));
    // Room for the names of the first and the last.
    let level = fitted.iter().map(|[_, value]| *value).find(|value| value.is_finite()).unwrap_or_default();
    let ends = vec![[-0.5, level], [scored.len() as f64 - 0.5, level]];
    chart.curves.push(ChartCurve::new("", Color32::TRANSPARENT, ChartStyle::Dots(1.0), ends));
    chart.curves.push(ChartCurve::new("fit", palette.series[0], ChartStyle::Dots(4.0), fitted));
    chart.curves.push(ChartCurve::new(
        "honest: validation manoeuvres",
        palette.series[1],
        ChartStyle::Dots(4.0),
        predicted,
    ));
    chart
}

/// The board as text for other programs.
fn csv(scored: &[ScoredStructure]) -> String {
    let titles =
        ["structure", "coefficient", "parameters", "samples", "r_squared", "pse", "aic", "bic", "validation_r_squared"];
    let mut rows = Vec::new();
    for of in scored {
        for (coefficient, found) in &of.scores {
            let Ok(found) = found else { continue };
            let criteria = [found.r_squared, found.predicted_squared_error, found.akaike, found.bayes];
            let sizes = (found.parameters, found.samples);
            rows.push((&of.name, coefficient.name(), sizes, criteria, found.validation_r_squared));
        }
    }
    csv_text(&titles, rows)
}
