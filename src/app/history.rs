//! The list of edits: a click goes back to there, or forward again.

use eframe::egui::{self, Label, RichText, ScrollArea, Ui, vec2};

use super::Workbench;

/// Width of the window, and height of its list at most, points.
const WIDTH: f32 = 280.0;
const MOST: f32 = 320.0;

impl Workbench {
    /// Shows the list of edits, or no more.
    pub fn toggle_history(&mut self) {
        self.history_shown = !self.history_shown;
    }

    /// Goes to the state after `done` edits.
    pub fn go_to_edit(&mut self, done: usize) {
        if self.document.history.go_to(done) {
            self.undone = true;
            self.cause = match done.checked_sub(1).map(|last| self.document.history.steps().0[last].to_owned()) {
                Some(label) => format!("go to {label}"),
                None => "go to the start".to_owned(),
            };
        }
    }

    /// Draws the list.
    pub(super) fn show_history(&mut self, ctx: &egui::Context) {
        if !self.history_shown {
            return;
        }
        let mut open = true;
        let mut wanted = None;
        let (steps, done) = self.document.history.steps();
        egui::Window::new("History")
            .id(egui::Id::unique("history"))
            .open(&mut open)
            .default_pos(egui::pos2(140.0, 60.0))
            .default_width(WIDTH)
            .collapsible(false)
            .show(ctx, |ui| {
                let text = if steps.is_empty() { "No edit yet." } else { "Click an edit to go to the state after it." };
                ui.add(Label::new(RichText::new(text).size(11.0).weak()).wrap());
                ScrollArea::vertical().auto_shrink([false, true]).max_height(MOST).stick_to_bottom(true).show(
                    ui,
                    |ui| {
                        ui.spacing_mut().item_spacing.y = 1.0;
                        let all = std::iter::once("Start").chain(steps.iter().copied());
                        for (at, label) in all.enumerate() {
                            if row(ui, label, (at, done)) {
                                wanted = Some(at);
                            }
                        }
                    },
                );
            });
        self.history_shown = open;
        if let Some(done) = wanted {
            self.go_to_edit(done);
        }
    }
}

/// One edit; whether it was clicked. What was taken back is pale.
fn row(ui: &mut Ui, label: &str, (at, done): (usize, usize)) -> bool {
    let ink = if at > done { ui.visuals().weak_text_color() } else { ui.visuals().text_color() };
    let text = RichText::new(capitalised(label)).color(ink);
    let button = egui::Button::selectable(at == done, text).truncate();
    let size = vec2(ui.available_width(), 20.0);
    let left = egui::Layout::left_to_right(egui::Align::Center).with_main_justify(true);
    let response = ui.allocate_ui_with_layout(size, left.with_main_align(egui::Align::Min), |ui| ui.add(button)).inner;
    let name = format!("history {at}: {label}");
    ui.ctx().accesskit_node_builder(response.id, |node| node.set_label(name));
    response.clicked()
}

fn capitalised(label: &str) -> String {
    let mut letters = label.chars();
    letters.next().map_or_else(String::new, |first| first.to_uppercase().chain(letters).collect())
}
