//! A channel map made by hand: one row per role, written in the form every map has.

use toml::{Table, Value};

use crate::load::contents::{ChannelInfo, Probe};
use crate::load::error::LoadError;
use crate::load::maps::attitude::QuaternionAxes;
use crate::load::maps::map::{FORMAT, VERSION};
use crate::load::names::stated_unit::{is_count, stated_unit};
use crate::quantity::{Role, Unit};

/// A channel by the names of its source and its own.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord)]
#[expect(missing_docs, reason = "names say it")]
pub struct ChannelName {
    pub source: String,
    pub channel: String,
}

impl ChannelName {
    /// The channel called so, where one of `probes` has it.
    pub fn find<'p>(&self, probes: &'p [Probe]) -> Option<&'p ChannelInfo> {
        let mut sources = probes.iter().flat_map(|probe| &probe.sources).filter(|source| source.name == self.source);
        sources.find_map(|source| source.channels.iter().find(|channel| channel.name == self.channel))
    }
}

/// How one role is made of one channel: `SI value = sign * scale * to_si(raw + offset)`.
#[derive(Clone, Debug, PartialEq)]
pub struct ManualChannel {
    /// Its channel.
    pub from: ChannelName,
    /// Unit of the channel; as recorded where none is given.
    pub unit: Option<Unit>,
    /// Its sign is turned.
    pub turned: bool,
    /// Factor.
    pub scale: f64,
    /// Added to the raw value.
    pub offset: f64,
    /// How it was found.
    pub by: By,
    /// How its name fits the role, where that decided.
    pub fit: Option<NameFit>,
    /// Share of the likelihood of all channels that were compared, where values alone decided.
    pub share: Option<f64>,
    /// The recorder's documentation, or what values of its size must be, says its unit.
    pub is_unit_known: bool,
    /// Nothing says its sign.
    pub asks_sign: bool,
    /// The relation to other channels that it was found by.
    pub evidence: Option<String>,
    /// The channel of the surface on the other side: what is read is half the sum of both.
    pub other_side: Option<OtherSide>,
}

/// The channel of the surface on the other side, of the same source and unit.
#[derive(Clone, Debug, PartialEq)]
pub struct OtherSide {
    /// Its name.
    pub channel: String,
    /// -1 where the two are recorded against each other: then half their difference is read.
    pub sign: f64,
}

/// How the channel of a role was found.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum By {
    /// Named by the user.
    #[default]
    Hand,
    /// A file of names that the user gives.
    File,
    /// The recorder is known.
    Recorder,
    /// The recorder is known by the order of the columns, which have no names.
    Layout,
    /// Words of its name.
    Name,
    /// Words of its name and the channels of the other axes.
    Axes,
    /// What another channel says it is.
    Physics,
}

impl By {
    crate::variant_texts! {
        /// In words.
        pub description:
            Hand "by its name", File "by the names file", Recorder "by its recorder",
            Layout "by the order of the columns", Name "by its name", Axes "by its name and axes",
            Physics "by comparison with other channels",
    }
}

/// How a channel's name fits a role, the best first.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum NameFit {
    /// The whole name, in the words of recorders.
    Whole,
    /// The whole name in German or French words.
    Foreign,
    /// The name without words such as `measured`.
    Essence,
    /// The last part of a path.
    Leaf,
    /// It ends on the name.
    End,
    /// It begins with the name, and a place or sensor follows.
    Begin,
    /// It ends on German or French words.
    ForeignEnd,
}

impl NameFit {
    /// In the order in which roles are given: names that are a role's own first, so that `z` of one recorder does not take the `az` of another.
    pub(crate) const ALL: [Self; 7] =
        [Self::Whole, Self::Foreign, Self::Essence, Self::Leaf, Self::End, Self::Begin, Self::ForeignEnd];

    /// In words.
    pub fn description(self) -> &'static str {
        match self {
            Self::Whole | Self::Foreign => "whole name",
            Self::Essence => "name without qualifiers",
            Self::Leaf => "last part of the name",
            Self::End | Self::ForeignEnd => "end of the name",
            Self::Begin => "start of the name",
        }
    }
}

/// A channel that could play a role, and why another is preferred.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct RunnerUp {
    /// The channel.
    pub from: ChannelName,
    /// Why another is preferred.
    pub reason: String,
}

impl ManualChannel {
    /// A channel as it is, in `unit`.
    pub fn new(from: ChannelName, unit: Option<Unit>) -> Self {
        let (by, is_unit_known, asks_sign) = (By::Hand, false, false);
        let (fit, share, evidence, other_side) = (None, None, None, None);
        let (turned, scale, offset) = (false, 1.0, 0.0);
        Self { from, unit, turned, scale, offset, by, fit, share, is_unit_known, asks_sign, evidence, other_side }
    }

    /// Whether its channel states no unit, neither beside its name nor at the end of it, or says no more than that it has none.
    pub fn is_unit_open(&self, probes: &[Probe]) -> bool {
        !self.is_unit_known && self.from.find(probes).is_some_and(|channel| stated_unit(channel).is_none_or(is_count))
    }

    /// The channel of the other side.
    fn other_from(&self) -> Option<ChannelName> {
        let channel = self.other_side.as_ref()?.channel.clone();
        Some(ChannelName { source: self.from.source.clone(), channel })
    }

    /// Its channel or channels as a user reads them: `'elevator'`, `half of 'right aileron' - 'left aileron'`.
    pub fn channels(&self) -> String {
        match &self.other_side {
            Some(other) => {
                let sign = if other.sign < 0.0 { '-' } else { '+' };
                format!("half of '{}' {sign} '{}'", self.from.channel, other.channel)
            }
            None => format!("'{}'", self.from.channel),
        }
    }

    /// What the row will read; `None` where the channel is unknown or holds nothing finite, or has no unit.
    pub fn values(&self, probes: &[Probe]) -> Option<RowValues> {
        let channel = self.from.find(probes)?;
        let unit = self.unit.or_else(|| Unit::parse(channel.unit.as_deref()?).ok())?;
        let sign = if self.turned { -1.0 } else { 1.0 };
        let read = |raw: f64| unit.from_si(sign * self.scale * unit.to_si(raw + self.offset));
        let other = self.other_side.as_ref().and_then(|other| Some((other.sign, self.other_from()?.find(probes)?)));
        let sum = |(k, value): (usize, &f64)| match other {
            Some((sign, other)) => 0.5 * (value + sign * other.values().get(k).copied().unwrap_or(f64::NAN)),
            None => *value,
        };
        let mut finite = channel.values().iter().enumerate().map(sum).filter(|value| value.is_finite()).map(read);
        let first = finite.next()?;
        let (least, greatest) =
            finite.fold((first, first), |(least, greatest), value| (least.min(value), greatest.max(value)));
        Some(RowValues { unit, first, least, greatest })
    }
}

/// Values of a row with its sign, scale and offset, in the unit of its channel.
#[derive(Clone, Copy, Debug, PartialEq)]
#[expect(missing_docs, reason = "names say it")]
pub struct RowValues {
    pub unit: Unit,
    /// First finite value.
    pub first: f64,
    pub least: f64,
    pub greatest: f64,
}

/// Where the time of a source comes from that has no time vector of a known name.
#[derive(Clone, Debug, PartialEq)]
pub enum ManualTime {
    /// One of its channels, in a unit of time.
    Channel(String, Unit),
    /// Evenly spaced at this rate, Hz.
    Rate(f64),
    /// Evenly spaced from a time on, s, at a rate, Hz: its stamps are coarser than its samples.
    Even {
        /// Time of the first sample, s.
        start_s: f64,
        /// Rate, Hz.
        rate_hz: f64,
    },
}

/// A map in the making.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct ManualChannelMap {
    /// Name of the map.
    pub name: String,
    /// Time of sources, by name; what the file itself gives for the others.
    pub time: Vec<(String, ManualTime)>,
    /// Roles with their channels, in the order of [`Role::ALL`].
    pub rows: Vec<(Role, ManualChannel)>,
    /// Position comes from latitude and longitude, and, where position down has no channel, from the altitude of satellite navigation, or else
    /// the pressure altitude.
    pub position_from_fixes: bool,
    /// Attitude comes from a quaternion.
    pub attitude: Option<ManualQuaternion>,
    /// Velocity north and east come from ground speed and track.
    pub velocity: Option<[ManualChannel; 2]>,
    /// Recorders that are known.
    pub recorders: Vec<String>,
    /// What flew, where the recorder says it.
    pub kind: Option<String>,
    /// Channels that a word of their name or their recorder leaves out, and why.
    pub left_out_by_name: Vec<(ChannelName, String)>,
    /// Channels that their values leave out although their names fit, and why.
    pub left_out: Vec<(ChannelName, String)>,
    /// Channels that would play a role if the one chosen did not.
    pub runners_up: Vec<(Role, RunnerUp)>,
}

/// The parts `w, x, y, z` of a quaternion in a source, and the axes it turns into each other.
#[derive(Clone, Debug, PartialEq)]
#[expect(missing_docs, reason = "names say it")]
pub struct ManualQuaternion {
    pub source: String,
    /// Channels.
    pub parts: [String; 4],
    pub axes: QuaternionAxes,
}

impl ManualChannelMap {
    /// Channels without a role although their names or values fit one, and why.
    pub fn all_left_out(&self) -> impl Iterator<Item = &(ChannelName, String)> {
        self.left_out_by_name.iter().chain(&self.left_out)
    }

    /// What attitude, velocity and the time of coarse stamps are derived from, a line each.
    pub fn derivations(&self) -> Vec<String> {
        let attitude = self.attitude.as_ref().map(|attitude| {
            let (parts, axes) = (attitude.parts.join("', '"), attitude.axes.description());
            format!("phi, theta and psi: the quaternion '{parts}' of {}, {axes}", attitude.source)
        });
        let velocity = self.velocity.as_ref().map(|[speed, track]| {
            format!(
                "v_north and v_east: '{}' along '{}' of {}",
                speed.from.channel, track.from.channel, speed.from.source
            )
        });
        let times = self.time.iter().filter_map(|(source, time)| match time {
            ManualTime::Even { start_s, rate_hz } => Some(format!(
                "time of {source}: {rate_hz} Hz from {start_s:.3} s, its stamps are coarser than the samples"
            )),
            _ => None,
        });
        times.chain(attitude).chain(velocity).collect()
    }

    /// The channel that would play a role if the one chosen did not.
    pub fn runner_up(&self, role: Role) -> Option<&RunnerUp> {
        let chosen = self.row(role)?;
        let found = self.runners_up.iter().find(|(other, _)| *other == role);
        found.map(|(_, runner_up)| runner_up).filter(|runner_up| runner_up.from != chosen.from)
    }

    /// The row of `role`.
    pub fn row(&self, role: Role) -> Option<&ManualChannel> {
        self.rows.iter().find(|(other, _)| *other == role).map(|(_, row)| row)
    }

    /// Gives `role` a row, or takes it away.
    pub fn set(&mut self, role: Role, row: Option<ManualChannel>) {
        self.rows.retain(|(other, _)| *other != role);
        if let Some(row) = row {
            self.rows.push((role, row));
            self.rows.sort_by_key(|(role, _)| *role);
        }
    }

    /// Role whose altitude a position made of fixes takes; none where position down has a channel of its own.
    fn fix_altitude(&self) -> Option<Role> {
        let is_open = self.row(Role::PositionDown).is_none();
        [Role::GpsAltitude, Role::Altitude].into_iter().find(|role| is_open && self.row(*role).is_some())
    }

    /// The map as the text of a channel map file, which [`crate::load::ChannelMap::parse`] reads.
    ///
    /// # Errors
    /// [`LoadError::Map`] when it cannot be written as TOML.
    pub fn text(&self) -> Result<String, LoadError> {
        let mut map = Table::new();
        map.insert("format".to_owned(), FORMAT.into());
        map.insert("version".to_owned(), i64::from(VERSION).into());
        map.insert("name".to_owned(), self.name.clone().into());
        let time: Vec<Value> = self.time.iter().map(|(source, time)| Value::Table(time_table(source, time))).collect();
        if !time.is_empty() {
            map.insert("time".to_owned(), Value::Array(time));
        }
        let roles: Table =
            self.rows.iter().map(|(role, row)| (role.name().to_owned(), Value::Table(row_table(row)))).collect();
        map.insert("roles".to_owned(), Value::Table(roles));
        let mut derive = Table::new();
        if self.position_from_fixes {
            let altitude = self.fix_altitude().map(|role| ("altitude".to_owned(), role.name().into()));
            derive.insert("position".to_owned(), Table::from_iter(altitude).into());
        }
        if let Some(attitude) = &self.attitude {
            derive.insert("attitude".to_owned(), attitude_table(attitude).into());
        }
        if let Some(velocity) = &self.velocity {
            let parts = ["ground_speed", "track"].into_iter().zip(velocity);
            let parts = parts.map(|(part, row)| (part.to_owned(), row_table(row).into()));
            derive.insert("velocity".to_owned(), Table::from_iter(parts).into());
        }
        if !derive.is_empty() {
            map.insert("derive".to_owned(), derive.into());
        }
        toml::to_string(&map).map_err(|error| LoadError::Map { path: None, line: 1, what: error.to_string() })
    }
}

fn time_table(source: &str, time: &ManualTime) -> Table {
    let mut table = Table::from_iter([("source".to_owned(), Value::from(source))]);
    match time {
        ManualTime::Channel(channel, unit) => {
            table.insert("channel".to_owned(), channel.as_str().into());
            table.insert("unit".to_owned(), unit.symbol.into());
        }
        ManualTime::Rate(rate_hz) => {
            table.insert("sample_rate".to_owned(), (*rate_hz).into());
        }
        ManualTime::Even { start_s, rate_hz } => {
            table.insert("start_time".to_owned(), (*start_s).into());
            table.insert("sample_rate".to_owned(), (*rate_hz).into());
        }
    }
    table
}

fn attitude_table(attitude: &ManualQuaternion) -> Table {
    let mut table = Table::new();
    if !attitude.source.is_empty() {
        table.insert("source".to_owned(), attitude.source.as_str().into());
    }
    table.insert("quaternion".to_owned(), attitude.parts.to_vec().into());
    table.insert("axes".to_owned(), attitude.axes.name().into());
    table
}

fn row_table(row: &ManualChannel) -> Table {
    let mut table = Table::new();
    if !row.from.source.is_empty() {
        table.insert("source".to_owned(), row.from.source.as_str().into());
    }
    match &row.other_side {
        Some(other) => {
            let terms = [(row.from.channel.as_str(), 0.5), (other.channel.as_str(), 0.5 * other.sign)];
            table.insert("sum".to_owned(), Value::Array(terms.into_iter().map(term_table).collect()));
        }
        None => {
            table.insert("channel".to_owned(), row.from.channel.as_str().into());
        }
    }
    if let Some(unit) = row.unit {
        table.insert("unit".to_owned(), unit.symbol.into());
    }
    if row.turned {
        table.insert("sign".to_owned(), (-1.0).into());
    }
    if row.scale != 1.0 {
        table.insert("scale".to_owned(), row.scale.into());
    }
    if row.offset != 0.0 {
        table.insert("offset".to_owned(), row.offset.into());
    }
    table
}

fn term_table((channel, weight): (&str, f64)) -> Value {
    Value::Table(Table::from_iter([("channel".to_owned(), channel.into()), ("weight".to_owned(), weight.into())]))
}
