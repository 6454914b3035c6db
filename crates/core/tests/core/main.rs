//! Tests of the numerics, in one program: `cargo test -p doublet-core --test core SUBJECT` runs those of one subject.

#![allow(clippy::panic, clippy::print_stdout, clippy::unwrap_used, reason = "helpers of tests are not marked as tests")]

#[path = "../common/flight.rs"]
mod flight;
#[path = "../common/mavlink.rs"]
mod mavlink;
#[path = "../common/shared.rs"]
mod shared;

mod airframe;
mod align;
mod compatibility;
mod estimate;
mod load;
mod model;
mod propulsion;
mod reconstruct;
mod replay;
mod sensitivity;
mod signals;
mod simulate;
