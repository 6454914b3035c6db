//! Nothing is ever lost: files replaced in one step, unsaved work kept aside, one owner for every session file.

mod durable;
mod folder;
mod lock;
mod manifest;
mod sweep;

pub(crate) use durable::sync_folder_of;
pub use durable::{check_apart, remove_leftovers, replace, replace_keeping_previous};
pub(crate) use folder::PrivateFolder;
pub use folder::{Earlier, Put, PutError, Staging};
pub(crate) use lock::describe_owner;
pub use lock::{Lock, LockResult, Owner};
pub use manifest::{MANIFEST, has_manifest};
pub(crate) use manifest::{hash_bytes, hash_file, hex};
pub use sweep::sweep;
