//! Carries out commands.

use doublet_core::series::TimeRange;
use doublet_engine::session::{Annotation, Edit, WindowEdit};
use eframe::egui;

use super::help::Topic;
use super::mark_commands::mark;
use super::{Asked, Document, Pending, Workbench};
use crate::command::{EditCommand, FileCommand, HelpCommand, RunCommand, UiCommand, ViewCommand};
use crate::layouts::{Arranged, LayoutKey};
use crate::panels::{self, Pane};

/// Room shown on both sides of a window, as a part of its length.
const WINDOW_ROOM: f64 = 0.25;

/// Carries out one command.
pub fn dispatch(app: &mut Workbench, command: UiCommand, ctx: &egui::Context) {
    let menu_s = app.state.at_s.take();
    match command {
        UiCommand::File(command) => file(app, command, ctx),
        UiCommand::Edit(command) => edit(app, command),
        UiCommand::Mark(command) => mark(app, command, menu_s),
        UiCommand::Run(RunCommand::Again) => app.compute_again(),
        UiCommand::Run(RunCommand::Study(study)) => app.study(study),
        UiCommand::Run(RunCommand::Cancel) => app.cancel(),
        UiCommand::View(command) => view(app, command, ctx),
        UiCommand::Help(HelpCommand::Palette) => app.palette.open(),
        UiCommand::Help(HelpCommand::Here) => app.help_here(ctx),
        UiCommand::Help(HelpCommand::Manual) => app.help.open(Topic::Contents),
        UiCommand::Help(HelpCommand::Glossary) => app.help.open(Topic::Page("glossary".to_owned(), None)),
        UiCommand::Help(HelpCommand::About) => app.help.open(Topic::About),
        UiCommand::Help(HelpCommand::Shortcuts) => show_pane(app, Pane::Shortcuts),
        UiCommand::Help(HelpCommand::Tour) => app.leave(Pending::Tour, ctx),
    }
}

/// Opens, saves, writes results.
fn file(app: &mut Workbench, command: FileCommand, ctx: &egui::Context) {
    match command {
        FileCommand::New => app.leave(Pending::AskRecording, ctx),
        FileCommand::ContinueNew => app.continue_beginning(),
        FileCommand::NewFromFolder => app.leave(Pending::AskFolder, ctx),
        FileCommand::Open => app.leave(Pending::AskOpen, ctx),
        FileCommand::OpenBeside => app.ask(Asked::OpenBeside, ctx),
        FileCommand::CloseBeside => app.close_beside(),
        FileCommand::OpenShipped => app.leave(Pending::Shipped(Document::SHIPPED), ctx),
        FileCommand::OpenShippedSession(name) => app.leave(Pending::Shipped(name), ctx),
        FileCommand::OpenPublic => app.leave(Pending::AskPublic, ctx),
        FileCommand::OpenRecent(at) => {
            if let Some(path) = app.state.recent.get(at).cloned() {
                app.leave(Pending::Open(path), ctx);
            }
        }
        FileCommand::Save => app.save_then(None, ctx),
        FileCommand::SaveAs => app.ask(Asked::Save(None), ctx),
        FileCommand::SaveInstruments => app.ask(Asked::Instruments, ctx),
        FileCommand::UseAircraft => app.ask(Asked::OtherAircraft, ctx),
        FileCommand::SaveDescribedAircraft => app.ask(Asked::DescribedAircraft, ctx),
        FileCommand::Browse(field) => app.ask(Asked::Field(field), ctx),
        FileCommand::SaveAircraft => app.ask(Asked::OwnAircraft, ctx),
        FileCommand::Export | FileCommand::ExportModel | FileCommand::Report if app.is_busy() => {
            app.complain("results are still being computed: write them after the run");
        }
        FileCommand::Export | FileCommand::ExportModel | FileCommand::Report if app.is_exporting() => {
            app.complain("files are still being written")
        }
        FileCommand::Report => app.ask(Asked::Report, ctx),
        FileCommand::Export => app.ask(Asked::Export, ctx),
        FileCommand::AddReference => app.ask(Asked::Reference, ctx),
        FileCommand::ClearReferences => app.references.clear(),
        FileCommand::ExportModel => app.ask(Asked::ExportModel, ctx),
        FileCommand::FindRecording => app.ask_missing(ctx),
        FileCommand::Quit => app.leave(Pending::Quit, ctx),
    }
}

/// Changes the session, or which of its windows is chosen.
fn edit(app: &mut Workbench, command: EditCommand) {
    match command {
        EditCommand::Undo => app.undo(),
        EditCommand::Redo => app.redo(),
        EditCommand::History => app.toggle_history(),
        EditCommand::AddWindow => add_window(app),
        EditCommand::RemoveWindow => each_selected(app, "remove", WindowEdit::Remove),
        EditCommand::UseWindows(role) => {
            each_selected(app, &format!("use for {}:", role.name()), |name| WindowEdit::Role { name, role });
        }
        EditCommand::SelectAll => {
            let session = app.document.session().clone();
            let flight = app.state.selection.flight.clone().unwrap_or_default();
            let of_flight = session.windows.iter().filter(|window| window.flight == flight);
            app.state.selection.others = of_flight.map(|window| window.name.clone()).collect();
        }
        EditCommand::RenameWindow => {
            app.state.renaming = app.state.selection.window.clone();
            show_pane(app, Pane::Manoeuvres);
        }
        EditCommand::Annotate => annotate(app),
        EditCommand::NextWindow => step(app, 1),
        EditCommand::PreviousWindow => step(app, -1),
    }
}

/// Asks for words at the time under the pointer, else at marker A, else in the middle of what is on screen.
fn annotate(app: &mut Workbench) {
    let (time, range) = (&app.state.time, app.state.time.range());
    let at_s = time.cursor_s.or(time.markers_s[0]).unwrap_or(0.5 * (range.start_s + range.end_s));
    if let Some(flight) = app.state.selection.flight.clone() {
        app.state.annotating = Some((Annotation { flight, time_s: at_s, text: String::new() }, None));
    }
}

/// Changes every selected window in one step of undo.
pub(super) fn each_selected(app: &mut Workbench, what: &str, edit: impl Fn(String) -> WindowEdit) {
    let session = app.document.session().clone();
    let names: Vec<String> = app.state.selection.windows(&session).map(|window| window.name.clone()).collect();
    match names.as_slice() {
        [] => {}
        [one] => app.apply(&Edit::Window(edit(one.clone()))),
        several => {
            let edits = several.iter().map(|name| Edit::Window(edit(name.clone())));
            app.apply_together(&format!("{what} {} manoeuvres", several.len()), edits);
        }
    }
}

/// Brings a panel on screen, away from the start page.
fn show_pane(app: &mut Workbench, pane: Pane) {
    app.leave_start_page();
    app.state.show_pane(pane);
}

/// Chooses the window `by` places on in the order of time, around the ends.
fn step(app: &mut Workbench, by: isize) {
    let session = app.document.session().clone();
    let windows = panels::windows_by_time(&session);
    let count = windows.len();
    if count == 0 {
        return;
    }
    let chosen = app.state.selection.window.as_deref();
    let at = windows.iter().position(|window| Some(window.name.as_str()) == chosen).unwrap_or(0);
    let next = (at + count).wrapping_add_signed(by) % count;
    panels::choose(&mut app.state, &session, &windows[next].name);
}

/// A manoeuvre between the markers.
fn add_window(app: &mut Workbench) {
    let Some(flight) = app.state.selection.flight.clone() else { return };
    let part = match app.state.time.markers_s {
        [Some(a), Some(b)] if a != b => TimeRange::new(a, b),
        _ => return app.complain("Set markers A and B first, or drag with Ctrl in a plot."),
    };
    let window = panels::new_window(app.document.session(), flight, part);
    let name = window.name.clone();
    app.apply(&Edit::Window(WindowEdit::Add(window)));
    let session = app.document.session().clone();
    panels::choose(&mut app.state, &session, &name);
}

/// Shows a layout, away from the start page.
fn show_layout(app: &mut Workbench, key: LayoutKey) {
    app.leave_start_page();
    app.state.show_layout(key);
}

/// Changes what is on screen.
fn view(app: &mut Workbench, command: ViewCommand, ctx: &egui::Context) {
    let window = app.state.selection.window.as_deref().and_then(|name| app.document.session().window(name));
    let window = window.map(|window| window.window);
    let time = &mut app.state.time;
    match command {
        ViewCommand::ZoomHome => {
            time.home();
            app.state.window_time.home();
        }
        ViewCommand::ZoomBack => {
            time.go_back();
        }
        ViewCommand::ZoomForward => {
            time.go_forward();
        }
        ViewCommand::ZoomToWindow => {
            if let Some(TimeRange { start_s, end_s }) = window {
                let room = WINDOW_ROOM * (end_s - start_s);
                time.zoom_to(TimeRange::new(start_s - room, end_s + room));
            }
        }
        ViewCommand::ZoomToMarkers => {
            if let [Some(a), Some(b)] = time.markers_s {
                time.zoom_to(TimeRange::new(a, b));
            }
        }
        // Escape closes the manual before it clears anything.
        ViewCommand::ClearMarkers if app.help.close() => {}
        ViewCommand::ClearMarkers => {
            time.markers_s = [None; 2];
            app.state.window_time.markers_s = [None; 2];
        }
        ViewCommand::OpenWindow => {
            view(app, ViewCommand::ZoomToWindow, ctx);
            show_pane(app, Pane::Flight);
        }
        ViewCommand::Show(pane) => show_pane(app, pane),
        ViewCommand::Step(step) => show_layout(app, LayoutKey::Step(step)),
        ViewCommand::Overview => show_layout(app, LayoutKey::Overview),
        ViewCommand::NamedLayout(at) => {
            if let Some(name) = app.state.layout_names().get(at).map(ToString::to_string) {
                show_layout(app, LayoutKey::Named(name));
            }
        }
        ViewCommand::ForgetLayout(at) => {
            if let Some(name) = app.state.layout_names().get(at).map(ToString::to_string) {
                app.state.forget_layout(&name);
            }
        }
        ViewCommand::KeepLayout => app.name_layout(),
        ViewCommand::StartPage => app.show_start_page(),
        ViewCommand::Workbench => app.leave_start_page(),
        ViewCommand::ResetLayout => app.state.shown = Arranged::new(app.state.shown.key.clone()),
        ViewCommand::Units(units) => app.state.units = units,
        // By keys egui does it by itself.
        ViewCommand::Larger => egui::gui_zoom::zoom_in(ctx),
        ViewCommand::Smaller => egui::gui_zoom::zoom_out(ctx),
        ViewCommand::Appearance(theme) => {
            app.state.appearance = theme;
            ctx.set_theme(theme);
        }
    }
}
