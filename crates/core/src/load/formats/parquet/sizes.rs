//! What a table takes in memory, by what the file states of it: nothing is unpacked.
//!
//! Form: Apache Parquet, `parquet.thrift`, struct `PageHeader`; Apache Thrift, "Thrift Compact protocol encoding".

use parquet::basic::Type;
use parquet::file::metadata::ParquetMetaData;

use crate::load::budget::NUMBER_BYTES;
use crate::load::pieces::Pieces;

/// Deepest nesting of a page header that is followed; the format has two levels.
const MAX_DEPTH: usize = 4;

/// Bytes of a number of a column in memory; none for text, which is not read. Whole numbers stay whole beside a mark for blanks.
pub fn number_bytes(kind: Type) -> Option<u64> {
    match kind {
        Type::FLOAT | Type::DOUBLE => Some(NUMBER_BYTES),
        Type::BOOLEAN | Type::INT32 | Type::INT64 | Type::INT96 => Some(2 * NUMBER_BYTES),
        Type::BYTE_ARRAY | Type::FIXED_LEN_BYTE_ARRAY => None,
    }
}

/// Bytes that the numbers of a table take, with its largest page when unpacked.
pub fn stated_bytes(metadata: &ParquetMetaData, contents: &mut Pieces<'_>) -> u64 {
    let (mut numbers, mut largest) = (0_u64, 0_u64);
    for column in metadata.row_groups().iter().flat_map(|group| group.columns()) {
        let described = column.column_descr();
        let Some(bytes) = number_bytes(column.column_type()).filter(|_| described.max_rep_level() == 0) else {
            continue;
        };
        let count = u64::try_from(column.num_values()).unwrap_or(0);
        numbers = numbers.saturating_add(count.saturating_mul(bytes));
        let start = column.dictionary_page_offset().unwrap_or(column.data_page_offset());
        let place = usize::try_from(start).ok().zip(usize::try_from(column.compressed_size()).ok());
        let chunk = place.and_then(|(start, length)| contents.get(start, length));
        largest = largest.max(largest_page(chunk.unwrap_or_default()));
    }
    numbers.saturating_add(largest)
}

/// Bytes of the largest page of a column when unpacked, as far as its pages follow each other.
fn largest_page(mut chunk: &[u8]) -> u64 {
    let mut largest = 0;
    while let Some(page) = PageSizes::read(&mut chunk) {
        largest = largest.max(page.unpacked);
        let Some(rest) = usize::try_from(page.packed).ok().and_then(|packed| chunk.get(packed..)) else { break };
        chunk = rest;
    }
    largest
}

/// Bytes of a page.
#[derive(Debug, Default, PartialEq)]
struct PageSizes {
    unpacked: u64,
    packed: u64,
}

impl PageSizes {
    /// The sizes in a page header, which is taken from `bytes`; none where there is no header.
    fn read(bytes: &mut &[u8]) -> Option<Self> {
        let (mut sizes, mut field) = (Self::default(), 0);
        if bytes.is_empty() {
            return None;
        }
        while let Some(kind) = field_kind(bytes, &mut field)? {
            match (field, kind) {
                (2, 5) => sizes.unpacked = u64::try_from(signed(bytes)?).ok()?,
                (3, 5) => sizes.packed = u64::try_from(signed(bytes)?).ok()?,
                _ => skip(bytes, kind, 0)?,
            }
        }
        Some(sizes)
    }
}

fn byte(bytes: &mut &[u8]) -> Option<u8> {
    let (first, rest) = bytes.split_first()?;
    *bytes = rest;
    Some(*first)
}

fn varint(bytes: &mut &[u8]) -> Option<u64> {
    let mut value = 0;
    for shift in (0..64).step_by(7) {
        let next = byte(bytes)?;
        value |= u64::from(next & 0x7f) << shift;
        if next & 0x80 == 0 {
            return Some(value);
        }
    }
    None
}

/// A signed number, its sign in the lowest bit.
fn signed(bytes: &mut &[u8]) -> Option<i64> {
    let value = varint(bytes)?;
    Some((value >> 1).cast_signed() ^ -(value & 1).cast_signed())
}

/// Kind of the next field, whose number is `field`; none at the end of the struct.
#[expect(clippy::option_option, reason = "the outer option is the end of the bytes")]
fn field_kind(bytes: &mut &[u8], field: &mut i64) -> Option<Option<u8>> {
    let head = byte(bytes)?;
    if head == 0 {
        return Some(None);
    }
    *field = if head >> 4 == 0 { signed(bytes)? } else { field.checked_add(i64::from(head >> 4))? };
    Some(Some(head & 0xf))
}

/// Takes a value away.
fn skip(bytes: &mut &[u8], kind: u8, depth: usize) -> Option<()> {
    let mut take = |count: usize| bytes.get(count..).map(|rest| *bytes = rest);
    match kind {
        1 | 2 => {}
        3 => take(1)?,
        4..=6 => _ = varint(bytes)?,
        7 => take(8)?,
        8 => {
            let length = usize::try_from(varint(bytes)?).ok()?;
            *bytes = bytes.get(length..)?;
        }
        12 if depth < MAX_DEPTH => {
            let mut field = 0;
            while let Some(kind) = field_kind(bytes, &mut field)? {
                skip(bytes, kind, depth + 1)?;
            }
        }
        // Lists and maps do not occur in a page header.
        _ => return None,
    }
    Some(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sizes_are_read_and_the_rest_of_the_header_is_passed_over() {
        // Fields 1 to 3, the data page header (field 5) with a statistics struct, then the page and another header.
        let header = [0x15, 0x00, 0x15, 0x90, 0x4e, 0x15, 0x08];
        let nested = [0x2c, 0x15, 0x02, 0x15, 0x00, 0x3c, 0x18, 0x02, b'a', b'b', 0x00, 0x00, 0x00];
        let pages = [&header[..], &nested, &[9; 4], &header, &nested, &[9; 4]].concat();
        let mut rest = &pages[..];
        assert_eq!(PageSizes::read(&mut rest), Some(PageSizes { unpacked: 5000, packed: 4 }));
        assert_eq!(rest.len(), pages.len() - header.len() - nested.len());
        assert_eq!(largest_page(&pages), 5000);
        assert_eq!(largest_page(&pages[..pages.len() - 20]), 5000, "cut in the second header");
        assert_eq!(largest_page(&[0x15]), 0);
    }
}
