//! Commands: what a user can ask for, from the menu, a shortcut or the palette, out of one table.

pub mod palette;
pub mod ui_command;

pub use palette::CommandPalette;
pub use ui_command::{
    CommandInfo, EditCommand, FileCommand, FileField, HelpCommand, MarkCommand, Menu, RunCommand, UiCommand,
    ViewCommand,
};
