//! Asking for a file: the system's dialog off the drawing thread, our own where the system has none.

use std::path::{Path, PathBuf};
use std::sync::mpsc::{Receiver, TryRecvError, channel};
use std::time::Duration;

use eframe::egui::text::{CCursor, CCursorRange};
use eframe::egui::{self, Align, Button, Label, Layout, RichText, ScrollArea, TextEdit, vec2};

use crate::notation::ago;

/// Longest name proposed for a file, characters.
const LONGEST_NAME: usize = 48;

/// What a file is wanted for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Purpose {
    /// Read an existing file.
    Open,
    /// Read one or several existing files.
    Several,
    /// Read an existing folder.
    Folder,
    /// Write a file.
    Save,
}

#[derive(Clone, Debug)]
pub struct FileQuestion {
    /// Title of the dialog.
    pub title: String,
    /// Read or write.
    pub purpose: Purpose,
    /// Endings of the files offered, without dot; none offers all.
    pub extensions: Vec<String>,
    /// Folder to begin in.
    pub folder: PathBuf,
    /// Proposed name.
    pub name: String,
    /// Folders one is likely to want, offered as buttons.
    pub places: Vec<PathBuf>,
}

/// One line of a folder.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct Entry {
    /// Files after folders.
    pub is_file: bool,
    /// Name in the folder.
    pub name: String,
    /// Size of a file, bytes.
    pub bytes: u64,
    /// Time since it was last changed, where the system says so.
    pub age: Option<Duration>,
}

/// Folders and files of `folder` that end in one of `extensions`, hidden ones left out.
pub fn entries(folder: &Path, extensions: &[String]) -> std::io::Result<Vec<Entry>> {
    let mut found = Vec::new();
    for entry in std::fs::read_dir(folder)? {
        let path = entry?.path();
        let Some(name) = path.file_name().and_then(|name| name.to_str()) else { continue };
        let is_file = !path.is_dir();
        let ending = path.extension().and_then(|ending| ending.to_str()).unwrap_or_default();
        let offered = extensions.is_empty() || extensions.iter().any(|wanted| wanted.eq_ignore_ascii_case(ending));
        if !name.starts_with('.') && (!is_file || offered) {
            let about = path.metadata().ok();
            let age = about.as_ref().and_then(|about| about.modified().ok()?.elapsed().ok());
            let bytes = about.filter(|_| is_file).map_or(0, |about| about.len());
            found.push(Entry { is_file, name: name.to_owned(), bytes, age });
        }
    }
    found.sort();
    Ok(found)
}

/// `bytes` as people read them.
fn size(bytes: u64) -> String {
    let mut value = bytes as f64;
    let mut unit = "B";
    for larger in ["kB", "MB", "GB", "TB"] {
        if value < 999.5 {
            break;
        }
        (value, unit) = (value / 1000.0, larger);
    }
    let decimals = usize::from(unit != "B" && value < 99.95);
    format!("{value:.decimals$} {unit}")
}

/// Between the names of several files in the field.
const BETWEEN: &str = "; ";
/// Width of the dialog and of the columns beside the names, height of a row and of the list, points.
const WIDTH: f32 = 640.0;
const COLUMNS: [f32; 2] = [80.0, 150.0];
const ROW: f32 = 22.0;
const LIST: f32 = 320.0;

/// Frames in which a new dialog asks for the keyboard.
const FRAMES_TO_FOCUS: u8 = 3;

/// The dialog of the workbench itself.
struct OwnDialog {
    question: FileQuestion,
    folder: PathBuf,
    entries: Vec<Entry>,
    typed: String,
    /// Files of any ending are listed.
    all: bool,
    complaint: Option<String>,
    /// Frames in which the field still asks for the keyboard: another dialog may hold it at first.
    to_focus: u8,
}

/// What a dialog came to.
enum Answer {
    Open,
    Chosen(Vec<PathBuf>),
    GivenUp,
}

/// How the question is being put. A dialog of the system takes the keyboard from the window: an answer of none before that means
/// that the system has no dialog.
enum Asking {
    System { question: FileQuestion, shown: bool, answer: Receiver<Option<Vec<PathBuf>>> },
    Own(OwnDialog),
}

/// At most one question at a time.
#[derive(Default)]
pub struct Files {
    asking: Option<Asking>,
    own_only: bool,
}

impl Files {
    /// Never asks the system.
    pub fn without_system() -> Self {
        Self { asking: None, own_only: true }
    }

    /// Puts `question`; one put before is forgotten.
    pub fn ask(&mut self, question: FileQuestion, ctx: &egui::Context) {
        let system = if self.own_only { None } else { ask_system(&question, ctx) };
        self.asking = Some(match system {
            Some(answer) => Asking::System { question, shown: false, answer },
            None => Asking::Own(OwnDialog::new(question)),
        });
    }

    /// Whether a question is open.
    pub fn is_asking(&self) -> bool {
        self.asking.is_some()
    }

    /// Whether a dialog of our own is on screen.
    pub fn is_shown(&self) -> bool {
        matches!(self.asking, Some(Asking::Own(_)))
    }

    /// Draws the dialog where it is ours; the files once any are chosen, one where no more were asked for.
    pub fn show(&mut self, ctx: &egui::Context) -> Option<Vec<PathBuf>> {
        match self.asking.take()? {
            Asking::System { question, shown, answer } => match answer.try_recv() {
                Ok(Some(paths)) => return Some(paths),
                Ok(None) if shown => {}
                Ok(None) | Err(TryRecvError::Disconnected) => {
                    self.own_only = true;
                    self.asking = Some(Asking::Own(OwnDialog::new(question)));
                    ctx.request_repaint();
                }
                Err(TryRecvError::Empty) => {
                    let shown = shown || !ctx.input(|input| input.focused);
                    self.asking = Some(Asking::System { question, shown, answer });
                }
            },
            Asking::Own(mut dialog) => match dialog.show(ctx) {
                Answer::Open => self.asking = Some(Asking::Own(dialog)),
                Answer::Chosen(paths) => return Some(paths),
                Answer::GivenUp => {}
            },
        }
        None
    }
}

/// Asks the system in a thread of its own.
fn ask_system(question: &FileQuestion, ctx: &egui::Context) -> Option<Receiver<Option<Vec<PathBuf>>>> {
    let (send, receive) = channel();
    let (question, ctx) = (question.clone(), ctx.clone());
    let ask = move || {
        // The question may have been forgotten meanwhile; then nobody listens.
        let _ = send.send(run_dialog(&question));
        ctx.request_repaint();
    };
    std::thread::Builder::new().name("file dialog".to_owned()).spawn(ask).ok().map(|_| receive)
}

/// Shows the dialog of the system until it is answered; none where it is given up.
fn run_dialog(question: &FileQuestion) -> Option<Vec<PathBuf>> {
    let mut dialog = rfd::FileDialog::new().set_title(&question.title).set_directory(&question.folder);
    if !question.extensions.is_empty() {
        dialog = dialog.add_filter(question.extensions.join(", "), &question.extensions);
        dialog = if question.purpose == Purpose::Save { dialog } else { dialog.add_filter("all files", &["*"]) };
    }
    let one = |path: Option<PathBuf>| path.map(|path| vec![path]);
    match question.purpose {
        Purpose::Open => one(dialog.pick_file()),
        Purpose::Several => dialog.pick_files(),
        Purpose::Folder => one(dialog.pick_folder()),
        Purpose::Save => one(dialog.set_file_name(&question.name).save_file()),
    }
}

impl OwnDialog {
    fn new(question: FileQuestion) -> Self {
        let folder = question.folder.canonicalize().unwrap_or_else(|_| PathBuf::from("/"));
        let typed = question.name.clone();
        let mut dialog = Self {
            question,
            folder: PathBuf::new(),
            entries: Vec::new(),
            typed,
            all: false,
            complaint: None,
            to_focus: FRAMES_TO_FOCUS,
        };
        dialog.enter(folder);
        dialog
    }

    /// Shows another folder, or says why not.
    fn enter(&mut self, folder: PathBuf) {
        let extensions = if self.all { &[][..] } else { &self.question.extensions };
        match entries(&folder, extensions) {
            Ok(entries) => {
                self.entries = entries;
                self.folder = folder;
                self.complaint = None;
                // The keyboard goes on in the folder entered.
                self.to_focus = FRAMES_TO_FOCUS;
            }
            Err(error) => self.complaint = Some(format!("{}: {error}", folder.display())),
        }
    }

    fn show(&mut self, ctx: &egui::Context) -> Answer {
        let mut answer = Answer::Open;
        egui::Modal::new(egui::Id::unique("file dialog")).show(ctx, |ui| {
            ui.set_width(WIDTH.min(ctx.content_rect().width() - 40.0));
            ui.heading(&self.question.title);
            ui.add_space(4.0);
            answer = self.contents(ui);
        });
        if ctx.input(|i| i.key_pressed(egui::Key::Escape)) { Answer::GivenUp } else { answer }
    }

    /// Ways to other folders.
    fn ways(&mut self, ui: &mut egui::Ui) {
        ui.horizontal_wrapped(|ui| {
            let parent = self.folder.parent().map(Path::to_path_buf);
            let mut to = None;
            if ui.add_enabled(parent.is_some(), Button::new("Up")).clicked() {
                to = parent;
            }
            let home = std::env::home_dir().filter(|home| home.is_dir());
            if let Some(home) = home.filter(|_| ui.button("Home").clicked()) {
                to = Some(home);
            }
            for place in &self.question.places {
                let name = place.file_name().unwrap_or(place.as_os_str()).to_string_lossy();
                let button = Button::selectable(*place == self.folder, name.as_ref());
                if ui.add(button).on_hover_text(place.display().to_string()).clicked() {
                    to = Some(place.clone());
                }
            }
            to.into_iter().for_each(|to| self.enter(to));
        });
        ui.add(Label::new(RichText::new(self.folder.display().to_string()).weak()).truncate());
    }

    fn contents(&mut self, ui: &mut egui::Ui) -> Answer {
        self.ways(ui);
        let mut enter = self.list(ui);
        let output =
            TextEdit::singleline(&mut self.typed).hint_text("Name or path").desired_width(f32::INFINITY).show(ui);
        let field = output.response.response;
        // What is typed replaces the name proposed, not its ending.
        if self.to_focus == 1 && self.question.purpose == Purpose::Save {
            let stem = Path::new(&self.typed).file_stem().map_or(0, |stem| stem.to_string_lossy().chars().count());
            let mut state = output.state;
            state.cursor.set_char_range(Some(CCursorRange::two(CCursor::new(0), CCursor::new(stem))));
            state.store(ui.ctx(), field.id);
        }
        ui.ctx().accesskit_node_builder(field.id, |node| node.set_label("File name"));
        if self.to_focus > 0 {
            self.to_focus -= 1;
            field.request_focus();
            ui.ctx().request_repaint();
        }
        let confirmed = field.lost_focus() && ui.input(|i| i.key_pressed(egui::Key::Enter));
        if let Some(complaint) = &self.complaint {
            ui.colored_label(ui.visuals().error_fg_color, complaint);
        }
        let mut answer = Answer::Open;
        ui.horizontal(|ui| {
            let action = match self.question.purpose {
                Purpose::Open | Purpose::Several => "Open",
                Purpose::Folder => "Use this folder",
                Purpose::Save => "Save",
            };
            let here = self.question.purpose == Purpose::Folder;
            let pressed = ui.add_enabled(here || !self.typed.trim().is_empty(), egui::Button::new(action)).clicked();
            if here && (pressed || (confirmed && self.typed.trim().is_empty())) {
                answer = Answer::Chosen(vec![self.folder.join(self.typed.trim())]);
                return;
            }
            if ui.button("Cancel").clicked() {
                answer = Answer::GivenUp;
            }
            if !self.question.extensions.is_empty() && self.question.purpose != Purpose::Save {
                let all = ui.checkbox(&mut self.all, "all files");
                if all.on_hover_text(format!("Otherwise: {}", self.question.extensions.join(", "))).changed() {
                    self.enter(self.folder.clone());
                }
            }
            if self.question.purpose == Purpose::Several {
                ui.weak("Ctrl+click: select several of one flight");
            }
            if pressed || confirmed {
                enter = Some(single_ending(self.typed.trim(), &self.question.extensions));
            }
        });
        if let Some(name) = enter {
            answer = self.choose(&name);
        }
        answer
    }

    /// The folder, its rows as wide as the dialog; the one that is to be entered or taken.
    fn list(&mut self, ui: &mut egui::Ui) -> Option<String> {
        let mut enter = None;
        let entries = std::mem::take(&mut self.entries);
        let area = ScrollArea::vertical().max_height(LIST).min_scrolled_height(LIST).auto_shrink(false);
        area.show_rows(ui, ROW, entries.len().max(1), |ui, rows| {
            if entries.is_empty() {
                let is_filtered = !self.all && !self.question.extensions.is_empty();
                ui.weak(if is_filtered { "No file of these types in this folder." } else { "This folder is empty." });
            }
            for entry in entries.get(rows).unwrap_or_default() {
                self.row(ui, entry, &mut enter);
            }
        });
        self.entries = entries;
        enter
    }

    /// One folder or file: name, size and time since its last change.
    fn row(&mut self, ui: &mut egui::Ui, entry: &Entry, enter: &mut Option<String>) {
        let name = if entry.is_file { entry.name.clone() } else { format!("{}/", entry.name) };
        let is_chosen = entry.is_file && self.typed.split(BETWEEN).any(|typed| typed == entry.name);
        ui.horizontal(|ui| {
            let width = (ui.available_width() - COLUMNS.iter().sum::<f32>() - 30.0).max(120.0);
            let button = Button::selectable(is_chosen, name.as_str()).truncate();
            let full = Layout::top_down_justified(Align::LEFT);
            let row = ui.allocate_ui_with_layout(vec2(width, ROW), full, |ui| ui.add(button)).inner;
            let size = if entry.is_file { size(entry.bytes) } else { String::new() };
            for (text, width) in [size, entry.age.map(ago).unwrap_or_default()].into_iter().zip(COLUMNS) {
                ui.allocate_ui_with_layout(vec2(width, ROW), Layout::right_to_left(Align::Center), |ui| {
                    ui.set_width(width);
                    ui.weak(text);
                });
            }
            if row.clicked() && entry.is_file {
                let several = self.question.purpose == Purpose::Several && ui.input(|input| input.modifiers.command);
                self.take(&entry.name, several);
            }
            if (row.clicked() && !entry.is_file) || row.double_clicked() {
                *enter = Some(entry.name.clone());
            }
        });
    }

    /// Puts a file into the field, with `several` beside those that are there or away from them.
    fn take(&mut self, name: &str, several: bool) {
        let mut names: Vec<&str> = match several {
            true => self.typed.split(BETWEEN).map(str::trim).filter(|typed| !typed.is_empty()).collect(),
            false => Vec::new(),
        };
        match names.iter().position(|typed| *typed == name) {
            Some(at) => drop(names.remove(at)),
            None => names.push(name),
        }
        self.typed = names.join(BETWEEN);
    }

    /// Enters a folder, takes files, or says what is wrong with `name`.
    fn choose(&mut self, name: &str) -> Answer {
        let path = self.folder.join(name);
        if path.is_dir() {
            self.typed.clear();
            self.enter(path);
            return Answer::Open;
        }
        let reads = matches!(self.question.purpose, Purpose::Open | Purpose::Several);
        let paths: Vec<PathBuf> = if self.question.purpose == Purpose::Several && !path.is_file() {
            let names = name.split(BETWEEN).map(str::trim).filter(|name| !name.is_empty());
            names.map(|name| self.folder.join(name)).collect()
        } else {
            vec![path]
        };
        match paths.iter().find(|path| reads && !path.is_file()) {
            Some(path) => self.complaint = Some(format!("{} does not exist", path.display())),
            None => return Answer::Chosen(paths),
        }
        Answer::Open
    }
}

/// `name` with its ending once: a whole path typed over a selected stem may bring its own.
fn single_ending(name: &str, extensions: &[String]) -> String {
    let shorter = |ending: &String| {
        let once = name.strip_suffix(&format!(".{ending}"))?;
        once.ends_with(&format!(".{ending}")).then(|| once.to_owned())
    };
    extensions.iter().find_map(shorter).unwrap_or_else(|| name.to_owned())
}

/// A name in letters and digits for a file; `otherwise` where it has none.
pub(super) fn file_stem(name: &str, otherwise: &str) -> String {
    let letters = name.chars().map(|c| if c.is_alphanumeric() || c == '-' { c } else { '_' });
    let mut stem = String::new();
    letters.for_each(|letter| {
        if letter != '_' || !stem.ends_with('_') {
            stem.push(letter);
        }
    });
    // A long name ends with a whole word.
    if let Some((end, _)) = stem.char_indices().nth(LONGEST_NAME) {
        let cut = if stem[end..].starts_with('_') { Some(end) } else { stem[..end].rfind('_') };
        stem.truncate(cut.filter(|&cut| cut > 0).unwrap_or(end));
    }
    match stem.trim_matches(['-', '_']) {
        "" => otherwise.to_owned(),
        stem => stem.to_owned(),
    }
}

/// The path of a file of text that was chosen; it ends with `.toml` where no ending was typed.
pub(super) fn with_ending(path: &Path) -> PathBuf {
    if path.extension().is_some() { path.to_path_buf() } else { path.with_extension("toml") }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn folder_lists_folders_first_and_only_the_endings_asked_for() {
        let folder = tempfile::tempdir().unwrap();
        for name in ["b.toml", "a.TOML", "c.csv", ".hidden.toml"] {
            std::fs::write(folder.path().join(name), "").unwrap();
        }
        std::fs::create_dir(folder.path().join("zz")).unwrap();
        let names = |extensions: &[&str]| -> Vec<String> {
            let extensions: Vec<String> = extensions.iter().map(ToString::to_string).collect();
            entries(folder.path(), &extensions).unwrap().into_iter().map(|entry| entry.name).collect()
        };
        assert_eq!(names(&["toml"]), ["zz", "a.TOML", "b.toml"]);
        assert_eq!(names(&[]), ["zz", "a.TOML", "b.toml", "c.csv"]);
        assert!(entries(&folder.path().join("nowhere"), &[]).is_err());
        let toml = ["toml".to_owned()];
        assert_eq!(single_ending("/a/b.toml.toml", &toml), "/a/b.toml");
        assert_eq!(single_ending("b.toml", &toml), "b.toml");
    }

    #[test]
    fn files_state_their_size_and_age() {
        let sizes = [0, 999, 1000, 15_300, 99_960, 4_200_000].map(size);
        assert_eq!(sizes, ["0 B", "999 B", "1.0 kB", "15.3 kB", "100 kB", "4.2 MB"]);
        let folder = tempfile::tempdir().unwrap();
        std::fs::write(folder.path().join("a.csv"), "12345").unwrap();
        let found = entries(folder.path(), &[]).unwrap();
        assert_eq!(found[0].bytes, 5);
        assert_eq!(found[0].age.map(ago).as_deref(), Some("less than a minute ago"));
    }

    #[test]
    fn proposed_names_are_words_joined_once_and_end_with_a_whole_word() {
        assert_eq!(file_stem("Trainer II", "aircraft"), "Trainer_II");
        assert_eq!(file_stem("Flight 3 (left): doublets - ", "session"), "Flight_3_left_doublets");
        assert_eq!(file_stem("???", "session"), "session");
        let title = "Cessna 337F, simulated flight: doublets and 3-2-1-1 at 4,000 ft and 90 kt";
        let stem = file_stem(title, "session");
        assert!(stem.len() <= LONGEST_NAME && !stem.contains("__"), "{stem}");
        assert_eq!(stem, "Cessna_337F_simulated_flight_doublets_and");
    }
}
