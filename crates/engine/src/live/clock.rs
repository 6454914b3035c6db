//! Stamps of one source: what came at which stamp, the usual interval, rows whose stamps others have to confirm.

use std::cmp::Ordering;
use std::collections::BTreeMap;
use std::hash::{DefaultHasher, Hash, Hasher};

use doublet_core::load::stream::StreamRow;

/// How far a stamp may lie from the newest of its source, s. One beyond is stray unless others follow it.
pub(super) const REACH_S: f64 = 10.0;
/// Usual intervals that a stamp may lie ahead: a slow source has long ones.
const REACH_INTERVALS: f64 = 10.0;
/// Rows in a row, all away from the newest stamp, that show that the clock of the source has changed.
const STAYS: usize = 10;
/// The same where a restart is expected, and for the first stamps of a source.
const STAYS_EXPECTED: usize = 2;
/// The same at the end of the stream, after which no more can come.
const STAYS_AT_END: usize = 3;
/// Part of the usual interval within which two rows of the same channels are one row of the same time.
const SAME_TIME: f64 = 0.55;
/// Latest stamps of which the usual interval is taken, and rows after which it is taken again.
const INTERVALS: usize = 101;
const INTERVAL_RENEWED: u64 = 32;
/// Least rows whose content is known, whatever their age.
const LEAST_RECENT: usize = 16;

/// A stamp in its order.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Stamp(f64);

impl Eq for Stamp {}

impl PartialOrd for Stamp {
    fn partial_cmp(&self, other: &Self) -> Option<Ordering> {
        Some(self.cmp(other))
    }
}

impl Ord for Stamp {
    fn cmp(&self, other: &Self) -> Ordering {
        self.0.total_cmp(&other.0)
    }
}

/// Where the stamp of a row lies.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Place {
    /// The row came before.
    Doubled,
    /// At the newest stamp or ahead of it.
    Ahead,
    /// Behind the newest stamp, where no row was.
    Gap,
    /// Too far from the newest stamp, or where another row of the same channels was.
    Away,
}

/// Stamps of one source.
#[derive(Debug, Default)]
pub(super) struct Clock {
    pub(super) newest_s: f64,
    pub(super) rows: u64,
    /// Times that it began anew.
    pub(super) restarts: usize,
    /// Whether it may begin anew now: its file was written anew.
    pub(super) expects_restart: bool,
    /// Rows away from the newest stamp, with their stamps.
    pub(super) away: Vec<(StreamRow, f64)>,
    /// Content of the rows within reach, by their stamps and by the channels that have values.
    recent: BTreeMap<(Stamp, u64), u64>,
    interval_s: f64,
}

impl Clock {
    /// A clock that began anew.
    pub(super) fn begun_anew(restarts: usize) -> Self {
        Self { restarts, ..Self::default() }
    }

    /// How far ahead of the newest a stamp may lie, s.
    fn reach_s(&self) -> f64 {
        REACH_S.max(REACH_INTERVALS * self.interval_s)
    }

    /// Usual interval, s; zero before the second row.
    pub(super) fn interval_s(&self) -> f64 {
        self.interval_s
    }

    /// Where a row with this stamp lies.
    pub(super) fn place(&self, row: &StreamRow, stamp_s: f64) -> Place {
        let is_same =
            |(other, other_s): &(StreamRow, f64)| *other_s == stamp_s && hash_values(other) == hash_values(row);
        let known = self.recent.get(&(Stamp(stamp_s), hash_channels(row)));
        if known == Some(&hash_values(row)) || self.away.iter().any(is_same) {
            return Place::Doubled;
        }
        if self.rows == 0 || self.is_out_of_reach(stamp_s) {
            return Place::Away;
        }
        if stamp_s >= self.newest_s {
            return Place::Ahead;
        }
        let follows = self.away.last().is_some_and(|(_, last_s)| (0.0..REACH_S).contains(&(stamp_s - last_s)));
        if follows || self.has_row_near(row, stamp_s) { Place::Away } else { Place::Gap }
    }

    /// Whether a stamp is too far from the newest.
    fn is_out_of_reach(&self, stamp_s: f64) -> bool {
        let ahead_s = stamp_s - self.newest_s;
        ahead_s > self.reach_s() || ahead_s < -REACH_S
    }

    /// Whether a row of the same channels came at nearly the same stamp.
    fn has_row_near(&self, row: &StreamRow, stamp_s: f64) -> bool {
        let (channels, near_s) = (hash_channels(row), SAME_TIME * self.interval_s);
        let range = (Stamp(stamp_s - near_s), u64::MIN)..=(Stamp(stamp_s + near_s), u64::MAX);
        self.recent.range(range).any(|((_, other), _)| *other == channels)
    }

    /// Whether a row with this stamp goes on with those that wait.
    pub(super) fn goes_on(&self, stamp_s: f64) -> bool {
        self.away.last().is_none_or(|(_, last_s)| stamp_s > last_s - self.reach_s())
    }

    /// From which of the rows that wait on the others confirm each other; none while there are too few.
    pub(super) fn confirmed_from(&self, is_restart_expected: bool) -> Option<usize> {
        let stamps: Vec<f64> = self.away.iter().map(|(_, stamp_s)| *stamp_s).collect();
        let needed = match usize::try_from(self.rows) {
            Ok(0) => STAYS_EXPECTED,
            _ if is_restart_expected => STAYS_EXPECTED,
            Ok(rows) => rows.clamp(STAYS_EXPECTED + 1, STAYS),
            Err(_) => STAYS,
        };
        let run = self.last_run();
        if run >= needed {
            return Some(stamps.len() - run);
        }
        if self.rows == 0
            && let [.., first_s, second_s, third_s] = stamps[..]
            && is_even(second_s - first_s, third_s - second_s)
        {
            return Some(stamps.len() - 3);
        }
        (stamps.len() >= STAYS).then_some(0)
    }

    /// From which of the rows that wait on the others confirm each other at the end of the stream: out of reach, they are not late rows.
    pub(super) fn confirmed_at_end(&self) -> Option<usize> {
        let from = self.away.len() - self.last_run();
        let is_away = self.away[from..].iter().all(|(_, stamp_s)| self.is_out_of_reach(*stamp_s));
        (is_away && self.last_run() >= STAYS_AT_END).then_some(from)
    }

    /// How many of the rows that wait, counted from the last, lie near each other.
    fn last_run(&self) -> usize {
        let is_near = |pair: &&[(StreamRow, f64)]| (pair[1].1 - pair[0].1).abs() <= self.reach_s();
        self.away.len().min(1 + self.away.windows(2).rev().take_while(is_near).count())
    }

    /// Takes in the stamp of a row.
    pub(super) fn note(&mut self, row: &StreamRow, stamp_s: f64) {
        self.newest_s = if self.rows == 0 { stamp_s } else { self.newest_s.max(stamp_s) };
        self.rows += 1;
        self.recent.insert((Stamp(stamp_s), hash_channels(row)), hash_values(row));
        let oldest_s = self.newest_s - REACH_S;
        while self.recent.len() > LEAST_RECENT
            && self.recent.first_key_value().is_some_and(|((stamp, _), _)| stamp.0 < oldest_s)
        {
            self.recent.pop_first();
        }
        if self.rows < INTERVAL_RENEWED || self.rows.is_multiple_of(INTERVAL_RENEWED) {
            self.interval_s = self.usual_interval_s();
        }
    }

    /// Median interval of the latest stamps in their order, whatever order they came in, s; zero before the second.
    fn usual_interval_s(&self) -> f64 {
        let mut stamps: Vec<f64> = self.recent.keys().rev().take(INTERVALS).map(|(stamp, _)| stamp.0).collect();
        stamps.dedup();
        let mut intervals: Vec<f64> = stamps.windows(2).map(|pair| pair[0] - pair[1]).collect();
        intervals.sort_by(f64::total_cmp);
        intervals.get(intervals.len() / 2).copied().unwrap_or(0.0)
    }
}

/// Whether two intervals are those of one slow source.
fn is_even(first_s: f64, second_s: f64) -> bool {
    let (short_s, long_s) = (first_s.min(second_s), first_s.max(second_s));
    short_s > 0.0 && long_s <= REACH_INTERVALS * short_s
}

/// A number for the values of a row.
fn hash_values(row: &StreamRow) -> u64 {
    let mut hasher = DefaultHasher::new();
    row.values.iter().for_each(|value| value.to_bits().hash(&mut hasher));
    hasher.finish()
}

/// A number for the channels that have values in a row.
fn hash_channels(row: &StreamRow) -> u64 {
    let mut hasher = DefaultHasher::new();
    let finite = row.values.iter().enumerate().filter(|(_, value)| value.is_finite());
    finite.for_each(|(at, _)| at.hash(&mut hasher));
    hasher.finish()
}
