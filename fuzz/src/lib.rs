//! One function per kind of file that doublet reads: whatever the bytes, it returns.

mod whole_path;

use std::io::Write;
use std::path::{Path, PathBuf};
use std::sync::LazyLock;

use doublet_core::load::stream::{JsonDecoder, MavlinkDecoder, StreamMap, TextDecoder};
use doublet_core::load::{ChannelMap, aircraft, datcom, inspect, instruments, plan, propulsion_maps, read};
use doublet_core::prep::Expression;
use doublet_engine::session;

pub use whole_path::whole_path;

/// A function that takes whatever bytes there are.
pub type Target = fn(&[u8]);

/// Every function by its name.
pub const TARGETS: [(&str, Target); 18] = [
    ("hdf5", hdf5),
    ("mat", mat),
    ("csv", csv),
    ("ulog", ulog),
    ("dataflash", dataflash),
    ("tdms", tdms),
    ("mdf4", mdf4),
    ("mcap", mcap),
    ("parquet", parquet),
    ("datcom_listing", datcom_listing),
    ("session", session),
    ("aircraft", aircraft),
    ("instruments", instruments),
    ("channel_map", channel_map),
    ("propulsion_maps", propulsion_maps),
    ("expression", expression),
    ("stream", stream),
    ("whole_path", whole_path),
];

/// The channel maps that every recording is read by.
static MAPS: LazyLock<Vec<ChannelMap>> =
    LazyLock::new(|| ChannelMap::shipped().iter().filter_map(|(_, text)| ChannelMap::parse(text).ok()).collect());

/// HDF5 and MAT v7.3.
pub fn hdf5(data: &[u8]) {
    recording("h5", &[b"\x89HDF\r\n\x1a\n"], data);
}

/// MAT v5.
pub fn mat(data: &[u8]) {
    recording("mat", &[b"MATLAB 5.0 MAT-file", &[b' '; 97]], data);
}

/// Delimited text and text columns.
pub fn csv(data: &[u8]) {
    recording("csv", &[], data);
}

/// Streams: MAVLink packets, lines of text and of JSON, in pieces whose size the first byte tells.
pub fn stream(data: &[u8]) {
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

/// PX4 logs.
pub fn ulog(data: &[u8]) {
    recording("ulg", &[b"ULog\x01\x12\x35"], data);
}

/// ArduPilot logs, binary and as text.
pub fn dataflash(data: &[u8]) {
    recording("bin", &[b"\xa3\x95\x80\x80\x59FMT\0"], data);
    recording("log", &[b"FMT, 128, 89, FMT,"], data);
}

/// LabVIEW files.
pub fn tdms(data: &[u8]) {
    recording("tdms", &[b"TDSm"], data);
}

/// ASAM MDF files.
pub fn mdf4(data: &[u8]) {
    recording("mf4", &[b"MDF     4.10    "], data);
}

/// Recordings of messages.
pub fn mcap(data: &[u8]) {
    recording("mcap", &[b"\x89MCAP0\r\n"], data);
}

/// Parquet tables.
pub fn parquet(data: &[u8]) {
    recording("parquet", &[b"PAR1"], data);
}

/// Digital DATCOM listings.
pub fn datcom_listing(data: &[u8]) {
    if let Ok(listing) = datcom::DatcomListing::parse(&String::from_utf8_lossy(data)) {
        let _ = (listing.level_flight_alpha_rad(), format!("{:?}", listing.warnings));
    }
}

/// Sessions; one that is understood is written and read back the same.
pub fn session(data: &[u8]) {
    let Ok(session) = session::parse(&String::from_utf8_lossy(data)) else { return };
    let _ = session::check(&session);
    let text = session::print(&session).expect("a session has a saved form");
    let back = session::parse(&text).expect("a saved session is understood");
    // Not compared as values: not a number, which a file may hold, differs from itself.
    assert_eq!(session::print(&back).expect("a session has a saved form"), text);
}

/// Aircraft files.
pub fn aircraft(data: &[u8]) {
    let _ = aircraft::parse(&String::from_utf8_lossy(data));
}

/// Instruments files.
pub fn instruments(data: &[u8]) {
    let _ = instruments::parse(&String::from_utf8_lossy(data));
}

/// Channel maps.
pub fn channel_map(data: &[u8]) {
    let _ = ChannelMap::parse(&String::from_utf8_lossy(data));
}

/// Engine charts and propeller maps.
pub fn propulsion_maps(data: &[u8]) {
    let text = String::from_utf8_lossy(data);
    let _ = propulsion_maps::parse_engine_chart(&text, Path::new("chart.toml"));
    let _ = propulsion_maps::parse_propeller_map(&text, Path::new("propeller.toml"));
}

/// Channels by expression; one that is understood has a value.
pub fn expression(data: &[u8]) {
    if let Ok(expression) = Expression::parse(&String::from_utf8_lossy(data)) {
        let _ = expression.value(|index| index as f64, &mut Vec::new());
    }
}

/// Lists, inspects and reads a recording: `data` as it is where it has the `magic` of its format, else behind it.
fn recording(extension: &str, magic: &[&[u8]], data: &[u8]) {
    let path = scratch(extension);
    let mut file = std::fs::File::create(&path).expect("the scratch file can be written");
    if magic.first().is_some_and(|start| !data.starts_with(start)) {
        magic.iter().for_each(|part| file.write_all(part).expect("the scratch file can be written"));
    }
    file.write_all(data).expect("the scratch file can be written");
    drop(file);
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
