//! Runs the stages: at once for the command line, in the background for the workbench.

mod autosaver;
mod coordinator;
mod details;
mod experiments;
mod inquiries;
mod job;
mod live;
mod overlays;
mod pipeline;
mod snapshot;
mod snapshot_builder;
mod studies;
mod tuning;

pub use crate::graph::{Cancelled, Control};
pub use autosaver::Autosaver;
pub use coordinator::{CACHE_BYTES, Engine, Request};
pub use details::{DetailRequest, Details, WindowDetails};
pub use experiments::{ExperimentRows, NamedSlots, experiment_rows};
pub use inquiries::{InquiryRequest, answer, with_study_input};
pub use job::Job;
pub use live::{EstimateTrace, LiveOrder, LiveThread, LiveView};
pub use overlays::{MOST_OVERLAID, OverlaidResults, Overlays};
pub use pipeline::{Scope, run};
pub use snapshot::{Inquiries, LogEntry, Slot, Snapshot, Studies, WindowResults};
pub use tuning::{tune_delay, tune_noise};
