//! When the controls moved in a record.

use std::ops::Range;

use doublet_core::statistics;

use super::aero::WindowAero;
use super::tolerances::RecordDemand;
use crate::session::{Manoeuvre, Surface};

/// Part of the range of a deflection that counts as moved.
const MOVED: f64 = 0.1;
/// Part at either end of the record that tells the deflection at rest, s.
const REST_S: f64 = 0.5;

/// The input of a record.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Movement {
    pub surface: Surface,
    /// Steady flight before it, s.
    pub before_s: f64,
    /// Time at which it came to rest, s of the recording.
    pub rest_at_s: f64,
    /// Time up to which it stayed there, s of the recording.
    pub rest_until_s: f64,
    /// Largest change from the deflection at the start, rad.
    pub largest_rad: f64,
}

/// The movement of the window's surface, or of that which moved most: from the first departure from where it began to the start of the
/// longest part at where it ended, a tenth of its range to either side. `None` where no deflection is recorded or none moved.
pub fn movement(window: &Manoeuvre, aero: &WindowAero) -> Option<Movement> {
    let moved = movements(aero).filter(|moved| window.surface.is_none_or(|own| own == moved.surface));
    moved.max_by(|a, b| a.largest_rad.abs().total_cmp(&b.largest_rad.abs()))
}

/// The movement of every surface whose deflection is recorded.
pub(super) fn movements(aero: &WindowAero) -> impl Iterator<Item = Movement> + '_ {
    let of_surface = |surface| deflection_movement(surface, &aero.data.time_s, deflection(surface, aero)?);
    Surface::ALL.into_iter().filter_map(of_surface)
}

pub(super) fn deflection_movement(surface: Surface, time_s: &[f64], values: &[f64]) -> Option<Movement> {
    let (&first_s, &last_s) = (time_s.first()?, time_s.last()?);
    let head = time_s.partition_point(|&time| time <= first_s + REST_S);
    let tail = time_s.partition_point(|&time| time < last_s - REST_S);
    let begins = statistics::median(&mut values.get(..head)?.to_vec())?;
    let ends = statistics::median(&mut values.get(tail..)?.to_vec())?;
    let (low, high) = values.iter().fold((begins, begins), |(low, high), &v| (low.min(v), high.max(v)));
    let least = MOVED * (high - low);
    let onset = values.iter().position(|value| (value - begins).abs() > least)?;
    let rest = longest_run(values, onset, |value| (value - ends).abs() <= least)?;
    let largest = values.iter().map(|value| value - begins).max_by(|a, b| a.abs().total_cmp(&b.abs()))?;
    Some(Movement {
        surface,
        before_s: time_s.get(onset)? - first_s,
        rest_at_s: *time_s.get(rest.start)?,
        rest_until_s: *time_s.get(rest.end.checked_sub(1)?)?,
        largest_rad: largest,
    })
}

impl Movement {
    /// Flight with the controls at rest after it, s.
    pub fn after_s(&self) -> f64 {
        self.rest_until_s - self.rest_at_s
    }
}

/// The longest run of values from `first` on that `holds`.
fn longest_run(values: &[f64], first: usize, holds: impl Fn(f64) -> bool) -> Option<Range<usize>> {
    let mut longest: Option<Range<usize>> = None;
    let mut run = first..first;
    for (index, value) in values.iter().enumerate().skip(first) {
        run = if holds(*value) { run.start..index + 1 } else { index + 1..index + 1 };
        if run.len() > longest.as_ref().map_or(0, Range::len) {
            longest = Some(run.clone());
        }
    }
    longest
}

/// Recorded deflection of a surface, rad.
pub fn deflection(surface: Surface, aero: &WindowAero) -> Option<&[f64]> {
    aero.data.controls.get(&surface.role()).map(|column| &**column)
}

/// What the record lacks of what the rule asks for, in words; empty where it lacks nothing. `cycles` are those of its free response.
pub(crate) fn shortfall(
    demand: &RecordDemand,
    movement: Option<&Movement>,
    duration_s: f64,
    cycles: Option<f64>,
) -> Vec<String> {
    /// Part of a demand that may be missing: records end at samples.
    const SLACK: f64 = 0.01;
    let short = |found: f64, asked: f64| asked > 0.0 && found < asked * (1.0 - SLACK);
    let mut lacks = Vec::new();
    let (before_s, after_s) = movement.map_or((0.0, 0.0), |movement| (movement.before_s, movement.after_s()));
    if short(before_s, demand.before_s) {
        lacks.push(format!("{before_s:.1} s before the input ({:.0} s required)", demand.before_s));
    }
    if short(after_s, demand.after_s) {
        lacks.push(format!("{after_s:.1} s after the input ({:.0} s required)", demand.after_s));
    }
    if short(duration_s, demand.least_s) {
        lacks.push(format!("{duration_s:.1} s in all ({:.0} s required)", demand.least_s));
    }
    if let Some(cycles) = cycles.filter(|cycles| short(*cycles, demand.cycles)) {
        lacks.push(format!("{cycles:.1} cycles of the free response ({:.0} required)", demand.cycles));
    }
    lacks
}

#[cfg(test)]
mod tests {
    use super::*;

    /// 20 s at 50 Hz of a deflection.
    fn record(deflection: impl Fn(f64) -> f64) -> Option<Movement> {
        let time_s: Vec<f64> = (0..1000).map(|k| 100.0 + f64::from(k) * 0.02).collect();
        let values: Vec<f64> = time_s.iter().map(|time| deflection(time - 100.0)).collect();
        deflection_movement(Surface::Elevator, &time_s, &values)
    }

    #[test]
    fn an_input_begins_where_it_leaves_the_trim_and_ends_where_it_comes_to_rest() {
        let doublet = |t: f64| match t {
            3.0..4.0 => 0.15,
            4.0..5.0 => -0.05,
            _ => 0.05,
        };
        let found = record(doublet).unwrap();
        assert!((found.before_s - 3.0).abs() < 0.021 && (found.rest_at_s - 105.0).abs() < 0.021);
        assert!((found.after_s() - 14.98).abs() < 0.03 && (found.largest_rad.abs() - 0.1).abs() < 1e-12);
        // A step comes to rest where it was put.
        let step = record(|t| if t < 6.0 { 0.0 } else { 0.2 }).unwrap();
        assert!((step.before_s - 6.0).abs() < 0.021 && (step.rest_at_s - 106.0).abs() < 0.021);
        // Controls taken again at the very end do not make the rest of the record an input.
        let taken = record(|t| if t < 19.9 { doublet(t) } else { 0.08 }).unwrap();
        assert!((taken.rest_at_s - 105.0).abs() < 0.021 && (taken.rest_until_s - 119.88).abs() < 0.03);
        assert_eq!(record(|_| 0.1), None);
    }

    #[test]
    fn a_record_lacks_what_the_rule_asks_for_beyond_it() {
        let movement = record(|t| if (3.0..4.0).contains(&t) { 0.1 } else { 0.0 });
        let lacks = |demand| shortfall(&demand, movement.as_ref(), 20.0, Some(1.7));
        assert!(lacks(RecordDemand { before_s: 3.0, after_s: 15.0, least_s: 20.0, cycles: 1.7 }).is_empty());
        let all = lacks(RecordDemand { before_s: 5.0, after_s: 20.0, least_s: 30.0, cycles: 6.0 });
        assert_eq!(all.len(), 4, "{all:?}");
        assert_eq!(all[0], "3.0 s before the input (5 s required)");
        assert!(lacks(RecordDemand::default()).is_empty());
    }
}
