//! Raw sensors to clean signals: thesis examples, synthetic truths, the shipped flight.

#![expect(
    clippy::unwrap_used,
    clippy::panic,
    clippy::print_stdout,
    reason = "a test helper that fails is a failed test"
)]

mod air_data;
mod control_surfaces;
mod demo;
mod fuel;
mod held;
mod manoeuvres;
mod noise;
mod steady;
mod support;
