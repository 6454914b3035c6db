//! The palette: every command by typing part of its name.

use eframe::egui::{self, Align2, Id, Key, Modifiers, TextEdit, vec2};

use super::ui_command::{CommandInfo, UiCommand};

/// Rows shown at most.
const ROWS: usize = 12;

/// The palette's state; closed to begin with.
#[derive(Debug, Default)]
pub struct CommandPalette {
    open: bool,
    just_opened: bool,
    typed: String,
    chosen: usize,
}

/// Rows of `table` whose name holds every word of `typed`, those that begin with it first.
pub fn matching<'a>(table: &'a [CommandInfo], typed: &str) -> Vec<&'a CommandInfo> {
    let typed = typed.trim().to_lowercase();
    let holds = |row: &&CommandInfo| {
        let name = row.name.to_lowercase();
        typed.split_whitespace().all(|word| name.contains(word) || means(&row.name, word))
    };
    let mut found: Vec<_> = table.iter().filter(holds).collect();
    // Names with words that begin so come before those that only mean it, and both before `board` in `keyboard`.
    found.sort_by_key(|row| {
        let name = row.name.to_lowercase();
        let begins = |word: &str| name.split_whitespace().any(|own| own.starts_with(word));
        let is_named = typed.split_whitespace().all(begins);
        let is_meant = typed.split_whitespace().all(|word| begins(word) || means(&row.name, word));
        (!name.starts_with(&typed), !is_named, !is_meant)
    });
    found
}

/// Other words for what a command is about, behind its name.
const MEANINGS: &str = include_str!("meanings.txt");

/// Whether a command called `name` is about `word`.
fn means(name: &str, word: &str) -> bool {
    let mut words = MEANINGS.lines().filter_map(|line| line.strip_prefix(name)?.strip_prefix(": "));
    word.len() > 1 && words.any(|words| words.split(' ').any(|one| one.starts_with(word)))
}

impl CommandPalette {
    /// Opens it, empty.
    pub fn open(&mut self) {
        *self = Self { open: true, just_opened: true, ..Self::default() };
    }

    /// Whether it is open.
    pub fn is_open(&self) -> bool {
        self.open
    }

    /// Draws it while it is open; the command that was chosen.
    pub fn show(&mut self, ctx: &egui::Context, table: &[CommandInfo]) -> Option<UiCommand> {
        if !self.open {
            return None;
        }
        let (up, down, enter, escape) = ctx.input_mut(|input| {
            let mut key = |key| input.consume_key(Modifiers::NONE, key);
            (key(Key::ArrowUp), key(Key::ArrowDown), key(Key::Enter), key(Key::Escape))
        });
        let mut picked = None;
        let area = egui::Window::new("Commands")
            .id(Id::unique("command palette"))
            .title_bar(false)
            .resizable(false)
            .anchor(Align2::CENTER_TOP, vec2(0.0, 80.0))
            .fixed_size(vec2(460.0, 0.0))
            .show(ctx, |ui| {
                let hint = "Type part of a command";
                let entry = TextEdit::singleline(&mut self.typed).hint_text(hint).desired_width(f32::INFINITY);
                let entry = ui.add(entry);
                ui.ctx().accesskit_node_builder(entry.id, |node| node.set_label("Command"));
                entry.request_focus();
                if entry.changed() {
                    self.chosen = 0;
                }
                let found = matching(table, &self.typed);
                let last = found.len().min(ROWS).saturating_sub(1);
                self.chosen = (self.chosen + usize::from(down)).saturating_sub(usize::from(up)).min(last);
                if found.is_empty() {
                    ui.weak("No command found.");
                }
                for (at, row) in found.into_iter().take(ROWS).enumerate() {
                    let shortcut = row.keys(ui.ctx());
                    let button = egui::Button::selectable(at == self.chosen, &row.name).shortcut_text(shortcut);
                    let response = ui.add_sized([ui.available_width(), 24.0], button);
                    if response.clicked() || (enter && at == self.chosen) {
                        picked = Some(row.command);
                    }
                }
            });
        let elsewhere = !self.just_opened && area.is_some_and(|area| area.response.clicked_elsewhere());
        self.just_opened = false;
        if picked.is_some() || escape || elsewhere {
            self.open = false;
        }
        picked
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::command::ui_command::table;

    #[test]
    fn words_match_in_any_order_and_a_beginning_comes_first() {
        let table = table();
        assert_eq!(matching(&table, "").len(), table.len());
        assert_eq!(matching(&table, "back zoom")[0].name, "Zoom back");
        assert!(matching(&table, "no such thing").is_empty());
        for (typed, first) in [
            ("inertia", "Loading"),
            ("engine", "Propulsion"),
            ("fuel", "Loading"),
            ("compare", "Experiments"),
            ("kalman", "Noise and filter"),
            ("weighing", "Airframe"),
            ("model", "Model"),
            ("AIC", "Model"),
            ("board", "Experiments"),
        ] {
            assert_eq!(matching(&table, typed)[0].name, first, "{typed}");
        }
        assert!(
            MEANINGS.lines().all(|line| table.iter().any(|row| line.starts_with(&format!("{}: ", row.name)))),
            "each is a command"
        );
        assert!(matching(&table, "zoom")[0].name.starts_with("Zoom"));
    }
}
