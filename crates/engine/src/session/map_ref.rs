//! How a session names the channel map of a recording.

use std::sync::Arc;

use serde::{Deserialize, Serialize};

/// The channel map of a recording.
#[derive(Clone, Debug, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[serde(from = "MapTable", into = "MapTable")]
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

/// Saved form: a path, or the map in full.
#[derive(Serialize, Deserialize)]
#[serde(untagged)]
enum MapTable {
    File(String),
    Own(toml::Table),
}

impl From<MapTable> for MapRef {
    fn from(table: MapTable) -> Self {
        match table {
            MapTable::File(path) => Self::File(path),
            MapTable::Own(map) => Self::Own(map.to_string().into()),
        }
    }
}

/// A map the session holds was parsed before; what is no TOML is written as a path, so that its error names it.
impl From<MapRef> for MapTable {
    fn from(map: MapRef) -> Self {
        match map {
            MapRef::File(path) => Self::File(path),
            MapRef::Own(text) => text.parse().map_or_else(|_| Self::File(text.to_string()), Self::Own),
        }
    }
}

impl From<&str> for MapRef {
    fn from(path: &str) -> Self {
        Self::File(path.to_owned())
    }
}
