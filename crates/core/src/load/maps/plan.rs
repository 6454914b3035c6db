//! The plan: which channel will play which role, and every problem, before anything is read.

use std::collections::{BTreeMap, BTreeSet};

use crate::load::clocks::time_unit::{contradiction, settle_units};
use crate::load::contents::{ChannelInfo, Probe, Source};
use crate::load::error::Problem;
use crate::load::maps::attitude::QuaternionAxes;
use crate::load::maps::by_name::{column_counts, find, set_clock};
use crate::load::maps::map::{ATTITUDE, ChannelMap, Entry, FlatEarth, Term, TimeEntry, VELOCITY, matches};
use crate::quantity::{Dimension, Role, Unit};

/// Place of a channel among probes.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) struct At {
    pub probe: usize,
    pub source: usize,
    pub channel: usize,
}

/// One role and the channels that will make it.
#[derive(Clone, Debug)]
pub struct Assignment {
    /// What it will be: a role's name, or a state's for a true history.
    pub target: String,
    /// Channels with their files, sources and weights, as shown to the user.
    pub description: String,
    /// The same without files.
    pub channels: String,
    /// Unit of the raw value.
    pub unit: Unit,
    /// Samples there will be, before any are left out for their time.
    pub samples: usize,
    /// Sign times scale.
    pub(crate) factor: f64,
    /// Added to the raw value.
    pub(crate) offset: f64,
    /// Channels and weights, for each part of a recording in parts.
    pub(crate) parts: Vec<Vec<(At, f64)>>,
}

/// The channels that derived roles are made of.
#[derive(Clone, Debug, Default)]
pub(crate) struct DerivedChannels {
    pub attitude: Option<(Vec<Assignment>, QuaternionAxes)>,
    pub velocity: Option<[Assignment; 2]>,
}

/// What reading will do.
#[derive(Clone, Debug)]
pub struct Plan {
    /// Roles and their channels.
    pub roles: BTreeMap<Role, Assignment>,
    /// True histories and their channels.
    pub truth: BTreeMap<String, Assignment>,
    /// Everything that is wrong or worth knowing.
    pub problems: Vec<Problem>,
    pub(crate) probes: Vec<Probe>,
    pub(crate) position: Option<FlatEarth>,
    pub(crate) derived: DerivedChannels,
    pub(crate) end_to_end_gap_s: Option<f64>,
    /// Sources laid end to end, in order, as `(probe, source)`.
    pub(crate) sequence: Vec<(usize, usize)>,
    /// Time entry of each source, by `(probe, source)`.
    pub(crate) time: BTreeMap<(usize, usize), TimeEntry>,
}

impl Plan {
    /// Whether [`crate::load::read()`] will refuse.
    pub fn has_errors(&self) -> bool {
        self.problems.iter().any(|problem| problem.is_error)
    }

    /// Roles that reading will give: those with channels and those the map derives from others.
    pub fn all_roles(&self) -> BTreeSet<Role> {
        let position = self.position.as_ref().map(|_| [Role::PositionNorth, Role::PositionEast, Role::PositionDown]);
        let attitude = self.derived.attitude.as_ref().map(|_| ATTITUDE);
        let velocity = self.derived.velocity.as_ref().map(|_| VELOCITY);
        let derived =
            position.into_iter().flatten().chain(attitude.into_iter().flatten()).chain(velocity.into_iter().flatten());
        self.roles.keys().copied().chain(derived).collect()
    }

    /// Whether position comes from latitude and longitude.
    pub fn derives_position(&self) -> bool {
        self.position.is_some()
    }
}

/// Plans the reading of one recording.
pub fn plan(probe: &Probe, map: &ChannelMap) -> Plan {
    plan_all(std::slice::from_ref(probe), map)
}

/// Plans the reading of all recordings of one flight into one.
///
/// A role that two sources could play is a problem that names both; nothing is replaced silently.
pub fn plan_all(probes: &[Probe], map: &ChannelMap) -> Plan {
    let mut planner = Planner::new(probes, map);
    planner.name_columns();
    planner.set_clocks();
    let sequence = planner.sequence();
    let mut roles = BTreeMap::new();
    for (&role, entry) in &map.roles {
        if let Some(assignment) = planner.assign(role.name(), Some(role.dimension()), entry, &sequence) {
            roles.insert(role, assignment);
        }
    }
    let mut truth = BTreeMap::new();
    for (name, entry) in &map.truth {
        if let Some(assignment) = planner.assign(name, None, entry, &sequence) {
            truth.insert(name.clone(), assignment);
        }
    }
    planner.check_derived(&roles);
    let derived = planner.derive(&roles, &sequence);
    planner.warn_of_unset_clocks();
    planner.question_clocks(&roles);
    Plan {
        roles,
        truth,
        problems: planner.problems,
        probes: planner.probes,
        position: map.derive.position.clone(),
        derived,
        end_to_end_gap_s: map.end_to_end_gap_s,
        sequence,
        time: planner.time,
    }
}

struct Planner<'m> {
    map: &'m ChannelMap,
    probes: Vec<Probe>,
    problems: Vec<Problem>,
    time: BTreeMap<(usize, usize), TimeEntry>,
    /// Why the map's time does not fit a source, by `(probe, source)`, until a role needs it.
    unset_clocks: BTreeMap<(usize, usize), String>,
    /// Sources of which it was said that they have no time.
    timeless: BTreeSet<(usize, usize)>,
}

impl<'m> Planner<'m> {
    fn new(probes: &[Probe], map: &'m ChannelMap) -> Self {
        Self {
            map,
            probes: probes.to_vec(),
            problems: Vec::new(),
            time: BTreeMap::new(),
            unset_clocks: BTreeMap::new(),
            timeless: BTreeSet::new(),
        }
    }
}

impl Planner<'_> {
    fn error(&mut self, text: String) {
        self.problems.push(Problem { is_error: true, text });
    }

    fn warn(&mut self, text: String) {
        self.problems.push(Problem { is_error: false, text });
    }

    /// Renames `M[i]` to `M.name` for every matrix the map names the columns of.
    fn name_columns(&mut self) {
        let mut problems = Vec::new();
        for probe in &mut self.probes {
            for source in &mut probe.sources {
                for (pattern, names) in &self.map.columns {
                    let counts = column_counts(source, pattern);
                    if !pattern.contains('*') {
                        problems.extend(counts.iter().filter(|(_, count)| **count != names.len()).map(
                            |(matrix, count)| {
                                format!(
                                    "{}: matrix '{matrix}' has {count} columns, the map names {}; correct its columns",
                                    probe.path.display(),
                                    names.len()
                                )
                            },
                        ));
                    }
                    for channel in &mut source.channels {
                        let Some((matrix, index)) = channel.column() else { continue };
                        let fits = counts.get(matrix) == Some(&names.len());
                        if let Some(name) = names.get(index).filter(|_| fits) {
                            channel.name = format!("{matrix}.{name}");
                        }
                    }
                    for clock in &mut source.clocks {
                        if let Some(index) = clock.index {
                            clock.channel.clone_from(&source.channels[index].name);
                        }
                    }
                }
            }
        }
        problems.into_iter().for_each(|problem| self.error(problem));
    }

    /// Applies the map's time entries to the sources they match.
    fn set_clocks(&mut self) {
        for (probe_index, probe) in self.probes.iter_mut().enumerate() {
            for (source_index, source) in probe.sources.iter_mut().enumerate() {
                let Some(entry) = self.map.time.iter().find(|entry| matches(&entry.source, &source.name)) else {
                    continue;
                };
                let place = (probe_index, source_index);
                if let Err(problem) = set_clock(source, entry) {
                    self.unset_clocks.insert(place, format!("{}: {problem}", probe.path.display()));
                }
                self.time.insert(place, entry.clone());
            }
            settle_units(&mut probe.sources);
        }
    }

    /// A map for several recorders need not fit the time of a source that plays no role: a warning, not an error.
    fn warn_of_unset_clocks(&mut self) {
        let unset = std::mem::take(&mut self.unset_clocks);
        unset.into_values().for_each(|problem| self.warn(problem));
    }

    /// Says of a source, once for all roles it was to play, that it has no time.
    fn error_of_no_time(&mut self, at: At) {
        let place = (at.probe, at.source);
        if !self.timeless.insert(place) {
            return;
        }
        let (path, source) = (self.probes[at.probe].path.display(), self.source(at));
        let short = || format!("source '{}' has no channel of more than one sample; record it again", source.name);
        let missing = format!("{path}: {}", source.missing_time().unwrap_or_else(short));
        let text = self.unset_clocks.remove(&place).unwrap_or(missing);
        self.error(text);
    }

    /// Sources that will be joined in time or laid end to end, in order.
    fn sequence(&mut self) -> Vec<(usize, usize)> {
        if self.map.end_to_end_gap_s.is_none() && !self.map.join_in_time {
            return Vec::new();
        }
        let mut sequence = Vec::new();
        for (probe_index, probe) in self.probes.iter().enumerate() {
            for (source_index, source) in probe.sources.iter().enumerate() {
                let plays = |entry: &Entry| entry.terms.iter().any(|term| find(source, &term.names).next().is_some());
                if matches(&self.map.source, &source.name) && self.map.roles.values().any(plays) {
                    sequence.push((probe_index, source_index));
                }
            }
        }
        if self.map.join_in_time {
            let clock = |&(probe, source): &(usize, usize)| self.probes[probe].sources[source].clocks.first();
            let start = |place: &(usize, usize)| clock(place).map_or(f64::INFINITY, |clock| clock.start_s);
            sequence.sort_by(|a, b| start(a).total_cmp(&start(b)));
            let overlap = sequence.windows(2).find_map(|pair| {
                let (before, after) = (clock(&pair[0])?, clock(&pair[1])?);
                (before.end_s >= after.start_s).then(|| (pair[0], before.end_s, pair[1], after.start_s))
            });
            if let Some((before, end, after, start)) = overlap {
                let (before, after) = (self.name_source(before), self.name_source(after));
                let fix = "read them as separate recordings, or correct their time in the map";
                self.error(format!("{before} ends at {end} s, after {after} starts at {start} s; {fix}"));
            }
        }
        sequence
    }

    fn name_source(&self, (probe, source): (usize, usize)) -> String {
        format!("{}: source '{}'", self.probes[probe].path.display(), self.probes[probe].sources[source].name)
    }

    /// Finds the channels of one entry, or says why it cannot.
    fn assign(
        &mut self,
        target: &str,
        dimension: Option<Dimension>,
        entry: &Entry,
        sequence: &[(usize, usize)],
    ) -> Option<Assignment> {
        let mut parts: Vec<Vec<(At, f64)>> = Vec::new();
        let found = if sequence.len() > 1 {
            sequence.iter().try_for_each(|&place| self.terms(entry, Some(place)).map(|terms| parts.push(terms)))
        } else {
            self.terms(entry, None).map(|terms| parts.push(terms))
        };
        if let Err((is_missing, problem)) = found {
            let text = format!("{target}: {problem} (map line {})", entry.line);
            self.problems.push(Problem { is_error: !(is_missing && entry.optional), text });
            return None;
        }
        let unit = self.unit(target, dimension, entry, &parts)?;
        for part in &parts {
            self.check_lengths(target, part)?;
        }
        let samples = parts.iter().filter_map(|part| part.first()).map(|&(at, _)| self.channel(at).samples).sum();
        let description = self.describe(&parts[0], parts.len(), |at| self.channel_path(at));
        let channels = self.describe(&parts[0], parts.len(), |at| self.channel_name(at));
        let (factor, offset) = (entry.factor, entry.offset);
        Some(Assignment { target: target.to_owned(), description, channels, unit, samples, factor, offset, parts })
    }

    fn channel(&self, at: At) -> &ChannelInfo {
        &self.probes[at.probe].sources[at.source].channels[at.channel]
    }

    fn source(&self, at: At) -> &Source {
        &self.probes[at.probe].sources[at.source]
    }

    /// `source/channel`.
    fn channel_name(&self, at: At) -> String {
        format!("{}/{}", self.source(at).name, self.channel(at).name)
    }

    /// `file: source/channel`.
    fn channel_path(&self, at: At) -> String {
        format!("{}: {}", self.probes[at.probe].path.display(), self.channel_name(at))
    }

    /// Channels with their weights, each as `shown`.
    fn describe(&self, terms: &[(At, f64)], parts: usize, shown: impl Fn(At) -> String) -> String {
        let term = |&(at, weight): &(At, f64)| match weight {
            1.0 => shown(at),
            _ => format!("{weight} x {}", shown(at)),
        };
        let listed: Vec<String> = terms.iter().map(term).collect();
        let parts = if parts > 1 { format!(" and {} more parts", parts - 1) } else { String::new() };
        listed.join(" + ") + &parts
    }

    /// Every term's channel, within one source if `within` says so. The flag of the error tells a missing channel.
    fn terms(&self, entry: &Entry, within: Option<(usize, usize)>) -> Result<Vec<(At, f64)>, (bool, String)> {
        entry.terms.iter().map(|term| Ok((self.term(term, within)?, term.weight))).collect()
    }

    fn term(&self, term: &Term, within: Option<(usize, usize)>) -> Result<At, (bool, String)> {
        let pattern = term.source.as_ref().unwrap_or(&self.map.source);
        for name in &term.names {
            let mut found = Vec::new();
            for (probe, contents) in self.probes.iter().enumerate() {
                for (source, channels) in contents.sources.iter().enumerate() {
                    let allowed =
                        within.map_or_else(|| matches(pattern, &channels.name), |place| place == (probe, source));
                    if allowed {
                        let channels = find(channels, std::slice::from_ref(name));
                        found.extend(channels.map(|channel| At { probe, source, channel }));
                    }
                }
            }
            match found[..] {
                [] => {}
                [at] => return Ok(at),
                [first, second, ..] => {
                    let (first, second) = (self.channel_path(first), self.channel_path(second));
                    let fix = "name the source in the map";
                    return Err((false, format!("'{name}' could be {first} or {second}; {fix}")));
                }
            }
        }
        let place = match within {
            Some((probe, source)) => format!("source '{}'", self.probes[probe].sources[source].name),
            None if pattern == "*" => self.files(),
            None => format!("source '{pattern}' of {}", self.files()),
        };
        let wanted = term.names.join("' or '");
        Err((true, format!("no channel '{wanted}' in {place}{}; add its name to the aliases", self.near(&term.names))))
    }

    fn files(&self) -> String {
        self.probes.iter().map(|probe| probe.path.display().to_string()).collect::<Vec<_>>().join(", ")
    }

    /// A hint at a channel whose name differs only in capitals or in what precedes it.
    fn near(&self, names: &[String]) -> String {
        let last = |name: &str| name.rsplit(['.', '/']).next().unwrap_or(name).to_lowercase();
        let mut channels = self.probes.iter().flat_map(|probe| &probe.sources).flat_map(|source| &source.channels);
        let near = channels.find(|channel| names.iter().any(|name| last(name) == last(&channel.name)));
        near.map(|channel| format!(" (there is '{}')", channel.name)).unwrap_or_default()
    }

    /// The unit of the raw value: the map's, or the recorded one, of the right dimension.
    fn unit(
        &mut self,
        target: &str,
        wanted: Option<Dimension>,
        entry: &Entry,
        parts: &[Vec<(At, f64)>],
    ) -> Option<Unit> {
        let &(at, _) = parts.first()?.first()?;
        let recorded = self.channel(at).unit.clone();
        let parsed = recorded.as_deref().map(Unit::parse);
        let place = self.channel_path(at);
        if let Some(unit) = entry.unit {
            if let Some(Ok(other)) = parsed.filter(|parsed| parsed.as_ref().is_ok_and(|other| *other != unit)) {
                self.warn(format!(
                    "{target}: {place} was recorded in {}, the map's {} is used",
                    other.symbol, unit.symbol
                ));
            }
            return Some(unit);
        }
        let fix = format!("give 'unit' in the map (line {})", entry.line);
        match parsed {
            None => self.error(format!("{target}: {place} has no recorded unit; {fix}")),
            Some(Err(_)) => {
                let name = recorded.unwrap_or_default();
                self.error(format!("{target}: {place} has the unknown unit '{name}'; {fix}"));
            }
            Some(Ok(unit)) => match wanted.filter(|wanted| *wanted != unit.dimension) {
                None => return Some(unit),
                Some(wanted) => {
                    let si = wanted.si_symbol();
                    self.error(format!(
                        "{target}: {place} is in {}, which does not convert to {si}; {fix}",
                        unit.symbol
                    ));
                }
            },
        }
        None
    }

    /// Every channel has a clock, and those of one sum the same length.
    fn check_lengths(&mut self, target: &str, terms: &[(At, f64)]) -> Option<()> {
        let &(first, _) = terms.first()?;
        for &(at, _) in terms {
            let (channel, source) = (self.channel(at), self.source(at));
            if source.clocks.is_empty() {
                self.error_of_no_time(at);
                return None;
            }
            if channel.clock.is_none() {
                let clocks: Vec<String> =
                    source.clocks.iter().map(|clock| format!("'{}' has {}", clock.channel, clock.samples)).collect();
                let text = format!(
                    "{target}: {} has {} samples, {}; state its time channel or the sample rate in the map",
                    self.channel_path(at),
                    channel.samples,
                    clocks.join(", ")
                );
                self.error(text);
                return None;
            }
            let same_clock =
                (at.probe, at.source, channel.clock) == (first.probe, first.source, self.channel(first).clock);
            if !same_clock {
                let text = format!(
                    "{target}: {} and {} have different clocks; sum channels of one",
                    self.channel_path(first),
                    self.channel_path(at)
                );
                self.error(text);
                return None;
            }
        }
        Some(())
    }

    /// Clocks of the parts of an assignment: probe, source, clock.
    fn clocks(&self, assignment: &Assignment) -> Vec<(usize, usize, Option<usize>)> {
        let first = assignment.parts.iter().filter_map(|terms| terms.first());
        first.map(|&(at, _)| (at.probe, at.source, self.channel(at).clock)).collect()
    }

    /// Asks about the time of what plays a role, once for each clock.
    fn question_clocks(&mut self, roles: &BTreeMap<Role, Assignment>) {
        let mut asked = BTreeSet::new();
        for (role, assignment) in roles {
            for (probe, source, clock) in self.clocks(assignment) {
                let Some(clock) = clock else { continue };
                let (path, source) = (self.probes[probe].path.display(), &self.probes[probe].sources[source]);
                let clock = &source.clocks[clock];
                // What is no motion may come as slowly as it likes.
                let odd = || contradiction(source, clock).filter(|_| *role <= Role::Rudder);
                asked.extend(clock.question.clone().or_else(odd).map(|question| format!("{path}: time {question}")));
            }
        }
        asked.into_iter().for_each(|question| self.warn(question));
    }

    fn check_derived(&mut self, roles: &BTreeMap<Role, Assignment>) {
        let Some(derive) = &self.map.derive.position else { return };
        let wanted = [Some(Role::Latitude), Some(Role::Longitude), derive.altitude];
        for role in wanted.into_iter().flatten().filter(|role| !roles.contains_key(role)) {
            self.error(format!("the derived position needs the role {}; map it", role.name()));
        }
        let clock = |role: &Role| roles.get(role).map(|assignment| self.clocks(assignment));
        let first = clock(&Role::Latitude);
        let wanted = [Some(Role::Longitude), derive.altitude];
        let others: Vec<Role> =
            wanted.into_iter().flatten().filter(|role| clock(role).is_some_and(|other| Some(other) != first)).collect();
        for role in others {
            self.error(format!(
                "derived position: {} has another clock than latitude; map channels of one clock",
                role.name()
            ));
        }
        self.check_mapped_once(roles, &[Role::PositionNorth, Role::PositionEast]);
    }

    fn check_mapped_once(&mut self, roles: &BTreeMap<Role, Assignment>, derived: &[Role]) {
        for role in derived.iter().filter(|role| roles.contains_key(role)) {
            self.error(format!("{} is mapped and derived; remove one of the two from the map", role.name()));
        }
    }

    /// Finds the channels that attitude and velocity are derived from.
    fn derive(&mut self, roles: &BTreeMap<Role, Assignment>, sequence: &[(usize, usize)]) -> DerivedChannels {
        let derive = &self.map.derive;
        let mut derived = DerivedChannels::default();
        if let Some((entries, axes)) = &derive.attitude {
            self.check_mapped_once(roles, &ATTITUDE);
            let targets = ["w", "x", "y", "z"].map(|part| format!("[derive.attitude] {part}"));
            let parts = self.assign_together(&targets, entries, Dimension::Dimensionless, sequence);
            derived.attitude = parts.map(|parts| (parts, *axes));
        }
        if let Some(entries) = &derive.velocity {
            self.check_mapped_once(roles, &VELOCITY);
            let targets = ["ground_speed", "track"].map(|part| format!("[derive.velocity] {part}"));
            let speed = self.assign_together(&targets[..1], &entries[..1], Dimension::Speed, sequence);
            let track = self.assign_together(&targets[1..], &entries[1..], Dimension::Angle, sequence);
            let both: Option<Vec<Assignment>> = speed.zip(track).map(|(speed, track)| [speed, track].concat());
            derived.velocity = both.filter(|both| self.check_one_clock(both)).and_then(|both| both.try_into().ok());
        }
        derived
    }

    /// Assigns channels that are samples of one clock; `None` where one is missing.
    fn assign_together(
        &mut self,
        targets: &[String],
        entries: &[Entry],
        dimension: Dimension,
        sequence: &[(usize, usize)],
    ) -> Option<Vec<Assignment>> {
        let assigned =
            targets.iter().zip(entries).map(|(target, entry)| self.assign(target, Some(dimension), entry, sequence));
        let assigned: Vec<Assignment> = assigned.collect::<Option<_>>()?;
        self.check_one_clock(&assigned).then_some(assigned)
    }

    fn check_one_clock(&mut self, assigned: &[Assignment]) -> bool {
        let other = assigned.iter().find(|other| self.clocks(other) != self.clocks(&assigned[0]));
        let problem = other.map(|other| {
            format!("{}: its clock is not that of {}; map channels of one clock", other.target, assigned[0].target)
        });
        let is_one = problem.is_none();
        problem.into_iter().for_each(|problem| self.error(problem));
        is_one
    }
}
