//! Findings about the flight path of one window.

use doublet_core::message;
use doublet_core::reconstruct::consistency::{ChannelConsistency, Consistency};
use doublet_core::reconstruct::{Reconstruction, State};
use doublet_core::series::TimeRange;

use super::judge::{Evidence, level_above, not_computed};
use super::noise::NOISE_EXPLAINS;
use super::{Finding, Level, flight, loading, propulsion, remedies, sampling, saturated, spoilt, stalls, stuck};
use crate::session::{Edit, EstimationEdit, Fix, Manoeuvre, PathSource, Place, Session, WindowEdit};
use crate::stage::{NoiseStep, WindowPath};

/// Mean NIS over its expectation: outside its 95 % band and beyond these it is a caution, above the last bad. Noise stated too large
/// leaves the path less exact than it could be, noise stated too small leaves it wrong.
const NIS_CAUTION: [f64; 2] = [1.0 / 3.0, 1.5];
const NIS_BAD: f64 = 3.0;
/// Mean innovation in predicted deviations.
const OFFSET_CAUTION: f64 = 0.5;
const OFFSET_BAD: f64 = 5.0;
/// Correlation of neighbouring innovations, and how much larger than predicted they are, before they show something no noise explains:
/// small innovations are correlated in every recording of a sensor slower than its recorder.
const LAG_ONE: f64 = 0.3;
const LARGER_THAN_PREDICTED: f64 = 1.3;
/// Part of the samples at which filter and smoother may differ by more than three deviations, and the deviations that are bad where
/// they last.
const SMOOTHER_OUTSIDE: f64 = 0.1;
const SMOOTHER_BAND: f64 = 3.0;
const SMOOTHER_BAD: f64 = 20.0;
const SMOOTHER_BAD_S: f64 = 0.5;
/// States the coefficients are formed from, whose filtered and smoothed paths are compared.
const COMPARED: [State; 5] =
    [State::VelocityU, State::VelocityV, State::VelocityW, State::BankAngle, State::PitchAngle];

/// What speaks against the samples, the flight path and the loading of a window.
pub(super) fn findings(evidence: Evidence<'_>, manoeuvre: &Manoeuvre) -> Vec<Finding> {
    let place = Place::manoeuvre(&manoeuvre.name);
    let Some(results) = evidence.snapshot.windows.get(&manoeuvre.name) else { return Vec::new() };
    if let Some(error) = results.path.error().or(results.aero.error()) {
        let finding = not_computed(Level::Bad, place, error).with_setting("Flight", "");
        return vec![finding.with_fix(Fix::ignore([manoeuvre.name.as_str()]))];
    }
    let mut findings = Vec::new();
    findings.extend(saturated::finding(&place, evidence, manoeuvre));
    findings.extend(stuck::finding(&place, evidence, manoeuvre));
    let stalled = stalls::finding(&place, evidence, manoeuvre);
    let is_stalled = stalled.is_some();
    findings.extend(stalled);
    if let Some(path) = results.path.ready() {
        if evidence.session.preparation.path == PathSource::Measured {
            let text = "Path as measured: sensor errors bias the coefficients, without innovations as a check.";
            let finding = Finding::new(Level::Caution, "as-measured", place.clone(), text);
            let edit = Edit::Estimation(EstimationEdit::Path(PathSource::Smoothed));
            let finding = finding.with_fix_text("Use the smoothed path, except for comparisons.");
            let finding = finding.with_setting("Noise and filter", "preparation.path");
            findings.push(finding.with_fix(Fix::new("use the smoothed path", edit)));
        }
        let fit = channels_fit(evidence, manoeuvre);
        findings.extend(
            path.assessment()
                .consistency
                .iter()
                .flat_map(|consistency| innovations(&place, consistency, (evidence, manoeuvre), fit)),
        );
        findings.extend(smoother(&place, (evidence.session, manoeuvre), path));
        if is_stalled {
            findings.iter_mut().for_each(|finding| explain_by_stalls(finding, evidence, manoeuvre));
        }
        findings.extend(flight::turn(&place, manoeuvre, path));
    }
    if let Some(aero) = results.aero.ready() {
        findings.extend(flight::dynamic_pressure(&place, evidence, manoeuvre, aero));
        findings.extend(sampling::sudden_control(&place, evidence, manoeuvre, aero));
        findings.extend(loading::loading_findings(&place, evidence, manoeuvre, aero));
        findings.extend(propulsion::extrapolated(&place, evidence, manoeuvre, aero));
    }
    findings
}

/// What to do about a path that does not fit where the recorder stalls: no delay, no noise of a sensor explains that.
fn explain_by_stalls(finding: &mut Finding, evidence: Evidence<'_>, manoeuvre: &Manoeuvre) {
    if matches!(finding.code, "nis" | "smoother" | "innovation") {
        finding.fix_text = stalls::FIX.to_owned();
        finding.fix = spoilt::fix(evidence, manoeuvre);
        (finding.panel, finding.setting) = (Some("Manoeuvres"), Some("manoeuvre.exclude".to_owned()));
    }
}

/// Whether the channels of a window's flight fit each other: then none of them has a wrong sign, unit or clock.
fn channels_fit(evidence: Evidence<'_>, manoeuvre: &Manoeuvre) -> bool {
    let physics = evidence.snapshot.physics.get(&manoeuvre.flight).and_then(|slot| slot.ready());
    physics.is_some_and(|physics| !physics.rows.is_empty() && physics.contradictions().next().is_none())
}

fn innovations(
    place: &Place,
    consistency: &Consistency,
    (evidence, manoeuvre): (Evidence<'_>, &Manoeuvre),
    channels_fit: bool,
) -> Vec<Finding> {
    let mut found: Vec<Finding> = nis(place, consistency, (evidence, manoeuvre), channels_fit).into_iter().collect();
    found.extend(consistency.channels.iter().filter_map(|channel| offset(&manoeuvre.name, evidence.session, channel)));
    found.extend(
        consistency.channels.iter().filter_map(|channel| correlated(&manoeuvre.name, evidence.session, channel)),
    );
    found
}

fn nis(
    place: &Place,
    consistency: &Consistency,
    (evidence, manoeuvre): (Evidence<'_>, &Manoeuvre),
    channels_fit: bool,
) -> Option<Finding> {
    let (ratio, [low, high]) = (consistency.nis_ratio, consistency.nis_band_correlated);
    if (low..=high).contains(&consistency.nis_mean) {
        return None;
    }
    let (level, limit) = if ratio > NIS_BAD || ratio.is_nan() {
        (Level::Bad, NIS_BAD)
    } else if !(NIS_CAUTION[0]..=NIS_CAUTION[1]).contains(&ratio) {
        (Level::Caution, if ratio > 1.0 { NIS_CAUTION[1] } else { NIS_CAUTION[0] })
    } else {
        return None;
    };
    let channels = &consistency.channels;
    let extreme = |is_loudest: bool| {
        let sign = if is_loudest { 1.0 } else { -1.0 };
        channels.iter().max_by(|a, b| (sign * a.deviation_ratio).total_cmp(&(sign * b.deviation_ratio)))
    };
    let found = extreme(ratio > 1.0);
    let (name, times) =
        found.map_or(("a measurement", f64::NAN), |found| (found.measurement.name(), found.deviation_ratio));
    let advice = found.and_then(|found| evidence.noise.advise(manoeuvre, found));
    let explanation = match ratio > 1.0 {
        true => message!("innovations exceed the noise, most in {} ({:.1} times predicted)", name, times),
        false => {
            message!("noise set too high, most in {} (predicted {:.1} times the innovations)", name, times.recip())
        }
    };
    let is_noise = ratio < NOISE_EXPLAINS && channels_fit;
    let by_noise = found.and_then(|found| evidence.noise.fix(found.measurement));
    let fix_text = match advice.as_ref().map(|advice| advice.step) {
        _ if ratio > 1.0 && !is_noise => format!("Check sign, unit and clock of {name}, then set its noise."),
        _ if by_noise.is_some() => format!("Set the noise of {name} by its innovations in all manoeuvres."),
        Some(NoiseStep::NotNoise) => format!("Check {name} for a delay, a filter or its position."),
        Some(NoiseStep::Keep) if ratio < 1.0 => "Lower the process noise first.".to_owned(),
        _ => format!("Set the noise of {name} by its innovations."),
    };
    let (mean, expected) = (consistency.nis_mean, consistency.nis_mean / ratio);
    let text = message!(
        "Mean NIS {:.3}, expected {:.3} (ratio {:.2}, limit {:.2}): {}.",
        mean,
        expected,
        ratio,
        limit,
        explanation
    );
    let setting = found
        .filter(|_| ratio > 1.0)
        .map_or("filter.measurement_noise".to_owned(), |_| format!("filter.measurement_noise.{name}"));
    let finding = Finding::new(level, "nis", place, text).with_figure(ratio, limit);
    let fix = by_noise.or_else(|| remedies::estimate_delays(evidence.session).filter(|_| ratio > 1.0));
    Some(finding.with_fix_text(fix_text).with_setting("Noise and filter", setting).with_fix(fix))
}

fn offset(manoeuvre: &str, session: &Session, channel: &ChannelConsistency) -> Option<Finding> {
    let (level, limit) = level_above(channel.mean.abs(), OFFSET_CAUTION, OFFSET_BAD)?;
    let name = channel.measurement.name();
    if !channel.has_offset() {
        return None;
    }
    let text = message!("Mean innovation of {} is {:+.2} standard deviations (limit {}).", name, channel.mean, limit);
    let fix_text = format!("Check {name} for an offset, a wrong sign or a clock error.");
    let finding =
        Finding::new(level, "innovation", Place::in_manoeuvre(manoeuvre, name), text).with_figure(channel.mean, limit);
    let finding =
        finding.with_fix_text(fix_text).with_setting("Innovations", format!("filter.measurement_noise.{name}"));
    Some(finding.with_fix(remedies::estimate_offset(session, channel.measurement)))
}

fn correlated(manoeuvre: &str, session: &Session, channel: &ChannelConsistency) -> Option<Finding> {
    let (lag_one, ratio) = (channel.lag_one(), channel.deviation_ratio);
    if lag_one <= LAG_ONE || channel.is_white || ratio <= LARGER_THAN_PREDICTED {
        return None;
    }
    let name = channel.measurement.name();
    let text = message!(
        "{} innovations are {:.2} times predicted and correlated (lag one {:.2}, limit {}).",
        name,
        ratio,
        lag_one,
        LAG_ONE
    );
    let fix_text = format!("Check {name} for a delay, a filter or repeated samples.");
    let finding = Finding::new(Level::Caution, "innovation", Place::in_manoeuvre(manoeuvre, name), text);
    let finding = finding.with_figure(lag_one, LAG_ONE).with_fix_text(fix_text);
    let finding = finding.with_setting("Innovations", format!("filter.measurement_delay_s.{name}"));
    Some(finding.with_fix(remedies::estimate_delays(session)))
}

/// Filter against smoother: the worst state.
fn smoother(place: &Place, (session, manoeuvre): (&Session, &Manoeuvre), path: &WindowPath) -> Option<Finding> {
    let run = &path.reconstruction;
    let apart: Vec<(State, Apart)> =
        COMPARED.into_iter().filter_map(|state| Some((state, Apart::measure(run, manoeuvre, state)?))).collect();
    let bad_s = |it: &Apart| it.bad.end_s - it.bad.start_s;
    let lasting =
        apart.iter().max_by(|a, b| bad_s(&a.1).total_cmp(&bad_s(&b.1))).filter(|(_, it)| bad_s(it) > SMOOTHER_BAD_S);
    let outside = apart.iter().max_by(|a, b| a.1.outside.total_cmp(&b.1.outside));
    let (state, level, text, figure, limit) = match (lasting, outside) {
        (Some((state, it)), _) => {
            let text = message!(
                "Filter and smoother differ by {:.0} standard deviations in {} (limit {} for {} s).",
                it.largest,
                state.name(),
                SMOOTHER_BAD,
                SMOOTHER_BAD_S
            );
            (state, Level::Bad, text, it.largest, SMOOTHER_BAD)
        }
        (None, Some((state, it))) if it.outside > SMOOTHER_OUTSIDE => {
            let text = message!(
                "Filter and smoother differ by over {} standard deviations in {} at {:.0} % of samples (limit {:.0} %).",
                SMOOTHER_BAND,
                state.name(),
                100.0 * it.outside,
                100.0 * SMOOTHER_OUTSIDE
            );
            (state, Level::Caution, text, it.outside, SMOOTHER_OUTSIDE)
        }
        _ => return None,
    };
    let fix_text = "Check process noise and random walks, and look for unmodelled sensor errors.";
    let finding = Finding::new(level, "smoother", place, text).with_figure(figure, limit).with_fix_text(fix_text);
    let finding = finding.with_setting("Noise and filter", format!("filter.random_walk.{}", state.name()));
    let apart = lasting.and_then(|(_, it)| without_part(manoeuvre, it.bad));
    let gusts = || remedies::estimate_gusts(session);
    Some(finding.with_fix(apart.or_else(gusts).or_else(|| remedies::iterate_smoother(session))))
}

/// Excludes a part of a manoeuvre; none where that is most of it.
fn without_part(manoeuvre: &Manoeuvre, part: TimeRange) -> Option<Fix> {
    let TimeRange { start_s, end_s } = part;
    let is_most = end_s - start_s > 0.5 * (manoeuvre.window.end_s - manoeuvre.window.start_s);
    let (name, excluded) = (manoeuvre.name.clone(), manoeuvre.excluded_with(part).filter(|_| !is_most)?);
    let label = format!("exclude {start_s:.2} to {end_s:.2} s of '{name}'");
    Some(Fix::new(label, Edit::Window(WindowEdit::Exclude { name, excluded })))
}

/// How far the filtered and the smoothed path of a state are apart.
struct Apart {
    /// Part of the samples beyond [`SMOOTHER_BAND`] deviations of their difference.
    outside: f64,
    /// Largest difference, deviations.
    largest: f64,
    /// Longest part beyond [`SMOOTHER_BAD`] deviations.
    bad: TimeRange,
}

impl Apart {
    /// `|x_f - x_s|` over the deviation of the difference, whose variance is the difference of the variances (Bierman); of the filtered
    /// deviation a tenth at least, so that rounding where the two are equal counts for nothing. Excluded parts do not count.
    fn measure(run: &Reconstruction, manoeuvre: &Manoeuvre, state: State) -> Option<Self> {
        let smoothed = run.smoothed.as_ref()?;
        let k = state as usize;
        let (mut outside, mut samples, mut largest, mut since) = (0_usize, 0_usize, 0.0_f64, None);
        let mut bad = TimeRange { start_s: 0.0, end_s: 0.0 };
        for (index, &time_s) in run.time_s.iter().enumerate() {
            if manoeuvre.excluded_at(time_s).is_some() {
                since = None;
                continue;
            }
            samples += 1;
            let (before, after) = (run.deviations[k].at(index), smoothed.deviations[k].at(index));
            let deviation = (before * before - after * after).max((0.1 * before).powi(2)).sqrt();
            let apart = (run.states[k][index] - smoothed.states[k][index]).abs() / deviation;
            outside += usize::from(apart > SMOOTHER_BAND);
            largest = if apart.is_finite() { largest.max(apart) } else { largest };
            since = if apart > SMOOTHER_BAD { since.or(Some(time_s)) } else { None };
            if let Some(start_s) = since.filter(|start_s| time_s - start_s > bad.end_s - bad.start_s) {
                bad = TimeRange { start_s, end_s: time_s };
            }
        }
        Some(Self { outside: outside as f64 / samples.max(1) as f64, largest, bad })
    }
}
