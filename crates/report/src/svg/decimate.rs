//! Fewer points for the same picture: the extremes of every column of the plot.

/// A step this many times the usual one is a gap in the recording.
const GAP_STEPS: f64 = 8.0;

/// Unbroken lines through the samples of `range`, at most about two points in each of `columns` columns: its smallest and largest
/// value in the order they happened. A sample that is not finite, or a gap, breaks the line.
pub fn decimate(x: &[f64], y: &[f64], range: [f64; 2], columns: usize) -> Vec<Vec<(f64, f64)>> {
    let first = x.partition_point(|&x| x < range[0]).saturating_sub(1);
    let end = (x.partition_point(|&x| x <= range[1]) + 1).min(x.len()).min(y.len());
    let mut lines: Vec<Vec<(f64, f64)>> = Vec::new();
    if first >= end {
        return lines;
    }
    let longest = longest_step(&x[first..end]);
    let width = (range[1] - range[0]) / columns.max(1) as f64;
    let mut column = Column::default();
    let mut line = Vec::new();
    let mut before = f64::NEG_INFINITY;
    for k in first..end {
        if !y[k].is_finite() || (before.is_finite() && x[k] - before > longest) {
            column.finish(&mut line);
            if !line.is_empty() {
                lines.push(std::mem::take(&mut line));
            }
            before = f64::NEG_INFINITY;
            if !y[k].is_finite() {
                continue;
            }
        }
        before = x[k];
        let place = ((x[k] - range[0]) / width).floor();
        if place != column.place {
            column.finish(&mut line);
            column.place = place;
        }
        column.add((x[k], y[k]));
    }
    column.finish(&mut line);
    if !line.is_empty() {
        lines.push(line);
    }
    lines
}

/// A few times the median step.
fn longest_step(x: &[f64]) -> f64 {
    let mut steps: Vec<f64> = x.windows(2).map(|pair| pair[1] - pair[0]).collect();
    if steps.is_empty() {
        return f64::INFINITY;
    }
    let middle = steps.len() / 2;
    let (_, &mut median, _) = steps.select_nth_unstable_by(middle, f64::total_cmp);
    GAP_STEPS * median
}

/// What one column of the plot holds so far.
#[derive(Default)]
struct Column {
    place: f64,
    lowest: Option<(f64, f64)>,
    highest: Option<(f64, f64)>,
}

impl Column {
    fn add(&mut self, point: (f64, f64)) {
        if self.lowest.is_none_or(|lowest| point.1 < lowest.1) {
            self.lowest = Some(point);
        }
        if self.highest.is_none_or(|highest| point.1 > highest.1) {
            self.highest = Some(point);
        }
    }

    /// Adds its extremes to the line and forgets them.
    fn finish(&mut self, line: &mut Vec<(f64, f64)>) {
        let (Some(low), Some(high)) = (self.lowest.take(), self.highest.take()) else { return };
        let (early, late) = if low.0 <= high.0 { (low, high) } else { (high, low) };
        line.push(early);
        if late != early {
            line.push(late);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn no_peak_is_lost_and_points_stay_few() {
        let x: Vec<f64> = (0..100_000).map(|k| f64::from(k) * 0.01).collect();
        let mut y: Vec<f64> = x.iter().map(|t| (3.0 * t).sin()).collect();
        y[54_321] = 7.0;
        let lines = decimate(&x, &y, [0.0, 1000.0], 200);
        assert_eq!(lines.len(), 1);
        assert!(lines[0].len() <= 404, "{}", lines[0].len());
        assert!(lines[0].contains(&(x[54_321], 7.0)));
        assert!(lines[0].windows(2).all(|pair| pair[0].0 < pair[1].0));
    }

    #[test]
    fn gaps_and_missing_values_break_the_line() {
        let x = [0.0, 1.0, 2.0, 3.0, 40.0, 41.0, 42.0];
        let y = [0.0, 1.0, f64::NAN, 3.0, 4.0, 5.0, 6.0];
        let lines = decimate(&x, &y, [0.0, 42.0], 1000);
        let lengths: Vec<usize> = lines.iter().map(Vec::len).collect();
        assert_eq!(lengths, [2, 1, 3]);
        assert!(decimate(&[], &[], [0.0, 1.0], 10).is_empty());
    }
}
