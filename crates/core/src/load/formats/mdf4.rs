//! ASAM MDF 4 files: a source per channel group, times in seconds since the start of the measurement.
//!
//! Form: ASAM MDF 4.1, "Measurement Data Format", block descriptions.

use std::collections::HashSet;
use std::io::Read;
use std::path::Path;

use crate::load::budget::Budget;
use crate::load::contents::{ChannelInfo, Source, one_line};
use crate::load::error::LoadError;
use crate::load::format::Format;

/// First bytes of a file that its recorder did not close.
const UNFINISHED: &[u8] = b"UnFinMF ";
/// Place of the header block, and bytes of a block before its links.
const HEADER: usize = 64;
const BLOCK_HEAD: usize = 24;
/// Groups of a file and channels of a group at most.
const MOST_GROUPS: usize = 10_000;
const MOST_CHANNELS: usize = 100_000;
/// Kinds of a channel: time, and time that is computed from the number of the record.
const MASTER: u8 = 2;
const VIRTUAL_MASTER: u8 = 3;
const VIRTUAL_DATA: u8 = 6;
/// Flag of a group whose records have a length of their own.
const VARIABLE_LENGTH: u16 = 1;

/// A block: its four letters, links and data.
#[derive(Clone, Copy)]
struct Block<'a> {
    id: &'a [u8],
    links: &'a [u8],
    data: &'a [u8],
}

fn u64_at(bytes: &[u8], at: usize) -> Option<u64> {
    Some(u64::from_le_bytes(*bytes.get(at..)?.first_chunk()?))
}

fn u32_at(bytes: &[u8], at: usize) -> Option<u32> {
    Some(u32::from_le_bytes(*bytes.get(at..)?.first_chunk()?))
}

fn u16_at(bytes: &[u8], at: usize) -> Option<u16> {
    Some(u16::from_le_bytes(*bytes.get(at..)?.first_chunk()?))
}

impl<'a> Block<'a> {
    /// The block at a place of the file; `None` where none fits.
    fn at(contents: &'a [u8], place: u64) -> Option<Self> {
        let start = usize::try_from(place).ok().filter(|start| *start > 0)?;
        let head = contents.get(start..start.checked_add(BLOCK_HEAD)?)?;
        let length = usize::try_from(u64_at(head, 8)?).ok()?;
        let links = usize::try_from(u64_at(head, 16)?).ok()?.checked_mul(8)?;
        let body = contents.get(start..start.checked_add(length)?)?.get(BLOCK_HEAD..)?;
        let (links, data) = body.split_at_checked(links)?;
        (head.starts_with(b"##")).then_some(Self { id: &head[2..4], links, data })
    }

    /// The place a link leads to; 0 where it leads nowhere.
    fn link(&self, index: usize) -> u64 {
        u64_at(self.links, 8 * index).unwrap_or(0)
    }

    /// The block a link leads to, where it is one of the kind `id`.
    fn follow(&self, contents: &'a [u8], index: usize, id: &[u8]) -> Option<Self> {
        Self::at(contents, self.link(index)).filter(|block| block.id == id)
    }

    /// Text that a link leads to; of XML what stands in its first element of text.
    fn text(&self, contents: &[u8], index: usize) -> Option<String> {
        let block = Block::at(contents, self.link(index))?;
        let end = block.data.iter().position(|byte| *byte == 0).unwrap_or(block.data.len());
        let text = String::from_utf8_lossy(&block.data[..end]);
        let plain = match block.id {
            b"TX" => &text,
            b"MD" => text.split_once("<TX>")?.1.split_once("</TX>")?.0,
            _ => return None,
        };
        Some(one_line(plain.trim()))
    }
}

/// The blocks of a list that `first` begins, linked by their link 0; what is wrong where the list leads back to itself.
fn chain<'a>(contents: &'a [u8], first: u64, id: &'static [u8], most: usize) -> Result<Vec<Block<'a>>, String> {
    let (mut blocks, mut visited, mut place) = (Vec::new(), HashSet::new(), first);
    while let Some(block) = Block::at(contents, place).filter(|block| block.id == id && blocks.len() < most) {
        if !visited.insert(place) {
            return Err(circle(place));
        }
        blocks.push(block);
        place = block.link(0);
    }
    Ok(blocks)
}

/// What is wrong with a list that comes a second time to the block at `place`.
fn circle(place: u64) -> String {
    format!("links lead back to the block at byte {place}")
}

/// From the number as stored to the quantity.
enum Conversion {
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
    fn from_block(block: Option<Block<'_>>) -> Result<Self, &'static str> {
        let Some(block) = block else { return Ok(Self::None) };
        let (kind, count) = (block.data.first().copied().unwrap_or(0), u16_at(block.data, 6).unwrap_or(0));
        let value = |index: usize| Some(f64::from_bits(u64_at(block.data, 24 + 8 * index)?));
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
struct Field {
    name: String,
    unit: Option<String>,
    kind: u8,
    data_type: u8,
    bit_offset: u32,
    byte_offset: usize,
    bits: u32,
    /// Bit that says a sample is invalid, counted from the first byte behind the data.
    invalid_bit: Option<usize>,
    conversion: Conversion,
}

impl Field {
    fn is_master(&self) -> bool {
        self.kind == MASTER || self.kind == VIRTUAL_MASTER
    }

    /// The quantity in the record with the given number.
    fn value(&self, record: &[u8], data_bytes: usize, number: usize) -> f64 {
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

    /// The number as stored.
    fn stored(&self, record: &[u8]) -> Option<f64> {
        let count = (self.bit_offset + self.bits).div_ceil(8) as usize;
        let bytes = record.get(self.byte_offset..self.byte_offset.checked_add(count)?)?;
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
struct Group {
    name: String,
    id: u64,
    fields: Vec<Field>,
    data_bytes: usize,
    record_bytes: usize,
    is_variable: bool,
}

/// Sources of a file, and warnings.
pub(crate) fn sources(path: &Path, contents: &[u8]) -> Result<(Vec<Source>, Vec<String>), LoadError> {
    let damaged =
        |what: &str| LoadError::Damaged { path: path.to_owned(), format: Format::Mdf4, what: what.to_owned() };
    if contents.starts_with(UNFINISHED) {
        return Err(damaged("its recorder did not close it: finalise it with a tool of the recorder"));
    }
    if contents.get(8).is_none_or(|version| *version < b'4') {
        return Err(damaged("it is of a version before 4: convert it to MDF 4"));
    }
    let header = Block::at(contents, HEADER as u64).filter(|block| block.id == b"HD");
    let header = header.ok_or_else(|| damaged("no header block at byte 64"))?;
    let budget = Budget::for_file(path, Format::Mdf4);
    let (mut sources, mut warnings) = (Vec::new(), Vec::new());
    let data_groups = chain(contents, header.link(0), b"DG", MOST_GROUPS).map_err(|what| damaged(&what))?;
    for (number, data_group) in data_groups.into_iter().enumerate() {
        let id_bytes = usize::from(data_group.data.first().copied().unwrap_or(0));
        let groups = chain(contents, data_group.link(1), b"CG", MOST_GROUPS).and_then(|blocks| {
            blocks.into_iter().map(|block| group(contents, block, number + 1, &mut warnings)).collect()
        });
        let groups: Vec<Group> = groups.map_err(|what| damaged(&what))?;
        if id_bytes > 8 || (id_bytes == 0 && groups.len() > 1) {
            return Err(damaged(&format!("data group {} does not state the channel group of its records", number + 1)));
        }
        let records = records(contents, data_group.link(2), &budget)?;
        let records = records.map_err(|what| damaged(&format!("data group {}: {what}", number + 1)))?;
        let (found, left) = collect(&groups, &records, id_bytes, &budget)?;
        if left > 0 {
            warnings.push(format!("data group {}: {left} bytes at its end are not a whole record", number + 1));
        }
        sources.extend(found);
    }
    if let (Some(first), Some(start)) = (sources.first_mut(), u64_at(header.data, 0)) {
        first.notes.push(("start, ns since 1970-01-01".to_owned(), start.to_string()));
    }
    Ok((sources, warnings))
}

fn group(contents: &[u8], block: Block<'_>, number: usize, warnings: &mut Vec<String>) -> Result<Group, String> {
    let name = block.text(contents, 2).filter(|name| !name.is_empty()).unwrap_or_else(|| format!("group {number}"));
    let data_bytes = u32_at(block.data, 24).unwrap_or(0) as usize;
    let invalid_bytes = u32_at(block.data, 28).unwrap_or(0) as usize;
    let channels = chain(contents, block.link(1), b"CN", MOST_CHANNELS)?;
    let fields = channels.into_iter().filter_map(|channel| match field(contents, channel, invalid_bytes > 0) {
        Ok(field) => Some(field),
        Err((channel, why)) => {
            warnings.push(format!("'{name}/{channel}' is left out: {why}"));
            None
        }
    });
    let fields = fields.collect();
    let is_variable = u16_at(block.data, 16).unwrap_or(0) & VARIABLE_LENGTH != 0;
    let id = u64_at(block.data, 0).unwrap_or(0);
    Ok(Group { name, id, fields, data_bytes, record_bytes: data_bytes + invalid_bytes, is_variable })
}

/// A channel; its name and why it cannot be read where that is so.
fn field(contents: &[u8], block: Block<'_>, has_invalid: bool) -> Result<Field, (String, &'static str)> {
    let name = block.text(contents, 2).unwrap_or_default();
    let byte = |at: usize| block.data.get(at).copied().unwrap_or(0);
    let word = |at: usize| u32_at(block.data, at).unwrap_or(0);
    let (kind, data_type, bits) = (byte(0), byte(2), word(8));
    let fits = match data_type {
        0..4 => (1..=64).contains(&bits),
        4 | 5 => bits == 32 || bits == 64,
        _ => return Err((name, "it holds text or bytes")),
    };
    let is_virtual = kind == VIRTUAL_MASTER || kind == VIRTUAL_DATA;
    if kind == 1 || !(fits || is_virtual) {
        return Err((name, "its numbers have an unusual length"));
    }
    let converted = block.follow(contents, 4, b"CC");
    let unit = block.text(contents, 6).or_else(|| converted?.text(contents, 1)).filter(|unit| !unit.is_empty());
    let conversion = match Conversion::from_block(converted) {
        Ok(conversion) => conversion,
        Err(why) => return Err((name, why)),
    };
    let flags = word(12);
    let invalid_bit = (has_invalid && flags & 2 != 0).then(|| word(16) as usize);
    let (bit_offset, byte_offset) = (u32::from(byte(3) & 7), word(4) as usize);
    Ok(Field { name, unit, kind, data_type, bit_offset, byte_offset, bits, invalid_bit, conversion })
}

/// The records of a data group, joined from all their blocks; the inner error says what is wrong with them.
fn records(contents: &[u8], place: u64, budget: &Budget<'_>) -> Result<Result<Vec<u8>, String>, LoadError> {
    let mut joined = Vec::new();
    let mut pending = vec![place];
    let mut visited = HashSet::new();
    while let Some(place) = pending.pop().filter(|place| *place != 0) {
        let Some(block) = Block::at(contents, place) else { return Ok(Err(format!("no block is at byte {place}"))) };
        if !visited.insert(place) {
            return Ok(Err(circle(place)));
        }
        match block.id {
            b"DT" => {
                budget.take(block.data.len() as u64, || "records".to_owned())?;
                joined.extend_from_slice(block.data);
            }
            b"DZ" => {
                if let Err(what) = unpack(block.data, budget, &mut joined)? {
                    return Ok(Err(what));
                }
            }
            b"HL" => pending.push(block.link(0)),
            b"DL" => {
                pending.push(block.link(0));
                let count = block.links.len() / 8;
                pending.extend((1..count).rev().map(|index| block.link(index)).filter(|place| *place != 0));
            }
            other => {
                return Ok(Err(format!(
                    "its records are in a block '{}', which is not known",
                    String::from_utf8_lossy(other)
                )));
            }
        }
    }
    Ok(Ok(joined))
}

/// Appends what a compressed block holds.
fn unpack(block: &[u8], budget: &Budget<'_>, joined: &mut Vec<u8>) -> Result<Result<(), String>, LoadError> {
    let (Some(&kind), Some(width), Some(length)) = (block.get(2), u32_at(block, 4), u64_at(block, 8)) else {
        return Ok(Err("a compressed block ends too early".to_owned()));
    };
    if kind > 1 {
        return Ok(Err(format!(
            "a block is compressed in way {kind}: only deflate (0) and transposed deflate (1) are known"
        )));
    }
    budget.take(length, || "records".to_owned())?;
    let mut plain = Vec::new();
    let inflated =
        flate2::read::ZlibDecoder::new(block.get(24..).unwrap_or_default()).take(length).read_to_end(&mut plain);
    if inflated.is_err() || plain.len() as u64 != length {
        return Ok(Err("a compressed block is damaged: copy the file again".to_owned()));
    }
    let width = width as usize;
    if kind == 1 && width > 1 {
        // Whole rows were written column by column; what is left over follows as it is.
        let rows = plain.len() / width;
        joined.extend((0..rows * width).map(|at| plain[at % width * rows + at / width]));
        joined.extend_from_slice(&plain[rows * width..]);
    } else {
        joined.extend_from_slice(&plain);
    }
    Ok(Ok(()))
}

/// A source per group from the records of their data group, and the number of bytes left over.
fn collect(
    groups: &[Group],
    records: &[u8],
    id_bytes: usize,
    budget: &Budget<'_>,
) -> Result<(Vec<Source>, usize), LoadError> {
    let mut values: Vec<Vec<Vec<f64>>> = groups.iter().map(|group| vec![Vec::new(); group.fields.len()]).collect();
    let mut counts = vec![0; groups.len()];
    let mut at = 0;
    while at < records.len() {
        let mut id = [0; 8];
        let Some(stored) = records.get(at..at + id_bytes) else { break };
        id[..id_bytes].copy_from_slice(stored);
        let id = u64::from_le_bytes(id);
        let Some(index) = groups.iter().position(|group| id_bytes == 0 || group.id == id) else { break };
        let (group, start) = (&groups[index], at + id_bytes);
        if group.is_variable {
            let Some(length) = u32_at(records, start) else { break };
            at = start + 4 + length as usize;
            continue;
        }
        let Some(record) = records.get(start..start + group.record_bytes).filter(|record| !record.is_empty()) else {
            break;
        };
        budget.take(8 * group.fields.len() as u64, || format!("group '{}'", group.name))?;
        for (field, values) in group.fields.iter().zip(&mut values[index]) {
            values.push(field.value(record, group.data_bytes, counts[index]));
        }
        counts[index] += 1;
        at = start + group.record_bytes;
    }
    let sources = groups.iter().zip(values).map(|(group, values)| {
        let mut source = Source::new(group.name.clone());
        for (field, values) in group.fields.iter().zip(values).filter(|(_, values)| !values.is_empty()) {
            let name = if field.is_master() { "time".to_owned() } else { field.name.clone() };
            let unit = field.unit.clone().or_else(|| field.is_master().then(|| "s".to_owned()));
            source.channels.push(ChannelInfo::new(name, unit, values));
        }
        source
    });
    let sources = sources.filter(|source| !source.channels.is_empty()).collect();
    Ok((sources, records.len().saturating_sub(at)))
}
