//! A flight watched: source, channel map, pace, pipeline and recorder together.

use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

use doublet_core::load::ChannelMap;
use doublet_core::load::stream::{StreamMap, StreamRow};

use super::pace::Pace;
use super::pipeline::LivePipeline;
use super::record::Recorder;
use super::settings::LiveSettings;
use super::source::{Polled, Source};
use super::update::LiveUpdate;
use crate::session::Session;

/// Rest where nothing came.
const REST: Duration = Duration::from_millis(20);

/// Longest time that what was recorded waits for the disk.
const FLUSHED_EVERY: Duration = Duration::from_secs(1);

/// A flight that is watched.
pub struct LiveWatch {
    source: Source,
    map: StreamMap,
    map_text: String,
    pace: Pace,
    pipeline: LivePipeline,
    recorder: Option<Recorder>,
    /// Time without a row after which the stream has ended, once it had begun; none for never.
    wait: Option<Duration>,
    last_rows: Option<Instant>,
    last_flush: Option<Instant>,
    has_ended: bool,
    is_finished: bool,
}

/// What a step gave.
#[derive(Debug, Default)]
pub struct Step {
    /// Updates, in order.
    pub updates: Vec<LiveUpdate>,
    /// Nothing comes any more and everything is computed.
    pub is_finished: bool,
    /// How long to rest before the next step.
    pub rest: Option<Duration>,
}

impl LiveWatch {
    /// Watches `source` through the channel map of this text, at `speed` times real time; without one as fast as samples come.
    ///
    /// # Errors
    /// One line: a map or settings that cannot be used.
    pub fn new(
        source: Source,
        map_text: String,
        settings: LiveSettings,
        speed: Option<f64>,
        wait: Option<Duration>,
    ) -> Result<Self, String> {
        let map = ChannelMap::parse(&map_text).map_err(|error| error.to_string())?;
        let pipeline = LivePipeline::new(settings)?;
        let (map, pace) = (StreamMap::new(map), Pace::new(speed));
        let (recorder, last_rows, last_flush, has_ended, is_finished) = (None, None, None, false, false);
        Ok(Self {
            source,
            map,
            map_text,
            pace,
            pipeline,
            recorder,
            wait,
            last_rows,
            last_flush,
            has_ended,
            is_finished,
        })
    }

    /// Keeps every row in the new folder `folder`, beside the channel map.
    ///
    /// # Errors
    /// One line when it exists or cannot be made.
    pub fn record(&mut self, folder: &Path) -> Result<(), String> {
        self.recorder = Some(Recorder::new(folder, &self.map_text)?);
        Ok(())
    }

    /// Takes what came and computes what follows from it.
    ///
    /// # Errors
    /// One line: a source that cannot be read, a disk that is full.
    pub fn step(&mut self, now: Instant) -> Result<Step, String> {
        let mut polled = Polled::Nothing;
        if !self.has_ended && !self.pace.is_full() {
            let mut rows = Vec::new();
            polled = self.source.poll(&mut rows)?;
            self.has_ended = polled == Polled::Ended || self.is_silent(now, !rows.is_empty());
            self.keep(&rows, now)?;
            let mut samples = Vec::new();
            rows.iter().for_each(|row| self.map.take(row, &mut samples));
            self.pace.put(samples.into_iter());
        }
        let due = self.pace.due(now);
        let is_busy = !due.is_empty() || polled == Polled::Rows && !self.pace.is_full();
        let mut updates = self.pipeline.push(due);
        if self.has_ended && self.pace.is_empty() && !self.is_finished {
            updates.extend(self.pipeline.finish());
            self.is_finished = true;
        }
        let problems = self.problems();
        updates.iter_mut().for_each(|update| update.findings.extend(problems.iter().cloned()));
        Ok(Step { updates, is_finished: self.is_finished, rest: (!is_busy).then_some(REST) })
    }

    /// Whether nothing came for so long that the stream has ended.
    fn is_silent(&mut self, now: Instant, has_rows: bool) -> bool {
        if has_rows {
            self.last_rows = Some(now);
        }
        let silence = self.last_rows.map(|last| now.saturating_duration_since(last));
        self.source.address().is_some() && silence.zip(self.wait).is_some_and(|(silence, wait)| silence > wait)
    }

    /// Records rows; what was recorded is on its way to the disk within a second.
    fn keep(&mut self, rows: &[StreamRow], now: Instant) -> Result<(), String> {
        let Some(recorder) = &mut self.recorder else { return Ok(()) };
        recorder.write(rows)?;
        if self.last_flush.is_none_or(|last| now.saturating_duration_since(last) > FLUSHED_EVERY) {
            self.last_flush = Some(now);
            recorder.flush()?;
        }
        Ok(())
    }

    /// The stream is not followed any more: the next step goes to the end of what was due.
    pub fn stop(&mut self) {
        self.has_ended = true;
        self.pace.clear();
    }

    /// Where the source listens.
    pub fn address(&self) -> Option<std::net::SocketAddr> {
        self.source.address()
    }

    /// What the map cannot find and what of the stream is lost.
    fn problems(&self) -> Vec<String> {
        let missing = self.map.problems.iter().filter(|problem| problem.is_error).map(ToString::to_string);
        missing.chain(self.source.losses()).collect()
    }

    /// Ends the recording, if there is one, and makes a session of it with the settings of `like`; its path.
    ///
    /// # Errors
    /// One line when nothing was recorded or it cannot be read.
    pub fn finish(self, like: Option<&Session>, aircraft: Option<&str>) -> Result<Option<PathBuf>, String> {
        self.recorder.map(|recorder| recorder.finish(&self.map_text, like, aircraft)).transpose()
    }
}
