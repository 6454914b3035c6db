//! The question for a session whose file somebody else has changed while it was open here.

use eframe::egui::{self, Event, Key, ScrollArea, vec2};

use doublet_engine::document::Changed;

use super::Workbench;
use super::pending::{Asked, Pending};

/// What is asked, and what waits for the answer.
pub(super) struct Question {
    changed: Changed,
    after: Option<Pending>,
    /// Whether the differences are shown.
    shown: bool,
}

#[derive(Clone, Copy)]
enum Answer {
    KeepMine,
    TakeTheirs,
    Show,
    Stay,
}

impl Workbench {
    /// Whether it is being asked what to do with a file that was changed on disk.
    pub fn is_asking_about_change(&self) -> bool {
        self.changed.is_some()
    }

    /// Asks what to do where the session's file was changed on disk; whether it was.
    pub(super) fn ask_about_change(&mut self, after: Option<Pending>) -> bool {
        let Some(changed) = self.document.changed_on_disk() else { return false };
        self.changed = Some(Question { changed, after, shown: false });
        true
    }

    /// Asks the same where the window has just been given the keyboard: whoever comes back from an editor learns of its version before
    /// the next edit. A version that was answered with "Stay" is not asked about again before the session is saved.
    pub(super) fn notice_change(&mut self, ctx: &egui::Context) {
        let came_back = ctx.input(|input| input.events.contains(&Event::WindowFocused(true)));
        if !came_back || self.is_asking() || self.document.history.is_open() {
            return;
        }
        let changed = self.document.changed_on_disk();
        let changed = changed.filter(|changed| self.stayed_with.as_deref() != Some(changed.sha256()));
        self.changed = changed.map(|changed| Question { changed, after: None, shown: false });
    }

    pub(super) fn draw_change(&mut self, ctx: &egui::Context) {
        let Some(question) = &self.changed else { return };
        let mut answer = None;
        egui::Modal::new(egui::Id::unique("changed")).show(ctx, |ui| {
            ui.set_width(620.0);
            ui.heading("This session was changed on disk");
            let count = question.changed.differences.len();
            ui.label(format!("Another program has changed its file ({count} differences)."));
            if question.shown {
                ui.add_space(8.0);
                ScrollArea::vertical().max_height(300.0).show(ui, |ui| {
                    question.changed.differences.iter().for_each(|line| _ = ui.label(line));
                });
            }
            ui.add_space(10.0);
            ui.horizontal(|ui| {
                let mut button = |name: &str, enabled: bool, given: Answer| {
                    let button = egui::Button::new(name).min_size(vec2(120.0, 26.0));
                    if ui.add_enabled(enabled, button).clicked() {
                        answer = Some(given);
                    }
                };
                button("Keep mine as…", true, Answer::KeepMine);
                button("Take theirs", question.changed.can_be_taken(), Answer::TakeTheirs);
                button("Show", !question.shown, Answer::Show);
                button("Stay", true, Answer::Stay);
            });
        });
        if ctx.input(|i| i.key_pressed(Key::Escape)) {
            answer = Some(Answer::Stay);
        }
        match answer {
            Some(Answer::Show) => self.changed.iter_mut().for_each(|question| question.shown = true),
            Some(answer) => self.answer_change(answer, ctx),
            None => {}
        }
    }

    fn answer_change(&mut self, answer: Answer, ctx: &egui::Context) {
        let Some(Question { changed, after, .. }) = self.changed.take() else { return };
        match answer {
            Answer::KeepMine => self.ask(Asked::Save(after), ctx),
            Answer::TakeTheirs => {
                self.document.take_theirs(changed);
                self.set_message("Loaded the version on disk: undo restores yours");
                if let Some(pending) = after {
                    self.leave(pending, ctx);
                }
            }
            Answer::Stay => self.stayed_with = Some(changed.sha256().to_owned()),
            Answer::Show => {}
        }
    }
}
