//! Two experiments beside each other, setting by setting and derivative by derivative; the scores of all as text.

use doublet_engine::compare::{ExperimentRow, PRESENT, SettingDifference, experiment_differences};
use doublet_engine::run::{ExperimentRows, Slot};
use doublet_engine::session::{Configuration, Session};
use eframe::egui::{Grid, Label, RichText, Ui};

use crate::panels::PanelContext;
use crate::panels::model::experiment_intervals::interval;
use crate::panels::model::setting_words::{setting_words, value_words};
use crate::widgets::csv_text::csv_text;
use crate::{notation, theme};

/// Titles of the table of derivatives and of its text.
const TITLES: [&str; 6] = ["derivative", "first", "first_error", "second", "second_error", "difference"];
/// Opacity of a difference of nothing.
const SAME: f32 = 0.35;
/// Width left to the names of settings, and the least of a value, points.
const SETTING: f32 = 150.0;
const LEAST_VALUE: f32 = 120.0;

/// What differs between two rows.
#[derive(Default)]
pub struct Differences(Option<([Configuration; 2], Vec<SettingDifference>)>);

impl Differences {
    /// Settings and derivatives of the two chosen rows, or of the chosen one and the session.
    pub fn show(&mut self, ctx: &PanelContext<'_>, ui: &mut Ui, chosen: &[String]) {
        let [first, second] = match chosen {
            [one] if one != PRESENT => [PRESENT, one.as_str()],
            [first, second] => [first.as_str(), second.as_str()],
            _ => return,
        };
        let Some(of) = configuration(ctx.session, first).zip(configuration(ctx.session, second)) else { return };
        let of = [of.0, of.1];
        if self.0.as_ref().is_none_or(|(known, _)| *known != of) {
            let settings = experiment_differences(ctx.session, &of[0], &of[1]).unwrap_or_default();
            self.0 = Some((of, settings));
        }
        let Some((_, settings)) = &self.0 else { return };
        if settings.is_empty() {
            ui.label(format!("{first} and {second} have the same settings."));
            return;
        }
        let column = (0.5 * (ui.available_width() - SETTING)).max(LEAST_VALUE);
        Grid::new("settings that differ").num_columns(3).striped(true).show(ui, |ui| {
            for title in ["Setting", first, second] {
                ui.label(notation::typeset_in(title, 11.0, ui.visuals().weak_text_color()));
            }
            ui.end_row();
            for difference in settings {
                ui.add(Label::new(notation::typeset(&setting_words(&difference.setting), 13.0)).extend());
                for value in [&difference.first, &difference.second] {
                    let text = value_words(difference, value.as_deref());
                    value_cell(ui, column, &text);
                }
                ui.end_row();
            }
        });
        let rows = &ctx.snapshot.inquiries.experiments;
        let row = |name: &str| rows.row(name).and_then(Slot::latest).map(AsRef::as_ref);
        if let Some(both) = row(first).zip(row(second)) {
            derivatives(ui, [first, second], [both.0, both.1]);
        }
    }
}

/// A value as wide as it is, wrapped where its column is narrower.
fn value_cell(ui: &mut Ui, column: f32, text: &str) {
    let job = notation::typeset(text, 13.0);
    let width = ui.painter().layout_job(job.clone()).size().x.ceil();
    ui.scope(|ui| {
        ui.set_width(width.min(column));
        ui.add(Label::new(job).wrap());
    });
}

/// The configuration of a row.
fn configuration(session: &Session, name: &str) -> Option<Configuration> {
    if name == PRESENT {
        return Some(Configuration::from_session(session));
    }
    session.experiment(name).map(|experiment| Configuration::clone(&experiment.configuration))
}

/// Every derivative that one of two rows has, with estimates, errors and their difference.
fn compared(both: [&ExperimentRow; 2]) -> Vec<(String, [Option<f64>; 5])> {
    let mut found: Vec<(String, [Option<f64>; 5])> = Vec::new();
    let coefficients = both.into_iter().flat_map(|row| &row.outcome.coefficients);
    for (coefficient, derivative) in coefficients.flat_map(|one| one.derivatives.iter().map(|of| (one.coefficient, of)))
    {
        if found.iter().all(|(name, _)| *name != derivative.name) {
            let [a, b] = both.map(|row| interval(row, coefficient, &derivative.name));
            let difference = a.zip(b).map(|(a, b)| b.estimate - a.estimate);
            let [a, b] = [a, b].map(|one| [one.map(|one| one.estimate), one.map(|one| one.standard_error)]);
            found.push((derivative.name.clone(), [a[0], a[1], b[0], b[1], difference]));
        }
    }
    found
}

/// The derivatives of two rows beside each other.
fn derivatives(ui: &mut Ui, names: [&str; 2], both: [&ExperimentRow; 2]) {
    let rows = compared(both);
    ui.add_space(6.0);
    if ui.small_button("Copy derivatives as CSV").clicked() {
        ui.ctx().copy_text(csv_text(&TITLES, &rows));
    }
    Grid::new("derivatives that differ").num_columns(6).striped(true).show(ui, |ui| {
        for title in ["Derivative", names[0], "±", names[1], "±", "Difference"] {
            ui.label(notation::typeset_in(title, 11.0, ui.visuals().weak_text_color()));
        }
        ui.end_row();
        for (name, values) in &rows {
            ui.label(notation::derivative_job(ui, name));
            for (column, value) in values.iter().enumerate() {
                // What does not differ steps back behind what does.
                let is_same = column + 1 == values.len() && *value == Some(0.0);
                let text = value.map_or("–".to_owned(), notation::number);
                let text = RichText::new(text).font(theme::figures(ui)).size(11.5);
                ui.scope(|ui| {
                    ui.multiply_opacity(if is_same { SAME } else { 1.0 });
                    ui.label(text);
                });
            }
            ui.end_row();
        }
    });
}

/// Scores of every coefficient of every row, for other programs.
pub fn scores_csv(rows: &ExperimentRows) -> String {
    let titles = [
        "experiment", "coefficient", "parameters", "samples", "r_squared", "honest_r_squared", "pse", "aic",
        "delta_aic", "bic", "delta_bic",
    ];
    let rows = rows.0.iter().filter_map(|(name, slot)| Some((name, slot.latest()?)));
    let scores = rows.flat_map(|(name, row)| {
        row.outcome.coefficients.iter().filter_map(move |one| {
            let fit = one.fit.as_ref()?;
            let akaike = (fit.akaike, fit.delta_akaike, fit.bayes, fit.delta_bayes);
            let quality = (fit.r_squared, fit.honest_r_squared, fit.predicted_squared_error);
            Some((name, one.coefficient, fit.parameters, fit.samples, quality, akaike))
        })
    });
    csv_text(&titles, scores)
}
