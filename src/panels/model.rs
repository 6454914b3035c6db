//! Terms of the aerodynamic model: coefficients against terms, ticked.

use std::collections::BTreeSet;

use doublet_core::model::{Coefficient, Structure, Term, Variable};
use doublet_engine::session::{Edit, EstimationEdit, ModelEdit, PooledConstants};
use eframe::egui::{self, Grid, Key, RichText, ScrollArea, TextEdit, Ui};

use super::{Panel, PanelContext, choices};
use crate::notation;
use crate::theme;

/// Variables that always have a row.
const COMMON: [Variable; 10] = [
    Variable::Alpha,
    Variable::AlphaDot,
    Variable::PitchRate,
    Variable::Elevator,
    Variable::Beta,
    Variable::BetaDot,
    Variable::RollRate,
    Variable::YawRate,
    Variable::Aileron,
    Variable::Rudder,
];

/// A named structure.
type Preset = (&'static str, fn() -> Structure);

/// Structures to start from.
const PRESETS: [Preset; 4] = [
    ("Thesis", Structure::thesis),
    ("Alternative", Structure::alternative),
    ("Quadratic", Structure::quadratic),
    ("With power", Structure::with_power),
];

/// The panel.
#[derive(Default)]
pub struct Model {
    typed: String,
    problem: Option<String>,
    added: BTreeSet<Term>,
}

impl Panel for Model {
    fn show(&mut self, ctx: &mut PanelContext<'_>, ui: &mut Ui) {
        ui.horizontal(|ui| {
            ui.weak("Structure");
            for (name, structure) in PRESETS {
                let structure = structure();
                let on = ctx.session.structure == structure;
                if ui.selectable_label(on, name).clicked() && !on {
                    ctx.edit(Edit::Model(ModelEdit::Structure(structure)));
                }
            }
        });
        ui.horizontal(|ui| {
            ui.weak("Constants");
            let mut constants = ctx.session.estimation.constants;
            let all = [(PooledConstants::PerWindow, "per window"), (PooledConstants::Common, "common")];
            if choices(ui, &mut constants, &all) {
                ctx.edit(Edit::Estimation(EstimationEdit::Constants(constants)));
            }
            let mut by_surface = ctx.session.estimation.by_surface;
            let hint = "Symmetric coefficients from elevator windows, asymmetric ones from aileron and rudder windows";
            if ui.checkbox(&mut by_surface, "by surface").on_hover_text(hint).changed() {
                ctx.edit(Edit::Estimation(EstimationEdit::BySurface(by_surface)));
            }
        });
        ui.separator();
        ScrollArea::both().auto_shrink(false).show(ui, |ui| {
            self.matrix(ctx, ui);
            ui.add_space(6.0);
            self.add_term(ui);
            ui.add_space(6.0);
            warnings(ctx, ui);
        });
    }
}

impl Model {
    /// Terms that have a row: the common ones, those the model has, those just added.
    fn terms(&self, structure: &Structure) -> Vec<Term> {
        let mut terms = vec![Term::constant()];
        terms.extend(COMMON.map(Term::from));
        let used = structure.models.iter().flat_map(|(_, terms)| terms);
        for term in used.chain(&self.added) {
            if !terms.contains(term) {
                terms.push(term.clone());
            }
        }
        terms
    }

    fn matrix(&mut self, ctx: &mut PanelContext<'_>, ui: &mut Ui) {
        let session = ctx.session;
        Grid::new("terms").num_columns(Coefficient::ALL.len() + 1).spacing([14.0, 2.0]).striped(true).show(ui, |ui| {
            ui.label("");
            for coefficient in Coefficient::ALL {
                let name = format!("{}_", coefficient.name());
                ui.label(notation::derivative_job(ui, &name));
            }
            ui.end_row();
            for term in self.terms(&session.structure) {
                let about = term.factors().iter().map(|(variable, _)| variable.description()).collect::<Vec<_>>();
                let label = ui.label(notation::term(&term.to_string()));
                if !about.is_empty() {
                    label.on_hover_text(about.join("\n"));
                }
                for coefficient in Coefficient::ALL {
                    let was = session.structure.terms(coefficient).is_some_and(|terms| terms.contains(&term));
                    let mut on = was;
                    let tick = ui.checkbox(&mut on, "");
                    let name = format!("{} {term}", coefficient.name());
                    ui.ctx().accesskit_node_builder(tick.id, |node| node.set_label(name));
                    tick.on_hover_text(notation::derivative(&term.derivative_name(coefficient)));
                    if on != was {
                        ctx.edit(Edit::Model(ModelEdit::SetTerm { coefficient, term: term.clone(), on }));
                    }
                }
                ui.end_row();
            }
        });
    }

    /// A field for any product of variables.
    fn add_term(&mut self, ui: &mut Ui) {
        ui.horizontal(|ui| {
            ui.weak("Product term");
            let field = ui.add(TextEdit::singleline(&mut self.typed).hint_text("alpha*delta_e").desired_width(140.0));
            ui.ctx().accesskit_node_builder(field.id, |node| node.set_label("term to add"));
            let entered = field.lost_focus() && ui.input(|i| i.key_pressed(Key::Enter));
            if ui.button("Add row").clicked() || entered {
                match Term::parse(&self.typed) {
                    Ok(term) => {
                        self.added.insert(term);
                        self.typed.clear();
                        self.problem = None;
                    }
                    Err(error) => self.problem = Some(error.to_string()),
                }
            }
        });
        if let Some(problem) = &self.problem {
            let color = theme::palette(ui).error;
            ui.add(egui::Label::new(RichText::new(problem).color(color)).wrap());
        }
    }
}

/// Coefficients that could not be estimated, and why; how well conditioned the others are.
fn warnings(ctx: &PanelContext<'_>, ui: &mut Ui) {
    let palette = theme::palette(ui);
    let Some(pooled) = ctx.snapshot.pooled.latest() else { return };
    for fit in &pooled.fits {
        let name = fit.coefficient.name();
        match &fit.fit {
            Err(error) => {
                let text = RichText::new(format!("⚠ {name}: {error}")).color(palette.error);
                ui.add(egui::Label::new(text).wrap());
            }
            Ok(fit) => {
                ui.horizontal(|ui| {
                    ui.label(notation::derivative_job(ui, &format!("{name}_")));
                    let quality = &fit.quality;
                    ui.weak(format!(
                        "R² {}   residual {}   condition {}   {} samples",
                        notation::fixed(quality.r_squared, 4),
                        notation::number(fit.residual_std),
                        notation::number(fit.condition_number),
                        fit.samples()
                    ));
                });
            }
        }
    }
}
