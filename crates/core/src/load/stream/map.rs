//! A channel map applied row by row.

use std::collections::BTreeMap;
use std::path::PathBuf;
use std::sync::Arc;

use crate::load::clocks::find_clocks::find_clocks;
use crate::load::clocks::time_names::is_time_name;
use crate::load::clocks::time_unit::settle_units;
use crate::load::contents::{ChannelInfo, Probe, Source};
use crate::load::error::Problem;
use crate::load::format::Format;
use crate::load::maps::attitude::QuaternionAxes;
use crate::load::maps::derive::{metres_per_radian, wrapped};
use crate::load::maps::map::{ATTITUDE, ChannelMap, VELOCITY, matches};
use crate::load::maps::plan::{Assignment, Plan, plan_all};
use crate::quantity::{Role, Unit};

use crate::load::row::{StreamChannel, StreamRow};

/// Rows of a source that tell its time, and of one whose time the map states.
const HEAD_ROWS: usize = 8;
const STATED_ROWS: usize = 2;
/// Rows after which a source takes part though few of its stamps differ.
const MOST_HEAD_ROWS: usize = 64;

/// A value of a role.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RoleSample {
    /// Role.
    pub role: Role,
    /// Time on the clock of its source, s.
    pub time_s: f64,
    /// Value, SI; not a number where the source gave none.
    pub value: f64,
}

/// Applies a channel map to rows as they come, by the plan that a whole recording gets. A source takes part from its eighth row on, with
/// those before: these tell its time. Where the map states the time two rows are enough.
#[derive(Debug)]
pub struct StreamMap {
    map: ChannelMap,
    sources: Vec<StreamSource>,
    /// What the map cannot find, as long as it cannot.
    pub problems: Vec<Problem>,
    /// Sources that came after others and have channels of the same roles: the map cannot tell them apart.
    pub left_out: Vec<Arc<str>>,
    /// First fix, from which positions count: latitude, longitude, altitude.
    origin: Option<[f64; 3]>,
}

/// A source so far.
#[derive(Debug)]
struct StreamSource {
    name: Arc<str>,
    channels: Arc<[StreamChannel]>,
    head: Vec<Vec<f64>>,
    is_settled: bool,
    rows: u64,
    makers: Vec<Maker>,
    clock: Option<RowClock>,
}

/// Time of a row.
#[derive(Clone, Copy, Debug)]
enum RowClock {
    Channel(usize, Unit),
    Even { start_s: f64, rate_hz: f64 },
}

/// A role's value from a row: `factor * to_si(sum of weight * raw + offset)`.
#[derive(Clone, Debug)]
struct Linear {
    terms: Vec<(usize, f64)>,
    offset: f64,
    factor: f64,
    unit: Unit,
}

impl Linear {
    fn value(&self, values: &[f64]) -> f64 {
        let term_value = |&(channel, weight): &(usize, f64)| weight * values.get(channel).copied().unwrap_or(f64::NAN);
        self.factor * self.unit.to_si(self.terms.iter().map(term_value).sum::<f64>() + self.offset)
    }
}

/// What a row gives.
#[derive(Clone, Debug)]
enum Maker {
    Role(Role, Linear),
    Position { fix: [Linear; 2], altitude: Option<Linear> },
    Attitude(Vec<Linear>, QuaternionAxes),
    Velocity([Linear; 2]),
}

impl StreamMap {
    /// A map before the first row.
    pub fn new(map: ChannelMap) -> Self {
        Self { map, sources: Vec::new(), problems: Vec::new(), left_out: Vec::new(), origin: None }
    }

    /// Roles that are made of what came so far.
    pub fn roles(&self) -> Vec<Role> {
        let makers = self.sources.iter().flat_map(|source| &source.makers);
        makers
            .flat_map(|maker| match maker {
                Maker::Role(role, _) => vec![*role],
                Maker::Position { altitude, .. } => {
                    let down = altitude.as_ref().map(|_| Role::PositionDown);
                    [Role::PositionNorth, Role::PositionEast].into_iter().chain(down).collect()
                }
                Maker::Attitude(..) => ATTITUDE.to_vec(),
                Maker::Velocity(_) => VELOCITY.to_vec(),
            })
            .collect()
    }

    /// Takes in a row and adds what it gives.
    pub fn take(&mut self, row: &StreamRow, samples: &mut Vec<RoleSample>) {
        for row in self.ready(row.clone()) {
            if let Some(time_s) = self.time_s(&row) {
                self.convert(&row, time_s, samples);
            }
        }
    }

    /// Takes in a row and gives those that can be converted now: none while the clock of the source is looked for, then all of its head.
    pub fn ready(&mut self, row: StreamRow) -> Vec<StreamRow> {
        let at = self.source_of(&row);
        let is_stated = self.map.time.iter().any(|entry| matches(&entry.source, &row.source));
        let head_rows = if is_stated { STATED_ROWS } else { HEAD_ROWS };
        let source = &mut self.sources[at];
        let has_grown = row.channels.len() > source.channels.len();
        if has_grown {
            source.channels = Arc::clone(&row.channels);
            source.head.iter_mut().for_each(|values| values.resize(row.channels.len(), f64::NAN));
        }
        if source.is_settled && !has_grown {
            return vec![row];
        }
        source.head.push(row.values.clone());
        if source.is_settled {
            self.settle();
            return vec![row];
        }
        if source.ordered_head().len() < head_rows && source.head.len() < MOST_HEAD_ROWS {
            return Vec::new();
        }
        self.begin(at);
        self.head_of(at)
    }

    /// Rows of the sources whose clock is still looked for.
    pub fn waiting(&self) -> Vec<StreamRow> {
        let waits = |at: &usize| !self.sources[*at].is_settled;
        (0..self.sources.len()).filter(waits).flat_map(|at| self.head_of(at)).collect()
    }

    fn head_of(&self, at: usize) -> Vec<StreamRow> {
        let StreamSource { name, channels, head, .. } = &self.sources[at];
        let row = |values: &Vec<f64>| StreamRow {
            source: Arc::clone(name),
            channels: Arc::clone(channels),
            values: values.clone(),
        };
        head.iter().map(row).collect()
    }

    /// Lets a source take part, unless its channels make roles of others ambiguous.
    fn begin(&mut self, at: usize) {
        let before = self.roles();
        self.sources[at].is_settled = true;
        self.settle();
        let after = self.roles();
        if before.iter().any(|role| !after.contains(role)) {
            self.left_out.push(Arc::clone(&self.sources[at].name));
            self.settle();
        }
    }

    /// Time of a row on the clock of its source, s, which is not a number where its stamp is missing; none where the source has no clock.
    pub fn time_s(&self, row: &StreamRow) -> Option<f64> {
        let source = self.sources.iter().find(|source| source.name == row.source)?;
        match source.clock? {
            RowClock::Channel(channel, unit) => Some(unit.to_si(row.values.get(channel).copied().unwrap_or(f64::NAN))),
            RowClock::Even { start_s, rate_hz } => Some(start_s + source.rows as f64 / rate_hz),
        }
    }

    fn source_of(&mut self, row: &StreamRow) -> usize {
        if let Some(at) = self.sources.iter().position(|source| source.name == row.source) {
            return at;
        }
        let (name, channels) = (Arc::clone(&row.source), Arc::clone(&row.channels));
        let (head, makers) = (Vec::new(), Vec::new());
        self.sources.push(StreamSource { name, channels, head, is_settled: false, rows: 0, makers, clock: None });
        self.sources.len() - 1
    }

    /// Plans anew with the heads of all sources that are settled.
    fn settle(&mut self) {
        let takes_part = |source: &StreamSource| source.is_settled && !self.left_out.contains(&source.name);
        let settled: Vec<usize> = (0..self.sources.len()).filter(|at| takes_part(&self.sources[*at])).collect();
        let mut sources: Vec<Source> = settled.iter().map(|at| self.sources[*at].head_as_source()).collect();
        settle_units(&mut sources);
        let (path, warnings) = (PathBuf::from("stream"), Vec::new());
        let plan = plan_all(&[Probe { path, format: Format::DelimitedText, sources, warnings }], &self.map);
        self.problems.clone_from(&plan.problems);
        for (index, &at) in settled.iter().enumerate() {
            let (makers, clock) = makers(&plan, index);
            (self.sources[at].makers, self.sources[at].clock) = (makers, clock);
        }
        for source in self.sources.iter_mut().filter(|source| self.left_out.contains(&source.name)) {
            (source.makers, source.clock) = (Vec::new(), None);
        }
    }

    /// Adds what a row gives at this time, s.
    pub fn convert(&mut self, row: &StreamRow, time_s: f64, samples: &mut Vec<RoleSample>) {
        let Some(source) = self.sources.iter_mut().find(|source| source.name == row.source) else { return };
        source.rows += 1;
        if !time_s.is_finite() {
            return;
        }
        let values = &row.values;
        let mut add = |role, value| samples.push(RoleSample { role, time_s, value });
        for maker in &source.makers {
            match maker {
                Maker::Role(role, linear) => add(*role, linear.value(values)),
                Maker::Velocity([speed, track]) => {
                    let (speed, track) = (speed.value(values), track.value(values));
                    add(VELOCITY[0], speed * track.cos());
                    add(VELOCITY[1], speed * track.sin());
                }
                Maker::Attitude(parts, axes) => {
                    if let [w, x, y, z] = &parts[..] {
                        let angles = axes.euler_rad([w, x, y, z].map(|part| part.value(values)));
                        ATTITUDE.into_iter().zip(angles).for_each(|(role, angle)| add(role, angle));
                    }
                }
                Maker::Position { fix: [latitude, longitude], altitude } => {
                    let (lat, lon) = (latitude.value(values), longitude.value(values));
                    let height = altitude.as_ref().map_or(0.0, |altitude| altitude.value(values));
                    if !(lat.is_finite() && lon.is_finite() && height.is_finite()) {
                        continue;
                    }
                    let [lat0, lon0, h0] = *self.origin.get_or_insert([lat, lon, height]);
                    let (north, east) = metres_per_radian(lat0, h0);
                    add(Role::PositionNorth, north * (lat - lat0));
                    add(Role::PositionEast, east * wrapped(lon - lon0));
                    if altitude.is_some() {
                        add(Role::PositionDown, h0 - height);
                    }
                }
            }
        }
    }
}

impl StreamSource {
    /// The first rows in the order of their stamps, each stamp once.
    fn ordered_head(&self) -> Vec<&Vec<f64>> {
        let mut head: Vec<&Vec<f64>> = self.head.iter().collect();
        if let Some(stamp) = self.channels.iter().position(|channel| is_time_name(&channel.name)) {
            let stamp_of = |row: &[f64]| row.get(stamp).copied().unwrap_or(f64::NAN);
            head.sort_by(|a, b| stamp_of(a).total_cmp(&stamp_of(b)));
            head.dedup_by(|later, earlier| stamp_of(later) == stamp_of(earlier));
        }
        head
    }

    /// The rows that show its time, as a source of a recording: in the order of their stamps, each once, whatever order they came in.
    fn head_as_source(&self) -> Source {
        let mut source = Source::new(&*self.name);
        let head = self.ordered_head();
        for (index, channel) in self.channels.iter().enumerate() {
            let values = head.iter().map(|row| row.get(index).copied().unwrap_or(f64::NAN)).collect();
            source.channels.push(ChannelInfo::new(channel.name.clone(), channel.unit.clone(), values));
        }
        find_clocks(&mut source, |_, _| {});
        source
    }
}

/// What the rows of the source at `index` of a plan give, and its clock.
fn makers(plan: &Plan, index: usize) -> (Vec<Maker>, Option<RowClock>) {
    let roles: BTreeMap<Role, Linear> =
        plan.roles.iter().filter_map(|(role, assignment)| Some((*role, form_linear(assignment, index)?))).collect();
    let mut makers = Vec::new();
    if let (Some(position), Some(lat), Some(lon)) =
        (&plan.position, roles.get(&Role::Latitude), roles.get(&Role::Longitude))
    {
        let altitude = position.altitude.and_then(|role| roles.get(&role).cloned());
        makers.push(Maker::Position { fix: [lat.clone(), lon.clone()], altitude });
    }
    if let Some((parts, axes)) = &plan.derived.attitude
        && let Some(parts) = parts.iter().map(|part| form_linear(part, index)).collect::<Option<Vec<_>>>()
    {
        makers.push(Maker::Attitude(parts, *axes));
    }
    if let Some([speed, track]) = &plan.derived.velocity
        && let (Some(speed), Some(track)) = (form_linear(speed, index), form_linear(track, index))
    {
        makers.push(Maker::Velocity([speed, track]));
    }
    makers.extend(roles.into_iter().map(|(role, linear)| Maker::Role(role, linear)));
    let source = plan.probes.first().and_then(|probe| probe.sources.get(index));
    let clock = source.and_then(|source| source.clocks.first()).map(|clock| match clock.index {
        Some(channel) => RowClock::Channel(channel, clock.unit),
        None => RowClock::Even { start_s: clock.start_s, rate_hz: clock.rate_hz },
    });
    (makers, clock)
}

fn form_linear(assignment: &Assignment, index: usize) -> Option<Linear> {
    let terms = assignment.parts.first()?;
    let own = terms.iter().all(|(at, _)| at.source == index);
    let terms = terms.iter().map(|(at, weight)| (at.channel, *weight)).collect();
    let Assignment { offset, factor, unit, .. } = *assignment;
    own.then_some(Linear { terms, offset, factor, unit })
}
