//! Where a command writes.

use std::path::{Path, PathBuf};

use clap::builder::{PathBufValueParser, TypedValueParser};

/// Reads the name of a file or folder to write; `-`, which other programs take for the standard output, is none.
pub fn output_path() -> impl TypedValueParser<Value = PathBuf> {
    PathBufValueParser::new().try_map(|path| match path == Path::new("-") {
        true => Err("name a file or folder; one called '-' is './-'"),
        false => Ok(path),
    })
}
