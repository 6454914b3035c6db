//! ASAM MDF 4 files: a source per channel group, times in seconds since the start of the measurement.
//!
//! Form: ASAM MDF 4.1, "Measurement Data Format", block descriptions.

mod block;
mod group;
mod records;

use std::collections::HashSet;
use std::path::Path;

use block::{Block, chain, circle, u16_at, u32_at, u64_at};
use group::{Conversion, DataBlock, DataGroup, Field, Group, VIRTUAL_DATA, VIRTUAL_MASTER};
use records::{Numbers, read_records};

use crate::load::budget::Budget;
use crate::load::contents::Source;
use crate::load::error::LoadError;
use crate::load::format::Format;
use crate::load::pieces::Pieces;
use crate::message;
use crate::message::{Message, quoted};

/// First bytes of a file that its recorder did not close.
const UNFINISHED: &[u8] = b"UnFinMF ";
/// Place of the header block.
const HEADER: u64 = 64;
/// Groups of a file and channels of a group at most.
const MOST_GROUPS: usize = 10_000;
const MOST_CHANNELS: usize = 100_000;
/// Flag of a group whose records have a length of their own.
const VARIABLE_LENGTH: u16 = 1;

/// Sources of a file, and warnings.
pub(crate) fn sources(path: &Path, budget: &Budget<'_>) -> Result<(Vec<Source>, Vec<Message>), LoadError> {
    let file = &mut budget.pieces()?;
    let read = read_sources(path, file, budget);
    file.check()?;
    read
}

fn read_sources(
    path: &Path,
    file: &mut Pieces<'_>,
    budget: &Budget<'_>,
) -> Result<(Vec<Source>, Vec<Message>), LoadError> {
    let damaged =
        |what: &str| LoadError::Damaged { path: path.to_owned(), format: Format::Mdf4, what: what.to_owned() };
    if file.get(0, UNFINISHED.len()).is_some_and(|mark| mark == UNFINISHED) {
        return Err(damaged("not closed by its recorder: finalise it with a tool of the recorder"));
    }
    if file.get(8, 1).is_none_or(|version| version < b"4".as_slice()) {
        return Err(damaged("its version is below 4: convert it to MDF 4"));
    }
    let header = Block::at(file, HEADER).filter(|block| block.id == *b"HD");
    let header = header.ok_or_else(|| damaged("no header block at byte 64"))?;
    let mut warnings = Vec::new();
    let groups = data_groups(file, header, budget, &mut warnings)?.map_err(|what| damaged(&what))?;
    let stated = groups.iter().map(DataGroup::stated_bytes).fold(0, u64::saturating_add);
    budget.check(stated, || format!("its records and their numbers take {} MB", stated / 1_000_000))?;
    let mut sources = Vec::new();
    for (number, group) in groups.iter().enumerate() {
        let mut numbers = Numbers::new(group);
        let read = read_records(file, &group.blocks, budget, &mut |bytes| numbers.add(bytes, budget))?;
        read.map_err(|what| damaged(&format!("data group {}: {what}", number + 1)))?;
        let left = numbers.left();
        if left > 0 {
            warnings.push(message!("data group {}: {} bytes at its end are not a whole record", number + 1, left));
        }
        sources.extend(numbers.into_sources());
    }
    if let (Some(first), Some(start)) = (sources.first_mut(), u64_at(header.data(), 0)) {
        first.notes.push(("start, ns since 1970-01-01".to_owned(), start.to_string()));
    }
    Ok((sources, warnings))
}

/// The data groups of a file; the inner error says what is wrong with them.
fn data_groups(
    file: &mut Pieces<'_>,
    header: Block,
    budget: &Budget<'_>,
    warnings: &mut Vec<Message>,
) -> Result<Result<Vec<DataGroup>, String>, LoadError> {
    // No block belongs to two others, so that none counts twice.
    let visited = &mut HashSet::new();
    let places = match chain(file, header.link(0), b"DG", MOST_GROUPS, visited) {
        Ok(places) => places,
        Err(what) => return Ok(Err(what)),
    };
    let mut found = Vec::new();
    for (index, place) in places.into_iter().enumerate() {
        let Some(block) = Block::at(file, place) else { continue };
        let id_bytes = usize::from(block.data().first().copied().unwrap_or(0));
        let parts = chain(file, block.link(1), b"CG", MOST_GROUPS, visited)
            .and_then(|groups| Ok((groups, data_blocks(file, block.link(2), visited)?)));
        let (places, blocks) = match parts {
            Ok(parts) => parts,
            Err(what) => return Ok(Err(format!("data group {}: {what}", index + 1))),
        };
        let mut groups = Vec::new();
        for place in places {
            let Some(block) = Block::at(file, place) else { continue };
            match group(file, (block, index + 1), (visited, budget), warnings)? {
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
    file: &mut Pieces<'_>,
    (block, number): (Block, usize),
    (visited, budget): (&mut HashSet<u64>, &Budget<'_>),
    warnings: &mut Vec<Message>,
) -> Result<Result<Group, String>, LoadError> {
    let name = block.text(file, 2).filter(|name| !name.is_empty()).unwrap_or_else(|| format!("group {number}"));
    let data_bytes = u32_at(block.data(), 24).unwrap_or(0) as usize;
    let invalid_bytes = u32_at(block.data(), 28).unwrap_or(0) as usize;
    let channels = match chain(file, block.link(1), b"CN", MOST_CHANNELS, visited) {
        Ok(channels) => channels,
        Err(what) => return Ok(Err(what)),
    };
    let mut fields = Vec::new();
    for place in channels {
        let Some(channel) = Block::at(file, place) else { continue };
        match field(file, channel, invalid_bytes > 0) {
            Ok(field) => {
                // Names and conversions may be shared, and are held by each channel.
                budget.take(field.bytes(), || format!("the description of group '{name}'"))?;
                fields.push(field);
            }
            Err((channel, why)) => {
                let line = message!("{} is left out: {}", quoted(format!("{name}/{channel}")), why);
                budget.take(line.to_string().len() as u64, || format!("the description of group '{name}'"))?;
                warnings.push(line);
            }
        }
    }
    let is_variable = u16_at(block.data(), 16).unwrap_or(0) & VARIABLE_LENGTH != 0;
    let (id, stated_records) = (u64_at(block.data(), 0).unwrap_or(0), u64_at(block.data(), 8).unwrap_or(0));
    let record_bytes = data_bytes + invalid_bytes;
    Ok(Ok(Group { name, id, fields, data_bytes, record_bytes, is_variable, stated_records }))
}

/// A channel; its name and why it cannot be read where that is so.
fn field(file: &mut Pieces<'_>, block: Block, has_invalid: bool) -> Result<Field, (String, &'static str)> {
    let name = block.text(file, 2).unwrap_or_default();
    let byte = |at: usize| block.data().get(at).copied().unwrap_or(0);
    let word = |at: usize| u32_at(block.data(), at).unwrap_or(0);
    let (kind, data_type, bits) = (byte(0), byte(2), word(8));
    let fits = match data_type {
        0..4 => (1..=64).contains(&bits),
        4 | 5 => bits == 32 || bits == 64,
        _ => return Err((name, "it contains text or bytes")),
    };
    let is_virtual = kind == VIRTUAL_MASTER || kind == VIRTUAL_DATA;
    if kind == 1 || !(fits || is_virtual) {
        return Err((name, "its numbers have an unusual length"));
    }
    let converted = block.follow(file, 4, b"CC");
    let unit = block.text(file, 6).or_else(|| converted?.text(file, 1)).filter(|unit| !unit.is_empty());
    let conversion = match Conversion::from_block(file, converted) {
        Ok(conversion) => conversion,
        Err(why) => return Err((name, why)),
    };
    let flags = word(12);
    let invalid_bit = (has_invalid && flags & 2 != 0).then(|| word(16) as usize);
    let (bit_offset, byte_offset) = (u32::from(byte(3) & 7), word(4) as usize);
    Ok(Field { name, unit, kind, data_type, bit_offset, byte_offset, bits, invalid_bit, conversion })
}

/// The blocks of a data group that hold records, in their order; what is wrong where they are not to be had.
fn data_blocks(file: &mut Pieces<'_>, place: u64, visited: &mut HashSet<u64>) -> Result<Vec<DataBlock>, String> {
    let (mut blocks, mut pending) = (Vec::new(), vec![place]);
    while let Some(place) = pending.pop().filter(|place| *place != 0) {
        let block = Block::at(file, place).ok_or_else(|| format!("no block is at byte {place}"))?;
        if !visited.insert(place) {
            return Err(circle(place));
        }
        match &block.id {
            b"DT" => blocks.push(DataBlock { place, bytes: block.data_bytes as u64, is_compressed: false }),
            b"DZ" => {
                let bytes = u64_at(block.data(), 8).unwrap_or(0);
                blocks.push(DataBlock { place, bytes, is_compressed: true });
            }
            b"HL" => pending.push(block.link(0)),
            b"DL" => {
                pending.push(block.link(0));
                let links = file.get(block.links_at, 8 * block.link_count).unwrap_or_default();
                let link = |index: usize| u64_at(links, 8 * index).unwrap_or(0);
                pending.extend((1..block.link_count).rev().map(link).filter(|place| *place != 0));
            }
            other => {
                let name = String::from_utf8_lossy(other);
                return Err(format!("its records are in a block of unknown kind '{name}'"));
            }
        }
    }
    Ok(blocks)
}
