//! Everything found on the way to the results: what the verdict rests on, then what was merely noted.

use doublet_core::message;
use doublet_core::message::Message;
use doublet_core::reconstruct::Measurement;
use doublet_core::reconstruct::consistency::{ChannelConsistency, WORTH_CHANGING};

use super::fold::{Folded, fold};
use super::noise::{MeasurementNoise, find_far_too_high};
use super::{Finding, Level, sideslip};
use crate::notation::significant;
use crate::session::{Manoeuvre, Place, Session, path_warning};
use crate::snapshot::Snapshot;
use crate::stage::NoiseAdvice;

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
    let mut note = |place: &Place, text: &Message| found.push(Finding::new(Level::Good, "note", place, text.clone()));
    path_warning(session).into_iter().for_each(|text| note(&"session".into(), &text.into()));
    for flight in &session.flights {
        let place = Place::flight(&flight.name);
        let loaded = snapshot.flights.get(&flight.name).and_then(|slot| slot.ready());
        loaded.iter().flat_map(|loaded| &loaded.recording.warnings).for_each(|text| note(&place, text));
        let engines = snapshot.engines.get(&flight.name).and_then(|slot| slot.ready());
        engines.iter().flat_map(|engines| &engines.warnings).for_each(|(_, text)| note(&place, text));
    }
    for window in &session.windows {
        let Some(results) = snapshot.windows.get(&window.name) else { continue };
        let place = Place::manoeuvre(&window.name);
        let path = results.path.ready();
        path.iter().flat_map(|path| &path.assessment().warnings).for_each(|text| note(&place, text));
        results.aero.ready().iter().flat_map(|aero| &aero.warnings).for_each(|text| note(&place, text));
    }
    found.extend(sideslip::offset(session, snapshot));
    found.extend(advice(session, snapshot));
    found
}

/// What the innovations of every window advise, where their size is not as predicted: one action for each measurement, by the noise
/// of all manoeuvres where there is one, otherwise the one that most manoeuvres ask for.
fn advice(session: &Session, snapshot: &Snapshot) -> Vec<Finding> {
    let noise = MeasurementNoise::new(session, snapshot);
    let (hinted, mut found): (Vec<Measurement>, Vec<Finding>) = find_far_too_high(&noise).into_iter().unzip();
    let is_as_predicted = |ratio: f64| (1.0 / WORTH_CHANGING..=WORTH_CHANGING).contains(&ratio);
    let mut asked: Vec<(&Manoeuvre, f64, NoiseAdvice)> = Vec::new();
    for window in &session.windows {
        let path = snapshot.windows.get(&window.name).and_then(|results| results.path.ready());
        let channels =
            path.iter().filter_map(|path| path.assessment().consistency.as_ref()).flat_map(|found| &found.channels);
        let is_new = |channel: &&ChannelConsistency| !hinted.contains(&channel.measurement);
        let unlike = channels.filter(is_new).filter(|channel| !is_as_predicted(channel.deviation_ratio));
        asked.extend(unlike.filter_map(|found| Some((window, found.deviation_ratio, noise.advise(window, found)?))));
    }
    for (window, ratio, advice) in &asked {
        let measurement = advice.measurement;
        let factor = noise.pooled(measurement).map(|std| std / noise.used(measurement));
        let fix_text = match factor {
            Some(factor) if is_as_predicted(factor) => "Keep its noise: all manoeuvres together agree.".to_owned(),
            Some(factor) => format!("Multiply its noise by {} (all manoeuvres).", significant(factor, 2)),
            None => most_asked(&asked, measurement).map_or_else(String::new, |action| format!("{action}.")),
        };
        let name = measurement.name();
        let text = message!("{} innovations are {:.2} of predicted", name, *ratio);
        let finding = Finding::new(Level::Good, "innovation-advice", Place::manoeuvre(&window.name), text);
        let setting = format!("filter.measurement_noise.{name}");
        let finding = finding.with_figure(*ratio, 1.0).with_fix_text(fix_text);
        let fix = factor.filter(|factor| !is_as_predicted(*factor)).and_then(|_| noise.fix(measurement));
        found.push(finding.with_setting("Noise and filter", setting).with_fix(fix));
    }
    found
}

/// What most manoeuvres ask for of a measurement, other than another noise.
fn most_asked(asked: &[(&Manoeuvre, f64, NoiseAdvice)], measurement: Measurement) -> Option<String> {
    let of_measurement = asked.iter().filter(|(_, _, advice)| advice.measurement == measurement);
    let actions: Vec<&str> =
        of_measurement.map(|(_, _, advice)| advice.action).filter(|action| !action.is_empty()).collect();
    let count = |action: &str| actions.iter().filter(|other| **other == action).count();
    let most = *actions.iter().max_by_key(|action| count(action))?;
    let (first, rest) = most.split_at(1);
    Some(first.to_uppercase() + rest)
}

/// [`findings`] with those of one kind in one line, the worst first.
pub fn folded(session: &Session, snapshot: &Snapshot) -> Vec<Folded> {
    let recordings = session.flights.iter().flat_map(|flight| &flight.recordings);
    let paths: Vec<&str> = recordings.map(|recording| recording.path.as_str()).collect();
    fold(&findings(session, snapshot), &paths)
}
