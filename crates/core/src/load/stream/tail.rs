//! A text file that grows.

use std::fs::{File, Metadata};
use std::io::{Read, Seek, SeekFrom};
use std::path::{Path, PathBuf};

use crate::load::error::LoadError;
use crate::load::file::stem;

use super::text::TextDecoder;
use crate::load::row::StreamRow;

/// Bytes read at once.
const PIECE: usize = 256 * 1024;

/// A text file read as it grows, each byte once.
#[derive(Debug)]
pub struct TailedFile {
    path: PathBuf,
    file: File,
    /// Bytes read.
    at: u64,
    decoder: TextDecoder,
    /// Bytes that could not be understood before the file became another.
    refused_before: usize,
    piece: Vec<u8>,
    /// How often it became shorter than it was, and was read from its start again.
    pub restarts: usize,
}

impl TailedFile {
    /// Opens the file at `path`, which may be empty yet.
    ///
    /// # Errors
    /// When it cannot be opened.
    pub fn open(path: &Path) -> Result<Self, LoadError> {
        let file = File::open(path).map_err(|cause| LoadError::Open { path: path.to_owned(), cause })?;
        let decoder = TextDecoder::new(&stem(path));
        Ok(Self { path: path.to_owned(), file, at: 0, decoder, refused_before: 0, piece: vec![0; PIECE], restarts: 0 })
    }

    /// Adds the rows of the next piece; whether there was anything.
    ///
    /// # Errors
    /// When it cannot be read.
    pub fn poll(&mut self, rows: &mut Vec<StreamRow>) -> Result<bool, LoadError> {
        let path = self.path.clone();
        let failed = |cause| LoadError::Open { path: path.clone(), cause };
        if self.file.metadata().map_err(failed)?.len() < self.at {
            self.file.seek(SeekFrom::Start(0)).map_err(failed)?;
            self.at = 0;
            self.begin_anew(rows);
        }
        let mut read = self.file.read(&mut self.piece).map_err(failed)?;
        // The file was read to its end; another in its place is read from its start.
        if read == 0 && self.is_replaced() {
            self.file = File::open(&self.path).map_err(failed)?;
            self.at = 0;
            self.begin_anew(rows);
            read = self.file.read(&mut self.piece).map_err(failed)?;
        }
        self.at += read as u64;
        self.decoder.push(&self.piece[..read], rows);
        Ok(read > 0)
    }

    /// The text begins anew: what was refused so far stays counted.
    fn begin_anew(&mut self, rows: &mut Vec<StreamRow>) {
        self.decoder.finish(rows);
        self.refused_before += self.decoder.refused_bytes;
        self.decoder = TextDecoder::new(&stem(&self.path));
        self.restarts += 1;
    }

    /// Whether another file has its name now.
    fn is_replaced(&self) -> bool {
        let (open, named) = (self.file.metadata(), self.path.metadata());
        open.is_ok_and(|open| named.is_ok_and(|named| !is_same(&open, &named)))
    }

    /// Nothing comes any more: adds what a short file holds.
    pub fn finish(&mut self, rows: &mut Vec<StreamRow>) {
        self.decoder.finish(rows);
    }

    /// Bytes that could not be understood, those before restarts included.
    pub fn refused_bytes(&self) -> usize {
        self.refused_before + self.decoder.refused_bytes
    }
}

#[cfg(unix)]
fn is_same(one: &Metadata, other: &Metadata) -> bool {
    use std::os::unix::fs::MetadataExt;
    (one.dev(), one.ino()) == (other.dev(), other.ino())
}

#[cfg(not(unix))]
fn is_same(one: &Metadata, other: &Metadata) -> bool {
    match (one.created(), other.created()) {
        (Ok(one), Ok(other)) => one == other,
        _ => true,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn refused_bytes_stay_counted_when_the_file_is_shortened_or_replaced() {
        let folder = tempfile::tempdir().unwrap();
        let (path, other) = (folder.path().join("log.csv"), folder.path().join("other.csv"));
        let no_table = "no table in this line\n".repeat(4000);
        let table: String = (0..20).fold("time,p\n".to_owned(), |text, k| format!("{text}{k},0.5\n"));
        std::fs::write(&path, &no_table).unwrap();
        let (mut tail, mut rows) = (TailedFile::open(&path).unwrap(), Vec::new());
        while tail.poll(&mut rows).unwrap() {}
        assert_eq!((rows.len(), tail.refused_bytes(), tail.restarts), (0, no_table.len(), 0));
        std::fs::write(&path, &table).unwrap();
        while tail.poll(&mut rows).unwrap() {}
        assert_eq!((rows.len(), tail.refused_bytes(), tail.restarts), (20, no_table.len(), 1));
        std::fs::write(&other, &no_table).unwrap();
        std::fs::rename(&other, &path).unwrap();
        while tail.poll(&mut rows).unwrap() {}
        assert_eq!((rows.len(), tail.refused_bytes(), tail.restarts), (20, 2 * no_table.len(), 2));
    }
}
