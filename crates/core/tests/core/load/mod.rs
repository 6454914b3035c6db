//! Recordings in: formats, channel maps, bad input.

mod bad_input;
mod claims;
mod flight_log;
mod formats;
mod frames;
mod labelled;
mod long;
mod maps;
mod mutations;
mod recorders;
mod schema;
mod strange_tables;
mod stream;
mod time_stamps;
mod user_names;

use std::path::{Path, PathBuf};

use doublet_core::load::{ChannelInfo, Probe};

/// A small recording of `data/`.
fn fixture(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/core/load/data").join(name)
}

/// Writes `contents` to a file called `name` in a new folder that lives as long as the first value.
fn written(name: &str, contents: impl AsRef<[u8]>) -> (tempfile::TempDir, PathBuf) {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join(name);
    std::fs::write(&path, contents).unwrap();
    (folder, path)
}

/// The channel `name` of the source `source`.
fn channel<'p>(probe: &'p Probe, source: &str, name: &str) -> &'p ChannelInfo {
    let names = || probe.sources.iter().map(|source| &source.name).collect::<Vec<_>>();
    let found = probe.source(source).unwrap_or_else(|| panic!("no source {source} in {:?}", names()));
    let names = || found.channels.iter().map(|channel| &channel.name).collect::<Vec<_>>();
    found.channels.iter().find(|channel| channel.name == name).unwrap_or_else(|| panic!("no {name} in {:?}", names()))
}

/// Samples of the fixtures: `f(i, t)`, t = 0.02 i.
fn made(count: usize, f: impl Fn(f64, f64) -> f64) -> Vec<f64> {
    (0..count).map(|i| f(i as f64, 0.02 * i as f64)).collect()
}

/// An element of a MAT file of level 5.
fn element(kind: u32, data: &[u8]) -> Vec<u8> {
    let mut element = [kind.to_le_bytes(), (data.len() as u32).to_le_bytes()].concat();
    element.extend(data);
    element.resize(element.len().next_multiple_of(8), 0);
    element
}
