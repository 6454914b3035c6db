//! Time histories as one HDF5 file, every data set with its unit.

use std::path::Path;

use hdf5_writer::{AttributeBuilder, DatasetBuilder, Hdf5Builder, Hdf5Writer, WriteOptions};

use super::History;
use crate::report::{ReportError, file_error};

/// Writes all histories; each data set has the attributes `units` and `description`.
pub fn write(histories: &[History<'_>], title: &str, path: &Path) -> Result<(), ReportError> {
    let formed = |error: &dyn std::fmt::Display| ReportError::Form { what: "histories.h5", reason: error.to_string() };
    let mut builder = Hdf5Builder::new()
        .attribute(AttributeBuilder::fixed_string("title", if title.is_empty() { "-" } else { title }))
        .attribute(AttributeBuilder::fixed_string("app", concat!("doublet ", env!("CARGO_PKG_VERSION"))));
    let mut put = |path: String, unit: &str, description: &str, values: &[f64]| {
        let data_set = DatasetBuilder::typed_data(path.clone(), vec![values.len() as u64], values)
            .map_err(|error| formed(&format!("{path}: {error}")))?
            .attribute(AttributeBuilder::fixed_string("units", unit))
            .attribute(AttributeBuilder::fixed_string("description", description));
        builder = std::mem::take(&mut builder).dataset(data_set);
        Ok::<(), ReportError>(())
    };
    for history in histories {
        for time in &history.time_paths {
            put(format!("{}/{time}", history.group), "s", "time", &history.time_s)?;
        }
        for column in &history.columns {
            put(format!("{}/{}", history.group, column.path), &column.unit, &column.description, &column.values)?;
        }
    }
    let plan = builder.into_plan().map_err(|error| formed(&error))?;
    let file = std::fs::File::create(path).map_err(file_error(path))?;
    Hdf5Writer::new(std::io::BufWriter::new(file), WriteOptions::default())
        .finish(plan)
        .map_err(|error| formed(&error))?;
    Ok(())
}
