//! Nothing is ever lost: files replaced in one step, unsaved work kept aside, one owner for every session file.

mod autosave;
mod durable;
mod lock;

pub use autosave::{Draft, Orphan, Slot, orphans, state_folder};
pub use durable::{remove_leftovers, replace, replace_keeping_previous};
pub(crate) use lock::named;
pub use lock::{Claim, Lock, Owner};
