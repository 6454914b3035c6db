//! Objective tests of flight simulators on the identified model: tests of a file on the manoeuvres of the session, with tolerance
//! bands, flight and model, and the guide as a file.

use std::path::{Path, PathBuf};

use doublet_engine::builtin::PREFIX;
use doublet_engine::keep::Put;
use doublet_engine::qtg::{Judged, NAME, TestFile, judge};
use doublet_engine::run::{Control, Job};
use doublet_engine::session::Session;
use doublet_report::DocumentSet;
use eframe::egui::{self, Button, Label, RichText, ScrollArea, Ui};

use crate::command::FileField;
use crate::panels::report::design::written_forms;
use crate::panels::{Panel, PanelContext, Working, browse, empty, text_field};
use crate::theme;
use crate::widgets::level_mark::level_mark;

/// Tests that come with the program.
const SHIPPED: &str = "builtin:qtg/demo";
/// Width of the list of tests.
const LIST: f32 = 300.0;

#[derive(Default)]
pub struct Qualification {
    /// File of tests as typed; before that the one that comes with the program, where it fits the session.
    tests: Option<String>,
    /// Names of the windows, and whether the tests that come with the program are on them.
    fits: Option<(Vec<String>, bool)>,
    folder: String,
    judging: Working<Judged>,
    writing: Working<Put>,
    /// Session that was judged.
    of: Option<Box<Session>>,
    chosen: usize,
}

impl Panel for Qualification {
    fn show(&mut self, ctx: &mut PanelContext<'_>, ui: &mut Ui) {
        ui.horizontal_wrapped(|ui| {
            let before = self.named(ctx.session);
            let mut tests = before.clone();
            text_field(ui, "file of tests", &mut tests, "file of tests", 220.0);
            browse(ctx, ui, FileField::Tests, &mut tests);
            if tests != before {
                self.tests = Some(tests.clone());
            }
            let possible = !tests.trim().is_empty() && !self.judging.is_busy();
            if ui.add_enabled(possible, Button::new("Judge the tests")).clicked() {
                self.start(ctx, ui, tests.trim());
            }
            self.write(ctx, ui);
        });
        if self.judging.show(ui) {
            self.chosen = 0;
        }
        self.writing.show(ui);
        let Some(judged) = self.judging.done() else {
            return empty(
                ui,
                match self.named(ctx.session).trim() {
                    "" => "Choose a file of objective tests: a rule, and the manoeuvres of each test.",
                    _ => "Judge the tests to compare the model with the manoeuvres of the session.",
                },
            );
        };
        let palette = theme::palette(ui);
        if self.of.as_deref().is_some_and(|of| of != ctx.session) {
            ui.label(RichText::new("the session has changed: evaluate again").color(palette.warning));
        }
        ui.label(format!("{}: {}", judged.found.rule, judged.found.tally()));
        egui::Panel::left("list of tests").resizable(false).exact_size(LIST).show(ui, |ui| {
            ScrollArea::vertical().auto_shrink(false).show(ui, |ui| {
                ui.style_mut().wrap_mode = Some(egui::TextWrapMode::Truncate);
                for (index, test) in judged.found.tests.iter().enumerate() {
                    ui.horizontal(|ui| {
                        level_mark(ui, Some(test.outcome.level())).on_hover_text(test.outcome.label());
                        let name = format!("{} {}", test.id, test.title);
                        let row = ui.selectable_label(self.chosen == index, name);
                        if row.on_hover_text(&test.reason).clicked() {
                            self.chosen = index;
                        }
                    });
                }
            });
        });
        let ground = egui::Frame::new().inner_margin(egui::Margin { left: 8, ..Default::default() });
        egui::CentralPanel::default().frame(ground).show(ui, |ui| {
            let Some(test) = judged.found.tests.get(self.chosen) else { return };
            let name = test.section();
            let Some(page) = judged.guide.sections.iter().find(|section| section.name == name) else { return };
            ScrollArea::vertical().id_salt(&name).auto_shrink(false).show(ui, |ui| {
                ui.add(Label::new(RichText::new(&page.title).strong()).wrap());
                ctx.document(ui, &page.blocks);
            });
        });
    }
}

impl Qualification {
    /// The file of tests: as typed, else the one that comes with the program where all its windows are in the session.
    fn named(&mut self, session: &Session) -> String {
        if let Some(typed) = &self.tests {
            return typed.clone();
        }
        let names = || session.windows.iter().map(|window| &window.name);
        if !self.fits.as_ref().is_some_and(|(of, _)| of.iter().eq(names())) {
            let all: Vec<String> = names().cloned().collect();
            let shipped = TestFile::open(Path::new(SHIPPED));
            let fits = shipped.is_ok_and(|file| {
                let mut used_windows = file.tests.iter().flat_map(|test| &test.windows).peekable();
                used_windows.peek().is_some() && used_windows.all(|window| all.contains(window))
            });
            self.fits = Some((all, fits));
        }
        let fits = self.fits.as_ref().is_some_and(|(_, fits)| *fits);
        if fits { SHIPPED.to_owned() } else { String::new() }
    }

    fn start(&mut self, ctx: &PanelContext<'_>, ui: &Ui, name: &str) {
        let tests = if name.starts_with(PREFIX) { PathBuf::from(name) } else { ctx.folder.join(name) };
        let (session, folder) = (ctx.session.clone(), ctx.folder.to_owned());
        self.of = Some(Box::new(session.clone()));
        let work = move |control: &Control, progress: &(dyn Fn(f32) + Sync)| {
            judge(&session, &folder, &TestFile::open(&tests)?, control, progress)
        };
        let repaint = ui.ctx().clone();
        self.judging.take(Job::start("doublet-qualification", move || repaint.request_repaint(), work));
    }

    /// The folder for the guide and the button that writes it.
    fn write(&mut self, ctx: &mut PanelContext<'_>, ui: &mut Ui) {
        let Some(judged) = self.judging.done() else { return };
        text_field(ui, "folder of the guide", &mut self.folder, "folder for the guide", 180.0);
        browse(ctx, ui, FileField::Guide, &mut self.folder);
        let possible = !self.folder.trim().is_empty() && !self.writing.is_busy();
        if !ui.add_enabled(possible, Button::new("Write the guide")).clicked() {
            return;
        }
        let place = ctx.folder.join(Path::new(self.folder.trim()));
        let (guide, beside) = (judged.guide.clone(), judged.beside());
        let work = move |control: &Control, progress: &(dyn Fn(f32) + Sync)| {
            let (beside, formats) = (beside?, written_forms());
            let set = DocumentSet { folder: &place, name: NAME, formats: &formats, beside: &beside };
            set.write(&guide, "qualification test guide", control, progress)
        };
        let repaint = ui.ctx().clone();
        self.writing.take(Job::start("doublet-guide", move || repaint.request_repaint(), work));
    }
}
