//! Unsaved work of a program that ended: recovered, discarded or left for later.

use std::path::PathBuf;

use doublet_engine::autosave::{AbandonedAutosave, abandoned_autosaves};
use doublet_engine::compare::{self, SettingDifference};
use doublet_engine::document::Document;
use doublet_engine::session;
use eframe::egui::{self, Grid, RichText, ScrollArea, Ui};

use super::Workbench;
use crate::notation;

/// Differences drawn at most; a session that differs in more is another session.
const DIFFERENCES: usize = 200;

/// Where unsaved work is kept, and what was found there.
#[derive(Default)]
pub struct Recovery {
    folder: Option<PathBuf>,
    found: Vec<Found>,
    asking: bool,
}

/// Work that was found.
struct Found {
    abandoned: AbandonedAutosave,
    name: String,
    since: Option<String>,
    differing: Option<Result<Vec<SettingDifference>, String>>,
}

enum Answer {
    Recover,
    Discard,
    Show,
}

impl Workbench {
    /// Keeps unsaved work in `folder` from now on, and offers what is left there.
    #[must_use]
    pub fn keeping_work_in(mut self, folder: PathBuf) -> Self {
        self.recovery.folder = Some(folder);
        self.keep_document();
        self.look_for_work(|_| true);
        self
    }

    /// Whether unsaved work is being offered.
    pub fn is_offering_work(&self) -> bool {
        self.recovery.asking
    }

    /// Takes hold of the file of the session just opened.
    pub(super) fn keep_document(&mut self) {
        let Some(folder) = self.recovery.folder.clone() else { return };
        // Where it cannot be kept the document says so from now on.
        let _ = self.document.keep_in(&folder);
        if let (Some(path), Some(owner)) = (&self.document.path, self.document.held_by()) {
            let line = format!("{} is open in {owner}: save changes under another name", path.display());
            self.complain(line);
        }
    }

    /// Hands new work to the background writer.
    pub(super) fn keep_work(&mut self) {
        self.document.autosave();
    }

    /// Offers the work of the session just opened.
    pub(super) fn look_for_its_work(&mut self) {
        if let Some(path) = self.document.path.as_deref().and_then(|path| path.canonicalize().ok()) {
            self.look_for_work(|abandoned| abandoned.autosave.of.as_ref() == Some(&path));
        }
    }

    fn look_for_work(&mut self, wanted: impl Fn(&AbandonedAutosave) -> bool) {
        let Some(folder) = &self.recovery.folder else { return };
        let (mut found, unreadable) = abandoned_autosaves(folder);
        found.retain(wanted);
        self.recovery.found = found.into_iter().map(Found::new).collect();
        self.recovery.asking = !self.recovery.found.is_empty();
        if !unreadable.is_empty() {
            self.complain(unreadable.join("; "));
        }
    }

    /// Draws the offer.
    pub(super) fn offer_work(&mut self, ctx: &egui::Context) {
        if !self.recovery.asking || self.guarded.is_some() {
            return;
        }
        let (mut answer, mut later) = (None, false);
        egui::Modal::new(egui::Id::unique("recovery")).show(ctx, |ui| {
            ui.set_width(560.0);
            ui.heading("Unsaved work found");
            ui.label("The program ended before saving.");
            ui.add_space(8.0);
            for (at, found) in self.recovery.found.iter().enumerate() {
                if let Some(chosen) = found.show(ui) {
                    answer = Some((at, chosen));
                }
            }
            ui.add_space(8.0);
            later = ui.button("Ask again at the next start").clicked();
        });
        if later || ctx.input(|i| i.key_pressed(egui::Key::Escape)) {
            self.recovery.asking = false;
            // Let go of, so that another window may offer it.
            self.recovery.found.clear();
        }
        match answer {
            Some((at, Answer::Recover)) => self.recover(at),
            Some((at, Answer::Discard)) => {
                if let Err(error) = self.recovery.found.remove(at).abandoned.discard() {
                    self.complain(error.to_string());
                }
                self.recovery.asking = !self.recovery.found.is_empty();
            }
            Some((at, Answer::Show)) => self.recovery.found[at].compare(),
            None => {}
        }
    }

    /// Opens what was found at `at`. Unsaved work of the present session, if any, stays kept and is offered in its turn.
    fn recover(&mut self, at: usize) {
        let found = self.recovery.found.remove(at);
        self.recovery.asking = false;
        self.recovery.found.clear();
        self.document = Document::recover(&found.abandoned.autosave);
        self.message = None;
        self.enter();
        match self.document.adopt(found.abandoned) {
            Ok(()) if self.message.is_some() => {}
            Ok(()) if self.document.path.is_some() => {
                self.set_message("Recovered unsaved work: undo returns to the saved file");
            }
            Ok(()) => self.set_message("Recovered unsaved work without a file: save it"),
            Err(line) => self.complain(line),
        }
        self.look_for_work(|_| true);
    }
}

impl Found {
    fn new(abandoned: AbandonedAutosave) -> Self {
        let autosave = &abandoned.autosave;
        let name = autosave.of.as_ref().map(|of| of.display().to_string());
        let age = |time: std::time::SystemTime| time.elapsed().ok().map(notation::ago);
        Self {
            name: name.unwrap_or_else(|| format!("{} (never saved)", autosave.session.title)),
            since: age(abandoned.kept),
            abandoned,
            differing: None,
        }
    }

    fn compare(&mut self) {
        let autosave = &self.abandoned.autosave;
        let Some(of) = &autosave.of else { return };
        let rows = session::open(of).and_then(|opened| compare::settings(&opened.session, &autosave.session));
        self.differing = Some(rows.map_err(|error| error.to_string()));
    }

    fn show(&self, ui: &mut Ui) -> Option<Answer> {
        let mut answer = None;
        ui.label(RichText::new(&self.name).strong());
        let windows = self.abandoned.autosave.session.windows.len();
        let since = self.since.as_deref().map_or(String::new(), |since| format!("kept {since}, "));
        ui.weak(format!("{since}{windows} manoeuvres"));
        ui.horizontal(|ui| {
            // What was never saved has nothing to be compared with.
            let show = self.abandoned.autosave.of.is_some().then_some(("Show what differs", Answer::Show));
            for (name, choice) in [("Recover", Answer::Recover), ("Discard", Answer::Discard)].into_iter().chain(show) {
                if ui.button(name).clicked() {
                    answer = Some(choice);
                }
            }
        });
        match &self.differing {
            None => {}
            Some(Err(line)) => drop(ui.label(line)),
            Some(Ok(rows)) => table(rows, &self.name, ui),
        }
        ui.add_space(6.0);
        answer
    }
}

fn table(rows: &[SettingDifference], name: &str, ui: &mut Ui) {
    ScrollArea::both().id_salt(name).max_height(220.0).show(ui, |ui| {
        Grid::new(name).striped(true).num_columns(3).show(ui, |ui| {
            for title in ["Setting", "In the file", "In the unsaved work"] {
                ui.strong(title);
            }
            ui.end_row();
            let value = |text: &Option<String>, unit: &str| match text {
                Some(text) => format!("{text} {unit}"),
                None => "–".to_owned(),
            };
            for row in rows.iter().take(DIFFERENCES) {
                ui.label(&row.setting);
                ui.label(value(&row.first, &row.unit));
                ui.label(value(&row.second, &row.unit));
                ui.end_row();
            }
        });
    });
}
