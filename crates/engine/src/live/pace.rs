//! Samples held until their time: a recording flown again at any speed.

use std::collections::VecDeque;
use std::time::Instant;

use doublet_core::load::stream::RoleSample;

/// Samples on their way.
#[derive(Debug)]
pub struct Pace {
    /// Seconds of the flight in one of the clock; none for as fast as it goes.
    speed: Option<f64>,
    waiting: VecDeque<RoleSample>,
    start: Option<(Instant, f64)>,
}

/// Samples that wait at most before no more are read.
const MOST_WAITING: usize = 20_000;

impl Pace {
    /// At `speed` times real time; none for as fast as it goes.
    pub fn new(speed: Option<f64>) -> Self {
        Self { speed, waiting: VecDeque::new(), start: None }
    }

    /// Takes in samples in the order they came.
    pub fn put(&mut self, samples: impl Iterator<Item = RoleSample>) {
        self.waiting.extend(samples);
    }

    /// Whether enough wait for now.
    pub(crate) fn is_full(&self) -> bool {
        self.waiting.len() >= MOST_WAITING
    }

    /// Forgets the samples that wait.
    pub fn clear(&mut self) {
        self.waiting.clear();
    }

    /// Whether none waits.
    pub fn is_empty(&self) -> bool {
        self.waiting.is_empty()
    }

    /// The samples whose time has come.
    pub fn due(&mut self, now: Instant) -> Vec<RoleSample> {
        let (Some(speed), Some(first)) = (self.speed, self.waiting.front()) else {
            return self.waiting.drain(..).collect();
        };
        let (start, start_s) = *self.start.get_or_insert((now, first.time_s));
        let due_s = start_s + speed * now.saturating_duration_since(start).as_secs_f64();
        // Samples go on as they came: one that is not due holds those behind it, in the order of arrival.
        let count = self.waiting.iter().take_while(|sample| sample.time_s <= due_s).count();
        self.waiting.drain(..count).collect()
    }
}
