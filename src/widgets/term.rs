//! A word of the glossary: a pause over it says what it is, F1 opens its entry.

use doublet_cli::glossary::{self, Entry};
use eframe::egui::{self, Id, Label, Response, RichText, Ui};
use egui_extras::TableRow;

/// Width of what a pause shows, points.
const WIDTH: f32 = 330.0;

/// The word under the pointer in the frame of that number.
#[derive(Clone, Copy)]
struct Hovered(&'static str, u64);

/// `shown` with the entry of the glossary it is called by.
pub fn term(ui: &mut Ui, shown: impl Into<RichText>) -> Response {
    let text = shown.into();
    let word = text.text().to_owned();
    term_called(ui, text, &word)
}

/// `shown` with the entry of `word`.
pub fn term_called(ui: &mut Ui, shown: impl Into<RichText>, word: &str) -> Response {
    explained(ui.add(Label::new(shown.into()).truncate()), word)
}

/// The title of a column, with the entry of the glossary it is called by.
pub fn column_title(ui: &mut Ui, title: &str) -> Response {
    column_title_called(ui, title, title)
}

pub fn column_titles<'t>(mut header: TableRow<'_, '_>, titles: impl IntoIterator<Item = &'t str>) {
    for title in titles {
        header.col(|ui| drop(column_title(ui, title)));
    }
}

/// The title of a column with the entry of `word`.
pub fn column_title_called(ui: &mut Ui, title: &str, word: &str) -> Response {
    let label = ui.add(Label::new(RichText::new(title).size(11.0).weak()).extend());
    if !title.is_empty() {
        ui.ctx().accesskit_node_builder(label.id, |node| {
            node.set_role(egui::accesskit::Role::ColumnHeader);
            node.set_label(title);
        });
    }
    explained(label, word)
}

/// `response` with what the glossary says of `word` while the pointer rests on it.
pub fn explained(response: Response, word: &str) -> Response {
    let Some(entry) = glossary::find(word) else { return response };
    response.ctx.accesskit_node_builder(response.id, |node| node.set_description(entry.what.as_str()));
    if response.contains_pointer() {
        let ctx = &response.ctx;
        let hovered = Hovered(&entry.word, ctx.cumulative_frame_nr());
        ctx.data_mut(|data| data.insert_temp(Id::NULL, hovered));
    }
    response.on_hover_ui(|ui| show_entry(ui, entry))
}

/// The word under the pointer.
pub fn hovered(ctx: &egui::Context) -> Option<&'static str> {
    let Hovered(word, frame) = ctx.data(|data| data.get_temp(Id::NULL))?;
    (ctx.cumulative_frame_nr() <= frame + 1).then_some(word)
}

/// Draws an entry.
fn show_entry(ui: &mut Ui, entry: &Entry) {
    ui.set_max_width(WIDTH);
    ui.strong(&entry.word);
    ui.add(Label::new(&entry.what).wrap());
    for (name, text) in entry.facts() {
        ui.add(Label::new(RichText::new(format!("{name}: {text}")).size(11.5).weak()).wrap());
    }
    ui.label(RichText::new("F1 opens the glossary").size(10.5).weak());
}
