//! All rows kept as they came, and the session made of them.

use std::collections::BTreeMap;
use std::fs::File;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use doublet_core::load::stream::{StreamChannel, StreamRow};
use doublet_core::load::{ChannelMap, plan_all};

use crate::begin::{self, add_flight, empty_session};
use crate::run::Control;
use crate::session::{self, MapRef, Session};

/// Name of the session in its folder.
const SESSION: &str = "session.toml";
/// Name of the channel map in it, for a recording that was never finished.
const MAP: &str = "channel_map.toml";
/// Name of the flight in it.
const FLIGHT: &str = "live";

/// Writes the rows of every source into a file of its own in a new folder.
pub struct Recorder {
    folder: PathBuf,
    files: BTreeMap<Arc<str>, SourceFile>,
}

/// File of one source.
struct SourceFile {
    channels: Arc<[StreamChannel]>,
    path: PathBuf,
    writer: csv::Writer<File>,
    /// How many files the source has: a new one begins where a channel is added.
    part: usize,
}

impl Recorder {
    /// Into `folder`, which must not exist, with the text of the channel map that reads it.
    ///
    /// # Errors
    /// One line when it exists or cannot be made.
    pub fn new(folder: &Path, map: &str) -> Result<Self, String> {
        if folder.exists() {
            return Err(format!(
                "{} exists: choose another folder, a recording is never overwritten",
                folder.display()
            ));
        }
        std::fs::create_dir_all(folder).map_err(|error| format!("{}: {error}", folder.display()))?;
        std::fs::write(folder.join(MAP), map).map_err(|error| format!("{}: {error}", folder.join(MAP).display()))?;
        Ok(Self { folder: folder.to_owned(), files: BTreeMap::new() })
    }

    /// Writes rows.
    ///
    /// # Errors
    /// One line when the disk does not take them.
    pub fn write(&mut self, rows: &[StreamRow]) -> Result<(), String> {
        for row in rows {
            let known = self.files.get(&row.source);
            if known.is_none_or(|file| file.channels.len() != row.channels.len()) {
                let part = known.map_or(1, |file| file.part + 1);
                let file = self.file(row, part)?;
                self.files.insert(Arc::clone(&row.source), file);
            }
            let Some(file) = self.files.get_mut(&row.source) else { continue };
            let cells = row.values.iter().map(|value| if value.is_nan() { String::new() } else { value.to_string() });
            file.writer.write_record(cells).map_err(|error| format!("{}: {error}", file.path.display()))?;
        }
        Ok(())
    }

    /// A file for the rows of a source, with its header. One whose channels have grown replaces the one before, whose rows are copied.
    fn file(&mut self, row: &StreamRow, part: usize) -> Result<SourceFile, String> {
        let plain: String = row
            .source
            .chars()
            .map(|letter| if letter.is_alphanumeric() || "-_.".contains(letter) { letter } else { '_' })
            .collect();
        let path = self.folder.join(format!("{plain}.csv"));
        let named = |error: &dyn std::fmt::Display| format!("{}: {error}", path.display());
        let before = match self.files.remove(&row.source) {
            Some(mut file) => {
                file.writer.flush().map_err(|error| named(&error))?;
                std::fs::read_to_string(&path).map_err(|error| named(&error))?
            }
            None => String::new(),
        };
        let file = File::create(&path).map_err(|error| named(&error))?;
        let mut writer = csv::Writer::from_writer(file);
        let header = row.channels.iter().map(|channel| match &channel.unit {
            Some(unit) => format!("{} [{unit}]", channel.name),
            None => channel.name.clone(),
        });
        writer.write_record(header).map_err(|error| named(&error))?;
        let mut earlier = csv::ReaderBuilder::new().has_headers(true).from_reader(before.as_bytes());
        for record in earlier.records() {
            let mut record = record.map_err(|error| named(&error))?;
            (record.len()..row.channels.len()).for_each(|_| record.push_field(""));
            writer.write_record(&record).map_err(|error| named(&error))?;
        }
        Ok(SourceFile { channels: Arc::clone(&row.channels), path, writer, part })
    }

    /// Sends what was written to the disk.
    ///
    /// # Errors
    /// One line when the disk does not take it.
    pub fn flush(&mut self) -> Result<(), String> {
        for file in self.files.values_mut() {
            file.writer.flush().map_err(|error| format!("{}: {error}", file.path.display()))?;
        }
        Ok(())
    }

    /// Ends the recording and writes a session of it, read by the map of this text, with the settings of `like`; its path.
    ///
    /// # Errors
    /// One line when nothing was recorded or it cannot be read by the map.
    pub fn finish(mut self, map: &str, like: Option<&Session>, aircraft: Option<&str>) -> Result<PathBuf, String> {
        self.flush()?;
        let paths: Vec<PathBuf> = self.files.values().map(|file| file.path.clone()).collect();
        self.files.clear();
        if paths.is_empty() {
            return Err(format!("{}: nothing was recorded", self.folder.display()));
        }
        let title = begin::name_of(&self.folder);
        let mut session = match like {
            Some(like) => {
                Session { flights: Vec::new(), windows: Vec::new(), steady: Vec::new(), title, ..like.clone() }
            }
            None => empty_session(&title, aircraft),
        };
        let inspected = begin::inspect(&paths, &Control::default(), &|_| {})?;
        let parsed = ChannelMap::parse(map).map_err(|error| error.to_string())?;
        let plan = plan_all(&inspected.probes, &parsed);
        let own = MapRef::Own(map.into());
        add_flight(&mut session, (FLIGHT, &own), &inspected, &plan, &Control::default(), &|_| {})?;
        let path = self.folder.join(SESSION);
        let session = session::relative_to(&session, &self.folder);
        session::save(&session, &path).map_err(|error| error.to_string())?;
        Ok(path)
    }
}
