//! Files that are read whole: sessions, aircraft, maps, listings, tables of earlier results.

use std::io::{self, Read};
use std::path::Path;

/// Most bytes of a file that is read whole; such files have kilobytes.
pub const MOST_BYTES: u64 = 64 << 20;

/// The bytes of a file that people write: neither a pipe nor a device, whose reading may never end, nor one that fills the memory.
///
/// # Errors
/// When it is none or cannot be read; the message does not name it.
pub fn read_bytes(path: &Path) -> io::Result<Vec<u8>> {
    let refused = |text: String| Err(io::Error::new(io::ErrorKind::InvalidInput, text));
    let about = path.metadata()?;
    if about.is_dir() {
        return refused("a folder, not a file: choose a file".to_owned());
    }
    if !about.is_file() {
        return refused("a pipe or a device, not a file: choose a file".to_owned());
    }
    let too_large = |bytes: u64| {
        let (megabytes, most) = (bytes / 1_000_000, MOST_BYTES / 1_000_000);
        refused(format!("size over {megabytes} MB (limit for files written by hand {most} MB): choose another file"))
    };
    if about.len() > MOST_BYTES {
        return too_large(about.len());
    }
    let mut bytes = Vec::new();
    // Some files of the system have more to read than their size.
    std::fs::File::open(path)?.take(MOST_BYTES + 1).read_to_end(&mut bytes)?;
    if bytes.len() as u64 > MOST_BYTES { too_large(bytes.len() as u64) } else { Ok(bytes) }
}

/// The text of a file that people write, as [`read_bytes`].
///
/// # Errors
/// As [`read_bytes`], and when it is no text.
pub fn read_text(path: &Path) -> io::Result<String> {
    String::from_utf8(read_bytes(path)?)
        .map_err(|_| io::Error::new(io::ErrorKind::InvalidData, "binary data, not text: choose another file"))
}

/// Name of a file without its extension, which names the source of a file that has only one.
pub(crate) fn stem(path: &Path) -> String {
    path.file_stem().map_or_else(|| path.display().to_string(), |stem| stem.to_string_lossy().into_owned())
}
