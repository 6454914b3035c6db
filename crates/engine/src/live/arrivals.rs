//! Rows by the clock of their source: doubled ones and stray stamps are counted and left out, a clock that begins anew is followed.

use std::collections::BTreeMap;
use std::sync::Arc;

use doublet_core::load::stream::StreamRow;

use super::clock::{Clock, Place, REACH_S};

/// Pause put between the rows before a clock began anew and those after it, s.
const RESTART_PAUSE_S: f64 = 1.0;
/// How far rows of two sources may lie apart whose clocks began anew together, s.
const SHARED_S: f64 = 2.0;
/// Greatest stamp, s: above any clock in nanoseconds that was taken for one in seconds.
const FARTHEST_S: f64 = 1e19;

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

impl Arrivals {
    /// Takes a row whose stamp is `stamp_s`, none where its source has no clock, and gives those that are taken now.
    pub fn take(&mut self, row: StreamRow, stamp_s: Option<f64>) -> Vec<Arrived> {
        let Some(stamp_s) = stamp_s else { return vec![Arrived::new(row, None)] };
        if stamp_s.is_nan() || stamp_s.abs() > FARTHEST_S {
            self.stray += 1;
            return Vec::new();
        }
        let clock = self.sources.entry(Arc::clone(&row.source)).or_default();
        match clock.place(&row, stamp_s) {
            Place::Doubled => {
                self.doubled += 1;
                Vec::new()
            }
            Place::Gap => vec![self.accept(row, stamp_s)],
            Place::Away => self.put_aside(row, stamp_s),
            Place::Ahead => {
                clock.expects_restart = false;
                let away = std::mem::take(&mut clock.away);
                let mut taken = self.release(away);
                taken.push(self.accept(row, stamp_s));
                taken
            }
        }
    }

    /// The files of all sources were written anew: their clocks may begin anew.
    pub fn expect_restart(&mut self) {
        self.sources.values_mut().for_each(|clock| clock.expects_restart = true);
    }

    /// Rows that still waited for others to confirm their stamps: those behind a pause or a restart are taken where they confirm each other,
    /// those of a source that never began have no time.
    pub fn finish(&mut self) -> Vec<Arrived> {
        let mut taken = Vec::new();
        let sources: Vec<_> = self.sources.keys().cloned().collect();
        for source in sources {
            let Some(clock) = self.sources.get_mut(&source) else { continue };
            let confirmed_from = clock.confirmed_at_end();
            let mut away = std::mem::take(&mut clock.away);
            if clock.rows == 0 {
                taken.extend(away.into_iter().map(|(row, _)| Arrived::new(row, None)));
                continue;
            }
            let confirmed = away.split_off(confirmed_from.unwrap_or(away.len()));
            taken.extend(self.release(away));
            taken.extend(self.follow(&source, confirmed));
        }
        taken
    }

    /// How often a clock has begun anew.
    pub fn restarts(&self) -> usize {
        self.shifts_s.len()
    }

    /// Rows that others did not confirm: those within reach are taken, the others are stray.
    fn release(&mut self, away: Vec<(StreamRow, f64)>) -> Vec<Arrived> {
        let mut taken = Vec::new();
        for (row, stamp_s) in away {
            let newest_s = self.sources.get(&row.source).filter(|clock| clock.rows > 0).map(|clock| clock.newest_s);
            if newest_s.is_some_and(|newest_s| (newest_s - REACH_S..=newest_s).contains(&stamp_s)) {
                taken.push(self.accept(row, stamp_s));
            } else {
                self.stray += 1;
            }
        }
        taken
    }

    /// Keeps a row whose stamp is away from the newest; all that wait are taken once there are enough.
    fn put_aside(&mut self, row: StreamRow, stamp_s: f64) -> Vec<Arrived> {
        let source = Arc::clone(&row.source);
        let Some(clock) = self.sources.get_mut(&source) else { return Vec::new() };
        let unconfirmed = if clock.goes_on(stamp_s) { Vec::new() } else { std::mem::take(&mut clock.away) };
        clock.away.push((row, stamp_s));
        let newest_s = self.newest_s.unwrap_or(stamp_s);
        let is_with_others = |shift_s: &f64| (stamp_s + shift_s - newest_s).abs() <= SHARED_S + clock.interval_s();
        let has_shared_restart =
            self.shifts_s.len() > clock.restarts && self.shifts_s.last().is_some_and(is_with_others);
        let confirmed = clock.confirmed_from(clock.expects_restart || has_shared_restart);
        let away = confirmed.map(|from| (std::mem::take(&mut clock.away), from));
        let mut taken = self.release(unconfirmed);
        if let Some((mut away, from)) = away {
            let confirmed = away.split_off(from);
            taken.extend(self.release(away));
            taken.extend(self.follow(&source, confirmed));
        }
        taken
    }

    /// Takes rows that confirm each other: those of a new clock where they begin behind the newest stamp.
    fn follow(&mut self, source: &Arc<str>, confirmed: Vec<(StreamRow, f64)>) -> Vec<Arrived> {
        let first_s = confirmed.iter().map(|(_, stamp_s)| *stamp_s).fold(f64::INFINITY, f64::min);
        let before = self.sources.get(source).filter(|clock| clock.rows > 0 && first_s < clock.newest_s);
        if let Some(restarts) = before.map(|clock| clock.restarts) {
            let restarts = self.shift_of(first_s, restarts);
            self.sources.insert(Arc::clone(source), Clock::begun_anew(restarts));
        }
        confirmed.into_iter().map(|(row, stamp_s)| self.accept(row, stamp_s)).collect()
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
        clock.note(&row, stamp_s);
        let restarts = clock.restarts;
        let shift_s = restarts.checked_sub(1).and_then(|last| self.shifts_s.get(last)).copied().unwrap_or(0.0);
        let time_s = stamp_s + shift_s;
        self.newest_s = Some(self.newest_s.map_or(time_s, |newest_s| newest_s.max(time_s)));
        Arrived { row, time_s, stamp_s, restarts }
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

    /// Rows of rates whose values differ with the start of the clock.
    fn flown(source: &str, start_s: f64, count: u32, value: f64) -> Vec<(StreamRow, f64)> {
        rows_at(start_s, count).map(|stamp_s| (row(source, [stamp_s, value + stamp_s]), stamp_s)).collect()
    }

    fn take_all(arrivals: &mut Arrivals, rows: Vec<(StreamRow, f64)>) -> Vec<Arrived> {
        rows.into_iter().flat_map(|(row, stamp_s)| arrivals.take(row, Some(stamp_s))).collect()
    }

    #[test]
    fn a_clock_that_begins_anew_within_reach_is_followed() {
        let mut arrivals = Arrivals::default();
        take_all(&mut arrivals, flown("imu", 0.0, 80, 1.0));
        let slow = (0..10).map(|k| (row("gps", [f64::from(k), 1.0]), f64::from(k)));
        take_all(&mut arrivals, slow.collect());
        let imu = take_all(&mut arrivals, flown("imu", 0.0, 80, 2.0));
        assert!(imu.len() == 80 && (imu[0].time_s - 10.0).abs() < 1e-9, "{} {}", imu.len(), imu[0].time_s);
        assert!(imu.iter().all(|arrived| arrived.restarts == 1));
        // A slow source follows by the restart of the other, from its second row.
        let gps = take_all(&mut arrivals, (7..9).map(|k| (row("gps", [f64::from(k), 2.0]), f64::from(k))).collect());
        assert_eq!(gps.iter().map(|arrived| arrived.restarts).collect::<Vec<_>>(), [1, 1]);
        assert_eq!((arrivals.restarts(), arrivals.reordered, arrivals.stray, arrivals.doubled), (1, 0, 0, 0));
    }

    #[test]
    fn a_file_written_anew_restarts_the_clock_with_its_second_row() {
        let mut arrivals = Arrivals::default();
        take_all(&mut arrivals, flown("log", 0.0, 80, 1.0));
        arrivals.expect_restart();
        let again = take_all(&mut arrivals, flown("log", 0.0, 2, 2.0));
        assert_eq!((again.len(), arrivals.restarts()), (2, 1));
        // One that goes on is the same flight.
        let mut arrivals = Arrivals::default();
        take_all(&mut arrivals, flown("log", 0.0, 80, 1.0));
        arrivals.expect_restart();
        assert_eq!((take_all(&mut arrivals, flown("log", 8.0, 80, 2.0)).len(), arrivals.restarts()), (80, 0));
    }

    #[test]
    fn rows_up_to_two_seconds_late_are_put_in_order_and_are_no_restart() {
        let mut arrivals = Arrivals::default();
        // Twenty rows wait for those of the next two seconds, again and again.
        let order = (0..40_u32).map(|k| if k.is_multiple_of(2) { k + 1 } else { k - 1 });
        let stamps = order.flat_map(|block| rows_at(2.0 * f64::from(block), 20));
        let taken = times(&mut arrivals, "a", stamps);
        assert_eq!((taken.len(), arrivals.restarts(), arrivals.stray, arrivals.doubled), (800, 0, 0, 0));
        assert_eq!(arrivals.reordered, 400);
    }

    #[test]
    fn rows_behind_a_pause_at_the_end_confirm_each_other() {
        let finished = |stamps: &[f64]| {
            let mut arrivals = Arrivals::default();
            times(&mut arrivals, "a", rows_at(0.0, 50));
            assert!(times(&mut arrivals, "a", stamps.iter().copied()).is_empty());
            let taken: Vec<f64> = arrivals.finish().iter().map(|arrived| arrived.time_s).collect();
            (taken, arrivals.stray, arrivals.restarts())
        };
        assert_eq!(finished(&[500.0, 500.1, 500.2]), (vec![500.0, 500.1, 500.2], 0, 0));
        // A stray stamp before them stays out, and two rows are too few.
        assert_eq!(finished(&[-1e9, 500.0, 500.1, 500.2]), (vec![500.0, 500.1, 500.2], 1, 0));
        assert_eq!(finished(&[500.0, 500.1]), (vec![], 2, 0));
        // A clock that restarted goes on one second after the newest, 4.9 s.
        let (taken, stray, restarts) = finished(&[-100.0, -99.9, -99.8]);
        assert!(taken.iter().zip([5.9, 6.0, 6.1]).all(|(own, other)| (own - other).abs() < 1e-9), "{taken:?}");
        assert_eq!((taken.len(), stray, restarts), (3, 0, 1));
    }

    #[test]
    fn late_rows_at_the_end_are_no_restart() {
        let mut arrivals = Arrivals::default();
        take_all(&mut arrivals, flown("a", 0.0, 50, 1.0));
        assert!(take_all(&mut arrivals, flown("a", 1.0, 5, 2.0)).is_empty());
        assert_eq!((arrivals.finish().len(), arrivals.restarts(), arrivals.stray), (5, 0, 0));
    }

    #[test]
    fn first_stamps_need_a_second_row() {
        for bad_s in [1e9, -1e9, 1e30] {
            let mut arrivals = Arrivals::default();
            let stamps = std::iter::once(bad_s).chain(rows_at(0.0, 50));
            assert_eq!(times(&mut arrivals, "a", stamps), rows_at(0.0, 50).collect::<Vec<_>>(), "{bad_s}");
            assert_eq!((arrivals.stray, arrivals.restarts()), (1, 0));
        }
        // A source of one row has no time; it is not lost.
        let mut arrivals = Arrivals::default();
        assert!(times(&mut arrivals, "a", [7.0]).is_empty());
        assert!(matches!(&arrivals.finish()[..], [only] if only.time_s.is_nan()));
    }
}
