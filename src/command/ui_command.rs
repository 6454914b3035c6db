//! The table of commands: name, menu and shortcut of each.

use eframe::egui::{Key, KeyboardShortcut, Modifiers, ThemePreference};

use crate::panels::Pane;

/// Something a user can ask for.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum UiCommand {
    /// What is on screen.
    View(ViewCommand),
    /// Finding one's way.
    Help(HelpCommand),
}

/// Commands that change what is on screen and nothing else.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum ViewCommand {
    /// Show the whole recording.
    ZoomHome,
    /// Show what was shown before.
    ZoomBack,
    /// Take back a step back.
    ZoomForward,
    /// Show the stretch between the markers.
    ZoomToMarkers,
    /// Remove both markers.
    ClearMarkers,
    /// Bring a panel to the front, opening it where it is closed.
    Show(Pane),
    /// Put every panel back where it first was.
    ResetLayout,
    /// Choose the theme.
    Appearance(ThemePreference),
}

/// Commands that explain.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum HelpCommand {
    /// Find any command by its name.
    Palette,
}

/// The menus, in their order.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Menu {
    /// What is on screen.
    View,
    /// Panels to bring to the front.
    Panels,
    /// Help.
    Help,
}

impl Menu {
    /// Every menu, from left to right.
    pub const ALL: [Self; 3] = [Self::View, Self::Panels, Self::Help];

    /// Its title.
    pub fn title(self) -> &'static str {
        match self {
            Self::View => "View",
            Self::Panels => "Panels",
            Self::Help => "Help",
        }
    }
}

/// A row of the table.
#[derive(Clone, Debug)]
pub struct CommandInfo {
    /// What it does.
    pub command: UiCommand,
    /// Its name, in menus and in the palette.
    pub name: String,
    /// Where it is found.
    pub menu: Menu,
    /// Its keys.
    pub shortcut: Option<KeyboardShortcut>,
}

/// Keys with Ctrl (Command on a Mac).
const fn ctrl(key: Key) -> Option<KeyboardShortcut> {
    Some(KeyboardShortcut::new(Modifiers::COMMAND, key))
}

/// Keys with Alt.
const fn alt(key: Key) -> Option<KeyboardShortcut> {
    Some(KeyboardShortcut::new(Modifiers::ALT, key))
}

/// A key alone.
const fn plain(key: Key) -> Option<KeyboardShortcut> {
    Some(KeyboardShortcut::new(Modifiers::NONE, key))
}

/// Every command, in the order menus and palette show them.
pub fn table() -> Vec<CommandInfo> {
    use ViewCommand::{Appearance, ClearMarkers, ResetLayout, Show, ZoomBack, ZoomForward, ZoomHome, ZoomToMarkers};
    let row = |menu, name: &str, command, shortcut| CommandInfo { command, name: name.to_owned(), menu, shortcut };
    let view = |name, command, shortcut| row(Menu::View, name, UiCommand::View(command), shortcut);
    let mut table = vec![
        view("Show whole recording", ZoomHome, plain(Key::Home)),
        view("Zoom back", ZoomBack, alt(Key::ArrowLeft)),
        view("Zoom forward", ZoomForward, alt(Key::ArrowRight)),
        view("Zoom to markers", ZoomToMarkers, plain(Key::M)),
        view("Clear markers", ClearMarkers, plain(Key::Escape)),
        view("Dark theme", Appearance(ThemePreference::Dark), None),
        view("Light theme", Appearance(ThemePreference::Light), None),
        view("Theme of the system", Appearance(ThemePreference::System), None),
        view("Reset layout", ResetLayout, None),
    ];
    table.extend(Pane::ALL.iter().map(|&pane| row(Menu::Panels, pane.title(), UiCommand::View(Show(pane)), None)));
    table.push(row(Menu::Help, "Find a command", UiCommand::Help(HelpCommand::Palette), ctrl(Key::P)));
    table
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_and_shortcuts_of_commands_are_unique() {
        let table = table();
        for (at, one) in table.iter().enumerate() {
            for other in &table[at + 1..] {
                assert_ne!(one.name, other.name);
                assert!(one.shortcut.is_none() || one.shortcut != other.shortcut, "{} and {}", one.name, other.name);
            }
        }
    }

    #[test]
    fn every_panel_can_be_asked_for() {
        for &pane in Pane::ALL {
            let command = UiCommand::View(ViewCommand::Show(pane));
            assert!(table().iter().any(|row| row.command == command && row.name == pane.title()));
        }
    }
}
