//! What can go wrong on the way in: one line each, naming file, channel and fix.

use std::fmt;
use std::path::PathBuf;

use thiserror::Error;

use crate::load::clock::TimeFault;
use crate::load::format::{Format, readable};

/// A recording or channel map could not be taken in.
#[derive(Debug, Error)]
pub enum LoadError {
    /// The file or folder could not be opened or read.
    #[error("{}: {cause}; check the path and the permissions", path.display())]
    Open {
        /// File or folder.
        path: PathBuf,
        /// What the operating system said.
        cause: std::io::Error,
    },
    /// The file holds no bytes, or no numbers.
    #[error("{}: empty ({what}); check that the recorder or the copy finished", path.display())]
    Empty {
        /// File or folder.
        path: PathBuf,
        /// What was looked for.
        what: &'static str,
    },
    /// The content belongs to no format that is read.
    #[error("{}: not a recording ({reason}); give {}", path.display(), readable())]
    NotRecognised {
        /// File.
        path: PathBuf,
        /// What gave it away.
        reason: String,
    },
    /// The file ends before what it promises.
    #[error("{}: {format} file cut off at byte {at}: {what} needs {needed} bytes, {left} are left; copy it again", path.display())]
    Truncated {
        /// File.
        path: PathBuf,
        /// Its format.
        format: Format,
        /// Offset into the file, or into its decompressed variable.
        at: usize,
        /// What was being read.
        what: &'static str,
        /// Bytes it needs.
        needed: u64,
        /// Bytes there are.
        left: u64,
    },
    /// The content contradicts its format.
    #[error("{}: damaged {format} file, {what}; copy it again or export it again", path.display())]
    Damaged {
        /// File.
        path: PathBuf,
        /// Its format.
        format: Format,
        /// What is wrong and where.
        what: String,
    },
    /// The content is valid and needs more memory than a recording may take.
    #[error("{}: {format} file too large when unpacked: {what} (limit {budget_mb} MB); export fewer channels or a shorter part, or set DOUBLET_UNPACK_MB to more", path.display())]
    TooLarge {
        /// File.
        path: PathBuf,
        /// Its format.
        format: Format,
        /// What would take more.
        what: String,
        /// What it may take, in megabytes.
        budget_mb: u64,
    },
    /// The content is valid but of a kind that is not read.
    #[error("{}: {what} is not read; {fix}", path.display())]
    Unsupported {
        /// File.
        path: PathBuf,
        /// What was met.
        what: String,
        /// What to do instead.
        fix: &'static str,
    },
    /// The time vector of a source is not strictly increasing.
    #[error("{}: time channel '{channel}' of source '{source_name}' {fault}; {fix}", path.display())]
    Time {
        /// File.
        path: PathBuf,
        /// Source the time belongs to.
        source_name: String,
        /// Time channel.
        channel: String,
        /// What is wrong, with index and time.
        fault: TimeFault,
        /// What to do.
        fix: Box<str>,
    },
    /// A channel map could not be understood.
    #[error("channel map{}, line {line}: {what}", path.as_ref().map(|path| format!(" {}", path.display())).unwrap_or_default())]
    Map {
        /// File, when it was read from one.
        path: Option<PathBuf>,
        /// Line, from 1.
        line: usize,
        /// What is wrong and what would be right.
        what: String,
    },
    /// A file of names could not be understood.
    #[error("names file{}, line {line}: {what}", path.as_ref().map(|path| format!(" {}", path.display())).unwrap_or_default())]
    Names {
        /// File, when it was read from one.
        path: Option<PathBuf>,
        /// Line, from 1.
        line: usize,
        /// What is wrong and what would be right.
        what: String,
    },
    /// The plan has problems that make reading pointless.
    #[error("{}", join(problems))]
    Plan {
        /// Every problem, errors and warnings.
        problems: Vec<Problem>,
    },
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
