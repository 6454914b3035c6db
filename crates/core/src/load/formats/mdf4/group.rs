//! Channels and groups of a file: how the numbers of a record become quantities.

use super::block::{Block, u16_at, u64_at};
use crate::load::budget::NUMBER_BYTES;
use crate::load::pieces::Pieces;

/// Kinds of a channel: time, and time that is computed from the number of the record.
const MASTER: u8 = 2;
pub(super) const VIRTUAL_MASTER: u8 = 3;
pub(super) const VIRTUAL_DATA: u8 = 6;
/// Bytes of a conversion that are looked at: its head and as many numbers as its count can state.
const MOST_CONVERSION: usize = 24 + 8 * 65_535;

/// From the number as stored to the quantity.
pub(super) enum Conversion {
    None,
    Linear(f64, f64),
    Rational([f64; 6]),
    /// Pairs of a key and its value, with what lies between them interpolated or taken from the nearest.
    Table {
        pairs: Vec<[f64; 2]>,
        is_interpolated: bool,
    },
    /// Lower and upper end of a range and its value, and the value outside all of them.
    Ranges(Vec<[f64; 3]>, f64),
}

impl Conversion {
    /// The conversion of a channel; why there is none where it is of another kind.
    pub(super) fn from_block(file: &mut Pieces<'_>, block: Option<Block>) -> Result<Self, &'static str> {
        let Some(block) = block else { return Ok(Self::None) };
        let data = file.get(block.data_at, block.data_bytes.min(MOST_CONVERSION)).unwrap_or_default();
        let (kind, count) = (data.first().copied().unwrap_or(0), u16_at(data, 6).unwrap_or(0));
        let value = |index: usize| Some(f64::from_bits(u64_at(data, 24 + 8 * index)?));
        let values: Vec<f64> = (0..usize::from(count)).map_while(value).collect();
        match (kind, &values[..]) {
            (0, _) => Ok(Self::None),
            (1, [offset, factor, ..]) => Ok(Self::Linear(*offset, *factor)),
            (2, [a, b, c, d, e, f, ..]) => Ok(Self::Rational([*a, *b, *c, *d, *e, *f])),
            (4 | 5, values) => {
                Ok(Self::Table { pairs: values.as_chunks::<2>().0.to_vec(), is_interpolated: kind == 4 })
            }
            (6, values) => {
                let (ranges, rest) = values.as_chunks::<3>();
                Ok(Self::Ranges(ranges.to_vec(), rest.first().copied().unwrap_or(f64::NAN)))
            }
            (3, _) => Err("its conversion is a formula"),
            (7.., _) => Err("its values are codes of texts"),
            _ => Err("its conversion is incomplete"),
        }
    }

    fn apply(&self, x: f64) -> f64 {
        match self {
            Self::None => x,
            Self::Linear(offset, factor) => offset + factor * x,
            Self::Rational([a, b, c, d, e, f]) => (a * x * x + b * x + c) / (d * x * x + e * x + f),
            Self::Table { pairs, is_interpolated } => table(pairs, *is_interpolated, x),
            Self::Ranges(ranges, otherwise) => {
                let found = ranges.iter().find(|[low, high, _]| *low <= x && x <= *high);
                found.map_or(*otherwise, |[.., value]| *value)
            }
        }
    }
}

/// Value of a table at `x`; its end values outside.
fn table(pairs: &[[f64; 2]], is_interpolated: bool, x: f64) -> f64 {
    let above = pairs.partition_point(|[key, _]| *key < x);
    match (above.checked_sub(1).and_then(|below| pairs.get(below)), pairs.get(above)) {
        (Some([x0, y0]), Some([x1, y1])) if is_interpolated => y0 + (y1 - y0) * (x - x0) / (x1 - x0),
        (Some([x0, y0]), Some([x1, y1])) => {
            if x - x0 < x1 - x {
                *y0
            } else {
                *y1
            }
        }
        (Some([_, value]), None) | (None, Some([_, value])) => *value,
        (None, None) => f64::NAN,
    }
}

/// Where and how a channel stands in a record.
pub(super) struct Field {
    pub(super) name: String,
    pub(super) unit: Option<String>,
    pub(super) kind: u8,
    pub(super) data_type: u8,
    pub(super) bit_offset: u32,
    pub(super) byte_offset: usize,
    pub(super) bits: u32,
    /// Bit that says a sample is invalid, counted from the first byte behind the data.
    pub(super) invalid_bit: Option<usize>,
    pub(super) conversion: Conversion,
}

impl Field {
    /// Bytes in memory.
    pub(super) fn bytes(&self) -> u64 {
        let text = self.name.len() + self.unit.as_ref().map_or(0, String::len);
        let table = match &self.conversion {
            Conversion::Table { pairs, .. } => size_of_val(&pairs[..]),
            Conversion::Ranges(ranges, _) => size_of_val(&ranges[..]),
            _ => 0,
        };
        (size_of::<Self>() + text + table) as u64
    }

    pub(super) fn is_master(&self) -> bool {
        self.kind == MASTER || self.kind == VIRTUAL_MASTER
    }

    /// The quantity in the record with the given number.
    pub(super) fn value(&self, record: &[u8], data_bytes: usize, number: usize) -> f64 {
        if self.kind == VIRTUAL_MASTER || self.kind == VIRTUAL_DATA {
            return self.conversion.apply(number as f64);
        }
        let is_invalid = self
            .invalid_bit
            .is_some_and(|bit| record.get(data_bytes + bit / 8).is_some_and(|byte| byte >> (bit % 8) & 1 == 1));
        match self.stored(record).filter(|_| !is_invalid) {
            Some(stored) => self.conversion.apply(stored),
            None => f64::NAN,
        }
    }

    fn stored(&self, record: &[u8]) -> Option<f64> {
        let count = (self.bit_offset + self.bits).div_ceil(8) as usize;
        let bytes = record.get(self.byte_offset..self.byte_offset.checked_add(count)?)?;
        match (self.data_type, self.bits, self.bit_offset) {
            (4, 64, 0) => return Some(f64::from_le_bytes(*bytes.first_chunk()?)),
            (4, 32, 0) => return Some(f64::from(f32::from_le_bytes(*bytes.first_chunk()?))),
            _ => {}
        }
        // Types come in pairs: little-endian first.
        let mut wide = [0; 16];
        for (place, byte) in wide.iter_mut().zip(0..count) {
            *place = if self.data_type.is_multiple_of(2) { bytes[byte] } else { bytes[count - 1 - byte] };
        }
        let mask = (1_u128 << self.bits) - 1;
        let raw = (u128::from_le_bytes(wide) >> self.bit_offset & mask) as u64;
        Some(match (self.data_type, self.bits) {
            (0 | 1, _) => raw as f64,
            (2 | 3, _) => ((raw << (64 - self.bits)) as i64 >> (64 - self.bits)) as f64,
            (4 | 5, 32) => f64::from(f32::from_bits(raw as u32)),
            (4 | 5, 64) => f64::from_bits(raw),
            _ => return None,
        })
    }
}

/// A channel group: its fields and the length of its records.
pub(super) struct Group {
    pub(super) name: String,
    pub(super) id: u64,
    pub(super) fields: Vec<Field>,
    pub(super) data_bytes: usize,
    pub(super) record_bytes: usize,
    pub(super) is_variable: bool,
    /// Number of its records, as the file states it.
    pub(super) stated_records: u64,
}

/// Channel groups of common records, and the blocks that hold these.
pub(super) struct DataGroup {
    /// Bytes of the number of the group before each record.
    pub(super) id_bytes: usize,
    pub(super) groups: Vec<Group>,
    pub(super) blocks: Vec<DataBlock>,
}

/// A block of records: its place, the bytes of its records and whether they are compressed.
#[derive(Clone, Copy)]
pub(super) struct DataBlock {
    pub(super) place: u64,
    pub(super) bytes: u64,
    pub(super) is_compressed: bool,
}

impl DataGroup {
    /// Bytes in memory of the largest compressed block and of the numbers, by what the file states of them.
    pub(super) fn stated_bytes(&self) -> u64 {
        let bytes = self.blocks.iter().map(|block| block.bytes).fold(0, u64::saturating_add);
        let compressed = self.blocks.iter().filter(|block| block.is_compressed).map(|block| block.bytes);
        let numbers = |group: &Group| {
            let record = (self.id_bytes + group.record_bytes).max(1) as u64;
            let records = if self.id_bytes > 0 { group.stated_records.min(bytes / record) } else { bytes / record };
            records.saturating_mul(NUMBER_BYTES * group.fields.len() as u64)
        };
        self.groups.iter().map(numbers).fold(compressed.max().unwrap_or(0), u64::saturating_add)
    }
}
