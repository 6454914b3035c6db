//! One history as a Parquet file; the metadata `unit:<column>` and `description:<column>` explain each column.

use std::path::Path;
use std::sync::Arc;

use parquet::basic::{Repetition, Type as Physical};
use parquet::data_type::DoubleType;
use parquet::errors::ParquetError;
use parquet::file::metadata::KeyValue;
use parquet::file::properties::WriterProperties;
use parquet::file::writer::SerializedFileWriter;
use parquet::schema::types::Type;

use super::{History, HistoryColumn};
use crate::report::{ReportError, file_error};

/// Writes the file; a value that does not exist is not a number.
pub fn write(history: &History<'_>, path: &Path) -> Result<(), ReportError> {
    let file = std::fs::File::create(path).map_err(file_error(path))?;
    written(history, file)
        .map_err(|error| ReportError::Form { what: "a Parquet file", reason: format!("{}: {error}", path.display()) })
}

fn written(history: &History<'_>, file: std::fs::File) -> Result<(), ParquetError> {
    let time = HistoryColumn::new("time".to_owned(), "s", "time", &history.time_s);
    let columns = || std::iter::once(&time).chain(&history.columns);
    let name = |column: &HistoryColumn<'_>| column.path.replace(['/', '.'], "_");
    let field = |column| {
        let name = name(column);
        let field = Type::primitive_type_builder(&name, Physical::DOUBLE);
        field.with_repetition(Repetition::REQUIRED).build().map(Arc::new)
    };
    let fields = columns().map(field).collect::<Result<Vec<_>, _>>()?;
    let schema = Type::group_type_builder("history").with_fields(fields).build()?;
    let mut metadata = vec![KeyValue::new("history".to_owned(), format!("{} {}", history.group, history.kind))];
    for column in columns() {
        metadata.push(KeyValue::new(format!("unit:{}", name(column)), column.unit.clone()));
        metadata.push(KeyValue::new(format!("description:{}", name(column)), column.description.clone()));
    }
    let properties = WriterProperties::builder()
        .set_dictionary_enabled(false)
        .set_created_by(crate::PROGRAM.to_owned())
        .set_key_value_metadata(Some(metadata))
        .build();
    let mut writer = SerializedFileWriter::new(file, Arc::new(schema), Arc::new(properties))?;
    let mut group = writer.next_row_group()?;
    for column in columns() {
        let Some(mut place) = group.next_column()? else { break };
        place.typed::<DoubleType>().write_batch(&column.values.all(), None, None)?;
        place.close()?;
    }
    group.close()?;
    writer.close()?;
    Ok(())
}
