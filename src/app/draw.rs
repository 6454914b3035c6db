//! Draws the menu, the panels in their layout, the status line, and what lies over them.

use std::collections::BTreeMap;
use std::sync::Arc;

use doublet_engine::run::{DetailRequest, InquiryRequest};
use doublet_engine::verdict::Level;
use eframe::egui::{
    self, Align, Button, Frame, Id, Layout, Margin, MenuBar, Panel as Bar, ProgressBar, Response, RichText, Role,
    Sense, Spinner, Ui, WidgetInfo, WidgetText, vec2,
};
use egui_tiles::{Container, EditAction, SimplificationOptions, Tabs, Tile, TileId, Tiles, UiResponse};

use super::{Workbench, start, step_bar, timeline};
use crate::command::{CommandInfo, EditCommand, FileCommand, Menu, RunCommand, UiCommand, ViewCommand};
use crate::layouts::{LEAST_WIDTH, LayoutKey};
use crate::panels::{GuardedPanel, Pane, PanelContext, count_experiments, headline, judge_shown, overlaid_names};
use crate::step::Step;
use crate::widgets::level_mark;
use crate::{notation, theme};

/// How long a message stays that asks for nothing, s.
const MESSAGE_S: f64 = 12.0;
/// Space between panels.
const GAP: f32 = 4.0;
/// Room kept for the title of the session beside menus and steps.
const LEAST_TITLE: f32 = 40.0;
/// Frames in which a tab that was opened is scrolled into view.
const FRAMES_TO_REVEAL: u8 = 4;
/// Room on either side of the title of a tab, in a window narrower than its layouts are made for and in others.
const NARROW_TAB_SPACING: f32 = 4.0;
const TAB_SPACING: f32 = 8.0;
/// Width of a column of the names of panels.
const PANEL_NAMES: f32 = 150.0;

/// One frame.
pub fn draw(app: &mut Workbench, ui: &mut Ui) {
    let width = ui.available_width();
    // The page of a new session is not about the open one.
    let is_of_session = !app.is_on_beginning_page();
    Bar::top("menu").show(ui, |ui| {
        // The steps stand beside the menus where there is room for both.
        if !menu(app, ui, is_of_session) {
            step_bar::show(app, ui);
        }
    });
    Bar::bottom("status").show(ui, |ui| status(app, ui, is_of_session));
    let ground = Frame::new().inner_margin(Margin::same(4)).fill(ui.visuals().panel_fill);
    if app.is_on_beginning_page() {
        let ground = ground.inner_margin(Margin::symmetric(12, 6));
        egui::CentralPanel::default().frame(ground).show(ui, |ui| app.show_beginning_page(ui));
    } else if app.is_on_start_page() {
        egui::CentralPanel::default().frame(ground).show(ui, |ui| start::show(app, ui));
    } else {
        let strip = Frame::new().fill(ui.visuals().panel_fill);
        Bar::top("timeline").resizable(false).frame(strip).exact_size(timeline::height(ui.ctx())).show(ui, |ui| {
            timeline::show(app, ui);
        });
        app.show_second(ui);
        app.state.shown.fit(ui.available_width().min(width));
        egui::CentralPanel::default().frame(ground).show(ui, |ui| panels(app, ui));
    }
    if let Some(command) = app.palette.show(ui.ctx(), &app.table) {
        app.commands.push(command);
    }
    app.show_beginning(ui.ctx());
    if let Some(paths) = app.files.show(ui.ctx()) {
        app.take_files(&paths, ui.ctx());
    }
    app.show_tour(ui.ctx());
    app.show_help(ui.ctx());
    app.show_analyses(ui.ctx());
    app.show_history(ui.ctx());
    app.ask_layout_name(ui.ctx());
    app.ask_annotation(ui.ctx());
    app.ask_note(ui.ctx());
    app.guard(ui.ctx());
    app.take_figures(ui.ctx());
    app.offer_work(ui.ctx());
    app.draw_change(ui.ctx());
    app.typing = ui.ctx().egui_wants_keyboard_input();
    let moved = app.hovered_s != app.state.time.cursor_s;
    if moved || !app.commands.is_empty() || !app.edits.is_empty() {
        ui.ctx().request_repaint();
    }
}

/// The panels of the layout on screen.
fn panels(app: &mut Workbench, ui: &mut Ui) {
    // Drawn as a copy: a panic leaves the layout whole.
    let mut layout = app.state.shown.tree.clone();
    let overlaid = overlaid_names(&app.state, app.document.session());
    let experiments = app.has_open_experiments();
    let inquiry = InquiryRequest { overlaid, experiments, ..InquiryRequest::default() };
    let window = app.state.selection.window.clone();
    let mut wanted = DetailRequest { window, inquiry, ..DetailRequest::default() };
    let context = PanelContext {
        session: app.document.history.present(),
        folder: &app.document.folder,
        snapshot: &app.snapshot,
        state: &mut app.state,
        hovered_s: &mut app.hovered_s,
        table: &app.table,
        commands: &mut app.commands,
        edits: &mut app.edits,
        references: &app.references,
        wanted: &mut wanted,
        figures: &mut app.figures,
    };
    let is_narrow = ui.available_width() < LEAST_WIDTH;
    let open = open_tabs(&layout.tiles);
    let mut docking =
        Docking { panels: &mut app.panels, context, open, touched: false, pointed: None, has_failed: false, is_narrow };
    layout.ui(&mut docking, ui);
    let Docking { touched, pointed, has_failed, .. } = docking;
    app.pointed = pointed;
    app.state.shown.tree = layout;
    app.state.shown.touched |= touched;
    app.compares = wanted.inquiry.experiments || app.compares && app.document.history.is_open();
    app.engine.request_details(&wanted);
    if has_failed {
        app.keep_work_after_failed_panel();
    }
}

/// The menu bar, from the table of commands, with the steps behind it; whether there was room for those, or none are due.
fn menu(app: &mut Workbench, ui: &mut Ui, is_of_session: bool) -> bool {
    let mut has_steps = !is_of_session;
    let history = &app.document.history;
    let named = |word: &str, label: Option<&str>| label.map(|label| format!("{word} {label}"));
    let undo = named("Undo", history.undo_label());
    let redo = named("Redo", history.redo_label());
    MenuBar::new().ui(ui, |ui| {
        for menu in Menu::ALL {
            ui.menu_button(menu.title(), |ui| {
                if menu == Menu::Panels {
                    return panel_menu(&app.state, &app.table, &mut app.commands, ui);
                }
                for row in app.table.iter().filter(|row| row.menu == menu) {
                    let name = match row.command {
                        UiCommand::Edit(EditCommand::Undo) => undo.as_deref(),
                        UiCommand::Edit(EditCommand::Redo) => redo.as_deref(),
                        _ => None,
                    };
                    let enabled = is_enabled(app, row.command);
                    if row.begins_group() {
                        ui.separator();
                    }
                    let is_on = is_on(&app.state, row.command);
                    let name = name.unwrap_or(&row.name);
                    let mut button = Button::selectable(is_on, name);
                    if row.shortcut.is_some() {
                        button = button.shortcut_text(row.keys(ui.ctx()));
                    }
                    if ui.add_enabled(enabled, button).clicked() {
                        app.commands.push(row.command);
                        ui.close();
                    }
                    if row.command == UiCommand::File(FileCommand::Open) && !app.state.recent.is_empty() {
                        recent(&app.state.recent, &mut app.commands, ui);
                    }
                    if row.command == UiCommand::View(ViewCommand::Overview) {
                        named_layouts(&app.state.layout_names(), &mut app.commands, ui);
                    }
                }
            });
        }
        if !is_of_session {
            return;
        }
        has_steps = ui.available_width() > step_bar::width(ui) + LEAST_TITLE;
        if has_steps {
            ui.add_space(GAP);
            step_bar::show(app, ui);
        }
        ui.with_layout(Layout::right_to_left(Align::Center), |ui| {
            let session = app.document.session();
            let mark = if app.document.history.is_modified() { "• " } else { "" };
            let title = RichText::new(format!("{mark}{}", session.title)).weak();
            ui.add(egui::Label::new(title).truncate());
        });
    });
    has_steps
}

/// Whether a command has something to act on.
fn is_enabled(app: &Workbench, command: UiCommand) -> bool {
    match command {
        UiCommand::Edit(EditCommand::Undo) => app.document.history.undo_label().is_some(),
        UiCommand::Edit(EditCommand::Redo) => app.document.history.redo_label().is_some(),
        UiCommand::Edit(EditCommand::AddWindow) => {
            matches!(app.state.time.markers_s, [Some(a), Some(b)] if a != b)
        }
        UiCommand::File(FileCommand::ContinueNew) => app.draft_name().is_some(),
        UiCommand::File(FileCommand::CloseBeside) => app.second.is_some(),
        UiCommand::File(FileCommand::ClearReferences) => !app.references.is_empty(),
        UiCommand::File(FileCommand::FindRecording) => app.missing_recording().is_some(),
        _ => true,
    }
}

/// Whether what a command chooses is chosen: the theme, the units, the layout on screen, panels it has.
fn is_on(state: &crate::ui_state::UiState, command: UiCommand) -> bool {
    match command {
        UiCommand::View(ViewCommand::Appearance(appearance)) => state.appearance == appearance,
        UiCommand::View(ViewCommand::Units(units)) => state.units == units,
        UiCommand::View(ViewCommand::Step(step)) => state.shown.key == LayoutKey::Step(step),
        UiCommand::View(ViewCommand::Overview) => state.shown.key == LayoutKey::Overview,
        UiCommand::View(ViewCommand::Show(pane)) => state.shown.holds(pane),
        _ => false,
    }
}

/// The panels by the steps in whose layouts they are, in two columns: one would be higher than a small screen.
fn panel_menu(state: &crate::ui_state::UiState, table: &[CommandInfo], commands: &mut Vec<UiCommand>, ui: &mut Ui) {
    let of_step = |step: Option<Step>| {
        let is_of = |row: &&CommandInfo| matches!(row.command, UiCommand::View(ViewCommand::Show(pane)) if Step::of_pane(pane) == step);
        let rows: Vec<_> = table.iter().filter(|row| row.menu == Menu::Panels).filter(is_of).collect();
        (step.map_or("Others", Step::title), rows)
    };
    let groups: Vec<(&str, Vec<&CommandInfo>)> = Step::ALL.into_iter().map(Some).chain([None]).map(of_step).collect();
    let rows = |groups: &[(&str, Vec<&CommandInfo>)]| groups.iter().map(|(_, rows)| 1 + rows.len()).sum::<usize>();
    let left = (0..groups.len()).find(|&left| 2 * rows(&groups[..left]) >= rows(&groups)).unwrap_or(groups.len());
    let (left, right) = groups.split_at(left);
    ui.horizontal_top(|ui| {
        for groups in [left, right] {
            ui.allocate_ui_with_layout(vec2(PANEL_NAMES, 0.0), Layout::top_down_justified(Align::LEFT), |ui| {
                for (title, rows) in groups {
                    ui.add(egui::Label::new(RichText::new(*title).size(11.0).weak()));
                    for row in rows {
                        if ui.add(Button::selectable(is_on(state, row.command), row.name.as_str())).clicked() {
                            commands.push(row.command);
                            ui.close();
                        }
                    }
                }
            });
        }
    });
}

/// Layouts kept under a name, each with the way to forget it.
fn named_layouts(names: &[&str], commands: &mut Vec<UiCommand>, ui: &mut Ui) {
    for (at, name) in names.iter().enumerate() {
        ui.horizontal(|ui| {
            if ui.button(*name).clicked() {
                commands.push(UiCommand::View(ViewCommand::NamedLayout(at)));
                ui.close();
            }
            if ui.small_button("✖").on_hover_text(format!("Forget the layout {name}")).clicked() {
                commands.push(UiCommand::View(ViewCommand::ForgetLayout(at)));
                ui.close();
            }
        });
    }
}

/// Sessions opened last.
fn recent(paths: &[std::path::PathBuf], commands: &mut Vec<UiCommand>, ui: &mut Ui) {
    ui.menu_button("Open recent", |ui| {
        for (at, path) in paths.iter().enumerate() {
            let name = path.file_name().unwrap_or_default().to_string_lossy();
            if ui.button(name.into_owned()).on_hover_text(path.display().to_string()).clicked() {
                commands.push(UiCommand::File(FileCommand::OpenRecent(at)));
                ui.close();
            }
        }
    });
}

/// What is running and why, or how the last run ended; what was said last.
fn status(app: &mut Workbench, ui: &mut Ui, is_of_session: bool) {
    let palette = theme::palette(ui);
    if let Some(error) = app.document.autosave_error() {
        let text = format!("Autosave failed ({error}): save often");
        ui.add(egui::Label::new(RichText::new(text).color(palette.error)).wrap());
    }
    let errors = app.message.as_ref().is_some_and(|message| message.is_error);
    if errors {
        ui.horizontal(|ui| message(app, ui));
    }
    ui.horizontal(|ui| {
        ui.set_min_height(24.0);
        ui.with_layout(Layout::right_to_left(Align::Center), |ui| {
            if errors || app.message.is_none() {
                ui.weak("Ctrl+P: find a command");
            } else {
                let room = vec2(0.5 * ui.available_width(), ui.available_height());
                ui.allocate_ui_with_layout(room, Layout::right_to_left(Align::Center), |ui| message(app, ui));
            }
            if is_of_session {
                ui.with_layout(Layout::left_to_right(Align::Center), |ui| running(app, ui));
            }
        });
    });
}

/// What was said last, with the ways to close it and to open what was written. What went wrong has lines of its own and stays until it is
/// closed; anything else stands in the status line, so that nothing on screen moves for it.
fn message(app: &mut Workbench, ui: &mut Ui) {
    let Some(message) = &app.message else { return };
    let palette = theme::palette(ui);
    let age_s = ui.input(|input| input.time) - *app.said_at_s.get_or_insert(ui.input(|input| input.time));
    let mut closed = false;
    if !message.is_error && message.written.is_none() {
        closed = age_s > MESSAGE_S;
        ui.ctx().request_repaint_after(std::time::Duration::from_secs_f64((MESSAGE_S - age_s).max(0.0) + 0.05));
    }
    closed |= ui.small_button("✖").on_hover_text("Close").clicked();
    if let Some(written) = &message.written
        && ui.small_button("Open").on_hover_text(written.display().to_string()).clicked()
    {
        app.opening = Some((written.clone(), open::that_in_background(written)));
    }
    let color = if message.is_error { palette.error } else { palette.good };
    let label = egui::Label::new(RichText::new(&message.text).color(color));
    if message.is_error {
        ui.add(label.wrap());
    } else {
        ui.add(label.truncate());
    }
    if closed {
        app.message = None;
    }
}

/// The lamp with what it means; what is being written and computed, or how long the last run took.
fn running(app: &mut Workbench, ui: &mut Ui) {
    if app.document.session().flights.is_empty() {
        ui.weak("No session is open");
        return;
    }
    let snapshot = Arc::clone(&app.snapshot);
    let busy = app.is_busy();
    lamp(app, ui, busy);
    if let Some(export) = &app.exporting {
        ui.add(ProgressBar::new(export.progress()).desired_width(160.0).desired_height(10.0));
        ui.label("Writing");
        if ui.small_button("Stop writing").clicked() {
            export.cancel();
        }
        // The thread ends a moment after its last step wakes this one.
        ui.ctx().request_repaint_after(std::time::Duration::from_millis(50));
    }
    if busy {
        // Until the new run begins the snapshot is that of the run before.
        let is_former = snapshot.generation < app.awaited;
        let (progress, cause) = if is_former { (0.0, &app.cause) } else { (snapshot.progress, &snapshot.cause) };
        ui.add(ProgressBar::new(progress).desired_width(160.0).desired_height(10.0));
        ui.label(format!("Computing: {cause}"));
        if let Some(memory) = snapshot.memory.as_ref().filter(|_| !is_former) {
            let text = RichText::new(memory.text.to_string()).color(level_mark::color(ui, Some(memory.level)));
            ui.label(text).on_hover_text(&memory.fix_text);
        }
        if ui.small_button("Cancel").clicked() {
            app.commands.push(UiCommand::Run(RunCommand::Cancel));
        }
        return;
    }
    if let Some((done, all)) = count_experiments(&snapshot.inquiries.experiments) {
        ui.weak(format!("Experiments: {done} of {all} computed"));
    }
    let Some(last) = snapshot.log.iter().rev().find(|line| !line.duration.is_zero()) else { return };
    let text = RichText::new(format!("{} in {}", last.cause, notation::duration(last.duration))).weak();
    ui.add(egui::Label::new(text).truncate()).on_hover_text(&last.text);
    if let Some((place, error)) = snapshot.failures().first() {
        let text = RichText::new(format!("{place}: {error}")).color(theme::palette(ui).error);
        ui.add(egui::Label::new(text).truncate());
    }
}

/// The verdict's shape and colour with its sentence; a ring turns about it while something is computed. A click shows the reasons.
fn lamp(app: &mut Workbench, ui: &mut Ui, busy: bool) {
    let verdicts = app.snapshot.verdicts.latest();
    let level = verdicts.and_then(|verdicts| judge_shown(app.document.session(), verdicts));
    let (rect, lamp) = ui.allocate_exact_size(vec2(22.0, 22.0), Sense::click());
    let color = level_mark::color(ui, level);
    let color = if app.snapshot.verdicts.is_stale() { color.gamma_multiply(0.55) } else { color };
    level_mark::paint(ui.painter(), rect.center(), 5.0, level, color);
    if busy {
        Spinner::new().color(ui.visuals().text_color()).paint_at(ui, rect.shrink(1.0));
    }
    let name = format!("verdict: {}{}", level.map_or("none yet", Level::name), if busy { ", computing" } else { "" });
    lamp.widget_info(|| WidgetInfo::labeled(Role::Button, true, &name));
    let mut clicked = lamp.on_hover_text("Which results can be trusted, and why").clicked();
    if let Some(verdicts) = verdicts {
        let (visuals, is_stale) = (ui.visuals(), app.snapshot.verdicts.is_stale());
        let ink = if is_stale { visuals.weak_text_color() } else { visuals.text_color() };
        let text = notation::typeset_in(&headline(app.document.session(), verdicts), 13.0, ink);
        clicked |= ui.add(egui::Label::new(text).sense(Sense::click())).clicked();
    }
    if clicked {
        app.commands.push(UiCommand::View(ViewCommand::Show(Pane::Summary)));
    }
}

/// Titles of the panels in a tile, from the first to the last.
fn titles(tiles: &Tiles<Pane>, tile: TileId) -> Vec<&'static str> {
    match tiles.get(tile) {
        Some(Tile::Pane(pane)) => vec![pane.short_title()],
        Some(Tile::Container(container)) => container.children().flat_map(|&child| titles(tiles, child)).collect(),
        None => Vec::new(),
    }
}

/// The open tab of each row of tabs, and the row. Found before the tiles are drawn: a row is not among them meanwhile.
fn open_tabs(tiles: &Tiles<Pane>) -> Vec<(TileId, TileId)> {
    let open = |(row, tile): (&TileId, &Tile<Pane>)| match tile {
        Tile::Container(Container::Tabs(tabs)) => Some((tabs.active?, *row)),
        _ => None,
    };
    tiles.iter().filter_map(open).collect()
}

/// The open tab of several, from frame to frame.
#[derive(Clone)]
struct OpenTab {
    tile: TileId,
    /// Layout it is in: tiles of two layouts have the same numbers.
    layout: LayoutKey,
    /// Width of the row of tabs.
    row: f32,
    /// Width of it beyond the right edge of the tabs, negative beyond the left one.
    hidden: f32,
    /// Frames in which it is still scrolled into view.
    frames: u8,
}

impl OpenTab {
    fn kept(ctx: &egui::Context, tabs: TileId) -> Option<Self> {
        ctx.data(|data| data.get_temp(Id::unique(("open tab", tabs))))
    }

    fn keep(self, ctx: &egui::Context, tabs: TileId) {
        ctx.data_mut(|data| data.insert_temp(Id::unique(("open tab", tabs)), self));
    }
}

/// Draws panels into tiles.
struct Docking<'a> {
    panels: &'a mut BTreeMap<Pane, GuardedPanel>,
    context: PanelContext<'a>,
    /// Open tabs with their rows.
    open: Vec<(TileId, TileId)>,
    /// Whether a panel or an edge was moved.
    touched: bool,
    /// Panel under the pointer.
    pointed: Option<Pane>,
    /// Whether a panel has panicked.
    has_failed: bool,
    /// Whether tabs are close together, so that those of eight panels fit half of a small window.
    is_narrow: bool,
}

impl egui_tiles::Behavior<Pane> for Docking<'_> {
    fn pane_ui(&mut self, ui: &mut Ui, _tile: TileId, pane: &mut Pane) -> UiResponse {
        if ui.rect_contains_pointer(ui.max_rect()) {
            self.pointed = Some(*pane);
        }
        let frame = Frame::new().inner_margin(Margin::symmetric(8, 6));
        frame.show(ui, |ui| {
            if let Some(panel) = self.panels.get_mut(pane) {
                self.has_failed |= panel.show(&mut self.context, ui);
            }
        });
        UiResponse::None
    }

    fn tab_title_for_pane(&mut self, pane: &Pane) -> WidgetText {
        pane.short_title().into()
    }

    fn tab_title_for_tile(&mut self, tiles: &Tiles<Pane>, tile: TileId) -> WidgetText {
        match titles(tiles, tile).as_slice() {
            [] => "empty".into(),
            [one] => (*one).into(),
            [first, second] => format!("{first} · {second}").into(),
            [first, second, more @ ..] => format!("{first} · {second} + {}", more.len()).into(),
        }
    }

    fn tab_title_spacing(&self, _: &egui::Visuals) -> f32 {
        if self.is_narrow { NARROW_TAB_SPACING } else { TAB_SPACING }
    }

    // A cross on every tab would take the room of a tab more.
    fn is_tab_closable(&self, _: &Tiles<Pane>, tile: TileId) -> bool {
        self.open.iter().any(|(open, _)| *open == tile)
    }

    fn on_tab_close(&mut self, _: &mut Tiles<Pane>, _: TileId) -> bool {
        self.touched = true;
        true
    }

    fn on_tab_button(&mut self, _: &mut Tiles<Pane>, tile: TileId, button: Response) -> Response {
        if let Some(&(_, parent)) = self.open.iter().find(|(open, _)| *open == tile) {
            let (all, seen) = (button.rect, button.interact_rect);
            let hidden = (all.right() - seen.right()) - (seen.left() - all.left());
            let layout = &self.context.state.shown.key;
            let known =
                OpenTab::kept(&button.ctx, parent).filter(|known| known.tile == tile && known.layout == *layout);
            let (row, frames) = known.map_or((0.0, FRAMES_TO_REVEAL), |known| (known.row, known.frames));
            OpenTab { tile, layout: layout.clone(), row, hidden, frames }.keep(&button.ctx, parent);
        }
        button
    }

    /// Scrolls the tabs until one that was just opened is seen whole, and again where their row becomes wider or narrower.
    fn top_bar_right_ui(&mut self, _: &Tiles<Pane>, ui: &mut Ui, tile: TileId, _: &Tabs, offset: &mut f32) {
        // An offset beyond the end would spring back, and the tabs slide on where an arrow has appeared meanwhile.
        ui.spacing_mut().scroll.kinetic.rubber_band = false;
        let row = ui.available_width();
        let Some(open) = OpenTab::kept(ui.ctx(), tile) else { return };
        let frames = if open.row == row { open.frames } else { FRAMES_TO_REVEAL };
        if frames > 0 {
            *offset += open.hidden;
            OpenTab { frames: frames - 1, row, ..open }.keep(ui.ctx(), tile);
            ui.ctx().request_repaint();
        }
    }

    fn on_edit(&mut self, action: EditAction) {
        self.touched |= matches!(action, EditAction::TileDropped | EditAction::TileResized);
    }

    fn gap_width(&self, _style: &egui::Style) -> f32 {
        GAP
    }

    fn simplification_options(&self) -> SimplificationOptions {
        SimplificationOptions { all_panes_must_have_tabs: true, ..Default::default() }
    }
}
