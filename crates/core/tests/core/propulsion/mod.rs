//! Engine chart, propeller map, powerplant, engine comparison and Digital DATCOM against published numbers.

#![expect(clippy::unwrap_used, reason = "a test helper that fails is a failed test")]

mod comparison;
mod datcom;
mod maps;
mod support;
mod tables;
