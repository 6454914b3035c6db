//! The manoeuvres as a table: name, interval, use, surface, note, lock, state of their results.

use std::sync::Arc;

use doublet_core::series::TimeRange;
use doublet_engine::session::{Edit, Manoeuvre, Surface, WindowEdit, WindowFlag, WindowRole};
use doublet_engine::stage::{Steadiness, measure_steadiness};
use eframe::egui::text::{CCursor, CCursorRange};
use eframe::egui::{self, ComboBox, FontId, Galley, Id, Label, Response, RichText, TextEdit, Ui};
use egui_extras::{Column, TableBuilder, TableRow};

use crate::command::{EditCommand, MarkCommand, UiCommand};
use crate::panels::manoeuvres::proposals::proposals;
use crate::panels::manoeuvres::window_filter::{Order, WindowFilter};
use crate::panels::marking::{self, Spot};
use crate::panels::{EditRequest, Panel, PanelContext, role_color, select_among};
use crate::widgets::grid::texts_grid;
use crate::widgets::quantity_edit::QuantityEdit;
use crate::widgets::term::column_title;
use crate::{notation, theme};

/// Height of a row.
const ROW: f32 = 26.0;
/// Size of the line that says why a window has no results.
const REASON: f32 = 11.5;
/// Change of a time per point it is dragged, s.
const DRAG_S: f64 = 0.05;
/// Room of the column with a window's mark, which that line starts behind.
const MARK: f32 = 18.0;
/// Width from which buttons and filter stand in one row.
const ONE_ROW: f32 = 820.0;
/// Height of a panel below which every row of the table counts.
const LITTLE: f32 = 320.0;
/// Width of the fields of times, and of the other columns; names are whole in theirs as long as those of the proposals are.
const TIME: f32 = 72.0;
const NAME: f32 = 118.0;
const FLIGHT: f32 = 76.0;
const FLAGS: f32 = 44.0;
const USE: f32 = 118.0;
const SURFACE: f32 = 88.0;
const NOTE: f32 = 34.0;
/// Room at the right end of that line for the scroll bar.
const RIGHT_ROOM: f32 = 16.0;

/// A text being typed.
struct Typing {
    field: String,
    /// What it shall hold.
    text: String,
    /// Whether the keyboard was asked for.
    focused: bool,
}

/// A text of a window as its cell shows it.
struct Shown<'a> {
    field: String,
    /// What it holds.
    present: &'a str,
    /// What stands there where it holds nothing.
    nothing: &'a str,
    /// What hovering says about it.
    hint: &'a str,
    /// Windows of the table in their order.
    order: &'a [&'a str],
}

#[derive(Default)]
pub struct Manoeuvres {
    typing: Option<Typing>,
    /// Row that was last brought into view.
    in_view: Option<usize>,
    filter: WindowFilter,
}

impl Panel for Manoeuvres {
    fn show(&mut self, ctx: &mut PanelContext<'_>, ui: &mut Ui) {
        let in_one_row = ui.available_width() >= ONE_ROW;
        ui.horizontal(|ui| {
            for (name, command, hint) in [
                ("◀", EditCommand::PreviousWindow, "Previous manoeuvre (Page up)"),
                ("▶", EditCommand::NextWindow, "Next manoeuvre (Page down)"),
                (
                    "Add",
                    EditCommand::AddWindow,
                    "New manoeuvre between markers A and B (Insert). Or drag with Ctrl in a plot.",
                ),
                ("Remove", EditCommand::RemoveWindow, "Remove the selected manoeuvres (Delete)"),
            ] {
                if ui.button(name).on_hover_text(hint).clicked() {
                    ctx.commands.push(UiCommand::Edit(command));
                }
            }
            let used = ctx.session.windows.iter().filter(|window| window.role == WindowRole::Identification).count();
            ui.weak(format!("{} in all, {used} for identification", ctx.session.windows.len()));
            if in_one_row {
                ui.separator();
                self.filter.show(ctx, ui);
            }
        });
        if !in_one_row {
            ui.horizontal_wrapped(|ui| self.filter.show(ctx, ui));
        }
        let windows = self.filter(ctx, ui);
        bulk(ctx, ui);
        proposals(ctx, ui);
        ui.add_space(2.0);
        let session = ctx.session;
        if let Some(window) = ctx.state.renaming.take().and_then(|name| session.window(&name)) {
            self.typing = Some(Typing::over(name_field(window), &window.name));
        }
        let columns = Columns::in_width(ui.available_width() - RIGHT_ROOM, session.flights.len() > 1);
        let reason_width = (ui.available_width() - MARK - RIGHT_ROOM).max(60.0);
        let reasons: Vec<_> = windows.iter().map(|window| reason(ctx, ui, window, reason_width)).collect();
        let chosen = windows.iter().position(|w| ctx.selection().window.as_deref() == Some(w.name.as_str()));
        let row = chosen.map(|at| at + reasons[..=at].iter().flatten().count());
        // Closer than usual, so that the note has room beside the name.
        ui.spacing_mut().item_spacing.x = 4.0;
        let mut table = texts_grid(ui, "manoeuvres")
            .sense(egui::Sense::click())
            .column(Column::exact(MARK))
            .column(Column::remainder().at_least(96.0).clip(true));
        if let Some(row) = row.filter(|_| row != self.in_view) {
            table = table.scroll_to_row(row, None);
        }
        self.in_view = row;
        let optional = |there: bool, width: f32| there.then(|| Column::exact(width).clip(true));
        let after_name = optional(columns.flight, FLIGHT).into_iter().chain([Column::exact(TIME)]);
        let fixed = [FLAGS, USE, SURFACE].map(Column::exact);
        let rest = after_name.chain(optional(columns.end, TIME)).chain(fixed).chain(optional(columns.note, NOTE));
        table = rest.fold(table, TableBuilder::column);
        table
            .header(20.0, |mut header| {
                for (title, order) in columns.titles() {
                    header.col(|ui| {
                        match order {
                            Some(order) => self.filter.title(ui, title, order),
                            None => column_title(ui, title),
                        };
                    });
                }
            })
            .body(|mut body| {
                let order: Vec<&str> = windows.iter().map(|window| window.name.as_str()).collect();
                for (window, reason) in windows.iter().zip(&reasons) {
                    body.row(ROW, |row| self.row(ctx, row, window, (columns, &order)));
                    if let Some(reason) = reason {
                        body.row(reason.size().y + 8.0, |row| {
                            reason_row(ctx, row, window, columns.titles().count(), reason)
                        });
                    }
                }
            });
    }
}

impl Manoeuvres {
    /// What the filter lets through; how many that are, where it leaves any out.
    fn filter<'a>(&mut self, ctx: &mut PanelContext<'a>, ui: &mut Ui) -> Vec<&'a Manoeuvre> {
        let windows = self.filter.windows(ctx);
        if self.filter.is_set() {
            ui.horizontal(|ui| {
                ui.weak(format!("{} of {} shown", windows.len(), ctx.session.windows.len()));
                if let Some(first) = windows.first().filter(|_| ui.small_button("Select these").clicked()) {
                    ctx.choose(&first.name);
                    ctx.state.selection.others = windows[1..].iter().map(|window| window.name.clone()).collect();
                }
            });
        }
        windows
    }

    /// One window; `order`: names of those shown, from the first to the last.
    fn row(
        &mut self,
        ctx: &mut PanelContext<'_>,
        mut row: TableRow<'_, '_>,
        window: &Manoeuvre,
        (columns, order): (Columns, &[&str]),
    ) {
        row.set_selected(ctx.selection().is_selected(&window.name));
        row.col(|ui| state(ctx, ui, window));
        self.name(ctx, &mut row, window, order);
        if columns.flight {
            row.col(|ui| {
                ui.weak(&window.flight);
            });
        }
        let TimeRange { start_s, end_s } = window.window;
        let per_point = if window.flags.locked { 0.0 } else { DRAG_S };
        let ends = [("start", start_s, end_s), ("end", end_s, start_s)];
        for (what, value, other) in ends.into_iter().take(if columns.end { 2 } else { 1 }) {
            row.col(|ui| {
                // Six digits fit the column.
                ui.spacing_mut().button_padding.x = 2.0;
                let name = format!("{} {what}", window.name);
                let edited = QuantityEdit::new(&name, value).per_point(per_point).decimals(3).wide(TIME - 2.0).show(ui);
                ctx.edit_quantity(edited, |value| {
                    let window_s = if what == "start" { (value, other) } else { (other, value) };
                    let placed = TimeRange { start_s: window_s.0, end_s: window_s.1 };
                    Edit::Window(WindowEdit::Place { name: window.name.clone(), window: placed })
                });
            });
        }
        row.col(|ui| {
            LOCK.show(ctx, ui, window);
            CONFIRM.show(ctx, ui, window);
        });
        row.col(|ui| use_of(ctx, ui, window));
        row.col(|ui| surface_of(ctx, ui, window));
        if columns.note {
            self.note(ctx, &mut row, window, order);
        }
        let line = row.response();
        line.context_menu(|ui| menu(ctx, ui, window));
        if line.clicked() {
            let modifiers = line.ctx.input(|input| input.modifiers);
            select_among(ctx.state, ctx.session, order, &window.name, modifiers);
        }
    }

    /// The name: a click chooses the window, a double click or F2 lets it be typed.
    fn name(&mut self, ctx: &mut PanelContext<'_>, row: &mut TableRow<'_, '_>, window: &Manoeuvre, order: &[&str]) {
        let hint = if window.kind.is_empty() { "Double click or F2 renames" } else { window.kind.as_str() };
        let shown = Shown { field: name_field(window), present: &window.name, nothing: "", hint, order };
        let Some(to) = self.text(ctx, row, window, &shown).filter(|to| !to.is_empty()) else { return };
        if ctx.selection().window.as_deref() == Some(window.name.as_str()) && ctx.session.window(&to).is_none() {
            ctx.state.selection.window = Some(to.clone());
        }
        ctx.edit(Edit::Window(WindowEdit::Rename { from: window.name.clone(), to }));
    }

    /// The note, in the same way.
    fn note(&mut self, ctx: &mut PanelContext<'_>, row: &mut TableRow<'_, '_>, window: &Manoeuvre, order: &[&str]) {
        let hint = if window.note.is_empty() { "Double click to write a note" } else { window.note.as_str() };
        let field = format!("note of {}", window.name);
        let shown = Shown { field, present: &window.note, nothing: "–", hint, order };
        if let Some(note) = self.text(ctx, row, window, &shown) {
            ctx.edit(Edit::Window(WindowEdit::Note { name: window.name.clone(), note }));
        }
    }

    /// A text of `window` that a double click lets be typed in place; what it is to be once the field was left and differs.
    fn text(
        &mut self,
        ctx: &mut PanelContext<'_>,
        row: &mut TableRow<'_, '_>,
        window: &Manoeuvre,
        shown: &Shown<'_>,
    ) -> Option<String> {
        let mut typed = None;
        let (_, cell) = row.col(|ui| match self.typing.as_mut().filter(|typing| typing.field == shown.field) {
            Some(typing) => typed = typing.show(ui).then(|| ui.input(|i| i.key_pressed(egui::Key::Escape))),
            None => {
                let text = if shown.present.is_empty() {
                    RichText::new(shown.nothing).weak()
                } else {
                    RichText::new(shown.present)
                };
                let label = ui.add(Label::new(text).truncate());
                ui.ctx().accesskit_node_builder(label.id, |node| {
                    node.set_role(egui::accesskit::Role::Button);
                    node.set_label(shown.field.as_str());
                    node.set_value(shown.present);
                });
            }
        });
        if let Some(given_up) = typed {
            let text = self.typing.take().map(|typing| typing.text.trim().to_owned());
            return text.filter(|text| !given_up && text != shown.present);
        }
        let cell = cell.on_hover_text(shown.hint);
        if cell.clicked() {
            let modifiers = cell.ctx.input(|input| input.modifiers);
            select_among(ctx.state, ctx.session, shown.order, &window.name, modifiers);
        }
        if cell.double_clicked() {
            self.typing = Some(Typing::over(shown.field.clone(), shown.present));
        }
        None
    }
}

/// What is done to all selected windows at once, where there are several.
fn bulk(ctx: &mut PanelContext<'_>, ui: &mut Ui) {
    let count = ctx.selection().windows(ctx.session).count();
    if count < 2 && ui.available_height() < LITTLE {
        return;
    }
    // There with one too where there is room: rows below do not move under the pointer when more of them are selected.
    ui.add_enabled_ui(count > 0, |ui| {
        ui.horizontal_wrapped(|ui| bulk_buttons(ctx, ui, count));
    });
}

/// The buttons that act on the `count` selected manoeuvres, each in one step of undo.
pub(crate) fn bulk_buttons(ctx: &mut PanelContext<'_>, ui: &mut Ui, count: usize) {
    ui.strong(format!("{count} selected:"));
    for (role, keys) in WindowRole::ALL.into_iter().zip(["I", "V", "X"]) {
        let name = if role == WindowRole::Ignored { "ignore" } else { role.name() };
        if ui.button(name).on_hover_text(keys).clicked() {
            ctx.commands.push(UiCommand::Edit(EditCommand::UseWindows(role)));
        }
    }
    ui.menu_button("surface", |ui| {
        for surface in [None].into_iter().chain(Surface::ALL.map(Some)) {
            if ui.button(surface.map_or("any", Surface::name)).clicked() {
                ctx.commands.push(UiCommand::Mark(MarkCommand::Surface(surface)));
                ui.close();
            }
        }
    });
    if ui.button("confirm").on_hover_text("Checked and confirmed").clicked() {
        flag_selected(ctx, WindowFlag::Confirmed);
    }
    if ui.button("remove").on_hover_text("Delete").clicked() {
        ctx.commands.push(UiCommand::Edit(EditCommand::RemoveWindow));
    }
}

/// Sets a flag of every selected window in one step of undo.
fn flag_selected(ctx: &mut PanelContext<'_>, flag: WindowFlag) {
    let names: Vec<String> = ctx.selection().windows(ctx.session).map(|window| window.name.clone()).collect();
    ctx.edits.push(EditRequest::Begin(format!("{} {} manoeuvres", flag.verb(true), names.len())));
    for name in names {
        ctx.edit(Edit::Window(WindowEdit::Flag { name, flag, on: true }));
    }
    ctx.edits.push(EditRequest::Commit);
}

/// The menu of a row: of all selected windows where it is one of them, of its own else.
pub(crate) fn menu(ctx: &mut PanelContext<'_>, ui: &mut Ui, window: &Manoeuvre) {
    if !ctx.selection().is_selected(&window.name) {
        ctx.choose(&window.name);
    }
    let count = ctx.selection().windows(ctx.session).count();
    if count > 1 {
        ui.weak(format!("{count} manoeuvres"));
    }
    let (session, table, markers_s) = (ctx.session, ctx.table, ctx.state.time.markers_s);
    let window = session.window(&window.name);
    let spot = Spot { session, table, window, candidate: None, time_s: None, markers_s };
    let chosen = marking::menu(ui, &spot);
    ui.separator();
    if ui.button("Select all   Ctrl+Shift+A").clicked() {
        ctx.commands.push(UiCommand::Edit(EditCommand::SelectAll));
        ui.close();
    }
    if let Some(command) = chosen {
        ctx.follow_menu(&spot, command);
    }
    if ui.button("Confirm").clicked() {
        flag_selected(ctx, WindowFlag::Confirmed);
        ui.close();
    }
}

/// The field of a window's name.
fn name_field(window: &Manoeuvre) -> String {
    format!("name of {}", window.name)
}

impl Typing {
    /// Typing over `present` in `field`.
    fn over(field: String, present: &str) -> Self {
        Self { field, text: present.to_owned(), focused: false }
    }

    /// Draws the field; whether it was left.
    fn show(&mut self, ui: &mut Ui) -> bool {
        let id = Id::unique(("typed in place", &self.field));
        let field = TextEdit::singleline(&mut self.text)
            .id(id)
            .desired_width(ui.available_width())
            .align(egui::Align2::LEFT_CENTER)
            .min_size(egui::vec2(0.0, ROW - 4.0))
            .margin(egui::Margin::symmetric(2, 0));
        let output = field.show(ui);
        let response: Response = output.response.response;
        ui.ctx().accesskit_node_builder(response.id, |node| node.set_label(self.field.as_str()));
        if !self.focused {
            self.focused = true;
            response.request_focus();
            let (mut state, length) = (output.state, self.text.chars().count());
            state.cursor.set_char_range(Some(CCursorRange::two(CCursor::new(0), CCursor::new(length))));
            state.store(ui.ctx(), id);
            return false;
        }
        response.lost_focus()
    }
}

/// Columns beside mark, name, start, flags, use and surface.
#[derive(Clone, Copy)]
struct Columns {
    flight: bool,
    end: bool,
    note: bool,
}

impl Columns {
    /// As many as leave the names their room: the flight where there are several, the end, and the note.
    fn in_width(width: f32, several: bool) -> Self {
        let gap = 4.0;
        let needed = MARK + NAME + TIME + FLAGS + USE + SURFACE + 5.0 * gap + if several { FLIGHT + gap } else { 0.0 };
        let with_end = needed + TIME + gap;
        Self { flight: several, end: width >= with_end, note: width >= with_end + NOTE + gap }
    }

    /// Titles, with what a click on them orders by.
    fn titles(self) -> impl Iterator<Item = (&'static str, Option<Order>)> {
        let all = [
            ("", None, true),
            ("Name", Some(Order::Name), true),
            ("Flight", None, self.flight),
            ("Start [s]", Some(Order::Start), true),
            ("End [s]", Some(Order::End), self.end),
            ("", None, true),
            ("Use", Some(Order::Use), true),
            ("Surface", Some(Order::Surface), true),
            ("Note", None, self.note),
        ];
        all.into_iter().filter(|(.., there)| *there).map(|(title, order, _)| (title, order))
    }
}

/// Why a window has no results.
fn error<'a>(ctx: &PanelContext<'a>, window: &Manoeuvre) -> Option<&'a str> {
    let results = ctx.snapshot.windows.get(&window.name)?;
    results.path.error().or(results.aero.error()).or(results.fits.error())
}

/// Why a window has no results, or that it cuts its input, laid out in lines of `width`.
fn reason(ctx: &PanelContext<'_>, ui: &Ui, window: &Manoeuvre, width: f32) -> Option<Arc<Galley>> {
    let (text, color) = match error(ctx, window) {
        Some(error) => (error.to_owned(), theme::palette(ui).error),
        None => (describe_cut(ctx, window)?, theme::palette(ui).warning),
    };
    Some(ui.painter().layout(text, FontId::proportional(REASON), color, width))
}

/// That a manoeuvre uses a part of its input only.
fn describe_cut(ctx: &PanelContext<'_>, window: &Manoeuvre) -> Option<String> {
    let input = ctx.snapshot.proposals.get(&window.flight)?.latest()?.cut_input(window)?;
    let [start, end] = [input.onset_s, input.input_end_s].map(|time_s| notation::fixed(time_s, 2));
    Some(format!("Cuts its input, which lasts from {start} s to {end} s: only a part of it is used."))
}

/// The row below a window that says why it has no results, or what it cuts, across all columns.
fn reason_row(
    ctx: &mut PanelContext<'_>,
    mut row: TableRow<'_, '_>,
    window: &Manoeuvre,
    columns: usize,
    reason: &Arc<Galley>,
) {
    let (mut left, mut visible) = (0.0, egui::Rect::NOTHING);
    for column in 0..columns {
        row.col(|ui| {
            let cell = ui.max_rect();
            visible |= ui.clip_rect();
            if column == 0 {
                left = cell.left() + MARK;
            }
            // Drawn from the last cell, over the stripes of those before it.
            if column + 1 == columns {
                let line = egui::Rect::from_min_size(egui::pos2(left, cell.top() + 2.0), reason.size());
                let mut over = ui.new_child(egui::UiBuilder::new().max_rect(line));
                over.set_clip_rect(visible);
                over.add(egui::Label::new(Arc::clone(reason)).selectable(false));
            }
        });
    }
    if row.response().clicked() {
        ctx.choose(&window.name);
    }
}

/// A dot: the colour of the use, a warning where the results failed.
fn state(ctx: &PanelContext<'_>, ui: &mut Ui, window: &Manoeuvre) {
    let palette = theme::palette(ui);
    match error(ctx, window) {
        Some(error) => ui.label(RichText::new("⚠").color(palette.error)).on_hover_text(error),
        None => {
            let dot = ui.label(RichText::new("■").color(role_color(palette, window.role)));
            dot.on_hover_ui(|ui| {
                ui.label(hint(ctx, window));
            })
        }
    };
}

/// What hovering over a window's dot says.
fn hint(ctx: &PanelContext<'_>, window: &Manoeuvre) -> String {
    let results = ctx.snapshot.windows.get(&window.name);
    let mut hint = format!("{} s", notation::fixed(window.window.end_s - window.window.start_s, 2));
    if let Some(path) = results.and_then(|results| results.path.latest()) {
        hint += &format!(", {} samples", path.data.inputs.time_s.len());
    }
    let excluded_s: f64 = window.excluded.iter().map(TimeRange::length_s).sum();
    if excluded_s > 0.0 {
        hint += &format!(", {} s excluded", notation::fixed(excluded_s, 2));
    }
    match results.and_then(|results| measure_steadiness(results.aero.latest()?)) {
        Some(before) => hint + "\n" + &describe_before_input(&before),
        None => hint,
    }
}

/// How steady a window is before its input, in words.
fn describe_before_input(before: &Steadiness) -> String {
    let Steadiness { length_s, airspeed_slope_m_s2, w_slope_m_s2, climb_m_s } = *before;
    let [length, airspeed, w] = [length_s, airspeed_slope_m_s2, w_slope_m_s2].map(|value| notation::fixed(value, 2));
    let climb = climb_m_s.map_or(String::new(), |climb| format!(", climb {} m/s", notation::fixed(climb, 2)));
    format!("{length} s before the input: airspeed changes by {airspeed} m/s², w by {w} m/s²{climb}")
}

/// A flag of a window as a button: what it shows and what hovering says, set and not set.
struct FlagButton {
    flag: WindowFlag,
    marks: [&'static str; 2],
    hints: [&'static str; 2],
}

const LOCK: FlagButton = FlagButton {
    flag: WindowFlag::Locked,
    marks: ["🔒", "🔓"],
    hints: [
        "Start and end are locked against dragging. Click to unlock",
        "Click to lock start and end against dragging",
    ],
};

const CONFIRM: FlagButton = FlagButton {
    flag: WindowFlag::Confirmed,
    marks: ["✔", "○"],
    hints: ["Confirmed. Click to undo", "Click to confirm this manoeuvre"],
};

impl FlagButton {
    fn show(&self, ctx: &mut PanelContext<'_>, ui: &mut Ui, window: &Manoeuvre) {
        let mut flags = window.flags;
        let on = *self.flag.among(&mut flags);
        let (mark, hint) = (self.marks[usize::from(!on)], self.hints[usize::from(!on)]);
        let text = if on { RichText::new(mark) } else { RichText::new(mark).weak() };
        let button = ui.add(egui::Button::new(text).frame(false)).on_hover_text(hint);
        let label = format!("{} of {}", self.flag.name(), window.name);
        ui.ctx().accesskit_node_builder(button.id, |node| node.set_label(label));
        if button.clicked() {
            ctx.edit(Edit::Window(WindowEdit::Flag { name: window.name.clone(), flag: self.flag, on: !on }));
        }
    }
}

fn use_of(ctx: &mut PanelContext<'_>, ui: &mut Ui, window: &Manoeuvre) {
    let mut role = window.role;
    let combo = ComboBox::from_id_salt(("use", &window.name)).selected_text(role.name()).width(USE).show_ui(ui, |ui| {
        for choice in WindowRole::ALL {
            ui.selectable_value(&mut role, choice, choice.name());
        }
    });
    ui.ctx().accesskit_node_builder(combo.response.id, |node| node.set_label(format!("use of {}", window.name)));
    if role != window.role {
        ctx.edit(Edit::Window(WindowEdit::Role { name: window.name.clone(), role }));
    }
}

fn surface_of(ctx: &mut PanelContext<'_>, ui: &mut Ui, window: &Manoeuvre) {
    let mut surface = window.surface;
    let text = |surface: Option<Surface>| surface.map_or("any", Surface::name);
    let combo = ComboBox::from_id_salt(("surface", &window.name)).selected_text(text(surface)).width(SURFACE).show_ui(
        ui,
        |ui| {
            for choice in [None].into_iter().chain(Surface::ALL.map(Some)) {
                ui.selectable_value(&mut surface, choice, text(choice));
            }
        },
    );
    ui.ctx().accesskit_node_builder(combo.response.id, |node| node.set_label(format!("surface of {}", window.name)));
    if surface != window.surface {
        ctx.edit(Edit::Window(WindowEdit::Surface { name: window.name.clone(), surface }));
    }
}
