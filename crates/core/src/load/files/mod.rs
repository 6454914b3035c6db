//! Data files beside recordings: aircraft, instruments, propulsion maps, DATCOM listings.

pub mod aircraft;
pub mod datcom;
pub mod instruments;
pub mod propulsion_maps;

use serde::Deserialize;

/// What a file says it is, read before anything else; empty and zero where it does not.
#[derive(Default, Deserialize)]
#[serde(default)]
pub struct FileHeader {
    /// What it holds.
    pub format: String,
    /// Version of its layout.
    pub version: u32,
}
