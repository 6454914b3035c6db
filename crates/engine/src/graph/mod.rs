//! What every stage is made of: its declaration, its context, the key of its content, and the cache of what was computed.

mod cache;
mod context;
mod control;
mod guard;
mod key;
mod stage;

pub use cache::{Cache, Footprint};
pub use context::{Context, FileStamp};
pub use control::{Cancelled, Control};
pub use guard::guarded;
pub use key::{Key, KeyBuilder};
pub use stage::{Keyed, Stage, StageError, StageResult};
