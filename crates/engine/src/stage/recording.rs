//! Reads the recordings of one flight and merges them on its time line.

use std::collections::{BTreeMap, BTreeSet};

use doublet_core::airframe::instruments::StatedNoise;
use doublet_core::load::{ChannelMap, read_all};
use doublet_core::message;
use doublet_core::message::{Message, file, quoted};
use doublet_core::quantity::Role;
use doublet_core::series::{ClockRestart, Recording};
use rayon::prelude::*;

use super::air_data::add_air_data;
use super::align::{UsedClock, align};
use super::expressions::{ExpressedChannel, add_expressions};
use super::held_samples::use_held_once;
use super::instruments::derive;
use super::signals::{TreatedSignal, treat_signals};
use super::stalls::{Stall, find_stalls};
use crate::graph::{Context, Footprint, Stage, StageError, StageResult};
use crate::session::{Finding, Flight, HeldSampleUse, Level, MapRef, Place, RecordingRef, content_hash};

/// A flight as read.
#[derive(Clone, Debug, Default)]
pub struct LoadedFlight {
    /// Channels and roles of all its recordings.
    pub recording: Recording,
    /// SHA-256 of each recording, in the order of the session.
    pub hashes: Vec<String>,
    /// Clocks applied.
    pub clocks: Vec<UsedClock>,
    /// Signals that were smoothed or resampled.
    pub treated: Vec<TreatedSignal>,
    /// Channels that expressions gave, in the order of the session.
    pub expressions: Vec<ExpressedChannel>,
    /// UTC of the first sample, s since 1970-01-01, where a recorder's clock says.
    pub utc_start_s: Option<f64>,
    /// SHA-256 of the instruments file, where the flight has one.
    pub instruments_sha256: Option<String>,
    /// Noise that the instruments file states.
    pub stated_noise: BTreeMap<Role, StatedNoise>,
    /// What was found in its signals and what was done about it.
    pub findings: Vec<Finding>,
    /// Blocks in which a recorder stalls.
    pub stalls: Vec<Stall>,
}

impl LoadedFlight {
    /// The flight with the stalls of its recorders found.
    #[must_use]
    pub fn with_stalls(mut self) -> Self {
        self.stalls = find_stalls(&self);
        self
    }
}

impl Footprint for LoadedFlight {
    fn bytes(&self) -> usize {
        self.recording.channels.iter().map(|channel| channel.series.values.len() * 16 + 200).sum()
    }
}

/// A flight as read: moving a clock reads nothing again.
struct ReadFlight;

impl Stage for ReadFlight {
    type Params<'a> = &'a [RecordingRef];
    type Inputs<'a> = ();
    type Output = LoadedFlight;
    const NAME: &'static str = "flight as read";

    fn run(recordings: &[RecordingRef], (): (), context: &Context<'_>) -> StageResult<LoadedFlight> {
        read_flight(context, recordings)
    }
}

/// A flight on its time line with all that the session makes of it. Changing an expression fits no clock again.
impl Stage for LoadedFlight {
    type Params<'a> = &'a Flight;
    type Inputs<'a> = ();
    type Output = Self;
    const NAME: &'static str = "flight";

    fn run(flight: &Flight, (): (), context: &Context<'_>) -> StageResult<Self> {
        if flight.expressions.is_empty() {
            return align_flight(context, &*context.get::<ReadFlight>(&flight.recordings, ())?, flight);
        }
        let without = Flight { expressions: Vec::new(), ..flight.clone() };
        add_expressions(&*context.get::<Self>(&without, ())?, &flight.expressions)
    }
}

/// Reads a flight, every recorder on its own clock.
pub fn read_flight(context: &Context<'_>, recordings: &[RecordingRef]) -> StageResult<LoadedFlight> {
    let place = |entry: &RecordingRef| context.locate(&entry.path).map_err(|line| describe_missing(&line, entry));
    let places = recordings.iter().map(place).collect::<Result<Vec<_>, _>>()?;
    let hash_all = || places.par_iter().map(|place| content_hash(place)).collect::<Vec<_>>();
    let (hashes, merged) = rayon::join(hash_all, || merge_all(context, recordings));
    let hashes = hashes.into_iter().collect::<Result<Vec<_>, _>>().map_err(|error| error.to_string())?;
    let (mut merged, utc_start_s) = merged?;
    let changes = recordings.iter().zip(&hashes).filter_map(|(entry, hash)| describe_change(entry, hash));
    merged.warnings.splice(0..0, changes);
    let mut seen = BTreeSet::new();
    merged.warnings.retain(|warning| seen.insert(warning.to_string()));
    Ok(LoadedFlight { recording: merged, hashes, utc_start_s, ..LoadedFlight::default() })
}

/// All recorders of a flight in one recording, and when the first of them begins, UTC, s since 1970-01-01.
fn merge_all(context: &Context<'_>, recordings: &[RecordingRef]) -> StageResult<(Recording, Option<f64>)> {
    let mut merged = Recording::default();
    let mut utc_start_s: Option<f64> = None;
    for Group { map, only, entries } in groups(recordings) {
        let text = match map {
            MapRef::File(path) => context.text(path, "channel_maps")?,
            MapRef::Own(text) => text.to_string(),
        };
        let map = ChannelMap::parse(&text).map_err(|error| format!("channel map {}: {error}", map.name()))?;
        let places = entries.iter().map(|entry| context.locate(&entry.path)).collect::<Result<Vec<_>, _>>()?;
        let recording = read_all(&places, &map).map_err(|error| error.to_string())?;
        utc_start_s = utc_start_s.into_iter().chain(first_utc_s(&recording)).reduce(f64::min);
        merge(&mut merged, recording, only);
    }
    if let (Some((source, restarts)), true) = (merged.restarts.first_key_value(), recordings.len() > 1) {
        let after_s = restarts.first().map_or(f64::NAN, |restart| restart.before_s);
        let line = format!("recorder '{source}' restarted after {after_s:.3} s, beside other recordings");
        return Err(format!("{line}: write each part to a separate file").into());
    }
    Ok((merged, utc_start_s))
}

/// Where the recorder of a flight restarted, and where its later samples were put.
pub fn restart_findings(recording: &Recording, flight: &str) -> Vec<Finding> {
    let all =
        recording.restarts.iter().flat_map(|(source, restarts)| restarts.iter().map(move |restart| (source, restart)));
    all.map(|(source, restart)| restart_finding(source, restart, flight)).collect()
}

fn restart_finding(source: &str, restart: &ClockRestart, flight: &str) -> Finding {
    let (before_s, time_s) = (restart.before_s, restart.time_s);
    let (source, begin) = (quoted(source), "its later samples begin at");
    let text = message!("Recorder {} restarted after {:.3} s; {} {:.3} s.", source, before_s, begin, time_s);
    Finding::new(Level::Caution, "clock", Place::flight(flight), text)
        .with_fix_text("Mark no manoeuvre across it; split the file if these are two flights.")
        .with_setting("Preprocess", "")
}

/// What to say of a recording whose content is not what it was when it was added.
pub fn describe_change(entry: &RecordingRef, hash: &str) -> Option<Message> {
    let known = entry.sha256.as_ref().filter(|known| *known != hash)?;
    let path = file(entry.path.as_ref());
    Some(message!("{} has changed since it was added: its SHA-256 was {}, now it is {}", path, known.as_str(), hash))
}

/// Puts a flight as read on its time line, adds what its instruments give, and smooths and resamples what the session says.
pub fn align_flight(context: &Context<'_>, read: &LoadedFlight, flight: &Flight) -> StageResult<LoadedFlight> {
    let (mut recording, clocks, mut findings) = align(&read.recording, flight)?;
    let instruments =
        flight.instruments.as_ref().map(|setting| derive(&mut recording, context, setting)).transpose()?;
    let (instruments_sha256, stated_noise) = instruments.unzip();
    let (held, of_samples) = match flight.signals.held_samples {
        HeldSampleUse::Once => use_held_once(&mut recording, &flight.name),
        HeldSampleUse::Every => Default::default(),
    };
    findings.extend(of_samples);
    findings.extend(restart_findings(&read.recording, &flight.name));
    add_air_data(&mut recording);
    let treated = join_treatments(held, treat_signals(&mut recording, &flight.signals)?);
    let (hashes, utc_start_s) = (read.hashes.clone(), read.utc_start_s);
    let loaded = LoadedFlight {
        recording,
        hashes,
        clocks,
        treated,
        expressions: Vec::new(),
        utc_start_s,
        instruments_sha256,
        stated_noise: stated_noise.unwrap_or_default(),
        findings,
        stalls: Vec::new(),
    };
    Ok(loaded.with_stalls())
}

/// What was done to signals by two steps, one row per role that begins at its recorded channel.
fn join_treatments(first: Vec<TreatedSignal>, then: Vec<TreatedSignal>) -> Vec<TreatedSignal> {
    let mut all = first;
    for next in then {
        match all.iter_mut().find(|before| before.role == next.role) {
            Some(before) => {
                before.steps.extend(next.steps);
                before.samples[1] = next.samples[1];
                (before.stretches, before.max_gap_s) = (next.stretches, next.max_gap_s);
            }
            None => all.push(next),
        }
    }
    all
}

/// UTC of the first sample of a recording on its own clocks, s since 1970-01-01.
fn first_utc_s(recording: &Recording) -> Option<f64> {
    let stamped = recording
        .channels
        .iter()
        .filter_map(|channel| Some(recording.utc_start_s.get(&channel.source)? + channel.series.time_s.first()?));
    stamped.reduce(f64::min)
}

/// What to look for where a recording is missing.
fn describe_missing(line: &StageError, entry: &RecordingRef) -> String {
    match &entry.sha256 {
        Some(hash) => format!("{line}: put back the recording with SHA-256 {hash}, or change its path in the session"),
        None => format!("{line}: put the recording back, or change its path in the session"),
    }
}

/// Neighbouring recordings with one channel map: read together, so that the map sees all their sources.
struct Group<'a> {
    map: &'a MapRef,
    only: Option<&'a [Role]>,
    entries: Vec<&'a RecordingRef>,
}

fn groups(recordings: &[RecordingRef]) -> Vec<Group<'_>> {
    let mut groups: Vec<Group<'_>> = Vec::new();
    for entry in recordings {
        let (map, only) = (&entry.channel_map, entry.only.as_deref());
        match groups.last_mut() {
            Some(group) if group.map == map && group.only == only => group.entries.push(entry),
            _ => groups.push(Group { map, only, entries: vec![entry] }),
        }
    }
    groups
}

/// Adds channels and roles. What the flight has already is kept and said.
fn merge(merged: &mut Recording, added: Recording, only: Option<&[Role]>) {
    let offset = merged.channels.len();
    let roles: BTreeMap<_, _> =
        added.roles.into_iter().filter(|(role, _)| only.is_none_or(|roles| roles.contains(role))).collect();
    for (role, index) in roles {
        let channel = &added.channels[index];
        match merged.role(role) {
            Some(first) => merged.warnings.push(message!(
                "{} is recorded in {} and in {}: the first is used; limit the roles of one recording to choose",
                role.name(),
                &first.source,
                &channel.source
            )),
            None => {
                merged.roles.insert(role, offset + index);
            }
        }
    }
    merged.channels.extend(added.channels);
    merged.warnings.extend(added.warnings);
    merged.restarts.extend(added.restarts);
    for (state, series) in added.truth {
        merged.truth.entry(state).or_insert(series);
    }
}
