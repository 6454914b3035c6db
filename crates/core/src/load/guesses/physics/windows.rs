//! Means and slopes of every channel over the same short windows: what relations between channels are tested on.

use std::f64::consts::TAU;

/// Shortest and longest window, s, and its least number of median intervals of most channels.
const LENGTH_S: std::ops::RangeInclusive<f64> = 0.12..=0.4;
/// Fewest windows side by side in a recording that is long enough for them.
const LEAST_COUNT: f64 = 40.0;
const LEAST_INTERVALS: f64 = 2.0;
const MOST_WINDOWS: usize = 400;
/// Windows on either side that the activity of one is averaged over, the part of the largest that motion has at least, and the part of a
/// recording from which all of it counts as motion.
const NEAR: usize = 4;
const LEAST_ACTIVITY: f64 = 0.55;
const MOST_MOVING: f64 = 0.8;
/// Most windows that the fastest are chosen of, and the most that one channel counts for, in units of its deviation.
const MOST_FINE: usize = 20_000;
const LARGEST_SPEED: f64 = 4.0;
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
    /// Of every column the earlier one that it copies.
    pub copies: Vec<Option<usize>>,
    /// Number of windows.
    pub count: usize,
    /// Number of windows that do not overlap.
    pub independent: f64,
    /// Length of a window and time from one to the next, s.
    pub length_s: f64,
    pub stride_s: f64,
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
    let cut = |starts: &[f64]| -> Vec<Column> { all.iter().map(|series| column(*series, starts, length_s)).collect() };
    let columns = cut(&starts);
    let moving = find_motion(&columns, &starts, stride);
    let independent = (stride * count as f64 / length_s).min(count as f64);
    let room: f64 = moving.iter().map(|[from, to]| to - from).sum();
    if moving.is_empty() || room > MOST_MOVING * stride * count as f64 || room < LEAST_COUNT * length_s {
        return Windows { columns, count, independent, length_s, stride_s: stride, ..Windows::default() };
    }
    let stride = (room / MOST_WINDOWS as f64).max(0.5 * interval);
    let mut starts = Vec::with_capacity(MOST_WINDOWS);
    let mut left = 0.0;
    for [from, to] in moving {
        let mut at = from + left;
        while at < to {
            starts.push(at);
            at += stride;
        }
        left = at - to;
    }
    let count = starts.len();
    let independent = independent.min(count as f64);
    Windows { columns: cut(&starts), count, independent, length_s, stride_s: stride, ..Windows::default() }
}

/// Cuts every channel into the windows in which some of them change fastest; nothing where windows cover the recording already.
pub fn cut_fastest(all: &[Series<'_>], windows: &Windows, fast: &[usize]) -> Windows {
    let length_s = windows.length_s;
    if windows.stride_s <= length_s || length_s <= 0.0 {
        return Windows::default();
    }
    let Some(first) = fast.first().and_then(|i| all.get(*i)) else { return Windows::default() };
    let (Some(start), Some(end)) = (first.time_s.first(), first.time_s.last()) else { return Windows::default() };
    #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "positive, limited")]
    let count = (((end - start) / length_s).max(0.0) as usize).min(MOST_FINE);
    let starts: Vec<f64> = (0..count).map(|k| start + k as f64 * length_s).collect();
    let mut speed = vec![0.0; count];
    for series in fast.iter().filter_map(|i| all.get(*i)) {
        let column = column(*series, &starts, length_s);
        let finite = column.slope.iter().filter(|slope| slope.is_finite());
        let (sum, number) = finite.fold((0.0, 0.0), |(sum, number), slope| (sum + slope * slope, number + 1.0));
        let size: f64 = f64::sqrt(sum / number);
        let relative_slope = |slope: &f64| if slope.is_finite() && size > 0.0 { slope.abs() / size } else { 0.0 };
        speed
            .iter_mut()
            .zip(&column.slope)
            .for_each(|(speed, slope)| *speed += relative_slope(slope).min(LARGEST_SPEED));
    }
    let mut order: Vec<usize> = (0..count).collect();
    order.sort_by(|a, b| speed[*b].total_cmp(&speed[*a]));
    order.truncate(MOST_WINDOWS);
    order.sort_unstable();
    let starts: Vec<f64> = order.into_iter().map(|k| starts[k]).collect();
    let columns = all.iter().map(|series| column(*series, &starts, length_s)).collect();
    let count = starts.len();
    Windows { columns, count, independent: count as f64, length_s, stride_s: length_s, ..Windows::default() }
}

/// The parts of a recording in which most of its channels change as fast as they ever do: what stands on the ground shows no relation.
fn find_motion(columns: &[Column], starts: &[f64], stride: f64) -> Vec<[f64; 2]> {
    let count = starts.len();
    let (mut activity, mut number) = (vec![0.0; count], 0.0_f64);
    for column in columns.iter().filter(|column| column.varies()) {
        let mut sizes: Vec<f64> = column.slope.iter().map(|slope| slope.abs()).filter(|s| s.is_finite()).collect();
        sizes.sort_by(f64::total_cmp);
        let Some(&fast) = sizes.get(sizes.len() * 9 / 10).filter(|fast| **fast > 0.0) else { continue };
        number += 1.0;
        for (activity, slope) in activity.iter_mut().zip(&column.slope) {
            *activity += if slope.is_finite() { (slope.abs() / fast).min(1.0) } else { 0.0 };
        }
    }
    let smooth: Vec<f64> = (0..count)
        .map(|k| {
            let near = &activity[k.saturating_sub(NEAR)..(k + NEAR + 1).min(count)];
            near.iter().sum::<f64>() / near.len() as f64 / number.max(1.0)
        })
        .collect();
    let mut sorted = smooth.clone();
    sorted.sort_by(f64::total_cmp);
    let limit = sorted.get(count * 9 / 10).map_or(0.0, |most| LEAST_ACTIVITY * most);
    let mut all: Vec<[f64; 2]> = Vec::new();
    for (start, _) in starts.iter().zip(&smooth).filter(|(_, activity)| **activity > limit) {
        match all.last_mut().filter(|[_, to]| *start < to + 0.5 * stride) {
            Some([_, to]) => *to = start + stride,
            None => all.push([*start, start + stride]),
        }
    }
    all
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
