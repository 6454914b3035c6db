//! The session being worked on: its history, its file, the folder its paths start from.

use std::path::{Path, PathBuf};

use doublet_engine::builtin;
use doublet_engine::session::{self, Session};
use doublet_engine::undo::History;

/// The session that opens by default.
const SHIPPED: &str = "demo";

/// A session with its past and its place on disk.
pub struct Document {
    /// The session now and before.
    pub history: History,
    /// Its file; `None` for what comes with the program, until it is saved.
    pub path: Option<PathBuf>,
    /// Folder its relative paths start from.
    pub folder: PathBuf,
}

impl Document {
    /// Opens a session file.
    ///
    /// # Errors
    /// One line: the file and what is wrong with it.
    pub fn open(path: &Path) -> Result<Self, String> {
        let opened = session::open(path).map_err(|error| in_one_line(path, &error.to_string()))?;
        Ok(Self { history: History::new(opened.session), path: Some(opened.path), folder: opened.folder })
    }

    /// The session that comes with the program.
    ///
    /// # Errors
    /// One line, should it not be readable.
    pub fn shipped() -> Result<Self, String> {
        let text = builtin::session(SHIPPED).ok_or("no session comes with this program")?;
        let session = session::parse(text).map_err(|error| error.to_string())?;
        Ok(Self { history: History::new(session), path: None, folder: std::env::current_dir().unwrap_or_default() })
    }

    /// The session as it is now.
    pub fn session(&self) -> &Session {
        self.history.present()
    }

    /// Saves to `path`, which becomes the session's file. Relative paths of recordings, aircraft and channel maps keep
    /// meaning the same files.
    ///
    /// # Errors
    /// One line when the file cannot be written.
    pub fn save(&mut self, path: &Path) -> Result<(), String> {
        let folder = path.parent().map_or_else(PathBuf::new, Path::to_path_buf);
        let moved = absolute(&folder) != absolute(&self.folder);
        if moved {
            let (old, new) = (absolute(&self.folder), absolute(&folder));
            let session = doublet_engine::session::rebased(self.session(), &old, &new);
            session::save(&session, path).map_err(|error| in_one_line(path, &error.to_string()))?;
            self.history.replace_all(|session| doublet_engine::session::rebased(session, &old, &new));
        } else {
            session::save(self.session(), path).map_err(|error| in_one_line(path, &error.to_string()))?;
        }
        self.history.mark_saved();
        self.path = Some(path.to_path_buf());
        self.folder = folder;
        Ok(())
    }

    /// Title of the window: file, and a dot while there is something to save.
    pub fn title(&self) -> String {
        let name = self.path.as_deref().and_then(Path::file_name).and_then(|name| name.to_str());
        let mark = if self.history.is_modified() { "• " } else { "" };
        format!("{mark}{} – doublet", name.unwrap_or(self.session().title.as_str()))
    }
}

/// `message` with its file named once, without line breaks.
fn in_one_line(path: &Path, message: &str) -> String {
    let place = path.display().to_string();
    let message = message.lines().map(str::trim).collect::<Vec<_>>().join(" ");
    if message.contains(&place) { message } else { format!("{place}: {message}") }
}

/// `path` from the root; as it is where the system cannot say.
fn absolute(path: &Path) -> PathBuf {
    let path = if path.as_os_str().is_empty() { Path::new(".") } else { path };
    path.canonicalize().or_else(|_| std::path::absolute(path)).unwrap_or_else(|_| path.to_path_buf())
}
