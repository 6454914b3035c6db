//! The airframe against the thesis's tables, against independent computations, and against impossible data.

#![allow(
    clippy::unwrap_used,
    clippy::panic,
    clippy::print_stdout,
    reason = "helpers of tests fail by panicking and say what they skip"
)]

mod check;
mod envelope;
mod files;
mod geometry;
mod history;
mod inertia;
mod mass;
mod support;
mod weighing;
