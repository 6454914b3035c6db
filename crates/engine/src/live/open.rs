//! What is to be watched, found by what was asked for.

use std::net::IpAddr;
use std::path::{Path, PathBuf};
use std::time::Duration;

use doublet_core::load::{self, ChannelMap, Format, plan_all};
use doublet_core::quantity::Role;

use super::replay::Replay;
use super::settings::LiveSettings;
use super::source::{LineFormat, Source};
use crate::begin::{self, empty_session};
use crate::builtin;
use crate::graph::{Context, Control};
use crate::session::{self, MapRef, Session};
use crate::stage::{LoadedFlight, aircraft_data, aircraft_of, load_aircraft};

/// Name of the shipped map for MAVLink.
const MAVLINK_MAP: &str = "mavlink";

/// Where a flight comes from.
#[derive(Clone, Debug, PartialEq)]
pub enum Feed {
    /// A recording, a text file that grows, a telemetry log, or a session whose flight is flown again.
    File(String),
    /// Lines by UDP at this address.
    Lines(String, LineFormat),
    /// MAVLink packets by UDP at this address, or a telemetry log.
    Mavlink(String),
}

/// What is to be watched and with what.
#[derive(Clone, Debug, Default)]
pub struct Opening {
    /// Where the flight comes from; that of the session without.
    pub feed: Option<Feed>,
    /// Session file, or `builtin:` and a name, whose settings are used.
    pub session: Option<String>,
    /// A session as it is edited and the folder its paths start from, in the place of a file.
    pub in_memory: Option<(Session, PathBuf)>,
    /// Channel map, by file or name.
    pub map: Option<String>,
    /// Aircraft, by file or name.
    pub aircraft: Option<String>,
    /// Campaign whose limits are watched, by file or `builtin:` and a name.
    pub campaign: Option<String>,
    /// The one address whose packets are taken; none for all.
    pub from: Vec<IpAddr>,
    /// Time without a change after which a growing file has ended; none for never.
    pub wait: Option<Duration>,
}

/// A flight ready to be watched.
pub struct Watched {
    /// Where rows come from.
    pub source: Source,
    /// Text of the channel map.
    pub map: String,
    pub settings: LiveSettings,
    /// Session whose settings they are; paths from its own folder.
    pub session: Option<Session>,
    /// Aircraft as a session refers to it.
    pub aircraft: Option<String>,
    /// Whether the source is a recording that was made, with a time of its own.
    pub is_recorded: bool,
    /// What was chosen, a line each.
    pub notes: Vec<String>,
}

/// A session with its folder.
struct Like {
    session: Session,
    folder: PathBuf,
}

/// Finds what is to be watched.
pub fn open(opening: &Opening) -> Result<Watched, String> {
    let in_memory = opening.in_memory.clone().map(|(session, folder)| Like { session, folder });
    let mut like = opening.session.as_deref().map(read_session).transpose()?.or(in_memory);
    let mut feed = opening.feed.clone();
    if let Some(Feed::File(name)) = &feed
        && (name.ends_with(".toml") || builtin::session(name.strip_prefix(builtin::PREFIX).unwrap_or("")).is_some())
    {
        like = Some(like.map_or_else(|| read_session(name), Ok)?);
        feed = None;
    }
    let mut notes = Vec::new();
    let (source, map, is_recorded) = match (&feed, &like) {
        (Some(Feed::File(name)), _) => open_file(name, opening, like.as_ref(), &mut notes)?,
        (Some(Feed::Lines(address, format)), _) => {
            let map = named_map(opening)?.unwrap_or_else(by_role_names);
            (Source::lines(address, &opening.from, *format)?, map, false)
        }
        (Some(Feed::Mavlink(place)), _) => {
            let (map, path) = (named_map(opening)?.map_or_else(mavlink_map, Ok)?, Path::new(place));
            if path.exists() {
                (Source::log(path)?, map, true)
            } else {
                (Source::mavlink(place, &opening.from)?, map, false)
            }
        }
        (None, Some(like)) => {
            let replay = replay_of(like)?;
            let map = replay.map.clone();
            (Source::Replay(replay), map, true)
        }
        (None, None) => return Err("no data source: give --file, --udp, --mavlink or --session".to_owned()),
    };
    let parsed = ChannelMap::parse(&map).map_err(|error| error.to_string())?;
    let of_map = parsed.aircraft.as_ref().map(|name| reference(name));
    let named = opening.aircraft.as_deref().map(reference);
    let aircraft = named.or_else(|| like.as_ref().and_then(|like| like.session.aircraft.clone())).or(of_map);
    let folder = like.as_ref().map_or_else(PathBuf::new, |like| like.folder.clone());
    let context = Context::new(&folder);
    let loading = like.as_ref().and_then(|like| like.session.loading.as_ref());
    let of_session = like.as_ref().filter(|like| like.session.aircraft == aircraft);
    let data = aircraft.as_deref().map(|name| {
        let loaded = match of_session {
            Some(like) => aircraft_of(&context, &like.session),
            None => load_aircraft(&context, name),
        };
        let loaded = loaded.map_err(|error| error.to_string())?;
        Ok::<_, String>(aircraft_data(loaded.shared().clone(), loading))
    });
    let data = data.transpose()?;
    match &aircraft {
        Some(aircraft) => notes.push(format!("aircraft: {aircraft}")),
        None => notes.push(format!("{}: give --aircraft", crate::stage::NO_AIRCRAFT)),
    }
    let aircraft_changes = of_session.map(|like| like.session.aircraft_changes.clone()).unwrap_or_default();
    let session = like.map(|like| Session {
        aircraft: aircraft.clone(),
        aircraft_changes,
        ..session::relative_to(&like.session, &like.folder)
    });
    let defaults = || empty_session("live", aircraft.as_deref());
    let settings = LiveSettings::from_session(session.as_ref().unwrap_or(&defaults()), data);
    Ok(Watched { source, map, settings, session, aircraft, is_recorded, notes })
}

/// A session by its file or the name of one that comes with the program.
fn read_session(name: &str) -> Result<Like, String> {
    if let Some(text) = name.strip_prefix(builtin::PREFIX).and_then(builtin::session) {
        let session = session::parse(text).map_err(|error| error.to_string())?;
        return Ok(Like { session, folder: PathBuf::new() });
    }
    let opened = session::open(Path::new(name)).map_err(|error| error.to_string())?;
    Ok(Like { session: opened.session, folder: opened.folder })
}

/// The first flight of a session, as all else takes it: clocks, instruments and expressions included.
fn replay_of(like: &Like) -> Result<Replay, String> {
    let flight = like.session.flights.first().ok_or("the session has no flight")?;
    let context = Context::new(&like.folder);
    let loaded = context.get::<LoadedFlight>(flight, ()).map_err(|error| error.to_string())?;
    Ok(Replay::new(&loaded.recording))
}

/// A recording or a text file that may grow.
fn open_file(
    name: &str,
    opening: &Opening,
    like: Option<&Like>,
    notes: &mut Vec<String>,
) -> Result<(Source, String, bool), String> {
    let path = match name.strip_prefix(builtin::PREFIX) {
        Some(inside) => builtin::on_disk(inside)?,
        None => PathBuf::from(name),
    };
    let has_ending = |ending: &str| path.extension().is_some_and(|found| found.eq_ignore_ascii_case(ending));
    if has_ending("tlog") {
        return Ok((Source::log(&path)?, named_map(opening)?.map_or_else(mavlink_map, Ok)?, true));
    }
    let inspected = begin::inspect(std::slice::from_ref(&path), &Control::default(), &|_| {});
    let stated = match named_map(opening)? {
        Some(map) => Some(map),
        None => like.map(|like| map_in_session(like, &path)).transpose()?.flatten(),
    };
    let (map, inspected) = match (stated, inspected) {
        (Some(map), Err(_)) if path.is_file() => return Ok((Source::tail(&path, opening.wait)?, map, true)),
        (_, Err(error)) => return Err(error),
        (Some(map), Ok(inspected)) => (map, inspected),
        (None, Ok(inspected)) => {
            let (map, what) = match inspected.fitting.first() {
                Some(best) => {
                    (builtin::text("channel_maps", best.name).unwrap_or_default().to_owned(), best.name.to_owned())
                }
                None => (inspected.guess.text().map_err(|error| error.to_string())?, "guessed; give --map".to_owned()),
            };
            notes.push(format!("channel map: {what}"));
            (map, inspected)
        }
    };
    let is_text = |format: Format| matches!(format, Format::DelimitedText | Format::TextColumns);
    if inspected.probes.iter().all(|probe| is_text(probe.format)) {
        return Ok((Source::tail(&path, opening.wait)?, map, true));
    }
    let parsed = ChannelMap::parse(&map).map_err(|error| error.to_string())?;
    let recording = load::read(&plan_all(&inspected.probes, &parsed)).map_err(|error| error.to_string())?;
    let replay = Replay::new(&recording);
    let aircraft = parsed.aircraft.map(|name| format!("aircraft = \"{name}\"\n")).unwrap_or_default();
    let map = replay.map.replacen("version = 1\n", &format!("version = 1\n{aircraft}"), 1);
    Ok((Source::Replay(replay), map, true))
}

/// The map that a session reads a recording of this name by.
fn map_in_session(like: &Like, path: &Path) -> Result<Option<String>, String> {
    let mut recordings = like.session.flights.iter().flat_map(|flight| &flight.recordings);
    let same = recordings.find(|recording| Path::new(&recording.path).file_name() == path.file_name());
    same.map(|recording| match &recording.channel_map {
        MapRef::Own(text) => Ok(text.to_string()),
        MapRef::File(file) => Context::new(&like.folder).text(file, "channel_maps").map_err(|error| error.to_string()),
    })
    .transpose()
}

/// The text of the map that was named.
fn named_map(opening: &Opening) -> Result<Option<String>, String> {
    let Some(name) = &opening.map else { return Ok(None) };
    if let Some(text) = builtin::text("channel_maps", name.strip_prefix(builtin::PREFIX).unwrap_or(name)) {
        return Ok(Some(text.to_owned()));
    }
    load::read_text(Path::new(name)).map(Some).map_err(|error| format!("{name}: {error}"))
}

fn mavlink_map() -> Result<String, String> {
    builtin::text("channel_maps", MAVLINK_MAP)
        .map(str::to_owned)
        .ok_or_else(|| format!("no built-in map '{MAVLINK_MAP}'"))
}

/// A map for channels that are called as roles are, in SI.
fn by_role_names() -> String {
    let mut map = String::from("format = \"doublet channel map\"\nversion = 1\nname = \"roles by their names\"\n");
    for role in Role::ALL {
        let (name, unit) = (role.name(), role.dimension().si_symbol());
        map.push_str(&format!("\n[roles.{name}]\nchannel = \"{name}\"\nunit = \"{unit}\"\noptional = true\n"));
    }
    map
}

/// An aircraft by the name of one that comes with the program, or its file.
fn reference(name: &str) -> String {
    if builtin::text("aircraft", name).is_some() {
        return format!("{}{name}", builtin::PREFIX);
    }
    Path::new(name).canonicalize().map_or_else(|_| name.to_owned(), |full| full.display().to_string())
}
