//! Runs the stages: at once for the command line, in the background for the workbench.

mod autosaver;
mod board;
mod control;
mod coordinator;
mod details;
mod files;
mod flights;
mod job;
mod physics;
mod pipeline;
mod proof;
mod snapshot;
mod studies;
mod tuning;

pub use autosaver::Autosaver;
pub use control::{Cancelled, Control};
pub use coordinator::{Engine, Request};
pub use details::{Details, Wanted, WindowDetails, details};
pub use job::Job;
pub use pipeline::{Scope, run};
pub use snapshot::{LogEntry, Slot, Snapshot, Studies, WindowResults};
pub use tuning::{tune_delay, tune_noise};
