//! Findings as they are read: what was found, where, what to do, the fix with the verdict it leads to, and the way to the panel and its field.

use std::cmp::Reverse;
use std::collections::BTreeSet;

use doublet_core::model::Coefficient;
use doublet_engine::session::{Edit, ExperimentEdit, Fix, Place, Session};
use doublet_engine::verdict::{Finding, VerdictCounts};
use eframe::egui::{Button, Label, RichText, Ui};

use crate::command::{EditCommand, UiCommand, ViewCommand};
use crate::notation;
use crate::panels::results::applied_fix::{HeldFindings, describe};
use crate::panels::{Pane, PanelContext};
use crate::ui_state::Scope;
use crate::widgets::level_mark::level_mark;
use crate::widgets::quantity_edit;

/// Width of the verdict after a fix, and room for the scroll bar right of the findings.
const AFTER: f32 = 270.0;
const SCROLL_ROOM: f32 = 10.0;
/// Code of channels that contradict each other.
const CONTRADICTION: &str = "physics";

/// Findings of one kind and level: the first stands for all.
pub struct FindingKind<'a> {
    first: &'a Finding,
    places: Vec<&'a Place>,
    /// The fixes of all of them as one.
    pub fix: Option<Fix>,
}

impl<'a> FindingKind<'a> {
    /// The kinds among findings in their order, channels that contradict each other before others as bad: those follow from them.
    pub fn group(findings: &[&'a Finding]) -> Vec<Self> {
        let mut groups: Vec<Vec<&'a Finding>> = Vec::new();
        for finding in findings {
            let same = |group: &&mut Vec<&Finding>| (group[0].code, group[0].level) == (finding.code, finding.level);
            match groups.iter_mut().find(same) {
                Some(group) => group.push(finding),
                None => groups.push(vec![finding]),
            }
        }
        groups.sort_by_key(|group| (Reverse(group[0].level), group[0].code != CONTRADICTION));
        groups.into_iter().map(|group| Self::join(&group)).collect()
    }

    fn join(group: &[&'a Finding]) -> Self {
        let mut fixes: Vec<&Fix> = Vec::new();
        for fix in group.iter().filter_map(|finding| finding.fix.as_ref()) {
            if fixes.iter().all(|known| known.edits != fix.edits) {
                fixes.push(fix);
            }
        }
        let places = group.iter().map(|finding| &finding.place).collect();
        Self { first: group[0], places, fix: Fix::join(&fixes) }
    }

    /// The manoeuvres of `session` that they are about.
    fn manoeuvres<'s>(&self, session: &'s Session) -> Vec<&'s str> {
        let named: BTreeSet<&str> = self.places.iter().filter_map(|place| place.manoeuvre_name()).collect();
        session.windows.iter().map(|window| window.name.as_str()).filter(|name| named.contains(name)).collect()
    }
}

/// Findings of one kind; the height of the row of their fix where that is to be applied.
pub fn show(ctx: &mut PanelContext<'_>, ui: &mut Ui, kind: &FindingKind<'_>, held: &HeldFindings) -> Option<f32> {
    let (finding, alike) = (kind.first, kind.places.len());
    let mut wanted = None;
    ui.add_space(2.0);
    ui.horizontal_top(|ui| {
        level_mark(ui, Some(finding.level));
        ui.vertical(|ui| {
            ui.set_max_width(ui.available_width() - SCROLL_ROOM);
            ui.spacing_mut().item_spacing.y = 1.0;
            let more = if alike > 1 { format!("   and {} more like this", alike - 1) } else { String::new() };
            let weak = ui.visuals().weak_text_color();
            ui.add(Label::new(notation::typeset_in(&format!("{}{more}", finding.place), 11.0, weak)).wrap());
            ui.add(Label::new(notation::typeset(&finding.text.to_string(), 13.0)).wrap());
            if !finding.fix_text.is_empty() {
                ui.add(Label::new(notation::typeset_in(&finding.fix_text, 11.5, weak)).wrap());
            }
            if let Some(fix) = &kind.fix {
                wanted = fix_row(ctx, ui, fix, held);
            }
            ui.horizontal_wrapped(|ui| {
                ui.spacing_mut().item_spacing.x = 8.0;
                select(ctx, ui, &kind.manoeuvres(ctx.session));
                if let Some(pane) = finding.panel.and_then(Pane::from_title)
                    && ui.small_button(format!("Open {}", pane.title())).clicked()
                {
                    open(ctx, ui, finding, pane);
                }
            });
        });
    });
    wanted
}

/// The fix with the verdict before and after it; its height where it is to be applied.
fn fix_row(ctx: &mut PanelContext<'_>, ui: &mut Ui, fix: &Fix, held: &HeldFindings) -> Option<f32> {
    let mut is_wanted = false;
    let applied = held.applied(fix);
    let row = ui.vertical(|ui| {
        if let Some(applied) = applied {
            ui.set_min_height(applied.height);
            ui.horizontal_wrapped(|ui| applied_actions(ctx, ui, fix));
            return change(ui, Some(applied.before), applied.after(ctx).ok_or("computing"));
        }
        let tried = &mut ctx.wanted.inquiry.fixes;
        tried.0 = ctx.snapshot.generation;
        tried.1.push(fix.clone());
        ui.horizontal_wrapped(|ui| is_wanted = actions(ctx, ui, fix));
        let slot = ctx.snapshot.inquiries.fixes.row(fix);
        let after = match slot.map(|slot| (slot.ready(), slot.error())) {
            Some((Some(outcome), _)) => Ok(outcome.verdict),
            Some((None, Some(error))) => Err(error),
            _ => Err("computing"),
        };
        let before = ctx.snapshot.verdicts.latest().map(|verdicts| VerdictCounts::count(verdicts));
        change(ui, before, after);
    });
    is_wanted.then_some(row.response.rect.height())
}

/// What can be done with a fix: apply it, or keep it as an experiment; whether it is to be applied.
fn actions(ctx: &mut PanelContext<'_>, ui: &mut Ui, fix: &Fix) -> bool {
    ui.spacing_mut().item_spacing.x = 8.0;
    let button = ui.add(Button::new(notation::typeset(&format!("Apply: {}", fix.label), 12.5)).small());
    ui.ctx().accesskit_node_builder(button.id, |node| node.set_label(format!("Apply: {}", fix.label)));
    let is_wanted = button.on_hover_text("Applies the fix as one undo step").clicked();
    if fix.is_of_configuration() {
        let button = ui.small_button("Add as experiment");
        let hint = "Keeps the session with this fix as an experiment, to compare it with others";
        if button.on_hover_text(hint).clicked()
            && let Some(experiment) = fix.to_experiment(ctx.session)
        {
            ctx.edit(Edit::Experiment(ExperimentEdit::Add(vec![experiment])));
            ctx.commands.push(UiCommand::View(ViewCommand::Show(Pane::Experiments)));
        }
    }
    is_wanted
}

/// A fix that was applied, and its undo.
fn applied_actions(ctx: &mut PanelContext<'_>, ui: &mut Ui, fix: &Fix) {
    let text = format!("Applied: {}", fix.label);
    ui.label(notation::typeset_in(&text, 12.5, ui.visuals().strong_text_color()));
    if ui.small_button("Undo").clicked() {
        ctx.commands.push(UiCommand::Edit(EditCommand::Undo));
    }
}

/// The verdict before and after a fix, or why the latter is not there; the latter is in a row of its own where both do not fit.
fn change(ui: &mut Ui, before: Option<VerdictCounts>, after: Result<VerdictCounts, &str>) {
    ui.horizontal_wrapped(|ui| {
        before.into_iter().for_each(|before| describe(ui, before));
        if ui.available_size_before_wrap().x < AFTER {
            ui.end_row();
        }
        ui.label("→");
        match after {
            Ok(after) => describe(ui, after),
            Err(reason) => drop(ui.weak(reason)),
        }
    });
}

/// The link that selects manoeuvres.
fn select(ctx: &mut PanelContext<'_>, ui: &mut Ui, names: &[&str]) {
    let Some((first, others)) = names.split_first() else { return };
    let text = match names.len() {
        1 => "Select this manoeuvre".to_owned(),
        count => format!("Select these {count} manoeuvres"),
    };
    let link = ui.link(RichText::new(text).size(11.5));
    if link.on_hover_text("Edits of the selected manoeuvre then apply to all of them").clicked() {
        ctx.choose(first);
        ctx.state.selection.others = others.iter().map(|name| (*name).to_owned()).collect();
        ctx.commands.push(UiCommand::View(ViewCommand::Show(Pane::Manoeuvres)));
    }
}

/// The name of the field of a panel that holds the setting of a finding.
fn field(reason: &Finding, manoeuvre: Option<&str>) -> Option<String> {
    let setting = reason.setting.as_deref()?;
    let called = |prefix: &str, word: &str| setting.strip_prefix(prefix).map(|name| format!("{word} {name}"));
    let control = || {
        let control = setting.strip_prefix("preparation.control_lag.")?.split('.').next()?;
        Some(format!("{control} delay"))
    };
    match setting {
        "filter.gravity_m_s2" => Some("gravity".to_owned()),
        "manoeuvre.end_s" => manoeuvre.map(|name| format!("{name} end")),
        _ => {
            called("filter.measurement_noise.", "R").or_else(|| called("filter.random_walk.", "walk")).or_else(control)
        }
    }
}

/// Brings the panel that fixes `reason` to the front, with what it is about chosen and its field marked.
fn open(ctx: &mut PanelContext<'_>, ui: &Ui, reason: &Finding, pane: Pane) {
    let window = reason.place.manoeuvre_name().and_then(|name| ctx.session.window(name));
    if let Some(field) = field(reason, window.map(|window| window.name.as_str())) {
        quantity_edit::seek(ui.ctx(), field);
    }
    if let Some(window) = window {
        ctx.choose(&window.name);
    }
    if let Place::Derivative { name, .. } = &reason.place
        && Coefficient::from_name(name).is_none()
    {
        ctx.state.selection.derivative = Some(name.clone());
        ctx.state.selection.scope = if window.is_some() { Scope::Chosen } else { Scope::All };
    }
    ctx.commands.push(UiCommand::View(ViewCommand::Show(pane)));
}
