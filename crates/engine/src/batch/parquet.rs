//! The table of a batch as Parquet.

use std::sync::Arc;

use parquet::basic::{LogicalType, Repetition, Type as Physical};
use parquet::data_type::{ByteArray, ByteArrayType, DoubleType, Int64Type};
use parquet::errors::ParquetError;
use parquet::file::properties::WriterProperties;
use parquet::file::writer::{SerializedFileWriter, SerializedRowGroupWriter};
use parquet::schema::types::Type;

use super::table::Column;

impl Column {
    fn field(&self, name: &str) -> Result<Type, ParquetError> {
        let (physical, logical) = match self {
            Self::Text(_) => (Physical::BYTE_ARRAY, Some(LogicalType::String)),
            Self::Number(_) => (Physical::DOUBLE, None),
            Self::Count(_) => (Physical::INT64, None),
        };
        let field = Type::primitive_type_builder(name, physical).with_logical_type(logical);
        field.with_repetition(Repetition::OPTIONAL).build()
    }

    /// Definition levels: one where there is a value.
    fn levels<T>(values: &[Option<T>]) -> Vec<i16> {
        values.iter().map(|value| i16::from(value.is_some())).collect()
    }

    fn write(&self, group: &mut SerializedRowGroupWriter<'_, &mut Vec<u8>>) -> Result<(), ParquetError> {
        let Some(mut place) = group.next_column()? else { return Ok(()) };
        match self {
            Self::Text(values) => {
                let present: Vec<ByteArray> = values.iter().flatten().map(|text| text.as_str().into()).collect();
                place.typed::<ByteArrayType>().write_batch(&present, Some(&Self::levels(values)), None)?;
            }
            Self::Number(values) => {
                let present: Vec<f64> = values.iter().flatten().copied().collect();
                place.typed::<DoubleType>().write_batch(&present, Some(&Self::levels(values)), None)?;
            }
            Self::Count(values) => {
                let present: Vec<i64> = values.iter().flatten().copied().collect();
                place.typed::<Int64Type>().write_batch(&present, Some(&Self::levels(values)), None)?;
            }
        }
        place.close()
    }
}

/// The whole file.
pub(super) fn parquet(columns: &[(String, Column)]) -> Result<Vec<u8>, ParquetError> {
    let fields = columns.iter().map(|(name, column)| column.field(name).map(Arc::new)).collect::<Result<_, _>>()?;
    let schema = Type::group_type_builder("batch").with_fields(fields).build()?;
    let created_by = crate::PROGRAM.to_owned();
    let properties = WriterProperties::builder().set_created_by(created_by).build();
    let mut bytes = Vec::new();
    let mut writer = SerializedFileWriter::new(&mut bytes, Arc::new(schema), Arc::new(properties))?;
    let mut group = writer.next_row_group()?;
    for (_, column) in columns {
        column.write(&mut group)?;
    }
    group.close()?;
    writer.close()?;
    Ok(bytes)
}
