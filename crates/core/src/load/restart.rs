//! A recorder that was switched off and on within one file: its clock goes back to where it began and goes on.

use crate::series::ClockRestart;
use crate::statistics::median;

/// Least samples of what follows a step back.
const LEAST_PART: usize = 50;
/// Most parts of a recording.
const MOST_PARTS: usize = 10;
/// Part of what was recorded before that the clock goes back over at least; less is of late or repeated samples.
const GOES_BACK: f64 = 0.9;
/// Pause between two parts, longer than any gap that is bridged, s and median intervals.
const PAUSE_S: f64 = 10.0;
const PAUSE_INTERVALS: f64 = 10.0;

/// Times of which each part behind a restart follows the part before after a pause, and the restarts. None where no stamp goes back, or where
/// the steps back are of something else: late samples, rows of several sources, one part written twice.
pub(crate) fn follow_restarts(stamps_s: &[f64]) -> Option<(Vec<f64>, Vec<ClockRestart>)> {
    let steps = (1..stamps_s.len()).filter(|&at| stamps_s[at] < stamps_s[at - 1]);
    let bounds: Vec<usize> = [0].into_iter().chain(steps.take(MOST_PARTS)).chain([stamps_s.len()]).collect();
    let parts: Vec<&[f64]> = bounds.windows(2).map(|pair| &stamps_s[pair[0]..pair[1]]).collect();
    let is_restarted = parts.windows(2).all(|pair| is_restart(pair[0], pair[1]));
    if parts.len() < 2 || parts.len() > MOST_PARTS || !is_restarted {
        return None;
    }
    let steps = parts.iter().flat_map(|part| part.windows(2)).map(|pair| pair[1] - pair[0]);
    let mut intervals: Vec<f64> = steps.filter(|step_s| *step_s > 0.0).collect();
    let pause_s = PAUSE_S.max(PAUSE_INTERVALS * median(&mut intervals)?);
    let (mut time_s, mut restarts) = (Vec::with_capacity(stamps_s.len()), Vec::new());
    for part in parts {
        let Some(&before_s) = time_s.last() else {
            time_s.extend_from_slice(part);
            continue;
        };
        let (stamp_s, start_s) = (part[0], before_s + pause_s);
        restarts.push(ClockRestart { before_s, stamp_s, time_s: start_s });
        time_s.extend(part.iter().map(|own_s| start_s + (own_s - stamp_s)));
    }
    Some((time_s, restarts))
}

/// Whether a recorder that had the stamps `before` restarted with those `after`.
fn is_restart(before: &[f64], after: &[f64]) -> bool {
    let ([first_s, .., last_s], [start_s, .., end_s]) = (before, after) else { return false };
    let goes_back = last_s - start_s >= GOES_BACK * (last_s - first_s);
    goes_back && after.len() >= LEAST_PART && (first_s, last_s) != (start_s, end_s)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Stamps 0.02 s apart.
    fn part(start_s: f64, count: u32) -> impl Iterator<Item = f64> + Clone {
        (0..count).map(move |k| start_s + 0.02 * f64::from(k))
    }

    #[test]
    fn a_part_behind_a_restart_follows_after_a_pause() {
        let stamps: Vec<f64> = part(3.0, 1000).chain(part(2.5, 600)).chain(part(3.0, 100)).collect();
        let (time_s, restarts) = follow_restarts(&stamps).unwrap();
        assert_eq!((time_s.len(), restarts.len()), (1700, 2));
        assert_eq!(time_s[..1000], stamps[..1000]);
        // The parts last 19.98 s and 11.98 s; the pause is 10 s.
        for (at, expected_s) in [(999, 22.98), (1000, 32.98), (1599, 44.96), (1600, 54.96), (1699, 56.94)] {
            assert!((time_s[at] - expected_s).abs() < 1e-9, "{at}: {} s", time_s[at]);
        }
        assert!(time_s.windows(2).all(|pair| pair[1] > pair[0]));
        let first = restarts[0];
        assert!((first.before_s - 22.98).abs() < 1e-9 && first.stamp_s == 2.5 && first.time_s == time_s[1000]);
    }

    #[test]
    fn a_slow_recorder_has_a_pause_that_is_not_bridged() {
        let minutes: Vec<f64> = (0..60).chain(0..50).map(|k| 60.0 * f64::from(k)).collect();
        let (time_s, _) = follow_restarts(&minutes).unwrap();
        assert_eq!(time_s[60] - time_s[59], 600.0);
    }

    #[test]
    fn other_steps_back_are_no_restart() {
        let late = part(0.0, 1000).chain(part(18.0, 60)).chain(part(20.0, 100));
        let twice = part(0.0, 500).chain(part(0.0, 500));
        let short = part(0.0, 500).chain(part(0.0, 49));
        let sources = (0..20).flat_map(|_| part(0.0, 60));
        let without_step = part(0.0, 500).chain([f64::NAN]).chain(part(0.0, 400));
        let all: [Vec<f64>; 5] =
            [late.collect(), twice.collect(), short.collect(), sources.collect(), without_step.collect()];
        for (at, stamps) in all.iter().enumerate() {
            assert_eq!(follow_restarts(stamps), None, "case {at}");
        }
        assert_eq!(follow_restarts(&[]), None);
    }
}
