//! Parts of a manoeuvre that are left out.

use doublet_core::series::TimeRange;

use super::Manoeuvre;

/// Parts in the order of time, those that touch as one.
pub(super) fn apart(mut parts: Vec<TimeRange>) -> Vec<TimeRange> {
    parts.sort_by(|a, b| a.start_s.total_cmp(&b.start_s));
    let mut apart: Vec<TimeRange> = Vec::with_capacity(parts.len());
    for part in parts {
        match apart.last_mut() {
            Some(last) if part.start_s <= last.end_s => last.end_s = last.end_s.max(part.end_s),
            _ => apart.push(part),
        }
    }
    apart
}

impl Manoeuvre {
    /// Where it lies, and what of that is left out.
    pub fn samples(&self) -> (TimeRange, &[TimeRange]) {
        (self.window, &self.excluded)
    }

    /// The excluded parts with `part` among them, as far as it lies inside; `None` where it does not.
    pub fn excluded_with(&self, part: TimeRange) -> Option<Vec<TimeRange>> {
        let start_s = part.start_s.max(self.window.start_s);
        let end_s = part.end_s.min(self.window.end_s);
        let inside = TimeRange { start_s, end_s };
        (start_s < end_s).then(|| apart(self.excluded.iter().copied().chain([inside]).collect()))
    }

    /// The excluded parts without what of them lies in `part`.
    pub fn excluded_without(&self, part: TimeRange) -> Vec<TimeRange> {
        let parts = |one: &TimeRange| {
            let before = TimeRange { end_s: one.end_s.min(part.start_s), ..*one };
            let after = TimeRange { start_s: one.start_s.max(part.end_s), ..*one };
            [before, after].into_iter().filter(|part| part.start_s < part.end_s)
        };
        self.excluded.iter().flat_map(parts).collect()
    }

    /// The excluded part at `time_s`.
    pub fn excluded_at(&self, time_s: f64) -> Option<TimeRange> {
        self.excluded.iter().copied().find(|part| part.contains(time_s))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn range(start_s: f64, end_s: f64) -> TimeRange {
        TimeRange { start_s, end_s }
    }

    #[test]
    fn parts_that_touch_are_one_and_stay_inside_the_manoeuvre() {
        let mut manoeuvre = Manoeuvre::new("m".to_owned(), "f".to_owned(), range(10.0, 20.0));
        manoeuvre.excluded = manoeuvre.excluded_with(range(5.0, 11.0)).unwrap();
        assert_eq!(manoeuvre.excluded, [range(10.0, 11.0)]);
        manoeuvre.excluded = manoeuvre.excluded_with(range(13.0, 14.0)).unwrap();
        assert_eq!(manoeuvre.excluded_with(range(10.5, 13.5)).unwrap(), [range(10.0, 14.0)]);
        assert_eq!(manoeuvre.excluded_with(range(20.0, 25.0)), None);
        assert_eq!(manoeuvre.excluded_without(range(10.5, 13.5)), [range(10.0, 10.5), range(13.5, 14.0)]);
        assert_eq!(manoeuvre.excluded_at(13.2), Some(range(13.0, 14.0)));
        assert_eq!(manoeuvre.excluded_at(12.0), None);
        assert_eq!(apart(vec![range(3.0, 4.0), range(1.0, 3.5), range(6.0, 7.0)]), [range(1.0, 4.0), range(6.0, 7.0)]);
    }
}
