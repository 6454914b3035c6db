//! Numbers of HDF5 data sets as f64, whatever numeric type they are stored in.

use std::sync::Arc;

use hdf5_reader::{Dataset, Datatype};

use crate::load::formats::mat_contents::MAX_COLUMNS;

/// One column of a data set: where its number sits in an element and which type it has.
pub(crate) struct Column {
    /// Suffix to the data set's name: empty, `[i]` or `.field`.
    pub suffix: String,
    /// Element index of the first sample, and steps to the next.
    first: usize,
    step: usize,
    /// Byte offset in the element.
    offset: usize,
    number: Number,
}

impl Column {
    /// Bytes of one of its numbers.
    pub(crate) fn size(&self) -> usize {
        self.number.size()
    }
}

/// A numeric type of native byte order.
#[derive(Clone, Copy)]
enum Number {
    Signed(usize),
    Unsigned(usize),
    Float(usize),
}

impl Number {
    /// The type of `datatype`, if it is a number; enumerations (booleans among them) count by their value.
    fn from_datatype(datatype: &Datatype) -> Option<Self> {
        match datatype {
            Datatype::FixedPoint { size, signed: true, .. } => Some(Self::Signed(*size as usize)),
            Datatype::FixedPoint { size, .. } | Datatype::Bitfield { size, .. } => Some(Self::Unsigned(*size as usize)),
            Datatype::FloatingPoint { size, .. } => Some(Self::Float(*size as usize)),
            Datatype::Enum { base, .. } => Self::from_datatype(base),
            _ => None,
        }
        .filter(|number| {
            matches!(number, Self::Signed(1 | 2 | 4 | 8) | Self::Unsigned(1 | 2 | 4 | 8) | Self::Float(4 | 8))
        })
    }

    fn size(self) -> usize {
        match self {
            Self::Signed(size) | Self::Unsigned(size) | Self::Float(size) => size,
        }
    }

    /// The number at the start of `bytes`; NaN where they end before it does.
    fn read(self, bytes: &[u8]) -> f64 {
        macro_rules! native {
            ($type:ty) => {
                bytes.first_chunk().map_or(f64::NAN, |bytes| <$type>::from_ne_bytes(*bytes) as f64)
            };
        }
        match self {
            Self::Signed(1) => native!(i8),
            Self::Signed(2) => native!(i16),
            Self::Signed(4) => native!(i32),
            Self::Signed(_) => native!(i64),
            Self::Unsigned(1) => native!(u8),
            Self::Unsigned(2) => native!(u16),
            Self::Unsigned(4) => native!(u32),
            Self::Unsigned(_) => native!(u64),
            Self::Float(4) => native!(f32),
            Self::Float(_) => native!(f64),
        }
    }
}

/// What a data set is to a loader.
pub(crate) enum Layout {
    /// Channels with this many samples each.
    Columns(usize, Vec<Column>),
    Text,
    /// Something that is no channel, with its reason.
    Other(&'static str),
}

/// The channels of a data set, from its shape and type alone: time runs along the longer side.
///
/// `by_rows` settles a square one: MATLAB stores matrices transposed, so that its columns are rows here.
pub(crate) fn layout(dataset: &Dataset, by_rows: bool) -> Layout {
    let shape: Vec<usize> = dataset.shape().iter().map(|&side| usize::try_from(side).unwrap_or(usize::MAX)).collect();
    let (samples, count, across) = match shape[..] {
        [] => (1, 1, true),
        [samples] | [samples, 1] | [1, samples] => (samples, 1, true),
        [rows, columns] if rows > columns || (rows == columns && !by_rows) => (rows, columns, true),
        [rows, columns] => (columns, rows, false),
        _ => return Layout::Other("of more than two dimensions"),
    };
    if samples == 0 {
        return Layout::Other("empty");
    }
    if count > MAX_COLUMNS {
        return Layout::Other("too wide for a set of channels");
    }
    let suffix = |index: usize| if count == 1 { String::new() } else { format!("[{index}]") };
    // A shape may claim anything: what is more than the file can hold is refused before a place is used.
    let place = |index: usize| if across { (index, count) } else { (index.saturating_mul(samples), 1) };
    match dataset.dtype() {
        Datatype::String { .. } | Datatype::VarLen { .. } => Layout::Text,
        Datatype::Compound { fields, .. } => {
            let mut columns = Vec::new();
            for field in fields.iter().filter(|_| count == 1) {
                let offset = field.byte_offset as usize;
                let column = |suffix, offset, number| Column { suffix, first: 0, step: 1, offset, number };
                match (Number::from_datatype(&field.datatype), &field.datatype) {
                    (Some(number), _) => columns.push(column(format!(".{}", field.name), offset, number)),
                    (None, Datatype::Array { base, dims }) if dims.len() == 1 && dims[0] <= MAX_COLUMNS as u64 => {
                        let Some(number) = Number::from_datatype(base) else { continue };
                        let element = |index: usize| offset + index * number.size();
                        let name = |index: usize| format!(".{}[{index}]", field.name);
                        columns.extend((0..dims[0] as usize).map(|index| column(name(index), element(index), number)));
                    }
                    _ => {}
                }
            }
            Layout::Columns(samples, columns)
        }
        other => match Number::from_datatype(other) {
            Some(number) => {
                let column = |index: usize| {
                    let (first, step) = place(index);
                    Column { suffix: suffix(index), first, step, offset: 0, number }
                };
                Layout::Columns(samples, (0..count).map(column).collect())
            }
            None => Layout::Other("of a type that is not a number"),
        },
    }
}

/// Reads the data set and gives its columns.
pub(crate) fn read(
    dataset: &Dataset,
    samples: usize,
    columns: &[Column],
) -> hdf5_reader::error::Result<Vec<Arc<[f64]>>> {
    let plain_f64 = matches!(dataset.dtype(), Datatype::FloatingPoint { size: 8, .. });
    if plain_f64 {
        let (values, offset) = dataset.read_array_parallel::<f64>()?.into_raw_vec_and_offset();
        if let ([_], None | Some(0)) = (columns, offset) {
            return Ok(vec![values.into()]);
        }
        let pick = |column: &Column| {
            let at = (0..samples).map(|sample| column.first + sample * column.step);
            at.map(|at| values.get(at).copied().unwrap_or(f64::NAN)).collect()
        };
        return Ok(columns.iter().map(pick).collect());
    }
    let bytes = dataset.read_native_bytes()?;
    let element = dataset.raw_element_size()?;
    let pick = |column: &Column| {
        let at = (0..samples).map(|sample| (column.first + sample * column.step) * element + column.offset);
        at.map(|at| column.number.read(bytes.get(at..).unwrap_or(&[]))).collect()
    };
    Ok(columns.iter().map(pick).collect())
}
