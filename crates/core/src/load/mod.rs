//! Recordings and data files: probe -> plan -> read.
