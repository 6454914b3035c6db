//! Recordings and data files: probe -> plan -> read.
//!
//! [`probe()`] recognises a file or folder by its content and lists what it holds; [`inspect`] also counts the samples that
//! are not finite. A [`ChannelMap`] says which channel plays which role; [`plan`] applies it and lists every problem;
//! [`read`] gives the [`crate::series::Recording`] in SI. Nothing is repaired silently and nothing is allocated by a size
//! that a file merely claims.

mod budget;
mod clock;
mod clocks;
mod contents;
mod error;
mod file;
mod files;
mod format;
mod formats;
mod guesses;
mod maps;
mod mavlink;
mod names;
mod pieces;
mod restart;
mod row;
pub mod stream;

pub use budget::{BUDGET_VARIABLE, available_memory, memory};
pub use clock::{Clock, CoarseStamps, Gap, TimeFault};
pub use contents::{ChannelInfo, Probe, Source};
pub use error::{LoadError, Problem};
pub use file::{MOST_BYTES, read_bytes, read_text};
pub use files::{FileHeader, aircraft, datcom, instruments, propulsion_maps};
pub use format::{FORMATS, Format, FormatInfo};
pub use formats::recognise::{inspect, probe};
pub use guesses::guess::{guess, guess_row, guess_with, share_rate_unit};
pub use guesses::other_units::find_surface_signal;
pub use guesses::user_names::{NAMES_FILE, UserNames};
pub use maps::attitude::QuaternionAxes;
pub use maps::by_hand::{
    By, ChannelName, ManualChannel, ManualChannelMap, ManualQuaternion, ManualTime, NameFit, OtherSide, RowValues,
    RunnerUp,
};
pub use maps::expected::mismatches;
pub use maps::map::{ChannelMap, Derivations, Entry, FlatEarth, Term, TimeEntry, TimeOrigin};
pub use maps::plan::{Assignment, Plan, plan, plan_all};
pub use maps::read::{read, read_all};
pub use names::stated_unit::{stated_unit, stem_and_unit};

/// What a text holds as a recording called `mine.csv`.
#[cfg(test)]
fn probe_of(text: &str) -> Probe {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("mine.csv");
    std::fs::write(&path, text).unwrap();
    inspect(&path).unwrap()
}
