//! TOML files that state their format and version.

use std::fmt::Display;
use std::path::Path;

use doublet_core::load::read_text;
use doublet_core::toml_error;
use serde::de::DeserializeOwned;

/// Reads a file by `parse`; an error names the file.
pub(crate) fn open<T, E: Display>(path: &Path, parse: impl FnOnce(&str) -> Result<T, E>) -> Result<T, String> {
    let named = |error: &dyn Display| format!("{}: {error}", path.display());
    let text = read_text(path).map_err(|error| named(&error))?;
    parse(&text).map_err(|error| named(&error))
}

/// Reads the text of a file of a format and version; `stated` are those that it has.
pub(crate) fn parse<T: DeserializeOwned>(
    text: &str,
    (format, version): (&str, u32),
    stated: impl FnOnce(&T) -> (&str, u32),
) -> Result<T, String> {
    let file: T = toml::from_str(text).map_err(|error| toml_error::one_line(text, &error))?;
    let (own_format, own_version) = stated(&file);
    if (own_format, own_version) != (format, version) {
        return Err(format!("format '{own_format}' version {own_version} is not '{format}' version {version}"));
    }
    Ok(file)
}
