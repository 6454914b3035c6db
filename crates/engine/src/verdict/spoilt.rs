//! Samples of a manoeuvre without information: a sensor at the end of its range, a recorder that stalls.

use doublet_core::series::TimeRange;

use super::judge::Evidence;
use super::{saturated, stalls};
use crate::session::{Edit, Fix, Manoeuvre, WindowEdit};

/// Time before and behind such samples that differentiation spreads them to, s.
const MARGIN_S: f64 = 0.1;

/// Whether a part of `range` is in a manoeuvre and not excluded from it.
pub(super) fn is_left(manoeuvre: &Manoeuvre, range: TimeRange) -> bool {
    let is_in = |outer: &TimeRange| range.start_s < outer.end_s && range.end_s > outer.start_s;
    let covers = |outer: &TimeRange| outer.start_s <= range.start_s && outer.end_s >= range.end_s;
    is_in(&manoeuvre.window) && !manoeuvre.excluded.iter().any(covers)
}

/// The excluded parts of a manoeuvre with its spoilt samples among them; none where it has none.
pub(super) fn excluded(evidence: Evidence<'_>, manoeuvre: &Manoeuvre) -> Option<Vec<TimeRange>> {
    let stalled = stalls::inside(evidence, manoeuvre).map(|stall| stall.range);
    let at_end = saturated::rests(evidence.snapshot, manoeuvre).into_iter().flat_map(|rest| rest.parts);
    let mut all = manoeuvre.clone();
    let mut is_any = false;
    for TimeRange { start_s, end_s } in stalled.chain(at_end) {
        let wide = TimeRange { start_s: start_s - MARGIN_S, end_s: end_s + MARGIN_S };
        if let Some(with) = all.excluded_with(wide) {
            all.excluded = with;
            is_any = true;
        }
    }
    is_any.then_some(all.excluded)
}

/// Excludes the saturated and stalled samples of a manoeuvre.
pub(super) fn fix(evidence: Evidence<'_>, manoeuvre: &Manoeuvre) -> Option<Fix> {
    let name = manoeuvre.name.clone();
    let label = format!("exclude the saturated and stalled samples of '{name}'");
    let excluded = excluded(evidence, manoeuvre)?;
    Some(Fix::new(label, Edit::Window(WindowEdit::Exclude { name, excluded })))
}
