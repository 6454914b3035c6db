//! The headless workbench: everything between the mathematics and the pixels.
//!
//! A [`session::Session`] is what is saved and undone. [`session::Edit`]s change it, [`undo::History`] remembers it, the stages of
//! [`stage`] compute what follows from it, [`graph`] keeps what they computed under keys of its content, and [`run`] does so in
//! the background and publishes [`snapshot::Snapshot`]s; [`study`] holds what takes longer and is asked for. The command line and the workbench use the same road.

pub mod aircraft;
pub mod autosave;
pub mod batch;
pub mod begin;
pub mod builtin;
pub mod calibrate;
pub mod check;
pub mod compare;
pub mod confidence;
pub mod date;
pub mod document;
pub mod export;
pub mod graph;
pub mod ground_tests;
pub mod keep;
pub mod live;
pub mod notation;
pub mod planning;
pub mod prior;
pub mod qtg;
pub mod recorded_coverage;
pub mod report;
pub mod run;
pub mod session;
pub mod snapshot;
pub mod stage;
pub mod study;
mod toml_file;
pub mod trace;
pub mod undo;
pub mod verdict;
pub mod weigh;

/// Name and version of the program, as everything it writes states them.
pub const PROGRAM: &str = concat!("doublet ", env!("CARGO_PKG_VERSION"));
