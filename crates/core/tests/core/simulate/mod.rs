//! The simulator against mechanics, its own truth and its shipped recording.
#![expect(clippy::unwrap_used, reason = "a test helper that fails is a failed test")]

mod flight;
mod mechanics;
