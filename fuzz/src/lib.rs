//! A target for each kind of file that doublet reads: whatever the bytes, it returns.

mod guess_session;
mod live;
pub mod recording_chain;
mod whole_path;

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};
use std::sync::LazyLock;

use doublet_core::load::stream::{JsonDecoder, MavlinkDecoder, StreamMap, TextDecoder};
use doublet_core::load::{
    ChannelMap, FORMATS, FormatInfo, aircraft, datcom, inspect, instruments, plan, propulsion_maps, read,
};
use doublet_core::prep::Expression;
use doublet_engine::session;

use whole_path::whole_path;

/// A function that takes whatever bytes there are.
type Target = fn(&[u8]);

/// What is fuzzed beside recordings.
const OTHERS: [(&str, Target); 11] = [
    ("datcom_listing", datcom_listing),
    ("session", session),
    ("aircraft", aircraft),
    ("instruments", instruments),
    ("channel_map", channel_map),
    ("propulsion_maps", propulsion_maps),
    ("expression", expression),
    ("stream", stream),
    ("live", live::live),
    ("whole_path", whole_path),
    ("recording_chain", recording_chain::recording_chain),
];

/// Names of all targets: those of the formats of recordings, then the others.
pub fn targets() -> Vec<&'static str> {
    let formats: BTreeSet<&str> = FORMATS.iter().map(|format| format.fuzz_target).collect();
    formats.into_iter().chain(OTHERS.map(|(name, _)| name)).collect()
}

/// Calls the target `name` with `data`.
pub fn call(name: &str, data: &[u8]) {
    match OTHERS.iter().find(|(other, _)| *other == name) {
        Some((_, target)) => target(data),
        None => recordings(name, data),
    }
}

/// The channel maps that every recording is read by.
static MAPS: LazyLock<Vec<ChannelMap>> =
    LazyLock::new(|| ChannelMap::shipped().iter().filter_map(|(_, text)| ChannelMap::parse(text).ok()).collect());

/// Streams: MAVLink packets, lines of text and of JSON, in pieces whose size the first byte tells.
fn stream(data: &[u8]) {
    let Some((&size, data)) = data.split_first() else { return };
    let (mut mavlink, mut text, mut json) =
        (MavlinkDecoder::default(), TextDecoder::new("stream"), JsonDecoder::default());
    let mut rows = Vec::new();
    for piece in data.chunks(usize::from(size).max(1)) {
        mavlink.push(piece, &mut rows);
        text.push(piece, &mut rows);
        rows.extend(json.decode(&String::from_utf8_lossy(piece)));
    }
    mavlink.end_of_datagram(&mut rows);
    text.finish(&mut rows);
    for map in MAPS.iter() {
        let (mut map, mut samples) = (StreamMap::new(map.clone()), Vec::new());
        rows.iter().for_each(|row| map.take(row, &mut samples));
    }
}

/// Digital DATCOM listings.
fn datcom_listing(data: &[u8]) {
    if let Ok(listing) = datcom::DatcomListing::parse(&String::from_utf8_lossy(data)) {
        let _ = (listing.level_flight_alpha_rad(), format!("{:?}", listing.warnings));
    }
}

/// Sessions; one that is understood is written and read back the same.
fn session(data: &[u8]) {
    let Ok(session) = session::parse(&String::from_utf8_lossy(data)) else { return };
    let _ = session::check(&session);
    let text = session::print(&session).expect("a session has a saved form");
    let back = session::parse(&text).expect("a saved session is understood");
    // Not compared as values: not a number, which a file may hold, differs from itself.
    assert_eq!(session::print(&back).expect("a session has a saved form"), text);
}

/// Aircraft files.
fn aircraft(data: &[u8]) {
    let _ = aircraft::parse(&String::from_utf8_lossy(data));
}

/// Instruments files.
fn instruments(data: &[u8]) {
    let _ = instruments::parse(&String::from_utf8_lossy(data));
}

fn channel_map(data: &[u8]) {
    let _ = ChannelMap::parse(&String::from_utf8_lossy(data));
}

/// Engine charts and propeller maps.
fn propulsion_maps(data: &[u8]) {
    let text = String::from_utf8_lossy(data);
    let _ = propulsion_maps::parse_engine_chart(&text, Path::new("chart.toml"));
    let _ = propulsion_maps::parse_propeller_map(&text, Path::new("propeller.toml"));
}

/// Channels by expression; one that is understood has a value.
fn expression(data: &[u8]) {
    if let Ok(expression) = Expression::parse(&String::from_utf8_lossy(data)) {
        let _ = expression.value(|index| index as f64, &mut Vec::new());
    }
}

/// Reads `data` as a recording of a target: as it is where it has a mark of one of its formats or none has a mark, else with each mark put in.
fn recordings(target: &str, data: &[u8]) {
    let formats: Vec<&FormatInfo> = FORMATS.iter().filter(|format| format.fuzz_target == target).collect();
    let extension = |format: &FormatInfo| format.endings.first().copied().unwrap_or("csv");
    let begins_at = |at: usize, mark: &[u8]| data.get(at..).is_some_and(|rest| rest.starts_with(mark));
    let has_mark =
        |format: &FormatInfo| format.marks.iter().any(|mark| format.at.iter().any(|at| begins_at(*at, mark)));
    if formats.iter().all(|format| format.marks.is_empty()) || formats.iter().any(|format| has_mark(format)) {
        return formats.iter().take(1).for_each(|format| recording(extension(format), data));
    }
    for (format, mark) in formats.iter().flat_map(|format| format.marks.iter().map(move |mark| (format, mark))) {
        let before = vec![b' '; format.at[0]];
        recording(extension(format), &[&before, *mark, data].concat());
    }
}

/// Lists, inspects and reads a recording.
fn recording(extension: &str, data: &[u8]) {
    let path = scratch(extension);
    std::fs::write(&path, data).expect("the scratch file can be written");
    if let Ok(probe) = inspect(&path) {
        for map in MAPS.iter() {
            let _ = read(&plan(&probe, map));
        }
    }
}

/// One file per process and thread, in memory where the system has such a place.
fn scratch(extension: &str) -> PathBuf {
    let memory = Path::new("/dev/shm");
    let folder = if memory.is_dir() { memory.to_path_buf() } else { std::env::temp_dir() };
    let thread = format!("{:?}", std::thread::current().id());
    let thread: String = thread.chars().filter(char::is_ascii_digit).collect();
    folder.join(format!("doublet-{}-{thread}.{extension}", std::process::id()))
}
