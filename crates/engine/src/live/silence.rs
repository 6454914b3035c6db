//! Silence of a live stream: of all of it, of one of its sources, of the rates without which the estimates stand still.

use std::collections::BTreeMap;
use std::sync::Arc;
use std::time::{Duration, Instant};

use doublet_core::load::stream::RoleSample;
use doublet_core::quantity::Role;

/// Silence after which an alarm is given, and given again while no sample leads to an update.
const SILENCE: Duration = Duration::from_secs(2);
/// Usual intervals without a row after which a slow source is silent.
const INTERVALS: f64 = 3.0;
/// Rows from which the usual interval of a source is known.
const KNOWN_ROWS: u32 = 3;
/// Roles of which the filter needs at least one to go on.
const RATES: [Role; 3] = [Role::RollRate, Role::PitchRate, Role::YawRate];

/// Whether a sample is a value of a rate.
pub(super) fn is_rate(sample: &RoleSample) -> bool {
    sample.value.is_finite() && RATES.contains(&sample.role)
}

/// When what came last.
#[derive(Debug, Default)]
pub(super) struct Silence {
    start: Option<Instant>,
    /// Latest row of any source.
    row: Option<Instant>,
    /// Latest value of a rate.
    rate: Option<Instant>,
    /// Sources of which roles are made.
    sources: BTreeMap<Arc<str>, Seen>,
    /// Latest update with an alarm of silence.
    stated: Option<Instant>,
}

/// Rows of one source.
#[derive(Debug)]
struct Seen {
    first: Instant,
    last: Instant,
    first_s: f64,
    last_s: f64,
    rows: u32,
    has_rates: bool,
}

impl Seen {
    /// Silence after which an alarm is given: longer for a slow source, by its stamps and by the clock.
    fn patience(&self) -> Duration {
        if self.rows < KNOWN_ROWS {
            return SILENCE;
        }
        let by_clock_s = self.last.saturating_duration_since(self.first).as_secs_f64();
        let interval_s = by_clock_s.max(self.last_s - self.first_s) / f64::from(self.rows - 1);
        let patience = Duration::try_from_secs_f64(INTERVALS * interval_s).unwrap_or(Duration::MAX);
        SILENCE.max(patience)
    }
}

impl Silence {
    /// Time without a row of any source; none before the first row.
    pub(super) fn since_row(&self, now: Instant) -> Option<Duration> {
        self.row.map(|last| now.saturating_duration_since(last))
    }

    /// A step at `now`, with rows or without.
    pub(super) fn note_step(&mut self, has_rows: bool, now: Instant) {
        self.start.get_or_insert(now);
        if has_rows {
            self.row = Some(now);
        }
    }

    /// A row of `source` gave these samples.
    pub(super) fn note_samples(&mut self, source: &Arc<str>, time_s: f64, samples: &[RoleSample], now: Instant) {
        if samples.iter().all(|sample| !sample.value.is_finite()) {
            return;
        }
        let has_rates = samples.iter().any(is_rate);
        if has_rates {
            self.rate = Some(now);
        }
        let new = Seen { first: now, last: now, first_s: time_s, last_s: time_s, rows: 0, has_rates: false };
        let seen = self.sources.entry(Arc::clone(source)).or_insert(new);
        seen.rows = seen.rows.saturating_add(1);
        seen.has_rates |= has_rates;
        (seen.last, seen.last_s) = (now, seen.last_s.max(time_s));
    }

    /// Alarms at `now`, a line each.
    pub(super) fn alarms(&self, now: Instant) -> Vec<String> {
        let Some(start) = self.start else { return Vec::new() };
        let silent = |since: Instant| now.saturating_duration_since(since);
        let all = silent(self.row.unwrap_or(start));
        if all >= SILENCE {
            return vec![format!("no data for {} s", all.as_secs())];
        }
        let quiet: Vec<(&Arc<str>, &Seen)> =
            self.sources.iter().filter(|(_, seen)| silent(seen.last) >= seen.patience()).collect();
        let rates = silent(self.rate.unwrap_or(start));
        let are_rates_silent = rates >= SILENCE && !self.is_slow(rates);
        let of_sources = quiet.iter().map(|(name, seen)| {
            // A second source of rates may go on.
            let stops = seen.has_rates && are_rates_silent;
            let effect = if stops { ": no roll, pitch or yaw rate, estimates stand still" } else { "" };
            format!("no data from '{name}' for {} s{effect}", silent(seen.last).as_secs())
        });
        let of_rates = (are_rates_silent && quiet.iter().all(|(_, seen)| !seen.has_rates))
            .then(|| format!("no roll, pitch or yaw rate for {} s: estimates stand still", rates.as_secs()));
        of_sources.chain(of_rates).collect()
    }

    /// Whether a source of rates is slow enough for this silence.
    fn is_slow(&self, rates: Duration) -> bool {
        self.sources.values().any(|seen| seen.has_rates && rates < seen.patience())
    }

    /// Whether alarms are given now: with every update, and again and again where no sample leads to one.
    pub(super) fn is_due(&mut self, has_updates: bool, now: Instant) -> bool {
        let is_due = has_updates || self.stated.is_none_or(|stated| now.saturating_duration_since(stated) >= SILENCE);
        if is_due {
            self.stated = Some(now);
        }
        is_due
    }
}
