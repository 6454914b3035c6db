//! Judging the tests of a file on the windows of a session that was run.

use std::collections::BTreeMap;
use std::path::Path;

use doublet_core::estimate::Fit;
use doublet_core::model::Derivatives;
use doublet_core::reconstruct::Measurement;
use doublet_core::validate::Histories;
use doublet_dynamics::modes::measured::Read;

use super::cards::cards;
use super::conditions::initial;
use super::document::document;
use super::free_response::{self, FreeResponse, free_response};
use super::index::{certainty, index};
use super::judge::{at_time, channels, lacks_data, met, over_bands, over_values, values};
use super::snapshot::{self, snapshot};
use super::trimmed::{LEAST_STEADY_S, TrimmedStart, trimmed};
use super::{
    CARDS, Constants, FORMAT, NAME, Outcome, Page, Qualification, QualificationTest, TestEntry, TestFile, VERSION,
    data, pages,
};
use crate::date;
use crate::graph::{Cache, Control, StageResult};
use crate::report::document::Document;
use crate::report::session_sha256;
use crate::run::{Scope, run};
use crate::session::{self, Manoeuvre, Session, WindowRole};
use crate::snapshot::Snapshot;
use crate::stage::{
    Judgement, Movement, ObjectiveTest, PooledFits, Quantity, ReplayWindow, Tolerances, ValueTolerance, WindowAero,
    WindowFlight, WindowPath, WindowReplay, fly_window, measured_histories, model_of_window, movement, shortfall,
    window_flight,
};
use crate::verdict::list_failures;

/// Time before a deflection has left its rest at which it is taken to begin, s.
const MOVING_S: f64 = 0.1;
/// Steady flight at the start of a record in which no surface moves, s.
const LEAD_S: f64 = 3.0;

/// The session with the windows of the tests in use: those that it ignores are flown as validation windows, which changes no derivative.
pub fn prepare(session: &Session, file: &TestFile) -> Session {
    let mut prepared = session.clone();
    for window in &mut prepared.windows {
        let is_named = file.tests.iter().any(|entry| entry.windows.contains(&window.name));
        if is_named && window.role == WindowRole::Ignored {
            window.role = WindowRole::Validation;
        }
    }
    prepared
}

/// Tests judged, and the guide that says so.
#[derive(Clone, Debug)]
pub struct Judged {
    /// Results.
    pub found: Qualification,
    /// The guide, a section per test named as [`QualificationTest::section`].
    pub guide: Document,
    /// Campaign of the tests of the rule without a record, as its file; none where all have one.
    pub cards: Option<String>,
}

impl Judged {
    /// Files that go with the guide: the results and the copies of the validation data.
    pub fn beside(&self) -> Result<Vec<(String, Vec<u8>)>, String> {
        let json = serde_json::to_vec_pretty(&self.found).map_err(|error| error.to_string())?;
        let copies = self.found.tests.iter().filter_map(|test| test.data.as_ref());
        let copies = copies.map(|copy| (copy.name.clone(), copy.text.clone().into_bytes()));
        let cards = self.cards.iter().map(|text| (CARDS.to_owned(), text.clone().into_bytes()));
        Ok(std::iter::once((format!("{NAME}.json"), json)).chain(cards).chain(copies).collect())
    }
}

/// Runs a session whose relative paths start from `folder` with the windows that the tests need, judges them and lays the guide out.
pub fn judge(
    session: &Session,
    folder: &Path,
    file: &TestFile,
    control: &Control,
    progress: &(dyn Fn(f32) + Sync),
) -> StageResult<Judged> {
    let prepared = prepare(session, file);
    if let Some(finding) = session::check(&prepared).into_iter().find(session::stops_run) {
        return Err(format!("with the manoeuvres of the tests: {finding}").into());
    }
    let scope = Scope { session: &prepared, folder, first: None, studies: &[], cause: "qualification", generation: 1 };
    let publish = |snapshot: Snapshot| progress(snapshot.progress);
    let snapshot = run(&scope, &Snapshot::default(), &Cache::new(0), control, &publish);
    control.checkpoint()?;
    let failures = list_failures(&snapshot.failures());
    if !snapshot.windows.values().any(|window| window.path.ready().is_some())
        && let Some(first) = failures.into_iter().next()
    {
        return Err(first.into());
    }
    let mut found = evaluate(session, &snapshot, file)?;
    let cards = cards(&prepared, folder, &snapshot, file, &mut found.index);
    Ok(Judged { guide: document(session, &snapshot, file, &found), found, cards })
}

/// Judges every test of `file` on a session and what the run of it, [`prepare`]d, found.
pub fn evaluate(session: &Session, snapshot: &Snapshot, file: &TestFile) -> StageResult<Qualification> {
    let prepared = prepare(session, file);
    let mut tests = Vec::new();
    for Place { id, entry, rule, window } in places(&prepared, file) {
        let context = Evaluation { session: &prepared, snapshot, file, entry, rule, id };
        let test = match window {
            Ok(window) => context.test(window).map_err(|error| error.at(format!("test '{}'", entry.id)))?,
            Err(reason) => {
                let mut test = context.unflown(None, Outcome::NoRecording, reason);
                test.page.facts.extend(pages::without_record());
                test
            }
        };
        tests.push(test);
    }
    let count = |passed: Option<bool>| tests.iter().filter(|test| test.passed == passed).count();
    let aircraft = snapshot.aircraft.ready().map(|loaded| loaded.aircraft.name.clone());
    Ok(Qualification {
        format: FORMAT,
        version: VERSION,
        app: crate::PROGRAM.to_owned(),
        date: date::today(),
        title: file.title.clone(),
        aircraft: aircraft.unwrap_or_default(),
        session_sha256: session_sha256(session),
        rule: file.rule.name.clone(),
        edition: file.rule.edition.clone(),
        certainty: file.rule.certainty_note.clone(),
        constants: file.constants.name(),
        percent: file.reading.percent.reference_description(),
        engineering_data: file.is_engineering_data,
        passed: count(Some(true)),
        failed: count(Some(false)),
        not_judged: count(None),
        index: index(&file.rule, &tests),
        tests,
    })
}

/// A page of the guide: a test on a window, or why there is none.
struct Place<'a> {
    id: String,
    entry: &'a TestEntry,
    rule: &'a ObjectiveTest,
    window: Result<&'a Manoeuvre, String>,
}

/// Pages in the order of the file; those that share a test of the rule are numbered.
fn places<'a>(session: &'a Session, file: &'a TestFile) -> Vec<Place<'a>> {
    let mut places = Vec::new();
    for entry in &file.tests {
        let Some(rule) = file.rule.test(&entry.id) else { continue };
        for window in windows_of(session, entry, rule) {
            places.push(Place { id: rule.id.clone(), entry, rule, window });
        }
    }
    let mut of_rule: BTreeMap<String, usize> = BTreeMap::new();
    places.iter().for_each(|place| *of_rule.entry(place.id.clone()).or_default() += 1);
    let mut counted: BTreeMap<String, usize> = BTreeMap::new();
    for place in &mut places {
        if of_rule.get(&place.id).is_some_and(|all| *all > 1) {
            let number = counted.entry(place.id.clone()).or_default();
            *number += 1;
            place.id = format!("{}-{number}", place.id);
        }
    }
    places
}

/// Windows that serve a test, or a line for each that is not there.
fn windows_of<'a>(
    session: &'a Session,
    entry: &'a TestEntry,
    rule: &ObjectiveTest,
) -> Vec<Result<&'a Manoeuvre, String>> {
    if !entry.windows.is_empty() {
        let named =
            |name: &'a String| session.window(name).ok_or_else(|| format!("the session has no manoeuvre '{name}'"));
        return entry.windows.iter().map(named).collect();
    }
    let word = entry.kind.as_ref().map(|kind| kind.to_lowercase());
    let of_kind = |window: &Manoeuvre| word.as_ref().is_none_or(|word| window.kind.to_lowercase().contains(word));
    let windows = session.windows.iter().filter(|window| window.role == WindowRole::Validation);
    let found: Vec<_> = windows.filter(|window| rule.applies_to(window) && of_kind(window)).map(Ok).collect();
    if found.is_empty() {
        let kind = entry.kind.as_ref().map(|kind| format!(" with '{kind}' in its kind of input")).unwrap_or_default();
        return vec![Err(format!("the session has no validation manoeuvre for this test{kind}"))];
    }
    found
}

/// What a test is judged with.
struct Evaluation<'a> {
    session: &'a Session,
    snapshot: &'a Snapshot,
    file: &'a TestFile,
    entry: &'a TestEntry,
    rule: &'a ObjectiveTest,
    id: String,
}

impl Evaluation<'_> {
    /// A test without a flight to judge.
    fn unflown(&self, window: Option<&Manoeuvre>, outcome: Outcome, reason: String) -> QualificationTest {
        QualificationTest {
            id: self.id.clone(),
            rule_id: self.rule.id.clone(),
            title: self.title(window),
            certainty: certainty(self.rule).0,
            kind: self.rule.judgement.name(),
            condition: self.entry.condition.clone(),
            model_changed: !self.entry.scale.is_empty(),
            departure: None,
            window: window.map(|window| window.name.clone()),
            passed: outcome.passed(),
            outcome,
            reason,
            channels: Vec::new(),
            values: Vec::new(),
            oscillation: Vec::new(),
            data: None,
            page: Page { facts: pages::stated(self.entry, self.rule, &self.file.rule.name), ..Page::default() },
        }
    }

    /// Title, with the window where several serve one entry of the file.
    fn title(&self, window: Option<&Manoeuvre>) -> String {
        let title = self.entry.title.clone().unwrap_or_else(|| self.rule.name.clone());
        match window.filter(|_| self.entry.windows.len() != 1) {
            Some(window) => format!("{title}, {}", window.name),
            None => title,
        }
    }

    fn test(&self, manoeuvre: &Manoeuvre) -> StageResult<QualificationTest> {
        let unflown = |outcome, reason| self.unflown(Some(manoeuvre), outcome, reason);
        let results = self.snapshot.windows.get(&manoeuvre.name);
        let path = results.and_then(|results| results.path.ready());
        let aero = results.and_then(|results| results.aero.ready());
        let (Some(path), Some(aero)) = (path, aero) else {
            let error = results.and_then(|results| results.path.error().or(results.aero.error()));
            let reason = error.unwrap_or("the manoeuvre was not computed").to_owned();
            return Ok(unflown(Outcome::NotComputed, reason));
        };
        let Some(pooled) = self.snapshot.pooled.ready() else {
            return Ok(unflown(Outcome::NotComputed, "no derivatives were identified".to_owned()));
        };
        let pooled = scaled(pooled, &self.entry.scale)?;
        let (preparation, gravity) = (&self.session.preparation, self.gravity_m_s2());
        let window = ReplayWindow { manoeuvre, path, aero };
        let flight = match window_flight(&path.reconstruction, aero, preparation, gravity) {
            Ok(flight) => flight,
            Err(error) => return Ok(unflown(Outcome::NotComputed, error.to_string())),
        };
        let measured = measured_histories(&flight.motion, aero);
        let moved = movement(manoeuvre, aero);
        let structure = &self.session.structure;
        let mut test = unflown(Outcome::NotComputed, String::new());
        let mut span_s = self.steady_s(manoeuvre, &measured, moved.as_ref());
        if moved.is_none() && self.entry.to_s.is_none() && !self.is_snapshot() {
            span_s[1] = span_s[1].min(span_s[0] + LEAD_S);
        }
        let configuration = self.entry.configuration.as_ref().or(self.file.device.get("configuration"));
        test.page.initial =
            initial((manoeuvre, path), aero, &measured, self.snapshot, configuration.map(String::as_str));
        match &self.rule.judgement {
            Judgement::Snapshot(requirements) | Judgement::TrimChange(requirements) => {
                if let Err(error) = require_vane(&manoeuvre.name, path) {
                    test.reason = error.to_string();
                } else {
                    let model = snapshot::model(&pooled, structure);
                    self.judge_snapshot(&mut test, model, (manoeuvre, aero), &measured, span_s, requirements);
                }
            }
            _ if self.file.constants == Constants::Identification && span_s[1] - span_s[0] < LEAST_STEADY_S => {
                test.outcome = Outcome::RecordTooShort;
                test.reason = format!(
                    "{:.1} s of steady flight before the input: {LEAST_STEADY_S} s are needed to trim the model",
                    (span_s[1] - span_s[0]).max(0.0)
                );
            }
            _ => match self.fly(&window, flight, &pooled, span_s) {
                Err(error) => {
                    test.outcome = Outcome::Failed;
                    test.reason = format!("the model cannot simulate the record: {error}");
                }
                Ok((flown, start)) => {
                    self.judge_flown(&mut test, manoeuvre, &flown, aero, moved.as_ref());
                    test.page.facts.extend(start.iter().flat_map(TrimmedStart::facts));
                    test.add_reservation(start.as_ref().and_then(TrimmedStart::difference));
                }
            },
        }
        test.passed = test.outcome.passed();
        Ok(test)
    }

    /// The record flown by the model: from its own trim, or from the reconstructed state.
    fn fly(
        &self,
        window: &ReplayWindow<'_>,
        flight: WindowFlight,
        pooled: &PooledFits,
        span_s: [f64; 2],
    ) -> StageResult<(WindowReplay, Option<TrimmedStart>)> {
        let (structure, none) = (&self.session.structure, Tolerances::default());
        match self.file.constants {
            Constants::Refit => {
                let model = model_of_window(pooled, structure, window)?;
                Ok((fly_window(window, &model, &flight, &none)?, None))
            }
            Constants::Identification => {
                let model = snapshot::model(pooled, structure)?;
                let trimmed = trimmed(&model, flight, window.aero, span_s)?;
                Ok((fly_window(window, &model, &trimmed.flight, &none)?, Some(trimmed.start)))
            }
        }
    }

    /// Steady flight of a trim, s of the recording: as the file says, else from the start of the record to its input.
    fn steady_s(&self, manoeuvre: &Manoeuvre, measured: &Histories, moved: Option<&Movement>) -> [f64; 2] {
        let begins = measured.time_s.first().copied().unwrap_or(f64::NAN);
        let ends = measured.time_s.last().copied().unwrap_or(f64::NAN);
        let input = moved.map_or(ends, |moved| begins + moved.before_s - MOVING_S);
        let from_start = |time_s: f64| manoeuvre.window.start_s + time_s;
        [self.entry.from_s.map_or(begins, from_start), self.entry.to_s.map_or(input, from_start)]
    }

    fn is_snapshot(&self) -> bool {
        matches!(self.rule.judgement, Judgement::Snapshot(_) | Judgement::TrimChange(_))
    }

    fn gravity_m_s2(&self) -> f64 {
        self.snapshot.gravity_m_s2(self.session)
    }

    /// Judges the flight of the model over the record.
    fn judge_flown(
        &self,
        test: &mut QualificationTest,
        manoeuvre: &Manoeuvre,
        flown: &WindowReplay,
        aero: &WindowAero,
        moved: Option<&Movement>,
    ) {
        let flown = flown.judge_by(self.rule.bands());
        let (measured, simulated) = (&flown.measured, &flown.simulated);
        let ends = [measured.time_s.first(), measured.time_s.last()].map(|time| time.copied().unwrap_or(f64::NAN));
        let rest_s = moved.map_or(ends, |moved| [moved.rest_at_s, moved.rest_until_s]);
        let lag = match &self.rule.judgement {
            Judgement::FreeResponse { lag, .. } => *lag,
            _ => None,
        };
        let free = self.rule.read.map(|signal| free_response(measured, simulated, rest_s, signal, lag));
        let cycles = free.as_ref().and_then(|free| free.cycles);
        let lacks = shortfall(&self.rule.record, moved, ends[1] - ends[0], cycles);
        let mut reasons = Vec::new();
        let mut holds = true;
        if let (Judgement::History(bands), [result]) = (&self.rule.judgement, flown.tests.as_slice()) {
            test.channels = channels(result);
            holds = result.passed();
            reasons.push(over_bands(bands.requirements.len(), result));
        }
        if let (Judgement::FreeResponse { requirements, .. }, Some(free)) = (&self.rule.judgement, &free) {
            self.judge_free(test, requirements, free, &mut reasons, &mut holds);
        } else if let Some(free) = &free {
            test.oscillation = free_response::rows(free);
        }
        if let Judgement::Value { at_s, trend, requirements, .. } = &self.rule.judgement {
            let (rows, agrees) = at_time(measured, simulated, rest_s[0], *at_s, *trend, requirements);
            holds = agrees && met(&rows, requirements.len());
            reasons.push(over_values(&rows, requirements.len()));
            test.values = rows;
        }
        let unread = matches!(self.rule.judgement, Judgement::FreeResponse { .. }) && cycles.is_none();
        test.outcome = match (lacks.is_empty() && !unread, &self.entry.deviation, holds) {
            (false, None, _) => Outcome::RecordTooShort,
            (false, Some(_), _) if unread => Outcome::RecordTooShort,
            (_, _, true) if lacks_data(&test.values) => Outcome::PassedInPart,
            (_, _, true) => Outcome::Passed,
            (_, _, false) => Outcome::Failed,
        };
        if !lacks.is_empty() {
            let lacks = format!("the record has {}", lacks.join(", "));
            test.departure = self.entry.deviation.as_ref().map(|_| lacks.clone());
            reasons.push(lacks);
            if let Some(deviation) = &self.entry.deviation {
                reasons.push("judged with the departure stated on the page".to_owned());
                test.page.facts.push(("Departure".to_owned(), deviation.clone()));
            }
        }
        test.reason = reasons.join("; ");
        test.data = Some(data::copy(&test.id, &flown, aero));
        let loaded = self.snapshot.flights.get(&manoeuvre.flight).and_then(|slot| slot.ready());
        let recording = loaded.map(|loaded| &loaded.recording);
        let constants = self.file.constants;
        test.page.facts.extend(pages::record_facts(manoeuvre, aero, recording, moved, test.data.as_ref(), constants));
        test.page.figure = Some(pages::figure(&test.id, manoeuvre, &flown, aero));
    }

    fn judge_free(
        &self,
        test: &mut QualificationTest,
        requirements: &[Vec<ValueTolerance>],
        free: &FreeResponse,
        reasons: &mut Vec<String>,
        holds: &mut bool,
    ) {
        let pair = |quantity: Quantity| free.pairs.iter().find(|pair| pair.quantity == quantity);
        let flight = |quantity| Some(pair(quantity)?.flight?.value);
        let model = |quantity| Some(pair(quantity)?.model?.value);
        let mut rows = values(requirements, &flight, &model);
        for row in &mut rows {
            let found = free.pairs.iter().find(|pair| pair.quantity.name() == row.parameter);
            let error = |read: Option<Read>| read.map(|read| read.standard_error).filter(|error| error.is_finite());
            row.flight_error = found.and_then(|pair| error(pair.flight));
            row.model_error = found.and_then(|pair| error(pair.model));
        }
        *holds = met(&rows, requirements.len());
        reasons.push(over_values(&rows, requirements.len()));
        reasons.extend(free.unread.iter().cloned());
        test.values = rows;
    }

    /// The trim in another window.
    fn trim(&self, name: &str, model: &Derivatives) -> StageResult<snapshot::Snapshot> {
        let manoeuvre = self.session.window(name).ok_or_else(|| format!("the session has no manoeuvre '{name}'"))?;
        let results = self.snapshot.windows.get(name);
        let path = results.and_then(|results| results.path.ready());
        let (Some(path), Some(aero)) = (path, results.and_then(|results| results.aero.ready())) else {
            return Err(format!("manoeuvre '{name}' was not computed").into());
        };
        require_vane(name, path)?;
        let flight = window_flight(&path.reconstruction, aero, &self.session.preparation, self.gravity_m_s2())?;
        let measured = measured_histories(&flight.motion, aero);
        let span_s = self.steady_s(manoeuvre, &measured, movement(manoeuvre, aero).as_ref());
        snapshot(model, aero, &measured, span_s, self.gravity_m_s2())
    }

    /// Judges the model's trim.
    fn judge_snapshot(
        &self,
        test: &mut QualificationTest,
        model: StageResult<Derivatives>,
        (manoeuvre, aero): (&Manoeuvre, &WindowAero),
        measured: &Histories,
        span_s: [f64; 2],
        requirements: &[Vec<ValueTolerance>],
    ) {
        let trim = match &self.rule.judgement {
            Judgement::TrimChange(_) => self.entry.trim.as_deref(),
            _ => None,
        };
        let before = match (trim, &model) {
            (Some(window), Ok(model)) => self.trim(window, model).map(Some),
            _ => Ok(None),
        };
        let before = match before {
            Ok(before) => before,
            Err(error) => {
                test.reason = format!("reference trim: {error}");
                return;
            }
        };
        let found = model.and_then(|model| {
            let own = snapshot(&model, aero, measured, span_s, self.gravity_m_s2())?;
            Ok(before.map_or_else(|| own.clone(), |before| own.since(&before)))
        });
        let found = match found {
            Ok(found) => found,
            Err(error) => {
                test.outcome = Outcome::Failed;
                test.reason = format!("the model has no trim there: {error}");
                return;
            }
        };
        let value_of = |values: &snapshot::Values, quantity: Quantity| {
            values.iter().find(|(known, _)| *known == quantity).map(|(_, value)| *value)
        };
        let rows = values(requirements, &|quantity| value_of(&found.flight, quantity), &|quantity| {
            value_of(&found.model, quantity)
        });
        test.outcome = match met(&rows, requirements.len()) {
            true if lacks_data(&rows) => Outcome::PassedInPart,
            true => Outcome::Passed,
            false => Outcome::Failed,
        };
        test.reason = over_values(&rows, requirements.len());
        test.values = rows;
        test.page.facts.extend(pages::snapshot_facts(manoeuvre, span_s, trim));
    }
}

/// Refuses a window without a measured angle of attack: the trim angle of attack of the flight is not known there.
fn require_vane(name: &str, path: &WindowPath) -> StageResult<()> {
    if path.missing.contains(&Measurement::AngleOfAttack) {
        return Err(format!("manoeuvre '{name}' has no measured angle of attack: its trim is unknown").into());
    }
    Ok(())
}

/// The estimates with some derivatives changed by a factor.
fn scaled(pooled: &PooledFits, scale: &BTreeMap<String, f64>) -> StageResult<PooledFits> {
    let mut pooled = pooled.clone();
    for (name, factor) in scale {
        let fits = pooled.fits.iter_mut().filter_map(|fit| fit.fit.as_mut().ok());
        let change = |fit: &mut Fit| {
            let index = fit.names.iter().position(|known| known == name)?;
            fit.estimates.get_mut(index).map(|estimate| *estimate *= factor)
        };
        if fits.filter_map(change).count() == 0 {
            return Err(format!("scale: the model has no derivative '{name}'").into());
        }
    }
    Ok(pooled)
}
