//! A flight that is watched and recorded: rows of several sources in any order, by any clocks, in pieces of any size.

use std::collections::VecDeque;
use std::path::Path;
use std::sync::{Arc, LazyLock};
use std::time::{Duration, Instant};

use doublet_core::load::stream::{StreamChannel, StreamRow};
use doublet_engine::live::{Feed, LineFormat, LiveSettings, LiveUpdate, LiveWatch, Opening, Source, open};

use super::scratch;

/// Bytes of a row.
const ROW: usize = 3;
const MOST_ROWS: usize = 2000;
/// Most steps: each piece, and the end.
const MOST_STEPS: u32 = 4010;
/// Time between two steps, and where the watching stands still.
const STEP: Duration = Duration::from_millis(20);
const LONG_STEP: Duration = Duration::from_secs(11);

/// Sources: two have like names and the same channels.
const SOURCES: [(&str, &[&str]); 4] = [
    ("imu", &["time", "ax", "ay", "az", "p", "q", "r"]),
    ("air/1", &["time", "airspeed", "alpha", "beta"]),
    ("air_1", &["time", "delta_e"]),
    ("AIR_1", &["time", "delta_e"]),
];
/// Channels that a source may have from some row on.
const MORE: [&str; 2] = ["delta_a", "delta_r"];

/// Channel map and settings.
static WATCHED: LazyLock<(String, LiveSettings)> = LazyLock::new(|| {
    let feed = Some(Feed::Lines("127.0.0.1:0".to_owned(), LineFormat::Json));
    let opening = Opening { feed, aircraft: Some("c337f".to_owned()), ..Opening::default() };
    let watched = open(&opening).expect("the aircraft comes with the program");
    (watched.map, watched.settings)
});

/// Source of rows as it is while they are made.
struct Sender {
    source: Arc<str>,
    channels: Arc<[StreamChannel]>,
    time_s: f64,
    latest: Option<StreamRow>,
}

impl Sender {
    fn new((source, names): (&str, &[&str])) -> Self {
        let channel = |name: &&str| StreamChannel { name: (*name).to_owned(), unit: None };
        Self { source: source.into(), channels: names.iter().map(channel).collect(), time_s: 0.0, latest: None }
    }

    /// The next row: what its clock does, by how much, and a number of which the values are made.
    fn send(&mut self, action: u8, amount: u8, value: u8) -> StreamRow {
        let step_s = f64::from(amount % 32) * 0.005;
        self.time_s = match action {
            4 => self.time_s - 20.0 * step_s,
            5 => step_s,
            6 => self.time_s,
            7 => f64::from(amount).exp2() - 1.0,
            _ => self.time_s + 0.005 + step_s,
        };
        if action == 6
            && let Some(row) = &self.latest
        {
            return row.clone();
        }
        let other = |at: usize| f64::from(value) / 64.0 - 2.0 + at as f64;
        let mut values: Vec<f64> = (0..self.channels.len()).map(other).collect();
        values[0] = if (action, amount) == (7, 255) { f64::NAN } else { self.time_s };
        let row = StreamRow { source: Arc::clone(&self.source), channels: Arc::clone(&self.channels), values };
        self.latest = Some(row.clone());
        row
    }

    /// One channel more.
    fn widen(&mut self) {
        let has = |name: &&&str| self.channels.iter().any(|channel| channel.name == **name);
        if let Some(name) = MORE.iter().find(|name| !has(name)) {
            let new = StreamChannel { name: (*name).to_owned(), unit: None };
            self.channels = self.channels.iter().cloned().chain([new]).collect();
        }
    }
}

/// Rows in pieces, and after which pieces the watching stands still. Of the first byte of a row the lowest two bits are the source, the
/// next three what its clock does, then: one channel more, the piece ends, the watching stands still behind it.
fn rows_from(data: &[u8]) -> (VecDeque<Vec<StreamRow>>, Vec<bool>) {
    let mut senders = SOURCES.map(Sender::new);
    let (mut pieces, mut pauses, mut piece) = (VecDeque::new(), Vec::new(), Vec::new());
    for bytes in data.chunks_exact(ROW).take(MOST_ROWS) {
        let (first, amount, value) = (bytes[0], bytes[1], bytes[2]);
        let sender = &mut senders[usize::from(first & 3)];
        if first & 32 != 0 {
            sender.widen();
        }
        piece.push(sender.send((first >> 2) & 7, amount, value));
        if first & 64 != 0 {
            pieces.push_back(std::mem::take(&mut piece));
            pauses.push(first & 128 != 0);
        }
    }
    pieces.push_back(piece);
    pauses.push(false);
    (pieces, pauses)
}

/// Watches and records what the bytes say: time never goes back, no row is made, every file is a table.
pub fn live(data: &[u8]) {
    let (map, settings) = &*WATCHED;
    let (pieces, pauses) = rows_from(data);
    let given = pieces.iter().map(Vec::len).sum::<usize>() as u64;
    let folder = scratch("recording");
    // What an earlier run left that was ended.
    let _ = std::fs::remove_dir_all(&folder);
    let source = Source::Given(pieces);
    let mut watch =
        LiveWatch::new(source, map.clone(), settings.clone(), None, None).expect("the settings are those by default");
    watch.record(&folder, None, Some("builtin:c337f")).expect("the scratch folder can be made");
    let (mut now, mut updates) = (Instant::now(), Vec::<LiveUpdate>::new());
    for step in 0..=MOST_STEPS {
        assert!(step < MOST_STEPS, "the end is never reached");
        let found = watch.step(now).expect("rows that are given can be read");
        updates.extend(found.updates);
        if found.is_finished {
            break;
        }
        now += if pauses.get(step as usize) == Some(&true) { LONG_STEP } else { STEP };
    }
    assert!(updates.iter().all(|update| update.time_s.is_finite() && update.lag_s >= 0.0), "times are numbers");
    assert!(updates.is_sorted_by(|one, next| one.time_s <= next.time_s), "time never goes back");
    assert_eq!(watch.recording_errors(), Vec::<String>::new());
    let left_out = updates.last().map_or(0, |update| update.counts.doubled + update.counts.stray);
    // A recording that no session can be made of is refused in one line.
    let _ = watch.finish();
    let recorded = count_rows(&folder);
    assert!(recorded + left_out <= given, "{recorded} recorded and {left_out} left out of {given} rows");
    std::fs::remove_dir_all(&folder).expect("the scratch folder can be removed");
}

/// Rows of all tables in a folder and those in it.
fn count_rows(folder: &Path) -> u64 {
    let mut rows = 0;
    for entry in std::fs::read_dir(folder).expect("the recording is there").flatten() {
        let path = entry.path();
        if path.is_dir() {
            rows += count_rows(&path);
        } else if path.extension().is_some_and(|ending| ending == "csv") {
            let text = std::fs::read_to_string(&path).expect("a recording is text");
            let cells = |line: &str| line.split(',').count();
            let header = text.lines().next().map_or(0, cells);
            assert!(text.lines().all(|line| cells(line) == header), "{}", path.display());
            rows += text.lines().count().saturating_sub(1) as u64;
        }
    }
    rows
}
