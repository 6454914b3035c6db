//! ASAM MDF 4 files: a source per channel group, times in seconds since the start of the measurement.
//!
//! Form: ASAM MDF 4.1, "Measurement Data Format", block descriptions.

use std::collections::{HashMap, HashSet};
use std::io::Read;
use std::path::Path;

use crate::load::budget::{Budget, NUMBER_BYTES};
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
/// Bytes of a text that are looked at, and letters of a name or unit.
const MOST_TEXT: usize = 1 << 16;
const MOST_LETTERS: usize = 1000;
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
        let data = &block.data[..block.data.len().min(MOST_TEXT)];
        let end = data.iter().position(|byte| *byte == 0).unwrap_or(data.len());
        let text = String::from_utf8_lossy(&data[..end]);
        let plain = match block.id {
            b"TX" => &text,
            b"MD" => text.split_once("<TX>")?.1.split_once("</TX>")?.0,
            _ => return None,
        };
        Some(one_line(plain.trim()).chars().take(MOST_LETTERS).collect())
    }
}

/// The blocks of a list that `first` begins, linked by their link 0; what is wrong where it leads to one of the blocks `visited`.
fn chain<'a>(
    contents: &'a [u8],
    first: u64,
    id: &'static [u8],
    most: usize,
    visited: &mut HashSet<u64>,
) -> Result<Vec<Block<'a>>, String> {
    let (mut blocks, mut place) = (Vec::new(), first);
    while let Some(block) = Block::at(contents, place).filter(|block| block.id == id && blocks.len() < most) {
        if !visited.insert(place) {
            return Err(circle(place));
        }
        blocks.push(block);
        place = block.link(0);
    }
    Ok(blocks)
}

/// What is wrong with links that come a second time to the block at `place`.
fn circle(place: u64) -> String {
    format!("several links lead to the block at byte {place}")
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
    /// Bytes in memory.
    fn bytes(&self) -> u64 {
        let text = self.name.len() + self.unit.as_ref().map_or(0, String::len);
        let table = match &self.conversion {
            Conversion::Table { pairs, .. } => size_of_val(&pairs[..]),
            Conversion::Ranges(ranges, _) => size_of_val(&ranges[..]),
            _ => 0,
        };
        (size_of::<Self>() + text + table) as u64
    }

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
    /// Number of its records, as the file states it.
    stated_records: u64,
}

/// Sources of a file, and warnings.
pub(crate) fn sources(
    path: &Path,
    contents: &[u8],
    budget: &Budget<'_>,
) -> Result<(Vec<Source>, Vec<String>), LoadError> {
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
    let mut warnings = Vec::new();
    let groups = data_groups(contents, header, budget, &mut warnings)?.map_err(|what| damaged(&what))?;
    let stated = groups.iter().map(DataGroup::stated_bytes).fold(0, u64::saturating_add);
    budget.check(stated, || format!("its records and their numbers take {} MB", stated / 1_000_000))?;
    let mut sources = Vec::new();
    for (number, group) in groups.iter().enumerate() {
        let records = records(&group.blocks, budget)?;
        let records = records.map_err(|what| damaged(&format!("data group {}: {what}", number + 1)))?;
        let (found, left) = collect(&group.groups, &records, group.id_bytes, budget)?;
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

/// Channel groups of common records, and the blocks that hold these.
struct DataGroup<'a> {
    /// Bytes of the number of the group before each record.
    id_bytes: usize,
    groups: Vec<Group>,
    blocks: Vec<Block<'a>>,
}

impl DataGroup<'_> {
    /// Bytes in memory of the records and of their numbers, by what the file states of them.
    fn stated_bytes(&self) -> u64 {
        let bytes = self.blocks.iter().map(stated_length).fold(0, u64::saturating_add);
        let numbers = |group: &Group| {
            let record = (self.id_bytes + group.record_bytes).max(1) as u64;
            let records = if self.id_bytes > 0 { group.stated_records.min(bytes / record) } else { bytes / record };
            records.saturating_mul(NUMBER_BYTES * group.fields.len() as u64)
        };
        self.groups.iter().map(numbers).fold(bytes, u64::saturating_add)
    }
}

/// Bytes of records in a block, as it states them where they are compressed.
fn stated_length(block: &Block<'_>) -> u64 {
    if block.id == b"DZ" { u64_at(block.data, 8).unwrap_or(0) } else { block.data.len() as u64 }
}

/// The data groups of a file; the inner error says what is wrong with them.
fn data_groups<'a>(
    contents: &'a [u8],
    header: Block<'a>,
    budget: &Budget<'_>,
    warnings: &mut Vec<String>,
) -> Result<Result<Vec<DataGroup<'a>>, String>, LoadError> {
    // No block belongs to two others, so that none counts twice.
    let visited = &mut HashSet::new();
    let blocks = match chain(contents, header.link(0), b"DG", MOST_GROUPS, visited) {
        Ok(blocks) => blocks,
        Err(what) => return Ok(Err(what)),
    };
    let mut found = Vec::new();
    for (index, block) in blocks.into_iter().enumerate() {
        let id_bytes = usize::from(block.data.first().copied().unwrap_or(0));
        let parts = chain(contents, block.link(1), b"CG", MOST_GROUPS, visited)
            .and_then(|groups| Ok((groups, data_blocks(contents, block.link(2), visited)?)));
        let (group_blocks, blocks) = match parts {
            Ok(parts) => parts,
            Err(what) => return Ok(Err(format!("data group {}: {what}", index + 1))),
        };
        let mut groups = Vec::new();
        for block in group_blocks {
            match group(contents, (block, index + 1), (visited, budget), warnings)? {
                Ok(group) => groups.push(group),
                Err(what) => return Ok(Err(what)),
            }
        }
        if id_bytes > 8 || (id_bytes == 0 && groups.len() > 1) {
            return Ok(Err(format!("data group {} does not state the channel group of its records", index + 1)));
        }
        found.push(DataGroup { id_bytes, groups, blocks });
    }
    Ok(Ok(found))
}

/// A channel group; the inner error says what is wrong with its channels.
fn group(
    contents: &[u8],
    (block, number): (Block<'_>, usize),
    (visited, budget): (&mut HashSet<u64>, &Budget<'_>),
    warnings: &mut Vec<String>,
) -> Result<Result<Group, String>, LoadError> {
    let name = block.text(contents, 2).filter(|name| !name.is_empty()).unwrap_or_else(|| format!("group {number}"));
    let data_bytes = u32_at(block.data, 24).unwrap_or(0) as usize;
    let invalid_bytes = u32_at(block.data, 28).unwrap_or(0) as usize;
    let channels = match chain(contents, block.link(1), b"CN", MOST_CHANNELS, visited) {
        Ok(channels) => channels,
        Err(what) => return Ok(Err(what)),
    };
    let mut fields = Vec::new();
    for channel in channels {
        match field(contents, channel, invalid_bytes > 0) {
            Ok(field) => {
                // Names and conversions may be shared, and are held by each channel.
                budget.take(field.bytes(), || format!("the description of group '{name}'"))?;
                fields.push(field);
            }
            Err((channel, why)) => {
                let line = format!("'{name}/{channel}' is left out: {why}");
                budget.take(line.len() as u64, || format!("the description of group '{name}'"))?;
                warnings.push(line);
            }
        }
    }
    let is_variable = u16_at(block.data, 16).unwrap_or(0) & VARIABLE_LENGTH != 0;
    let (id, stated_records) = (u64_at(block.data, 0).unwrap_or(0), u64_at(block.data, 8).unwrap_or(0));
    let record_bytes = data_bytes + invalid_bytes;
    Ok(Ok(Group { name, id, fields, data_bytes, record_bytes, is_variable, stated_records }))
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

/// The blocks of a data group that hold records, in their order; what is wrong where they are not to be had.
fn data_blocks<'a>(contents: &'a [u8], place: u64, visited: &mut HashSet<u64>) -> Result<Vec<Block<'a>>, String> {
    let (mut blocks, mut pending) = (Vec::new(), vec![place]);
    while let Some(place) = pending.pop().filter(|place| *place != 0) {
        let block = Block::at(contents, place).ok_or_else(|| format!("no block is at byte {place}"))?;
        if !visited.insert(place) {
            return Err(circle(place));
        }
        match block.id {
            b"DT" | b"DZ" => blocks.push(block),
            b"HL" => pending.push(block.link(0)),
            b"DL" => {
                pending.push(block.link(0));
                let count = block.links.len() / 8;
                pending.extend((1..count).rev().map(|index| block.link(index)).filter(|place| *place != 0));
            }
            other => {
                let name = String::from_utf8_lossy(other);
                return Err(format!("its records are in a block '{name}', which is not known"));
            }
        }
    }
    Ok(blocks)
}

/// The records of a data group, joined from all their blocks; the inner error says what is wrong with them.
fn records(blocks: &[Block<'_>], budget: &Budget<'_>) -> Result<Result<Vec<u8>, String>, LoadError> {
    let mut joined = Vec::new();
    for block in blocks {
        if block.id == b"DT" {
            budget.take(block.data.len() as u64, || "records".to_owned())?;
            joined.extend_from_slice(block.data);
        } else if let Err(what) = unpack(block.data, budget, &mut joined)? {
            return Ok(Err(what));
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

/// The records of a data group one after the other: number of the group and bytes.
struct Records<'a> {
    groups: &'a [Group],
    by_id: HashMap<u64, usize>,
    records: &'a [u8],
    id_bytes: usize,
    at: usize,
}

impl<'a> Records<'a> {
    fn new(groups: &'a [Group], records: &'a [u8], id_bytes: usize) -> Self {
        // Of two groups with one number the first counts.
        let by_id = groups.iter().enumerate().rev().map(|(index, group)| (group.id, index)).collect();
        Self { groups, by_id, records, id_bytes, at: 0 }
    }
}

impl<'a> Iterator for Records<'a> {
    type Item = (usize, &'a [u8]);

    fn next(&mut self) -> Option<(usize, &'a [u8])> {
        loop {
            let start = self.at.checked_add(self.id_bytes)?;
            let mut id = [0; 8];
            id[..self.id_bytes].copy_from_slice(self.records.get(self.at..start)?);
            let id = u64::from_le_bytes(id);
            let index = if self.id_bytes == 0 { 0 } else { *self.by_id.get(&id)? };
            let group = self.groups.get(index)?;
            if group.is_variable {
                self.at = start + 4 + u32_at(self.records, start)? as usize;
                continue;
            }
            let end = start.checked_add(group.record_bytes)?;
            let record = self.records.get(start..end).filter(|record| !record.is_empty())?;
            self.at = end;
            return Some((index, record));
        }
    }
}

/// A source per group from the records of their data group, and the number of bytes left over.
fn collect(
    groups: &[Group],
    records: &[u8],
    id_bytes: usize,
    budget: &Budget<'_>,
) -> Result<(Vec<Source>, usize), LoadError> {
    let mut counts = vec![0; groups.len()];
    let mut all = Records::new(groups, records, id_bytes);
    all.by_ref().for_each(|(index, _)| counts[index] += 1);
    let at = all.at;
    let numbers = |(group, count): (&Group, &usize)| NUMBER_BYTES * (group.fields.len() as u64) * *count as u64;
    let bytes = groups.iter().zip(&counts).map(numbers).sum();
    budget.take(bytes, || "the numbers of its records".to_owned())?;
    let empty = |(group, count): (&Group, &usize)| vec![Vec::with_capacity(*count); group.fields.len()];
    let mut values: Vec<Vec<Vec<f64>>> = groups.iter().zip(&counts).map(empty).collect();
    for (index, record) in Records::new(groups, records, id_bytes) {
        let group = &groups[index];
        for (field, values) in group.fields.iter().zip(&mut values[index]) {
            values.push(field.value(record, group.data_bytes, values.len()));
        }
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
