//! Steady stretches of a flight, where what a channel still does is its noise.

use super::noise_statistics::noise_statistics;
use super::{PrepError, check, stretches};
use crate::series::{Series, TimeRange, gap_threshold_s};

/// How steady stretches are looked for.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SteadySettings {
    /// Length of a window, s; the thesis takes about 10 s (section 4.4.3).
    pub length_s: f64,
    /// Samples are averaged over blocks this long, s, so that noise does not count as motion.
    pub block_s: f64,
    /// Most motion, relative to the quietest tenth of the flight.
    pub max_motion: f64,
    /// Greatest correlation of successive residuals about a parabola: above it what is left is motion, or filtered, and no noise.
    pub max_lag_one: f64,
    /// Most windows.
    pub most: usize,
}

impl Default for SteadySettings {
    /// Ten seconds in blocks of half a second, twice the motion of the quietest tenth, a correlation of a half, at most twelve.
    fn default() -> Self {
        Self { length_s: 10.0, block_s: 0.5, max_motion: 2.0, max_lag_one: MAX_LAG_ONE, most: 12 }
    }
}

/// Correlation of successive residuals of noise `n` with slow motion `m` beside it: `s_m^2 / (s_m^2 + s_n^2)`. At a half both are
/// alike.
pub(crate) const MAX_LAG_ONE: f64 = 0.5;

/// A signal that tells whether the flight is steady.
#[derive(Clone, Copy, Debug)]
pub struct SteadySignal<'a> {
    /// Its samples.
    pub series: &'a Series,
    /// Greatest standard deviation of its block means about their straight line, in its unit; infinite for a signal that may only
    /// not drift, whose motion is not compared with the rest of the flight and whose noise need not be white.
    pub max_deviation: f64,
    /// Greatest change along that line over the window, in its unit.
    pub max_drift: f64,
}

/// A steady part.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SteadyStretch {
    /// When.
    pub window: TimeRange,
    /// Its motion relative to the quietest tenth of the flight, of the signal that moved most.
    pub motion: f64,
}

/// Steady parts of a flight, and what became of the others.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct SteadySearch {
    /// Windows found, in order of time.
    pub found: Vec<SteadyStretch>,
    /// Windows in which every signal has samples throughout.
    pub looked_at: usize,
    /// Of these, windows in which no signal deviates or drifts too far.
    pub quiet: usize,
    /// Of these, windows whose noise was looked at and is not white.
    pub coloured: usize,
}

/// Steady parts inside the spans of `within`.
///
/// A window counts where every signal has samples throughout, without a pause longer than a few of its intervals. Each signal's
/// block means have a standard deviation about their straight line and a change along it; both stay below the signal's limits.
/// Divided by the lowest tenth of the same signal over the flight, the deviation is the signal's motion; a window is as steady as the
/// signal that moves most. The steadiest are taken that do not overlap and in which what a parabola leaves of every signal is white
/// (its correlation from sample to sample is below the limit).
///
/// # Errors
/// Lengths that differ, time that does not increase, a block that is not above zero or longer than a quarter of the window.
pub fn find_steady(
    signals: &[SteadySignal<'_>],
    within: &[TimeRange],
    settings: &SteadySettings,
) -> Result<SteadySearch, PrepError> {
    let SteadySettings { length_s, block_s, .. } = *settings;
    if !(block_s > 0.0 && length_s >= 4.0 * block_s && length_s.is_finite()) {
        let allowed = "above zero and at most a quarter of the window, s";
        return Err(PrepError::Setting { setting: "block_s", value: block_s, allowed });
    }
    for SteadySignal { series, .. } in signals {
        check(&series.time_s, &series.values, "the search for steady flight", 0)?;
    }
    #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "positive and checked above")]
    let blocks = (length_s / block_s).round() as usize;
    let recorded = signals.iter().fold(within.to_vec(), |spans, signal| intersect(&spans, &recorded(signal.series)));
    let (mut candidates, mut quiet): (Vec<Candidate>, _) = (Vec::new(), Vec::new());
    for span in &recorded {
        let means: Vec<Vec<f64>> = signals.iter().map(|signal| block_means(signal.series, *span, block_s)).collect();
        let count = means.iter().map(Vec::len).min().unwrap_or(0);
        for first in 0..(count + 1).saturating_sub(blocks) {
            let lines: Vec<_> = means.iter().map(|means| about_line(&means[first..first + blocks])).collect();
            if lines.iter().all(|(deviation, _)| deviation.is_finite()) {
                let is_quiet = lines.iter().zip(signals).all(|((deviation, drift), signal)| {
                    *deviation <= signal.max_deviation && drift.abs() <= signal.max_drift
                });
                quiet.push(is_quiet);
                candidates
                    .push((span.start_s + first as f64 * block_s, lines.into_iter().map(|line| line.0).collect()));
            }
        }
    }
    let compared: Vec<usize> = (0..signals.len()).filter(|&index| signals[index].max_deviation.is_finite()).collect();
    let levels: Vec<(usize, f64)> = compared.iter().map(|&index| (index, lowest_tenth(&candidates, index))).collect();
    let motion = |moved: &[f64]| {
        let relative =
            levels.iter().map(|(index, level)| if moved[*index] > 0.0 { moved[*index] / level } else { 0.0 });
        relative.fold(0.0, f64::max)
    };
    let still = candidates.iter().zip(&quiet).filter(|(_, quiet)| **quiet);
    let mut ranked: Vec<(f64, f64)> = still.map(|((start, moved), _)| (motion(moved), *start)).collect();
    ranked.retain(|(motion, _)| *motion <= settings.max_motion);
    ranked.sort_by(|a, b| a.0.total_cmp(&b.0));
    let quiet = quiet.iter().filter(|quiet| **quiet).count();
    let mut search = SteadySearch { looked_at: candidates.len(), quiet, ..SteadySearch::default() };
    for (motion, start_s) in ranked {
        let apart = |other: &SteadyStretch| (other.window.start_s - start_s).abs() >= length_s;
        if search.found.len() >= settings.most || !search.found.iter().all(apart) {
            continue;
        }
        let window = TimeRange { start_s, end_s: start_s + length_s };
        let white = |&index: &usize| is_white(signals[index].series, window, settings.max_lag_one);
        if compared.iter().all(white) {
            search.found.push(SteadyStretch { window, motion });
        } else {
            search.coloured += 1;
        }
    }
    search.found.sort_by(|a, b| a.window.start_s.total_cmp(&b.window.start_s));
    Ok(search)
}

/// Start of a window (s) and the deviation of each signal in it.
type Candidate = (f64, Vec<f64>);

/// Whether successive residuals about a parabola correlate less than `max_lag_one`.
fn is_white(series: &Series, window: TimeRange, max_lag_one: f64) -> bool {
    noise_statistics(series, &[window], 2).is_ok_and(|noise| noise.lag_one <= max_lag_one)
}

/// Spans in which a signal has samples, without a pause longer than a few of its intervals.
fn recorded(series: &Series) -> Vec<TimeRange> {
    let time = series.finite().time_s;
    let ranges = stretches(&time, gap_threshold_s(&time));
    ranges.into_iter().map(|range| TimeRange { start_s: time[range.start], end_s: time[range.end - 1] }).collect()
}

/// What two lists of spans in order of time have in common.
pub fn intersect(a: &[TimeRange], b: &[TimeRange]) -> Vec<TimeRange> {
    let (mut i, mut k) = (0, 0);
    let mut common = Vec::new();
    while let (Some(one), Some(other)) = (a.get(i), b.get(k)) {
        let window = TimeRange { start_s: one.start_s.max(other.start_s), end_s: one.end_s.min(other.end_s) };
        if window.start_s < window.end_s {
            common.push(window);
        }
        if one.end_s < other.end_s {
            i += 1;
        } else {
            k += 1;
        }
    }
    common
}

/// Mean of each block of a span; not a number where a block has no finite sample.
fn block_means(series: &Series, span: TimeRange, block_s: f64) -> Vec<f64> {
    let inside = span.indices(&series.time_s);
    let mut sums: Vec<(f64, f64)> = Vec::new();
    for (time, value) in series.time_s[inside.clone()].iter().zip(&series.values[inside]) {
        #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "inside the span, so not negative")]
        let block = ((time - span.start_s) / block_s) as usize;
        if block >= MOST_BLOCKS {
            break;
        }
        if sums.len() <= block {
            sums.resize(block + 1, (0.0, 0.0));
        }
        if value.is_finite() {
            sums[block].0 += value;
            sums[block].1 += 1.0;
        }
    }
    sums.into_iter().map(|(sum, count)| if count > 0.0 { sum / count } else { f64::NAN }).collect()
}

/// Blocks looked at in one span: a day of half seconds.
const MOST_BLOCKS: usize = 172_800;

/// Standard deviation of equally spaced values about their straight line, and what the line changes by over them.
fn about_line(values: &[f64]) -> (f64, f64) {
    let n = values.len() as f64;
    let middle = 0.5 * (n - 1.0);
    let mean = values.iter().sum::<f64>() / n;
    let (mut xy, mut xx, mut yy) = (0.0, 0.0, 0.0);
    for (k, value) in values.iter().enumerate() {
        let (x, y) = (k as f64 - middle, value - mean);
        (xy, xx, yy) = (xy + x * y, xx + x * x, yy + y * y);
    }
    (((yy - xy * xy / xx).max(0.0) / (n - 2.0)).sqrt(), n * xy / xx)
}

/// Deviation of one signal that a tenth of the windows stay below.
fn lowest_tenth(candidates: &[Candidate], index: usize) -> f64 {
    let mut all: Vec<f64> = candidates.iter().map(|(_, moved)| moved[index]).collect();
    let rank = all.len() / 10;
    crate::statistics::ranked(&mut all, rank).unwrap_or(0.0)
}
