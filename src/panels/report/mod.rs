//! What is handed on: report, qualification guide, the next flight, the log.

pub(super) mod contents;
pub(super) mod design;
pub(super) mod enough;
pub(super) mod log;
mod pages;
pub(super) mod qualification;
