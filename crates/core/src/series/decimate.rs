//! Few points that draw like many: extremes per pixel column, exact samples when zoomed in.

use std::ops::Range;

use super::gap::gap_threshold_s;

/// Samples per block of a [`Pyramid`].
const BLOCK: usize = 32;

/// Where the smallest and the largest finite sample of a stretch are.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
struct Extremes {
    low: u32,
    high: u32,
}

/// Extremes of every block of samples, so that a column of many samples is read without visiting them all.
#[derive(Clone, Debug, Default)]
pub struct Pyramid {
    blocks: Vec<Option<Extremes>>,
    gap_s: f64,
}

/// Points ready to draw, of whatever type the canvas takes.
#[derive(Clone, Debug)]
pub struct Decimated<P> {
    /// All points, in time order, without a value that is not finite.
    pub points: Vec<P>,
    /// Unbroken stretches of `points`.
    pub segments: Vec<Range<usize>>,
    /// Smallest and largest value drawn, `None` when nothing is.
    pub extent: Option<(f64, f64)>,
    /// Sum of all changes of value along the lines.
    pub travel: f64,
    last: f64,
}

impl<P> Default for Decimated<P> {
    fn default() -> Self {
        Self { points: Vec::new(), segments: Vec::new(), extent: None, travel: 0.0, last: f64::NAN }
    }
}

impl<P: From<[f64; 2]>> Decimated<P> {
    /// Unbroken lines.
    pub fn lines(&self) -> impl Iterator<Item = &[P]> {
        self.segments.iter().map(|segment| &self.points[segment.clone()])
    }

    /// Empties it and keeps its memory.
    fn clear(&mut self) {
        self.points.clear();
        self.segments.clear();
        self.extent = None;
        self.travel = 0.0;
    }

    /// Adds a point to the current line, or to a new one after a break.
    fn push(&mut self, time_s: f64, value: f64, broken: bool) {
        let at = self.points.len();
        if !broken && at > 0 {
            self.travel += (value - self.last).abs();
        }
        self.last = value;
        self.points.push(P::from([time_s, value]));
        match self.segments.last_mut() {
            Some(segment) if !broken => segment.end = at + 1,
            _ => self.segments.push(at..at + 1),
        }
        let (low, high) = self.extent.get_or_insert((value, value));
        *low = low.min(value);
        *high = high.max(value);
    }
}

impl Pyramid {
    /// Reads the samples once.
    pub fn new(time_s: &[f64], values: &[f64]) -> Self {
        let blocks =
            (0..values.len()).step_by(BLOCK).map(|at| extremes(values, at..(at + BLOCK).min(values.len()))).collect();
        Self { blocks, gap_s: gap_threshold_s(time_s) }
    }

    /// Extremes of `range`, visiting samples only at its ragged ends.
    fn extremes(&self, values: &[f64], range: Range<usize>) -> Option<Extremes> {
        let (first, last) = (range.start.div_ceil(BLOCK), range.end / BLOCK);
        if first >= last {
            return extremes(values, range);
        }
        let ends = [extremes(values, range.start..first * BLOCK), extremes(values, last * BLOCK..range.end)];
        self.blocks[first..last].iter().copied().chain(ends).flatten().reduce(|a, b| Extremes {
            low: if values[b.low as usize] < values[a.low as usize] { b.low } else { a.low },
            high: if values[b.high as usize] > values[a.high as usize] { b.high } else { a.high },
        })
    }
}

/// Extremes of the finite samples of `range`.
fn extremes(values: &[f64], range: Range<usize>) -> Option<Extremes> {
    let (mut low, mut high) = (f64::INFINITY, f64::NEG_INFINITY);
    let mut found = Extremes { low: u32::MAX, high: u32::MAX };
    for (at, &value) in range.clone().zip(&values[range]) {
        // Comparisons with NaN are false; the second half of each keeps infinities out.
        if value < low && value > f64::NEG_INFINITY {
            low = value;
            found.low = at as u32;
        }
        if value > high && value < f64::INFINITY {
            high = value;
            found.high = at as u32;
        }
    }
    (found.low != u32::MAX && found.high != u32::MAX).then_some(found)
}

/// The first index from `from` to `end` at or after `edge_s`, looked for about `hint` samples on.
fn advance(time_s: &[f64], from: usize, end: usize, edge_s: f64, hint: usize) -> usize {
    let mut step = 4;
    let (mut low, mut high) = (from, (from + hint).min(end));
    while high < end && time_s[high] < edge_s {
        low = high + 1;
        high = (high + step).min(end);
        step *= 2;
    }
    if low == from && high > from + 8 && time_s[high - 8] < edge_s {
        low = high - 8;
    }
    low + time_s[low..high].partition_point(|&t| t < edge_s)
}

/// Index range of the samples to draw for `range_s`: those inside and one neighbour on each side.
fn visible(time_s: &[f64], range_s: (f64, f64)) -> Range<usize> {
    let first = time_s.partition_point(|&t| t < range_s.0).saturating_sub(1);
    let end = (time_s.partition_point(|&t| t <= range_s.1) + 1).min(time_s.len());
    first..end.max(first)
}

/// Points of `values` (times `scale`) over `range_s` for `columns` pixel columns, written into `out`.
///
/// Up to two samples per column every sample is drawn. Above, a column gives its smallest and its largest sample in
/// the order they happened, so no peak is lost. A sample that is not finite, or a step much longer than usual, breaks
/// the line; once columns hold several samples only a break of a whole column shows.
pub fn decimate<P: From<[f64; 2]>>(
    pyramid: &Pyramid,
    time_s: &[f64],
    values: &[f64],
    scale: f64,
    range_s: (f64, f64),
    columns: usize,
    out: &mut Decimated<P>,
) {
    out.clear();
    let shown = visible(time_s, range_s);
    if shown.len() <= 2 * columns.max(1) {
        exact(pyramid.gap_s, time_s, values, scale, shown, out);
        return;
    }
    let width_s = (range_s.1 - range_s.0) / columns as f64;
    // Columns keep their place in time while the view pans, so that the picture moves without flickering.
    let first_column = (range_s.0 / width_s).floor();
    let mut at = shown.start;
    let mut broken = true;
    let mut last_s = f64::NEG_INFINITY;
    let mut hint = shown.len() / columns;
    for column in 0..=columns {
        let edge_s = width_s * (first_column + (column + 1) as f64);
        let end = if column == columns { shown.end } else { advance(time_s, at, shown.end, edge_s, hint) };
        hint = end - at;
        if end == at {
            continue;
        }
        broken |= time_s[at] - last_s > pyramid.gap_s;
        match pyramid.extremes(values, at..end) {
            Some(Extremes { low, high }) => {
                let (first, second) = (low.min(high) as usize, low.max(high) as usize);
                out.push(time_s[first], scale * values[first], broken);
                if second != first {
                    out.push(time_s[second], scale * values[second], false);
                }
                broken = false;
            }
            None => broken = true,
        }
        last_s = time_s[end - 1];
        at = end;
    }
}

/// Every finite sample of `shown`, broken at gaps.
fn exact<P: From<[f64; 2]>>(
    gap_s: f64,
    time_s: &[f64],
    values: &[f64],
    scale: f64,
    shown: Range<usize>,
    out: &mut Decimated<P>,
) {
    let mut broken = true;
    let mut last_s = f64::NEG_INFINITY;
    for at in shown {
        if values[at].is_finite() {
            broken |= time_s[at] - last_s > gap_s;
            out.push(time_s[at], scale * values[at], broken);
            broken = false;
        } else {
            broken = true;
        }
        last_s = time_s[at];
    }
}

/// A band around a line: centre plus and minus a half width, reduced like the line. Segments break where either is
/// not finite.
#[derive(Clone, Debug, Default)]
pub struct Band {
    /// Times, s.
    pub time_s: Vec<f64>,
    /// Lower edge.
    pub low: Vec<f64>,
    /// Upper edge.
    pub high: Vec<f64>,
    /// Unbroken stretches.
    pub segments: Vec<Range<usize>>,
}

/// The band `values +- factor * sigma` over `range_s` for `columns` pixel columns (all times `scale`), written into
/// `out`: each column gives the lowest lower and the highest upper edge of its samples.
pub fn decimate_band(
    series: (&[f64], &[f64], &[f64]),
    scale: f64,
    factor: f64,
    range_s: (f64, f64),
    columns: usize,
    out: &mut Band,
) {
    let (time_s, values, sigma) = series;
    out.time_s.clear();
    out.low.clear();
    out.high.clear();
    out.segments.clear();
    let shown = visible(time_s, range_s);
    let per_point = shown.len().div_ceil(columns.max(1)).max(1);
    let mut broken = true;
    for first in shown.clone().step_by(per_point) {
        let end = (first + per_point).min(shown.end);
        let edges = (first..end)
            .map(|at| (scale * values[at], (scale * factor * sigma[at]).abs()))
            .filter(|(centre, half)| (centre + half).is_finite())
            .map(|(centre, half)| (centre - half, centre + half))
            .reduce(|a, b| (a.0.min(b.0), a.1.max(b.1)));
        let Some((low, high)) = edges else {
            broken = true;
            continue;
        };
        let at = out.time_s.len();
        out.time_s.push(0.5 * (time_s[first] + time_s[end - 1]));
        out.low.push(low);
        out.high.push(high);
        match out.segments.last_mut() {
            Some(segment) if !broken => segment.end = at + 1,
            _ => out.segments.push(at..at + 1),
        }
        broken = false;
    }
}

impl Pyramid {
    /// Longest step that is still no gap, s.
    pub fn gap_s(&self) -> f64 {
        self.gap_s
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const STEP_S: f64 = 0.01;

    fn time(count: usize) -> Vec<f64> {
        (0..count).map(|k| k as f64 * STEP_S).collect()
    }

    fn reduced(time_s: &[f64], values: &[f64], range_s: (f64, f64), columns: usize) -> Decimated<[f64; 2]> {
        let mut out = Decimated::default();
        decimate(&Pyramid::new(time_s, values), time_s, values, 1.0, range_s, columns, &mut out);
        out
    }

    #[test]
    fn every_single_sample_peak_survives_decimation() {
        let time = time(100_000);
        for spike in [0, 1, 63, 64, 12_345, 54_321, 99_999] {
            let mut values: Vec<f64> = time.iter().map(|t| t.sin()).collect();
            values[spike] = 7.0;
            values[99_999 - spike] = -9.0;
            let out = reduced(&time, &values, (0.0, time[99_999]), 800);
            assert_eq!(out.extent, Some((-9.0, 7.0)), "spike at {spike}");
            assert!(out.points.iter().any(|p| p[0] == time[spike] && p[1] == 7.0));
            assert!(out.points.len() <= 2 * 801);
            assert_eq!(out.segments.len(), 1);
            assert!(out.points.is_sorted_by(|a, b| a[0] < b[0]));
        }
    }

    #[test]
    fn column_edges_are_found_whatever_the_hint() {
        let time: Vec<f64> = (0..500).map(|k| f64::from(k * k) * 1e-3).collect();
        for from in [0, 7, 123, 499] {
            for edge_s in [-1.0, 0.0, 0.05, 3.3, 100.0, 248.9, 1e9] {
                for hint in [0, 1, 9, 50, 1000] {
                    let expected = from + time[from..].partition_point(|&t| t < edge_s);
                    assert_eq!(advance(&time, from, 500, edge_s, hint), expected, "from {from} hint {hint}");
                }
            }
        }
    }

    #[test]
    fn panning_keeps_the_points_in_their_columns() {
        let time = time(100_000);
        let values: Vec<f64> = (0..100_000).map(|k| f64::from((k * 7919) % 1013)).collect();
        let before = reduced(&time, &values, (100.0, 700.0), 600);
        let after = reduced(&time, &values, (103.5, 703.5), 600);
        let inside = |points: &[[f64; 2]]| -> Vec<[f64; 2]> {
            points.iter().filter(|p| (110.0..690.0).contains(&p[0])).map(|p| [p[0], p[1]]).collect()
        };
        assert_eq!(inside(&before.points), inside(&after.points));
    }

    #[test]
    fn pyramid_agrees_with_reading_every_sample() {
        let values: Vec<f64> =
            (0..1000).map(|k| if k % 97 < 3 { f64::NAN } else { ((k * 7919) % 1013) as f64 }).collect();
        let pyramid = Pyramid::new(&time(1000), &values);
        for start in (0..1000).step_by(37) {
            for end in (start..1000).step_by(41) {
                let value = |e: Option<Extremes>| e.map(|e| (values[e.low as usize], values[e.high as usize]));
                assert_eq!(value(pyramid.extremes(&values, start..end)), value(extremes(&values, start..end)));
            }
        }
    }

    #[test]
    fn zoomed_in_shows_the_exact_samples_and_one_neighbour_on_each_side() {
        let time = time(10_000);
        let values: Vec<f64> = time.iter().map(|t| t * t).collect();
        let out = reduced(&time, &values, (50.002, 50.998), 500);
        let expected: Vec<f64> = time[5000..=5100].to_vec();
        assert_eq!(out.points.iter().map(|p| p[0]).collect::<Vec<_>>(), expected);
        assert_eq!(out.points[0][1], values[5000]);
    }

    #[test]
    fn values_not_finite_split_the_line_and_are_never_drawn() {
        let time = time(100);
        let mut values = vec![1.0; 100];
        values[20] = f64::NAN;
        values[40..60].fill(f64::INFINITY);
        let out = reduced(&time, &values, (0.0, 1.0), 500);
        assert_eq!(out.segments, vec![0..20, 20..39, 39..79]);
        assert!(out.points.iter().all(|p| p[1].is_finite()));
    }

    #[test]
    fn missing_samples_split_the_line_zoomed_out_and_in() {
        let mut time = time(200_000);
        for t in &mut time[100_000..] {
            *t += 500.0;
        }
        let values = vec![0.5; 200_000];
        assert_eq!(reduced(&time, &values, (0.0, 2500.0), 600).segments.len(), 2);
        assert_eq!(reduced(&time, &values, (999.0, 1501.0), 600).segments.len(), 2);
        let mut holes = values.clone();
        holes[50_000..60_000].fill(f64::NAN);
        assert_eq!(reduced(&time, &holes, (0.0, 2500.0), 600).segments.len(), 3);
    }

    #[test]
    fn slow_channel_among_dense_columns_is_not_broken() {
        let time: Vec<f64> = (0..100).map(|k| k as f64).collect();
        assert_eq!(reduced(&time, &time, (0.0, 99.0), 2000).segments, vec![0..100]);
    }

    #[test]
    fn nothing_to_draw_gives_no_points() {
        assert!(reduced(&[], &[], (0.0, 1.0), 100).points.is_empty());
        assert!(reduced(&time(500), &[f64::NAN; 500], (0.0, 5.0), 100).points.is_empty());
        let outside = reduced(&time(10), &[1.0; 10], (50.0, 60.0), 100);
        assert!(outside.points.len() <= 1);
    }

    #[test]
    fn band_encloses_every_edge_and_breaks_where_sigma_is_unknown() {
        let time = time(4000);
        let values = vec![1.0; 4000];
        let mut sigma: Vec<f64> = (0..4000).map(|k| if k == 1777 { 5.0 } else { 0.1 }).collect();
        sigma[2400..2800].fill(f64::NAN);
        let mut band = Band::default();
        decimate_band((&time, &values, &sigma), 2.0, 2.0, (0.0, 40.0), 400, &mut band);
        assert_eq!(band.segments.len(), 2);
        assert_eq!(band.high.iter().copied().fold(f64::MIN, f64::max), 2.0 * (1.0 + 2.0 * 5.0));
        assert_eq!(band.low.iter().copied().fold(f64::MAX, f64::min), 2.0 * (1.0 - 2.0 * 5.0));
        assert!(band.time_s.len() <= 401);
    }
}
