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
mod snapshot_builder;
mod studies;
mod tried_fixes;
mod tuning;

pub use crate::graph::{Cancelled, Control};
pub use crate::snapshot::{
    Details, ExperimentRows, Inquiries, LogEntry, NamedSlots, OverlaidResults, Overlays, Slot, Snapshot, Studies,
    TriedFixes, WindowDetails, WindowResults, answer, with_study_input,
};
pub use autosaver::Autosaver;
pub use coordinator::{CACHE_BYTES, Engine, Request};
pub use details::DetailRequest;
pub use experiments::experiment_rows;
pub use inquiries::InquiryRequest;
pub use job::Job;
pub use live::{EstimateTrace, LiveOrder, LiveThread, LiveView};
pub use overlays::MOST_OVERLAID;
pub use pipeline::{Scope, run};
pub use tried_fixes::try_fixes;
pub use tuning::{tune_delay, tune_noise};
