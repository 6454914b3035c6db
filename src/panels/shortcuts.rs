//! Every command with its keys, on one page.

use eframe::egui;

use crate::command::Menu;
use crate::panels::{Panel, PanelContext};

/// What the pointer does in a time plot.
const POINTER: [(&str, &str); 21] = [
    ("Right click", "Menu: save or copy a plot, markers, zoom"),
    ("Wheel beside the plots", "Scroll a long stack"),
    ("Wheel", "Zoom time about the pointer"),
    ("Shift+Wheel", "Zoom values about the pointer"),
    ("Drag, middle drag", "Pan"),
    ("Right drag", "Zoom to a box; a flat box zooms time only"),
    ("Drag on an axis", "Zoom that axis; a double click fits it"),
    ("Ctrl+Drag", "New manoeuvre over the dragged time range"),
    ("Alt+Drag inside a manoeuvre", "Exclude the time range"),
    ("Alt+Shift+Drag inside a manoeuvre", "Include it again"),
    ("A, B, then E", "Exclude between the markers, where the desktop takes Alt+Drag"),
    ("Double click", "Show whole recording, fit values"),
    ("A, B; Shift+Click, Ctrl+Click", "Set marker A, marker B"),
    ("Click on a name of a legend", "Hide or show the curve; a double click hides the others"),
    ("Ctrl+C, Ctrl+Shift+C", "Copy the plot under the pointer: picture, data"),
    ("Ctrl+Click, Shift+Click on a manoeuvre", "Add to the selection, or extend to it"),
    ("Drag in the strip of the flight", "Select the time shown; drag its ends or middle"),
    ("← →, Shift+← →", "Step marker A, marker B by a sample"),
    ("Alt in a drag of a manoeuvre", "Snap only to samples, not to onsets, ends, markers, manoeuvres or gaps"),
    ("Escape in a drag", "Cancel the drag"),
    ("Ctrl++, Ctrl+-", "Larger and smaller text and controls, everywhere"),
];

/// Least width of a column, points.
const COLUMN: f32 = 550.0;

pub struct Shortcuts;

impl Panel for Shortcuts {
    fn show(&mut self, ctx: &mut PanelContext<'_>, ui: &mut egui::Ui) {
        egui::ScrollArea::vertical().auto_shrink(false).show(ui, |ui| {
            let count = match ui.available_width() / COLUMN {
                fit if fit >= 4.0 => 4,
                fit if fit >= 2.0 => 2,
                _ => 1,
            };
            ui.columns(count, |columns| {
                for menu in Menu::ALL {
                    commands(ctx, &mut columns[column_of(menu) * count / 4], menu);
                }
                gestures(&mut columns[column_of(Menu::Mark) * count / 4]);
            });
        });
    }
}

/// The column of a menu among four.
fn column_of(menu: Menu) -> usize {
    match menu {
        Menu::File | Menu::Edit => 0,
        Menu::Mark | Menu::Run => 1,
        Menu::View | Menu::Layout | Menu::Help => 2,
        Menu::Panels => 3,
    }
}

/// The commands of one menu with their keys.
fn commands(ctx: &mut PanelContext<'_>, ui: &mut egui::Ui, menu: Menu) {
    ui.add_space(4.0);
    ui.heading(menu.title());
    egui::Grid::new(menu.title()).num_columns(2).min_col_width(250.0).show(ui, |ui| {
        for row in ctx.table.iter().filter(|row| row.menu == menu) {
            if ui.link(&row.name).clicked() {
                ctx.commands.push(row.command);
            }
            ui.monospace(row.keys(ui.ctx()));
            ui.end_row();
        }
    });
}

/// What the pointer does in a time plot.
fn gestures(ui: &mut egui::Ui) {
    ui.add_space(4.0);
    ui.heading("Time plots");
    egui::Grid::new("pointer").num_columns(2).min_col_width(250.0).show(ui, |ui| {
        for (gesture, effect) in POINTER {
            ui.label(effect);
            ui.monospace(gesture);
            ui.end_row();
        }
    });
}
