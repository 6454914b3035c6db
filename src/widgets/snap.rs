//! Moments an edge of a span is drawn to while it is dragged.

use doublet_core::series::gap_threshold_s;

use super::span_editor::Grip;
use super::time_view::TimeRange;

/// How near an edge must come to a moment to be drawn to it, points.
pub const SNAP_REACH: f32 = 8.0;

/// A moment that means something, with the word shown while an edge rests on it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SnapPoint {
    /// When, s.
    pub time_s: f64,
    /// What happens then.
    pub word: &'static str,
}

/// Where a span that was at `origin` is after `grip` moved by `by_s` to within `reach_s` of one of `points`, and that point: the
/// nearest one, the first where two are as near. The span is never empty and stays within `limits`; its length is kept when the
/// whole span moves. `None` where no point is near.
pub fn to_point(
    origin: TimeRange,
    grip: Grip,
    by_s: f64,
    points: &[SnapPoint],
    (reach_s, limits): (f64, TimeRange),
) -> Option<(TimeRange, SnapPoint)> {
    let TimeRange { start_s, end_s } = origin;
    let length_s = origin.length_s();
    let of_start = |point: &SnapPoint| {
        let end_s = if grip == Grip::Body { point.time_s + length_s } else { end_s };
        (point.time_s - start_s - by_s, TimeRange { start_s: point.time_s, end_s }, *point)
    };
    let of_end = |point: &SnapPoint| {
        let start_s = if grip == Grip::Body { point.time_s - length_s } else { start_s };
        (point.time_s - end_s - by_s, TimeRange { start_s, end_s: point.time_s }, *point)
    };
    let starts = points.iter().filter(|_| grip != Grip::End).map(of_start);
    let ends = points.iter().filter(|_| grip != Grip::Start).map(of_end);
    let possible = |part: &TimeRange| {
        let inside = part.start_s >= limits.start_s && part.end_s <= limits.end_s;
        part.end_s > part.start_s && inside
    };
    let near = starts.chain(ends).filter(|(off, part, _)| off.abs() <= reach_s && possible(part));
    near.min_by(|a, b| a.0.abs().total_cmp(&b.0.abs())).map(|(_, part, point)| (part, point))
}

/// Edges of the gaps of a signal that lie in `range`: its last sample before each and its first after it. Samples without a value
/// count as missing.
pub fn gap_edges(time_s: &[f64], values: &[f64], range: TimeRange) -> Vec<SnapPoint> {
    let longest_s = gap_threshold_s(time_s);
    let first = time_s.partition_point(|&t| t < range.start_s).saturating_sub(1);
    let end = (time_s.partition_point(|&t| t <= range.end_s) + 1).min(time_s.len());
    let mut edges = Vec::new();
    let mut last: Option<f64> = None;
    for (&time_s, _) in time_s[first..end].iter().zip(&values[first..end]).filter(|(_, value)| value.is_finite()) {
        if let Some(last) = last.filter(|last| time_s - last > longest_s) {
            edges.extend([last, time_s].map(|time_s| SnapPoint { time_s, word: "gap" }));
        }
        last = Some(time_s);
    }
    edges
}

#[cfg(test)]
mod tests {
    use super::*;

    const POINTS: [SnapPoint; 2] =
        [SnapPoint { time_s: 12.3, word: "onset" }, SnapPoint { time_s: 33.0, word: "marker A" }];
    const LIMITS: TimeRange = TimeRange { start_s: 0.0, end_s: 100.0 };

    fn moved(grip: Grip, by_s: f64) -> Option<(TimeRange, SnapPoint)> {
        to_point(TimeRange { start_s: 10.0, end_s: 30.0 }, grip, by_s, &POINTS, (0.5, LIMITS))
    }

    #[test]
    fn an_edge_within_reach_lands_on_the_point_and_the_other_stays() {
        let onset = TimeRange { start_s: 12.3, end_s: 30.0 };
        assert_eq!(moved(Grip::Start, 2.0), Some((onset, POINTS[0])));
        assert_eq!(moved(Grip::Start, 2.75), Some((onset, POINTS[0])));
        assert_eq!(moved(Grip::Start, 2.85), None);
        assert_eq!(moved(Grip::End, 2.6), Some((TimeRange { start_s: 10.0, end_s: 33.0 }, POINTS[1])));
    }

    #[test]
    fn a_whole_span_keeps_its_length_and_takes_the_edge_that_is_nearer() {
        // At 2.6 the start is 0.3 past the onset, the end 0.4 short of the marker.
        let (part, point) = moved(Grip::Body, 2.6).expect("two points are near");
        assert_eq!((point.word, part.start_s), ("onset", 12.3));
        assert!((part.length_s() - 20.0).abs() < 1e-12);
        let (part, point) = moved(Grip::Body, 2.7).expect("two points are near");
        assert_eq!((point.word, part.end_s), ("marker A", 33.0));
        assert!((part.length_s() - 20.0).abs() < 1e-12);
    }

    #[test]
    fn no_point_makes_a_span_empty_or_leads_it_out_of_the_flight() {
        assert_eq!(moved(Grip::Start, 23.0), None, "the marker lies behind the end");
        let early = [SnapPoint { time_s: -1.0, word: "marker A" }];
        let origin = TimeRange { start_s: 0.0, end_s: 5.0 };
        assert_eq!(to_point(origin, Grip::Start, -1.0, &early, (0.5, LIMITS)), None);
    }

    #[test]
    fn gaps_are_pauses_and_samples_without_a_value() {
        let time_s: Vec<f64> =
            (0..400).map(|k| if k < 200 { 0.1 * f64::from(k) } else { 5.0 + 0.1 * f64::from(k) }).collect();
        let values: Vec<f64> = (0..400).map(|k| if (50..80).contains(&k) { f64::NAN } else { 1.0 }).collect();
        let times = |range| gap_edges(&time_s, &values, range).iter().map(|edge| edge.time_s).collect::<Vec<_>>();
        assert_eq!(times(TimeRange::new(0.0, 50.0)), [time_s[49], time_s[80], time_s[199], time_s[200]]);
        assert_eq!(times(TimeRange::new(18.0, 22.0)), [time_s[199], time_s[200]]);
        assert!(times(TimeRange::new(10.0, 15.0)).is_empty());
    }
}
