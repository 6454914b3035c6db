//! The C337F's instruments.

use std::path::{Path, PathBuf};

use doublet_core::airframe::instruments::Instruments;
use doublet_core::load::instruments;

/// A file of the shipped assets.
pub fn asset(path: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../../assets").join(path)
}

/// The C337F's instrument file.
pub fn c337f() -> Instruments {
    instruments::read(&asset("aircraft/c337f_instruments.toml")).unwrap()
}
