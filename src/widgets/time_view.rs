//! The part of time on screen, shared by everything that has a time axis.

pub use doublet_core::series::TimeRange;
use serde::{Deserialize, Serialize};

/// Steps of zoom kept to go back to.
const HISTORY: usize = 64;
/// Pauses longer than this end a gesture of the wheel or a pan, s.
const GESTURE_PAUSE_S: f64 = 0.4;
/// Length shown of a part that is too long for what is on screen, over its own.
const REVEALED: f64 = 1.5;
/// Shortest part that can be shown, s.
const SHORTEST_S: f64 = 1e-4;

/// What is on screen: range with its history, the linked cursor and the markers A and B.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct TimeView {
    full: TimeRange,
    range: TimeRange,
    #[serde(skip)]
    back: Vec<TimeRange>,
    #[serde(skip)]
    forward: Vec<TimeRange>,
    #[serde(skip)]
    gesture_at_s: Option<f64>,
    /// Time under the pointer in whichever plot it is, s.
    #[serde(skip)]
    pub cursor_s: Option<f64>,
    /// Instant at which words are asked for, s.
    #[serde(skip)]
    pub annotate_s: Option<f64>,
    /// How often everything was asked for: values of plots are fitted then, too.
    #[serde(skip)]
    homes: u32,
    /// Markers A and B, s.
    pub markers_s: [Option<f64>; 2],
}

impl Default for TimeView {
    fn default() -> Self {
        Self::new(TimeRange { start_s: 0.0, end_s: 1.0 })
    }
}

impl TimeView {
    /// Shows all of `full`.
    pub fn new(full: TimeRange) -> Self {
        let full = TimeRange::new(full.start_s, full.end_s.max(full.start_s + SHORTEST_S));
        Self {
            full,
            range: full,
            back: Vec::new(),
            forward: Vec::new(),
            gesture_at_s: None,
            cursor_s: None,
            annotate_s: None,
            homes: 0,
            markers_s: [None; 2],
        }
    }

    /// The part on screen.
    pub fn range(&self) -> TimeRange {
        self.range
    }

    /// The whole part there is.
    pub fn full(&self) -> TimeRange {
        self.full
    }

    /// Takes the extent of another recording; what is on screen stays where it still lies inside it.
    pub fn set_full(&mut self, full: TimeRange) {
        if full == self.full {
            return;
        }
        let showed_all = self.range == self.full;
        let kept = Self::new(full);
        let overlaps = self.range.start_s < full.end_s && self.range.end_s > full.start_s;
        let range = if showed_all || !overlaps { kept.full } else { self.range };
        *self = Self { range, ..kept };
    }

    /// Shows `range`; the part before can be come back to.
    pub fn zoom_to(&mut self, range: TimeRange) {
        self.gesture_at_s = None;
        self.remember();
        self.range = self.limited(range);
    }

    /// Shows `range` as a part of a gesture that [`Self::zoom_to`] began.
    pub fn drag_to(&mut self, range: TimeRange) {
        self.range = self.limited(range);
    }

    /// Moves along until `part` is on screen; shows it with room about it where it is longer than what is on screen.
    pub fn reveal(&mut self, part: TimeRange) {
        let (range, full) = (self.range, self.full);
        let holds = |outer: TimeRange| part.start_s >= outer.start_s && part.end_s <= outer.end_s;
        if holds(range) || !holds(full) {
            return;
        }
        let middle = 0.5 * (part.start_s + part.end_s);
        let half = 0.5 * range.length_s().max(REVEALED * part.length_s());
        let start_s = (middle - half).min(full.end_s - 2.0 * half).max(full.start_s);
        self.zoom_to(TimeRange { start_s, end_s: start_s + 2.0 * half });
    }

    /// Shows everything.
    pub fn home(&mut self) {
        self.homes = self.homes.wrapping_add(1);
        self.zoom_to(self.full);
    }

    /// How often everything was asked for.
    pub fn homes(&self) -> u32 {
        self.homes
    }

    /// Moves along by `by_s`; moves without a pause count as one step of history. `now_s` is the time of the input.
    pub fn pan(&mut self, by_s: f64, now_s: f64) {
        self.gesture(now_s);
        let (length, full) = (self.range.length_s(), self.full);
        let start = (self.range.start_s + by_s).min(full.end_s - length).max(full.start_s.min(full.end_s - length));
        self.range = TimeRange { start_s: start, end_s: start + length };
    }

    /// Magnifies by `factor` (above 1 shows less) about `about_s`; without a pause it is one step of history.
    pub fn zoom(&mut self, factor: f64, about_s: f64, now_s: f64) {
        self.gesture(now_s);
        let at = |edge: f64| about_s + (edge - about_s) / factor;
        self.range = self.limited(TimeRange::new(at(self.range.start_s), at(self.range.end_s)));
    }

    /// Shows what was shown before; `false` when there is nothing to go back to.
    pub fn go_back(&mut self) -> bool {
        self.gesture_at_s = None;
        self.back.pop().map(|range| self.forward.push(std::mem::replace(&mut self.range, range))).is_some()
    }

    /// Undoes [`Self::go_back`]; `false` when there is nothing to go forward to.
    pub fn go_forward(&mut self) -> bool {
        self.gesture_at_s = None;
        self.forward.pop().map(|range| self.back.push(std::mem::replace(&mut self.range, range))).is_some()
    }

    /// Keeps `range` inside what there is, at least [`SHORTEST_S`] long.
    fn limited(&self, range: TimeRange) -> TimeRange {
        let start_s = range.start_s.max(self.full.start_s).min(self.full.end_s - SHORTEST_S);
        let end_s = range.end_s.min(self.full.end_s).max(start_s + SHORTEST_S);
        TimeRange { start_s, end_s }
    }

    /// Remembers where a gesture began.
    fn gesture(&mut self, now_s: f64) {
        if self.gesture_at_s.is_none_or(|at| now_s - at > GESTURE_PAUSE_S) {
            self.remember();
        }
        self.gesture_at_s = Some(now_s);
    }

    /// Puts what is on screen into the history.
    fn remember(&mut self) {
        if self.back.last() != Some(&self.range) {
            self.back.push(self.range);
            if self.back.len() > HISTORY {
                self.back.remove(0);
            }
        }
        self.forward.clear();
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn view() -> TimeView {
        TimeView::new(TimeRange::new(0.0, 100.0))
    }

    #[test]
    fn zoom_keeps_the_time_under_the_pointer_and_stays_inside() {
        let mut view = view();
        view.zoom(2.0, 25.0, 0.0);
        assert_eq!(view.range(), TimeRange { start_s: 12.5, end_s: 62.5 });
        view.zoom(1e-9, 25.0, 0.1);
        assert_eq!(view.range(), view.full());
        view.zoom(1e12, 100.0, 0.2);
        assert!(view.range().length_s() >= SHORTEST_S * 0.999 && view.range().end_s <= 100.0);
    }

    #[test]
    fn a_gesture_is_one_step_back_and_can_be_gone_forward_again() {
        let mut view = view();
        view.zoom_to(TimeRange::new(10.0, 20.0));
        for k in 0..10 {
            view.pan(1.0, f64::from(k) * 0.05);
        }
        assert_eq!(view.range(), TimeRange::new(20.0, 30.0));
        assert!(view.go_back());
        assert_eq!(view.range(), TimeRange::new(10.0, 20.0));
        assert!(view.go_back());
        assert_eq!(view.range(), view.full());
        assert!(!view.go_back());
        assert!(view.go_forward() && view.go_forward());
        assert_eq!(view.range(), TimeRange::new(20.0, 30.0));
        assert!(!view.go_forward());
    }

    #[test]
    fn pan_stops_at_the_ends_with_its_length_kept() {
        let mut view = view();
        view.zoom_to(TimeRange::new(10.0, 20.0));
        view.pan(1e6, 0.0);
        assert_eq!(view.range(), TimeRange::new(90.0, 100.0));
        view.pan(-1e6, 0.1);
        assert_eq!(view.range(), TimeRange::new(0.0, 10.0));
    }

    #[test]
    fn what_is_off_screen_is_brought_there_and_what_is_on_screen_stays() {
        let mut view = view();
        view.zoom_to(TimeRange::new(10.0, 30.0));
        view.reveal(TimeRange::new(12.0, 28.0));
        assert_eq!(view.range(), TimeRange::new(10.0, 30.0));
        view.reveal(TimeRange::new(60.0, 70.0));
        assert_eq!(view.range(), TimeRange::new(55.0, 75.0));
        view.reveal(TimeRange::new(95.0, 100.0));
        assert_eq!(view.range(), TimeRange::new(80.0, 100.0));
        view.reveal(TimeRange::new(20.0, 60.0));
        assert_eq!(view.range(), TimeRange::new(10.0, 70.0));
        view.reveal(TimeRange::new(90.0, 200.0));
        assert_eq!(view.range(), TimeRange::new(10.0, 70.0), "what no recording has is not gone to");
    }

    #[test]
    fn another_recording_keeps_the_range_only_where_it_overlaps() {
        let mut view = view();
        view.zoom_to(TimeRange::new(10.0, 20.0));
        view.set_full(TimeRange::new(0.0, 50.0));
        assert_eq!(view.range(), TimeRange::new(10.0, 20.0));
        view.set_full(TimeRange::new(500.0, 600.0));
        assert_eq!(view.range(), TimeRange::new(500.0, 600.0));
    }
}
