//! The questions for the words of an annotation and for the note on a manoeuvre.

use doublet_engine::session::{AnnotationEdit, Edit, WindowEdit};
use eframe::egui::{self, Button, Key, KeyboardShortcut, Modifiers, TextEdit, Ui};

use super::Workbench;
use crate::notation;

/// Inserts a line break; Enter alone keeps the words.
const LINE_BREAK: KeyboardShortcut = KeyboardShortcut::new(Modifiers::SHIFT, Key::Enter);

/// The field of words, as high as they need; whether Enter keeps them.
fn edit_words(ui: &mut Ui, words: &mut String, label: &str, hint: &str) -> bool {
    let field = TextEdit::multiline(words).hint_text(hint).desired_width(f32::INFINITY);
    let field = ui.add(field.desired_rows(1).return_key(LINE_BREAK));
    ui.ctx().accesskit_node_builder(field.id, |node| node.set_label(label));
    // The key that opened the dialog does not close it.
    let had_focus = field.has_focus();
    field.request_focus();
    ui.add_space(8.0);
    had_focus && ui.input(|input| input.key_pressed(Key::Enter) && !input.modifiers.shift)
}

impl Workbench {
    /// Asks for the note on a manoeuvre; Enter keeps it.
    pub(super) fn ask_note(&mut self, ctx: &egui::Context) {
        let Some((name, mut note)) = self.state.noting.take() else { return };
        let (mut kept, mut given_up) = (false, false);
        egui::Modal::new(egui::Id::unique("note")).show(ctx, |ui| {
            ui.set_width(360.0);
            ui.heading(format!("Note on {name}"));
            let confirmed = edit_words(ui, &mut note, "note", "For example: light turbulence");
            ui.horizontal(|ui| {
                kept = ui.button("Keep").clicked() || confirmed;
                given_up = ui.button("Cancel").clicked() || ui.input(|input| input.key_pressed(Key::Escape));
            });
        });
        if kept {
            self.apply(&Edit::Window(WindowEdit::Note { name, note: note.trim().to_owned() }));
        } else if !given_up {
            self.state.noting = Some((name, note));
        }
    }

    /// Asks for the words of the annotation being written; Enter keeps them, without words it is removed.
    pub(super) fn ask_annotation(&mut self, ctx: &egui::Context) {
        let Some((mut new, before)) = self.state.annotating.take() else { return };
        let (mut kept, mut removed, mut given_up) = (false, false, false);
        egui::Modal::new(egui::Id::unique("annotation")).show(ctx, |ui| {
            ui.set_width(320.0);
            ui.heading(format!("At {} s", notation::fixed(new.time_s, 2)));
            let confirmed = edit_words(ui, &mut new.text, "words of the annotation", "What happens here");
            ui.horizontal(|ui| {
                let has_words = !new.text.trim().is_empty();
                kept = (ui.add_enabled(has_words, Button::new("Keep")).clicked() || confirmed) && has_words;
                removed = before.is_some() && (ui.button("Remove annotation").clicked() || (confirmed && !has_words));
                given_up = ui.button("Cancel").clicked() || ui.input(|input| input.key_pressed(Key::Escape));
            });
        });
        let edit = match before.clone() {
            Some(from) if removed => Some(AnnotationEdit::Remove(from)),
            Some(from) if kept => Some(AnnotationEdit::Change { from, to: new.clone() }),
            None if kept => Some(AnnotationEdit::Add(new.clone())),
            _ => None,
        };
        match edit {
            Some(edit) => self.apply(&Edit::Annotation(edit)),
            None if given_up => {}
            None => self.state.annotating = Some((new, before)),
        }
    }
}
