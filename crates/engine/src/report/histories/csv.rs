//! One history as comma-separated values: names, units, then one row per sample.

use std::path::Path;

use super::History;
use crate::report::{ReportError, file_error};

/// Writes the file; a value that does not exist is empty.
pub fn write(history: &History<'_>, path: &Path) -> Result<(), ReportError> {
    let failed = |error: csv::Error| file_error(path)(error.into());
    let mut writer = csv::Writer::from_path(path).map_err(failed)?;
    let names = history.columns.iter().map(|column| column.path.as_str());
    writer.write_record(std::iter::once("time").chain(names)).map_err(failed)?;
    let units = history.columns.iter().map(|column| column.unit.as_str());
    writer.write_record(std::iter::once("s").chain(units)).map_err(failed)?;
    let mut text = String::new();
    for (row, time_s) in history.time_s.iter().enumerate() {
        for value in std::iter::once(*time_s).chain(history.columns.iter().filter_map(|column| column.values.get(row)))
        {
            text.clear();
            if value.is_finite() {
                use std::fmt::Write;
                // Writing to a string cannot fail.
                let _ = write!(text, "{value}");
            }
            writer.write_field(&text).map_err(failed)?;
        }
        writer.write_record(None::<&[u8]>).map_err(failed)?;
    }
    writer.flush().map_err(file_error(path))
}
