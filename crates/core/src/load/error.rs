//! What can go wrong on the way in: one line each, naming file, channel and fix.

use std::fmt;
use std::path::PathBuf;

use thiserror::Error;

use crate::load::clock::TimeFault;
use crate::load::format::{Format, readable};

/// A recording or channel map could not be taken in.
#[derive(Debug, Error)]
#[expect(missing_docs, reason = "the messages say what variants and fields are")]
pub enum LoadError {
    #[error("{}: {cause}; check the path and the permissions", path.display())]
    Open { path: PathBuf, cause: std::io::Error },
    #[error("{}: empty ({what}); check that the recorder or the copy finished", path.display())]
    Empty { path: PathBuf, what: &'static str },
    #[error("{}: not a recording ({reason}); give {}", path.display(), readable())]
    NotRecognised { path: PathBuf, reason: String },
    #[error("{}: {format} file cut off at byte {at}: {what} needs {needed} bytes, {left} are left; copy it again", path.display())]
    Truncated { path: PathBuf, format: Format, at: usize, what: &'static str, needed: u64, left: u64 },
    #[error("{}: damaged {format} file, {what}; copy it again or export it again", path.display())]
    Damaged { path: PathBuf, format: Format, what: String },
    #[error("{}: {format} file too large when unpacked: {what} (limit {budget_mb} MB); export fewer channels or a shorter part, or set DOUBLET_UNPACK_MB to more", path.display())]
    TooLarge { path: PathBuf, format: Format, what: String, budget_mb: u64 },
    #[error("{}: {what} is not read; {fix}", path.display())]
    Unsupported { path: PathBuf, what: String, fix: &'static str },
    #[error("{}: time channel '{channel}' of source '{source_name}' {fault}; {fix}", path.display())]
    Time { path: PathBuf, source_name: String, channel: String, fault: TimeFault, fix: Box<str> },
    #[error("channel map{}, line {line}: {what}", path.as_ref().map(|path| format!(" {}", path.display())).unwrap_or_default())]
    Map { path: Option<PathBuf>, line: usize, what: String },
    #[error("names file{}, line {line}: {what}", path.as_ref().map(|path| format!(" {}", path.display())).unwrap_or_default())]
    Names { path: Option<PathBuf>, line: usize, what: String },
    /// The plan has problems that make reading pointless.
    #[error("{}", join(problems))]
    Plan { problems: Vec<Problem> },
}

fn join(problems: &[Problem]) -> String {
    let errors: Vec<String> = problems.iter().filter(|problem| problem.is_error).map(ToString::to_string).collect();
    errors.join(" | ")
}

/// Something that stands between a recording and its roles.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Problem {
    /// Whether reading is refused because of it; otherwise it is a warning.
    pub is_error: bool,
    /// What, where and what to do, in one line.
    pub text: String,
}

impl fmt::Display for Problem {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.text)
    }
}
