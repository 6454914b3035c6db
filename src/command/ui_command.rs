//! The table of commands: name, menu and shortcut of each.

use doublet_engine::session::{Surface, WindowRole};
use doublet_engine::study::Study;
use eframe::egui::{self, Key, KeyboardShortcut, Modifiers, ThemePreference};

use crate::notation::Units;
use crate::pane::Pane;
use crate::step::Step;

/// Something a user can ask for; [`table`] says in words what each is.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum UiCommand {
    File(FileCommand),
    Edit(EditCommand),
    Mark(MarkCommand),
    Run(RunCommand),
    View(ViewCommand),
    Help(HelpCommand),
}

/// Commands on session files and results.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum FileCommand {
    New,
    NewFromFolder,
    ContinueNew,
    Open,
    OpenBeside,
    CloseBeside,
    OpenShipped,
    /// Open another one that comes with the program, by its name.
    OpenShippedSession(&'static str),
    OpenPublic,
    /// Open one of the sessions opened last.
    OpenRecent(usize),
    Save,
    SaveAs,
    SaveAircraft,
    /// Use an aircraft file in the session.
    UseAircraft,
    /// Write the aircraft that was described for a session without one, which uses it from then on.
    SaveDescribedAircraft,
    /// Ask for the file or folder of a field of a panel.
    Browse(FileField),
    /// Write the instruments with what was fitted to a file, which the flight then uses.
    SaveInstruments,
    Export,
    Report,
    AddReference,
    ClearReferences,
    ExportModel,
    FindRecording,
    Quit,
}

/// The fields of panels that hold a file or a folder.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum FileField {
    Tests,
    Guide,
    Card,
    LiveSource,
    LiveCampaign,
    LiveRecord,
}

impl FileField {
    doublet_core::variant_texts! {
        pub name: Tests "file of tests", Guide "folder of the guide", Card "folder of the card", LiveSource "live source",
            LiveCampaign "live campaign", LiveRecord "live record"
    }
}

/// Commands on the session.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum EditCommand {
    Undo,
    Redo,
    History,
    AddWindow,
    RemoveWindow,
    RenameWindow,
    UseWindows(WindowRole),
    /// Write words at the time under the pointer, else at marker A.
    Annotate,
    SelectAll,
    NextWindow,
    PreviousWindow,
}

/// Commands that mark manoeuvres.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum MarkCommand {
    NewShown,
    StartHere,
    EndHere,
    Split,
    Exclude,
    /// Take the excluded part at the pointer in again, else all of the chosen one.
    Include,
    Surface(Option<Surface>),
    Note,
    Lock,
    Accept,
    Refuse,
    NextCandidate,
    ShowRefused,
}

/// Commands on the run in the background.
#[derive(Clone, Copy, Debug, PartialEq)]
#[allow(clippy::large_enum_variant, reason = "copied once a click")]
pub enum RunCommand {
    Again,
    Study(Study),
    Cancel,
}

/// Commands that change what is on screen and nothing else.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum ViewCommand {
    ZoomHome,
    ZoomBack,
    ZoomForward,
    ZoomToWindow,
    ZoomToMarkers,
    ClearMarkers,
    Show(Pane),
    OpenWindow,
    Step(Step),
    Overview,
    /// Show the layout kept under a name, by its place among them.
    NamedLayout(usize),
    KeepLayout,
    /// Forget the layout kept under a name, by its place among them.
    ForgetLayout(usize),
    StartPage,
    Workbench,
    ResetLayout,
    Appearance(ThemePreference),
    Units(Units),
    Larger,
    Smaller,
}

/// Commands that explain.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum HelpCommand {
    Palette,
    Here,
    Manual,
    Glossary,
    Shortcuts,
    Tour,
    About,
}

/// The menus, in their order.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Menu {
    File,
    Edit,
    Mark,
    View,
    Layout,
    Panels,
    Run,
    Help,
}

impl Menu {
    doublet_core::named_variants! {
        pub title:
            File "File", Edit "Edit", Mark "Mark", View "View", Layout "Layout", Panels "Panels", Run "Run",
            Help "Help",
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

impl CommandInfo {
    /// Its keys in words; empty where it has none.
    pub fn keys(&self, ctx: &egui::Context) -> String {
        let words = self.shortcut.map(|keys| ctx.format_shortcut(&keys)).unwrap_or_default();
        words.replace("OpenBracket", "[").replace("CloseBracket", "]")
    }

    /// Whether a menu draws a line above it.
    pub fn begins_group(&self) -> bool {
        use {EditCommand as E, FileCommand as F, MarkCommand as M, ViewCommand as V};
        matches!(
            self.command,
            UiCommand::File(F::Save | F::Export | F::AddReference | F::Quit)
                | UiCommand::Edit(E::RenameWindow | E::UseWindows(WindowRole::Identification) | E::NextWindow)
                | UiCommand::Mark(M::StartHere | M::Exclude | M::Surface(None) | M::Accept)
                | UiCommand::View(
                    V::Larger
                        | V::Appearance(ThemePreference::Dark)
                        | V::Units(Units::Metric)
                        | V::Step(Step::Recording)
                        | V::Overview
                        | V::ResetLayout
                )
                | UiCommand::Run(RunCommand::Cancel)
        )
    }
}

/// Keys with Ctrl (Command on a Mac).
const fn ctrl(key: Key) -> Option<KeyboardShortcut> {
    Some(KeyboardShortcut::new(Modifiers::COMMAND, key))
}

const fn ctrl_shift(key: Key) -> Option<KeyboardShortcut> {
    Some(KeyboardShortcut::new(Modifiers::COMMAND.plus(Modifiers::SHIFT), key))
}

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
    let file = |name, command, shortcut| row(Menu::File, name, UiCommand::File(command), shortcut);
    let edit = |name, command, shortcut| row(Menu::Edit, name, UiCommand::Edit(command), shortcut);
    let run = |name, command, shortcut| row(Menu::Run, name, UiCommand::Run(command), shortcut);
    let mut table = vec![
        file("New session from recording…", FileCommand::New, ctrl(Key::N)),
        file("New session from folder of CSV files…", FileCommand::NewFromFolder, ctrl_shift(Key::N)),
        file("Continue new session", FileCommand::ContinueNew, None),
        file("Open session…", FileCommand::Open, ctrl(Key::O)),
        file("Open second session beside…", FileCommand::OpenBeside, ctrl_shift(Key::O)),
        file("Close second session", FileCommand::CloseBeside, None),
        file("Open shipped session", FileCommand::OpenShipped, None),
        file("Open public recording…", FileCommand::OpenPublic, None),
        file("Save session", FileCommand::Save, ctrl(Key::S)),
        file("Save session as…", FileCommand::SaveAs, ctrl_shift(Key::S)),
        file("Choose aircraft file…", FileCommand::UseAircraft, None),
        file("Save aircraft as…", FileCommand::SaveAircraft, None),
        file("Export results…", FileCommand::Export, ctrl(Key::E)),
        file("Write report…", FileCommand::Report, ctrl_shift(Key::E)),
        file("Add reference derivatives…", FileCommand::AddReference, None),
        file("Remove reference derivatives", FileCommand::ClearReferences, None),
        file("Export model…", FileCommand::ExportModel, None),
        file("Find a missing recording…", FileCommand::FindRecording, None),
        file("Quit", FileCommand::Quit, ctrl(Key::Q)),
        edit("Undo", EditCommand::Undo, ctrl(Key::Z)),
        edit("Redo", EditCommand::Redo, ctrl_shift(Key::Z)),
        edit("History", EditCommand::History, None),
        edit("Annotate at the pointer…", EditCommand::Annotate, plain(Key::T)),
        run("Compute again", RunCommand::Again, plain(Key::F5)),
        run("Compute sensitivity", RunCommand::Study(Study::Sensitivity), None),
        run("Find lags of the controls", RunCommand::Study(Study::Lags), None),
        run("Compute frequency responses", RunCommand::Study(Study::Responses), None),
        run("Cancel", RunCommand::Cancel, ctrl(Key::Period)),
        view("Show whole recording", ZoomHome, plain(Key::Home)),
        view("Zoom back", ZoomBack, plain(Key::Backspace)),
        view("Zoom forward", ZoomForward, alt(Key::ArrowRight)),
        view("Zoom to markers", ZoomToMarkers, plain(Key::M)),
        view("Clear markers", ClearMarkers, plain(Key::Escape)),
        view("Larger text and controls", ViewCommand::Larger, ctrl(Key::Plus)),
        view("Smaller text and controls", ViewCommand::Smaller, ctrl(Key::Minus)),
        view("Dark theme", Appearance(ThemePreference::Dark), None),
        view("Light theme", Appearance(ThemePreference::Light), None),
        view("Theme of the system", Appearance(ThemePreference::System), None),
        view("Units: degrees, m, m/s", ViewCommand::Units(Units::Metric), None),
        view("Units: degrees, ft, kt", ViewCommand::Units(Units::Aviation), None),
        view("Units: SI and radians", ViewCommand::Units(Units::Si), None),
    ];
    table.extend(mark_table());
    let layout = |name: &str, command, shortcut| row(Menu::Layout, name, UiCommand::View(command), shortcut);
    table.push(layout("Start page", ViewCommand::StartPage, alt(Key::Home)));
    let keys = [Key::Num1, Key::Num2, Key::Num3, Key::Num4, Key::Num5, Key::Num6, Key::Num7, Key::Num8, Key::Num9];
    let steps = Step::ALL.into_iter().zip(keys);
    table
        .extend(steps.map(|(step, key)| layout(&format!("Step {}", step.title()), ViewCommand::Step(step), ctrl(key))));
    table.push(layout("Overview", ViewCommand::Overview, ctrl(Key::Num0)));
    table.push(layout("Keep this layout…", ViewCommand::KeepLayout, None));
    table.push(layout("Reset layout", ResetLayout, None));
    table.extend(Pane::ALL.iter().map(|&pane| row(Menu::Panels, pane.title(), UiCommand::View(Show(pane)), None)));
    let help = |name: &str, command, shortcut| row(Menu::Help, name, UiCommand::Help(command), shortcut);
    table.push(help("Explain item under the pointer", HelpCommand::Here, plain(Key::F1)));
    table.push(help("Manual", HelpCommand::Manual, None));
    table.push(help("Glossary", HelpCommand::Glossary, None));
    table.push(help("Keyboard shortcuts", HelpCommand::Shortcuts, ctrl(Key::F1)));
    table.push(row(Menu::Help, "Tour of the shipped flight", UiCommand::Help(HelpCommand::Tour), None));
    table.push(row(Menu::Help, "Find a command", UiCommand::Help(HelpCommand::Palette), ctrl(Key::P)));
    table.push(help("About doublet", HelpCommand::About, None));
    table
}

/// Commands on manoeuvres: made, moved, divided, used, accepted.
fn mark_table() -> Vec<CommandInfo> {
    use {EditCommand as E, MarkCommand as M};
    let row =
        |name: &str, command, shortcut| CommandInfo { command, name: name.to_owned(), menu: Menu::Mark, shortcut };
    let edit = |name, command, shortcut| row(name, UiCommand::Edit(command), shortcut);
    let mark = |name, command, shortcut| row(name, UiCommand::Mark(command), shortcut);
    let view = |name, command, shortcut| row(name, UiCommand::View(command), shortcut);
    let mut table = vec![
        edit("New manoeuvre between markers", E::AddWindow, plain(Key::Insert)),
        mark("New manoeuvre of what is shown", M::NewShown, None),
        mark("Start manoeuvre here", M::StartHere, plain(Key::OpenBracket)),
        mark("End manoeuvre here", M::EndHere, plain(Key::CloseBracket)),
        mark("Split manoeuvre here", M::Split, plain(Key::S)),
        mark("Exclude between markers", M::Exclude, plain(Key::E)),
        mark("Include excluded part", M::Include, plain(Key::R)),
        edit("Rename manoeuvre", E::RenameWindow, plain(Key::F2)),
        mark("Note on manoeuvre…", M::Note, plain(Key::F4)),
        mark("Lock or unlock edges", M::Lock, plain(Key::L)),
        edit("Remove manoeuvre", E::RemoveWindow, plain(Key::Delete)),
        edit("Use for identification", E::UseWindows(WindowRole::Identification), plain(Key::I)),
        edit("Use for validation", E::UseWindows(WindowRole::Validation), plain(Key::V)),
        edit("Ignore", E::UseWindows(WindowRole::Ignored), plain(Key::X)),
        mark("Surface: any", M::Surface(None), None),
    ];
    let surface = |surface: Surface| mark(surface_title(surface), M::Surface(Some(surface)), None);
    table.extend(Surface::ALL.map(surface));
    table.extend([
        mark("Accept candidate", M::Accept, plain(Key::Y)),
        mark("Refuse candidate", M::Refuse, plain(Key::N)),
        mark("Next candidate", M::NextCandidate, plain(Key::C)),
        mark("Offer refused candidates again", M::ShowRefused, None),
        edit("Next manoeuvre", E::NextWindow, plain(Key::PageDown)),
        edit("Previous manoeuvre", E::PreviousWindow, plain(Key::PageUp)),
        edit("Select all manoeuvres", E::SelectAll, ctrl_shift(Key::A)),
        view("Zoom to manoeuvre", ViewCommand::ZoomToWindow, plain(Key::W)),
        view("Open manoeuvre in Flight", ViewCommand::OpenWindow, plain(Key::Enter)),
    ]);
    table
}

fn surface_title(surface: Surface) -> &'static str {
    match surface {
        Surface::Elevator => "Surface: elevator",
        Surface::Aileron => "Surface: aileron",
        Surface::Rudder => "Surface: rudder",
    }
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
