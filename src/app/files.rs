//! Asking for a file: the system's dialog off the drawing thread, our own where the system has none.

use std::path::{Path, PathBuf};
use std::sync::mpsc::{Receiver, TryRecvError, channel};

use eframe::egui::text::{CCursor, CCursorRange};
use eframe::egui::{self, Align, Layout, ScrollArea, TextEdit};

/// What a file is wanted for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Purpose {
    /// Read an existing file.
    Open,
    /// Read an existing folder.
    Folder,
    /// Write a file.
    Save,
}

/// A question for a file.
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
}

/// One line of a folder.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct Entry {
    /// Files after folders.
    pub is_file: bool,
    /// Name in the folder.
    pub name: String,
}

/// Folders and files of `folder` that end in one of `extensions`, hidden ones left out.
///
/// # Errors
/// When the folder cannot be read.
pub fn entries(folder: &Path, extensions: &[String]) -> std::io::Result<Vec<Entry>> {
    let mut found = Vec::new();
    for entry in std::fs::read_dir(folder)? {
        let path = entry?.path();
        let Some(name) = path.file_name().and_then(|name| name.to_str()) else { continue };
        let is_file = !path.is_dir();
        let ending = path.extension().and_then(|ending| ending.to_str()).unwrap_or_default();
        let offered = extensions.is_empty() || extensions.iter().any(|wanted| wanted.eq_ignore_ascii_case(ending));
        if !name.starts_with('.') && (!is_file || offered) {
            found.push(Entry { is_file, name: name.to_owned() });
        }
    }
    found.sort();
    Ok(found)
}

/// Frames in which a new dialog asks for the keyboard.
const FRAMES_TO_FOCUS: u8 = 3;

/// The dialog of the workbench itself.
struct OwnDialog {
    question: FileQuestion,
    folder: PathBuf,
    entries: Vec<Entry>,
    typed: String,
    complaint: Option<String>,
    /// Frames in which the field still asks for the keyboard: another dialog may hold it at first.
    to_focus: u8,
}

/// What a dialog came to.
enum Answer {
    Open,
    Chosen(PathBuf),
    GivenUp,
}

/// How the question is being put. A dialog of the system takes the keyboard from the window: an answer of none before that means
/// that the system has no dialog.
enum Asking {
    System { question: FileQuestion, shown: bool, answer: Receiver<Option<PathBuf>> },
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

    /// Draws the dialog where it is ours; the file once one is chosen.
    pub fn show(&mut self, ctx: &egui::Context) -> Option<PathBuf> {
        match self.asking.take()? {
            Asking::System { question, shown, answer } => match answer.try_recv() {
                Ok(Some(path)) => return Some(path),
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
                Answer::Chosen(path) => return Some(path),
                Answer::GivenUp => {}
            },
        }
        None
    }
}

/// Asks the system in a thread of its own.
fn ask_system(question: &FileQuestion, ctx: &egui::Context) -> Option<Receiver<Option<PathBuf>>> {
    let (send, receive) = channel();
    let (question, ctx) = (question.clone(), ctx.clone());
    let ask = move || {
        let mut dialog = rfd::FileDialog::new().set_title(&question.title).set_directory(&question.folder);
        if !question.extensions.is_empty() {
            dialog = dialog.add_filter(question.extensions.join(", "), &question.extensions);
        }
        let path = match question.purpose {
            Purpose::Open => dialog.pick_file(),
            Purpose::Folder => dialog.pick_folder(),
            Purpose::Save => dialog.set_file_name(&question.name).save_file(),
        };
        // The question may have been forgotten meanwhile; then nobody listens.
        let _ = send.send(path);
        ctx.request_repaint();
    };
    std::thread::Builder::new().name("file dialog".to_owned()).spawn(ask).ok().map(|_| receive)
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
            complaint: None,
            to_focus: FRAMES_TO_FOCUS,
        };
        dialog.enter(folder);
        dialog
    }

    /// Shows another folder, or says why not.
    fn enter(&mut self, folder: PathBuf) {
        match entries(&folder, &self.question.extensions) {
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
            ui.set_width(560.0);
            ui.heading(&self.question.title);
            ui.add_space(4.0);
            answer = self.contents(ui);
        });
        if ctx.input(|i| i.key_pressed(egui::Key::Escape)) { Answer::GivenUp } else { answer }
    }

    fn contents(&mut self, ui: &mut egui::Ui) -> Answer {
        ui.horizontal(|ui| {
            let parent = self.folder.parent().map(Path::to_path_buf);
            if ui.add_enabled(parent.is_some(), egui::Button::new("Up")).clicked() {
                parent.into_iter().for_each(|parent| self.enter(parent));
            }
            ui.add(egui::Label::new(self.folder.display().to_string()).truncate());
        });
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
                Purpose::Open => "Open",
                Purpose::Folder => "Use this folder",
                Purpose::Save => "Save",
            };
            let here = self.question.purpose == Purpose::Folder;
            let pressed = ui.add_enabled(here || !self.typed.trim().is_empty(), egui::Button::new(action)).clicked();
            if here && (pressed || (confirmed && self.typed.trim().is_empty())) {
                answer = Answer::Chosen(self.folder.join(self.typed.trim()));
                return;
            }
            if ui.button("Cancel").clicked() {
                answer = Answer::GivenUp;
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
        let height = ui.spacing().interact_size.y;
        ScrollArea::vertical().max_height(300.0).auto_shrink(false).show_rows(
            ui,
            height,
            self.entries.len(),
            |ui, rows| {
                ui.with_layout(Layout::top_down_justified(Align::LEFT), |ui| {
                    for entry in &self.entries[rows] {
                        let name = if entry.is_file { entry.name.clone() } else { format!("{}/", entry.name) };
                        let chosen = entry.is_file && self.typed == entry.name;
                        let row = ui.selectable_label(chosen, name);
                        if row.clicked() && entry.is_file {
                            self.typed.clone_from(&entry.name);
                        }
                        if (row.clicked() && !entry.is_file) || row.double_clicked() {
                            enter = Some(entry.name.clone());
                        }
                    }
                });
            },
        );
        enter
    }

    /// Enters a folder, takes a file, or says what is wrong with `name`.
    fn choose(&mut self, name: &str) -> Answer {
        let path = self.folder.join(name);
        if path.is_dir() {
            self.typed.clear();
            self.enter(path);
        } else if self.question.purpose == Purpose::Open && !path.is_file() {
            self.complaint = Some(format!("{} does not exist", path.display()));
        } else {
            return Answer::Chosen(path);
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
}
