//! The questions for the words of an annotation and for the note on a manoeuvre.

use doublet_engine::session::{AnnotationEdit, Edit, WindowEdit};
use eframe::egui::{self, Button, Key, TextEdit};

use super::Workbench;
use crate::notation;

impl Workbench {
    /// Asks for the note on a manoeuvre; Enter keeps it.
    pub(super) fn ask_note(&mut self, ctx: &egui::Context) {
        let Some((name, mut note)) = self.state.noting.take() else { return };
        let (mut kept, mut given_up) = (false, false);
        egui::Modal::new(egui::Id::unique("note")).show(ctx, |ui| {
            ui.set_width(360.0);
            ui.heading(format!("Note on {name}"));
            let field = TextEdit::singleline(&mut note).hint_text("For example: light turbulence");
            let field = ui.add(field.desired_width(f32::INFINITY));
            ui.ctx().accesskit_node_builder(field.id, |node| node.set_label("note"));
            let confirmed = field.lost_focus() && ui.input(|input| input.key_pressed(Key::Enter));
            field.request_focus();
            ui.add_space(8.0);
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
            let field = TextEdit::singleline(&mut new.text).hint_text("What happens here").desired_width(f32::INFINITY);
            let field = ui.add(field);
            ui.ctx().accesskit_node_builder(field.id, |node| node.set_label("words of the annotation"));
            let confirmed = field.lost_focus() && ui.input(|input| input.key_pressed(Key::Enter));
            field.request_focus();
            ui.add_space(8.0);
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
