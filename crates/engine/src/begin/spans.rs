//! The time that recordings span, and recorders that share none.

use std::collections::BTreeMap;

use doublet_core::load::Probe;
use doublet_core::quantity::Role;
use doublet_core::series::{Channel, Recording, TimeRange};

use crate::session::Manoeuvre;
use crate::stage::is_of_engine_or_fuel;

/// One window over the time all clocks of the recordings span together.
pub fn whole_window(flight: &str, probes: &[Probe]) -> Option<Manoeuvre> {
    let clocks = probes.iter().flat_map(|probe| &probe.sources).flat_map(|source| &source.clocks);
    let (start_s, end_s) =
        clocks.filter(|clock| clock.samples > 1).fold((f64::INFINITY, f64::NEG_INFINITY), |(start, end), clock| {
            (start.min(clock.start_s), end.max(clock.end_s))
        });
    let window = TimeRange { start_s, end_s };
    (start_s < end_s).then(|| Manoeuvre::new(flight.to_owned(), flight.to_owned(), window))
}

/// The longest span over which everything that plays a role is recorded, except what would leave less than half of that of the roll rate.
pub(super) fn recorded_span(recording: &Recording) -> Option<TimeRange> {
    let shared =
        |a: TimeRange, b: TimeRange| TimeRange { start_s: a.start_s.max(b.start_s), end_s: a.end_s.min(b.end_s) };
    let length = |window: TimeRange| window.end_s - window.start_s;
    let base = recording.role(Role::RollRate).and_then(span)?;
    let mut all: Vec<TimeRange> = recording.roles.keys().filter_map(|&role| span(recording.role(role)?)).collect();
    all.sort_by(|a, b| length(shared(base, *b)).total_cmp(&length(shared(base, *a))));
    let is_long = |window: &TimeRange| length(*window) > 0.5 * length(base);
    Some(all.into_iter().fold(base, |found, next| Some(shared(found, next)).filter(is_long).unwrap_or(found)))
}

/// Times of the first and last sample of a channel that is finite.
fn span(channel: &Channel) -> Option<TimeRange> {
    let time_s = &channel.series.time_s;
    let known = |k: &usize| channel.series.values[*k].is_finite();
    let (first, last) = ((0..time_s.len()).find(known)?, (0..time_s.len()).rev().find(known)?);
    Some(TimeRange { start_s: time_s[first], end_s: time_s[last] })
}

/// Recorders without a common time: their spans, and the key that aligns them.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Apart {
    /// What does not overlap.
    pub text: String,
    /// What to state.
    pub fix_text: String,
}

impl std::fmt::Display for Apart {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "{} {}", self.text, self.fix_text)
    }
}

/// Sources with roles that share no time with the source of the roll rate; none where all overlap. Engines and fuel do not count: the
/// flight path does without them.
pub fn find_apart(recording: &Recording) -> Option<Apart> {
    let mut spans: BTreeMap<&str, TimeRange> = BTreeMap::new();
    let roles = recording.roles.keys().filter(|role| !is_of_engine_or_fuel(**role));
    for channel in roles.filter_map(|role| recording.role(*role)) {
        let Some(found) = span(channel) else { continue };
        let all = spans.entry(channel.source.as_str()).or_insert(found);
        *all = TimeRange { start_s: all.start_s.min(found.start_s), end_s: all.end_s.max(found.end_s) };
    }
    let base = recording.role(Role::RollRate)?.source.as_str();
    let own = *spans.get(base)?;
    let is_apart = |other: &TimeRange| other.end_s < own.start_s || other.start_s > own.end_s;
    let apart: Vec<(&str, TimeRange)> = spans.into_iter().filter(|(_, span)| is_apart(span)).collect();
    let describe = |(name, span): &(&str, TimeRange)| {
        let decimals = usize::from(span.end_s - span.start_s < 10.0);
        format!("{name} {:.decimals$} to {:.decimals$} s", span.start_s, span.end_s)
    };
    let (first, other) = apart.first()?;
    let others: Vec<String> = apart.iter().map(describe).collect();
    Some(Apart {
        text: format!("{} and {} do not overlap.", describe(&(base, own)), others.join(", ")),
        fix_text: format!(
            "State the clock offset of source '{first}': {:.1} s if both start together.",
            own.start_s - other.start_s
        ),
    })
}

#[cfg(test)]
pub(super) mod tests {
    use super::*;
    use doublet_core::series::Series;

    /// A recording of roles with the source of each, first and last time in s.
    pub(in crate::begin) fn recording(all: &[(Role, &str, u32, u32)]) -> Recording {
        let channel = |(_, source, start, end): &(Role, &str, u32, u32)| {
            let values: std::sync::Arc<[f64]> = (*start..=*end).map(f64::from).collect();
            let [name, unit] = Default::default();
            let series = Series { time_s: values.clone(), values };
            Channel { source: (*source).to_owned(), name, unit, series }
        };
        let roles = all.iter().enumerate().map(|(index, (role, ..))| (*role, index)).collect();
        Recording { channels: all.iter().map(channel).collect(), roles, ..Recording::default() }
    }

    #[test]
    fn the_whole_recording_begins_where_every_long_channel_does_whatever_the_short_ones_do() {
        let all = [(Role::RollRate, "", 0, 100), (Role::EngineSpeed1, "", 9, 98), (Role::FuelMass, "", 0, 30)];
        assert_eq!(recorded_span(&recording(&all)).unwrap(), TimeRange { start_s: 9.0, end_s: 98.0 });
    }

    #[test]
    fn recorders_without_a_common_time_are_named_with_the_offset_to_state() {
        let inertial = (Role::RollRate, "inertial", 0, 254);
        let apart = recording(&[inertial, (Role::Elevator, "daq", 35_998, 36_252)]);
        let Apart { text, fix_text } = find_apart(&apart).unwrap();
        assert_eq!(text, "inertial 0 to 254 s and daq 35998 to 36252 s do not overlap.");
        assert!(fix_text.contains("source 'daq': -35998.0 s"), "{fix_text}");
        let overlap = recording(&[inertial, (Role::Elevator, "daq", 200, 36_252)]);
        assert_eq!(find_apart(&overlap), None);
        let fuel = recording(&[inertial, (Role::FuelMass, "fuel", 35_998, 36_252)]);
        assert_eq!(find_apart(&fuel), None);
    }
}
