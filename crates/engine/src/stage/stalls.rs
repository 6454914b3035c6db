//! Stalls of a recorder: blocks in which the channels of a source repeat one value together.

use std::collections::BTreeMap;

use doublet_core::quantity::Role;
use doublet_core::series::{Series, TimeRange};

use super::LoadedFlight;

/// Equal samples in a row that may be a stall.
const IN_A_ROW: usize = 4;
/// Channels that repeat together at least, and part of the moving channels of the source that they are.
const CHANNELS: usize = 4;
const PART: f64 = 0.75;
/// Part of its samples that a moving channel has in such rows at most: one that has more has few steps, or a sensor slower than the recorder.
const IN_ROWS: f64 = 0.2;
/// Part of the samples of the fastest channel of a source that a channel has at least: a slower one may repeat nothing in a stall.
const OF_FASTEST: f64 = 0.5;

/// A block in which a recorder stalls.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Stall {
    /// From its first sample, which is a true one, to its last.
    pub range: TimeRange,
    /// Channels that repeat one value.
    pub channels: usize,
}

/// The stalls of the recorders of a flight, by the channels that have a role, as recorded.
pub(super) fn find_stalls(flight: &LoadedFlight) -> Vec<Stall> {
    let recorded = |(role, index): (&Role, &usize)| {
        flight.treated.iter().find(|treated| treated.role == *role).map_or(*index, |treated| treated.recorded)
    };
    let mut sources: BTreeMap<&str, Vec<Series>> = BTreeMap::new();
    let mut indices: Vec<usize> = flight.recording.roles.iter().map(recorded).collect();
    indices.sort_unstable();
    indices.dedup();
    for channel in indices.into_iter().filter_map(|index| flight.recording.channels.get(index)) {
        sources.entry(&channel.source).or_default().push(channel.series.finite());
    }
    sources.values().flat_map(|channels| of_source(channels)).collect()
}

fn of_source(channels: &[Series]) -> Vec<Stall> {
    let fastest = channels.iter().map(|series| series.values.len()).max().unwrap_or(0);
    let fast = channels.iter().filter(|series| series.values.len() as f64 >= OF_FASTEST * fastest as f64);
    let moving: Vec<Vec<TimeRange>> = fast.filter_map(rows).collect();
    let are_enough = |count: usize| count >= CHANNELS && count as f64 >= PART * moving.len() as f64;
    let mut edges: Vec<(f64, bool)> =
        moving.iter().flatten().flat_map(|row| [(row.start_s, false), (row.end_s, true)]).collect();
    edges.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
    let (mut found, mut now, mut since) = (Vec::new(), 0_usize, None);
    for (time_s, is_end) in edges {
        if !is_end {
            now += 1;
            if are_enough(now) {
                let (start_s, most) = since.unwrap_or((time_s, 0));
                since = Some((start_s, now.max(most)));
            }
            continue;
        }
        now -= 1;
        if !are_enough(now)
            && let Some((start_s, channels)) = since.take()
        {
            found.push(Stall { range: TimeRange { start_s, end_s: time_s }, channels });
        }
    }
    found.retain(|stall| stall.range.end_s > stall.range.start_s);
    found
}

/// The rows of equal samples of a channel; none where it has too many of them to be a moving one.
fn rows(series: &Series) -> Option<Vec<TimeRange>> {
    let (mut rows, mut next, mut samples) = (Vec::new(), 0, 0);
    for row in series.values.chunk_by(|a, b| a == b) {
        let first = next;
        next += row.len();
        if row.len() >= IN_A_ROW {
            samples += row.len();
            rows.push(TimeRange { start_s: series.time_s[first], end_s: series.time_s[next - 1] });
        }
    }
    ((samples as f64) <= IN_ROWS * next as f64 && next > 0).then_some(rows)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Four channels of one source, each with its own motion, that hold their values in `held` (s).
    fn channels(held: &[[f64; 2]], step: f64) -> Vec<Series> {
        let time_s: Vec<f64> = (0..2000).map(|k| 0.02 * f64::from(k)).collect();
        let at = |time_s: f64| {
            let row = held.iter().find(|[start_s, end_s]| (*start_s..*end_s).contains(&time_s));
            row.map_or(time_s, |[start_s, _]| *start_s)
        };
        let value = |rate: f64| {
            let values = time_s.iter().map(|time_s| ((rate * at(*time_s)).sin() / step).round() * step);
            Series { time_s: time_s.clone().into(), values: values.collect() }
        };
        [0.7, 1.1, 1.9, 2.3].map(value).to_vec()
    }

    #[test]
    fn channels_that_repeat_together_are_a_stall_and_one_alone_or_few_steps_are_none() {
        let held = [[9.2, 9.6], [29.0, 29.4], [31.0, 31.2]];
        let found = of_source(&channels(&held, 1e-6));
        assert_eq!(found.len(), 3, "{found:?}");
        for (stall, [start_s, end_s]) in found.iter().zip(held) {
            assert_eq!(stall.channels, 4);
            assert!(
                (stall.range.start_s - start_s).abs() < 0.021 && (stall.range.end_s - end_s).abs() < 0.041,
                "{stall:?}"
            );
        }
        // Two samples more are no stall, nor are two of four channels, nor those of few steps.
        assert_eq!(of_source(&channels(&[[9.2, 9.25]], 1e-6)), []);
        let mut two = channels(&held, 1e-6);
        two[..2].clone_from_slice(&channels(&[], 1e-6)[..2]);
        assert_eq!(of_source(&two), []);
        assert_eq!(of_source(&channels(&[], 0.25)), []);
        assert_eq!(of_source(&channels(&[], 1e-6)), []);
    }
}
