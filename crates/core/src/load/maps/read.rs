//! Reading: from a plan to a recording in SI.

use std::borrow::Cow;
use std::collections::{BTreeMap, BTreeSet};
use std::path::Path;
use std::sync::Arc;

use rayon::prelude::*;

use crate::load::clock::{TimeFault, fault_at};
use crate::load::clocks::counter::unwrap_counter;
use crate::load::contents::{Data, Probe, Source};
use crate::load::error::LoadError;
use crate::load::formats::recognise::inspect;
use crate::load::maps::derive::{add_attitude, add_position, add_velocity};
use crate::load::maps::map::ChannelMap;
use crate::load::maps::plan::{Assignment, At, Plan, plan_all};
use crate::load::restart::follow_restarts;
use crate::message;
use crate::message::{Message, file, quoted};
use crate::series::{Channel, ClockRestart, Recording, Series};

/// Reads what `plan` says: mapped channels in SI first, then every other channel that has a time vector, as recorded.
///
/// # Errors
/// [`LoadError::Plan`] when the plan has errors; [`LoadError::Time`] when the time of a mapped channel does not increase and
/// the map does not say to drop such samples; whatever reading the file gives.
pub fn read(plan: &Plan) -> Result<Recording, LoadError> {
    read_probes(plan, plan.probes.clone())
}

/// Reads what `plan` says of `probes`, which are its own. Samples that nothing else holds are given back as soon as they are converted.
fn read_probes(plan: &Plan, mut probes: Vec<Probe>) -> Result<Recording, LoadError> {
    if plan.has_errors() {
        return Err(LoadError::Plan { problems: plan.problems.clone() });
    }
    for probe in &mut probes {
        probe.complete()?;
    }
    let uses = count_uses(plan);
    let maps = (BTreeMap::new(), BTreeMap::new(), BTreeMap::new());
    let mut reader = Reader { plan, probes, uses, stamps: maps.0, shifts: maps.1, joined: maps.2 };
    let mut recording = Recording::default();
    for probe in &reader.probes {
        recording.warnings.extend(probe.warnings.iter().map(|warning| message!("{}: {}", file(&probe.path), warning)));
    }
    recording.warnings.extend(plan.problems.iter().map(|problem| problem.to_string().into()));
    reader.lay_end_to_end(&mut recording.warnings)?;
    let mut used = BTreeSet::new();
    for (&role, assignment) in &plan.roles {
        let series = reader.series(assignment)?;
        let first = assignment.parts[0][0].0;
        if assignment.parts[0].len() == 1 {
            used.extend(assignment.parts.iter().map(|terms| terms[0].0));
        }
        note_non_finite(&assignment.target, &series, &mut recording.warnings);
        recording.roles.insert(role, recording.channels.len());
        let names: Vec<&str> = assignment.parts[0].iter().map(|&(at, _)| reader.channel_name(at)).collect();
        let (source, name) = (reader.source(first).name.clone(), names.join(" & "));
        reader.give_back(assignment);
        recording.channels.push(Channel { source, name, unit: role.dimension().si_symbol().to_owned(), series });
    }
    for (name, assignment) in &plan.truth {
        recording.truth.insert(name.clone(), reader.series(assignment)?);
        used.extend(assignment.parts.iter().flatten().map(|&(at, _)| at));
    }
    reader.derive(&mut recording, &mut used)?;
    let of_roles: BTreeSet<ClockAt> = reader.stamps.keys().copied().collect();
    reader.add_unmapped(&used, &mut recording);
    reader.note_clocks(&of_roles, &mut recording);
    Ok(recording)
}

/// Reads all recordings of one flight into one.
///
/// # Errors
/// As [`crate::load::probe()`] and [`read`].
pub fn read_all<P: AsRef<Path>>(paths: &[P], map: &ChannelMap) -> Result<Recording, LoadError> {
    let paths: Vec<&Path> = paths.iter().map(AsRef::as_ref).collect();
    let probes: Vec<_> = paths.into_par_iter().with_max_len(1).map(inspect).collect();
    // of several that cannot be read the first is told
    let probes = probes.into_iter().collect::<Result<Vec<_>, _>>()?;
    let mut plan = plan_all(&probes, map);
    drop(probes);
    let probes = std::mem::take(&mut plan.probes);
    read_probes(&plan, probes)
}

/// How often the roles, histories and derived roles of a plan use each channel. One that is mixed with others is also added as recorded.
fn count_uses(plan: &Plan) -> BTreeMap<At, usize> {
    let attitude = plan.derived.attitude.iter().flat_map(|(parts, _)| parts);
    let derived = attitude.chain(plan.derived.velocity.iter().flatten());
    let mut uses = BTreeMap::new();
    for assignment in plan.roles.values().chain(plan.truth.values()).chain(derived) {
        let is_mixed = usize::from(assignment.parts.iter().any(|terms| terms.len() > 1));
        for &(at, _) in assignment.parts.iter().flatten() {
            *uses.entry(at).or_insert(0) += 1 + is_mixed;
        }
    }
    uses
}

/// What to do about a time vector that does not increase.
const TIME_CURE: &str =
    "set the repair of the time to 'drop' in the channel map, or state start time and sample rate there";

/// What to do about a clock that was set back and went on.
const RESTART_CURE: &str = "if the recorder restarted there, write each part to a separate file; for single late samples set the \
                            repair of the time to 'drop' in the channel map";
/// Most samples behind a step back of single late samples.
const MOST_LATE: usize = 50;

/// A clock's place: probe, source, clock.
type ClockAt = (usize, usize, usize);

/// Stamps of a clock and the samples that keep theirs.
struct Stamps {
    time_s: Arc<[f64]>,
    /// Indices kept, when some were left out.
    kept: Option<Vec<usize>>,
    /// Whether they are of a counter that began again at zero and was continued.
    is_continued: bool,
    /// Restarts of the recorder, behind which they follow.
    restarts: Vec<ClockRestart>,
}

struct Reader<'p> {
    plan: &'p Plan,
    probes: Vec<Probe>,
    /// How often each channel is still needed.
    uses: BTreeMap<At, usize>,
    stamps: BTreeMap<ClockAt, Stamps>,
    /// Added to the time of a source laid end to end, s.
    shifts: BTreeMap<(usize, usize), f64>,
    /// Time vectors of recordings in parts.
    joined: BTreeMap<Vec<ClockAt>, Arc<[f64]>>,
}

impl Reader<'_> {
    fn source(&self, at: At) -> &Source {
        &self.probes[at.probe].sources[at.source]
    }

    fn channel_name(&self, at: At) -> &str {
        &self.source(at).channels[at.channel].name
    }

    fn clock_at(&self, at: At) -> Option<ClockAt> {
        self.source(at).channels[at.channel].clock.map(|clock| (at.probe, at.source, clock))
    }

    /// Stamps of one clock, checked once.
    fn stamps(&mut self, at: ClockAt) -> Result<&Stamps, LoadError> {
        if !self.stamps.contains_key(&at) {
            let stamps = self.check_stamps(at)?;
            self.stamps.insert(at, stamps);
        }
        Ok(&self.stamps[&at])
    }

    fn check_stamps(&self, at: ClockAt) -> Result<Stamps, LoadError> {
        let (probe, source, clock) = at;
        let source = &self.probes[probe].sources[source];
        let clock = &source.clocks[clock];
        let shift = self.shifts.get(&(at.0, at.1)).copied().unwrap_or(0.0);
        let Some(index) = clock.index else {
            let time_s = (0..clock.samples).map(|index| clock.start_s + shift + index as f64 / clock.rate_hz).collect();
            return Ok(Stamps { time_s, kept: None, is_continued: false, restarts: Vec::new() });
        };
        let raw = unwrap_counter(source.channels[index].values());
        let is_asked = self.plan.time.get(&(at.0, at.1)).is_some_and(|entry| entry.drop_faults);
        let in_seconds = |value: f64| clock.unit.to_si(value) + shift;
        // Beside another clock the time that the recorder was off would have to be known.
        let follows = !clock.restarts.is_empty() && !is_asked && self.has_one_clock();
        let all = |raw: &[f64]| raw.iter().map(|&value| in_seconds(value)).collect::<Vec<_>>();
        let (followed, restarts) = follows.then(|| follow_restarts(&all(&raw))).flatten().unzip();
        let mut latest = f64::NEG_INFINITY;
        let mut kept: Option<Vec<usize>> = None;
        let mut time_s = Vec::with_capacity(raw.len());
        for (index, &value) in raw.iter().enumerate() {
            let time = followed.as_ref().map_or_else(|| in_seconds(value), |times| times[index]);
            match fault_at(index, time, latest) {
                None => {
                    latest = time;
                    time_s.push(time);
                    kept.iter_mut().for_each(|kept| kept.push(index));
                }
                Some(fault) if is_asked || clock.repeats_some() && matches!(fault, TimeFault::Repeated { .. }) => {
                    kept.get_or_insert_with(|| (0..index).collect());
                }
                Some(fault) => return Err(self.time_error(at, fault)),
            }
        }
        let (is_continued, restarts) = (matches!(raw, Cow::Owned(_)), restarts.unwrap_or_default());
        Ok(Stamps { time_s: time_s.into(), kept, is_continued, restarts })
    }

    /// Whether all that is read has one clock.
    fn has_one_clock(&self) -> bool {
        let sources = self.probes.iter().flat_map(|probe| &probe.sources);
        sources.map(|source| source.clocks.len()).sum::<usize>() == 1
    }

    fn time_error(&self, at: ClockAt, fault: TimeFault) -> LoadError {
        let probe = &self.probes[at.0];
        let source = &probe.sources[at.1];
        let clock = &source.clocks[at.2];
        let restarts = matches!(fault, TimeFault::Backwards { index, .. } if index + MOST_LATE < clock.samples);
        let fix = clock.question.as_deref().unwrap_or(if restarts { RESTART_CURE } else { TIME_CURE }).into();
        let (path, source_name, channel) = (probe.path.clone(), source.name.clone(), clock.channel.clone());
        LoadError::Time { path, source_name, channel, fault, fix }
    }

    /// Shifts the sources of a recording in parts so that each starts after the one before.
    fn lay_end_to_end(&mut self, warnings: &mut Vec<Message>) -> Result<(), LoadError> {
        let Some(gap_s) = self.plan.end_to_end_gap_s else { return Ok(()) };
        let mut end_s: Option<f64> = None;
        for &(probe, source) in &self.plan.sequence {
            let stamps = self.check_stamps((probe, source, 0))?;
            let (Some(&first), Some(&last)) = (stamps.time_s.first(), stamps.time_s.last()) else { continue };
            let shift = end_s.map_or(0.0, |end| end + gap_s - first);
            self.shifts.insert((probe, source), shift);
            end_s = Some(last + shift);
            let (name, start, end) = (&self.probes[probe].sources[source].name, first + shift, last + shift);
            warnings.push(message!(
                "source {} covers {:.3} s to {:.3} s: its clock plus {:.3} s",
                quoted(name),
                start,
                end,
                shift
            ));
        }
        Ok(())
    }

    /// The SI series of one assignment: sign * scale * to_si(sum of weight * raw + offset).
    fn series(&mut self, assignment: &Assignment) -> Result<Series, LoadError> {
        let clocks: Vec<ClockAt> = assignment.parts.iter().filter_map(|terms| self.clock_at(terms[0].0)).collect();
        for &clock in &clocks {
            self.stamps(clock)?;
        }
        let parts = assignment.parts.iter().zip(&clocks);
        let mut parts =
            parts.map(|(terms, clock)| self.converted(assignment, terms, self.stamps[clock].kept.as_deref()));
        if let [clock] = clocks[..] {
            let values = parts.next().unwrap_or_default();
            return Ok(Series { time_s: Arc::clone(&self.stamps[&clock].time_s), values });
        }
        let values = parts.flat_map(|part| part.to_vec()).collect();
        Ok(Series { time_s: self.joined_time(clocks)?, values })
    }

    /// Adds the roles that the map derives; the channels they are made of count as used.
    fn derive(&mut self, recording: &mut Recording, used: &mut BTreeSet<At>) -> Result<(), LoadError> {
        if let Some(position) = &self.plan.position {
            add_position(recording, position);
        }
        let channels = &self.plan.derived;
        if let Some((parts, axes)) = &channels.attitude {
            let series = parts.iter().map(|part| self.series(part)).collect::<Result<Vec<_>, _>>()?;
            add_attitude(recording, &series, *axes);
        }
        if let Some([speed, track]) = &channels.velocity {
            let (speed, track) = (self.series(speed)?, self.series(track)?);
            add_velocity(recording, &speed, &track);
        }
        let attitude = channels.attitude.iter().flat_map(|(parts, _)| parts);
        let all = attitude.chain(channels.velocity.iter().flatten());
        used.extend(all.flat_map(|assignment| assignment.parts.iter().flatten()).map(|&(at, _)| at));
        Ok(())
    }

    /// Lets go of the samples of an assignment that nothing needs any more; time vectors are kept.
    fn give_back(&mut self, assignment: &Assignment) {
        for &(at, _) in assignment.parts.iter().flatten() {
            let Some(uses) = self.uses.get_mut(&at) else { continue };
            *uses = uses.saturating_sub(1);
            let source = &mut self.probes[at.probe].sources[at.source];
            let is_clock = source.clocks.iter().any(|clock| clock.index == Some(at.channel));
            if *uses == 0 && !is_clock {
                source.channels[at.channel].data = Data::Values(Arc::default());
            }
        }
    }

    /// The samples of a channel as they are, where an assignment changes none of them.
    fn unchanged(&self, assignment: &Assignment, terms: &[(At, f64)], kept: Option<&[usize]>) -> Option<Arc<[f64]>> {
        let ([(at, weight)], None) = (terms, kept) else { return None };
        let Data::Values(values) = &self.source(*at).channels[at.channel].data else { return None };
        let is_one = *weight == 1.0 && assignment.factor == 1.0 && assignment.unit.scale == 1.0;
        let is_as_recorded = is_one && assignment.offset == 0.0 && assignment.unit.offset == 0.0;
        // A sum with zero has no negative zero.
        let has_sum = || values.iter().any(|value| value.to_bits() == (-0.0_f64).to_bits());
        (is_as_recorded && !has_sum()).then(|| Arc::clone(values))
    }

    /// Values of one part of an assignment, SI.
    fn converted(&self, assignment: &Assignment, terms: &[(At, f64)], kept: Option<&[usize]>) -> Arc<[f64]> {
        if let Some(values) = self.unchanged(assignment, terms, kept) {
            return values;
        }
        let raw: Vec<(&[f64], f64)> =
            terms.iter().map(|&(at, weight)| (self.source(at).channels[at.channel].values(), weight)).collect();
        let convert = |index: usize| {
            let sum: f64 = raw.iter().map(|(values, weight)| weight * values[index]).sum();
            assignment.factor * assignment.unit.to_si(sum + assignment.offset)
        };
        match kept {
            None => (0..raw[0].0.len()).map(convert).collect(),
            Some(kept) => kept.iter().map(|&index| convert(index)).collect(),
        }
    }

    /// Time of consecutive parts, which may not overlap.
    fn joined_time(&mut self, clocks: Vec<ClockAt>) -> Result<Arc<[f64]>, LoadError> {
        for pair in clocks.windows(2) {
            let (before, after) = (&self.stamps[&pair[0]].time_s, &self.stamps[&pair[1]].time_s);
            if let (Some(&before_s), Some(&time_s)) = (before.last(), after.first())
                && before_s >= time_s
            {
                return Err(self.time_error(pair[1], TimeFault::Backwards { index: 0, before_s, time_s }));
            }
        }
        let stamps = &self.stamps;
        let join =
            |clocks: &Vec<ClockAt>| clocks.iter().flat_map(|clock| stamps[clock].time_s.iter().copied()).collect();
        let time: &mut Arc<[f64]> = self.joined.entry(clocks.clone()).or_insert_with(|| join(&clocks));
        Ok(Arc::clone(time))
    }

    /// Adds every channel that has a time vector and plays no role, as recorded.
    fn add_unmapped(&mut self, used: &BTreeSet<At>, recording: &mut Recording) {
        let mut refused = BTreeSet::new();
        for probe in 0..self.probes.len() {
            for source in 0..self.probes[probe].sources.len() {
                for channel in 0..self.probes[probe].sources[source].channels.len() {
                    let at = At { probe, source, channel };
                    let Some(clock) = self.clock_at(at) else { continue };
                    if used.contains(&at) || refused.contains(&clock) || self.source(at).channels[channel].is_time {
                        continue;
                    }
                    if let Err(error) = self.stamps(clock) {
                        recording.warnings.push(message!("{}; its channels are left out", error.to_string()));
                        refused.insert(clock);
                        continue;
                    }
                    recording.channels.push(self.as_recorded(at, &self.stamps[&clock]));
                }
            }
        }
    }

    fn as_recorded(&self, at: At, stamps: &Stamps) -> Channel {
        let (source, channel) = (self.source(at), &self.source(at).channels[at.channel]);
        let values = match (&channel.data, &stamps.kept) {
            (Data::Values(values), None) => Arc::clone(values),
            (_, Some(kept)) => kept.iter().map(|&index| channel.values()[index]).collect(),
            (_, None) => channel.values().into(),
        };
        let unit = channel.unit.clone().unwrap_or_default();
        let series = Series { time_s: Arc::clone(&stamps.time_s), values };
        Channel { source: source.name.clone(), name: channel.name.clone(), unit, series }
    }

    /// Warnings on samples left out by the clocks that were used and on gaps of those of roles, and their UTC starts.
    fn note_clocks(&self, of_roles: &BTreeSet<ClockAt>, recording: &mut Recording) {
        for (&at, stamps) in &self.stamps {
            let (probe, source, clock) = at;
            let contents = &self.probes[probe].sources[source];
            let clock = &contents.clocks[clock];
            let place = message!("{}: source {}", file(&self.probes[probe].path), quoted(&contents.name));
            if let Some(kept) = &stamps.kept {
                let (lost, all) = (clock.samples - kept.len(), clock.samples);
                let why =
                    clock.faults.first().map(|fault| format!(", the first because it {fault}")).unwrap_or_default();
                let omitted = message!("{}: {} of {} samples omitted for their time stamps{}", &place, lost, all, why);
                recording.warnings.push(omitted);
            }
            if !stamps.restarts.is_empty() {
                recording.restarts.insert(contents.name.clone(), stamps.restarts.clone());
            }
            if stamps.is_continued {
                let channel = quoted(&clock.channel);
                recording.warnings.push(message!(
                    "{}: time counter {} begins again at zero, continued",
                    &place,
                    channel
                ));
            }
            let longest = clock.gaps.iter().max_by(|a, b| (a.end_s - a.start_s).total_cmp(&(b.end_s - b.start_s)));
            if let Some(longest) = longest.filter(|_| of_roles.contains(&at)) {
                let (count, length) = (clock.gaps.len(), longest.end_s - longest.start_s);
                let after_s = longest.start_s;
                let gaps = "gaps in time, the longest";
                recording.warnings.push(message!(
                    "{}: {} {} {:.3} s after {:.3} s",
                    &place,
                    count,
                    gaps,
                    length,
                    after_s
                ));
            }
            if let Some(utc) = self.plan.time.get(&(probe, source)).and_then(|entry| entry.utc_start_s) {
                recording.utc_start_s.insert(contents.name.clone(), utc);
            }
        }
    }
}

/// Says how many samples are not finite, unless blanks between those of a slower sensor are meant.
fn note_non_finite(target: &str, series: &Series, warnings: &mut Vec<Message>) {
    let Some(first) = series.values.iter().position(|value| !value.is_finite()) else { return };
    if is_of_slower_sensor(&series.values) {
        return;
    }
    let count = series.values.iter().filter(|value| !value.is_finite()).count();
    let (all, time) = (series.values.len(), series.time_s[first]);
    warnings.push(message!("{}: {} of {} samples are not finite, the first at {:.3} s", target, count, all, time));
}

/// Whether the finite values come every so many rows.
fn is_of_slower_sensor(values: &[f64]) -> bool {
    /// Finite values that show it at least, and the part of their intervals that must be the usual one, or one row off it.
    const LEAST: usize = 10;
    const EVEN: f64 = 0.95;
    let rows: Vec<usize> = (0..values.len()).filter(|&row| values[row].is_finite()).collect();
    let mut intervals: Vec<usize> = rows.windows(2).map(|pair| pair[1] - pair[0]).collect();
    if rows.len() < LEAST {
        return false;
    }
    intervals.sort_unstable();
    let usual = intervals[intervals.len() / 2];
    let even = intervals.iter().filter(|interval| interval.abs_diff(usual) <= 1).count();
    usual >= 2 && even as f64 >= EVEN * intervals.len() as f64
}
