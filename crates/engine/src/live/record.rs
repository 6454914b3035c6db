//! Rows kept as they come, and the session made of them: a flight more each time a clock begins anew, in a folder of its own.

use std::collections::BTreeMap;
use std::fs::File;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use doublet_core::load::stream::{StreamChannel, StreamRow};
use doublet_core::load::{ChannelMap, plan_all};

use super::arrivals::Arrived;
use super::recorded_file::{cut_to_whole_lines, put_in_order};
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
    /// By the number of times that clocks had begun anew, and by source.
    files: BTreeMap<(usize, Arc<str>), SourceFile>,
}

/// What a recording is made into a session with.
pub struct Ending<'a> {
    /// Text of the channel map.
    pub map: &'a str,
    /// Session whose settings are taken.
    pub like: Option<&'a Session>,
    /// Aircraft as a session refers to it.
    pub aircraft: Option<&'a str>,
    /// Sources that the map cannot tell from others.
    pub left_out: &'a [Arc<str>],
    /// Time of a row on the clock of its source, s.
    pub time_s: &'a dyn Fn(&StreamRow) -> Option<f64>,
}

/// File of one source.
struct SourceFile {
    source: Arc<str>,
    channels: Arc<[StreamChannel]>,
    path: PathBuf,
    writer: csv::Writer<File>,
    /// Time of the latest row, s.
    last_s: f64,
    /// Whether every row has a later time than the one before.
    is_in_order: bool,
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
    pub fn write(&mut self, rows: &[Arrived]) -> Result<(), String> {
        for Arrived { row, time_s, restarts } in rows {
            let key = (*restarts, Arc::clone(&row.source));
            if self.files.get(&key).is_none_or(|file| file.channels.len() != row.channels.len()) {
                let file = self.file(row, &key)?;
                self.files.insert(key.clone(), file);
            }
            let Some(file) = self.files.get_mut(&key) else { continue };
            file.is_in_order &= time_s.is_nan() || *time_s > file.last_s;
            file.last_s = file.last_s.max(*time_s);
            let cells = row.values.iter().map(|value| if value.is_nan() { String::new() } else { value.to_string() });
            file.writer.write_record(cells).map_err(|error| format!("{}: {error}", file.path.display()))?;
        }
        Ok(())
    }

    /// A file for the rows of a source, with its header. One whose channels have grown replaces the one before, whose rows are copied.
    fn file(&mut self, row: &StreamRow, key: &(usize, Arc<str>)) -> Result<SourceFile, String> {
        let plain: String = row
            .source
            .chars()
            .map(|letter| if letter.is_alphanumeric() || "-_.".contains(letter) { letter } else { '_' })
            .collect();
        let folder = self.folder_of(key.0);
        let path = folder.join(format!("{plain}.csv"));
        let named = |error: &dyn std::fmt::Display| format!("{}: {error}", path.display());
        let (mut before, mut last_s, mut is_in_order) = (String::new(), f64::NEG_INFINITY, true);
        match self.files.remove(key) {
            Some(mut file) => {
                file.writer.flush().map_err(|error| named(&error))?;
                before = std::fs::read_to_string(&path).map_err(|error| named(&error))?;
                (last_s, is_in_order) = (file.last_s, file.is_in_order);
            }
            None if key.0 > 0 => std::fs::create_dir_all(&folder).map_err(|error| named(&error))?,
            None => {}
        }
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
        let (source, channels) = (Arc::clone(&row.source), Arc::clone(&row.channels));
        Ok(SourceFile { source, channels, path, writer, last_s, is_in_order })
    }

    /// Folder of the rows after so many times that clocks began anew.
    fn folder_of(&self, restarts: usize) -> PathBuf {
        if restarts == 0 { self.folder.clone() } else { self.folder.join(format!("restart_{restarts}")) }
    }

    /// Sends what was written to the disk.
    ///
    /// # Errors
    /// One line when the disk does not take it, or the file is gone.
    pub fn flush(&mut self) -> Result<(), String> {
        for file in self.files.values_mut() {
            let flushed = file.writer.flush().and_then(|()| file.path.metadata());
            flushed.map_err(|error| format!("{}: {error}", file.path.display()))?;
        }
        Ok(())
    }

    /// Ends the recording and writes a session of it; its path.
    ///
    /// # Errors
    /// One line when nothing was recorded or it cannot be read by the map.
    pub fn finish(mut self, ending: &Ending<'_>) -> Result<PathBuf, String> {
        let mut flights: BTreeMap<usize, Vec<PathBuf>> = BTreeMap::new();
        for ((restarts, _), file) in std::mem::take(&mut self.files) {
            let SourceFile { source, channels, path, writer, is_in_order, .. } = file;
            // What a full disk did not take any more was said when it happened.
            drop(writer);
            cut_to_whole_lines(&path).map_err(|error| format!("{}: {error}", path.display()))?;
            if !is_in_order {
                let row = |values| StreamRow { source: Arc::clone(&source), channels: Arc::clone(&channels), values };
                put_in_order(&path, &|values| (ending.time_s)(&row(values)))
                    .map_err(|error| format!("{}: {error}", path.display()))?;
            }
            if !ending.left_out.contains(&source) {
                flights.entry(restarts).or_default().push(path);
            }
        }
        if flights.is_empty() {
            return Err(format!("{}: nothing was recorded", self.folder.display()));
        }
        let title = begin::name_of(&self.folder);
        let mut session = match ending.like {
            Some(like) => {
                Session { flights: Vec::new(), windows: Vec::new(), steady: Vec::new(), title, ..like.clone() }
            }
            None => empty_session(&title, ending.aircraft),
        };
        let parsed = ChannelMap::parse(ending.map).map_err(|error| error.to_string())?;
        let own = MapRef::Own(ending.map.into());
        for (restarts, paths) in &flights {
            let name = if *restarts == 0 { FLIGHT.to_owned() } else { format!("{FLIGHT} {}", restarts + 1) };
            let inspected = begin::inspect(paths, &Control::default(), &|_| {})?;
            let plan = plan_all(&inspected.probes, &parsed);
            add_flight(&mut session, (&name, &own), &inspected, &plan, &Control::default(), &|_| {})?;
        }
        let path = self.folder.join(SESSION);
        let session = session::relative_to(&session, &self.folder);
        session::save(&session, &path).map_err(|error| error.to_string())?;
        Ok(path)
    }
}
