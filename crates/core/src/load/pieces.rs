//! A recording that is read in pieces, so that its file and its numbers are not in memory together.

use std::fs::File;
use std::io::{self, Read, Seek, SeekFrom};
use std::path::Path;

use crate::load::error::LoadError;

/// Bytes read at least where one piece follows another, and elsewhere: neighbouring pieces come from one call of the system.
const LEAST_READ: usize = 256 << 10;
const LEAST_APART: usize = 4 << 10;

/// A file of known length and what was read of it last.
pub(crate) struct Pieces<'p> {
    path: &'p Path,
    file: File,
    length: usize,
    /// Place of what was read last.
    at: usize,
    read: Vec<u8>,
    /// Place of the file's cursor.
    cursor: Option<usize>,
    failed: Option<io::Error>,
}

impl<'p> Pieces<'p> {
    /// A file of `length` bytes; what is added to it later is not read.
    pub(crate) fn new(path: &'p Path, file: File, length: usize) -> Self {
        Self { path, file, length, at: 0, read: Vec::new(), cursor: None, failed: None }
    }

    /// Bytes of the file.
    pub(crate) fn len(&self) -> usize {
        self.length
    }

    /// `count` bytes from a place on; `None` where the file ends before or cannot be read, see [`Self::check`].
    pub(crate) fn get(&mut self, at: usize, count: usize) -> Option<&[u8]> {
        let end = at.checked_add(count).filter(|end| *end <= self.length)?;
        let known = self.at..=self.at + self.read.len();
        if at < *known.start() || end > *known.end() {
            let least = if known.contains(&at) { LEAST_READ } else { LEAST_APART };
            let bytes = count.max(least).min(self.length - at);
            if let Err(cause) = self.fill(at, bytes) {
                self.read.clear();
                self.cursor = None;
                self.failed.get_or_insert(cause);
                return None;
            }
        }
        self.read.get(at - self.at..)?.get(..count)
    }

    fn fill(&mut self, at: usize, count: usize) -> io::Result<()> {
        if self.cursor != Some(at) {
            self.file.seek(SeekFrom::Start(at as u64))?;
        }
        // What a large piece took is given back with the next one.
        if self.read.capacity() > count.max(LEAST_READ) {
            self.read = Vec::new();
        }
        self.read.resize(count, 0);
        self.at = at;
        self.file.read_exact(&mut self.read)?;
        self.cursor = Some(at + count);
        Ok(())
    }

    /// Why a piece inside the file was not to be had.
    ///
    /// # Errors
    /// [`LoadError::Open`] with the cause.
    pub(crate) fn check(&mut self) -> Result<(), LoadError> {
        let path = self.path.to_owned();
        self.failed.take().map_or(Ok(()), |cause| Err(LoadError::Open { path, cause }))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn pieces_are_those_of_the_file_in_any_order() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("pieces");
        let bytes: Vec<u8> = (0..3 * LEAST_READ + 7).map(|at| (at % 251) as u8).collect();
        std::fs::write(&path, &bytes).unwrap();
        let mut pieces = Pieces::new(&path, File::open(&path).unwrap(), bytes.len());
        for (at, count) in [(0, 4), (4, LEAST_READ), (10, 3), (2 * LEAST_READ, LEAST_READ + 7), (5, 0), (1, 900_000)] {
            let expected = bytes.get(at..at + count);
            assert_eq!(pieces.get(at, count), expected, "{count} bytes at {at}");
        }
        assert_eq!(pieces.get(bytes.len() - 1, 2), None);
        assert_eq!(pieces.get(usize::MAX, 2), None);
        assert!(pieces.check().is_ok());
        // A file that was cut meanwhile.
        std::fs::write(&path, &bytes[..100]).unwrap();
        assert_eq!(pieces.get(2 * LEAST_READ, 9), None);
        assert!(matches!(pieces.check(), Err(LoadError::Open { .. })));
    }
}
