//! The file in which the rows of a source are kept.

use std::collections::BTreeSet;
use std::fs::{File, OpenOptions};
use std::io::{self, ErrorKind};
use std::path::{Path, PathBuf};
use std::sync::Arc;

use doublet_core::load::stream::{StreamChannel, StreamRow};

use crate::keep;

/// Longest name of a file without its ending, bytes: what is written beside it has a longer one.
const LONGEST_NAME: usize = 100;

pub(super) struct SourceFile {
    pub(super) source: Arc<str>,
    pub(super) channels: Arc<[StreamChannel]>,
    pub(super) path: PathBuf,
    writer: csv::Writer<File>,
    pub(super) rows: u64,
    /// Earliest and latest stamp, s.
    pub(super) first_s: f64,
    pub(super) last_s: f64,
    /// Whether every row has a later time than the one before.
    pub(super) is_in_order: bool,
}

impl SourceFile {
    /// A new file with the header of this row.
    pub(super) fn new(path: PathBuf, row: &StreamRow) -> io::Result<Self> {
        let mut writer = csv::Writer::from_writer(OpenOptions::new().write(true).create_new(true).open(&path)?);
        writer.write_record(header(&row.channels))?;
        let (source, channels) = (Arc::clone(&row.source), Arc::clone(&row.channels));
        let (first_s, last_s) = (f64::INFINITY, f64::NEG_INFINITY);
        Ok(Self { source, channels, path, writer, rows: 0, first_s, last_s, is_in_order: true })
    }

    /// Adds a row, whose channels may be more than those so far.
    pub(super) fn write(&mut self, row: &StreamRow, stamp_s: f64) -> io::Result<()> {
        if row.channels.len() > self.channels.len() {
            self.widen(&row.channels)?;
        }
        self.is_in_order &= stamp_s.is_nan() || stamp_s > self.last_s;
        self.rows += 1;
        (self.first_s, self.last_s) = (self.first_s.min(stamp_s), self.last_s.max(stamp_s));
        let cell = |at: usize| row.values.get(at).filter(|value| !value.is_nan()).map(f64::to_string);
        self.writer.write_record((0..self.channels.len()).map(|at| cell(at).unwrap_or_default()))?;
        Ok(())
    }

    /// Puts a file with more channels and the rows so far in its place: at any instant the old one or the new one is there, whole.
    fn widen(&mut self, channels: &Arc<[StreamChannel]>) -> io::Result<()> {
        self.writer.flush()?;
        let mut wider = csv::Writer::from_writer(Vec::new());
        wider.write_record(header(channels))?;
        let mut rows = csv::ReaderBuilder::new().from_path(&self.path)?;
        for row in rows.records() {
            let mut row = row?;
            (row.len()..channels.len()).for_each(|_| row.push_field(""));
            wider.write_record(&row)?;
        }
        keep::replace(&self.path, &wider.into_inner().map_err(csv::IntoInnerError::into_error)?)?;
        self.writer = csv::Writer::from_writer(OpenOptions::new().append(true).open(&self.path)?);
        self.channels = Arc::clone(channels);
        Ok(())
    }

    /// Sends what was written to the disk; fails where the file is gone.
    pub(super) fn flush(&mut self) -> io::Result<()> {
        self.writer.flush()?;
        self.path.metadata().map(drop)
    }

    /// Has the disk keep the rows and the name of the file through a loss of power.
    pub(super) fn sync(&self) -> io::Result<()> {
        self.writer.get_ref().sync_all()?;
        keep::sync_folder_of(&self.path)
    }
}

fn header(channels: &[StreamChannel]) -> impl Iterator<Item = String> {
    channels.iter().map(|channel| match &channel.unit {
        Some(unit) => format!("{} [{unit}]", channel.name),
        None => channel.name.clone(),
    })
}

/// The name of a source as that of a file: other letters than those of every file system replaced, cut, and unlike those in `taken`, also
/// where capitals count as small letters.
pub(super) fn name_file(source: &str, taken: &BTreeSet<String>) -> String {
    let plain = |letter: char| if letter.is_alphanumeric() || "-_.".contains(letter) { letter } else { '_' };
    let cut = |text: &str, most: usize| text[..text.floor_char_boundary(most)].to_owned();
    let name = cut(&source.chars().map(plain).collect::<String>(), LONGEST_NAME);
    let name = if name.trim_matches('.').is_empty() { "source".to_owned() } else { name };
    let is_free = |name: &String| taken.iter().all(|other| other.to_lowercase() != name.to_lowercase());
    let numbered = |number: usize| format!("{name}_{number}");
    std::iter::once(name.clone()).chain((2..).map(numbered)).find(is_free).unwrap_or_default()
}

/// What happened to a file and what to do, in one line.
pub(super) fn describe_error(path: &Path, error: &io::Error) -> String {
    let fix = match error.kind() {
        ErrorKind::StorageFull | ErrorKind::QuotaExceeded | ErrorKind::FileTooLarge => "free disk space",
        ErrorKind::InvalidFilename | ErrorKind::InvalidInput => "give the source a shorter name",
        ErrorKind::NotFound => "keep the folder while it is recorded into",
        ErrorKind::PermissionDenied | ErrorKind::ReadOnlyFilesystem => "record into a folder that you may write",
        ErrorKind::AlreadyExists => "record into a new folder",
        _ => "record to another disk",
    };
    format!("{}: {error}: {fix}", path.display())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn row(names: &[&str], values: &[f64]) -> StreamRow {
        let channel = |name: &&str| StreamChannel { name: (*name).to_owned(), unit: None };
        let channels = names.iter().map(channel).collect::<Vec<_>>().into();
        StreamRow { source: "stream".into(), channels, values: values.to_vec() }
    }

    #[test]
    fn names_of_files_are_cut_and_differ_also_without_capitals() {
        let mut taken = BTreeSet::new();
        let long = "ä".repeat(300);
        let names = ["gps/1", "gps_1", "GPS_1", "", "..", &long, &long].map(|source| {
            let name = name_file(source, &taken);
            taken.insert(name.clone());
            name
        });
        let cut = "ä".repeat(50);
        let expected = ["gps_1", "gps_1_2", "GPS_1_3", "source", "source_2", &cut, &format!("{cut}_2")];
        assert_eq!(names.each_ref().map(String::as_str), expected);
    }

    /// A second name of the old file shows what a program that is killed meanwhile leaves.
    #[test]
    fn a_new_channel_leaves_the_old_file_whole_until_the_new_one_is_there() {
        let folder = tempfile::tempdir().unwrap();
        let (path, second) = (folder.path().join("stream.csv"), folder.path().join("before.csv"));
        let mut file = SourceFile::new(path.clone(), &row(&["time", "p"], &[])).unwrap();
        (0..2000).for_each(|k| file.write(&row(&["time", "p"], &[f64::from(k), 0.5]), f64::from(k)).unwrap());
        std::fs::hard_link(&path, &second).unwrap();
        file.write(&row(&["time", "p", "q"], &[2000.0, 0.5, 0.25]), 2000.0).unwrap();
        file.flush().unwrap();
        let before = std::fs::read_to_string(second).unwrap();
        assert_eq!((before.lines().count(), before.lines().last()), (2001, Some("1999,0.5")));
        let after = std::fs::read_to_string(path).unwrap();
        assert_eq!((after.lines().count(), after.lines().next()), (2002, Some("time,p,q")));
        assert_eq!(after.lines().skip(2000).collect::<Vec<_>>(), ["1999,0.5,", "2000,0.5,0.25"]);
    }
}
