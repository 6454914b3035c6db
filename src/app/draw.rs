//! Draws the menu, the panels in their layout, and what lies over them.

use std::collections::BTreeMap;

use eframe::egui::{self, Frame, Margin, MenuBar, Panel as Bar, Ui, WidgetText};
use egui_tiles::{SimplificationOptions, TileId, Tiles, UiResponse};

use super::Workbench;
use crate::command::{CommandInfo, Menu, UiCommand};
use crate::panels::{Pane, Panel, PanelContext};

/// Space between panels.
const GAP: f32 = 4.0;

/// One frame.
pub fn draw(app: &mut Workbench, ui: &mut Ui) {
    Bar::top("menu").show(ui, |ui| menu(ui, &app.table, &mut app.commands));
    egui::CentralPanel::default().frame(Frame::new().inner_margin(Margin::same(4)).fill(ui.visuals().panel_fill)).show(
        ui,
        |ui| {
            let context = PanelContext { time: &mut app.state.time, table: &app.table, commands: &mut app.commands };
            app.state.layout.ui(&mut Docking { panels: &mut app.panels, context }, ui);
        },
    );
    if let Some(command) = app.palette.show(ui.ctx(), &app.table) {
        app.commands.push(command);
    }
    if !app.commands.is_empty() {
        ui.ctx().request_repaint();
    }
}

/// The menu bar, from the table of commands.
fn menu(ui: &mut Ui, table: &[CommandInfo], commands: &mut Vec<UiCommand>) {
    MenuBar::new().ui(ui, |ui| {
        for menu in Menu::ALL {
            ui.menu_button(menu.title(), |ui| {
                for row in table.iter().filter(|row| row.menu == menu) {
                    let mut button = egui::Button::new(&row.name);
                    if let Some(keys) = row.shortcut {
                        button = button.shortcut_text(ui.ctx().format_shortcut(&keys));
                    }
                    if ui.add(button).clicked() {
                        commands.push(row.command);
                        ui.close();
                    }
                }
            });
        }
    });
}

/// Draws panels into tiles.
struct Docking<'a> {
    panels: &'a mut BTreeMap<Pane, Box<dyn Panel>>,
    context: PanelContext<'a>,
}

impl egui_tiles::Behavior<Pane> for Docking<'_> {
    fn pane_ui(&mut self, ui: &mut Ui, _tile: TileId, pane: &mut Pane) -> UiResponse {
        let frame = Frame::new().inner_margin(Margin::symmetric(8, 6));
        frame.show(ui, |ui| {
            if let Some(panel) = self.panels.get_mut(pane) {
                panel.show(&mut self.context, ui);
            }
        });
        UiResponse::None
    }

    fn tab_title_for_pane(&mut self, pane: &Pane) -> WidgetText {
        pane.title().into()
    }

    fn is_tab_closable(&self, _tiles: &Tiles<Pane>, _tile: TileId) -> bool {
        true
    }

    fn gap_width(&self, _style: &egui::Style) -> f32 {
        GAP
    }

    fn simplification_options(&self) -> SimplificationOptions {
        SimplificationOptions { all_panes_must_have_tabs: true, ..Default::default() }
    }
}
