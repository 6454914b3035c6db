//! Terms of the aerodynamic model: a table of coefficients and terms with ticks.

use std::collections::BTreeSet;

use doublet_core::estimate::{Constraint, TermEffect};
use doublet_core::model::{Coefficient, Structure, Term, Variable};
use doublet_engine::session::{
    Edit, EstimationEdit, ExperimentEdit, ModelEdit, PooledConstants, PredictionParameters, ResidualWeights,
};
use doublet_engine::verdict::CONDITION_LIMIT;
use eframe::egui::{self, CollapsingHeader, Grid, Key, RichText, ScrollArea, TextEdit, Ui};

use crate::command::{UiCommand, ViewCommand};
use crate::panels::model::{coefficient_settings, constraints, experiments, term_effects};
use crate::panels::{Pane, Panel, PanelContext, break_before, choices};
use crate::{notation, theme};

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

/// A named structure, with what it holds.
type Preset = (&'static str, fn() -> Structure, &'static str);

/// Structures to start from.
pub const PRESETS: [Preset; 4] = [
    ("Thesis", Structure::thesis, "CX CZ Cm of 1, α, q, δe and CY Cl Cn of 1, β, p, r, δa, δr (thesis Eq. 3.21, 3.22)"),
    ("Alternative", Structure::alternative, "Adds the rates of the flow angles (thesis Eq. B.1, B.2)"),
    ("Quadratic", Structure::quadratic, "Adds α² in CX, CZ, Cm (thesis Eq. 3.20)"),
    ("With power", Structure::with_power, "Adds engine power: needs manoeuvres at different power"),
];

/// What the weights of the residuals do.
const WEIGHTS_HINT: &str = "Huber: residuals beyond 1.345 σ weigh less. GLS: generalised least squares by an autoregression, for residuals that are correlated in time";

#[derive(Default)]
pub struct Model {
    typed: String,
    problem: Option<String>,
    added: BTreeSet<Term>,
    /// Row to bring into view.
    shown: Option<Term>,
    studied: Option<Coefficient>,
}

/// The choice of the weights of the residuals.
fn residual_weights(ctx: &mut PanelContext<'_>, ui: &mut Ui) {
    break_before(ui, &["Weights", "equal", "Huber", "GLS"]);
    ui.weak("Weights").on_hover_text(WEIGHTS_HINT);
    let mut weights = ctx.session.estimation.weights;
    let order = match weights {
        ResidualWeights::Autoregression(order) => order,
        ResidualWeights::Equal | ResidualWeights::Huber => ResidualWeights::USUAL_ORDER,
    };
    let all = [
        (ResidualWeights::Equal, "equal"),
        (ResidualWeights::Huber, "Huber"),
        (ResidualWeights::Autoregression(order), "GLS"),
    ];
    if choices(ui, &mut weights, &all) {
        ctx.edit(Edit::Estimation(EstimationEdit::Weights(weights)));
    }
}

impl Panel for Model {
    fn show(&mut self, ctx: &mut PanelContext<'_>, ui: &mut Ui) {
        ctx.wanted.terms = Some(self.terms(&ctx.session.structure));
        ui.horizontal_wrapped(|ui| {
            ui.weak("Structure");
            for (name, structure, about) in PRESETS {
                let structure = structure();
                let on = ctx.session.structure == structure;
                if ui.selectable_label(on, name).on_hover_text(about).clicked() && !on {
                    ctx.edit(Edit::Model(ModelEdit::Structure(structure)));
                }
            }
            ui.separator();
            keep(ctx, ui);
        });
        ui.horizontal_wrapped(|ui| {
            ui.weak("Constants");
            let mut constants = ctx.session.estimation.constants;
            let all = [(PooledConstants::PerManoeuvre, "per manoeuvre"), (PooledConstants::Common, "common")];
            if choices(ui, &mut constants, &all) {
                ctx.edit(Edit::Estimation(EstimationEdit::Constants(constants)));
            }
            let mut by_surface = ctx.session.estimation.by_surface;
            let hint =
                "Symmetric coefficients from elevator manoeuvres, asymmetric ones from aileron and rudder manoeuvres";
            if ui.checkbox(&mut by_surface, "by surface").on_hover_text(hint).changed() {
                ctx.edit(Edit::Estimation(EstimationEdit::BySurface(by_surface)));
            }
            residual_weights(ctx, ui);
        });
        ui.horizontal_wrapped(|ui| {
            ui.weak("Predictions by");
            let mut predict_with = ctx.session.estimation.predict_with;
            let all = [
                (PredictionParameters::Pooled, "pooled estimate"),
                (PredictionParameters::ManoeuvreMeans, "means of single manoeuvres"),
            ];
            if choices(ui, &mut predict_with, &all) {
                ctx.edit(Edit::Estimation(EstimationEdit::PredictWith(predict_with)));
            }
        });
        CollapsingHeader::new("Axes, reference, thrust and lags").show(ui, |ui| coefficient_settings::show(ctx, ui));
        let modelled =
            ctx.session.structure.models.iter().map(|(coefficient, _)| (Some(*coefficient), coefficient.name()));
        let all: Vec<_> = [(None, "All ticks")].into_iter().chain(modelled).collect();
        if !all.iter().any(|(choice, _)| *choice == self.studied) {
            self.studied = None;
        }
        ui.horizontal_wrapped(|ui| {
            choices(ui, &mut self.studied, &all);
            self.add_term(ui);
        });
        if let Some(problem) = &self.problem {
            let color = theme::palette(ui).error;
            ui.add(egui::Label::new(RichText::new(problem).color(color)).wrap());
        }
        ui.separator();
        ScrollArea::both().auto_shrink(false).show(ui, |ui| {
            match self.studied {
                Some(studied) => term_effects::show(ctx, ui, studied),
                None => {
                    self.matrix(ctx, ui);
                    term_effects::legend(ui);
                }
            }
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
        let details = ctx.snapshot.details.latest();
        let studies = details.map(|details| details.model.as_slice()).unwrap_or_default();
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
                if self.shown.as_ref() == Some(&term) {
                    label.scroll_to_me(None);
                    self.shown = None;
                }
                if !about.is_empty() {
                    label.on_hover_text(about.join("\n"));
                }
                for coefficient in Coefficient::ALL {
                    let was = session.structure.terms(coefficient).is_some_and(|terms| terms.contains(&term));
                    let mut on = was;
                    let cell = ui.cursor();
                    let tick = ui.checkbox(&mut on, "");
                    let name = format!("{} {term}", coefficient.name());
                    ui.ctx().accesskit_node_builder(tick.id, |node| node.set_label(name));
                    let derivative = notation::derivative(&term.derivative_name(coefficient));
                    let effect = term_effects::effect(studies, coefficient, &term);
                    let words =
                        effect.map(|effect| format!("\n{}", term_effects::effect_text(effect))).unwrap_or_default();
                    let tick = tick.on_hover_ui(|ui| {
                        ui.label(format!("{derivative}{words}"));
                        if let Some((text, color)) =
                            effect.and_then(|effect| term_effects::judgement(effect, theme::palette(ui)))
                        {
                            ui.label(RichText::new(text).color(color));
                        }
                        let known = session.estimation.constraints.iter();
                        for known in known.filter(|known| known.coefficient == coefficient && known.term == term) {
                            ui.label(known.summary());
                        }
                        if was {
                            ui.weak("Right click: fix, bound, prior");
                        }
                    });
                    mark(ui, &cell, effect, session.estimation.known(coefficient, &term));
                    if was {
                        constraints::menu(ctx, &tick, coefficient, &term);
                    }
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
            let field = ui.add(TextEdit::singleline(&mut self.typed).hint_text("alpha*delta_e").desired_width(110.0));
            ui.ctx().accesskit_node_builder(field.id, |node| node.set_label("term to add"));
            let entered = field.lost_focus() && ui.input(|i| i.key_pressed(Key::Enter));
            if ui.button("Add row").clicked() || entered {
                match Term::parse(&self.typed) {
                    Ok(term) => {
                        self.shown = Some(term.clone());
                        self.studied = None;
                        self.added.insert(term);
                        self.typed.clear();
                        self.problem = None;
                    }
                    Err(error) => self.problem = Some(error.to_string()),
                }
            }
        });
    }
}

/// Keeps the session as it is, with this structure, and leads to what was kept.
fn keep(ctx: &mut PanelContext<'_>, ui: &mut Ui) {
    let hint = "Save the session's configuration, with this structure, as an experiment, and go on editing";
    // Short: the row has no room for more in a panel of half a window.
    let button = ui.button("Keep").on_hover_text(hint);
    ui.ctx().accesskit_node_builder(button.id, |node| node.set_label("Keep as experiment"));
    if button.clicked() {
        let name = experiments::free_name(ctx.session);
        ctx.edit(Edit::Experiment(ExperimentEdit::Keep(name)));
    }
    if ui.button("Experiments").on_hover_text("Compare experiments and make one current").clicked() {
        ctx.commands.push(UiCommand::View(ViewCommand::Show(Pane::Experiments)));
    }
}

/// Marks beside a tick: what is known of its derivative, and whether its term deserves attention.
fn mark(ui: &Ui, cell: &egui::Rect, effect: Option<&TermEffect>, known: Constraint) {
    let place = cell.left_top() + egui::vec2(31.0, 10.0);
    let font = egui::FontId::proportional(12.0);
    let color = ui.visuals().strong_text_color();
    ui.painter().text(place, egui::Align2::LEFT_CENTER, constraints::sign(known), font, color);
    let Some((_, color)) = effect.and_then(|effect| term_effects::judgement(effect, theme::palette(ui))) else {
        return;
    };
    ui.painter().circle_filled(cell.left_top() + egui::vec2(26.0, 11.0), term_effects::DOT, color);
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
                        "R² {}   residual {}   condition {} (limit {CONDITION_LIMIT})   {} samples",
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
