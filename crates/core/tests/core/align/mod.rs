//! Clocks recovered from synthetic recordings.

mod clocks;
mod onset;
mod support;
