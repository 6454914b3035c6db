//! The simulator against mechanics, its own truth and its shipped recording.
mod flight;
mod mechanics;
mod steady;
