//! Before drawing: keys become commands, commands are carried out.

use eframe::egui::{self, Modifiers};

use super::Workbench;
use crate::command::{UiCommand, dispatch};

/// One step.
pub fn run(app: &mut Workbench, ctx: &egui::Context) {
    app.state.time.cursor_s = None;
    take_shortcuts(app, ctx);
    for command in std::mem::take(&mut app.commands) {
        dispatch::dispatch(app, command, ctx);
    }
}

/// Turns pressed keys into commands. While a field has the keyboard, or the palette is open, keys without Ctrl or Alt
/// belong to it.
fn take_shortcuts(app: &mut Workbench, ctx: &egui::Context) {
    let busy = ctx.egui_wants_keyboard_input() || app.palette.is_open() || ctx.dragged_id().is_some();
    let mut pressed: Vec<UiCommand> = Vec::new();
    ctx.input_mut(|input| {
        for row in &app.table {
            let keys = row.shortcut.filter(|keys| !busy || keys.modifiers != Modifiers::NONE);
            if keys.is_some_and(|keys| input.consume_shortcut(&keys)) {
                pressed.push(row.command);
            }
        }
    });
    app.commands.extend(pressed);
}
