//! Tests of the dynamics, in one program: `cargo test -p doublet-dynamics --test dynamics SUBJECT` runs those of one subject.

#[path = "../../../core/tests/common/shared.rs"]
#[allow(clippy::print_stdout, reason = "says why a test is skipped")]
mod shared;

mod aircraft;
mod frequency;
mod modes;
mod pilot;
mod published;
mod qualities;
