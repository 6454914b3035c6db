//! Carries out commands.

use eframe::egui;

use super::ui_command::{HelpCommand, UiCommand, ViewCommand};
use crate::app::Workbench;
use crate::ui_state;
use crate::widgets::time_view::Stretch;

/// Carries out one command.
pub fn dispatch(app: &mut Workbench, command: UiCommand, ctx: &egui::Context) {
    match command {
        UiCommand::View(command) => view(app, command, ctx),
        UiCommand::Help(HelpCommand::Palette) => app.palette.open(),
    }
}

/// Changes what is on screen.
fn view(app: &mut Workbench, command: ViewCommand, ctx: &egui::Context) {
    let time = &mut app.state.time;
    match command {
        ViewCommand::ZoomHome => time.home(),
        ViewCommand::ZoomBack => {
            time.go_back();
        }
        ViewCommand::ZoomForward => {
            time.go_forward();
        }
        ViewCommand::ZoomToMarkers => {
            if let [Some(a), Some(b)] = time.markers_s {
                time.zoom_to(Stretch::new(a, b));
            }
        }
        ViewCommand::ClearMarkers => time.markers_s = [None; 2],
        ViewCommand::Show(pane) => ui_state::bring_to_front(&mut app.state.layout, pane),
        ViewCommand::ResetLayout => app.state.layout = ui_state::default_layout(),
        ViewCommand::Appearance(theme) => {
            app.state.appearance = theme;
            ctx.set_theme(theme);
        }
    }
}
