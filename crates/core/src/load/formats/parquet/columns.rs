//! The columns of a table as numbers.

use std::cell::Cell;
use std::panic::AssertUnwindSafe;
use std::path::Path;
use std::sync::Once;

use parquet::basic::{Compression, LogicalType, TimeUnit};
use parquet::column::reader::{ColumnReader, ColumnReaderImpl};
use parquet::data_type::{DataType, Int96};
use parquet::errors::ParquetError;
use parquet::file::metadata::ParquetMetaData;
use parquet::file::reader::{FileReader, SerializedFileReader};
use parquet::schema::types::ColumnDescriptor;

use super::arrow_schema::{self, Field};
use super::sizes::{number_bytes, stated_bytes};
use crate::load::budget::Budget;
use crate::load::contents::{ChannelInfo, Source, one_line};
use crate::load::error::LoadError;
use crate::load::file::stem;
use crate::load::format::Format;
use crate::load::names::stated_unit::split_unit;
use crate::message;
use crate::message::Message;

/// Rows read at a time.
const ROWS_AT_A_TIME: usize = 65_536;

#[derive(Clone, Copy)]
enum Meaning {
    Number,
    /// Ticks of a second, of time stamps or of durations.
    Ticks(i64),
}

/// A column: whole numbers stay whole until the first stamp is subtracted.
enum Values {
    Whole(Vec<Option<i64>>),
    Real(Vec<f64>),
}

thread_local! {
    /// Whether a panic of this thread is one that damage explains.
    static IS_GUARDED: Cell<bool> = const { Cell::new(false) };
}

/// Keeps guarded panics off the terminal: they become an error.
static QUIET: Once = Once::new();

/// Sources of a file, and warnings.
pub fn sources(path: &Path, budget: &Budget<'_>) -> Result<(Vec<Source>, Vec<Message>), LoadError> {
    QUIET.call_once(|| {
        let report = std::panic::take_hook();
        std::panic::set_hook(Box::new(move |panic| {
            if !IS_GUARDED.get() {
                report(panic);
            }
        }));
    });
    IS_GUARDED.set(true);
    // Nothing of the budget is used after a panic.
    let read = std::panic::catch_unwind(AssertUnwindSafe(|| read_table(path, budget)));
    IS_GUARDED.set(false);
    read.unwrap_or_else(|_| {
        let what = "its pages do not match their description".to_owned();
        Err(LoadError::Damaged { path: path.to_owned(), format: Format::Parquet, what })
    })
}

/// Reads the table; the crate panics at some damage.
fn read_table(path: &Path, budget: &Budget<'_>) -> Result<(Vec<Source>, Vec<Message>), LoadError> {
    let damaged = |cause: &dyn std::fmt::Display| LoadError::Damaged {
        path: path.to_owned(),
        format: Format::Parquet,
        what: one_line(&cause.to_string()),
    };
    let pieces = &mut budget.pieces()?;
    let file = std::fs::File::open(path).map_err(|cause| LoadError::Open { path: path.to_owned(), cause })?;
    let file = SerializedFileReader::new(file).map_err(|cause| damaged(&cause))?;
    let metadata = file.metadata().file_metadata();
    check_compression(path, file.metadata())?;
    check_places(file.metadata(), pieces.len() as u64).map_err(|what| damaged(&what))?;
    let written = metadata.key_value_metadata().into_iter().flatten().find(|entry| entry.key == "ARROW:schema");
    let fields = written.and_then(|entry| arrow_schema::fields(entry.value.as_deref()?)).unwrap_or_default();
    let stated = stated_bytes(file.metadata(), pieces);
    pieces.check()?;
    budget.check(stated, || format!("its columns take {} MB", stated / 1_000_000))?;
    let mut source = Source::new(stem(path));
    let mut left_out = Vec::new();
    for (index, column) in metadata.schema_descr().columns().iter().enumerate() {
        let name = column.path().string();
        let field = fields.iter().find(|field| field.name == name);
        if column.max_rep_level() > 0 {
            left_out.push(name);
            continue;
        }
        let mut values = None;
        for group in 0..file.num_row_groups() {
            let group = file.get_row_group(group).map_err(|cause| damaged(&cause))?;
            let reader = group.get_column_reader(index).map_err(|cause| damaged(&cause))?;
            read_column(reader, column.max_def_level(), &mut values, budget, &name)?
                .map_err(|cause| damaged(&format!("column '{name}': {cause}")))?;
        }
        match values {
            Some(values) => source.channels.push(channel(name, meaning(column, field), field, values)),
            None => left_out.push(name),
        }
    }
    let mut warnings = Vec::new();
    if !left_out.is_empty() {
        warnings.push(message!("columns of text or lists are left out: {}", left_out.join(", ")));
    }
    Ok((vec![source], warnings))
}

/// Refuses a way of compression that is legal and not read.
fn check_compression(path: &Path, metadata: &ParquetMetaData) -> Result<(), LoadError> {
    let mut compressions =
        metadata.row_groups().iter().flat_map(|group| group.columns()).map(|column| column.compression());
    let unread = |compression: &Compression| matches!(compression, Compression::BROTLI(_) | Compression::LZO);
    compressions.find(unread).map_or(Ok(()), |compression| {
        let name = if compression == Compression::LZO { "LZO" } else { "Brotli" };
        let (path, what) = (path.to_owned(), format!("{name} compression of Parquet"));
        Err(LoadError::Unsupported { path, what, fix: "write the file with zstd or snappy" })
    })
}

/// Refuses columns that do not lie in the file: the reader takes their places for granted.
fn check_places(metadata: &ParquetMetaData, length: u64) -> Result<(), String> {
    for column in metadata.row_groups().iter().flat_map(|group| group.columns()) {
        let start = column.dictionary_page_offset().unwrap_or(column.data_page_offset());
        let end = start.checked_add(column.compressed_size());
        let lies_inside =
            end.is_some_and(|end| start >= 0 && column.data_page_offset() >= 0 && start <= end && end as u64 <= length);
        if !lies_inside {
            return Err(format!("column '{}' is not inside the file", column.column_path().string()));
        }
    }
    Ok(())
}

/// What the numbers of a column mean, by the table's own type or by that of Arrow.
fn meaning(column: &ColumnDescriptor, field: Option<&Field>) -> Meaning {
    match column.logical_type_ref() {
        Some(LogicalType::Timestamp(time) | LogicalType::Time(time)) => ticks(&time.unit),
        _ => field.and_then(|field| field.ticks).map_or(Meaning::Number, Meaning::Ticks),
    }
}

fn ticks(unit: &TimeUnit) -> Meaning {
    match unit {
        TimeUnit::MILLIS => Meaning::Ticks(1000),
        TimeUnit::MICROS => Meaning::Ticks(1_000_000),
        TimeUnit::NANOS => Meaning::Ticks(1_000_000_000),
    }
}

fn channel(name: String, meaning: Meaning, field: Option<&Field>, values: Values) -> ChannelInfo {
    let unit = field.and_then(|field| field.unit.clone()).or_else(|| split_unit(&name).1);
    match (values, meaning) {
        (Values::Real(values), _) => ChannelInfo::new(name, unit, values),
        (Values::Whole(values), Meaning::Number) => {
            let values = values.into_iter().map(|value| value.map_or(f64::NAN, |value| value as f64)).collect();
            ChannelInfo::new(name, unit, values)
        }
        (Values::Whole(values), Meaning::Ticks(ticks)) => {
            let first = values.iter().flatten().next().copied().unwrap_or(0);
            // A table has one clock: what counts from its first stamp is in step with everything in it.
            let since =
                |value: Option<i64>| value.map_or(f64::NAN, |value| value.wrapping_sub(first) as f64 / ticks as f64);
            let mut channel = ChannelInfo::new(name, Some("s".to_owned()), values.into_iter().map(since).collect());
            channel.is_time_of_day = true;
            channel
        }
    }
}

/// Adds the rows of one group to a column; text leaves it `None`.
fn read_column(
    reader: ColumnReader,
    levels: i16,
    values: &mut Option<Values>,
    budget: &Budget<'_>,
    name: &str,
) -> Result<Result<(), ParquetError>, LoadError> {
    let mut add = |rows: Vec<Option<i64>>| match values.get_or_insert_with(|| Values::Whole(Vec::new())) {
        Values::Whole(values) => values.extend(rows),
        Values::Real(_) => {}
    };
    match reader {
        ColumnReader::BoolColumnReader(reader) => read(reader, levels, budget, name, |rows| {
            add(rows.iter().map(|row| row.map(i64::from)).collect());
        }),
        ColumnReader::Int32ColumnReader(reader) => read(reader, levels, budget, name, |rows| {
            add(rows.iter().map(|row| row.map(i64::from)).collect());
        }),
        ColumnReader::Int64ColumnReader(reader) => read(reader, levels, budget, name, |rows| add(rows.to_vec())),
        ColumnReader::Int96ColumnReader(reader) => read(reader, levels, budget, name, |rows: &[Option<Int96>]| {
            add(rows.iter().map(|row| row.map(|stamp| stamp.to_nanos())).collect());
        }),
        ColumnReader::FloatColumnReader(reader) => read(reader, levels, budget, name, |rows| {
            real(values, rows.iter().map(|row| row.map_or(f64::NAN, f64::from)));
        }),
        ColumnReader::DoubleColumnReader(reader) => read(reader, levels, budget, name, |rows| {
            real(values, rows.iter().map(|row| row.unwrap_or(f64::NAN)));
        }),
        ColumnReader::ByteArrayColumnReader(_) | ColumnReader::FixedLenByteArrayColumnReader(_) => Ok(Ok(())),
    }
}

fn real(values: &mut Option<Values>, rows: impl Iterator<Item = f64>) {
    if let Values::Real(values) = values.get_or_insert_with(|| Values::Real(Vec::new())) {
        values.extend(rows);
    }
}

/// Reads the rows of a group, blank ones as `None`.
fn read<T: DataType>(
    mut reader: ColumnReaderImpl<T>,
    levels: i16,
    budget: &Budget<'_>,
    name: &str,
    mut add: impl FnMut(&[Option<T::T>]),
) -> Result<Result<(), ParquetError>, LoadError>
where
    T::T: Copy,
{
    let (mut values, mut defined, mut rows) = (Vec::new(), Vec::new(), Vec::new());
    loop {
        values.clear();
        defined.clear();
        rows.clear();
        let count = match reader.read_records(ROWS_AT_A_TIME, (levels > 0).then_some(&mut defined), None, &mut values) {
            Ok((0, ..)) => return Ok(Ok(())),
            Ok((count, ..)) => count,
            Err(cause) => return Ok(Err(cause)),
        };
        let bytes = number_bytes(T::get_physical_type()).unwrap_or_default();
        budget.take(count as u64 * bytes, || format!("column '{name}'"))?;
        if levels == 0 {
            rows.extend(values.iter().copied().map(Some));
        } else {
            let mut filled = values.iter().copied();
            rows.extend(defined.iter().map(|&level| if level == levels { filled.next() } else { None }));
        }
        add(&rows);
    }
}
