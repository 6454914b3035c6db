//! What each term of the model tells, and what a term beside it would: numbers of every tick.

use doublet_core::estimate::TermEffect;
use doublet_core::model::{Coefficient, Term};
use doublet_engine::session::{Edit, ModelEdit};
use doublet_engine::stage::CoefficientStudy;
use eframe::egui::{self, Color32, RichText, Ui};
use egui_extras::{Column, TableBuilder};

use crate::notation;
use crate::panels::PanelContext;
use crate::theme::{self, Palette};
use crate::widgets::term::column_titles;

/// Partial F below which a term is not significant at 95 %.
const SIGNIFICANT: f64 = 4.0;
/// Variance inflation from which terms can hardly be told apart.
const INFLATED: f64 = 10.0;
/// Fall of the predicted squared error that makes a term worth adding.
const WORTHWHILE: f64 = -0.01;
/// Radius of the dot of a judgement, points.
pub const DOT: f32 = 3.0;
const TITLES: [&str; 7] = ["", "Term", "VIF", "Partial F", "ΔR²", "ΔPSE", ""];

/// One line of judgement, with its colour; `None` where nothing needs to be said.
pub fn judgement(effect: &TermEffect, palette: &Palette) -> Option<(&'static str, Color32)> {
    if !effect.informative {
        return Some(("collinear with the other terms: cannot be estimated", palette.error));
    }
    match effect.in_model {
        true if effect.partial_f < SIGNIFICANT => Some(("not significant", palette.warning)),
        true if effect.variance_inflation > INFLATED => Some(("nearly collinear with the others", palette.warning)),
        false if effect.predicted_error_change < WORTHWHILE => Some(("would improve prediction", palette.good)),
        _ => None,
    }
}

/// What the dots beside ticks mean.
pub fn legend(ui: &mut Ui) {
    let palette = theme::palette(ui);
    let meanings = [
        (palette.warning, "not significant, or nearly collinear"),
        (palette.error, "collinear"),
        (palette.good, "would improve prediction"),
    ];
    ui.horizontal(|ui| {
        for (color, meaning) in meanings {
            let (rect, _) = ui.allocate_exact_size(egui::vec2(2.0 * DOT, 2.0 * DOT), egui::Sense::hover());
            ui.painter().circle_filled(rect.center(), DOT, color);
            ui.label(RichText::new(meaning).size(11.0).weak());
        }
    });
}

/// The effect of a tick, if it was studied.
pub fn effect<'a>(studies: &'a [CoefficientStudy], coefficient: Coefficient, term: &Term) -> Option<&'a TermEffect> {
    let study = studies.iter().find(|study| study.coefficient == coefficient)?;
    let at = study.terms.iter().position(|other| other == term)?;
    study.study.as_ref().ok()?.terms.get(at)
}

/// The numbers of a tick in words.
pub fn effect_text(effect: &TermEffect) -> String {
    let verb = if effect.in_model { "without it" } else { "with it" };
    format!(
        "VIF {}   partial F {}\n{verb}: R² {:+.4}, predicted squared error {:+.1} %",
        notation::number(effect.variance_inflation),
        notation::number(effect.partial_f),
        effect.r_squared_change,
        100.0 * effect.predicted_error_change,
    )
}

/// Draws the table of one coefficient.
pub fn show(ctx: &mut PanelContext<'_>, ui: &mut Ui, coefficient: Coefficient) {
    let slot = &ctx.snapshot.details;
    let details = slot.latest().map(|details| details.model.as_slice()).unwrap_or_default();
    let Some(study) = details.iter().find(|study| study.coefficient == coefficient) else {
        ui.weak("Waiting for the estimate");
        return;
    };
    let term_study = match &study.study {
        Ok(term_study) => term_study,
        Err(error) => return crate::panels::trouble(ui, Some(&error.to_string())),
    };
    ui.weak(format!(
        "R² {}   predicted squared error {}   ΔR², ΔPSE: when the tick is changed",
        notation::fixed(term_study.r_squared, 4),
        notation::number(term_study.predicted_squared_error)
    ));
    if slot.is_stale() {
        ui.multiply_opacity(0.6);
    }
    TableBuilder::new(ui)
        .id_salt("effects of terms")
        .striped(true)
        .vscroll(false)
        .cell_layout(egui::Layout::left_to_right(egui::Align::Center))
        .column(Column::exact(22.0))
        .column(Column::exact(86.0).clip(true))
        .columns(Column::exact(64.0), 4)
        .column(Column::remainder().at_least(60.0).clip(true))
        .header(18.0, |header| column_titles(header, TITLES))
        .body(|mut body| {
            for (effect, term) in term_study.terms.iter().zip(&study.terms) {
                body.row(20.0, |mut row| {
                    let terms = ctx.session.structure.terms(coefficient).unwrap_or_default();
                    let on = terms.contains(term);
                    row.col(|ui| tick(ctx, ui, coefficient, term, on));
                    row.col(|ui| {
                        ui.label(notation::term(&term.to_string()));
                    });
                    for text in [
                        notation::number(effect.variance_inflation),
                        notation::number(effect.partial_f),
                        notation::fixed(effect.r_squared_change, 4),
                        format!("{} %", notation::fixed(100.0 * effect.predicted_error_change, 1)),
                    ] {
                        row.col(|ui| {
                            ui.label(RichText::new(text).font(theme::figures(ui)).size(11.0));
                        });
                    }
                    row.col(|ui| {
                        if let Some((text, color)) = judgement(effect, theme::palette(ui)) {
                            let text = RichText::new(text).size(11.0).color(color);
                            ui.add(egui::Label::new(text).truncate());
                        }
                    });
                });
            }
        });
}

fn tick(ctx: &mut PanelContext<'_>, ui: &mut Ui, coefficient: Coefficient, term: &Term, was: bool) {
    let mut on = was;
    let tick = ui.checkbox(&mut on, "");
    let name = format!("effect of {} {term}", coefficient.name());
    ui.ctx().accesskit_node_builder(tick.id, |node| node.set_label(name));
    if on != was {
        ctx.edit(Edit::Model(ModelEdit::SetTerm { coefficient, term: term.clone(), on }));
    }
}
