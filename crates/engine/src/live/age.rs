//! Age of the newest sample of a live stream, by the clock of this computer.

use std::time::Instant;

/// Drift of the clock of a source against that of this computer that is taken for one, s per s.
const DRIFT: f64 = 1e-4;

/// When the newest sample came, and when by the clock of its source it was due.
#[derive(Debug, Default)]
pub(super) struct Age {
    start: Option<Instant>,
    newest: Option<Newest>,
}

/// The newest sample.
#[derive(Clone, Copy, Debug)]
struct Newest {
    time_s: f64,
    /// When it came, s since the start.
    arrived_s: f64,
    /// Arrival less time of the samples that came soonest, s.
    least_s: f64,
}

impl Age {
    /// A sample of this time came.
    pub(super) fn note(&mut self, time_s: f64, now: Instant) {
        let arrived_s = self.seconds_to(now);
        let least_s = match self.newest {
            Some(newest) if time_s <= newest.time_s => return,
            Some(newest) => (newest.least_s + DRIFT * (arrived_s - newest.arrived_s)).min(arrived_s - time_s),
            None => arrived_s - time_s,
        };
        self.newest = Some(Newest { time_s, arrived_s, least_s });
    }

    /// The clock of the source began anew: nothing is known of it.
    pub(super) fn forget(&mut self) {
        self.newest = None;
    }

    /// How much later than usual the newest sample is, s: it waited on its way, or nothing came since.
    pub(super) fn age_s(&mut self, now: Instant) -> f64 {
        let now_s = self.seconds_to(now);
        self.newest.map_or(0.0, |newest| (now_s - newest.time_s - newest.least_s).max(0.0))
    }

    fn seconds_to(&mut self, now: Instant) -> f64 {
        now.saturating_duration_since(*self.start.get_or_insert(now)).as_secs_f64()
    }
}

#[cfg(test)]
mod tests {
    use std::time::Duration;

    use super::*;

    #[test]
    fn age_is_what_a_sample_waited_beyond_the_soonest_and_the_silence_since() {
        let (mut age, start) = (Age::default(), Instant::now());
        let at = |seconds: f64| start + Duration::from_secs_f64(seconds);
        assert_eq!(age.age_s(at(0.0)), 0.0);
        (0..100).for_each(|k| age.note(100.0 + 0.1 * f64::from(k), at(5.0 + 0.1 * f64::from(k))));
        assert!(age.age_s(at(14.9)) < 1e-3, "{}", age.age_s(at(14.9)));
        // Three seconds of silence, then a sample that waited two of them.
        assert!((age.age_s(at(17.9)) - 3.0).abs() < 1e-2);
        age.note(111.0, at(18.0));
        assert!((age.age_s(at(18.0)) - 2.0).abs() < 1e-2, "{}", age.age_s(at(18.0)));
        age.forget();
        age.note(0.0, at(19.0));
        assert_eq!(age.age_s(at(19.0)), 0.0);
    }
}
