//! Least squares against published answers, and the properties every estimate keeps.

#[path = "../common/shared.rs"]
mod shared;

mod attas_table;
mod coloured;
mod properties;
