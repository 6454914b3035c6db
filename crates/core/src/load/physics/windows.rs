//! Means and slopes of every channel over the same short windows: what relations between channels are tested on.

use std::f64::consts::TAU;

/// Shortest and longest window, s, and its least number of median intervals of most channels.
const LENGTH_S: std::ops::RangeInclusive<f64> = 0.12..=0.4;
/// Fewest windows side by side in a recording that is long enough for them.
const LEAST_COUNT: f64 = 40.0;
const LEAST_INTERVALS: f64 = 2.0;
/// Most windows of a recording.
const MOST_WINDOWS: usize = 400;
/// Most samples of one window that are used.
const MOST_SAMPLES: usize = 40;
/// Part of a turn that an angle jumps by where it is wrapped, and the most that it may exceed a turn by.
const JUMP: f64 = 0.7;
const TURN_EXCESS: f64 = 1.3;

/// Samples of a channel with their stamps.
#[derive(Clone, Copy, Debug)]
pub struct Series<'s> {
    /// Stamps, s.
    pub time_s: &'s [f64],
    /// Values as recorded.
    pub values: &'s [f64],
}

/// A channel in windows.
#[derive(Clone, Debug, Default)]
pub struct Column {
    /// Mean of each window, weighted so that it is the slope of what the channel is the derivative of.
    pub mean: Vec<f64>,
    /// Least-squares slope of each window, per second.
    pub slope: Vec<f64>,
    /// Largest magnitude.
    pub largest: f64,
    /// Least and greatest value.
    pub range: [f64; 2],
    /// Length of a turn, where the values jump by it.
    pub turn: Option<f64>,
}

impl Column {
    /// Whether it varies.
    pub fn varies(&self) -> bool {
        !self.mean.is_empty()
    }
}

/// Channels in the same windows.
#[derive(Clone, Debug, Default)]
pub struct Windows {
    /// The channels, in their order.
    pub columns: Vec<Column>,
    /// Number of windows.
    pub count: usize,
    /// Number of windows that do not overlap.
    pub independent: f64,
}

/// Median interval of stamps, s; none of fewer than 20.
fn interval_s(time_s: &[f64]) -> Option<f64> {
    let span = time_s.last()? - time_s.first()?;
    let interval = span / (time_s.len() - 1) as f64;
    (time_s.len() >= 20 && interval > 0.0 && interval.is_finite()).then_some(interval)
}

/// Cuts every channel into windows, longer by a factor.
pub fn cut(all: &[Series<'_>], factor: f64) -> Windows {
    let mut intervals: Vec<f64> = all.iter().filter_map(|series| interval_s(series.time_s)).collect();
    intervals.sort_by(f64::total_cmp);
    let Some(&interval) = intervals.get(intervals.len() / 2) else { return Windows::default() };
    let usable = || all.iter().filter(|series| interval_s(series.time_s).is_some());
    let start = usable().map(|series| series.time_s[0]).fold(f64::INFINITY, f64::min);
    let end = usable().map(|series| series.time_s[series.time_s.len() - 1]).fold(f64::NEG_INFINITY, f64::max);
    let length_s =
        ((end - start) / LEAST_COUNT).clamp(*LENGTH_S.start(), *LENGTH_S.end()).max(LEAST_INTERVALS * interval)
            * factor;
    let room = end - start - length_s;
    if room.is_nan() || room < 5.0 * length_s {
        return Windows::default();
    }
    let stride = (room / MOST_WINDOWS as f64).max(0.5 * interval);
    #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "positive, at most some thousands")]
    let count = (room / stride) as usize;
    let starts: Vec<f64> = (0..count).map(|k| start + k as f64 * stride).collect();
    let columns = all.iter().map(|series| column(*series, &starts, length_s)).collect();
    Windows { columns, count, independent: (room / length_s).min(count as f64) }
}

/// The turn that an angle jumps by.
fn find_turn(values: &[f64], [least, most]: [f64; 2]) -> Option<f64> {
    let jumps = |turn: f64| {
        let size = |pair: &[f64]| (pair[1] - pair[0]).abs() / turn;
        values.windows(2).filter(|pair| (JUMP..=TURN_EXCESS).contains(&size(pair))).count()
    };
    let span = most - least;
    [360.0, TAU].into_iter().find(|turn| {
        (JUMP * turn..=TURN_EXCESS * turn).contains(&span) && jumps(*turn) > 0 && 50 * jumps(*turn) < values.len()
    })
}

fn column(series: Series<'_>, starts: &[f64], length_s: f64) -> Column {
    let finite = series.values.iter().filter(|value| value.is_finite());
    let range = finite.fold([f64::INFINITY, f64::NEG_INFINITY], |[least, most], v| [least.min(*v), most.max(*v)]);
    let largest = range[0].abs().max(range[1].abs());
    let is_alive = range[1] - range[0] > 1e-9 * largest && largest < 1e12;
    let Some(interval) = interval_s(series.time_s).filter(|_| is_alive && series.values.len() == series.time_s.len())
    else {
        return Column { range, largest, ..Column::default() };
    };
    let turn = find_turn(series.values, range);
    let (mut mean, mut slope) = (Vec::with_capacity(starts.len()), Vec::with_capacity(starts.len()));
    let (mut first, count) = (0, series.time_s.len());
    for &start in starts {
        while first + 1 < count && series.time_s[first] < start - 1e-9 {
            first += 1;
        }
        let (a, b) = if interval > 0.45 * length_s {
            between(series, first, start, length_s, turn)
        } else {
            inside(series, first, start, length_s, turn)
        };
        mean.push(a);
        slope.push(b);
    }
    Column { mean, slope, largest, range, turn }
}

/// Difference of two values without a jump of a turn.
fn step(from: f64, to: f64, turn: Option<f64>) -> f64 {
    turn.map_or(to - from, |turn| (to - from) - turn * ((to - from) / turn).round())
}

/// Mean and slope of the samples of a window.
fn inside(series: Series<'_>, first: usize, start: f64, length_s: f64, turn: Option<f64>) -> (f64, f64) {
    const NONE: (f64, f64) = (f64::NAN, f64::NAN);
    let mut last = first;
    while last + 1 < series.time_s.len() && series.time_s[last + 1] <= start + length_s + 1e-9 {
        last += 1;
    }
    let number = last - first + 1;
    let span = series.time_s[last] - series.time_s[first];
    if number < 3 || span < 0.5 * length_s || span > 1.5 * length_s {
        return NONE;
    }
    let stride = number.div_ceil(MOST_SAMPLES);
    let middle = 0.5 * (series.time_s[first] + series.time_s[last]);
    let (base, mut xx, mut xy, mut sum, mut weights) = (series.values[first], 0.0, 0.0, 0.0, 0.0);
    let (mut xsum, mut ysum, mut samples) = (0.0, 0.0, 0.0);
    for k in (first..=last).step_by(stride) {
        let x = series.time_s[k] - middle;
        let y = step(base, series.values[k], turn);
        // The slope of a line is the mean of the derivative with parabolic weights.
        let weight = (1.0 - (x / (0.5 * span + 0.5 * span / (number as f64))).powi(2)).max(0.0);
        (xx, xy, sum, weights) = (xx + x * x, xy + x * y, sum + weight * y, weights + weight);
        (xsum, ysum, samples) = (xsum + x, ysum + y, samples + 1.0);
    }
    let slope = (xy - xsum * ysum / samples) / (xx - xsum * xsum / samples);
    (base + sum / weights, slope)
}

/// Mean and slope of a window by the values at its ends, linearly between samples: of channels slower than windows.
fn between(series: Series<'_>, first: usize, start: f64, length_s: f64, turn: Option<f64>) -> (f64, f64) {
    let mut at = first.max(1);
    let mut value = |time: f64| {
        while at + 1 < series.time_s.len() && series.time_s[at] < time {
            at += 1;
        }
        let (before, after) = (series.time_s[at - 1], series.time_s[at]);
        let part = (time - before) / (after - before);
        let is_inside = (-1e-9..=1.0 + 1e-9).contains(&part);
        let value = series.values[at - 1] + part * step(series.values[at - 1], series.values[at], turn);
        if is_inside { value } else { f64::NAN }
    };
    let (one, other) = (value(start), value(start + length_s));
    let change = step(one, other, turn);
    (one + 0.5 * change, change / length_s)
}
