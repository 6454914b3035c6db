//! How a session names the channel map of a recording.

use std::sync::Arc;

/// The channel map of a recording.
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
pub enum MapRef {
    /// A file, relative to the session file, or `builtin:` and a name.
    File(String),
    /// A map the session itself holds: the text of a channel map file.
    Own(Arc<str>),
}

impl MapRef {
    /// The file, where it is one.
    pub fn file(&self) -> Option<&str> {
        match self {
            Self::File(path) => Some(path),
            Self::Own(_) => None,
        }
    }

    /// Name in messages.
    pub fn name(&self) -> &str {
        self.file().unwrap_or("of the session")
    }
}

impl From<&str> for MapRef {
    fn from(path: &str) -> Self {
        Self::File(path.to_owned())
    }
}
