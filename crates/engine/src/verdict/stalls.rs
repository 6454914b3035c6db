//! Findings about recorders that stall.

use doublet_core::message;

use super::judge::Evidence;
use super::{Finding, Level, spoilt};
use crate::session::{Manoeuvre, Place};
use crate::stage::Stall;

/// The stalls inside a manoeuvre that are not excluded from it.
pub(super) fn inside<'a>(evidence: Evidence<'a>, manoeuvre: &'a Manoeuvre) -> impl Iterator<Item = &'a Stall> {
    let flight = evidence.snapshot.flights.get(&manoeuvre.flight).and_then(|slot| slot.ready());
    let all = flight.into_iter().flat_map(|flight| &flight.stalls);
    all.filter(move |stall| spoilt::is_left(manoeuvre, stall.range))
}

/// The stalls of the recorder in a manoeuvre.
pub(super) fn finding(place: &Place, evidence: Evidence<'_>, manoeuvre: &Manoeuvre) -> Option<Finding> {
    let (mut count, mut longest_s, mut channels) = (0_usize, 0.0_f64, 0);
    for stall in inside(evidence, manoeuvre) {
        count += 1;
        longest_s = longest_s.max(stall.range.end_s - stall.range.start_s);
        channels = channels.max(stall.channels);
    }
    if count == 0 {
        return None;
    }
    let text = message!(
        "Recording stalls: {} {} of up to {:.2} s in {} channels.",
        count,
        if count == 1 { "block" } else { "blocks" },
        longest_s,
        channels
    );
    let finding = Finding::new(Level::Caution, "stuck", place, text).with_figure(longest_s, 0.0);
    let finding = finding.with_fix_text(FIX).with_setting("Manoeuvres", "manoeuvre.exclude");
    Some(finding.with_fix(spoilt::fix(evidence, manoeuvre)))
}

/// What to do about a stall.
pub(super) const FIX: &str = "Exclude these blocks, and check the recorder.";
