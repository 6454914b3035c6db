//! A flight watched: source, channel map, pace, pipeline and recorder together.

use std::path::Path;
use std::time::{Duration, Instant};

use doublet_core::load::ChannelMap;
use doublet_core::load::stream::{StreamMap, StreamRow};

use super::age::Age;
use super::arrivals::{Arrivals, Arrived};
use super::columns::Columns;
use super::news::News;
use super::pace::Pace;
use super::pipeline::LivePipeline;
use super::record::{Reading, Recorded, Recorder};
use super::settings::LiveSettings;
use super::silence::{Silence, is_rate};
use super::source::{Polled, Source};
use super::update::LiveUpdate;
use crate::session::Session;

/// Rest where nothing came.
const REST: Duration = Duration::from_millis(20);

/// Longest time that what was recorded waits for the disk.
const FLUSHED_EVERY: Duration = Duration::from_secs(1);

/// Time from the first row to the first session of what was recorded, and from one to the next.
const FIRST_SESSION: Duration = Duration::from_secs(10);
const NEXT_SESSION: Duration = Duration::from_secs(60);

/// A flight that is watched.
pub struct LiveWatch {
    source: Source,
    map: StreamMap,
    map_text: String,
    pace: Pace,
    pipeline: LivePipeline,
    columns: Columns,
    arrivals: Arrivals,
    age: Age,
    recorder: Option<Recorder>,
    /// Why nothing is recorded any more.
    recording_error: Option<String>,
    /// Time without a row after which the stream has ended, once it had begun; none for never.
    wait: Option<Duration>,
    silence: Silence,
    last_flush: Option<Instant>,
    /// When the session of the recording is written next.
    session_due: Option<Instant>,
    news: News,
    /// The latest update, for alarms while nothing comes.
    latest: Option<LiveUpdate>,
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
    /// Watches `source` through the channel map of this text, at `speed` times real time; without one as fast as samples come. A socket
    /// that is silent for `wait` has ended; without that it is listened to until it is stopped.
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
        let (recorder, recording_error, arrivals) = (None, None, Arrivals::default());
        let (silence, last_flush, session_due, has_ended, is_finished) = (Silence::default(), None, None, false, false);
        let (columns, age, news, latest) = (Columns::default(), Age::default(), News::default(), None);
        Ok(Self {
            source,
            map,
            map_text,
            pace,
            pipeline,
            columns,
            arrivals,
            age,
            recorder,
            recording_error,
            wait,
            silence,
            last_flush,
            session_due,
            news,
            latest,
            has_ended,
            is_finished,
        })
    }

    /// Keeps every row in the new folder `folder`, beside the channel map and a session with the settings of `like`, or those by
    /// default with this aircraft.
    pub fn record(&mut self, folder: &Path, like: Option<&Session>, aircraft: Option<&str>) -> Result<(), String> {
        self.recorder = Some(Recorder::new(folder, &self.map_text, like, aircraft)?);
        Ok(())
    }

    /// Takes what came and computes what follows from it.
    ///
    /// # Errors
    /// One line: a source that cannot be read. A disk that is full ends the recording alone.
    pub fn step(&mut self, now: Instant) -> Result<Step, String> {
        let mut polled = Polled::Nothing;
        if !self.has_ended && !self.pace.is_full() {
            let mut rows = Vec::new();
            let files = self.source.files_begun();
            polled = self.source.poll(&mut rows)?;
            if self.source.files_begun() > files {
                self.arrivals.expect_restart();
            }
            self.has_ended = polled == Polled::Ended || self.is_silent(now, !rows.is_empty());
            self.take_rows(rows, now);
        }
        let due = self.pace.due(now);
        let is_busy = !due.is_empty() || polled == Polled::Rows && !self.pace.is_full();
        let mut updates = self.pipeline.push(due);
        if self.has_ended && self.pace.is_empty() && !self.is_finished {
            updates.extend(self.pipeline.finish());
            self.is_finished = true;
        }
        let alarms = self.silent(now);
        if !alarms.is_empty() && self.silence.is_due(!updates.is_empty(), now) && updates.is_empty() {
            // Nothing to compute from: the latest update again, with the alarm.
            let (limits, findings) = (Vec::new(), Vec::new());
            let latest = self.latest.clone().unwrap_or_default();
            updates.push(LiveUpdate { limits, findings, nis_per_measurement: None, ..latest });
        }
        self.complete(&mut updates, &alarms, now);
        Ok(Step { updates, is_finished: self.is_finished, rest: (!is_busy).then_some(REST) })
    }

    /// Records rows and puts their samples on their way.
    fn take_rows(&mut self, rows: Vec<StreamRow>, now: Instant) {
        let restarts = self.arrivals.restarts();
        let mut arrived = Vec::new();
        for row in rows {
            let row = self.columns.align(row);
            for row in self.map.ready(row) {
                arrived.extend(self.arrive(row));
            }
        }
        if self.has_ended {
            arrived.extend(self.arrivals.finish());
            // Sources that ended before their clock was found are recorded all the same.
            let waiting = self.map.waiting().into_iter();
            let short: Vec<Arrived> = waiting.map(|row| Arrived::new(row, None)).collect();
            self.keep(&short, now);
        }
        self.keep(&arrived, now);
        if self.arrivals.restarts() > restarts {
            self.age.forget();
            self.note_clock_restarts(&arrived, restarts);
        }
        let mut samples = Vec::new();
        for Arrived { row, time_s, .. } in &arrived {
            let before = samples.len();
            self.map.convert(row, *time_s, &mut samples);
            self.silence.note_samples(&row.source, *time_s, &samples[before..], now);
            if samples[before..].iter().any(is_rate) {
                self.age.note(*time_s, now);
            }
        }
        self.pace.put(samples.into_iter());
    }

    /// Tells the pipeline the first time after each restart beyond the first `known`.
    fn note_clock_restarts(&mut self, arrived: &[Arrived], mut known: usize) {
        for row in arrived.iter().filter(|row| row.time_s.is_finite()) {
            if row.restarts > known {
                known = row.restarts;
                self.pipeline.note_clock_restart(row.time_s);
            }
        }
    }

    /// Adds the counts, findings and alarms of the stream to updates, and the age of the newest sample of a live one.
    fn complete(&mut self, updates: &mut [LiveUpdate], alarms: &[String], now: Instant) {
        if let Some(latest) = updates.last() {
            self.latest = Some(latest.clone());
        }
        let problems = self.problems();
        let age_s = if self.source.is_live() && !self.has_ended { self.age.age_s(now) } else { 0.0 };
        let recording = self.recording_errors();
        for update in updates.iter_mut() {
            let counts = &mut update.counts;
            (counts.doubled, counts.stray) = (self.arrivals.doubled, self.arrivals.stray);
            (counts.reordered, counts.clock_restarts) = (self.arrivals.reordered, self.arrivals.restarts() as u64);
            update.findings.extend(problems.iter().cloned());
            update.findings = self.news.take_new(std::mem::take(&mut update.findings), update.time_s);
            update.alarms = alarms.iter().chain(&recording).cloned().collect();
            update.lag_s += age_s;
        }
    }

    /// Alarms of a live source, or of a part of it, that is silent.
    fn silent(&self, now: Instant) -> Vec<String> {
        if self.has_ended || !self.source.is_live() || !self.pace.is_empty() {
            return Vec::new();
        }
        self.silence.alarms(now)
    }

    /// Whether nothing came for so long that the stream has ended.
    fn is_silent(&mut self, now: Instant, has_rows: bool) -> bool {
        self.silence.note_step(has_rows, now);
        let silence = self.silence.since_row(now);
        self.source.address().is_some() && silence.zip(self.wait).is_some_and(|(silence, wait)| silence > wait)
    }

    /// What of a row is taken now, with the time it is taken at.
    fn arrive(&mut self, row: StreamRow) -> Vec<Arrived> {
        let stamp_s = self.map.time_s(&row);
        if self.source.is_trusted() {
            return vec![Arrived::new(row, stamp_s)];
        }
        self.arrivals.take(row, stamp_s)
    }

    /// Records rows; what was recorded is on its way to the disk within a second, its session within the first minute. A disk that does
    /// not take them ends the recording and nothing else.
    fn keep(&mut self, rows: &[Arrived], now: Instant) {
        let Some(recorder) = self.recorder.as_mut().filter(|_| self.recording_error.is_none()) else { return };
        let mut kept = recorder.write(rows);
        if self.last_flush.is_none_or(|last| now.saturating_duration_since(last) > FLUSHED_EVERY) {
            self.last_flush = Some(now);
            kept = kept.and_then(|()| recorder.flush());
        }
        let is_due = self.session_due.is_some_and(|due| now >= due);
        if is_due {
            kept = kept.and_then(|()| recorder.renew(&self.map.left_out));
        }
        if is_due || self.session_due.is_none() && !rows.is_empty() {
            self.session_due = Some(now + if is_due { NEXT_SESSION } else { FIRST_SESSION });
        }
        self.recording_error = kept.err().map(|error| format!("recording stopped, estimation continues: {error}"));
    }

    /// Why nothing is recorded any more, or not all sources are, a line each.
    pub fn recording_errors(&self) -> Vec<String> {
        let refused = self.recorder.iter().flat_map(Recorder::describe_refused);
        self.recording_error.iter().cloned().chain(refused).collect()
    }

    /// The stream is not followed any more: the next step goes to the end of what was due.
    pub fn stop(&mut self) {
        if !self.has_ended {
            self.has_ended = true;
            // Rows that wait for others are recorded all the same.
            self.take_rows(Vec::new(), Instant::now());
        }
        self.pace.clear();
    }

    /// Where the source listens.
    pub fn address(&self) -> Option<std::net::SocketAddr> {
        self.source.address()
    }

    /// What the map cannot find, what of the stream is lost and clocks that began anew.
    fn problems(&self) -> Vec<String> {
        let missing = self.map.problems.iter().filter(|problem| problem.is_error).map(ToString::to_string);
        let left_out = self.map.left_out.iter().map(|source| {
            format!(
                "source '{source}' is left out: its channels have the roles of another source; name sources in the map"
            )
        });
        let restarts = Some(self.arrivals.restarts()).filter(|count| *count > 0);
        let restarts = restarts.map(|count| format!("clock restarts in the stream: {count}; time continues"));
        let others = restarts.into_iter().chain(self.source.losses());
        missing.chain(left_out).chain(others).collect()
    }

    /// Ends the recording, if there is one, and makes a session of it.
    pub fn finish(self) -> Result<Option<Recorded>, String> {
        let Some(recorder) = self.recorder else { return Ok(None) };
        let reading = Reading { left_out: &self.map.left_out, time_s: &|row| self.map.time_s(row) };
        // Why there is no session is why nothing was recorded.
        recorder.finish(&reading).map(Some).map_err(|error| self.recording_error.unwrap_or(error))
    }
}
