//! Rows kept as they come, and the session made of them: a flight more each time a clock begins anew, in a folder of its own. While
//! they come, a session of one manoeuvre a flight is kept up to date, so that a killed program leaves one.

use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};
use std::sync::Arc;

use doublet_core::load::stream::StreamRow;
use doublet_core::load::{ChannelMap, plan_all};
use doublet_core::series::TimeRange;
use toml_edit::DocumentMut;

use super::arrivals::Arrived;
use super::recorded_file::{cut_to_whole_lines, put_in_order};
use super::source_file::{SourceFile, describe_error, name_file};
use crate::begin::{self, add_flight, empty_session};
use crate::graph::Control;
use crate::keep;
use crate::session::{self, Flight, Manoeuvre, MapRef, RecordingRef, Session};

/// Name of the session in its folder.
const SESSION: &str = "session.toml";
/// Name of the channel map in it, for a recording that was never finished.
const MAP: &str = "channel_map.toml";
/// Name of the flight in it.
const FLIGHT: &str = "live";

/// Writes the rows of every source into a file of its own in a new folder.
pub struct Recorder {
    folder: PathBuf,
    /// Text of the channel map.
    map: String,
    /// Session whose settings are taken.
    like: Option<Session>,
    /// Aircraft as a session refers to it.
    aircraft: Option<String>,
    /// By the number of times that clocks had begun anew, and by source.
    files: BTreeMap<(usize, Arc<str>), SourceFile>,
    /// Names of the files of the sources.
    names: BTreeMap<Arc<str>, String>,
    /// Sources whose file cannot be made, with the reason.
    refused: BTreeMap<Arc<str>, String>,
}

/// A recording that has ended.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Recorded {
    pub session: PathBuf,
    /// What of it the session leaves out, a line each.
    pub notes: Vec<String>,
}

/// How the rows on disk are read.
pub struct Reading<'a> {
    /// Sources that the map cannot tell from others.
    pub left_out: &'a [Arc<str>],
    /// Time of a row on the clock of its source, s.
    pub time_s: &'a dyn Fn(&StreamRow) -> Option<f64>,
}

impl Recorder {
    /// Into `folder`, which must not exist, with the text of the channel map that reads it; the session takes the settings of `like`, or
    /// those by default with this aircraft.
    pub fn new(folder: &Path, map: &str, like: Option<&Session>, aircraft: Option<&str>) -> Result<Self, String> {
        if folder.exists() {
            return Err(format!(
                "{} exists: choose another folder, a recording is never overwritten",
                folder.display()
            ));
        }
        std::fs::create_dir_all(folder).map_err(|error| format!("{}: {error}", folder.display()))?;
        let place = folder.join(MAP);
        keep::replace(&place, map.as_bytes()).map_err(|error| format!("{}: {error}", place.display()))?;
        keep::sync_folder_of(folder).map_err(|error| format!("{}: {error}", folder.display()))?;
        Ok(Self {
            folder: folder.to_owned(),
            map: map.to_owned(),
            like: like.cloned(),
            aircraft: aircraft.map(str::to_owned),
            files: BTreeMap::new(),
            names: BTreeMap::new(),
            refused: BTreeMap::new(),
        })
    }

    /// Writes rows; a source whose file cannot be made is left out.
    pub fn write(&mut self, rows: &[Arrived]) -> Result<(), String> {
        for Arrived { row, stamp_s, restarts, .. } in rows {
            let key = (*restarts, Arc::clone(&row.source));
            if self.refused.contains_key(&row.source) {
                continue;
            }
            if !self.files.contains_key(&key) {
                match self.begin_file(row, *restarts) {
                    Ok(file) => _ = self.files.insert(key.clone(), file),
                    Err(line) => _ = self.refused.insert(Arc::clone(&row.source), line),
                }
            }
            let Some(file) = self.files.get_mut(&key) else { continue };
            file.write(row, *stamp_s).map_err(|error| describe_error(&file.path, &error))?;
        }
        Ok(())
    }

    fn begin_file(&mut self, row: &StreamRow, restarts: usize) -> Result<SourceFile, String> {
        let taken = || self.names.values().cloned().collect::<BTreeSet<_>>();
        let name = self.names.get(&row.source).cloned().unwrap_or_else(|| name_file(&row.source, &taken()));
        let folder = self.folder_of(restarts);
        if restarts > 0 {
            let made = std::fs::create_dir_all(&folder).and_then(|()| keep::sync_folder_of(&folder));
            made.map_err(|error| describe_error(&folder, &error))?;
        }
        let path = folder.join(format!("{name}.csv"));
        self.names.insert(Arc::clone(&row.source), name);
        SourceFile::new(path.clone(), row).map_err(|error| describe_error(&path, &error))
    }

    /// Sources that are not recorded, a line each.
    pub fn describe_refused(&self) -> impl Iterator<Item = String> {
        self.refused.iter().map(|(source, line)| format!("source '{}' is not recorded: {line}", shorten(source)))
    }

    /// Folder of the rows after so many times that clocks began anew.
    fn folder_of(&self, restarts: usize) -> PathBuf {
        if restarts == 0 { self.folder.clone() } else { self.folder.join(format!("restart_{restarts}")) }
    }

    /// Sends what was written to the disk.
    pub fn flush(&mut self) -> Result<(), String> {
        for file in self.files.values_mut() {
            file.flush().map_err(|error| describe_error(&file.path, &error))?;
        }
        Ok(())
    }

    /// Has the disk keep the rows and the names of their files through a loss of power.
    fn sync(&self) -> Result<(), String> {
        for file in self.files.values() {
            file.sync().map_err(|error| describe_error(&file.path, &error))?;
        }
        Ok(())
    }

    /// Writes a session of what was recorded so far, each flight as one manoeuvre; none before there are two rows.
    pub fn renew(&mut self, left_out: &[Arc<str>]) -> Result<(), String> {
        self.flush()?;
        self.sync()?;
        // Rows are put in order at the end alone.
        let map = MapRef::Own(dropping_faults(&self.map).into());
        let mut session = self.session();
        let mut flights: BTreeMap<usize, Vec<&SourceFile>> = BTreeMap::new();
        for ((restarts, _), file) in self.files.iter().filter(|((_, source), _)| !left_out.contains(source)) {
            flights.entry(*restarts).or_default().push(file);
        }
        for (restarts, files) in flights {
            // The source of most rows is that of the rates.
            let fastest = files.iter().filter(|file| file.last_s > file.first_s).max_by_key(|file| file.rows);
            let Some(SourceFile { first_s, last_s, .. }) = fastest else { continue };
            let window = TimeRange { start_s: *first_s, end_s: *last_s };
            let name = flight_name(restarts);
            let recording = |file: &&SourceFile| RecordingRef {
                path: file.path.display().to_string(),
                sha256: None,
                channel_map: map.clone(),
                only: None,
            };
            session.flights.push(Flight::new(name.clone(), files.iter().map(recording).collect()));
            session.windows.push(Manoeuvre::new(name.clone(), name, window));
        }
        if session.flights.is_empty() {
            return Ok(());
        }
        self.save(&session).map(drop)
    }

    /// Sources whose file has another name, a line each.
    fn describe_names(&self) -> Vec<String> {
        let renamed =
            self.names.iter().filter(|(source, name)| ***source != ***name && !self.refused.contains_key(*source));
        renamed.map(|(source, name)| format!("rows of source '{}' are in {name}.csv", shorten(source))).collect()
    }

    /// A session without flights.
    fn session(&self) -> Session {
        let title = begin::name_of(&self.folder);
        match &self.like {
            Some(like) => {
                Session { flights: Vec::new(), windows: Vec::new(), steady: Vec::new(), title, ..like.clone() }
            }
            None => empty_session(&title, self.aircraft.as_deref()),
        }
    }

    fn save(&self, session: &Session) -> Result<PathBuf, String> {
        let path = self.folder.join(SESSION);
        let session = session::relative_to(session, &self.folder);
        session::save_without_backup(&session, &path).map_err(|error| error.to_string())?;
        Ok(path)
    }

    /// Ends the recording and writes a session of it, with the manoeuvres found. A flight that cannot be read is left out unless it is
    /// the only one.
    pub fn finish(mut self, reading: &Reading<'_>) -> Result<Recorded, String> {
        let mut flights: BTreeMap<usize, Vec<PathBuf>> = BTreeMap::new();
        let mut notes = self.describe_names();
        for ((restarts, _), file) in std::mem::take(&mut self.files) {
            let (source, channels) = (Arc::clone(&file.source), Arc::clone(&file.channels));
            let (path, is_in_order) = (file.path.clone(), file.is_in_order);
            // What a full disk did not take any more was said when it happened.
            drop(file);
            let row = |values| StreamRow { source: Arc::clone(&source), channels: Arc::clone(&channels), values };
            let ordered = cut_to_whole_lines(&path).map_err(Box::from).and_then(|()| match is_in_order {
                true => Ok(()),
                false => put_in_order(&path, &|values| (reading.time_s)(&row(values))),
            });
            if let Err(error) = ordered {
                notes.push(format!("{}: {error}: not in the session", path.display()));
                continue;
            }
            if !reading.left_out.contains(&source) {
                flights.entry(restarts).or_default().push(path);
            }
        }
        if flights.is_empty() {
            let nothing = format!("{}: nothing was recorded", self.folder.display());
            let all = std::iter::once(nothing).chain(self.describe_refused()).chain(notes);
            return Err(all.collect::<Vec<_>>().join("; "));
        }
        let parsed = ChannelMap::parse(&self.map).map_err(|error| error.to_string())?;
        let mut session = self.session();
        for (restarts, paths) in &flights {
            match self.with_flight(&session, (*restarts, paths), &parsed) {
                Ok(longer) => session = longer,
                Err(line) => notes.push(format!("flight '{}' is left out: {line}", flight_name(*restarts))),
            }
        }
        if session.flights.is_empty() {
            return Err(notes.join("; "));
        }
        Ok(Recorded { session: self.save(&session)?, notes })
    }

    /// A session with one more flight.
    fn with_flight(
        &self,
        session: &Session,
        (restarts, paths): (usize, &[PathBuf]),
        map: &ChannelMap,
    ) -> Result<Session, String> {
        let mut session = session.clone();
        let inspected = begin::inspect(paths, &Control::default(), &|_| {})?;
        let plan = plan_all(&inspected.probes, map);
        let own = MapRef::Own(self.map.as_str().into());
        add_flight(&mut session, (&flight_name(restarts), &own), &inspected, &plan, &Control::default(), &|_| {})?;
        Ok(session)
    }
}

/// The beginning of the name of a source.
fn shorten(source: &str) -> String {
    /// Characters shown.
    const MOST: usize = 40;
    let start: String = source.chars().take(MOST).collect();
    if start.len() < source.len() { format!("{start}…") } else { start }
}

/// Name of the flight after so many times that clocks had begun anew.
fn flight_name(restarts: usize) -> String {
    if restarts == 0 { FLIGHT.to_owned() } else { format!("{FLIGHT} {}", restarts + 1) }
}

/// The channel map that leaves out rows whose time goes back or repeats.
fn dropping_faults(map: &str) -> String {
    let Ok(mut document) = map.parse::<DocumentMut>() else { return map.to_owned() };
    let entries = document.get_mut("time").and_then(|time| time.as_array_of_tables_mut());
    entries.into_iter().flat_map(|entries| entries.iter_mut()).for_each(|entry| entry["repair"] = "drop".into());
    document.to_string()
}
