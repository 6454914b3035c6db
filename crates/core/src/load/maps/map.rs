//! Channel maps: which recorded channel plays which role, in which unit and with which sign.

use std::collections::BTreeMap;
use std::path::Path;

use serde::Deserialize;
use toml::Spanned;

use crate::load::clocks::utc;
use crate::load::error::LoadError;
use crate::load::maps::attitude::QuaternionAxes;
use crate::load::maps::mixing::{MixingTable, kinds, shares};
use crate::quantity::{Dimension, Role, Unit};
use crate::schema::{Refused, schema_of};

/// First line of every channel map.
pub(crate) const FORMAT: &str = "doublet channel map";
/// Version of the form this reads.
pub(crate) const VERSION: u32 = 1;

/// Which recorded channel plays which role.
///
/// `SI value = sign * scale * to_si(raw + offset)`, with `raw` one channel or a weighted sum of several. Patterns for sources,
/// channels and matrices take `*` for any run of characters.
#[derive(Clone, Debug, PartialEq)]
pub struct ChannelMap {
    /// Name shown in lists.
    pub name: String,
    /// One line on the recordings it is for, and where they depart from the conventions.
    pub description: String,
    /// Sources it draws from, as a pattern.
    pub source: String,
    /// Matching sources are consecutive cuts of one flight on one clock: they are joined in time, and may not overlap.
    pub join_in_time: bool,
    /// When set, matching sources are cuts of one flight, each with its own clock: they are laid end to end with this
    /// many seconds between them, which a warning states.
    pub end_to_end_gap_s: Option<f64>,
    /// Names of the columns of matrices, by a pattern for the matrix: column `i` of `M` becomes `M.name`.
    pub columns: BTreeMap<String, Vec<String>>,
    /// Where time comes from; sources that match none keep the time vector found in the file.
    pub time: Vec<TimeEntry>,
    /// Roles and their channels.
    pub roles: BTreeMap<Role, Entry>,
    /// True histories of a simulated recording and their channels, by the name of the state (`bias_ax`, `wind_north`).
    pub truth: BTreeMap<String, Entry>,
    /// Roles worked out of other roles and channels.
    pub derive: Derivations,
    /// Aircraft its recordings are of: the name of one that comes with the program, or a file beside the map.
    pub aircraft: Option<String>,
}

/// Time of the sources that match a pattern.
#[derive(Clone, Debug, PartialEq)]
pub struct TimeEntry {
    /// Sources, as a pattern.
    pub source: String,
    /// Where the stamps come from.
    pub origin: TimeOrigin,
    /// UTC at time zero, s since 1970-01-01.
    pub utc_start_s: Option<f64>,
    /// Leave out samples whose stamp does not lie after every earlier one, instead of refusing the source.
    pub drop_faults: bool,
}

/// Where time stamps come from.
#[derive(Clone, Debug, PartialEq)]
pub enum TimeOrigin {
    /// A recorded channel, with its aliases, in a unit of time.
    Channel {
        /// Names to look for, best first.
        names: Vec<String>,
        /// Unit of the stamps; as recorded, or seconds, where the map gives none.
        unit: Option<Unit>,
    },
    /// Evenly spaced.
    Even {
        /// Time of the first sample, s.
        start_s: f64,
        /// Samples per second, Hz.
        rate_hz: f64,
    },
    /// As the file gives it.
    File,
}

/// How one role is made.
#[derive(Clone, Debug, PartialEq)]
pub struct Entry {
    /// Channels and their weights; their weighted sum is the raw value.
    pub terms: Vec<Term>,
    /// Unit of the raw value; as recorded where the map gives none.
    pub unit: Option<Unit>,
    /// Sign times scale.
    pub factor: f64,
    /// Added to the raw value.
    pub offset: f64,
    /// A recording without the channel is no error.
    pub optional: bool,
    /// Range of the median of the values in recordings this map is for, in its unit, with sign, scale and offset.
    pub median: Option<[f64; 2]>,
    /// The same of the magnitude that one value in a hundred passes.
    pub largest: Option<[f64; 2]>,
    /// Line in the map, from 1.
    pub line: usize,
}

/// One channel of a weighted sum.
#[derive(Clone, Debug, PartialEq)]
pub struct Term {
    /// Sources to look in, as a pattern; the map's own where it gives none.
    pub source: Option<String>,
    /// Names to look for, best first: the channel, then its aliases.
    pub names: Vec<String>,
    /// Weight.
    pub weight: f64,
}

/// Position relative to the first fix, from latitude, longitude and altitude on a flat Earth.
///
/// `x = R_M (lat - lat0)`, `y = R_N cos(lat0) (lon - lon0)`, `z = -(h - h0)` with the radii of curvature of the WGS 84
/// ellipsoid at the first fix (Stevens and Lewis, Aircraft Control and Simulation, section 1.6).
#[derive(Clone, Debug, PartialEq)]
pub struct FlatEarth {
    /// Role that gives the altitude; position down is left out without one.
    pub altitude: Option<Role>,
}

/// What a map derives.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Derivations {
    /// Position from fixes.
    pub position: Option<FlatEarth>,
    /// Attitude from the parts `w, x, y, z` of a quaternion.
    pub attitude: Option<(Vec<Entry>, QuaternionAxes)>,
    /// Velocity north and east from ground speed and track over the ground.
    pub velocity: Option<[Entry; 2]>,
}

pub(crate) const ATTITUDE: [Role; 3] = [Role::BankAngle, Role::PitchAngle, Role::HeadingAngle];
/// Horizontal velocity over the ground.
pub(crate) const VELOCITY: [Role; 2] = [Role::VelocityNorth, Role::VelocityEast];

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Header {
    format: Spanned<String>,
    version: Spanned<u32>,
    name: String,
    #[serde(default)]
    description: String,
    aircraft: Option<String>,
    #[serde(default = "any")]
    source: String,
    #[serde(default)]
    join_in_time: bool,
    end_to_end_gap_s: Option<Spanned<f64>>,
    #[serde(default)]
    columns: BTreeMap<String, Vec<String>>,
    #[serde(default)]
    time: Vec<Spanned<TimeTable>>,
    #[serde(default)]
    roles: BTreeMap<Spanned<String>, EntryTable>,
    #[serde(default)]
    mixing: BTreeMap<Spanned<String>, MixingTable>,
    #[serde(default)]
    truth: BTreeMap<Spanned<String>, EntryTable>,
    #[serde(default)]
    derive: DeriveTable,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct TimeTable {
    #[serde(default = "any")]
    source: String,
    channel: Option<String>,
    #[serde(default)]
    aliases: Vec<String>,
    unit: Option<Spanned<String>>,
    start_time: Option<f64>,
    sample_rate: Option<f64>,
    utc_start: Option<Spanned<String>>,
    repair: Option<Spanned<String>>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct EntryTable {
    source: Option<String>,
    channel: Option<String>,
    #[serde(default)]
    aliases: Vec<String>,
    #[serde(default)]
    sum: Vec<TermTable>,
    unit: Option<Spanned<String>>,
    sign: Option<Spanned<f64>>,
    #[serde(default = "one")]
    scale: f64,
    #[serde(default)]
    offset: f64,
    #[serde(default)]
    optional: bool,
    median: Option<[f64; 2]>,
    largest: Option<[f64; 2]>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct TermTable {
    source: Option<String>,
    channel: String,
    #[serde(default)]
    aliases: Vec<String>,
    #[serde(default = "one")]
    weight: f64,
}

#[derive(Default, Deserialize)]
#[serde(deny_unknown_fields)]
struct DeriveTable {
    position: Option<PositionTable>,
    attitude: Option<AttitudeTable>,
    velocity: Option<VelocityTable>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct AttitudeTable {
    source: Option<String>,
    quaternion: Spanned<[String; 4]>,
    axes: Option<Spanned<String>>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct VelocityTable {
    ground_speed: Spanned<EntryTable>,
    track: Spanned<EntryTable>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct PositionTable {
    altitude: Option<Spanned<String>>,
}

fn any() -> String {
    "*".to_owned()
}

fn one() -> f64 {
    1.0
}

impl ChannelMap {
    /// Reads the map in the file `path`.
    ///
    /// # Errors
    /// [`LoadError::Open`], or [`LoadError::Map`] with the line.
    pub fn read(path: &Path) -> Result<Self, LoadError> {
        let text = crate::load::read_text(path).map_err(|cause| LoadError::Open { path: path.to_owned(), cause })?;
        Self::parse(&text).map_err(|error| match error {
            LoadError::Map { line, what, .. } => LoadError::Map { path: Some(path.to_owned()), line, what },
            other => other,
        })
    }

    /// Reads the map written in `text` (TOML).
    ///
    /// # Errors
    /// [`LoadError::Map`] with the line: not TOML, an unknown key, role or unit, a unit of another dimension than
    /// the role's, a newer version.
    pub fn parse(text: &str) -> Result<Self, LoadError> {
        let source = Text(text);
        let header: Header = toml::from_str(text).map_err(|error| {
            let at = error.span().map_or(0, |span| span.start);
            source.fault(at, error.message().replace('\n', " "))
        })?;
        if header.format.get_ref() != FORMAT {
            return Err(source.fault(header.format.span().start, format!("format is not \"{FORMAT}\"")));
        }
        let version = *header.version.get_ref();
        if version != VERSION {
            let what = format!("version {version} is not version {VERSION} of this program; use a newer program");
            return Err(source.fault(header.version.span().start, what));
        }
        let gap = header.end_to_end_gap_s.map(|gap| (gap.span().start, gap.into_inner()));
        if let Some((at, _)) = gap.filter(|(_, gap)| !(gap.is_finite() && *gap > 0.0)) {
            return Err(source.fault(at, "end_to_end_gap_s must be more than 0 s".to_owned()));
        }
        let mut roles = BTreeMap::new();
        for (key, table) in header.roles {
            let known = Role::from_name(key.get_ref());
            let role = known.ok_or_else(|| source.unknown(&key, "role", Role::ALL.iter().map(|role| role.name())))?;
            roles.insert(role, source.entry(table, Some(role.dimension()), key.span().start)?);
        }
        for (key, table) in header.mixing {
            source.mix(&key, &table, &mut roles)?;
        }
        let mut truth = BTreeMap::new();
        for (key, table) in header.truth {
            let at = key.span().start;
            let entry = source.entry(table, None, at)?;
            if entry.unit.is_none() {
                return Err(source.fault(at, "a true history needs its unit".to_owned()));
            }
            truth.insert(key.into_inner(), entry);
        }
        Ok(Self {
            name: header.name,
            description: header.description,
            source: header.source,
            join_in_time: header.join_in_time,
            end_to_end_gap_s: gap.map(|(_, gap)| gap),
            columns: header.columns,
            time: header.time.into_iter().map(|table| source.time(table)).collect::<Result<_, _>>()?,
            roles,
            truth,
            derive: Derivations {
                position: header.derive.position.map(|table| source.position(table)).transpose()?,
                attitude: header.derive.attitude.map(|table| source.attitude(table)).transpose()?,
                velocity: header.derive.velocity.map(|table| source.velocity(table)).transpose()?,
            },
            aircraft: header.aircraft,
        })
    }

    /// JSON Schema of channel maps.
    pub fn schema() -> Result<serde_json::Value, Refused> {
        schema_of::<Header>(FORMAT)
    }

    /// Maps shipped with the program: file name without extension, and text.
    pub fn shipped() -> &'static [(&'static str, &'static str)] {
        SHIPPED
    }
}

macro_rules! shipped {
    ($($name:literal),* $(,)?) => {
        &[$(($name, include_str!(concat!("../../../../../assets/channel_maps/", $name, ".toml")))),*]
    };
}

const SHIPPED: &[(&str, &str)] = shipped![
    "citation_simulated_truth", "citation_simulated_clean", "attas", "phlab_citation", "uav_oat", "demo_flight"
];

/// The text of a map, to tell lines by offsets.
struct Text<'a>(&'a str);

impl Text<'_> {
    fn line(&self, at: usize) -> usize {
        1 + self.0.as_bytes().iter().take(at).filter(|&&byte| byte == b'\n').count()
    }

    fn fault(&self, at: usize, what: String) -> LoadError {
        LoadError::Map { path: None, line: self.line(at), what }
    }

    fn unknown<'n>(&self, key: &Spanned<String>, kind: &str, known: impl Iterator<Item = &'n str>) -> LoadError {
        let known: Vec<&str> = known.collect();
        self.fault(key.span().start, format!("unknown {kind} '{}': use one of {}", key.get_ref(), known.join(", ")))
    }

    fn unit(&self, name: &Spanned<String>, dimension: Option<Dimension>) -> Result<Unit, LoadError> {
        let at = name.span().start;
        let unit = Unit::parse(name.get_ref()).map_err(|error| self.fault(at, error.to_string()))?;
        if let Some(dimension) = dimension.filter(|dimension| unit.dimension != *dimension) {
            let what = format!("unit '{}' does not convert to {}", unit.symbol, dimension.si_symbol());
            return Err(self.fault(at, what));
        }
        Ok(unit)
    }

    fn entry(&self, table: EntryTable, dimension: Option<Dimension>, at: usize) -> Result<Entry, LoadError> {
        let unit = table.unit.as_ref().map(|name| self.unit(name, dimension)).transpose()?;
        if let Some(sign) = table.sign.as_ref().filter(|sign| sign.get_ref().abs() != 1.0) {
            return Err(self.fault(sign.span().start, "sign is 1 or -1; use scale for a factor".to_owned()));
        }
        let mut terms: Vec<Term> = Vec::new();
        match (table.channel, table.sum.is_empty()) {
            (Some(channel), true) => {
                terms.push(Term { source: table.source, names: names(channel, table.aliases), weight: 1.0 })
            }
            (None, false) => terms.extend(table.sum.into_iter().map(|term| Term {
                source: term.source.or_else(|| table.source.clone()),
                names: names(term.channel, term.aliases),
                weight: term.weight,
            })),
            _ => {
                return Err(
                    self.fault(at, "give either 'channel' or 'sum', a list of channels with weights".to_owned())
                );
            }
        }
        let factor = table.sign.map_or(1.0, Spanned::into_inner) * table.scale;
        let numbers = terms.iter().map(|term| term.weight).chain([factor, table.offset]);
        if let Some(number) = numbers.into_iter().find(|number| !number.is_finite()) {
            return Err(self.fault(at, format!("scale, offset and weights must be finite, not {number}")));
        }
        let ranges = [("median", table.median), ("largest", table.largest)];
        if let Some((name, _)) = ranges
            .iter()
            .find(|(_, range)| range.is_some_and(|[low, high]| low.is_nan() || high.is_nan() || low >= high))
        {
            return Err(self.fault(at, format!("{name} is a range: state its lower end, then its upper")));
        }
        let EntryTable { offset, optional, median, largest, .. } = table;
        Ok(Entry { terms, unit, factor, offset, optional, median, largest, line: self.line(at) })
    }

    /// Adds the roles two surfaces play together.
    fn mix(
        &self,
        key: &Spanned<String>,
        table: &MixingTable,
        roles: &mut BTreeMap<Role, Entry>,
    ) -> Result<(), LoadError> {
        let at = key.span().start;
        let shares = shares(key.get_ref()).ok_or_else(|| self.unknown(key, "mixing", kinds()))?;
        let unit = table.unit.as_ref().map(|name| self.unit(name, Some(Dimension::Angle))).transpose()?;
        let sign = |given: &Option<Spanned<f64>>| match given {
            Some(given) if given.get_ref().abs() != 1.0 => {
                Err(self.fault(given.span().start, "a sign is 1 or -1".to_owned()))
            }
            given => Ok(given.as_ref().map_or(1.0, |given| *given.get_ref())),
        };
        let signs = [sign(&table.left_sign)?, sign(&table.right_sign)?];
        for (role, weights) in shares {
            let term = |side: usize, channel: &String| Term {
                source: table.source.clone(),
                names: vec![channel.clone()],
                weight: signs[side] * weights[side],
            };
            let terms = vec![term(0, &table.left), term(1, &table.right)];
            let (factor, offset, optional, line) = (1.0, 0.0, table.optional, self.line(at));
            let entry = Entry { terms, unit, factor, offset, optional, median: None, largest: None, line };
            if roles.insert(*role, entry).is_some() {
                let what = format!("the map gives {} twice: as a role, and by {}", role.name(), key.get_ref());
                return Err(self.fault(at, what));
            }
        }
        Ok(())
    }

    fn time(&self, table: Spanned<TimeTable>) -> Result<TimeEntry, LoadError> {
        let at = table.span().start;
        let table = table.into_inner();
        let unit = table.unit.as_ref().map(|name| self.unit(name, Some(Dimension::Time))).transpose()?;
        let origin = match (table.channel, table.start_time, table.sample_rate) {
            (Some(channel), None, None) => TimeOrigin::Channel { names: names(channel, table.aliases), unit },
            (None, start, Some(rate_hz)) if rate_hz.is_finite() && rate_hz > 0.0 => {
                TimeOrigin::Even { start_s: start.unwrap_or(0.0), rate_hz }
            }
            (None, None, None) => TimeOrigin::File,
            _ => {
                let what = "give either 'channel', or 'sample_rate' (more than 0 Hz) with or without 'start_time'";
                return Err(self.fault(at, what.to_owned()));
            }
        };
        let utc_start_s = table
            .utc_start
            .map(|text| {
                utc::parse(text.get_ref()).ok_or_else(|| {
                    let what = format!("'{}' is not a UTC time such as 2024-05-01T09:30:00Z", text.get_ref());
                    self.fault(text.span().start, what)
                })
            })
            .transpose()?;
        if let Some(word) = table.repair.as_ref().filter(|word| word.get_ref() != "drop") {
            let what = format!("unknown repair '{}': use \"drop\"", word.get_ref());
            return Err(self.fault(word.span().start, what));
        }
        Ok(TimeEntry { source: table.source, origin, utc_start_s, drop_faults: table.repair.is_some() })
    }

    fn position(&self, table: PositionTable) -> Result<FlatEarth, LoadError> {
        let Some(name) = table.altitude else { return Ok(FlatEarth { altitude: None }) };
        match Role::from_name(name.get_ref()) {
            Some(role) if role.dimension() == Dimension::Length => Ok(FlatEarth { altitude: Some(role) }),
            _ => Err(self.fault(name.span().start, "altitude is \"gps_altitude\" or \"altitude\"".to_owned())),
        }
    }

    fn attitude(&self, table: AttitudeTable) -> Result<(Vec<Entry>, QuaternionAxes), LoadError> {
        let axes = match &table.axes {
            None => QuaternionAxes::Ned,
            Some(name) => {
                let known = QuaternionAxes::from_name(name.get_ref());
                let what = || format!("axes '{}' are not known: use \"ned\" or \"enu\"", name.get_ref());
                known.ok_or_else(|| self.fault(name.span().start, what()))?
            }
        };
        let at = table.quaternion.span().start;
        let unit = Some(Unit::si(Dimension::Dimensionless));
        let part = |channel: String| {
            let terms = vec![Term { source: table.source.clone(), names: vec![channel], weight: 1.0 }];
            let line = self.line(at);
            Entry { terms, unit, factor: 1.0, offset: 0.0, optional: false, median: None, largest: None, line }
        };
        Ok((table.quaternion.into_inner().map(part).into(), axes))
    }

    fn velocity(&self, table: VelocityTable) -> Result<[Entry; 2], LoadError> {
        let entry = |table: Spanned<EntryTable>, dimension: Dimension| {
            let at = table.span().start;
            self.entry(table.into_inner(), Some(dimension), at)
        };
        Ok([entry(table.ground_speed, Dimension::Speed)?, entry(table.track, Dimension::Angle)?])
    }
}

fn names(channel: String, aliases: Vec<String>) -> Vec<String> {
    std::iter::once(channel).chain(aliases).collect()
}

/// Whether `text` matches `pattern`, in which `*` stands for any run of characters.
pub(crate) fn matches(pattern: &str, text: &str) -> bool {
    let Some((head, rest)) = pattern.split_once('*') else { return pattern == text };
    let Some(mut left) = text.strip_prefix(head) else { return false };
    let mut parts = rest.split('*').peekable();
    while let Some(part) = parts.next() {
        if parts.peek().is_none() {
            return left.ends_with(part);
        }
        let Some(at) = left.find(part) else { return false };
        left = &left[at + part.len()..];
    }
    true
}
