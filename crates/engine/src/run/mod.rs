//! Runs the stages: at once for the command line, in the background for the workbench.

mod control;
mod coordinator;
mod details;
mod export;
mod files;
mod pipeline;
mod snapshot;
mod studies;

pub use control::{Cancelled, Control};
pub use coordinator::{Engine, Request};
pub use details::{Details, Wanted, WindowDetails, details};
pub use export::Export;
pub use pipeline::{Scope, run};
pub use snapshot::{LogEntry, Slot, Snapshot, Studies, WindowResults};
