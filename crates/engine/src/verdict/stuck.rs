//! Findings about channels that stand still in a window while they move elsewhere in the recording.

use doublet_core::message;
use doublet_core::quantity::Role;
use doublet_core::reconstruct::{Input, Measurement};
use doublet_core::series::Series;

use super::judge::Evidence;
use super::{Finding, Level};
use crate::session::{Fix, Manoeuvre, Place};
use crate::snapshot::Snapshot;

/// Shortest standstill, s, and part of the window it takes at least.
const SHORTEST_S: f64 = 3.0;
const PART: f64 = 0.5;
/// Runs of one value up to this many samples are motion, noise or held samples; a channel that has longer ones in more than this part of its
/// other samples has too few steps to tell.
const SHORT_RUN: usize = 10;
const IN_LONG_RUNS: f64 = 0.1;

/// A channel that stands still in a manoeuvre.
pub(super) struct Standstill {
    pub(super) role: Role,
    value: f64,
    length_s: f64,
}

/// The channels of the filter that stand still in a manoeuvre.
pub(super) fn standstills(snapshot: &Snapshot, manoeuvre: &Manoeuvre) -> Vec<Standstill> {
    let Some(flight) = snapshot.flights.get(&manoeuvre.flight).and_then(|slot| slot.ready()) else { return Vec::new() };
    let least_s = least_s(manoeuvre);
    let inputs = Input::ALL.into_iter().map(Input::role);
    let roles = inputs.chain(Measurement::ALL.into_iter().map(Measurement::role));
    let standing = |role: Role| {
        let series = &flight.recording.role(role)?.series;
        let indices = manoeuvre.window.indices(&series.time_s);
        let (value, length_s) = longest_run(&series.time_s[indices.clone()], &series.values[indices])?;
        (length_s >= least_s && moves_else(series, value)).then_some(Standstill { role, value, length_s })
    };
    roles.filter_map(standing).collect()
}

/// Shortest standstill in a manoeuvre, s.
fn least_s(manoeuvre: &Manoeuvre) -> f64 {
    SHORTEST_S.max(PART * (manoeuvre.window.end_s - manoeuvre.window.start_s))
}

/// The channel of the filter that stands still longest in a manoeuvre.
pub(super) fn finding(place: &Place, evidence: Evidence<'_>, manoeuvre: &Manoeuvre) -> Option<Finding> {
    let standing = standstills(evidence.snapshot, manoeuvre);
    let Standstill { role, value, length_s } = standing.into_iter().max_by(|a, b| a.length_s.total_cmp(&b.length_s))?;
    let finding = stuck_finding(place, role, value, length_s, least_s(manoeuvre));
    Some(finding.with_fix(Fix::ignore([manoeuvre.name.as_str()])))
}

fn stuck_finding(place: &Place, role: Role, value: f64, length_s: f64, least_s: f64) -> Finding {
    let name = role.name();
    let text = message!(
        "{} is stuck at {:.4} {} for {:.1} s (limit {:.1} s).",
        name,
        value,
        role.dimension().si_symbol(),
        length_s,
        least_s
    );
    let finding = Finding::new(Level::Bad, "stuck", place, text).with_figure(length_s, least_s);
    let fix_text = "Ignore the manoeuvre, or leave the channel out.";
    finding.with_fix_text(fix_text).with_setting("Flight", "manoeuvre.role")
}

/// Value and length in s of the longest run of one finite value.
fn longest_run(time_s: &[f64], values: &[f64]) -> Option<(f64, f64)> {
    let mut start = 0;
    let runs = values.chunk_by(|a, b| a == b).map(|run| {
        let first = start;
        start += run.len();
        (run[0], time_s[start - 1] - time_s[first])
    });
    runs.filter(|(value, _)| value.is_finite()).max_by(|(_, a), (_, b)| a.total_cmp(b))
}

/// Whether a channel hardly ever keeps another value than `still`.
fn moves_else(series: &Series, still: f64) -> bool {
    let runs = series.values.chunk_by(|a, b| a == b).filter(|run| run[0].is_finite() && run[0] != still);
    let (long, all) = runs
        .fold((0, 0), |(long, all), run| (long + if run.len() > SHORT_RUN { run.len() } else { 0 }, all + run.len()));
    all > SHORT_RUN && (long as f64) < IN_LONG_RUNS * all as f64
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn standstill_is_told_from_few_steps() {
        let series = |step: f64| {
            let time_s: Vec<f64> = (0..1000).map(|k| 0.02 * f64::from(k)).collect();
            let value = |time: f64| ((0.4 * time).sin() / step).round() * step;
            let values = time_s.iter().map(|time| value(time.min(12.0))).collect();
            Series { time_s: time_s.into(), values }
        };
        for (step, is_told) in [(1e-6, true), (0.25, false)] {
            let series = series(step);
            let (value, length_s) = longest_run(&series.time_s[500..], &series.values[500..]).unwrap();
            assert!(length_s > 7.97);
            assert_eq!(moves_else(&series, value), is_told);
        }
    }
}
