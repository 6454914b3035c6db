//! Everything found on the way to the results: what the verdict rests on, then what was merely noted.

use doublet_core::reconstruct::Measurement;
use doublet_core::reconstruct::consistency::{ChannelConsistency, WORTH_CHANGING};

use super::fold::{Folded, fold};
use super::{Finding, Level, sideslip};
use crate::notation::significant;
use crate::run::Snapshot;
use crate::session::{Session, path_warning};
use crate::stage::{NoiseAdvice, NoiseStep, channel_advice, pooled_noise};

/// Reasons of the verdict, derivatives that are not determined, notes of recordings, engines and windows, an offset of the sideslip,
/// and the advice of the innovations.
pub fn findings(session: &Session, snapshot: &Snapshot) -> Vec<Finding> {
    let mut found = Vec::new();
    if let Some(verdicts) = snapshot.verdicts.ready() {
        found.extend(verdicts.session.reasons.iter().cloned());
        let derivatives = verdicts.pooled.iter().flat_map(|fit| &fit.derivatives);
        let only_theirs = derivatives.flat_map(|derivative| &derivative.verdict.reasons);
        found.extend(only_theirs.filter(|reason| !verdicts.session.reasons.contains(reason)).cloned());
    }
    let mut note = |place: &str, text: &str| found.push(Finding::new(Level::Good, "note", place, text));
    path_warning(session).iter().for_each(|text| note("session", text));
    for flight in &session.flights {
        let place = format!("flight '{}'", flight.name);
        let loaded = snapshot.flights.get(&flight.name).and_then(|slot| slot.ready());
        loaded.iter().flat_map(|loaded| &loaded.recording.warnings).for_each(|text| note(&place, text));
        let engines = snapshot.engines.get(&flight.name).and_then(|slot| slot.ready());
        engines.iter().flat_map(|engines| &engines.warnings).for_each(|text| note(&place, text));
    }
    for window in &session.windows {
        let Some(results) = snapshot.windows.get(&window.name) else { continue };
        let place = format!("manoeuvre '{}'", window.name);
        let path = results.path.ready();
        path.iter().flat_map(|path| &path.assessment().warnings).for_each(|text| note(&place, text));
        results.aero.ready().iter().flat_map(|aero| &aero.warnings).for_each(|text| note(&place, text));
    }
    found.extend(sideslip::offset(snapshot));
    found.extend(advice(session, snapshot));
    found
}

/// What the innovations of every window advise, where their size is not as predicted. A factor on the noise is that of all windows.
fn advice(session: &Session, snapshot: &Snapshot) -> Vec<Finding> {
    let used = |channel: &ChannelConsistency| session.filter.measurement_noise[channel.measurement as usize];
    let mut all: Vec<(&str, &ChannelConsistency, NoiseAdvice)> = Vec::new();
    for window in &session.windows {
        let path = snapshot.windows.get(&window.name).and_then(|results| results.path.ready());
        let noise = snapshot.noise.get(&window.flight).and_then(|slot| slot.ready()).map(|noise| &**noise);
        let Some((path, found)) = path.and_then(|path| Some((path, path.assessment().consistency.as_ref()?))) else {
            continue;
        };
        let one = |channel| Some((window.name.as_str(), channel, channel_advice(path, channel, used(channel), noise)?));
        all.extend(found.channels.iter().filter_map(one));
    }
    let is_as_predicted = |ratio: f64| (1.0 / WORTH_CHANGING..=WORTH_CHANGING).contains(&ratio);
    let pooled = |measurement: Measurement| {
        let own = all.iter().filter(|(_, channel, _)| channel.measurement == measurement);
        pooled_noise(&own.map(|(.., advice)| advice.clone()).collect::<Vec<_>>())
    };
    let pooled: Vec<Option<f64>> = Measurement::ALL.map(pooled).into();
    let one = |(window, channel, advice): &(&str, &ChannelConsistency, NoiseAdvice)| {
        let (name, ratio) = (channel.measurement.name(), channel.deviation_ratio);
        let fix_text = match (advice.step, pooled[channel.measurement as usize]) {
            (NoiseStep::Set | NoiseStep::Differ, Some(std)) if is_as_predicted(std / used(channel)) => {
                "keep its noise: all manoeuvres together are as predicted".to_owned()
            }
            (NoiseStep::Set | NoiseStep::Differ, Some(std)) => {
                format!("multiply its noise by {}", significant(std / used(channel), 2))
            }
            _ => advice.reason.clone(),
        };
        let text = format!("innovations of {name} are {ratio:.2} times predicted");
        let finding = Finding::new(Level::Good, "innovation-advice", format!("manoeuvre '{window}'"), text);
        let setting = format!("filter.measurement_noise.{name}");
        finding.with_figure(ratio, 1.0).with_fix_text(fix_text).with_setting("Noise and filter", setting)
    };
    all.iter().filter(|(_, channel, _)| !is_as_predicted(channel.deviation_ratio)).map(one).collect()
}

/// [`findings`] with those of one kind in one line, the worst first.
pub fn folded(session: &Session, snapshot: &Snapshot) -> Vec<Folded> {
    let recordings = session.flights.iter().flat_map(|flight| &flight.recordings);
    let paths: Vec<&str> = recordings.map(|recording| recording.path.as_str()).collect();
    fold(&findings(session, snapshot), &paths)
}
