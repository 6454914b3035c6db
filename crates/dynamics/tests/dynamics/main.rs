//! Tests of the dynamics, in one program: `cargo test -p doublet-dynamics --test dynamics SUBJECT` runs those of one subject.

#![allow(clippy::panic, clippy::print_stdout, clippy::unwrap_used, reason = "helpers of tests are not marked as tests")]

#[path = "../../../core/tests/common/shared.rs"]
mod shared;

mod aircraft;
mod cr_2144;
mod frequency;
mod modes;
mod pilot;
mod published;
mod qualities;
