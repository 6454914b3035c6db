//! Recorders that are known: files beside the program say which channel of theirs plays which role, in which unit and with which sign.

use std::collections::{BTreeMap, BTreeSet};
use std::sync::OnceLock;

use serde::Deserialize;

use crate::load::contents::{ChannelInfo, Probe, Source};
use crate::load::guesses::candidates::unit_by_size;
use crate::load::guesses::layouts::Layout;
use crate::load::maps::attitude::QuaternionAxes;
use crate::load::maps::by_hand::{By, ChannelName, ManualChannel, ManualQuaternion};
use crate::load::maps::map::matches;
use crate::load::names::stated_unit::{split_unit, stated_unit};
use crate::quantity::{Role, Unit};

/// What a file of a recorder says first.
const FORMAT: &str = "doublet recorder";
/// Version of these files.
const VERSION: u32 = 1;

/// A recorder: how it is recognised and what its channels are.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct Recorder {
    format: String,
    version: u32,
    pub(crate) name: String,
    /// What it flies in, where that follows from it.
    #[serde(default)]
    pub(crate) kind: Option<String>,
    /// Channels that are not listed play no role.
    complete: bool,
    /// Channels that never play a role.
    #[serde(default)]
    never: Vec<String>,
    signature: Signature,
    #[serde(default)]
    quaternion: Vec<Quaternion>,
    #[serde(default)]
    ground: Vec<Ground>,
    /// Tables that it writes without names.
    #[serde(default)]
    layout: Vec<Layout>,
    /// Channels of each role, best first.
    roles: BTreeMap<String, Vec<Column>>,
}

/// What only recordings of it hold.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct Signature {
    #[serde(default)]
    formats: Vec<String>,
    #[serde(default)]
    sources: Vec<String>,
    #[serde(default)]
    channels: Vec<String>,
    /// Channels that play a role count too.
    #[serde(default)]
    with_roles: bool,
    least: usize,
}

/// A channel, as `source/channel` or by its own name, and how it is read.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct Column {
    from: String,
    #[serde(default)]
    unit: Option<String>,
    #[serde(default = "one")]
    sign: f64,
    #[serde(default = "one")]
    scale: f64,
    /// The documentation does not say the sign.
    #[serde(default)]
    ask_sign: bool,
}

fn one() -> f64 {
    1.0
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct Quaternion {
    source: String,
    parts: [String; 4],
    axes: String,
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct Ground {
    speed: Column,
    track: Column,
}

/// What a recorder says of the recordings of one flight.
#[derive(Debug, Default)]
pub(crate) struct Claims {
    pub(crate) names: Vec<String>,
    /// What flew, where the recorder says so.
    pub(crate) kind: Option<String>,
    pub(crate) rows: Vec<(Role, ManualChannel)>,
    pub(crate) attitude: Option<ManualQuaternion>,
    pub(crate) velocity: Option<[ManualChannel; 2]>,
    /// Sources of whose other channels none plays a role.
    pub(crate) closed: BTreeSet<String>,
    /// Channels that play no role.
    pub(crate) never: BTreeSet<ChannelName>,
}

macro_rules! shipped {
    ($($name:literal),* $(,)?) => {
        &[$(include_str!(concat!("../../../../../assets/recorders/", $name, ".toml"))),*]
    };
}

const SHIPPED: &[&str] = shipped![
    "px4", "ardupilot", "mavros", "mavlink", "qgroundcontrol", "inav_blackbox", "blackbox", "opentx", "airdata",
    "xplaneconnect", "xplane_fdr", "xplane_datarefs", "xplane_udp", "xplane_data", "flightgear",
    "flightgear_properties", "garmin", "inertialsense", "jsbsim_properties", "jsbsim", "msfs", "msfs_programs",
    "flight_data_accessor", "opensky", "dashlink", "cloudahoy", "datcon", "dji_flight_log", "phone_logger",
    "racechrono", "vbox", "flysight", "sidpac", "realflight", "faam",
];

/// The recorders that come with the program.
fn recorders() -> &'static [Recorder] {
    static ALL: OnceLock<Vec<Recorder>> = OnceLock::new();
    ALL.get_or_init(|| SHIPPED.iter().filter_map(|text| parse(text).ok()).collect())
}

/// A recorder of the text of its file.
fn parse(text: &str) -> Result<Recorder, String> {
    let recorder: Recorder = toml::from_str(text).map_err(|error| error.to_string())?;
    if recorder.format != FORMAT || recorder.version != VERSION {
        return Err(format!("'{}' must be of format '{FORMAT}', version {VERSION}", recorder.name));
    }
    let columns = recorder.roles.values().flatten();
    let mut units = columns.filter_map(|column| column.unit.as_deref());
    units.try_for_each(|unit| Unit::parse(unit).map(|_| ()).map_err(|error| error.to_string()))?;
    match recorder.roles.keys().find(|name| Role::from_name(name).is_none()) {
        Some(name) => Err(format!("role '{name}' not found")),
        None => Ok(recorder),
    }
}

/// What the recorders known say of `probes`.
pub(crate) fn claim(probes: &[Probe]) -> Claims {
    let mut claims = Claims::default();
    for probe in probes {
        let known = recorders().iter().find(|recorder| recorder.fits(probe));
        if let Some(recorder) = known {
            recorder.claim(probe, &mut claims);
        } else {
            claim_columns(probe, &mut claims);
        }
    }
    claims.rows.sort_by_key(|(role, _)| *role);
    claims
}

/// The same of a table without names whose columns are those that a recorder writes; every role is asked for.
fn claim_columns(probe: &Probe, claims: &mut Claims) {
    let mut layouts = recorders().iter().flat_map(|recorder| recorder.layout.iter().map(move |one| (recorder, one)));
    let found = layouts.find_map(|(recorder, layout)| Some((recorder, layout, layout.name_columns(probe)?)));
    let Some((recorder, layout, named)) = found else { return };
    let mut own = Claims::default();
    recorder.claim(&named, &mut own);
    let channels = || probe.sources.iter().flat_map(|source| &source.channels);
    for (_, row) in &mut own.rows {
        let Some((index, count)) = layout.index_and_count(&row.from.channel) else { continue };
        let Some(channel) = channels().nth(index) else { continue };
        (row.by, row.share) = (By::Layout, Some(1.0));
        row.evidence = Some(format!("column {} of {count} is '{}' in {}", index + 1, row.from.channel, layout.name));
        row.from.channel.clone_from(&channel.name);
    }
    let taken = |role: Role| claims.rows.iter().any(|(other, _)| *other == role);
    let rows: Vec<_> = own.rows.into_iter().filter(|(role, _)| !taken(*role)).collect();
    claims.rows.extend(rows);
    claims.names.push(recorder.name.clone());
    claims.kind = claims.kind.take().or(own.kind);
}

impl Recorder {
    /// Whether a recording holds what only recordings of it hold.
    fn fits(&self, probe: &Probe) -> bool {
        let signature = &self.signature;
        // In another format the names of the sources alone say too little.
        let formats = &signature.formats;
        let is_format = formats.is_empty() || formats.iter().any(|name| *name == probe.format.to_string());
        let has_source = |pattern: &&String| probe.sources.iter().any(|source| is_source(pattern, source));
        let has_channel = |pattern: &&String| {
            probe.sources.iter().any(|source| source.channels.iter().any(|channel| is_it(pattern, source, channel)))
        };
        let sources = if is_format { signature.sources.iter().filter(has_source).count() } else { 0 };
        let of_roles = self.roles.values().flatten().map(|column| &column.from).filter(|_| signature.with_roles);
        let channels: BTreeSet<&String> = signature.channels.iter().chain(of_roles).collect();
        sources + channels.into_iter().filter(has_channel).count() >= signature.least
    }

    fn claim(&self, probe: &Probe, claims: &mut Claims) {
        claims.names.push(self.name.clone());
        claims.kind = claims.kind.take().or_else(|| self.kind.clone());
        let taken = |claims: &Claims, role: Role| claims.rows.iter().any(|(other, _)| *other == role);
        for (name, columns) in &self.roles {
            let Some(role) = Role::from_name(name).filter(|role| !taken(claims, *role)) else { continue };
            if let Some(row) = best(columns, probe, role) {
                claims.rows.push((role, row));
            }
        }
        if claims.attitude.is_none() {
            claims.attitude = self.quaternion.iter().find_map(|quaternion| quaternion.find(probe));
        }
        if claims.velocity.is_none() {
            claims.velocity = self.ground.iter().find_map(|ground| {
                let speed = best(std::slice::from_ref(&ground.speed), probe, Role::TrueAirspeed)?;
                let track = best(std::slice::from_ref(&ground.track), probe, Role::HeadingAngle)?;
                (speed.from.source == track.from.source).then_some([speed, track])
            });
        }
        for source in &probe.sources {
            if self.complete {
                claims.closed.insert(source.name.clone());
            }
            let never = |channel: &&ChannelInfo| self.never.iter().any(|pattern| is_it(pattern, source, channel));
            claims.never.extend(source.channels.iter().filter(never).map(|channel| name_of(source, channel)));
        }
    }
}

impl Quaternion {
    fn find(&self, probe: &Probe) -> Option<ManualQuaternion> {
        let axes = if self.axes == "enu" { QuaternionAxes::Enu } else { QuaternionAxes::Ned };
        probe.sources.iter().find_map(|source| {
            let part = |name: &String| {
                let pattern = format!("{}/{name}", self.source);
                let is = |channel: &&ChannelInfo| is_usable(source, channel) && is_it(&pattern, source, channel);
                source.channels.iter().find(is).map(|channel| channel.name.clone())
            };
            let [w, x, y, z] = self.parts.each_ref().map(part);
            Some(ManualQuaternion { source: source.name.clone(), parts: [w?, x?, y?, z?], axes })
        })
    }
}

/// The row of the first of `columns` that varies, otherwise of the first that is there.
fn best(columns: &[Column], probe: &Probe, role: Role) -> Option<ManualChannel> {
    let found = columns.iter().flat_map(|column| {
        let all = probe.sources.iter().flat_map(|source| source.channels.iter().map(move |channel| (source, channel)));
        all.filter(|(source, channel)| is_usable(source, channel) && is_it(&column.from, source, channel))
            .map(move |(source, channel)| (column, source, channel))
    });
    let found: Vec<_> = found.collect();
    let (column, source, channel) = found.iter().find(|(_, _, channel)| varies(channel)).or(found.first())?;
    let of_role = |unit: &Unit| unit.dimension == role.dimension();
    let by_definition = column.unit.as_deref().and_then(|unit| Unit::parse(unit).ok());
    let stated = || stated_unit(channel).filter(of_role);
    // The definition of a whole name knows its unit better than an end of the name that looks like one: `TAT_DI_R` is in K.
    let is_defined = channel.unit.is_none() && !column.from.contains('*');
    let unit = if is_defined { by_definition.or_else(stated) } else { stated().or(by_definition) };
    let mut row =
        ManualChannel::new(name_of(source, channel), Some(unit.unwrap_or_else(|| unit_by_size(channel, role))));
    row.by = By::Recorder;
    row.is_unit_known = unit.is_some();
    row.asks_sign = column.ask_sign;
    row.turned = column.sign < 0.0;
    // Numbers of a channel that states its unit are in that unit.
    row.scale = if channel.unit.is_some() { 1.0 } else { column.scale };
    Some(row)
}

/// Whether a channel has a time.
fn is_usable(source: &Source, channel: &ChannelInfo) -> bool {
    !channel.is_time && channel.samples > 1 && (channel.clock.is_some() || source.clocks.is_empty())
}

/// Whether the finite values of a channel differ.
fn varies(channel: &ChannelInfo) -> bool {
    let mut finite = channel.values().iter().filter(|value| value.is_finite());
    finite.next().is_some_and(|first| finite.any(|value| value != first))
}

fn name_of(source: &Source, channel: &ChannelInfo) -> ChannelName {
    ChannelName { source: source.name.clone(), channel: channel.name.clone() }
}

/// Name of a source without the number of its instance, with one sign between its parts.
fn plain_source(name: &str) -> String {
    let name = match name.strip_suffix(']').and_then(|name| name.rsplit_once('[')) {
        Some((stem, _)) => stem,
        None => name,
    };
    let name = match name.rsplit_once('_') {
        Some((stem, number)) if !number.is_empty() && number.bytes().all(|byte| byte.is_ascii_digit()) => stem,
        _ => name,
    };
    name.replace(['-', '.', ':'], "/")
}

fn is_source(pattern: &str, source: &Source) -> bool {
    ends_on_pattern(&plain_source(&source.name), pattern)
}

/// Whether `text` is `pattern` or ends on it where a part begins.
fn ends_on_pattern(text: &str, pattern: &str) -> bool {
    if pattern.contains('*') {
        let starts = std::iter::once(0).chain(text.match_indices('/').map(|(at, _)| at + 1));
        return starts.into_iter().any(|start| matches(pattern, &text[start..]));
    }
    text.strip_suffix(pattern).is_some_and(|before| before.is_empty() || before.ends_with(['/', '_']))
}

/// Letters of the shortest name that is the same in other capitals and with `_` for a blank: short ones differ by nothing else.
const LEAST_LETTERS: usize = 6;

/// A name in small letters with blanks between its words.
fn fold(name: &str) -> String {
    name.to_lowercase().replace('_', " ")
}

/// Whether a channel is the one that `pattern` names: `source/channel`, or its own name alone, in whatever capitals.
fn is_it(pattern: &str, source: &Source, channel: &ChannelInfo) -> bool {
    let (name, _) = split_unit(&channel.name);
    if !pattern.contains('/') {
        let is_long = pattern.bytes().filter(u8::is_ascii_alphabetic).count() >= LEAST_LETTERS;
        let is_alike = || is_long && matches(&fold(pattern), &fold(&name));
        return matches(pattern, &name) || matches(pattern, &channel.name) || is_alike();
    }
    let plain = name.replace("field.", "").replace('.', "/");
    ends_on_pattern(&format!("{}/{plain}", plain_source(&source.name)), pattern)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_recorder_that_ships_is_read() {
        for text in SHIPPED {
            let parsed = parse(text);
            assert!(parsed.is_ok(), "{:?}", parsed.err());
        }
        assert_eq!(recorders().len(), SHIPPED.len());
        for recorder in recorders() {
            let Signature { sources, channels, with_roles, least, .. } = &recorder.signature;
            let roles = if *with_roles { recorder.roles.values().map(Vec::len).sum() } else { 0 };
            assert!(
                sources.len() + channels.len() + roles >= *least,
                "{}: no recording has its signature",
                recorder.name
            );
        }
    }

    #[test]
    fn surfaces_and_velocities_of_a_table_of_datarefs_are_known() {
        let head = "sim/flightmodel/position/P,sim/flightmodel/position/local_vz,sim/flightmodel/forces/g_nrml,\
                    sim/flightmodel/controls/hstab1_elv1def[0]";
        let row = |role: Role| row_of(head, role).map(|(_, unit, turned)| (unit.unwrap_or_default(), turned));
        assert_eq!(row(Role::RollRate), Some(("deg/s", false)));
        assert_eq!(row(Role::VelocityNorth), Some(("m/s", true)));
        assert_eq!(row(Role::SpecificForceZ), Some(("g", true)));
        assert_eq!(row(Role::Elevator), Some(("deg", false)));
    }

    #[test]
    fn surfaces_of_a_plane_are_known_before_its_mixer_and_turned() {
        let head = "ATT/DesRoll,IMU/GyrX,GPS/Lng,AETR/Ail,AETR/Elev,AETR/Rudd";
        for (role, channel) in [(Role::Aileron, "Ail"), (Role::Elevator, "Elev"), (Role::Rudder, "Rudd")] {
            let found = row_of(head, role).map(|(found, _, turned)| (found, turned));
            assert_eq!(found, Some((format!("AETR/{channel}"), true)));
        }
    }

    /// Channel, unit and sign of a role of a table of one recorder, whose columns hold small numbers that vary.
    fn row_of(head: &str, role: Role) -> Option<(String, Option<&'static str>, bool)> {
        let columns = head.split(',').count();
        let row = |k: usize| {
            (0..columns).map(|column| format!("{:.2}", 0.1 * (k * (column + 3) % 11) as f64)).collect::<Vec<_>>()
        };
        let rows: String = (0..40).map(|k| format!("{:.2},{}\n", 0.05 * k as f64, row(k).join(","))).collect();
        let claims = claim(&[crate::load::probe_of(&format!("Time,{head}\n{rows}"))]);
        let (_, row) = claims.rows.into_iter().find(|(other, _)| *other == role)?;
        Some((row.from.channel, row.unit.map(|unit| unit.symbol), row.turned))
    }

    #[test]
    fn names_of_a_recorder_are_known_in_other_capitals_and_with_underscores() {
        let head = "Plane_Bank_Degrees,Plane_Pitch_Degrees,Plane_Altitude,Airspeed_True,Rotation_Velocity_Body_X,\
                    Rotation_Velocity_Body_Y,Rotation_Velocity_Body_Z,Acceleration_Body_X";
        for (role, channel, turned) in [
            (Role::BankAngle, "Plane_Bank_Degrees", true),
            (Role::RollRate, "Rotation_Velocity_Body_Z", true),
            (Role::PitchRate, "Rotation_Velocity_Body_X", true),
            (Role::YawRate, "Rotation_Velocity_Body_Y", false),
        ] {
            let (found, _, is_turned) = row_of(head, role).unwrap_or_else(|| panic!("{}", role.name()));
            assert_eq!((found.as_str(), is_turned), (channel, turned));
        }
        assert_eq!(row_of(head, Role::SpecificForceX), None);
    }

    #[test]
    fn roles_of_a_recorder_may_be_its_signature() {
        for prefix in ["", "/fdm/jsbsim/"] {
            let names = ["attitude/roll-rad", "attitude/pitch-rad", "velocities/vtrue-fps", "velocities/vc-fps"];
            let head = names.map(|name| format!("{prefix}{name}")).join(",");
            let (channel, unit, _) = row_of(&head, Role::CalibratedAirspeed).unwrap();
            assert_eq!((channel, unit), (format!("{prefix}velocities/vc-fps"), Some("ft/s")));
        }
        assert_eq!(row_of("attitude/roll-rad,velocities/vc-fps,x,y", Role::CalibratedAirspeed), None);
    }

    #[test]
    fn a_flight_log_of_a_multirotor_leaves_out_its_gimbal() {
        let head = "OSD.pitch,OSD.roll,OSD.yaw,OSD.height [m],GIMBAL.pitch,GIMBAL.roll,GIMBAL.yaw";
        assert_eq!(row_of(head, Role::PitchAngle), Some(("OSD.pitch".to_owned(), Some("deg"), false)));
        let slip = "degrees/LAT,degrees/LON,feet/ALT (GPS),ft Baro/AltB,degrees/HDG,degrees/Yaw";
        assert_eq!(row_of(slip, Role::HeadingAngle), Some(("degrees/HDG".to_owned(), Some("deg"), false)));
        assert_eq!(row_of(slip, Role::Sideslip), Some(("degrees/Yaw".to_owned(), Some("deg"), false)));
    }

    #[test]
    fn topics_are_found_under_the_names_that_exports_give_them() {
        for (name, topic, wanted) in [
            ("log_sensor_accel_0", "sensor_accel", true),
            ("vehicle_attitude[1]", "vehicle_attitude", true),
            ("carbonZ_engine_failure-mavros-imu-data", "mavros/imu/data", true),
            ("carbonZ_engine_failure-mavros-imu-data_raw", "mavros/imu/data", false),
            ("estimator_attitude", "vehicle_attitude", false),
        ] {
            assert_eq!(ends_on_pattern(&plain_source(name), topic), wanted, "{name}");
        }
    }
}
