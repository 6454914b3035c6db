//! Recordings and data files: probe -> plan -> read.
//!
//! [`probe()`] recognises a file or folder by its content and lists what it holds; [`inspect`] also counts the samples that
//! are not finite. A [`ChannelMap`] says which channel plays which role; [`plan`] applies it and lists every problem;
//! [`read`] gives the [`crate::series::Recording`] in SI. Nothing is repaired silently and nothing is allocated by a size
//! that a file merely claims.

pub mod aircraft;
mod attitude;
#[cfg(test)]
mod awkward_cases;
mod budget;
mod by_hand;
mod by_name;
mod by_physics;
mod by_words;
mod candidates;
mod clock;
mod contents;
mod dataflash;
pub mod datcom;
mod derive;
mod error;
mod expected;
mod file;
mod find_clocks;
mod finish;
mod flysight;
mod foreign_names;
mod guess;
mod guess_frames;
mod hdf5;
mod hdf5_decode;
pub mod instruments;
mod kinds;
mod layouts;
mod map;
mod mat;
mod mat_contents;
mod mcap;
mod mdf4;
mod mixing;
mod motion;
mod motion_units;
mod names;
mod parquet;
mod physics;
mod plan;
pub mod propulsion_maps;
mod ranges;
mod read;
mod recognise;
mod recorders;
mod runner_up;
mod slopes;
mod stamp;
mod stated_unit;
mod stored_number;
pub mod stream;
mod tdms;
mod text;
mod text_layout;
mod time_unit;
mod tokens;
mod ulog;
mod user_names;
mod utc;
mod vbox;
mod vectors;
mod words;

pub use attitude::QuaternionAxes;
pub use budget::{BUDGET_VARIABLE, memory};
pub use by_hand::{
    By, ChannelName, ManualChannel, ManualChannelMap, ManualQuaternion, ManualTime, NameFit, RowValues, RunnerUp,
};
pub use clock::{Clock, Gap, TimeFault};
pub use contents::{ChannelInfo, Format, Probe, Source};
pub use error::LoadError;
pub use expected::mismatches;
pub use file::{MOST_BYTES, read_bytes, read_text};
pub use guess::{guess, guess_row, guess_with, share_rate_unit};
pub use map::{ChannelMap, Derivations, Entry, FlatEarth, Term, TimeEntry, TimeOrigin};
pub use plan::{Assignment, Plan, Problem, plan, plan_all};
pub use read::{read, read_all};
pub use recognise::{inspect, probe};
pub use stated_unit::{stated_unit, stem_and_unit};
pub use user_names::{NAMES_FILE, UserNames};

/// What a text holds as a recording called `mine.csv`.
#[cfg(test)]
fn probe_of(text: &str) -> Probe {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("mine.csv");
    std::fs::write(&path, text).unwrap();
    inspect(&path).unwrap()
}
