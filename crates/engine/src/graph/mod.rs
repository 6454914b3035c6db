//! Keys of content and the cache of what stages computed.

mod cache;
mod key;

pub use cache::{Cache, Footprint};
pub use key::{Key, KeyBuilder};
