//! Recordings that are still being made: rows of values as they arrive, from a growing text file, lines of text or JSON, or MAVLink
//! packets, and the channel map applied to them row by row.

mod json;
mod map;
mod tail;
mod text;

pub use crate::load::mavlink::{Field, FieldType, MESSAGES, MavlinkDecoder, Message, packet_checksum};
pub use crate::load::row::{StreamChannel, StreamRow};
pub use json::JsonDecoder;
pub use map::{RoleSample, StreamMap};
pub use tail::TailedFile;
pub use text::TextDecoder;
