//! Identity of the files a session names.

use std::path::Path;

use crate::graph::{Key, KeyBuilder};
use crate::session;
use crate::stage;

/// Identity of a flight's files by path, size and time of change: reading them again to hash them would cost more than it saves.
pub fn files_key(folder: &Path, flight: &session::Flight) -> Key {
    let mut key = KeyBuilder::new("files", 1).parameters(&flight.recordings);
    for entry in &flight.recordings {
        for path in std::iter::once(entry.path.as_str()).chain(entry.channel_map.file()) {
            let Ok(place) = stage::locate(folder, path) else { continue };
            for file in stage::files(&place) {
                let metadata = std::fs::metadata(&file);
                let changed = metadata.as_ref().ok().and_then(|m| m.modified().ok());
                key = key.parameters(&(file, metadata.map(|m| m.len()).ok(), changed));
            }
        }
    }
    key.finish()
}
