//! Steady stretches of a flight, where what a channel still does is its noise.

use super::{PrepError, check};
use crate::series::{Series, Window};

/// How steady stretches are looked for.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SteadySettings {
    /// Length of a window, s; the thesis takes about 10 s (section 4.4.3).
    pub length_s: f64,
    /// Samples are averaged over blocks this long, s, so that noise does not count as motion.
    pub block_s: f64,
    /// Most motion, relative to the quietest tenth of the flight.
    pub max_motion: f64,
    /// Most windows.
    pub most: usize,
}

impl Default for SteadySettings {
    /// Ten seconds in blocks of half a second, twice the motion of the quietest tenth, at most twelve.
    fn default() -> Self {
        Self { length_s: 10.0, block_s: 0.5, max_motion: 2.0, most: 12 }
    }
}

/// A steady window.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SteadyStretch {
    /// When.
    pub window: Window,
    /// Its motion relative to the quietest tenth of the flight, of the signal that moved most.
    pub motion: f64,
}

/// Steady windows inside the spans of `within`, in order of time.
///
/// Each signal's block means have a standard deviation about their straight line over every window; divided by the lowest tenth
/// of the same signal it is the signal's motion. A window is as steady as the signal that moves most. The steadiest are taken
/// that do not overlap. Windows in which a signal lacks a block are left out.
///
/// # Errors
/// Lengths that differ, time that does not increase, a block that is not above zero or longer than a quarter of the window.
pub fn find_steady(
    signals: &[&Series],
    within: &[Window],
    settings: &SteadySettings,
) -> Result<Vec<SteadyStretch>, PrepError> {
    let SteadySettings { length_s, block_s, .. } = *settings;
    if !(block_s > 0.0 && length_s >= 4.0 * block_s && length_s.is_finite()) {
        let allowed = "above zero and at most a quarter of the window, s";
        return Err(PrepError::Setting { setting: "block_s", value: block_s, allowed });
    }
    for series in signals {
        check(&series.time_s, &series.values, "the search for steady flight", 0)?;
    }
    #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "positive and checked above")]
    let blocks = (length_s / block_s).round() as usize;
    let mut candidates: Vec<(f64, Vec<f64>)> = Vec::new();
    for span in within {
        let means: Vec<Vec<f64>> = signals.iter().map(|series| block_means(series, *span, block_s)).collect();
        let count = means.iter().map(Vec::len).min().unwrap_or(0);
        for first in 0..(count + 1).saturating_sub(blocks) {
            let moved = means.iter().map(|means| about_line(&means[first..first + blocks]));
            let moved: Vec<f64> = moved.collect();
            if moved.iter().all(|deviation| deviation.is_finite()) {
                candidates.push((span.start_s + first as f64 * block_s, moved));
            }
        }
    }
    let levels: Vec<f64> = (0..signals.len()).map(|index| lowest_tenth(&candidates, index)).collect();
    let motion = |moved: &[f64]| {
        let relative = moved.iter().zip(&levels).map(|(moved, level)| if *moved > 0.0 { moved / level } else { 0.0 });
        relative.fold(0.0, f64::max)
    };
    let mut ranked: Vec<(f64, f64)> = candidates.iter().map(|(start, moved)| (motion(moved), *start)).collect();
    ranked.retain(|(motion, _)| *motion <= settings.max_motion);
    ranked.sort_by(|a, b| a.0.total_cmp(&b.0));
    let mut found: Vec<SteadyStretch> = Vec::new();
    for (motion, start_s) in ranked {
        let apart = |other: &SteadyStretch| (other.window.start_s - start_s).abs() >= length_s;
        if found.len() < settings.most && found.iter().all(apart) {
            found.push(SteadyStretch { window: Window { start_s, end_s: start_s + length_s }, motion });
        }
    }
    found.sort_by(|a, b| a.window.start_s.total_cmp(&b.window.start_s));
    Ok(found)
}

/// Mean of each block of a span; not a number where a block has no finite sample.
fn block_means(series: &Series, span: Window, block_s: f64) -> Vec<f64> {
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

/// Standard deviation of equally spaced values about their straight line.
fn about_line(values: &[f64]) -> f64 {
    let n = values.len() as f64;
    let middle = 0.5 * (n - 1.0);
    let mean = values.iter().sum::<f64>() / n;
    let (mut xy, mut xx, mut yy) = (0.0, 0.0, 0.0);
    for (k, value) in values.iter().enumerate() {
        let (x, y) = (k as f64 - middle, value - mean);
        (xy, xx, yy) = (xy + x * y, xx + x * x, yy + y * y);
    }
    ((yy - xy * xy / xx).max(0.0) / (n - 2.0)).sqrt()
}

/// Deviation of one signal that a tenth of the windows stay below.
fn lowest_tenth(candidates: &[(f64, Vec<f64>)], index: usize) -> f64 {
    let mut all: Vec<f64> = candidates.iter().map(|(_, moved)| moved[index]).collect();
    if all.is_empty() {
        return 0.0;
    }
    let place = all.len() / 10;
    *all.select_nth_unstable_by(place, f64::total_cmp).1
}
