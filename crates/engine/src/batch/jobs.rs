//! The runs of a batch: every session of a folder, every combination of a sweep.

use std::path::{Path, PathBuf};

use serde::Deserialize;

use super::sweep::{self, Sweep};
use crate::graph::{Key, KeyBuilder};
use crate::session::{self, Session};

/// One run.
#[derive(Clone, Debug)]
pub struct BatchJob {
    /// Session or sweep it comes from, by file name.
    pub name: String,
    /// Settings swept and their values, in the order of the sweep; empty for a session as it is.
    pub settings: Vec<(String, String)>,
    /// The session, or why there is none.
    pub session: Result<Session, String>,
    /// Folder its relative paths start from.
    pub folder: PathBuf,
    /// Identity by content: the session and the program. The files it reads are known once it ran, see [`super::Finished`].
    pub(super) key: Key,
}

/// Any file of a batch, by its first key.
#[derive(Deserialize)]
struct Header {
    #[serde(default)]
    format: String,
}

/// The runs of `path`: a session, a sweep, or a folder of both, in the order of their names.
///
/// # Errors
/// One line when nothing is there, a sweep cannot be understood, or it varies what the session cannot have. A session that cannot be
/// read is a run that fails.
pub fn jobs(path: &Path) -> Result<Vec<BatchJob>, String> {
    let named = |error: &dyn std::fmt::Display| format!("{}: {error}", path.display());
    let mut files = vec![path.to_path_buf()];
    if path.is_dir() {
        let entries = std::fs::read_dir(path).map_err(|error| named(&error))?;
        files =
            entries.map(|entry| entry.map(|entry| entry.path())).collect::<Result<_, _>>().map_err(|e| named(&e))?;
        files.retain(|file| file.extension().is_some_and(|ending| ending == "toml") && file.is_file());
        files.sort();
    }
    let mut jobs = Vec::new();
    for file in files {
        let text = doublet_core::load::read_text(&file).map_err(|error| format!("{}: {error}", file.display()))?;
        let format = toml::from_str::<Header>(&text).map_or_else(|_| String::new(), |header| header.format);
        let name = file.file_name().unwrap_or_default().to_string_lossy().into_owned();
        if format == sweep::FORMAT {
            let sweep = Sweep::parse(&text).map_err(|error| format!("{}: {error}", file.display()))?;
            let folder = file.parent().unwrap_or(Path::new("")).to_path_buf();
            let opened = session::open(&folder.join(&sweep.session))
                .map_err(|error| format!("{}: {}: {error}", file.display(), sweep.session))?;
            sweep.check(&opened.session).map_err(|error| format!("{}: {error}", file.display()))?;
            for (settings, session) in sweep.sessions(&opened.session) {
                jobs.push(BatchJob::new(name.clone(), settings, session, opened.folder.clone()));
            }
        } else if format == session::FORMAT || !path.is_dir() {
            let folder = file.parent().unwrap_or(Path::new("")).to_path_buf();
            let session = session::parse(&text).map_err(|error| error.to_string());
            jobs.push(BatchJob::new(name, Vec::new(), session, folder));
        }
    }
    if jobs.is_empty() {
        return Err(named(&"no session and no sweep is here"));
    }
    Ok(jobs)
}

impl BatchJob {
    fn new(name: String, settings: Vec<(String, String)>, session: Result<Session, String>, folder: PathBuf) -> Self {
        let place = folder.canonicalize().unwrap_or_else(|_| folder.clone());
        let text = session.as_ref().map(|session| session::print(session).map_err(|error| error.to_string()));
        let key = KeyBuilder::new("batch").program().with(&name).with(&settings).with(&place).with(&text).finish();
        Self { name, settings, session, folder, key }
    }
}
