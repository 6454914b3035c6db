//! Rows by the clock of their source: doubled ones and stray stamps are counted and left out, a clock that begins anew is followed.

use std::cmp::Ordering;
use std::collections::BTreeMap;
use std::hash::{DefaultHasher, Hash, Hasher};
use std::sync::Arc;

use doublet_core::load::stream::StreamRow;

/// How far a stamp may lie from the newest of its source, s. One beyond is stray unless others follow it.
const REACH_S: f64 = 10.0;
/// Usual intervals that a stamp may lie ahead: a slow source has long ones.
const REACH_INTERVALS: f64 = 10.0;
/// Rows in a row, all away from the newest stamp and in order, that show that the clock of the source has changed.
const STAYS: usize = 10;
/// Pause put between the rows before a clock began anew and those after it, s.
const RESTART_PAUSE_S: f64 = 1.0;

/// A row that is taken, with its time.
#[derive(Debug)]
pub struct Arrived {
    /// Row as it came.
    pub row: StreamRow,
    /// Time in the flight, s: that of its source, later where the clock of the source began anew; not a number where it has none.
    pub time_s: f64,
    /// Stamp of its source, s; not a number where it has none.
    pub stamp_s: f64,
    /// How often clocks had begun anew before it.
    pub restarts: usize,
}

impl Arrived {
    /// A row that no clock has shifted, none where its source has no clock.
    pub fn new(row: StreamRow, stamp_s: Option<f64>) -> Self {
        let stamp_s = stamp_s.unwrap_or(f64::NAN);
        Self { row, time_s: stamp_s, stamp_s, restarts: 0 }
    }
}

/// What became of the rows of all sources.
#[derive(Debug, Default)]
pub struct Arrivals {
    sources: BTreeMap<Arc<str>, Clock>,
    /// Added to the stamps since each time that a clock began anew, s.
    shifts_s: Vec<f64>,
    newest_s: Option<f64>,
    /// Rows that came again with the same values.
    pub doubled: u64,
    /// Rows with a stamp far from those around it.
    pub stray: u64,
    /// Rows that came after a later one of their source.
    pub reordered: u64,
}

/// Stamps of one source.
#[derive(Debug, Default)]
struct Clock {
    first_s: f64,
    newest_s: f64,
    rows: u64,
    restarts: usize,
    /// Content of the rows within reach, by their stamps.
    recent: BTreeMap<Stamp, u64>,
    /// Rows away from the newest stamp, with their stamps.
    away: Vec<(StreamRow, f64)>,
}

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

/// What is said of a row by its content alone.
fn content(row: &StreamRow) -> u64 {
    let mut hasher = DefaultHasher::new();
    row.values.iter().for_each(|value| value.to_bits().hash(&mut hasher));
    hasher.finish()
}

impl Arrivals {
    /// Takes a row whose stamp is `stamp_s`, none where its source has no clock, and gives those that are taken now.
    pub fn take(&mut self, row: StreamRow, stamp_s: Option<f64>) -> Vec<Arrived> {
        let Some(stamp_s) = stamp_s else { return vec![Arrived::new(row, None)] };
        if !stamp_s.is_finite() {
            self.stray += 1;
            return Vec::new();
        }
        let clock = self.sources.entry(Arc::clone(&row.source)).or_default();
        if !clock.is_within_reach(stamp_s) {
            return self.put_aside(row, stamp_s);
        }
        self.stray += std::mem::take(&mut clock.away).len() as u64;
        if clock.recent.get(&Stamp(stamp_s)) == Some(&content(&row)) {
            self.doubled += 1;
            return Vec::new();
        }
        vec![self.accept(row, stamp_s)]
    }

    /// Rows that still waited for others to confirm their stamps: none followed.
    pub fn finish(&mut self) {
        self.stray += self.sources.values_mut().map(|clock| std::mem::take(&mut clock.away).len() as u64).sum::<u64>();
    }

    /// How often a clock has begun anew.
    pub fn restarts(&self) -> usize {
        self.shifts_s.len()
    }

    /// Keeps a row whose stamp is far from the newest; all that wait are taken once there are enough.
    fn put_aside(&mut self, row: StreamRow, stamp_s: f64) -> Vec<Arrived> {
        let source = Arc::clone(&row.source);
        let Some(clock) = self.sources.get_mut(&source) else { return Vec::new() };
        let is_apart = |(_, last_s): &(StreamRow, f64)| (stamp_s - last_s).abs() > clock.reach_s();
        if clock.away.last().is_some_and(is_apart) {
            self.stray += std::mem::take(&mut clock.away).len() as u64;
        }
        clock.away.push((row, stamp_s));
        if clock.away.len() < STAYS {
            return Vec::new();
        }
        let away = std::mem::take(&mut clock.away);
        let (newest_s, restarts) = (clock.newest_s, clock.restarts);
        let first_s = away.iter().map(|(_, stamp_s)| *stamp_s).fold(f64::INFINITY, f64::min);
        if first_s < newest_s {
            let restarts = self.shift_of(first_s, restarts);
            self.sources.insert(source, Clock { restarts, ..Clock::default() });
        }
        away.into_iter().map(|(row, stamp_s)| self.accept(row, stamp_s)).collect()
    }

    /// Number of the shift for a clock that goes back to `first_s`: that of another source that went back with it, or a new one.
    fn shift_of(&mut self, first_s: f64, restarts: usize) -> usize {
        let newest_s = self.newest_s.unwrap_or(first_s);
        let is_shared = |shift_s: &f64| (first_s + shift_s - newest_s).abs() <= REACH_S;
        if self.shifts_s.len() == restarts || !self.shifts_s.last().is_some_and(is_shared) {
            self.shifts_s.push(newest_s + RESTART_PAUSE_S - first_s);
        }
        self.shifts_s.len()
    }

    fn accept(&mut self, row: StreamRow, stamp_s: f64) -> Arrived {
        let clock = self.sources.entry(Arc::clone(&row.source)).or_default();
        self.reordered += u64::from(clock.rows > 0 && stamp_s < clock.newest_s);
        clock.note(stamp_s, content(&row));
        let restarts = clock.restarts;
        let shift_s = restarts.checked_sub(1).and_then(|last| self.shifts_s.get(last)).copied().unwrap_or(0.0);
        let time_s = stamp_s + shift_s;
        self.newest_s = Some(self.newest_s.map_or(time_s, |newest_s| newest_s.max(time_s)));
        Arrived { row, time_s, stamp_s, restarts }
    }
}

impl Clock {
    /// How far ahead of the newest a stamp may lie, s.
    fn reach_s(&self) -> f64 {
        let interval_s = (self.newest_s - self.first_s) / self.rows.max(2).saturating_sub(1) as f64;
        REACH_S.max(REACH_INTERVALS * interval_s)
    }

    fn is_within_reach(&self, stamp_s: f64) -> bool {
        let ahead_s = stamp_s - self.newest_s;
        // The interval of a source is not known before its third row.
        self.rows == 0 || -ahead_s <= REACH_S && (self.rows < 3 || ahead_s <= self.reach_s())
    }

    fn note(&mut self, stamp_s: f64, content: u64) {
        if self.rows == 0 {
            (self.first_s, self.newest_s) = (stamp_s, stamp_s);
        }
        self.rows += 1;
        self.newest_s = self.newest_s.max(stamp_s);
        self.recent.insert(Stamp(stamp_s), content);
        let oldest_s = self.newest_s - REACH_S;
        while self.recent.first_key_value().is_some_and(|(stamp, _)| stamp.0 < oldest_s) {
            self.recent.pop_first();
        }
    }
}

#[cfg(test)]
mod tests {
    use doublet_core::load::stream::StreamChannel;

    use super::*;

    fn row(source: &str, values: [f64; 2]) -> StreamRow {
        let channels = ["time", "p"].map(|name| StreamChannel { name: name.to_owned(), unit: None });
        StreamRow { source: source.into(), channels: Arc::new(channels), values: values.to_vec() }
    }

    fn times(arrivals: &mut Arrivals, source: &str, stamps: impl IntoIterator<Item = f64>) -> Vec<f64> {
        let taken =
            stamps.into_iter().flat_map(|stamp_s| arrivals.take(row(source, [stamp_s, stamp_s]), Some(stamp_s)));
        taken.map(|arrived| arrived.time_s).collect()
    }

    fn rows_at(start_s: f64, count: u32) -> impl Iterator<Item = f64> {
        (0..count).map(move |k| start_s + 0.1 * f64::from(k))
    }

    #[test]
    fn doubled_rows_are_left_out_and_exchanged_ones_are_not() {
        let mut arrivals = Arrivals::default();
        assert_eq!(times(&mut arrivals, "a", [0.0, 0.2, 0.1, 0.1, 0.3, 0.2]), [0.0, 0.2, 0.1, 0.3]);
        assert_eq!((arrivals.doubled, arrivals.stray, arrivals.reordered), (2, 0, 1));
        // Other values at the same time are another row.
        assert_eq!(arrivals.take(row("a", [0.3, 7.0]), Some(0.3)).len(), 1);
    }

    #[test]
    fn a_lone_stamp_far_off_is_stray() {
        let mut arrivals = Arrivals::default();
        let stamps: Vec<f64> = rows_at(0.0, 50).chain([1e9, -1e9, f64::NAN]).chain(rows_at(5.0, 50)).collect();
        let expected: Vec<f64> = rows_at(0.0, 50).chain(rows_at(5.0, 50)).collect();
        assert_eq!(times(&mut arrivals, "a", stamps), expected);
        assert_eq!((arrivals.stray, arrivals.restarts()), (3, 0));
    }

    #[test]
    fn a_clock_that_begins_anew_is_followed_and_one_shift_serves_all_sources() {
        let mut arrivals = Arrivals::default();
        times(&mut arrivals, "a", rows_at(100.0, 100));
        times(&mut arrivals, "b", rows_at(100.0, 100));
        let a = times(&mut arrivals, "a", rows_at(0.0, 100));
        let b = times(&mut arrivals, "b", rows_at(0.0, 100));
        // The newest stamp was 109.9 s, and the pause is one second.
        assert!((a[0] - 110.9).abs() < 1e-9 && a.len() == 100, "{a:?}");
        assert_eq!((a, arrivals.restarts(), arrivals.stray), (b, 1, 0));
    }

    #[test]
    fn a_slow_source_and_a_long_pause_are_no_faults() {
        let mut arrivals = Arrivals::default();
        let slow: Vec<f64> = (0..20).map(|k| 30.0 * f64::from(k)).collect();
        assert_eq!(times(&mut arrivals, "slow", slow.clone()), slow);
        let paused: Vec<f64> = rows_at(0.0, 20).chain(rows_at(500.0, 20)).collect();
        assert_eq!(times(&mut arrivals, "paused", paused.clone()), paused);
        assert_eq!((arrivals.stray, arrivals.restarts()), (0, 0));
    }
}
