//! Recordings and data files: probe -> plan -> read.

pub mod propulsion_maps;
