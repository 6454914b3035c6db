//! Runs the stages: at once for the command line, in the background for the workbench.

mod control;
mod coordinator;
mod pipeline;
mod snapshot;

pub use control::{Cancelled, Control};
pub use coordinator::{Engine, Request};
pub use pipeline::{Scope, run};
pub use snapshot::{LogEntry, Slot, Snapshot, WindowResults};
