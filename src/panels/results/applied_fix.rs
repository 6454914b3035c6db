//! A fix that was applied: the verdict before and after it, and the way back.

use doublet_engine::session::{Fix, Session};
use doublet_engine::verdict::VerdictCounts;
use eframe::egui::{Label, Ui};

use crate::command::{EditCommand, UiCommand};
use crate::notation;
use crate::panels::{EditRequest, PanelContext};
use crate::widgets::level_mark::level_mark;

/// A fix and what it was applied to.
pub struct AppliedFix {
    label: String,
    before: VerdictCounts,
    fixed: Session,
    /// Generation of the results it was applied to.
    generation: u64,
}

impl AppliedFix {
    /// Applies a fix as one step of undo; none where an edit is refused: that edit says why, and those before it are taken back.
    pub fn apply(ctx: &mut PanelContext<'_>, fix: &Fix) -> Option<Self> {
        let before = VerdictCounts::count(ctx.snapshot.verdicts.latest()?);
        ctx.edits.push(EditRequest::Begin(fix.label.clone()));
        ctx.edits.extend(fix.edits.iter().cloned().map(EditRequest::Apply));
        let fixed = fix.apply(ctx.session);
        ctx.edits.push(if fixed.is_ok() { EditRequest::Commit } else { EditRequest::Abort });
        let fixed = fixed.ok()?;
        Some(Self { label: fix.label.clone(), before, fixed, generation: ctx.snapshot.generation })
    }

    /// Whether the session is still what the fix made of it.
    pub fn is_current(&self, session: &Session) -> bool {
        self.fixed == *session
    }

    /// The fix, and the verdict before and, once it is computed, after.
    pub fn show(&self, ctx: &mut PanelContext<'_>, ui: &mut Ui) {
        ui.horizontal_wrapped(|ui| {
            let text = format!("Applied: {}.", self.label);
            ui.label(notation::typeset_in(&text, 12.5, ui.visuals().strong_text_color()));
            if ui.small_button("Undo").clicked() {
                ctx.commands.push(UiCommand::Edit(EditCommand::Undo));
            }
        });
        ui.horizontal_wrapped(|ui| {
            describe(ui, self.before);
            ui.label("→");
            let verdicts = ctx.snapshot.verdicts.ready();
            match verdicts.filter(|_| ctx.snapshot.generation > self.generation) {
                Some(verdicts) => describe(ui, VerdictCounts::count(verdicts)),
                None => drop(ui.weak("computing")),
            }
        });
    }
}

/// The level of a verdict, and how many derivatives are good, a caution, bad.
pub fn describe(ui: &mut Ui, counts: VerdictCounts) {
    let VerdictCounts { level, good, caution, bad } = counts;
    level_mark(ui, Some(level));
    let text = format!("{} (derivatives: {good} good, {caution} caution, {bad} bad)", level.name());
    ui.add(Label::new(notation::typeset(&text, 11.5)).truncate());
}
