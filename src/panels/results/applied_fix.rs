//! Fixes that were applied, and the findings as they were then: no row moves under the pointer, each shows the verdict before and after.

use std::sync::Arc;

use doublet_engine::session::{Fix, Session};
use doublet_engine::verdict::{VerdictCounts, Verdicts};
use eframe::egui::{Label, Rect, TextWrapMode, Ui};

use crate::notation;
use crate::panels::{EditRequest, PanelContext};
use crate::widgets::level_mark::level_mark;

/// A fix and what it was applied to.
pub struct AppliedFix {
    fix: Fix,
    pub before: VerdictCounts,
    fixed: Session,
    /// Generation of the results it was applied to.
    generation: u64,
    /// Height of its row then, points.
    pub height: f32,
}

impl AppliedFix {
    /// Applies a fix as one step of undo; none where an edit is refused: that edit says why, and those before it are taken back.
    fn apply(ctx: &mut PanelContext<'_>, fix: &Fix, height: f32) -> Option<Self> {
        let before = VerdictCounts::count(ctx.snapshot.verdicts.latest()?);
        ctx.edits.push(EditRequest::Begin(fix.label.clone()));
        ctx.edits.extend(fix.edits.iter().cloned().map(EditRequest::Apply));
        let fixed = fix.apply(ctx.session);
        ctx.edits.push(if fixed.is_ok() { EditRequest::Commit } else { EditRequest::Abort });
        let fixed = fixed.ok()?;
        Some(Self { fix: fix.clone(), before, fixed, generation: ctx.snapshot.generation, height })
    }

    /// The verdict with it, once it is computed.
    pub fn after(&self, ctx: &PanelContext<'_>) -> Option<VerdictCounts> {
        let verdicts = ctx.snapshot.verdicts.ready().filter(|_| ctx.snapshot.generation > self.generation);
        verdicts.map(|verdicts| VerdictCounts::count(verdicts))
    }
}

/// The findings listed while fixes are applied: those of the first of them, until the pointer leaves the list.
#[derive(Default)]
pub struct HeldFindings {
    held: Option<Arc<Verdicts>>,
    /// The fixes that still hold, in the order in which they were applied.
    applied: Vec<AppliedFix>,
    /// Whether the pointer has been over the list since.
    has_entered: bool,
}

impl HeldFindings {
    /// The verdicts whose findings are listed.
    pub fn listed(&self, latest: &Arc<Verdicts>) -> Arc<Verdicts> {
        Arc::clone(self.held.as_ref().unwrap_or(latest))
    }

    /// Whether the findings listed are those of an earlier moment.
    pub fn is_holding(&self) -> bool {
        self.held.is_some()
    }

    /// The fix as it was applied, if it was.
    pub fn applied(&self, fix: &Fix) -> Option<&AppliedFix> {
        self.applied.iter().find(|applied| applied.fix == *fix)
    }

    /// Applies a fix of a row of that height, and holds the findings.
    pub fn apply(&mut self, ctx: &mut PanelContext<'_>, listed: &Arc<Verdicts>, (fix, height): (&Fix, f32)) {
        if let Some(applied) = AppliedFix::apply(ctx, fix, height) {
            self.applied.push(applied);
            self.held = Some(Arc::clone(listed));
        }
    }

    /// Forgets fixes that were undone or changed since.
    pub fn follow(&mut self, ctx: &PanelContext<'_>) {
        if ctx.edits.is_empty() {
            let is_current = |applied: &AppliedFix| applied.fixed == *ctx.session;
            let kept = self.applied.iter().rposition(is_current).map_or(0, |last| last + 1);
            self.applied.truncate(kept);
        }
    }

    /// Lists the latest findings again.
    pub fn release(&mut self) {
        *self = Self::default();
    }

    /// Lists the latest findings again where the pointer has left `list`, or nothing applied is left and it never was there.
    pub fn release_left(&mut self, ui: &Ui, list: Rect) {
        let is_inside = ui.input(|input| input.pointer.latest_pos()).is_some_and(|pointer| list.contains(pointer));
        if self.held.is_some() && !is_inside && (self.has_entered || self.applied.is_empty()) {
            self.release();
        } else {
            self.has_entered = self.held.is_some() && (self.has_entered || is_inside);
        }
    }
}

/// The level of a verdict, and how many derivatives are good, a caution, bad.
pub fn describe(ui: &mut Ui, counts: VerdictCounts) {
    let VerdictCounts { level, good, caution, bad } = counts;
    level_mark(ui, Some(level));
    let text = format!("{} ({good} good, {caution} caution, {bad} bad)", level.name());
    let label = ui.add(Label::new(notation::typeset(&text, 11.5)).wrap_mode(TextWrapMode::Extend));
    label.on_hover_text("Level of the session, and the derivatives by their level");
}
