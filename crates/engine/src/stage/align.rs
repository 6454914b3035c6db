//! Puts every recorder on the flight's time line. Stamps move, samples do not: nothing is resampled.

use std::collections::HashMap;
use std::sync::Arc;

use doublet_core::align::{ClockEstimate, ClockFitSettings, ClockModel, ClockPair, ClockSearch, clock_fit_pairs};
use doublet_core::series::{Channel, Recording};
use rayon::prelude::*;

use crate::graph::StageResult;
use crate::session::ClockSetting;

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

/// The recording with every clock applied, and the clocks.
///
/// # Errors
/// One line: a channel that is not there, or channels that do not agree on a clock.
pub fn align(recording: &Recording, settings: &[ClockSetting]) -> StageResult<(Recording, Vec<UsedClock>)> {
    let one = |setting: &ClockSetting| -> StageResult<UsedClock> {
        let clock = clock(recording, setting).map_err(|error| format!("clock of {}: {error}", setting.source))?;
        Ok(UsedClock { model: clock.model.shifted(setting.shift_s), shift_s: setting.shift_s, ..clock })
    };
    // Each is fitted to the recording as read and knows nothing of the others; the first error is that of the session's order.
    let clocks: Vec<StageResult<UsedClock>> = settings.par_iter().map(one).collect();
    let clocks: Vec<UsedClock> = clocks.into_iter().collect::<StageResult<_>>()?;
    let mut aligned = recording.clone();
    let mut moved: HashMap<*const f64, Arc<[f64]>> = HashMap::new();
    for channel in &mut aligned.channels {
        let Some(clock) = clocks.iter().find(|clock| is_stamped_by(&clock.source, &channel.source)) else { continue };
        let time_s = Arc::clone(&channel.series.time_s);
        let on_line = moved
            .entry(time_s.as_ptr())
            .or_insert_with(|| time_s.iter().map(|&own| clock.model.reference_s(own)).collect());
        channel.series.time_s = Arc::clone(on_line);
    }
    Ok((aligned, clocks))
}

/// Whether a source is one of those a clock stamps: its name is `pattern`, or begins with it where it ends in `*`.
pub fn is_stamped_by(pattern: &str, source: &str) -> bool {
    pattern.strip_suffix('*').map_or(pattern == source, |beginning| source.starts_with(beginning))
}

/// The channel written `source/name`.
///
/// # Errors
/// One line with the channels that have this name, or the names of the source.
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
            "list them with `doublet inspect`".to_owned()
        } else {
            format!("there is {}", same.join(", "))
        };
        format!("no channel '{path}'; {hint}").into()
    })
}

fn clock(recording: &Recording, setting: &ClockSetting) -> StageResult<UsedClock> {
    let given = ClockModel::new(setting.offset_s, setting.drift)?;
    if setting.fit.is_empty() {
        return Ok(UsedClock { source: setting.source.clone(), model: given, shift_s: 0.0, estimate: None });
    }
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
    Ok(UsedClock { source: setting.source.clone(), model: estimate.model, shift_s: 0.0, estimate: Some(estimate) })
}
