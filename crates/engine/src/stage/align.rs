//! Puts every recorder on the flight's time line. Stamps move, samples do not: nothing is resampled.

use std::collections::HashMap;
use std::sync::Arc;

use doublet_core::align::{ClockEstimate, ClockFitSettings, ClockModel, ClockPair, ClockSearch, clock_fit_pairs};
use doublet_core::message;
use doublet_core::quantity::Role;
use doublet_core::series::{Channel, DERIVED, Recording};
use rayon::prelude::*;

use crate::graph::{StageError, StageResult};
use crate::session::{ClockSetting, Finding, Flight, Level, Place};

/// A recorder's clock as used.
#[derive(Clone, Debug)]
pub struct UsedClock {
    /// Sources with this clock.
    pub source: String,
    /// The clock, shifted by hand where the session says so.
    pub model: ClockModel,
    /// Seconds it was shifted by hand.
    pub shift_s: f64,
    /// How it was fitted, with its standard errors and the lag of every chunk; `None` for a clock as set.
    pub estimate: Option<ClockEstimate>,
}

/// The recording with every clock of the flight applied, the clocks, and those that could not be fitted but only stamp engines or fuel.
pub fn align(recording: &Recording, flight: &Flight) -> StageResult<(Recording, Vec<UsedClock>, Vec<Finding>)> {
    // Each is fitted to the recording as read and knows nothing of the others; the first error is that of the session's order.
    let clocks: Vec<StageResult<_>> =
        flight.clocks.par_iter().map(|setting| find_clock(recording, flight, setting)).collect();
    let (clocks, findings): (Vec<UsedClock>, Vec<Option<Finding>>) =
        clocks.into_iter().collect::<StageResult<Vec<_>>>()?.into_iter().unzip();
    let mut aligned = recording.clone();
    let mut moved: HashMap<*const f64, Arc<[f64]>> = HashMap::new();
    for channel in &mut aligned.channels {
        let time_s = Arc::clone(&channel.series.time_s);
        let Some(clock) = clocks.iter().find(|clock| is_stamped_by(&clock.source, &channel.source)) else {
            // Derived channels have the stamps of those they are derived of, which come before them.
            if let Some(on_line) = moved.get(&time_s.as_ptr()).filter(|_| channel.source == DERIVED) {
                channel.series.time_s = Arc::clone(on_line);
            }
            continue;
        };
        let on_line = moved
            .entry(time_s.as_ptr())
            .or_insert_with(|| time_s.iter().map(|&own| clock.model.reference_s(own)).collect());
        channel.series.time_s = Arc::clone(on_line);
    }
    Ok((aligned, clocks, findings.into_iter().flatten().collect()))
}

fn find_clock(
    recording: &Recording,
    flight: &Flight,
    setting: &ClockSetting,
) -> StageResult<(UsedClock, Option<Finding>)> {
    let (clock, finding) = match clock(recording, setting) {
        Ok(clock) => (clock, None),
        Err(error) if stamps_engines_alone(recording, setting, flight) => {
            (clock_as_set(setting)?, Some(describe_unfitted(setting, flight, &error)))
        }
        Err(error) => return Err(format!("clock of {}: {error}", setting.source).into()),
    };
    Ok((UsedClock { model: clock.model.shifted(setting.shift_s), shift_s: setting.shift_s, ..clock }, finding))
}

/// Whether a source is one of those a clock stamps: its name is `pattern`, or begins with it where it ends in `*`.
pub fn is_stamped_by(pattern: &str, source: &str) -> bool {
    pattern.strip_suffix('*').map_or(pattern == source, |beginning| source.starts_with(beginning))
}

/// The channel written `source/name`.
pub fn channel<'a>(recording: &'a Recording, path: &str) -> StageResult<&'a Channel> {
    let found = recording.channels.iter().find(|channel| {
        path.strip_prefix(channel.source.as_str()).and_then(|rest| rest.strip_prefix('/')) == Some(&channel.name)
    });
    found.ok_or_else(|| {
        let name = path.rsplit('/').next().unwrap_or(path);
        let same: Vec<_> = recording
            .channels
            .iter()
            .filter(|channel| channel.name == name)
            .map(|channel| format!("'{}/{}'", channel.source, channel.name))
            .collect();
        let hint = if same.is_empty() {
            "choose a channel of the recording".to_owned()
        } else {
            format!("the recording has {}", same.join(", "))
        };
        format!("channel '{path}' not found: {hint}").into()
    })
}

/// Whether every role that a clock stamps is of an engine or of fuel: flight path and controls do without. A source without roles may give
/// those of the flight's instruments.
fn stamps_engines_alone(recording: &Recording, setting: &ClockSetting, flight: &Flight) -> bool {
    let source = |index: &usize| recording.channels.get(*index).map(|channel| channel.source.as_str());
    let stamped = recording
        .roles
        .iter()
        .filter(|(_, index)| source(index).is_some_and(|source| is_stamped_by(&setting.source, source)));
    let mut roles = stamped.map(|(role, _)| *role).peekable();
    if roles.peek().is_none() {
        return flight.instruments.is_none();
    }
    roles.all(is_of_engine_or_fuel)
}

/// Roles that only thrust, power and the mass of fuel follow from.
pub(crate) fn is_of_engine_or_fuel(role: Role) -> bool {
    matches!(
        role,
        Role::FuelMass
            | Role::FuelFlow
            | Role::Thrust1
            | Role::Thrust2
            | Role::ThrustCoefficient
            | Role::EngineSpeed1
            | Role::EngineSpeed2
            | Role::ManifoldPressure1
            | Role::ManifoldPressure2
            | Role::Power1
            | Role::Power2
    )
}

/// A clock that could not be fitted and is used as the session sets it.
fn describe_unfitted(setting: &ClockSetting, flight: &Flight, error: &StageError) -> Finding {
    let place = Place::in_flight(&flight.name, format!("clock of {}", setting.source));
    let text = message!("not fitted: {}; engines and fuel use the clock as set", error.to_string());
    Finding::new(Level::Caution, "clock", place, text)
        .with_fix_text("Fit it to another channel, or state its offset.")
        .with_setting("Preprocess", "flight.clock")
}

/// The clock as the session sets it.
fn clock_as_set(setting: &ClockSetting) -> StageResult<UsedClock> {
    let model = ClockModel::new(setting.offset_s, setting.drift)?;
    Ok(UsedClock { source: setting.source.clone(), model, shift_s: 0.0, estimate: None })
}

fn clock(recording: &Recording, setting: &ClockSetting) -> StageResult<UsedClock> {
    let as_set = clock_as_set(setting)?;
    if setting.fit.is_empty() {
        return Ok(as_set);
    }
    let given = as_set.model;
    let mut pairs = Vec::new();
    for pair in &setting.fit {
        pairs.push(ClockPair {
            name: &pair.other,
            reference: &channel(recording, &pair.reference)?.series,
            other: &channel(recording, &pair.other)?.series,
            inverted: pair.inverted,
        });
    }
    let about = given != ClockModel::REFERENCE;
    let search = if about { ClockSearch::About(given) } else { ClockSearch::Everywhere };
    let settings = ClockFitSettings { search, ..ClockFitSettings::default() };
    let estimate = clock_fit_pairs(&pairs, &settings)?;
    Ok(UsedClock { model: estimate.model, estimate: Some(estimate), ..as_set })
}
