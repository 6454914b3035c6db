//! Frequency responses and low-order equivalent systems against systems whose answers are exact.
#![allow(clippy::print_stdout, clippy::unwrap_used, reason = "a test helper that fails is a failed test")]

mod equivalent;
mod signals;
mod spectra;
