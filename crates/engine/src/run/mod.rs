//! Runs the stages: at once for the command line, in the background for the workbench.

mod autosaver;
mod coordinator;
mod details;
mod experiments;
mod inquiries;
mod job;
mod live;
mod named_slots;
mod overlays;
mod pipeline;
mod snapshot;
mod snapshot_builder;
mod studies;
mod tried_fixes;
mod tuning;

pub use crate::graph::{Cancelled, Control};
pub use autosaver::Autosaver;
pub use coordinator::{CACHE_BYTES, Engine, Request};
pub use details::{DetailRequest, Details, WindowDetails};
pub use experiments::{ExperimentRows, experiment_rows};
pub use inquiries::{InquiryRequest, answer, with_study_input};
pub use job::Job;
pub use live::{EstimateTrace, LiveOrder, LiveThread, LiveView};
pub use named_slots::NamedSlots;
pub use overlays::{MOST_OVERLAID, OverlaidResults, Overlays};
pub use pipeline::{Scope, run};
pub use snapshot::{Inquiries, LogEntry, Slot, Snapshot, Studies, WindowResults};
pub use tried_fixes::{TriedFixes, try_fixes};
pub use tuning::{tune_delay, tune_noise};
