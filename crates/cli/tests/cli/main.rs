//! Tests of the command line, in one program: `cargo test -p doublet-cli --test cli SUBJECT` runs those of one subject.

#![allow(
    clippy::expect_used,
    clippy::panic,
    clippy::print_stdout,
    clippy::unwrap_used,
    reason = "helpers of tests are not marked as tests"
)]

#[path = "../../../core/tests/common/shared.rs"]
mod shared;

mod common;

mod batch;
mod campaign;
mod chain;
mod check;
mod design;
mod dynamics;
mod end_to_end;
mod exports;
mod faults;
mod folders;
mod guess;
mod hostile_files;
mod inertial_only;
mod live;
mod manual;
mod nameless;
mod propose;
mod propulsion;
mod qtg;
mod recognition;
mod regress;
mod report;
mod response;
mod schema;
mod sensors;
mod surface;
mod windows;
